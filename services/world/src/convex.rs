//! Discs and convex polygons somewhere in the plane, and the distances between them.
//!
//! Everything solid in a world is one of parry's shapes at a pose, and parry answers, in f64 and in
//! the frame of one of the two, so that answers do not depend on where on the map they stand.
//! Pairs of discs and boxes and all distances to points are closed formulas. Pairs with a polygon
//! go through GJK, which stops within 1e-7 of the distance; both were checked against brute force
//! over sizes of 1 mm to 1 km (below).

use crate::parry_pose::parry_pose;
use nalgebra::{Point2, Vector2};
use parry2d::bounding_volume::Aabb;
use parry2d::math::{Pose2, Vec2};
use parry2d::query::{DefaultQueryDispatcher, PointQuery, QueryDispatcher};
use parry2d::shape::{Ball, Cuboid, Segment, Shape, SharedShape};
use parry2d::utils::point_in_convex_poly2d;
use zeronav_msgs::Pose;

/// Corners with which a disc is drawn.
const DISC_CORNERS: u32 = 48;

/// Beyond this nothing is told apart: worlds end at 1e6 m, and GJK must not be asked about numbers
/// that are not finite. [m]
const FAR_M: f64 = 1.0e9;

/// A closed convex set of points: a ball, cuboid or convex polygon of parry, and where its frame
/// is placed in the current frame. Cheap to copy and to move: the form is shared.
#[derive(Clone)]
pub struct Convex {
    pose: Pose2,
    form: SharedShape,
}

impl Convex {
    /// All points within `radius_m` >= 0 of `centre`.
    #[must_use]
    pub fn disc(centre: Point2<f64>, radius_m: f64) -> Self {
        Self {
            pose: Pose2::from_translation(vec2(centre)),
            form: SharedShape::ball(radius_m),
        }
    }

    /// A rectangle of these side lengths around the origin. [m]
    pub(crate) fn rectangle(size_m: [f64; 2]) -> Self {
        Self {
            pose: Pose2::IDENTITY,
            form: SharedShape::cuboid(size_m[0] / 2.0, size_m[1] / 2.0),
        }
    }

    /// The hull of corners that are in convex position, counter-clockwise and none needless, as
    /// [`crate::polygon::convex_corners`] gives them; `None` when two are on one spot.
    pub(crate) fn polygon(corners: &[Point2<f64>]) -> Option<Self> {
        // Unmodified: parry's own clean-up drops corners of round polygons (turns below 1.5
        // degrees).
        let corners = corners.iter().copied().map(vec2).collect();
        Some(Self {
            pose: Pose2::IDENTITY,
            form: SharedShape::convex_polyline_unmodified(corners)?,
        })
    }

    /// The same set seen from the frame in which `pose` is its present frame. No allocation.
    #[must_use]
    pub fn placed(&self, pose: &Pose) -> Self {
        Self {
            pose: parry_pose(pose) * self.pose,
            form: self.form.clone(),
        }
    }

    /// Where the frame of [`Self::form`] is.
    #[must_use]
    pub const fn pose(&self) -> &Pose2 {
        &self.pose
    }

    /// Ball, cuboid or convex polygon, in its own frame.
    #[must_use]
    pub fn form(&self) -> &dyn Shape {
        &*self.form
    }

    /// True for a disc, which turns in itself.
    #[must_use]
    pub fn is_disc(&self) -> bool {
        self.form.as_ball().is_some()
    }

