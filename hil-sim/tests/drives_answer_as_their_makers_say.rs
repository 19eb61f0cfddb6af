//! Each impersonated drive, spoken to in frames written out by hand from its
//! maker's documents, answers as those say: on power-up, on the way to torque,
//! out of order, when commands stay out, after a fault, under a wrong id.

use canloop::frame::{CanId, Frame, FrameKind};
use canloop::schema::FaultCode;
use canloop::time::{Duration, Instant};
use canloop::wheels::Wheel;
use hil_sim::scenario::Scenario;
use hil_sim::virtual_robot::VirtualRobot;

/// The drives of a shipped scenario on a bus on which frames take no time.
struct Rig {
    robot: VirtualRobot,
    now: Instant,
}

impl Rig {
    fn new(scenario: &str) -> Self {
        let scenario = Scenario::load(scenario, &[]).unwrap_or_else(|problems| panic!("{problems}"));
        Self { robot: scenario.virtual_robot(Instant::ZERO), now: Instant::ZERO }
    }

    /// Puts a frame, written as candump writes it, on the bus; gives what the
    /// drives answer at once.
    fn say(&mut self, frame: &str) -> Vec<String> {
        self.robot.handle_frame(&parse(frame), 0.0);
        self.heard()
    }

    /// Lets time pass; gives all that the drives said meanwhile.
    fn pass_ms(&mut self, millis: u32) -> Vec<String> {
        let mut heard = Vec::new();
        for _ in 0..millis {
            self.robot.advance(0.001);
            self.now += Duration::from_millis(1);
            while self.robot.next_wakeup() <= self.now {
                self.robot.handle_wakeup(self.now);
            }
            heard.extend(self.heard());
        }
        heard
    }

    /// Says something again and again, a millisecond apart.
    fn keep_saying(&mut self, frames: &[&str], millis: u32) {
        for _ in 0..millis {
            frames.iter().for_each(|frame| drop(self.say(frame)));
            self.pass_ms(1);
        }
    }

    fn heard(&mut self) -> Vec<String> {
        std::iter::from_fn(|| self.robot.poll_transmit()).map(|(_, frame)| frame.to_string()).collect()
    }

    fn state(&self) -> &str {
        self.robot.drive(Wheel::Right).state_name()
    }
}

/// A frame written as candump writes it.
fn parse(text: &str) -> Frame {
    let (id, data) = text.split_once('#').expect("ID#DATA");
    let raw = u32::from_str_radix(id, 16).expect("a hexadecimal id");
    let id = if id.len() > 3 { CanId::Extended(raw) } else { CanId::Standard(raw as u16) };
    if let Some(len) = data.strip_prefix('R') {
        let mut frame = Frame::zeroed(id, len.parse().unwrap_or(0));
        frame.kind = FrameKind::Remote;
        return frame;
    }
    let byte = |at: usize| u8::from_str_radix(&data[at..at + 2], 16).expect("hexadecimal bytes");
    Frame::classic(id, &(0..data.len()).step_by(2).map(byte).collect::<Vec<_>>())
}

/// The last of these frames that has this id.
#[track_caller]
fn last(frames: &[String], id: &str) -> String {
    let found = frames.iter().rfind(|frame| frame.starts_with(&format!("{id}#")));
    found.unwrap_or_else(|| panic!("no {id} in {frames:?}")).clone()
}

mod cia402 {
    use super::*;

    /// RPDO1 of node 1 in cyclic synchronous torque, and SYNC; gives the
    /// statusword of its TPDO1.
    fn controlword(rig: &mut Rig, controlword: &str) -> String {
        rig.say(&format!("201#{controlword}00000A"));
        sync(rig)
    }

    fn sync(rig: &mut Rig) -> String {
        rig.pass_ms(5);
        last(&rig.say("080#"), "181")[4..8].to_owned()
    }

    fn operational() -> Rig {
        let mut rig = Rig::new("cia402");
        rig.pass_ms(300);
        rig.say("000#0100");
        sync(&mut rig);
        rig
    }

