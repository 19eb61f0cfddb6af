//! A stack that does not take the torque away when it trips is found out: by a
//! campaign, and by the scenarios that expect it.

mod rig;

use rig::Rig;

#[test]
fn a_campaign_finds_torque_after_a_trip_and_says_how_to_see_it_again() {
    let rig = Rig::new();
    let plan = "name = \"small\"\nscenarios = [\"guarded\"]\nset = [\"path.duration_s=40\"]\n\
        duration_s = 6\nmoments_s = [4.0]\n\
        [[fault]]\nkind = \"drive-fault\"\nfault = \"over_current\"\nwheel = [\"left\", \"right\"]\n\
        [[fault]]\nkind = \"drop\"\nmessage = \"RightFeedback\"\n";
    rig.write("small.toml", plan);
    let run = rig.hil_sim(&["campaign", "small.toml"]).expect_status(1);
    let violations = run.stdout.matches("violated: ").count();
    assert_eq!(violations, 3, "each of them trips, and in none may torque be sent afterwards: {}", run.stdout);
    assert!(run.stdout.contains("torque was sent after a trip"), "{}", run.stdout);
    assert!(run.stdout.contains("hil-sim run guarded "), "{}", run.stdout);
}

#[test]
fn a_scenario_that_expects_no_torque_to_be_sent_after_a_trip_fails() {
    let rig = Rig::new();
    let text = "base = \"heartbeat-stops\"\nname = \"strict\"\n[[expect]]\nafter = \"tripped\"\nfrom_s = 0.01\n\
        signal = [\"torque_sent_right_nm\", \"torque_sent_left_nm\"]\nmin = 0.0\nmax = 0.0\n";
    rig.write("strict.toml", text);
    let run = rig.hil_sim(&["run", "strict.toml", "--no-log", "--no-report"]).expect_status(1);
    assert!(run.stdout.contains("torque_sent_right_nm = 0 from 0.01 s after `tripped` on: FAILED"), "{}", run.stdout);
}
