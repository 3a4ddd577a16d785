use super::super::own_time::Doing;
use super::*;

const LOOK: Duration = Duration::from_millis(10);

fn limit(ms: u64, lockstep: bool) -> Limit {
    Limit {
        after: Duration::from_millis(ms),
        lockstep,
    }
}

fn reading(doing: Doing, ran_ms: u64) -> Reading {
    Reading {
        id: (7, 1),
        group: 7,
        doing,
        ran_ns: ran_ms * 1_000_000,
        waited_ns: 0,
    }
}

/// The look, of at most 10,000 at intervals of 10 ms, at which a process is hung that stands still and
/// of which the kernel says this at look n. [looks]
fn hung_after(limit: Limit, kernel: impl Fn(u64) -> Option<Reading>) -> Option<u64> {
    let mut watch = HangWatch::default();
    (0..10_000).find(|n| watch.look(Role::Mapping, (1, 7), LOOK, limit, || kernel(*n)))
}

/// 0.5 s, as exactly as the kernel is asked.
fn about_50(looks: u64) -> bool {
    (50..=54).contains(&looks)
}

#[test]
fn waiting_for_a_processor_is_no_hang_however_long() {
    for lockstep in [false, true] {
        let kernel = |_| Some(reading(Doing::Runnable, 5));
        assert_eq!(hung_after(limit(500, lockstep), kernel), None);
        // It gets a millisecond of every second.
        let kernel = |n| Some(reading(Doing::Runnable, n / 100));
        assert_eq!(hung_after(limit(500, lockstep), kernel), None);
    }
}

#[test]
fn blocked_and_stopped_processes_hang_after_the_limit() {
    for lockstep in [false, true] {
        for doing in [Doing::Blocked, Doing::Stopped] {
            let hung = hung_after(limit(500, lockstep), |_| Some(reading(doing, 5)));
            assert!(hung.is_some_and(about_50), "{doing:?}: {hung:?}");
        }
    }
    let unseen = hung_after(limit(500, false), |_| None);
    assert!(unseen.is_some_and(about_50), "{unseen:?}");
}

#[test]
fn endless_computing_is_a_hang_and_in_lockstep_after_ten_times_as_long() {
    let kernel = |n| Some(reading(Doing::Runnable, 10 * n));
    let soon = hung_after(limit(500, false), kernel);
    assert!(soon.is_some_and(about_50), "{soon:?}");
    let late = hung_after(limit(500, true), kernel);
    assert!(
        late.is_some_and(|looks| (350..=520).contains(&looks)),
        "{late:?}"
    );
    let disk = hung_after(limit(500, false), |_| Some(reading(Doing::Device, 5)));
    assert!(
        disk.is_some_and(|looks| (350..=520).contains(&looks)),
        "{disk:?}"
    );
}

#[test]
fn counters_of_another_process_do_not_count() {
    // Process id 7 is another process every time.
    let kernel = |n| {
        Some(Reading {
            id: (7, n),
            ..reading(Doing::Runnable, 10 * n)
        })
    };
    assert_eq!(hung_after(limit(500, false), kernel), None);
    let backwards = |n| Some(reading(Doing::Blocked, 100_000 - n));
    assert_eq!(hung_after(limit(500, false), backwards), None);
}

#[test]
fn standing_still_counts_only_while_launch_looks() {
    let limit = limit(500, false);
    let mut watch = HangWatch::default();
    let mut look = |progress, ms| {
        let since = Duration::from_millis(ms);
        let kernel = || Some(reading(Doing::Blocked, 5));
        watch.look(Role::Mapping, (1, progress), since, limit, kernel)
    };
    assert!(!look(1, 10));
    assert!(!look(1, 3000), "launch was asleep, too");
    let late = (0..100).find(|_| look(1, 10));
    assert!(
        late.is_some_and(|looks| (48..=51).contains(&looks)),
        "{late:?}"
    );
    assert!(!look(2, 10), "it goes on");
}

#[test]
fn a_starved_service_is_told_when_it_goes_on() {
    let limit = limit(500, false);
    let mut watch = HangWatch::default();
    let look = |watch: &mut HangWatch, progress| {
        let kernel = || Some(reading(Doing::Runnable, 5));
        assert!(!watch.look(Role::Mapping, (1, progress), LOOK, limit, kernel));
    };
    for _ in 0..300 {
        look(&mut watch, 1);
    }
    let [now] = watch.starving(limit.after)[..] else {
        panic!("it is starved");
    };
    assert_eq!(watch.take_starved(), []);
    look(&mut watch, 2);
    assert_eq!(watch.take_starved(), [now]);
    assert_eq!(watch.starving(limit.after), []);
    assert!(now.waited.as_millis() > 2_800 && now.still.as_millis() > 2_900);
    // A short wait is none.
    for _ in 0..30 {
        look(&mut watch, 3);
    }
    look(&mut watch, 4);
    assert_eq!(watch.take_starved(), []);
}

#[test]
fn seats_that_stand_still_together_get_more_time() {
    let limit = limit(100, false);
    let mut watch = HangWatch::default();
    let kernel = || Some(reading(Doing::Blocked, 5));
    let (mut first, mut looks) = (0, 0);
    while first == 0 {
        looks += 1;
        let alone = watch.look(Role::Mapping, (1, looks), LOOK, limit, kernel);
        assert!(!alone, "it goes on");
        let one = watch.look(Role::GlobalPlanner, (1, 7), LOOK, limit, kernel);
        let other = watch.look(Role::CollisionGuard, (1, 9), LOOK, limit, kernel);
        if one || other {
            first = looks;
        }
    }
    // The first look counts no time, and standing still has to last longer than the limit.
    let least = 10 * u64::from(LENIENT) + 2;
    assert!((least..least + 3).contains(&first), "{first}");
}

#[test]
fn a_successor_starts_with_a_clean_slate() {
    let limit = limit(5, false);
    let mut watch = HangWatch::default();
    let mut look = |epoch| watch.look(Role::Mapping, (epoch, 7), LOOK, limit, || None);
    assert!((0..5).any(|_| look(1)));
    assert!(!look(2));
}
