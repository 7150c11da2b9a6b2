//! The dat files of a world: a portal and a cell file, and the records read from them.
//!
//! Records are read when they are first asked for and then shared: they never change, and the same id always gives the same value, so the
//! cache cannot be seen in results. Source: `spec/11-dat-files.md, 3.10`.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use super::container::{DatFile, ReadCounts};
use super::error::{DatError, Problem};
use super::kind::{DataSet, REGION_ID, RecordKind};
use super::reader::Strictness;
use super::record::Record;
use super::{
    Animation, DegradeInfo, EnvCell, Environment, GfxObj, Landblock, LandblockInfo, MotionTable,
    Palette, ParticleEmitterInfo, PhysicsScript, PhysicsScriptTable, Region, RenderSurface, Scene,
    Setup, SoundTable, Surface, SurfaceTexture,
};

/// File name of the portal file in a world's folder.
pub const PORTAL_FILE: &str = "client_portal.dat";
/// File name of the cell file in a world's folder.
pub const CELL_FILE: &str = "client_cell_1.dat";

type Cache<T> = Mutex<BTreeMap<u32, Arc<T>>>;

/// A record type that a [`DatSet`] keeps. Implemented by this module only.
pub trait Kept: Record {
    /// Which of the two files holds it.
    const DATA_SET: DataSet;

    #[doc(hidden)]
    fn cache(caches: &Caches) -> &Mutex<BTreeMap<u32, Arc<Self>>>;
}

