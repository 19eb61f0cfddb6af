//! A bus to hold bounds against: one frame at a time, the lowest order first.
//! It knows nothing of the analysis.

/// A frame that waits, or will.
#[derive(Clone, Copy)]
struct Waiting {
    queued_ns: i64,
    /// How many were queued before, which tells those of one moment apart.
    turn: usize,
    frame: Frame,
    /// The caller's name for it.
    tag: (usize, i64),
}

/// What goes over the wire.
#[derive(Clone, Copy)]
pub struct Frame {
    /// The lowest wins.
    pub order: u64,
    /// How long it takes, ns.
    pub length_ns: i64,
    /// The queue in which it waits for those that were there before; without
    /// one its sender sends the most urgent first.
    pub queue: Option<usize>,
}

/// The bus.
#[derive(Default)]
pub struct Wire {
    free_ns: i64,
    queued: usize,
    waiting: Vec<Waiting>,
}

impl Wire {
    /// Has a frame queued at a moment that may be yet to come.
    pub fn queue(&mut self, queued_ns: i64, tag: (usize, i64), frame: Frame) {
        self.waiting.push(Waiting { queued_ns, turn: self.queued, frame, tag });
        self.queued += 1;
    }

    /// The next frame that goes through: when, and which.
    pub fn next(&mut self) -> Option<(i64, (usize, i64))> {
        let start = self.waiting.iter().map(|waiting| waiting.queued_ns).min()?.max(self.free_ns);
        let is_first = |waiting: &Waiting| {
            let mut same = self.waiting.iter().filter(|other| other.frame.queue == waiting.frame.queue);
            same.all(|other| (other.queued_ns, other.turn) >= (waiting.queued_ns, waiting.turn))
        };
        let may_go =
            |waiting: &Waiting| waiting.queued_ns <= start && (waiting.frame.queue.is_none() || is_first(waiting));
        let ready = self.waiting.iter().enumerate().filter(|(_, waiting)| may_go(waiting));
        let (index, _) = ready.min_by_key(|(_, waiting)| (waiting.frame.order, waiting.queued_ns, waiting.turn))?;
        let Waiting { frame, tag, .. } = self.waiting.remove(index);
        self.free_ns = start + frame.length_ns;
        Some((self.free_ns, tag))
    }
}

/// A row of numbers that looks like chance.
pub struct Chance(u64);

impl Chance {
    /// The same seed, the same row.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// One of `0..=most`.
    pub fn up_to(&mut self, most: i64) -> i64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % (most as u64 + 1)) as i64
    }

    /// Nothing, all, or something in between.
    pub fn extreme(&mut self, most: i64) -> i64 {
        match self.up_to(2) {
            0 => 0,
            1 => most,
            _ => self.up_to(most),
        }
    }
}
