//! Contacts with what moves that are of no own fault though an oracle could have avoided them.
//!
//! The oracle knows every future and may flee; a stack that was struck may do neither. Two rules say
//! when nothing that the stack did brought a contact about. Both hold for what moves alone: what stands
//! does not come.
//!
//! - **Run into.** A robot that stands is run into, and that is no fault. One that turns on the spot is as
//!   well, when in the pose in which it stood before the turn the same obstacle would have touched it
//!   at most [`ANYWAY_S`] later: the turn changed nothing.
//! - **Without guard.** While the last stage before the wheels is killed or stopped, no command comes
//!   through: the robot holds the last one for its `command_timeout_s`, then brakes by itself. A
//!   contact before it can have come to rest is the fault's, when from its state at the fault's begin
//!   it could still have been avoided: what could not be avoided then had been driven into before. The
//!   contact counts again from the guard's next command on.

use super::super::future::Future;
use super::super::hindsight::{Hindsight, state_at};
use super::super::oracle::robot::State;
use zeronav_measure::result::{RunResult, Touch};
use zeronav_msgs::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::time::seconds;
use zeronav_robot_description::RobotSpec;

/// Forward speed up to which a robot stands or turns on the spot, as the simulator counts. [m/s]
const STANDS_MPS: f64 = 0.05;

/// How much later a robot that did not turn may be touched for the turn not to matter. [s]
const ANYWAY_S: f64 = 0.5;

/// Between two looks at what comes. [s]
const LOOK_S: f64 = 0.01;

/// From the last command to the first tick that knows it to be too old: it may be a tick old when the guard
/// breaks, and a tick has begun. [ticks]
const TICKS: f64 = 2.0;

/// Why a contact with what moves is no own fault, with the figures; `None` when it is.
pub(super) fn excuse(hindsight: &Hindsight, run: &RunResult, touch: &Touch) -> Option<String> {
    run_into(hindsight.future(), run, touch).or_else(|| without_guard(hindsight, run, touch))
}

/// The first rule.
fn run_into(future: &Future, run: &RunResult, touch: &Touch) -> Option<String> {
    if touch.v_mps.abs() > STANDS_MPS {
        return None;
    }
    let mover = future.movers.iter().find(|it| it.name == touch.with)?;
    let before = run.motion.partition_point(|row| row[0] < touch.time_s);
    let rows = run.motion[..before].iter().rev();
    let [since_s, x_m, y_m, yaw_rad, ..] =
        *rows.take_while(|row| row[4].abs() <= STANDS_MPS).last()?;
    let stood = (future.abilities.outline).placed(&Pose::new(x_m, y_m, yaw_rad));
    let touches = |time_s: f64| {
        let disc = mover.at(time_s + run.first_goal_s);
        disc.is_some_and(|([x, y], radius_m)| stood.distance_to_point_m([x, y].into()) <= radius_m)
    };
    let until_s = touch.time_s + ANYWAY_S;
    let times = (0_u32..).map(|look| since_s + LOOK_S * f64::from(look));
    let anyway_s = times
        .take_while(|time_s| *time_s <= until_s)
        .find(|time_s| touches(*time_s))?;
    Some(format!(
        "{} at {:.2} s: it turned on the spot; as it stood at {since_s:.2} s it would have been touched at \
         {anyway_s:.2} s",
        touch.with, touch.time_s
    ))
}

/// The second rule.
fn without_guard(hindsight: &Hindsight, run: &RunResult, touch: &Touch) -> Option<String> {
    let contact_s = touch.time_s + run.first_goal_s;
    let (from_s, until_s) = outages(run)
        .into_iter()
        .find(|(from_s, until_s)| (*from_s..*until_s).contains(&contact_s))?;
    let state = state_at(run, from_s)?;
    let scenario = &hindsight.future().scenario;
    let rest_s = from_s + rest_after_s(&scenario.robot, &state, seconds(scenario.run.tick_ns()));
    if contact_s > rest_s || !hindsight.is_avoidable(&state, contact_s) {
        return None;
    }
    // In the time of the contact.
    let [from_s, until_s, rest_s] = [from_s, until_s, rest_s].map(|at_s| at_s - run.first_goal_s);
    Some(format!(
        "{} at {:.2} s: there was no guard from {from_s:.2} to {until_s:.2} s; from {:.2} m/s and {:.2} \
         rad/s the robot rests by itself at {rest_s:.2} s, and it could have been avoided until then",
        touch.with, touch.time_s, state.v_mps, state.w_radps
    ))
}

