//! From a path to wheel targets: directly, or through a loop on the pose.

use crate::config::{Bound, Section};
use crate::path::{Path, Reference};
use crate::robot::{Pose, Robot, wrap_angle_rad};
use crate::wheels::Wheels;

use super::law::{Measured, Target};

/// Leads the wheels along a path, one period at a time.
pub struct Guidance {
    path: Path,
    robot: Robot,
    period_s: f64,
    pose_loop: PoseLoop,
    sampling: Sampling,
    /// Periods since motion began.
    tick: u64,
    /// Wheel angles and speeds of the tick before.
    last: Target,
    /// While braking: by how much the faster wheel slows down in a period, rad/s.
    braking_step_rad_s: Option<f64>,
    /// The path at this tick and the two after it.
    ahead: [Reference; 3],
}

/// How the wheels are measured and how soon a torque acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Speeds are exact and a torque acts at once: the paper's own simulation.
    Exact,
    /// Speeds are differences of encoder positions, and a torque acts in the
    /// period after the next SYNC. Targets are made to match.
    OverBus,
}

/// What turns a pose error into wheel targets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PoseLoop {
    /// Nothing: the wheels follow the path's own angles, as in the paper.
    None,
    /// A tracking law after Kanayama and others (1990) on odometry.
    Kanayama(Kanayama),
}

/// Gains and limits of the pose loop:
/// `v = v* cos e_phi + kx e_x`,
/// `w = w* + (|v*| + v0) ky e_y + kphi sin e_phi`.
///
/// The lateral error cannot shrink while the speed is zero, which is what v0
/// is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kanayama {
    /// 1/s.
    pub kx_per_s: f64,
    /// 1/m^2.
    pub ky_per_m2: f64,
    /// 1/s.
    pub kphi_per_s: f64,
    /// m/s.
    pub v0_m_s: f64,
    /// Limit of the forward speed asked for, m/s.
    pub speed_limit_m_s: f64,
    /// Limit of the yaw rate asked for, rad/s.
    pub yaw_rate_limit_rad_s: f64,
    /// Limit of the wheel acceleration asked for, rad/s^2.
    pub wheel_acceleration_limit_rad_s2: f64,
}

impl Guidance {
    /// Leads a robot believed to be `robot` along `path`.
    pub fn new(path: Path, robot: Robot, period_s: f64, pose_loop: PoseLoop, sampling: Sampling) -> Self {
        let ahead = [Reference::default(); 3];
        let last = Target::default();
        let mut guidance =
            Self { path, robot, period_s, pose_loop, sampling, tick: 0, last, braking_step_rad_s: None, ahead };
        guidance.reset();
        guidance
    }

    /// Goes back to the path's beginning.
    pub fn reset(&mut self) {
        self.tick = 0;
        self.last = Target::default();
        self.braking_step_rad_s = None;
        self.ahead = [0.0, 1.0, 2.0].map(|ticks| self.path.at(ticks * self.period_s));
    }

    /// Leads along another path, from its beginning.
    pub fn follow(&mut self, path: Path) {
        self.path = path;
        self.reset();
    }

    /// The path at this tick.
    pub fn reference(&self) -> &Reference {
        &self.ahead[0]
    }

    /// Goes on to the next tick.
    pub fn advance(&mut self) {
        self.tick += 1;
        let beyond = self.path.at((self.tick + 2) as f64 * self.period_s);
        self.ahead = [self.ahead[1], self.ahead[2], beyond];
    }

    /// Leaves the path: from how the wheels turn now they are brought to rest,
    /// the faster one at this deceleration and the other in proportion, so that
    /// the robot stays on the arc that it is on.
    pub fn brake(&mut self, measured: &Measured, deceleration_rad_s2: f64) {
        let acceleration_rad_s2 = Wheels::default();
        let Measured { angle_rad, speed_rad_s, .. } = *measured;
        self.last = Target { angle_rad, speed_rad_s, acceleration_rad_s2 };
        self.braking_step_rad_s = Some(deceleration_rad_s2 * self.period_s);
    }

    /// Whether the wheels are being brought to rest.
    pub const fn is_braking(&self) -> bool {
        self.braking_step_rad_s.is_some()
    }

    /// Whether the wheels are wanted to be at rest, and braking is over.
    pub fn is_braked(&self) -> bool {
        self.is_braking() && self.last.speed_rad_s == Wheels::default()
    }

    /// How the wheels should turn at this tick, with the robot at `pose`.
    /// To be asked once a tick.
    pub fn target(&mut self, pose: &Pose) -> Target {
        let target = match (self.braking_step_rad_s, self.pose_loop) {
            (Some(step_rad_s), _) => self.to_rest(step_rad_s),
            (None, PoseLoop::None) => self.along_the_path(),
            (None, PoseLoop::Kanayama(gains)) => self.towards_the_path(&gains, pose),
        };
        self.last = target;
        target
    }

