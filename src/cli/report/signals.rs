//! Every signal that a DBC file knows, over time.

use std::collections::BTreeMap;

use crate::report::{Chart, Curve, Figure, Page, Role, Section, Series, Stroke};
use crate::schema::Dbc;
use crate::traffic::Record;

/// Gathered record by record.
pub struct Signals<'d> {
    dbcs: &'d [Dbc],
    /// By message and signal, in the order of the DBC.
    curves: BTreeMap<(String, usize), (String, String, Curve)>,
}

/// Signals that a page shows: more than anybody looks at.
const MOST: usize = 200;

impl<'d> Signals<'d> {
    /// Of messages in these files.
    pub fn of(dbcs: &'d [Dbc]) -> Self {
        Self { dbcs, curves: BTreeMap::new() }
    }

    /// Takes a record of that moment, s.
    pub fn take(&mut self, record: &Record, at_s: f64) {
        let Some(frame) = record.frame() else { return };
        let Some(message) = self.dbcs.iter().find_map(|dbc| dbc.message_by_id(frame.id)) else { return };
        for (nth, signal) in message.carried(frame) {
            let key = (message.name.clone(), nth);
            if self.curves.len() >= MOST && !self.curves.contains_key(&key) {
                continue;
            }
            let new = || (signal.name.clone(), signal.unit.clone(), Curve::default());
            let (.., curve) = self.curves.entry(key).or_insert_with(new);
            curve.take(at_s, signal.decode(frame.storage()));
        }
    }

    /// Adds a chart a signal.
    pub fn sections(self, page: Page) -> Page {
        let mut charts: BTreeMap<String, Vec<Chart>> = BTreeMap::new();
        for ((message, _), (signal, unit, curve)) in self.curves {
            let line = Series::new(&signal, Role::Response, Stroke::Solid, curve.points());
            let chart = Chart::new(&signal).x_axis("time", "s").y_axis(&signal, unit).series(line);
            charts.entry(message).or_default().push(chart);
        }
        charts.into_iter().fold(page, |page, (message, charts)| {
            let figure = Figure::new(&message, "Of each stretch of time the least and the greatest value.", charts);
            page.section(Section::new(&message).figure(figure))
        })
    }
}
