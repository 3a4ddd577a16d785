//! `control/velocity_request` and `robot/velocity_command`: what the wheels shall do.

use crate::message::{Refusal, SPEED_MAX, ZeroCopySend, ensure, number};
use crate::scan::BEAMS_MAX;
use crate::{codes, message};

/// Farthest point of a scan from the robot. [m]
const POINT_M_MAX: f64 = 1.0e3;

codes! {
    /// What a velocity request or command means. Anything but `Drive` is a stop.
    pub enum Validity: u16 {
        /// Idle: there is no path to follow.
        NoPath = 0 => "no_path",
        /// Drive as asked.
        Drive = 1 => "drive",
        /// The goal is reached.
        AtGoal = 2 => "at_goal",
        /// No motion is admissible now.
        Blocked = 3 => "blocked",
        /// An input is too old or missing.
        Stale = 4 => "stale",
        /// Guard only: no request came yet.
        NoRequest = 5 => "no_request",
        /// The task was cancelled or the run is stopping.
        Stopped = 6 => "stopped",
    }
}

codes! {
    /// What the guard did to a request.
    pub enum Intervention: u16 {
        /// Passed on as it was.
        None = 0 => "none",
        /// Brought into the robot's limits.
        Clamped = 1 => "clamped",
        /// Refused: not a number.
        Refused = 2 => "refused",
        /// Slowed to a stop because the request is too old or missing.
        RequestStale = 3 => "request_stale",
        /// Slowed to a stop because the scan is too old or missing.
        ScanStale = 4 => "scan_stale",
        /// Slowed to a stop because odometry is too old or missing.
        OdometryStale = 5 => "odometry_stale",
        /// Slowed because something is in the way.
        Slowed = 6 => "slowed",
        /// Stopped because something is in the way.
        StoppedShort = 7 => "stopped_short",
        /// Slowed because of the speed limit of a zone.
        ZoneSlowed = 8 => "zone_slowed",
        /// Slowed or stopped because a keepout zone is in the way.
        ZoneStopped = 9 => "zone_stopped",
        /// Slowed to a stop because zones were announced and have not come.
        ZonesMissing = 10 => "zones_missing",
    }
}

codes! {
    /// What decided a velocity request. Nothing that is carried out depends on it.
    pub enum RequestCause: u16 {
        /// Not told.
        None = 0 => "none",
        /// Nothing but the limits of the robot.
        Free = 1 => "free",
        /// The end of the path: slow enough to stop there.
        Goal = 2 => "goal",
        /// A corner of the path.
        Corner = 3 => "corner",
        /// The controller's critics prefer a slower motion; which of them is not told.
        Critics = 4 => "critics",
        /// An input is getting old.
        Ageing = 5 => "ageing",
        /// The robot faces away from the path.
        Heading = 6 => "heading",
        /// It turns on the spot towards the path.
        Turn = 7 => "turn",
        /// It waits for a dynamic obstacle to pass before it turns on the spot.
        TurnWait = 8 => "turn_wait",
        /// It is within the goal's tolerance and slows down to a stop.
        Arrive = 9 => "arrive",
        /// It turns on the spot to the goal's yaw.
        GoalYaw = 10 => "goal_yaw",
        /// No motion is admissible.
        Blocked = 11 => "blocked",
        /// An input is too old or missing.
        Stale = 12 => "stale",
        /// Recovery: another path was asked for.
        AskForPath = 13 => "ask_for_path",
        /// Recovery: it drives back along the track that it came by.
        BackUp = 14 => "back_up",
        /// Recovery: it turns on the spot to look around.
        Rotate = 15 => "rotate",
        /// Recovery: it waits for the way to become free.
        Wait = 16 => "wait",
        /// Recovery: nothing is left to try.
        GiveUp = 17 => "give_up",
        /// Critics: a slower motion keeps more clearance.
        ClearanceCritic = 18 => "clearance_critic",
        /// Critics: a slower motion stays nearer to the path, or more along it.
        PathCritic = 19 => "path_critic",
        /// Critics: a slower motion gets farther on the free way to the goal.
        ProgressCritic = 20 => "progress_critic",
        /// Critics: a faster motion leads into a dynamic obstacle where that will be.
        DynamicObstacleCritic = 21 => "dynamic_obstacle_critic",
        /// Critics: a slower motion changes the yaw rate less.
        SmoothnessCritic = 22 => "smoothness_critic",
        /// From no faster motion that was looked at can the robot stop in time.
        StoppingDistance = 23 => "stopping_distance",
        /// A search in time among dynamic obstacles: a slower motion costs less time and risk.
        TimedSearch = 24 => "timed_search",
        /// The robot faces away from where a potential field leads it.
        PotentialField = 25 => "potential_field",
        /// It yields to a dynamic obstacle that a faster motion would soon touch.
        Yield = 26 => "yield",
        /// Recovery: it drives a manoeuvre of arcs and turns that was searched for with the true
        /// outline.
        Manoeuvre = 27 => "manoeuvre",
        /// The controller fits a curve to its way and follows it; no fit is free of obstacles, so that it
        /// goes without one. Nothing else limits it.
        NoFit = 28 => "no_fit",
        /// It does not know where it is, and looks around by small safe motions.
        SeekPose = 29 => "seek_pose",
        /// The speed limit of a zone, here or so near that the robot has to slow down.
        SpeedZone = 30 => "speed_zone",
    }
}

