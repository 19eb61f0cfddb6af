//! What is watched while the stack is armed. Each watch is shown what happens,
//! and says what is wrong with it, and with which wheel.

use std::collections::VecDeque;

use super::limits::Limits;
use super::state::Reason;
use crate::wheels::{Wheel, Wheels};

/// The watches and what they remember. They count time in periods.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    limits: Limits,
    period_s: f64,
    /// Periods begun.
    ticks: u64,
    /// Periods since both drives last answered in time.
    without_feedback: u32,
    /// Periods since each drive last gave a sign of life.
    without_heartbeat: Wheels<u32>,
    /// Periods in a row in which the law asked for more than the torque limit.
    saturated: Wheels<u32>,
    /// Periods in which the last damaged frames came, as many as trip.
    damaged_at: VecDeque<u64>,
    /// How fast the wheels turned when that could last be told, rad/s.
    speed_rad_s: Wheels<Option<f64>>,
}

/// A span that is a smaller share of the period says nothing of speed: a loop
/// that is late now and punctual again a moment later measures its own lateness.
const SHORT_SPAN: f64 = 0.5;

/// What is wrong, and with which wheel if with one.
pub(super) type Finding = Option<(Reason, Option<Wheel>)>;

impl Watch {
    pub fn new(limits: Limits, period_s: f64) -> Self {
        Self {
            limits,
            period_s,
            ticks: 0,
            without_feedback: 0,
            without_heartbeat: Wheels::default(),
            saturated: Wheels::default(),
            damaged_at: VecDeque::with_capacity(limits.damaged_frames as usize + 1),
            speed_rad_s: Wheels::default(),
        }
    }

    /// The stack is armed: what was tolerable until now counts no more.
    pub fn arm(&mut self) {
        self.without_heartbeat = Wheels::default();
        self.saturated = Wheels::default();
        self.damaged_at.clear();
    }

    /// Another period begins.
    pub fn begin_period(&mut self) -> Finding {
        self.ticks += 1;
        self.without_heartbeat = self.without_heartbeat.map(|periods| periods.saturating_add(1));
        let is_lost = |wheel: &Wheel| self.has_lasted(self.without_heartbeat[*wheel], self.limits.heartbeat_timeout_s);
        let lost = Wheel::BOTH.into_iter().find(is_lost)?;
        Some((Reason::HeartbeatLost, Some(lost)))
    }

    /// A drive gave a sign of life.
    pub fn heartbeat(&mut self, wheel: Wheel) {
        self.without_heartbeat[wheel] = 0;
    }

    /// Both drives have answered in time, or not.
    pub fn feedback(&mut self, has_come: bool) -> Finding {
        self.without_feedback = if has_come { 0 } else { self.without_feedback.saturating_add(1) };
        let is_stale = self.without_feedback >= self.limits.feedback_timeout_periods;
        is_stale.then_some((Reason::StaleFeedback, None))
    }

    /// A drive's frame was damaged.
    pub fn damaged_frame(&mut self) -> Finding {
        let most = self.limits.damaged_frames as usize;
        self.damaged_at.push_back(self.ticks);
        if self.damaged_at.len() > most {
            self.damaged_at.pop_front();
        }
        let first = *self.damaged_at.front()?;
        let window_periods = self.limits.damaged_frames_window_s / self.period_s;
        let is_dense = self.damaged_at.len() == most && ((self.ticks - first) as f64) < window_periods;
        is_dense.then_some((Reason::DamagedFrames, None))
    }

    /// The wheels have moved by so much, rad, in so many seconds each.
    pub fn motion(&mut self, moved_rad: Wheels<f64>, span_s: Wheels<f64>) -> Finding {
        let jumped = Wheel::BOTH.into_iter().find(|&wheel| {
            let expected_rad = self.speed_rad_s[wheel].unwrap_or(moved_rad[wheel] / span_s[wheel]) * span_s[wheel];
            let periods = (span_s[wheel] / self.period_s).max(1.0);
            (moved_rad[wheel] - expected_rad).abs() > self.limits.encoder_jump_rad * periods
        });
        let fast = Wheel::BOTH.into_iter().find(|&wheel| {
            moved_rad[wheel].abs() > self.limits.wheel_speed_limit_rad_s * span_s[wheel].max(self.period_s)
        });
        for wheel in Wheel::BOTH {
            if span_s[wheel] > SHORT_SPAN * self.period_s {
                self.speed_rad_s[wheel] = Some(moved_rad[wheel] / span_s[wheel]);
            }
        }
        let jump = jumped.map(|wheel| (Reason::EncoderJump, Some(wheel)));
        jump.or(fast.map(|wheel| (Reason::OverSpeed, Some(wheel))))
    }

