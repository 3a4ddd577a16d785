//! Swaps while a stack drives, on the real processes: the newcomer takes over without a gap, and one
//! that fails gives the seat back.

use rustix::process::Signal;
use serde_json::Value;
use zeronav_tests::up::Up;
use zeronav_tests::{Zeronav, quiet_turn, real_time_turn, send_signal};

/// The seats that can be swapped.
const SEATS: [&str; 4] = [
    "mapping",
    "global_planner",
    "local_planner",
    "collision_guard",
];

/// Swaps of each seat; 20 and more are made with `ZERONAV_SWAPS=20`.
fn swaps_per_seat() -> usize {
    let wished = std::env::var("ZERONAV_SWAPS").ok();
    wished.map_or(1, |text| text.parse().expect("a number of swaps"))
}

/// A stack that drives to and fro in an aisle until it is ended.
fn driving() -> Up {
    let folder = tempfile::tempdir().expect("a folder");
    let goals = "[[goals]]\npose = [24.0, 8.5, 0.0]\n[[goals]]\npose = [4.0, 8.5, 3.1416]\n";
    let file = folder.path().join("to_and_fro.toml");
    std::fs::write(&file, goals).expect("written");
    let up = Up::start_in(folder, &["open_aisle"]);
    up.ask(&["goals", file.to_str().expect("a path"), "--loop"], 0);
    up
}

/// Runs a swap to its end.
fn swap(up: &Up, arguments: &[&str], code: i32) -> Value {
    let lines = up.lines(&[&["swap"], arguments].concat(), code);
    lines.last().expect("a line").clone()
}

/// Waits until the swap that goes on is in this state; the swap.
fn swap_in_state(up: &mut Up, state: &str) -> Value {
    let what = format!("the swap is in state {state}");
    up.stack.wait_until(&what, |stack| {
        let report = stack.report();
        report.is_some_and(|report| report["swap"]["state"] == state)
    });
    up.status()["swap"].clone()
}

/// Most tries of a swap: a machine that is busy with other things misses periods by itself.
const TRIES_MAX: usize = 3;

/// Runs `swap` until no velocity command was later than two periods; the last one.
fn without_a_gap(mut swap: impl FnMut() -> Value) -> Value {
    let mut gaps = Vec::new();
    for _ in 0..TRIES_MAX {
        let swap = swap();
        let gap = swap["command_gap_ticks"].as_u64().expect("ticks");
        gaps.push(gap);
        if (1..=2).contains(&gap) {
            return swap;
        }
    }
    panic!("ticks from command to command: {gaps:?}");
}

fn process<'a>(report: &'a Value, role: &str) -> Vec<&'a Value> {
    let services = report["services"].as_array().expect("services");
    let of = |service: &&Value| service["role"] == role;
    services.iter().filter(of).collect()
}

#[test]
fn every_seat_is_swapped_while_the_robot_drives_and_no_period_is_missed() {
    let _turn = quiet_turn();
    let up = driving();
    for round in 0..swaps_per_seat() {
        for seat in SEATS {
            let mut before = Value::Null;
            let swapped = without_a_gap(|| {
                before = up.status();
                swap(&up, &[seat, "--shadow", "500ms", "--keep", "500ms"], 0)
            });
            assert_eq!(swapped["state"], "swapped", "{swapped}");
            let found = &swapped["comparison"];
            assert!(found["ticks"].as_u64() > Some(3), "{swapped}");
            assert!(
                found["newcomer"]["p50_us"].as_f64() > Some(0.0),
                "{swapped}"
            );
            let after = up.status();
            let (old, new) = (process(&before, seat), process(&after, seat));
            assert_eq!((old.len(), new.len()), (1, 1), "{after}");
            assert_ne!(old[0]["pid"], new[0]["pid"]);
            assert_eq!(new[0]["pid"], swapped["pid"]);
            eprintln!("round {round}: {seat} swapped, {swapped}");
        }
    }
    swap(&up, &[SEATS[0], "--shadow", "500ms", "--keep", "500ms"], 0);
    up.ask(&["cancel"], 0);
    // In use is the configuration of the newest swap of each seat; those before it are gone.
    assert_eq!(configurations_of_swaps(&up), SEATS.len());
    let result = up.down();
    assert_eq!(result["contacts"], 0, "{result}");
    assert_eq!(result["restarts"].as_array().map(Vec::len), Some(0));
    let swaps = result["swaps"].as_array().expect("swaps");
    assert!(swaps.len() > (4 * swaps_per_seat()).min(99));
}

