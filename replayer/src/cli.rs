//! The command line of `ac-replay`.
//!
//! Exit codes: 0 = done; 1 = `dat check` found faults, or `seek` another state than the trace holds; 2 = it could not be done (the message says what, where, and what to do).

use std::{
    fs::File,
    io::BufWriter,
    num::NonZeroU32,
    ops::RangeInclusive,
    path::{Path, PathBuf},
    process::ExitCode,
};

use ac_client::{frame::FrameStates, profile::Profile};
use ac_golden_traces::{
    GoldenError, Scene,
    import::hash_world,
    trace::{FormatVersion, TraceInfo, TraceReader},
};
use clap::{Parser, Subcommand};
use miette::{IntoDiagnostic, WrapErr, miette};

use crate::{
    Simulation, Simulator,
    client::ClientSimulator,
    keyframes::{self, Identity},
    replay::{Detail, Replay, last_frame, replay_frames},
};

/// The command could not run.
pub const COULD_NOT_RUN: u8 = 2;

#[derive(Parser)]
#[command(
    name = "ac-replay",
    version,
    about = "Runs scenes and recordings through the client library"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene and write what every tracked entity did as a trace.
    Run(RunArgs),
    /// Go to a frame of a trace by its keyframes and print the state there; exit code 1 if the trace holds another one.
    Seek(keyframes::SeekArgs),
    /// List the keyframes of a trace, or print one.
    Keyframes(keyframes::KeyframesArgs),
    /// Look into dat files and check them.
    Dat(crate::dat_cmd::DatArgs),
}

#[derive(clap::Args)]
struct RunArgs {
    /// A scene (`*.scene.json`), or a trace (`*.mcap`) whose scene is run again.
    input: PathBuf,
    /// Folder of the worlds. Default: the bundled worlds.
    #[arg(long)]
    worlds: Option<PathBuf>,
    /// Behaviour to run under. Default: that of the trace which is run again, else `retail`.
    #[arg(long)]
    profile: Option<String>,
    /// Also write what goes into and comes out of every stage of every entity's tick.
    #[arg(long)]
    checkpoints: bool,
    /// Also write all state after every N frames, so that `seek` and `run --from` need not run what is before.
    #[arg(long, value_name = "N")]
    keyframes: Option<NonZeroU32>,
    /// Write frames from this one on; a trace with keyframes goes on from the last one before. Default: -1, the state before
    /// the first frame.
    #[arg(long, value_name = "FRAME", allow_negative_numbers = true)]
    from: Option<i32>,
    /// Write frames up to this one. Default: the last.
    #[arg(long, value_name = "FRAME", allow_negative_numbers = true)]
    to: Option<i32>,
    /// Do not use the keyframes of the input: run from the start.
    #[arg(long)]
    from_start: bool,
    /// The trace to write.
    #[arg(short, long)]
    output: PathBuf,
}

/// Parses the arguments of the process and runs the command.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let _ = error.print();
            return if error.use_stderr() {
                ExitCode::from(COULD_NOT_RUN)
            } else {
                ExitCode::SUCCESS
            };
        }
    };
    let outcome = match cli.command {
        Command::Run(args) => run(&args).map(|()| ExitCode::SUCCESS),
        Command::Seek(args) => keyframes::seek(&args),
        Command::Keyframes(args) => keyframes::list(&args).map(|()| ExitCode::SUCCESS),
        Command::Dat(args) => crate::dat_cmd::run(&args, &mut std::io::stdout().lock())
            .map(|verdict| ExitCode::from(verdict.code()))
            .map_err(miette::Report::new),
    };
    match outcome {
        Ok(code) => code,
        Err(report) => {
            eprintln!("{report:?}");
            ExitCode::from(COULD_NOT_RUN)
        }
    }
}

