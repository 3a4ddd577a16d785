//! A node of the beam search.

use super::visited;
use crate::surroundings::LocalPose;
use zeronav_msgs::rollouts::RolloutOutcome;

/// Sides of a cell: [m], [rad], [m/s].
const CELL_M: f32 = 0.15;
const CELL_RAD: f32 = 0.4;
const CELL_MPS: f32 = 0.4;

/// The robot after some manoeuvres: position relative to where it is now along the axes of the map
/// [m], yaw in the map [rad] with its cosine and sine, speed [m/s] and yaw rate [rad/s].
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    pub(super) x: f32,
    pub(super) y: f32,
    pub(super) yaw: f32,
    pub(super) cos: f32,
    pub(super) sin: f32,
    pub(super) v: f32,
    pub(super) w: f32,
}

impl State {
    /// As the clearance field takes it.
    pub(super) fn place(&self) -> LocalPose {
        LocalPose {
            x: self.x,
            y: self.y,
            cos: self.cos,
            sin: self.sin,
        }
    }
}

/// What a manoeuvre leads into.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blocked {
    /// Where the robot is then, as in [`State`]. [m]
    pub(super) at: (f32, f32),
    /// What it is.
    pub(super) by: RolloutOutcome,
}

/// The end of a sequence of manoeuvres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) state: State,
    /// Spent and risked so far. [s]
    pub(super) cost: f32,
    /// The same with what is still to come. [s]
    pub(super) total: f32,
    /// The way to go. [m]
    pub(super) to_go: f32,
    /// Index of the node before.
    pub(super) parent: usize,
    /// Speed [m/s] and yaw rate [rad/s] of the last manoeuvre.
    pub(super) asked: (f32, f32),
    /// The robot is at the goal and stays there.
    pub(super) arrived: bool,
    /// Bit by bit: discs that the robot was in from the beginning.
    pub(super) inside: u64,
}

impl Node {
    /// The cell that it is in.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "some metres in cells; saturates"
    )]
    pub(super) fn cell(&self) -> visited::Cell {
        let State { x, y, yaw, v, .. } = self.state;
        [
            (x / CELL_M).floor() as i16,
            (y / CELL_M).floor() as i16,
            (yaw / CELL_RAD).round() as i16,
            (v / CELL_MPS).round() as i16,
        ]
    }
}
