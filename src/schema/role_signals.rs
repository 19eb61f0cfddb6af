//! From what a role of a profile names to the signals of its message, each with
//! unit and side of the gear.

use super::encoding::Rounding;
use super::linker::{Linked, Linker};
use super::pattern::Field;
use super::quantities::{Position, PositionScale, Speed, Torque, TorqueScale};
use super::signal::Signal;
use super::units::{Motor, Nameplate, POSITION_UNITS, PositionUnit, SIDES, SPEED_UNITS, TORQUE_UNITS};
use crate::config::Section;

/// Reads the signals of roles.
pub(super) struct RoleSignals<'r> {
    pub linker: Linker<'r>,
    pub rounding: Rounding,
}

impl RoleSignals<'_> {
    /// What the message always says.
    pub fn constants(&self, section: &Section<'_>, message: Linked<'_>) -> Option<Vec<Field>> {
        let constants = section.section("constants");
        constants.allow(&constants.keys());
        let fields = constants.keys().into_iter().map(|key| {
            let signal = self.linker.signal_named(&constants, key, key, message)?;
            Some(Field { pattern: self.linker.pattern(&constants, key, message, &signal)?, signal })
        });
        fields.collect()
    }

    /// The counter, if the role names one.
    pub fn counter(&self, section: &Section<'_>, message: Linked<'_>) -> Option<Option<Signal>> {
        let asked = section.has("counter").then(|| self.linker.counter(section, "counter", message));
        asked.map_or(Some(None), |linked| linked.map(Some))
    }

    /// The mode of operation, if the role names it.
    pub fn mode(&self, section: &Section<'_>, message: Linked<'_>) -> Option<Option<Signal>> {
        if !section.has("mode") {
            return Some(None);
        }
        let signal = self.linker.signal(section, "mode", message)?;
        self.linker.unless(!signal.is_integer(), section, "mode", &signal, "a whole number, factor 1, offset 0")?;
        Some(Some(signal))
    }

    /// The torque under `key`, with a range that includes 0.
    pub fn torque(&self, section: &Section<'_>, key: &str, message: Linked<'_>) -> Option<Torque> {
        let unit = section.choice(&format!("{key}_unit"), &TORQUE_UNITS, false);
        let side = section.choice(&format!("{key}_at"), &SIDES, true);
        let signal = self.linker.signal(section, key, message)?;
        let scale = TorqueScale::default();
        let mut torque = Torque { signal, unit, side, rounding: self.rounding, nm_per_unit: 1.0, scale };
        torque.fit(&Motor { counts_per_turn: 1, gear_ratio: 1.0, plate: Nameplate::default() });
        let TorqueScale { minimum_nm, maximum_nm, .. } = torque.scale;
        let sound = minimum_nm <= 0.0 && maximum_nm >= 0.0 && (maximum_nm - minimum_nm).is_finite();
        self.linker.unless(!sound, section, key, &torque.signal, "a finite range that includes 0")?;
        Some(torque)
    }

    /// The position, fine enough to count with.
    pub fn position(&self, section: &Section<'_>, message: Linked<'_>) -> Option<Position> {
        let unit = section.choice("position_unit", &POSITION_UNITS, true);
        let side = section.choice("position_at", &SIDES, true);
        let signal = self.linker.signal(section, "position", message)?;
        let is_count = unit == PositionUnit::Counts;
        let sound =
            if is_count { signal.is_integer() } else { true } && (signal.is_float() || signal.bit_count() <= 48);
        let expected = if is_count {
            "a whole number of at most 48 bits, factor 1, offset 0"
        } else {
            "a whole number of at most 48 bits or a floating-point one"
        };
        self.linker.unless(!sound, section, "position", &signal, expected)?;
        Some(Position { signal, unit, side, units_per_count: 1.0, is_count: false, scale: PositionScale::default() })
    }

    /// The speed.
    pub fn speed(&self, section: &Section<'_>, message: Linked<'_>) -> Option<Speed> {
        let unit = section.choice("speed_unit", &SPEED_UNITS, true);
        let side = section.choice("speed_at", &SIDES, true);
        let signal = self.linker.signal(section, "speed", message)?;
        Some(Speed { signal, unit, side, rounding: self.rounding, rad_s_per_unit: 1.0 })
    }
}
