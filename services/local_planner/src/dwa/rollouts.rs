//! The motions of one dynamic window, all at once.
//!
//! A rollout speeds up or slows down to its target twist within the robot's accelerations and
//! holds it. Its speed depends only on the target speed and its heading only on the target yaw
//! rate, so the trigonometry is done once per yaw rate and step, and a rollout is a walk of
//! multiply-adds. Each step is the chord of the exact arc of the step's mean twist.

#![allow(
    clippy::cast_precision_loss,
    reason = "at most 64 speeds, 256 yaw rates and 100 steps"
)]

use crate::dwa::window::{Window, ramp_mean, snap, spread};
use crate::lanes::data::narrow;
use crate::local_path::LocalPath;
use crate::surroundings::{LocalPose, Surroundings};
use zeronav_motion::{Twist, reachable, sinc, stop_angle_rad, stop_distance_m};

/// [m/s] below which a motion is a turn on the spot.
pub(crate) const TURNING_MPS: f64 = 0.02;

/// Places of a rollout that are compared with the path, as shares of its scored length.
const MARKS: usize = 2;

/// The sampled window; buffers are reused.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rollouts {
    steps: usize,
    /// Target speeds. [m/s]
    pub(crate) speeds: Vec<f64>,
    /// Target yaw rates. [rad/s]
    pub(crate) yaw_rates: Vec<f64>,
    /// Driven in each step, speeds x steps. [m]
    driven: Vec<f32>,
    /// Driven up to the end of each step, speeds x steps. [m]
    arcs: Vec<f32>,
    /// Chord direction times chord per metre driven, yaw rates x steps.
    chords: Vec<(f32, f32)>,
    /// Cosine and sine of the heading at the end of each step, yaw rates x steps.
    headings: Vec<(f32, f32)>,
    /// Turned up to the end of each step, yaw rates x steps. [rad]
    turned: Vec<f32>,
}

/// An admissible rollout in the terms of the evaluation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outcome {
    /// [m] along the path.
    pub(crate) progress_m: f64,
    /// [m] beside the path, mean of a penalty that is quadratic up to 30 cm and linear beyond.
    pub(crate) beside_m: f64,
    /// 1 - cos of the angle between the end's heading and the path.
    pub(crate) heading: f64,
    /// [m] least space around the outline, at most the soft clearance.
    pub(crate) margin_m: f64,
}

impl Rollouts {
    /// Samples `n_speeds x n_yaw_rates` targets evenly; the yaw rates nearest to zero and to the
    /// preferred one are moved onto them, so straight on and straight at the goal are there.
    pub(crate) fn prepare(&mut self, window: &Window<'_>, n_speeds: usize, n_yaw_rates: usize) {
        spread(&mut self.speeds, window.speeds, n_speeds);
        spread(&mut self.yaw_rates, window.yaw_rates, n_yaw_rates);
        snap(&mut self.yaw_rates, 0.0);
        snap(&mut self.yaw_rates, window.preferred_radps);
        let (n, dt) = (window.steps(), window.step_s);
        self.steps = n;
        let (robot, from) = (window.robot, window.from);
        self.driven.clear();
        self.arcs.clear();
        for &target in &self.speeds {
            let (mut v, mut arc_m) = (from.v_mps, 0.0);
            for _ in 0..n {
                let next = reachable(robot, Twist::new(v, 0.0), Twist::new(target, 0.0), dt).v_mps;
                let rate = if next.abs() > v.abs() {
                    robot.a_mps2_max
                } else {
                    robot.brake_mps2
                };
                let step_m = ramp_mean(v, next, rate, dt) * dt;
                arc_m += step_m.abs();
                self.driven.push(narrow(step_m));
                self.arcs.push(narrow(arc_m));
                v = next;
            }
        }
        self.chords.clear();
        self.headings.clear();
        self.turned.clear();
        for &target in &self.yaw_rates {
            let (mut w, mut turned) = (from.w_radps, 0.0);
            let (mut sin, mut cos) = window.yaw_rad.sin_cos();
            for _ in 0..n {
                let next =
                    reachable(robot, Twist::new(0.0, w), Twist::new(0.0, target), dt).w_radps;
                let angle = ramp_mean(w, next, robot.alpha_radps2_max, dt) * dt;
                // The chord points along half the step's turn.
                let (half_sin, half_cos) = (0.5 * angle).sin_cos();
                (sin, cos) = (
                    sin * half_cos + cos * half_sin,
                    cos * half_cos - sin * half_sin,
                );
                let chord = sinc(0.5 * angle);
                self.chords.push((narrow(chord * cos), narrow(chord * sin)));
                (sin, cos) = (
                    sin * half_cos + cos * half_sin,
                    cos * half_cos - sin * half_sin,
                );
                self.headings.push((narrow(cos), narrow(sin)));
                turned += angle;
                self.turned.push(narrow(turned));
                w = next;
            }
        }
    }

