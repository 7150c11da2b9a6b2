//! What a bisection found, for people and for programs.

use std::fmt::Write;

use serde_json::{Value, json};

use super::{
    locate::Location,
    search::Found,
    verdict::{Place, Verdict},
};

/// Schema of the JSON line.
pub const SCHEMA: &str = "ac-conform-bisect/1";

/// The first bad commit, for people.
pub fn found(found: &Found) -> String {
    let mut text = format!(
        "first commit with another verdict: {} {}\n",
        found.first_bad.id, found.first_bad.subject
    );
    for commit in &found.or {
        let _ = writeln!(
            text,
            "or, since it cannot be told: {} {}",
            commit.id, commit.subject
        );
    }
    let _ = writeln!(text, "  before: {}", found.good.line());
    let _ = writeln!(text, "  since:  {}", found.bad.line());
    let _ = writeln!(
        text,
        "  {} commits in question, {} built and run, {} cannot be built",
        found.commits, found.asked, found.unbuildable
    );
    text
}

/// Where the two builds part, for people.
pub fn located(location: &Location) -> String {
    let mut text = String::new();
    match location.states.first() {
        None => text += "no tracked state differs between the two builds\n",
        Some(first) => {
            let _ = writeln!(
                text,
                "states differ first in frame {}:",
                first.divergence.frame
            );
        }
    }
    for Place { guid, divergence } in &location.states {
        let _ = writeln!(
            text,
            "  {guid} {}: good {}, bad {}",
            divergence.field, divergence.expected, divergence.actual
        );
    }
    let Some(stage) = &location.stage else {
        return text + "no stage record differs (or one of the builds writes none)\n";
    };
    let _ = writeln!(
        text,
        "stages differ first in frame {}, entity {}, quantum {}: {} ({})",
        stage.frame,
        stage.guid,
        stage.quantum,
        stage.stage,
        stage.how.meaning()
    );
    for (path, good, bad) in &stage.fields {
        let _ = writeln!(text, "  {path}: good {good}, bad {bad}");
    }
    text
}

/// Everything on one line of JSON.
pub fn json(trace: &str, found: Option<&Found>, location: &Location) -> Value {
    let verdict = |verdict: &Verdict| json!({"line": verdict.line(), "verdict": verdict});
    json!({
        "schema": SCHEMA,
        "trace": trace,
        "first_bad": found.map(|found| json!({
            "commit": found.first_bad.id,
            "subject": found.first_bad.subject,
            "or": found.or.iter().map(|commit| &commit.id).collect::<Vec<_>>(),
            "commits": found.commits,
            "asked": found.asked,
            "unbuildable": found.unbuildable,
            "before": verdict(&found.good),
            "since": verdict(&found.bad),
        })),
        "states": location.states,
        "stage": location.stage,
    })
}
