//! Pictures for people: static line charts in SVG, and one HTML page that
//! carries charts, tables and prose in a single file. Neither needs a script,
//! a font or a network, and the same input gives the same bytes.
//!
//! ```
//! use canloop::report::{Chart, Figure, Page, Section, Series};
//!
//! let points: Vec<(f64, f64)> = (0..=150).map(|second| (f64::from(second), 9.0)).collect();
//! let chart = Chart::new("Position x").x_axis("time", "s").y_axis("x", "m").series(Series::response(points));
//! let svg = chart.to_svg();
//! let page = Page::new("A circle, driven").section(
//!     Section::new("The run").figure(Figure::new("Figure 1", "The robot stands still.", vec![chart])),
//! );
//! assert!(svg.starts_with("<svg") && page.to_html().starts_with("<!DOCTYPE html>"));
//! ```

mod chart;
mod curve;
mod decimate;
mod heat_map;
mod legend;
mod load_curve;
mod markup;
mod page;
mod scale;
mod states;
mod svg;
mod table;

pub use chart::{Chart, Role, Series, Stroke};
pub use curve::Curve;
pub use heat_map::{HeatMap, MapCell, Panel};
pub use load_curve::LoadCurve;
pub use markup::Markup;
pub use page::{Figure, Page, Section};
pub use states::{levels, stack_states, steps};
pub use table::{Badge, Cell, Column, Table};
