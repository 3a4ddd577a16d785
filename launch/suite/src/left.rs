//! What a run has left over: processes that it started, shared memory of its domain, temporary files.
//!
//! All are told from those of other runs on the machine. A run has a folder of its own for temporary
//! files, which all that it starts, and what these start, inherit in their environment; its domain is
//! in the arguments of its services.

use rustix::process::{Pid, Signal, kill_process};
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use zeronav_shell::memory::SHM;

/// The variable that names the folder for temporary files.
pub(crate) const TEMP: &str = "TMPDIR";

/// How long what a run started may outlive it: services that lost their launch need two seconds.
const GRACE: Duration = Duration::from_secs(3);

/// Between two looks.
const PAUSE: Duration = Duration::from_millis(20);

/// A process of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Process {
    pid: i32,
    words: Vec<String>,
}

/// Processes of the run whose temporary files go into `temp`. Those that have ended and were not yet
/// waited for have no environment any more.
fn processes(temp: &Path) -> Vec<Process> {
    let mark = [TEMP.as_bytes(), b"=", temp.as_os_str().as_bytes()].concat();
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    let of_run = pids.filter_map(|pid: i32| {
        // Those of other users cannot be read.
        let environment = std::fs::read(format!("/proc/{pid}/environ")).ok()?;
        environment
            .split(|byte| *byte == 0)
            .find(|it| *it == mark)?;
        let line = std::fs::read(format!("/proc/{pid}/cmdline")).ok()?;
        let words = line.split(|byte| *byte == 0).filter(|it| !it.is_empty());
        let words = words.map(|word| String::from_utf8_lossy(word).into_owned());
        Some(Process {
            pid,
            words: words.collect(),
        })
    });
    of_run.collect()
}

/// Root folder of the domain of that run, once one of its services is there.
pub(crate) fn domain(temp: &Path) -> Option<PathBuf> {
    let of = |process: Process| {
        let after = process.words.iter().skip_while(|word| *word != "--domain");
        let root = PathBuf::from(after.take(2).nth(1)?);
        (root.parent() == Some(Path::new(SHM)) && root.file_name().is_some()).then_some(root)
    };
    processes(temp).into_iter().find_map(of)
}

/// What a run that has ended has left over, one line each, once it has had its time to go.
pub(crate) fn left_over(temp: &Path, domain: Option<&Path>) -> Vec<String> {
    let began = Instant::now();
    loop {
        let left = look(temp, domain);
        if left.is_empty() || began.elapsed() > GRACE {
            return left;
        }
        std::thread::sleep(PAUSE);
    }
}

fn look(temp: &Path, domain: Option<&Path>) -> Vec<String> {
    let processes = processes(temp).into_iter();
    let processes = processes.map(|it| format!("process {}: {}", it.pid, it.words.join(" ")));
    let segments = domain.map(shared_memory).unwrap_or_default().into_iter();
    let segments = segments.map(|path| path.display().to_string());
    let files = names(temp).into_iter();
    let files = files.map(|path| format!("temporary {}", path.display()));
    processes.chain(segments).chain(files).collect()
}

/// The root folder of a domain, if it is there, and the segments beside it.
fn shared_memory(root: &Path) -> Vec<PathBuf> {
    let Some(name) = root.file_name().map(OsStr::as_bytes) else {
        return Vec::new();
    };
    let is_of_it = |path: &PathBuf| {
        let other = path.file_name().map_or(&b""[..], OsStr::as_bytes);
        (other.strip_prefix(name)).is_some_and(|rest| rest.is_empty() || rest[0] == b'_')
    };
    names(Path::new(SHM)).into_iter().filter(is_of_it).collect()
}

/// What lies in a folder, by name.
fn names(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    names.sort();
    names
}

/// Ends what a run has left over and removes its temporary files, so that the next drive begins like
/// the first. The shared memory of domains without a process is removed by the runner.
pub(crate) fn clear(temp: &Path) {
    for process in processes(temp) {
        if let Some(pid) = Pid::from_raw(process.pid) {
            // It may have ended by itself just now.
            let _ = kill_process(pid, Signal::KILL);
        }
    }
    let _ = std::fs::remove_dir_all(temp);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::{Child, Command, Stdio};

    /// A process of a run with this folder, in the domain at `root`.
    fn service(temp: &Path, root: &Path) -> Child {
        let script = "echo ready; read line";
        let mut command = Command::new("sh");
        command
            .args(["-c", script, "service", "--domain"])
            .arg(root);
        let piped = command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = piped.env(TEMP, temp).spawn().expect("a shell");
        let mut ready = [0; 6];
        let stdout = child.stdout.as_mut().expect("its output");
        std::io::Read::read_exact(stdout, &mut ready).expect("a line");
        child
    }

    #[test]
    fn a_process_a_segment_and_a_file_are_left_over_and_those_of_others_are_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let (own, other) = (folder.path().join("1"), folder.path().join("10"));
        std::fs::create_dir(&own).expect("a folder");
        std::fs::create_dir(&other).expect("a folder");
        std::fs::write(other.join("file"), "").expect("written");
        // Named by this process, so that no other test has it.
        let root = Path::new(SHM).join(format!("soaktest{}", std::process::id()));
        let name = |tail: &str| PathBuf::from(format!("{}{tail}", root.display()));
        let mut others = service(&other, &name("0"));
        std::fs::write(name("0_of_another"), "").expect("written");
        assert_eq!(look(&own, Some(&root)), Vec::<String>::new());
        assert_eq!(domain(&own), None);

        let mut process = service(&own, &root);
        std::fs::write(name("_a.data"), "").expect("written");
        std::fs::create_dir(&root).expect("a folder");
        std::fs::write(own.join("half_written"), "").expect("written");
        assert_eq!(domain(&own).as_ref(), Some(&root));
        let left = look(&own, Some(&root));
        let of_process = format!("process {}: sh -c", process.id());
        assert!(left[0].starts_with(&of_process), "{left:?}");
        let rest = [
            root.display().to_string(),
            name("_a.data").display().to_string(),
            format!("temporary {}", own.join("half_written").display()),
        ];
        assert_eq!(left[1..], rest);

        clear(&own);
        let status = process.wait().expect("its end");
        assert!(!status.success(), "it was killed: {status}");
        assert!(others.try_wait().expect("a status").is_none());
        assert!(!own.exists() && other.exists());
        // Its memory is still there, whatever becomes of its processes.
        assert_eq!(left_over(&own, Some(&root)).len(), 2);
        std::fs::remove_dir(&root).expect("removed");
        for tail in ["_a.data", "0_of_another"] {
            std::fs::remove_file(name(tail)).expect("removed");
        }
        others.kill().expect("killed");
        others.wait().expect("its end");
        assert_eq!(left_over(&own, Some(&root)), Vec::<String>::new());
    }
}