impl RequestCause {
    /// True for a behaviour of the recovery.
    #[must_use]
    pub const fn is_recovery(self) -> bool {
        matches!(
            self,
            Self::AskForPath
                | Self::BackUp
                | Self::Rotate
                | Self::Manoeuvre
                | Self::Wait
                | Self::GiveUp
        )
    }
}

codes! {
    /// An input of the local planner.
    pub enum PlannerInput: u16 {
        /// None.
        None = 0 => "none",
        /// `robot/odometry`.
        Odometry = 1 => "odometry",
        /// `robot/scan`.
        Scan = 2 => "scan",
        /// `map/update`.
        Map = 3 => "map",
        /// `plan/path`.
        Path = 4 => "path",
        /// `robot/description`.
        Description = 5 => "description",
        /// The pose on `map/update`: the robot does not know where it is.
        Pose = 6 => "pose",
    }
}

codes! {
    /// Why the recovery does what it does.
    pub enum RecoveryReason: u16 {
        /// It does nothing.
        None = 0 => "none",
        /// No motion was admissible.
        Blocked = 1 => "blocked",
        /// The robot came no closer.
        NoProgress = 2 => "no_progress",
        /// A dynamic obstacle is near.
        DynamicObstacle = 3 => "dynamic_obstacle",
        /// The attempt before it took too long.
        TimedOut = 4 => "timed_out",
        /// The time without coming closer is over.
        Stuck = 5 => "stuck",
        /// No attempt is left.
        OutOfAttempts = 6 => "out_of_attempts",
    }
}

/// Age that is not known, or longer than the field holds. [ms]
pub const AGE_MS_MAX: u16 = u16::MAX;

message! {
    /// Fixed fields of a velocity request; the slice is empty. What explains it may be left 0.
    pub struct VelocityRequest = "zeronav.VelocityRequest.v2" {
        /// [m/s] forward speed in `base`.
        pub v_mps: f64,
        /// [rad/s] yaw rate in `base`.
        pub w_radps: f64,
        /// Code of [`Validity`].
        pub validity: u16,
        /// Code of [`RequestCause`].
        pub cause: u16,
        /// Code of [`PlannerInput`]: the one that is old, with the causes `ageing` and `stale`.
        pub input: u16,
        /// Code of [`RecoveryReason`], with the causes of the recovery.
        pub recovery: u16,
        /// [m] length of the arc on which the author can still stop, >= 0.
        pub braking_arc_m: f64,
        /// [ms, ms, ms, ms] ages of odometry, scan, map and path when it was made; 65535 = never
        /// received, or older. All 0 with the cause `none` = not told.
        pub ages_ms: [u16; 4],
        /// [m/s] fastest forward speed that the cause allows, >= 0; 0 = it sets none.
        pub limit_mps: f64,
        /// [m] along the path to the first obstacle on it, >= 0; 0 = none in sight.
        pub blocked_arc_m: f64,
        /// [number] Track of the nearest dynamic obstacle on `map/obstacles` within 2.5 m; 0 = none.
        pub obstacle: u64,
    }
}

