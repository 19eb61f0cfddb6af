//! Finding a configuration: by the name of one that ships with the program, or
//! by its path, and with the one that it is based on.

use std::path::{MAIN_SEPARATOR, Path};

use super::document::Document;
use super::problem::Problem;
use super::reader::nearest;

impl Document {
    /// Opens a configuration and lays it over the one that it names as its
    /// `base`, and that over its own. A name that is no path is that of one of
    /// `shipped`, pairs of name and text; paths of bases count from the file
    /// that names them. A base that is not shipped may also be named without
    /// its `.toml` when it stands beside that file.
    pub fn open(name_or_path: &str, shipped: &[(&str, &str)]) -> Result<Self, Problem> {
        const DEEPEST: usize = 8;
        let mut document = open(name_or_path, shipped)?;
        let mut folder = Path::new(name_or_path).parent().map(Path::to_owned).unwrap_or_default();
        let mut next = document.text_of("base").map(str::to_owned);
        for _ in 0..DEEPEST {
            let Some(name) = next else { return Ok(document) };
            let beside = folder.join(format!("{name}.toml"));
            let is_shipped = shipped.iter().any(|(known, _)| *known == name);
            let path = match name.ends_with(".toml") {
                true => folder.join(&name).display().to_string(),
                false if !is_shipped && beside.is_file() => beside.display().to_string(),
                false => name,
            };
            let base = open(&path, shipped).map_err(|problem| {
                document.problem_at("base", problem.title, "named here").help(problem.help.unwrap_or_default())
            })?;
            next = base.text_of("base").map(str::to_owned);
            folder = Path::new(&path).parent().map(Path::to_owned).unwrap_or_default();
            document.lay_over(base);
        }
        let title = format!("configurations are based on one another more than {DEEPEST} deep");
        Err(document.problem_at("base", title, "found a circle, or a very long chain"))
    }
}

fn open(name_or_path: &str, shipped: &[(&str, &str)]) -> Result<Document, Problem> {
    if name_or_path.ends_with(".toml") || name_or_path.contains(MAIN_SEPARATOR) {
        return Document::read(Path::new(name_or_path));
    }
    if let Some((name, text)) = shipped.iter().find(|(name, _)| *name == name_or_path) {
        return Document::parse(format!("{name}.toml (shipped)"), *text);
    }
    if shipped.is_empty() {
        let here = format!("{name_or_path}.toml");
        return Err(Problem::bare(format!("there is no configuration `{name_or_path}` here")).help(format!(
            "scenarios that ship are known to hil-sim alone, which writes one as a file: \
             hil-sim scenario {name_or_path} > {here}; a file is given by its path, ending in .toml"
        )));
    }
    let names = || shipped.iter().map(|(name, _)| *name);
    let problem = Problem::bare(format!("there is no shipped configuration `{name_or_path}`"));
    Err(match nearest(name_or_path, names()) {
        Some(name) => problem.help(format!("did you mean `{name}`? A file is given by its path, ending in .toml")),
        None => problem.help(format!(
            "shipped are {}; a file is given by its path, ending in .toml",
            names().collect::<Vec<_>>().join(", ")
        )),
    })
}
