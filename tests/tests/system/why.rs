//! `zeronav why`: what it says of runs in lockstep is true at the right time, and of a running stack now.

use serde_json::Value;
use std::path::{Path, PathBuf};
use zeronav_tests::up::Up;
use zeronav_tests::{Ended, leftovers, real_time_turn, zeronav};

/// A run in lockstep that is over.
struct Run {
    ended: Ended,
    result: Value,
    folder: String,
}

impl Run {
    fn of(scenario: &str) -> Self {
        let ended = zeronav(&["run", scenario, "--lockstep", "--headless", "--json"]);
        let result = ended.expect(0);
        let directory = result["directory"].as_str().expect("a folder");
        let folder = ended.folder.path().join(directory).display().to_string();
        Self {
            ended,
            result,
            folder,
        }
    }

    /// Moments that were kept.
    fn moments(&self) -> &[Value] {
        self.result["reasons"].as_array().expect("reasons")
    }

    /// The time of the first moment that is so. [s]
    #[track_caller]
    fn first(&self, is: impl Fn(&Value) -> bool) -> f64 {
        let found = self.moments().iter().find(|moment| is(moment));
        let found = found.unwrap_or_else(|| panic!("no such moment: {:#?}", self.moments()));
        found["time_s"].as_f64().expect("a time")
    }

    /// What is said of a time. [s]
    #[track_caller]
    fn why(&self, time_s: f64) -> String {
        let ended = zeronav(&["why", &self.folder, &time_s.to_string()]);
        assert_eq!(ended.code(), 0, "{}", ended.stderr);
        ended.stdout
    }

    /// What is said of the end.
    fn end(&self) -> String {
        let ended = zeronav(&["why", &self.folder]);
        assert_eq!(ended.code(), 0, "{}", ended.stderr);
        ended.stdout
    }

    /// Time of the first path with this cause and outcome. [s]
    #[track_caller]
    fn planned(&self, cause: &str, status: &str) -> f64 {
        let plans = self.result["plans"].as_array().expect("paths");
        let is = |plan: &&Value| plan["cause"] == cause && plan["status"] == status;
        let plan = plans.iter().find(is).expect("such a path");
        plan["time_s"].as_f64().expect("a time")
    }
}

#[track_caller]
fn says(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}

/// The numbers in the first pair of parentheses after `words`.
#[track_caller]
fn place_after(text: &str, words: &str) -> [f64; 2] {
    let (_, after) = text
        .split_once(words)
        .unwrap_or_else(|| panic!("no {words}: {text}"));
    let inside = after
        .trim_start_matches(" (")
        .split(')')
        .next()
        .expect("a place");
    let numbers: Vec<f64> = inside
        .split(", ")
        .filter_map(|word| word.parse().ok())
        .collect();
    numbers
        .try_into()
        .unwrap_or_else(|_| panic!("no place after {words}: {text}"))
}

#[test]
fn sealed_rooms_are_proved_shut_by_the_door_that_was_seen_last() {
    let run = Run::of("sealed");
    let time_s = run.planned("obstacle", "unreachable");
    let text = run.why(time_s + 1.0);
    says(
        &text,
        &[
            "the global planner has proved that no way leads to the goal",
            "(unreachable)",
        ],
    );
    // Both doors are at x = 7.95, the one at y = 2.0, the other at 6.8.
    let [x_m, y_m] = place_after(&text, "the last path was cut at");
    assert!((x_m - 7.95).abs() < 0.6, "{text}");
    assert!((y_m - 2.0).abs() < 1.2 || (y_m - 6.8).abs() < 1.2, "{text}");
    says(
        &run.end(),
        &["The task has failed: the global planner has proved"],
    );
    // Before that it took the other door, and says why.
    let text = run.why(run.planned("obstacle", "found") + 0.1);
    says(&text, &["It follows a path of", "because an obstacle at ("]);
}

