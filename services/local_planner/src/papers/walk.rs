//! The roll-out that all potential-field methods share (paper notes, Appendix D).

use super::law::{Body, Law, LawInput, Push};
use nalgebra::{Point2, Vector2};
use zeronav_msgs::path::Waypoint;

/// Steps over which a displacement is looked at for [`End::Stuck`], and the least that it must be, in
/// steps.
const STUCK_STEPS: usize = 40;
const STUCK_MOVED: f64 = 0.5 * 20.0;

/// How a roll-out is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Walk {
    /// Length of a step. [m or cells]
    pub step: f64,
    /// Distance from the goal that counts as there.
    pub tolerance: f64,
    /// Most steps.
    pub limit: usize,
    /// Obstacles are points and may be walked through, as printed.
    pub literal: bool,
}

impl Walk {
    /// [JU]: 0.1 m, 0.2 m, 2000 steps.
    pub const JU: Self = Self {
        step: 0.1,
        tolerance: 0.2,
        limit: 2000,
        literal: false,
    };

    /// [LWX], in cells: 0.2, 0.5, 4000 steps.
    pub const LWX: Self = Self {
        step: 0.2,
        tolerance: 0.5,
        limit: 4000,
        ..Self::JU
    };

    /// The same in metres.
    pub const LWX_M: Self = Self {
        step: 0.1,
        tolerance: 0.2,
        limit: 2000,
        ..Self::JU
    };
}

/// How a roll-out ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// At the goal.
    Reached,
    /// No way on: forces cancel, or the walk turns round and round on one spot.
    Stuck,
    /// Out of steps.
    Limit,
    /// The next step hits an obstacle, however short.
    Collision,
}

/// A roll-out.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Positions from the start on.
    pub points: Vec<Point2<f64>>,
    /// How it ended.
    pub end: End,
    /// Steps done, each of which asked the law once.
    pub steps: usize,
}

impl Trace {
    /// Length of the polyline.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.points
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).norm())
            .sum()
    }
}

/// Walks from `start` to `goal` by `law`. Unless literal, a step that would enter an area is
/// halved up to four times.
pub fn walk(
    law: &mut dyn Law,
    start: Point2<f64>,
    goal: Point2<f64>,
    bodies: &[Body],
    path: &[Waypoint],
    how: &Walk,
) -> Trace {
    let mut points = vec![start];
    let mut at = start;
    let mut velocity = Vector2::zeros();
    let done = |points: Vec<Point2<f64>>, end, steps| Trace { points, end, steps };
    for steps in 0..how.limit {
        if (at - goal).norm() < how.tolerance {
            return done(points, End::Reached, steps);
        }
        let input = LawInput {
            at,
            velocity,
            goal,
            bodies,
            path,
            geometry: 1,
            literal: how.literal,
            steps: 1.0,
            ground: None,
        };
        let Push::Along(force) = law.push(&input) else {
            return done(points, End::Stuck, steps);
        };
        let next = force
            .try_normalize(1.0e-9)
            .ok_or(End::Stuck)
            .and_then(|direction| Ok((direction, stride(&input, goal, direction, how)?)));
        match next {
            Err(end) => return done(points, end, steps),
            Ok((direction, length)) => {
                at += direction * length;
                velocity = direction;
                points.push(at);
            }
        }
        if !law.escapes_minima() && points.len() > STUCK_STEPS {
            let before = points[points.len() - 1 - STUCK_STEPS];
            if (at - before).norm() < STUCK_MOVED * how.step {
                return done(points, End::Stuck, steps + 1);
            }
        }
    }
    done(points, End::Limit, how.limit)
}

/// Length of the next step: at most to the goal, halved until it is free.
pub(super) fn stride(
    input: &LawInput<'_>,
    goal: Point2<f64>,
    direction: Vector2<f64>,
    how: &Walk,
) -> Result<f64, End> {
    let at = input.at;
    let mut length = how.step.min((at - goal).norm());
    let mut halvings = 0;
    while !how.literal && !input.is_free(at, at + direction * length) {
        if halvings == 4 {
            return Err(End::Collision);
        }
        halvings += 1;
        length *= 0.5;
    }
    Ok(length)
}
