//! Where the robot was between two messages of odometry, and what is said of roles that answer.

use zeronav_msgs::Pose;
use zeronav_msgs::header::{Header, Id};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{RunClock, RunControl, RunMode, Seat};
use zeronav_shell::odometry::is_stopped;
use zeronav_shell::{OdometryHistory, Roster};

#[test]
fn between_two_messages_every_coordinate_changes_evenly() {
    let mut history = OdometryHistory::default();
    for (count, run_ns, pose) in [
        (1, 100, Pose::new(1.0, 2.0, 0.2)),
        (2, 200, Pose::new(2.0, -2.0, 0.4)),
    ] {
        let header = Header {
            id: Id::new(1, count).0,
            run_ns,
            ..Header::default()
        };
        let odometry = Odometry {
            pose,
            ..Odometry::default()
        };
        history.push(&header, &odometry, run_ns);
    }
    for (run_ns, expected) in [
        (100, [1.0, 2.0, 0.2]),
        (125, [1.25, 1.0, 0.25]),
        (150, [1.5, 0.0, 0.3]),
        (200, [2.0, -2.0, 0.4]),
    ] {
        let pose = history.pose_at(run_ns).expect("within the history");
        let found = [pose.x_m, pose.y_m, pose.yaw_rad];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{run_ns} ns: {pose:?}");
        }
    }
    assert!(history.pose_at(99).is_none() && history.pose_at(201).is_none());
}

#[test]
fn a_robot_is_stopped_below_both_speeds() {
    for (v_mps, w_radps, stopped) in [
        (0.019, 0.049, true),
        (-0.019, -0.049, true),
        (0.02, 0.0, false),
        (-0.021, 0.0, false),
        (0.0, 0.05, false),
        (0.0, -0.051, false),
    ] {
        let odometry = Odometry {
            v_mps,
            w_radps,
            ..Odometry::default()
        };
        assert_eq!(is_stopped(&odometry), stopped, "{v_mps}, {w_radps}");
    }
}

#[test]
fn only_in_lockstep_is_a_role_awaited_that_answers_and_has_not_spoken() {
    let seat = Seat {
        role: Role::Mapping.code(),
        epoch: 1,
        // Empty in ticks 5 to 8.
        off_tick: 5,
        on_tick: 9,
        ..Seat::default()
    };
    let roster = |mode: RunMode| Roster {
        clock: RunClock {
            mode: mode.code(),
            ..RunClock::default()
        },
        control: RunControl::default(),
        seats: vec![seat],
        ..Roster::default()
    };
    let lockstep = roster(RunMode::Lockstep);
    for (role, tick, spoken_tick, awaited) in [
        (Role::Mapping, 4, 3, true),
        (Role::Mapping, 4, 4, false),
        (Role::Mapping, 6, 3, false),
        (Role::Mapping, 9, 8, true),
        (Role::Robot, 4, 3, false),
    ] {
        let found = lockstep.awaits(role, tick, spoken_tick);
        assert_eq!(found, awaited, "{role} {tick}");
    }
    let in_real_time = roster(RunMode::RealTime);
    assert!(in_real_time.answers(Role::Mapping, 4) && !in_real_time.awaits(Role::Mapping, 4, 3));
    assert!(lockstep.is_known() && in_real_time.is_known());
    let empty = Roster {
        seats: Vec::new(),
        ..lockstep
    };
    assert!(empty.has_clock() && !empty.is_known());
    let stopped = Roster {
        clock: RunClock::default(),
        ..in_real_time
    };
    assert!(!stopped.has_clock() && !stopped.is_known());
}
