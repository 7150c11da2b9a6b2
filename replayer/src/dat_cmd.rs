//! `ac-replay dat`: looks into dat files and checks them.
//!
//! Exit codes: 0 all is well, 1 something is wrong with the data, 2 the question could not be answered (no such file or record, not a dat
//! file).

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use ac_client::dat::{
    AnyRecord, CELL_FILE, DatError, DatFile, DatSet, PORTAL_FILE, RecordKind, Strictness, lint,
};
use clap::{Args, Subcommand};
use miette::Diagnostic;

/// Looks into dat files and checks them.
#[derive(Debug, Args)]
pub struct DatArgs {
    /// What to do.
    #[command(subcommand)]
    pub command: DatCommand,
}

/// What to do with dat files.
#[derive(Debug, Subcommand)]
pub enum DatCommand {
    /// Lists the records of a file.
    Ls {
        /// A dat file.
        file: PathBuf,
        /// Only records of this type, e.g. gfx-obj, setup, env-cell.
        #[arg(long = "type", value_name = "TYPE", value_parser = parse_kind)]
        kind: Option<RecordKind>,
    },
    /// Prints a record as JSON.
    Cat {
        /// A dat file.
        file: PathBuf,
        /// Id of the record, hexadecimal, with or without 0x.
        #[arg(value_parser = parse_id)]
        id: u32,
        /// Prints the stored bytes in hexadecimal instead; works for every type.
        #[arg(long)]
        raw: bool,
    },
    /// Checks the container and every record of a file, or of both files of a world's folder.
    Check {
        /// A dat file, or a folder with client_portal.dat and client_cell_1.dat.
        path: PathBuf,
        /// Lets pass what a client would survive.
        #[arg(long)]
        lenient: bool,
    },
}

fn parse_kind(name: &str) -> Result<RecordKind, String> {
    RecordKind::from_name(name).ok_or_else(|| {
        let names: Vec<&str> = RecordKind::ALL.iter().map(|k| k.name()).collect();
        format!("no such type; there are: {}", names.join(", "))
    })
}

fn parse_id(text: &str) -> Result<u32, String> {
    let digits = text.trim_start_matches("0x").trim_start_matches("0X");
    u32::from_str_radix(digits, 16)
        .map_err(|e| format!("{e}; an id has up to eight hexadecimal digits"))
}

/// What the exit code says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Exit code 0.
    Good,
    /// Exit code 1: something is wrong with the data.
    Bad,
}

impl Verdict {
    /// The exit code.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::Good => 0,
            Self::Bad => 1,
        }
    }
}

/// Why a question could not be answered; exit code 2.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum DatCmdError {
    /// A file or record cannot be read.
    #[error(transparent)]
    #[diagnostic(code(dat::unreadable), help("{}", .0.help()))]
    Dat(#[from] DatError),
    /// The record is not in the file.
    #[error("{file}: there is no record 0x{id:08X}")]
    #[diagnostic(
        code(dat::no_record),
        help("`ac-replay dat ls {file}` lists the records")
    )]
    NoRecord {
        /// The file.
        file: String,
        /// The id asked for.
        id: u32,
    },
    /// The record's layout is not known.
    #[error("{file}: record 0x{id:08X} ({what}) is of a type that is not read")]
    #[diagnostic(code(dat::unknown_type), help("`--raw` prints its bytes"))]
    UnknownType {
        /// The file.
        file: String,
        /// The id asked for.
        id: u32,
        /// Name of the id's range.
        what: &'static str,
    },
    /// The answer could not be written.
    #[error("cannot write the answer: {0}")]
    #[diagnostic(code(dat::output))]
    Output(#[from] io::Error),
    /// The record could not be turned into JSON.
    #[error("cannot print the record: {0}")]
    #[diagnostic(code(dat::json))]
    Json(#[from] serde_json::Error),
}

/// Runs a `dat` command and writes its answer to `out`.
///
/// # Errors
/// If the question cannot be answered; the caller ends with exit code 2.
pub fn run(args: &DatArgs, out: &mut dyn Write) -> Result<Verdict, DatCmdError> {
    match &args.command {
        DatCommand::Ls { file, kind } => list(file, *kind, out),
        DatCommand::Cat { file, id, raw } => cat(file, *id, *raw, out),
        DatCommand::Check { path, lenient } => {
            let strictness = if *lenient {
                Strictness::Lenient
            } else {
                Strictness::Strict
            };
            check(path, strictness, out)
        }
    }
}

fn kind_name(file: &DatFile, id: u32) -> &'static str {
    match RecordKind::of(file.data_set(), id) {
        RecordKind::Other => RecordKind::range_name(id),
        kind => kind.name(),
    }
}

