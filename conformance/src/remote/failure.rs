//! What stores say when they fail.

use std::error::Error;

use object_store::client::{HttpError, HttpErrorKind};

use super::RemoteError;

/// What a store says, in our words where they help.
pub(super) fn classify(url: &str, error: &object_store::Error) -> RemoteError {
    use object_store::Error as E;

    let url = url.to_owned();
    let reason = chain(error);
    match error {
        E::NotFound { .. } => RemoteError::NotFound { url, reason },
        E::PermissionDenied { .. } | E::Unauthenticated { .. } => {
            RemoteError::Permission { url, reason }
        }
        _ if is_unreachable(error) => RemoteError::Unreachable {
            url,
            copies: "the cache was not asked",
            reason,
        },
        _ => RemoteError::Store { url, reason },
    }
}

/// Whether no answer came at all.
fn is_unreachable(error: &object_store::Error) -> bool {
    let mut next: Option<&(dyn Error + 'static)> = Some(error);
    while let Some(error) = next {
        if let Some(http) = error.downcast_ref::<HttpError>() {
            return matches!(
                http.kind(),
                HttpErrorKind::Connect | HttpErrorKind::Timeout | HttpErrorKind::Request
            );
        }
        next = error.source();
    }
    false
}

/// The messages of an error and its sources, without what is said twice.
fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut next = error.source();
    while let Some(error) = next {
        let message = error.to_string();
        if !text.contains(&message) {
            text += &format!(": {message}");
        }
        next = error.source();
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
