//! The figures of drives that are made by hand.

use super::*;
use crate::fixture::{Value, Written, record, recording_until, written};
use zeronav_msgs::header::SHADOW_EPOCH_MIN;

const ROBOT: u8 = 2;
const PLANNER: u8 = 4;
const GUARD: u8 = 6;

fn real(path: &'static str, value: f64) -> Value {
    (path, value.to_le_bytes().to_vec())
}

fn by(epoch: u32) -> Value {
    ("header.id", Id::new(epoch, 1).0.to_le_bytes().to_vec())
}

fn command(epoch: u32, tick: u64, v_mps: f64, intervention: Intervention) -> Written {
    let intervention = intervention.code().to_le_bytes().to_vec();
    let values = [
        by(epoch),
        real("meta.v_mps", v_mps),
        ("meta.intervention", intervention),
    ];
    written(RobotCommand::ROW, GUARD, tick, &values)
}

fn path(epoch: u32, tick: u64, status: PathStatus, length_m: f64) -> Written {
    let status = ("meta.status", status.code().to_le_bytes().to_vec());
    let length = real("meta.length_m", length_m);
    let cost = real("meta.cost", 2.0 * length_m);
    written(
        PlanPath::ROW,
        PLANNER,
        tick,
        &[by(epoch), status, length, cost],
    )
}

fn truth(tick: u64, clearance_m: f64, driven_m: f64) -> Written {
    let values = [
        by(1),
        real("meta.clearance_m", clearance_m),
        real("meta.driven_m", driven_m),
        ("meta.contacts_moving", vec![1]),
        ("meta.contacts_standing", vec![2]),
    ];
    written(GroundTruth::ROW, ROBOT, tick, &values)
}

fn span(epoch: u32, tick: u64, ms: u64) -> Written {
    let values = [
        ("role", vec![GUARD]),
        ("epoch", epoch.to_le_bytes().to_vec()),
        ("tick", tick.to_le_bytes().to_vec()),
        ("output", vec![1]),
        ("started_ns", 5_u64.to_le_bytes().to_vec()),
        ("published_ns", (5 + ms * 1_000_000).to_le_bytes().to_vec()),
    ];
    record(&SPANS, &values)
}

/// The guard's seat goes over from 1 to 2 at this tick.
fn roster(since_tick: u64) -> Written {
    let seat = |role: u8, epoch: u8, other: u8, since_tick: u64| {
        let since = ("since_tick", since_tick.to_le_bytes().to_vec());
        vec![
            ("role", vec![role]),
            ("epoch", vec![epoch]),
            ("other", vec![other]),
            since,
        ]
    };
    let seats = vec![
        seat(ROBOT, 1, 0, 0),
        seat(PLANNER, 1, 0, 0),
        seat(GUARD, 2, 1, since_tick),
    ];
    written(RunControlTopic::ROW, 1, 0, &[]).with(seats)
}

fn of(messages: &[Written], end_tick: u64) -> BTreeMap<String, Option<f64>> {
    let bytes = recording_until(messages, Some(end_tick));
    let figures = figures(&bytes[..], Some(end_tick)).expect("figures");
    figures.into_iter().map(|it| (it.name, it.value)).collect()
}

#[test]
fn a_drive_is_added_up_until_its_end() {
    let none = Intervention::None;
    let found = of(
        &[
            truth(1, 0.5, 0.0),
            path(1, 1, PathStatus::Found, 4.0),
            command(1, 1, 0.5, none),
            span(1, 1, 2),
            truth(2, 0.2, 1.5),
            path(1, 2, PathStatus::NoGoal, 9.0),
            command(1, 2, -1.0, Intervention::Slowed),
            span(1, 2, 3),
            path(1, 3, PathStatus::Found, 2.0),
            command(1, 3, 0.0, none),
            span(1, 3, 9),
            // The run is over.
            truth(4, 0.0, 7.0),
            command(1, 4, 9.0, Intervention::Refused),
            span(1, 4, 99),
        ],
        4,
    );
    let expected = [
        ("driven", 1.5),
        ("least clearance", 0.2),
        ("contacts", 3.0),
        ("interventions of the guard", 1.0),
        ("mean speed", 0.5),
        ("paths found", 2.0),
        ("mean length of a path", 3.0),
        ("mean cost of a path", 6.0),
        ("median computing time, collision_guard", 3.0),
    ];
    for (name, value) in expected {
        let found = found[name].unwrap_or_else(|| panic!("no {name}"));
        assert!((found - value).abs() < 1e-12, "{name}: {found}");
    }
    assert_eq!(found.len(), expected.len() + 2, "{found:?}");
    assert_eq!(found["median error of the place"], None);
}

#[test]
fn where_mapping_has_the_robot_is_held_against_the_truth() {
    let pose = |path: &'static str, x_m: f64| real(path, x_m);
    let mut messages = Vec::new();
    for tick in 1..=4_u8 {
        let x_m = f64::from(tick);
        let truth = [by(1), pose("meta.pose.x_m", 10.0 + 1.25 * x_m)];
        let map = [by(1), pose("meta.map_from_odom.x_m", 10.0)];
        let odometry = [by(1), pose("meta.pose.x_m", x_m)];
        // In any order; without a scan there is no map.
        messages.push(written(GroundTruth::ROW, ROBOT, tick.into(), &truth));
        if tick != 2 {
            messages.push(written(MapUpdate::ROW, 3, tick.into(), &map));
        }
        messages.push(written(RobotOdometry::ROW, ROBOT, tick.into(), &odometry));
    }
    let found = of(&messages, 9);
    assert_eq!(found["median error of the place"], Some(0.75));
    assert_eq!(found["largest error of the place"], Some(1.0));
}

#[test]
fn only_who_is_obeyed_counts() {
    let stops = Intervention::StoppedShort;
    let mut messages = vec![roster(3)];
    for tick in 1..=4 {
        // Both answer; the second is obeyed from tick 3 on. A shadow never is.
        messages.push(command(1, tick, 1.0, stops));
        messages.push(command(2, tick, 3.0, Intervention::None));
        messages.push(command(SHADOW_EPOCH_MIN + 1, tick, 50.0, stops));
        messages.push(span(1, tick, 1));
        messages.push(span(2, tick, 5));
        messages.push(span(SHADOW_EPOCH_MIN + 1, tick, 80));
    }
    let found = of(&messages, 9);
    assert_eq!(found["mean speed"], Some(2.0));
    assert_eq!(found["interventions of the guard"], Some(2.0));
    // 1, 1, 5 and 5 ms: the mean of the two in the middle.
    assert_eq!(found["median computing time, collision_guard"], Some(3.0));
    // Without a roster, everybody but the shadow.
    let found = of(&messages[1..], 9);
    assert_eq!(found["mean speed"], Some(2.0));
    assert_eq!(found["interventions of the guard"], Some(4.0));
}

#[test]
fn what_was_not_recorded_has_no_figure() {
    let found = of(&[truth(1, f64::INFINITY, 0.0)], 9);
    assert_eq!(found["least clearance"], None);
    assert_eq!(found["mean speed"], None);
    assert_eq!(found["paths found"], None);
}
