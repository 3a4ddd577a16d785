//! A walled square with round posts, and distances in it by formula.

use nalgebra::{Point2, Vector2};
use zeronav_msgs::Pose;
use zeronav_msgs::description::Corner;

/// Half the side of the walled square. [m]
pub(crate) const HALF_M: f64 = 3.0;

/// Distance of a point from the outline: of a disc, or of a rectangle of these half extents. [m]
#[derive(Clone, Copy)]
pub(crate) enum Shape {
    Disc(f64),
    Rectangle(f64, f64),
}

impl Shape {
    pub(crate) fn corners(self) -> Vec<Corner> {
        match self {
            Self::Disc(_) => Vec::new(),
            Self::Rectangle(x, y) => [(x, y), (-x, y), (-x, -y), (x, -y)]
                .map(|(x_m, y_m)| Corner { x_m, y_m })
                .to_vec(),
        }
    }

    /// Distance between the outline at `pose` and a post. [m]
    pub(crate) fn to_post_m(self, pose: &Pose, post: &Post) -> f64 {
        let offset = pose.isometry().inverse() * post.at;
        let centre_m = match self {
            Self::Disc(radius_m) => offset.coords.norm() - radius_m,
            Self::Rectangle(x, y) => {
                let (dx, dy) = (offset.x.abs() - x, offset.y.abs() - y);
                let outside = dx.max(0.0).hypot(dy.max(0.0));
                outside + dx.max(dy).min(0.0)
            }
        };
        centre_m - post.radius_m
    }

    /// Distance between the outline at `pose` and the four walls. [m]
    pub(crate) fn to_walls_m(self, pose: &Pose) -> f64 {
        let least = |point: Point2<f64>| HALF_M - point.x.abs().max(point.y.abs());
        match self {
            Self::Disc(radius_m) => least(pose.point()) - radius_m,
            Self::Rectangle(..) => self
                .corners()
                .iter()
                .map(|corner| least(pose.transform(Point2::new(corner.x_m, corner.y_m))))
                .fold(f64::INFINITY, f64::min),
        }
    }

    /// Signed distance between the outline at `pose` and a point. [m]
    pub(crate) fn to_point_m(self, pose: &Pose, at: Point2<f64>) -> f64 {
        self.to_post_m(pose, &Post { at, radius_m: 0.0 })
    }
}

/// A round obstacle.
#[derive(Clone, Copy)]
pub(crate) struct Post {
    pub(crate) at: Point2<f64>,
    pub(crate) radius_m: f64,
}

pub(crate) struct World {
    pub(crate) posts: Vec<Post>,
}

impl World {
    pub(crate) fn distance_m(&self, shape: Shape, pose: &Pose) -> f64 {
        self.posts
            .iter()
            .map(|post| shape.to_post_m(pose, post))
            .fold(shape.to_walls_m(pose), f64::min)
    }

    /// The point of a surface that is nearest to the outline at `pose`, to half a centimetre.
    pub(crate) fn nearest(&self, shape: Shape, pose: &Pose) -> Point2<f64> {
        let steps = |n: u32| (0..n).map(move |i| f64::from(i) / f64::from(n));
        let walls = steps(1200).flat_map(|share| {
            let along = HALF_M * (2.0 * share - 1.0);
            [
                (along, HALF_M),
                (along, -HALF_M),
                (HALF_M, along),
                (-HALF_M, along),
            ]
        });
        let posts = self.posts.iter().flat_map(|post| {
            steps(500).map(|share| {
                let (sin, cos) = (std::f64::consts::TAU * share).sin_cos();
                (
                    post.at.x + post.radius_m * cos,
                    post.at.y + post.radius_m * sin,
                )
            })
        });
        let points = walls.chain(posts).map(|(x, y)| Point2::new(x, y));
        let far_m = |point: &Point2<f64>| shape.to_point_m(pose, *point);
        points
            .min_by(|a, b| far_m(a).total_cmp(&far_m(b)))
            .expect("walls")
    }

    pub(crate) fn range_m(&self, from: Point2<f64>, direction: Vector2<f64>) -> f64 {
        let wall = |at: f64, step: f64| {
            if step.abs() < 1e-12 {
                f64::INFINITY
            } else {
                (HALF_M * step.signum() - at) / step
            }
        };
        let walls = wall(from.x, direction.x).min(wall(from.y, direction.y));
        self.posts.iter().fold(walls, |least, post| {
            let offset = post.at - from;
            let along = offset.dot(&direction);
            let squared = post.radius_m.powi(2) - (offset.norm_squared() - along * along);
            let hit = along - squared.max(0.0).sqrt();
            if squared >= 0.0 && hit >= 0.0 {
                least.min(hit)
            } else {
                least
            }
        })
    }
}
