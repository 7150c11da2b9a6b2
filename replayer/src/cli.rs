//! The command line of `ac-replay`.
//!
//! Exit codes: 0 = done; 1 = `dat check` found faults; 2 = it could not be done (the message says what, where, and what to do).

use std::{
    fs::File,
    io::BufWriter,
    path::{Path, PathBuf},
    process::ExitCode,
};

use ac_client::{dat::DatSet, frame::plan::Outputs, profile::Profile};
use ac_golden_traces::{
    GoldenError, Scene, corpus,
    import::hash_world,
    trace::{FormatVersion, TraceInfo, TraceReader},
};
use clap::{Parser, Subcommand};
use miette::{IntoDiagnostic, WrapErr, miette};

use crate::{
    client::{ClientSimulator, PlanChoice, SceneRun},
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
    /// Run a scene and write what every tracked entity did as a trace.
    Run(RunArgs),
    /// Say what can be left out of a scene, and why, or write it as a file for `run --plan`.
    Plan(crate::plan_cmd::Args),
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
    /// Behaviour to run under.
    #[arg(long, default_value = "retail")]
    profile: String,
    /// Also write what goes into and comes out of every stage of every entity's tick.
    #[arg(long)]
    checkpoints: bool,
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

fn run(args: &RunArgs) -> miette::Result<()> {
    let (scene, text) = load(&args.input).into_diagnostic()?;
    let profile = Profile::named(&args.profile).ok_or_else(|| {
        miette!(
            help = "profiles: retail, ace, gdle, gdle-repaired",
            "no profile is called `{}`",
            args.profile
        )
    })?;
    let worlds = args
        .worlds
        .clone()
        .unwrap_or_else(|| corpus::bundled().join("worlds"));
    let world = hash_world(&worlds.join(&scene.world))
        .into_diagnostic()
        .wrap_err_with(|| {
            format!(
                "the world `{}` is not under {}; name its folder with --worlds",
                scene.world,
                worlds.display()
            )
        })?;
    let info = TraceInfo {
        version: FormatVersion::CURRENT,
        scene: scene.name.clone(),
        producer: concat!("ac-replay ", env!("CARGO_PKG_VERSION")).into(),
        profile: args.profile.clone(),
        world,
    };
    let plan = PlanChoice::parse(args.plan.as_deref(), args.force_plan).into_diagnostic()?;
    let outputs = Outputs {
        checkpoints: args.checkpoints,
    };
    let simulator = ClientSimulator::new(worlds)
        .with_plan(plan)
        .with_outputs(outputs);
    let mut simulation = simulator.run(&scene, &profile).into_diagnostic()?;
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
    let frames = replay(&mut simulation, &scene, &text, &info, detail, out)
        .into_diagnostic()
        .wrap_err_with(context)?;
    println!(
        "{}: {frames} frames of {} entities in {}",
        scene.name,
        scene.track.len(),
        args.output.display()
    );
    if args.plan.is_some() {
        let set = simulator.world(&scene.world).into_diagnostic()?;
        println!("{}", work(&simulation, &set));
    }
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

/// The scene in a file, and its text.
pub(crate) fn load(path: &Path) -> Result<(Scene, Vec<u8>), GoldenError> {
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
