//! Kill it, stop it: every service comes back, the robot is safe meanwhile and still arrives.

use rustix::process::Signal;
use serde_json::Value;
use zeronav_tests::rooms::box_in_an_aisle;
use zeronav_tests::{Zeronav, leftovers, send_signal, shipped};

/// The services that may die; the robot may not.
const MORTALS: [&str; 4] = [
    "mapping",
    "global_planner",
    "local_planner",
    "collision_guard",
];

/// A small generator (PCG-like), so that kills can be repeated by seed.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(self.0 >> 33).expect("31 bits") % sides
    }
}

/// Drives a scenario with these lines more and without its expectation of a cause: a planner that
/// restarts behind what has come has nothing to replan.
fn drive(text: &str, more: &str) -> Zeronav {
    let folder = tempfile::tempdir().expect("a folder");
    let text = text.replace("obstacle_replans_min = 1", "");
    std::fs::write(folder.path().join("it.toml"), format!("{text}\n{more}")).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    let mut run = Zeronav::start_in(folder, &arguments);
    run.wait_until("the drive has begun", |run| run.report().is_some());
    run
}

/// Sends `signal` to the service in the seat `role` at the run time `time_s` or soon after; false
/// when the run was over before.
fn strike(run: &mut Zeronav, role: &str, signal: Signal, time_s: f64) -> bool {
    while !run.has_ended() {
        // Whoever asks without a pause takes the processor from who drives.
        std::thread::sleep(std::time::Duration::from_millis(5));
        let Some(report) = run.report() else { continue };
        if report["time_s"]
            .as_f64()
            .is_some_and(|now_s| now_s >= time_s)
        {
            let services = report["services"].as_array().cloned().unwrap_or_default();
            let seat = services.iter().find(|service| service["role"] == role);
            let pid = seat.and_then(|service| service["pid"].as_u64());
            return pid.is_some_and(|pid| send_signal(u32::try_from(pid).unwrap_or(0), signal));
        }
    }
    false
}

/// The result of a run that must have arrived safely.
fn arrived(run: Zeronav) -> Value {
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    result
}

fn restarts(result: &Value) -> Vec<String> {
    let restarts = result["restarts"].as_array().expect("restarts");
    restarts
        .iter()
        .map(|restart| restart["service"].as_str().expect("a name").to_owned())
        .collect()
}

#[test]
fn every_service_may_be_killed_in_the_middle_of_a_drive() {
    for role in MORTALS {
        // Whoever is slow because the machine is busy shall not be taken for hung here.
        let mut run = drive(&box_in_an_aisle(), "[restart]\nhang_after_s = 10.0\n");
        assert!(
            strike(&mut run, role, Signal::KILL, 3.0),
            "{role} was not there"
        );
        let result = arrived(run);
        assert_eq!(restarts(&result), [role]);
        // The scenario knows nothing of it.
        assert_eq!(result["reproducible"], false, "{result:#}");
        let why = result["not_reproducible"][0].as_str().unwrap_or_default();
        assert_eq!(why, format!("{role} killed by signal 9"));
    }
}

#[test]
fn every_service_may_hang_in_the_middle_of_a_drive() {
    for role in MORTALS {
        let mut run = drive(&box_in_an_aisle(), "[restart]\nhang_after_s = 2.0\n");
        assert!(
            strike(&mut run, role, Signal::STOP, 3.0),
            "{role} was not there"
        );
        let result = arrived(run);
        assert_eq!(restarts(&result), [role]);
        let how = result["restarts"][0]["how"]
            .as_str()
            .expect("a reason")
            .to_owned();
        assert!(how.contains("no progress"), "{how}");
    }
}

