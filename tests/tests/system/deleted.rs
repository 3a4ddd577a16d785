//! A stack whose shared memory is deleted while it drives, as logind does at logout: the robot is
//! stopped, one line says why, and nothing is left.

use std::path::{Path, PathBuf};
use zeronav_tests::up::Up;
use zeronav_tests::{await_by_itself, is_alive, leftovers, real_time_turn};

/// What is deleted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lost {
    /// The root folder and all segments.
    Everything,
    /// The root folder.
    Folder,
    /// All segments.
    Segments,
}

/// Deletes files of the domain at `root`; its segments carry its name.
fn delete(root: &Path, lost: Lost) {
    let name = root.file_name().and_then(|name| name.to_str());
    let prefix = format!("{}_", name.expect("a name"));
    if lost != Lost::Folder {
        let shm = std::fs::read_dir("/dev/shm").expect("shared memory");
        for entry in shm.flatten() {
            if entry.file_name().to_string_lossy().starts_with(&prefix) {
                std::fs::remove_file(entry.path()).expect("a segment");
            }
        }
    }
    if lost != Lost::Segments {
        // The stack may make a file in it meanwhile.
        let deleted = (0..1000).any(|_| std::fs::remove_dir_all(root).is_ok() || !root.exists());
        assert!(deleted, "{} cannot be deleted", root.display());
    }
}

/// Deletes memory of a stack whose robot drives.
fn check(lost: Lost) {
    let mut up = Up::start(&["open_aisle"]);
    up.ask(&["goal", "27", "8.5", "0"], 0);
    up.stack.wait_until("the robot is fast", |stack| {
        let report = stack.report().unwrap_or_default();
        report["goal"]["elapsed_s"].as_f64() > Some(2.0)
    });
    let report = up.status();
    let services = report["services"].as_array().expect("services");
    let pids: Vec<u32> = (services.iter())
        .filter_map(|service| u32::try_from(service["pid"].as_u64()?).ok())
        .collect();
    assert_eq!(pids.len(), 5, "{report:#}");
    let log = Path::new(report["folder"].as_str().expect("a folder")).join("logs/launch.log");
    let root = PathBuf::from(&up.root);
    delete(&root, lost);

    let ended = up.stack.finish();
    assert_eq!(
        ended.code(),
        3,
        "{lost:?}: {}{}",
        ended.stdout,
        ended.stderr
    );
    let result = ended.json();
    assert_eq!(result["outcome"], "memory_deleted", "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
    let said = |line: &&str| line.contains("the shared memory of the stack was deleted");
    let line = ended.stderr.lines().find(said).expect(&ended.stderr);
    for way_out in ["enable-linger", "system user", "RemoveIPC=no"] {
        assert!(line.contains(way_out), "{line}");
    }
    let log = std::fs::read_to_string(log).expect("launch's log");
    assert!(log.contains("the robot was stopped at_rest=true"), "{log}");
    for pid in pids {
        await_by_itself("no process is left", || !is_alive(pid));
    }
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new(), "{lost:?}");
}

#[test]
fn a_stack_whose_memory_is_deleted_stops_the_robot_and_says_why() {
    let _turn = real_time_turn();
    for lost in [Lost::Everything, Lost::Folder, Lost::Segments] {
        check(lost);
    }
}
