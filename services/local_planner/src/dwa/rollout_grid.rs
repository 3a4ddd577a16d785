//! The rollouts of one dynamic window, speed by speed, all yaw rates side by side.
//!
//! A rollout speeds up or slows down to its target twist within the robot's accelerations and
//! holds it; each step is the chord of the exact arc of the step's mean twist. Its speed depends
//! on the target speed alone and its heading on the target yaw rate alone, so the trigonometry is
//! done once per yaw rate and step. Positions lie in lanes (structure of arrays), so that a step of
//! a whole row is a handful of vector instructions. Steps that no position can have left the free
//! space in are passed over: the least clearance of the row bounds how far it may drive unseen.

#![allow(
    clippy::needless_range_loop,
    clippy::single_match_else,
    reason = "several arrays step by step and lane by lane"
)]

use crate::dwa::window::{STEPS_MAX, Window, ramp_mean, snap, spread};
use crate::dynamic_obstacles::DynamicObstacles;
use crate::footprint::DISCS_MAX;
use crate::lanes::data::{LANES_MAX, Lanes, Sheet, Turns, WIDTH, narrow};
use crate::lanes::{
    advance, least_nearest_m, lower_space, lower_space_around, note_space, strike, turn,
};
use crate::surroundings::Surroundings;
use zeronav_casts::Cast;
use zeronav_motion::{Twist, reachable, sinc};
use zeronav_msgs::obstacles::OBSTACLES_MAX;

/// The sampled window; buffers are reused.
#[derive(Debug, Clone)]
pub(crate) struct RolloutGrid {
    /// Steps of a rollout.
    pub(crate) steps: usize,
    /// Target speeds. [m/s]
    pub(crate) speeds: Vec<f64>,
    /// Target yaw rates. [rad/s]
    pub(crate) yaw_rates: Vec<f64>,
    /// Yaw rates, rounded up to whole vectors; the rest repeats the last one.
    lanes: usize,
    /// Driven in each step, speeds x steps. [m]
    driven: Vec<f32>,
    /// Driven up to the end of each step, speeds x steps. [m]
    arcs: Vec<f32>,
    /// Per step: chord per metre driven along x and y, then cosine and sine of the heading.
    chord_x: Vec<Lanes>,
    chord_y: Vec<Lanes>,
    pub(crate) cos: Vec<Lanes>,
    pub(crate) sin: Vec<Lanes>,
    /// Turned up to the end of each step. [rad]
    turned: Vec<Lanes>,
    turns: Box<Turns>,
    /// By how much the robot overlaps each predicted obstacle now. [m]
    overlaps: Vec<f32>,
    /// Centres of predicted obstacles and the distances of contact, steps x obstacles. [m]
    discs: Vec<[f32; 3]>,
    /// The current row.
    pub(crate) row: Row,
}

/// All rollouts of one speed.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    /// Positions at the ends of the steps, relative to the robot along the axes of the map. [m]
    pub(crate) x: Vec<Lanes>,
    pub(crate) y: Vec<Lanes>,
    /// Least space around the outline up to the last scored step, at most the soft clearance. [m]
    pub(crate) space: Lanes,
    /// First step that is not free of the map and the scan; infinite for none.
    pub(crate) hit: Lanes,
    /// First step in which a predicted obstacle is touched; infinite for none.
    pub(crate) struck: Lanes,
}

impl Default for RolloutGrid {
    fn default() -> Self {
        let lanes = || vec![[0.0; LANES_MAX]; STEPS_MAX];
        Self {
            steps: 0,
            speeds: Vec::with_capacity(LANES_MAX),
            yaw_rates: Vec::with_capacity(LANES_MAX),
            lanes: 0,
            driven: Vec::with_capacity(LANES_MAX * STEPS_MAX),
            arcs: Vec::with_capacity(LANES_MAX * STEPS_MAX),
            chord_x: lanes(),
            chord_y: lanes(),
            cos: lanes(),
            sin: lanes(),
            turned: lanes(),
            turns: Box::new(Turns {
                cos: [1.0; LANES_MAX],
                sin: [0.0; LANES_MAX],
                turned: [0.0; LANES_MAX],
                angle: [0.0; LANES_MAX],
                half_cos: [1.0; LANES_MAX],
                half_sin: [0.0; LANES_MAX],
                chord: [1.0; LANES_MAX],
            }),
            overlaps: Vec::with_capacity(OBSTACLES_MAX),
            discs: Vec::with_capacity(OBSTACLES_MAX * STEPS_MAX),
            row: Row {
                x: lanes(),
                y: lanes(),
                space: [0.0; LANES_MAX],
                hit: [0.0; LANES_MAX],
                struck: [0.0; LANES_MAX],
            },
        }
    }
}

