//! Every service with every fault, and many random faults in one long drive.

use rustix::process::Signal;
use serde_json::{Value, json};
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::time::{Duration, Instant};
use zeronav_tests::faults::{
    DISTURBED_EVERY_S, KINDS, SERVICES, disturbances, effect, fault, one_after_another, scenario,
};
use zeronav_tests::up::Up;
use zeronav_tests::{Zeronav, children_of, leftovers, real_time_turn, services_of};

/// Faults that come twice a second make a long drive slow: no run takes longer.
const LONG: Duration = Duration::from_secs(3600);

/// Drives in real time beside each other in one turn.
const SIDE_BY_SIDE: usize = 3;

fn folder_with(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    folder
}

/// A lockstep drive that must have arrived without a contact, and left nothing behind.
fn drive(text: &str) -> Value {
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    let mut run = Zeronav::start_in(folder_with(text), &arguments);
    run.wait_until("it has a domain", |run| !run.domains().is_empty());
    let root = run.domains().remove(0);
    let started = Instant::now();
    while !run.has_ended() && started.elapsed() < LONG {
        std::thread::sleep(Duration::from_millis(5));
    }
    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{}", result["reason"]);
    assert_eq!(result["contacts"], 0, "{}", result["touches"]);
    assert!(leftovers(&root).is_empty(), "{:?}", leftovers(&root));
    result
}

#[test]
fn every_service_survives_every_fault() {
    eprintln!("fault                      recovery [ms]  stop [m]  stood [s]  lowest [m/s]");
    for service in SERVICES {
        for kind in KINDS {
            let result = drive(&scenario(1, &fault(kind, service, 3.0)));
            let broken = &result["faults"][0];
            let recovery_ms = broken["recovery_ms"].as_f64().expect("an answer");
            let seen = effect(&result, 0, 5.0);
            eprintln!(
                "{:<26} {recovery_ms:13.0}  {:>8}  {:9.1}  {:12.2}",
                format!("{kind} {service}"),
                (seen.stop_m).map_or_else(|| "-".to_owned(), |stop_m| format!("{stop_m:.2}")),
                seen.stood_s,
                seen.v_mps_min
            );
            let restarts = result["restarts"].as_array().map_or(0, Vec::len);
            assert_eq!(restarts, usize::from(kind != "slow"), "{kind} {service}");
            if kind == "slow" {
                assert_eq!(seen.stop_m, None, "lockstep waits for a late answer");
            } else {
                // Without requests the guard brakes, without commands the robot does. Old paths and maps
                // are good for longer than the seat is empty.
                let brakes = ["local_planner", "collision_guard"].contains(&service);
                assert_eq!(seen.v_mps_min < 0.7, brakes, "{kind} {service}: {seen:?}");
            }
        }
    }
}

/// In drives in real time side by side, which are judged by ground truth as a whole.
#[test]
fn every_topic_survives_every_disturbance_and_every_service_a_wrong_clock() {
    let _turn = real_time_turn();
    let faults = disturbances();
    let runs: Vec<(Zeronav, Vec<String>)> = (faults.chunks(faults.len().div_ceil(SIDE_BY_SIDE)))
        .map(|some| {
            let (lines, names) = one_after_another(some);
            let text = scenario(2 + names.len() / 3, &lines);
            let arguments = ["run", "./it.toml", "--headless", "--json"];
            (Zeronav::start_in(folder_with(&text), &arguments), names)
        })
        .collect();
    eprintln!(
        "fault                                         recovery [ms]  stop [m]  lowest [m/s]"
    );
    for (run, names) in runs {
        let result = run.finish().expect(0);
        assert_eq!(result["reached"], true, "{}", result["reason"]);
        assert_eq!(result["contacts"], 0, "{}", result["touches"]);
        assert_eq!(result["restarts"].as_array().map(Vec::len), Some(0));
        for (index, name) in names.iter().enumerate() {
            let fault = &result["faults"][index];
            let recovery_ms = fault["recovery_ms"].as_f64();
            let seen = effect(&result, index, DISTURBED_EVERY_S);
            eprintln!(
                "{name:<45} {:>13}  {:>8}  {:12.2}",
                recovery_ms.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.0}")),
                (seen.stop_m).map_or_else(|| "-".to_owned(), |stop_m| format!("{stop_m:.2}")),
                seen.v_mps_min
            );
            assert_eq!(fault["why"], Value::Null, "{fault}");
            // 0 when the seat has answered before launch takes notice that the fault is over.
            assert!(recovery_ms.is_some(), "{name}: {fault}");
        }
    }
}

