//! What a controller is given in a control period, and what it answers.

use crate::past_hits::Hit;
use nalgebra::Point2;
use zeronav_motion::Ahead;
use zeronav_msgs::command::{RequestCause, Validity};
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::foresight::Foreseen;
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::path::Waypoint;
use zeronav_msgs::task::Goal;
use zeronav_msgs::{MapView, Pose};

/// Where obstacles will be, as the simulator tells it in a run that measures what prediction costs;
/// empty in normal runs.
#[derive(Debug, Clone, Copy, Default)]
pub struct Future<'a> {
    /// What moves, `map` frame.
    pub obstacles: &'a [Foreseen],
    /// [s] since they were where they begin.
    pub age_s: f64,
}

/// What a controller may know in one control period. Everything is as of now: the caller has
/// carried the scan's points and the pose forward to the odometry of this period.
#[derive(Debug, Clone, Copy)]
pub struct Situation<'a> {
    /// `map_from_base`.
    pub map_from_base: Pose,
    /// [m/s] measured forward speed in `base`.
    pub v_mps: f64,
    /// [rad/s] measured yaw rate in `base`.
    pub w_radps: f64,
    /// The robot.
    pub robot: &'a Description,
    /// Its convex footprint in `base`, counter-clockwise; empty = a disc.
    pub corners: &'a [Corner],
    /// Corners of the path in the map frame. Segments may be metres long. Empty = no path.
    pub path: &'a [Waypoint],
    /// Id of the path's geometry; another id is another path.
    pub path_geometry: u64,
    /// The shared map; `None` = the points of the scan alone.
    pub map: Option<MapView<'a>>,
    /// Grows when cells of the map change; the same number means the same cells.
    pub map_cells: u64,
    /// Tracked obstacles in the map frame, as they were `obstacles_age_s` ago.
    pub obstacles: &'a [Obstacle],
    /// [s] since the tracked obstacles were so.
    pub obstacles_age_s: f64,
    /// Where they will be, when that is told.
    pub future: Future<'a>,
    /// Hits of the current scan, in `base` as it is now. [m]
    pub scan_points_in_base: &'a [Point2<f64>],
    /// Hits of scans before it where it measures nothing, in `base` as it is now. [m]
    pub past_hits_in_base: &'a [Hit],
    /// Where the path leads, with its tolerances.
    pub goal: &'a Goal,
    /// [0, 1] share of the fastest speed that the age of the inputs allows.
    pub speed_factor: f64,
    /// [m/s] fastest speed that zones allow here and on the path ahead; infinite = they set none.
    pub zone_mps: f64,
    /// [s] control period: the published twist holds that long.
    pub period_s: f64,
    /// [s] by which "now" is ahead of the scan and of what the sensors tell; see
    /// [`Situation::ahead`].
    pub ahead_s: f64,
}

/// Room for what [`Situation::ahead`] moves.
#[derive(Debug, Clone, Default)]
pub struct Room {
    points: Vec<Point2<f64>>,
    hits: Vec<Hit>,
}

impl Situation<'_> {
    /// The same as of the moment when a command of now takes effect: the robot is where the commands on
    /// their way take it, and what moves has moved on. `room` is for the scan and the hits before it from there.
    #[must_use]
    pub fn ahead<'b>(&'b self, ahead: &Ahead, room: &'b mut Room) -> Situation<'b> {
        let then_from_now = Pose::from(ahead.shift.isometry().inverse());
        let Room { points, hits } = room;
        let here = self.scan_points_in_base.iter();
        points.clear();
        points.extend(here.map(|point| then_from_now.transform(*point)));
        hits.clear();
        let past = self.past_hits_in_base.iter();
        hits.extend(past.map(|hit| hit.in_parent(&then_from_now)));
        Situation {
            map_from_base: self.map_from_base.then(&ahead.shift),
            v_mps: ahead.twist.v_mps,
            w_radps: ahead.twist.w_radps,
            scan_points_in_base: points,
            past_hits_in_base: hits,
            obstacles_age_s: self.obstacles_age_s + ahead.elapsed_s,
            future: Future {
                age_s: self.future.age_s + ahead.elapsed_s,
                ..self.future
            },
            ahead_s: self.ahead_s + ahead.elapsed_s,
            ..*self
        }
    }
}

/// The twist for this period and what it rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    /// [m/s] forward speed in `base`.
    pub v_mps: f64,
    /// [rad/s] yaw rate in `base`.
    pub w_radps: f64,
    /// `Drive`, or why the robot shall stop; then the twist is the first step of the ramp to rest.
    pub validity: Validity,
    /// [m] length of the checked arc on which the robot can still stop.
    pub braking_arc_m: f64,
    /// The robot turns on the spot, towards the path or the goal's yaw.
    pub turns: bool,
    /// Motions looked at.
    pub rollouts: u32,
    /// [m] along the path to the first place where the robot would touch something, within the
    /// controller's sight; `None` = the path is free as far as it sees.
    pub blocked_arc_m: Option<f64>,
    /// Where an obstacle keeps the robot from its goal, `map` frame [m], as far as a controller tells that
    /// does not follow the path.
    pub against: Option<Point2<f64>>,
    /// What decided the twist, as far as the controller tells.
    pub cause: RequestCause,
    /// [m/s] fastest speed that this allows; 0 = it sets none.
    pub limit_mps: f64,
}
