//! `[[event]]` tables.

use canloop::config::{Bound, Section};
use canloop::path::Path;
use canloop::robot::{Load, Robot};
use canloop::safety::Operator;
use canloop::schema::{Dbc, FaultCode};
use canloop::wheels::Wheels;

use super::condition::Condition;
use super::contradiction;
use super::read_bus;
use super::what::{Region, What};
use super::{Planned, Start};

/// The word for each kind, and how the rest of its table is read.
const KINDS: [(&str, Read); 21] = [
    ("stop", |_, _| What::Operator(Operator::Stop)),
    ("emergency-stop", |_, _| What::Operator(Operator::EmergencyStop)),
    ("reset", |_, _| What::Operator(Operator::Reset)),
    ("enable", |_, _| What::Operator(Operator::Enable)),
    ("new-path", |event, _| What::NewPath(Path::read(&event.section("path")))),
    ("power-loss", |event, _| What::PowerLoss(wheels(event))),
    ("drive-fault", |event, _| What::DriveFault(wheels(event), event.choice("fault", &FAULTS, true))),
    ("torque-limit", |event, _| What::TorqueLimit(wheels(event), event.number("limit_nm", Bound::Within(0.0, 1e6)))),
    ("torque-sensor", |event, _| What::TorqueSensor(wheels(event), event.number("gain", Bound::Within(-10.0, 10.0)))),
    ("brown-out", |event, _| What::BrownOut(event.number("above_nm", Bound::Within(0.0, 1e6)))),
    ("clock-drift", |event, _| What::ClockDrift(event.number("drift", Bound::Within(-0.9, 9.0)))),
    ("clock-phase", |event, _| What::ClockPhase(event.number("by_s", Bound::Within(1e-6, 1e3)))),
    ("encoder-stuck", |event, _| What::EncoderStuck(wheels(event))),
    ("encoder-jump", |event, _| What::EncoderJump(wheels(event), event.number("jump_rad", Bound::Within(-1e3, 1e3)))),
    ("encoder-reversed", |event, _| What::EncoderReversed(wheels(event))),
    ("feedback-dropout", |event, _| What::FeedbackDropout(wheels(event))),
    ("wheel-lift", |event, robot| What::WheelLift(lifted(event, robot))),
    ("load", |event, robot| What::Load(load(event, robot))),
    ("friction", |event, _| What::Friction(wheels(event), factor(event), region(event))),
    ("push", |event, _| push(event)),
    ("slope", |event, _| slope(event)),
];

