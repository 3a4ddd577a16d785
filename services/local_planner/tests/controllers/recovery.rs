//! What is done when the robot does not get on: the machine's laws, and whole drives with it; and
//! goals with and without a yaw, for every controller.

#![allow(
    clippy::print_stdout,
    reason = "transitions and results of a failed run"
)]

use crate::support::whole::Whole;
use crate::support::{Loop, PERIOD_S, block, disc, goal_at, jackal, path};
use proptest::prelude::*;
use zeronav_local_planner::LocalPlannerConfig;
use zeronav_local_planner::recovery::options::RecoveryConfig;
use zeronav_local_planner::recovery::{Behaviour, Cause, Facts, Reason, Recovery, Transition};
use zeronav_local_planner::table::CONTROLLERS;
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::command::Validity;
use zeronav_msgs::path::PathBlock;
use zeronav_msgs::pose::wrap_angle;
use zeronav_msgs::task::{StuckCause, TaskState};

pub(crate) fn fine(now_s: f64) -> Facts {
    Facts {
        now_s,
        goal: 1,
        geometry: 1,
        blocked: false,
        turns: false,
        stalled_s: 0.0,
        idle_s: 0.0,
        no_progress: false,
        stuck: false,
        dynamic_obstacle: false,
        free_behind: false,
        room_to_turn: false,
        ..Facts::default()
    }
}

/// [s] that a behaviour may last, with a period to spare; following is not bounded.
fn limit_s(behaviour: Behaviour, config: &RecoveryConfig) -> f64 {
    let limit_s = match behaviour {
        Behaviour::Follow | Behaviour::GiveUp(_) => f64::INFINITY,
        Behaviour::AskForPath => config.ask_s,
        Behaviour::Wait => config.wait_s,
        Behaviour::BackUp | Behaviour::Rotate => config.manoeuvre_s,
        Behaviour::Manoeuvre => 10.0 * config.manoeuvre_s,
    };
    limit_s + 2.0 * PERIOD_S
}

proptest! {
    #[test]
    fn every_behaviour_ends_and_changes_have_their_reasons(
        pieces in proptest::collection::vec(
            (1_u32..80, any::<[bool; 6]>(), 0_u64..3, 0.0_f64..0.6, 0.0_f64..2.0),
            1..60,
        ),
    ) {
        let config = RecoveryConfig::default();
        let mut recovery = Recovery::new(config);
        let (mut now_s, mut since_s, mut came_closer_s) = (0.0, 0.0, 0.0);
        for (periods, [blocked, turns, behind, room, moves, closer], geometry, backed_m, rotated_rad)
            in pieces
        {
            for _ in 0..periods {
                now_s += PERIOD_S;
                if closer && !blocked {
                    came_closer_s = now_s;
                }
                let facts = Facts {
                    blocked,
                    turns,
                    geometry: geometry + 1,
                    stalled_s: now_s - came_closer_s,
                    idle_s: now_s - came_closer_s,
                    no_progress: now_s - came_closer_s > 10.0,
                    free_behind: behind,
                    room_to_turn: room,
                    dynamic_obstacle: moves,
                    backed_m,
                    rotated_rad,
                    ..fine(now_s)
                };
                let before = recovery.behaviour();
                if let Some(change) = recovery.step(&facts) {
                    prop_assert_eq!(change.from, before);
                    prop_assert_eq!(change.to, recovery.behaviour());
                    prop_assert_ne!(change.from, change.to);
                    if change.to == Behaviour::BackUp {
                        prop_assert!(facts.free_behind, "back into what is known");
                    }
                    if change.to == Behaviour::Rotate {
                        prop_assert!(facts.room_to_turn);
                    }
                    if change.reason == Reason::DynamicObstacle {
                        prop_assert!(facts.dynamic_obstacle);
                    }
                    prop_assert!(!matches!(before, Behaviour::GiveUp(_)), "the end is the end");
                    since_s = now_s;
                }
                let limit_s = limit_s(recovery.behaviour(), &config);
                prop_assert!(now_s - since_s <= limit_s, "{:?} for ever", recovery.behaviour());
                prop_assert!(recovery.attempts() <= config.attempts);
            }
        }
    }

    #[test]
    fn a_robot_that_stays_blocked_gives_up_with_a_cause(
        behind in any::<bool>(),
        room in any::<bool>(),
        moves in any::<bool>(),
        paths in any::<bool>(),
    ) {
        let config = RecoveryConfig::default();
        let mut recovery = Recovery::new(config);
        // Every attempt with a question before and after it, and the patience between them.
        let each_s = config.patience_s * 2.0
            + config.ask_s * 2.0
            + config.wait_s.max(config.manoeuvre_s)
            + 1.0;
        let mut now_s = 0.0;
        let mut end = None;
        while now_s < each_s * f64::from(config.attempts + 2) && end.is_none() {
            now_s += PERIOD_S;
            let manoeuvring = matches!(recovery.behaviour(), Behaviour::BackUp | Behaviour::Rotate);
            let facts = Facts {
                blocked: !manoeuvring,
                stalled_s: now_s,
                free_behind: behind,
                room_to_turn: room,
                dynamic_obstacle: moves,
                // A planner that changes its mind all the time.
                geometry: if paths && (now_s * 4.0).fract() < 0.5 { 1 } else { 2 },
                ..fine(now_s)
            };
            end = recovery.step(&facts).filter(|change| matches!(change.to, Behaviour::GiveUp(_)));
        }
        let end = end.expect("it gives up");
        prop_assert_eq!(end.to, Behaviour::GiveUp(Cause::TooManyAttempts));
        prop_assert_eq!(end.reason, Reason::OutOfAttempts);
    }
}

