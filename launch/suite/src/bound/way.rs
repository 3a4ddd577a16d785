//! What is asked for, and a way as an answer: a drive in small steps, looked at in each of them.

use super::super::future::Mover;
use super::super::oracle::robot::{Abilities, State};
use super::velocity_pairs::{MOMENTS, STEPS, VelocityPairs, step, step_s};
use nalgebra::Point2;
use zeronav_msgs::Pose;
use zeronav_world::World;

/// Distance that counts as a contact. [m] A little more than the simulator's skin.
const CONTACT_M: f64 = 1.0e-3;

/// From where to where, among what, and within what time.
pub(super) struct Task<'a> {
    /// What stands.
    pub(super) world: &'a World,
    /// What moves.
    pub(super) movers: &'a [Mover],
    /// The robot.
    pub(super) abilities: &'a Abilities,
    /// `map_from_base` at the start, where it stands.
    pub(super) start: Pose,
    /// The goal. [m]
    pub(super) goal_m: [f64; 2],
    /// How near its centre must come. [m]
    pub(super) tolerance_m: f64,
    /// Run time that it has. [s]
    pub(super) time_limit_s: f64,
}

/// A drive from the start to the goal that touches nothing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Route {
    /// Every step of 5 ms, from the start on.
    pub(super) states: Vec<State>,
    /// Least distance of the outline from anything; infinite in an empty world. [m]
    pub(super) clearance_m: f64,
}

impl Task<'_> {
    /// The robot at the start.
    pub(super) const fn first(&self) -> State {
        State {
            t_s: 0.0,
            at_m: [self.start.x_m, self.start.y_m],
            yaw_rad: self.start.yaw_rad,
            v_mps: 0.0,
            w_radps: 0.0,
        }
    }

    /// True when a place is near enough to the goal.
    pub(super) fn is_there(&self, at_m: [f64; 2]) -> bool {
        self.to_goal_m(at_m) <= self.tolerance_m
    }

    /// Distance of a place from the goal. [m]
    pub(super) fn to_goal_m(&self, at_m: [f64; 2]) -> f64 {
        (at_m[0] - self.goal_m[0]).hypot(at_m[1] - self.goal_m[1])
    }

    /// Distance of the outline from anything. [m]
    pub(super) fn clearance_m(&self, state: &State) -> f64 {
        let pose = Pose::new(state.at_m[0], state.at_m[1], state.yaw_rad);
        let outline = self.abilities.outline.placed(&pose);
        let discs = self.movers.iter().filter_map(|mover| mover.at(state.t_s));
        let apart_m = discs.map(|([x, y], radius_m)| {
            let centre_m = outline.distance_to_point_m(Point2::new(x, y));
            (centre_m - radius_m).max(0.0)
        });
        let nearest_m = apart_m.fold(f64::INFINITY, f64::min);
        self.world.convex_distance_m(&outline, nearest_m)
    }
}

impl Route {
    /// Drives from pair to pair until the robot is at the goal; `None` when it touches something
    /// before, or does not get there.
    pub(super) fn drive(
        task: &Task<'_>,
        pairs: &VelocityPairs,
        sequence: &[usize],
    ) -> Option<Self> {
        let mut now = task.first();
        let mut states = vec![now];
        let mut clearance_m = task.clearance_m(&now);
        for pair in sequence {
            for _ in 0..MOMENTS * STEPS {
                if task.is_there(now.at_m) || clearance_m <= CONTACT_M {
                    break;
                }
                now = step(&now, pairs.pair(*pair), task.abilities);
                // Not a sum of steps: rounding shall not shift what moves.
                now.t_s = step_s(states.len());
                clearance_m = clearance_m.min(task.clearance_m(&now));
                states.push(now);
            }
        }
        let is_found =
            task.is_there(now.at_m) && clearance_m > CONTACT_M && now.t_s <= task.time_limit_s;
        is_found.then_some(Self {
            states,
            clearance_m,
        })
    }

    /// Run time of the arrival. [s]
    pub(super) fn time_s(&self) -> f64 {
        self.states.last().map_or(0.0, |last| last.t_s)
    }

    /// Length of the drive. [m]
    pub(super) fn length_m(&self) -> f64 {
        let part_m = |ends: &[State]| {
            let ([ax, ay], [bx, by]) = (ends[0].at_m, ends[1].at_m);
            (bx - ax).hypot(by - ay)
        };
        self.states.windows(2).map(part_m).sum()
    }
}
