//! What a keyframe belongs to.

use std::collections::BTreeMap;

use ac_client::profile::Profile;
use ac_golden_traces::trace::TraceInfo;
use serde::{Deserialize, Serialize};

use super::KeyframeError;
use crate::client::SCENE_VERSION;

/// First word of a header.
const FORMAT: &str = "ac-keyframe";

/// Versions of the forms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Versions {
    /// Of header and compression.
    pub keyframe: u32,
    /// Of what the scene remembers.
    pub scene: u32,
    /// Of the world.
    pub world: u32,
}

impl Versions {
    /// What this program writes, and the only ones that it reads.
    pub const CURRENT: Self = Self {
        keyframe: 1,
        scene: SCENE_VERSION,
        world: ac_client::snapshot::VERSION,
    };
}

/// What a run is of: the same identity gives the same states.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Name of the scene.
    pub scene: String,
    /// BLAKE3 of the scene file.
    pub scene_hash: String,
    /// BLAKE3 of each file of the world, by file name.
    pub world: BTreeMap<String, String>,
    /// Name of the profile.
    pub profile: String,
    /// BLAKE3 of all its switches.
    pub profile_hash: String,
}

impl Identity {
    /// The identity of a run of the scene in `scene_text` under a profile; `info` names scene and world.
    pub fn new(info: &TraceInfo, scene_text: &[u8], profile: &Profile) -> Self {
        let mut switches = blake3::Hasher::new();
        for switch in Profile::SWITCHES {
            let line = format!("{} = {}\n", switch.field, (switch.show)(profile));
            switches.update(line.as_bytes());
        }
        Self {
            scene: info.scene.clone(),
            scene_hash: blake3::hash(scene_text).to_string(),
            world: info.world.clone(),
            profile: profile.name.into(),
            profile_hash: switches.finalize().to_string(),
        }
    }

    /// Refuses a keyframe of another run.
    ///
    /// # Errors
    /// What is another one.
    pub fn accept(&self, header: &KeyframeHeader) -> Result<(), KeyframeError> {
        let found = &header.identity;
        let other = |what: &str, found: &str, wanted: &str| {
            Err(KeyframeError::Other {
                what: what.into(),
                found: format!("`{found}`"),
                wanted: format!("`{wanted}`"),
            })
        };
        if found.scene != self.scene {
            return other("scene", &found.scene, &self.scene);
        }
        if found.scene_hash != self.scene_hash {
            return other("scene file", &found.scene_hash, &self.scene_hash);
        }
        if found.profile != self.profile {
            return other("profile", &found.profile, &self.profile);
        }
        if found.profile_hash != self.profile_hash {
            let what = format!("form of profile {}", self.profile);
            return other(&what, &found.profile_hash, &self.profile_hash);
        }
        let files = found.world.keys().chain(self.world.keys());
        for file in files {
            let hash = |world: &BTreeMap<String, String>| {
                world
                    .get(file)
                    .cloned()
                    .unwrap_or_else(|| "no such file".into())
            };
            let (found, wanted) = (hash(&found.world), hash(&self.world));
            if found != wanted {
                return other(&format!("world ({file})"), &found, &wanted);
            }
        }
        Ok(())
    }
}

/// The head of a keyframe: one line of JSON in front of the compressed snapshot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KeyframeHeader {
    /// `ac-keyframe`.
    pub format: String,
    /// Versions of the forms.
    pub versions: Versions,
    /// The state is that after this frame.
    pub frame: i32,
    /// What the run is of.
    #[serde(flatten)]
    pub identity: Identity,
    /// Length of the snapshot, bytes.
    pub length: u64,
    /// BLAKE3 of the snapshot: a hash of all state, the same for equal states.
    pub hash: String,
}

impl KeyframeHeader {
    /// The header of a snapshot.
    pub fn new(frame: i32, identity: &Identity, snapshot: &[u8]) -> Self {
        Self {
            format: FORMAT.into(),
            versions: Versions::CURRENT,
            frame,
            identity: identity.clone(),
            length: snapshot.len() as u64,
            hash: blake3::hash(snapshot).to_string(),
        }
    }

    /// Refuses what this program does not read.
    ///
    /// # Errors
    /// Another format or version.
    pub fn check(&self) -> Result<(), KeyframeError> {
        if self.format != FORMAT {
            let reason = format!("its header says `{}`", self.format);
            return Err(KeyframeError::Format(reason));
        }
        let known = Versions::CURRENT;
        for (what, found, known) in [
            ("keyframe format", self.versions.keyframe, known.keyframe),
            ("scene form", self.versions.scene, known.scene),
            ("world form", self.versions.world, known.world),
        ] {
            if found != known {
                return Err(KeyframeError::Version { what, found, known });
            }
        }
        Ok(())
    }
}

/// The beginning of a header, which every version has.
#[derive(Deserialize)]
struct AnyHeader {
    format: String,
    versions: Versions,
}

impl KeyframeHeader {
    /// Reads a header; one of another version is refused for that reason, whatever else it has.
    ///
    /// # Errors
    /// No header, or one that this program does not read.
    pub(super) fn parse(text: &[u8]) -> Result<Self, KeyframeError> {
        let bad = |error: serde_json::Error| KeyframeError::Format(format!("its header: {error}"));
        let any: AnyHeader = serde_json::from_slice(text).map_err(bad)?;
        let unread = Self {
            format: any.format,
            versions: any.versions,
            frame: 0,
            identity: Identity {
                scene: String::new(),
                scene_hash: String::new(),
                world: BTreeMap::new(),
                profile: String::new(),
                profile_hash: String::new(),
            },
            length: 0,
            hash: String::new(),
        };
        unread.check()?;
        serde_json::from_slice(text).map_err(bad)
    }
}
