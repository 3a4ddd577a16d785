//! `plan/path`: the way to the goal, or why there is none.

use crate::map::ObstacleSource;
use crate::message::{COORDINATE_M_MAX, Refusal, ZeroCopySend, ensure, number};
use crate::{codes, message};

/// Most waypoints of a path. Grid paths are sent as their corners.
pub const WAYPOINTS_MAX: usize = 2048;

codes! {
    /// Outcome of planning.
    pub enum PathStatus: u16 {
        /// Idle: no path was asked for, or no map has come yet.
        NoGoal = 0 => "no_goal",
        /// The waypoints lead from the robot to the goal; with a block that closes the only way as far as is known,
        /// to where the robot can see it from near.
        Found = 1 => "found",
        /// The robot is not on the map.
        StartOutsideMap = 2 => "start_outside_map",
        /// The robot is in an obstacle and no free cell is near.
        StartBlocked = 3 => "start_blocked",
        /// The goal is not on the map.
        GoalOutsideMap = 4 => "goal_outside_map",
        /// No free cell within the tolerance of the goal.
        GoalBlocked = 5 => "goal_blocked",
        /// Proved: no way leads to the goal.
        Unreachable = 6 => "unreachable",
        /// Proved: only a way that cuts an obstacle's corner leads to the goal.
        UnreachableCorner = 7 => "unreachable_corner",
        /// An incomplete planner gave up.
        DeadEnd = 8 => "dead_end",
        /// The budget ended before the search did.
        OutOfBudget = 9 => "out_of_budget",
        /// The path has more corners than a message holds.
        TooLong = 10 => "too_long",
    }
}

codes! {
    /// Why the geometry of a path is what it is.
    pub enum PathCause: u16 {
        /// Idle.
        None = 0 => "none",
        /// A new goal.
        Goal = 1 => "goal",
        /// A map update cut the corridor of the path before.
        Obstacle = 2 => "obstacle",
        /// The local planner asked.
        Request = 3 => "request",
        /// A map update opened a shorter way.
        Shortcut = 4 => "shortcut",
        /// The next goal of a list came up.
        NextGoal = 5 => "next_goal",
        /// A search found a better path than the detour that was ready when its predecessor was cut.
        Improved = 6 => "improved",
    }
}

codes! {
    /// The cell that decided about a path, or about the end of a task.
    pub enum PathBlock: u16 {
        /// None is known.
        None = 0 => "none",
        /// The robot's own: it is blocked.
        Robot = 1 => "robot",
        /// The goal's own: it is blocked, or beside the map.
        Goal = 2 => "goal",
        /// The first blocked one on the path before this one.
        PathBefore = 3 => "path_before",
        /// The tightest one of the shortest way that could be opened: no way leads to the goal.
        Closed = 4 => "closed",
        /// One of the obstacle that the robot did not get past.
        Obstacle = 5 => "obstacle",
    }
}

message! {
    /// Fixed fields of a path. Search statistics are counts, never times. A message with an
    /// unchanged path repeats the waypoints and says by its parents how current it is.
    pub struct Path = "zeronav.Path.v5" {
        /// [text] Key of the planner in lower case, padded with 0.
        pub planner: [u8; 24],
        /// Code of [`PathStatus`].
        pub status: u16,
        /// Code of [`PathCause`] of the geometry.
        pub cause: u16,
        /// [count] Waypoints in the slice.
        pub n_waypoints: u32,
        /// [id] Id of the message that brought this geometry or failure first; its own id when new.
        pub geometry: u64,
        /// [id] Map revision that the search used; the header's parent is the one it was checked with.
        pub searched_map: u64,
        /// [count] Nodes taken from the open list and closed.
        pub expanded: u64,
        /// [count] Nodes put into the open list.
        pub generated: u64,
        /// [count] Neighbours looked at, repeats counted.
        pub evaluated: u64,
        /// [count] Longest open list.
        pub peak_open: u64,
        /// [m] length, >= 0.
        pub length_m: f64,
        /// [-] Cost in the planner's own measure, >= 0.
        pub cost: f64,
        /// [-] No path costs less, in the same measure; 0 = not known. At most `cost`.
        pub bound: f64,
        /// [number] Goal that it leads to, by [`crate::task::Goal::id`].
        pub goal: u64,
        /// [m] from the last waypoint to the goal, >= 0: above 0 when the goal's own place cannot be
        /// reached and the nearest one within its tolerance that can is taken.
        pub beside_goal_m: f64,
        /// Code of [`PathBlock`]: which cell made this path another one, made it end beside the goal, or
        /// left no path. May be left 0.
        pub block: u16,
        /// Code of [`ObstacleSource`] of the obstacle in that cell or nearest to it. May be left 0.
        pub source: u16,
        /// Written as 0.
        pub spare: [u16; 2],
        /// [m] x and y of the centre of that cell, `map` frame.
        pub block_m: [f64; 2],
    }
}

