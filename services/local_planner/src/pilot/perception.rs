//! What a controller sees of path, map, scan and dynamic obstacles in a control period.
//!
//! Which map and which points of the scan a chooser sees is decided here and nowhere else.

use crate::cost_to_go::{CostToGo, CostToGoInputs};
use crate::dwa::options::DwaConfig;
use crate::dynamic_obstacles::DynamicObstacles;
use crate::local_path::LocalPath;
use crate::progress::{PathTracker, Place};
use crate::recovery::escape::{LOOKBACK_M, PIECE_M};
use crate::situation::Situation;
use crate::surroundings::{Reach, Surroundings};
use nalgebra::Point2;
use zeronav_motion::{Twist, stop_distance_m};
use zeronav_msgs::description::Description;
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::scan::BEAMS_MAX;

/// [s] of driving at full speed that the sampled stretch of the path spans at most.
pub(crate) const PATH_HORIZON_S: f64 = 1.5;

/// [s] within which a robot that brakes must be hit for rest to be no refuge.
const HIT_SOON_S: f64 = 3.0;

/// What is seen in a period.
#[derive(Debug)]
pub(crate) struct Perception {
    pub(crate) tracker: PathTracker,
    pub(crate) path: LocalPath,
    pub(crate) surroundings: Surroundings,
    pub(crate) dynamic: DynamicObstacles,
    tracks: Tracks,
}

/// What becomes of tracked obstacles.
#[derive(Debug)]
pub(crate) enum Tracks {
    /// Nothing: obstacles are where the scan met them.
    Ignored,
    /// They are avoided where the scan met them, and every command is checked against where they
    /// will be.
    Checked,
    /// They are avoided where they will be instead of where the scan met them.
    Predicted(Box<Prediction>),
}

/// What a chooser in time sees besides.
#[derive(Debug)]
pub(crate) struct Prediction {
    cost_to_go: CostToGo,
    /// Path whose cost-to-go can be asked for, and the one that it was put off for.
    found: Option<u64>,
    put_off: Option<u64>,
    /// Points of the scan that belong to no dynamic obstacle.
    static_points: Vec<Point2<f64>>,
    /// [m] around the robot that is known where there are dynamic obstacles, if not more is.
    sight_m: f64,
}

impl Default for Prediction {
    fn default() -> Self {
        Self {
            cost_to_go: CostToGo::default(),
            found: None,
            put_off: None,
            static_points: Vec::with_capacity(BEAMS_MAX),
            sight_m: 0.0,
        }
    }
}

impl Prediction {
    /// The same with at least `sight_m` around the robot where there are dynamic obstacles.
    pub(crate) fn with_sight(self, sight_m: f64) -> Self {
        Self { sight_m, ..self }
    }
}

/// [s] length of a rollout: at least the time of a stop from full speed.
pub(crate) fn horizon_s(config: &DwaConfig, robot: &Description) -> f64 {
    let stop_m = stop_distance_m(robot, robot.v_mps_max, config.reaction_s) + config.stop_margin_m;
    config.horizon_s.max(stop_m / robot.v_mps_max)
}

impl Perception {
    pub(crate) fn new(tracks: Tracks) -> Self {
        Self {
            tracker: PathTracker::new(),
            path: LocalPath::default(),
            surroundings: Surroundings::default(),
            dynamic: DynamicObstacles::default(),
            tracks,
        }
    }

