//! An entity's record of a frame, and the way back (`spec/scene-format.md`, "Expected-state trace").

use super::Entity;
use crate::animation::{PartArray, Sequence};
use crate::frame::FrameState;
use crate::frame::state::{AnimState, Collision, ContactPlane, Fields, MotionState};
use crate::math::{CellId, Frame, Plane, Position, Quat, Vec3};
use crate::motion::{Command, MotionInterp};
use crate::physics::state::{PhysicsState, TransientState};
use crate::world::World;

impl Entity {
    /// Fills the record of this frame. Reuses the record's memory; nothing is allocated once its lists are large enough.
    pub fn frame_state(&self, frame: i32, time: f64, record: &mut FrameState) {
        record.reset(frame, time, self.guid());
        record.has = Fields::all()
            - Fields::PLANE_PARTS
            - Fields::ANIM_PARTS
            - Fields::MOTION_TABLE_PARTS
            - Fields::MOTION_INTERPRETED_PARTS;
        self.record_body(record);
        self.record_contact(record);
        self.record_animation(record);
        self.record_motion(record);
        record.steps.extend_from_slice(&self.steps);
        record.events.extend_from_slice(&self.events);
        if self.touched_environment {
            record.collisions.push(Collision::Environment);
        }
        let touched = self.touched.iter().map(|&guid| Collision::Object(guid));
        record.collisions.extend(touched);
        record.collisions.sort_unstable();
        record.collisions.dedup();
    }

    /// Forgets what was recorded of the last frame: events, steps, touches.
    pub fn begin_frame(&mut self) {
        self.events.clear();
        self.steps.clear();
        self.touched.clear();
        self.touched_environment = false;
    }

    fn record_body(&self, record: &mut FrameState) {
        let Position { cell, frame } = &self.body.position;
        let q = frame.rotation();
        record.cell = if self.body.cell.is_some() { cell.0 } else { 0 };
        record.origin = numbers(frame.origin);
        record.rotation = [q.w, q.x, q.y, q.z].map(number);
        record.velocity = numbers(self.kin.velocity);
        record.acceleration = numbers(self.kin.acceleration);
        record.omega = numbers(self.kin.omega);
        record.state = self.body.state.bits();
        record.transient = self.kin.transient.bits();
    }

    fn record_contact(&self, record: &mut FrameState) {
        let transient = self.kin.transient;
        if transient.contains(TransientState::CONTACT) {
            record.has |= Fields::PLANE_PARTS;
            record.contact_plane = Some(ContactPlane {
                n: numbers(self.kin.contact_plane.n),
                d: number(self.kin.contact_plane.d),
                cell: self.kin.contact_plane_cell_id.0,
            });
        }
        record.sliding_normal = transient
            .contains(TransientState::SLIDING)
            .then(|| numbers(self.kin.sliding_normal));
    }

    fn record_animation(&self, record: &mut FrameState) {
        let Some(parts) = &self.body.part_array else {
            record.anim = None;
            return;
        };
        record.has |= Fields::ANIM_PARTS;
        let sequence = &parts.sequence;
        let anim = record.anim.get_or_insert_with(AnimState::default);
        anim.frame_number = sequence.frame_number();
        anim.id = sequence.current_node().map_or(0, |n| n.animation_id());
        anim.first_cyclic = sequence.plays_cycle();
        anim.queue.clear();
        anim.queue
            .extend(sequence.nodes().map(|n| n.animation_id()));
        anim.velocity = numbers(sequence.velocity);
        anim.omega = numbers(sequence.omega);
    }

    fn record_motion(&self, record: &mut FrameState) {
        let table = self
            .body
            .part_array
            .as_ref()
            .and_then(|p| p.motion_table.as_ref());
        let interp = self.interp();
        if table.is_none() && interp.is_none() {
            return;
        }
        record.has |= Fields::MOTION_TABLE_PARTS;
        let mut motion = MotionState::default();
        if let Some(table) = table {
            motion.style = table.state.style;
            motion.substate = table.state.substate;
            motion.substate_speed = table.state.substate_speed;
        }
        if let Some(interp) = interp {
            record.has |= Fields::MOTION_INTERPRETED_PARTS;
            record_interpreted(interp, &mut motion);
        }
        record.motion = Some(motion);
    }
}

/// A number of a record. There is one "not a number": sign and payload of a computed one depend on the processor.
const fn number(x: f32) -> f32 {
    if x.is_nan() { f32::NAN } else { x }
}

fn numbers(v: Vec3) -> [f32; 3] {
    v.to_array().map(number)
}

