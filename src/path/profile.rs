//! Distance along a path as a function of time.

/// How a path is run through, from rest to rest.
#[derive(Clone, Debug, PartialEq)]
pub enum SpeedProfile {
    /// Spans of constant acceleration, one after the other.
    Phases(Vec<Phase>),
    /// Least jerk: a fifth-order polynomial whose speed and acceleration are
    /// zero at both ends.
    Soft {
        /// Distance covered, m.
        length_m: f64,
        /// Time taken, s.
        duration_s: f64,
    },
}

/// A span of constant acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    start_s: f64,
    duration_s: f64,
    start_m: f64,
    start_speed_m_s: f64,
    acceleration_m_s2: f64,
}

/// Motion along the path at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Along {
    /// Distance from the beginning, m.
    pub distance_m: f64,
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// Acceleration, m/s^2.
    pub acceleration_m_s2: f64,
}

impl SpeedProfile {
    /// Speeds up evenly for half the time and slows down evenly for the other
    /// half: the profile of eq 19.
    pub fn even(length_m: f64, duration_s: f64) -> Self {
        let half_s = duration_s / 2.0;
        let acceleration_m_s2 = length_m / (half_s * half_s);
        let mut phases = Vec::new();
        push_phase(&mut phases, half_s, acceleration_m_s2);
        push_phase(&mut phases, half_s, -acceleration_m_s2);
        Self::Phases(phases)
    }

    /// The fastest run through stretches of `(length_m, speed_limit_m_s)` that
    /// begins and ends at rest and never accelerates by more than
    /// `acceleration_m_s2`.
    pub fn limited(stretches: &[(f64, f64)], acceleration_m_s2: f64) -> Self {
        let reach = |speed: f64, length: f64| (speed * speed + 2.0 * acceleration_m_s2 * length).sqrt();
        // Highest speed allowed at each joint: first by what follows, then by what came before.
        let mut joints = vec![0.0; stretches.len() + 1];
        for (index, &(length, limit)) in stretches.iter().enumerate().skip(1).rev() {
            let before = stretches[index - 1].1;
            joints[index] = reach(joints[index + 1], length).min(limit).min(before);
        }
        for (index, &(length, _)) in stretches.iter().enumerate() {
            joints[index + 1] = reach(joints[index], length).min(joints[index + 1]);
        }
        let mut phases = Vec::new();
        for (index, &(length, limit)) in stretches.iter().enumerate() {
            let (enter, leave) = (joints[index], joints[index + 1]);
            let peak = ((enter * enter + leave * leave) / 2.0 + acceleration_m_s2 * length).sqrt().min(limit);
            let ramps_m = (2.0 * peak * peak - enter * enter - leave * leave) / (2.0 * acceleration_m_s2);
            push_phase(&mut phases, (peak - enter) / acceleration_m_s2, acceleration_m_s2);
            push_phase(&mut phases, (length - ramps_m).max(0.0) / peak, 0.0);
            push_phase(&mut phases, (peak - leave) / acceleration_m_s2, -acceleration_m_s2);
        }
        Self::Phases(phases)
    }

    /// Motion at `time_s`; at rest before the beginning and after the end.
    pub fn at(&self, time_s: f64) -> Along {
        if time_s <= 0.0 {
            return Along::default();
        }
        if time_s >= self.duration_s() {
            return Along { distance_m: self.length_m(), ..Along::default() };
        }
        match self {
            Self::Phases(phases) => {
                let after = phases.iter().position(|phase| time_s < phase.start_s).unwrap_or(phases.len());
                phases[after - 1].at(time_s)
            }
            Self::Soft { length_m, duration_s } => soft(*length_m, *duration_s, time_s),
        }
    }

    /// Time taken, s.
    pub fn duration_s(&self) -> f64 {
        match self {
            Self::Phases(phases) => phases.last().map_or(0.0, |last| last.start_s + last.duration_s),
            Self::Soft { duration_s, .. } => *duration_s,
        }
    }

