//! Many independent pieces of work on all processors, their results one after
//! the other as if there were only one.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// How far ahead of the last result that was taken anybody works, a thread:
/// what bounds the results in memory.
const AHEAD: u64 = 64;

/// Does `work` for each number below `count` on so many threads, and gives the
/// results to `take` in order of their numbers, on the caller's thread. When
/// `take` breaks, what has not begun is left out.
pub fn in_order<T: Send>(
    count: u64,
    threads: usize,
    work: impl Fn(u64) -> T + Sync,
    mut take: impl FnMut(u64, T) -> ControlFlow<()>,
) {
    let threads = threads.max(1);
    let bench = Workbench::new(count, AHEAD * threads as u64);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(number) = bench.next() {
                    bench.put(number, work(number));
                }
            });
        }
        for number in 0..count {
            if take(number, bench.get(number)).is_break() {
                break;
            }
        }
        bench.close();
    });
}

struct Workbench<T> {
    count: u64,
    ahead: u64,
    state: Mutex<State<T>>,
    changed: Condvar,
}

struct State<T> {
    /// What nobody has begun.
    next: u64,
    /// What has been taken.
    taken: u64,
    done: BTreeMap<u64, T>,
}

impl<T> Workbench<T> {
    fn new(count: u64, ahead: u64) -> Self {
        let state = Mutex::new(State { next: 0, taken: 0, done: BTreeMap::new() });
        Self { count, ahead, state, changed: Condvar::new() }
    }

    /// The number of a piece of work that is now somebody's; none when there is
    /// no more.
    fn next(&self) -> Option<u64> {
        let mut state = self.lock();
        while state.next < self.count && state.next >= state.taken + self.ahead {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        let number = state.next;
        state.next += u64::from(number < self.count);
        (number < self.count).then_some(number)
    }

    fn put(&self, number: u64, result: T) {
        self.lock().done.insert(number, result);
        self.changed.notify_all();
    }

    /// The result of a piece of work, once it is there.
    fn get(&self, number: u64) -> T {
        let mut state = self.lock();
        loop {
            if let Some(result) = state.done.remove(&number) {
                state.taken = number + 1;
                self.changed.notify_all();
                return result;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Nothing more is begun.
    fn close(&self) {
        self.lock().next = self.count;
        self.changed.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn results_come_in_order_whoever_is_done_first() {
        for threads in [0, 1, 3, 8] {
            let mut taken = Vec::new();
            let work = |number: u64| (0..(number * 7919) % 5000).fold(number, |sum, one| sum ^ one);
            in_order(500, threads, work, |number, result| {
                taken.push((number, result));
                ControlFlow::Continue(())
            });
            assert_eq!(taken, (0..500).map(|number| (number, work(number))).collect::<Vec<_>>());
        }
    }

    #[test]
    fn nobody_works_far_ahead_of_what_was_taken() {
        let begun = AtomicU64::new(0);
        let work = |_| begun.fetch_add(1, Ordering::Relaxed);
        in_order(10_000, 2, work, |number, _| {
            assert!(begun.load(Ordering::Relaxed) <= number + 1 + 2 * AHEAD + 2);
            ControlFlow::Continue(())
        });
    }

    #[test]
    fn what_has_not_begun_is_left_out_after_a_break() {
        let begun = AtomicU64::new(0);
        let count = |_| begun.fetch_add(1, Ordering::Relaxed);
        in_order(
            1_000_000,
            2,
            count,
            |number, _| if number < 9 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) },
        );
        assert!(begun.into_inner() < 10 + 2 * AHEAD + 4);
    }
}
