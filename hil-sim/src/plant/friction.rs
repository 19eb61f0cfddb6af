//! Friction in a wheel's bearing and gear, eq 6-8.

/// Friction of one wheel. In motion it is
/// `viscous w + sign(w) (coulomb + (static - coulomb) exp(-stribeck |w|))`;
/// at rest it takes up whatever it must, up to `static_nm`. The paper writes
/// it for one direction; it is meant for both. All zeros: no friction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Friction {
    /// Viscous friction (c), N m s/rad.
    pub viscous_nm_s_per_rad: f64,
    /// What holds a wheel at rest at most (T_max), N m.
    pub static_nm: f64,
    /// What is left in fast motion (T_min), N m.
    pub coulomb_nm: f64,
    /// How fast static friction turns into Coulomb friction (a), s/rad.
    pub stribeck_s_per_rad: f64,
}

/// From this `a|w|` on the Stribeck term is below rounding.
pub(super) const STRIBECK_END: f64 = 45.0;

impl Friction {
    /// Whether a wheel can stick.
    pub fn is_dry(&self) -> bool {
        self.static_nm > 0.0 || self.coulomb_nm > 0.0
    }

    /// The friction torque, N m, at `speed_rad_s` in a wheel that turns in
    /// `direction` (+1 or -1; 0 where there is no dry friction). Smooth in
    /// the speed: past zero it goes on as if the direction had not changed.
    pub(super) fn slipping_nm(&self, direction: f64, speed_rad_s: f64) -> f64 {
        let dry_nm = self.coulomb_nm + self.drop_nm() * self.stribeck_factor(direction * speed_rad_s);
        self.viscous_nm_s_per_rad * speed_rad_s + direction * dry_nm
    }

    /// How steeply the Stribeck term changes with the speed, N m s/rad.
    pub(super) fn stribeck_slope(&self, speed_rad_s: f64) -> f64 {
        self.stribeck_s_per_rad * self.drop_nm().abs() * self.stribeck_factor(speed_rad_s.abs())
    }

    /// From rest to fast motion the friction drops by this much, N m.
    pub(super) fn drop_nm(&self) -> f64 {
        self.static_nm - self.coulomb_nm
    }

    /// `exp(-a w)`, without the call where it does not matter.
    fn stribeck_factor(&self, forward_rad_s: f64) -> f64 {
        /// A trial step may end a little beyond zero, and must not overflow there.
        const BEYOND: f64 = -1.0;
        let exponent = self.stribeck_s_per_rad * forward_rad_s;
        if exponent > STRIBECK_END { 0.0 } else { libm::exp(-exponent.max(BEYOND)) }
    }
}