    /// The wheels are so far from their targets, rad.
    pub fn error(&self, error_rad: Wheels<f64>) -> Finding {
        let far = beyond(error_rad, self.limits.following_error_rad)?;
        Some((Reason::FollowingError, Some(far)))
    }

    /// The law asks for this torque, N m.
    pub fn torque(&mut self, wanted_nm: Wheels<f64>) -> Finding {
        if !wanted_nm.all(|torque| torque.is_finite()) {
            let wheel = Wheel::BOTH.into_iter().find(|wheel| !wanted_nm[*wheel].is_finite());
            return Some((Reason::NotFinite, wheel));
        }
        let limit_nm = self.limits.torque_limit_nm;
        self.saturated =
            self.saturated.zip_with(
                wanted_nm,
                |periods, wanted_nm| {
                    if wanted_nm.abs() > limit_nm { periods.saturating_add(1) } else { 0 }
                },
            );
        let is_long = |wheel: &Wheel| self.has_lasted(self.saturated[*wheel], self.limits.saturation_timeout_s);
        let long = Wheel::BOTH.into_iter().find(is_long)?;
        Some((Reason::TorqueSaturated, Some(long)))
    }

    /// Whether so many periods are, to the nearest of them, as long as this.
    pub fn has_lasted(&self, periods: u32, timeout_s: f64) -> bool {
        periods > 0 && (f64::from(periods) + 0.5) * self.period_s > timeout_s
    }
}

