//! A recording that is kept with the project: what was recorded once is read, and played, by every later version.

use super::n;
use zeronav_tests::data::shipped_data;
use zeronav_tests::zeronav;

/// Makes it again.
const COMMAND: &str = "rm tests/data/recordings/noisy.mcap; zeronav run tests/data/recordings/noisy.toml --lockstep \
                       --headless --record=tests/data/recordings/noisy.mcap";

/// Largest of all that is kept. [bytes]
const BYTES_MAX: u64 = 600 << 10;

#[test]
fn what_was_recorded_once_is_read_and_played_and_a_difference_is_named() {
    let kept = shipped_data("recordings").join("noisy.mcap");
    let bytes = std::fs::metadata(&kept).map_or(u64::MAX, |it| it.len());
    assert!(bytes <= BYTES_MAX, "{}: {bytes} bytes", kept.display());
    let path = kept.display().to_string();
    let check = zeronav(&["bag", "check", &path]);
    assert_eq!(check.code(), 0, "{}; {COMMAND}", check.stderr);

    // What plays it writes beside nothing that is kept.
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::copy(&kept, folder.path().join("noisy.mcap")).expect("copied");
    let copy = folder.path().display().to_string();
    let ended = zeronav(&["suite", "recordings", &copy, "--json"]);
    let report = ended.json();
    let row = &report["recordings"][0];
    let verdict = &row["verdict"];
    assert!(
        verdict["not_played"].is_null(),
        "{verdict:#}: a contract or a scenario that has changed wants it made again: {COMMAND}"
    );
    // Whoever changes an algorithm changes what it says, and is told where that begins.
    if let Some(first) = verdict["differs"].as_str() {
        eprintln!("differs: {first}");
        assert!(first.starts_with("tick "), "{row:#}");
        assert_eq!(ended.code(), 1, "{}", ended.stderr);
    } else {
        assert_eq!(verdict, "equal", "{row:#}");
        assert_eq!(ended.code(), 0, "{}", ended.stderr);
    }
    let topics = row["comparison"]["topics"].as_array().expect("topics");
    let seen = |of: &str| topics.iter().map(|it| n(&it[of])).sum::<u64>();
    assert!(seen("equal") + seen("different") > 500, "{row:#}");
    // With slipping wheels and false returns the pose is kept.
    let error_m = row["error_m"].as_f64();
    assert!(error_m.is_some_and(|it| it < 0.3), "{row:#}");
}
