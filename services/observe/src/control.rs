//! What can be asked of a stack over its control socket: one JSON object per line, with its `command`.

use serde::{Deserialize, Serialize};

/// What can be asked of a stack. Goals, faults, orders of swaps and zones are what the program that asks or answers
/// takes them for: launch reads and checks them, others pass them on as they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "command", rename_all = "snake_case", deny_unknown_fields)]
pub enum Request<Goal, Fault, Order, Zone> {
    /// The stack and its processes.
    Ps,
    /// Drive to these poses in order, after those of the clients before.
    Goal {
        /// Where to; not empty.
        goals: Vec<Goal>,
        /// True when the first follows the last one.
        #[serde(default)]
        repeats: bool,
        /// Run time after which they are given up. [s]
        #[serde(default)]
        time_limit_s: Option<f64>,
        /// True when they take the place of all that were asked for before.
        #[serde(default)]
        now: bool,
    },
    /// What becomes of the goals with this id.
    GoalStatus {
        /// As in the answer to [`Request::Goal`].
        id: u64,
    },
    /// Stop driving to the goals with this id, or to all.
    Cancel {
        /// As in the answer to [`Request::Goal`].
        #[serde(default)]
        id: Option<u64>,
    },
    /// Why the robot did what it did so long ago.
    Why {
        /// Run time before now. [s]
        ago_s: f64,
    },
    /// Hold run time.
    Pause,
    /// Let run time go on.
    Resume,
    /// Let a paused lockstep stack do so many ticks.
    Step {
        /// At least 1.
        ticks: u64,
    },
    /// Let a lockstep stack go so many times as fast as real time.
    Speed {
        /// Without, as fast as it can.
        #[serde(default)]
        factor: Option<f64>,
    },
    /// The robot is there.
    Pose {
        /// x [m], y [m] and yaw [rad] in the map frame.
        pose: [f64; 3],
    },
    /// Change an obstacle of the simulated world.
    Obstacle {
        /// Its name.
        name: String,
        /// What becomes of it.
        change: ObstacleChange,
    },
    /// Put a zone, in place of one of the same name.
    ZoneAdd {
        /// Which.
        zone: Zone,
    },
    /// Take a zone away.
    ZoneRemove {
        /// Its name.
        name: String,
    },
    /// The zones that hold.
    Zones,
    /// Break something on purpose.
    Fault {
        /// Which, and how.
        fault: Fault,
    },
    /// End the faults that go on.
    Heal {
        /// Of this seat; without, of all.
        #[serde(default)]
        target: Option<String>,
    },
    /// Exchange or compare the process in a seat.
    Swap {
        /// How.
        order: Order,
    },
    /// What becomes of the swap with this number, or of the newest.
    SwapStatus {
        /// As in the answer to [`Request::Swap`].
        #[serde(default)]
        id: Option<u64>,
    },
    /// End the swap that goes on; the process that was in the seat before has it.
    SwapCancel,
    /// Bring the robot to rest and end the stack.
    Down,
}

/// What becomes of an obstacle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ObstacleChange {
    /// A new one.
    Add {
        /// x [m], y [m] and yaw [rad] in the map frame.
        pose: [f64; 3],
        /// Sides of a rectangle; the second is 0 for a disc, the first its diameter. [m]
        size_m: [f64; 2],
    },
    /// It is somewhere else from now on, whatever its script says.
    Move {
        /// x [m], y [m] and yaw [rad] in the map frame.
        pose: [f64; 3],
    },
    /// It is gone.
    Remove,
}
