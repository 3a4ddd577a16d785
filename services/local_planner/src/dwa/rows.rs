//! The rollouts of a dynamic window, evaluated speed by speed.

use crate::dwa::rollout_grid::RolloutGrid;
use crate::dwa::window::Window;
use crate::lanes::data::{LANES_MAX, WIDTH, narrow};
use crate::pilot::scene::Scene;
use crate::record::{DrawnRollout, Record};
use crate::rollout_scores::{Evaluate, ScoredRollouts, Terms};
use zeronav_casts::Cast;
use zeronav_motion::{Twist, stop_angle_rad, stop_distance_m};
use zeronav_msgs::rollouts::RolloutOutcome;

/// [m/s] below which a motion is a turn on the spot.
const TURNING_MPS: f64 = 0.02;

/// [m/s] below which being hit is not the robot's doing.
const STOPPED_MPS: f64 = 0.05;

/// The sampled window and the evaluation of one speed of it.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    pub(crate) grid: RolloutGrid,
    /// The current row.
    pub(crate) rated: Box<ScoredRollouts>,
    /// Steps of it in which static obstacles were looked for.
    followed: usize,
}

impl Rows {
    /// Samples the window, and takes in the obstacles that the scene predicts.
    pub(crate) fn prepare(&mut self, window: &Window<'_>, scene: &mut Scene<'_>, n: (u32, u32)) {
        let grid = &mut self.grid;
        grid.prepare(window, n.0 as usize, n.1 as usize);
        scene.memory.rollouts = u32::try_from(grid.len()).unwrap_or(u32::MAX);
        let dynamic = &mut scene.seen.dynamic;
        dynamic.tabulate(grid.steps, window.step_s, 0.0);
        grid.foresee(dynamic, scene.seen.surroundings.footprint.circumscribed_m);
    }

    /// Follows and evaluates the rollouts of a speed; the most promising lane among those on which
    /// the robot can stop. Beyond the end of the path and the step `judged` nothing is scored.
    pub(crate) fn rate(
        &mut self,
        scene: &Scene<'_>,
        window: &Window<'_>,
        (speed, judged): (usize, usize),
        terms: &impl Evaluate,
    ) -> Option<usize> {
        let Self {
            grid,
            rated,
            followed,
        } = self;
        let seen = &*scene.seen;
        let lanes = grid.yaw_rates.len();
        let ahead = narrow(seen.path.ahead_m);
        let arcs = grid.arcs_m(speed);
        let scored = arcs.partition_point(|arc| *arc < ahead).min(judged);
        let looked = looked(grid, window, speed, scored);
        *followed = looked;
        grid.drive(speed, &seen.surroundings, window.soft_m, (scored, looked));
        settle(grid, window, speed, scored, rated);
        if rated.admissible == 0 {
            return None;
        }
        let padded = lanes.next_multiple_of(WIDTH);
        for (x, y, found) in [
            (&rated.x, &rated.y, &mut rated.then),
            (&rated.half_x, &rated.half_y, &mut rated.half),
        ] {
            seen.path.project_all(&x[..padded], &y[..padded], found);
        }
        rated.rate(terms, &grid.yaw_rates);
        rated.most_promising(lanes)
    }

    /// The terms of what a rollout of the current row is worth.
    pub(crate) fn terms(&self, evaluate: &impl Evaluate, lane: usize) -> Terms {
        let rated = &self.rated;
        evaluate.terms(
            self.grid.yaw_rates[lane],
            &rated.outcome(lane),
            rated.collision_cost[lane],
        )
    }

    /// Tells the record of the rollouts of the current row, with what those are worth on which the
    /// robot can stop.
    pub(crate) fn tell(&self, record: &mut Record, speed: usize, worth: impl Fn(usize) -> f64) {
        for lane in 0..self.grid.yaw_rates.len() {
            let is_rated = self.rated.is_admissible(lane);
            let seen = self.seen(speed, lane, if is_rated { worth(lane) } else { 0.0 });
            record.offer(&seen, |step| self.place(step, lane));
        }
    }

    /// Tells the record that this rollout of the current row is the best one so far.
    pub(crate) fn lead(&self, record: &mut Record, (speed, lane): (usize, usize), worth: f64) {
        record.lead(&self.seen(speed, lane, worth), |step| {
            self.place(step, lane)
        });
    }

    fn place(&self, step: usize, lane: usize) -> (f32, f32) {
        let row = &self.grid.row;
        (row.x[step][lane], row.y[step][lane])
    }

