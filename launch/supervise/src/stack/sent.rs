//! What launch tells the services of the task: goals, poses, obstacles, zones.

use super::Stack;
use zeronav_msgs::task::{Goal, PoseEstimate, Task, TaskKind};
use zeronav_msgs::truth::{Placement, Placements};
use zeronav_msgs::zones::{ZONE_PARTS_MAX, ZonePart, Zones};
use zeronav_shell::{Draft, StartError};

impl Stack {
    /// Sends a task and returns its id; without goals it cancels the one before. In lockstep
    /// `from_tick` lies above the lease.
    pub fn send_goals(&mut self, goals: &[Goal], from_tick: u64) -> u64 {
        let kind = if goals.is_empty() {
            TaskKind::Cancel
        } else {
            TaskKind::Go
        };
        let task = Task {
            kind: kind.code(),
            n_goals: u32::try_from(goals.len()).unwrap_or(0),
            from_tick,
            ..Task::default()
        };
        let sent = self.goals.publish(&Draft::default(), task, goals);
        self.ring_for(self.goals.row());
        sent.map_or(0, |sent| sent.id.0)
    }

    /// Tells mapping where the robot is; false when there was no memory for the message.
    pub fn estimate_pose(&mut self, estimate: PoseEstimate) -> bool {
        let sent = self.poses.publish(&Draft::default(), estimate, &[]);
        self.ring_for(self.poses.row());
        sent.is_some()
    }

    /// Puts obstacles into the simulated world; false when there was no memory for the message.
    pub fn place(&mut self, placements: &[Placement]) -> bool {
        let meta = Placements {
            n_placements: placements.len() as u64,
        };
        let sent = self.placements.publish(&Draft::default(), meta, placements);
        self.ring_for(self.placements.row());
        sent.is_some()
    }

    /// Sends the zones, and names their revision in `run/control`; false when there was no memory for the
    /// message: then those before hold.
    ///
    /// # Errors
    /// When the topic cannot be opened.
    pub fn send_zones(&mut self, zones: Zones, parts: &[ZonePart]) -> Result<bool, StartError> {
        if self.zones.is_none() {
            let Some(peer) = &self.peer else {
                return Ok(false);
            };
            self.zones = Some(peer.writer(ZONE_PARTS_MAX)?);
        }
        let Some(writer) = &mut self.zones else {
            return Ok(false);
        };
        let sent = writer.publish(&Draft::default(), zones, parts);
        let row = writer.row();
        if sent.is_none() {
            return Ok(false);
        }
        // The same again is for those who have lost it, and wakes nobody.
        if self.roster.control.zones != zones.revision {
            self.ring_for(row);
            self.roster.control.zones = zones.revision;
            self.publish_control();
        }
        Ok(true)
    }
}