macro_rules! kept {
    ($($(#[$doc:meta])* $field:ident: $type:ident in $set:ident,)*) => {
        /// Records read so far.
        #[derive(Debug, Default)]
        #[doc(hidden)]
        pub struct Caches {
            $($field: Cache<$type>,)*
        }

        $(impl Kept for $type {
            const DATA_SET: DataSet = DataSet::$set;

            fn cache(caches: &Caches) -> &Cache<Self> {
                &caches.$field
            }
        })*

        impl DatSet {
            $($(#[$doc])*
            ///
            /// # Errors
            /// A damaged file or record. A record that is not there is `None`.
            pub fn $field(&self, id: u32) -> Result<Option<Arc<$type>>, DatError> {
                self.get(id)
            })*

            /// Drops the records that nobody else holds.
            pub fn forget_unused(&self) {
                $(lock(&self.caches.$field).retain(|_, r| Arc::strong_count(r) > 1);)*
            }
        }
    };
}

kept! {
    /// Landblock record, id 0xXXYYFFFF; see [`DatSet::landblock_of`] for any id of the block.
    landblock: Landblock in Cell,
    /// Landblock info record, id 0xXXYYFFFE.
    landblock_info: LandblockInfo in Cell,
    /// Room.
    env_cell: EnvCell in Cell,
    /// Shape.
    gfx_obj: GfxObj in Portal,
    /// Setup.
    setup: Setup in Portal,
    /// Animation.
    animation: Animation in Portal,
    /// Motion table.
    motion_table: MotionTable in Portal,
    /// Environment.
    environment: Environment in Portal,
    /// Scene.
    scene: Scene in Portal,
    /// Region by id; the one of this world is [`DatSet::region`].
    region_record: Region in Portal,
    /// Degrade info.
    degrade_info: DegradeInfo in Portal,
    /// Physics script.
    physics_script: PhysicsScript in Portal,
    /// Physics script table.
    physics_script_table: PhysicsScriptTable in Portal,
    /// Particle emitter.
    particle_emitter: ParticleEmitterInfo in Portal,
    /// Sound table.
    sound_table: SoundTable in Portal,
    /// Palette.
    palette: Palette in Portal,
    /// Surface.
    surface: Surface in Portal,
    /// Surface texture.
    surface_texture: SurfaceTexture in Portal,
    /// Render surface.
    render_surface: RenderSurface in Portal,
}

/// An opened world: portal file, cell file, region, and the records read so far.
#[derive(Debug)]
pub struct DatSet {
    portal: DatFile,
    cell: DatFile,
    region: Arc<Region>,
    caches: Caches,
}

impl DatSet {
    /// Opens `client_portal.dat` and `client_cell_1.dat` in a folder.
    ///
    /// # Errors
    /// A file that cannot be opened, is damaged or of the wrong kind; a missing region record.
    pub fn open(folder: impl AsRef<Path>, strictness: Strictness) -> Result<Self, DatError> {
        let folder = folder.as_ref();
        let portal = DatFile::open(folder.join(PORTAL_FILE), Some(DataSet::Portal), strictness)?;
        let cell = DatFile::open(folder.join(CELL_FILE), Some(DataSet::Cell), strictness)?;
        Self::from_files(portal, cell)
    }

    /// A world of two opened files.
    ///
    /// # Errors
    /// Files of the wrong kind; a missing or damaged region record.
    pub fn from_files(portal: DatFile, cell: DatFile) -> Result<Self, DatError> {
        for (file, expected) in [(&portal, DataSet::Portal), (&cell, DataSet::Cell)] {
            let (expected, found) = (expected.value(), file.header().data_set);
            if expected != found {
                return Err(DatError::in_file(
                    file.name(),
                    0x14C,
                    Problem::WrongDataSet { expected, found },
                ));
            }
        }
        let region = portal
            .record::<Region>(REGION_ID)?
            .ok_or_else(|| missing(&portal, REGION_ID, RecordKind::Region, None))?;
        Ok(Self {
            portal,
            cell,
            region: Arc::new(region),
            caches: Caches::default(),
        })
    }

    /// The portal file.
    #[must_use]
    pub fn portal(&self) -> &DatFile {
        &self.portal
    }

    /// The cell file.
    #[must_use]
    pub fn cell(&self) -> &DatFile {
        &self.cell
    }

    /// The region of this world.
    #[must_use]
    pub fn region(&self) -> &Arc<Region> {
        &self.region
    }

    /// Work done on both files (portal, cell).
    #[must_use]
    pub fn counts(&self) -> (ReadCounts, ReadCounts) {
        (self.portal.counts(), self.cell.counts())
    }

    /// Landblock record of the block of any cell id.
    ///
    /// # Errors
    /// As [`DatSet::get`].
    pub fn landblock_of(&self, cell_id: u32) -> Result<Option<Arc<Landblock>>, DatError> {
        self.landblock(cell_id | 0xFFFF)
    }

    /// Landblock info record of the block of any cell id.
    ///
    /// # Errors
    /// As [`DatSet::get`].
    pub fn landblock_info_of(&self, cell_id: u32) -> Result<Option<Arc<LandblockInfo>>, DatError> {
        self.landblock_info(cell_id & 0xFFFF_0000 | 0xFFFE)
    }

    /// A record; `None` if it is not in its file, or the id is not one of this type's.
    ///
    /// # Errors
    /// A damaged file or record.
    pub fn get<T: Kept>(&self, id: u32) -> Result<Option<Arc<T>>, DatError> {
        if RecordKind::of(T::DATA_SET, id) != T::KIND {
            return Ok(None);
        }
        if let Some(record) = lock(T::cache(&self.caches)).get(&id) {
            return Ok(Some(Arc::clone(record)));
        }
        let Some(record) = self.file(T::DATA_SET).record::<T>(id)? else {
            return Ok(None);
        };
        // Another thread may have been faster; all must share one value.
        let mut cache = lock(T::cache(&self.caches));
        Ok(Some(Arc::clone(
            cache.entry(id).or_insert_with(|| Arc::new(record)),
        )))
    }

    /// A record that must be there; `wanted_by` is the id of the record that names it.
    ///
    /// # Errors
    /// [`Problem::Missing`], and those of [`DatSet::get`].
    pub fn require<T: Kept>(&self, id: u32, wanted_by: Option<u32>) -> Result<Arc<T>, DatError> {
        self.get(id)?
            .ok_or_else(|| missing(self.file(T::DATA_SET), id, T::KIND, wanted_by))
    }

    fn file(&self, data_set: DataSet) -> &DatFile {
        match data_set {
            DataSet::Cell => &self.cell,
            DataSet::Portal | DataSet::Local => &self.portal,
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    // A cache is whole after every statement, so a panic elsewhere does not spoil it.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn missing(file: &DatFile, id: u32, kind: RecordKind, wanted_by: Option<u32>) -> DatError {
    DatError::in_record(
        file.name(),
        id,
        0,
        Problem::Missing {
            kind: kind.name(),
            wanted_by,
        },
    )
}