#[test]
fn the_ladder_is_climbed_and_left_when_the_robot_comes_closer() {
    let mut recovery = Recovery::new(RecoveryConfig::default());
    let mut seen = Vec::new();
    let mut now_s = 0.0;
    let mut backed_m = 0.0;
    recovery.step(&fine(now_s));
    while seen.len() < 12 && now_s < 60.0 {
        now_s += PERIOD_S;
        let backs = recovery.behaviour() == Behaviour::BackUp;
        backed_m = if backs { backed_m + 0.01 } else { 0.0 };
        let change = recovery.step(&Facts {
            blocked: !backs,
            stalled_s: now_s,
            free_behind: true,
            room_to_turn: false,
            backed_m,
            ..fine(now_s)
        });
        seen.extend(change.map(|change| (change.to, change.reason)));
    }
    println!("{seen:?}");
    assert_eq!(
        seen[..7],
        [
            (Behaviour::AskForPath, Reason::Blocked),
            (Behaviour::BackUp, Reason::TimedOut),
            (Behaviour::Follow, Reason::Done),
            (Behaviour::BackUp, Reason::Blocked),
            (Behaviour::Follow, Reason::Done),
            (Behaviour::BackUp, Reason::Blocked),
            (Behaviour::Follow, Reason::Done),
        ]
    );
    assert_eq!(seen[7], (Behaviour::Wait, Reason::Blocked));
    // Closer: the next trouble begins with a question again.
    let mut change = None;
    for _ in 0..400 {
        now_s += PERIOD_S;
        recovery.step(&fine(now_s));
    }
    while change.is_none() {
        now_s += PERIOD_S;
        change = recovery.step(&Facts {
            blocked: true,
            free_behind: true,
            ..fine(now_s)
        });
    }
    assert_eq!(change.map(|change| change.to), Some(Behaviour::AskForPath));
}

#[test]
fn what_is_tried_is_given_time_to_help() {
    // In a crowd: it could move, but comes no closer, can neither back up nor turn, and every wait
    // ends at once.
    let config = RecoveryConfig::default();
    let mut recovery = Recovery::new(config);
    recovery.step(&fine(0.0));
    let mut tries_s = Vec::new();
    let times_s = (1..).map(|n| PERIOD_S * f64::from(n));
    for now_s in times_s.take_while(|now_s| *now_s < 20.0) {
        let change = recovery.step(&Facts {
            stalled_s: 10.0 + now_s,
            no_progress: true,
            dynamic_obstacle: true,
            ..fine(now_s)
        });
        let is_try = change.is_some_and(|change| change.reason == Reason::NoProgress);
        tries_s.extend(is_try.then_some(now_s));
    }
    println!("{tries_s:?}");
    assert!((3..=7).contains(&tries_s.len()), "{tries_s:?}");
    let apart = tries_s.windows(2).map(|pair| pair[1] - pair[0]);
    assert!(apart.fold(f64::INFINITY, f64::min) > config.wait_s);
    assert!(!matches!(recovery.behaviour(), Behaviour::GiveUp(_)));
}

