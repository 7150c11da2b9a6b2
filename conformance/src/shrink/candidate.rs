//! A scene with the records of its own world, and the ways to take something out of it.

use std::{
    collections::BTreeMap,
    ops::Range,
    sync::{Arc, OnceLock},
};

use ac_client::dat::{
    DatBuilder, DatError, DatFile, DatSet, DataSet, ITERATION_ID, REGION_ID, Strictness,
};
use ac_golden_traces::{
    Scene,
    scene::{Action, FrameRun},
};

use super::{ShrinkError, Size};

/// The bytes of every record of a world, by id.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Records {
    /// Of the portal file.
    pub portal: BTreeMap<u32, Vec<u8>>,
    /// Of the cell file.
    pub cell: BTreeMap<u32, Vec<u8>>,
}

/// A scene with its world.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The scene.
    pub scene: Scene,
    /// Records of its world.
    pub records: Arc<Records>,
    /// The world as it is opened; made when it is first asked for.
    opened: Arc<OnceLock<Arc<DatSet>>>,
}

fn world(error: DatError) -> ShrinkError {
    ShrinkError::World(error.to_string())
}

impl Records {
    /// All records of a world.
    ///
    /// # Errors
    /// When one cannot be read.
    pub fn of(set: &DatSet) -> Result<Self, ShrinkError> {
        let read = |file: &DatFile| -> Result<BTreeMap<u32, Vec<u8>>, DatError> {
            let entries = file.entries()?;
            let wanted = entries.iter().filter(|entry| entry.id != ITERATION_ID);
            wanted
                .map(|entry| Ok((entry.id, file.read(entry)?)))
                .collect()
        };
        Ok(Self {
            portal: read(set.portal()).map_err(world)?,
            cell: read(set.cell()).map_err(world)?,
        })
    }

    /// The bytes of the portal and of the cell file.
    ///
    /// # Errors
    /// When they cannot be written as dat files.
    pub fn files(&self) -> Result<[Vec<u8>; 2], ShrinkError> {
        let file = |set, records: &BTreeMap<u32, Vec<u8>>| {
            let mut builder = DatBuilder::new(set);
            for (id, bytes) in records {
                builder.insert(*id, bytes.clone());
            }
            builder.write().map_err(world)
        };
        Ok([
            file(DataSet::Portal, &self.portal)?,
            file(DataSet::Cell, &self.cell)?,
        ])
    }

    /// Number of records in both files.
    pub fn len(&self) -> usize {
        self.portal.len() + self.cell.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Without the records at these places, counted through both files, cell first. The region stays: no world opens without it.
    fn without(&self, range: &Range<usize>) -> Self {
        let mut place = 0..;
        let mut keep = |id: &u32| {
            let place = place.next().unwrap_or(usize::MAX);
            !range.contains(&place) || *id == REGION_ID
        };
        let mut of = |records: &BTreeMap<u32, Vec<u8>>| {
            let kept = records.iter().filter(|(id, _)| keep(id));
            kept.map(|(id, bytes)| (*id, bytes.clone())).collect()
        };
        Self {
            cell: of(&self.cell),
            portal: of(&self.portal),
        }
    }
}

impl Candidate {
    /// A scene with its world.
    pub fn new(scene: Scene, records: Records) -> Self {
        Self {
            scene,
            records: Arc::new(records),
            opened: Arc::default(),
        }
    }

    /// The opened world. Candidates with the same records share it.
    ///
    /// # Errors
    /// When it is none: a record that it cannot do without is not there.
    pub fn world(&self) -> Result<Arc<DatSet>, ShrinkError> {
        if let Some(set) = self.opened.get() {
            return Ok(Arc::clone(set));
        }
        let [portal, cell] = self.records.files()?;
        let open = |name, bytes, set| {
            DatFile::from_bytes(name, bytes, Some(set), Strictness::Lenient).map_err(world)
        };
        let portal = open("portal", portal, DataSet::Portal)?;
        let cell = open("cell", cell, DataSet::Cell)?;
        let set = Arc::new(DatSet::from_files(portal, cell).map_err(world)?);
        Ok(Arc::clone(self.opened.get_or_init(|| set)))
    }

