//! A table of torques goes in, a table of states comes out; a bad table is
//! refused with the place and the reason.
#![allow(missing_docs, reason = "tests have no readers of their documentation")]

use canloop::config::Source;
use canloop::robot::{Load, Model, Pose, Robot};
use canloop::wheels::Wheels;
use hil_sim::plant::{Friction, Plant, Torque};
use hil_sim::torque_csv::{TorqueRow, parse, read, run_open_loop};

const HEADER: &str = "t_s,torque_right_nm,torque_left_nm\n";

#[test]
fn rows_are_read_with_spaces_and_windows_line_ends() {
    let rows = vec![row(0.0, 1.5, -2.0), row(0.25, 3e1, 0.0)];
    for text in [
        "t_s,torque_right_nm,torque_left_nm\n0,1.5,-2\n0.25,3e1,0\n",
        "t_s,torque_right_nm,torque_left_nm\n0,1.5,-2\n0.25,3e1,0",
        "t_s, torque_right_nm ,torque_left_nm\r\n 0, 1.5,\t-2 \r\n0.25,3e1,0\r\n",
        "t_s,torque_right_nm,torque_left_nm\n0,1.5,-2\n0.25,3e1,0\n\n \r\n",
    ] {
        assert_eq!(parsed(text).expect(text), rows);
    }
}

#[test]
fn a_file_is_read_and_named_in_problems() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let path = folder.path().join("in.csv");
    std::fs::write(&path, format!("{HEADER}0,1,x\n")).expect("the test's file");
    let problem = read(&path).expect_err("x is no number");
    assert_eq!(problem.position(), Some(format!("{}:2:5", path.display())));
    std::fs::write(&path, format!("\u{feff}{HEADER}0,1,2\n")).expect("the test's file");
    assert_eq!(read(&path).expect("a byte order mark does no harm"), [row(0.0, 1.0, 2.0)]);
    let missing = read(&folder.path().join("none.csv")).expect_err("there is no such file");
    assert!(missing.title.starts_with("cannot read ") && missing.title.contains("none.csv"), "{missing}");
    std::fs::write(&path, [0xff, 0xfe, 0x00]).expect("the test's file");
    assert!(read(&path).expect_err("not text").title.contains("UTF-8"));
}

#[test]
fn an_empty_file_lacks_its_header() {
    refused("", "1:1", "not the header of a torque table", "found nothing, expected `t_s`");
}

#[test]
fn a_header_that_differs_is_refused_where_it_differs() {
    let title = "not the header of a torque table";
    refused("t_s,left_nm,right_nm\n0,0,0\n", "1:5", title, "found `left_nm`, expected `torque_right_nm`");
    refused("T_S,torque_right_nm,torque_left_nm\n", "1:1", title, "found `T_S`, expected `t_s`");
    refused("t_s,torque_right_nm\n", "1:20", title, "found nothing, expected `torque_left_nm`");
    let extra = "t_s,torque_right_nm,torque_left_nm,note\n";
    refused(extra, "1:36", title, "found `note`, expected nothing");
    refused("0,1,2\n", "1:1", title, "found `0`, expected `t_s`");
}

#[test]
fn a_table_without_rows_is_refused() {
    refused(HEADER, "2:1", "no torques", "found no row, expected at least one below the header");
}

#[test]
fn a_missing_field_is_refused() {
    refused_row("0,1", "2:4", "a field is missing", "found 2 of 3 fields, expected `torque_left_nm` here");
}

#[test]
fn an_empty_field_is_refused() {
    let label = "found nothing, expected a finite number for `torque_right_nm`";
    refused_row("0,,2", "2:3", "a field is empty", label);
    refused_row("0,  ,2", "2:5", "a field is empty", label);
}

#[test]
fn a_field_too_many_is_refused() {
    refused_row("0,1,2,3", "2:7", "more fields than columns", "found 4 fields, expected 3");
}

#[test]
fn a_blank_line_in_the_middle_is_refused() {
    let label = "found nothing, expected three numbers";
    refused_row("0,1,2\n\n1,1,2\n", "3:1", "a blank line in the table", label);
    refused_row("\n0,1,2\n", "2:1", "a blank line in the table", label);
}

