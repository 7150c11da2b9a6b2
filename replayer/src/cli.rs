//! The command line of `ac-replay`.
//!
//! Exit codes: 0 = done; 1 = `dat check` found faults, or `seek` another state than the trace holds; 2 = it could not be done (the message says what, where, and what to do).

use std::{
    collections::BTreeMap,
    fs::File,
    io::BufWriter,
    num::NonZeroU32,
    ops::RangeInclusive,
    path::{Path, PathBuf},
    process::ExitCode,
};

use ac_client::{
    dat::DatSet,
    frame::{FrameStates, plan::Outputs},
    profile::Profile,
};
use ac_golden_traces::{
    GoldenError, Scene,
    import::hash_world,
    pictures::of_trace,
    trace::{FormatVersion, TraceInfo, TraceReader},
};
use clap::{Parser, Subcommand};
use miette::{IntoDiagnostic, WrapErr, miette};

use crate::{
    Simulation, Simulator,
    client::{ClientSimulator, PlanChoice, SceneRun},
    keyframes::{self, Identity},
    packets::{self, command::PacketArgs},
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
    /// Run a scene or a packet recording and write what every tracked entity did as a trace.
    Run(RunArgs),
    /// Go to a frame of a trace by its keyframes and print the state there; exit code 1 if the trace holds another one.
    Seek(keyframes::SeekArgs),
    /// List the keyframes of a trace, or print one.
    Keyframes(keyframes::KeyframesArgs),
    /// Say what can be left out of a scene, and why, or write it as a file for `run --plan`.
    Plan(crate::plan_cmd::Args),
    /// Look into dat files and check them.
    Dat(crate::dat_cmd::DatArgs),
}

#[derive(clap::Args)]
struct RunArgs {
    /// A scene (`*.scene.json`), a trace (`*.mcap`) whose scene is run again, or a packet recording of ac-record (`*.mcap`).
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
    #[arg(long, value_name = "N", conflicts_with = "plan")]
    keyframes: Option<NonZeroU32>,
    /// Write frames from this one on; a trace with keyframes goes on from the last one before. Default: -1, the state before
    /// the first frame.
    #[arg(
        long,
        value_name = "FRAME",
        allow_negative_numbers = true,
        conflicts_with = "plan"
    )]
    from: Option<i32>,
    /// Write frames up to this one. Default: the last.
    #[arg(long, value_name = "FRAME", allow_negative_numbers = true)]
    to: Option<i32>,
    /// Do not use the keyframes of the input: run from the start.
    #[arg(long)]
    from_start: bool,
    /// Work that is done: `full` (everything a client does), `auto` (what can change the states), or a file of `ac-replay plan`. The states
    /// are the same. Default: records are opened when they are first asked for, every entity is advanced in every frame.
    #[arg(long, value_name = "full|auto|FILE")]
    plan: Option<String>,
    /// Carry a plan file out even if it leaves out what may change the states.
    #[arg(long, requires = "plan")]
    force_plan: bool,
    /// The trace to write.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    packets: PacketArgs,
    /// Also write the trace as pictures for Foxglove and Rerun, an MCAP file (docs/foxglove.md).
    #[arg(long, value_name = "FILE")]
    foxglove: Option<PathBuf>,
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
        Command::Plan(args) => crate::plan_cmd::run(&args).map(|text| {
            print!("{text}");
            ExitCode::SUCCESS
        }),
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

/// Replays a packet recording.
fn run_packets(args: &RunArgs, bytes: &[u8]) -> miette::Result<()> {
    let refused = [
        args.plan.is_some(),
        args.checkpoints,
        args.keyframes.is_some(),
        args.from.is_some(),
        args.to.is_some(),
        args.foxglove.is_some(),
    ];
    if refused.contains(&true) {
        return Err(miette!(
            help = "leave out --plan, --checkpoints, --keyframes, --from, --to and --foxglove",
            "{} is a packet recording: it is replayed from its start, and written as states only",
            args.input.display()
        ));
    }
    let worlds = keyframes::worlds(args.worlds.as_deref());
    let profile = keyframes::profile_for(args.profile.as_deref(), "").into_diagnostic()?;
    let (session, scene) = args.packets.open(bytes, &args.input)?;
    let info = TraceInfo {
        version: FormatVersion::CURRENT,
        scene: scene.name.clone(),
        producer: concat!("ac-replay ", env!("CARGO_PKG_VERSION")).into(),
        profile: profile.name.into(),
        world: world_of(&scene, &worlds)?,
    };
    let simulator = ClientSimulator::new(&worlds);
    let output = &args.output;
    let text = packets::command::run(session, &scene, &simulator, &profile, &info, output)?;
    print!("{text}");
    Ok(())
}

