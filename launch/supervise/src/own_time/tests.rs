use super::*;

const MS: u64 = 1_000_000;

fn ms(n: u64) -> Duration {
    Duration::from_millis(n)
}

/// A reading of process 7, in milliseconds.
fn reading(doing: Doing, ran_ms: u64, waited_ms: u64) -> Reading {
    Reading {
        id: (7, 100),
        group: 7,
        doing,
        ran_ns: ran_ms * MS,
        waited_ns: waited_ms * MS,
    }
}

/// Ran, blocked, waiting for a device and for a processor. [ms]
fn split(time: &OwnTime) -> [u128; 4] {
    [time.ran, time.blocked, time.device, time.waited].map(|time| time.as_millis())
}

/// From `before` to `now`, two looks and 20 ms later.
fn between(before: Reading, now: Reading) -> [u128; 4] {
    let mut time = OwnTime::since(Some(before));
    time.add(ms(10), ms(10), || unreachable!("it is too early to ask"));
    time.add(ms(10), ms(10), || Some(now));
    split(&time)
}

#[test]
fn time_goes_where_the_kernel_says() {
    let from = reading(Doing::Blocked, 50, 20);
    let to = |doing, ran_ms, waited_ms| between(from, reading(doing, ran_ms, waited_ms));
    assert_eq!(to(Doing::Blocked, 52, 23), [2, 15, 0, 3]);
    assert_eq!(to(Doing::Stopped, 50, 20), [0, 20, 0, 0]);
    assert_eq!(to(Doing::Traced, 50, 20), [0; 4], "a debugger has it");
    assert_eq!(to(Doing::Device, 51, 20), [1, 0, 19, 0]);
    assert_eq!(to(Doing::Runnable, 70, 20), [20, 0, 0, 0], "it computes");
    // The wait that goes on is not in the counter yet.
    assert_eq!(to(Doing::Runnable, 51, 20), [1, 0, 0, 19], "it waits");
    // Four threads compute; a wait that began long ago ends.
    assert_eq!(to(Doing::Runnable, 130, 20), [20, 0, 0, 0]);
    assert_eq!(to(Doing::Blocked, 51, 4_000), [1, 0, 0, 19]);
}

#[test]
fn computing_that_the_kernel_counts_late_is_not_lost() {
    let mut time = OwnTime::since(Some(reading(Doing::Runnable, 0, 0)));
    for (look, ran_ms) in [(1_u64, 14), (2, 40), (3, 56), (4, 80)] {
        let at_ms = 20 * look;
        assert!(ran_ms <= at_ms);
        time.add(ms(20), ms(20), || Some(reading(Doing::Runnable, ran_ms, 0)));
    }
    // Only what the kernel owes at the end is missing.
    assert_eq!(time.ran, ms(74));
}

#[test]
fn another_process_and_counters_that_go_back_count_nothing() {
    let from = reading(Doing::Blocked, 50, 20);
    assert_eq!(between(from, reading(Doing::Blocked, 49, 20)), [0; 4]);
    assert_eq!(between(from, reading(Doing::Blocked, 50, 19)), [0; 4]);
    let used_again = Reading {
        id: (7, 101),
        ..reading(Doing::Runnable, 60, 20)
    };
    assert_eq!(between(from, used_again), [0; 4]);
}

#[test]
fn what_launch_slept_through_is_not_blocked_but_computed_is_computed() {
    let mut time = OwnTime::since(Some(reading(Doing::Blocked, 0, 0)));
    let mut look = |doing, ran_ms| {
        let kernel = || Some(reading(doing, ran_ms, 0));
        time.add(ms(3_000), awake(ms(3_000)), kernel);
        split(&time)
    };
    assert_eq!(look(Doing::Blocked, 0), [0, 20, 0, 0]);
    let then = look(Doing::Runnable, 3_000);
    assert_eq!(then, [3_000, 20, 0, 0]);
    // Without the kernel's word, looked-at time is blocked time.
    let mut unseen = OwnTime::default();
    unseen.add(ms(20), ms(20), || None);
    assert_eq!(split(&unseen), [0, 20, 0, 0]);
}

#[test]
fn the_kernels_files_are_read_whatever_the_name_of_a_program() {
    let stat = "12 (a) R (b) S 1 9 12 0 -1 4194304 0 0 0 0 3 4 0 0 20 0 1 0 777 1 2";
    let thread = Thread::parse(stat, Some("1000 2000 3\n")).expect("a thread");
    assert_eq!(thread.doing, Some(Doing::Blocked));
    assert_eq!((thread.group, thread.began), (9, 777));
    assert_eq!((thread.ran_ns, thread.waited_ns), (1_000, 2_000));
    let coarse = Thread::parse(stat, None).expect("a thread");
    assert_eq!((coarse.ran_ns, coarse.waited_ns), (70 * MS, 0));
    let traced = stat.replace(") S", ") t");
    let traced = Thread::parse(&traced, None).expect("one");
    assert_eq!(traced.doing, Some(Doing::Traced));
    let zombie = stat.replace(") S", ") Z");
    assert_eq!(Thread::parse(&zombie, None).expect("one").doing, None);
    for cut in ["", "12 (a", "12 (a) S", "12 (a) S 1 x"] {
        assert!(Thread::parse(cut, None).is_none(), "{cut}");
    }
}

#[test]
fn this_process_is_seen_to_compute() {
    let own = std::process::id();
    let before = Reading::of(own).expect("a reading");
    let mut sum = 0_u64;
    while Reading::of(own).is_some_and(|now| now.ran_ns < before.ran_ns + 5 * MS) {
        sum = core::hint::black_box(sum + 1);
    }
    let now = Reading::of(own).expect("a reading");
    assert_eq!((now.id, now.doing), (before.id, Doing::Runnable));
    assert!(Reading::of(u32::MAX).is_none());
}
