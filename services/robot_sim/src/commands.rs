//! Inputs of the simulated robot: velocities for the wheels, obstacles for its world.

use zeronav_msgs::command::Validity;
use zeronav_msgs::header::Parents;
use zeronav_msgs::span::SpanKind;
use zeronav_msgs::topics::{RobotCommand, SimPlacement};
use zeronav_robot_sim::Simulator;
use zeronav_shell::clock::both_ns;
use zeronav_shell::{Due, Latest, Peer, Shell, StartError};

/// Reads `robot/velocity_command` and `sim/placement`.
pub(crate) struct Commands {
    command: Latest<RobotCommand>,
    placements: Latest<SimPlacement>,
    /// When the newest command came in: monotonic, in lockstep run time. [ns]
    came_ns: Option<u64>,
}

impl Commands {
    pub(crate) fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            command: peer.latest()?,
            placements: peer.latest()?,
            came_ns: None,
        })
    }

    /// Passes the newest command to the motors, and puts obstacles into the world.
    pub(crate) fn poll(&mut self, shell: &mut Shell, simulator: &mut Simulator) {
        if self.command.poll(shell.roster()) {
            self.take_command(shell, simulator);
        }
        if self.placements.poll(shell.roster())
            && let Some(view) = self.placements.get()
        {
            for placement in view.items {
                simulator.place(placement);
            }
        }
        shell.count(&[&self.command, &self.placements]);
    }

    fn take_command(&mut self, shell: &mut Shell, simulator: &mut Simulator) {
        let Some(command) = self.command.get() else {
            return;
        };
        if command.meta.validity() == Some(Validity::NoRequest) {
            simulator.no_command();
        } else {
            simulator.set_command(command.meta.v_mps, command.meta.w_radps);
        }
        let header = command.header;
        if shell.roster().lockstep() {
            self.came_ns = Some(header.run_ns);
            return;
        }
        self.came_ns = Some(shell.woken_ns());
        let parents = Parents {
            request: header.id,
            ..Parents::default()
        };
        let due = Due {
            tick: header.tick,
            kind: SpanKind::Applied,
        };
        // The draft's start is the moment at which the set point took effect.
        let mut draft = shell.begin(due, header.run_ns, header.capture_ns, parents);
        (draft.started_ns, draft.raw_ns) = both_ns();
        shell.finish(&draft, None, 0);
    }

    /// Age of the newest command at `now_ns`, monotonic or in lockstep run time. Without launch no
    /// command counts any more: the driver brings the robot to rest. [ns]
    pub(crate) fn age_ns(&self, shell: &Shell, now_ns: u64) -> u64 {
        self.came_ns
            .filter(|_| !shell.is_orphaned())
            .map_or(u64::MAX, |came_ns| now_ns.saturating_sub(came_ns))
    }
}
