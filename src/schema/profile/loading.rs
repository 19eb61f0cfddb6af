//! Where profiles come from: those that the program brings along, and files.

use std::path::Path;
use std::sync::Arc;

use super::Profile;
use super::reader;
use crate::config::{Document, Problem, Problems, Reader, Source};
use crate::schema::dbc::Dbc;

/// Name, TOML and DBC of the profiles that the program brings along.
macro_rules! builtin {
    ($($name:literal),*) => {
        [$(($name, include_str!(concat!("../../../dbc/", $name, ".toml")), include_str!(concat!("../../../dbc/", $name, ".dbc")))),*]
    };
}

const BUILTIN: &[(&str, &str, &str)] =
    &builtin!["wheel_drive", "cia402", "odrive-0.6", "odrive-0.5", "vesc", "damiao-dm4310", "comma-body"];

impl Profile {
    /// The profile of this name that the program brings along.
    pub fn builtin(name: &str) -> Option<Self> {
        let (name, toml, dbc) = BUILTIN.iter().find(|(known, ..)| *known == name)?;
        let profile = Document::parse(format!("{name}.toml"), *toml)
            .map_err(Problems::from)
            .and_then(|document| Self::parse(&document, &Source::new(format!("{name}.dbc"), *dbc)));
        Some(profile.unwrap_or_else(|problems| panic!("the profile that came with the program is broken:\n{problems}")))
    }

    /// Names of the profiles that the program brings along.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        BUILTIN.iter().map(|&(name, ..)| name)
    }

    /// A profile that the program brings along, by its name, or any other by
    /// the path of its TOML file; its DBC's path counts from there.
    pub fn load(name_or_path: &str) -> Result<Self, Problems> {
        if let Some(profile) = Self::builtin(name_or_path) {
            return Ok(profile);
        }
        let path = Path::new(name_or_path);
        if path.extension().is_none_or(|extension| extension != "toml") {
            let names = Self::builtin_names().collect::<Vec<_>>().join(", ");
            return Err(Problem::bare(format!("there is no drive profile {name_or_path:?}"))
                .help(format!("expected one of {names}, or the path of a .toml file"))
                .into());
        }
        let document = Document::read(path)?;
        let dbc = dbc_source(&document, path.parent().unwrap_or(Path::new("")))?;
        Self::parse(&document, &dbc)
    }

    /// A profile from its TOML and the text of its DBC.
    pub fn parse(toml: &Document, dbc: &Arc<Source>) -> Result<Self, Problems> {
        let dbc = Dbc::parse(dbc)?;
        let reader = Reader::new(toml);
        let profile = reader::profile(&reader.root(), toml, dbc);
        let profile = reader.finish(profile)?;
        Ok(profile.expect("what keeps a profile from being made is reported to the reader"))
    }

    /// All that is wrong with a profile, and with the DBC that it names, seen
    /// from `folder`. Roles are looked for in whatever of the DBC makes sense.
    pub fn check(toml: &Document, folder: &Path) -> Vec<Problem> {
        let source = match dbc_source(toml, folder) {
            Ok(source) => source,
            Err(problem) => return vec![problem],
        };
        let (dbc, mut findings) = Dbc::check(&source);
        let reader = Reader::new(toml);
        let profile = reader::profile(&reader.root(), toml, dbc);
        if let Err(problems) = reader.finish(profile) {
            findings.extend(problems.0);
        }
        findings
    }
}

/// The DBC that a profile names, read from beside it.
fn dbc_source(toml: &Document, folder: &Path) -> Result<Arc<Source>, Problem> {
    let reader = Reader::new(toml);
    let root = reader.root();
    let Some(name) = root.text_or_none("dbc") else {
        return Err(root.problem("dbc", "no DBC file is named", "expected dbc = \"FILE.dbc\", seen from here"));
    };
    Dbc::read_source(&folder.join(name)).map_err(|problem| root.problem("dbc", &problem.title, "named here"))
}