    /// How many rollouts there are.
    pub(crate) fn len(&self) -> usize {
        self.speeds.len() * self.yaw_rates.len()
    }

    /// Follows the rollout of one target; `None` when the robot could not stop on it before
    /// contact: `v^2 / 2a + v t_reaction + margin <= free arc`, on the spot the same with angles.
    ///
    /// What lies beyond the end of the path is neither driven nor scored.
    pub(crate) fn outcome(
        &self,
        window: &Window<'_>,
        surroundings: &Surroundings,
        path: &LocalPath,
        speed: usize,
        yaw_rate: usize,
    ) -> Option<Outcome> {
        let n = self.steps;
        let driven = &self.driven[speed * n..(speed + 1) * n];
        let arcs = &self.arcs[speed * n..(speed + 1) * n];
        let chords = &self.chords[yaw_rate * n..(yaw_rate + 1) * n];
        let headings = &self.headings[yaw_rate * n..(yaw_rate + 1) * n];
        // The last step worth scoring, and the steps that are compared with the path.
        let scored = arcs
            .partition_point(|arc| *arc < narrow(path.ahead_m))
            .clamp(0, n - 1);
        let marks = core::array::from_fn::<usize, MARKS, _>(|i| (scored * (i + 1)) / MARKS);
        let mut at = LocalPose {
            x: 0.0,
            y: 0.0,
            cos: 1.0,
            sin: 0.0,
        };
        let soft = narrow(window.soft_m);
        let mut margin = soft;
        let (mut beside, mut mark, mut end) = (0.0, 0, None);
        let mut free = n;
        for step in 0..n {
            at.x += driven[step] * chords[step].0;
            at.y += driven[step] * chords[step].1;
            (at.cos, at.sin) = headings[step];
            match surroundings.space(at, soft) {
                Some(space) if step <= scored => margin = margin.min(space),
                Some(_) => {}
                None => {
                    free = step;
                    break;
                }
            }
            while mark < MARKS && marks[mark] == step {
                let place = path.project(at.x, at.y);
                beside += cost_beside(place.beside);
                mark += 1;
                if mark == MARKS {
                    end = Some((place, headings[step]));
                }
            }
        }
        if !self.can_stop(window, surroundings, (speed, yaw_rate), free, at) {
            return None;
        }
        // Cut short by an obstacle beyond the braking distance: scored as far as it goes.
        let (place, heading) = end.unwrap_or_else(|| {
            let heading = headings[free.saturating_sub(1).min(n - 1)];
            (path.project(at.x, at.y), heading)
        });
        let unmarked = (MARKS - mark) as f32 * cost_beside(place.beside);
        let direction = place.direction;
        let cos = heading.0 * direction.0 + heading.1 * direction.1;
        let pathless = direction == (0.0, 0.0);
        Some(Outcome {
            progress_m: f64::from(place.along),
            beside_m: f64::from((beside + unmarked) / MARKS as f32),
            heading: if pathless { 0.0 } else { 1.0 - f64::from(cos) },
            margin_m: f64::from(margin),
        })
    }

    /// True when the robot can stop before contact on a rollout that is free for `free` steps.
    fn can_stop(
        &self,
        window: &Window<'_>,
        surroundings: &Surroundings,
        (speed, yaw_rate): (usize, usize),
        free: usize,
        end: LocalPose,
    ) -> bool {
        let (v, w) = (self.speeds[speed], self.yaw_rates[yaw_rate]);
        let n = self.steps;
        if v.abs() < TURNING_MPS {
            let turned = &self.turned[yaw_rate * n..(yaw_rate + 1) * n];
            let free_rad = match free.checked_sub(1) {
                Some(last) => f64::from(turned[last]).abs(),
                None => 0.0,
            };
            return free == n || stop_angle_rad(window.robot, w, window.reaction_s) <= free_rad;
        }
        let needed_m = stop_distance_m(window.robot, v, window.reaction_s) + window.stop_margin_m;
        let free_m = match free.checked_sub(1) {
            Some(last) => f64::from(self.arcs[speed * n + last]),
            None => 0.0,
        };
        if free < n {
            return needed_m <= free_m;
        }
        // A slow rollout ends before the place where its stop would: look there as well.
        needed_m <= free_m || tail_is_free(surroundings, end, w / v, needed_m - free_m)
    }
}

