//! Without torque the robot gains no energy; without friction it loses none.

use canloop::robot::{Model, Pose, Robot};
use canloop::wheels::Wheels;
use hil_sim::plant::{Friction, Plant};
use proptest::prelude::*;

use crate::paper::{MODELS, NO_FRICTION, constant, robot, seeded};

proptest! {
    #![proptest_config(seeded(48))]

    #[test]
    fn energy_never_grows_without_torque(
        friction in (any_friction(), any_friction()),
        speed in (-20.0..20.0, -20.0..20.0),
        cog_angle_rad in 0.0..6.3,
        step_s in prop::sample::select(vec![1e-4, 1e-3, 5e-3, 0.1]),
    ) {
        for model in MODELS {
            let mut robot = robot(model);
            robot.load.cog_angle_rad = cog_angle_rad;
            let mut plant = Plant::new(robot, Wheels { right: friction.0, left: friction.1 }, Pose::default());
            plant.set_speed(Wheels { right: speed.0, left: speed.1 });
            let mut before_j = energy_j(&robot, &plant);
            for _ in 0..100 {
                plant.advance(step_s, constant(0.0, 0.0));
                let now_j = energy_j(&robot, &plant);
                prop_assert!(now_j <= before_j * (1.0 + 1e-10), "{:?}: from {} to {} J", model, before_j, now_j);
                before_j = now_j;
            }
        }
    }
}

#[test]
fn a_rigid_body_without_friction_keeps_its_energy_and_trades_it_between_the_wheels() {
    let robot = robot(Model::RigidBody);
    let mut plant = Plant::new(robot, Wheels::both(NO_FRICTION), Pose::default());
    plant.set_speed(Wheels { right: 2.0, left: -1.0 });
    let before_j = energy_j(&robot, &plant);
    plant.advance(20.0, constant(0.0, 0.0));
    assert!((energy_j(&robot, &plant) / before_j - 1.0).abs() < 1e-9);
    assert!((plant.state().speed_rad_s.right - 2.0).abs() > 0.1, "{:?}", plant.state());
}

#[test]
fn in_the_paper_s_model_nothing_changes_the_speeds_without_friction() {
    let mut plant = Plant::new(robot(Model::Paper), Wheels::both(NO_FRICTION), Pose::default());
    let speed = Wheels { right: 2.0, left: -1.0 };
    plant.set_speed(speed);
    plant.advance(20.0, constant(0.0, 0.0));
    assert_eq!(plant.state().speed_rad_s, speed);
}

fn any_friction() -> impl Strategy<Value = Friction> {
    let number = |most: f64| prop_oneof![Just(0.0), 0.0..most];
    (number(2.0), number(60.0), number(20.0), number(1000.0)).prop_map(
        |(viscous_nm_s_per_rad, static_nm, coulomb_nm, stribeck_s_per_rad)| Friction {
            viscous_nm_s_per_rad,
            static_nm,
            coulomb_nm,
            stribeck_s_per_rad,
        },
    )
}

fn energy_j(robot: &Robot, plant: &Plant) -> f64 {
    let speed = plant.state().speed_rad_s;
    let momentum = robot.mass_matrix().times(speed);
    0.5 * (speed.right * momentum.right + speed.left * momentum.left)
}
