//! What the recorded stack was made from.

use std::path::Path as FilePath;

use super::broken;
use crate::config::{Document, Problems, Reader, Source};
use crate::path::Path;
use crate::replay::attachments;
use crate::schema::Profile;
use crate::stack::{RobotFile, StackConfig};

/// A stack's configuration, and the paths that an operator could ask for.
pub struct Origin {
    /// The configuration.
    pub config: StackConfig,
    /// By the number of the event that has it.
    pub paths: Vec<(u16, Path)>,
}

/// Names that the configuration has in a log.
const CONFIGS: [&str; 2] = ["scenario.toml", "robot.toml"];

impl Origin {
    /// That of a log, or the given one in its place, with overrides laid over it.
    pub fn find(log: &[u8], name: &FilePath, other: Option<&FilePath>, overrides: &[String]) -> Result<Self, Problems> {
        let attached = attached_texts(log).map_err(|what| broken(name, &what))?;
        let named = |wanted: &dyn Fn(&str) -> bool| attached.iter().find(|(name, _)| wanted(name));
        let is_config = |name: &str| CONFIGS.contains(&name);
        let config = named(&is_config);
        let profile = named(&|name| name.ends_with(".toml") && !is_config(name));
        let dbc = named(&|name| name.ends_with(".dbc"));
        let (Some((config_name, config)), Some((profile_name, profile)), Some((dbc_name, dbc))) =
            (config, profile, dbc)
        else {
            let found = attached.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
            let found = if found.is_empty() { "nothing" } else { &found };
            let what = format!(
                "found {found} attached to it, expected the configuration of a stack with its drive profile and DBC, \
                 as canloop drive and hil-sim run attach them"
            );
            return Err(broken(name, &what).into());
        };
        if let Some(other) = other {
            let path = other.display().to_string();
            let mut document = Document::open(&path, &[])?;
            overrides.iter().try_for_each(|assignment| document.set(assignment))?;
            return Ok(Self { config: RobotFile::load(&path, overrides)?.stack, paths: paths(&document)? });
        }
        let mut document = Document::parse(config_name.clone(), config.clone())?;
        overrides.iter().try_for_each(|assignment| document.set(assignment))?;
        let toml = Document::parse(profile_name.clone(), profile.clone())?;
        let profile = Profile::parse(&toml, &Source::new(dbc_name.clone(), dbc.clone()))?;
        let paths = paths(&document)?;
        Ok(Self { config: RobotFile::with_profile(&document, profile)?.stack, paths })
    }
}

/// Texts attached to a log, by name.
fn attached_texts(log: &[u8]) -> Result<Vec<(String, String)>, String> {
    let text = |(name, data): (String, Vec<u8>)| match String::from_utf8(data) {
        Ok(text) => Ok((name, text)),
        Err(_) => Err(format!("the attached {name} is no text")),
    };
    attachments(log)?.into_iter().map(text).collect()
}

/// Paths that events of a scenario have.
fn paths(scenario: &Document) -> Result<Vec<(u16, Path)>, Problems> {
    let reader = Reader::new(scenario);
    let root = reader.root();
    let read = |(nth, event): (usize, &crate::config::Section<'_>)| {
        event.has("path").then(|| (nth as u16, Path::read(&event.section("path"))))
    };
    let paths = root.sections("event").iter().enumerate().filter_map(read).collect();
    reader.finish_in_part(paths)
}
