//! What waits to be taken, in order: frames, events.

/// A queue, first in, first out. One that has been emptied begins anew at its
/// first place: what is filled and emptied once a period then keeps to a few
/// cache lines, where a ring would wander through all that it has room for.
#[derive(Clone, Debug)]
pub struct Fifo<T> {
    items: Vec<T>,
    /// How many of the items have been taken.
    taken: usize,
}

impl<T: Copy> Fifo<T> {
    /// An empty queue that allocates nothing until it holds more than this.
    pub fn with_capacity(capacity: usize) -> Self {
        Self { items: Vec::with_capacity(capacity), taken: 0 }
    }

    /// Puts one at the end.
    #[inline]
    pub fn push(&mut self, item: T) {
        if self.items.len() == self.items.capacity() {
            self.items.drain(..std::mem::take(&mut self.taken));
        }
        self.items.push(item);
    }

    /// Takes the first.
    #[inline]
    pub fn pop(&mut self) -> Option<T> {
        let first = *self.front()?;
        self.taken += 1;
        if self.is_empty() {
            self.items.clear();
            self.taken = 0;
        }
        Some(first)
    }

    /// The first.
    #[inline]
    pub fn front(&self) -> Option<&T> {
        self.items.get(self.taken)
    }

    /// How many there are.
    #[inline]
    pub const fn len(&self) -> usize {
        self.items.len() - self.taken
    }

    /// Whether there is none.
    #[inline]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl<T: Copy> Extend<T> for Fifo<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, items: I) {
        items.into_iter().for_each(|item| self.push(item));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_put_in_first_comes_out_first_and_room_is_used_again() {
        let mut queue = Fifo::with_capacity(4);
        let room = queue.items.capacity();
        (0..3).for_each(|item| queue.push(item));
        for item in 3..1000 {
            queue.push(item);
            assert_eq!((queue.pop(), queue.len()), (Some(item - 3), 3));
        }
        assert_eq!(queue.items.capacity(), room);
        assert_eq!([queue.pop(), queue.pop(), queue.pop(), queue.pop()], [Some(997), Some(998), Some(999), None]);
        assert!(queue.is_empty() && queue.front().is_none());
    }
}