impl RolloutGrid {
    /// Samples `n_speeds x n_yaw_rates` targets evenly; the yaw rates nearest to zero and to the
    /// preferred one are moved onto them.
    pub(crate) fn prepare(&mut self, window: &Window<'_>, n_speeds: usize, n_yaw_rates: usize) {
        spread(&mut self.speeds, window.speeds, n_speeds.min(LANES_MAX));
        spread(
            &mut self.yaw_rates,
            window.yaw_rates,
            n_yaw_rates.min(LANES_MAX),
        );
        snap(&mut self.yaw_rates, 0.0);
        snap(&mut self.yaw_rates, window.preferred_radps);
        self.steps = window.steps();
        self.lanes = self.yaw_rates.len().div_ceil(WIDTH) * WIDTH;
        let (dt, robot, from) = (window.step_s, window.robot, window.from);
        self.driven.clear();
        self.arcs.clear();
        for &target in &self.speeds {
            let (mut v, mut arc_m) = (from.v_mps, 0.0);
            for _ in 0..self.steps {
                #[allow(clippy::float_cmp, reason = "a clamp that no longer clamps")]
                let step_m = if v == target {
                    target * dt
                } else {
                    let (was, to) = (Twist::new(v, 0.0), Twist::new(target, 0.0));
                    let next = reachable(robot, was, to, dt).v_mps;
                    let rate = if next.abs() > v.abs() {
                        robot.a_mps2_max
                    } else {
                        robot.brake_mps2
                    };
                    ramp_mean(core::mem::replace(&mut v, next), next, rate, dt) * dt
                };
                arc_m += step_m.abs();
                self.driven.push(narrow(step_m));
                self.arcs.push(narrow(arc_m));
            }
        }
        self.turn(window);
    }