/// The load drops while no process makes a map: the local planner brakes for what the scan shows, and
/// with the new mapping comes a new path.
#[test]
fn without_mapping_the_guard_brakes_for_the_scan() {
    // Mapping stays away for three seconds, in which the load drops. An old map alone would stop
    // the robot before; here it may be as old as it likes.
    let mut run = drive(
        &shipped("blocked_aisle"),
        "[restart]\nabsent_ticks = 150\n\
         [services.local_planner]\nconfig.staleness.map_age_s = 10.0\n",
    );
    assert!(
        strike(&mut run, "mapping", Signal::KILL, 4.5),
        "mapping was not there"
    );
    let result = arrived(run);
    assert_eq!(restarts(&result), ["mapping"]);
    let gone_s = result["restarts"][0]["time_s"].as_f64().expect("a time");
    let plans = result["plans"].as_array().expect("plans");
    let around = plans
        .iter()
        .find(|plan| plan["cause"] == "obstacle")
        .expect("a new path");
    let planned_s = around["time_s"].as_f64().expect("a time");
    let back_s = gone_s + 3.0;
    eprintln!("mapping gone at {gone_s} s, back at {back_s} s, new path at {planned_s} s");
    assert!(planned_s <= back_s + 1.0, "no new path within a second");
}

/// What moved when mapping died is known while the map grows old.
#[test]
fn what_moves_is_known_while_there_is_no_mapping() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = shipped("moving_discs");
    let more = "[restart]\nabsent_ticks = 45\n\
                [[faults]]\nkind = \"kill\"\nservice = \"mapping\"\nbegins = { at_s = 4.6 }\n";
    std::fs::write(folder.path().join("it.toml"), format!("{text}\n{more}")).expect("written");
    let arguments = [
        "run",
        "./it.toml",
        "--lockstep",
        "--headless",
        "--json",
        "--seed",
        "1",
    ];
    let result = Zeronav::start_in(folder, &arguments).finish().expect(0);
    assert_eq!(result["contacts"], 0, "{result:#}");
    // A disc is near before, and all the time until the successor's first map.
    let moments = result["reasons"].as_array().expect("moments");
    let around: Vec<&Value> = (moments.iter())
        .filter(|moment| {
            let time_s = moment["time_s"].as_f64().expect("a time");
            (4.4..5.55).contains(&time_s) && !moment["request"].is_null()
        })
        .map(|moment| &moment["request"])
        .collect();
    let age_ms = |request: &Value| request["ages_ms"][2].as_u64().expect("an age");
    let oldest_ms = around.iter().map(|request| age_ms(request)).max();
    assert!(oldest_ms > Some(600), "the map was {oldest_ms:?} ms old");
    let unknown = around.iter().find(|it| it["obstacle"].is_null());
    assert!(unknown.is_none(), "{unknown:?}");
}

/// The seat that is empty owes no answer, so that the time limit ends the run and not its silence.
#[test]
fn the_time_limit_ends_a_run_in_which_a_seat_is_empty() {
    let text = box_in_an_aisle();
    let shorter = text.replace("time_limit_s = 60.0", "time_limit_s = 6.0");
    assert_ne!(shorter, text, "the scenario has another time limit");
    let mut run = drive(&shorter, "[restart]\nabsent_ticks = 1000\n");
    assert!(
        strike(&mut run, "mapping", Signal::KILL, 3.0),
        "mapping was not there"
    );
    let result = run.finish().expect(1);
    assert_eq!(restarts(&result), ["mapping"]);
    assert_eq!(result["outcome"], "timeout", "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
}

#[test]
fn forty_kills_and_every_goal_is_reached() {
    let seed = 20_260_101;
    eprintln!("seed {seed}");
    let mut dice = Dice(seed);
    let (mut kills, mut drives) = (0, 0);
    while kills < 40 {
        let mut run = drive(&shipped("door_closes"), "");
        let root = run
            .report()
            .and_then(|report| report["domain"].as_str().map(str::to_owned));
        let mut time_s = 0.5;
        let mut struck = 0;
        for _ in 0..8 {
            let role = MORTALS[dice.roll(MORTALS.len())];
            time_s += 1.5 + 0.1 * f64::from(u32::try_from(dice.roll(30)).expect("small"));
            struck += usize::from(strike(&mut run, role, Signal::KILL, time_s));
        }
        let result = arrived(run);
        let restarted = restarts(&result).len();
        assert!(
            restarted + 1 >= struck,
            "{struck} kills, {restarted} restarts: {result:#}"
        );
        kills += restarted;
        drives += 1;
        if let Some(root) = root {
            let left = leftovers(std::path::Path::new(&root));
            assert!(left.is_empty(), "{left:?}");
        }
    }
    eprintln!("{kills} kills in {drives} drives");
}
