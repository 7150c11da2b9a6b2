//! Forms of what everything consists of: numbers, ids, flags, vectors, places, lists.

use std::collections::VecDeque;

use super::form::{Stored, stored};
use super::{Restorer, SnapshotError};
use crate::dat::StoredFrame;
use crate::math::{CellId, Frame, Plane, Position, Quat, Vec3};
use crate::motion::{Action, Actions, Command, MovementFlags};
use crate::physics::body::{EntityId, StaticId};
use crate::physics::state::{PhysicsState, TransientState};
use crate::world::CellHandle;

#[cfg(test)]
use super::form::Forms;

/// Types that are stored as they are.
macro_rules! plain {
    ($($type:ty),*) => {$(
        impl Stored for $type {
            type Form = Self;
            fn store(&self) -> Self {
                self.clone()
            }
            fn restore(form: Self, _: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
                Ok(form)
            }
            #[cfg(test)]
            fn describe(_: &mut Forms) -> String {
                stringify!($type).into()
            }
        }
    )*};
}

plain!(bool, u8, u16, u32, u64, i32, f32, f64, String, [u16; 9]);

/// Types that are a number with a meaning.
macro_rules! number {
    ($($type:ty as $form:ty = $name:literal: |$value:ident| $store:expr, |$number:ident| $restore:expr;)*) => {$(
        impl Stored for $type {
            type Form = $form;
            fn store(&self) -> $form {
                let $value = *self;
                $store
            }
            fn restore($number: $form, _: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
                $restore
            }
            #[cfg(test)]
            fn describe(_: &mut Forms) -> String {
                concat!($name, " as ", stringify!($form)).into()
            }
        }
    )*};
}

number! {
    CellId as u32 = "cell id": |id| id.0, |n| Ok(Self(n));
    CellHandle as u32 = "cell handle": |id| id.0, |n| Ok(Self(n));
    EntityId as u32 = "entity": |id| id.0, |n| Ok(Self(n));
    StaticId as u32 = "static object": |id| id.0, |n| Ok(Self(n));
    Command as u32 = "command": |command| command.0, |n| Ok(Self(n));
    PhysicsState as u32 = "physics state": |flags| flags.bits(), |n| Ok(Self::from_bits_retain(n));
    TransientState as u32 = "transient state": |flags| flags.bits(), |n| Ok(Self::from_bits_retain(n));
    MovementFlags as u32 = "movement flags": |flags| flags.bits(), |n| Ok(Self::from_bits_retain(n));
    Vec3 as [f32; 3] = "vector": |v| v.to_array(), |n| Ok(Self::from_array(n));
    Quat as [f32; 4] = "rotation": |q| [q.w, q.x, q.y, q.z], |n| Ok(Self::new(n[0], n[1], n[2], n[3]));
    [f32; 2] as [f32; 2] = "pair": |pair| pair, |n| Ok(n);
    usize as u64 = "index": |index| index as u64, |n| usize::try_from(n)
        .map_err(|_| super::inconsistent(format!("{n} is no index")));
}

/// Boxed, so that a list of nothing takes little memory: one byte of a file stands for each.
impl<T: Stored> Stored for Option<T> {
    type Form = Option<Box<T::Form>>;

    fn store(&self) -> Self::Form {
        self.as_ref().map(|value| Box::new(value.store()))
    }

    fn restore(form: Self::Form, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        form.map(|form| T::restore(*form, by)).transpose()
    }

    #[cfg(test)]
    fn describe(forms: &mut Forms) -> String {
        format!("optional {}", T::describe(forms))
    }
}

impl<T: Stored> Stored for Box<T> {
    type Form = T::Form;

    fn store(&self) -> Self::Form {
        T::store(self)
    }

    fn restore(form: Self::Form, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        Ok(Self::new(T::restore(form, by)?))
    }

    #[cfg(test)]
    fn describe(forms: &mut Forms) -> String {
        T::describe(forms)
    }
}

/// Lists of both kinds.
macro_rules! list {
    ($($list:ident),*) => {$(
        impl<T: Stored> Stored for $list<T> {
            type Form = Vec<T::Form>;

            fn store(&self) -> Self::Form {
                self.iter().map(T::store).collect()
            }

            fn restore(form: Self::Form, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
                by.spend(form.len())?;
                form.into_iter().map(|form| T::restore(form, by)).collect()
            }

            #[cfg(test)]
            fn describe(forms: &mut Forms) -> String {
                format!("list of {}", T::describe(forms))
            }
        }
    )*};
}

list!(Vec, VecDeque);

impl<A: Stored, B: Stored> Stored for (A, B) {
    type Form = (A::Form, B::Form);

    fn store(&self) -> Self::Form {
        (self.0.store(), self.1.store())
    }

    fn restore(form: Self::Form, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        Ok((A::restore(form.0, by)?, B::restore(form.1, by)?))
    }

    #[cfg(test)]
    fn describe(forms: &mut Forms) -> String {
        format!("({}, {})", A::describe(forms), B::describe(forms))
    }
}

/// The matrix of a frame follows from its rotation.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FrameForm {
    origin: [f32; 3],
    rotation: [f32; 4],
}

impl Stored for Frame {
    type Form = FrameForm;

    fn store(&self) -> FrameForm {
        let (origin, rotation) = self.parts();
        FrameForm {
            origin: origin.store(),
            rotation: rotation.store(),
        }
    }

    fn restore(form: FrameForm, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        let FrameForm { origin, rotation } = form;
        Ok(Self::new(
            Vec3::restore(origin, by)?,
            Quat::restore(rotation, by)?,
        ))
    }

    #[cfg(test)]
    fn describe(_: &mut Forms) -> String {
        "frame { origin: [f32; 3], rotation: [f32; 4] }".into()
    }
}

stored!(
    struct PositionForm of Position { cell: CellId, frame: Frame }
);
stored!(
    struct PlaneForm of Plane { n: Vec3, d: f32 }
);
stored!(
    struct StoredFrameForm of StoredFrame { origin: Vec3, rotation: Quat }
);
stored!(
    struct ActionForm of Action { command: Command, speed: f32, stamp: u32, autonomous: bool }
);

impl Stored for Actions {
    type Form = Vec<ActionForm>;

    fn store(&self) -> Self::Form {
        self.iter().map(Action::store).collect()
    }

    fn restore(form: Self::Form, by: &mut Restorer<'_>) -> Result<Self, SnapshotError> {
        let mut actions = Self::default();
        for action in Vec::<Action>::restore(form, by)? {
            actions.add(action);
        }
        Ok(actions)
    }

    #[cfg(test)]
    fn describe(forms: &mut Forms) -> String {
        Vec::<Action>::describe(forms)
    }
}
