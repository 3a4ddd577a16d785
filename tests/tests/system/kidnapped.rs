//! `zeronav suite kidnapped`: robots that do not know where on a map they are.

use serde_json::Value;
use zeronav_tests::data::shipped_data;
use zeronav_tests::zeronav;

#[test]
fn robots_that_do_not_know_where_they_are_find_themselves() {
    let data = shipped_data("").display().to_string();
    let drive = |worlds: &str| {
        zeronav(&[
            "suite",
            "kidnapped",
            "--data",
            &data,
            "--worlds",
            worlds,
            "--json",
        ])
    };
    let suite = |worlds: &str| drive(worlds).expect(0);
    let report = suite("17..27");
    let runs = report["runs"].as_array().expect("runs");
    // The rooms are alike in places: who stands there cannot know which of them it is.
    let told_nothing = runs.iter().filter(|run| run["class"] == "told_nothing");
    for run in told_nothing {
        assert_eq!(run["wrong_arrival"], false, "{run:#}");
    }
    for class in ["told_nothing", "told_wrong"] {
        let found = |run: &&Value| run["class"] == class && run["success"] == true;
        assert!(runs.iter().any(|run| found(&run)), "{class}: {report:#}");
    }
    for run in runs.iter().filter(|run| run["success"] == true) {
        let below = |key: &str, most: f64| run[key].as_f64().is_some_and(|value| value < most);
        assert!(below("pose_error_m", 0.1), "{run:#}");
        assert!(below("pose_error_rad", 3.0_f64.to_radians()), "{run:#}");
    }
    // Who is told the truth doubts it at first, and neither loses it nor fails by that.
    let right = suite("40..42");
    let right = right["runs"].as_array().expect("runs");
    assert_eq!(right.len(), 2);
    for run in right {
        assert_eq!(run["class"], "told_right", "{run:#}");
        assert_eq!(
            (&run["success"], &run["lost"]),
            (&true.into(), &0.into()),
            "{run:#}"
        );
    }
    // Who may look around finds out which of the rooms it is.
    let around = suite("61..63");
    for run in around["runs"].as_array().expect("runs") {
        assert_eq!(run["class"], "looks_around", "{run:#}");
        assert_eq!(run["success"], true, "{run:#}");
    }
    let ended = drive("9000..9001");
    assert_eq!(ended.code(), 2, "{}", ended.stderr);
    let said = &ended.stderr;
    assert!(said.contains("have the worlds 0..320"), "{said}");
}
