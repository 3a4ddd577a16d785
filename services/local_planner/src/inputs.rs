//! What the local planner is told in a control period.

use crate::situation::Future;
use crate::staleness::Ages;
use nalgebra::Point2;
use zeronav_motion::{Ahead, InFlight, Twist};
use zeronav_msgs::certainty::PoseCertainty;
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::path::{Path, Waypoint};
use zeronav_msgs::{MapView, Pose, ZoneSet};

/// The newest path message.
#[derive(Debug, Clone, Copy)]
pub struct PathInput<'a> {
    /// Its fixed fields.
    pub path: &'a Path,
    /// Its waypoints, in the map frame.
    pub waypoints: &'a [Waypoint],
}

/// What the local planner knows in one control period. Messages have passed their checks;
/// `None` = never received.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// Control tick.
    pub tick: u64,
    /// [ns] run time of the tick.
    pub run_ns: u64,
    /// [s] control period.
    pub period_s: f64,
    /// The robot and its footprint.
    pub robot: Option<(&'a Description, &'a [Corner])>,
    /// Odometry of this tick.
    pub odometry: Option<&'a Odometry>,
    /// `map_from_odom` of the newest map, with the map.
    pub map: Option<(Pose, MapView<'a>)>,
    /// How far the robot knows where it is on that map.
    pub certainty: PoseCertainty,
    /// Grows when cells of the map change.
    pub map_cells: u64,
    /// Tracked obstacles in the map frame and their age. [s]
    pub obstacles: (&'a [Obstacle], f64),
    /// Where they will be, when that is told.
    pub future: Future<'a>,
    /// The newest path.
    pub path: Option<PathInput<'a>>,
    /// Hits of the newest scan in `base` of now, see [`crate::scan_points::ScanPoints`]. [m]
    pub scan_points_in_base: &'a [Point2<f64>],
    /// The commands on their way to the wheels.
    pub in_flight: &'a InFlight,
    /// Where the robot is slow; `None` = nowhere.
    pub zones: Option<&'a ZoneSet>,
    /// Ages of all of them.
    pub ages: Ages,
    /// The run is stopping.
    pub stopping: bool,
}

impl Inputs<'_> {
    /// Where the robot is.
    #[must_use]
    pub fn map_from_base(&self) -> Option<Pose> {
        let (map_from_odom, _) = self.map?;
        Some(map_from_odom.then(&self.odometry?.pose))
    }

    /// Where the robot will be when a command of now takes effect; `None` = it is there, or nobody
    /// knows.
    #[must_use]
    pub fn ahead(&self) -> Option<Ahead> {
        let (robot, _) = self.robot?;
        let twist = Twist::measured(self.odometry?);
        self.in_flight.ahead(robot, twist, self.run_ns)
    }
}