fn list(
    path: &Path,
    kind: Option<RecordKind>,
    out: &mut dyn Write,
) -> Result<Verdict, DatCmdError> {
    let file = DatFile::open(path, None, Strictness::Lenient)?;
    let (mut records, mut bytes) = (0, 0);
    for entry in file.entries()? {
        if kind.is_some_and(|k| k != RecordKind::of(file.data_set(), entry.id)) {
            continue;
        }
        let packed = if entry.is_compressed() {
            " compressed"
        } else {
            ""
        };
        writeln!(
            out,
            "0x{:08X}  {:<20} {:>9}{packed}",
            entry.id,
            kind_name(&file, entry.id),
            entry.size
        )?;
        records += 1;
        bytes += u64::from(entry.size);
    }
    writeln!(out, "{records} records, {bytes} bytes")?;
    Ok(Verdict::Good)
}

fn cat(path: &Path, id: u32, raw: bool, out: &mut dyn Write) -> Result<Verdict, DatCmdError> {
    let file = DatFile::open(path, None, Strictness::Lenient)?;
    let name = file.name().to_owned();
    let Some(bytes) = file.get(id)? else {
        return Err(DatCmdError::NoRecord { file: name, id });
    };
    if raw {
        for (i, line) in bytes.chunks(16).enumerate() {
            let hex: Vec<String> = line.iter().map(|b| format!("{b:02X}")).collect();
            writeln!(out, "{:06X}  {}", 16 * i, hex.join(" "))?;
        }
        return Ok(Verdict::Good);
    }
    let Some(record) = AnyRecord::of(file.data_set(), &name, id, &bytes, Strictness::Lenient)
    else {
        return Err(DatCmdError::UnknownType {
            file: name,
            id,
            what: kind_name(&file, id),
        });
    };
    let json = serde_json::to_string_pretty(&record?.0)?;
    out.write_all(short_lists_on_one_line(&json).as_bytes())?;
    Ok(Verdict::Good)
}

/// Pretty JSON whose lists of plain values stand on one line each, as far as they fit: points are easier to read so.
fn short_lists_on_one_line(json: &str) -> String {
    const WIDTH: usize = 120;
    let lines: Vec<&str> = json.lines().collect();
    let (mut out, mut i) = (String::with_capacity(json.len()), 0);
    while i < lines.len() {
        let mut line = lines[i].to_owned();
        if line.ends_with('[') {
            let plain = |l: &&&str| {
                !matches!(l.trim_start().as_bytes().first(), Some(b'[' | b']' | b'{'))
                    && !l.ends_with(['[', '{'])
            };
            let inner = lines[i + 1..].iter().take_while(plain).count();
            let closed = lines
                .get(i + 1 + inner)
                .filter(|l| l.trim_start().starts_with(']'));
            let parts: Vec<&str> = lines[i + 1..i + 1 + inner]
                .iter()
                .map(|l| l.trim())
                .collect();
            let joined = parts.join(" ");
            if let Some(end) = closed.filter(|_| line.len() + joined.len() < WIDTH) {
                line.push_str(&joined);
                line.push_str(end.trim());
                i += 1 + inner;
            }
        }
        out.push_str(&line);
        out.push('\n');
        i += 1;
    }
    out
}

fn check(path: &Path, strictness: Strictness, out: &mut dyn Write) -> Result<Verdict, DatCmdError> {
    if !path.is_dir() {
        let file = DatFile::open(path, None, strictness)?;
        return check_file(&file, strictness, out);
    }
    let mut verdict = Verdict::Good;
    for name in [PORTAL_FILE, CELL_FILE] {
        let file = DatFile::open(path.join(name), None, strictness)?;
        if check_file(&file, strictness, out)? == Verdict::Bad {
            verdict = Verdict::Bad;
        }
    }
    if verdict == Verdict::Good {
        let lints = lint::world(&DatSet::open(path, strictness)?)?;
        for l in &lints {
            writeln!(out, "lint: {l}")?;
        }
        writeln!(out, "{}: {} lints", path.display(), lints.len())?;
    }
    Ok(verdict)
}

/// Numbers of one type of record.
#[derive(Default)]
struct Tally {
    records: usize,
    bytes: u64,
    errors: usize,
}

