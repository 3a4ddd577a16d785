//! A world that can be asked: what is solid, how far away it is, and what a map of it looks like.

use crate::convex::Convex;
use crate::error::{SpecError, number};
use crate::footprint::Footprint;
use crate::shape::{Shape, point};
use crate::spec::{ObstacleSpec, ShapeSpec, Trigger, WorldSpec};
use crate::static_map::{StaticMap, cells_along};
use crate::track::Track;
use crate::{raster, rectangles};
use nalgebra::Point2;
use parry2d::bounding_volume::Aabb;
use parry2d::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use parry2d::query::PointQuery;
use parry2d::shape::Segment;
use zeronav_msgs::grid::{RESOLUTION_M, SIDE_CELLS_MAX};
use zeronav_msgs::truth::TRUTH_OBSTACLES_MAX;
use zeronav_msgs::{GridGeometry, Pose};

/// Longest time that a scenario may name. [s]
pub const TIME_S_MAX: f64 = 1.0e6;

/// Shortest time that an obstacle lasts. [s]
pub const LASTS_S_MIN: f64 = 1.0e-3;

/// Distances of the robot that trigger an obstacle. [m]
pub const NEAR_M: [f64; 2] = [1.0e-3, 1.0e6];

/// Fastest obstacle. [m/s]
pub const SPEED_MPS_MAX: f64 = 1.0e3;

/// A scripted obstacle: what the scenario says and its shape. It is on no map.
#[derive(Debug, Clone)]
pub struct Obstacle {
    /// What the scenario says.
    pub spec: ObstacleSpec,
    /// Its shape; [`Shape::pose`] is where it appears.
    pub shape: Shape,
}

impl Obstacle {
    /// True when it is there from the start of the run.
    #[must_use]
    pub fn is_there_from_the_start(&self) -> bool {
        self.spec.appears.as_ref().is_none_or(|trigger| {
            trigger.robot_near.is_none() && trigger.at_s.is_some_and(|at_s| at_s <= 0.0)
        })
    }
}

/// The world of a scenario.
///
/// Solid are the occupied cells of the map file (as closed squares: the grid is the world, not a
/// picture of it), the shapes, and obstacles while they exist. Unknown cells and what lies beside
/// the map are not solid.
#[derive(Debug, Clone)]
pub struct World {
    geometry: GridGeometry,
    static_map: Option<StaticMap>,
    shapes: Vec<Shape>,
    obstacles: Vec<Obstacle>,
    /// The occupied cells of the map file.
    rectangles: Vec<Aabb>,
    /// First the rectangles, then the shapes.
    tree: Bvh,
}