/// Goals to and fro with this many random faults before `until_s`.
fn soak(n_goals: usize, n_faults: usize, until_s: f64) {
    let lines = format!("[random_faults]\ncount = {n_faults}\nuntil_s = {until_s:?}\n");
    let result = drive(&scenario(n_goals, &lines));
    let made = result["faults"].as_array().expect("faults");
    assert_eq!(made.len(), n_faults, "the drive was over before");
    let refused = made.iter().find(|fault| !fault["why"].is_null());
    assert_eq!(refused, None);
    eprintln!(
        "{n_faults} faults, {} restarts, {n_goals} goals, {:.0} m in {:.0} s of run time",
        result["restarts"].as_array().map_or(0, Vec::len),
        result["driven_m"].as_f64().unwrap_or(0.0),
        result["time_s"].as_f64().unwrap_or(0.0)
    );
}

#[test]
fn thirty_random_faults_in_one_drive() {
    soak(3, 30, 20.0);
}

/// Mapping dies again and again while odometry drifts: each successor goes on from where the robot was
/// thought to be, not from where odometry says.
#[test]
fn successors_of_mapping_know_where_odometry_has_drifted_to() {
    let kills: String = [8.0, 12.0, 16.0, 20.0]
        .map(|at_s| fault("kill", "mapping", at_s))
        .concat();
    // A lidar of four turns in five ticks: most scans lie between two ticks.
    let robot = "[robot]\nslip = true\nodometry = true\nlidar.rate_hz = 40.0\n";
    let result = drive(&scenario(5, &format!("{robot}{kills}")));
    assert_eq!(result["restarts"].as_array().map(Vec::len), Some(4));
    let error_m = |name: &str| result["pose"][name].as_f64().expect("an error");
    let (alone_m, corrected_m) = (error_m("odometry_error_m_max"), error_m("error_m_max"));
    eprintln!("odometry {alone_m:.2} m off, the map {corrected_m:.3} m");
    assert!(alone_m > 0.3, "{alone_m} m of drift prove nothing");
    assert!(corrected_m < 0.1, "{corrected_m} m off after a restart");
}

/// One drive of `zeronav suite soak`, which is interrupted and goes on.
#[test]
fn soak_as_a_suite_goes_on_and_counts_faults_restarts_and_what_is_left() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["suite", "soak", "--worlds", "0..1", "--json"];
    let mut soak = Zeronav::start_in(folder, &arguments);
    let services = |soak: &Zeronav| -> Vec<(u32, String)> {
        let runs = children_of(soak.pid()).into_iter();
        runs.flat_map(|(run, _)| services_of(run)).collect()
    };
    soak.wait_until("it drives", |soak| services(soak).len() == 5);
    soak.signal(Signal::INT);
    let ended = soak.finish();
    let report = ended.expect(130);
    assert_eq!(report["complete"], false, "{report:#}");
    let (first, first_s) = (&report["soak"], &report["soak"]["used_s"]);
    assert_eq!(
        (&first["ended"], &first["verdict"]),
        (&json!("interrupted"), &json!("open"))
    );

    let name = report["directory"].as_str().expect("its folder").to_owned();
    let arguments = ["suite", "--resume", &name, "--hours", "0.5", "--json"];
    let ended = Zeronav::start_in(ended.folder, &arguments).finish();
    let report = ended.expect(0);
    assert_eq!(report["complete"], true);
    let soak = &report["soak"];
    assert_eq!(
        (&soak["ended"], &soak["hours"]),
        (&json!("worlds"), &json!(0.5))
    );
    assert!(soak["used_s"].as_f64() > first_s.as_f64(), "{soak:#}");
    let totals = &soak["totals"];
    assert_eq!(
        (&totals["drives"], &totals["faults"]),
        (&json!(1), &json!(80))
    );
    let restarts = totals["restarts"].as_object().expect("restarts by seat");
    let n: u64 = restarts.values().filter_map(Value::as_u64).sum();
    assert_eq!((restarts.len(), n), (4, 60), "{totals:#}");
    // Other tests' stacks come and go meanwhile, and do not count.
    for name in ["contacts_own_fault", "stuck", "failed", "left", "unasked"] {
        assert_eq!(totals[name], 0, "{name}: {soak:#}");
    }
    assert_eq!(soak["drives"][0]["seed"], 1);
    let run = report["runs"][0]["directory"].as_str().expect("its folder");
    let result = ended
        .folder
        .path()
        .join(&name)
        .join(run)
        .join("result.json");
    assert!(result.is_file(), "{}", result.display());
}

