//! The one clock of a host, and the fault that a process reads another time than the others.

use core::sync::atomic::{AtomicI64, Ordering};
use rustix::time::{ClockId, clock_gettime};

/// By how much the clock of this process is put forward on purpose. [ns]
static OFFSET_NS: AtomicI64 = AtomicI64::new(0);

/// `CLOCK_MONOTONIC` in nanoseconds, comparable between all processes of this host, unless launch
/// puts the clock of this one forward on purpose.
#[must_use]
pub fn now_ns() -> u64 {
    host_ns().saturating_add_signed(OFFSET_NS.load(Ordering::Relaxed))
}

/// The same without the fault: what decides when a process leaves. [ns]
pub(crate) fn host_ns() -> u64 {
    let time = clock_gettime(ClockId::Monotonic);
    time.tv_sec.cast_unsigned() * 1_000_000_000 + time.tv_nsec.cast_unsigned()
}

/// Puts the clock of this process forward by `offset_ns`, or back. [ns]
pub(crate) fn put_forward(offset_ns: i64) {
    if OFFSET_NS.swap(offset_ns, Ordering::Relaxed) != offset_ns {
        tracing::warn!(offset_ns, "the clock of this process is put forward");
    }
}

/// Processor time of the calling thread. [ns]
#[must_use]
pub(crate) fn thread_cpu_ns() -> u64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec.cast_unsigned() * 1_000_000_000 + time.tv_nsec.cast_unsigned()
}

/// One moment on two clocks: [`now_ns`] and `CLOCK_MONOTONIC_RAW`, which the kernel does not slew.
///
/// A process that is put aside between the two readings would make moments of them, so they are
/// taken again until they lie close together, a few times at most.
#[must_use]
pub fn both_ns() -> (u64, u64) {
    const CLOSE_NS: u64 = 2_000;
    const TRIES: u32 = 8;
    let mut best = (u64::MAX, 0, 0);
    for _ in 0..TRIES {
        let before_ns = now_ns();
        let raw = clock_gettime(ClockId::MonotonicRaw);
        let apart_ns = now_ns().saturating_sub(before_ns);
        if apart_ns < best.0 {
            let raw_ns = raw.tv_sec.cast_unsigned() * 1_000_000_000 + raw.tv_nsec.cast_unsigned();
            best = (apart_ns, before_ns, raw_ns);
        }
        if apart_ns <= CLOSE_NS {
            break;
        }
    }
    (best.1, best.2)
}
