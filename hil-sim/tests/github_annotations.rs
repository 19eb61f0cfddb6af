//! Where GitHub runs the program, what does not hold is annotated where it
//! stands in the scenario.

mod rig;

use rig::{Rig, finish};

const SCENARIO: &str = r#"
base = "dac-friction"
name = "mine"
duration_s = 0.5
path.duration_s = 150.0
[[expect]]
name = "100 %: still, always"
signal = "position_error_m"
max = 1e-9
[[expect]]
signal = "position_error_m"
max = 1
"#;

/// The annotations of a run with this in the environment.
fn annotations(rig: &Rig, github: Option<&str>, args: &[&str]) -> Vec<String> {
    let mut command = rig.command(&[&["run", "--no-log", "--no-report"], args].concat());
    command.env_remove("GITHUB_ACTIONS");
    github.map(|value| command.env("GITHUB_ACTIONS", value));
    let run = finish(&mut command);
    assert_eq!(run.status, Some(1), "{}", run.stderr);
    run.stdout.lines().filter(|line| line.starts_with("::")).map(str::to_owned).collect()
}

#[test]
fn what_fails_is_annotated_at_its_line_with_special_signs_escaped() {
    let rig = Rig::new();
    rig.write("a,b.toml", SCENARIO);
    let lines = annotations(&rig, Some("true"), &["a,b.toml"]);
    let [line] = &lines[..] else { panic!("{lines:?}") };
    let start =
        "::error file=a%2Cb.toml,line=6,title=mine%3A 100 %25%3A still%2C always::position_error_m <= 0.000000001";
    assert!(line.starts_with(start), "{line}");
    assert!(line.contains("too high") && line.ends_with("Reproduce: hil-sim run a,b.toml --set seed=1"), "{line}");
}

#[test]
fn an_expectation_that_stands_in_no_file_is_annotated_without_one() {
    let set = ["--set", "expect=[{signal=\"position_error_m\",max=1e-9}]", "--set", "duration_s=0.5"];
    let lines = annotations(&Rig::new(), Some("true"), &[&["dac-friction"][..], &set].concat());
    assert!(lines.len() == 1 && lines[0].starts_with("::error title=dac-friction%3A position"), "{lines:?}");
}

#[test]
fn elsewhere_nothing_is_annotated() {
    let rig = Rig::new();
    rig.write("a.toml", SCENARIO);
    assert_eq!(annotations(&rig, None, &["a.toml"]), Vec::<String>::new());
    assert_eq!(annotations(&rig, Some("false"), &["a.toml"]), Vec::<String>::new());
}
