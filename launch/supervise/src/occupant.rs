//! Who really sits in a seat, as its heartbeat and the kernel say.

use std::path::Path;

/// The process that is obeyed in a seat.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Occupant {
    /// Which start of the seat it is.
    pub epoch: u32,
    /// Its process id, as its heartbeat says.
    pub pid: u32,
    /// File name of the program that it runs.
    pub binary: String,
}

impl Occupant {
    /// The process `pid`, while it is still there.
    #[must_use]
    pub fn of(epoch: u32, pid: u32) -> Self {
        Self {
            epoch,
            pid,
            binary: program(pid),
        }
    }

    /// True once the process has ended. One that could not be seen at all is taken to be there.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.pid));
        let ended = stat.is_ok_and(|stat| {
            let state = stat.rsplit(") ").next().unwrap_or("");
            state.starts_with('Z')
        });
        self.binary != UNKNOWN && (ended || program(self.pid) != self.binary)
    }
}

/// The program of a process that cannot be seen.
const UNKNOWN: &str = "unknown";

/// File name of the program that a process runs.
fn program(pid: u32) -> String {
    let program = std::fs::read_link(format!("/proc/{pid}/exe")).unwrap_or_default();
    let name = file_name(&program);
    // What the kernel adds when the file was replaced by a newer one.
    match name.strip_suffix(" (deleted)").unwrap_or(&name) {
        "" => UNKNOWN.to_owned(),
        name => name.to_owned(),
    }
}

/// Last part of a path.
#[must_use]
pub fn file_name(path: &Path) -> String {
    path.file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_is_named_by_the_program_that_it_runs() {
        let own = std::env::current_exe().expect("a program");
        let occupant = Occupant::of(3, std::process::id());
        assert_eq!(occupant.binary, file_name(&own));
        assert!(!occupant.has_ended());
        let unseen = Occupant::of(1, u32::MAX);
        assert!(unseen.binary == UNKNOWN && !unseen.has_ended());
    }

    #[test]
    fn a_process_has_ended_once_it_is_a_zombie() {
        let mut child = std::process::Command::new("sleep").arg("60").spawn();
        let child = child.as_mut().expect("a child");
        let occupant = Occupant::of(1, child.id());
        assert!(!occupant.has_ended());
        child.kill().expect("it is there");
        let started = std::time::Instant::now();
        while !occupant.has_ended() {
            assert!(started.elapsed().as_secs() < 10, "it is a zombie by now");
            std::thread::yield_now();
        }
        child.wait().expect("its end");
        assert!(occupant.has_ended());
    }
}