#[test]
fn a_lidar_that_says_nothing_is_named_as_soon_as_its_scans_are_old() {
    let run = Run::of("blackout_2s");
    let slows_s = run.first(|moment| moment["request"]["cause"] == "ageing");
    says(
        &run.why(slows_s),
        &["slows down to", "because the scan is getting old"],
    );
    // Before the first scan it waits for one, too.
    let stops_s = run.first(|moment| {
        moment["request"]["cause"] == "stale" && moment["time_s"].as_f64() > Some(1.0)
    });
    assert!(slows_s < stops_s, "{slows_s} {stops_s}");
    let text = run.why(stops_s + 0.02);
    says(
        &text,
        &[
            "brakes because the scan is 3",
            " ms old: the robot must send it again.",
        ],
    );
    // It stands until the lidar is back, two seconds after it fell silent.
    let text = run.why(stops_s + 1.0);
    says(&text, &["the robot stands.", "because the scan is"]);
    let drives = |moment: &Value| {
        moment["time_s"].as_f64() > Some(stops_s) && moment["request"]["validity"] == "drive"
    };
    let blind_s = run.first(drives) - stops_s;
    assert!((1.3..2.0).contains(&blind_s), "{blind_s}");
    says(&run.end(), &["The robot has arrived"]);
}

#[test]
fn a_box_in_the_way_is_the_reason_for_another_path() {
    let run = Run::of("drop_box_0_8m");
    let text = run.why(run.planned("obstacle", "found") + 0.05);
    let [x_m, y_m] = place_after(&text, "because an obstacle at");
    let corners = run.result["obstacles"][0]["corners_m"]
        .as_array()
        .expect("corners");
    let middle = |axis: usize| {
        let along = corners.iter().filter_map(|corner| corner[axis].as_f64());
        along.sum::<f64>() / f64::from(u32::try_from(corners.len()).expect("four"))
    };
    let off_m = (x_m - middle(0)).hypot(y_m - middle(1));
    assert!(off_m < 1.2, "{text}");
    says(&run.end(), &["The robot has arrived"]);
}

#[test]
fn a_person_that_crosses_is_named_while_it_is_near() {
    let run = Run::of("crossing_person_1mps");
    let near_s =
        run.first(|moment| moment["request"]["obstacle"]["speed_mps"].as_f64() > Some(0.6));
    let text = run.why(near_s);
    assert!((3.0..9.0).contains(&near_s), "{near_s}");
    let obstacle = &run
        .moments()
        .iter()
        .rfind(|moment| moment["time_s"].as_f64() <= Some(near_s));
    let at = &obstacle.expect("it")["request"]["obstacle"]["at_m"];
    assert!((at[0].as_f64().expect("x") - 7.0).abs() < 0.5, "{at}");
    says(&text, &["At ", "Ages of the inputs: odometry 0 ms, scan "]);
    says(&run.end(), &["The robot has arrived"]);
}

#[test]
fn a_trap_is_left_with_a_reason_at_every_moment() {
    let run = Run::of("u_trap_1m");
    let text = run.why(run.planned("obstacle", "found") + 0.05);
    says(&text, &["because an obstacle at (7."]);
    // Every moment has its sentence.
    let all = zeronav(&["why", &run.folder, "--all"]);
    assert_eq!(
        all.stdout.lines().count(),
        run.moments().len(),
        "{}",
        all.stderr
    );
    for line in all.stdout.lines() {
        assert!(line.starts_with("At ") && line.ends_with('.'), "{line}");
        assert!(!line.contains("it tells no more"), "{line}");
    }
    drop(run.ended);
}

#[test]
fn the_guard_names_the_beam_that_holds_the_robot_back() {
    let run = Run::of("narrow_passage");
    let held_s = run.first(|moment| !moment["command"]["point"].is_null());
    let text = run.why(held_s);
    says(
        &text,
        &[
            "The collision guard ",
            "Beam ",
            " decided: its point is ",
            " from the outline",
        ],
    );
    // The walls of the passage are beside the robot, 3 cm away.
    let moment = run
        .moments()
        .iter()
        .find(|moment| moment["time_s"] == held_s);
    let point = &moment.expect("it")["command"]["point"];
    let clearance_m = point["clearance_m"].as_f64().expect("a distance");
    assert!((-0.05..0.2).contains(&clearance_m), "{point:#}");
    let away_m = point["at_m"][0]
        .as_f64()
        .expect("x")
        .hypot(point["at_m"][1].as_f64().expect("y"));
    assert!(away_m < 1.5, "{point:#}");
}