/// Hashes of the files of a scene's world.
fn world_of(scene: &Scene, worlds: &Path) -> miette::Result<BTreeMap<String, String>> {
    hash_world(&worlds.join(&scene.world))
        .into_diagnostic()
        .wrap_err_with(|| {
            format!(
                "the world `{}` is not under {}; name its folder with --worlds",
                scene.world,
                worlds.display()
            )
        })
}

fn run(args: &RunArgs) -> miette::Result<()> {
    // What cannot be read is reported where it is read as a scene.
    if let Some(bytes) = packets::recording_at(&args.input) {
        return run_packets(args, &bytes);
    }
    let worlds = keyframes::worlds(args.worlds.as_deref());
    let plan = PlanChoice::parse(args.plan.as_deref(), args.force_plan).into_diagnostic()?;
    let outputs = Outputs {
        checkpoints: args.checkpoints,
    };
    let simulator = ClientSimulator::new(&worlds)
        .with_plan(plan)
        .with_outputs(outputs);
    let (input, info) = about(args, &worlds)?;
    let profile =
        keyframes::profile_for(args.profile.as_deref(), &info.profile).into_diagnostic()?;
    let info = TraceInfo {
        profile: profile.name.into(),
        ..info
    };
    let identity = Identity::new(&info, &input.text, &profile);
    let what = Replay {
        scene: &input.scene,
        scene_text: &input.text,
        info: &info,
        detail: if args.checkpoints {
            Detail::Checkpoints
        } else {
            Detail::States
        },
        frames: frames(args, &input.scene)?,
        keyframes: args.keyframes.map(|every| (every, &identity)),
    };
    if args.plan.is_some() {
        let mut simulation = simulator.run(&input.scene, &profile).into_diagnostic()?;
        write(args, &what, &mut simulation)?;
        let set = simulator.world(&input.scene.world).into_diagnostic()?;
        println!("{}", work(&simulation, &set));
        return Ok(());
    }
    let first = *what.frames.start();
    let mut simulation = begin(args, &worlds, &simulator, &input, &profile, first)?;
    write(args, &what, simulation.as_mut())
}

/// Runs the frames and writes the trace.
fn write(args: &RunArgs, what: &Replay<'_>, simulation: &mut dyn Simulation) -> miette::Result<()> {
    let context = || format!("cannot write {}", args.output.display());
    let out = BufWriter::new(
        File::create(&args.output)
            .into_diagnostic()
            .wrap_err_with(context)?,
    );
    let frames = replay_frames(simulation, what, out)
        .into_diagnostic()
        .wrap_err_with(context)?;
    println!(
        "{}: {frames} frames of {} entities in {}",
        what.scene.name,
        what.scene.track.len(),
        args.output.display()
    );
    if let Some(pictures) = &args.foxglove {
        draw(&args.output, pictures).into_diagnostic()?;
    }
    Ok(())
}

/// Draws a trace that was just written.
fn draw(trace: &Path, pictures: &Path) -> Result<(), GoldenError> {
    let out = File::create(pictures).map_err(|source| GoldenError::Io {
        path: pictures.into(),
        source,
    })?;
    let mut reader = TraceReader::open(trace)?;
    let library = concat!("ac-replay ", env!("CARGO_PKG_VERSION"));
    let counts = of_trace(&mut reader, BufWriter::new(out), library, pictures)?;
    println!(
        "{}: {} objects at {} places, {} lines of log",
        pictures.display(),
        counts.objects,
        counts.places,
        counts.lines
    );
    Ok(())
}

/// What a run under a plan has cost, in one line.
fn work(simulation: &SceneRun, set: &DatSet) -> String {
    let (portal, cell) = set.counts();
    let late = simulation.extended();
    format!(
        "{} records and {} bytes of the dat files; {} entities created late, {} ticks left out",
        portal.records + cell.records,
        portal.file_bytes + cell.file_bytes,
        late.entities,
        late.frames_put_off
    )
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
fn about(args: &RunArgs, worlds: &Path) -> miette::Result<(Input, TraceInfo)> {
    let (input, profile) = read(&args.input).into_diagnostic()?;
    let world = world_of(&input.scene, worlds)?;
    let info = TraceInfo {
        version: FormatVersion::CURRENT,
        scene: input.scene.name.clone(),
        producer: concat!("ac-replay ", env!("CARGO_PKG_VERSION")).into(),
        profile,
        world,
    };
    Ok((input, info))
}

/// The scene in a file, and its text.
pub(crate) fn load(path: &Path) -> Result<(Scene, Vec<u8>), GoldenError> {
    let (input, _) = read(path)?;
    Ok((input.scene, input.text))
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
