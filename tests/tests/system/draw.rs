//! `zeronav draw`: the animated picture of a recorded run.

use std::path::Path;
use zeronav_tests::{Zeronav, workspace, zeronav};

/// Largest picture. [bytes]
const SIZE_MAX: usize = 300_000;

/// What the animation of `blocked_aisle` shows.
fn check(svg: &str) {
    assert!(svg.len() < SIZE_MAX, "{} bytes", svg.len());
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    for (element, count) in [
        ("<g", svg.matches("</g>").count()),
        ("<polyline", svg.matches("</polyline>").count()),
        ("class=\"robot\" stroke-width", 1),
        ("<title>load</title>", 1),
        ("attributeName=\"stroke-dashoffset\"", 1),
        ("type=\"rotate\"", 1),
        ("prefers-color-scheme:dark", 0),
        ("prefers-color-scheme: dark", 1),
        ("<script", 0),
        ("NaN", 0),
    ] {
        assert_eq!(svg.matches(element).count(), count, "{element}");
    }
    let paths = svg.matches("<polyline class=\"path\"").count();
    assert!(
        paths >= 3,
        "{paths}: the first path, what is left of it, and the second one"
    );
    for words in [
        "driving to the goal",
        "load appears",
        "reached after",
        "0 contacts",
    ] {
        assert!(svg.contains(words), "{words}");
    }
}

#[test]
fn a_recorded_run_becomes_an_animated_picture() {
    let ended = zeronav(&["run", "blocked_aisle", "--lockstep", "--headless", "--json"]);
    let result = ended.expect(0);
    let run = result["directory"].as_str().expect("its folder").to_owned();
    let drawn = Zeronav::start_in(ended.folder, &["draw", &run]).finish();
    assert_eq!(drawn.code(), 0, "{}", drawn.stderr);
    let file = drawn.stdout.trim_end();
    assert_eq!(Path::new(file), Path::new(&run).join("animation.svg"));
    check(&std::fs::read_to_string(drawn.folder.path().join(file)).expect("a picture"));
}

#[test]
fn the_picture_of_the_readme_is_one() {
    check(
        &std::fs::read_to_string(workspace().join("launch/blocked_aisle.svg")).expect("a picture"),
    );
}

#[test]
fn a_folder_without_a_recording_is_named() {
    let ended = zeronav(&["draw", "nowhere"]);
    assert_eq!(ended.code(), 2, "{}", ended.stderr);
    assert!(
        ended.stderr.contains("nowhere/recording.json"),
        "{}",
        ended.stderr
    );
    for (text, problem) in [("{}", "missing field"), ("no JSON", "expected")] {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("recording.json"), text).expect("written");
        let ended = Zeronav::start_in(folder, &["draw", "."]).finish();
        assert_eq!(ended.code(), 2, "{}", ended.stderr);
        assert!(ended.stderr.contains(problem), "{}", ended.stderr);
    }
}
