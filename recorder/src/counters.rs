//! What a proxy counts while it runs. Nothing is lost without being counted.

use std::sync::atomic::{AtomicU64, Ordering};

use serde::{Deserialize, Serialize};

macro_rules! counters {
    ($($(#[doc = $doc:literal])* $name:ident),* $(,)?) => {
        /// Counters that the relay and the writer share.
        #[derive(Debug, Default)]
        #[allow(missing_docs, reason = "see `Counts`")]
        pub struct Counters { $(pub $name: AtomicU64),* }

        /// The counters at one moment.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
        #[serde(default)]
        pub struct Counts { $($(#[doc = $doc])* pub $name: u64),* }

        impl Counters {
            /// The counters now.
            pub fn counts(&self) -> Counts {
                Counts { $($name: self.$name.load(Ordering::Relaxed)),* }
            }
        }

        impl Counts {
            /// Names and values.
            pub fn iter(&self) -> impl Iterator<Item = (&'static str, u64)> {
                [$((stringify!($name), self.$name)),*].into_iter()
            }
        }
    };
}

counters! {
    /// Datagrams that arrived from clients.
    from_clients,
    /// Datagrams that arrived from the server.
    from_server,
    /// Datagrams passed on to the server.
    to_server,
    /// Datagrams passed on to clients.
    to_clients,
    /// Datagrams that the system refused to send.
    not_sent,
    /// Datagrams for clients that were kept until the client had proved its address.
    held,
    /// Of these, those that were dropped because too many waited.
    held_dropped,
    /// Datagrams from unknown addresses that are no valid login: not passed on, not recorded.
    refused,
    /// Logins while there were too many clients.
    too_many_clients,
    /// Datagrams from addresses that are not the server's.
    strangers,
    /// Datagrams that the system dropped because the proxy read them too late (Linux).
    system_dropped,
    /// Datagrams recorded and on their way to the disk, or there.
    recorded,
    /// Datagrams that are not in the recording because the disk was too slow: they waited for the writer and there were too many.
    unwritten_slow,
    /// Datagrams that are not in the recording because writing failed.
    unwritten_failed,
    /// Secret bytes overwritten.
    secret_bytes,
    /// Files begun.
    files,
}

/// Adds to a counter.
pub fn add(counter: &AtomicU64, n: u64) {
    counter.fetch_add(n, Ordering::Relaxed);
}

impl Counts {
    /// Datagrams that were passed on or tried to be, but are not in the recording.
    pub const fn unwritten(&self) -> u64 {
        self.unwritten_slow + self.unwritten_failed
    }
}

/// Says what was lost since the last time.
pub fn complain(before: &Counts, now: &Counts) {
    let slow = now.unwritten_slow - before.unwritten_slow;
    if slow > 0 {
        tracing::error!(
            datagrams = slow,
            in_all = now.unwritten_slow,
            "NOT RECORDED: the disk is too slow. Datagrams are still passed on"
        );
    }
    let failed = now.unwritten_failed - before.unwritten_failed;
    if failed > 0 {
        tracing::error!(
            datagrams = failed,
            in_all = now.unwritten_failed,
            "NOT RECORDED: the file cannot be written. Datagrams are still passed on"
        );
    }
    let dropped = now.system_dropped - before.system_dropped;
    if dropped > 0 {
        tracing::warn!(
            datagrams = dropped,
            "LOST: the system dropped datagrams because this program was not fast enough"
        );
    }
    let full = now.too_many_clients - before.too_many_clients;
    if full > 0 {
        tracing::warn!(logins = full, "too many clients; see --max-clients");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_survive_json_and_newer_programs() {
        let counters = Counters::default();
        add(&counters.recorded, 3);
        add(&counters.unwritten_failed, 2);
        let counts = counters.counts();
        assert_eq!((counts.recorded, counts.unwritten()), (3, 2));
        let json = serde_json::to_string(&counts).expect("plain numbers");
        assert_eq!(
            serde_json::from_str::<Counts>(&json).expect("own JSON"),
            counts
        );
        let other: Counts = serde_json::from_str(r#"{"recorded":1,"new":5}"#).expect("open");
        assert_eq!(other.recorded, 1);
    }
}