impl World {
    /// The world of `spec`, whose map file has been read, or whose map has been generated, as
    /// `static_map`. The words for data sets must have been replaced by what their files hold.
    ///
    /// # Errors
    /// The first field that is wrong. `map` when `spec` names a map and `static_map` is `None` or
    /// the other way around, or when its cells do not fit its geometry.
    pub fn new(spec: &WorldSpec, static_map: Option<StaticMap>) -> Result<Self, SpecError> {
        let geometry = match (&static_map, spec.area_m) {
            (Some(map), None) => map.geometry,
            (Some(_), Some(_)) => {
                let why = "a map file brings its own area: remove area_m or map";
                return Err(SpecError::new("area_m", why));
            }
            (None, area_m) => geometry_of(area_m, spec.resolution_m)?,
        };
        if static_map.is_some() != (spec.map.is_some() || spec.generated.is_some()) {
            return Err(SpecError::new("map", "its file has not been read"));
        }
        for (unread, field) in [
            (spec.barn.is_some(), "barn"),
            (spec.dynabarn.is_some(), "dynabarn"),
            (spec.pedestrians.is_some(), "pedestrians"),
        ] {
            if unread {
                return Err(SpecError::new(field, "its file has not been read"));
            }
        }
        if let Some(map) = &static_map {
            let refused = map.geometry.check().err().map(|why| why.to_string());
            let wrong_length = map.cells.len() != map.geometry.len();
            let why = refused.or_else(|| wrong_length.then(|| "cells are missing".to_owned()));
            if let Some(why) = why {
                return Err(SpecError::new("map", why));
            }
        }
        let mut shapes = Vec::with_capacity(spec.shapes.len());
        for (index, shape) in spec.shapes.iter().enumerate() {
            let place = format!("shapes[{index}]");
            shapes.push(Shape::new(shape).map_err(|error| error.within(&place))?);
        }
        let obstacles = obstacles_of(&spec.obstacles)?;
        let rectangles = static_map
            .as_ref()
            .map(rectangles::of_occupied)
            .unwrap_or_default();
        let solid: Vec<Aabb> = rectangles
            .iter()
            .copied()
            .chain(shapes.iter().map(|shape| shape.placed().bounds()))
            .collect();
        let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &solid);
        let world = Self {
            geometry,
            static_map,
            shapes,
            obstacles,
            rectangles,
            tree,
        };
        for (index, obstacle) in world.obstacles.iter().enumerate() {
            let placed = obstacle.shape.placed();
            if obstacle.spec.bounces_mps.is_some() && world.convex_distance_m(placed, 1.0) <= 0.0 {
                let why = "a disc that bounces must not begin in something static";
                return Err(SpecError::new(format!("obstacles[{index}].shape"), why));
            }
        }
        Ok(world)
    }

    /// Where the grid of the static map lies.
    #[must_use]
    pub const fn geometry(&self) -> &GridGeometry {
        &self.geometry
    }

    /// The map file's cells, without the shapes; `None` for a world of shapes alone.
    #[must_use]
    pub const fn static_map(&self) -> Option<&StaticMap> {
        self.static_map.as_ref()
    }

    /// Shapes that never move, in the order of the scenario.
    #[must_use]
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Scripted obstacles, in the order of the scenario.
    #[must_use]
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// The occupied cells of the map file as few rectangles: they cover exactly these cells and
    /// none twice. Empty for a world of shapes alone.
    #[must_use]
    pub fn occupied_rectangles(&self) -> &[Aabb] {
        &self.rectangles
    }

    /// True when a point of the map frame lies on the static map.
    #[must_use]
    pub fn contains(&self, point_in_map: Point2<f64>) -> bool {
        self.geometry.cell_at(point_in_map).is_some()
    }

    /// The static map with the shapes drawn in: a cell is occupied when its closed square touches
    /// a shape. Without a map file everything else is free. Obstacles stand on no map.
    #[must_use]
    pub fn rasterise(&self) -> StaticMap {
        let mut map = self
            .static_map
            .clone()
            .unwrap_or_else(|| StaticMap::free(self.geometry));
        for shape in &self.shapes {
            raster::mark(&mut map, shape.placed());
        }
        map
    }

    /// Distance of the robot from everything static, 0 when it touches; infinite in an empty
    /// world. [m]
    #[must_use]
    pub fn distance_m(&self, footprint: &Footprint, map_from_base: &Pose) -> f64 {
        self.convex_distance_m(&footprint.placed(map_from_base), f64::INFINITY)
    }

    /// Like [`Self::distance_m`], also from obstacles: those that exist, as their place in
    /// [`Self::obstacles`] and `map_from_shape`. Places beyond the list are left out.
    #[must_use]
    pub fn distance_with_obstacles_m(
        &self,
        footprint: &Footprint,
        map_from_base: &Pose,
        existing: impl IntoIterator<Item = (usize, Pose)>,
    ) -> f64 {
        let robot = footprint.placed(map_from_base);
        let mut nearest_m = f64::INFINITY;
        for (index, map_from_shape) in existing {
            if let Some(obstacle) = self.obstacles.get(index) {
                let placed = obstacle.shape.placed_at(&map_from_shape);
                nearest_m = nearest_m.min(robot.distance_m(&placed));
            }
        }
        self.convex_distance_m(&robot, nearest_m)
    }

    /// True when the robot touches something static.
    #[must_use]
    pub fn touches(&self, footprint: &Footprint, map_from_base: &Pose) -> bool {
        let placed = footprint.placed(map_from_base);
        self.convex_distance_m(&placed, f64::MIN_POSITIVE) <= 0.0
    }

    /// Distance of a convex set of the map frame from everything static, at most `limit_m`. [m]
    #[must_use]
    pub fn convex_distance_m(&self, convex: &Convex, limit_m: f64) -> f64 {
        let own = convex.bounds();
        // Distance of two rectangles = distance of the origin from their Minkowski difference.
        let apart_m = |node: &BvhNode, _| {
            Aabb::new(node.mins() - own.maxs, node.maxs() - own.mins).distance_to_origin()
        };
        let leaf_m = |leaf: u32, _| {
            let index = leaf as usize;
            Some(match self.rectangles.get(index) {
                Some(rectangle) => convex.distance_to_bounds_m(rectangle),
                None => convex.distance_m(self.shapes[index - self.rectangles.len()].placed()),
            })
        };
        self.tree
            .find_best(limit_m, apart_m, leaf_m)
            .map_or(limit_m, |(_, distance_m)| distance_m)
    }

    /// Distance of a chain of straight lines of the map frame from everything static, 0 when they
    /// touch: a robot of radius r whose centre drives along it stays clear when this is more than
    /// r. A single point counts as a chain; infinite for none and in an empty world. [m]
    ///
    /// Distances to cells of the map file are exact to rounding: a line that clips the corner of
    /// an occupied square by a hundredth of a cell touches it.
    #[must_use]
    pub fn polyline_clearance_m(&self, polyline_in_map: &[Point2<f64>]) -> f64 {
        let ends = polyline_in_map.windows(2).map(|ends| [ends[0], ends[1]]);
        let only = match polyline_in_map {
            [only] => Some([*only, *only]),
            _ => None,
        };
        ends.chain(only).fold(f64::INFINITY, |nearest_m, [a, b]| {
            self.segment_distance_m(a, b, nearest_m)
        })
    }

    fn segment_distance_m(&self, a: Point2<f64>, b: Point2<f64>, limit_m: f64) -> f64 {
        let segment = Segment::new(a.coords.into(), b.coords.into());
        let own = segment.local_aabb();
        let apart_m = |node: &BvhNode, _| {
            Aabb::new(node.mins() - own.maxs, node.maxs() - own.mins).distance_to_origin()
        };
        let leaf_m = |leaf: u32, _| {
            let index = leaf as usize;
            Some(if let Some(rectangle) = self.rectangles.get(index) {
                rectangle_to_segment_m(rectangle, &segment)
            } else {
                let shape = &self.shapes[index - self.rectangles.len()];
                shape.placed().distance_to_segment_m(a, b)
            })
        };
        self.tree
            .find_best(limit_m, apart_m, leaf_m)
            .map_or(limit_m, |(_, distance_m)| distance_m)
    }

    /// Distance of a point of the map frame from everything static, 0 inside. [m]
    #[must_use]
    pub fn point_distance_m(&self, point_in_map: Point2<f64>) -> f64 {
        self.convex_distance_m(&Convex::disc(point_in_map, 0.0), f64::INFINITY)
    }
}