/// The first wheel of which a quantity is, either way, beyond a limit.
fn beyond(quantity: Wheels<f64>, limit: f64) -> Option<Wheel> {
    Wheel::BOTH.into_iter().find(|wheel| quantity[*wheel].abs() > limit)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.01;

    fn watch() -> Watch {
        Watch::new(limits(), PERIOD_S)
    }

    fn limits() -> Limits {
        Limits {
            heartbeat_timeout_s: 0.05,
            damaged_frames: 3,
            damaged_frames_window_s: 0.1,
            saturation_timeout_s: 0.03,
            wheel_speed_limit_rad_s: 20.0,
            ..Limits::for_tests()
        }
    }

    fn only(wheel: Wheel, number: f64) -> Wheels<f64> {
        Wheels::from_fn(|other| if other == wheel { number } else { 0.0 })
    }

    #[test]
    fn feedback_may_stay_out_for_less_than_its_timeout() {
        let mut watch = watch();
        for _ in 0..3 {
            assert_eq!(watch.feedback(false), None);
            assert_eq!(watch.feedback(true), None);
        }
        assert_eq!(watch.feedback(false), None);
        assert_eq!(watch.feedback(false), Some((Reason::StaleFeedback, None)));
        assert_eq!(watch.feedback(false), Some((Reason::StaleFeedback, None)));
    }

    #[test]
    fn a_heartbeat_is_lost_at_its_timeout_and_each_drive_has_its_own() {
        for wheel in Wheel::BOTH {
            let mut watch = watch();
            let periods = (1..20).take_while(|_| {
                watch.heartbeat(wheel.other());
                watch.begin_period().is_none()
            });
            assert_eq!(periods.count(), 4, "the fifth period of 10 ms is one too many");
            assert_eq!(watch.begin_period(), Some((Reason::HeartbeatLost, Some(wheel))));
            watch.heartbeat(wheel);
            assert_eq!(watch.begin_period(), None);
        }
    }

    #[test]
    fn what_was_before_the_stack_was_armed_does_not_count() {
        let mut watch = watch();
        (0..100).for_each(|_| {
            watch.begin_period();
        });
        (0..3).for_each(|_| {
            watch.damaged_frame();
        });
        (0..100).for_each(|_| {
            watch.torque(Wheels::both(91.0));
        });
        watch.arm();
        assert_eq!(watch.begin_period(), None);
        assert_eq!(watch.damaged_frame(), None);
        assert_eq!(watch.torque(Wheels::both(91.0)), None);
    }

    #[test]
    fn so_many_damaged_frames_within_the_window_are_too_many() {
        let mut watch = watch();
        assert_eq!([watch.damaged_frame(), watch.damaged_frame()], [None, None]);
        assert_eq!(watch.damaged_frame(), Some((Reason::DamagedFrames, None)));
        assert_eq!(watch.damaged_frame(), Some((Reason::DamagedFrames, None)));
    }

    #[test]
    fn damaged_frames_that_come_seldom_are_tolerated() {
        let after = |periods: u32| {
            let mut watch = Watch::new(Limits { heartbeat_timeout_s: f64::INFINITY, ..limits() }, PERIOD_S);
            (0..1000).for_each(|_| assert_eq!(watch.begin_period(), None));
            watch.damaged_frame();
            watch.damaged_frame();
            (0..periods).for_each(|_| assert_eq!(watch.begin_period(), None));
            watch.damaged_frame()
        };
        assert_eq!(after(9), Some((Reason::DamagedFrames, None)));
        assert_eq!(after(10), None);
        let mut watch = Watch::new(Limits { heartbeat_timeout_s: f64::INFINITY, ..limits() }, PERIOD_S);
        for _ in 0..100 {
            assert_eq!(watch.damaged_frame(), None);
            (0..5).for_each(|_| {
                watch.begin_period();
            });
        }
    }

    /// What is found of a wheel that moves by this much in a time, while the
    /// other one rests.
    fn moves(watch: &mut Watch, wheel: Wheel, moved_rad: f64, span_s: f64) -> Finding {
        watch.motion(only(wheel, moved_rad), Wheels::both(span_s))
    }

    #[test]
    fn a_wheel_that_jumps_in_a_period_is_told_from_one_that_turns() {
        for (wheel, way) in [(Wheel::Right, 1.0), (Wheel::Left, -1.0)] {
            let mut watch = watch();
            let mut moves = |moved_rad: f64| moves(&mut watch, wheel, moved_rad * way, PERIOD_S);
            assert_eq!(moves(0.15), None, "at first it may turn at any speed");
            assert_eq!(moves(0.06), None);
            assert_eq!(moves(0.17), Some((Reason::EncoderJump, Some(wheel))));
            assert_eq!(moves(0.17), None);
            assert_eq!(moves(0.06), Some((Reason::EncoderJump, Some(wheel))), "back again");
        }
    }

    #[test]
    fn over_several_periods_a_wheel_may_do_several_times_as_much() {
        let mut watch = watch();
        moves(&mut watch, Wheel::Left, 0.0, PERIOD_S);
        assert_eq!(moves(&mut watch, Wheel::Left, 0.19, 2.0 * PERIOD_S), None);
        let mut watch = Watch::new(limits(), PERIOD_S);
        moves(&mut watch, Wheel::Left, 0.0, PERIOD_S);
        let jump = moves(&mut watch, Wheel::Left, 0.21, 2.0 * PERIOD_S);
        assert_eq!(jump, Some((Reason::EncoderJump, Some(Wheel::Left))));
    }

    #[test]
    fn a_span_that_came_out_short_is_no_jump_and_says_nothing_of_speed() {
        let limits = Limits { wheel_speed_limit_rad_s: f64::INFINITY, ..limits() };
        let mut watch = Watch::new(limits, PERIOD_S);
        for span_s in [PERIOD_S, 0.001 * PERIOD_S, PERIOD_S, 0.49 * PERIOD_S, PERIOD_S] {
            assert_eq!(moves(&mut watch, Wheel::Right, 0.18, PERIOD_S), None);
            assert_eq!(moves(&mut watch, Wheel::Right, 0.18 * span_s / PERIOD_S + 0.05, span_s), None);
        }
        // From half a period on it does.
        let mut watch = Watch::new(limits, PERIOD_S);
        moves(&mut watch, Wheel::Right, 0.18, PERIOD_S);
        moves(&mut watch, Wheel::Right, 0.02, 0.51 * PERIOD_S);
        let jump = moves(&mut watch, Wheel::Right, 0.18, PERIOD_S);
        assert_eq!(jump, Some((Reason::EncoderJump, Some(Wheel::Right))));
    }

    #[test]
    fn limits_themselves_are_kept() {
        // Numbers that binary fractions hold exactly.
        let limits = Limits { encoder_jump_rad: 0.25, wheel_speed_limit_rad_s: f64::INFINITY, ..limits() };
        let mut watch = Watch::new(limits, 1.0);
        moves(&mut watch, Wheel::Left, 0.0, 1.0);
        assert_eq!(moves(&mut watch, Wheel::Left, 0.25, 1.0), None, "as far as the limit");
        assert_eq!(moves(&mut watch, Wheel::Left, 0.0, 0.5), None, "half a period says nothing of speed");
        assert_eq!(moves(&mut watch, Wheel::Left, 0.5, 1.0), None, "0.25 more than at 0.25 rad/s");
        assert!(!watch.has_lasted(1, 1.5) && watch.has_lasted(1, 1.49), "half a period counts for the next");
        assert!(!watch.has_lasted(0, 0.1), "what has not begun has not lasted");
    }

    #[test]
    fn a_wheel_may_turn_as_fast_as_the_limit_and_no_faster() {
        for (wheel, way) in [(Wheel::Right, -1.0), (Wheel::Left, 1.0)] {
            let mut watch = Watch::new(Limits { encoder_jump_rad: f64::INFINITY, ..limits() }, PERIOD_S);
            moves(&mut watch, wheel, 0.19 * way, PERIOD_S);
            assert_eq!(moves(&mut watch, wheel, 0.2 * way, PERIOD_S), None);
            assert_eq!(moves(&mut watch, wheel, 0.2 * way, 0.6 * PERIOD_S), None, "the span came out short");
            assert_eq!(moves(&mut watch, wheel, 0.205 * way, PERIOD_S), Some((Reason::OverSpeed, Some(wheel))));
            assert_eq!(moves(&mut watch, wheel, 0.39 * way, 2.0 * PERIOD_S), None);
            assert_eq!(moves(&mut watch, wheel, 0.41 * way, 2.0 * PERIOD_S), Some((Reason::OverSpeed, Some(wheel))));
        }
    }

    #[test]
    fn a_wheel_may_be_as_far_from_its_target_as_the_limit_and_no_further() {
        let watch = Watch::new(Limits { following_error_rad: 0.5, ..limits() }, PERIOD_S);
        for (wheel, way) in [(Wheel::Right, 1.0), (Wheel::Left, -1.0)] {
            assert_eq!(watch.error(only(wheel, 0.5 * way)), None);
            assert_eq!(watch.error(only(wheel, 0.51 * way)), Some((Reason::FollowingError, Some(wheel))));
        }
    }

    #[test]
    fn the_law_may_ask_for_too_much_for_a_while() {
        for (wheel, way) in [(Wheel::Right, 1.0), (Wheel::Left, -1.0)] {
            let mut watch = watch();
            for _ in 0..3 {
                assert_eq!(watch.torque(only(wheel, 91.0 * way)), None);
                assert_eq!(watch.torque(only(wheel, 91.0 * way)), None);
                assert_eq!(watch.torque(only(wheel, 90.0 * way)), None, "the limit itself is not too much");
            }
            watch.torque(only(wheel, 91.0 * way));
            watch.torque(only(wheel, 91.0 * way));
            assert_eq!(watch.torque(only(wheel, 91.0 * way)), Some((Reason::TorqueSaturated, Some(wheel))));
        }
    }

    #[test]
    fn a_torque_that_is_no_number_is_found_at_once() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for wheel in Wheel::BOTH {
                assert_eq!(watch().torque(only(wheel, bad)), Some((Reason::NotFinite, Some(wheel))));
            }
        }
    }

    #[test]
    fn what_is_infinite_is_not_watched() {
        let mut watch = Watch::new(Limits { heartbeat_timeout_s: f64::INFINITY, ..Limits::for_tests() }, PERIOD_S);
        for _ in 0..10_000 {
            assert_eq!((watch.begin_period(), watch.torque(Wheels::both(1e9))), (None, None));
        }
        assert_eq!(watch.error(Wheels::both(1e9)), None);
    }
}