    /// Samples the path and takes in map, scan and dynamic obstacles.
    pub(crate) fn look(&mut self, config: &DwaConfig, situation: &Situation<'_>, place: &Place) {
        let robot = situation.robot;
        let horizon_s = horizon_s(config, robot);
        self.surroundings.describe(robot, situation.corners);
        let position = situation.map_from_base.point();
        // Sampled as densely as the weights of the evaluation are meant for.
        let path_m = robot.v_mps_max * horizon_s.min(PATH_HORIZON_S) + 0.5;
        self.path
            .sample(&self.tracker, situation.path, place, position, path_m);
        let map = situation.map.map(|map| (map, situation.map_cells));
        let mut stamped = situation.scan_points_in_base;
        let obstacles = match self.tracks {
            Tracks::Ignored => &[],
            Tracks::Checked | Tracks::Predicted(_) => situation.obstacles,
        };
        self.predict(situation, obstacles);
        let reach = self.reach(config, situation);
        if let Tracks::Predicted(prediction) = &mut self.tracks {
            let points = situation.scan_points_in_base.iter();
            prediction.static_points.clear();
            prediction
                .static_points
                .extend(points.filter(|point| !self.dynamic.owns(**point)));
            stamped = &prediction.static_points;
        }
        let hits = (situation.scan_points_in_base, situation.past_hits_in_base);
        self.surroundings
            .look(map, &situation.map_from_base, hits, stamped, reach);
    }

    /// Makes the cost-to-go of a chooser in time that of path and map.
    ///
    /// It takes most of the time of an answer to a new path. One that can do without for a period says so
    /// by `puts_off`: then there is none for a new path in its first period.
    pub(super) fn find_cost_to_go(
        &mut self,
        config: &DwaConfig,
        situation: &Situation<'_>,
        place: &Place,
        puts_off: bool,
    ) {
        let reach_m = self.reach(config, situation).field_m;
        let (Tracks::Predicted(prediction), Some(map)) = (&mut self.tracks, situation.map) else {
            return;
        };
        let path = Some(situation.path_geometry);
        // Among what moves the path changes too often to be without it each time.
        let puts_off = puts_off && situation.obstacles.is_empty();
        if puts_off && prediction.found != path && prediction.put_off != path {
            (prediction.found, prediction.put_off) = (None, path);
            return;
        }
        prediction.found = path;
        let inputs = CostToGoInputs {
            map,
            map_cells: situation.map_cells,
            path: situation.path,
            geometry: situation.path_geometry,
            place: *place,
            position: situation.map_from_base.point(),
            reach_m,
            // Narrower than that no stop is free, whatever the robot's heading.
            inscribed_m: self.surroundings.footprint.inscribed_m + config.safety_margin_m,
            soft_m: config.soft_clearance_m,
        };
        prediction.cost_to_go.update(&self.tracker, &inputs);
    }

    /// Takes in map, scan and dynamic obstacles for a manoeuvre that follows no path: all points of
    /// the scan are obstacles, and tracked ones are predicted besides, whatever the controller does. Sees
    /// at least `reach_m` far.
    pub(crate) fn look_around(
        &mut self,
        config: &DwaConfig,
        situation: &Situation<'_>,
        reach_m: f64,
    ) {
        self.surroundings
            .describe(situation.robot, situation.corners);
        self.predict(situation, situation.obstacles);
        let map = situation.map.map(|map| (map, situation.map_cells));
        let points = situation.scan_points_in_base;
        let reach = self.reach(config, situation);
        let reach = Reach {
            field_m: reach.field_m.max(reach_m),
            ..reach
        };
        let hits = (points, situation.past_hits_in_base);
        self.surroundings
            .look(map, &situation.map_from_base, hits, points, reach);
    }

    fn predict(&mut self, situation: &Situation<'_>, obstacles: &[Obstacle]) {
        self.dynamic.take(
            obstacles,
            (situation.obstacles_age_s, situation.ahead_s),
            &situation.future,
            &situation.map_from_base,
        );
    }

    /// How far the queries of a period reach.
    fn reach(&self, config: &DwaConfig, situation: &Situation<'_>) -> Reach {
        let robot = situation.robot;
        let sight_m = match &self.tracks {
            Tracks::Predicted(prediction) if !situation.obstacles.is_empty() => prediction.sight_m,
            _ => 0.0,
        };
        let rollout_m = robot.v_mps_max * horizon_s(config, robot);
        Reach {
            field_m: sight_m.max(rollout_m.max(2.0 * LOOKBACK_M) + 0.5),
            stop_m: stop_distance_m(robot, robot.v_mps_max, config.reaction_s).max(PIECE_M),
            soft_m: config.soft_clearance_m,
            margin_m: config.safety_margin_m,
        }
    }

