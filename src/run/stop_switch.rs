//! The switch by which somebody outside ends a run.

use std::sync::atomic::{AtomicU32, Ordering};

/// Pressed once it brakes to rest first; pressed again it ends the run at once.
#[derive(Debug, Default)]
pub struct StopSwitch(AtomicU32);

/// What somebody who pressed the switch wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopWish {
    /// Brake to rest, then let go.
    Brake,
    /// Let go at once.
    LetGo,
}

impl StopSwitch {
    /// A switch that nobody has pressed.
    pub const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// Presses it; may be called in a signal handler.
    pub fn press(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    /// What is wanted, if it was pressed.
    pub fn wish(&self) -> Option<StopWish> {
        match self.0.load(Ordering::Relaxed) {
            0 => None,
            1 => Some(StopWish::Brake),
            _ => Some(StopWish::LetGo),
        }
    }
}
