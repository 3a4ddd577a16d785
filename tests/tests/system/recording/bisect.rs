//! The first commit, tick and seat that drive a recorded run otherwise.

use super::{recorded, refused};
use rustix::process::Signal;
use std::path::Path;
use std::process::Command;
use zeronav_tests::{Zeronav, binaries, is_alive, workspace, zeronav};

/// Runs git in `folder`, with nothing of the machine's configuration.
fn git(folder: &Path, words: &[&str]) {
    let ran = Command::new("git")
        .args([
            "-c",
            "user.name=a",
            "-c",
            "user.email=a@b",
            "-c",
            "init.defaultBranch=main",
        ])
        .args(words)
        .current_dir(folder)
        .env("GIT_CONFIG_GLOBAL", "/dev/null")
        .output()
        .expect("git runs");
    assert!(
        ran.status.success(),
        "{words:?}: {}",
        String::from_utf8_lossy(&ran.stderr)
    );
}

/// A repository with a commit for each of these: its planner is the stock one, another one, or cannot be built.
fn repository(folder: &Path, commits: &[&str]) {
    let stock = binaries().join("zeronav-global-planner");
    let other = binaries().join("examples/straight_line_service");
    git(folder, &["init", "--quiet"]);
    for (n, kind) in commits.iter().enumerate() {
        let program = match *kind {
            "stock" => stock.display().to_string(),
            "other" => other.display().to_string(),
            _ => String::new(),
        };
        let text = format!("#!/bin/sh\nexec {program} \"$@\"\n");
        std::fs::write(folder.join("planner"), text).expect("written");
        let builds = if *kind == "broken" {
            "exit 1\n"
        } else {
            "chmod +x planner\n"
        };
        std::fs::write(folder.join("build"), builds).expect("written");
        std::fs::write(folder.join("number"), n.to_string()).expect("written");
        git(folder, &["add", "."]);
        git(
            folder,
            &["commit", "--quiet", "-m", &format!("number {n} is {kind}")],
        );
        git(folder, &["tag", &format!("c{n}")]);
    }
}

/// `zeronav bisect` of a recording over the commits of a repository.
fn bisect(folder: &Path, file: &Path, commits: &str) -> (i32, String, String) {
    let (file, repository) = (file.display().to_string(), folder.display().to_string());
    let place = tempfile::tempdir().expect("a folder");
    let ended = Zeronav::start_in(
        place,
        &[
            "bisect",
            &file,
            "--commits",
            commits,
            "--build",
            "sh build",
            "--repository",
            &repository,
            "--swap",
            "global_planner=planner",
        ],
    )
    .finish();
    (ended.code(), ended.stdout.clone(), ended.stderr.clone())
}

#[test]
fn the_first_commit_that_drives_otherwise_is_found_with_its_tick_and_seat() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = recorded(folder.path(), "it", "");
    let repo = folder.path().join("repository");
    std::fs::create_dir(&repo).expect("a folder");
    repository(
        &repo,
        &["stock", "broken", "stock", "other", "other", "other"],
    );
    let (code, said, complained) = bisect(&repo, &file, "c0..c5");
    assert_eq!(code, 0, "{said}\n{complained}");
    assert!(said.contains("the first commit that differs: "), "{said}");
    assert!(said.contains("number 3 is other"), "{said}\n{complained}");
    assert!(
        said.contains("global_planner is the first seat that differs, at tick "),
        "{said}"
    );
    // Nothing is left of it.
    let list = Command::new("git")
        .args(["worktree", "list"])
        .current_dir(&repo)
        .output();
    let list = String::from_utf8_lossy(&list.expect("git runs").stdout).into_owned();
    assert_eq!(list.lines().count(), 1, "{list}");
    // Ends that are not what they are called.
    let (code, _, complained) = bisect(&repo, &file, "c0..c2");
    assert_eq!(code, 2, "{complained}");
    assert!(
        complained.contains("c2 does not differ from the recording"),
        "{complained}"
    );
    let (code, _, complained) = bisect(&repo, &file, "c3..c5");
    assert_eq!(code, 2, "{complained}");
    assert!(
        complained.contains("c3 differs from the recording already"),
        "{complained}"
    );
    let (code, _, complained) = bisect(&repo, &file, "c0..absent");
    assert_eq!(code, 2, "{complained}");
    assert!(complained.contains("absent"), "{complained}");
}

