//! Whatever a user gets wrong: one clear line, exit code 2, nothing half-started.

use std::path::Path;
use zeronav_tests::{Ended, Zeronav, zeronav};

const WORLD: &str = r#"
[world]
area_m = [[0.0, 0.0], [10.0, 8.0]]
shapes = [{ kind = "box", centre_m = [5.0, 4.0], size_m = [1.0, 1.0] }]
"#;

const ROBOT: &str = r"
[robot]
radius_m = 0.25
v_mps_max = 0.8
w_radps_max = 1.8
a_mps2_max = 1.0
alpha_radps2_max = 4.0
[robot.lidar]
n_beams = 90
rate_hz = 10.0
range_m_min = 0.1
range_m_max = 12.0
";

/// A scenario with these lines in front of a world and a robot.
fn scenario(head: &str) -> String {
    format!("title = \"test\"\n{head}\n{WORLD}\n{ROBOT}")
}

const HEAD: &str = "start = [1.0, 1.0, 0.0]\n[[goals]]\npose = [9.0, 7.0, 0.0]\n";

/// Runs a scenario file with this text; `runs/` must not appear.
fn run(text: &str) -> Ended {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let ended =
        Zeronav::start_in(folder, &["run", "./it.toml", "--lockstep", "--headless"]).finish();
    assert!(ended.stdout.is_empty(), "{}", ended.stdout);
    assert!(
        !ended.folder.path().join("runs").exists(),
        "a run was half-started"
    );
    ended
}

/// Exit 2 with one line on standard error that holds every one of these words.
fn refused(ended: &Ended, words: &[&str]) {
    assert_eq!(ended.code(), 2, "{}", ended.stderr);
    let lines: Vec<&str> = ended.stderr.lines().collect();
    assert_eq!(lines.len(), 1, "more than one line:\n{}", ended.stderr);
    for word in words {
        assert!(
            lines[0].contains(word),
            "`{word}` is not named: {}",
            lines[0]
        );
    }
}

#[test]
fn the_good_one_is_good() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), scenario(HEAD)).expect("written");
    let ended = Zeronav::start_in(folder, &["check", "it.toml"]).finish();
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    assert!(ended.stdout.contains("200 x 160 cells"), "{}", ended.stdout);
}

#[test]
fn unknown_scenario() {
    let ended = zeronav(&["run", "blocked_isle"]);
    refused(&ended, &["blocked_isle", "blocked_aisle"]);
}

#[test]
fn malformed_toml_names_line_and_field() {
    refused(&run(&scenario("start = [1.0, 1.0, 0.0\n")), &["it.toml:"]);
    let text = scenario(HEAD).replace("v_mps_max", "v_max");
    let line = 1 + text
        .lines()
        .position(|line| line.starts_with("v_max"))
        .expect("the line");
    refused(&run(&text), &[&format!("it.toml:{line}"), "v_max"]);
    let text = scenario(HEAD).replace("n_beams = 90", "n_beams = 0");
    refused(&run(&text), &["it.toml:", "robot.lidar.n_beams"]);
}

#[test]
fn missing_and_corrupt_map_files() {
    let with_map =
        |map: &str| format!("title = \"test\"\n{HEAD}\n[world]\nmap = \"{map}\"\n{ROBOT}");
    refused(&run(&with_map("nowhere.yaml")), &["nowhere.yaml"]);

    let broken = |image: &[u8], words: &[&str]| {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, bytes: &[u8]| {
            std::fs::write(folder.path().join(name), bytes).expect("written");
        };
        write("map.yaml", b"image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
        write("map.pgm", image);
        write("it.toml", with_map("map.yaml").as_bytes());
        let ended = Zeronav::start_in(folder, &["run", "it.toml", "--headless"]).finish();
        refused(&ended, words);
    };
    broken(b"P5\n400 400\n255\nshort", &["map.pgm"]);
    broken(b"not an image at all", &["map.pgm"]);
    broken(b"", &["map.pgm"]);
}

#[test]
fn start_in_an_obstacle() {
    let text = scenario(&HEAD.replace("[1.0, 1.0, 0.0]", "[5.0, 4.0, 0.0]"));
    refused(&run(&text), &["it.toml:2", "start"]);
}

#[test]
fn goal_without_a_free_pose() {
    let text = scenario(&HEAD.replace("[9.0, 7.0, 0.0]", "[5.0, 4.0, 0.0]"));
    refused(&run(&text), &["it.toml:", "goals"]);
}

#[test]
fn a_binary_that_does_not_exist() {
    for name in ["no-such-service", "./no/such/service"] {
        let text = format!(
            "{}\n[services.mapping]\nbinary = \"{name}\"\n",
            scenario(HEAD)
        );
        refused(&run(&text), &["services.mapping.binary", name]);
    }
}

#[test]
fn a_service_that_does_not_know_its_configuration_is_named() {
    let text = format!(
        "{}\n[services.global_planner]\nconfig.planner = \"best\"\n",
        scenario(HEAD)
    );
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let ended = Zeronav::start_in(folder, &["run", "./it.toml", "--headless"]).finish();
    assert_eq!(ended.code(), 2, "{}", ended.stderr);
    for word in ["global_planner", "best", "c_astar"] {
        assert!(
            ended.stderr.contains(word),
            "`{word}` is not named:\n{}",
            ended.stderr
        );
    }
}

#[test]
fn wrong_arguments() {
    for arguments in [
        &["run"][..],
        &["run", "blocked_aisle", "--seed", "x"],
        &["fly"],
        &["goal", "1", "2"],
        &["goal", "1", "2", "0", "--domain", "/dev/shm/zn_nobody"],
    ] {
        let ended = zeronav(arguments);
        assert_eq!(ended.code(), 2, "{arguments:?}: {}", ended.stderr);
        assert!(!ended.stderr.is_empty());
    }
}

#[test]
fn a_folder_that_cannot_be_written() {
    let ended = zeronav(&["run", "open_aisle", "--headless", "--out", "/proc/runs"]);
    refused(&ended, &["/proc/runs"]);
}

#[test]
fn list_and_check_know_the_shipped_scenarios() {
    let listed = zeronav(&["list"]);
    assert_eq!(listed.code(), 0);
    for name in ["blocked_aisle", "open_aisle", "sealed", "unsealed"] {
        assert!(listed.stdout.contains(name), "{}", listed.stdout);
        let checked = zeronav(&["check", name, "--json"]);
        assert_eq!(checked.expect(0)["ok"], true);
    }
    assert!(Path::new("/dev/shm").is_dir());
}
