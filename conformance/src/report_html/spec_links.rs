//! Where the specification speaks of a stage or a field: what to read first when it differs.

/// Section of the specification for a divergence.
pub fn section(stage: Option<&str>, field: &str) -> &'static str {
    match stage {
        Some("animation") => "spec/06-physics-object.md, B5; spec/07-animation.md, 8.5 to 8.10",
        Some("adjust") => "spec/06-physics-object.md, B5 step 3, F1 to F4",
        Some("integrate") => "spec/06-physics-object.md, B6",
        Some("hooks") => "spec/06-physics-object.md, B5 step 6, E5; spec/07-animation.md, 9.2",
        Some("transition") => {
            "spec/05-transition.md, 6 to 11 and 13; spec/06-physics-object.md, C1"
        }
        Some("commit") => "spec/06-physics-object.md, C2, C7, D1, D2",
        Some("motion") => "spec/06-physics-object.md, B4 steps 9 to 12; spec/08-motion.md",
        _ => of_field(field),
    }
}

fn of_field(field: &str) -> &'static str {
    let head = field.split(['.', '[']).next().unwrap_or_default();
    match head {
        "time" => "spec/01-math-and-positions.md, 12",
        "cell" => "spec/03-cells.md, 9; spec/06-physics-object.md, D1",
        "origin" => "spec/06-physics-object.md, B4 to B6; spec/05-transition.md, 10",
        "rotation" => "spec/06-physics-object.md, B5 and B6",
        "velocity" => "spec/06-physics-object.md, B6, B8 and C7",
        "acceleration" => "spec/06-physics-object.md, B7",
        "omega" => "spec/06-physics-object.md, B8",
        "state" => "spec/06-physics-object.md, A4 and E3",
        "transient" => "spec/06-physics-object.md, A4 and C2",
        "contact_plane" | "sliding_normal" => {
            "spec/05-transition.md, 9 and 10; spec/06-physics-object.md, C2"
        }
        "anim" => "spec/07-animation.md",
        "motion" => "spec/08-motion.md",
        "steps" if field.ends_with(".outcome") => "spec/05-transition.md, 10.14",
        "steps" => "spec/06-physics-object.md, B2 and B3",
        "collisions" => "spec/06-physics-object.md, C8",
        "events" => "spec/06-physics-object.md, A8",
        "record" => "spec/06-physics-object.md, part G",
        _ => "spec/scene-format.md, \"Expected-state trace\"",
    }
}

#[cfg(test)]
mod tests {
    use super::section;

    #[test]
    fn the_stage_decides_before_the_field() {
        assert!(section(Some("integrate"), "out.velocity[0]").ends_with("B6"));
        assert!(section(None, "steps[0].outcome").contains("10.14"));
        assert!(section(None, "steps").contains("B3"));
        assert!(section(None, "anim.frame_number").contains("07"));
    }
}
