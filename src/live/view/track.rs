//! Where the robot has been, thinned to what a picture can show.

use serde::Serialize;

use crate::robot::Pose;

/// Places of a track, at most.
const PLACES: usize = 1500;
/// From one place to the next at first, m.
const STEP_M: f64 = 0.005;

/// Places at least a step apart.
#[derive(Clone, Debug)]
pub(super) struct Track {
    places: Vec<(f32, f32)>,
    step_m: f64,
    last: Option<Pose>,
    /// Counts how often all places were made anew.
    generation: u32,
}

/// What of a track a viewer has seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct SeenPlaces {
    generation: Option<u32>,
    next: usize,
}

/// Places that are new to a viewer: x and y, m.
#[derive(Debug, Serialize)]
pub(super) struct NewPlaces<'t> {
    /// Another one than before: forget all places.
    generation: u32,
    places_m: &'t [(f32, f32)],
}

impl Track {
    /// Nowhere yet.
    pub const fn new() -> Self {
        Self { places: Vec::new(), step_m: STEP_M, last: None, generation: 0 }
    }

    /// The robot is here.
    pub fn take(&mut self, pose: &Pose) {
        let is_near = self.last.is_some_and(|last| last.distance_m(pose) < self.step_m);
        if is_near || !(pose.x_m.is_finite() && pose.y_m.is_finite()) {
            return;
        }
        self.last = Some(*pose);
        self.places.push((pose.x_m as f32, pose.y_m as f32));
        if self.places.len() >= PLACES {
            self.places = self.places.iter().copied().step_by(2).collect();
            self.step_m *= 2.0;
            self.generation += 1;
        }
    }

    /// What is new to a viewer who has seen so much.
    pub fn news(&self, seen: &mut SeenPlaces) -> NewPlaces<'_> {
        if seen.generation != Some(self.generation) {
            *seen = SeenPlaces { generation: Some(self.generation), next: 0 };
        }
        let places_m = &self.places[seen.next..];
        seen.next = self.places.len();
        NewPlaces { generation: self.generation, places_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x_m: f64) -> Pose {
        Pose { x_m, ..Pose::default() }
    }

    #[test]
    fn a_track_has_places_a_step_apart_and_no_more_than_a_picture_shows() {
        let mut track = Track::new();
        (0..1_000_000).for_each(|mm| track.take(&at(f64::from(mm) * 1e-3)));
        assert!((PLACES / 2..=PLACES).contains(&track.places.len()), "{}", track.places.len());
        assert_eq!(track.places[0], (0.0, 0.0));
        assert!(track.places.last().unwrap().0 > 998.0);
        assert!(track.places.is_sorted_by(|one, next| one.0 < next.0));
    }

    #[test]
    fn a_viewer_is_told_each_place_once_until_all_are_made_anew() {
        let mut track = Track::new();
        let mut seen = SeenPlaces::default();
        (0..10).for_each(|step| track.take(&at(f64::from(step))));
        assert_eq!(track.news(&mut seen).places_m.len(), 10);
        track.take(&at(9.001));
        assert_eq!(track.news(&mut seen).places_m.len(), 0);
        track.take(&at(10.0));
        assert_eq!(track.news(&mut seen).places_m, [(10.0, 0.0)]);
        (11..PLACES as i32).for_each(|step| track.take(&at(f64::from(step))));
        let news = track.news(&mut seen);
        assert_eq!((news.generation, news.places_m.len()), (1, PLACES / 2));
    }

    #[test]
    fn a_robot_that_is_nowhere_leaves_no_track() {
        let mut track = Track::new();
        track.take(&at(f64::NAN));
        track.take(&at(f64::INFINITY));
        assert!(track.news(&mut SeenPlaces::default()).places_m.is_empty());
    }
}
