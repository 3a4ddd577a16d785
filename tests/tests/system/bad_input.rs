//! Whatever a user gets wrong: one clear line, exit code 2, nothing half-started.

use std::path::Path;
use std::process::Command;
use zeronav_tests::{Ended, Zeronav, command, executable, zeronav};

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
fn valid_scenario_is_accepted() {
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

/// The line of the scenario that begins with `start`.
fn line_of(text: &str, start: &str) -> usize {
    let line = text.lines().position(|line| line.starts_with(start));
    1 + line.expect("the line")
}

/// Seat, line of its section that is wrong, and words of the message.
const WRONG_SERVICES: &[(&str, &str, &[&str])] = &[
    (
        "mapping",
        "binary = \"./plain.txt\"",
        &["binary", "not executable"],
    ),
    ("mapping", "binary = \"./absent\"", &["binary", "./absent"]),
    (
        "mapping",
        "config.padding = 0.1",
        &["padding", "did you mean `padding_m`?"],
    ),
    (
        "mapping",
        "config.padding_m = nan",
        &["padding_m", "from 0 to 1", "NaN"],
    ),
    (
        "mapping",
        "config.static_map = \"absent.yaml\"",
        &["static_map", "absent.yaml"],
    ),
    (
        "mapping",
        "config.save_to = \"absent\"",
        &["save_to", "absent"],
    ),
    (
        "mapping",
        "config.log_odds.hit = 0",
        &["log_odds.hit", "1 to 10000"],
    ),
    (
        "global_planner",
        "config.planner = \"best\"",
        &["planner", "c_astar"],
    ),
    (
        "global_planner",
        "config.planner = \"lazy_teta\"",
        &["did you mean `lazy_theta`?"],
    ),
    (
        "global_planner",
        "config.smooth_m = 1e308",
        &["smooth_m", "0 to 2, not 1e308"],
    ),
    (
        "local_planner",
        "config.controller = \"bean\"",
        &["did you mean `beam`?"],
    ),
    (
        "local_planner",
        "config.dwa.horizont_s = 1.0",
        &["dwa.horizont_s", "`horizon_s`"],
    ),
    (
        "local_planner",
        "config.dwa.horizon_s = \"x\"",
        &["dwa.horizon_s", "string"],
    ),
    (
        "collision_guard",
        "config.margin_m = inf",
        &["margin_m", "0.01 to 1"],
    ),
    (
        "robot",
        "config.worlt = 1",
        &["worlt", "did you mean `world`?"],
    ),
    (
        "robot",
        "config.start = [1.0, 1.0, 0.0, 0.0]",
        &["start", "3 entries"],
    ),
];

#[test]
fn invalid_service_configuration_is_found_by_check_and_before_a_run() {
    for (seat, line, words) in WRONG_SERVICES {
        let text = format!("{}\n[services.{seat}]\n{line}\n", scenario(HEAD));
        let place = format!("it.toml:{}: services.{seat}.", line_of(&text, line));
        for command in [
            &["check", "./it.toml"][..],
            &["run", "./it.toml", "--headless"],
        ] {
            let folder = tempfile::tempdir().expect("a folder");
            std::fs::write(folder.path().join("it.toml"), &text).expect("written");
            std::fs::write(folder.path().join("plain.txt"), "no program").expect("written");
            let ended = Zeronav::start_in(folder, command).finish();
            let words: Vec<&str> = [place.as_str()].iter().chain(*words).copied().collect();
            refused(&ended, &words);
            assert!(ended.stdout.is_empty(), "{}", ended.stdout);
            assert!(!ended.folder.path().join("runs").exists(), "{command:?}");
        }
    }
}

#[test]
fn external_seats_are_not_asked_for_their_configuration() {
    let text = format!(
        "{}\n[services.mapping]\nbinary = \"no-such-service\"\n",
        scenario(HEAD)
    );
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let mut run = Zeronav::start_in(
        folder,
        &["run", "./it.toml", "--headless", "--external", "mapping"],
    );
    run.wait_until("the other services are there", |run| {
        run.children().len() == 4 && run.domains().len() == 1
    });
    run.signal(rustix::process::Signal::INT);
    assert_eq!(run.finish().code(), 130);
}

#[test]
fn binaries_that_do_not_print_their_configuration_are_named() {
    for (program, said) in [
        ("echo no such flag >&2; exit 1", "exit code 1: no such flag"),
        ("exec sleep 1000", "no answer within 5 s"),
        ("yes & exec yes", "more than 4 MB of answer"),
        ("sleep 1000 & exit 3", "exit code 3"),
        ("printf 'red \\033[31m\\n' >&2; exit 1", "red \\u{1b}[31m"),
    ] {
        let text = format!(
            "{}\n[services.mapping]\nbinary = \"./guest\"\n",
            scenario(HEAD)
        );
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("it.toml"), &text).expect("written");
        let guest = folder.path().join("guest");
        executable(&guest, &format!("#!/bin/sh\n{program}\n"));
        let place = format!(
            "it.toml:{}: services.mapping.binary",
            line_of(&text, "binary")
        );
        refused(
            &Zeronav::start_in(folder, &["check", "it.toml"]).finish(),
            &[&place, "--print-config", said],
        );
    }
}

