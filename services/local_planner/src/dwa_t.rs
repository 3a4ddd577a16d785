//! `dwa_t`: the time-indexed dynamic window. What it adds to [`crate::dwa`]:
//!
//! - **Time.** Rollouts meet tracked obstacles where they will be, with a radius that grows with
//!   the uncertainty of the prediction; the scan's points of dynamic obstacles are not taken for
//!   walls. What is published also keeps clear of them until the robot has stopped.
//! - **Cost-to-go.** Progress is measured by the shortest free way over the local window
//!   (`cost_to_go.rs`), so a dead end beside the path attracts no rollout.
//! - **Speed by clearance**: `v <= speed_base + speed_gain * space`.
//! - **All yaw rates at once** (`rollout_grid.rs`), and the best of every speed in reserve for the
//!   exact check.

pub mod options;
pub(crate) mod rollout_grid;

use crate::dwa::options::DwaConfig;
use crate::dwa::rollouts::{Outcome, TURNING_MPS};
use crate::dwa::window::Window;
use crate::dynamic_obstacles::Growth;
use crate::lanes::data::{LANES_MAX, WIDTH, narrow};
use crate::pilot::Pilot;
use crate::pilot::perception::{PATH_HORIZON_S, Perception, Prediction, Tracks};
use crate::pilot::scene::{CREEP_MPS, Choose, Heading, Mode, Scene, Wish};
use crate::rated::{Rated, TimedWorth};
use nalgebra::Point2;
use options::DwaTConfig;
use rollout_grid::RolloutGrid;
use zeronav_motion::{Twist, stop_angle_rad, stop_distance_m};

/// [m] by which the free way may be longer than the way along the path before it counts.
const DEAD_END_M: f32 = 0.3;

/// [m/s] below which being hit is not the robot's doing.
const STOPPED_MPS: f64 = 0.05;

/// The controller `dwa_t` at rest. The numbers must be within the ranges of their structs.
#[must_use]
pub fn dwa_t(dwa: DwaConfig, config: DwaTConfig) -> Pilot {
    Pilot::new(
        in_time(dwa, config),
        Tracks::Predicted(Box::new(Prediction::new(Growth::from(&config)))),
        Box::new(TimedWindow::new(config)),
    )
}

/// The pilot's parameters with the rollouts of the time-indexed window.
pub(crate) fn in_time(dwa: DwaConfig, config: DwaTConfig) -> DwaConfig {
    DwaConfig {
        horizon_s: config.horizon_s,
        step_s: config.horizon_s / f64::from(config.steps),
        ..dwa
    }
}

/// The best twist of the time-indexed window.
#[derive(Debug)]
pub(crate) struct TimedWindow {
    config: DwaTConfig,
    grid: RolloutGrid,
    /// The current row.
    rated: Box<Rated>,
}

impl Choose for TimedWindow {
    fn choose(&mut self, scene: &mut Scene<'_>) -> Wish {
        match scene.heading() {
            Ok(heading) => {
                let best = self.best(scene, &heading);
                scene.steer_or_rest(best)
            }
            Err(turn) => turn,
        }
    }
}

/// The free way from `here` to the goal. [m]
fn to_go(seen: &Perception, at: Point2<f64>) -> Option<f32> {
    seen.cost_to_go().and_then(|cost_to_go| cost_to_go.at(at))
}

impl TimedWindow {
    pub(crate) fn new(config: DwaTConfig) -> Self {
        Self {
            config,
            grid: RolloutGrid::default(),
            rated: Box::default(),
        }
    }

    /// The best twist of the window; the best of the other speeds go into the reserve.
    pub(crate) fn best(&mut self, scene: &mut Scene<'_>, heading: &Heading) -> Option<Twist> {
        let (window, config) = (scene.window(heading), self.config);
        let grid = &mut self.grid;
        grid.prepare(&window, config.speeds as usize, config.yaw_rates as usize);
        scene.memory.rollouts = u32::try_from(grid.len()).unwrap_or(u32::MAX);
        scene.seen.dynamic.tabulate(grid.steps, window.step_s);
        let footprint = &scene.seen.surroundings.footprint;
        grid.foresee(&scene.seen.dynamic, footprint.circumscribed_m);
        let now = to_go(scene.seen, scene.situation.map_from_base.point());
        // Later only dynamic obstacles count.
        let judged_s = judged_s(scene, config.scored_s);
        let judged = steps_of(judged_s, window.step_s).clamp(1, grid.steps) - 1;
        scene.memory.reserve.clear();
        for speed in 0..self.grid.speeds.len() {
            let best = self.best_of_speed(scene, &window, speed, judged, now);
            scene.memory.reserve.extend(best);
        }
        let reserve = &mut scene.memory.reserve;
        reserve.sort_by(|a, b| b.0.total_cmp(&a.0));
        reserve.first().map(|(_, twist)| *twist)
    }

