//! `ac-replay seek` and `ac-replay keyframes`.

use std::{
    io::Write,
    path::{Path, PathBuf},
    process::ExitCode,
};

use ac_client::{
    frame::{FrameState, FrameStates},
    profile::Profile,
};
use ac_golden_traces::{
    corpus,
    import::hash_world,
    record,
    trace::{ChannelKind, SeekableTrace},
};
use clap::ValueEnum;
use miette::{IntoDiagnostic, WrapErr};

use super::{KeyframeError, Seeker, Sought, frame_of, name_of};
use crate::client::ClientSimulator;

/// The state of the trace differs from that of the client.
const DIFFERS: u8 = 1;

/// Arguments of `ac-replay seek`.
#[derive(clap::Args)]
pub struct SeekArgs {
    /// A trace (`*.mcap`).
    trace: PathBuf,
    /// The frame; -1 is the state before the first one.
    #[arg(long, allow_negative_numbers = true)]
    frame: i32,
    /// Folder of the worlds. Default: the bundled worlds.
    #[arg(long)]
    worlds: Option<PathBuf>,
    /// Behaviour to run under. Default: that of the trace.
    #[arg(long)]
    profile: Option<String>,
    /// Do not use keyframes: run from the start.
    #[arg(long)]
    from_start: bool,
    /// How to write the state.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Arguments of `ac-replay keyframes`.
#[derive(clap::Args)]
pub struct KeyframesArgs {
    /// A trace (`*.mcap`).
    trace: PathBuf,
    /// Print the whole state of the keyframe after this frame as JSON, to be looked at.
    #[arg(long)]
    frame: Option<i32>,
}

/// How a state is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Format {
    /// One line of JSON per entity, as in the trace, and a line about the frame.
    #[default]
    Human,
    /// One JSON document with the records, the way there, and the hash of all state.
    Json,
}

/// The profile of this name; without one that of the trace, or `retail` for a trace that was not produced under any.
///
/// # Errors
/// When no profile has this name.
pub(crate) fn profile_for(name: Option<&str>, of_trace: &str) -> Result<Profile, KeyframeError> {
    let name = match (name, of_trace) {
        (Some(name), _) => name,
        (None, "") => "retail",
        (None, name) => name,
    };
    Profile::named(name).ok_or_else(|| KeyframeError::Profile(name.into()))
}

/// Opens a trace for seeking.
///
/// # Errors
/// When trace or world cannot be read, or there is no such profile.
pub(crate) fn open<'a>(
    trace: &Path,
    worlds: &Path,
    profile: Option<&str>,
    simulator: &'a ClientSimulator,
) -> miette::Result<Seeker<'a>> {
    let of_trace = SeekableTrace::open(trace).into_diagnostic()?;
    let profile = profile_for(profile, &of_trace.info().profile).into_diagnostic()?;
    Seeker::open(trace, simulator, profile, |world| {
        Ok(hash_world(&worlds.join(world))?)
    })
    .into_diagnostic()
    .wrap_err_with(|| format!("cannot seek in {}", trace.display()))
}

/// The folder of the worlds.
pub(crate) fn worlds(named: Option<&Path>) -> PathBuf {
    named.map_or_else(|| corpus::bundled().join("worlds"), Into::into)
}

/// Goes to a frame, prints its state, and compares it with what the trace holds. Exit code 1 when that differs.
///
/// # Errors
/// When the frame cannot be reached.
pub fn seek(args: &SeekArgs) -> miette::Result<ExitCode> {
    let worlds = worlds(args.worlds.as_deref());
    let simulator = ClientSimulator::new(&worlds);
    let mut seeker = open(&args.trace, &worlds, args.profile.as_deref(), &simulator)?;
    if args.from_start {
        seeker.ignore_keyframes();
    }
    let mut states = FrameStates::new();
    let sought = seeker
        .seek(args.frame, &mut states)
        .into_diagnostic()
        .wrap_err_with(|| {
            format!(
                "cannot go to frame {} of {}",
                args.frame,
                args.trace.display()
            )
        })?;
    let same = compare(&mut seeker, args.frame, &states).into_diagnostic()?;
    let hash = match sought.simulation.snapshot().into_diagnostic()? {
        Some(snapshot) => blake3::hash(&snapshot).to_string(),
        None => String::new(),
    };
    let text = match args.format {
        Format::Human => human(args.frame, &sought, &states, &hash, same),
        Format::Json => json(args.frame, &sought, &states, &hash, same).into_diagnostic()?,
    };
    emit(&text)?;
    Ok(if same == Some(false) {
        ExitCode::from(DIFFERS)
    } else {
        ExitCode::SUCCESS
    })
}

