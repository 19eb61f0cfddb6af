//! What a viewer is sent.

use serde::Serialize;

use super::Run;
use super::bus::Drives;
use super::happenings::NewHappenings;
use super::now::Now;
use super::strip::{NewRows, SeenRows};
use super::track::{NewPlaces, SeenPlaces};

/// Places of the path that are shown.
const PATH_PLACES: u32 = 600;

/// What a viewer has seen already; nothing at first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    run: Option<u64>,
    pub(super) recent: SeenRows,
    pub(super) whole: SeenRows,
    pub(super) track: SeenPlaces,
    pub(super) happenings: u64,
}

/// All that is new to a viewer.
#[derive(Debug, Serialize)]
pub(super) struct News<'v> {
    /// At the beginning of another run: forget all of the last one.
    pub run: Option<&'v RunFacts>,
    pub now: &'v Now,
    pub drives: Drives,
    pub frames: u64,
    pub load_percent: Option<f64>,
    pub recent: NewRows<'v>,
    pub whole: NewRows<'v>,
    pub track: NewPlaces<'v>,
    pub happened: Option<NewHappenings<'v>>,
    pub viewing: Viewing,
    /// How the run ended, if it has.
    pub ended: Option<&'v str>,
}

/// What is known of a run before its first event.
#[derive(Clone, Debug, Serialize)]
pub(super) struct RunFacts {
    pub number: u64,
    name: String,
    program: &'static str,
    version: &'static str,
    duration_s: Option<f64>,
    period_s: f64,
    torque_limit_nm: f64,
    bit_rate_bit_s: Option<u32>,
    half_track_m: f64,
    /// Where the path leads: x and y.
    path_m: Vec<(f32, f32)>,
}

/// What did not reach viewers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct Viewing {
    /// Events that no viewer was shown: they came faster than they were taken.
    pub events_lost: u64,
    /// Updates that viewers went without because they read too slowly.
    pub updates_missed: u64,
}

impl Seen {
    /// Run `number` is shown; says whether it is another one than before, of
    /// which nothing has been seen.
    pub(super) fn begin(&mut self, number: u64) -> bool {
        let is_new = self.run != Some(number);
        if is_new {
            *self = Self { run: Some(number), ..Self::default() };
        }
        is_new
    }
}

impl RunFacts {
    pub fn new(run: &Run<'_>, number: u64) -> Self {
        let path = &run.stack.controller.path;
        let place = |nth: u32| {
            let pose = path.at(path.duration_s() * f64::from(nth) / f64::from(PATH_PLACES)).pose;
            (pose.x_m as f32, pose.y_m as f32)
        };
        Self {
            number,
            name: run.name.to_owned(),
            program: run.program,
            version: env!("CARGO_PKG_VERSION"),
            duration_s: run.duration_s,
            period_s: run.stack.period.as_secs_f64(),
            torque_limit_nm: run.stack.safety.torque_limit_nm,
            bit_rate_bit_s: run.bit_rate_bit_s,
            half_track_m: run.stack.controller.belief.half_track_m,
            path_m: (0..=PATH_PLACES).map(place).collect(),
        }
    }
}
