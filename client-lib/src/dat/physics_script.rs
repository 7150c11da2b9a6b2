//! Physics script, 0x33......, and physics script table, 0x34...... Source: `spec/11-dat-files.md, 9.10`.

use serde::Serialize;

use super::hook::AnimationHook;
use super::kind::RecordKind;
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;

/// Hooks with times. In file order; a client runs them sorted **stably** by time (D-35): [`PhysicsScript::in_order_of_time`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhysicsScript {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Start time in seconds, and hook, in file order.
    pub entries: Vec<ScriptEntry>,
}

/// One event of a script.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScriptEntry {
    /// Seconds after the script's start.
    pub time: f64,
    /// What happens.
    pub hook: AnimationHook,
}

impl PhysicsScript {
    /// Entries sorted stably by time.
    #[must_use]
    pub fn in_order_of_time(&self) -> Vec<&ScriptEntry> {
        let mut list: Vec<&ScriptEntry> = self.entries.iter().collect();
        list.sort_by(|a, b| a.time.total_cmp(&b.time));
        list
    }
}

impl Record for PhysicsScript {
    const KIND: RecordKind = RecordKind::PhysicsScript;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let n = r.count_u32("script entries", 16)?;
        Ok(Self {
            id,
            entries: r.many(n, |r| {
                Ok(ScriptEntry {
                    time: r.f64()?,
                    hook: AnimationHook::parse(r)?,
                })
            })?,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.count_u32("script entries", self.entries.len());
        for e in &self.entries {
            w.f64(e.time);
            e.hook.write(w);
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}

/// Which script stands for which kind of event, by intensity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhysicsScriptTable {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Kind of event and its scripts.
    pub kinds: Vec<(u32, Vec<ScriptChoice>)>,
}

/// A script and the intensity up to which it is meant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ScriptChoice {
    /// Intensity.
    pub modifier: f32,
    /// Script, 0x33......
    #[serde(serialize_with = "super::json::hex")]
    pub script: u32,
}

impl Record for PhysicsScriptTable {
    const KIND: RecordKind = RecordKind::PhysicsScriptTable;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let n = r.count_u32("script kinds", 8)?;
        let kinds = r.many(n, |r| {
            let kind = r.u32()?;
            let m = r.count_u32("scripts", 8)?;
            Ok((
                kind,
                r.many(m, |r| {
                    Ok(ScriptChoice {
                        modifier: r.f32()?,
                        script: r.u32()?,
                    })
                })?,
            ))
        })?;
        Ok(Self { id, kinds })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.count_u32("script kinds", self.kinds.len());
        for (kind, choices) in &self.kinds {
            w.u32(*kind);
            w.count_u32("scripts", choices.len());
            for c in choices {
                w.f32(c.modifier);
                w.u32(c.script);
            }
        }
    }

    fn id(&self) -> u32 {
        self.id
    }
}