    /// The best twist of a speed with its worth. `judged` is the last step that is compared with
    /// the path, `now` the way to go from here. [m]
    fn best_of_speed(
        &mut self,
        scene: &Scene<'_>,
        window: &Window<'_>,
        speed: usize,
        judged: usize,
        now: Option<f32>,
    ) -> Option<(f64, Twist)> {
        let Self {
            config,
            grid,
            rated,
        } = self;
        let (seen, here) = (&*scene.seen, scene.situation.map_from_base.point());
        let lanes = grid.yaw_rates.len();
        let v_mps = grid.speeds[speed];
        let ahead = narrow(seen.path.ahead_m);
        let arcs = grid.arcs_m(speed);
        let scored = arcs.partition_point(|arc| *arc < ahead).min(judged);
        let looked = looked(grid, window, speed, scored);
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
        let terms = TimedWorth {
            worth: scene.worth_at(v_mps),
            v_mps,
            config: *config,
        };
        rated.rate(&terms, &grid.yaw_rates);
        // Along the path, unless the free way from there is longer than that.
        let worth_of = |lane: usize| {
            let (x, y) = (f64::from(rated.x[lane]), f64::from(rated.y[lane]));
            let at = Point2::new(here.x + x, here.y + y);
            let nearer = to_go(seen, at).zip(now).map(|(then, now)| now - then);
            match nearer.filter(|nearer| *nearer < rated.then.along[lane] - DEAD_END_M) {
                None => rated.worth[lane],
                Some(nearer) => {
                    let outcome = Outcome {
                        progress_m: f64::from(nearer),
                        ..rated.outcome(lane)
                    };
                    terms.of(grid.yaw_rates[lane], &outcome, rated.badness[lane])
                }
            }
        };
        // The cost-to-go can only make a rollout worth less: most are out of the question once the
        // most promising one is known.
        let first = rated.most_promising(lanes)?;
        let mut best = (worth_of(first), first);
        for lane in (0..lanes).filter(|lane| *lane != first) {
            // Of two that are worth the same the lower yaw rate.
            let is_better = |worth: f64| worth > best.0 || worth >= best.0 && lane < best.1;
            if is_better(rated.worth[lane]) && rated.is_admissible(lane) {
                let worth = worth_of(lane);
                if is_better(worth) {
                    best = (worth, lane);
                }
            }
        }
        Some((best.0, Twist::new(v_mps, grid.yaw_rates[best.1])))
    }
}

/// [s] that rollouts are compared with the path and static obstacles: in the open as long as the
/// weights are meant for, where there is no room around the robot `tight_s`. There ways bend within
/// a metre, and a robot that wants one arc to fit them for longer creeps. A robot that creeps
/// already gets nowhere in `tight_s` and would find every motion as good as none.
fn judged_s(scene: &Scene<'_>, tight_s: f64) -> f64 {
    let soft_m = scene.config.soft_clearance_m;
    let (surroundings, last) = (&scene.seen.surroundings, scene.memory.last);
    let space_m =
        f64::from(surroundings.field.nearest_m(0.0, 0.0)) - surroundings.footprint.circumscribed_m;
    let open = ((space_m - soft_m) / soft_m).clamp(0.0, 1.0);
    let open_s = PATH_HORIZON_S.max(tight_s);
    let creep_mps = CREEP_MPS.min(0.25 * scene.situation.robot.v_mps_max);
    let creeping = !last.is_stopped() && last.v_mps.abs() < creep_mps;
    if creeping && scene.memory.mode == Mode::Follow {
        return open_s;
    }
    tight_s + open * (open_s - tight_s)
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

/// Whole steps in a time.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a few dozen"
)]
fn steps_of(time_s: f64, step_s: f64) -> usize {
    (time_s / step_s).round().max(0.0) as usize
}

/// The step that a lane of [`RolloutGrid`] was marked with; `n` when it was not.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a step's index"
)]
fn steps_until(mark: f32, n: usize) -> usize {
    // What is infinite becomes the largest number.
    (mark as u32 as usize).min(n)
}

/// How bad it is to touch an obstacle: 0 when none is touched, 1 when at once, never less than a
/// third, so that the robot gives way as soon as it sees it coming.
#[allow(clippy::cast_precision_loss, reason = "at most 64 steps")]
fn badness(struck: usize, n: usize) -> f64 {
    if struck >= n {
        0.0
    } else {
        1.0 / 3.0 + 2.0 / 3.0 * (1.0 - struck as f64 / n as f64)
    }
}

/// Takes in where the rollouts of a speed end: with the scored steps or before static obstacles, and
/// on which the robot can stop before static obstacles (`v^2 / 2a + v t_reaction + margin <= free arc`,
/// on the spot the same with angles) and before what comes.
#[allow(clippy::cast_precision_loss, reason = "at most 64 steps")]
fn settle(grid: &RolloutGrid, window: &Window<'_>, speed: usize, scored: usize, rated: &mut Rated) {
    let (v, steps, row) = (grid.speeds[speed], grid.steps, &grid.row);
    let needed_m = stop_distance_m(window.robot, v, window.reaction_s);
    let stopped = steps_to(grid, speed, needed_m + window.stop_margin_m) as f32;
    let comes = if v.abs() < STOPPED_MPS {
        0.0
    } else {
        steps_to(grid, speed, needed_m) as f32
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
    rated.badness.fill(0.0);
    for lane in 0..grid.yaw_rates.len() {
        if row.hit[lane] <= scored as f32 {
            let end = steps_until(row.hit[lane], steps).saturating_sub(1);
            (rated.x[lane], rated.y[lane]) = (row.x[end][lane], row.y[end][lane]);
            rated.half_x[lane] = row.x[end / 2][lane];
            rated.half_y[lane] = row.y[end / 2][lane];
            (rated.cos[lane], rated.sin[lane]) = (grid.cos[end][lane], grid.sin[end][lane]);
        }
        if row.struck[lane].is_finite() {
            rated.badness[lane] = badness(steps_until(row.struck[lane], steps), steps);
        }
    }
}