    /// Headings and chords of every lane.
    fn turn(&mut self, window: &Window<'_>) {
        let (dt, robot, n) = (window.step_s, window.robot, self.lanes);
        let last = self.yaw_rates.len() - 1;
        let (sin, cos) = window.yaw_rad.sin_cos();
        let turns = &mut self.turns;
        turns.cos[..n].fill(cos);
        turns.sin[..n].fill(sin);
        turns.turned[..n].fill(0.0);
        let mut rates = [window.from.w_radps; LANES_MAX];
        // Once its target is reached every step of a lane turns alike.
        let mut ramping: u64 = u64::MAX >> (LANES_MAX - n);
        for k in 0..self.steps {
            let mut left = ramping;
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                let (w, target) = (rates[lane], self.yaw_rates[lane.min(last)]);
                let next =
                    reachable(robot, Twist::new(0.0, w), Twist::new(0.0, target), dt).w_radps;
                let angle = ramp_mean(w, next, robot.alpha_radps2_max, dt) * dt;
                (turns.half_sin[lane], turns.half_cos[lane]) = (0.5 * angle).sin_cos();
                turns.chord[lane] = sinc(0.5 * angle);
                turns.angle[lane] = angle;
                #[allow(clippy::float_cmp, reason = "a clamp that no longer clamps")]
                if w == target {
                    ramping &= !(1 << lane);
                }
                rates[lane] = next;
            }
            let chords = (&mut self.chord_x[k], &mut self.chord_y[k]);
            let headings = (&mut self.cos[k], &mut self.sin[k]);
            turn(n, turns, chords, headings, &mut self.turned[k]);
        }
    }

    /// How many rollouts there are.
    pub(crate) fn len(&self) -> usize {
        self.speeds.len() * self.yaw_rates.len()
    }

    /// [m] driven up to the end of each step at a speed.
    pub(crate) fn arcs_m(&self, speed: usize) -> &[f32] {
        &self.arcs[speed * self.steps..(speed + 1) * self.steps]
    }

    /// [rad] turned up to the end of a step.
    pub(crate) fn turned_rad(&self, step: usize, lane: usize) -> f32 {
        self.turned[step][lane]
    }

    /// Follows all rollouts of one speed into [`Self::row`]: through the map and the scan with
    /// what must be kept, and through the obstacles of [`Self::foresee`]. Space counts up to the step
    /// `scored`; static obstacles are looked for in the first `looked` steps, at least as many as
    /// are scored.
    pub(crate) fn drive(
        &mut self,
        speed: usize,
        surroundings: &Surroundings,
        soft_m: f64,
        (scored, looked): (usize, usize),
    ) {
        let n = self.lanes;
        let (soft, need) = (narrow(soft_m), narrow(surroundings.need_m()));
        let soft = soft.max(need);
        let row = &mut self.row;
        row.space[..n].fill(soft);
        row.hit[..n].fill(f32::INFINITY);
        row.struck[..n].fill(f32::INFINITY);
        // Predicted obstacles are looked for until the end.
        self.roll(
            speed,
            if self.overlaps.is_empty() {
                looked
            } else {
                self.steps
            },
        );
        let row = &mut self.row;
        let arcs = &self.arcs[speed * self.steps..(speed + 1) * self.steps];
        let sheet = surroundings.field.sheet();
        let outer = narrow(surroundings.footprint.circumscribed_m);
        let slack = surroundings.field.slack_m();
        let is_disc = surroundings.footprint.is_disc();
        // Arc length up to which nothing can be near.
        let mut free_until = f32::NEG_INFINITY;
        let mut was_free = true;
        for k in 0..looked {
            if arcs[k] <= free_until {
                continue;
            }
            let step = k.to_f32();
            // Rollouts that have ended tell nothing more.
            let ended = |lanes: &[f32]| lanes.iter().all(|hit| *hit < step);
            let hits = row.hit[..n].chunks_exact(WIDTH);
            let Some(first) = hits.clone().position(|lanes| !ended(lanes)) else {
                break;
            };
            let last = hits.rev().take_while(|lanes| ended(lanes)).count();
            let open = first * WIDTH..n - last * WIDTH;
            let (x, y) = (&row.x[k][open.clone()], &row.y[k][open.clone()]);
            // For a disc the look at all of them costs as much as it may save.
            if was_free || !is_disc || k % 4 == 0 {
                let nearest = least_nearest_m(&sheet, x, y);
                // Anywhere in a cell the clearance differs from its centre's by the slack at most.
                let spare = nearest - outer - soft - slack;
                was_free = spare >= 0.0;
                if was_free {
                    free_until = arcs[k] + spare - slack;
                    continue;
                }
            }
            let mut space = [soft; LANES_MAX];
            let space = &mut space[..x.len()];
            let heading = (&self.cos[k][open.clone()], &self.sin[k][open.clone()]);
            fill_space(&sheet, surroundings, (x, y), heading, (need, soft), space);
            note_space(
                space,
                (need, step, k <= scored),
                &mut row.hit[open.clone()],
                &mut row.space[open],
            );
        }
        if !self.overlaps.is_empty() {
            self.strike_row(speed);
        }
    }

    /// Positions at the ends of the first `steps` steps of all rollouts of one speed.
    fn roll(&mut self, speed: usize, steps: usize) {
        let n = self.lanes;
        let driven = &self.driven[speed * self.steps..(speed + 1) * self.steps];
        let origin = [0.0_f32; LANES_MAX];
        let (mut from_x, mut from_y) = (&origin, &origin);
        let chords = self.chord_x.iter().zip(&self.chord_y);
        let ends = self.row.x.iter_mut().zip(&mut self.row.y);
        for ((chord, driven), (x, y)) in chords.zip(driven).zip(ends).take(steps) {
            advance(
                *driven,
                (&chord.0[..n], &chord.1[..n]),
                (&from_x[..n], &from_y[..n]),
                &mut x[..n],
                &mut y[..n],
            );
            (from_x, from_y) = (x, y);
        }
    }

    /// Takes in the predictions of [`DynamicObstacles::tabulate`] for a robot of `radius_m`.
    pub(crate) fn foresee(&mut self, moving: &DynamicObstacles, radius_m: f64) {
        let robot_m = narrow(radius_m + MOVING_MARGIN_M);
        // Who overlaps the grown disc already must be able to leave it.
        self.overlaps.clear();
        self.overlaps.extend(moving.now().iter().map(|now| {
            let overlap = (robot_m + now[2] - now[0].hypot(now[1]) + OVERLAP_M).max(0.0);
            if overlap > OVERLAP_M { overlap } else { 0.0 }
        }));
        self.discs.clear();
        for k in 0..self.steps {
            let discs = moving.at_step(k).iter().zip(&self.overlaps);
            self.discs.extend(discs.map(|(disc, overlap)| {
                let radius = robot_m + disc[2] - overlap;
                [disc[0], disc[1], radius]
            }));
        }
    }

    /// Marks the first step in which each rollout of the row touches a predicted obstacle.
    fn strike_row(&mut self, speed: usize) {
        let n = self.lanes;
        let arcs = &self.arcs[speed * self.steps..(speed + 1) * self.steps];
        let tracks = self.overlaps.len();
        let row = &mut self.row;
        for (k, discs) in self.discs.chunks_exact(tracks.max(1)).enumerate() {
            let (x, y) = (&row.x[k][..n], &row.y[k][..n]);
            for disc in discs {
                let away = disc[0] * disc[0] + disc[1] * disc[1];
                let reach = arcs[k] + disc[2];
                if disc[2] > 0.0 && away <= reach * reach {
                    strike(x, y, *disc, k.to_f32(), &mut row.struck[..n]);
                }
            }
        }
    }
}

