//! `dwa_t`: the time-indexed dynamic window. What it adds to [`crate::dwa`]:
//!
//! - **Time.** Rollouts meet tracked obstacles where they will be, with a radius that grows with
//!   the uncertainty of the prediction; the scan's points of dynamic obstacles are not taken for
//!   walls. What is published also keeps clear of them until the robot has stopped.
//! - **Cost-to-go.** Progress is measured by the shortest free way over the local window
//!   (`cost_to_go.rs`), so a dead end beside the path attracts no rollout.
//! - **Speed by clearance**: `v <= speed_base + speed_gain * space`.
//! - **The best of every speed in reserve** for the exact check.

pub mod options;

use crate::dwa::critics::Critics;
use crate::dwa::options::DwaConfig;
use crate::dwa::rows::Rows;
use crate::dwa::window::Window;
use crate::pilot::Pilot;
use crate::pilot::perception::{PATH_HORIZON_S, Perception, Tracks};
use crate::pilot::scene::{CREEP_MPS, Choose, ControlOutput, Heading, Mode, Scene};
use crate::record::Record;
use crate::rollout_scores::{Evaluate, Terms, TimedRolloutScore};
use nalgebra::Point2;
use options::DwaTConfig;
use zeronav_casts::Cast;
use zeronav_motion::Twist;
use zeronav_msgs::command::RequestCause;

/// [s] of a rollout that are compared with the path and static obstacles where there is no room
/// around the robot; ways bend within a metre there.
const TIGHT_S: f64 = 0.8;

/// [m] by which the free way may be longer than the way along the path before it counts.
const DEAD_END_M: f32 = 0.3;

/// The controller `dwa_t` at rest. The numbers must be within the ranges of their structs.
#[must_use]
pub fn dwa_t(dwa: DwaConfig, config: DwaTConfig) -> Pilot {
    Pilot::new(
        in_time(dwa, config),
        Tracks::Predicted(Box::default()),
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
    rows: Rows,
    /// Of the last choice.
    critics: Critics,
}

impl Choose for TimedWindow {
    fn choose(&mut self, scene: &mut Scene<'_>) -> ControlOutput {
        match scene.heading() {
            Ok(heading) => {
                let best = self.best(scene, &heading);
                scene.memory.limit.slower = self.decisive();
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
            rows: Rows::default(),
            critics: Critics::default(),
        }
    }

    /// Which critic decided against a faster motion, in the last choice.
    pub(crate) fn decisive(&self) -> RequestCause {
        self.critics.decisive()
    }

    /// The best twist of the window; the best of the other speeds go into the reserve.
    pub(crate) fn best(&mut self, scene: &mut Scene<'_>, heading: &Heading) -> Option<Twist> {
        let (window, config) = (scene.window(heading), self.config);
        self.rows
            .prepare(&window, scene, (config.speeds, config.yaw_rates));
        // A dead end that is taken for the way costs one period at most.
        scene.find_cost_to_go(true);
        let now = to_go(scene.seen, scene.situation.map_from_base.point());
        // Later only dynamic obstacles count.
        let judged_s = judged_s(scene, config.horizon_s);
        let judged = steps_of(judged_s, window.step_s).clamp(1, self.rows.grid.steps) - 1;
        scene.memory.reserve.clear();
        let mut record = scene.memory.record.take();
        let mut most = f64::NEG_INFINITY;
        self.critics = Critics::default();
        for speed in 0..self.rows.grid.speeds.len() {
            let telling = record.as_deref_mut();
            let Some(best) = self.best_of_speed(scene, &window, (speed, judged), now, telling)
            else {
                continue;
            };
            let (worth, lane, terms) = best;
            self.critics.offer(self.rows.grid.speeds[speed], terms);
            let twist = self.rows.twist(speed, lane);
            scene.memory.reserve.push((worth, twist));
            if let Some(record) = record.as_mut().filter(|_| worth > most) {
                most = worth;
                self.rows.lead(record, (speed, lane), worth);
            }
        }
        scene.memory.record = record;
        let reserve = &mut scene.memory.reserve;
        reserve.sort_by(|a, b| b.0.total_cmp(&a.0));
        reserve.first().map(|(_, twist)| *twist)
    }

    /// The best lane of a speed with its worth and the terms of that. `judged` is the last step that is
    /// compared with the path, `now` the way to go from here. [m]
    fn best_of_speed(
        &mut self,
        scene: &Scene<'_>,
        window: &Window<'_>,
        (speed, judged): (usize, usize),
        now: Option<f32>,
        record: Option<&mut Record>,
    ) -> Option<(f64, usize, Terms)> {
        let v_mps = self.rows.grid.speeds[speed];
        let terms = TimedRolloutScore {
            worth: scene.worth_at(v_mps),
            v_mps,
            config: self.config,
        };
        let first = self.rows.rate(scene, window, (speed, judged), &terms);
        let Rows { grid, rated, .. } = &self.rows;
        let here = scene.situation.map_from_base.point();
        // Along the path, unless the free way from there is longer than that.
        let nearer_m = |lane: usize| {
            let (x, y) = (f64::from(rated.x[lane]), f64::from(rated.y[lane]));
            let at = Point2::new(here.x + x, here.y + y);
            let nearer = to_go(scene.seen, at).zip(now).map(|(then, now)| now - then);
            nearer.filter(|nearer| *nearer < rated.then.along[lane] - DEAD_END_M)
        };
        let terms_of = |lane: usize| {
            let mut outcome = rated.outcome(lane);
            if let Some(nearer) = nearer_m(lane) {
                outcome.progress_m = f64::from(nearer);
            }
            terms.terms(grid.yaw_rates[lane], &outcome, rated.collision_cost[lane])
        };
        let worth_of = |lane: usize| match nearer_m(lane) {
            None => rated.worth[lane],
            Some(_) => terms_of(lane).worth(),
        };
        if let Some(record) = record {
            self.rows.tell(record, speed, worth_of);
        }
        let first = first?;
        // The cost-to-go can only make a rollout worth less: most are out of the question once the
        // most promising one is known.
        let mut best = (worth_of(first), first);
        for lane in (0..grid.yaw_rates.len()).filter(|lane| *lane != first) {
            // Of two that are worth the same the lower yaw rate.
            let is_better = |worth: f64| worth > best.0 || worth >= best.0 && lane < best.1;
            if is_better(rated.worth[lane]) && rated.is_admissible(lane) {
                let worth = worth_of(lane);
                if is_better(worth) {
                    best = (worth, lane);
                }
            }
        }
        Some((best.0, best.1, terms_of(best.1)))
    }
}

/// [s] that rollouts are compared with the path and static obstacles: in the open as long as the
/// weights are meant for, where there is no room around the robot [`TIGHT_S`]. There ways bend within
/// a metre, and a robot that wants one arc to fit them for longer creeps. A robot that creeps
/// already gets nowhere in that time and would find every motion as good as none.
fn judged_s(scene: &Scene<'_>, horizon_s: f64) -> f64 {
    let tight_s = TIGHT_S.min(horizon_s);
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

/// Whole steps in a time.
fn steps_of(time_s: f64, step_s: f64) -> usize {
    (time_s / step_s).round().max(0.0).to_usize()
}
