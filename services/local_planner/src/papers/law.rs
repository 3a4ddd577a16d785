//! What a potential-field law knows, and what it answers.

use core::fmt;
use nalgebra::{Point2, Vector2};
use zeronav_msgs::command::RequestCause;
use zeronav_msgs::path::Waypoint;

/// The shape of an obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Extent {
    /// All points within a radius. [m]
    Disc(f64),
    /// An upright square of this half side, as a cell of a grid. [m]
    Square(f64),
}

/// An obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Its centre. [m]
    pub at: Point2<f64>,
    /// Its shape.
    pub extent: Extent,
    /// [m/s]
    pub velocity: Vector2<f64>,
}

impl Body {
    /// A static body.
    #[must_use]
    pub fn standing(at: Point2<f64>, extent: Extent) -> Self {
        Self {
            at,
            extent,
            velocity: Vector2::zeros(),
        }
    }

    /// The point that repels: the nearest one of the area, or the centre when `literal`, as the
    /// papers print it.
    #[must_use]
    pub fn nearest(&self, from: Point2<f64>, literal: bool) -> Point2<f64> {
        if literal {
            return self.at;
        }
        let offset = from - self.at;
        match self.extent {
            Extent::Disc(radius_m) => {
                let distance_m = offset.norm();
                if distance_m <= radius_m {
                    from
                } else {
                    self.at + offset * (radius_m / distance_m)
                }
            }
            Extent::Square(half_m) => {
                let inside = Vector2::new(
                    offset.x.clamp(-half_m, half_m),
                    offset.y.clamp(-half_m, half_m),
                );
                self.at + inside
            }
        }
    }

    /// True when a segment touches the area, exactly.
    #[must_use]
    pub fn touches(&self, from: Point2<f64>, to: Point2<f64>) -> bool {
        let along = to - from;
        match self.extent {
            Extent::Disc(radius_m) => {
                let share = (self.at - from).dot(&along) / along.norm_squared().max(1.0e-18);
                (from + along * share.clamp(0.0, 1.0) - self.at).norm() <= radius_m
            }
            Extent::Square(half_m) => {
                // Where the segment enters and leaves each of two strips (Liang, Barsky 1984).
                let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
                for axis in 0..2 {
                    let (start, way) = (from[axis] - self.at[axis], along[axis]);
                    if way == 0.0 {
                        if start.abs() > half_m {
                            return false;
                        }
                        continue;
                    }
                    let (one, other) = ((-half_m - start) / way, (half_m - start) / way);
                    enters = enters.max(one.min(other));
                    leaves = leaves.min(one.max(other));
                }
                enters <= leaves
            }
        }
    }

    /// Distance of a point from the area, 0 inside. [m]
    #[must_use]
    pub fn distance_m(&self, from: Point2<f64>) -> f64 {
        (self.nearest(from, false) - from).norm()
    }
}

/// A situation in the plane. Lengths in metres, or in cells where a law's gains are meant so.
#[derive(Debug, Clone, Copy)]
pub struct LawInput<'a> {
    /// The robot's centre.
    pub at: Point2<f64>,
    /// The robot's velocity. [m/s]
    pub velocity: Vector2<f64>,
    /// Where the path leads.
    pub goal: Point2<f64>,
    /// What is around. A robot's radius is already part of the areas.
    pub bodies: &'a [Body],
    /// The path of a global planner; may be empty.
    pub path: &'a [Waypoint],
    /// Id of the path; another id is another path.
    pub geometry: u64,
    /// Obstacles are points, as printed; default on the robot: areas.
    pub literal: bool,
    /// Steps of the method that this question stands for: one in a roll-out; on the robot what it
    /// covers in a control period at full speed.
    pub steps: f64,
    /// Where the robot's centre may be, by the map and by every point of the scan; `None` off the
    /// robot, where the bodies are all there is.
    pub ground: Option<&'a dyn Ground>,
}

impl LawInput<'_> {
    /// True when the robot's centre can go straight from one point to the other.
    #[must_use]
    pub fn is_free(&self, from: Point2<f64>, to: Point2<f64>) -> bool {
        self.ground.map_or_else(
            || is_free(self.bodies, from, to),
            |ground| ground.is_free(from, to),
        )
    }
}

/// What is known of the robot's surroundings beyond the bodies.
pub trait Ground: fmt::Debug {
    /// True when the robot's centre can go straight from one point of the map frame to the other.
    /// [m]
    fn is_free(&self, from: Point2<f64>, to: Point2<f64>) -> bool;

    /// Appends what repels at `at`, wherever that is on the map: of every obstacle within `reach` the
    /// nearest part, widened by the robot's inscribed radius. `false` where there is no map, and nothing is
    /// known beyond the scan's bodies. [m]
    fn bodies(&self, at: Point2<f64>, reach: f64, bodies: &mut Vec<Body>) -> bool;
}

/// What a law says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Push {
    /// Go this way; only the direction counts.
    Along(Vector2<f64>),
    /// Forces cancel and nothing is left to try.
    Stuck,
}

/// A potential-field method. Deterministic; remembers what it needs from step to step.
pub trait Law: fmt::Debug {
    /// The force at the position of `input`.
    fn push(&mut self, input: &LawInput<'_>) -> Push;

    /// True when the law sees by itself that it is caught in a local minimum and says
    /// [`Push::Stuck`] once it has tried to escape; a roll-out leaves that to it.
    fn escapes_minima(&self) -> bool {
        false
    }

    /// Something of the method that the law does without just now, to explain the drive; `None` when it
    /// is whole. Nothing is decided by it.
    fn remark(&self) -> Option<RequestCause> {
        None
    }
}

/// True when a segment touches no area.
#[must_use]
pub fn is_free(bodies: &[Body], from: Point2<f64>, to: Point2<f64>) -> bool {
    !bodies.iter().any(|body| body.touches(from, to))
}
