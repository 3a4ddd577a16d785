//! Trials that are recorded: each of their rounds is a stack of its own.

use super::{info, n, refused};
use std::path::Path;
use zeronav_msgs::topics::{RobotCommand, Topic};
use zeronav_tests::rooms::aisle_for_trials;
use zeronav_tests::{Zeronav, real_time_turn, zeronav};

#[test]
fn each_round_of_trials_has_a_recording_of_its_own() {
    let _turn = real_time_turn();
    let arguments = ["run", "./it.toml", "--trials", "3", "--json", "--record"];
    let ended = Zeronav::start_in(aisle_for_trials(), &arguments).finish();
    let result = ended.expect(0);
    let folder = result["directory"]
        .as_str()
        .map(|it| ended.folder.path().join(it));
    let folder = folder.expect("a folder");
    for round in 1..=3 {
        let file = folder.join(format!("recording-{round}.mcap"));
        let said = info(&file, 0);
        let channels = said["channels"].as_array().expect("channels");
        let commands = channels
            .iter()
            .find(|it| it["topic"] == format!("zeronav/{}", RobotCommand::ROW.name));
        let commands = commands.map_or(0, |it| n(&it["messages"]));
        assert!(commands > 10, "{said:#}");
        let verdict = &said["metadata"]["zeronav"];
        // The last words of the stack are in it.
        assert_eq!(verdict["outcome"], "trials_over", "{verdict:#}");
        assert!(n(&verdict["end_tick"]) > 10, "{verdict:#}");
    }
    for absent in ["recording.mcap", "metadata.yaml"] {
        assert!(!Path::new(&folder).join(absent).exists(), "{absent}");
    }
}

#[test]
fn a_file_in_the_place_of_a_later_round_is_named_before_the_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let later = folder.path().join("it-3.mcap");
    std::fs::write(&later, "mine").expect("written");
    let record = format!("--record={}", folder.path().join("it.mcap").display());
    let ended = zeronav(&["run", "blocked_aisle", "--trials", "3", &record]);
    refused(&ended, "it-3.mcap: it exists");
    assert!(
        !ended.folder.path().join("runs").exists(),
        "a run was begun"
    );
    assert_eq!(std::fs::read(&later).expect("it"), b"mine");
}