/// From when to when the guard had been killed or stopped and gave no command: run times. [s]
fn outages(run: &RunResult) -> Vec<(f64, f64)> {
    let mut outages: Vec<(f64, f64)> = Vec::new();
    let of_guard = run.faults.iter().filter(|fault| {
        let is_guard = fault.target == Role::CollisionGuard.label();
        is_guard && fault.why.is_none() && ["kill", "stop"].contains(&fault.kind.as_str())
    });
    for fault in of_guard {
        // Of a process that was stopped: when it went on, or its successor answered.
        let answered_s = (fault.recovery_ms).map(|ms| fault.time_s + 1.0e-3 * ms);
        let answers_s = fault.until_s.or(answered_s).unwrap_or(f64::INFINITY);
        match outages.last_mut() {
            // It breaks again before it has answered.
            Some((_, until_s)) if fault.time_s <= *until_s => *until_s = until_s.max(answers_s),
            _ => outages.push((fault.time_s, answers_s)),
        }
    }
    outages
}

/// Time from the last command to rest, at most, of a robot that is left alone. [s]
fn rest_after_s(robot: &RobotSpec, state: &State, tick_s: f64) -> f64 {
    let brake_mps2 = robot.brake_mps2.unwrap_or(robot.a_mps2_max);
    let braking_s =
        (state.v_mps.abs() / brake_mps2).max(state.w_radps.abs() / robot.alpha_radps2_max);
    robot.command_timeout_s + robot.actuation_delay_s + TICKS * tick_s + braking_s
}

#[cfg(test)]
mod tests {
    use super::super::super::future::walker;
    use super::*;
    use serde_json::{Value, json};

    /// A run whose first goal came at 0.5 s, with these rows and faults; times are those of the run.
    fn run(rows: &[[f64; 6]], faults: &Value) -> RunResult {
        let text = include_str!("../../../measure/tests/data/result_lockstep.json");
        let mut result: Value = serde_json::from_str(text).expect("a result");
        let since_goal = |row: &[f64; 6]| [row[0] - 0.5, row[1], row[2], row[3], row[4], row[5]];
        result["motion"] = json!(rows.iter().map(since_goal).collect::<Vec<_>>());
        result["first_goal_s"] = json!(0.5);
        result["faults"] = faults.clone();
        serde_json::from_value(result).expect("a result")
    }

    fn touch(run_s: f64, v_mps: f64) -> Touch {
        Touch {
            time_s: run_s - 0.5,
            moving: true,
            v_mps,
            with: "walker".to_owned(),
            pose: [0.0; 3],
        }
    }

    /// A robot of 0.5 m by 0.4 m that brakes with 1 m/s^2, 0.2 s after its last command, beside a walker
    /// who comes north along x = 5 at 1 m/s and is at y = 2 at 4 s.
    fn hindsight() -> Hindsight {
        let folder = walker("");
        let file = folder.path().join("it.toml");
        let text = std::fs::read_to_string(&file).expect("a scenario");
        let outline = "footprint_m = [[-0.25, -0.2], [0.25, -0.2], [0.25, 0.2], [-0.25, 0.2]]";
        std::fs::write(
            &file,
            text.replace("radius_m = 0.25\n", &format!("{outline}\n")),
        )
        .expect("written");
        Hindsight::of(&file).expect("a known future")
    }

    /// Ten rows a second of a robot that stands at a place and turns at 0.5 rad/s from a time on.
    fn turning(x: f64, y: f64, yaw_rad: f64, from_s: f64) -> Vec<[f64; 6]> {
        let row = |tenth: u32| {
            let t = 0.1 * f64::from(tenth);
            let turned_rad = 0.5 * (t - from_s).max(0.0);
            [
                t,
                x,
                y,
                yaw_rad + turned_rad,
                0.0,
                if t < from_s { 0.0 } else { 0.5 },
            ]
        };
        (5..=50).map(row).collect()
    }

