//! What the numbers in a profile's frames can say: ranges, steps, counters.

use super::Profile;
use crate::schema::message::Command;
use crate::schema::quantities::{PositionScale, TorqueScale};
use crate::schema::roles::FeedbackRole;
use crate::schema::units::Motor;
use crate::wheels::Wheel;

impl Profile {
    /// The torques that a command to this wheel's drive can ask for.
    pub fn command_torque(&self, wheel: Wheel) -> TorqueScale {
        self.command.wheels[wheel].torque.scale
    }

    /// What a command of `torque_nm` really asks for, N m: what the frame can say.
    pub fn torque_as_said(&self, wheel: Wheel, torque_nm: f64) -> f64 {
        let role = &self.command.wheels[wheel];
        let mut data = [0; 64];
        role.write(&mut data, &Command { torque_nm, ..Command::default() });
        role.torque.decode(&data).unwrap_or(0.0)
    }

    /// The torques that this wheel's drive can report as applied, if it does.
    pub fn applied_torque(&self, wheel: Wheel) -> Option<TorqueScale> {
        self.first(wheel, |part| part.torque_applied.as_ref()).map(|torque| torque.scale)
    }

    /// How this wheel's drive counts its position, if it does.
    pub fn position_scale(&self, wheel: Wheel) -> Option<PositionScale> {
        self.first(wheel, |part| part.position.as_ref()).map(|position| position.scale)
    }

    /// The position that a drive reports at this encoder count, 0 if it reports none.
    #[inline]
    pub fn position_at_count(&self, wheel: Wheel, count: i64) -> f64 {
        let position = self.first(wheel, |part| part.position.as_ref());
        position.map_or(0.0, |position| count as f64 * position.units_per_count)
    }

    /// The smallest step of the speed that this wheel's drive reports, rad/s, if
    /// it reports any.
    pub fn speed_resolution_rad_s(&self, wheel: Wheel) -> Option<f64> {
        self.first(wheel, |part| part.speed.as_ref()).map(|speed| speed.resolution_rad_s())
    }

    /// Whether commands are counted.
    pub const fn command_has_counter(&self) -> bool {
        self.command.wheels.right.counter.is_some()
    }

    /// The counter that follows `counter` in commands to this wheel.
    pub fn next_command_counter(&self, wheel: Wheel, counter: u8) -> u8 {
        self.command.wheels[wheel].counter.as_ref().map_or(0, |signal| signal.next_counter(counter))
    }

    /// The counter of this wheel's feedback that answers a SYNC with
    /// `sync_counter`, or comes after a feedback with one less.
    #[inline]
    pub fn feedback_counter(&self, wheel: Wheel, sync_counter: u8) -> Option<u8> {
        self.first(wheel, |part| part.counter.as_ref()).map(|signal| signal.low_bits(sync_counter))
    }

    /// The counter that follows `counter` in SYNC.
    pub fn next_sync_counter(&self, counter: u8) -> u8 {
        let signal = self.sync.as_ref().and_then(|sync| sync.counter.as_ref());
        signal.map_or(0, |signal| signal.next_counter(counter))
    }

    /// Keys of the nameplate without which the numbers mean nothing.
    pub fn needs_of_plate(&self) -> Vec<&'static str> {
        let applied = self.first(Wheel::Right, |part| part.torque_applied.as_ref());
        let position = self.first(Wheel::Right, |part| part.position.as_ref());
        let speed = self.first(Wheel::Right, |part| part.speed.as_ref());
        let mut keys: Vec<_> = [
            self.command.wheels.right.torque.unit.needs(),
            applied.and_then(|torque| torque.unit.needs()),
            position.and_then(|position| position.unit.needs()),
            speed.and_then(|speed| speed.unit.needs()),
        ]
        .into_iter()
        .flatten()
        .collect();
        keys.dedup();
        keys
    }

    /// Reads and writes all quantities as this motor has them.
    pub fn fit(&mut self, motor: &Motor) {
        for wheel in Wheel::BOTH {
            self.command.wheels[wheel].torque.fit(motor);
            for part in &mut self.feedback {
                let part = &mut part.wheels[wheel];
                part.position.iter_mut().for_each(|position| position.fit(motor));
                part.speed.iter_mut().for_each(|speed| speed.fit(motor));
                part.torque_applied.iter_mut().for_each(|torque| torque.fit(motor));
            }
        }
    }

    #[inline]
    fn first<'p, T>(&'p self, wheel: Wheel, of: impl Fn(&'p FeedbackRole) -> Option<&'p T>) -> Option<&'p T> {
        self.feedback.iter().find_map(|part| of(&part.wheels[wheel]))
    }
}