/// Distance between a filled upright rectangle and a segment, 0 when they touch. [m] Where two
/// convex sets are apart, a corner of one is nearest to the other.
fn rectangle_to_segment_m(rectangle: &Aabb, segment: &Segment) -> f64 {
    let (a, b) = (segment.a, segment.b);
    let ends_m = [a, b].map(|end| rectangle.distance_to_local_point(end, true));
    let nearest_m = ends_m[0].min(ends_m[1]);
    // The line from a (0) to b (1) is inside from one number to the other.
    let crosses = a != b
        && rectangle
            .clip_line_parameters(a, b - a)
            .is_some_and(|(enters, leaves)| enters <= 1.0 && leaves >= 0.0);
    if nearest_m <= 0.0 || crosses {
        return 0.0;
    }
    rectangle
        .vertices()
        .into_iter()
        .map(|corner| segment.distance_to_local_point(corner, true))
        .fold(nearest_m, f64::min)
}

fn geometry_of(
    area_m: Option<[[f64; 2]; 2]>,
    resolution_m: f64,
) -> Result<GridGeometry, SpecError> {
    let Some([lower, upper]) = area_m else {
        let why = "missing: a world without a map file needs [[x, y], [x, y]], its lower left \
                   and upper right corner";
        return Err(SpecError::new("area_m", why));
    };
    let [least_m, most_m] = RESOLUTION_M;
    number(resolution_m, least_m, most_m, "resolution_m")?;
    point(lower, "area_m[0]")?;
    point(upper, "area_m[1]")?;
    let size_m = [upper[0] - lower[0], upper[1] - lower[1]];
    if size_m[0] < resolution_m || size_m[1] < resolution_m {
        let why = "the first corner must lie to the lower left of the second";
        return Err(SpecError::new("area_m", why));
    }
    let side = |length_m| cells_along(length_m, resolution_m).filter(|n| *n <= SIDE_CELLS_MAX);
    let (Some(width), Some(height)) = (side(size_m[0]), side(size_m[1])) else {
        let why = format!(
            "{} x {} m are more than {SIDE_CELLS_MAX} cells of {resolution_m} m along a side",
            size_m[0], size_m[1]
        );
        return Err(SpecError::new("area_m", why));
    };
    Ok(GridGeometry {
        origin_x_m: lower[0],
        origin_y_m: lower[1],
        resolution_m,
        width,
        height,
    })
}

