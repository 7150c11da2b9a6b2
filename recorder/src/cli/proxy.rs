//! `ac-record proxy`.

use std::fmt::Write as _;
use std::net::{SocketAddr, ToSocketAddrs};
use std::path::PathBuf;
use std::time::Duration;

use super::{FOUND, units};
use crate::disk::{DiskConfig, Rotation};
use crate::error::RecordError;
use crate::format::WriterOptions;
use crate::proxy::{Proxy, ProxyConfig, ProxyReport, asked_to_stop};
use crate::relay::RelayLimits;
use crate::secrets::SecretPolicy;

#[derive(clap::Args)]
#[command(
    after_help = "Ctrl-C or SIGTERM ends the recording. The file is never more than half a second behind: after a crash, \
                        `ac-record recover` saves the rest."
)]
pub(super) struct ProxyArgs {
    /// Login port of the server, HOST:PORT; the next port is used too.
    #[arg(long)]
    server: String,
    /// Where clients connect; the next port is used too. Other machines reach the proxy only if this says so.
    #[arg(long, default_value = "127.0.0.1:9000")]
    listen: SocketAddr,
    /// Clients at once.
    #[arg(long, default_value_t = RelayLimits::default().clients)]
    max_clients: usize,
    /// The recording to write. Further files get a number: FILE-0002.mcap.
    #[arg(short, long)]
    output: PathBuf,
    /// Begin a new file after so many bytes, for example 100MB.
    #[arg(long, value_parser = units::size)]
    rotate_size: Option<u64>,
    /// Begin a new file after so much time, for example 1h.
    #[arg(long, value_parser = units::duration)]
    rotate_every: Option<Duration>,
    /// Hide the lengths of account and password too: logins are recorded as if both were "x".
    #[arg(long)]
    hide_length: bool,
    /// Write account names, passwords and tickets as they are. The file says so. Whoever has it can log in as you.
    #[arg(long, conflicts_with = "hide_length")]
    keep_secrets: bool,
    /// When the recording ends, also write it as pictures for Foxglove and Rerun (docs/foxglove.md).
    #[arg(long, value_name = "FILE")]
    foxglove: Option<PathBuf>,
    /// Write chunks uncompressed: larger files, less work.
    #[arg(long)]
    uncompressed: bool,
}

impl ProxyArgs {
    fn config(&self) -> Result<ProxyConfig, RecordError> {
        Ok(ProxyConfig {
            listen: self.listen,
            server: resolve(&self.server)?,
            limits: RelayLimits {
                clients: self.max_clients,
                ..RelayLimits::default()
            },
            disk: DiskConfig {
                options: WriterOptions {
                    secrets: policy(self.keep_secrets, self.hide_length),
                    compress: !self.uncompressed,
                },
                rotation: Rotation {
                    size: self.rotate_size,
                    every: self.rotate_every,
                },
                ..DiskConfig::new(self.output.clone())
            },
        })
    }
}

pub(super) const fn policy(keep_secrets: bool, hide_length: bool) -> SecretPolicy {
    if keep_secrets {
        SecretPolicy::Keep
    } else {
        SecretPolicy::Redact { hide_length }
    }
}

fn resolve(text: &str) -> Result<SocketAddr, RecordError> {
    let bad = |reason: String| RecordError::Address {
        text: text.into(),
        reason,
    };
    let mut found = text.to_socket_addrs().map_err(|e| bad(e.to_string()))?;
    found.next().ok_or_else(|| bad("no address".into()))
}

pub(super) fn proxy(args: &ProxyArgs) -> Result<(String, u8), RecordError> {
    let config = args.config()?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|source| RecordError::Socket {
            address: args.listen,
            source,
        })?;
    let report = runtime.block_on(async {
        let proxy = Proxy::open(&config)?;
        if args.keep_secrets {
            tracing::warn!("account names and passwords are written to the file (--keep-secrets)");
        }
        tracing::info!(listen = %config.listen, server = %config.server, "recording; Ctrl-C ends it");
        let stop = async {
            asked_to_stop().await;
            tokio::spawn(give_up_when_asked_again());
        };
        Ok::<_, RecordError>(proxy.run(stop).await)
    })?;
    let (mut text, code) = told(args, &report);
    if let Some(output) = &args.foxglove {
        let _ = super::export::draw(&report.disk.files, output, &mut text)?;
    }
    Ok((text, code))
}

/// A disk that does not answer must not make the program immortal.
async fn give_up_when_asked_again() {
    asked_to_stop().await;
    eprintln!("ended without waiting for the disk; `ac-record recover` saves what is there");
    std::process::exit(i32::from(FOUND));
}

/// What the proxy did, and whether something is wrong.
fn told(args: &ProxyArgs, report: &ProxyReport) -> (String, u8) {
    let (counts, disk) = (&report.counts, &report.disk);
    let mut text = String::new();
    for file in &disk.files {
        let _ = writeln!(text, "{}", file.display());
    }
    let _ = writeln!(
        text,
        "{} datagrams recorded, {} passed on to the server, {} to clients; {} secret bytes overwritten",
        counts.recorded, counts.to_server, counts.to_clients, counts.secret_bytes
    );
    let mut wrong = false;
    let losses = [
        (counts.unwritten_slow, "NOT RECORDED: the disk was too slow"),
        (
            counts.unwritten_failed,
            "NOT RECORDED: the file could not be written",
        ),
        (
            counts.system_dropped,
            "LOST: dropped by the system before this program saw them",
        ),
        (counts.not_sent, "NOT PASSED ON: the system refused"),
    ];
    for (count, what) in losses {
        if count > 0 {
            wrong = true;
            let _ = writeln!(text, "{count} datagrams {what}");
        }
    }
    let ignored = [
        (
            counts.refused,
            "datagrams of unknown addresses that are no login: not passed on",
        ),
        (
            counts.too_many_clients,
            "logins refused: too many clients (--max-clients)",
        ),
        (
            counts.held_dropped,
            "datagrams dropped for clients that had not answered yet",
        ),
        (
            counts.strangers,
            "datagrams that did not come from the server: ignored",
        ),
    ];
    for (count, what) in ignored {
        if count > 0 {
            let _ = writeln!(text, "{count} {what}");
        }
    }
    if args.keep_secrets {
        text.push_str("secrets were KEPT (--keep-secrets)\n");
        return (text, if wrong { FOUND } else { 0 });
    }
    for (path, places) in &disk.leaks {
        wrong = true;
        let _ = writeln!(
            text,
            "SECRET FOUND in {}: {places} places; do not share this file",
            path.display()
        );
    }
    for (path, why) in &disk.unchecked {
        wrong = true;
        let _ = writeln!(text, "not searched for secrets: {}: {why}", path.display());
    }
    if disk.leaks.is_empty() && disk.unchecked.is_empty() {
        let _ = writeln!(
            text,
            "self-check: none of {} secrets found in {} files",
            disk.secrets,
            disk.files.len()
        );
    }
    if disk.too_many_secrets {
        text.push_str("there were more logins than the self-check can remember\n");
    }
    (text, if wrong { FOUND } else { 0 })
}