    /// The cost-to-go of a chooser in time as of [`Self::find_cost_to_go`]; none before the first map.
    pub(crate) fn cost_to_go(&self) -> Option<&CostToGo> {
        match &self.tracks {
            Tracks::Predicted(prediction) => prediction.found.map(|_| &prediction.cost_to_go),
            Tracks::Ignored | Tracks::Checked => None,
        }
    }

    /// [m] along the path to the first obstacle in sight.
    pub(crate) fn blocked_arc_m(&self) -> Option<f64> {
        self.path.blocked_m(
            &self.surroundings.field,
            self.surroundings.footprint.inscribed_m,
        )
    }

    /// [m] length of the stop from `twist` as far as what is static is concerned, when a robot that brakes
    /// from `from` is hit soon; `None` when that is not free, or the robot may as well brake.
    pub(crate) fn flight_arc_m(
        &self,
        config: &DwaConfig,
        robot: &Description,
        from: Twist,
        twist: Twist,
    ) -> Option<f64> {
        let surroundings = &self.surroundings;
        if surroundings.rest_is_free(robot, from, &self.dynamic, HIT_SOON_S) {
            return None;
        }
        surroundings.static_stop_arc_m(robot, twist, config.reaction_s)
    }

    /// [m] length of the stop from `twist`; `None` when it is not free.
    pub(crate) fn stop_arc_m(
        &self,
        config: &DwaConfig,
        robot: &Description,
        twist: Twist,
    ) -> Option<f64> {
        self.surroundings
            .stop_arc_m(robot, twist, config.reaction_s, &self.dynamic)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::situation::Future;
    use crate::test_robot::robot;
    use zeronav_msgs::path::Waypoint;
    use zeronav_msgs::task::Goal;
    use zeronav_msgs::{GridGeometry, MapCell, MapView, Pose};

    #[test]
    fn a_new_path_does_without_cost_to_go_for_a_period_unless_something_moves() {
        let geometry = GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 0.1,
            width: 60,
            height: 60,
        };
        let free = MapCell {
            clearance_mm: 1000,
            ..MapCell::default()
        };
        let cells = vec![free; geometry.len()];
        let path = [1.0, 5.0].map(|x_m| Waypoint {
            x_m,
            y_m: 3.0,
            ..Waypoint::default()
        });
        let (robot, goal) = (robot(), Goal::default());
        let mut seen = Perception::new(Tracks::Predicted(Box::default()));
        let mut knows = |path_geometry, obstacles: &[Obstacle], puts_off| {
            let situation = Situation {
                map_from_base: Pose::new(1.5, 3.0, 0.0),
                v_mps: 0.0,
                w_radps: 0.0,
                robot: &robot,
                corners: &[],
                path: &path,
                path_geometry,
                map: Some(MapView {
                    geometry: &geometry,
                    cells: &cells,
                }),
                map_cells: 1,
                obstacles,
                obstacles_age_s: 0.0,
                future: Future::default(),
                scan_points_in_base: &[],
                past_hits_in_base: &[],
                goal: &goal,
                speed_factor: 1.0,
                zone_mps: f64::INFINITY,
                period_s: 0.02,
                ahead_s: 0.0,
            };
            let here = situation.map_from_base.point();
            let place = seen.tracker.advance(path_geometry, &path, here);
            let place = place.expect("a path");
            seen.find_cost_to_go(&DwaConfig::default(), &situation, &place, puts_off);
            let to_go_m = seen.cost_to_go().and_then(|cost_to_go| cost_to_go.at(here));
            to_go_m.is_some_and(|to_go_m| (to_go_m - 3.5).abs() < 0.2)
        };
        assert!(!knows(1, &[], true), "the first period of a path");
        assert!(knows(1, &[], true), "the second");
        assert!(!knows(2, &[], true), "another path");
        assert!(knows(2, &[], true) && knows(2, &[], true));
        assert!(knows(3, &[Obstacle::default()], true), "something moves");
        assert!(knows(4, &[], false), "a chooser that needs it at once");
    }
}
