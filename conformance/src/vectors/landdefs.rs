//! Vector family `landdefs` (`spec/vector-format.md`; defined in `spec/01-math-and-positions.md`, 10).

use ac_client::math::{CellId, LandCoord};
use ac_client::profile::OffMap;
use serde_json::{Value, json};

use super::VectorContext;
use super::json::{id, int, put};
use super::math::{put_vec3, vec3};

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value> {
    let (name, args) = (vector["fn"].as_str()?, &vector["in"]);
    let cell = || id(&args["cell"]).map(CellId);
    let coord = |c: Option<LandCoord>| match c {
        Some(c) => json!({ "ok": true, "x": c.x, "y": c.y }),
        None => json!({ "ok": false }),
    };
    Some(match name {
        "gid_to_lcoord" => coord(cell()?.land_coord()),
        "lcoord_to_gid" => {
            let c = LandCoord {
                x: int(&args["x"])? as i32,
                y: int(&args["y"])? as i32,
            };
            let block = put::id(c.block_id().0);
            json!({ "cell": put::id(c.cell_id().0), "block": block, "in_bounds": c.in_bounds() })
        }
        // What a failed conversion leaves behind is the reference's own: `gdle` also refuses id 0 (`01:L2`) and keeps the sums.
        "blockid_to_lcoord" => match (cell()?.block_coord(), ctx.profile.off_map) {
            (found, OffMap::ComputesOn) => {
                let c = cell()?.block_corner();
                json!({ "ok": found.is_some() && !cell()?.is_none(), "x": c.x, "y": c.y })
            }
            (Some(c), _) => json!({ "ok": true, "x": c.x, "y": c.y }),
            (None, _) => json!({ "ok": false, "x": 0, "y": 0 }),
        },
        "inbound_valid_cellid" => json!({ "ok": cell()?.is_inbound_valid() }),
        "get_block_offset" => {
            let (from, to) = (CellId(id(&args["from"])?), CellId(id(&args["to"])?));
            match from.block_offset_to(to, ctx.profile) {
                Some(offset) => json!({ "offset": put_vec3(offset) }),
                None => json!({ "exception": "InvalidOperationException" }),
            }
        }
        "get_outside_lcoord" => {
            let offset = vec3(&args["offset"])?;
            coord(cell()?.outside_coord(offset.x, offset.y, ctx.profile))
        }
        "adjust_to_outside" => {
            let (cell, offset) = cell()?.adjust_to_outside(vec3(&args["offset"])?, ctx.profile);
            json!({ "ok": !cell.is_none(), "cell": put::id(cell.0), "offset": put_vec3(offset) })
        }
        _ => return None,
    })
}
