//! However the time is cut into steps, the plant agrees with itself at much
//! finer steps and with a simulator that works in another way.

use canloop::robot::{Model, Pose};
use canloop::wheels::Wheels;
use hil_sim::plant::{Friction, Plant, State, Torque};
use proptest::prelude::*;

use crate::oracle::Oracle;
use crate::paper::{FRICTION, MODELS, NO_FRICTION, constant, robot, seeded};

const START: Pose = Pose { x_m: 9.0, y_m: 5.0, heading_rad: 1.5 };

/// A named course of torques: each for a span.
struct Profile {
    name: &'static str,
    friction: Wheels<Friction>,
    parts: Vec<(f64, Wheels<Torque>)>,
}

#[test]
fn any_step_gives_the_motion_that_fine_steps_give() {
    for model in MODELS {
        for profile in profiles() {
            let fine = run(plant(model, &profile).with_finer_steps(10.0), &profile, 1e-3);
            for step_s in [10e-6, 1e-3, 5e-3, 1.0] {
                let state = run(plant(model, &profile), &profile, step_s);
                let error = error(&state, &fine);
                assert!(
                    error < 5e-7,
                    "{}, {model:?}, {step_s} s: off by {error:.1e}\n{state:?}\n{fine:?}",
                    profile.name
                );
            }
        }
    }
}

#[test]
fn another_simulator_gives_the_same_motion() {
    for model in MODELS {
        for profile in profiles() {
            let mut oracle = Oracle::new(robot(model), profile.friction, START);
            for &(span_s, torque) in &profile.parts {
                oracle.advance(span_s, torque);
            }
            let state = run(plant(model, &profile), &profile, 1e-3);
            let error = error(&state, &oracle.state());
            let name = profile.name;
            assert!(error < 3e-5, "{name}, {model:?}: off by {error:.1e}\n{state:?}\n{:?}", oracle.state());
        }
    }
}

proptest! {
    #![proptest_config(seeded(40))]

    #[test]
    fn any_step_will_do_for_any_course_of_torques(friction in any_friction(), parts in any_parts()) {
        let friction = Wheels { right: friction, left: FRICTION };
        check_steps(&Profile { name: "random", friction, parts })?;
    }
}

proptest! {
    #![proptest_config(seeded(600))]

    #[test]
    fn any_step_will_do_under_coulomb_friction(right_nm in 0.0..20.0, left_nm in 0.0..20.0, parts in any_parts()) {
        let friction = Wheels { right: coulomb(right_nm), left: coulomb(left_nm) };
        check_steps(&Profile { name: "random", friction, parts })?;
    }
}

#[test]
fn a_second_at_once_is_a_thousand_milliseconds() {
    for model in MODELS {
        for (right_nm, left_nm) in [(90.0, 70.0), (61.0, 0.0), (5.0, 75.0), (-64.0, 66.0)] {
            let torque = constant(right_nm, left_nm);
            let new = || Plant::new(robot(model), Wheels::both(FRICTION), START);
            let (mut once, mut often) = (new(), new());
            once.advance(1.0, torque);
            for _ in 0..1000 {
                often.advance(1e-3, torque);
            }
            let error = error(once.state(), often.state());
            assert!(error < 5e-9, "{right_nm} and {left_nm} N m, {model:?}: off by {error:.1e}");
        }
    }
}

#[test]
fn a_constant_turn_ends_where_the_circle_says() {
    let mut plant = Plant::new(robot(Model::Paper), Wheels::both(NO_FRICTION), Pose::default());
    let speed = Wheels { right: 3.0, left: 1.0 };
    plant.set_speed(speed);
    plant.advance(20.0, constant(0.0, 0.0));
    let twist = robot(Model::Paper).twist(speed);
    let heading_rad = twist.yaw_rate_rad_s * 20.0;
    let radius_m = twist.speed_m_s / twist.yaw_rate_rad_s;
    let expected =
        Pose { x_m: radius_m * libm::sin(heading_rad), y_m: radius_m * (1.0 - libm::cos(heading_rad)), heading_rad };
    let pose = plant.state().pose;
    assert!(pose.distance_m(&expected) < 1e-9, "{pose:?} instead of {expected:?}");
    assert!((pose.heading_rad - heading_rad).abs() < 1e-12);
}

