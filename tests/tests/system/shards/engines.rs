//! The examples of what shares suites out: Ray, Slurm, Kubernetes, GitHub Actions.

use super::{RESULTS, Said, read, suite, working_folder};
use rustix::process::Signal;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use zeronav_tests::python::engines;
use zeronav_tests::{await_by_itself, background, binaries, is_alive, send_signal, workspace};

fn example(name: &str) -> PathBuf {
    workspace().join("launch/examples/shards").join(name)
}

/// Where `zeronav` is, before all else.
fn path() -> String {
    let path = std::env::var("PATH").unwrap_or_default();
    format!("{}:{path}", binaries().display())
}

/// The whole suite, driven at once.
fn whole(arguments: &[&str]) -> Said {
    suite(
        working_folder(),
        &[&["scenarios", "--out", "whole"], arguments].concat(),
    )
}

/// Every result is that of the whole suite, byte for byte.
#[track_caller]
fn equals(whole: &Said, merged: &Path) {
    for name in RESULTS {
        let expected = read(&whole.folder.path().join(whole.directory()), name);
        assert!(read(merged, name) == expected, "{name} differs");
    }
}

/// The shards that are driven in `folder` and have one run already: the shard, its process, and who started it.
fn running(folder: &Path) -> Vec<(String, u32, u32)> {
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    let shard = |pid: u32| {
        let line = std::fs::read_to_string(format!("/proc/{pid}/cmdline")).ok()?;
        let words: Vec<&str> = line.split('\0').collect();
        let after = |word: &str| words.iter().skip_while(|it| **it != word).nth(1).copied();
        let out = Path::new(after("--out")?);
        let made = std::fs::read_dir(out.starts_with(folder).then_some(out)?).ok()?;
        let journal = made.flatten().next()?.path().join("runs.jsonl");
        // What was asked for, the names of all runs, and a run.
        let has_run = std::fs::read_to_string(journal).ok()?.lines().count() == 3;
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        let parent = stat.rsplit(") ").next()?.split(' ').nth(1)?.parse().ok()?;
        has_run.then_some((after("--shard")?.to_owned(), pid, parent))
    };
    pids.filter_map(shard).collect()
}

/// The job of Ray, which ends with the test, and what it says.
struct Job(Child, File);

impl Job {
    fn said(&mut self) -> String {
        let mut text = String::new();
        let _ = self.1.rewind();
        let _ = self.1.read_to_string(&mut text);
        text
    }