    /// Its corners, counter-clockwise; none for a disc.
    pub fn corners(&self) -> impl Iterator<Item = Point2<f64>> + '_ {
        let cuboid = self.form.as_cuboid().map(|cuboid| {
            let half = cuboid.half_extents;
            Aabb::new(-half, half).vertices()
        });
        let polygon = self.form.as_convex_polygon();
        let own = cuboid.into_iter().flatten().chain(
            polygon
                .into_iter()
                .flat_map(|it| it.points().iter().copied()),
        );
        own.map(|at| point2(self.pose * at))
    }

    /// The smallest upright rectangle that holds it.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.form.compute_aabb(&self.pose)
    }

    /// Distance between the two sets, 0 when they touch or overlap. [m]
    #[must_use]
    pub fn distance_m(&self, other: &Self) -> f64 {
        match (self.form.as_ball(), other.form.as_ball()) {
            (Some(ball), _) => {
                let centre = point2(self.pose.translation);
                (other.distance_to_point_m(centre) - ball.radius).max(0.0)
            }
            (None, Some(ball)) => {
                let centre = point2(other.pose.translation);
                (self.distance_to_point_m(centre) - ball.radius).max(0.0)
            }
            (None, None) => self.shape_distance_m(&other.pose, &*other.form),
        }
    }

    /// Distance to a filled upright rectangle, 0 when they touch or overlap. [m]
    #[must_use]
    pub fn distance_to_bounds_m(&self, bounds: &Aabb) -> f64 {
        if let Some(ball) = self.form.as_ball() {
            let to_edge_m = bounds.distance_to_local_point(self.pose.translation, true);
            return (to_edge_m - ball.radius).max(0.0);
        }
        let middle = Pose2::from_translation(bounds.center());
        self.shape_distance_m(&middle, &Cuboid::new(bounds.half_extents()))
    }

    /// Distance to a point, 0 inside. [m]
    #[must_use]
    pub fn distance_to_point_m(&self, point: Point2<f64>) -> f64 {
        let own = self.pose.inverse_transform_point(vec2(point));
        let Some(polygon) = self.form.as_convex_polygon() else {
            return self.form.distance_to_local_point(own, true).max(0.0);
        };
        // Not the polygon's own projection: it is GJK, and panics where that does not converge.
        let corners = polygon.points();
        if point_in_convex_poly2d(own, corners) {
            return 0.0;
        }
        let next = corners.iter().cycle().skip(1);
        corners
            .iter()
            .zip(next)
            .map(|(a, b)| Segment::new(*a, *b).distance_to_local_point(own, true))
            .fold(f64::INFINITY, f64::min)
    }

    /// Distance to the straight line from `a` to `b`, 0 when they touch. [m]
    #[must_use]
    pub fn distance_to_segment_m(&self, a: Point2<f64>, b: Point2<f64>) -> f64 {
        let [a, b] = [a, b].map(|end| vec2(end).clamp(Vec2::splat(-FAR_M), Vec2::splat(FAR_M)));
        let middle = (a + b) / 2.0;
        let half = b - middle;
        if half == Vec2::ZERO {
            return self.distance_to_point_m(point2(a));
        }
        let pose = Pose2::from_translation(middle);
        self.shape_distance_m(&pose, &Segment::new(-half, half))
    }

    /// Distance to a chain of straight lines, 0 when they touch; a single point counts as one,
    /// infinite for none. [m]
    #[must_use]
    pub fn distance_to_polyline_m(&self, points: &[Point2<f64>]) -> f64 {
        match points {
            [] => f64::INFINITY,
            [only] => self.distance_to_point_m(*only),
            _ => points
                .windows(2)
                .map(|ends| self.distance_to_segment_m(ends[0], ends[1]))
                .fold(f64::INFINITY, f64::min),
        }
    }

    /// Its edge as a closed chain of points for drawing, the first not repeated. A disc becomes a
    /// polygon of 48 corners on its circle.
    #[must_use]
    pub fn outline(&self) -> Vec<Point2<f64>> {
        match self.form.as_ball() {
            Some(Ball { radius }) => (0..DISC_CORNERS)
                .map(|corner| {
                    let angle_rad =
                        core::f64::consts::TAU * f64::from(corner) / f64::from(DISC_CORNERS);
                    let along = Vector2::new(angle_rad.cos(), angle_rad.sin());
                    point2(self.pose.translation) + along * *radius
                })
                .collect(),
            None => self.corners().collect(),
        }
    }

    /// Smallest and largest x of the part with `y_min <= y <= y_max`; `None` without such a part.
    #[must_use]
    pub fn extent_in_strip(&self, y_min: f64, y_max: f64) -> Option<(f64, f64)> {
        if let Some(ball) = self.form.as_ball() {
            let centre = self.pose.translation;
            let dy = centre.y.clamp(y_min, y_max) - centre.y;
            let square = ball.radius * ball.radius - dy * dy;
            return (square >= 0.0).then(|| (centre.x - square.sqrt(), centre.x + square.sqrt()));
        }
        let mut extent: Option<(f64, f64)> = None;
        let mut take = |x: f64| {
            let (low, high) = extent.unwrap_or((x, x));
            extent = Some((low.min(x), high.max(x)));
        };
        let next = self.corners().skip(1).chain(self.corners().take(1));
        for (a, b) in self.corners().zip(next) {
            if (y_min..=y_max).contains(&a.y) {
                take(a.x);
            }
            for y in [y_min, y_max] {
                if (a.y < y) != (b.y < y) {
                    take(a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y));
                }
            }
        }
        extent
    }

    /// Distance to another form of parry at `pose`. [m]
    fn shape_distance_m(&self, pose: &Pose2, form: &dyn Shape) -> f64 {
        let own_from_form = self.pose.inv_mul(pose);
        let apart_m = own_from_form.translation.length();
        if apart_m < FAR_M {
            // All that a world is made of is supported.
            DefaultQueryDispatcher
                .distance(&own_from_form, &*self.form, form)
                .map_or(f64::INFINITY, |found| found.distance)
        } else {
            // Infinite or far; what is nowhere (NaN) touches.
            apart_m.max(0.0)
        }
    }
}

impl core::fmt::Debug for Convex {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let form = self.form.as_typed_shape();
        formatter
            .debug_struct("Convex")
            .field("pose", &self.pose)
            .field("form", &form)
            .finish()
    }
}

fn vec2(at: Point2<f64>) -> Vec2 {
    at.coords.into()
}

fn point2(at: Vec2) -> Point2<f64> {
    Point2::new(at.x, at.y)
}

#[cfg(test)]
mod tests;
