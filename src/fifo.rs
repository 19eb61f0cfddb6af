//! What waits to be taken, in order: frames, events.

use std::collections::VecDeque;

/// A queue, first in, first out. One that has been emptied begins anew at its
/// first place: what is filled and emptied once a period then keeps to a few
/// cache lines, where a ring would wander through all that it has room for.
#[derive(Clone, Debug)]
pub struct Fifo<T>(VecDeque<T>);

impl<T> Fifo<T> {
    /// An empty queue that allocates nothing until it holds more than this.
    pub fn with_capacity(capacity: usize) -> Self {
        Self(VecDeque::with_capacity(capacity))
    }

    /// Puts one at the end.
    #[inline]
    pub fn push(&mut self, item: T) {
        self.0.push_back(item);
    }

    /// Takes the first.
    #[inline]
    pub fn pop(&mut self) -> Option<T> {
        let first = self.0.pop_front()?;
        if self.0.is_empty() {
            self.0.clear();
        }
        Some(first)
    }

    /// The first.
    #[inline]
    pub fn front(&self) -> Option<&T> {
        self.0.front()
    }

    /// How many there are.
    #[inline]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<T> Extend<T> for Fifo<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, items: I) {
        self.0.extend(items);
    }
}