type Read = fn(&Section<'_>, &Robot) -> What;

#[derive(Clone, Copy)]
enum Kind {
    OfTheBus(read_bus::Read),
    Other(Read),
}

/// Faults that a drive can raise of itself.
const FAULTS: [(&str, FaultCode); 9] = [
    ("over_current", FaultCode::OverCurrent),
    ("over_temperature", FaultCode::OverTemperature),
    ("motor_over_temperature", FaultCode::MotorOverTemperature),
    ("under_voltage", FaultCode::UnderVoltage),
    ("over_voltage", FaultCode::OverVoltage),
    ("overload", FaultCode::Overload),
    ("encoder", FaultCode::Encoder),
    ("command_timeout", FaultCode::CommandTimeout),
    ("other", FaultCode::Other),
];

/// Reads all events of a scenario of so many seconds with this robot and these
/// messages. What is wrong is reported to the section's reader.
pub fn read_events(root: &Section<'_>, robot: &Robot, dbc: &Dbc, duration_s: f64) -> Vec<Planned> {
    let sections = root.sections("event");
    let planned: Vec<Planned> = sections.iter().map(|event| read_event(event, robot, dbc)).collect();
    for (nth, (section, event)) in sections.iter().zip(&planned).enumerate() {
        if let Some(label) = planned[..nth].iter().find_map(|earlier| contradiction::between(earlier, event)) {
            section.complain("at_s", &label);
        }
        // A run that somebody makes shorter than its file says goes without.
        let comes_too_late = matches!(event.start, Start::At(at_s) if at_s > duration_s);
        if comes_too_late && !section.is_overlaid_by(root, "duration_s") {
            section.complain("at_s", &format!("found a moment after the end, expected one until {duration_s} s"));
        }
    }
    planned
}

fn read_event(event: &Section<'_>, robot: &Robot, dbc: &Dbc) -> Planned {
    let of_the_bus = read_bus::KINDS.iter().map(|&(word, read)| (word, (word, Kind::OfTheBus(read))));
    let others = KINDS.iter().map(|&(word, read)| (word, (word, Kind::Other(read))));
    let words: Vec<_> = others.chain(of_the_bus).collect();
    let (word, kind) = event.choice("kind", &words, true);
    let start = read_start(event);
    let every_s = event.number_or_none("every_s", Bound::Positive);
    let lasts_s = read_span(event, &start);
    if let (Some(every_s), Some(lasts_s)) = (every_s, lasts_s)
        && lasts_s > every_s
    {
        event.complain("every_s", &format!("found {every_s}, expected at least the {lasts_s} s that it goes on"));
    }
    Planned {
        name: event.text_or_none("name").unwrap_or_else(|| word.to_owned()),
        start,
        lasts_s,
        every_s,
        what: match kind {
            Kind::Other(read) => read(event, robot),
            Kind::OfTheBus(read) => What::Bus(read(event, dbc)),
        },
    }
}

fn read_start(event: &Section<'_>) -> Start {
    let Some(text) = event.text_or_none("when") else {
        return Start::At(event.number("at_s", Bound::NotNegative));
    };
    if event.has("at_s") {
        event.complain("when", "found a moment besides, `at_s`, expected one of the two");
        event.allow(&["at_s"]);
    }
    match Condition::parse(&text) {
        Ok(condition) => Start::When(condition),
        Err(label) => {
            event.complain("when", &label);
            Start::At(0.0)
        }
    }
}

/// How long it goes on: `for_s`, or up to `until_s`.
fn read_span(event: &Section<'_>, start: &Start) -> Option<f64> {
    let for_s = event.number_or_none("for_s", Bound::Positive);
    let Some(until_s) = event.number_or_none("until_s", Bound::Positive) else { return for_s };
    let Start::At(at_s) = *start else {
        event.complain("until_s", "found an end in time to something that begins by a condition, expected `for_s`");
        return for_s;
    };
    if for_s.is_some() {
        event.complain("until_s", "found a span besides, `for_s`, expected one of the two");
    } else if until_s <= at_s {
        event.complain("until_s", &format!("found {until_s}, expected a time after `at_s`, {at_s}"));
    }
    Some(until_s - at_s)
}

fn wheels(event: &Section<'_>) -> Wheels<bool> {
    let words = [
        ("both", Wheels::both(true)),
        ("right", Wheels { right: true, left: false }),
        ("left", Wheels { right: false, left: true }),
    ];
    event.choice("wheel", &words, false)
}

/// A wheel without inertia would be infinitely fast in the air.
fn lifted(event: &Section<'_>, robot: &Robot) -> Wheels<bool> {
    if robot.turning_inertia_kg_m2() == 0.0 {
        event.complain("kind", "found wheels without inertia, expected `robot.wheel_inertia_kg_m2` above 0");
    }
    wheels(event)
}

/// The robot's load, as far as the event does not say otherwise.
fn load(event: &Section<'_>, robot: &Robot) -> Load {
    let now = robot.load;
    Load {
        mass_kg: event.number_or("mass_kg", now.mass_kg, Bound::Within(0.0, 1e6)),
        cog_distance_m: event.number_or("cog_distance_m", now.cog_distance_m, Bound::Within(0.0, 1e3)),
        cog_angle_rad: event.number_or("cog_angle_rad", now.cog_angle_rad, Bound::Within(-1e3, 1e3)),
    }
}

fn factor(event: &Section<'_>) -> f64 {
    event.number("factor", Bound::Within(0.0, 1e3))
}

/// A patch of floor, where one is given.
fn region(event: &Section<'_>) -> Option<Region> {
    if !event.has("center_m") && !event.has("radius_m") {
        event.allow(&["center_m", "radius_m"]);
        return None;
    }
    let center_m = event.numbers("center_m", Bound::Within(-1e6, 1e6));
    Some(Region { center_m, radius_m: event.number("radius_m", Bound::Positive) })
}

fn push(event: &Section<'_>) -> What {
    let number = |key: &str| event.number_or(key, 0.0, Bound::Within(-1e6, 1e6));
    if !event.has("force_n") && !event.has("moment_nm") {
        event.complain("kind", "found a push without `force_n` and `moment_nm`, expected one of them");
    }
    What::Push { force_n: number("force_n"), moment_nm: number("moment_nm") }
}

fn slope(event: &Section<'_>) -> What {
    What::Slope {
        angle_rad: event.number("angle_rad", Bound::Within(-1.5, 1.5)),
        uphill_rad: event.number("uphill_rad", Bound::Within(-1e3, 1e3)),
    }
}
