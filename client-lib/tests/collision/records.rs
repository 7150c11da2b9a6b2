//! Shapes from dat records (`spec/11-dat-files.md`, 9.1 and 9.5).

use ac_client::dat::{
    BspTag, BspTree, CellInner, CellLeaf, CellNode, CellStruct, GfxObj, GfxObjFlags, NodeId,
    PhysicsBsp, PhysicsInner, PhysicsLeaf, PhysicsNode, PhysicsShape, Polygon, PolygonSet, Sides,
    Stippling, VertexArray,
};
use ac_client::math::{Plane, Sphere, Vec3};
use ac_client::physics::collision::{BoundingType, CellShape, GfxShape, TreeError};

use crate::soup::cuboid;
use crate::support::RETAIL;

fn faces(inwards: bool) -> (VertexArray, PolygonSet) {
    let (mut vertices, mut set) = (VertexArray::default(), PolygonSet::default());
    for face in cuboid(Vec3::NEG_ONE, Vec3::ONE, inwards) {
        let points: Vec<u16> = face
            .iter()
            .map(|&p| vertices.push(p, Vec3::Z, &[]))
            .collect();
        set.push(Polygon {
            key: 0,
            stippling: Stippling::empty(),
            sides: Sides(0),
            front_surface: 0,
            back_surface: 0,
            points: &points,
            front_uvs: &[],
            back_uvs: &[],
        });
    }
    (vertices, set)
}

/// A splitting plane with everything in front of it and a free leaf behind.
fn tree(keys: &[u16]) -> PhysicsBsp {
    let mut tree = BspTree::default();
    let polygons = tree.add_polygons(keys);
    let none = tree.add_polygons(&[]);
    let sphere = Sphere::new(Vec3::ZERO, 2.0);
    let leaf = |polygons| {
        PhysicsNode::Leaf(PhysicsLeaf {
            index: 0,
            solid: 0,
            sphere,
            polygons,
        })
    };
    let inner = PhysicsNode::Inner(PhysicsInner {
        tag: BspTag::BPIN,
        plane: Plane { n: Vec3::Z, d: 1.5 },
        positive: NodeId::new(1),
        negative: NodeId::new(2),
        sphere,
    });
    tree.nodes = vec![inner, leaf(polygons), leaf(none)];
    tree
}

fn object(keys: &[u16]) -> GfxObj {
    let (vertices, polygons) = faces(false);
    GfxObj {
        id: 0x0100_0001,
        flags: GfxObjFlags::PHYSICS,
        surfaces: Vec::new(),
        vertices,
        physics: Some(PhysicsShape {
            polygons,
            bsp: tree(keys),
        }),
        sort_center: Vec3::ZERO,
        drawing: None,
        degrade: 0,
    }
}

#[test]
fn an_object_becomes_a_shape() {
    let shape = GfxShape::from_record(&object(&[0, 1, 2, 3, 4, 5]), &RETAIL).expect("a tree");
    assert_eq!(shape.id, 0x0100_0001);
    assert_eq!(
        (shape.bounds.min, shape.bounds.max),
        (Vec3::NEG_ONE, Vec3::ONE)
    );
    assert_eq!(shape.physics_sphere(), Some(Sphere::new(Vec3::ZERO, 2.0)));
    let tree = shape.physics.expect("it collides");
    let touching = Sphere::new(Vec3::Z * 1.2, 0.5);
    assert!(tree.sphere_intersects_solid(&touching, false, &RETAIL));
}

#[test]
fn an_object_without_polygons_collides_with_nothing() {
    let mut record = object(&[]);
    record.physics = Some(PhysicsShape {
        polygons: PolygonSet::default(),
        bsp: tree(&[]),
    });
    let shape = GfxShape::from_record(&record, &RETAIL).expect("nothing to refuse");
    assert!(!shape.has_physics_bsp() && shape.physics_sphere().is_none());
}

#[test]
fn a_tree_with_a_missing_polygon_is_refused() {
    let error = GfxShape::from_record(&object(&[6]), &RETAIL).map(drop);
    assert_eq!(error, Err(TreeError::NoPolygon { node: 1, key: 6 }));
}

#[test]
fn a_room_becomes_a_shape() {
    let (vertices, polygons) = faces(true);
    let chain = [Vec3::Z, Vec3::NEG_Z, Vec3::X, Vec3::NEG_X];
    let mut cell_bsp = BspTree::default();
    for (i, n) in chain.into_iter().enumerate() {
        cell_bsp.nodes.push(CellNode::Inner(CellInner {
            tag: BspTag::BPnn,
            plane: Plane { n, d: 1.0 },
            positive: NodeId::new(i + 1),
            negative: None,
        }));
    }
    cell_bsp.nodes.push(CellNode::Leaf(CellLeaf { index: 0 }));
    let record = CellStruct {
        vertices,
        physics_polygons: polygons.clone(),
        polygons,
        portals: vec![4],
        cell_bsp,
        physics_bsp: tree(&[0, 1, 2, 3, 4, 5]),
        drawing_bsp: None,
    };
    let shape = CellShape::from_record(&record, &RETAIL).expect("a tree");
    assert!(shape.contains(Vec3::ZERO) && !shape.contains(Vec3::Z * 1.1));
    let corner = Sphere::new(Vec3::Z * 1.1, 0.5);
    assert_eq!(
        shape.intersects_sphere(&corner),
        BoundingType::PartiallyInside
    );
    assert!(shape.portal(4).is_some() && shape.portal(3).is_none() && shape.portal(9).is_none());
    assert!(shape.physics.sphere_intersects_solid(
        &Sphere::new(Vec3::Z * 0.8, 0.5),
        false,
        &RETAIL
    ));
}
