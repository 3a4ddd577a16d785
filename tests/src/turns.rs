//! Turns of tests in real time, so that they leave each other the processors, and places for what needs no
//! clock, so that more tests than processors can wait for a turn without all others driving at once.

use std::cell::Cell;
use std::marker::PhantomData;
use std::sync::{Condvar, Mutex, PoisonError};

/// Stacks in real time that may be up at once, besides those in lockstep: each takes a tenth to a fifth of a
/// processor.
const AT_ONCE: usize = 4;

/// Tests whose runs in lockstep and suites may be at work at once, besides those in real time.
const IN_BACKGROUND: usize = 4;

#[derive(Debug)]
struct Places {
    taken: usize,
    /// Tests that wait for all of them.
    waiting: usize,
}

static PLACES: Mutex<Places> = Mutex::new(Places {
    taken: 0,
    waiting: 0,
});
static FREED: Condvar = Condvar::new();

/// Tests with a place in the background.
static BACKGROUND: Mutex<usize> = Mutex::new(0);
static LEFT: Condvar = Condvar::new();

thread_local! {
    /// True while the test of this thread has a turn.
    static HAS_TURN: Cell<bool> = const { Cell::new(false) };
    /// Runs of this thread in the background: they share its place, or a test that has one and starts another
    /// could wait for ever.
    static RUNS: Cell<usize> = const { Cell::new(0) };
}

/// True while the test of this thread has a turn.
pub(crate) fn has_turn() -> bool {
    HAS_TURN.get()
}

/// A test's turn, until it is dropped, by the thread that took it.
#[derive(Debug)]
pub struct Turn {
    places: usize,
    of_this_thread: PhantomData<*const ()>,
}

/// A turn for a run in real time, beside three others at most.
#[must_use]
pub fn real_time_turn() -> Turn {
    take(1)
}

/// A turn for a run in real time whose times are judged: no other one beside it.
#[must_use]
pub fn quiet_turn() -> Turn {
    take(AT_ONCE)
}

/// A run's share in the place of its test in the background, until it is dropped.
#[derive(Debug)]
pub(crate) struct Place {
    of_this_thread: PhantomData<*const ()>,
}

/// Waits for a place in the background, unless this thread has one.
pub(crate) fn background_place() -> Place {
    if RUNS.get() == 0 {
        let mut at_work = BACKGROUND.lock().unwrap_or_else(PoisonError::into_inner);
        while *at_work >= IN_BACKGROUND {
            at_work = LEFT.wait(at_work).unwrap_or_else(PoisonError::into_inner);
        }
        *at_work += 1;
    }
    RUNS.set(RUNS.get() + 1);
    Place {
        of_this_thread: PhantomData,
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        RUNS.set(RUNS.get() - 1);
        if RUNS.get() == 0 {
            *BACKGROUND.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
            LEFT.notify_one();
        }
    }
}

fn take(places: usize) -> Turn {
    let is_quiet = places == AT_ONCE;
    let mut now = PLACES.lock().unwrap_or_else(PoisonError::into_inner);
    now.waiting += usize::from(is_quiet);
    // Those that wait for all places go first, or they would wait for good.
    while now.taken + places > AT_ONCE || (!is_quiet && now.waiting > 0) {
        now = FREED.wait(now).unwrap_or_else(PoisonError::into_inner);
    }
    now.waiting -= usize::from(is_quiet);
    now.taken += places;
    HAS_TURN.set(true);
    Turn {
        places,
        of_this_thread: PhantomData,
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        let mut now = PLACES.lock().unwrap_or_else(PoisonError::into_inner);
        now.taken -= self.places;
        HAS_TURN.set(false);
        FREED.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn some_share_and_a_quiet_one_is_alone() {
        let at_work = AtomicUsize::new(0);
        let most = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for n in 0..12 {
                let (at_work, most) = (&at_work, &most);
                scope.spawn(move || {
                    let is_quiet = n % 3 == 0;
                    let _turn = if is_quiet {
                        quiet_turn()
                    } else {
                        real_time_turn()
                    };
                    let beside = at_work.fetch_add(1, Ordering::SeqCst);
                    most.fetch_max(beside + 1, Ordering::SeqCst);
                    assert!(!is_quiet || beside == 0, "{beside} beside a quiet one");
                    std::thread::yield_now();
                    assert!(!is_quiet || at_work.load(Ordering::SeqCst) == 1);
                    at_work.fetch_sub(1, Ordering::SeqCst);
                });
            }
        });
        assert!(most.load(Ordering::SeqCst) <= AT_ONCE);
    }

    #[test]
    fn so_many_are_in_the_background_and_a_test_shares_its_place() {
        let at_work = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..3 * IN_BACKGROUND {
                scope.spawn(|| {
                    let places: Vec<Place> =
                        (0..2 * IN_BACKGROUND).map(|_| background_place()).collect();
                    let beside = at_work.fetch_add(1, Ordering::SeqCst);
                    assert!(beside < IN_BACKGROUND, "{beside} others");
                    std::thread::yield_now();
                    at_work.fetch_sub(1, Ordering::SeqCst);
                    drop(places);
                });
            }
        });
        assert_eq!(RUNS.get(), 0);
    }
}