    fn enabled() -> Rig {
        let mut rig = operational();
        let statuses = ["0600", "0700", "0F00"].map(|word| controlword(&mut rig, word));
        assert_eq!(statuses, ["2100", "2300", "2700"], "ready to switch on, switched on, operation enabled");
        rig
    }

    #[test]
    fn it_boots_up_and_is_silent_until_the_master_starts_it() {
        let mut rig = Rig::new("cia402");
        let heard = rig.pass_ms(300);
        assert_eq!((heard[0].as_str(), last(&heard, "701").as_str()), ("701#00", "701#7F"));
        assert!(rig.say("080#").is_empty(), "PDOs before the node is operational");
        rig.say("000#0102");
        assert!(!rig.say("080#").iter().any(|frame| frame.starts_with("181")), "only node 2 was started");
        rig.say("000#0101");
        rig.say("080#");
        assert_eq!(sync(&mut rig), "4000", "switch on disabled");
        assert_eq!(last(&rig.pass_ms(100), "701"), "701#05");
    }

    #[test]
    fn the_way_up_is_6_7_f_and_f_before_its_time_does_nothing() {
        let mut rig = operational();
        assert_eq!(controlword(&mut rig, "0F00"), "4000");
        enabled();
    }

    #[test]
    fn torque_flows_in_mode_10_and_in_mode_4_and_in_no_other() {
        // 500 per mille of rated torque.
        for (mode, torque) in [("0A", "F401"), ("04", "F401"), ("01", "0000")] {
            let mut rig = enabled();
            for _ in 0..3 {
                rig.say(&format!("201#0F00F401{mode}"));
                sync(&mut rig);
            }
            assert_eq!(&last(&rig.say("080#"), "181")[8..12], torque, "mode {mode}");
        }
    }

    /// Object 0x6061 shows the mode that a drive is in, by that of 0x6060.
    #[test]
    fn its_mode_display_follows_the_mode_of_operation() {
        let mut rig = operational();
        for mode in ["00", "0A", "04", "01"] {
            if mode != "00" {
                rig.say(&format!("201#06000000{mode}"));
            }
            rig.pass_ms(5);
            let answers = rig.say("080#");
            assert_eq!((&last(&answers, "181")[12..14], &last(&answers, "182")[12..14]), (mode, "00"));
        }
    }

    #[test]
    fn a_torque_that_came_after_sync_waits_for_the_next() {
        let mut rig = enabled();
        rig.say("201#0F00F4010A");
        rig.pass_ms(5);
        assert_eq!(&last(&rig.say("080#"), "181")[8..12], "0000", "it did not act before this SYNC");
        rig.pass_ms(10);
        assert_eq!(&last(&rig.say("080#"), "181")[8..12], "F401");
    }

    #[test]
    fn without_rpdos_it_faults_with_8250_and_only_the_edge_of_fault_reset_leads_out() {
        let mut rig = enabled();
        let heard = rig.pass_ms(100);
        assert_eq!(last(&heard, "081")[4..8], *"5082");
        assert_eq!(sync(&mut rig), "0800", "fault");
        assert_eq!(controlword(&mut rig, "0F00"), "0800");
        assert_eq!(controlword(&mut rig, "8000"), "4000");
        assert_eq!(controlword(&mut rig, "0600"), "2100");
        rig.robot.raise_fault(Wheel::Right, FaultCode::OverCurrent);
        assert_eq!(last(&rig.heard(), "081")[4..8], *"1023");
        assert_eq!(controlword(&mut rig, "8000"), "0F00", "fault reaction active");
        assert_eq!(controlword(&mut rig, "8000"), "0800", "the bit is still set: that is no edge");
        assert_eq!(controlword(&mut rig, "0000"), "0800");
        assert_eq!(controlword(&mut rig, "8000"), "4000");
    }

    #[test]
    fn a_node_that_lost_its_power_or_was_reset_begins_anew() {
        let mut rig = enabled();
        rig.robot.power_cycle(Wheel::Right);
        assert_eq!(rig.state(), "initialising");
        let mut rig = enabled();
        rig.say("000#8101");
        assert_eq!(rig.state(), "initialising");
        rig.pass_ms(200);
        assert_eq!(rig.state(), "pre-operational");
    }
}