fn run(args: &RunArgs) -> miette::Result<()> {
    let worlds = keyframes::worlds(args.worlds.as_deref());
    let simulator = ClientSimulator::new(&worlds);
    let (input, info) = load(args, &worlds)?;
    let profile =
        keyframes::profile_for(args.profile.as_deref(), &info.profile).into_diagnostic()?;
    let info = TraceInfo {
        version: FormatVersion::CURRENT,
        producer: concat!("ac-replay ", env!("CARGO_PKG_VERSION")).into(),
        profile: profile.name.into(),
        ..info
    };
    let frames = frames(args, &input.scene)?;
    let identity = Identity::new(&info, &input.text, &profile);
    let mut simulation = begin(args, &worlds, &simulator, &input, &profile, *frames.start())?;
    let context = || format!("cannot write {}", args.output.display());
    let out = BufWriter::new(
        File::create(&args.output)
            .into_diagnostic()
            .wrap_err_with(context)?,
    );
    let what = Replay {
        scene: &input.scene,
        scene_text: &input.text,
        info: &info,
        detail: if args.checkpoints {
            Detail::Checkpoints
        } else {
            Detail::States
        },
        frames,
        keyframes: args.keyframes.map(|every| (every, &identity)),
    };
    let frames = replay_frames(simulation.as_mut(), &what, out)
        .into_diagnostic()
        .wrap_err_with(context)?;
    println!(
        "{}: {frames} frames of {} entities in {}",
        info.scene,
        input.scene.track.len(),
        args.output.display()
    );
    Ok(())
}

/// The frames that are asked for.
fn frames(args: &RunArgs, scene: &Scene) -> miette::Result<RangeInclusive<i32>> {
    let last = last_frame(scene);
    let (from, to) = (args.from.unwrap_or(-1), args.to.unwrap_or(last));
    if from < -1 || to > last || from > to {
        return Err(miette!(
            help = format!("scene {} has the frames -1 to {last}", scene.name),
            "there are no frames {from} to {to}"
        ));
    }
    Ok(from..=to)
}

/// A simulation that stands before frame `first`: from a keyframe of the input if it has one, else from the start.
fn begin(
    args: &RunArgs,
    worlds: &Path,
    simulator: &ClientSimulator,
    input: &Input,
    profile: &Profile,
    first: i32,
) -> miette::Result<Box<dyn Simulation>> {
    let mut states = FrameStates::new();
    if first > 0 && input.is_trace && !args.from_start {
        let mut seeker = keyframes::open(&args.input, worlds, Some(profile.name), simulator)?;
        // Those of another profile are not for this run.
        if seeker.trace().info().profile != profile.name {
            seeker.ignore_keyframes();
        }
        let sought = seeker.seek(first - 1, &mut states).into_diagnostic()?;
        return Ok(sought.simulation);
    }
    let mut simulation = simulator.start(&input.scene, profile).into_diagnostic()?;
    for frame in 0..first {
        states.clear();
        let frame = frame.cast_unsigned();
        simulation.step(frame, &mut states).into_diagnostic()?;
    }
    Ok(simulation)
}

/// What is run.
struct Input {
    scene: Scene,
    text: Vec<u8>,
    is_trace: bool,
}

/// The input, and what a trace of it says about itself; the profile is that of the input, if it has one.
fn load(args: &RunArgs, worlds: &Path) -> miette::Result<(Input, TraceInfo)> {
    let (input, profile) = read(&args.input).into_diagnostic()?;
    let world = hash_world(&worlds.join(&input.scene.world))
        .into_diagnostic()
        .wrap_err_with(|| {
            format!(
                "the world `{}` is not under {}; name its folder with --worlds",
                input.scene.world,
                worlds.display()
            )
        })?;
    let info = TraceInfo {
        version: FormatVersion::CURRENT,
        scene: input.scene.name.clone(),
        producer: String::new(),
        profile,
        world,
    };
    Ok((input, info))
}

/// The scene in a file, its text, and the profile under which a trace was produced.
fn read(path: &Path) -> Result<(Input, String), GoldenError> {
    let is_trace = path
        .extension()
        .is_some_and(|extension| extension == "mcap");
    if is_trace {
        let reader = TraceReader::open(path)?;
        let input = Input {
            scene: reader.scene().clone(),
            text: reader.scene_text().to_vec(),
            is_trace,
        };
        return Ok((input, reader.info().profile.clone()));
    }
    let text = std::fs::read(path).map_err(|source| GoldenError::Io {
        path: path.into(),
        source,
    })?;
    let scene = Scene::parse(&text, path)?;
    let input = Input {
        scene,
        text,
        is_trace,
    };
    Ok((input, String::new()))
}