/// Cargo exports its variables to the tests of any project.
#[test]
fn cargo_never_builds_another_project() {
    let folder = tempfile::tempdir().expect("a folder");
    let built = folder.path().join("built");
    let cargo = folder.path().join("cargo");
    executable(
        &cargo,
        &format!("#!/bin/sh\necho \"$@\" > {}\n", built.display()),
    );
    let check = |package: &Path| {
        let checked = command()
            .args(["check", "open_aisle"])
            .current_dir(folder.path())
            .env("CARGO", &cargo)
            .env("CARGO_MANIFEST_DIR", package)
            .output()
            .expect("zeronav starts");
        assert!(checked.status.success(), "{checked:?}");
        std::fs::read_to_string(&built).ok()
    };
    std::fs::write(folder.path().join("Cargo.toml"), "[package]\n").expect("written");
    assert_eq!(check(folder.path()), None);
    let own = zeronav_tests::workspace();
    let manifest = own.join("Cargo.toml");
    let asked = check(&own.join("launch")).expect("its own project is built");
    assert!(
        asked.contains(manifest.to_str().expect("a name")),
        "{asked}"
    );
}

#[test]
fn impossible_numbers_and_names_are_rejected() {
    let good = scenario(HEAD);
    for (from, to, words) in [
        (
            "start = [1.0, 1.0, 0.0]",
            "start = [1.0, 1.0, 0.0, 0.0]",
            &["start", "3 entries"][..],
        ),
        (
            "start = [1.0, 1.0, 0.0]",
            "start = [1e308, 1.0, 0.0]",
            &["start[0]", "not 1e308"],
        ),
        (
            "title = \"test\"",
            "title = \"t\\u001b[31m\"",
            &["title", "control", "\\u{1b}"],
        ),
        (
            "\n[[goals]]",
            "\nbase = [\"warehous\"]\n[[goals]]",
            &["base", "`warehouse`"],
        ),
    ] {
        refused(&run(&good.replacen(from, to, 1)), words);
    }
    for value in ["nan", "inf", "-1.0", "0", "1e300"] {
        let text = scenario(HEAD).replacen(
            "\n[world]",
            &format!("\n[restart]\nhang_after_s = {value}\n[world]"),
            1,
        );
        let place = format!(
            "it.toml:{}: restart.hang_after_s",
            line_of(&text, "hang_after_s")
        );
        refused(&run(&text), &[&place, "from 0.1 to 3600"]);
    }
}

#[test]
fn wrong_arguments() {
    for (arguments, words) in [
        (&["run"][..], &["SCENARIO"][..]),
        (&["run", "blocked_aisle", "--seed", "x"], &["--seed", "'x'"]),
        (&["run", "blocked\u{1b}[31m"], &["\\u{1b}[31m"]),
        (
            &["check", "./a\nb.toml"],
            &["`./a\\nb.toml` holds control characters"],
        ),
        (
            &["run", "blocked_aisle", "--log-level", "nonsense"],
            &["--log-level", "nonsense", "info"],
        ),
        (
            &["run", "blocked_aisle", "--log-level", "inf"],
            &["did you mean `info`?"],
        ),
        (
            &["run", "blocked_aisle", "--inject", "mapping=1e308ms"],
            &["--inject", "10us to 655ms"],
        ),
        (
            &["run", "blocked_aisle", "--inject", "maping=5ms"],
            &["did you mean `mapping`?"],
        ),
        (
            &["run", "blocked_aisle", "--inject", "collision_guard=600ms"],
            &["collision_guard=600ms", "restart.hang_after_s", "250 ms"],
        ),
        (&["fly"], &["fly"]),
        (&["chek", "open_aisle"], &["chek", "'check'"]),
        (&["suite", "pedestrian"], &["did you mean `pedestrians`?"]),
        (&["goal", "1", "2"], &["YAW"]),
        (
            &["goal", "nan", "2", "0"],
            &["from -1000000 to 1000000, not NaN"],
        ),
        (&["goal", "1", "1e308", "0"], &["not 1e308"]),
        (&["goal", "1", "2", "1e9"], &["from -62.8 to 62.8"]),
        (
            &["goal", "1", "2", "0", "--tolerance", "-1"],
            &["--tolerance", "not -1.0"],
        ),
        (
            &["goal", "1", "2", "0", "--domain", "/dev/shm/zn_nobody"],
            &["zn_nobody"],
        ),
    ] {
        refused(&zeronav(arguments), words);
    }
}

#[test]
fn services_reject_wrong_arguments_in_one_line() {
    for (arguments, word) in [
        (
            &["--log-level", "nonsense", "--print-config"][..],
            "nonsense",
        ),
        (&["--no-such-flag"], "--no-such-flag"),
        (&[], "--domain"),
        (
            &["--config", "/absent.toml", "--print-config"],
            "/absent.toml",
        ),
    ] {
        let mapping = zeronav_tests::binaries().join("zeronav-mapping");
        let ended = Command::new(mapping)
            .args(arguments)
            .output()
            .expect("it starts");
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}: {said}");
        assert_eq!(said.lines().count(), 1, "{arguments:?}: {said}");
        assert!(said.contains(word), "{arguments:?}: {said}");
    }
}

#[test]
fn unwritable_folder_is_named() {
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

/// `zeronav` with at most so many open files: soft and hard limit.
fn with_open_files(soft: u32, hard: u32) -> std::process::Output {
    let folder = tempfile::tempdir().expect("a folder");
    let shell = format!(
        "ulimit -Sn {soft} && ulimit -Hn {hard} && exec \"$0\" run open_aisle --lockstep --headless"
    );
    Command::new("sh")
        .args(["-c", &shell])
        .arg(zeronav_tests::binaries().join("zeronav"))
        .current_dir(folder.path())
        .env_remove("CARGO")
        .output()
        .expect("a shell")
}

#[test]
fn too_few_open_files_are_named_with_the_number_needed() {
    let refused = with_open_files(100, 100);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(
        said.contains("100 open files") && said.contains("512"),
        "{said}"
    );
    // Where only the soft limit is low it is raised, and 512 are enough.
    let driven = with_open_files(100, 512);
    let said = String::from_utf8_lossy(&driven.stderr);
    assert_eq!(driven.status.code(), Some(0), "{said}");
}
