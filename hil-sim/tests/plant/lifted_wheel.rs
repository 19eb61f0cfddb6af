//! A wheel that is off the floor turns by itself; the robot rolls on over the
//! other one.

use canloop::robot::{Model, Pose, Robot};
use canloop::wheels::{Wheel, Wheels};
use hil_sim::plant::{Friction, Plant};
use proptest::prelude::*;

use crate::paper::{MODELS, NO_FRICTION, constant, robot, seeded};

const RIGHT: Wheels<bool> = Wheels { right: true, left: false };
const NEITHER: Wheels<bool> = Wheels { right: false, left: false };
const BOTH: Wheels<bool> = Wheels { right: true, left: true };

fn plant(robot: Robot, friction: Friction, speed_rad_s: Wheels<f64>) -> Plant {
    let mut plant = Plant::new(robot, Wheels::both(friction), Pose::default());
    plant.set_speed(speed_rad_s);
    plant
}

/// Kinetic energy of a robot of which one side rolls at another speed than its
/// wheel turns, J.
fn energy_j(robot: &Robot, wheels_rad_s: Wheels<f64>, sides_rad_s: Wheels<f64>) -> f64 {
    let turning = robot.turning_inertia_kg_m2();
    let of_matrix = robot.mass_matrix().times(sides_rad_s);
    let whole = of_matrix.right * sides_rad_s.right + of_matrix.left * sides_rad_s.left;
    let wheel = |wheel: Wheel| {
        let (own, side) = (wheels_rad_s[wheel], sides_rad_s[wheel]);
        turning * (own * own - side * side)
    };
    0.5 * (whole + wheel(Wheel::Right) + wheel(Wheel::Left))
}

#[test]
fn in_the_air_torque_accelerates_a_wheel_by_its_own_inertia() {
    for model in MODELS {
        let robot = robot(model);
        let mut plant = plant(robot, NO_FRICTION, Wheels::default());
        plant.lift(RIGHT);
        plant.advance(0.5, constant(2.0, 0.0));
        let expected_rad_s = 2.0 * 0.5 / robot.turning_inertia_kg_m2();
        let state = plant.state();
        assert!((state.speed_rad_s.right / expected_rad_s - 1.0).abs() < 1e-9, "{state:?}");
        assert!((state.angle_rad.right / (0.25 * expected_rad_s) - 1.0).abs() < 1e-9, "{state:?}");
        assert_eq!((state.speed_rad_s.left, state.pose), (0.0, Pose::default()), "nothing reaches the robot");
    }
}

#[test]
fn in_the_air_a_wheel_comes_to_rest_in_its_own_bearing_and_sticks() {
    let robot = robot(Model::RigidBody);
    let friction = Friction { viscous_nm_s_per_rad: 0.0, static_nm: 3.0, coulomb_nm: 2.0, stribeck_s_per_rad: 100.0 };
    let mut plant = plant(robot, friction, Wheels { right: 5.0, left: 0.0 });
    plant.lift(RIGHT);
    let stops_after_s = 5.0 * robot.turning_inertia_kg_m2() / 2.0;
    plant.advance(0.9 * stops_after_s, constant(0.0, 0.0));
    assert!(plant.state().speed_rad_s.right > 0.0);
    plant.advance(0.2 * stops_after_s, constant(0.0, 0.0));
    assert_eq!(plant.state().speed_rad_s.right, 0.0);
    assert!(plant.is_stuck().right);
    plant.advance(1.0, constant(2.9, 0.0));
    assert_eq!(plant.state().speed_rad_s.right, 0.0);
    plant.advance(1.0, constant(3.1, 0.0));
    assert!(plant.state().speed_rad_s.right > 0.0);
}

#[test]
fn without_friction_and_torque_a_lifted_wheel_changes_nothing() {
    // Without velocity terms both go on as they are.
    let speed = Wheels { right: 2.0, left: 1.0 };
    let mut on_floor = plant(robot(Model::Paper), NO_FRICTION, speed);
    let mut lifted = on_floor.clone();
    lifted.lift(RIGHT);
    on_floor.advance(3.0, constant(0.0, 0.0));
    lifted.advance(3.0, constant(0.0, 0.0));
    let (here, there) = (on_floor.state(), lifted.state());
    assert!(here.pose.distance_m(&there.pose) < 1e-9, "{here:?} {there:?}");
    assert!((here.angle_rad.right - there.angle_rad.right).abs() < 1e-9);
}

#[test]
fn with_both_wheels_in_the_air_the_robot_stands() {
    let mut plant = plant(robot(Model::RigidBody), NO_FRICTION, Wheels::both(3.0));
    plant.lift(BOTH);
    let pose = plant.state().pose;
    plant.push(100.0, 10.0);
    plant.advance(1.0, constant(1.0, -1.0));
    assert_eq!(plant.state().pose, pose);
    assert!(plant.state().speed_rad_s.right > 3.0 && plant.state().speed_rad_s.left < 3.0);
}

proptest! {
    #![proptest_config(seeded(64))]

    #[test]
    fn lifting_and_landing_never_gains_energy_nor_moves_anything(
        speed in (-10.0..10.0, -10.0..10.0),
        torque in (-5.0..5.0, -5.0..5.0),
        cog_angle_rad in 0.0..6.3,
        lifted in prop::sample::select(vec![RIGHT, Wheels { right: false, left: true }]),
    ) {
        for model in MODELS {
            let mut robot = robot(model);
            robot.load.cog_angle_rad = cog_angle_rad;
            let start = Wheels { right: speed.0, left: speed.1 };
            let mut plant = plant(robot, NO_FRICTION, start);
            plant.lift(lifted);
            prop_assert_eq!(plant.state().speed_rad_s, start);
            plant.advance(0.3, constant(torque.0, torque.1));
            let (before, sides) = (*plant.state(), sides_rad_s(&mut plant.clone(), &robot));
            let before_j = energy_j(&robot, before.speed_rad_s, sides);
            plant.lift(NEITHER);
            let after = *plant.state();
            prop_assert_eq!(after.pose, before.pose);
            for wheel in Wheel::BOTH {
                prop_assert!((after.angle_rad[wheel] - before.angle_rad[wheel]).abs() < 1e-9);
            }
            let after_j = energy_j(&robot, after.speed_rad_s, after.speed_rad_s);
            prop_assert!(after_j <= before_j * (1.0 + 1e-9), "{:?}: from {} to {} J", model, before_j, after_j);
        }
    }
}

/// How fast each side of the robot rolls, from its motion over the floor.
fn sides_rad_s(plant: &mut Plant, robot: &Robot) -> Wheels<f64> {
    const SPAN_S: f64 = 1e-6;
    let before = plant.state().pose;
    plant.advance(SPAN_S, constant(0.0, 0.0));
    let after = plant.state().pose;
    let (sin, cos) = libm::sincos(before.heading_rad);
    let ahead_m = (after.x_m - before.x_m) * cos + (after.y_m - before.y_m) * sin;
    robot.wheels(ahead_m / SPAN_S, (after.heading_rad - before.heading_rad) / SPAN_S)
}
