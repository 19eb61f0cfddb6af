//! Reading configuration: TOML in, checked numbers out, and every complaint
//! with its place.
//!
//! A [`Document`] is a parsed file with overrides laid over it. A [`Reader`]
//! hands out [`Section`]s, which ask for keys one at a time with the bound that
//! each must keep; it collects all problems, keys nobody asked for among them,
//! and gives them in one piece at the end.

mod document;
mod items;
mod numbers;
mod open;
mod problem;
mod reader;

pub use document::Document;
pub(crate) use document::read_text;
pub use items::Item;
pub use numbers::Bound;
pub use problem::{Problem, Problems, Severity, Source};
pub use reader::{Reader, Section, nearest};