fn record_interpreted(interp: &MotionInterp, motion: &mut MotionState) {
    let state = &interp.interpreted;
    motion.forward = state.forward_command.0;
    motion.forward_speed = state.forward_speed;
    motion.sidestep = state.sidestep_command.0;
    motion.sidestep_speed = state.sidestep_speed;
    motion.turn = state.turn_command.0;
    motion.turn_speed = state.turn_speed;
}

/// Resynchronising: every field that a record carries is taken over.
impl Entity {
    /// Sets the entity to a record: place and cell, velocities, state words, contact, animation frame, motion state. What a record does not
    /// carry stays: shadows are found anew, queues and the bounds of animations are kept.
    pub fn load_frame_state(&mut self, record: &FrameState, world: &mut World) {
        self.load_place(record, world);
        let has = |field| record.has.contains(field);
        if has(Fields::VELOCITY) {
            self.kin.velocity = record.velocity.into();
        }
        if has(Fields::ACCELERATION) {
            self.kin.acceleration = record.acceleration.into();
        }
        if has(Fields::OMEGA) {
            self.kin.omega = record.omega.into();
        }
        if has(Fields::STATE) {
            self.body.state = PhysicsState::from_bits_retain(record.state);
        }
        if has(Fields::TRANSIENT) {
            self.kin.transient = TransientState::from_bits_retain(record.transient);
        }
        if let Some(plane) = &record.contact_plane {
            self.kin.contact_plane = Plane {
                n: plane.n.into(),
                d: plane.d,
            };
            self.kin.contact_plane_cell_id = CellId(plane.cell);
        }
        if let Some(normal) = record.sliding_normal {
            self.kin.sliding_normal = normal.into();
        }
        self.load_animation(record);
        self.load_motion(record);
    }

    /// Takes cell and frame over; cell lists and shadows follow if they changed.
    fn load_place(&mut self, record: &FrameState, world: &mut World) {
        if !record.has.contains(Fields::ORIGIN | Fields::ROTATION) {
            return;
        }
        let [w, x, y, z] = record.rotation;
        let frame = Frame::new(record.origin.into(), Quat::new(w, x, y, z));
        let here = self.body.position.cell.0 == record.cell
            && self.body.position.frame.bits() == frame.bits();
        if here {
            return;
        }
        let cell = match record.cell {
            0 => None,
            id => world.visible_cell(CellId(id)),
        };
        if cell != self.body.cell {
            self.remove_shadows_from_cells(world);
            self.change_cell(cell, world);
        }
        self.set_frame(frame, world);
        if cell.is_some() && self.body.parent.is_none() {
            self.calc_cross_cells(world);
        }
    }

    fn load_animation(&mut self, record: &FrameState) {
        let (Some(parts), Some(anim)) = (self.body.part_array.as_mut(), record.anim.as_ref())
        else {
            return;
        };
        let PartArray { sequence, .. } = parts;
        if record.has.contains(Fields::ANIM_VELOCITY) {
            sequence.velocity = Vec3::from(anim.velocity);
        }
        if record.has.contains(Fields::ANIM_OMEGA) {
            sequence.omega = Vec3::from(anim.omega);
        }
        if record.has.contains(Fields::ANIM_FRAME_NUMBER) && plays(sequence, anim) {
            sequence.set_frame_number(anim.frame_number);
        }
    }

    fn load_motion(&mut self, record: &FrameState) {
        let Some(motion) = &record.motion else { return };
        let table = self
            .body
            .part_array
            .as_mut()
            .and_then(|p| p.motion_table.as_mut());
        if let Some(table) = table {
            table.state.style = motion.style;
            table.state.substate = motion.substate;
            table.state.substate_speed = motion.substate_speed;
        }
        let Some(interp) = self.interp_mut() else {
            return;
        };
        if record.has.contains(Fields::MOTION_INTERPRETED_PARTS) {
            let state = &mut interp.interpreted;
            state.forward_command = Command(motion.forward);
            state.forward_speed = motion.forward_speed;
            state.sidestep_command = Command(motion.sidestep);
            state.sidestep_speed = motion.sidestep_speed;
            state.turn_command = Command(motion.turn);
            state.turn_speed = motion.turn_speed;
        }
    }
}

/// Whether the sequence plays what the record says.
fn plays(sequence: &Sequence, anim: &AnimState) -> bool {
    sequence
        .nodes()
        .map(|n| n.animation_id())
        .eq(anim.queue.iter().copied())
        && sequence.current_node().map_or(0, |n| n.animation_id()) == anim.id
}
