//! What a controller thinks of itself: the error counters of ISO 11898-1:2015,
//! 12.1.4, and the states that follow from them.

use canloop::bus::ControllerState;

/// The error counters of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Confinement {
    transmit: u16,
    receive: u16,
}

/// Above this a counter warns.
const WARNING: u16 = 96;
/// Above this a node is error-passive.
const PASSIVE: u16 = 127;
/// A transmit error counter above this takes a node off the bus.
const OFF: u16 = 255;
/// What an error costs a transmitter, and a receiver that was alone in seeing
/// it first.
const HEAVY: u16 = 8;

impl Confinement {
    /// The transmit error counter.
    pub const fn transmit_errors(&self) -> u16 {
        self.transmit
    }

    /// The receive error counter.
    pub const fn receive_errors(&self) -> u16 {
        self.receive
    }

    /// What follows from them.
    pub const fn state(&self) -> ControllerState {
        if self.transmit > OFF {
            ControllerState::BusOff
        } else if self.is_passive() {
            ControllerState::ErrorPassive
        } else if self.transmit > WARNING || self.receive > WARNING {
            ControllerState::ErrorWarning
        } else {
            ControllerState::ErrorActive
        }
    }

    /// Whether it may say that it saw an error only in a way that nobody
    /// notices.
    pub const fn is_passive(&self) -> bool {
        self.transmit > PASSIVE || self.receive > PASSIVE
    }

    /// Whether it is off the bus.
    pub const fn is_off(&self) -> bool {
        self.transmit > OFF
    }

    /// Whether nothing is held against it.
    pub const fn is_clean(&self) -> bool {
        self.transmit == 0 && self.receive == 0
    }

    /// A frame of its own got through (rule g).
    pub const fn sent(&mut self) {
        self.transmit = self.transmit.saturating_sub(1);
    }

    /// It received a frame (rule h): an error-passive receiver is put back to
    /// where one more error makes it so again.
    pub const fn received(&mut self) {
        self.receive = if self.receive > PASSIVE { PASSIVE } else { self.receive.saturating_sub(1) };
    }

    /// A frame of its own met an error (rule c).
    pub const fn failed_to_send(&mut self) {
        self.transmit += HEAVY;
    }

    /// Nobody acknowledged its frame (rule c, exception 1): one who is
    /// error-passive may be alone on the bus, and that is no fault of its own.
    pub const fn was_not_acknowledged(&mut self) {
        if !self.is_passive() {
            self.transmit += HEAVY;
        }
    }

    /// It saw an error in another's frame (rule a). Who saw it first finds the
    /// others' error flags after its own and suspects itself (rule b).
    pub fn saw_error(&mut self, was_first: bool) {
        let counted = self.receive + if was_first { 1 + HEAVY } else { 1 };
        // Nothing comes of more than passive; hardware keeps eight bits.
        self.receive = counted.min(OFF);
    }

    /// Goes off the bus, whatever the counters say.
    pub const fn go_off(&mut self) {
        self.transmit = OFF + 1;
    }

    /// Back on the bus after its time off, with nothing held against it.
    pub const fn recover(&mut self) {
        *self = Self { transmit: 0, receive: 0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(errors: u16) -> Confinement {
        let mut node = Confinement::default();
        (0..errors).for_each(|_| node.failed_to_send());
        node
    }

    #[test]
    fn a_transmitter_counts_eight_for_an_error_and_one_back_for_a_success() {
        let mut node = after(2);
        assert_eq!(node.transmit_errors(), 16);
        node.sent();
        assert_eq!(node.transmit_errors(), 15);
        (0..20).for_each(|_| node.sent());
        assert_eq!(node.transmit_errors(), 0);
    }

    #[test]
    fn it_warns_above_96_is_passive_above_127_and_off_above_255() {
        let states = [12, 13, 15, 16, 31, 32].map(|errors| after(errors).state());
        use ControllerState::{BusOff, ErrorActive, ErrorPassive, ErrorWarning};
        assert_eq!(states, [ErrorActive, ErrorWarning, ErrorWarning, ErrorPassive, ErrorPassive, BusOff]);
    }

    #[test]
    fn it_is_active_again_when_both_counters_are_at_most_127() {
        let mut node = after(16);
        node.sent();
        assert_eq!((node.transmit_errors(), node.is_passive()), (127, false));
    }

    #[test]
    fn a_receiver_counts_one_for_an_error_and_nine_if_it_saw_it_first() {
        let mut node = Confinement::default();
        node.saw_error(false);
        node.saw_error(true);
        assert_eq!(node.receive_errors(), 10);
        node.received();
        assert_eq!(node.receive_errors(), 9);
    }

    #[test]
    fn a_passive_receiver_is_put_back_to_127_by_a_good_frame() {
        let mut node = Confinement::default();
        (0..20).for_each(|_| node.saw_error(true));
        assert_eq!((node.receive_errors(), node.state()), (180, ControllerState::ErrorPassive));
        node.received();
        assert_eq!((node.receive_errors(), node.is_passive()), (127, false));
    }

    #[test]
    fn a_receiver_never_goes_off_the_bus() {
        let mut node = Confinement::default();
        (0..1000).for_each(|_| node.saw_error(true));
        assert_eq!(node.state(), ControllerState::ErrorPassive);
    }

    #[test]
    fn who_is_not_acknowledged_becomes_passive_and_no_more() {
        let mut node = Confinement::default();
        (0..1000).for_each(|_| node.was_not_acknowledged());
        assert_eq!((node.transmit_errors(), node.state()), (128, ControllerState::ErrorPassive));
    }

    #[test]
    fn who_recovers_starts_with_nothing_held_against_it() {
        let mut node = after(40);
        node.recover();
        assert!(node.is_clean() && node.state() == ControllerState::ErrorActive);
    }
}