/// Files that swaps have left in the domain.
fn configurations_of_swaps(up: &Up) -> usize {
    let files = std::fs::read_dir(&up.root).expect("a domain").flatten();
    let of_swap = |file: &std::fs::DirEntry| file.file_name().to_string_lossy().contains(".swap");
    files.filter(of_swap).count()
}

/// Swaps a seat and breaks the newcomer once it is obeyed; the swap, rolled back.
fn broken_in_office(up: &mut Up, seat: &str, signal: Signal) -> Value {
    let before = process(&up.status(), seat)[0]["pid"].clone();
    let command = ["swap", seat, "--shadow", "0s", "--keep", "30s", "--no-wait"];
    up.ask(&command, 0);
    let kept = swap_in_state(up, "keep");
    let pid = kept["pid"].as_u64().and_then(|pid| u32::try_from(pid).ok());
    let cut_over = kept["cut_over_tick"].as_u64().expect("a tick");
    up.stack.wait_until("the newcomer is obeyed", |stack| {
        let report = stack.report();
        report.is_some_and(|report| report["tick"].as_u64() > Some(cut_over + 5))
    });
    assert!(
        send_signal(pid.expect("a pid"), signal),
        "{}",
        up.status()["swap"]
    );
    let back = swap_in_state(up, "rolled_back");
    assert!(back["why"].as_str().is_some_and(|why| !why.is_empty()));
    assert!(back["roll_back_tick"].as_u64() > Some(cut_over), "{back}");
    let after = up.status();
    assert_eq!(process(&after, seat)[0]["pid"], before, "{after}");
    back
}

#[test]
fn a_newcomer_that_dies_or_hangs_in_the_seat_gives_it_back() {
    let _turn = quiet_turn();
    let mut up = driving();
    for (seat, signal) in [
        ("collision_guard", Signal::KILL),
        ("collision_guard", Signal::STOP),
        ("local_planner", Signal::KILL),
        ("local_planner", Signal::STOP),
        ("global_planner", Signal::KILL),
        ("mapping", Signal::STOP),
    ] {
        let back = without_a_gap(|| broken_in_office(&mut up, seat, signal));
        eprintln!("{seat}, {signal:?}: {back}");
    }
    let result = up.down();
    assert_eq!(result["contacts"], 0, "{result}");
    assert_eq!(result["restarts"].as_array().map(Vec::len), Some(0));
}

/// It is warm and silent while it is compared, so that only what it does in the seat tells.
#[test]
fn a_newcomer_that_lies_in_the_seat_gives_it_back() {
    let _turn = real_time_turn();
    let up = driving();
    for (seat, liar, why) in [
        ("local_planner", "nan_once_obeyed", "rejected"),
        ("global_planner", "through_walls_once_obeyed", "obstacle"),
    ] {
        let before = process(&up.status(), seat)[0]["pid"].clone();
        let back = swap(&up, &[seat, liar, "--shadow", "0s", "--keep", "30s"], 1);
        assert_eq!(back["state"], "rolled_back", "{back}");
        let said = back["why"].as_str().unwrap_or_default();
        assert!(said.contains(why), "{seat}: {back}");
        // A cut-over is announced three ticks ahead. A lie that is found before its tick prevents it.
        let tick = |name: &str| back[name].as_u64().expect("a tick");
        assert!(tick("roll_back_tick") + 3 > tick("cut_over_tick"), "{back}");
        assert_eq!(process(&up.status(), seat)[0]["pid"], before);
    }
    // It is missed at the ticks that the robot has begun, whatever it claims.
    let before = process(&up.status(), "collision_guard")[0]["pid"].clone();
    let liar = [
        "collision_guard",
        "ahead_once_obeyed",
        "--shadow",
        "0s",
        "--keep",
        "30s",
    ];
    let back = swap(&up, &liar, 1);
    assert_eq!(back["state"], "rolled_back", "{back}");
    let said = back["why"].as_str().unwrap_or_default();
    assert!(said.contains("it has answered tick"), "{back}");
    assert_eq!(process(&up.status(), "collision_guard")[0]["pid"], before);
    assert_eq!(configurations_of_swaps(&up), 0);
    // The drive goes on under those who were there before.
    let result = up.down();
    assert_eq!(result["contacts"], 0, "{result}");
    assert_eq!(result["restarts"].as_array().map(Vec::len), Some(0));
}

