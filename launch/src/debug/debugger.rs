//! The debugger, in the terminal of this command.

use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::{Child, Command};

/// Which debugger, and with what.
#[derive(Debug, Clone)]
pub(super) struct Debugger {
    program: OsString,
    arguments: Vec<OsString>,
}

/// What stands for the process in the arguments.
const PID: &str = "{pid}";

/// To which processes a debugger may attach: 0 = those of its user, 1 = its children, 2 = root's choice, 3 = none.
const SCOPE: &str = "/proc/sys/kernel/yama/ptrace_scope";

impl Debugger {
    /// The one that these words name; without any, the first that is installed.
    ///
    /// # Errors
    /// One line when there is none.
    pub(super) fn of(words: &[OsString]) -> Result<Self, String> {
        if let Some((program, arguments)) = words.split_first() {
            return Ok(Self {
                program: program.clone(),
                arguments: arguments.to_vec(),
            });
        }
        // The rust- scripts show the values of Rust, and start the debugger behind their name.
        let known = [("gdb", "rust-gdb"), ("lldb", "rust-lldb")];
        let (plain, of_rust) = known
            .into_iter()
            .find(|(plain, _)| is_installed(plain))
            .ok_or("neither gdb nor lldb is installed: install one, or name another debugger behind --")?;
        let program = if is_installed(of_rust) {
            of_rust
        } else {
            plain
        };
        Ok(Self {
            program: program.into(),
            arguments: Vec::new(),
        })
    }

    /// Starts it on a process of the run whose domain is `root`; commands of zeronav that it starts are for that run.
    ///
    /// # Errors
    /// One line when it cannot be started.
    pub(super) fn start(&self, pid: u32, root: &Path) -> Result<Child, String> {
        let mut command = Command::new(&self.program);
        command
            .args(self.arguments_for(pid))
            .env("ZERONAV_DOMAIN", root);
        if let Some(path) = path_with_own_folder() {
            command.env("PATH", path);
        }
        let name = self.program.to_string_lossy();
        command
            .spawn()
            .map_err(|error| format!("starting {name}: {error}"))
    }

    fn arguments_for(&self, pid: u32) -> Vec<OsString> {
        let pid = pid.to_string();
        let is_named = |it: &OsString| it.to_string_lossy().contains(PID);
        if !self.arguments.iter().any(is_named) {
            let first = ["-p".into(), pid.into()];
            return first
                .into_iter()
                .chain(self.arguments.iter().cloned())
                .collect();
        }
        let put_in = |it: &OsString| match it.to_str() {
            Some(text) => text.replace(PID, &pid).into(),
            None => it.clone(),
        };
        self.arguments.iter().map(put_in).collect()
    }
}

/// What the kernel forbids, and the fix; `None` = nothing.
pub(super) fn restriction() -> Option<&'static str> {
    if rustix::process::geteuid().is_root() {
        return None;
    }
    match std::fs::read_to_string(SCOPE).unwrap_or_default().trim() {
        "1" => Some(
            "the kernel allows a debugger to attach only to its own children; `sudo sysctl kernel.yama.ptrace_scope=0` \
             lifts that until the next reboot",
        ),
        "2" => {
            Some("the kernel allows only root to attach a debugger (kernel.yama.ptrace_scope is 2)")
        }
        "3" => Some(
            "the kernel lets nobody attach a debugger until the next reboot (kernel.yama.ptrace_scope is 3)",
        ),
        _ => None,
    }
}

/// True for a program in one of the folders of `$PATH`.
fn is_installed(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

/// `$PATH` with the folder of this program before all others.
fn path_with_own_folder() -> Option<OsString> {
    let own = std::env::current_exe().ok()?;
    let path = std::env::var_os("PATH").unwrap_or_default();
    let first = own.parent()?.to_owned();
    let folders = core::iter::once(first).chain(std::env::split_paths(<OsStr>::new(&path)));
    std::env::join_paths(folders).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_process_is_put_where_it_is_named_or_first() {
        let words = |words: &[&str]| {
            let words: Vec<OsString> = words.iter().map(Into::into).collect();
            Debugger::of(&words).expect("named").arguments_for(7)
        };
        assert_eq!(words(&["gdb", "-batch"]), ["-p", "7", "-batch"]);
        assert_eq!(
            words(&["strace", "-fp{pid}", "-o", "{pid}.log"]),
            ["-fp7", "-o", "7.log"]
        );
    }
}
