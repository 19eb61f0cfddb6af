//! `hil-sim plant` moves the plant alone by a table of torques, for whoever
//! wants to compare it with a model of their own.

mod rig;

use rig::{Rig, Run};

const HEADER: &str = "t_s,torque_right_nm,torque_left_nm\n";
const STEPS: &str = "0,70,70\n0.25,0,0\n0.5,-70,-70\n2,0,0\n";

fn plant(rig: &Rig, rows: &str, overrides: &[&str]) -> Run {
    rig.write("in.csv", &format!("{HEADER}{rows}"));
    let mut args = vec!["plant", "dac-friction", "--torque", "in.csv", "--out", "out.csv"];
    overrides.iter().for_each(|set| args.extend(["--set", set]));
    rig.hil_sim(&args)
}

/// The rows of the answer as numbers.
#[track_caller]
fn answer(rows: &str, overrides: &[&str]) -> Vec<Vec<f64>> {
    let rig = Rig::new();
    plant(&rig, rows, overrides).expect_status(0);
    assert_eq!(rig.files(), ["in.csv", "out.csv"]);
    let text = std::fs::read_to_string(rig.path("out.csv")).expect("the answer");
    let mut lines = text.lines();
    let header = "t_s,x_m,y_m,heading_rad,theta_right_rad,theta_left_rad,omega_right_rad_s,omega_left_rad_s";
    assert_eq!(lines.next(), Some(header));
    lines.map(|line| line.split(',').map(|field| field.parse().expect("a number")).collect()).collect()
}

#[test]
fn the_state_comes_out_at_each_row_and_begins_at_rest_at_the_start() {
    let rows = answer(STEPS, &["start={x_m=1.0,y_m=2.0,heading_rad=0.5}"]);
    assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), [0.0, 0.25, 0.5, 2.0]);
    assert_eq!(rows[0], [0.0, 1.0, 2.0, 0.5, 0.0, 0.0, 0.0, 0.0]);
    assert!(rows[1][6] > 0.0 && rows[1][7] > 0.0, "70 N m break both wheels loose");
    assert!(rows[2][6] < rows[1][6], "friction brakes");
    assert!(rows[3][6] < 0.0, "and -70 N m turn it back");
}

#[test]
fn torque_below_the_static_friction_moves_nothing() {
    let rows = answer("0,59.9,-59.9\n1000,0,0\n", &[]);
    assert_eq!(rows[1][1..], rows[0][1..]);
}

#[test]
fn overrides_change_the_plant() {
    let paper = answer(STEPS, &[]);
    assert_ne!(answer(STEPS, &[r#"robot.model="rigid-body""#]), paper);
    assert_ne!(answer(STEPS, &["robot.load.mass_kg=0.0"]), paper);
    assert_eq!(answer(STEPS, &["controller.kd_per_s=4.0"]), paper, "there is no controller");
}

#[test]
fn a_bad_table_is_refused_with_its_place_and_leaves_no_answer() {
    for (rows, place, words) in [
        ("0,1,x\n", "in.csv:2:5", "found `x`, expected a finite number"),
        ("0,1,\n", "in.csv:2:5", "found nothing, expected a finite number"),
        ("0,1,2\n\n1,2,3\n", "in.csv:3:1", "expected three numbers"),
        ("0,1,2\n0,1,2\n", "in.csv:3:1", "expected a later time"),
        ("0,1,inf\n", "in.csv:2:5", "expected a finite number"),
        ("0,1,1e20\n", "in.csv:2:5", "found `1e20`, expected a number from"),
        ("", "in.csv:", "expected"),
    ] {
        let rig = Rig::new();
        let run = plant(&rig, rows, &[]).expect_status(2);
        assert!(run.stderr.contains(place) && run.stderr.contains(words), "{}", run.stderr);
        assert_eq!(rig.files(), ["in.csv"], "{rows:?}");
    }
}

#[test]
fn a_bad_scenario_or_a_missing_table_leaves_no_answer_either() {
    let rig = Rig::new();
    let run = plant(&rig, STEPS, &["robot.mass_kg=-1"]).expect_status(2);
    assert!(run.stderr.contains("--set:1:15"), "{}", run.stderr);
    let args = ["plant", "dac-friction", "--torque", "none.csv", "--out", "out.csv"];
    let run = rig.hil_sim(&args).expect_status(2);
    assert!(run.stderr.contains("cannot read none.csv"), "{}", run.stderr);
    assert_eq!(rig.files(), ["in.csv"]);
}