#[test]
fn a_newcomer_that_cannot_do_the_work_is_rejected_and_the_drive_goes_on() {
    let _turn = real_time_turn();
    let up = driving();
    let before = up.status();
    let set = ["--set", "planner=teleport"];
    let teleport = [&["global_planner"], &set[..]].concat();
    for (arguments, why) in [
        (&teleport[..], "teleport"),
        (&["global_planner", "crashes_at_start"], "exit code"),
        (&["global_planner", "hangs_after_start"], "no progress"),
        (&["local_planner", "requests_nan"], "rejected"),
        (
            &["collision_guard", "--shadow", "1s", "--require", "p99<1us"],
            "p99<1us is not met",
        ),
    ] {
        let rejected = swap(&up, arguments, 1);
        assert_eq!(rejected["state"], "rejected", "{rejected}");
        let said = rejected["why"].as_str().unwrap_or_default();
        assert!(said.contains(why), "{arguments:?}: {rejected}");
        assert_eq!(rejected["cut_over_tick"], Value::Null);
    }
    // What cannot be asked for changes nothing either.
    for (arguments, why) in [
        (&["swap", "robot"][..], "not swapped"),
        (&["swap", "mapping", "no-such-binary"], "no-such-binary"),
        (&["swap", "mapping", "--require", "p98<1ms"], "p98<1ms"),
        (&["swap", "mapping", "--keep", "0s"], "0.5"),
        (&["swap", "--cancel"], "no swap goes on"),
    ] {
        let said = up.ask(arguments, 2);
        assert!(said.contains(why), "{arguments:?}: {said}");
    }
    let after = up.status();
    for seat in SEATS {
        assert_eq!(
            process(&before, seat)[0]["pid"],
            process(&after, seat)[0]["pid"]
        );
    }
    let result = up.down();
    assert_eq!(result["contacts"], 0, "{result}");
}

#[test]
fn a_swap_survives_a_restart_of_the_process_in_the_seat_and_a_second_swap_waits() {
    let _turn = real_time_turn();
    let mut up = driving();
    let command = [
        "swap",
        "local_planner",
        "--shadow",
        "3s",
        "--keep",
        "500ms",
        "--no-wait",
    ];
    up.ask(&command, 0);
    assert!(up.ask(&["swap", "local_planner"], 2).contains("goes on"));
    assert!(up.ask(&["swap", "mapping"], 2).contains("goes on"));
    swap_in_state(&mut up, "shadow");
    up.ask(&["fault", "kill", "local_planner"], 0);
    let swapped = swap_in_state(&mut up, "swapped");
    assert_eq!(
        process(&up.status(), "local_planner")[0]["pid"],
        swapped["pid"]
    );
    // A parameter changes by the same binary with another configuration, and stays.
    let set = [
        "local_planner",
        "--set",
        "controller=dwa",
        "--shadow",
        "0s",
        "--keep",
        "500ms",
    ];
    assert_eq!(swap(&up, &set, 0)["state"], "swapped");
    up.ask(&["fault", "kill", "local_planner"], 0);
    up.stack.wait_until("its successor is ready", |stack| {
        let report = stack.report().unwrap_or_default();
        let found = process(&report, "local_planner");
        found.len() == 1 && found[0]["state"] == "ready" && found[0]["epoch"].as_u64() > Some(4)
    });
    let result = up.down();
    assert_eq!(result["contacts"], 0, "{result}");
    assert_eq!(result["restarts"].as_array().map(Vec::len), Some(2));
}

#[test]
fn a_shadow_is_compared_until_it_is_ended() {
    let _turn = real_time_turn();
    let up = driving();
    let lines = up.lines(&["shadow", "global_planner", "--for", "2s"], 0);
    let compared = lines.last().expect("a line");
    assert_eq!(compared["state"], "compared", "{compared}");
    assert!(
        compared["comparison"]["agree"].as_f64() > Some(0.8),
        "{compared}"
    );
    // No process answers within a nanosecond, and 1 s of ticks is enough for a median.
    let never = ["--for", "1s", "--require", "p50<0.001us"];
    let lines = up.lines(&[&["shadow", "local_planner"], &never[..]].concat(), 1);
    let rejected = lines.last().expect("a line");
    assert_eq!(rejected["state"], "rejected", "{rejected}");
    up.down();
}

/// A lockstep drive with these lines in its scenario; its result.
fn lockstep(lines: &str) -> Value {
    lockstep_to(6.425, [[7.0, 6.425], [12.5, 6.425]], lines)
}

