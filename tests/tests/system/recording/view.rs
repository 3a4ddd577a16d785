//! Recordings that are played in a page: the same as the report of their run.

use super::import::{carmen, imported};
use super::{recorded, recording_of, refused};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::Path;
use zeronav_tests::browser::Browser;
use zeronav_tests::rooms::short_drive;
use zeronav_tests::{Zeronav, real_time_turn, zeronav};

/// What `zeronav view FILE --json` prints.
fn played(file: &Path) -> Value {
    zeronav(&["view", &file.display().to_string(), "--json"]).expect(0)
}

/// What the run has left for its own report.
fn of_report(run: &Path) -> Value {
    let text = std::fs::read_to_string(run.join("recording.json")).expect("recording.json");
    serde_json::from_str(&text).expect("JSON")
}

fn frames(recording: &Value) -> &Vec<Value> {
    recording["scene"]["frames"].as_array().expect("frames")
}

/// The map as it is in the end: grid, and tiles by their place.
fn map(frames: &[Value]) -> (Value, BTreeMap<String, Value>) {
    let (mut grid, mut tiles) = (Value::Null, BTreeMap::new());
    for patch in frames.iter().map(|frame| &frame["map"]) {
        if !patch["grid"].is_null() {
            grid = patch["grid"].clone();
            tiles.clear();
        }
        for tile in patch["tiles"].as_array().into_iter().flatten() {
            let place = format!("{} {}", tile[0], tile[1]);
            tiles.insert(place, tile.clone());
        }
    }
    (grid, tiles)
}

/// A frame without some of its fields.
fn without(frame: &Value, keys: &[&str]) -> Map<String, Value> {
    let mut kept = frame.as_object().expect("a frame").clone();
    kept.retain(|key, _| !keys.contains(&key.as_str()));
    kept
}

/// The values of a field, one after the other.
fn sequence(frames: &[Value], key: &str) -> Vec<Value> {
    let said = frames.iter().map(|frame| frame[key].clone());
    let mut said: Vec<Value> = said.filter(|value| !value.is_null()).collect();
    said.dedup();
    said
}

#[test]
fn a_recording_plays_what_the_report_of_its_run_plays() {
    let arguments = ["run", "blocked_aisle", "--lockstep", "--json", "--record"];
    let ended = zeronav(&arguments);
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    let file = recording_of(ended.folder.path());
    let run = file.parent().expect("the run's folder");
    let (own, read) = (of_report(run), played(run));
    // What launch has judged and how it was called is in no message. How long services computed is measured, by
    // records that launch stops to read before the recorder does.
    let not_equal = ["reason", "command", "timings", "scene"];
    let keys = own.as_object().expect("an object");
    for (key, value) in keys
        .iter()
        .filter(|(key, _)| !not_equal.contains(&key.as_str()))
    {
        assert_eq!(&read[key], value, "{key}");
    }
    assert!(
        own["robot"]
            .as_array()
            .is_some_and(|robot| robot.len() > 100)
    );
    assert!(!own["obstacles"][0].is_null() && !own["paths"][1].is_null());
    assert_eq!(read["scene"]["fixed"], own["scene"]["fixed"]);
    // Launch hears map, goals and task when it looks, which is not at the same tick in every run.
    let looked = ["map", "goals", "task"];
    let (of_own, of_read) = (frames(&own), frames(&read));
    assert_eq!(of_read.len(), of_own.len());
    for (own, read) in of_own.iter().zip(of_read) {
        assert_eq!(without(read, &looked), without(own, &looked));
    }
    for key in ["goals", "task"] {
        assert_eq!(sequence(of_read, key), sequence(of_own, key), "{key}");
    }
    let (grid, tiles) = map(of_own);
    let (grid_read, tiles_read) = map(of_read);
    assert_eq!(grid_read, grid);
    let differ = tiles
        .iter()
        .filter(|(at, tile)| tiles_read.get(*at) != Some(tile));
    let differ: Vec<&String> = differ.map(|(at, _)| at).collect();
    // The last look is at most half a second before the end.
    assert!(
        tiles.len() > 10 && differ.len() <= 4,
        "{differ:?} of {}",
        tiles.len()
    );
}

#[test]
fn the_page_of_a_recording_plays_and_is_never_written_over() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = recorded(folder.path(), "it", "");
    let path = file.display().to_string();
    let ended = zeronav(&["view", &path]);
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    assert_eq!(ended.stderr, "");
    let page = folder.path().join("it.html");
    assert_eq!(ended.stdout.trim_end(), page.display().to_string());
    let text = std::fs::read_to_string(&page).expect("a page");
    for words in [
        "<h2>Events</h2>",
        "<h2>Why</h2>",
        "<h2>Recording</h2>",
        "complete",
        ">reached</b>",
    ] {
        assert!(text.contains(words), "{words}");
    }
    let mut browser = Browser::start(1200, 900);
    browser.open_file(&page);
    browser.wait_until("the page does", "document.body.classList.contains('plays')");
    browser.script("1"); // Whatever came before has come.
    let foreign = |url: &&String| !url.starts_with("file:") && !url.starts_with("data:");
    assert_eq!(browser.requests.iter().find(foreign), None);
    assert_eq!(browser.problems, [""; 0]);

    refused(
        &zeronav(&["view", &path]),
        "it exists; name another file with --out",
    );
    assert_eq!(zeronav(&["view", &path, "--force"]).code(), 0);
    let over = ["view", &path, "--out", &path, "--force"];
    refused(&zeronav(&over), "it is the recording; name another file");
    let out = folder.path().display().to_string();
    let in_folder = zeronav(&["view", &path, "--out", &out]);
    assert_ne!(in_folder.code(), 0, "a folder is no page");
    let other = folder.path().join("other.html").display().to_string();
    assert_eq!(zeronav(&["view", &path, "--out", &other]).code(), 0);
    assert_eq!(std::fs::read_to_string(&other).ok().as_ref(), Some(&text));
}