#[test]
fn being_stuck_names_what_it_was() {
    for (blocked, cause) in [(true, Cause::Blocked), (false, Cause::NoProgress)] {
        let mut recovery = Recovery::new(RecoveryConfig::default());
        recovery.step(&fine(0.0));
        recovery.step(&Facts {
            blocked,
            ..fine(0.02)
        });
        let change = recovery.step(&Facts {
            blocked,
            stuck: true,
            stalled_s: 30.1,
            ..fine(0.04)
        });
        assert_eq!(
            change,
            Some(Transition {
                from: Behaviour::Follow,
                to: Behaviour::GiveUp(cause),
                reason: Reason::Stuck,
            })
        );
        // And the next goal starts from the beginning.
        let change = recovery.idle(0.06, 0, false).map(|change| change.to);
        assert_eq!(change, Some(Behaviour::Follow));
    }
}

/// A pocket that is too narrow for the Jackal to turn in.
fn pocket() -> Loop {
    let blocks = [
        block(0.0, 0.0, 0.5, 4.0),
        block(3.0, 0.0, 6.0, 1.7),
        block(3.0, 2.3, 6.0, 4.0),
        block(4.2, 1.7, 6.0, 2.3),
    ];
    let corners = path(&[(1.5, 2.0), (3.85, 2.0)]);
    Loop::new(
        jackal(),
        &blocks,
        (6.0, 4.0),
        Pose::new(1.5, 2.0, 0.0),
        corners,
    )
}

#[test]
fn a_robot_that_drove_into_a_pocket_backs_out_by_its_own_track() {
    for key in ["dwa_t", "dwa", "mppi"] {
        let mut run = pocket();
        run.goal.tolerance_m = 0.3;
        let mut whole = Whole::with(key);
        // In, but not so far that the task ends.
        for _ in 0..2000 {
            run.step(&mut whole);
            if run.pose.x_m > 3.45 {
                break;
            }
        }
        assert!(
            run.pose.x_m > 3.45,
            "{key} did not drive in: {:?}",
            run.pose
        );
        run.path = path(&[(run.pose.x_m, 2.0), (1.0, 2.0)]);
        run.geometry += 1;
        let deepest_m = run.pose.x_m;
        let mut before = Twist::REST;
        let mut out = false;
        for _ in 0..2500 {
            let pose = run.pose;
            let decision = run.step(&mut whole);
            if before != Twist::REST {
                run.check_command(before, &pose, &decision);
            }
            before = Twist::new(decision.v_mps, decision.w_radps);
            out |= run.pose.x_m < 1.6;
            if out {
                break;
            }
        }
        println!("{key}: {:?} {:?}", run.pose, whole.changes);
        assert!(run.least_m > 0.0, "{key} touched something");
        let backed =
            |change: &Transition| matches!(change.to, Behaviour::BackUp | Behaviour::Manoeuvre);
        assert!(whole.changes.iter().any(backed), "{key} did not back up");
        assert!(
            out,
            "{key} stayed in the pocket: {:?} from {deepest_m}",
            run.pose
        );
        assert!(!whole.asked.is_empty(), "{key} asked for no path");
    }
}

#[test]
fn a_way_that_never_opens_ends_with_a_cause_and_without_contact() {
    let walls = [
        block(0.0, 0.0, 8.0, 0.4),
        block(0.0, 1.6, 8.0, 2.0),
        block(5.0, 0.4, 5.3, 1.6),
    ];
    let corners = path(&[(1.0, 1.0), (7.0, 1.0)]);
    let mut run = Loop::new(
        jackal(),
        &walls,
        (8.0, 2.0),
        Pose::new(1.0, 1.0, 0.0),
        corners,
    );
    let mut config = LocalPlannerConfig::default();
    config.recovery.attempts = 4;
    let mut whole = Whole::new(&config);
    for _ in 0..4000 {
        run.step(&mut whole);
        if whole.state() == Some(TaskState::Failed) && run.twist.is_stopped() {
            break;
        }
    }
    println!("{:.1} s {:?}", run.time_s, whole.changes);
    assert!(run.least_m > 0.0, "touched something");
    assert_eq!(whole.state(), Some(TaskState::Failed));
    let causes = whole.changes.iter().filter_map(|change| match change.to {
        Behaviour::GiveUp(cause) => Some(cause),
        _ => None,
    });
    assert_eq!(causes.collect::<Vec<_>>(), [Cause::TooManyAttempts]);
    // And the status says so to everybody.
    let (status, ends) = whole.planner.status();
    let attempts = whole.changes.iter().filter(|it| it.to.is_attempt());
    assert_eq!((status.recoveries, attempts.count()), (4, 4));
    assert_eq!(status.cause(), Some(StuckCause::TooManyAttempts));
    assert_eq!(status.check(ends), Ok(()));
    // The wall across the way, between its sides.
    assert_eq!(status.block(), Some(PathBlock::Obstacle), "{status:?}");
    let [x_m, y_m] = status.block_m;
    assert!((4.95..5.4).contains(&x_m), "{status:?}");
    assert!((0.3..1.7).contains(&y_m), "{status:?}");
    assert!(whole.changes.iter().all(|change| change.from != change.to));
}