    #[test]
    fn who_turns_where_he_stands_is_run_into_as_who_stands() {
        let hindsight = hindsight();
        let why =
            |rows: &[[f64; 6]], touch: &Touch| excuse(&hindsight, &run(rows, &json!([])), touch);
        // In the walker's way: his edge comes to y = 2.8 at 4.5 s.
        let in_the_way = turning(5.0, 3.0, 0.0, 4.2);
        let told = why(&in_the_way, &touch(4.5, 0.0)).expect("run into");
        assert!(told.contains("would have been touched at 4.0"), "{told}");
        // A corner swings into him who passes beside: where it stood there was room.
        let beside = turning(5.53, 2.0, core::f64::consts::FRAC_PI_2, 3.5);
        assert_eq!(why(&beside, &touch(4.0, 0.0)), None);
        // Who drives is not run into.
        assert_eq!(why(&in_the_way, &touch(4.5, 0.06)), None);
        let drives: Vec<[f64; 6]> = (in_the_way.iter())
            .map(|row| {
                [
                    row[0],
                    row[1] - 0.4 * (4.5 - row[0]),
                    row[2],
                    row[3],
                    0.4,
                    row[5],
                ]
            })
            .collect();
        assert_eq!(why(&drives, &touch(4.5, 0.0)), None);
        // Nor is who touches what stands.
        let wall = Touch {
            with: "world".to_owned(),
            ..touch(4.5, 0.0)
        };
        assert_eq!(why(&in_the_way, &wall), None);
    }

    /// Towards the east along y = 2 at 0.5 m/s, at `x` at 4 s.
    fn eastwards(x: f64) -> Vec<[f64; 6]> {
        let row = |tenth: u32| {
            let t = 0.1 * f64::from(tenth);
            [t, x + 0.5 * (t - 4.0), 2.0, 0.0, 0.5, 0.0]
        };
        (5..=50).map(row).collect()
    }

    #[test]
    fn without_a_guard_the_robot_brakes_late_and_that_is_the_faults() {
        let hindsight = hindsight();
        let fault = |kind: &str, time_s: f64, until_s: Option<f64>, recovery_ms: Option<f64>| {
            json!({"id": 1, "kind": kind, "target": "collision_guard", "tick": 0, "time_s": time_s,
                   "until_s": until_s, "recovery_ms": recovery_ms})
        };
        let why = |faults: &Value, run_s: f64| {
            excuse(
                &hindsight,
                &run(&eastwards(4.4), faults),
                &touch(run_s, 0.5),
            )
        };
        // 0.2 s and two ticks of 20 ms, then 0.5 s of braking: rest at 4.14 s.
        let killed = json!([fault("kill", 3.4, None, Some(900.0))]);
        let told = why(&killed, 3.9).expect("nobody could brake");
        let figures = "no guard from 2.90 to 3.80 s; from 0.50 m/s and 0.00 rad/s the robot rests by itself at 3.64 s";
        assert!(told.contains(figures), "{told}");
        assert_eq!(why(&killed, 4.15), None, "it should have come to rest");
        assert_eq!(why(&killed, 3.4 - 0.01), None, "before the fault");
        let soon_back = json!([fault("kill", 3.4, None, Some(400.0))]);
        assert_eq!(why(&soon_back, 3.9), None, "the next one obeys again");
        // Stopped, woken, and killed before it said anything: one outage.
        let twice = json!([
            fault("stop", 3.4, Some(3.7), Some(10.0)),
            fault("kill", 3.65, None, Some(600.0)),
        ]);
        assert!(why(&twice, 3.9).is_some());
        let woken = json!([fault("stop", 3.4, Some(3.7), Some(10.0))]);
        assert_eq!(why(&woken, 3.9), None);
        // Too late to brake when the guard broke: it was driven there before.
        let late = json!([fault("kill", 3.88, None, Some(900.0))]);
        let near = excuse(&hindsight, &run(&eastwards(4.54), &late), &touch(3.9, 0.5));
        assert_eq!(near, None);
        let other = json!([{"id": 1, "kind": "kill", "target": "mapping", "tick": 0, "time_s": 3.4,
                            "until_s": null, "recovery_ms": 900.0}]);
        assert_eq!(why(&other, 3.9), None);
    }
}
