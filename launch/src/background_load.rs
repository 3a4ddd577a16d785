//! A machine that is busy on purpose: one process per core computes beside the stack.
//!
//! Each is this program, started as `zeronav busy`. It ends with launch, whatever ends launch: the
//! kernel kills it, its standard input is closed, and it gives up after a while by itself.

use crate::run_plan::MachineLoad;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::Signal;
use std::hint::black_box;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use zeronav_supervise::process::end_with_this_thread;

/// Name of the subcommand.
pub const COMMAND: &str = "busy";

/// Most seconds that a process computes: longer than any trials last.
const LIMIT_S: u64 = 4 * 3600;

/// Most processes.
const PROCESSES_MAX: usize = 256;

/// Steps of a computation between two looks at standard input: about a millisecond.
const STEPS: u64 = 500_000;

/// The processes that keep the machine busy. Dropping it ends them.
#[derive(Debug)]
pub(crate) struct BackgroundLoad {
    processes: Vec<Child>,
}

impl BackgroundLoad {
    /// Starts a process per core when the load is to be busy, and nothing otherwise.
    ///
    /// # Errors
    /// One line when one could not be started; then none is left.
    pub(crate) fn start(load: MachineLoad) -> Result<Self, String> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let n = match load {
            MachineLoad::Idle => 0,
            MachineLoad::Busy => cores.min(PROCESSES_MAX),
        };
        let mut burden = Self {
            processes: Vec::with_capacity(n),
        };
        for _ in 0..n {
            let mut command = Command::new("/proc/self/exe");
            command
                .args([COMMAND, &LIMIT_S.to_string()])
                .stdin(Stdio::piped())
                .stdout(Stdio::null())
                .stderr(Stdio::null());
            end_with_this_thread(&mut command, Signal::KILL);
            let process = command.spawn();
            let process = process
                .map_err(|error| format!("starting a process to keep the machine busy: {error}"))?;
            burden.processes.push(process);
        }
        Ok(burden)
    }
}

impl Drop for BackgroundLoad {
    fn drop(&mut self) {
        for process in &mut self.processes {
            let _ = process.kill();
        }
        for process in &mut self.processes {
            let _ = process.wait();
        }
    }
}

/// Computes until standard input is closed, or for `limit_s` at most.
pub fn compute(limit_s: u64) {
    let (started, limit) = (Instant::now(), Duration::from_secs(limit_s));
    let mut state = 1_u64;
    while started.elapsed() < limit && is_wanted() {
        for _ in 0..STEPS {
            state = black_box(
                state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1),
            );
        }
    }
}

/// False once the other end of standard input is closed.
fn is_wanted() -> bool {
    let input = std::io::stdin();
    let mut look = [PollFd::new(&input, PollFlags::empty())];
    let polled = poll(&mut look, Some(&Timespec::default()));
    let gone = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
    polled.is_ok() && !look[0].revents().intersects(gone)
}