/// Walks `arc_m` on along a constant curvature.
fn tail_is_free(surroundings: &Surroundings, from: LocalPose, curvature: f64, arc_m: f64) -> bool {
    const STEP_M: f64 = 0.05;
    let mut at = from;
    let angle = curvature * STEP_M;
    if angle.abs() > 0.6 {
        // So tight that the robot turns on the spot.
        return true;
    }
    let (sin, cos) = angle.sin_cos();
    let (sin, cos) = (narrow(sin), narrow(cos));
    let step = narrow(STEP_M * sinc(0.5 * angle));
    let (half_sin, half_cos) = (0.5 * angle).sin_cos();
    let (half_sin, half_cos) = (narrow(half_sin), narrow(half_cos));
    let mut left_m = arc_m;
    while left_m > 0.0 {
        at.x += step * (at.cos * half_cos - at.sin * half_sin);
        at.y += step * (at.sin * half_cos + at.cos * half_sin);
        (at.cos, at.sin) = (at.cos * cos - at.sin * sin, at.sin * cos + at.cos * sin);
        if surroundings.space(at, 0.0).is_none() {
            return false;
        }
        left_m -= STEP_M;
    }
    true
}

/// Quadratic up to 30 cm, so that millimetres beside the path do not make the robot weave.
#[inline]
pub(crate) fn cost_beside(beside: f32) -> f32 {
    const BEND: f32 = 0.3;
    if beside < BEND {
        beside * beside / (2.0 * BEND)
    } else {
        (beside - 0.5 * BEND).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dwa::window::Range;
    use zeronav_msgs::description::Description;

    #[test]
    fn a_rollout_ends_where_its_ramp_and_arc_lead() {
        let robot = Description {
            v_mps_max: 1.0,
            w_radps_max: 2.0,
            a_mps2_max: 1.0,
            brake_mps2: 1.0,
            alpha_radps2_max: 4.0,
            ..Description::default()
        };
        let window = Window {
            robot: &robot,
            from: Twist::new(0.2, 0.1),
            speeds: Range {
                low: 0.2,
                high: 0.5,
            },
            yaw_rates: Range {
                low: -0.9,
                high: 1.1,
            },
            preferred_radps: 1.1,
            yaw_rad: 0.4,
            step_s: 0.1,
            horizon_s: 1.5,
            reaction_s: 0.1,
            stop_margin_m: 0.0,
            soft_m: 0.1,
        };
        let mut rollouts = Rollouts::default();
        rollouts.prepare(&window, 4, 5);
        assert_eq!((rollouts.len(), rollouts.steps), (20, 15));
        // Fine Euler integration of the same ramps to (0.5, 1.1).
        let (mut x, mut y, mut yaw, mut v, mut w) = (0.0_f64, 0.0_f64, 0.4_f64, 0.2_f64, 0.1_f64);
        let dt = 1.0e-5;
        for _ in 0..150_000 {
            v = (v + 1.0 * dt).min(0.5);
            w = (w + 4.0 * dt).min(1.1);
            x += v * dt * yaw.cos();
            y += v * dt * yaw.sin();
            yaw += w * dt;
        }
        let (mut rx, mut ry) = (0.0_f64, 0.0_f64);
        for step in 0..15 {
            let (driven, chord) = (
                rollouts.driven[3 * 15 + step],
                rollouts.chords[4 * 15 + step],
            );
            rx += f64::from(driven * chord.0);
            ry += f64::from(driven * chord.1);
        }
        assert!((rx - x).hypot(ry - y) < 0.01, "{rx} {ry} against {x} {y}");
        let (cos, sin) = rollouts.headings[4 * 15 + 14];
        assert!((f64::from(sin.atan2(cos)) - yaw).abs() < 1e-3);
    }
}
