use std::io::Cursor;

use super::*;
use crate::corpus;
use crate::trace::TraceReader;

/// Messages by topic: schema name, encodings, and bytes. Every schema must describe its message.
fn read(bytes: &[u8]) -> BTreeMap<String, Vec<Vec<u8>>> {
    let mut topics: BTreeMap<String, Vec<Vec<u8>>> = BTreeMap::new();
    for message in mcap::MessageStream::new(bytes).expect("an MCAP file") {
        let message = message.expect("readable");
        let channel = &message.channel;
        assert_eq!(channel.message_encoding, "protobuf");
        let schema = channel.schema.as_ref().expect("a schema");
        assert_eq!(schema.encoding, "protobuf");
        let expected = match channel.topic.as_str() {
            "/scene" => "foxglove.SceneUpdate",
            "/tf" => "foxglove.FrameTransforms",
            "/log" => "foxglove.Log",
            other => panic!("{other}"),
        };
        assert_eq!(schema.name, expected);
        describes(&schema.data, expected);
        topics
            .entry(channel.topic.clone())
            .or_default()
            .push(message.data.to_vec());
    }
    topics
}

/// A schema of protobuf is a set of files; one of them must define the message.
fn describes(schema: &[u8], name: &str) {
    let set = <prost_types::FileDescriptorSet as prost::Message>::decode(schema)
        .expect("a FileDescriptorSet");
    let defined = set.file.iter().flat_map(|file| {
        let package = file.package().to_owned();
        file.message_type
            .iter()
            .map(move |m| format!("{package}.{}", m.name()))
    });
    assert!(defined.into_iter().any(|n| n == name), "{name}");
}

fn decoded<T: prost::Message + Default>(bytes: &[Vec<u8>]) -> Vec<T> {
    let messages = bytes.iter().map(|b| T::decode(&b[..]));
    messages.map(|m| m.expect("as its schema says")).collect()
}

fn look(label: &str) -> Look {
    Look {
        label: label.into(),
        color: [1.0, 0.0, 0.0, 1.0],
        facts: vec![("guid".into(), "1".into())],
    }
}

fn at(cell: u32, x: f32) -> Place {
    Place {
        cell,
        origin: [x, 2.0, 3.0],
        rotation: [1.0, 0.0, 0.0, 0.0],
    }
}

#[test]
fn objects_move_leave_paths_and_go() {
    let mut pictures = PictureWriter::new(Cursor::new(Vec::new()), "test").expect("memory");
    let first = at(0xA9B4_0001, 1.0);
    for (time, place) in [
        (1, first),
        (2, first),
        (3, at(0xA9B4_0001, 5.0)),
        // The next landblock to the east.
        (4, at(0xAAB4_0001, 1.0)),
        (5, at(0, 1.0)),
        (5, at(0xA9B4_0001, f32::NAN)),
    ] {
        pictures
            .place(time, "X", &look("Drudge"), &place)
            .expect("memory");
    }
    pictures
        .log(6, Level::Warning, "net", "lost".into())
        .expect("memory");
    pictures.remove(7, "X").expect("memory");
    pictures.remove(8, "X").expect("memory");
    let (out, counts) = pictures.finish().expect("memory");
    assert_eq!((counts.objects, counts.places, counts.lines), (1, 4, 1));
    let topics = read(out.get_ref());

    let transforms: Vec<FrameTransforms> = decoded(&topics["/tf"]);
    let all: Vec<_> = transforms.iter().flat_map(|t| &t.transforms).collect();
    let x = |i: usize| all[i].translation.expect("a place").x;
    assert_eq!(
        (all[0].parent_frame_id.as_str(), x(0)),
        ("world", 169.0 * 192.0)
    );
    assert_eq!(all[1].child_frame_id, "object/X");
    assert_eq!([x(1), x(2), x(3), x(4)], [1.0, 1.0, 5.0, 193.0]);

    let updates: Vec<SceneUpdate> = decoded(&topics["/scene"]);
    let ids: Vec<_> = updates
        .iter()
        .flat_map(|u| u.entities.iter().map(|e| e.id.as_str()))
        .collect();
    let expected = ["object/X", "landblock/A9B4", "path/X", "landblock/AAB4"];
    // The jump to the next landblock begins a new path.
    assert_eq!(ids, expected);
    let gone = updates.last().expect("a deletion");
    assert_eq!(gone.deletions.len(), 2);

    let lines: Vec<Log> = decoded(&topics["/log"]);
    assert_eq!((lines[0].message.as_str(), lines[0].level), ("lost", 3));
}

#[test]
fn a_trace_becomes_pictures() {
    let path = &corpus::bundled().join("traces/terrain/cliff-jump.mcap");
    let mut trace = TraceReader::open(path).expect("a trace");
    let mut out = Cursor::new(Vec::new());
    let counts = of_trace(&mut trace, &mut out, "test", path).expect("memory");
    assert!(counts.objects > 0 && counts.places > counts.objects);
    let topics = read(out.get_ref());
    let transforms: Vec<FrameTransforms> = decoded(&topics["/tf"]);
    assert_eq!(transforms.len(), counts.places + 1);
    let _: Vec<SceneUpdate> = decoded(&topics["/scene"]);
    let lines: Vec<Log> = decoded(&topics["/log"]);
    assert_eq!(lines.len(), counts.lines);
}
