//! A scenario says how the kernel schedules a service; the result says what was granted.

use zeronav_tests::{Zeronav, real_time_turn};

/// A drive with `mapping` at a nice value on the first processor and on one that is not there, which
/// dies once.
const EXTRA: &str = r#"
[services.mapping.scheduling]
policy = "batch"
nice = 7
cpus = [FIRST, 1023]

[[faults]]
kind = "kill"
service = "mapping"
begins = { at_s = 2.0 }
"#;

/// The first processor that this process may use.
fn first_cpu() -> String {
    let status = std::fs::read_to_string("/proc/self/status").expect("proc is mounted");
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("Cpus_allowed_list:"));
    let first = line.and_then(|list| list.trim().split(['-', ',']).next());
    first.expect("at least one processor").to_owned()
}

/// A folder with `blocked_aisle` and these lines more in `it.toml`.
fn folder(more: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let text = zeronav_tests::shipped("blocked_aisle");
    let text = text.replace("obstacle_replans_min = 1", "");
    std::fs::write(folder.path().join("it.toml"), format!("{text}\n{more}")).expect("written");
    folder
}

#[test]
fn a_restarted_service_too_is_scheduled_as_asked_and_what_is_not_granted_is_said() {
    // In the background launch itself would be scheduled otherwise.
    let _turn = real_time_turn();
    let first = first_cpu();
    let folder = folder(&EXTRA.replace("FIRST", &first));
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    let ended = Zeronav::start_in(folder, &arguments).finish();
    let result = ended.expect(0);
    let service = |name: &str| {
        let services = result["services"].as_array().expect("services");
        let found = services.iter().find(|service| service["name"] == name);
        found.expect("its seat").clone()
    };
    let mapping = service("mapping");
    assert_eq!(mapping["starts"], 2, "{mapping}");
    let scheduling = &mapping["scheduling"];
    assert_eq!(scheduling["policy"], "batch", "{mapping}");
    assert_eq!(scheduling["nice"], 7, "{mapping}");
    assert_eq!(scheduling["cpus"], first, "{mapping}");
    let refused = scheduling["refused"].as_array().expect("a list");
    assert_eq!(refused.len(), 1, "{mapping}");
    let warnings = ended
        .stderr
        .lines()
        .filter(|line| line.contains("[1023]"))
        .count();
    assert!(warnings >= 2, "one of each process: {}", ended.stderr);
    let other = service("local_planner");
    assert_eq!(other["scheduling"]["policy"], "other", "{other}");
    assert_eq!(other["scheduling"]["nice"], 0, "{other}");
}

#[test]
fn a_priority_without_a_real_time_policy_is_rejected_before_anything_starts() {
    let folder = folder("[services.robot.scheduling]\npriority = 5\n");
    let ended = Zeronav::start_in(folder, &["run", "./it.toml", "--headless"]).finish();
    assert_eq!(ended.code(), 2, "{}", ended.stderr);
    let said = "services.robot.scheduling.priority: must be 1 to 99 with the policies fifo and rr";
    assert!(ended.stderr.contains(said), "{}", ended.stderr);
}
