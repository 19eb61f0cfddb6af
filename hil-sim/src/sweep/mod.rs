//! Thousands of runs that answer one question: for which period, load, friction,
//! gain is this loop stable and accurate?
//!
//! ```text
//! Plan -> cases, by number -> Shard -> runs on all processors -> rows, in order -> results.csv -> results.parquet
//! ```
//!
//! A case follows from the plan and its number alone, so that any part of a
//! sweep can be run anywhere, and what has been run is not run again.

mod axis;
mod case;
mod cells;
mod column;
mod draft;
mod map;
mod merge;
mod normal;
mod page;
mod parquet;
mod plan;
mod results;
mod row;
mod rows;
mod shard;

pub use self::parquet::to_parquet;
pub use axis::{Axis, Spread};
pub use case::Case;
pub use column::{Column, Kind, columns};
pub use map::{Axes, map};
pub use merge::{Merged, Parts};
pub use page::page;
pub use plan::{Method, Plan};
pub use results::{FILE, PARQUET, PLAN, Results, ResultsError};
pub use row::{COLUMNS, run};
pub use shard::Shard;

/// The plans that ship with the program, by name.
pub const SHIPPED: &[(&str, &str)] = &[
    ("period-and-delay", include_str!("../../sweeps/period-and-delay.toml")),
    ("load-and-belief", include_str!("../../sweeps/load-and-belief.toml")),
    ("friction-and-encoder", include_str!("../../sweeps/friction-and-encoder.toml")),
];
