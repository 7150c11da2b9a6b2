//! The command line of `ac-replay`.
//!
//! Exit codes: 0 = done; 1 = `dat check` found faults; 2 = it could not be done (the message says what, where, and what to do).

use std::{
    fs::File,
    io::BufWriter,
    path::{Path, PathBuf},
    process::ExitCode,
};

use ac_client::profile::Profile;
use ac_golden_traces::{
    GoldenError, Scene, corpus,
    import::hash_world,
    trace::{FormatVersion, TraceInfo, TraceReader},
};
use clap::{Parser, Subcommand};
use miette::{IntoDiagnostic, WrapErr, miette};

use crate::{
    Simulator,
    client::ClientSimulator,
    packets::{self, command::PacketArgs},
    replay::{Detail, replay},
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
    /// Behaviour to run under.
    #[arg(long, default_value = "retail")]
    profile: String,
    /// Also write what goes into and comes out of every stage of every entity's tick.
    #[arg(long)]
    checkpoints: bool,
    /// The trace to write.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    packets: PacketArgs,
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
    let profile = Profile::named(&args.profile).ok_or_else(|| {
        miette!(
            help = "profiles: retail, ace, gdle, gdle-repaired",
            "no profile is called `{}`",
            args.profile
        )
    })?;
    let bytes = std::fs::read(&args.input)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot read {}", args.input.display()))?;
    if packets::is_recording(&bytes) {
        return run_packets(args, &bytes, &profile);
    }
    let (scene, text) = load(&args.input).into_diagnostic()?;
    let info = info(args, &scene)?;
    let mut simulation = simulator(args).start(&scene, &profile).into_diagnostic()?;
    let detail = if args.checkpoints {
        Detail::Checkpoints
    } else {
        Detail::States
    };
    let context = || format!("cannot write {}", args.output.display());
    let out = BufWriter::new(
        File::create(&args.output)
            .into_diagnostic()
            .wrap_err_with(context)?,
    );
    let frames = replay(simulation.as_mut(), &scene, &text, &info, detail, out)
        .into_diagnostic()
        .wrap_err_with(context)?;
    println!(
        "{}: {frames} frames of {} entities in {}",
        scene.name,
        scene.track.len(),
        args.output.display()
    );
    Ok(())
}

fn run_packets(args: &RunArgs, bytes: &[u8], profile: &Profile) -> miette::Result<()> {
    let (session, scene) = args.packets.open(bytes, &args.input)?;
    let info = info(args, &scene)?;
    let output = &args.output;
    let simulator = simulator(args);
    let text = packets::command::run(session, &scene, &simulator, profile, &info, output)?;
    print!("{text}");
    Ok(())
}

fn worlds(args: &RunArgs) -> PathBuf {
    args.worlds
        .clone()
        .unwrap_or_else(|| corpus::bundled().join("worlds"))
}

fn simulator(args: &RunArgs) -> ClientSimulator {
    ClientSimulator::new(worlds(args))
}

fn info(args: &RunArgs, scene: &Scene) -> miette::Result<TraceInfo> {
    let worlds = worlds(args);
    let world = hash_world(&worlds.join(&scene.world))
        .into_diagnostic()
        .wrap_err_with(|| {
            format!(
                "the world `{}` is not under {}; name its folder with --worlds",
                scene.world,
                worlds.display()
            )
        })?;
    Ok(TraceInfo {
        version: FormatVersion::CURRENT,
        scene: scene.name.clone(),
        producer: concat!("ac-replay ", env!("CARGO_PKG_VERSION")).into(),
        profile: args.profile.clone(),
        world,
    })
}

/// The scene in a file, and its text.
fn load(path: &Path) -> Result<(Scene, Vec<u8>), GoldenError> {
    if path
        .extension()
        .is_some_and(|extension| extension == "mcap")
    {
        let reader = TraceReader::open(path)?;
        return Ok((reader.scene().clone(), reader.scene_text().to_vec()));
    }
    let text = std::fs::read(path).map_err(|source| GoldenError::Io {
        path: path.into(),
        source,
    })?;
    Ok((Scene::parse(&text, path)?, text))
}
