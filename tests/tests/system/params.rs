//! The values that a running stack uses.

use serde_json::Value;
use zeronav_tests::up::Up;
use zeronav_tests::zeronav;

const SCENARIO: &str = "title = \"values in use\"\nbase = [\"warehouse\", \"porter\"]\n\
    start = [4.0, 6.425, 0.0]\n\
    [services.global_planner]\nconfig.planner = \"any_angle\"\n\
    [services.mapping]\nconfig.tracking.static_margin_m = 0.125\n";

#[test]
fn values_of_the_scenario_and_defaults_are_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), SCENARIO).expect("written");
    let up = Up::start_in(folder, &["./it.toml", "--lockstep"]);
    assert_eq!(
        up.ask(&["params", "global_planner", "planner"], 0),
        "\"any_angle\"\n"
    );
    let margin = ["params", "mapping", "tracking.static_margin_m"];
    assert_eq!(up.ask(&margin, 0), "0.125\n");
    assert_eq!(up.lines(&margin, 0), [0.125]);
    // A default of the stock binary, by its declaration.
    let declared: Value = zeronav(&["params", "mapping", "--json"]).json();
    let declared = declared["parameters"].as_array().expect("parameters");
    let range = (declared.iter()).find(|parameter| parameter["path"] == "obstacle_range_m");
    let used = up.ask(&["params", "mapping", "--running", "--json"], 0);
    let used: Value = serde_json::from_str(&used).expect("JSON");
    assert_eq!(used["obstacle_range_m"], range.expect("it")["default"]);
    assert_eq!(used["tracking"]["static_margin_m"], 0.125);
    let wrong = up.ask(&["params", "mapping", "tracking.nothing"], 2);
    assert!(wrong.contains("no parameter `tracking.nothing`"), "{wrong}");
    let _ = up.down();
}

#[test]
fn without_a_stack_there_are_no_values_in_use() {
    let ended = zeronav(&["params", "mapping", "planner", "--domain", "/nowhere"]);
    assert_eq!(ended.code(), 2, "{}", ended.stdout);
    assert!(ended.stderr.contains("/nowhere"), "{}", ended.stderr);
}
