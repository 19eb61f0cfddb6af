//! A pair of things, one a wheel.

use std::ops::{Add, Index, IndexMut, Mul, Sub};

/// One of the robot's two driven wheels. The paper numbers them 1 (right)
/// and 2 (left).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wheel {
    /// The paper's wheel 1.
    Right,
    /// The paper's wheel 2.
    Left,
}

/// One `T` a wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wheels<T> {
    /// The paper's wheel 1.
    pub right: T,
    /// The paper's wheel 2.
    pub left: T,
}

impl Wheel {
    /// Both, in the paper's order.
    pub const BOTH: [Self; 2] = [Self::Right, Self::Left];

    /// `"right"` or `"left"`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Left => "left",
        }
    }

    /// The other one.
    pub const fn other(self) -> Self {
        match self {
            Self::Right => Self::Left,
            Self::Left => Self::Right,
        }
    }
}

impl<T> Wheels<T> {
    /// A pair made by asking for each wheel's share.
    pub fn from_fn(mut share: impl FnMut(Wheel) -> T) -> Self {
        Self { right: share(Wheel::Right), left: share(Wheel::Left) }
    }

    /// Applies `f` to both.
    pub fn map<U>(self, mut f: impl FnMut(T) -> U) -> Wheels<U> {
        Wheels { right: f(self.right), left: f(self.left) }
    }

    /// Joins two pairs wheel by wheel.
    pub fn zip_with<U, V>(self, other: Wheels<U>, mut f: impl FnMut(T, U) -> V) -> Wheels<V> {
        Wheels { right: f(self.right, other.right), left: f(self.left, other.left) }
    }

    /// References to both.
    pub const fn as_ref(&self) -> Wheels<&T> {
        Wheels { right: &self.right, left: &self.left }
    }

    /// Whether `predicate` holds for both.
    pub fn all(&self, mut predicate: impl FnMut(&T) -> bool) -> bool {
        predicate(&self.right) && predicate(&self.left)
    }

    /// Whether `predicate` holds for either.
    pub fn any(&self, mut predicate: impl FnMut(&T) -> bool) -> bool {
        predicate(&self.right) || predicate(&self.left)
    }
}

impl<T: Clone> Wheels<T> {
    /// The same for both.
    pub fn both(value: T) -> Self {
        Self { right: value.clone(), left: value }
    }
}

impl<T> Index<Wheel> for Wheels<T> {
    type Output = T;
    fn index(&self, wheel: Wheel) -> &T {
        match wheel {
            Wheel::Right => &self.right,
            Wheel::Left => &self.left,
        }
    }
}

impl<T> IndexMut<Wheel> for Wheels<T> {
    fn index_mut(&mut self, wheel: Wheel) -> &mut T {
        match wheel {
            Wheel::Right => &mut self.right,
            Wheel::Left => &mut self.left,
        }
    }
}

impl Add for Wheels<f64> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.zip_with(other, |a, b| a + b)
    }
}

impl Sub for Wheels<f64> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.zip_with(other, |a, b| a - b)
    }
}

impl Mul<f64> for Wheels<f64> {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        self.map(|value| value * factor)
    }
}