/// [m] kept from predicted obstacles.
const MOVING_MARGIN_M: f64 = 0.15;

/// [m] by which an overlap with a predicted disc is left per rollout at least.
const OVERLAP_M: f32 = 0.01;

/// Lowers `space`, which is `soft`, to that around the outline at every lane. Exact where it is
/// at least `need`. [m]
fn fill_space(
    sheet: &Sheet<'_>,
    surroundings: &Surroundings,
    (x, y): (&[f32], &[f32]),
    (cos, sin): (&[f32], &[f32]),
    (need, soft): (f32, f32),
    space: &mut [f32],
) {
    let footprint = &surroundings.footprint;
    if footprint.is_disc() {
        lower_space(sheet, x, y, narrow(footprint.circumscribed_m), space);
        return;
    }
    let enough = narrow(footprint.circumscribed_m) + soft + surroundings.field.slack_m();
    let mut discs = [[0.0; 3]; DISCS_MAX];
    for (to, disc) in discs.iter_mut().zip(&footprint.discs) {
        *to = [disc.centre.x, disc.centre.y, disc.radius_m].map(narrow);
    }
    let discs = &discs[..footprint.discs.len().min(DISCS_MAX)];
    for start in (0..x.len()).step_by(WIDTH) {
        let lanes = start..start + WIDTH;
        let at = (&x[lanes.clone()], &y[lanes.clone()]);
        if least_nearest_m(sheet, at.0, at.1) < enough {
            let heading = (&cos[lanes.clone()], &sin[lanes.clone()]);
            lower_space_around(sheet, at, heading, (discs, need), &mut space[lanes]);
        }
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
        let mut grid = RolloutGrid::default();
        grid.prepare(&window, 4, 5);
        assert_eq!((grid.len(), grid.steps), (20, 15));
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
        grid.roll(3, 15);
        let (rx, ry) = (f64::from(grid.row.x[14][4]), f64::from(grid.row.y[14][4]));
        assert!((rx - x).hypot(ry - y) < 0.01, "{rx} {ry} against {x} {y}");
        let (cos, sin) = (grid.cos[14][4], grid.sin[14][4]);
        assert!((f64::from(sin.atan2(cos)) - yaw).abs() < 1e-3);
    }
}
