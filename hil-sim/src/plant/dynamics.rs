//! Eq 5 at the wheels: `M theta'' + T(theta') = tau`, plus the velocity terms
//! of a rigid body whose centre of gravity lies ahead of the axle.

use canloop::robot::{MassMatrix, Model, Robot};
use canloop::wheels::{Wheel, Wheels};

use super::friction::Friction;
use super::grip::Grip;

/// Friction steeper than this has a time constant below a microsecond, which
/// no mechanism has: it is softened, so that the work for a step is bounded.
const STEEPEST_RATE_HZ: f64 = 1e6;

/// Speed error, rad/s, allowed to a step from rest for the Stribeck curve.
const STRIBECK_ERROR_RAD_S: f64 = 1e-8;

/// What turns torque into acceleration. Speeds only: the motion of the wheels
/// does not depend on where the robot is.
#[derive(Clone, Debug)]
pub struct Dynamics {
    mass: MassMatrix,
    /// Both wheels slipping: the inverse of `mass`.
    free: Mobility,
    /// Velocity torque per product of speeds, N m s^2; 0 in the paper's model.
    velocity_gain: f64,
    friction: Wheels<Friction>,
    stribeck_travel: Wheels<f64>,
}

/// Acceleration per torque, 1/(kg m^2): a symmetric matrix whose row and
/// column are zero where a wheel is stuck.
#[derive(Clone, Copy, Debug)]
pub struct Mobility {
    right: f64,
    cross: f64,
    left: f64,
}

impl Dynamics {
    /// The dynamics of this robot with both wheels on the floor.
    pub fn new(robot: &Robot, friction: Wheels<Friction>) -> Self {
        let velocity_gain = match robot.model {
            Model::Paper => 0.0,
            Model::RigidBody => {
                let ratio = robot.wheel_radius_m / (2.0 * robot.half_track_m);
                robot.total_mass_kg() * robot.cog_ahead_m() * ratio * ratio * robot.wheel_radius_m
            }
        };
        Self::with_mass(robot.mass_matrix(), velocity_gain, friction)
    }

    /// What is left of it on the floor with some wheels `lifted`. Their side
    /// rolls on without them: it has neither their inertia nor their friction.
    pub fn on_the_floor(robot: &Robot, friction: Wheels<Friction>, lifted: Wheels<bool>) -> Self {
        let grounded =
            friction.zip_with(lifted, |friction, is_lifted| if is_lifted { Friction::default() } else { friction });
        let whole = Self::new(robot, grounded);
        let turning_kg_m2 = lifted.map(|is_lifted| if is_lifted { robot.turning_inertia_kg_m2() } else { 0.0 });
        let mut mass = whole.mass;
        mass.m11 -= turning_kg_m2.right;
        mass.m22 -= turning_kg_m2.left;
        Self::with_mass(mass, whole.velocity_gain, grounded)
    }

    /// Wheels in the air: each turns by itself.
    pub fn in_the_air(robot: &Robot, friction: Wheels<Friction>) -> Self {
        let turning_kg_m2 = robot.turning_inertia_kg_m2();
        Self::with_mass(MassMatrix { m11: turning_kg_m2, m12: 0.0, m22: turning_kg_m2 }, 0.0, friction)
    }

    fn with_mass(mass: MassMatrix, velocity_gain: f64, friction: Wheels<Friction>) -> Self {
        let determinant = mass.m11 * mass.m22 - mass.m12 * mass.m12;
        let free =
            Mobility { right: mass.m22 / determinant, cross: -mass.m12 / determinant, left: mass.m11 / determinant };
        let mobility = Wheels { right: free.right, left: free.left };
        let friction = friction.zip_with(mobility, softened);
        let stribeck_travel =
            friction.map(|friction| libm::pow(2880.0 * friction.stribeck_s_per_rad * STRIBECK_ERROR_RAD_S, 0.2));
        Self { mass, free, velocity_gain, friction, stribeck_travel }
    }

    /// The speeds, rad/s, after a lifted `wheel` that turns at `landing_rad_s`
    /// has come down while the floor's side of it all moves at `speed_rad_s`:
    /// from then on they are one, with the momentum of both.
    pub fn after_landing(
        &self,
        wheel: Wheel,
        landing_rad_s: f64,
        speed_rad_s: Wheels<f64>,
        robot: &Robot,
    ) -> Wheels<f64> {
        let turning_kg_m2 = robot.turning_inertia_kg_m2();
        let mut momentum = self.mass.times(speed_rad_s);
        momentum[wheel] += turning_kg_m2 * landing_rad_s;
        let mut mass = self.mass;
        match wheel {
            Wheel::Right => mass.m11 += turning_kg_m2,
            Wheel::Left => mass.m22 += turning_kg_m2,
        }
        mass.solve(momentum)
    }

