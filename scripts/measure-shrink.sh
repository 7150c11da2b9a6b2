#!/bin/sh
# Shrinks one scene per numbered difference that a scene sees when it alone is set in the profile `retail`, and writes what came of it to
# target/shrink.jsonl, from which `ac-conform status` makes its table. Half a minute in a release build.
#
#   scripts/measure-shrink.sh [path/to/ac-conform]
set -eu
conform=${1:-target/release/ac-conform}
small=$(mktemp -d)
trap 'rm -rf "$small"' EXIT
mkdir -p target
: > target/shrink.jsonl
while read -r switch scene oracle; do
  "$conform" shrink "golden-traces/traces/$scene.mcap" --against "$oracle" --switch "$switch" -o "$small" --format json >> target/shrink.jsonl
done <<'END'
combine_normalizes moveto/position-far ace
grotate_skips_tiny building/enter-edge ace
undo_combine motion/rapid ace
vector_heading_pitches_y bounce/sledding ace
heading_arithmetic missile/indoors gdle
rotate_vector building/enter-edge ace
normalize dungeon/ramp-down-up ace
snap_to_plane terrain/map-corner-0000 gdle
tiny_gap_dropped clock/tiny gdle
floor_z terrain/limit-walkable gdle
cell_array_emptied building/upper-room ace
list_removal lifecycle/many ace
shadow_walk objects/inner-corner ace
part_boxes objects/crate-across-cells ace
sphere_roots objects/land-on gdle-repaired
walkable_scan_ends building/landing-fall ace
land_on_creature_spheres objects/land-on gdle
sphere_slide objects/boulder gdle
cylinder_landing objects/land-on gdle
collision_normal_normalized missile/hit-wall ace
sliding_normal_normalized missile/hit-wall ace
steep_penetration_adjusts terrain/cliff-foot ace
edge_slide_order building/landing-fall ace
last_known_cell extreme/ceiling-and-floor ace
nan_goal_refused extreme/nan-velocity ace
sledding_full_vector bounce/sledding ace
sledding bounce/sledding ace
set_velocity_tolerant bounce/sledding gdle-repaired
bounce_factor bounce/sledding gdle
reports missile/hit-wall ace
server_scatter extreme/spawn-corners ace
set_hidden extreme/static-object gdle
interpolation interp/queue ace
constraint_counts sticky/constraint ace
frame_number bounce/pushed-player ace
hooks_executed motion/door ace
default_state bounce/pushed-player gdle
weenie_set_twice bounce/pushed-player gdle
initial_state_assigned extreme/static-object ace
leave_ground_velocity bounce/sledding gdle
move_to_heading moveto/position-walk ace
move_to_arrival moveto/away ace
END