fn profiles() -> Vec<Profile> {
    let paper = Wheels::both(FRICTION);
    let lag = |final_nm: f64, excess_nm: f64, time_constant_s: f64| Torque { final_nm, excess_nm, time_constant_s };
    let profile = |name, friction, parts| Profile { name, friction, parts };
    vec![
        profile("both break loose and drive", paper, vec![(0.02, constant(65.0, 63.0)), (0.05, constant(7.0, 5.0))]),
        profile("brake to rest and stay", paper, vec![(0.02, constant(80.0, 80.0)), (0.1, constant(-10.0, -30.0))]),
        profile("reverse through zero", paper, vec![(0.02, constant(90.0, 85.0)), (0.05, constant(-95.0, -85.0))]),
        profile(
            "stop, stick, start again",
            paper,
            vec![(0.01, constant(70.0, -70.0)), (0.03, constant(0.0, 0.0)), (0.0123, constant(-61.0, 59.0))],
        ),
        profile("one wheel drags the other loose", paper, vec![(0.05, constant(90.0, -58.0))]),
        profile(
            "one wheel drags the other back",
            paper,
            vec![(0.01, constant(90.0, 62.0)), (0.05, constant(90.0, -54.0))],
        ),
        profile(
            "a wheel is dragged loose between two unlike lags",
            Wheels { right: Friction { static_nm: 14.0, ..FRICTION }, left: coulomb(13.0) },
            vec![
                (0.05, constant(0.0, -70.0)),
                (0.005, Wheels { right: lag(14.5, -8.0, 1e-4), left: lag(80.0, -90.0, 1e-2) }),
            ],
        ),
        profile("breaks loose by a hair", paper, vec![(0.02, constant(60.01, 60.02))]),
        profile(
            "a lagging torque breaks loose late",
            paper,
            vec![
                (0.01, Wheels { right: lag(70.0, -70.0, 1e-3), left: lag(65.0, -65.0, 4e-3) }),
                (0.02, Wheels { right: lag(6.0, 64.0, 1e-3), left: lag(-20.0, 80.0, 1e-3) }),
            ],
        ),
        profile(
            "a lagging torque reverses",
            paper,
            vec![
                (0.005, constant(70.0, 75.0)),
                (0.03, Wheels { right: lag(-80.0, 150.0, 2e-3), left: lag(80.0, -155.0, 2e-3) }),
            ],
        ),
        profile(
            "no friction",
            Wheels::both(NO_FRICTION),
            vec![(0.05, constant(20.0, -5.0)), (0.05, constant(-50.0, 30.0))],
        ),
        profile(
            "viscous friction alone",
            Wheels::both(Friction { viscous_nm_s_per_rad: 5.0, ..NO_FRICTION }),
            vec![
                (0.05, constant(20.0, -5.0)),
                (0.05, Wheels { right: lag(-30.0, 60.0, 1e-3), left: lag(10.0, 5.0, 1e-3) }),
            ],
        ),
        profile(
            "Coulomb friction alone",
            Wheels::both(coulomb(6.0)),
            vec![
                (0.03, constant(20.0, 9.0)),
                (0.04, Wheels { right: lag(-15.0, 25.0, 2e-3), left: lag(20.0, -80.0, 1e-3) }),
            ],
        ),
        profile(
            "a gentle Stribeck curve",
            Wheels::both(Friction { stribeck_s_per_rad: 2.0, ..FRICTION }),
            vec![(0.05, constant(70.0, 65.0)), (0.1, constant(0.0, -70.0))],
        ),
        profile(
            "wheels unlike each other, static friction below Coulomb's",
            Wheels { right: FRICTION, left: Friction { static_nm: 4.0, coulomb_nm: 9.0, ..FRICTION } },
            vec![(0.02, constant(62.0, 8.0)), (0.03, constant(-20.0, 8.5))],
        ),
    ]
}

fn check_steps(profile: &Profile) -> Result<(), TestCaseError> {
    for model in MODELS {
        let fine = run(plant(model, profile).with_finer_steps(10.0), profile, 1e-3);
        for step_s in [1e-3, 5e-3, 1.0] {
            let state = run(plant(model, profile), profile, step_s);
            let error = error(&state, &fine);
            prop_assert!(error < 1e-5, "{:?}, {} s: off by {:.1e}", model, step_s, error);
        }
    }
    Ok(())
}

fn coulomb(nm: f64) -> Friction {
    Friction { static_nm: nm, coulomb_nm: nm, ..NO_FRICTION }
}

/// None, Coulomb's, or with a gentle or a steep Stribeck curve.
fn any_friction() -> impl Strategy<Value = Friction> {
    (0.0..3.0, 0.0..60.0, 0.0..20.0, 5.0..2000.0, 0..4).prop_map(
        |(viscous_nm_s_per_rad, static_nm, coulomb_nm, stribeck_s_per_rad, kind)| match kind {
            0 => NO_FRICTION,
            1 => coulomb(coulomb_nm),
            _ => Friction { viscous_nm_s_per_rad, static_nm, coulomb_nm, stribeck_s_per_rad },
        },
    )
}

fn any_parts() -> impl Strategy<Value = Vec<(f64, Wheels<Torque>)>> {
    let part = (0.5e-3..0.03, any_torque(), any_torque());
    prop::collection::vec(part.prop_map(|(span_s, right, left)| (span_s, Wheels { right, left })), 1..6)
}

fn any_torque() -> impl Strategy<Value = Torque> {
    let time_constant_s = prop::sample::select(vec![1e-4, 1e-3, 3e-3, 1e-2]);
    (-100.0..100.0, -150.0..150.0, time_constant_s, any::<bool>()).prop_map(
        |(final_nm, excess_nm, time_constant_s, lags)| {
            if lags { Torque { final_nm, excess_nm, time_constant_s } } else { Torque::constant(final_nm) }
        },
    )
}

fn plant(model: Model, profile: &Profile) -> Plant {
    Plant::new(robot(model), profile.friction, START)
}

/// Runs a profile, each part cut into steps of `step_s`.
fn run(mut plant: Plant, profile: &Profile, step_s: f64) -> State {
    for &(span_s, torque) in &profile.parts {
        let mut torque = torque;
        let mut left_s = span_s;
        while left_s > 0.0 {
            let now_s = if left_s < step_s * 1.000_001 { left_s } else { step_s };
            plant.advance(now_s, torque);
            torque = torque.map(|torque| torque.after(now_s));
            left_s -= now_s;
        }
    }
    *plant.state()
}

/// The largest difference, relative to what is compared where that is large.
fn error(state: &State, expected: &State) -> f64 {
    let numbers = |state: &State| {
        let State { angle_rad, speed_rad_s, pose } = *state;
        [
            angle_rad.right,
            angle_rad.left,
            speed_rad_s.right,
            speed_rad_s.left,
            pose.x_m - START.x_m,
            pose.y_m - START.y_m,
            pose.heading_rad - START.heading_rad,
        ]
    };
    let pairs = numbers(state).into_iter().zip(numbers(expected));
    pairs.map(|(got, expected)| (got - expected).abs() / expected.abs().max(0.1)).fold(0.0, f64::max)
}
