//! The shapes that are drawn, as messages.

use foxglove::messages::{
    ArrowPrimitive, Color, CylinderPrimitive, FrameTransform, KeyValuePair, LinePrimitive, Point3,
    Pose, Quaternion, SceneEntity, TextPrimitive, Timestamp, Vector3, line_primitive,
};

use super::{LANDBLOCK, Look, ORIGIN};

pub(super) fn stamp(time: u64) -> Option<Timestamp> {
    let seconds = u32::try_from(time / 1_000_000_000).ok()?;
    Some(Timestamp::new(seconds, (time % 1_000_000_000) as u32))
}

const fn color([r, g, b, a]: [f64; 4]) -> Color {
    Color { r, g, b, a }
}

const fn point([x, y, z]: [f64; 3]) -> Point3 {
    Point3 { x, y, z }
}

const fn pose([x, y, z]: [f64; 3], [qw, qx, qy, qz]: [f64; 4]) -> Pose {
    Pose {
        position: Some(Vector3 { x, y, z }),
        orientation: Some(Quaternion {
            x: qx,
            y: qy,
            z: qz,
            w: qw,
        }),
    }
}

pub(super) const IDENTITY: [f64; 4] = [1.0, 0.0, 0.0, 0.0];
/// Turns +x, where arrows point, to +y, where objects look.
const TO_Y: [f64; 4] = [
    std::f64::consts::FRAC_1_SQRT_2,
    0.0,
    0.0,
    std::f64::consts::FRAC_1_SQRT_2,
];

pub(super) fn transform(
    time: u64,
    parent: &str,
    child: &str,
    [x, y, z]: [f64; 3],
    [w, qx, qy, qz]: [f64; 4],
) -> FrameTransform {
    FrameTransform {
        timestamp: stamp(time),
        parent_frame_id: parent.into(),
        child_frame_id: child.into(),
        translation: Some(Vector3 { x, y, z }),
        rotation: Some(Quaternion {
            x: qx,
            y: qy,
            z: qz,
            w,
        }),
    }
}

fn entity(time: u64, frame: &str, id: String) -> SceneEntity {
    SceneEntity {
        timestamp: stamp(time),
        frame_id: frame.into(),
        id,
        frame_locked: true,
        ..SceneEntity::default()
    }
}

/// A cylinder of a person's size, an arrow forward, and the label.
pub(super) fn figure(time: u64, id: &str, look: &Look) -> SceneEntity {
    let frame = format!("object/{id}");
    let facts = look.facts.iter();
    SceneEntity {
        metadata: facts
            .map(|(key, value)| KeyValuePair {
                key: key.clone(),
                value: value.clone(),
            })
            .collect(),
        cylinders: vec![CylinderPrimitive {
            pose: Some(pose([0.0, 0.0, 0.9], IDENTITY)),
            size: Some(Vector3 {
                x: 0.6,
                y: 0.6,
                z: 1.8,
            }),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color: Some(color(look.color)),
        }],
        arrows: vec![ArrowPrimitive {
            pose: Some(pose([0.0, 0.0, 1.2], TO_Y)),
            shaft_length: 0.7,
            shaft_diameter: 0.1,
            head_length: 0.3,
            head_diameter: 0.25,
            color: Some(color([1.0, 1.0, 1.0, look.color[3]])),
        }],
        texts: vec![TextPrimitive {
            pose: Some(pose([0.0, 0.0, 2.2], IDENTITY)),
            billboard: true,
            font_size: 14.0,
            scale_invariant: true,
            color: Some(color([1.0, 1.0, 1.0, 1.0])),
            text: look.label.clone(),
        }],
        ..entity(time, &frame, frame.clone())
    }
}

fn line(kind: line_primitive::Type, points: Vec<Point3>, colour: [f64; 4]) -> LinePrimitive {
    LinePrimitive {
        r#type: kind as i32,
        pose: Some(pose([0.0; 3], IDENTITY)),
        thickness: 2.0,
        scale_invariant: true,
        points,
        color: Some(color(colour)),
        ..LinePrimitive::default()
    }
}

pub(super) fn path(time: u64, id: &str, look: &Look, points: &[[f64; 3]]) -> SceneEntity {
    let points = points.iter().map(|&p| point(p)).collect();
    let [r, g, b, _] = look.color;
    SceneEntity {
        lines: vec![line(
            line_primitive::Type::LineStrip,
            points,
            [r, g, b, 0.6],
        )],
        ..entity(time, ORIGIN, format!("path/{id}"))
    }
}

/// The border of a landblock, at the height where it was first entered.
pub(super) fn border(time: u64, landblock: u32, [x, y, z]: [f64; 3]) -> SceneEntity {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let points = corners
        .map(|(u, v)| point([x + u * LANDBLOCK, y + v * LANDBLOCK, z]))
        .to_vec();
    SceneEntity {
        lines: vec![line(
            line_primitive::Type::LineLoop,
            points,
            [0.5, 0.5, 0.5, 0.6],
        )],
        ..entity(time, ORIGIN, format!("landblock/{landblock:04X}"))
    }
}
