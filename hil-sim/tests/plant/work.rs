//! Whatever the torque, the plant comes to an end with finite numbers.

use canloop::robot::{Model, Pose};
use canloop::wheels::Wheels;
use hil_sim::plant::{Friction, Plant, State, Torque};
use proptest::prelude::*;

use crate::paper::{FRICTION, MODELS, constant, plant, robot, seeded};

#[test]
fn alternating_torque_at_and_about_the_threshold_ends() {
    for model in MODELS {
        for nm in [60.0, 60.0 + 1e-12, 60.000_001, 61.0, 90.0] {
            for step_s in [1e-5, 1e-3] {
                let mut plant = plant(model);
                for k in 0..500 {
                    let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                    plant.advance(step_s, constant(sign * nm, -sign * nm));
                }
                assert_finite(plant.state());
            }
        }
    }
}

#[test]
fn absurd_torque_ends() {
    for model in MODELS {
        for nm in [1e4, 1e6, 1e9] {
            let mut plant = plant(model);
            for k in 0..20 {
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                plant.advance(1e-3, constant(sign * nm, -0.3 * nm));
            }
            assert_finite(plant.state());
        }
    }
}

#[test]
fn friction_steeper_than_any_real_one_ends() {
    let steep = Friction { viscous_nm_s_per_rad: 1e9, stribeck_s_per_rad: 1e9, ..FRICTION };
    let mut plant = Plant::new(robot(Model::RigidBody), Wheels::both(steep), Pose::default());
    plant.advance(1e-3, constant(90.0, -80.0));
    plant.advance(1e-3, constant(-90.0, -10.0));
    assert_finite(plant.state());
}

#[test]
fn a_speed_too_small_to_turn_the_wheel_still_comes_to_rest() {
    let mut plant = plant(Model::Paper);
    plant.set_speed(Wheels { right: 1e-300, left: -1e-310 });
    plant.advance(1.0, constant(10.0, 0.0));
    assert_eq!(plant.is_stuck(), Wheels::both(true));
}

#[test]
fn no_time_changes_nothing() {
    let mut plant = plant(Model::Paper);
    for span_s in [0.0, -1.0, f64::NAN] {
        plant.advance(span_s, constant(90.0, 90.0));
        assert_eq!(*plant.state(), State::default());
    }
}

proptest! {
    #![proptest_config(seeded(48))]

    #[test]
    fn any_friction_under_any_lagging_torque_ends(
        friction in (0.0..5.0, 0.0..90.0, 0.0..90.0, 0.0..5000.0),
        torques in prop::collection::vec(
            (prop::sample::select(vec![0.0, 6.0, 60.0, -60.0, 59.9, -90.0]), -150.0..150.0, 1e-5..1e-2, 1e-6..1e-2),
            1..30,
        ),
    ) {
        let (viscous_nm_s_per_rad, static_nm, coulomb_nm, stribeck_s_per_rad) = friction;
        let friction = Friction { viscous_nm_s_per_rad, static_nm, coulomb_nm, stribeck_s_per_rad };
        for model in MODELS {
            let mut plant = Plant::new(robot(model), Wheels { right: friction, left: FRICTION }, Pose::default());
            for &(final_nm, excess_nm, time_constant_s, span_s) in &torques {
                let right = Torque { final_nm, excess_nm, time_constant_s };
                plant.advance(span_s, Wheels { right, left: Torque { final_nm: -final_nm, ..right } });
            }
            assert_finite(plant.state());
        }
    }
}

fn assert_finite(state: &State) {
    let State { angle_rad, speed_rad_s, pose } = state;
    let finite = angle_rad.all(|angle| angle.is_finite()) && speed_rad_s.all(|speed| speed.is_finite());
    assert!(finite && pose.x_m.is_finite() && pose.y_m.is_finite() && pose.heading_rad.is_finite(), "{state:?}");
}
