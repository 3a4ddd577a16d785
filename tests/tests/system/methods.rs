//! The whole methods of the papers, `--as KEY`: each drives `blocked_aisle` in lockstep, to the end that it
//! has there; and the settings of a command line, of which a method is made.

use serde_json::Value;
use zeronav_tests::rooms::short_drive;
use zeronav_tests::{Zeronav, zeronav};

/// Drives `blocked_aisle` with these arguments.
fn drive(arguments: &[&str]) -> Value {
    drive_in("blocked_aisle", arguments)
}

/// Drives a scenario with these arguments.
fn drive_in(scenario: &str, arguments: &[&str]) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let mut all = vec!["run", scenario, "--lockstep", "--headless", "--json"];
    all.extend(arguments);
    let result = Zeronav::start_in(folder, &all).finish().json();
    eprintln!(
        "{arguments:?}: {} after {} s, {} m, {} contacts, {} plans",
        result["outcome"],
        result["time_s"],
        result["driven_m"],
        result["contacts"],
        result["plans"].as_array().map_or(0, Vec::len)
    );
    result
}

fn track(result: &Value) -> Vec<[f64; 2]> {
    serde_json::from_value(result["track_m"].clone()).expect("a track")
}

/// The farthest that a track comes from another one, and where. [m]
fn apart(one: &Value, other: &Value) -> (f64, [f64; 2]) {
    let other = track(other);
    let far = |[x, y]: [f64; 2]| {
        let each = other.iter().map(|at| (at[0] - x).hypot(at[1] - y));
        each.fold(f64::INFINITY, f64::min)
    };
    let places = track(one).into_iter().map(|at| (far(at), at));
    let farthest = places.max_by(|a, b| a.0.total_cmp(&b.0));
    farthest.expect("a track")
}

#[test]
fn every_method_is_listed() {
    let listed = zeronav(&["list", "--json"]).expect(0);
    let methods = listed["methods"].as_array().expect("methods");
    let keys: Vec<&str> = methods.iter().filter_map(|it| it["key"].as_str()).collect();
    assert_eq!(keys, ["tn", "ju", "zm", "lwx", "bao"]);
    let listed = zeronav(&["list"]);
    assert!(listed.stdout.contains("--as"), "{}", listed.stdout);
}

#[test]
fn a_setting_is_checked_like_the_scenario() {
    let run = |setting: &str| {
        let arguments = [
            "run",
            "open_aisle",
            "--lockstep",
            "--headless",
            "--set",
            setting,
        ];
        zeronav(&arguments)
    };
    for (setting, said) in [
        ("local_planner.controller=teb", "teb"),
        ("global_planner.options.cost_weight=-1", "cost_weight"),
        ("pilot.controller=dwa", "pilot"),
        ("controller=dwa", "ROLE.KEY=VALUE"),
    ] {
        let ended = run(setting);
        assert_eq!(ended.code(), 2, "{setting}");
        assert!(ended.stderr.contains(said), "{setting}: {}", ended.stderr);
    }
    let ended = zeronav(&["run", "open_aisle", "--as", "dijkstra"]);
    assert_eq!(ended.code(), 2);
    assert!(ended.stderr.contains("dijkstra"), "{}", ended.stderr);
}

/// The words of `run` are those of `up` and `suite`: a suite drives as the method, with the setting over it.
#[test]
fn up_and_suite_take_a_method_and_settings_too() {
    let ended = zeronav(&["up", "open_aisle", "--as", "dijkstra"]);
    assert_eq!(ended.code(), 2);
    assert!(ended.stderr.contains("dijkstra"), "{}", ended.stderr);
    let setting = "global_planner.planner=tn_3n";
    for (words, planner) in [(&[][..], "tn_hyb"), (&["--set", setting], "tn_3n")] {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("scenes")).expect("a folder");
        let scene = short_drive("resolution_m = 0.05\nshapes = []");
        std::fs::write(folder.path().join("scenes/tiny.toml"), scene).expect("written");
        let mut arguments = vec!["suite", "scenes", "--as", "tn", "--json"];
        arguments.extend(words);
        let ended = Zeronav::start_in(folder, &arguments).finish();
        let report = ended.expect(0);
        assert_eq!(report["summary"]["success"], 1.0, "{report:#}");
        let run = report["runs"][0]["directory"].as_str().expect("a folder");
        let suite = report["directory"].as_str().expect("a folder");
        let file = ended
            .folder
            .path()
            .join(suite)
            .join(run)
            .join("result.json");
        let text = std::fs::read_to_string(&file).expect("a result");
        let result: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(result["plans"][0]["planner"], planner, "{arguments:?}");
    }
}