/// One from x = 4 m and this y to these places. [m]
fn lockstep_to(y_m: f64, goals_m: [[f64; 2]; 2], lines: &str) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let goal = |[x_m, y_m]: [f64; 2]| format!("[[goals]]\npose = [{x_m:.1}, {y_m:.3}, 0.0]\n");
    let goals = goals_m.map(goal).concat();
    let text = format!(
        "title = \"a swap\"\nbase = [\"warehouse\", \"porter\"]\nstart = [4.0, {y_m:.3}, 0.0]\n\
         run.time_limit_s = 60.0\n{goals}{lines}"
    );
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    Zeronav::start_in(folder, &arguments).finish().expect(0)
}

#[test]
fn a_lockstep_run_with_swaps_is_bit_identical() {
    for seat in SEATS {
        let lines =
            format!("[[swaps]]\nservice = \"{seat}\"\nat_s = 2.0\nshadow_s = 0.6\nkeep_s = 0.6\n");
        let [first, second] = [lockstep(&lines), lockstep(&lines)];
        assert_eq!(first["swaps"][0]["state"], "swapped", "{}", first["swaps"]);
        // The newcomer hears the tick after 2.0 s first, and is obeyed 0.6 s later.
        assert_eq!(first["swaps"][0]["warm_tick"], 101);
        assert_eq!(first["swaps"][0]["cut_over_tick"], 131);
        assert_eq!(first["run_hash"], second["run_hash"], "{seat}");
        assert_eq!(first["contacts"], 0);
    }
}

/// A newcomer takes over when the process in the seat is there to come back to. The fault after the
/// swap is made when every seat has answered: nobody may owe what nobody has heard.
#[test]
fn a_lockstep_swap_waits_for_the_successor_of_the_process_in_the_seat() {
    let fault = |kind: &str, seat: &str, at_s: f64| {
        format!(
            "[[faults]]\nkind = \"{kind}\"\nservice = \"{seat}\"\nbegins = {{ at_s = {at_s} }}\n"
        )
    };
    let seat = "collision_guard";
    let faults = [
        fault("kill", seat, 2.0),
        fault("stop", seat, 3.2),
        fault("kill", "mapping", 3.6),
    ];
    let swap =
        format!("[[swaps]]\nservice = \"{seat}\"\nat_s = 2.4\nshadow_s = 0.5\nkeep_s = 1.0\n");
    let faults = faults.concat();
    let result = lockstep(&format!("[restart]\nabsent_ticks = 150\n{faults}{swap}"));
    let swapped = &result["swaps"][0];
    assert_eq!(swapped["state"], "swapped", "{swapped}");
    let cut_over = swapped["cut_over_tick"].as_u64();
    assert!(cut_over > Some(250), "it came back at 5 s: {swapped}");
    assert_eq!(result["contacts"], 0);
}

/// What a newcomer sends is judged after each tick while the robot is held there.
#[test]
fn a_lockstep_run_with_a_rollback_is_bit_identical() {
    // Along an aisle, and around the corner of the racks between two of them.
    for (seat, liar, y_m, goals_m, why) in [
        (
            "local_planner",
            "nan_once_obeyed",
            6.425,
            [[9.5, 6.425], [10.0, 6.425]],
            "rejected",
        ),
        (
            "global_planner",
            "through_walls_once_obeyed",
            8.5,
            [[9.5, 13.575], [10.0, 13.575]],
            "obstacle",
        ),
    ] {
        let lines = format!(
            "[[swaps]]\nservice = \"{seat}\"\nat_s = 2.0\nshadow_s = 0.1\nkeep_s = 3.0\n\
             binary = \"{liar}\"\n"
        );
        let runs = [(); 2].map(|()| lockstep_to(y_m, goals_m, &lines));
        for run in &runs {
            let swap = &run["swaps"][0];
            assert_eq!(swap["state"], "rolled_back", "{swap}");
            let said = swap["why"].as_str().unwrap_or_default();
            assert!(said.contains(why), "{swap}");
            let ticks = ["cut_over_tick", "roll_back_tick"];
            for tick in ticks {
                assert!(swap[tick].is_u64(), "{swap}");
                assert_eq!(swap[tick], runs[0]["swaps"][0][tick], "{seat}: {tick}");
            }
            assert_eq!(run["run_hash"], runs[0]["run_hash"], "{seat}: {swap}");
            assert_eq!(run["reproducible"], true, "{run:#}");
            assert_eq!(run["contacts"], 0, "{run:#}");
        }
    }
}