#[test]
fn who_has_no_recovery_is_left_alone() {
    let mut config = LocalPlannerConfig {
        controller: "ju_apf".to_owned(),
        ..LocalPlannerConfig::default()
    };
    for (for_papers, expected) in [(false, false), (true, true)] {
        config.recovery.for_papers = for_papers;
        let walls = [block(0.0, 0.0, 6.0, 0.4), block(3.0, 0.4, 3.3, 4.0)];
        let corners = path(&[(1.0, 2.0), (5.0, 2.0)]);
        let mut run = Loop::new(
            jackal(),
            &walls,
            (6.0, 4.0),
            Pose::new(1.0, 2.0, 0.0),
            corners,
        );
        let mut whole = Whole::new(&config);
        for _ in 0..800 {
            run.step(&mut whole);
        }
        assert!(run.least_m > 0.0);
        let asked = |change: &Transition| change.to == Behaviour::AskForPath;
        assert_eq!(
            whole.changes.iter().any(asked),
            expected,
            "{:?}",
            whole.changes
        );
    }
}

#[test]
fn goals_with_a_yaw_are_turned_to_and_goals_without_are_not() {
    for row in CONTROLLERS {
        for (yaw_rad, yaw_tolerance_rad) in [(-2.0, 0.1), (1.0, 4.0)] {
            let walls = [block(0.0, 0.0, 8.0, 0.2), block(0.0, 5.8, 8.0, 6.0)];
            let robot = disc(0.25, 0.8, 1.0, 1.8, 3.0);
            let corners = path(&[(1.0, 3.0), (4.0, 3.0)]);
            let pose = Pose::new(1.0, 3.0, 0.0);
            let mut run = Loop::new(robot, &walls, (8.0, 6.0), pose, corners);
            run.goal = goal_at(&run.path, 0.15, yaw_rad, yaw_tolerance_rad);
            let mut whole = Whole::with(row.key);
            let mut limit = 3000;
            while whole.state() != Some(TaskState::Reached) && limit > 0 {
                run.step(&mut whole);
                limit -= 1;
            }
            println!(
                "{} yaw {yaw_rad} +- {yaw_tolerance_rad}: {:.1} s, {:?}",
                row.key, run.time_s, run.pose
            );
            assert_eq!(whole.state(), Some(TaskState::Reached), "{}", row.key);
            assert!(run.pose.distance_m(&run.goal.pose) <= 0.15 + 0.02);
            let error_rad = wrap_angle(run.pose.yaw_rad - yaw_rad).abs();
            if yaw_tolerance_rad < 1.0 {
                assert!(
                    error_rad <= yaw_tolerance_rad + 0.02,
                    "{} {error_rad}",
                    row.key
                );
            } else {
                assert!(
                    run.pose.yaw_rad.abs() < 0.5,
                    "{} turned: {:?}",
                    row.key,
                    run.pose
                );
            }
            let last = run.history.last().expect("decisions");
            assert!(last.validity == Validity::AtGoal || last.v_mps.abs() < 0.03);
        }
    }
}

#[test]
fn shaped_commands_are_as_fast_when_the_robot_follows_late() {
    for key in ["dwa_t", "dwa"] {
        for delay in [0, 4] {
            let walls = [block(0.0, 0.0, 12.0, 0.4), block(0.0, 1.8, 12.0, 2.2)];
            let robot = disc(0.25, 0.8, 1.0, 1.8, 3.0);
            let corners = path(&[(1.0, 1.1), (11.0, 1.1)]);
            let pose = Pose::new(1.0, 1.1, 0.3);
            let mut run = Loop::new(robot, &walls, (12.0, 2.2), pose, corners);
            run.delay = delay;
            let mut whole = Whole::with(key);
            let arrived = run.run(&mut whole, 16.0);
            println!("{key}, delay {delay}: {:.2} s, {arrived}", run.time_s);
            // Full speed with both ramps takes 13.3 s.
            assert!(arrived && run.time_s < 13.3 * 1.08, "{}", run.time_s);
        }
    }
}