fn check_file(
    file: &DatFile,
    strictness: Strictness,
    out: &mut dyn Write,
) -> Result<Verdict, DatCmdError> {
    let (header, report) = (file.header(), file.check());
    let set = ac_client::dat::data_set_name(header.data_set);
    writeln!(
        out,
        "{}: {set} file, {} bytes in blocks of {}",
        file.name(),
        header.file_size,
        header.block_size
    )?;
    let b = report.blocks;
    writeln!(
        out,
        "  {} records, {} directory levels; {} blocks: {} records, {} directory, {} free, {} lost",
        report.entries.len(),
        b.levels,
        b.total,
        b.records,
        b.nodes,
        b.free,
        b.lost
    )?;
    let mut errors = report.errors.len();
    for e in &report.errors {
        writeln!(out, "  error: {e}")?;
    }
    let (mut tallies, mut notes): (BTreeMap<&str, Tally>, usize) =
        (BTreeMap::new(), file.notes().len());
    for entry in &report.entries {
        let tally = tallies.entry(kind_name(file, entry.id)).or_default();
        tally.records += 1;
        tally.bytes += u64::from(entry.size);
        // A chain that cannot be read has been reported with the container.
        let Ok(bytes) = file.read(entry) else {
            continue;
        };
        match AnyRecord::of(file.data_set(), file.name(), entry.id, &bytes, strictness) {
            Some(Err(e)) => {
                tally.errors += 1;
                errors += 1;
                writeln!(out, "  error: {e}")?;
            }
            Some(Ok((_, passed_over))) => {
                notes += passed_over.len();
                for n in passed_over {
                    writeln!(
                        out,
                        "  note: record 0x{:08X}, offset 0x{:X}: {}",
                        entry.id, n.offset, n.problem
                    )?;
                }
            }
            None => {}
        }
    }
    for (kind, t) in &tallies {
        writeln!(
            out,
            "  {kind:<20} {:>6} records {:>10} bytes {:>4} errors",
            t.records, t.bytes, t.errors
        )?;
    }
    writeln!(out, "  {errors} errors, {notes} notes")?;
    Ok(if errors == 0 {
        Verdict::Good
    } else {
        Verdict::Bad
    })
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        dat: DatArgs,
    }

    fn worlds() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../golden-traces/worlds")
    }

    /// Answer and exit code of `dat ARGS`; `W/` stands for the folder of the worlds.
    fn dat(args: &str) -> String {
        let folder = format!("{}/", worlds().display());
        let args = args.split(' ').map(|a| a.replace("W/", &folder));
        let cli = match Cli::try_parse_from(["dat".to_owned()].into_iter().chain(args)) {
            Ok(cli) => cli,
            Err(e) => return format!("{e}exit code 2"),
        };
        let mut out = Vec::new();
        let (text, code) = match run(&cli.dat, &mut out) {
            Ok(verdict) => (String::new(), verdict.code()),
            Err(e) => {
                let help = e.help().map(|h| format!("help: {h}\n")).unwrap_or_default();
                (format!("error: {e}\n{help}"), 2)
            }
        };
        let text = format!("{}{text}exit code {code}", String::from_utf8_lossy(&out));
        text.replace(&folder, "W/")
            .replace(&worlds().display().to_string(), "W")
    }

    #[test]
    fn ls() {
        insta::assert_snapshot!(dat("ls W/testbed/client_portal.dat --type setup"));
        insta::assert_snapshot!("ls_cell", dat("ls W/testbed2/client_cell_1.dat"));
    }

    #[test]
    fn cat() {
        insta::assert_snapshot!(
            "cat_room",
            dat("cat W/testbed/client_cell_1.dat 0xA9B40105")
        );
        insta::assert_snapshot!("cat_shape", dat("cat W/testbed/client_portal.dat 01000007"));
        insta::assert_snapshot!(
            "cat_raw",
            dat("cat W/testbed/client_portal.dat 01000007 --raw")
        );
    }

    #[test]
    fn check_good() {
        insta::assert_snapshot!(dat("check W/testbed"));
    }

    #[test]
    fn questions_without_answer() {
        let all = [
            "cat W/testbed/client_portal.dat 0x01FFFFFF",
            "cat W/testbed/client_portal.dat xyz",
            "ls W/testbed/world.json",
            "ls W/testbed/client_portal.dat --type shoe",
            "check W/none.dat",
        ];
        let answers: Vec<String> = all
            .iter()
            .map(|a| format!("$ dat {a}\n{}", dat(a)))
            .collect();
        insta::assert_snapshot!(answers.join("\n\n"));
    }

    #[test]
    fn check_bad() {
        // `W/` stands for the worlds: no drawn name may end so.
        let folder = tempfile::Builder::new()
            .suffix("-bad")
            .tempdir()
            .expect("a folder");
        let mut bytes = std::fs::read(worlds().join("testbed/client_cell_1.dat"))
            .expect("a file of this repository");
        let file =
            DatFile::from_bytes("x", bytes.clone(), None, Strictness::Strict).expect("opened");
        let at = |id| file.entry(id).expect("looked up").expect("there").offset as usize;
        // Another id in front; a not-a-number as origin; a chain that ends in the middle.
        bytes[at(0xA9B4_FFFF) + 4] ^= 1;
        let origin = at(0xA9B4_0105) + 4 + 0x18;
        bytes[origin..origin + 4].copy_from_slice(&f32::NAN.to_le_bytes());
        let long = file
            .entries()
            .expect("directory")
            .into_iter()
            .find(|e| e.size > 252)
            .expect("two blocks");
        let cut = long.offset as usize;
        bytes[cut..cut + 4].fill(0);
        let path = folder.path().join("client_cell_1.dat");
        std::fs::write(&path, bytes).expect("written");
        let shown = |args: &str| {
            dat(&args.replace("PATH", &path.display().to_string()))
                .replace(&path.display().to_string(), "PATH")
        };
        insta::assert_snapshot!("check_bad", shown("check PATH"));
        insta::assert_snapshot!("check_bad_lenient", shown("check PATH --lenient"));
    }
}