/// The walk turns counter-clockwise at the block of racks, so that it takes the north aisle from the start
/// and never meets the load in the other one: it arrives, and the scenario's expectation of another path
/// fails.
#[test]
fn tn_goes_around_the_other_side_and_meets_no_load() {
    let result = drive(&["--as", "tn"]);
    assert_eq!(result["outcome"], "reached");
    assert_eq!(result["contacts"], 0);
    assert_eq!(result["verdict"], "fail", "no path was cut");
    assert_eq!(result["plans"].as_array().map(Vec::len), Some(1));
    assert!(track(&result).iter().any(|[_, y]| *y > 13.0));
}

/// As printed the goal, 16 m away, attracts more than all points of the path together: the load is a local
/// minimum, and the robot stays before it, whichever path it is given. Attractions of the same size, an
/// option that the paper does not have, lead it around.
#[test]
fn ju_is_caught_before_the_load_by_its_far_goal() {
    let result = drive(&["--as", "ju"]);
    assert_ne!(result["outcome"], "reached");
    assert_eq!(result["contacts"], 0);
    let end = track(&result).pop().expect("a track");
    assert!(
        (8.0..11.0).contains(&end[0]) && (5.4..7.5).contains(&end[1]),
        "{end:?}"
    );
    let unit = "local_planner.papers.ju_fusion.normalised=true";
    let result = drive(&["--as", "ju", "--set", unit]);
    assert_eq!(
        (&result["outcome"], &result["contacts"]),
        (&"reached".into(), &0.into())
    );
}

/// The field follows the A* path: away from the load and through the other aisle.
#[test]
fn zm_arrives_and_drives_otherwise_than_its_parts() {
    let whole = drive(&["--as", "zm"]);
    assert_eq!(whole["verdict"], "pass", "{}", whole["reason"]);
    // The parts are pulled to the goal, not along the path.
    let part = drive(&["--as", "zm", "--set", "local_planner.controller=zm_esc"]);
    let (far_m, at) = apart(&whole, &part);
    eprintln!("zm_full is {far_m:.2} m beside zm_esc at {at:?}");
    assert!(far_m > 1.0, "{far_m} m");
    // Another search gives another path, and so another drive.
    let fixed = drive(&["--as", "zm", "--set", "global_planner.planner=zm_hw"]);
    let (far_m, at) = apart(&whole, &fixed);
    eprintln!("zm_im is {far_m:.2} m beside zm_hw at {at:?}");
    assert_ne!(whole["run_hash"], fixed["run_hash"]);
    assert!(far_m > 0.05, "{far_m} m");
}

/// The greedy search has no frontier: shut in before the load it fills the pocket cell by cell before it
/// turns to A*, a path of more than a hundred metres whose turning points the field chases until the time
/// is over.
#[test]
fn lwx_is_led_to_and_fro_before_the_load_by_its_greedy_search() {
    let result = drive(&["--as", "lwx"]);
    assert_ne!(result["outcome"], "reached");
    assert_eq!(result["contacts"], 0);
    let end = track(&result).pop().expect("a track");
    assert!(
        (6.5..11.0).contains(&end[0]) && (5.4..7.5).contains(&end[1]),
        "{end:?}"
    );
    // Its remark of a dropped fit is in the result.
    let reasons = result["reasons"].as_array().expect("reasons");
    let says = |cause: &str| reasons.iter().any(|it| it["request"]["cause"] == cause);
    assert!(says("no_fit") && says("free"), "{reasons:#?}");
}

/// Leaves its path for the load and goes around by another one.
#[test]
fn bao_arrives() {
    let result = drive(&["--as", "bao"]);
    assert_eq!(result["verdict"], "pass", "{}", result["reason"]);
}

/// Where its fit is free the fusion drives it from the first to the last period, on another way than the
/// turning points alone: 0.32 m beside it at (6.2, 5.7).
#[test]
fn lwx_fusion_drives_its_fit_and_otherwise_than_lwx_oapf() {
    let with = |controller: &str| {
        let setting = format!("local_planner.controller={controller}");
        drive_in("u_trap_1m", &["--set", &setting])
    };
    let (fusion, part) = (with("lwx_fusion"), with("lwx_oapf"));
    assert_eq!(
        (&fusion["outcome"], &part["outcome"]),
        (&"reached".into(), &"reached".into())
    );
    let reasons = fusion["reasons"].as_array().expect("reasons");
    let unfitted = reasons.iter().find(|it| it["request"]["cause"] == "no_fit");
    assert_eq!(unfitted, None, "its fit was dropped");
    let (far_m, at) = apart(&fusion, &part);
    eprintln!("lwx_fusion is {far_m:.2} m beside lwx_oapf at {at:?}");
    assert!(far_m > 0.2, "{far_m} m");
}
