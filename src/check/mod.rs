//! Looking through files before anything runs on them: DBC files, drive
//! profiles, robot files and scenarios. Everything that is wrong is found in
//! one go, and nothing is opened but files.

mod bus_load;
mod report;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::bus::USUAL_BIT_RATE_BIT_S;
use crate::config::{Document, Problem, Problems, Reader, Source, read_text};
use crate::schema::{Dbc, Profile};
use crate::stack::StackConfig;

pub use report::Report;

/// Reads a robot file or a scenario by its path, as the program does that runs
/// it.
pub type RobotReader = fn(&str) -> Result<StackConfig, Problems>;

/// How to look.
#[derive(Clone, Copy)]
pub struct Checker<'c> {
    /// The bus that messages are to fit on, bit/s, where files do not say.
    pub bitrate_bit_s: Option<u32>,
    /// Configurations that others may be based on: name and text.
    pub shipped: &'c [(&'c str, &'c str)],
    /// How robot files and scenarios are read.
    pub robot: RobotReader,
}

/// Keys that only a drive profile has.
const PROFILE_KEYS: [&str; 3] = ["dbc", "wheels", "feedback"];
/// Keys of which a robot file or a scenario has at least one.
const ROBOT_KEYS: [&str; 8] = ["base", "robot", "controller", "drive", "path", "period_s", "safety", "expect"];
/// Keys that only a scenario has.
const SCENARIO_KEYS: [&str; 3] = ["duration_s", "expect", "seed"];

impl Checker<'_> {
    /// Looks through all of `paths`, in order.
    pub fn check_all(&self, paths: &[PathBuf]) -> Report {
        let mut report = Report::default();
        for path in paths {
            match self.check(path) {
                Ok(findings) => report.add(findings),
                Err(problem) => report.add_unreadable(problem),
            }
        }
        report
    }

    /// Everything that is wrong with a file and with those that it names, by
    /// file and place; an error when it cannot be read at all.
    pub fn check(&self, path: &Path) -> Result<Vec<Problem>, Problem> {
        let source = Dbc::read_source(path)?;
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        if extension == "dbc" || extension != "toml" && looks_like_dbc(&source.text) {
            return Ok(sorted(self.dbc(&source)));
        }
        let source = Source::new(source.name.clone(), read_text(path)?);
        let syntax = Document::syntax_problems(&source);
        if !syntax.is_empty() {
            return if extension == "toml" { Ok(sorted(syntax)) } else { Err(unknown(path)) };
        }
        let document = Document::parse(source.name.clone(), source.text.clone())?;
        let has_any = |keys: &[&str]| keys.iter().any(|key| document.has(key));
        match () {
            () if has_any(&PROFILE_KEYS) => Ok(sorted(Profile::check(&document, folder(path)))),
            () if has_any(&ROBOT_KEYS) => Ok(sorted(self.robot(path))),
            () => Err(unknown(path)),
        }
    }

    fn dbc(&self, source: &Arc<Source>) -> Vec<Problem> {
        let (dbc, mut findings) = Dbc::check(source);
        if let Some(bitrate_bit_s) = self.bitrate_bit_s.or(dbc.bitrate_bit_s) {
            findings.extend(bus_load::of_dbc(&dbc, bitrate_bit_s));
        }
        findings
    }

    fn robot(&self, path: &Path) -> Vec<Problem> {
        let name = path_not_name(path);
        let document = match Document::open(&name, self.shipped) {
            Ok(document) => document,
            Err(problem) => return vec![self.without_base(path, problem)],
        };
        let mut findings = match (self.robot)(&name) {
            Ok(stack) => self.bus_load(&document, &stack).into_iter().collect(),
            Err(problems) => problems.0,
        };
        if let Some(path) = profile_path(&document) {
            match Document::read(&path) {
                Ok(document) => findings.extend(Profile::check(&document, folder(&path))),
                // The robot's reader has said so, and where it is named.
                Err(problem) => drop(problem),
            }
        }
        findings
    }

    fn bus_load(&self, document: &Document, stack: &StackConfig) -> Option<Problem> {
        let of_scenario = SCENARIO_KEYS.iter().any(|key| document.has(key)).then_some(USUAL_BIT_RATE_BIT_S);
        let bus = BusKeys::of(document);
        let bitrate_bit_s = self.bitrate_bit_s.or(bus.bitrate_bit_s).or(of_scenario)?;
        if bus.is_ideal { None } else { bus_load::of_stack(document, stack, bitrate_bit_s) }
    }

    /// A scenario may be based on one that only hil-sim knows.
    fn without_base(&self, path: &Path, problem: Problem) -> Problem {
        let own = Document::read(path).ok();
        let base = own.as_ref().and_then(|document| document.text_of("base"));
        match (&own, base) {
            (Some(document), Some(base)) if self.shipped.is_empty() && !base.ends_with(".toml") => {
                let label = format!("found `{base}`, which is no file here: the rest was not looked at");
                let hint = format!("if it is a scenario that ships with hil-sim: hil-sim check {}", path.display());
                document.problem_at("base", "this program does not know the base", label).help(hint).warning()
            }
            _ => problem,
        }
    }
}

/// What of `[bus]` matters here; whether it is right is hil-sim's to say.
struct BusKeys {
    bitrate_bit_s: Option<u32>,
    is_ideal: bool,
}

impl BusKeys {
    fn of(document: &Document) -> Self {
        let reader = Reader::new(document);
        let bus = reader.root().section("bus");
        let bitrate_bit_s = bus.integer_or("bitrate_bit_s", 0, 0, i64::from(u32::MAX)) as u32;
        let is_ideal = bus.text_or_none("link").is_some_and(|link| link == "ideal");
        Self { bitrate_bit_s: (bitrate_bit_s > 0).then_some(bitrate_bit_s), is_ideal }
    }
}

/// The profile that a robot file names, unless it is one that ships.
fn profile_path(document: &Document) -> Option<PathBuf> {
    let reader = Reader::new(document);
    let drive = reader.root().section("drive");
    let name = drive.text_or_none("profile").filter(|name| name.ends_with(".toml"))?;
    Some(drive.path_of("profile", &name))
}

/// A path that is not taken for the name of a shipped configuration.
fn path_not_name(path: &Path) -> String {
    let is_bare = path.components().count() == 1 && path.extension().is_none_or(|extension| extension != "toml");
    if is_bare { format!("./{}", path.display()) } else { path.display().to_string() }
}

fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

fn looks_like_dbc(text: &str) -> bool {
    text.lines().any(|line| line.starts_with("BO_ ") || line.starts_with("BU_") || line.starts_with("NS_"))
}

fn unknown(path: &Path) -> Problem {
    Problem::bare(format!("{} is no file that can be checked", path.display()))
        .help("expected a DBC, or a drive profile, robot or scenario in TOML")
}

/// By file and place, and nothing twice: a file may be read for several
/// reasons.
fn sorted(mut findings: Vec<Problem>) -> Vec<Problem> {
    let mut met = BTreeSet::new();
    findings.retain(|problem| met.insert((problem.position(), problem.title.clone(), problem.label.clone())));
    let mut files: Vec<String> = Vec::new();
    let mut key = |problem: &Problem| {
        let Some((source, span)) = &problem.place else { return (usize::MAX, 0) };
        let file = files.iter().position(|name| *name == source.name).unwrap_or_else(|| {
            files.push(source.name.clone());
            files.len() - 1
        });
        (file, span.start)
    };
    findings.sort_by_cached_key(|problem| key(problem));
    findings
}