    /// Looks until there is something, as long as the job goes on.
    fn until<T>(&mut self, mut look: impl FnMut() -> Option<T>) -> T {
        loop {
            if let Some(found) = look() {
                return found;
            }
            let ended = self.0.try_wait().expect("its state");
            assert!(ended.is_none(), "{ended:?}: {}", self.said());
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn ray_drives_a_shard_again_whose_worker_was_killed() {
    let whole = whole(&["--seeds", "4"]);
    let out = whole.folder.path().join("ray");
    let stderr = tempfile::tempfile().expect("a file");
    // Not in the background: who starts Ray waits half a minute for it.
    let job = Command::new(engines())
        .arg(example("ray_suite.py"))
        .args(["--shards", "4", "--workers", "2", "--out"])
        .arg(&out)
        .args(["--", "scenarios", "--seeds", "4"])
        .current_dir(whole.folder.path())
        .env("PATH", path())
        // As outside of a test: under cargo its workers would build the workspace first.
        .env_remove("CARGO")
        // Busy machines start slowly, and have little memory for a while.
        .envs([
            ("RAY_worker_register_timeout_seconds", "600"),
            ("RAY_health_check_timeout_ms", "120000"),
            ("RAY_gcs_server_request_timeout_seconds", "300"),
            ("RAY_memory_monitor_refresh_ms", "0"),
        ])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(stderr.try_clone().expect("a handle"))
        .spawn()
        .expect("Python starts");
    let mut job = Job(job, stderr);
    // The longest of them: it has five more runs before it.
    let (shard, driver, worker) = job.until(|| {
        let mut found = running(&out).into_iter();
        found.find(|(shard, ..)| shard == "4/4")
    });
    assert!(send_signal(worker, Signal::KILL));
    await_by_itself("its shard has stopped", || !is_alive(driver));
    let status = job.0.wait().expect("its end");
    assert!(status.success(), "{}", job.said());
    // The shard was begun twice, the others once.
    let attempts = std::fs::read_dir(out.join("shards"))
        .expect("shards")
        .flatten();
    let attempts: Vec<String> = attempts
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    let of = |shard: &str| {
        let name = format!("{}-", shard.replace('/', "_of_"));
        attempts.iter().filter(|it| it.starts_with(&name)).count()
    };
    assert_eq!(of(&shard), 2, "{shard}: {attempts:?}");
    assert_eq!(attempts.len(), 5, "{attempts:?}");
    let merged = std::fs::read_dir(&out).expect("results").flatten();
    let mut merged = merged
        .map(|it| it.path())
        .filter(|it| !it.ends_with("shards"));
    equals(&whole, &merged.next().expect("the merged suite"));
}

#[test]
fn a_job_array_of_slurm_is_driven_task_by_task() {
    let whole = whole(&["--seeds", "1"]);
    let out = whole.folder.path().join("slurm");
    let task = |index: u32| {
        background("bash")
            .arg(example("slurm.sh"))
            .args(["scenarios", "--seeds", "1"])
            .current_dir(whole.folder.path())
            .env("PATH", path())
            .env("ZERONAV_OUT", &out)
            .env("SLURM_ARRAY_JOB_ID", "17")
            .env("SLURM_ARRAY_TASK_COUNT", "3")
            .env("SLURM_ARRAY_TASK_ID", index.to_string())
            .output()
            .expect("bash runs")
    };
    for index in [1, 2, 3] {
        let done = task(index);
        assert!(
            done.status.success(),
            "{}",
            String::from_utf8_lossy(&done.stderr)
        );
    }
    // A task that Slurm starts again goes on with what there is: nothing is left to do.
    let again = task(2);
    assert!(
        again.status.success(),
        "{}",
        String::from_utf8_lossy(&again.stderr)
    );
    let shards = (1..=3).flat_map(|index| {
        let made = std::fs::read_dir(out.join(format!("17/{index}"))).expect("its folder");
        made.flatten().map(|entry| entry.path())
    });
    let shards: Vec<String> = shards.map(|it| it.display().to_string()).collect();
    assert_eq!(shards.len(), 3, "{shards:?}");
    let merge: Vec<&str> = ["merge"]
        .into_iter()
        .chain(shards.iter().map(String::as_str))
        .collect();
    let merged = suite(tempfile::tempdir().expect("a folder"), &merge);
    equals(&whole, &merged.folder.path().join(merged.directory()));
}

/// Runs a command that must succeed.
#[track_caller]
fn succeeds(command: &mut Command) {
    let done = command.output().expect("it starts");
    let said = [&done.stdout[..], &done.stderr[..]].concat();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&said));
}

#[test]
fn jobs_of_github_and_kubernetes_are_valid() {
    let python = engines();
    let tool = |name: &str| Command::new(python.with_file_name(name));
    succeeds(
        tool("check-jsonschema")
            .args(["--builtin-schema", "vendor.github-workflows"])
            .arg(example("github_actions.yml")),
    );
    succeeds(
        tool("kubernetes-validate")
            .arg("--strict")
            .arg(example("kubernetes.yaml")),
    );
    // A schema that accepts all would accept these, too.
    let place = tempfile::tempdir().expect("a folder");
    let wrong = |name: &str, right: &str, wrong: &str| {
        let text = std::fs::read_to_string(example(name)).expect("the example");
        assert!(text.contains(right), "{name}: {right}");
        let file = place.path().join(name);
        std::fs::write(&file, text.replace(right, wrong)).expect("written");
        file
    };
    let file = wrong("github_actions.yml", "runs-on", "runs_on");
    let mut check = tool("check-jsonschema");
    check
        .args(["--builtin-schema", "vendor.github-workflows"])
        .arg(file);
    assert!(!check.output().expect("it starts").status.success());
    let file = wrong("kubernetes.yaml", "completionMode", "completion_mode");
    let mut check = tool("kubernetes-validate");
    assert!(
        !check
            .arg("--strict")
            .arg(file)
            .output()
            .expect("it starts")
            .status
            .success()
    );
}

/// The command of a pod drives the shard of its index.
#[test]
fn a_pod_of_kubernetes_drives_the_shard_of_its_index() {
    let text = std::fs::read_to_string(example("kubernetes.yaml")).expect("the example");
    let command = text.split("- >-\n").nth(1).expect("a command");
    let command = command
        .split("resources:")
        .next()
        .expect("its end")
        .replace('\n', " ");
    let place = working_folder();
    let shared = place.path().join("shared").display().to_string();
    let command = command.replace("/shared", &shared).replace(
        &format!("barn --seeds 10 --data {shared}/data"),
        "scenarios",
    );
    let mut seen = BTreeSet::new();
    for (index, run) in [("6", "near-seed1"), ("36", "late-seed1")] {
        succeeds(
            background("bash")
                .args(["-c", &command])
                .current_dir(place.path())
                .env("PATH", path())
                .env("JOB_COMPLETION_INDEX", index),
        );
        let made = std::fs::read_dir(Path::new(&shared).join("suite/zeronav-suite").join(index));
        let made = made
            .expect("its folder")
            .flatten()
            .next()
            .expect("a suite")
            .path();
        let report: serde_json::Value =
            serde_json::from_str(&read(&made, "suite.json")).expect("JSON");
        seen.insert(report["shard"].as_str().expect("a shard").to_owned());
        assert!(
            made.join("runs").join(run).join("result.json").is_file(),
            "{report:#}"
        );
    }
    assert_eq!(
        seen,
        BTreeSet::from(["37/64".to_owned(), "7/64".to_owned()])
    );
}