message! {
    /// A pose on the path.
    pub struct Waypoint = "zeronav.Waypoint.v1" {
        /// [m] `map` frame.
        pub x_m: f64,
        /// [m] `map` frame.
        pub y_m: f64,
        /// [rad] direction to the next waypoint; at the last one the goal's yaw.
        pub yaw_rad: f32,
        /// [m] clearance when the path was made, saturated at the map's limit.
        pub clearance_m: f32,
    }
}

impl Path {
    /// The fixed fields of a message with these waypoints, by the planner with the key `planner`.
    /// Cost is length; identity, searched map and search statistics are 0.
    #[must_use]
    pub fn new(
        planner: &str,
        status: PathStatus,
        cause: PathCause,
        goal: u64,
        waypoints: &[Waypoint],
    ) -> Self {
        let legs = waypoints.iter().zip(waypoints.iter().skip(1));
        let length_m = legs
            .map(|(from, to)| (to.x_m - from.x_m).hypot(to.y_m - from.y_m))
            .sum();
        Self {
            planner: Self::planner_bytes(planner),
            status: status.code(),
            cause: cause.code(),
            n_waypoints: u32::try_from(waypoints.len()).unwrap_or(u32::MAX),
            length_m,
            cost: length_m,
            goal,
            ..Self::default()
        }
    }

    /// The outcome.
    #[must_use]
    pub const fn status(&self) -> Option<PathStatus> {
        PathStatus::from_code(self.status)
    }

    /// The cause.
    #[must_use]
    pub const fn cause(&self) -> Option<PathCause> {
        PathCause::from_code(self.cause)
    }

    /// The cell that decided.
    #[must_use]
    pub const fn block(&self) -> Option<PathBlock> {
        PathBlock::from_code(self.block)
    }

    /// Where the obstacle comes from that blocks that cell.
    #[must_use]
    pub const fn source(&self) -> Option<ObstacleSource> {
        ObstacleSource::from_code(self.source)
    }

    /// The planner's key as text.
    #[must_use]
    pub fn planner(&self) -> &str {
        let end = self
            .planner
            .iter()
            .position(|byte| *byte == 0)
            .unwrap_or(self.planner.len());
        core::str::from_utf8(&self.planner[..end]).unwrap_or("")
    }

    /// `key` in the form of [`Self::planner`], cut at its length.
    #[must_use]
    pub fn planner_bytes(key: &str) -> [u8; 24] {
        let mut bytes = [0; 24];
        for (to, from) in bytes.iter_mut().zip(key.bytes()) {
            *to = from;
        }
        bytes
    }

    /// Accepts paths whose fields describe `waypoints`.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, waypoints: &[Waypoint]) -> Result<(), Refusal> {
        let status = self.status().ok_or(Refusal::Code("status"))?;
        self.cause().ok_or(Refusal::Code("cause"))?;
        self.block().ok_or(Refusal::Code("block"))?;
        self.source().ok_or(Refusal::Code("source"))?;
        for along in self.block_m {
            number(along, -COORDINATE_M_MAX, COORDINATE_M_MAX, "block_m")?;
        }
        ensure(
            waypoints.len() == self.n_waypoints as usize
                && waypoints.len() <= WAYPOINTS_MAX
                && (status == PathStatus::Found) != waypoints.is_empty(),
            Refusal::Length("waypoints"),
        )?;
        ensure(
            self.planner
                .iter()
                .all(|byte| *byte == 0 || byte.is_ascii_graphic()),
            Refusal::OutOfRange("planner"),
        )?;
        number(self.length_m, 0.0, 1.0e9, "length_m")?;
        number(self.cost, 0.0, 1.0e15, "cost")?;
        number(self.bound, 0.0, self.cost, "bound")?;
        number(self.beside_goal_m, 0.0, 1.0e9, "beside_goal_m")?;
        let limit = COORDINATE_M_MAX;
        for waypoint in waypoints {
            number(waypoint.x_m, -limit, limit, "x_m")?;
            number(waypoint.y_m, -limit, limit, "y_m")?;
            number(f64::from(waypoint.yaw_rad), -6.3, 6.3, "yaw_rad")?;
            number(f64::from(waypoint.clearance_m), 0.0, 1.0e3, "clearance_m")?;
        }
        Ok(())
    }
}