#[test]
fn a_recording_in_real_time_and_one_that_was_cut_are_played_too() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), short_drive("")).expect("written");
    let arguments = ["run", "./it.toml", "--headless", "--record"];
    let real = Zeronav::start_in(folder, &arguments).finish();
    assert_eq!(real.code(), 0, "{}", real.stderr);
    let file = recording_of(real.folder.path());
    let (own, read) = (of_report(file.parent().expect("a folder")), played(&file));
    for key in [
        "scenario", "mode", "outcome", "walls_m", "goals", "contacts",
    ] {
        assert_eq!(read[key], own[key], "{key}");
    }
    // Launch takes the moment of the goal from what it had heard by then, so times are some ticks apart.
    let first_goal_s = [&own, &read].map(|it| it["first_goal_s"].as_f64());
    assert!(first_goal_s[1] >= Some(0.0), "{first_goal_s:?}");
    let frames = [&own, &read].map(|it| frames(it).len());
    assert!(frames[0] > 10 && frames[1] > frames[0] / 2, "{frames:?}");
    let reaction = &read["timings"]["reaction"]["figures"]["n"];
    assert!(reaction.as_u64() > Some(5), "{:#}", read["timings"]);

    let cut = real.folder.path().join("cut.mcap");
    let bytes = std::fs::read(&file).expect("the recording");
    std::fs::write(&cut, &bytes[..bytes.len() * 3 / 4]).expect("written");
    let path = cut.display().to_string();
    refused(
        &zeronav(&["view", &path]),
        "`zeronav bag recover` makes a whole file",
    );
    assert!(!cut.with_extension("html").exists(), "nothing is written");
    assert_eq!(zeronav(&["bag", "recover", &path]).code(), 0);
    let whole = cut.with_file_name("cut_recovered.mcap");
    let ended = zeronav(&["view", &whole.display().to_string()]);
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    assert!(ended.stderr.contains("NOT COMPLETE: "), "{}", ended.stderr);
    let page = std::fs::read_to_string(whole.with_extension("html")).expect("a page");
    assert!(page.contains("NOT COMPLETE: ") && page.contains("id=\"data\""));
}

#[test]
fn the_log_of_another_robot_is_played_without_a_map() {
    let folder = tempfile::tempdir().expect("a folder");
    let (log, file) = (folder.path().join("it.log"), folder.path().join("it.mcap"));
    std::fs::write(&log, carmen()).expect("written");
    imported(&log, &file);
    let read = played(&file);
    assert_eq!(read["walls_m"], Value::Array(Vec::new()));
    let frames = frames(&read);
    assert_eq!(map(frames).0, Value::Null, "there is none");
    let has = |key: &str| frames.iter().filter(|frame| !frame[key].is_null()).count();
    // Corrected poses and scans come five times a second.
    assert!(
        frames.len() > 50 && has("scan") > 20 && has("truth") > 20,
        "{}",
        frames.len()
    );
    let last = frames.last().expect("a frame");
    let x_m = last["robot"][0].as_f64().expect("x");
    assert!((x_m - 4.06).abs() < 0.1, "its wheels count too much: {x_m}");
    let page = zeronav(&["view", &file.display().to_string()]);
    assert_eq!(page.code(), 0, "{}", page.stderr);
    let text = std::fs::read_to_string(file.with_extension("html")).expect("a page");
    assert!(text.contains("CARMEN") && text.contains("id=\"data\""));
}

#[test]
fn what_cannot_be_played_is_refused_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let junk = folder.path().join("junk.mcap");
    std::fs::write(&junk, b"this is no recording at all, and long enough").expect("written");
    let pipe = folder.path().join("pipe.mcap");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.is_ok_and(|made| made.success()));
    let none = folder.path().join("none");
    std::fs::create_dir(&none).expect("a folder");
    for (file, why) in [
        (&junk, "it is no MCAP file of `zeronav run --record`"),
        (&pipe, "is a pipe, not a file"),
        (
            &none,
            "recording.mcap: there is none; a run leaves it with --record",
        ),
        (&folder.path().join("absent.mcap"), "No such file"),
    ] {
        refused(&zeronav(&["view", &file.display().to_string()]), why);
        assert!(!file.with_extension("html").exists(), "nothing is written");
    }
    let both = zeronav(&["view", &junk.display().to_string(), "--port", "9000"]);
    assert_eq!(both.code(), 2, "{}", both.stderr);
    assert_eq!(zeronav(&["view", "--force"]).code(), 2, "of what?");
}