/// Whether the trace's own states of a frame have the same bits; `None` if it has none of this profile.
fn compare(
    seeker: &mut Seeker<'_>,
    frame: i32,
    states: &[FrameState],
) -> Result<Option<bool>, KeyframeError> {
    let profile = seeker.profile().name;
    if seeker.trace().info().profile != profile {
        return Ok(None);
    }
    let mut same = None;
    let trace = seeker.trace();
    trace.states(&ChannelKind::States, frame..=frame, |_, _, expected| {
        let pairs = states.iter().zip(expected.iter());
        let equal = pairs.fold(states.len() == expected.len(), |equal, (a, b)| {
            equal && a.has == b.has && a.guid == b.guid && a.fields_same_bits(b, b.has)
        });
        same = Some(equal);
    })?;
    Ok(same)
}

fn lines(states: &[FrameState]) -> Vec<Vec<u8>> {
    let line = |state| {
        let mut line = Vec::new();
        record::write_line(&mut line, state);
        line
    };
    states.iter().map(line).collect()
}

fn human(
    frame: i32,
    sought: &Sought,
    states: &[FrameState],
    hash: &str,
    same: Option<bool>,
) -> String {
    let mut text = String::new();
    for line in lines(states) {
        text += String::from_utf8_lossy(&line).trim_end();
        text.push('\n');
    }
    let from = match sought.keyframe {
        Some(keyframe) => format!("the keyframe after frame {keyframe}"),
        None => "the start of the scene".into(),
    };
    text += &format!(
        "frame {frame}: {} frames run from {from}; hash of all state {hash}\n",
        sought.replayed
    );
    text += match same {
        Some(true) => "the trace holds the same bits\n",
        Some(false) => {
            "the trace holds OTHER states: it was written by a program that behaves otherwise\n"
        }
        None => "",
    };
    text
}

fn json(
    frame: i32,
    sought: &Sought,
    states: &[FrameState],
    hash: &str,
    same: Option<bool>,
) -> serde_json::Result<String> {
    let records: Vec<serde_json::Value> = lines(states)
        .iter()
        .map(|line| serde_json::from_slice(line))
        .collect::<Result<_, _>>()?;
    let document = serde_json::json!({
        "frame": frame,
        "keyframe": sought.keyframe,
        "replayed": sought.replayed,
        "state_hash": hash,
        "same_as_trace": same,
        "records": records,
    });
    Ok(format!("{document:#}\n"))
}

/// Lists the keyframes of a trace, or prints one.
///
/// # Errors
/// When trace or keyframe cannot be read.
pub fn list(args: &KeyframesArgs) -> miette::Result<()> {
    let mut trace = SeekableTrace::open(&args.trace).into_diagnostic()?;
    if let Some(frame) = args.frame {
        let (_, snapshot) = read(&mut trace, frame).into_diagnostic()?;
        let state = crate::client::snapshot_to_json(&snapshot).into_diagnostic()?;
        return emit(&format!("{state:#}\n"));
    }
    let mut frames: Vec<i32> = trace.attachments().filter_map(frame_of).collect();
    frames.sort_unstable();
    if frames.is_empty() {
        return emit(&format!(
            "{} has no keyframes; `ac-replay run --keyframes N` writes some\n",
            args.trace.display()
        ));
    }
    let mut text = String::from("   frame      state  hash of all state\n");
    for frame in frames {
        text += &match read(&mut trace, frame) {
            Ok((header, _)) => format!("{frame:>8} {:>10}  {}\n", header.length, header.hash),
            Err(error) => format!("{frame:>8}  {error}\n"),
        };
    }
    emit(&text)
}

/// Writes to standard output. A reader that has seen enough (`| head`) is no error.
fn emit(text: &str) -> miette::Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(error).into_diagnostic()
        }
        _ => Ok(()),
    }
}

fn read(
    trace: &mut SeekableTrace<std::fs::File>,
    frame: i32,
) -> Result<(super::KeyframeHeader, Vec<u8>), KeyframeError> {
    let bytes = trace.attachment(&name_of(frame))?;
    let missing = || KeyframeError::Format(format!("there is none after frame {frame}"));
    super::decode(&bytes.ok_or_else(missing)?)
}