    /// Each wheel's friction.
    pub const fn friction(&self) -> &Wheels<Friction> {
        &self.friction
    }

    /// What a wheel's own torque has to accelerate while the other turns
    /// steadily, kg m^2.
    pub const fn inertia_kg_m2(&self, wheel: Wheel) -> f64 {
        match wheel {
            Wheel::Right => self.mass.m11,
            Wheel::Left => self.mass.m22,
        }
    }

    /// How the wheels answer to torque with these grips.
    pub fn mobility(&self, grip: Wheels<Grip>) -> Mobility {
        match (grip.right, grip.left) {
            (Grip::Slips(_), Grip::Slips(_)) => self.free,
            (Grip::Slips(_), Grip::Sticks) => Mobility { right: 1.0 / self.mass.m11, cross: 0.0, left: 0.0 },
            (Grip::Sticks, Grip::Slips(_)) => Mobility { right: 0.0, cross: 0.0, left: 1.0 / self.mass.m22 },
            (Grip::Sticks, Grip::Sticks) => Mobility { right: 0.0, cross: 0.0, left: 0.0 },
        }
    }

    /// What is left of `torque_nm` to accelerate slipping wheels, N m. For a
    /// stuck wheel friction is left out: see [`Self::held_nm`].
    pub fn net_nm(&self, grip: Wheels<Grip>, speed_rad_s: Wheels<f64>, torque_nm: Wheels<f64>) -> Wheels<f64> {
        let friction_nm = Wheels::from_fn(|wheel| match grip[wheel] {
            Grip::Sticks => 0.0,
            Grip::Slips(direction) => self.friction[wheel].slipping_nm(direction, speed_rad_s[wheel]),
        });
        torque_nm + self.velocity_nm(speed_rad_s) - friction_nm
    }

    /// The torque that friction takes up to hold a stuck `wheel`, N m, while
    /// the other accelerates.
    pub fn held_nm(&self, wheel: Wheel, net_nm: Wheels<f64>, acceleration: Wheels<f64>) -> f64 {
        net_nm[wheel] - self.mass.m12 * acceleration[wheel.other()]
    }

    /// How fast viscous friction makes speeds forget their past at most, 1/s.
    pub fn viscous_rate_hz(&self, mobility: &Mobility) -> f64 {
        let Wheels { right, left } = &self.friction;
        right.viscous_nm_s_per_rad * mobility.right + left.viscous_nm_s_per_rad * mobility.left
    }

    /// How fast the velocity terms turn one wheel's speed into the other's, 1/s.
    pub fn velocity_rate_hz(&self, mobility: &Mobility, speed_rad_s: Wheels<f64>) -> f64 {
        let speeds = speed_rad_s.right.abs() + speed_rad_s.left.abs();
        self.velocity_gain.abs() * speeds * (mobility.right + mobility.left)
    }

    /// How fast small differences of speed grow at most through the Stribeck
    /// term, 1/s.
    pub fn stribeck_rate_hz(&self, mobility: &Mobility, speed_rad_s: Wheels<f64>) -> f64 {
        self.friction.right.stribeck_slope(speed_rad_s.right) * mobility.right
            + self.friction.left.stribeck_slope(speed_rad_s.left) * mobility.left
    }

    /// What part of the Stribeck speed `1/a` a step from rest may travel. A
    /// step that travels `q / a` is off by about `q^5 / (2880 a)` in speed.
    pub fn stribeck_travel(&self, wheel: Wheel) -> f64 {
        self.stribeck_travel[wheel]
    }

    /// The centre of gravity, `e` ahead of the axle, resists the turn: force
    /// `M e p^2` and moment `-M e v p`, here brought to the wheels. They do
    /// no work: the product with the speeds is zero.
    fn velocity_nm(&self, speed_rad_s: Wheels<f64>) -> Wheels<f64> {
        let Wheels { right, left } = speed_rad_s;
        let turning = self.velocity_gain * (right - left);
        Wheels { right: -turning * left, left: turning * right }
    }
}

impl Mobility {
    /// Acceleration, rad/s^2, under this torque, N m.
    pub fn times(&self, torque_nm: Wheels<f64>) -> Wheels<f64> {
        let Wheels { right, left } = torque_nm;
        Wheels { right: self.right * right + self.cross * left, left: self.cross * right + self.left * left }
    }
}

/// `friction` no steeper than [`STEEPEST_RATE_HZ`] in a wheel of this mobility.
fn softened(friction: Friction, mobility: f64) -> Friction {
    let steepest = STEEPEST_RATE_HZ / mobility;
    let drop_nm = friction.drop_nm().abs();
    Friction {
        viscous_nm_s_per_rad: friction.viscous_nm_s_per_rad.min(steepest),
        stribeck_s_per_rad: friction.stribeck_s_per_rad.min(steepest / drop_nm),
        ..friction
    }
}