#[test]
fn the_same_run_has_the_same_reasons() {
    let [one, other] = [Run::of("blackout_0_5s"), Run::of("blackout_0_5s")];
    assert_eq!(one.result["run_hash"], other.result["run_hash"]);
    assert_eq!(one.result["reasons"], other.result["reasons"]);
}

#[test]
fn a_running_stack_is_explained_as_it_is_now() {
    let _turn = real_time_turn();
    let mut up = Up::start(&["open_aisle"]);
    says(
        &up.ask(&["why"], 0),
        &["the robot stands.", "There is no goal"],
    );
    let time_s = |report: &Value| report["time_s"].as_f64().expect("a time");
    up.stack
        .wait_until("it has stood for two seconds", |stack| {
            stack.report().is_some_and(|report| time_s(&report) > 2.0)
        });
    up.ask(
        &["goal", "12.5", "6.425", "0", "--yaw-tolerance", "3.15"],
        0,
    );
    up.stack.wait_until("it drives", |stack| {
        let report = stack.report().unwrap_or_default();
        report["pose"][0].as_f64() > Some(4.5)
    });
    let text = up.ask(&["why"], 0);
    says(
        &text,
        &[
            "the robot drives at ",
            "It follows a path of",
            "because the goal was given",
        ],
    );
    let json: Value = serde_json::from_str(&up.ask(&["why", "--json"], 0)).expect("JSON");
    assert_eq!(json["moment"]["path"]["status"], "found", "{json:#}");
    assert_eq!(json["missing"], serde_json::json!([]), "{json:#}");
    up.ask(&["pause"], 0);
    says(&up.ask(&["why"], 0), &["Run time is paused"]);
    // It stood before the goal came, and the stack still knows why; of before its start it does not.
    let now_s = time_s(&up.status());
    let driving = up.ask(&["why", "--ago", "1"], 0);
    says(
        &driving,
        &["the robot drives at ", "because the goal was given"],
    );
    let before = format!("{:.2}", now_s - 1.0);
    let before = up.ask(&["why", "--ago", &before], 0);
    says(&before, &["the robot stands."]);
    let never = up.ask(&["why", "--ago", "9999"], 2);
    says(&never, &["no history for 9999 s ago"]);
    up.ask(&["resume"], 0);
    up.ask(&["fault", "kill", "local_planner"], 0);
    let text = up.ask(&["why"], 0);
    says(
        &text,
        &["The local planner ", "made on purpose: kill local_planner"],
    );
    up.ask(&["cancel"], 0);
    up.down();
}

#[test]
fn mistakes_are_answered_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("result.json"), "{\"verdict\": 7}").expect("written");
    let broken = folder.path().to_str().expect("a path");
    for (words, said) in [
        (vec!["--domain", "/dev/shm/zn_nothing000"], "no such folder"),
        (vec!["/nowhere/at/all"], "/nowhere/at/all"),
        (vec![broken], "not the result of a run"),
        (vec![broken, "-3"], "-3"),
        (vec![broken, "soon"], "a time is from 0 to"),
        (vec!["--ago", "1e308"], "a time is from 0 to"),
        (vec!["12.5"], "no run is in runs"),
    ] {
        let ended = zeronav(&[&["why"][..], &words].concat());
        assert_eq!(ended.code(), 2, "{words:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(said), "{words:?}: {}", ended.stderr);
        assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
        assert_eq!(ended.stdout, "");
    }
    let run = Run::of("goal_near_wall_20cm");
    let late = zeronav(&["why", &run.folder, "9999"]);
    assert_eq!(late.code(), 2);
    says(&late.stderr, &["the run was over after"]);
    assert_eq!(
        leftovers(Path::new("/dev/shm/zn_nothing000")),
        Vec::<PathBuf>::new()
    );
}