message! {
    /// Fixed fields of a velocity command; the slice is empty. What explains it may be left 0.
    pub struct VelocityCommand = "zeronav.VelocityCommand.v2" {
        /// [m/s] forward speed in `base`.
        pub v_mps: f64,
        /// [rad/s] yaw rate in `base`.
        pub w_radps: f64,
        /// Code of [`Validity`].
        pub validity: u16,
        /// Code of [`Intervention`].
        pub intervention: u16,
        /// [number] Beam towards the point that decided, counted from 1, in a scan taken where the
        /// robot is now; 0 = no point decided.
        pub beam: u16,
        /// Written as 0.
        pub spare: u16,
        /// [m] x and y of the point of a scan that is nearest to the way that was asked for and not free, in
        /// `base` of now; with the interventions `slowed` and `stopped_short`.
        pub point_m: [f64; 2],
        /// [m] least distance between the outline and that point on that way, at most the margin
        /// and the slow zone of the guard; below 0 inside the outline.
        pub point_clearance_m: f64,
    }
}

impl VelocityRequest {
    /// The meaning.
    #[must_use]
    pub const fn validity(&self) -> Option<Validity> {
        Validity::from_code(self.validity)
    }

    /// What decided it.
    #[must_use]
    pub const fn cause(&self) -> Option<RequestCause> {
        RequestCause::from_code(self.cause)
    }

    /// The input that is old.
    #[must_use]
    pub const fn input(&self) -> Option<PlannerInput> {
        PlannerInput::from_code(self.input)
    }

    /// Why the recovery does what it does.
    #[must_use]
    pub const fn recovery(&self) -> Option<RecoveryReason> {
        RecoveryReason::from_code(self.recovery)
    }

    /// Accepts finite requests with a known meaning.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), Refusal> {
        self.validity().ok_or(Refusal::Code("validity"))?;
        self.cause().ok_or(Refusal::Code("cause"))?;
        self.input().ok_or(Refusal::Code("input"))?;
        self.recovery().ok_or(Refusal::Code("recovery"))?;
        number(self.v_mps, -SPEED_MAX, SPEED_MAX, "v_mps")?;
        number(self.w_radps, -SPEED_MAX, SPEED_MAX, "w_radps")?;
        number(self.braking_arc_m, 0.0, 1.0e6, "braking_arc_m")?;
        number(self.limit_mps, 0.0, SPEED_MAX, "limit_mps")?;
        number(self.blocked_arc_m, 0.0, 1.0e6, "blocked_arc_m")
    }
}

impl VelocityCommand {
    /// The meaning.
    #[must_use]
    pub const fn validity(&self) -> Option<Validity> {
        Validity::from_code(self.validity)
    }

    /// What the guard did.
    #[must_use]
    pub const fn intervention(&self) -> Option<Intervention> {
        Intervention::from_code(self.intervention)
    }

    /// Accepts finite commands with known codes.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), Refusal> {
        self.validity().ok_or(Refusal::Code("validity"))?;
        self.intervention().ok_or(Refusal::Code("intervention"))?;
        number(self.v_mps, -SPEED_MAX, SPEED_MAX, "v_mps")?;
        number(self.w_radps, -SPEED_MAX, SPEED_MAX, "w_radps")?;
        ensure(
            usize::from(self.beam) <= BEAMS_MAX,
            Refusal::OutOfRange("beam"),
        )?;
        for along in self.point_m {
            number(along, -POINT_M_MAX, POINT_M_MAX, "point_m")?;
        }
        number(
            self.point_clearance_m,
            -POINT_M_MAX,
            POINT_M_MAX,
            "point_clearance_m",
        )
    }
}
