//! The states of the recovery, the reasons of its transitions, and what they are decided by.

/// What the robot does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Behaviour {
    /// Following the path, as the pilot decides: turns on the spot and the arrival included.
    Follow,
    /// Waiting for another path.
    AskForPath,
    /// Driving back along the track that it came by.
    BackUp,
    /// Turning on the spot to look around.
    Rotate,
    /// Driving a manoeuvre of arcs and turns that was searched for with the true outline.
    Manoeuvre,
    /// Waiting for the way to become free.
    Wait,
    /// Nothing more: the task has failed.
    GiveUp(Cause),
}

/// Why a task was given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Cause {
    /// No motion was admissible.
    Blocked,
    /// The robot moved, but came no closer.
    NoProgress,
    /// It came closer between them, but needed too many attempts.
    TooManyAttempts,
}

impl Behaviour {
    /// True for a motion of the recovery's own.
    pub(crate) const fn is_manoeuvre(self) -> bool {
        matches!(self, Self::BackUp | Self::Rotate | Self::Manoeuvre)
    }

    /// True for an attempt to make progress again.
    #[must_use]
    pub const fn is_attempt(self) -> bool {
        matches!(
            self,
            Self::BackUp | Self::Rotate | Self::Manoeuvre | Self::Wait
        )
    }
}

/// Why a behaviour ended and the next one began.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Reason {
    /// Another goal is current, or none.
    AnotherGoal,
    /// No motion is admissible.
    Blocked,
    /// The robot does not come closer.
    NoProgress,
    /// A dynamic obstacle is near.
    DynamicObstacle,
    /// Another path came.
    AnotherPath,
    /// A motion is admissible again.
    Cleared,
    /// The manoeuvre is complete.
    Done,
    /// The way behind is not free or not known.
    NotFreeBehind,
    /// There is no room to turn.
    NoRoomToTurn,
    /// The goal's yaw can only be reached by a manoeuvre.
    Approach,
    /// No manoeuvre was found.
    NoManoeuvre,
    /// The next piece of the manoeuvre is not free.
    NotFreeAhead,
    /// It took too long.
    TimedOut,
    /// The task's time without coming closer is over.
    Stuck,
    /// No attempt is left.
    OutOfAttempts,
}

/// A change of behaviour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transition {
    /// The behaviour that ended.
    pub from: Behaviour,
    /// The behaviour that begins.
    pub to: Behaviour,
    /// Why.
    pub reason: Reason,
}

/// Observations of a control period.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[allow(clippy::struct_excessive_bools, reason = "independent observations")]
pub struct Facts {
    /// [s] run time.
    pub now_s: f64,
    /// The current goal; 0 = none.
    pub goal: u64,
    /// Id of the path's geometry; 0 = no path.
    pub geometry: u64,
    /// The controller finds no admissible motion.
    pub blocked: bool,
    /// The pilot turns on the spot.
    pub turns: bool,
    /// [s] since the robot came closer to the goal.
    pub stalled_s: f64,
    /// [s] since it came closer, or turned on towards its way.
    pub idle_s: f64,
    /// The latter is longer than `task.no_progress_s`.
    pub no_progress: bool,
    /// It is longer than `task.stuck_s`.
    pub stuck: bool,
    /// A dynamic obstacle is near.
    pub dynamic_obstacle: bool,
    /// The way back along the track is free, and the robot drives backwards at all.
    pub free_behind: bool,
    /// There is room to turn on the spot.
    pub room_to_turn: bool,
    /// A manoeuvre may be searched for.
    pub manoeuvrable: bool,
    /// Following, the robot has hardly moved for some seconds.
    pub hardly_moves: bool,
    /// One is needed to arrive with the goal's yaw.
    pub approach: bool,
    /// The manoeuvre is over, and why.
    pub manoeuvred: Option<Reason>,
    /// [m] driven back since that began.
    pub backed_m: f64,
    /// [rad] turned since that began.
    pub rotated_rad: f64,
}
