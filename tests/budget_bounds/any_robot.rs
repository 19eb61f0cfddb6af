//! Drives of any kind: which messages are urgent, how long they are, how often
//! drives send by their own clocks and what makes them answer is left to
//! chance.

use canloop::budget::Terms;
use canloop::config::{Document, Source};
use canloop::schema::Profile;
use canloop::time::Duration;
use proptest::prelude::*;

/// How drives are asked and when a command acts, as profiles say it.
const KINDS: [(&str, &str); 5] = [
    ("sync", "at sync"),
    ("sync", "on arrival"),
    ("poll", "on arrival"),
    ("command", "on arrival"),
    ("nothing", "on arrival"),
];

/// A profile, and terms under which it may or may not be in time.
pub fn any_robot() -> impl Strategy<Value = (Profile, Terms)> {
    let kind = prop::sample::select(&KINDS[..]);
    let urgency = Just(vec![1_u32, 2, 3, 4, 5]).prop_shuffle();
    let lengths = prop::collection::vec(2_usize..=8, 4);
    let cycles_ms = (1_u32..40, 1_u32..20);
    let terms = (500_i64..8_000, prop::sample::select(&[250_000_u32, 500_000, 1_000_000][..]), 0_i64..200, 0_i64..200);
    (kind, urgency, lengths, cycles_ms, terms).prop_map(|(kind, urgency, lengths, cycles_ms, terms)| {
        let (period_us, bit_rate_bit_s, lateness_us, answer_us) = terms;
        let [period, lateness, answer] = [period_us, lateness_us, answer_us].map(Duration::from_micros);
        (profile(kind, &urgency, &lengths, cycles_ms), Terms { period, bit_rate_bit_s, lateness, answer })
    })
}

fn profile(
    (asks, acts): (&str, &str),
    urgency: &[u32],
    lengths: &[usize],
    (heartbeat_ms, feedback_ms): (u32, u32),
) -> Profile {
    let sync = if asks == "sync" { "[sync]\nmessage = \"Sync\"\n" } else { "" };
    let toml = format!(
        r#"
name = "any"
dbc = "any.dbc"
asks_with = "{asks}"
[wheels]
node_id_mask = 0x03
right = {{ node = "Right", id = 1 }}
left = {{ node = "Left", id = 2 }}
{sync}
[command]
message = "{{node}}Command"
acts = "{acts}"
torque = "Torque"
torque_at = "motor"
[[feedback]]
message = "{{node}}Feedback"
position = "Position"
position_unit = "counts"
position_at = "motor"
[[feedback]]
message = "{{node}}More"
speed = "Speed"
speed_unit = "rpm"
speed_at = "motor"
[heartbeat]
message = "{{node}}Heartbeat"
[[state]]
name = "released"
means = "ready"
commanded = "driven"
[[state]]
name = "driven"
means = "enabled"
"#
    );
    let mut dbc = format!("VERSION \"\"\nBU_: Stack Right Left\nBO_ {} Sync: 0 Stack\n", 16 * urgency[0]);
    let mut cycles = String::new();
    let kinds = [("Command", "Torque"), ("Feedback", "Position"), ("More", "Speed"), ("Heartbeat", "Life")];
    for (index, (message, signal)) in kinds.into_iter().enumerate() {
        for (node, wheel) in [(1, "Right"), (2, "Left")] {
            let id = 16 * urgency[index + 1] + node;
            let sender = if message == "Command" { "Stack" } else { wheel };
            dbc += &format!("BO_ {id} {wheel}{message}: {} {sender}\n", lengths[index]);
            dbc += &format!(" SG_ {signal} : 0|16@1- (1,0) [0|0] \"counts\" Stack\n");
            let cycle_ms = if message == "Heartbeat" { heartbeat_ms } else { feedback_ms };
            cycles += &format!("BA_ \"GenMsgCycleTime\" BO_ {id} {cycle_ms};\n");
        }
    }
    dbc += "BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\n";
    let document = Document::parse("any.toml", toml).unwrap();
    Profile::parse(&document, &Source::new("any.dbc", dbc + &cycles)).unwrap_or_else(|problems| panic!("{problems}"))
}
