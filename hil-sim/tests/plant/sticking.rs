//! A wheel sticks for good, lets go at the threshold, and stops when it stops.

use canloop::robot::{Model, Pose};
use canloop::wheels::Wheels;
use hil_sim::plant::{Friction, Plant, State, Torque};
use proptest::prelude::*;

use crate::paper::{FRICTION, MODELS, NO_FRICTION, constant, plant, robot, seeded};

proptest! {
    #![proptest_config(seeded(64))]

    #[test]
    fn a_stuck_robot_does_not_creep_in_an_hour(
        right_nm in -60.0..60.0, left_nm in -60.0..60.0, share in -1.0..1.0, time_constant_s in 1e-4..10.0,
    ) {
        let mut plant = plant(Model::Paper);
        let start = *plant.state();
        // A torque that goes from a share of it to all of it stays below the threshold too.
        let lag = |nm: f64| Torque { final_nm: nm, excess_nm: nm * (share - 1.0), time_constant_s };
        plant.advance(1800.0, Wheels { right: lag(right_nm), left: lag(left_nm) });
        for _ in 0..1800 {
            plant.advance(1.0, constant(right_nm, left_nm));
        }
        prop_assert_eq!(*plant.state(), start);
        prop_assert_eq!(plant.is_stuck(), Wheels::both(true));
    }
}

#[test]
fn static_friction_holds_just_below_its_limit_and_lets_go_just_above() {
    for model in MODELS {
        for sign in [1.0, -1.0] {
            let mut holding = plant(model);
            holding.advance(1.0, constant(sign * 59.99, sign * -59.99));
            assert_eq!(*holding.state(), State::default());
            let mut right = plant(model);
            right.advance(0.1, constant(sign * 60.01, 0.0));
            assert!(sign * right.state().speed_rad_s.right > 1.0);
            assert_eq!(right.state().angle_rad.left, 0.0);
            let mut left = plant(model);
            left.advance(0.1, constant(0.0, sign * 60.01));
            assert!(sign * left.state().speed_rad_s.left > 1.0);
            assert_eq!(left.state().angle_rad.right, 0.0);
        }
    }
}

#[test]
fn a_wheel_at_its_very_limit_stays() {
    let mut plant = plant(Model::Paper);
    plant.advance(10.0, constant(60.0, -60.0));
    assert_eq!(*plant.state(), State::default());
}

#[test]
fn a_wheel_that_would_hold_alone_is_dragged_loose_by_the_other() {
    for model in MODELS {
        let mut alone = plant(model);
        alone.advance(0.1, constant(0.0, -58.0));
        assert_eq!(alone.is_stuck(), Wheels::both(true));
        let mut dragged = plant(model);
        dragged.advance(0.1, constant(90.0, -58.0));
        assert!(dragged.state().speed_rad_s.left < -1.0, "{:?}", dragged.state());
    }
}

#[test]
fn a_wheel_that_holds_against_the_other_does_not_accelerate() {
    let mut plant = plant(Model::RigidBody);
    let torque_nm = Wheels { right: 90.0, left: -20.0 };
    plant.advance(0.01, torque_nm.map(Torque::constant));
    assert_eq!(plant.is_stuck(), Wheels { right: false, left: true });
    let acceleration = plant.acceleration(torque_nm);
    assert_eq!((acceleration.left, plant.state().angle_rad.left), (0.0, 0.0));
    let speed = plant.state().speed_rad_s.right;
    let m11 = robot(Model::RigidBody).mass_matrix().m11;
    let expected = (90.0 - 6.0 - 0.2 * speed) / m11;
    assert!((acceleration.right - expected).abs() < 1e-9 * expected);
}

#[test]
fn a_lagging_torque_breaks_a_wheel_loose_at_the_instant_it_passes_the_limit() {
    let (final_nm, time_constant_s) = (70.0, 1e-3);
    let rising = Torque { final_nm, excess_nm: -final_nm, time_constant_s };
    let instant_s = time_constant_s * libm::log(70.0 / 10.0);
    let angle_at = |t_s: f64| {
        let mut plant = plant(Model::Paper);
        plant.advance(t_s, Wheels { right: rising, left: Torque::default() });
        plant.state().angle_rad.right
    };
    assert_eq!(angle_at(instant_s - 1e-12), 0.0);
    assert!(angle_at(instant_s + 1e-12) >= 0.0);
    assert!(angle_at(instant_s + 1e-6) > 0.0);
}