mod odrive {
    use super::*;

    const TORQUE_MODE: &str = "02B#0100000001000000";
    const CLOSED_LOOP: &str = "027#0800000000000000";
    /// 1 N m.
    const TORQUE: &str = "02E#0000803F00000000";

    fn up(scenario: &str) -> Rig {
        let mut rig = Rig::new(scenario);
        assert_eq!(last(&rig.pass_ms(10), "021")[12..14], *"00", "undefined while it starts");
        assert_eq!(last(&rig.pass_ms(300), "021")[12..14], *"01", "idle");
        rig
    }

    fn in_closed_loop(scenario: &str) -> Rig {
        let mut rig = up(scenario);
        rig.say(TORQUE_MODE);
        rig.say(CLOSED_LOOP);
        rig.keep_saying(&[TORQUE], 120);
        rig
    }

    fn heartbeat(rig: &mut Rig) -> String {
        last(&rig.pass_ms(100), "021")
    }

    /// The torque at the shaft that it says it applies, N m.
    fn torque_nm(rig: &mut Rig) -> f32 {
        let answer = parse(&last(&rig.say("03C#R8"), "03C"));
        f32::from_le_bytes(answer.payload()[4..].try_into().expect("four bytes"))
    }

    #[test]
    fn a_remote_request_is_answered_with_the_value_and_one_to_another_node_is_not() {
        let mut rig = up("odrive-0.6");
        assert_eq!(rig.say("029#R8"), ["029#0000000000000000"]);
        assert_eq!(rig.say("049#R8"), ["049#0000000000000000"]);
        assert!(rig.say("069#R8").is_empty());
    }

