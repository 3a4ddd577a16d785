//! A guard that keeps the robot at rest until it is obeyed; then it answers a tick that the robot has
//! not begun, and is mute.

use zeronav_msgs::command::{Validity, VelocityCommand};
use zeronav_msgs::header::Parents;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::RobotCommand;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{Due, OdometryReader, Service, Shell, StartError, Trigger, Writer};
use zeronav_tests::seats::{AnyConfig, is_obeyed};

/// How far its last answer is ahead.
const AHEAD_TICKS: u64 = 10_000;

pub(crate) struct AheadOnceObeyed {
    odometry: OdometryReader,
    command: Writer<RobotCommand>,
    is_mute: bool,
}

impl Service for AheadOnceObeyed {
    const ROLE: Role = Role::CollisionGuard;
    type Config = AnyConfig;

    fn open(shell: &mut Shell, _config: AnyConfig) -> Result<Self, StartError> {
        let peer = shell.peer();
        Ok(Self {
            odometry: OdometryReader::open(peer)?,
            command: peer.writer(1)?,
            is_mute: false,
        })
    }

    fn wake(&mut self, shell: &mut Shell, _rung: Rung) -> Result<(), StartError> {
        self.odometry.poll(shell.roster());
        let trigger = Trigger {
            tick: self.odometry.tick(),
            complete: true,
            ..Trigger::default()
        };
        let due: Vec<Due> = shell.due(&trigger).collect();
        for mut due in due {
            if self.is_mute {
                break;
            }
            self.is_mute = is_obeyed(shell, due.tick);
            due.tick += if self.is_mute { AHEAD_TICKS } else { 0 };
            let parents = Parents {
                odometry: self.odometry.id().0,
                ..Parents::default()
            };
            let draft = shell.begin(due, shell.run_ns(due.tick), 0, parents);
            let command = VelocityCommand {
                validity: Validity::Stopped.code(),
                ..VelocityCommand::default()
            };
            shell.answer(&draft, &mut self.command, command, &[]);
        }
        Ok(())
    }
}