#[test]
fn a_wheel_that_lets_go_for_an_instant_is_back_at_rest_at_once() {
    let coulomb = Friction { static_nm: 60.0, coulomb_nm: 60.0, ..NO_FRICTION };
    for friction in [coulomb, FRICTION] {
        for (above_nm, time_constant_s) in [(1e-12, 1e-3), (1e-9, 1e-3), (1e-6, 1e-5), (1e-3, 1e-6)] {
            let torque = Torque { final_nm: 50.0, excess_nm: 10.0 + above_nm, time_constant_s };
            let mut plant = Plant::new(robot(Model::RigidBody), Wheels::both(friction), Pose::default());
            plant.advance(1.0, Wheels { right: torque, left: Torque { final_nm: -50.0, ..torque } });
            assert_eq!(plant.is_stuck(), Wheels::both(true));
            assert!(plant.state().angle_rad.all(|angle| angle.abs() < 1e-9), "{above_nm} N m: {:?}", plant.state());
        }
    }
}

#[test]
fn a_braked_wheel_stops_where_its_energy_is_spent() {
    let coulomb = Friction { static_nm: 6.0, coulomb_nm: 6.0, ..NO_FRICTION };
    let m11 = robot(Model::Paper).mass_matrix().m11;
    for step_s in [1e-5, 1e-3, 5e-3, 1.0] {
        let mut plant = Plant::new(robot(Model::Paper), Wheels::both(coulomb), Pose::default());
        plant.set_speed(Wheels { right: 2.0, left: 0.0 });
        let mut t_s = 0.0;
        while t_s < 0.5 {
            plant.advance(step_s, constant(0.0, 0.0));
            t_s += step_s;
        }
        let expected = m11 * 2.0 * 2.0 / (2.0 * 6.0);
        let angle = plant.state().angle_rad;
        assert!((angle.right - expected).abs() < 1e-11, "{angle:?} instead of {expected}");
        assert_eq!(angle.left, 0.0);
        assert_eq!(plant.is_stuck(), Wheels::both(true));
    }
}

#[test]
fn a_wheel_reverses_through_zero_only_under_more_than_static_friction() {
    for (brake_nm, reverses) in [(-59.99, false), (-60.01, true)] {
        let mut plant = plant(Model::Paper);
        plant.advance(0.05, constant(70.0, 0.0));
        assert!(plant.state().speed_rad_s.right > 1.0);
        plant.advance(0.2, constant(brake_nm, 0.0));
        assert_eq!(plant.is_stuck(), Wheels { right: !reverses, left: true }, "under {brake_nm} N m");
        assert_eq!(plant.state().speed_rad_s.right < -1.0, reverses);
    }
}

#[test]
fn both_wheels_of_a_straight_run_stop_together() {
    let mut robot = robot(Model::Paper);
    robot.load.cog_angle_rad = std::f64::consts::FRAC_PI_2;
    let mut plant = Plant::new(robot, Wheels::both(FRICTION), Pose::default());
    plant.advance(0.05, constant(70.0, 70.0));
    plant.advance(1.0, constant(0.0, 0.0));
    assert_eq!(plant.is_stuck(), Wheels::both(true));
    let State { angle_rad, pose, .. } = *plant.state();
    assert!((angle_rad.right - angle_rad.left).abs() < 1e-12);
    assert!(pose.y_m.abs() < 1e-12 && pose.x_m > 0.05, "{pose:?}");
}

#[test]
fn a_wheel_without_dry_friction_is_never_stuck() {
    let mut plant = Plant::new(robot(Model::Paper), Wheels::both(NO_FRICTION), Pose::default());
    assert_eq!(plant.is_stuck(), Wheels::both(false));
    plant.advance(1.0, constant(1e-9, 0.0));
    assert!(plant.state().angle_rad.right > 0.0);
}