#[test]
#[ignore = "takes about ten minutes"]
fn a_thousand_random_faults_in_one_drive() {
    soak(60, 1000, 550.0);
}

/// What a stack uses: memory of launch [kB], its open files, and shared memory of its domain [kB].
fn used(up: &Up) -> [f64; 3] {
    let pid = up.stack.pid();
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let memory = line.and_then(|line| line.trim().trim_end_matches("kB").trim().parse().ok());
    let files = std::fs::read_dir(format!("/proc/{pid}/fd")).map_or(0, Iterator::count);
    let parts = leftovers(Path::new(&up.root));
    let shared = parts.iter().filter_map(|path| {
        let found = std::fs::metadata(path).ok()?;
        Some(found.blocks() / 2)
    });
    let number = |n: u64| f64::from(u32::try_from(n).unwrap_or(u32::MAX));
    [
        memory.unwrap_or(f64::NAN),
        number(files as u64),
        number(shared.sum()),
    ]
}

/// `ZERONAV_SOAK_S` is another time than half an hour. [s]
#[test]
#[ignore = "takes half an hour"]
fn half_an_hour_of_random_faults_in_real_time() {
    let _turn = real_time_turn();
    let asked_s = std::env::var("ZERONAV_SOAK_S").ok();
    let time_s: f64 = asked_s.map_or(1800.0, |text| text.parse().expect("a number of seconds"));
    let lines = format!(
        "[random_faults]\ncount = {:.0}\nfrom_s = 5.0\nuntil_s = {:?}\n",
        time_s / 5.0,
        time_s + 5.0
    );
    let folder = folder_with(&scenario(0, &lines));
    let goals = "[[goals]]\npose = [12.5, 6.425, 0.0]\n[[goals]]\npose = [5.0, 6.425, 0.0]\n";
    let round = folder.path().join("round.toml");
    std::fs::write(&round, goals).expect("written");
    let mut up = Up::start_in(folder, &["./it.toml"]);
    up.ask(&["goals", round.to_str().expect("a path"), "--loop"], 0);
    let started = Instant::now();
    let mut samples = Vec::new();
    while started.elapsed().as_secs_f64() < time_s {
        std::thread::sleep(Duration::from_secs_f64(time_s / 60.0));
        assert!(!up.stack.has_ended(), "the stack ended early");
        samples.push(used(&up));
    }
    up.ask(&["down"], 0);
    while !up.stack.has_ended() && started.elapsed() < LONG {
        std::thread::sleep(Duration::from_millis(20));
    }
    let root = up.root.clone();
    let result = up.stack.finish().expect(0);
    let third = samples.len() / 3;
    for (what, at, room) in [
        ("memory", 0, 8192.0),
        ("files", 1, 16.0),
        ("shared", 2, 8192.0),
    ] {
        let most = |part: &[[f64; 3]]| part.iter().map(|used| used[at]).fold(0.0, f64::max);
        let (before, after) = (most(&samples[..third]), most(&samples[2 * third..]));
        eprintln!("{what}: at most {before} in the first third, {after} in the last");
        assert!(
            after <= before + room,
            "{what} grew from {before} to {after}"
        );
    }
    let made = result["faults"].as_array().map_or(0, Vec::len);
    eprintln!("{made} faults, {} contacts", result["contacts"]);
    assert_eq!(result["contacts"], 0, "{result:#}");
    assert!(leftovers(Path::new(&root)).is_empty());
}
