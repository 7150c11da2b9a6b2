//! What a type is stored as, and the two macros that write the conversions of plain structs and enums.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Restorer, SnapshotError};

/// A type that is state, and the plain type it is stored as.
pub(super) trait Stored: Sized {
    /// What is written.
    type Form: Serialize + DeserializeOwned;

    /// The state as plain data.
    fn store(&self) -> Self::Form;

    /// The state again.
    fn restore(form: Self::Form, by: &mut Restorer<'_>) -> Result<Self, SnapshotError>;

    /// Name of the form; adds what it consists of to `forms`, for the test of the version.
    #[cfg(test)]
    fn describe(forms: &mut Forms) -> String;
}

/// Definitions of forms by name.
#[cfg(test)]
pub(super) type Forms = std::collections::BTreeMap<&'static str, String>;

/// Adds the definition of a form, once.
#[cfg(test)]
pub(super) fn define(
    forms: &mut Forms,
    name: &'static str,
    definition: impl FnOnce(&mut Forms) -> String,
) -> String {
    if !forms.contains_key(name) {
        forms.insert(name, String::new());
        let definition = definition(forms);
        forms.insert(name, definition);
    }
    name.to_owned()
}

/// `stored!(struct Form of Type { field: FieldType, … })`: every field of the struct is state. A field that is missing here does not compile.
///
/// `stored!(enum Form of Type { Unit, One(inner: Inner), Many { field: FieldType, … }, … })`: the same for enums.
macro_rules! stored {
    ($(#[$doc:meta])* struct $form:ident of $type:ty { $($field:ident : $ty:ty),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub(super) struct $form {
            $(pub $field: <$ty as $crate::snapshot::form::Stored>::Form,)*
        }

        impl $crate::snapshot::form::Stored for $type {
            type Form = $form;

            fn store(&self) -> $form {
                // Without `..`: a new field has to be decided about.
                let Self { $($field),* } = self;
                $form { $($field: $crate::snapshot::form::Stored::store($field),)* }
            }

            fn restore(
                form: $form,
                by: &mut $crate::snapshot::Restorer<'_>,
            ) -> Result<Self, $crate::snapshot::SnapshotError> {
                let $form { $($field),* } = form;
                Ok(Self { $($field: $crate::snapshot::form::Stored::restore($field, by)?,)* })
            }

            #[cfg(test)]
            fn describe(forms: &mut $crate::snapshot::form::Forms) -> String {
                $crate::snapshot::form::define(forms, stringify!($form), |forms| {
                    let mut text = String::new();
                    $(
                        text += concat!("\n  ", stringify!($field), ": ");
                        text += &<$ty as $crate::snapshot::form::Stored>::describe(forms);
                    )*
                    text
                })
            }
        }
    };
    ($(#[$doc:meta])* enum $form:ident of $type:ty {
        $($variant:ident $(($inner:ident : $ity:ty))? $({ $($field:ident : $fty:ty),* $(,)? })?),* $(,)?
    }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub(super) enum $form {
            $($variant
                $((<$ity as $crate::snapshot::form::Stored>::Form))?
                $({ $($field: <$fty as $crate::snapshot::form::Stored>::Form),* })?,)*
        }

        impl $crate::snapshot::form::Stored for $type {
            type Form = $form;

            fn store(&self) -> $form {
                match self {
                    $(Self::$variant $(($inner))? $({ $($field),* })? => $form::$variant
                        $(($crate::snapshot::form::Stored::store($inner)))?
                        $({ $($field: $crate::snapshot::form::Stored::store($field)),* })?,)*
                }
            }

            fn restore(
                form: $form,
                by: &mut $crate::snapshot::Restorer<'_>,
            ) -> Result<Self, $crate::snapshot::SnapshotError> {
                let _ = &by;
                Ok(match form {
                    $($form::$variant $(($inner))? $({ $($field),* })? => Self::$variant
                        $((<$ity as $crate::snapshot::form::Stored>::restore($inner, by)?))?
                        $({ $($field: <$fty as $crate::snapshot::form::Stored>::restore($field, by)?),* })?,)*
                })
            }

            #[cfg(test)]
            fn describe(forms: &mut $crate::snapshot::form::Forms) -> String {
                $crate::snapshot::form::define(forms, stringify!($form), |forms| {
                    let _ = &forms;
                    let mut text = String::new();
                    $(
                        text += concat!("\n  | ", stringify!($variant));
                        $(
                            text += &format!("({})", <$ity as $crate::snapshot::form::Stored>::describe(forms));
                        )?
                        $($(
                            text += &format!(" {}: {}", stringify!($field),
                                <$fty as $crate::snapshot::form::Stored>::describe(forms));
                        )*)?
                    )*
                    text
                })
            }
        }
    };
}

pub(super) use stored;