    /// Its size.
    ///
    /// # Errors
    /// When its world cannot be written.
    pub fn size(&self) -> Result<Size, ShrinkError> {
        let created = self.scene.script.iter();
        let created = created.filter(|step| matches!(step.action, Action::Create { .. }));
        Ok(Size {
            frames: self.scene.frame_count(),
            entities: self.scene.entities.len() + created.count(),
            steps: self.scene.script.len(),
            records: self.records.len(),
            world_bytes: self.records.files()?.iter().map(Vec::len).sum(),
        })
    }

    /// Takes away all frames after this one.
    pub fn end_after(&mut self, frame: i32) {
        let lengths = lengths(&self.scene);
        let count = usize::try_from(frame).map_or(0, |frame| frame + 1);
        if count < lengths.len() {
            self.scene.frames = runs(&lengths[..count]);
        }
        let end = u32::try_from(count).unwrap_or(u32::MAX);
        self.scene.script.retain(|step| step.frame < end);
    }

    /// Without frames. What the script does in them is done in the next frame that is left.
    pub fn without_frames(&self, range: &Range<usize>) -> Self {
        let mut lengths = lengths(&self.scene);
        lengths.drain(range.clone());
        let mut scene = self.scene.clone();
        scene.frames = runs(&lengths);
        let (start, end) = (range.start as u32, range.end as u32);
        for step in &mut scene.script {
            if step.frame >= end {
                step.frame -= end - start;
            } else if step.frame >= start {
                step.frame = start;
            }
        }
        self.with(scene)
    }

    /// Without entities that exist from the start, and without what is done to them.
    pub fn without_entities(&self, range: &Range<usize>) -> Self {
        let mut scene = self.scene.clone();
        let gone: Vec<u32> = scene
            .entities
            .drain(range.clone())
            .map(|entity| entity.guid)
            .collect();
        let created = |guid: u32| {
            self.scene.script.iter().any(
                |step| matches!(&step.action, Action::Create { entity } if entity.guid == guid),
            )
        };
        scene
            .script
            .retain(|step| !gone.contains(&step.guid) || created(step.guid));
        scene
            .track
            .retain(|guid| !gone.contains(guid) || created(*guid));
        self.with(scene)
    }

    /// Without steps of the script.
    pub fn without_steps(&self, range: &Range<usize>) -> Self {
        let mut scene = self.scene.clone();
        scene.script.drain(range.clone());
        self.with(scene)
    }

    /// Without tracked entities.
    pub fn without_tracked(&self, range: &Range<usize>) -> Self {
        let mut scene = self.scene.clone();
        scene.track.drain(range.clone());
        self.with(scene)
    }

    /// Without records of the world.
    pub fn without_records(&self, range: &Range<usize>) -> Self {
        Self {
            scene: self.scene.clone(),
            records: Arc::new(self.records.without(range)),
            opened: Arc::default(),
        }
    }

    /// The same world with another scene.
    pub fn with(&self, scene: Scene) -> Self {
        Self {
            scene,
            ..self.clone()
        }
    }
}

/// The length of each frame, seconds.
fn lengths(scene: &Scene) -> Vec<f64> {
    let runs = scene.frames.iter();
    runs.flat_map(|run| std::iter::repeat_n(run.dt, run.count as usize))
        .collect()
}

/// Frames of the same length as runs.
fn runs(lengths: &[f64]) -> Vec<FrameRun> {
    let mut runs: Vec<FrameRun> = Vec::new();
    for dt in lengths {
        match runs.last_mut() {
            Some(run) if run.dt.to_bits() == dt.to_bits() => run.count += 1,
            _ => runs.push(FrameRun { dt: *dt, count: 1 }),
        }
    }
    runs
}
