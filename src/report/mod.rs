//! Pictures for people: static line charts in SVG. They need neither a script,
//! a font nor a network, and the same input gives the same bytes.
//!
//! ```
//! use canloop::report::{Chart, Series};
//!
//! let points: Vec<(f64, f64)> = (0..=150).map(|second| (f64::from(second), 9.0)).collect();
//! let chart = Chart::new("Position x").x_axis("time", "s").y_axis("x", "m").series(Series::response(points));
//! assert!(chart.to_svg().starts_with("<svg"));
//! ```

mod chart;
mod decimate;
mod legend;
mod markup;
mod scale;
mod svg;

pub use chart::{Chart, Role, Series, Stroke};
