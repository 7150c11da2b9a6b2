//! Vector family `terrain` (`spec/vector-format.md`; defined in `spec/02-terrain.md`, 5 to 11).

use ac_client::math::CellId;
use ac_client::world::terrain::{HeightTable, TerrainBlock, TerrainVertices, Triangle};
use serde_json::{Value, json};

use super::VectorContext;
use super::json::{id, int, list, put};
use super::math::{put_vec3, vec3};

/// The library's answer to one vector; `None`: not implemented.
pub fn answer(ctx: &VectorContext<'_>, vector: &Value) -> Option<Value> {
    let (name, args) = (vector["fn"].as_str()?, &vector["in"]);
    let terrain = block(ctx, args)?;
    match name {
        // Which cell is shown was drawn at random: it is an argument that stands among the results.
        "split" => split(&terrain, int(&vector["out"]["cell_index"])?),
        "find_terrain_poly" => {
            let results: Option<Vec<Value>> = args["queries"]
                .as_array()?
                .iter()
                .map(|query| find(ctx, &terrain, query))
                .collect();
            Some(json!({ "results": results? }))
        }
        _ => None,
    }
}

fn block(ctx: &VectorContext<'_>, args: &Value) -> Option<TerrainBlock> {
    let heights = list(&args["heights"], |v| u8::try_from(int(v)?).ok())?;
    let words = list(&args["terrain"], |v| u16::try_from(int(v)?).ok())?;
    let source = TerrainVertices {
        heights: heights.try_into().ok()?,
        words: words.try_into().ok()?,
    };
    let block = CellId(id(&args["block"])?);
    Some(TerrainBlock::new(
        block,
        source,
        &HeightTable::linear(),
        ctx.profile,
    ))
}

fn split(terrain: &TerrainBlock, cell: i64) -> Option<Value> {
    let index = usize::try_from(cell).ok()?;
    let cuts: String = (0..64)
        .map(|i| if terrain.is_sw_to_ne_cut(i) { '1' } else { '0' })
        .collect();
    let water: String = (0..64)
        .map(|i| char::from(b'0' + terrain.cell_water(i) as u8))
        .collect();
    let polys: Vec<Value> = terrain
        .triangles()
        .get(2 * index..2 * index + 2)?
        .iter()
        .map(put_triangle)
        .collect();
    Some(json!({
        "swtone_cut": cuts,
        "block_water": terrain.block_water() as u8,
        "cell_water": water,
        "cell_index": cell,
        "cell": put::id(terrain.cell_id(index).0),
        "polys": polys,
    }))
}

fn put_triangle(triangle: &Triangle) -> Value {
    json!({
        "vertices": triangle.vertices.map(put_vec3),
        "n": put_vec3(triangle.plane.n),
        "d": put::f32(triangle.plane.d),
    })
}

fn find(ctx: &VectorContext<'_>, terrain: &TerrainBlock, query: &Value) -> Option<Value> {
    let (cell, point) = (CellId(id(&query["cell"])?), vec3(&query["point"])?);
    let index = terrain.cell_index(cell)?;
    let depth = terrain.water_depth(index, point, ctx.profile);
    // 02:B21: one reference answers the f64 literal, the other the f32 that both use in the end.
    let depth = if ctx.oracle().starts_with("gdle") {
        put::f64(depth.literal())
    } else {
        put::f32(depth.metres())
    };
    Some(match terrain.find_terrain_poly(index, point) {
        None => json!({ "poly": null, "water_depth": depth }),
        Some((poly, triangle)) => json!({
            "poly": poly,
            "n": put_vec3(triangle.plane.n),
            "d": put::f32(triangle.plane.d),
            "water_depth": depth,
        }),
    })
}