/// A newcomer that dies does so when it likes; one that cannot be started may be the next time.
#[test]
fn a_lockstep_run_whose_swap_was_decided_by_the_clock_says_so() {
    let swap = "[[swaps]]\nservice = \"local_planner\"\nat_s = 2.0\nshadow_s = 0.1\nkeep_s = 1.0\n";
    let swapped = lockstep(swap);
    assert_eq!(swapped["swaps"][0]["state"], "swapped", "{swapped:#}");
    assert_eq!(swapped["reproducible"], true, "{swapped:#}");
    let fails = |binary: &str, outcome: &str, why: &str| {
        let run = lockstep(&format!("{swap}binary = \"{binary}\"\n"));
        assert_eq!(run["swaps"][0]["state"], outcome, "{}", run["swaps"]);
        assert_eq!(run["reproducible"], false, "{run:#}");
        let words = outcome.replace('_', " ");
        let said = run["not_reproducible"][0].as_str().unwrap_or_default();
        let start = format!("a newcomer of local_planner was {words}: ");
        assert!(said.starts_with(&start) && said.contains(why), "{said}");
        assert_eq!(run["contacts"], 0, "{run:#}");
    };
    fails("crashes_at_start", "rejected", "exit code");
    fails("dies_once_obeyed", "rolled_back", "exit code");
}

/// The second swap is due in the period at which the first one ends, and its comparison ends before
/// the next scan comes.
#[test]
fn lockstep_swaps_without_a_pause_between_them_go_on() {
    let lines = "[[swaps]]\nservice = \"mapping\"\nat_s = 2.0\nshadow_s = 0.61\nkeep_s = 0.61\n\
                 [[swaps]]\nservice = \"global_planner\"\nat_s = 3.22\nshadow_s = 0.05\nkeep_s = 0.61\n";
    let [first, second] = [lockstep(lines), lockstep(lines)];
    for swap in first["swaps"].as_array().expect("swaps") {
        assert_eq!(swap["state"], "swapped", "{swap}");
    }
    assert_eq!(first["swaps"].as_array().map(Vec::len), Some(2));
    assert_eq!(first["run_hash"], second["run_hash"]);
}

/// The planner dies while the robot waits for the newcomer. When it has answered the last scan by
/// then, the comparison ends before the next one, the first that its successor has to answer.
#[test]
fn a_lockstep_swap_goes_on_when_the_process_in_the_seat_dies() {
    let lines = "[[swaps]]\nservice = \"global_planner\"\nat_s = 2.0\nshadow_s = 0.08\nkeep_s = 0.6\n\
                 [[faults]]\nkind = \"kill\"\nservice = \"global_planner\"\nbegins = { at_s = 2.0 }\n";
    let result = lockstep(lines);
    let swap = &result["swaps"][0];
    assert_eq!(swap["state"], "swapped", "{swap}");
    assert_eq!(result["restarts"][0]["service"], "global_planner");
    assert_eq!(result["contacts"], 0);
}

#[test]
fn a_predecessor_that_hangs_is_ended_and_the_newcomer_stays() {
    let _turn = real_time_turn();
    let mut up = driving();
    let seat = "local_planner";
    let before = process(&up.status(), seat)[0]["pid"].clone();
    let command = ["swap", seat, "--shadow", "0s", "--keep", "60s", "--no-wait"];
    up.ask(&command, 0);
    let kept = swap_in_state(&mut up, "keep");
    let old = before.as_u64().and_then(|pid| u32::try_from(pid).ok());
    assert!(send_signal(old.expect("a pid"), Signal::STOP));
    let swapped = swap_in_state(&mut up, "swapped");
    let after = up.status();
    assert_eq!(process(&after, seat)[0]["pid"], kept["pid"], "{after}");
    assert_eq!(process(&after, seat).len(), 1, "{after}");
    assert!(swapped["why"].is_null(), "{swapped}");
    up.ask(&["cancel"], 0);
    let result = up.down();
    assert_eq!(result["contacts"], 0, "{result}");
    assert_eq!(result["restarts"].as_array().map(Vec::len), Some(0));
}

#[test]
fn a_shadow_for_the_whole_run_changes_nothing() {
    let plain = lockstep("");
    let shadow = lockstep("[services.local_planner.shadow]\nconfig.controller = \"dwa\"\n");
    assert_eq!(plain["run_hash"], shadow["run_hash"]);
    let found = &shadow["swaps"][0];
    assert!(found["comparison"]["ticks"].as_u64() > Some(100), "{found}");
    let measures = &found["comparison"]["measures"];
    assert!(
        measures["v_difference_mps_max"].as_f64() > Some(0.01),
        "{found}"
    );
}
