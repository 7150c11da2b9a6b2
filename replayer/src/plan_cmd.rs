//! `ac-replay plan`: what can be left out of a scene, and why.

use std::fmt::Write as _;
use std::path::PathBuf;

use ac_client::frame::Plan;
use ac_client::frame::plan::{Outputs, SceneOutline, WorldIndex};
use ac_client::profile::Profile;
use ac_golden_traces::corpus;
use clap::ValueEnum;
use miette::{IntoDiagnostic, WrapErr, miette};

use crate::cli::load;
use crate::client::{ClientSimulator, planning};

/// Ids that are shown of a list.
const SHOWN: usize = 6;

/// Arguments of `ac-replay plan`.
#[derive(clap::Args)]
pub struct Args {
    /// A scene (`*.scene.json`), or a trace (`*.mcap`) whose scene is planned.
    input: PathBuf,
    /// Folder of the worlds. Default: the bundled worlds.
    #[arg(long)]
    worlds: Option<PathBuf>,
    /// Behaviour the scene is going to run under.
    #[arg(long, default_value = "retail")]
    profile: String,
    /// Plan for a run that also writes checkpoints.
    #[arg(long)]
    checkpoints: bool,
    /// How to write the plan: text for people, or a file for `--plan FILE`.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Measure which landblocks and rooms belong together, and store it beside the dat files (`plan-index.PROFILE.json`): without that
    /// file every process that plans measures it anew.
    #[arg(long)]
    write_index: bool,
}

/// How a plan is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people.
    #[default]
    Human,
    /// For `--plan FILE.toml`.
    Toml,
    /// For `--plan FILE.json`.
    Json,
}

/// The text of the plan.
///
/// # Errors
/// When the scene, its world or the profile cannot be had, or the index cannot be written.
pub fn run(args: &Args) -> miette::Result<String> {
    let (scene, _) = load(&args.input).into_diagnostic()?;
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
    let folder = worlds.join(&scene.world);
    let simulator = ClientSimulator::new(worlds);
    let source = simulator.world(&scene.world).into_diagnostic()?;
    if args.write_index {
        let mut index = planning::measure_index(&source, &profile).into_diagnostic()?;
        index.profile.clone_from(&args.profile);
        index.world = planning::identity(&folder).unwrap_or_default();
        let path = folder.join(planning::index_file(&args.profile));
        let text = index.to_json().into_diagnostic()?;
        std::fs::write(&path, text)
            .into_diagnostic()
            .wrap_err_with(|| format!("cannot write {}", path.display()))?;
    }
    let index = simulator.index(&scene.world, &profile).into_diagnostic()?;
    let outputs = Outputs {
        checkpoints: args.checkpoints,
    };
    let outline = planning::outline(&scene, outputs);
    let plan = Plan::auto(&outline, source.as_ref(), &index, &profile, true);
    match args.format {
        Format::Human => Ok(human(&plan, &outline, &index, &args.profile)),
        Format::Toml => toml::to_string_pretty(&plan).into_diagnostic(),
        Format::Json => serde_json::to_string_pretty(&plan)
            .map(|text| text + "\n")
            .into_diagnostic(),
    }
}

/// The plan for people.
pub fn human(plan: &Plan, scene: &SceneOutline, index: &WorldIndex, profile: &str) -> String {
    let mut text = String::new();
    let tracked = scene.entities.iter().filter(|e| e.tracked).count();
    let _ = writeln!(
        text,
        "{} under {profile}: {} entities, {tracked} tracked, {:.2} s",
        scene.name,
        scene.entities.len(),
        scene.duration
    );
    let _ = writeln!(
        text,
        "world: {} groups of landblocks and rooms that are loaded together, {} with moving static objects\n\nleft out:",
        index.groups().len(),
        index.animated().len()
    );
    for omission in &plan.left_out {
        let _ = write!(text, "  {}", omission.part.name());
        if omission.part.has_ids() {
            let shown: Vec<_> = omission
                .ids
                .iter()
                .take(SHOWN)
                .map(|id| format!("{id:#010X}"))
                .collect();
            let more = if omission.ids.len() > SHOWN {
                ", …"
            } else {
                ""
            };
            let _ = write!(
                text,
                " ({}): {}{more}",
                omission.ids.len(),
                shown.join(", ")
            );
        }
        let _ = writeln!(
            text,
            "\n      {}\n      [{}]",
            omission.because, omission.source
        );
    }
    text.push_str("\nnothing is left out for good: what somebody needs after all is loaded, created or played before the difference shows\n");
    text
}