#[test]
fn where_a_commit_cannot_be_built_all_that_may_be_the_first_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = recorded(folder.path(), "it", "");
    let repo = folder.path().join("repository");
    std::fs::create_dir(&repo).expect("a folder");
    repository(&repo, &["stock", "broken", "other"]);
    let (code, said, complained) = bisect(&repo, &file, "c0..c2");
    assert_eq!(code, 0, "{said}\n{complained}");
    assert!(said.contains("one of these"), "{said}\n{complained}");
    assert!(
        said.contains("number 1 is broken") && said.contains("number 2 is other"),
        "{said}"
    );
    assert!(!said.contains("number 0"), "{said}");
}

#[test]
fn two_values_of_a_parameter_are_told_apart_and_mistakes_are_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = recorded(folder.path(), "it", "").display().to_string();
    let other = zeronav(&["bisect", &file, "--set", "local_planner.controller=dwa"]);
    assert_eq!(other.code(), 0, "{}", other.stderr);
    assert!(
        other
            .stdout
            .contains("local_planner is the first seat that differs"),
        "{}",
        other.stdout
    );
    let same = zeronav(&["bisect", &file, "--set", "mapping.footprint_clearing=true"]);
    assert_eq!(same.code(), 1, "{}{}", same.stdout, same.stderr);
    assert!(same.stdout.contains("equal: "), "{}", same.stdout);
    for (more, why) in [
        (&[][..], "name what to change"),
        (&["--commits", "a..b"], "--build"),
        (
            &["--commits", "a", "--build", "x", "--swap", "mapping=x"],
            "commits read like",
        ),
        (
            &["--commits", "a..-b", "--build", "x", "--swap", "mapping=x"],
            "commits read like",
        ),
        (
            &[
                "--commits",
                "a..b",
                "--build",
                "x",
                "--set",
                "mapping.footprint_clearing=true",
            ],
            "--commits needs --swap",
        ),
    ] {
        refused(&zeronav(&[&["bisect", &file], more].concat()), why);
    }
    let repository = workspace().join("absent");
    let repository = repository.display().to_string();
    let absent = [
        "bisect",
        &file,
        "--commits",
        "a..b",
        "--build",
        "x",
        "--swap",
        "mapping=x",
        "--repository",
        &repository,
    ];
    refused(&zeronav(&absent), "absent");
}

#[test]
fn an_interrupted_search_ends_its_build_and_leaves_no_worktree() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = recorded(folder.path(), "it", "").display().to_string();
    let repo = folder.path().join("repository");
    std::fs::create_dir(&repo).expect("a folder");
    repository(&repo, &["stock", "other"]);
    let place = folder.path().display().to_string();
    let (repo, pid) = (repo.display().to_string(), format!("{place}/pid"));
    let build = format!("echo $$ > {pid}; exec sleep 600");
    let mut search = Zeronav::start(&[
        "bisect",
        &file,
        "--commits",
        "c0..c1",
        "--build",
        &build,
        "--repository",
        &repo,
        "--swap",
        "global_planner=planner",
    ]);
    let builds = || std::fs::read_to_string(&pid).is_ok_and(|pid| pid.ends_with('\n'));
    search.wait_until("it builds", |_| builds());
    search.signal(Signal::INT);
    let ended = search.finish();
    assert_eq!(ended.code(), 130, "{}", ended.stderr);
    let pid = std::fs::read_to_string(&pid).expect("a process id");
    assert!(!is_alive(pid.trim().parse().expect("a number")), "{pid}");
    let list = Command::new("git")
        .args(["worktree", "list"])
        .current_dir(&repo)
        .output();
    let list = String::from_utf8_lossy(&list.expect("git runs").stdout).into_owned();
    assert_eq!(list.lines().count(), 1, "{list}");
}
