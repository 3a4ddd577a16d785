//! Completions that shells can read, and a manual page for every verb.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Stdio};
use zeronav_msgs::topics::{RobotScan, Topic};
use zeronav_tests::zeronav;

/// The verbs in the help of `words`, without `help` itself.
fn verbs(words: &[&str]) -> Vec<String> {
    let help = zeronav(&[words, &["--help"]].concat()).stdout;
    let Some((_, commands)) = help.split_once("Commands:\n") else {
        return Vec::new();
    };
    commands
        .lines()
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.strip_prefix("  ")?.split(' ').next())
        .filter(|name| !name.is_empty() && *name != "help")
        .map(str::to_owned)
        .collect()
}

fn is_installed(shell: &str) -> bool {
    let found = Command::new(shell)
        .arg("--version")
        .stdout(Stdio::null())
        .status();
    found.is_ok_and(|status| status.success())
}

/// Writes a script and lets its shell parse it.
fn is_parsed(shell: &str, folder: &Path) -> bool {
    let script = zeronav(&["completions", shell]);
    assert_eq!(script.code(), 0, "{}", script.stderr);
    for verb in verbs(&[]) {
        assert!(
            script.stdout.contains(&verb),
            "{shell} does not know {verb}"
        );
    }
    // Fish completes no positional arguments.
    let knows_topics = script.stdout.contains(RobotScan::ROW.name);
    assert!(knows_topics || shell == "fish", "{shell}");
    let file = folder.join(shell);
    std::fs::write(&file, script.stdout).expect("written");
    if !is_installed(shell) {
        assert_ne!(
            shell, "bash",
            "bash is on every machine that runs the tests"
        );
        return true;
    }
    let parsed = Command::new(shell).arg("-n").arg(&file).status();
    parsed.expect("a shell").success()
}

#[test]
fn completions_are_parsed_by_their_shells_and_know_every_verb() {
    let folder = tempfile::tempdir().expect("a folder");
    for shell in ["bash", "zsh", "fish"] {
        assert!(is_parsed(shell, folder.path()), "{shell}");
    }
    // What bash offers for the beginning of a verb.
    let script = format!(
        "source '{}'; COMP_WORDS=(zeronav topi); COMP_CWORD=1; _zeronav zeronav topi zeronav; \
         echo \"${{COMPREPLY[@]}}\"",
        folder.path().join("bash").display()
    );
    let offered = Command::new("bash")
        .args(["-c", &script])
        .output()
        .expect("bash");
    assert_eq!(String::from_utf8_lossy(&offered.stdout), "topics\n");
    let unknown = zeronav(&["completions", "cobol"]);
    assert_eq!(unknown.code(), 2);
    assert_eq!(unknown.stderr.lines().count(), 1, "{}", unknown.stderr);
}

#[test]
fn every_verb_has_a_manual_page_and_no_hidden_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let pages = folder.path().join("share/man1");
    let ended = zeronav(&["man", pages.to_str().expect("a path")]);
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    let entries = std::fs::read_dir(&pages).expect("the folder");
    let written: BTreeSet<String> = entries
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .into_string()
                .expect("text")
        })
        .collect();
    let mut expected = BTreeSet::from(["zeronav.1".to_owned()]);
    for verb in verbs(&[]) {
        expected.insert(format!("zeronav-{verb}.1"));
        for inner in verbs(&[&verb]) {
            expected.insert(format!("zeronav-{verb}-{inner}.1"));
        }
    }
    assert!(expected.len() > 15, "{expected:?}");
    assert_eq!(written, expected);
    for page in &written {
        let text = std::fs::read_to_string(pages.join(page)).expect("a page");
        assert!(text.contains(".TH ") && text.contains(".SH NAME"), "{page}");
    }
    let file = pages.join("zeronav.1");
    let nowhere = zeronav(&["man", file.to_str().expect("a path")]);
    assert_eq!(nowhere.code(), 4);
    assert_eq!(nowhere.stderr.lines().count(), 1, "{}", nowhere.stderr);
}
