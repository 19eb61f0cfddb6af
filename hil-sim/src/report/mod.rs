//! What a run leaves for people and for CI: a page that opens offline, a JUnit
//! file, annotations.

pub mod annotation;
mod expectations;
mod history;
pub mod junit;
mod page;

pub use history::History;
pub use page::page;
