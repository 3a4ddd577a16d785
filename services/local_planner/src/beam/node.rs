//! A node of the beam search.

use super::visited;
use crate::surroundings::LocalPose;
use zeronav_casts::Cast;
use zeronav_msgs::rollouts::RolloutOutcome;

/// Sides of a cell after the first manoeuvre: of the distance in a second at full speed, [rad], of the
/// full speed. Those of position and yaw grow with every manoeuvre: else a layer fills with variants of what
/// is best so far, and when that comes to nothing no other way is left.
const CELL_S: f32 = 0.06;
const CELL_RAD: f32 = 0.2;
const CELL_SPEED: f32 = 0.2;

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
    /// The cell that it is in after so many manoeuvres, for a robot with this full speed. [m/s]
    pub(super) fn cell(&self, depth: f32, fastest_mps: f32) -> visited::Cell {
        let State { x, y, yaw, v, .. } = self.state;
        let side_m = CELL_S * depth * fastest_mps;
        let side_rad = CELL_RAD * (0.75 + 0.25 * depth);
        let side_mps = CELL_SPEED * fastest_mps;
        [
            (x / side_m).floor().to_i16(),
            (y / side_m).floor().to_i16(),
            (yaw / side_rad).round().to_i16(),
            (v / side_mps).round().to_i16(),
        ]
    }
}