#[test]
fn text_is_refused() {
    refused_row("0, one,2", "2:4", "not a number", "found `one`, expected a finite number for `torque_right_nm`");
    refused_row("0,1,2 Nm", "2:5", "not a number", "found `2 Nm`, expected a finite number for `torque_left_nm`");
    refused_row("0,1,µ", "2:5", "not a number", "found `µ`, expected a finite number for `torque_left_nm`");
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    for text in ["nan", "NaN", "inf", "-inf", "infinity", "1e999"] {
        let label = format!("found `{text}`, expected a finite number for `torque_left_nm`");
        refused_row(&format!("0,1,{text}"), "2:5", "not a finite number", &label);
    }
}

#[test]
fn numbers_beyond_every_motor_and_every_run_are_refused() {
    let title = "a number out of range";
    refused_row(
        "0,1e7,2",
        "2:3",
        title,
        "found `1e7`, expected a number from -1000000 to 1000000 for `torque_right_nm`",
    );
    refused_row(
        "0,1,2\n1e300,1,2",
        "3:1",
        title,
        "found `1e300`, expected a number from -1000000 to 1000000 for `t_s`",
    );
}

#[test]
fn time_that_does_not_increase_is_refused() {
    let title = "time does not increase";
    refused_row("0,1,2\n0.5,1,2\n0.5,1,2", "4:1", title, "found 0.5 after 0.5, expected a later time");
    refused_row("0,1,2\n -1,1,2", "3:2", title, "found -1 after 0, expected a later time");
}

#[test]
fn each_row_holds_until_the_next_and_the_state_at_each_comes_out() {
    let rows = [row(2.0, 70.0, 65.0), row(2.01, 0.0, 80.0), row(2.5, 1e9, 1e9)];
    let mut out = Vec::new();
    run_open_loop(plant(), &rows, &mut out).expect("writing to memory");
    let text = String::from_utf8(out).expect("the table is text");
    let mut expected = plant();
    let torque = |row: TorqueRow| row.torque_nm.map(Torque::constant);
    let mut lines = text.lines();
    let header = "t_s,x_m,y_m,heading_rad,theta_right_rad,theta_left_rad,omega_right_rad_s,omega_left_rad_s";
    assert_eq!(lines.next(), Some(header));
    assert_eq!(lines.next(), Some("2,9,5,1.5,0,0,0,0"));
    for (before, now) in [(rows[0], rows[1]), (rows[1], rows[2])] {
        expected.advance(now.t_s - before.t_s, torque(before));
        let state = *expected.state();
        let numbers: Vec<f64> =
            lines.next().expect("a line a row").split(',').map(|number| number.parse().expect("a number")).collect();
        let Wheels { right: theta_right, left: theta_left } = state.angle_rad;
        let Wheels { right: omega_right, left: omega_left } = state.speed_rad_s;
        let Pose { x_m, y_m, heading_rad } = state.pose;
        assert_eq!(numbers, [now.t_s, x_m, y_m, heading_rad, theta_right, theta_left, omega_right, omega_left]);
    }
    assert_eq!(lines.next(), None);
}

fn row(t_s: f64, right: f64, left: f64) -> TorqueRow {
    TorqueRow { t_s, torque_nm: Wheels { right, left } }
}

fn parsed(text: &str) -> Result<Vec<TorqueRow>, canloop::config::Problem> {
    parse(&Source::new("in.csv", text))
}

/// A table whose rows are `rows` is refused there, for that reason.
#[track_caller]
fn refused_row(rows: &str, place: &str, title: &str, label: &str) {
    refused(&format!("{HEADER}{rows}"), place, title, label);
}

#[track_caller]
fn refused(text: &str, place: &str, title: &str, label: &str) {
    let problem = parsed(text).expect_err("the table is bad");
    assert_eq!(problem.position(), Some(format!("in.csv:{place}")), "{problem}");
    assert_eq!((problem.title.as_str(), problem.label.as_str()), (title, label));
    assert!(problem.help.is_some());
}

fn plant() -> Plant {
    let robot = Robot {
        model: Model::RigidBody,
        mass_kg: 46.5,
        inertia_kg_m2: 1.3133,
        half_track_m: 0.27,
        wheel_radius_m: 0.122,
        wheel_inertia_kg_m2: 0.0144,
        motor_inertia_kg_m2: 0.0125,
        gear_ratio: 3.0,
        load: Load { mass_kg: 80.0, cog_distance_m: 0.2, cog_angle_rad: 2.0 * std::f64::consts::FRAC_PI_3 },
    };
    let friction = Friction { viscous_nm_s_per_rad: 0.2, static_nm: 60.0, coulomb_nm: 6.0, stribeck_s_per_rad: 500.0 };
    Plant::new(robot, Wheels::both(friction), Pose { x_m: 9.0, y_m: 5.0, heading_rad: 1.5 })
}
