//! On an ideal link, the paper's own simulation, the controllers make the
//! errors that the paper's equations make.

mod rig;

use rig::{Rig, figures, findings, number};

const NO_FRICTION: &str = "robot.friction={viscous_nm_s_per_rad=0,static_nm=0,coulomb_nm=0,stribeck_s_per_rad=0}";
const DAC: &str = r#"controller={law="dac",kd_per_s=3.0,kp_per_s2=0.6}"#;
const PI_SPEED: &str = r#"controller={law="pi-speed",kp=1.0,ki=3.0}"#;
const PI_ANGLE: &str = r#"controller={law="pi-angle",kp=1.0,ki=3.0}"#;

/// 150 s round the circle, from a start on it.
fn ideal(controller: &str, friction: bool, period: &str) -> serde_json::Value {
    let mut overrides = vec![r#"bus.link="ideal""#, "expect=[]", controller, period];
    if !friction {
        overrides.push(NO_FRICTION);
    }
    figures(&overrides)
}

#[track_caller]
fn assert_near(summary: &serde_json::Value, pointer: &str, expected: f64, tolerance: f64) {
    let found = number(summary, pointer);
    assert!((found - expected).abs() <= tolerance * expected, "{pointer} is {found}, expected {expected}");
}

#[test]
fn without_friction_dac_follows_the_path_to_a_few_micrometres() {
    let summary = ideal(DAC, false, "period_s=0.001");
    assert!(number(&summary, "/tracking/rms_m") < 1e-5);
    assert!(number(&summary, "/tracking/max_m") < 3e-6);
    assert!(number(&summary, "/tracking/final_m") < 1e-6);
    assert_near(&summary, "/torque/max_nm", 0.049, 0.02);
}

#[test]
fn with_friction_dac_follows_the_path_to_a_few_millimetres() {
    for (period, rms_m, max_m, final_m, max_nm) in
        [("period_s=0.001", 1.2e-4, 1.4e-3, 6e-5, 60.03), ("period_s=0.005", 5.6e-4, 6.8e-3, 1.2e-4, 60.15)]
    {
        let summary = ideal(DAC, true, period);
        assert_near(&summary, "/tracking/rms_m", rms_m, 0.2);
        assert_near(&summary, "/tracking/max_m", max_m, 0.2);
        assert_near(&summary, "/tracking/final_m", final_m, 0.2);
        assert_near(&summary, "/torque/max_nm", max_nm, 0.001);
    }
}

#[test]
fn without_friction_pi_on_speed_ends_three_centimetres_off() {
    let summary = ideal(PI_SPEED, false, "period_s=0.001");
    assert_near(&summary, "/tracking/rms_m", 0.0197, 0.03);
    assert_near(&summary, "/tracking/max_m", 0.0301, 0.03);
    assert_near(&summary, "/tracking/final_m", 0.0301, 0.03);
    assert_near(&summary, "/torque/max_nm", 0.100, 0.03);
}

#[test]
fn with_friction_pi_on_speed_loses_the_path_by_metres() {
    for (period, rms_m, max_m, final_m, max_nm) in
        [("period_s=0.001", 4.08, 7.79, 3.99, 62.03), ("period_s=0.005", 4.10, 7.78, 4.00, 62.06)]
    {
        let summary = ideal(PI_SPEED, true, period);
        assert_near(&summary, "/tracking/rms_m", rms_m, 0.05);
        assert_near(&summary, "/tracking/max_m", max_m, 0.03);
        assert_near(&summary, "/tracking/final_m", final_m, 0.05);
        assert_near(&summary, "/torque/max_nm", max_nm, 0.01);
    }
}

#[test]
fn pi_on_the_angle_as_printed_is_reported_to_diverge_with_finite_figures() {
    for friction in [false, true] {
        let summary = ideal(PI_ANGLE, friction, "period_s=0.001");
        assert_eq!(summary["end"], "diverged");
        let findings = findings(&summary);
        assert!(findings.contains("diverged"), "{findings}");
        assert!(findings.contains("no damping term"), "{findings}");
        for pointer in ["/tracking/rms_m", "/tracking/max_m", "/tracking/final_m", "/torque/max_nm"] {
            assert!(number(&summary, pointer).is_finite());
        }
        assert!(number(&summary, "/tracking/final_m") > 1000.0);
        assert!(number(&summary, "/simulated_s") < 150.0);
    }
}

#[test]
fn a_run_that_diverges_fails_an_expectation_it_did_not_live_to_see() {
    let rig = Rig::new();
    let run = rig.run("dac-friction", &[r#"bus.link="ideal""#, PI_ANGLE]).expect_status(1);
    assert!(run.stdout.contains("diverged"), "{}", run.stdout);
    assert_eq!(rig.summary("runs")["passed"], false);
}

#[test]
fn an_ideal_link_carries_no_frames() {
    let summary = figures(&[r#"bus.link="ideal""#, "duration_s=2.0", "path.duration_s=2.0", "expect=[]"]);
    assert_eq!(summary["link"], "ideal");
    assert_eq!(summary["bus"]["frames"], 0);
    assert_eq!(summary["ticks"], 400);
}
