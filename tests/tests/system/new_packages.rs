//! `zeronav new`: what it writes builds, keeps the contract and drives as it is, by the very commands
//! that it prints.

use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;
use zeronav_tests::python::python;
use zeronav_tests::{
    Zeronav, background, binaries, executable, quick_profile, real_time_turn, zeronav,
};

/// A package, and the commands that were printed with it.
struct Package {
    folder: TempDir,
    build: String,
    /// Arguments of `zeronav contract`.
    contract: Vec<String>,
    /// Arguments of `zeronav run`.
    drive: Vec<String>,
}

impl Package {
    /// Writes one of this name into an empty folder.
    fn new(word: &str, lang: &str, name: &str) -> Self {
        let arguments = ["new", word, ".", "--lang", lang, "--name", name];
        let ended = zeronav(&arguments);
        assert_eq!(ended.code(), 0, "{}", ended.stderr);
        let lines = ended
            .stdout
            .lines()
            .filter_map(|line| line.strip_prefix("  "));
        let lines: Vec<&str> = lines.collect();
        let [cd, build, contract, drive] = lines[..] else {
            panic!("{}", ended.stdout);
        };
        assert_eq!(cd, "cd .");
        let program = binaries().join("zeronav").display().to_string();
        let arguments = |line: &str| -> Vec<String> {
            let mut words = line.split(' ').map(str::to_owned);
            assert_eq!(words.next(), Some(program.clone()));
            words.collect()
        };
        Self {
            build: build.to_owned(),
            contract: arguments(contract),
            drive: arguments(drive),
            folder: ended.folder,
        }
    }

    /// Runs the command that builds it.
    fn build(&self) {
        let output = background("sh")
            .args(["-c", &self.build])
            .current_dir(self.folder.path())
            // Everything is there: the workspace has been built with the same versions.
            .env("CARGO_NET_OFFLINE", "true")
            // With what else was built, cargo finds the library for C++ fresh.
            .env("CARGOFLAGS", "--bins --example straight_line_service")
            .env("PIP_DISABLE_PIP_VERSION_CHECK", "1")
            .output()
            .expect("a shell");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {said}", self.build);
    }

    /// Shares the target folder of the workspace with the other packages, so that dependencies are
    /// built once for all of them, as fast as that goes. What is zeronav's and its own is optimised: a
    /// search without takes 0.14 s of processor time, and a busy machine makes that a service that
    /// hangs.
    fn build_quickly(&self, name: &str) {
        let target = binaries().parent().expect("a target folder");
        let link = self.folder.path().join("target");
        std::os::unix::fs::symlink(target, link).expect("a link");
        let config = self.folder.path().join(".cargo/config.toml");
        std::fs::create_dir(config.parent().expect("a folder")).expect("made");
        std::fs::write(config, quick_profile(name)).expect("written");
        self.build();
    }

    /// Starts the kit on it.
    fn contract(self) -> Contract {
        let words: Vec<&str> = self.contract.iter().map(String::as_str).collect();
        // A fiftieth of what the kit sends without being asked.
        let flags = ["--hostile", "20000", "--json"];
        let run = Zeronav::start_in(self.folder, &[&words[..], &flags].concat());
        Contract {
            run,
            drive: self.drive,
        }
    }
}

/// The kit on a package.
struct Contract {
    run: Zeronav,
    drive: Vec<String>,
}

impl Contract {
    /// The kit finds every clause kept; then the package drives the scenario that it came with, in
    /// lockstep. The result of that.
    fn kept_then_driven(self) -> Value {
        let ended = self.run.finish();
        let report = ended.expect(0);
        assert_eq!(report["passes"], true, "{report:#}");
        let words: Vec<&str> = self.drive.iter().map(String::as_str).collect();
        let flags = ["--lockstep", "--headless", "--json"];
        let drive = Zeronav::start_in(ended.folder, &[&words[..], &flags].concat());
        let result = drive.finish().expect(0);
        assert_eq!(result["verdict"], "pass", "{result:#}");
        assert_eq!(result["contacts"], 0, "{result:#}");
        assert_eq!(result["restarts"], serde_json::json!([]), "{result:#}");
        result
    }
}

/// Name of the program in a seat of a run.
fn in_seat<'a>(result: &'a Value, role: &str) -> &'a Value {
    let services = result["services"].as_array().expect("services");
    let seat = services.iter().find(|service| service["name"] == role);
    &seat.expect("a seat")["binary"]
}

#[test]
fn packages_in_rust_build_keep_the_contract_and_drive() {
    let seats = [
        ("planner", "global_planner"),
        ("controller", "local_planner"),
        ("guard", "collision_guard"),
        ("mapping", "mapping"),
    ];
    let packages = seats.map(|(word, _)| {
        let name = format!("new_{word}");
        let package = Package::new(word, "rust", &name);
        package.build_quickly(&name);
        package
    });
    let _turn = real_time_turn();
    let contracts = packages.map(Package::contract);
    for ((word, role), contract) in seats.into_iter().zip(contracts) {
        let result = contract.kept_then_driven();
        let name = format!("new_{word}");
        assert_eq!(in_seat(&result, role), &name, "{result:#}");
        if word == "planner" {
            assert_eq!(result["plans"][0]["planner"], name, "{result:#}");
        }
    }
}

