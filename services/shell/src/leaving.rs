//! When a service leaves: soon when it is asked to, and with the robot at rest when launch is gone.
//!
//! Launch asks with SIGTERM, after it has let the robot come to rest. The kernel sends the same
//! signal when launch dies, and a service that was started by hand sees by the lock on `ROOT/launch`
//! that it did. Then the services between the requests and the wheels behave as if launch had asked
//! for a stop: the local planner requests zero, the guard ramps to rest, the robot brings itself to
//! zero. Each leaves when the robot has stopped, the robot last; or after [`REST_LIMIT_NS`], because a
//! robot that never stops must not keep the services.

use crate::clock::now_ns;
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

    /// One look before a wake, at `now_ns` of the host's clock; true when the service shall leave at
    /// once. [ns]
    pub(crate) fn look(&mut self, shell: &mut Shell, now_ns: u64) -> bool {
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

    /// One look after a wake, at `now_ns` of the host's clock; true when launch is gone and nothing is
    /// left to do. [ns]
    pub(crate) fn rests(
        &self,
        shell: &Shell,
        now_ns: u64,
        is_at_rest: impl FnOnce() -> bool,
    ) -> bool {
        let Some(orphaned_ns) = self.orphaned_ns else {
            return false;
        };
        let role = shell.peer().role();
        let is_robot = role == Role::Robot;
        let longer_ns = if is_robot { ROBOT_LONGER_NS } else { 0 };
        if now_ns >= orphaned_ns + REST_LIMIT_NS + longer_ns {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Stage, Words};
    use crate::seat::SeatLock;
    use zeronav_msgs::run::{RunControl, RunMode};

    /// Any moment of the host's clock. [ns]
    const START_NS: u64 = 5_000_000_000;

    const SEATS: [(Role, u32); 4] = [
        (Role::Robot, 1),
        (Role::Mapping, 1),
        (Role::LocalPlanner, 1),
        (Role::CollisionGuard, 1),
    ];

    fn words(mode: RunMode, stopping: u16) -> Words {
        Words {
            control: RunControl {
                stopping,
                ..RunControl::default()
            },
            ..Words::of(mode, &SEATS)
        }
    }

    /// A run in real time whose robot may move.
    fn moving() -> Stage {
        Stage::new(words(RunMode::RealTime, 0))
    }

    fn leaving() -> (Leaving, Arc<AtomicBool>) {
        let asked = Arc::new(AtomicBool::new(false));
        (Leaving::new(Arc::clone(&asked)), asked)
    }

    /// A shell whose launch is gone, and what saw it at [`START_NS`]; it stays.
    fn orphan(stage: &mut Stage, role: Role) -> (Shell, Leaving) {
        let mut shell = stage.open(role, 1);
        let (mut leaving, _) = leaving();
        stage.lose_launch();
        assert!(!leaving.look(&mut shell, START_NS), "it leaves at once");
        assert!(leaving.is_orphaned());
        (shell, leaving)
    }

    #[test]
    fn while_launch_is_there_and_nobody_asks_a_service_stays() {
        let mut stage = moving();
        let mut shell = stage.open(Role::CollisionGuard, 1);
        let (mut leaving, _) = leaving();
        for now_ns in [START_NS, START_NS + 60 * LOOK_NS] {
            assert!(!leaving.look(&mut shell, now_ns));
            assert!(!leaving.rests(&shell, now_ns, || true));
        }
        assert!(!leaving.is_orphaned() && !shell.is_orphaned());
        assert_eq!(leaving.deadline_ns(), u64::MAX);
    }

    #[test]
    fn a_service_that_is_asked_while_the_robot_may_move_serves_on_for_a_grace() {
        let mut stage = moving();
        let mut shell = stage.open(Role::CollisionGuard, 1);
        let (mut leaving, asked) = leaving();
        asked.store(true, Ordering::Relaxed);
        assert!(!leaving.look(&mut shell, START_NS));
        let before_ns = now_ns();
        let deadline_ns = leaving.deadline_ns();
        let soon = before_ns + SOON_NS..=now_ns() + SOON_NS;
        assert!(soon.contains(&deadline_ns), "the next look comes soon");
        assert!(!leaving.look(&mut shell, START_NS + GRACE_NS - 1));
        assert!(leaving.look(&mut shell, START_NS + GRACE_NS));
        assert!(!leaving.is_orphaned());
    }

    #[test]
    fn a_service_that_is_asked_while_the_robot_is_at_rest_leaves_at_once() {
        let mut stage = Stage::new(words(RunMode::RealTime, 1));
        let mut shell = stage.open(Role::CollisionGuard, 1);
        let (mut leaving, asked) = leaving();
        assert!(!leaving.look(&mut shell, START_NS), "nobody asked");
        asked.store(true, Ordering::Relaxed);
        assert!(leaving.look(&mut shell, START_NS + 1));
    }

    #[test]
    fn a_service_that_is_asked_before_the_run_is_known_leaves_at_once() {
        let mut stage = moving();
        let mut shell = stage.open_shadow(Role::CollisionGuard);
        assert!(!shell.roster().is_known());
        let (mut leaving, asked) = leaving();
        asked.store(true, Ordering::Relaxed);
        assert!(leaving.look(&mut shell, START_NS));
    }

    #[test]
    fn launch_is_looked_for_once_a_period() {
        let mut stage = moving();
        let mut shell = stage.open(Role::Mapping, 1);
        let (mut leaving, _) = leaving();
        assert!(!leaving.look(&mut shell, START_NS));
        stage.lose_launch();
        assert!(!leaving.look(&mut shell, START_NS + LOOK_NS - 1));
        assert!(!leaving.is_orphaned());
        assert!(leaving.look(&mut shell, START_NS + LOOK_NS));
        assert!(leaving.is_orphaned());
    }

    #[test]
    fn a_service_that_is_asked_looks_for_launch_at_once() {
        let mut stage = moving();
        let mut shell = stage.open(Role::Mapping, 1);
        let (mut leaving, asked) = leaving();
        assert!(!leaving.look(&mut shell, START_NS));
        stage.lose_launch();
        asked.store(true, Ordering::Relaxed);
        assert!(leaving.look(&mut shell, START_NS + 1));
        assert!(leaving.is_orphaned(), "it was the kernel that asked");
    }

    #[test]
    fn without_launch_the_services_at_the_wheels_bring_the_robot_to_rest() {
        for role in [Role::LocalPlanner, Role::CollisionGuard, Role::Robot] {
            let mut stage = moving();
            let (mut shell, mut leaving) = orphan(&mut stage, role);
            assert!(shell.is_orphaned());
            assert_eq!(shell.roster().control.stopping, 1, "{role}");
            let later_ns = START_NS + 2 * GRACE_NS;
            assert!(!leaving.look(&mut shell, later_ns), "{role}");
            let before_ns = now_ns();
            assert!(leaving.deadline_ns() >= before_ns + SOON_NS);
            assert_ne!(leaving.deadline_ns(), u64::MAX);
        }
    }

    #[test]
    fn without_launch_all_others_leave_at_once() {
        let guard = Role::CollisionGuard;
        let real_time = || words(RunMode::RealTime, 0);
        let leaves = |words: Words, role: Role, is_shadow: bool, seats: &[(Role, u32)]| {
            let mut stage = Stage::new(words.clone());
            let mut shell = if is_shadow {
                stage.open_shadow(role)
            } else {
                stage.open(role, 1)
            };
            // What launch says last.
            stage.say(Words {
                seats: Words::of(RunMode::RealTime, seats).seats,
                ..words
            });
            shell.wait(0);
            stage.lose_launch();
            leaving().0.look(&mut shell, START_NS)
        };
        assert!(!leaves(real_time(), guard, false, &SEATS), "the guard");
        assert!(leaves(real_time(), Role::Mapping, false, &SEATS), "mapping");
        assert!(leaves(real_time(), guard, true, &SEATS), "a shadow");
        assert!(leaves(real_time(), guard, false, &[]), "nobody is obeyed");
        let lockstep = words(RunMode::Lockstep, 0);
        assert!(
            leaves(lockstep, guard, false, &SEATS),
            "no lease, no motion"
        );
    }

    #[test]
    fn without_launch_a_service_leaves_when_the_robot_has_stopped() {
        let mut stage = moving();
        let (shell, leaving) = orphan(&mut stage, Role::CollisionGuard);
        assert!(!leaving.rests(&shell, START_NS, || false));
        assert!(leaving.rests(&shell, START_NS, || true));
    }

    #[test]
    fn the_robot_leaves_after_those_that_command_it() {
        for role in [Role::LocalPlanner, Role::CollisionGuard] {
            let mut stage = moving();
            let (shell, leaving) = orphan(&mut stage, Role::Robot);
            let domain = || crate::Domain::join(stage.root()).expect("the domain");
            let seat = SeatLock::take(&domain(), role).expect("a free seat");
            assert!(!leaving.rests(&shell, START_NS, || true), "{role}");
            drop(seat);
            assert!(leaving.rests(&shell, START_NS, || true));
            assert!(!leaving.rests(&shell, START_NS, || false), "it moves");
        }
    }

    #[test]
    fn the_guard_does_not_wait_for_the_other_seats() {
        let mut stage = moving();
        let (shell, leaving) = orphan(&mut stage, Role::CollisionGuard);
        let domain = crate::Domain::join(stage.root()).expect("the domain");
        let _seat = SeatLock::take(&domain, Role::LocalPlanner).expect("a free seat");
        assert!(leaving.rests(&shell, START_NS, || true));
    }

    #[test]
    fn a_robot_that_never_stops_does_not_keep_the_services() {
        for (role, limit_ns) in [
            (Role::CollisionGuard, REST_LIMIT_NS),
            (Role::Robot, REST_LIMIT_NS + ROBOT_LONGER_NS),
        ] {
            let mut stage = moving();
            let (shell, leaving) = orphan(&mut stage, role);
            let at = |after_ns| leaving.rests(&shell, START_NS + after_ns, || false);
            assert!(!at(limit_ns - 1), "{role}");
            assert!(at(limit_ns), "{role}");
        }
    }
}
