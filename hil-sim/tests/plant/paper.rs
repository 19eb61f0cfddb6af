//! The paper's robot (section 4) and friction.

use canloop::robot::{Load, Model, Pose, Robot};
use canloop::wheels::Wheels;
use hil_sim::plant::{Friction, Plant, Torque};
use proptest::test_runner::{Config as ProptestConfig, RngSeed};

pub const FRICTION: Friction =
    Friction { viscous_nm_s_per_rad: 0.2, static_nm: 60.0, coulomb_nm: 6.0, stribeck_s_per_rad: 500.0 };

pub const NO_FRICTION: Friction =
    Friction { viscous_nm_s_per_rad: 0.0, static_nm: 0.0, coulomb_nm: 0.0, stribeck_s_per_rad: 0.0 };

pub const MODELS: [Model; 2] = [Model::Paper, Model::RigidBody];

pub fn robot(model: Model) -> Robot {
    Robot {
        model,
        mass_kg: 46.5,
        inertia_kg_m2: 1.3133,
        half_track_m: 0.27,
        wheel_radius_m: 0.122,
        wheel_inertia_kg_m2: 0.0144,
        motor_inertia_kg_m2: 0.0125,
        gear_ratio: 3.0,
        load: Load { mass_kg: 80.0, cog_distance_m: 0.2, cog_angle_rad: 2.0 * std::f64::consts::FRAC_PI_3 },
    }
}

pub fn plant(model: Model) -> Plant {
    Plant::new(robot(model), Wheels::both(FRICTION), Pose::default())
}

pub fn constant(right_nm: f64, left_nm: f64) -> Wheels<Torque> {
    Wheels { right: Torque::constant(right_nm), left: Torque::constant(left_nm) }
}

/// Random cases, the same in every run.
pub fn seeded(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() }
}
