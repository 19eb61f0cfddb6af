//! A mirror image of the robot makes the mirror image of the motion.

use canloop::robot::{Pose, Robot};
use canloop::wheels::Wheels;
use hil_sim::plant::{Friction, Plant, Torque};
use proptest::prelude::*;

use crate::paper::{FRICTION, MODELS, robot, seeded};

proptest! {
    #![proptest_config(seeded(32))]

    #[test]
    fn mirrored_torques_move_the_mirrored_robot_along_the_mirrored_way(
        cog_angle_rad in 0.0..6.3,
        other_static_nm in 6.0..60.0,
        torques in prop::collection::vec((-90.0..90.0, -90.0..90.0, -40.0..40.0), 1..12),
    ) {
        let other = Friction { static_nm: other_static_nm, ..FRICTION };
        for model in MODELS {
            let robot = with_cog(robot(model), cog_angle_rad);
            let mirrored = with_cog(robot, std::f64::consts::PI - cog_angle_rad);
            let start = Pose { x_m: 1.0, y_m: 2.0, heading_rad: 0.5 };
            let mirrored_start = Pose { x_m: 1.0, y_m: -2.0, heading_rad: -0.5 };
            let mut one = Plant::new(robot, Wheels { right: FRICTION, left: other }, start);
            let mut two = Plant::new(mirrored, Wheels { right: other, left: FRICTION }, mirrored_start);
            for &(right_nm, left_nm, excess_nm) in &torques {
                let right = Torque { final_nm: right_nm, excess_nm, time_constant_s: 1e-3 };
                let left = Torque::constant(left_nm);
                one.advance(5e-3, Wheels { right, left });
                two.advance(5e-3, Wheels { right: left, left: right });
            }
            let (one, two) = (one.state(), two.state());
            let close = |a: f64, b: f64| (a - b).abs() < 1e-8;
            let wheels = |a: Wheels<f64>, b: Wheels<f64>| close(a.right, b.left) && close(a.left, b.right);
            prop_assert!(wheels(one.angle_rad, two.angle_rad), "{:?}\n{:?}", one, two);
            prop_assert!(wheels(one.speed_rad_s, two.speed_rad_s), "{:?}\n{:?}", one, two);
            prop_assert!(close(one.pose.x_m, two.pose.x_m) && close(one.pose.y_m, -two.pose.y_m));
            prop_assert!(close(one.pose.heading_rad, -two.pose.heading_rad));
        }
    }
}

fn with_cog(mut robot: Robot, angle_rad: f64) -> Robot {
    robot.load.cog_angle_rad = angle_rad;
    robot
}
