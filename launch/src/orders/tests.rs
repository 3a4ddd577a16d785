//! How orders are served, repeated and given again.

use super::*;
use zeronav_msgs::Pose;

fn order(x_m: f64) -> Order {
    Order {
        goals: vec![Goal {
            pose: Pose::new(x_m, 2.0, 0.5),
            tolerance_m: 0.25,
            yaw_tolerance_rad: 0.25,
            id: 0,
        }],
        repeats: false,
        time_limit_ns: None,
    }
}

fn end(state: TaskState) -> End {
    End {
        state,
        reason: EndReason::None,
        why: None,
        may_open: false,
        recoveries: 0,
        left: Vec::new(),
    }
}

#[test]
fn what_may_open_is_tried_again_while_somebody_wants_it() {
    let goals = |n: u64| -> Vec<Goal> {
        let of = |id| Goal {
            id,
            ..order(1.0).goals[0]
        };
        (1..=n).map(of).collect()
    };
    let failed = |may_open| End {
        reason: EndReason::Unreachable,
        may_open,
        recoveries: 2,
        left: goals(2).split_off(1),
        ..end(TaskState::Failed)
    };
    for (repeats, time_limit_ns) in [(true, None), (false, Some(100))] {
        let mut orders = Orders::default();
        let wanted = Order {
            goals: goals(2),
            repeats,
            time_limit_ns,
        };
        let id = give(&mut orders, wanted);
        orders.begin(0, Vec::new());
        for at in [10, 20] {
            let again = orders.ended(failed(true), at).expect("it is wanted");
            assert_eq!(again, goals(2).split_off(1), "only what was not reached");
        }
        assert_eq!(orders.outcome(id), Some((ACTIVE, 0)));
        // A wall stays, whoever wants it.
        assert_eq!(orders.ended(failed(false), 90), None);
        assert_eq!(orders.outcome(id), Some(("unreachable", 90)));
        assert_eq!(orders.recoveries(id), 6);
    }
    // Nor is it tried once its time is over.
    let mut orders = Orders::default();
    let limited = Order {
        time_limit_ns: Some(100),
        ..order(1.0)
    };
    let id = give(&mut orders, limited);
    orders.begin(0, Vec::new());
    assert!(orders.is_over_time(101));
    assert_eq!(orders.ended(failed(true), 110), None);
    assert_eq!(orders.outcome(id), Some(("time_limit", 110)));
}

fn give(orders: &mut Orders, order: Order) -> u64 {
    orders.give(3.0, order).expect("room for it")
}

fn outcomes(orders: &Orders) -> Vec<String> {
    let records = orders.records().into_iter();
    records.map(|record| record.outcome).collect()
}

#[test]
fn orders_are_served_as_they_came() {
    let mut orders = Orders::default();
    let ids = [1.0, 2.0, 3.0].map(|x_m| give(&mut orders, order(x_m)));
    assert_eq!(ids, [1, 2, 3]);
    let first = orders.begin(10, Vec::new()).expect("the first");
    assert!((first[0].pose.x_m - 1.0).abs() < 1.0e-12);
    assert_eq!(orders.begin(11, Vec::new()), None, "one at a time");
    assert_eq!(orders.outcome(3), Some((QUEUED, 0)));
    assert_eq!(orders.n_before(3), 2);
    assert_eq!(orders.ended(end(TaskState::Reached), 30), None);
    let second = orders.begin(20, Vec::new()).expect("the second");
    assert_eq!(second.len(), 1);
    assert_eq!(orders.n_before(3), 1);
    assert_eq!(orders.outcome(1), Some(("reached", 20)));
    let blocked = End {
        reason: EndReason::GoalBlocked,
        why: Some("because".to_owned()),
        may_open: true,
        recoveries: 4,
        left: second,
        ..end(TaskState::Failed)
    };
    assert_eq!(orders.ended(blocked, 40), None, "nobody waits for it");
    assert_eq!((orders.why(2), orders.why(1)), ("because", ""));
    assert_eq!((orders.recoveries(2), orders.recoveries(1)), (4, 0));
    assert_eq!(orders.current(), None);
    assert_eq!(outcomes(&orders), ["reached", "goal_blocked", "queued"]);
}

#[test]
fn a_repeated_order_begins_again_until_it_is_cancelled() {
    let mut orders = Orders::default();
    let repeated = Order {
        repeats: true,
        ..order(1.0)
    };
    let id = give(&mut orders, repeated);
    orders.begin(0, Vec::new());
    for _ in 0..3 {
        let again = orders.ended(end(TaskState::Reached), 30);
        assert_eq!(again.map(|goals| goals.len()), Some(1));
    }
    assert_eq!(orders.cancel(Some(id)), Ok(true));
    // It arrived before the cancellation was due.
    assert_eq!(orders.ended(end(TaskState::Reached), 30), None);
    assert_eq!(outcomes(&orders), ["cancelled"]);
}

#[test]
fn those_that_wait_are_cancelled_without_the_robot() {
    let mut orders = Orders::default();
    for x_m in [1.0, 2.0, 3.0] {
        give(&mut orders, order(x_m));
    }
    orders.begin(0, Vec::new());
    assert_eq!(orders.cancel(Some(2)), Ok(false));
    assert!(orders.cancel(Some(2)).is_err(), "it is cancelled already");
    assert!(orders.cancel(Some(99)).is_err());
    assert_eq!(orders.cancel(None), Ok(true));
    orders.ended(end(TaskState::Cancelled), 30);
    assert_eq!(outcomes(&orders), ["cancelled"; 3]);
}

#[test]
fn an_order_that_takes_the_place_of_all_others_ends_them() {
    let mut orders = Orders::default();
    give(&mut orders, order(1.0));
    give(&mut orders, order(2.0));
    orders.begin(0, order(9.0).goals);
    orders.replace(4);
    give(&mut orders, order(3.0));
    assert!(orders.begin(5, Vec::new()).is_some());
    assert_eq!(outcomes(&orders), ["replaced", "replaced", "active"]);
    assert_eq!(orders.take_aside(), Some(order(9.0).goals));
}

#[test]
fn time_limits_end_an_order_once() {
    let mut orders = Orders::default();
    let limited = Order {
        time_limit_ns: Some(100),
        ..order(1.0)
    };
    give(&mut orders, limited);
    assert!(!orders.is_over_time(1_000), "it has not begun");
    orders.begin(1_000, Vec::new());
    assert!(!orders.is_over_time(1_100));
    assert!(orders.is_over_time(1_101));
    assert!(!orders.is_over_time(1_102), "it is cancelled once");
    orders.ended(end(TaskState::Cancelled), 30);
    assert_eq!(outcomes(&orders), ["time_limit"]);
}

#[test]
fn waiting_and_memory_are_bounded() {
    let mut orders = Orders::default();
    for _ in 0..WAITING_MAX {
        give(&mut orders, order(1.0));
    }
    assert!(orders.give(0.0, order(1.0)).is_err());
    for _ in 0..2 * KEPT_MAX {
        orders.begin(0, Vec::new());
        orders.ended(end(TaskState::Reached), 30);
        give(&mut orders, order(1.0));
    }
    assert_eq!(orders.records().len(), KEPT_MAX);
    assert_eq!(orders.outcome(orders.newest_id), Some((QUEUED, 0)));
}
