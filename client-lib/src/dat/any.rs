//! A record of any kind, for tools that go through a whole file.

use serde::Serialize;

use super::error::DatError;
use super::kind::{DataSet, RecordKind};
use super::reader::{Note, Reader, Strictness};
use super::record::Record;
use super::writer::Writer;
use super::{
    Animation, DegradeInfo, EnvCell, Environment, GfxObj, Iteration, Landblock, LandblockInfo,
    MotionTable, Palette, PaletteSet, ParticleEmitterInfo, PhysicsScript, PhysicsScriptTable,
    Region, RenderSurface, Scene, Setup, SoundTable, Surface, SurfaceTexture, Wave,
};

macro_rules! any_record {
    ($($variant:ident($type:ty) = $($kind:ident)|+,)*) => {
        /// A record of any kind that this library reads.
        #[derive(Debug, Clone, PartialEq, Serialize)]
        #[serde(untagged)]
        #[allow(
            missing_docs,
            clippy::large_enum_variant,
            reason = "variants are named after their content, and there is one at a time"
        )]
        pub enum AnyRecord {
            $($variant($type),)*
        }

        impl AnyRecord {
            /// Reads a record of a given kind; `None` if the layout of that kind is not known.
            ///
            /// # Errors
            /// As [`Record::from_bytes`].
            pub fn parse(kind: RecordKind, file: &str, id: u32, bytes: &[u8], strictness: Strictness) -> Option<Result<(Self, Vec<Note>), DatError>> {
                match kind {
                    $($(RecordKind::$kind)|+ => Some(<$type>::from_bytes_noting(file, id, bytes, strictness).map(|(r, n)| (Self::$variant(r), n))),)*
                    RecordKind::Other => None,
                }
            }

            /// Reads up to where the record ends and answers how many bytes that is; `None` if the layout of that kind is not known.
            ///
            /// # Errors
            /// As [`Record::parse`].
            pub fn measure(kind: RecordKind, file: &str, id: u32, bytes: &[u8]) -> Option<Result<usize, DatError>> {
                let mut r = Reader::new(file, id, bytes, Strictness::Lenient);
                match kind {
                    $($(RecordKind::$kind)|+ => Some(<$type>::parse(&mut r).map(|_| r.offset())),)*
                    RecordKind::Other => None,
                }
            }

            /// The bytes to store.
            ///
            /// # Errors
            /// As [`Record::to_bytes`].
            pub fn to_bytes(&self) -> Result<Vec<u8>, DatError> {
                let mut w = Writer::new();
                match self {
                    $(Self::$variant(r) => { r.write(&mut w); w.finish(r.id()) })*
                }
            }
        }
    };
}

any_record! {
    Landblock(Landblock) = Landblock,
    LandblockInfo(LandblockInfo) = LandblockInfo,
    EnvCell(EnvCell) = EnvCell,
    GfxObj(GfxObj) = GfxObj,
    Setup(Setup) = Setup,
    Animation(Animation) = Animation,
    Palette(Palette) = Palette,
    SurfaceTexture(SurfaceTexture) = SurfaceTexture | RenderTexture,
    RenderSurface(RenderSurface) = RenderSurface,
    Surface(Surface) = Surface,
    MotionTable(MotionTable) = MotionTable,
    Wave(Wave) = Wave,
    Environment(Environment) = Environment,
    PaletteSet(PaletteSet) = PaletteSet,
    DegradeInfo(DegradeInfo) = DegradeInfo,
    Scene(Scene) = Scene,
    Region(Region) = Region,
    SoundTable(SoundTable) = SoundTable,
    ParticleEmitter(ParticleEmitterInfo) = ParticleEmitter,
    PhysicsScript(PhysicsScript) = PhysicsScript,
    PhysicsScriptTable(PhysicsScriptTable) = PhysicsScriptTable,
    Iteration(Iteration) = Iteration,
}

impl AnyRecord {
    /// Reads the record with this id of a file of this data set; `None` if its layout is not known.
    ///
    /// # Errors
    /// As [`Record::from_bytes`].
    pub fn of(
        data_set: DataSet,
        file: &str,
        id: u32,
        bytes: &[u8],
        strictness: Strictness,
    ) -> Option<Result<(Self, Vec<Note>), DatError>> {
        Self::parse(RecordKind::of(data_set, id), file, id, bytes, strictness)
    }
}
