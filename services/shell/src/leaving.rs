//! When a service leaves: soon when it is asked to, and with the robot at rest when launch is gone.
//!
//! Launch asks with SIGTERM, after it has let the robot come to rest. The kernel sends the same
//! signal when launch dies, and a service that was started by hand sees by the lock on `ROOT/launch`
//! that it did. Then the services between the requests and the wheels behave as if launch had asked
//! for a stop: the local planner requests zero, the guard ramps to rest, the robot brings itself to
//! zero. Each leaves when the robot has stopped, the robot last; or after [`REST_LIMIT_NS`], because a
//! robot that never stops must not keep the services.

use crate::clock::{host_ns, now_ns};
use crate::seat;
use crate::shell::Shell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use zeronav_msgs::role::Role;

/// Time between two looks whether launch is still there. [ns]
const LOOK_NS: u64 = 50_000_000;

/// For how long a service that is asked to leave while the robot may move serves on: the signal may
/// be the kernel's, and the lock of a launch that dies may last a little longer. [ns]
const GRACE_NS: u64 = 100_000_000;

/// Time between two looks in that time, and while the robot comes to rest. [ns]
const SOON_NS: u64 = 5_000_000;

/// How long the robot may take to come to rest without launch. [ns]
const REST_LIMIT_NS: u64 = 1_500_000_000;

/// How much longer the robot itself stays. [ns]
const ROBOT_LONGER_NS: u64 = 100_000_000;

/// See the module's description.
#[derive(Debug)]
pub(crate) struct Leaving {
    asked: Arc<AtomicBool>,
    asked_ns: Option<u64>,
    look_ns: u64,
    orphaned_ns: Option<u64>,
}

impl Leaving {
    /// `asked` is set by the signals that ask the process to stop.
    pub(crate) fn new(asked: Arc<AtomicBool>) -> Self {
        Self {
            asked,
            asked_ns: None,
            look_ns: 0,
            orphaned_ns: None,
        }
    }

    /// One look before a wake; true when the service shall leave at once.
    pub(crate) fn look(&mut self, shell: &mut Shell) -> bool {
        let now_ns = host_ns();
        if self.orphaned_ns.is_some() {
            return false;
        }
        if self.asked_ns.is_none() && self.asked.load(Ordering::Relaxed) {
            self.asked_ns = Some(now_ns);
        }
        if self.asked_ns.is_some() || now_ns >= self.look_ns {
            self.look_ns = now_ns + LOOK_NS;
            if shell.peer().domain().is_orphaned() {
                tracing::warn!(role = %shell.peer().role(), "launch is gone, leaving");
                self.orphaned_ns = Some(now_ns);
                shell.come_to_rest();
                return !brings_to_rest(shell);
            }
        }
        let at_rest = !shell.roster().is_known() || shell.roster().control.stopping == 1;
        self.asked_ns
            .is_some_and(|asked_ns| at_rest || now_ns >= asked_ns + GRACE_NS)
    }

    /// One look after a wake; true when launch is gone and nothing is left to do.
    pub(crate) fn rests(&self, shell: &Shell, is_at_rest: impl FnOnce() -> bool) -> bool {
        let Some(orphaned_ns) = self.orphaned_ns else {
            return false;
        };
        let role = shell.peer().role();
        let is_robot = role == Role::Robot;
        let longer_ns = if is_robot { ROBOT_LONGER_NS } else { 0 };
        if host_ns() >= orphaned_ns + REST_LIMIT_NS + longer_ns {
            tracing::warn!(%role, "the robot did not come to rest in time");
            return true;
        }
        let folder = shell.peer().domain().folder();
        let commanded = || {
            [Role::LocalPlanner, Role::CollisionGuard]
                .into_iter()
                .any(|role| seat::is_taken(folder, role))
        };
        is_at_rest() && !(is_robot && commanded())
    }

    /// When the next look is due at the latest. [ns]
    pub(crate) fn deadline_ns(&self) -> u64 {
        if self.asked_ns.or(self.orphaned_ns).is_some() {
            now_ns() + SOON_NS
        } else {
            u64::MAX
        }
    }

    /// True when launch is gone.
    pub(crate) fn is_orphaned(&self) -> bool {
        self.orphaned_ns.is_some()
    }
}

/// True for a service between the requests and the wheels of a robot that runs in real time. In lockstep
/// the robot stops as soon as launch does not extend its lease.
fn brings_to_rest(shell: &Shell) -> bool {
    let at_the_wheels = matches!(
        shell.peer().role(),
        Role::LocalPlanner | Role::CollisionGuard | Role::Robot
    );
    let roster = shell.roster();
    at_the_wheels && shell.is_obeyable() && roster.is_known() && !roster.lockstep()
}