fn obstacles_of(specs: &[ObstacleSpec]) -> Result<Vec<Obstacle>, SpecError> {
    if specs.len() > TRUTH_OBSTACLES_MAX {
        let why = format!("{} obstacles, at most {TRUTH_OBSTACLES_MAX}", specs.len());
        return Err(SpecError::new("obstacles", why));
    }
    let mut obstacles = Vec::with_capacity(specs.len());
    for (index, spec) in specs.iter().enumerate() {
        let place = format!("obstacles[{index}]");
        if let Some(first) = specs[..index].iter().position(|it| it.name == spec.name) {
            let why = format!(
                "\"{}\" is already the name of obstacles[{first}]",
                spec.name
            );
            return Err(SpecError::new("name", why).within(&place));
        }
        obstacles.push(obstacle_of(spec).map_err(|error| error.within(&place))?);
    }
    Ok(obstacles)
}

fn obstacle_of(spec: &ObstacleSpec) -> Result<Obstacle, SpecError> {
    if spec.name.trim().is_empty() {
        return Err(SpecError::new("name", "must not be empty"));
    }
    let shape = Shape::new(&spec.shape).map_err(|error| error.within("shape"))?;
    if let Some(trigger) = &spec.appears {
        check_trigger(trigger).map_err(|error| error.within("appears"))?;
    }
    if let Some(lasts_s) = spec.lasts_s {
        number(lasts_s, LASTS_S_MIN, TIME_S_MAX, "lasts_s")?;
    }
    if let Some(trigger) = &spec.starts {
        check_trigger(trigger).map_err(|error| error.within("starts"))?;
    }
    check_motion(spec)?;
    Ok(Obstacle {
        spec: spec.clone(),
        shape,
    })
}

/// Accepts an obstacle that is static, or moves in one way.
fn check_motion(spec: &ObstacleSpec) -> Result<(), SpecError> {
    let ways = [
        (!spec.waypoints_m.is_empty(), "waypoints_m"),
        (spec.bounces_mps.is_some(), "bounces_mps"),
        (!spec.track.is_empty(), "track"),
    ];
    let mut given = ways.iter().filter(|(given, _)| *given);
    if let (Some((_, first)), Some((_, second))) = (given.next(), given.next()) {
        let why = format!("an obstacle moves in one way, and there is {first} too");
        return Err(SpecError::new(*second, why));
    }
    let [(walks, _), (bounces, _), (tracks, _)] = ways;
    for (index, waypoint) in spec.waypoints_m.iter().enumerate() {
        point(*waypoint, &format!("waypoints_m[{index}]"))?;
    }
    number(spec.speed_mps, 0.0, SPEED_MPS_MAX, "speed_mps")?;
    number(spec.track_from_s, -TIME_S_MAX, TIME_S_MAX, "track_from_s")?;
    if walks && spec.speed_mps <= 0.0 {
        let why = "must be above 0 for an obstacle with waypoints_m";
        return Err(SpecError::new("speed_mps", why));
    }
    for (given, fits, field, needed) in [
        (spec.speed_mps > 0.0, walks, "speed_mps", "waypoints_m"),
        (
            spec.repeat,
            walks || tracks,
            "repeat",
            "waypoints_m or track",
        ),
        (
            spec.track_from_s.abs() > 0.0,
            tracks,
            "track_from_s",
            "track",
        ),
        (
            spec.starts.is_some(),
            walks || bounces || tracks,
            "starts",
            "waypoints_m, bounces_mps or track",
        ),
    ] {
        if given && !fits {
            let why = format!("means nothing without {needed}");
            return Err(SpecError::new(field, why));
        }
    }
    if let Some(velocity) = spec.bounces_mps {
        for (axis, value) in velocity.into_iter().enumerate() {
            let field = format!("bounces_mps[{axis}]");
            number(value, -SPEED_MPS_MAX, SPEED_MPS_MAX, &field)?;
        }
        if !matches!(spec.shape, ShapeSpec::Disc { .. }) {
            let why = "only a disc bounces";
            return Err(SpecError::new("bounces_mps", why));
        }
    }
    if tracks {
        Track::check(&spec.track).map_err(|error| error.within("track"))?;
        let speed_mps = Track::new(&spec.track, false, 0.0).speed_mps_max();
        number(speed_mps, 0.0, SPEED_MPS_MAX, "track")?;
    }
    Ok(())
}

fn check_trigger(trigger: &Trigger) -> Result<(), SpecError> {
    match (trigger.at_s, &trigger.robot_near) {
        (Some(at_s), None) => number(at_s, 0.0, TIME_S_MAX, "at_s"),
        (None, Some(near)) => {
            point(near.point_m, "robot_near.point_m")?;
            number(
                near.distance_m,
                NEAR_M[0],
                NEAR_M[1],
                "robot_near.distance_m",
            )
        }
        (Some(_), Some(_)) => Err(SpecError::new(
            "",
            "has both at_s and robot_near, give exactly one",
        )),
        (None, None) => Err(SpecError::new(
            "",
            "has neither at_s nor robot_near, give exactly one",
        )),
    }
}