#[test]
fn packages_in_python_keep_the_contract_and_drive() {
    let pursuit = Package::new("controller", "python", "new_pursuit");
    pursuit.build();
    // The others use the environment of the tests in place of one of their own.
    let python = python();
    let others = ["planner", "guard"].map(|word| {
        let package = Package::new(word, "python", "mine");
        let command = package.folder.path().join(".venv/bin/mine");
        std::fs::create_dir_all(command.parent().expect("a folder")).expect("made");
        let text = format!(
            "#!/bin/sh\nPYTHONPATH='{}' exec '{}' -c 'import mine; mine.main()' \"$@\"\n",
            package.folder.path().display(),
            python.display()
        );
        executable(&command, &text);
        package
    });
    let _turn = real_time_turn();
    let pursuit = pursuit.contract();
    for other in others.map(Package::contract) {
        other.kept_then_driven();
    }
    let result = pursuit.kept_then_driven();
    assert_eq!(
        in_seat(&result, "local_planner"),
        "new_pursuit",
        "{result:#}"
    );
}

#[test]
fn a_package_in_cpp_builds_keeps_the_contract_and_drives() {
    let package = Package::new("guard", "cpp", "new_guard");
    package.build();
    let _turn = real_time_turn();
    let result = package.contract().kept_then_driven();
    assert_eq!(
        in_seat(&result, "collision_guard"),
        "new_guard",
        "{result:#}"
    );
}

#[test]
fn a_package_has_the_name_of_its_folder_and_files_that_say_what_to_do() {
    let ended = zeronav(&["new", "controller", "deep/my_pilot", "--lang", "rust"]);
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    assert!(
        ended.stdout.contains("  cd deep/my_pilot\n"),
        "{}",
        ended.stdout
    );
    let folder = ended.folder.path().join("deep/my_pilot");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect(name);
    assert!(read("Cargo.toml").contains("name = \"my_pilot\""));
    assert!(read("src/main.rs").contains("zeronav_shell::run::<MyPilot>()"));
    assert!(read("README.md").contains("zeronav contract local_planner ./target/debug/my_pilot\n"));
    let scenario = read("blocked_aisle.toml");
    let seat = "\n[services.local_planner]\nbinary = \"./target/debug/my_pilot\"\n";
    assert!(scenario.ends_with(seat), "{scenario}");
    // The versions are those that zeronav is tested with.
    let own = zeronav_tests::workspace().join("Cargo.lock");
    assert_eq!(
        read("Cargo.lock"),
        std::fs::read_to_string(own).expect("the lock file")
    );
}

#[test]
fn what_cannot_be_written_is_said_in_one_line_and_leaves_nothing() {
    for (arguments, words) in [
        (
            &["robot", "x", "--lang", "rust"][..],
            "known are planner, controller, guard, mapping",
        ),
        (&["gard", "x", "--lang", "rust"], "did you mean `guard`?"),
        (
            &["planner", "x", "--lang", "cpp"],
            "global_planner is there in rust, python, and cpp has collision_guard",
        ),
        (
            &["planner", "My-Planner", "--lang", "rust"],
            "`My-Planner` is no name of a package",
        ),
        (
            &["planner", "x", "--lang", "rust", "--name", "fn"],
            "`fn` is taken",
        ),
        (
            &["planner", "random", "--lang", "python"],
            "`random` is a module of Python",
        ),
        (
            &["planner", "x", "--lang", "rust", "--zeronav", "/nowhere"],
            "--zeronav /nowhere",
        ),
        (
            &[
                "guard",
                "x",
                "--lang",
                "cpp",
                "--zeronav",
                "https://example.org/z",
            ],
            "C++ needs the sources in a folder",
        ),
        (&["planner", "x"], "--lang"),
    ] {
        let ended = zeronav(&[&["new"], arguments].concat());
        assert_eq!(ended.code(), 2, "{arguments:?}: {}", ended.stderr);
        assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
        assert!(
            ended.stderr.contains(words),
            "{arguments:?}: {}",
            ended.stderr
        );
        assert_eq!(entries(ended.folder.path()), 0, "{arguments:?}");
    }
}

#[test]
fn a_folder_that_is_in_use_stays_as_it_is() {
    let folder = TempDir::new().expect("a folder");
    std::fs::create_dir(folder.path().join("mine")).expect("made");
    std::fs::write(folder.path().join("mine/notes"), "text").expect("written");
    let arguments = ["new", "planner", "mine", "--lang", "python"];
    let ended = Zeronav::start_in(folder, &arguments).finish();
    assert_eq!(ended.code(), 2, "{}", ended.stderr);
    assert!(
        ended.stderr.contains("mine is not empty"),
        "{}",
        ended.stderr
    );
    assert_eq!(entries(&ended.folder.path().join("mine")), 1);
}

fn entries(folder: &Path) -> usize {
    std::fs::read_dir(folder).expect("a folder").count()
}
