//! Everything that can go wrong with a recording.

use std::path::PathBuf;

use miette::Diagnostic;
use thiserror::Error;

/// Why a recording could not be made or read.
#[derive(Debug, Error, Diagnostic)]
pub enum RecordError {
    /// A file could not be opened, read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The MCAP layer refuses.
    #[error("recording: {0}")]
    #[diagnostic(help("a file that was cut off can be saved with `ac-record recover`"))]
    Mcap(#[from] mcap::McapError),
    /// The file is no recording of this program.
    #[error("{}: no recording of packets (there is no `{}` metadata)", path.display(), crate::format::METADATA)]
    #[diagnostic(help("traces of frames are read by `ac-replay` and `ac-conform`"))]
    NotARecording {
        /// The file.
        path: PathBuf,
    },
    /// The file ends before its metadata: the program that wrote it was ended right at the start.
    #[error("{}: the file ends before the recording starts", path.display())]
    #[diagnostic(help("nothing was recorded; `ac-record recover` makes an empty recording of it"))]
    NotStarted {
        /// The file.
        path: PathBuf,
    },
    /// The file's format is newer than this program.
    #[error("{}: format {found}, this program reads format {}", path.display(), crate::format::VERSION)]
    #[diagnostic(help("use a newer ac-record"))]
    Version {
        /// The file.
        path: PathBuf,
        /// The format.
        found: String,
    },
    /// A capture could not be read.
    #[error("{}: {reason}", path.display())]
    #[diagnostic(help(
        "captures of tcpdump, dumpcap and Wireshark can be imported: pcap and pcapng"
    ))]
    Capture {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A socket could not be opened.
    #[error("UDP {address}: {source}")]
    #[diagnostic(help(
        "two ports in a row are used, the named one and the next; another program may have one of them"
    ))]
    Socket {
        /// The address.
        address: std::net::SocketAddr,
        /// What the system says.
        source: std::io::Error,
    },
    /// An address is not one.
    #[error("{text}: {reason}")]
    Address {
        /// What was given.
        text: String,
        /// What is wrong.
        reason: String,
    },
    /// The demonstration server cannot run.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Demo(Box<crate::demo_server::shell::ShellError>),
    /// The scripted client cannot play.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Play(Box<crate::play::shell::PlayError>),
}