    fn along_the_path(&self) -> Target {
        let [now, next, beyond] = &self.ahead;
        let angle_rad = now.wheel_angles_rad(&self.robot);
        match self.sampling {
            Sampling::Exact => Target {
                angle_rad,
                speed_rad_s: now.wheel_speeds_rad_s(&self.robot),
                acceleration_rad_s2: now.wheel_accelerations_rad_s2(&self.robot),
            },
            Sampling::OverBus => {
                let gained = beyond.wheel_speeds_rad_s(&self.robot) - next.wheel_speeds_rad_s(&self.robot);
                Target {
                    angle_rad,
                    speed_rad_s: (angle_rad - self.last.angle_rad) * (1.0 / self.period_s),
                    acceleration_rad_s2: gained * (1.0 / self.period_s),
                }
            }
        }
    }

    fn towards_the_path(&self, gains: &Kanayama, pose: &Pose) -> Target {
        let wanted = gains.wheel_speeds(&self.robot, &self.ahead[0], pose);
        let step = gains.wheel_acceleration_limit_rad_s2 * self.period_s;
        let last = self.last.speed_rad_s;
        self.on_to(last + (wanted - last).map(|change| change.clamp(-step, step)))
    }

    fn to_rest(&self, step_rad_s: f64) -> Target {
        let last = self.last.speed_rad_s;
        let fastest_rad_s = last.right.abs().max(last.left.abs());
        let share = if fastest_rad_s > step_rad_s { 1.0 - step_rad_s / fastest_rad_s } else { 0.0 };
        self.on_to(last * share)
    }

    /// A period on from the last target, to this speed.
    fn on_to(&self, speed_rad_s: Wheels<f64>) -> Target {
        let last = self.last.speed_rad_s;
        Target {
            angle_rad: self.last.angle_rad + (speed_rad_s + last) * (0.5 * self.period_s),
            speed_rad_s,
            acceleration_rad_s2: (speed_rad_s - last) * (1.0 / self.period_s),
        }
    }
}

impl PoseLoop {
    /// Reads `pose_loop` and its gains from a `[controller]` section.
    pub fn read(section: &Section<'_>) -> Self {
        let wanted = section.choice("pose_loop", &[("none", false), ("kanayama", true)], false);
        let gains = section.section("kanayama");
        let default = Kanayama::default();
        let number = |key: &str, default: f64, bound: Bound| gains.number_or(key, default, bound);
        let kanayama = Kanayama {
            kx_per_s: number("kx_per_s", default.kx_per_s, Bound::Within(0.0, 1e4)),
            ky_per_m2: number("ky_per_m2", default.ky_per_m2, Bound::Within(0.0, 1e4)),
            kphi_per_s: number("kphi_per_s", default.kphi_per_s, Bound::Within(0.0, 1e4)),
            v0_m_s: number("v0_m_s", default.v0_m_s, Bound::Within(0.0, 1e4)),
            speed_limit_m_s: number("speed_limit_m_s", default.speed_limit_m_s, Bound::Within(1e-6, 1e6)),
            yaw_rate_limit_rad_s: number(
                "yaw_rate_limit_rad_s",
                default.yaw_rate_limit_rad_s,
                Bound::Within(1e-6, 1e6),
            ),
            wheel_acceleration_limit_rad_s2: number(
                "wheel_acceleration_limit_rad_s2",
                default.wheel_acceleration_limit_rad_s2,
                Bound::Within(1e-6, 1e6),
            ),
        };
        if wanted { Self::Kanayama(kanayama) } else { Self::None }
    }
}

impl Default for Kanayama {
    fn default() -> Self {
        Self {
            kx_per_s: 0.3,
            ky_per_m2: 4.0,
            kphi_per_s: 2.0,
            v0_m_s: 0.3,
            speed_limit_m_s: 0.6,
            yaw_rate_limit_rad_s: 0.8,
            wheel_acceleration_limit_rad_s2: 5.0,
        }
    }
}