    /// A rollout of the current row as the record takes it.
    fn seen(&self, speed: usize, lane: usize, worth: f64) -> DrawnRollout {
        let (hit, struck) = (self.grid.row.hit[lane], self.grid.row.struck[lane]);
        // Dynamic obstacles are looked for until the end, static ones no farther than followed.
        let (outcome, steps) = if struck < hit {
            let end = self.grid.steps;
            let until = (steps_until(struck, end) + 1).min(end);
            (RolloutOutcome::MovingCollision, until)
        } else if hit.is_finite() {
            let until = (steps_until(hit, self.followed) + 1).min(self.followed);
            (RolloutOutcome::Collision, until)
        } else {
            (RolloutOutcome::Costlier, self.followed)
        };
        let twist = (self.grid.speeds[speed], self.grid.yaw_rates[lane]);
        DrawnRollout {
            twist: (narrow(twist.0), narrow(twist.1)),
            cost: narrow(-worth),
            outcome: if self.rated.is_admissible(lane) {
                outcome
            } else {
                RolloutOutcome::NoStop
            },
            steps,
        }
    }

    /// The target of a rollout.
    pub(crate) fn twist(&self, speed: usize, lane: usize) -> Twist {
        Twist::new(self.grid.speeds[speed], self.grid.yaw_rates[lane])
    }
}

/// How many steps must be free of static obstacles for a row to be judged: the scored ones, and as many
/// as a stop needs. Whatever lies beyond neither [`settle`] nor the evaluation asks for.
fn looked(grid: &RolloutGrid, window: &Window<'_>, speed: usize, scored: usize) -> usize {
    let v = grid.speeds[speed];
    if v.abs() < TURNING_MPS {
        return grid.steps;
    }
    let needed_m = stop_distance_m(window.robot, v, window.reaction_s) + window.stop_margin_m;
    steps_to(grid, speed, needed_m).max((scored + 1).min(grid.steps))
}

/// Steps after which an arc has been driven, all of them at most.
fn steps_to(grid: &RolloutGrid, speed: usize, arc_m: f64) -> usize {
    let short = |arc: &f32| f64::from(*arc) < arc_m;
    (grid.arcs_m(speed).partition_point(short) + 1).min(grid.steps)
}

/// The step that a lane of [`RolloutGrid`] was marked with; `n` when it was not.
fn steps_until(mark: f32, n: usize) -> usize {
    // What is infinite becomes the largest number.
    (mark.to_u32() as usize).min(n)
}

/// How bad it is to touch an obstacle: 0 when none is touched, 1 when at once, never less than a
/// third, so that the robot gives way as soon as it sees it coming.
fn collision_cost(struck: usize, n: usize) -> f64 {
    if struck >= n {
        0.0
    } else {
        1.0 / 3.0 + 2.0 / 3.0 * (1.0 - struck.to_f64() / n.to_f64())
    }
}

/// Takes in where the rollouts of a speed end: with the scored steps or before static obstacles, and
/// on which the robot can stop before static obstacles (`v^2 / 2a + v t_reaction + margin <= free arc`,
/// on the spot the same with angles) and before what comes.
fn settle(
    grid: &RolloutGrid,
    window: &Window<'_>,
    speed: usize,
    scored: usize,
    rated: &mut ScoredRollouts,
) {
    let (v, steps, row) = (grid.speeds[speed], grid.steps, &grid.row);
    let needed_m = stop_distance_m(window.robot, v, window.reaction_s);
    let stopped = steps_to(grid, speed, needed_m + window.stop_margin_m).to_f32();
    let comes = if v.abs() < STOPPED_MPS {
        0.0
    } else {
        steps_to(grid, speed, needed_m).to_f32()
    };
    rated.admissible = 0;
    for (lane, &w_radps) in grid.yaw_rates.iter().enumerate().take(LANES_MAX) {
        let stops = if v.abs() < TURNING_MPS {
            let free = steps_until(row.hit[lane], steps);
            let free_rad = free
                .checked_sub(1)
                .map_or(0.0, |last| f64::from(grid.turned_rad(last, lane)).abs());
            free == steps || stop_angle_rad(window.robot, w_radps, window.reaction_s) <= free_rad
        } else {
            row.hit[lane] >= stopped && row.struck[lane] >= comes
        };
        rated.admissible |= u64::from(stops) << lane;
    }
    if rated.admissible == 0 {
        return;
    }
    (rated.x, rated.y) = (row.x[scored], row.y[scored]);
    (rated.half_x, rated.half_y) = (row.x[scored / 2], row.y[scored / 2]);
    (rated.cos, rated.sin) = (grid.cos[scored], grid.sin[scored]);
    rated.space = row.space;
    rated.collision_cost.fill(0.0);
    for lane in 0..grid.yaw_rates.len() {
        if row.hit[lane] <= scored.to_f32() {
            let end = steps_until(row.hit[lane], steps).saturating_sub(1);
            (rated.x[lane], rated.y[lane]) = (row.x[end][lane], row.y[end][lane]);
            rated.half_x[lane] = row.x[end / 2][lane];
            rated.half_y[lane] = row.y[end / 2][lane];
            (rated.cos[lane], rated.sin[lane]) = (grid.cos[end][lane], grid.sin[end][lane]);
        }
        if row.struck[lane].is_finite() {
            rated.collision_cost[lane] =
                collision_cost(steps_until(row.struck[lane], steps), steps);
        }
    }
}
