//! When the machine of the recovery makes an attempt, and when none is called for.

use crate::recovery::fine;
use crate::support::PERIOD_S;
use zeronav_local_planner::recovery::options::RecoveryConfig;
use zeronav_local_planner::recovery::{Behaviour, Facts, Reason, Recovery, Transition};

#[test]
fn a_turn_that_does_not_end_asks_for_another_path() {
    let config = RecoveryConfig::default();
    let mut recovery = Recovery::new(config);
    let mut now_s = 0.0;
    let mut turn = |recovery: &mut Recovery, turns, lasting_s| {
        let end_s = now_s + lasting_s;
        let mut change = None;
        while now_s < end_s && change.is_none() {
            now_s += PERIOD_S;
            let facts = Facts {
                turns,
                // A turn comes no closer, and that alone is no reason to do something else.
                stalled_s: now_s,
                idle_s: now_s,
                no_progress: turns,
                ..fine(now_s)
            };
            change = recovery.step(&facts);
        }
        change
    };
    assert_eq!(turn(&mut recovery, true, PERIOD_S), None, "the first goal");
    let limit_s = 2.0 * config.manoeuvre_s;
    assert_eq!(turn(&mut recovery, true, limit_s - 0.1), None);
    assert_eq!(turn(&mut recovery, false, 0.1), None);
    assert_eq!(turn(&mut recovery, true, limit_s - 0.1), None, "a new turn");
    let change = turn(&mut recovery, true, 0.2);
    let expected = Transition {
        from: Behaviour::Follow,
        to: Behaviour::AskForPath,
        reason: Reason::TimedOut,
    };
    assert_eq!(change, Some(expected));
    // A robot that turns slowly gets on all the same.
    let mut recovery = Recovery::new(config);
    for period in 0..3000_u32 {
        let now_s = PERIOD_S * f64::from(period);
        let facts = Facts {
            turns: true,
            stalled_s: now_s,
            idle_s: 1.0,
            ..fine(now_s)
        };
        assert_eq!(recovery.step(&facts), None);
    }
}

/// A box stands before a robot that can neither back up nor turn, and the planner answers every second
/// with the way that it had before.
#[test]
fn a_path_on_which_the_robot_stands_as_blocked_as_before_is_no_other_path() {
    let config = RecoveryConfig::default();
    let mut recovery = Recovery::new(config);
    for period in 0..1500_u32 {
        let now_s = PERIOD_S * f64::from(period);
        let facts = Facts {
            blocked: true,
            geometry: 1 + u64::from(period / 50),
            stalled_s: now_s,
            idle_s: now_s,
            ..fine(now_s)
        };
        if let Some(change) = recovery.step(&facts) {
            assert_ne!(change.reason, Reason::AnotherPath, "{change:?}");
        }
    }
    // Half a minute: a wait and a question take four seconds.
    assert!(
        (5..=8).contains(&recovery.attempts()),
        "{}",
        recovery.attempts()
    );
    // One that lets it drive is.
    let change = recovery.step(&Facts {
        geometry: 99,
        ..fine(30.0)
    });
    assert!(
        change.is_some_and(|change| change.to == Behaviour::Follow),
        "{change:?}"
    );
}
