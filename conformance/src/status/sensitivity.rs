//! The part of the page about switches: what the scenes can tell apart.

use std::{collections::BTreeMap, fmt::Write};

use super::{columns, heading, row};
use crate::run::sensitivity::{SceneSensitivity, SwitchCount, switch_counts};

pub(super) fn section(text: &mut String, scenes: &[SceneSensitivity]) {
    if scenes.is_empty() {
        return;
    }
    text.push_str(
        "## Sensitivity\n\nEach scene runs again under its oracle's profile with one switch set to the choice of `retail`, once for every switch in which the two \
         differ. It is sensitive to a switch when any frame changes. A switch is named by its field in `Profile`, a scene's list by the first identifier that the \
         specification gives it. Where two switches belong together, one alone makes a mixture that no reconstruction runs: it may show \
         more than the difference itself, or hide it.\n\n",
    );
    let counts = switch_counts(scenes);
    totals(text, scenes, &counts);
    switches(text, scenes, &counts);
    unseen(text, scenes, &counts);
    per_scene(text, scenes);
}

fn totals(text: &mut String, scenes: &[SceneSensitivity], counts: &[SwitchCount]) {
    let names = [
        "switches that differ from `retail`",
        "of these seen by a scene",
        "runs",
        "runs that change",
        "scenes sensitive to any",
        "scenes not met before",
    ];
    heading(text, "oracle", &names);
    for oracle in columns(scenes.iter().map(|scene| scene.oracle.as_str())) {
        let of = || scenes.iter().filter(|scene| scene.oracle == oracle);
        let differing = || counts.iter().filter_map(|count| count.oracles.get(oracle));
        let cells = [
            differing().count(),
            differing().filter(|count| count.scenes > 0).count(),
            of().map(|scene| scene.tried).sum(),
            of().map(|scene| scene.sensitive.len()).sum(),
            of().filter(|scene| !scene.sensitive.is_empty()).count(),
            of().filter(|scene| scene.unmet.is_some()).count(),
        ];
        row(text, oracle, cells.map(|number: usize| number.to_string()));
    }
    text.push('\n');
}

fn switches(text: &mut String, scenes: &[SceneSensitivity], counts: &[SwitchCount]) {
    text.push_str("### Scenes per switch\n\nNumber of sensitive scenes per oracle (–: it chooses as `retail`), and one of them with its first change.\n\n");
    let oracles = columns(scenes.iter().map(|scene| scene.oracle.as_str()));
    let mut names = vec!["specification", "`retail`"];
    names.extend(&oracles);
    names.push("earliest change");
    heading(text, "switch", &names);
    for count in counts.iter().filter(|count| !count.is_unseen()) {
        let mut cells = vec![count.id.into(), format!("`{}`", count.retail_choice)];
        cells.extend(oracles.iter().map(|oracle| {
            count.oracles.get(*oracle).map_or("–".into(), |of| {
                format!("{} (`{}`)", of.scenes, of.choice)
            })
        }));
        cells.push(example(scenes, count.switch));
        row(text, &format!("`{}`", count.switch), cells);
    }
    text.push('\n');
}

/// The scene in which a switch shows first.
fn example(scenes: &[SceneSensitivity], switch: &str) -> String {
    scenes
        .iter()
        .flat_map(|scene| scene.sensitive.iter().map(move |found| (scene, found)))
        .filter(|(_, found)| found.switch == switch)
        .min_by_key(|(scene, found)| (found.change.divergence.frame, &scene.scene, &scene.oracle))
        .map_or(String::new(), |(scene, found)| {
            let divergence = &found.change.divergence;
            format!(
                "{}, {}: frame {}, `{}`",
                scene.scene, scene.oracle, divergence.frame, divergence.field
            )
        })
}

/// The switches that nothing here tests.
fn unseen(text: &mut String, scenes: &[SceneSensitivity], counts: &[SwitchCount]) {
    let unseen: Vec<_> = counts.iter().filter(|count| count.is_unseen()).collect();
    let _ = writeln!(
        text,
        "### Switches that no scene sees\n\nSet alone, {} of {} switches change no frame of any scene: nothing here tells these choices apart.\n\n\
         <details><summary>All of them</summary>\n",
        unseen.len(),
        counts.len()
    );
    let oracles = columns(scenes.iter().map(|scene| scene.oracle.as_str()));
    let mut names = vec!["specification", "`retail`"];
    names.extend(&oracles);
    heading(text, "switch", &names);
    for count in unseen {
        let mut cells = vec![count.id.into(), format!("`{}`", count.retail_choice)];
        cells.extend(oracles.iter().map(|oracle| {
            let of = count.oracles.get(*oracle);
            of.map_or("–".into(), |of| format!("`{}`", of.choice))
        }));
        row(text, &format!("`{}`", count.switch), cells);
    }
    text.push_str("\n</details>\n\n");
}

fn per_scene(text: &mut String, scenes: &[SceneSensitivity]) {
    text.push_str("### Switches per scene\n\n<details><summary>All scenes</summary>\n\n");
    let oracles = columns(scenes.iter().map(|scene| scene.oracle.as_str()));
    let mut rows: BTreeMap<&str, BTreeMap<&str, String>> = BTreeMap::new();
    for scene in scenes {
        let list = match scene.unmet {
            Some(_) => "not met".into(),
            None => list(scene),
        };
        rows.entry(&scene.scene)
            .or_default()
            .insert(&scene.oracle, list);
    }
    heading(text, "scene", &oracles);
    for (scene, lists) in rows {
        let cells = oracles
            .iter()
            .map(|oracle| lists.get(oracle).cloned().unwrap_or_default());
        row(text, scene, cells);
    }
    text.push_str("\n</details>\n\n");
}

/// `3: T-01 T-02 O-07`.
fn list(scene: &SceneSensitivity) -> String {
    let names: Vec<_> = scene
        .sensitive
        .iter()
        .map(|found| found.id.split(' ').next().unwrap_or(found.switch))
        .collect();
    match names.len() {
        0 => "0".into(),
        number => format!("{number}: {}", names.join(" ")),
    }
}