    #[test]
    fn closed_loop_without_torque_control_gives_no_torque() {
        let mut rig = up("odrive-0.6");
        rig.say(CLOSED_LOOP);
        rig.keep_saying(&[TORQUE], 50);
        assert_eq!(torque_nm(&mut rig), 0.0);
        rig.say(TORQUE_MODE);
        rig.keep_saying(&[TORQUE], 50);
        assert!((torque_nm(&mut rig) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn frames_of_four_bytes_will_do_as_in_the_maker_s_examples() {
        let mut rig = up("odrive-0.6");
        rig.say(TORQUE_MODE);
        rig.say("027#08000000");
        rig.keep_saying(&["02E#0000803F"], 50);
        assert!((torque_nm(&mut rig) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn commands_that_stay_out_disarm_it_with_the_watchdog_s_bit_until_errors_are_cleared() {
        for (scenario, bits, clear) in [("odrive-0.6", "00000001", "038#00"), ("odrive-0.5", "00080000", "038#")] {
            let mut rig = in_closed_loop(scenario);
            rig.pass_ms(90);
            assert_eq!(rig.state(), "closed loop");
            let disarmed = heartbeat(&mut rig);
            assert_eq!((&disarmed[4..12], &disarmed[12..14]), (bits, "01"), "{disarmed}");
            rig.say(CLOSED_LOOP);
            assert_eq!(&heartbeat(&mut rig)[4..14], format!("{bits}01"), "an error bars the way");
            rig.say(clear);
            assert_eq!(&heartbeat(&mut rig)[4..14], "0000000001");
        }
    }

    #[test]
    fn an_emergency_stop_to_all_nodes_disarms_both() {
        let mut rig = in_closed_loop("odrive-0.6");
        rig.say("7E2#");
        assert_eq!(&heartbeat(&mut rig)[4..14], "0000000201");
        assert_eq!(rig.robot.drive(Wheel::Left).state_name(), "disarmed");
    }

    #[test]
    fn a_fault_and_a_lost_supply_end_closed_loop() {
        let mut rig = in_closed_loop("odrive-0.6");
        rig.robot.raise_fault(Wheel::Right, FaultCode::OverTemperature);
        assert_eq!(&heartbeat(&mut rig)[4..14], "0040000001");
        let mut rig = in_closed_loop("odrive-0.6");
        rig.robot.power_cycle(Wheel::Right);
        assert_eq!(&heartbeat(&mut rig)[12..14], "00");
    }
}

mod vesc {
    use super::*;

    /// 10 A, and the same to all.
    const CURRENT: &str = "00000101#00002710";
    const TO_ALL: &str = "000001FF#00002710";

    /// The motor current in steps of 0.1 A, as Status 1 of controller 1 has it.
    fn current(rig: &mut Rig) -> String {
        last(&rig.pass_ms(10), "00000901")[17..21].to_owned()
    }

    #[test]
    fn it_obeys_its_own_id_and_that_of_all_and_reports_in_tenths_of_an_ampere() {
        let mut rig = Rig::new("vesc");
        assert!(rig.pass_ms(400).is_empty(), "it takes a while to start");
        rig.pass_ms(200);
        rig.keep_saying(&["00000103#00002710"], 20);
        assert_eq!(current(&mut rig), "0000");
        for command in [CURRENT, TO_ALL] {
            rig.keep_saying(&[command], 20);
            assert_eq!(current(&mut rig), "0063", "9.9999 A is 9.9");
            rig.pass_ms(600);
        }
    }

    #[test]
    fn commands_that_stay_out_for_half_a_second_release_the_motor_without_a_word() {
        let mut rig = Rig::new("vesc");
        rig.pass_ms(600);
        rig.say(CURRENT);
        rig.pass_ms(480);
        assert_ne!(current(&mut rig), "0000");
        let heard = rig.pass_ms(30);
        assert_eq!(last(&heard, "00000901")[17..21], *"0000");
        assert!(heard.iter().all(|frame| ["00000901", "00000902", "00001B01", "00001B02"].contains(&&frame[..8])));
        rig.say(CURRENT);
        assert_ne!(current(&mut rig), "0000", "it obeys again at once");
    }

    #[test]
    fn after_a_fault_it_stands_still_for_a_while() {
        let mut rig = Rig::new("vesc");
        rig.pass_ms(600);
        rig.keep_saying(&[CURRENT], 20);
        rig.robot.raise_fault(Wheel::Right, FaultCode::OverCurrent);
        rig.keep_saying(&[CURRENT], 400);
        assert_eq!(current(&mut rig), "0000");
        rig.keep_saying(&[CURRENT], 200);
        assert_ne!(current(&mut rig), "0000");
    }
}

mod damiao {
    use super::*;

    const ENABLE: &str = "001#FFFFFFFFFFFFFFFC";
    const DISABLE: &str = "001#FFFFFFFFFFFFFFFD";
    const CLEAR: &str = "001#FFFFFFFFFFFFFFFB";
    /// Kp and Kd 0, T code 0xFFF, 10 N m; and 0x7FF: as near to 0 as it gets.
    const TORQUE: &str = "001#7FFF7FF000000FFF";
    const NEXT_TO_NONE: &str = "001#7FFF7FF0000007FF";

    fn up() -> Rig {
        let mut rig = Rig::new("damiao-dm4310");
        assert!(rig.say(NEXT_TO_NONE).is_empty(), "it takes a while to start");
        rig.pass_ms(200);
        rig
    }

    /// The nibbles of its state and of its id, and the code of its torque.
    fn report(answers: &[String]) -> (String, u32) {
        let answer = last(answers, "011");
        (answer[4..6].to_owned(), u32::from_str_radix(&answer[13..16], 16).expect("hexadecimal"))
    }

    #[test]
    fn it_answers_every_command_and_gives_torque_only_when_enabled() {
        let mut rig = up();
        assert!(report(&rig.say(TORQUE)).0 == "01" && rig.state() == "disabled");
        rig.pass_ms(5);
        assert_eq!(report(&rig.say(TORQUE)), ("01".to_owned(), 2047), "no torque before it is enabled");
        assert_eq!(report(&rig.say(ENABLE)).0, "11");
        rig.keep_saying(&[TORQUE], 20);
        let (state, torque) = report(&rig.say(TORQUE));
        assert!(state == "11" && torque > 3400, "limited to 7 N m: {torque}");
        assert_eq!(report(&rig.say(DISABLE)).0, "01");
        assert!(rig.say("003#7FFF7FF0000007FF").is_empty(), "that is nobody's id");
    }

    #[test]
    fn commands_that_stay_out_end_in_communication_lost_until_that_is_cleared() {
        let mut rig = up();
        rig.say(ENABLE);
        rig.keep_saying(&[NEXT_TO_NONE], 20);
        assert_eq!(report(&rig.say(NEXT_TO_NONE)).0, "11");
        rig.pass_ms(120);
        assert_eq!(report(&rig.say(NEXT_TO_NONE)).0, "D1");
        assert_eq!(report(&rig.say(ENABLE)).0, "D1");
        assert_eq!(report(&rig.say(CLEAR)).0, "01");
        assert_eq!(report(&rig.say(ENABLE)).0, "11");
        rig.robot.raise_fault(Wheel::Right, FaultCode::MotorOverTemperature);
        assert_eq!(report(&rig.say(NEXT_TO_NONE)).0, "C1");
    }

    #[test]
    fn one_that_lost_its_power_is_disabled_when_it_is_back() {
        let mut rig = up();
        rig.say(ENABLE);
        rig.robot.power_cycle(Wheel::Right);
        assert!(rig.say(TORQUE).is_empty());
        rig.pass_ms(200);
        assert_eq!(report(&rig.say(TORQUE)).0, "01");
    }
}

mod comma_body {
    use super::*;

    /// CRC-8 with polynomial 0xD5 and initial value 0xFF over the bytes from
    /// the last to the first.
    fn crc(bytes: &[u8]) -> u8 {
        bytes.iter().rev().fold(0xFF, |remainder, byte| {
            (0..8).fold(remainder ^ byte, |bits, _| if bits & 0x80 != 0 { bits << 1 ^ 0xD5 } else { bits << 1 })
        })
    }

    /// Both wheels the same torque.
    fn command(torque: i16, counter: u8) -> String {
        let [high, low] = torque.to_be_bytes();
        let bytes = [high, low, high, low, counter & 0xF];
        let hex: String = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
        format!("250#{hex}{:02X}", crc(&bytes))
    }

    fn up() -> Rig {
        let mut rig = Rig::new("comma-body");
        rig.pass_ms(300);
        rig
    }

    /// Whether both wheels have come to turn, by what the board says.
    fn turns(rig: &mut Rig) -> bool {
        let report = last(&rig.pass_ms(20), "201");
        report[4..8] != *"0000" && report[8..12] != *"0000"
    }

    #[test]
    fn it_reports_both_speeds_with_a_count_and_a_checksum() {
        let mut rig = up();
        let reports: Vec<Frame> = rig.pass_ms(30).iter().map(|report| parse(report)).collect();
        assert_eq!(reports.len(), 3);
        for (index, report) in reports.iter().enumerate() {
            let bytes = report.payload();
            assert_eq!(bytes[7], crc(&bytes[..7]));
            assert_eq!(bytes[6] & 0xF, (reports[0].payload()[6] + index as u8) & 0xF);
        }
    }

    #[test]
    fn it_obeys_counted_commands_with_the_right_checksum_and_no_others() {
        let mut rig = up();
        for counter in 0..30 {
            let mut frame = command(1000, counter);
            frame.replace_range(4..5, "1");
            rig.say(&frame);
            rig.pass_ms(5);
        }
        assert!(!turns(&mut rig), "the checksum was another's");
        for counter in 0..60 {
            rig.say(&command(1000, counter));
            rig.pass_ms(5);
        }
        assert!(turns(&mut rig));
    }

    #[test]
    fn a_repeated_command_is_none_and_without_commands_it_lets_the_wheels_go() {
        let mut rig = up();
        for counter in 0..20 {
            rig.say(&command(1000, counter));
            rig.pass_ms(5);
        }
        assert_eq!(rig.state(), "driven");
        for _ in 0..30 {
            rig.say(&command(1000, 3));
            rig.pass_ms(5);
        }
        assert_eq!(rig.state(), "released");
    }
}