    /// Distance covered, m.
    pub fn length_m(&self) -> f64 {
        match self {
            Self::Phases(phases) => {
                phases.last().map_or(0.0, |last| last.at(last.start_s + last.duration_s).distance_m)
            }
            Self::Soft { length_m, .. } => *length_m,
        }
    }
}

impl Phase {
    fn at(&self, time_s: f64) -> Along {
        let into_s = time_s - self.start_s;
        Along {
            distance_m: self.start_m + (self.start_speed_m_s + 0.5 * self.acceleration_m_s2 * into_s) * into_s,
            speed_m_s: self.start_speed_m_s + self.acceleration_m_s2 * into_s,
            acceleration_m_s2: self.acceleration_m_s2,
        }
    }
}

/// Appends a phase where the last one ends; phases of no length are left out.
fn push_phase(phases: &mut Vec<Phase>, duration_s: f64, acceleration_m_s2: f64) {
    if duration_s <= 0.0 {
        return;
    }
    let start_s = phases.last().map_or(0.0, |last| last.start_s + last.duration_s);
    let start = phases.last().map_or(Along::default(), |last| last.at(start_s));
    phases.push(Phase {
        start_s,
        duration_s,
        start_m: start.distance_m,
        start_speed_m_s: start.speed_m_s,
        acceleration_m_s2,
    });
}

fn soft(length_m: f64, duration_s: f64, time_s: f64) -> Along {
    let u = time_s / duration_s;
    Along {
        distance_m: length_m * u * u * u * (10.0 + u * (-15.0 + 6.0 * u)),
        speed_m_s: length_m / duration_s * 30.0 * u * u * (1.0 - u) * (1.0 - u),
        acceleration_m_s2: length_m / (duration_s * duration_s) * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_consistent(profile: &SpeedProfile) {
        let step_s = 1e-4;
        let end_s = profile.duration_s();
        let mut time_s = step_s;
        while time_s < end_s - step_s {
            let (before, now, after) = (profile.at(time_s - step_s), profile.at(time_s), profile.at(time_s + step_s));
            let speed = (after.distance_m - before.distance_m) / (2.0 * step_s);
            assert!((speed - now.speed_m_s).abs() < 1e-3, "speed at {time_s} s");
            time_s += end_s / 997.0;
        }
    }

    #[test]
    fn eq_19_covers_half_the_way_in_half_the_time() {
        let profile = SpeedProfile::even(8.0, 10.0);
        assert!((profile.at(5.0).distance_m - 4.0).abs() < 1e-12);
        assert!((profile.at(10.0).distance_m - 8.0).abs() < 1e-12);
        assert_eq!(profile.at(2.0).acceleration_m_s2, -profile.at(8.0).acceleration_m_s2);
        assert_consistent(&profile);
    }

    #[test]
    fn a_soft_profile_starts_and_stops_without_acceleration() {
        let profile = SpeedProfile::Soft { length_m: 3.0, duration_s: 4.0 };
        assert!(profile.at(1e-9).acceleration_m_s2.abs() < 1e-6);
        assert!((profile.at(4.0).distance_m - 3.0).abs() < 1e-12);
        assert_consistent(&profile);
    }

    #[test]
    fn a_limited_profile_keeps_every_limit_and_covers_every_stretch() {
        let stretches = [(2.0, 0.5), (0.3, 0.2), (1.0, 0.8), (0.05, 0.8)];
        let profile = SpeedProfile::limited(&stretches, 0.25);
        assert!((profile.length_m() - 3.35).abs() < 1e-9);
        assert_consistent(&profile);
        for step in 0..=1000 {
            let along = profile.at(profile.duration_s() * f64::from(step) / 1000.0);
            let mut end_m = 0.0;
            let limit = stretches.iter().find(|(length, _)| {
                end_m += length;
                along.distance_m <= end_m - 1e-9
            });
            assert!(along.speed_m_s <= limit.map_or(0.8, |&(_, limit)| limit) + 1e-9, "{along:?}");
            assert!(along.acceleration_m_s2.abs() <= 0.25 + 1e-12);
        }
    }
}
