//! Every stiff or extreme case that the specification lists, one generator each.
//!
//! The lists are sections of the specification; a case is named by the number of its file and its place in the list. `docs/stability.md` has the
//! whole table.

use super::trial::Case;

mod animation;
mod cells;
mod collision;
mod dat;
mod math;
mod messages;
mod motion;
mod network;
mod objects;
mod render;
mod terrain;
mod transition;

/// Files of the specification with such a list.
pub const SECTIONS: [(&str, &str); 12] = [
    ("01", "Math and positions"),
    ("02", "Terrain"),
    ("03", "Cells"),
    ("04", "Collision primitives"),
    ("05", "Transition"),
    ("06", "Physics object"),
    ("07", "Animation"),
    ("08", "Motion"),
    ("09", "Network"),
    ("10", "Messages"),
    ("11", "Dat files"),
    ("12", "Rendering"),
];

/// All of them, in order.
pub fn all() -> Vec<&'static Case> {
    [
        math::CASES,
        terrain::CASES,
        cells::CASES,
        collision::CASES,
        transition::CASES,
        objects::CASES,
        animation::CASES,
        motion::CASES,
        network::CASES,
        messages::CASES,
        dat::CASES,
        render::CASES,
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A case in one line.
macro_rules! cases {
    ($section:literal; $( $number:literal $title:literal => $run:expr; )*) => {
        /// The cases of this section.
        pub(super) const CASES: &[$crate::stability::trial::Case] = &[ $( $crate::stability::trial::Case {
            section: $section,
            number: $number,
            title: $title,
            run: $run,
        }, )* ];
    };
}
pub(super) use cases;
