//! What the global planner's seat takes in and when it answers, whoever sits there.
//!
//! It answers every map, every task and every step of a task with a path; in lockstep every tick
//! with a scan, after the map of that tick.

use crate::error::StartError;
use crate::goal_at_hand::GoalAtHand;
use crate::map_input::MapInput;
use crate::peer::Peer;
use crate::roster::Roster;
use crate::service::Shell;
use crate::track::TrackReader;
use crate::turn::{Trigger, Turn};
use crate::writer::Draft;
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::REASON_MAP;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::SpanKind;

/// Odometry, the map and the goal at hand.
#[derive(Debug)]
pub struct PlanningInputs {
    /// Where the robot is.
    pub odometry: TrackReader,
    /// The map.
    pub map: MapInput,
    /// Where to.
    pub goals: GoalAtHand,
}

impl PlanningInputs {
    /// Opens the topics.
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            odometry: TrackReader::open(peer)?,
            map: MapInput::open(peer)?,
            goals: GoalAtHand::open(peer)?,
        })
    }

    /// Takes in what has come and says in the heartbeat whether the map is there; true when
    /// something asks for an answer in real time.
    pub fn poll(&mut self, shell: &mut Shell) -> bool {
        // Odometry first: in lockstep it carries the tick, and whatever belongs to that tick was
        // sent before or is waited for by its own tick.
        self.odometry.poll(shell.roster());
        let mapped = self.map.poll(shell);
        let elsewhere = self.goals.poll(shell.roster());
        let current = !self.map.is_lost() && self.map.info().current == 1;
        shell.reason(REASON_MAP, !current);
        mapped || elsewhere
    }

    /// The answers that are due; `news` as [`Self::poll`] said, or because of another input.
    pub fn turns(&self, shell: &Shell, news: bool) -> impl Iterator<Item = Turn> + use<> {
        shell.turns(&self.trigger(shell.roster(), news))
    }

    fn trigger(&self, roster: &Roster, news: bool) -> Trigger {
        if !roster.lockstep() {
            return Trigger {
                tick: self.map.stamp().map_or(0, |map| map.tick),
                complete: true,
                news,
            };
        }
        let newest = self.odometry.track().newest();
        let tick = newest
            .filter(|moment| moment.odometry.scan_due())
            .map_or(0, |moment| moment.tick);
        Trigger {
            tick,
            complete: self.map.has(tick) || !roster.answers(Role::Mapping, tick),
            news,
        }
    }

    /// Begins an answer: from here on the task holds that holds at its tick.
    pub fn begin(&mut self, shell: &Shell, turn: Turn) -> Draft {
        if turn.kind != SpanKind::Idle {
            self.goals.advance(turn.tick);
        }
        let map = self.map.stamp().unwrap_or_default();
        let run_ns = if turn.tick == map.tick {
            map.run_ns
        } else {
            turn.tick.saturating_mul(shell.roster().clock.tick_ns)
        };
        let parents = Parents {
            odometry: self.odometry.id().0,
            map: self.map.revision().0,
            goal: self.goals.task().0,
            ..Parents::default()
        };
        shell.draft(turn.tick, run_ns, map.capture_ns, parents)
    }

    /// Where the robot is on the map; `None` before the first odometry.
    #[must_use]
    pub fn map_from_base(&self) -> Option<Pose> {
        let newest = self.odometry.track().newest()?;
        Some(self.map.map_from_base(&newest.odometry.pose))
    }

    /// Messages that were refused.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.odometry.refused() + self.map.refused() + self.goals.refused()
    }
}