impl Kanayama {
    fn wheel_speeds(&self, robot: &Robot, reference: &Reference, pose: &Pose) -> Wheels<f64> {
        let (dx, dy) = (reference.pose.x_m - pose.x_m, reference.pose.y_m - pose.y_m);
        let (sin, cos) = libm::sincos(pose.heading_rad);
        let (ahead_m, left_m) = (cos * dx + sin * dy, cos * dy - sin * dx);
        let (sin_turn, cos_turn) = libm::sincos(wrap_angle_rad(reference.pose.heading_rad - pose.heading_rad));
        let path = reference.twist;
        let speed = path.speed_m_s * cos_turn + self.kx_per_s * ahead_m;
        let yaw_rate = path.yaw_rate_rad_s
            + (path.speed_m_s.abs() + self.v0_m_s) * self.ky_per_m2 * left_m
            + self.kphi_per_s * sin_turn;
        robot.wheels(
            speed.clamp(-self.speed_limit_m_s, self.speed_limit_m_s),
            yaw_rate.clamp(-self.yaw_rate_limit_rad_s, self.yaw_rate_limit_rad_s),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::tests::{PERIOD_S, circle, robot};

    fn guidance(pose_loop: PoseLoop, sampling: Sampling) -> Guidance {
        Guidance::new(circle(), robot(), PERIOD_S, pose_loop, sampling)
    }

    fn turning(right_rad_s: f64, left_rad_s: f64) -> Measured {
        let speed_rad_s = Wheels { right: right_rad_s, left: left_rad_s };
        Measured { angle_rad: Wheels { right: 10.0, left: 8.0 }, speed_rad_s, ..Measured::default() }
    }

    /// The path `ticks` periods after its beginning.
    fn path_at(ticks: u32) -> Reference {
        circle().at(f64::from(ticks) * PERIOD_S)
    }

    #[test]
    fn the_wheels_are_led_along_the_path_a_period_at_a_time() {
        let mut guidance = guidance(PoseLoop::None, Sampling::Exact);
        for _ in 0..2 {
            for tick in 0..5 {
                let now = path_at(tick);
                assert_eq!(*guidance.reference(), now);
                let target = guidance.target(&Pose::default());
                assert_eq!(target.angle_rad, now.wheel_angles_rad(&robot()));
                assert_eq!(target.speed_rad_s, now.wheel_speeds_rad_s(&robot()));
                assert_eq!(target.acceleration_rad_s2, now.wheel_accelerations_rad_s2(&robot()));
                guidance.advance();
            }
            guidance.reset();
        }
    }

    #[test]
    fn over_a_bus_targets_are_differences_as_measurements_are() {
        let mut guidance = guidance(PoseLoop::None, Sampling::OverBus);
        let per_s = 1.0 / PERIOD_S;
        let mut before_rad = Wheels::default();
        for tick in 0..5 {
            let target = guidance.target(&Pose::default());
            let angle_rad = path_at(tick).wheel_angles_rad(&robot());
            assert_eq!(target.angle_rad, angle_rad);
            assert_eq!(target.speed_rad_s, (angle_rad - before_rad) * per_s);
            // For the period in which the torque will act.
            let speed_rad_s = |ticks| path_at(ticks).wheel_speeds_rad_s(&robot());
            let expected = (speed_rad_s(tick + 2) - speed_rad_s(tick + 1)) * per_s;
            assert!((target.acceleration_rad_s2 - expected).all(|off| off.abs() < 1e-9), "{target:?}");
            before_rad = angle_rad;
            guidance.advance();
        }
    }

    #[test]
    fn braking_goes_on_from_how_the_wheels_turn_and_keeps_to_the_arc() {
        for way in [1.0, -1.0] {
            let mut guidance = guidance(PoseLoop::None, Sampling::OverBus);
            guidance.target(&Pose::default());
            assert!(!guidance.is_braking() && !guidance.is_braked());
            guidance.brake(&turning(2.0 * way, -way), 5.0);
            assert!(guidance.is_braking() && !guidance.is_braked());
            let target = guidance.target(&Pose::default());
            let step_rad_s = 5.0 * PERIOD_S;
            assert!((target.speed_rad_s.right - way * (2.0 - step_rad_s)).abs() < 1e-12);
            assert!((target.speed_rad_s.left + 0.5 * target.speed_rad_s.right).abs() < 1e-12);
            assert!((target.acceleration_rad_s2.right + 5.0 * way).abs() < 1e-9);
            let moved_rad = way * (2.0 - 0.5 * step_rad_s) * PERIOD_S;
            assert!((target.angle_rad.right - 10.0 - moved_rad).abs() < 1e-12);
            assert!((target.angle_rad.left - 8.0 + 0.5 * moved_rad).abs() < 1e-12);
        }
    }

    #[test]
    fn the_slower_wheel_may_be_either() {
        let mut guidance = guidance(PoseLoop::None, Sampling::OverBus);
        guidance.brake(&turning(0.5, 2.0), 5.0);
        let target = guidance.target(&Pose::default());
        assert!((target.speed_rad_s.left - 2.0 + 5.0 * PERIOD_S).abs() < 1e-12);
    }

    #[test]
    fn braking_ends_at_rest_after_the_speed_over_the_deceleration_whatever_led_before() {
        for pose_loop in [PoseLoop::None, PoseLoop::Kanayama(Kanayama::default())] {
            let mut guidance = guidance(pose_loop, Sampling::OverBus);
            guidance.brake(&turning(2.0, 1.0), 5.0);
            let mut ticks = 0;
            while !guidance.is_braked() {
                guidance.target(&Pose::default());
                ticks += 1;
            }
            let expected = (2.0 / 5.0 / PERIOD_S).round() as i32;
            assert!((ticks - expected).abs() <= 1, "{ticks} instead of {expected}");
            let at_rest = guidance.target(&Pose::default());
            assert_eq!((at_rest.speed_rad_s, at_rest.acceleration_rad_s2), (Wheels::default(), Wheels::default()));
            assert_eq!(guidance.target(&Pose::default()), at_rest);
        }
    }

    #[test]
    fn who_begins_anew_brakes_no_more() {
        let mut guidance = guidance(PoseLoop::None, Sampling::OverBus);
        let first = guidance.target(&Pose::default());
        guidance.brake(&turning(0.0, 0.0), 5.0);
        guidance.target(&Pose::default());
        guidance.reset();
        assert!(!guidance.is_braking());
        assert_eq!(guidance.target(&Pose::default()), first);
    }
}
