//! Rendering (`spec/12-rendering.md`, 24): the library has no renderer, so these cases have nothing to run.

use super::{super::trial::Trial, cases};

fn none(trial: &mut Trial) {
    trial.no_code("the library does not draw");
}

cases! { "12";
    1 "eye exactly in a portal plane, or moving through it" => none;
    2 "portal polygon crossing the eye's near plane, or behind it" => none;
    3 "cells that see themselves through a loop of portals" => none;
    4 "portal to an unloaded or missing cell" => none;
    5 "viewer on a block border or at the map edge, block x or y = 0 or 254" => none;
    6 "viewer without a cell" => none;
    7 "look straight up or down" => none;
    8 "frame with zero or NaN rotation" => none;
    9 "positions not finite" => none;
    10 "scale 0, negative, 1e−6, 1e6" => none;
    11 "mesh scale z = 0 in the degrade division" => none;
    12 "polygons with 2 or 255 vertices, repeated vertices, collinear, non-planar, non-convex" => none;
    13 "vertex keys with gaps, not ascending" => none;
    14 "surface index −1, ≥ count" => none;
    15 "texture sizes not multiples of 4 with DXT, 1×1, 1×8192, w·h overflow" => none;
    16 "JPEG truncated, arithmetic-coded, 1 or 4 components" => none;
    17 "palette shorter than an index" => none;
    18 "clip map with DXT and black content" => none;
    19 "description with part index ≥ part count, 255 entries, unknown ids" => none;
    20 "clothing table without the setup" => none;
    21 "more than 256 terrain layers" => none;
    22 "day fraction NaN, exactly 0 or 1" => none;
    23 "fog start = end" => none;
    24 "light falloff 0, distance 0" => none;
    25 "particle lifespan 0, max particles 0, birthrate 0" => none;
    26 "object in 100 cells" => none;
    27 "frame time 0 or hours" => none;
}
