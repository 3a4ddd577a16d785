//! `mppi`: model predictive path integral control.
//!
//! Source: Williams, Drews, Goldfain, Rehg, Theodorou, "Information-Theoretic Model Predictive
//! Control", IEEE T-RO 34(6), 2018: many noisy sequences of twists around the last one are followed,
//! the next sequence is their mean, weighted by `exp(-cost / temperature)`. The differences:
//!
//! - **Samples obey the accelerations**, so the mean does, and are drawn with low-frequency noise
//!   (`noise.rs`); what the importance weights of the source do for smooth commands, a critic does.
//! - **Four samples are no noise**: last period's sequence, the choice of the dynamic window in time,
//!   braking to rest, and driving backwards. So never do only colliding ones compete.
//! - **The mean is not believed.** The mean of two ways round a post leads into it. Mean, best sample,
//!   the mean at full speed and the dynamic window's choice are judged by the critics; the cheapest is taken
//!   whose outline is free of map, scan and predictions, point by point, for as long as a stop lasts.
//! - Guidance, turns on the spot, arriving and the check of what is published are those of
//!   [`crate::dwa`]; its next best twists stay in reserve.
//!
//! The weighted mean is built batch by batch with a running minimum, so no sample is kept.

pub(crate) mod batch;
pub(crate) mod critics;
mod decisive;
mod limits;
mod noise;
pub mod options;
mod plan;
mod tell;

use crate::dwa::options::DwaConfig;
use crate::dwa_t::options::DwaTConfig;
use crate::dwa_t::{TimedWindow, in_time};
use crate::lanes::data::narrow;
use crate::local_path::LocalPath;
use crate::mppi::critics::CRITICS;
use crate::mppi::critics::cycle::Cycle;
use crate::mppi::options::MppiConfig;
use crate::pilot::Pilot;
use crate::pilot::perception::Tracks;
use crate::pilot::scene::{COMFORT_SHARE, Choose, ControlOutput, Scene};
use crate::record::Record;
use batch::{Batch, LANES, Lanes};
use decisive::decisive;
use limits::Limits;
use nalgebra::{Point2, Vector2};
use noise::Noise;
use plan::Plan;
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::command::RequestCause;

/// Exponent of a weight below which a sample does not count.
const NEGLIGIBLE: f32 = 16.0;

/// [m] by which a point of the outline moves from one checked pose to the next.
const CHECK_SPACING_M: f64 = 0.03;

/// [s] of the chosen sequence that are checked at least.
const CHECK_S_MIN: f64 = 0.5;

/// The controller `mppi` at rest. The numbers must be within the ranges of their structs.
#[must_use]
pub fn mppi(dwa: DwaConfig, timed: DwaTConfig, config: MppiConfig) -> Pilot {
    let timed = DwaTConfig {
        // As far as the samples go, so that they stay where the surroundings are known.
        horizon_s: timed.horizon_s.max(config.step_s * f64::from(config.steps)),
        ..timed
    };
    Pilot::new(
        in_time(dwa, timed),
        Tracks::Predicted(Box::default()),
        Box::new(Mppi {
            window: TimedWindow::new(timed),
            optimiser: Optimiser::new(config),
        }),
    )
}

/// The optimiser around the choice of the time-indexed window.
#[derive(Debug)]
struct Mppi {
    window: TimedWindow,
    optimiser: Optimiser,
}

impl Choose for Mppi {
    fn choose(&mut self, scene: &mut Scene<'_>) -> ControlOutput {
        let heading = match scene.heading() {
            Ok(heading) => heading,
            Err(turn) => {
                self.forget();
                return turn;
            }
        };
        // Of the samples alone: the window's rollouts cost in other terms.
        let mut record = scene.memory.record.take();
        let best = self.window.best(scene, &heading);
        let telling = record.as_deref_mut();
        let refined = (self.optimiser).refine(scene, heading.fastest_mps, best, telling);
        scene.memory.record = record;
        scene.memory.rollouts = scene.memory.rollouts.max(self.optimiser.looked_at);
        let limit = &mut scene.memory.limit;
        limit.slower = match refined {
            Some((_, slower)) => slower.unwrap_or(limit.cause),
            None => self.window.decisive(),
        };
        scene.steer_or_rest(refined.map(|(twist, _)| twist).or(best))
    }

    fn forget(&mut self) {
        self.optimiser.plan.forget();
    }
}

/// The samples and what came of them.
#[derive(Debug, Clone)]
struct Optimiser {
    config: MppiConfig,
    noise: Noise,
    batch: Batch,
    path: LocalPath,
    plan: Plan,
    /// Weighted sums of twists per step and lane, and of the weights per lane.
    sum_v: Vec<Lanes>,
    sum_w: Vec<Lanes>,
    sum: Lanes,
    /// Cost of the best sample so far, and its twists.
    least: f32,
    best: Plan,
    looked_at: u32,
}

/// Lanes of the last batch.
const MEAN: usize = 0;
const BEST: usize = 1;
const WINDOW: usize = 2;
/// The mean's yaw rates as fast as allowed: the mean of speeds that end there stays below it by the
/// width of the noise.
const BRISK: usize = 3;

impl Optimiser {
    fn new(config: MppiConfig) -> Self {
        let steps = config.steps as usize;
        let rows = (config.samples as usize).div_ceil(LANES);
        Self {
            config,
            noise: Noise::new(config.seed, rows, steps),
            batch: Batch::new(steps),
            path: LocalPath::default(),
            plan: Plan::new(steps),
            sum_v: vec![[0.0; LANES]; steps],
            sum_w: vec![[0.0; LANES]; steps],
            sum: [0.0; LANES],
            least: f32::INFINITY,
            best: Plan::new(steps),
            looked_at: 0,
        }
    }

    /// The plan with noise, for one row of samples.
    fn ask(&mut self, row: usize, back_mps: f32, window: (f32, f32)) {
        let (std_v, std_w) = (
            narrow(self.config.speed_std_mps),
            narrow(self.config.yaw_rate_std_radps),
        );
        let batch = &mut self.batch;
        for step in 0..batch.steps {
            let (asked_v, asked_w) = (&mut batch.asked_v[step], &mut batch.asked_w[step]);
            self.noise.at(row, step, asked_v, asked_w);
            let (plan_v, plan_w) = self.plan.at(step);
            for (v, w) in asked_v.iter_mut().zip(asked_w) {
                *v = plan_v + std_v * *v;
                *w = plan_w + std_w * *w;
            }
        }
        if row == 0 {
            for step in 0..batch.steps {
                let seeds = [self.plan.at(step), window, (0.0, 0.0), (back_mps, 0.0)];
                for (lane, (v, w)) in seeds.into_iter().enumerate() {
                    batch.asked_v[step][lane] = v;
                    batch.asked_w[step][lane] = w;
                }
            }
        }
    }

    /// Takes a judged batch into the mean.
    fn weigh(&mut self, costs: &Lanes) {
        let inverse = 1.0 / narrow(self.config.temperature_m);
        let mut cheapest = 0;
        for (lane, cost) in costs.iter().enumerate() {
            if *cost < costs[cheapest] {
                cheapest = lane;
            }
        }
        if costs[cheapest] < self.least {
            let scale = libm::expf((costs[cheapest] - self.least) * inverse);
            self.least = costs[cheapest];
            self.best.take(&self.batch, cheapest);
            let sums = self.sum_v.iter_mut().chain(&mut self.sum_w);
            for sum in sums.chain(core::iter::once(&mut self.sum)).flatten() {
                *sum *= scale;
            }
        }
        let mut weights = [0.0; LANES];
        let mut any = false;
        for (weight, cost) in weights.iter_mut().zip(costs) {
            let exponent = (cost - self.least) * inverse;
            if exponent < NEGLIGIBLE {
                *weight = libm::expf(-exponent);
                any = true;
            }
        }
        if !any {
            return;
        }
        for (sum, weight) in self.sum.iter_mut().zip(&weights) {
            *sum += weight;
        }
        let sums = self.sum_v.iter_mut().zip(&mut self.sum_w);
        for ((sum_v, sum_w), (v, w)) in sums.zip(self.batch.v.iter().zip(&self.batch.w)) {
            for lane in 0..LANES {
                sum_v[lane] += weights[lane] * v[lane];
                sum_w[lane] += weights[lane] * w[lane];
            }
        }
    }

    /// Follows what is asked for and judges it.
    fn judge(&mut self, limits: &Limits, cycle: &Cycle<'_>, scene: &Scene<'_>, costs: &mut Lanes) {
        let (sin, cos) = scene.situation.map_from_base.yaw_rad.sin_cos();
        self.batch
            .roll(limits, pair(scene.from), (narrow(sin), narrow(cos)));
        self.batch
            .look(&scene.seen.surroundings, f64::from(cycle.soft_m));
        self.batch.project(cycle.path);
        *costs = [0.0; LANES];
        for critic in CRITICS {
            let weight = narrow((critic.weight)(&self.config.critics));
            if weight > 0.0 {
                (critic.score)(cycle, &self.batch, weight, costs);
            }
        }
    }

    /// Those that may be driven, as the last batch.
    fn finalists(&mut self, window: (f32, f32), fastest: f32) {
        let total: f32 = self.sum.iter().sum();
        for step in 0..self.batch.steps {
            let mean = (
                self.sum_v[step].iter().sum::<f32>() / total,
                self.sum_w[step].iter().sum::<f32>() / total,
            );
            self.batch.asked_v[step].fill(mean.0);
            self.batch.asked_w[step].fill(mean.1);
            let best = self.best.at(step);
            for (lane, (v, w)) in [(BEST, best), (WINDOW, window), (BRISK, (fastest, mean.1))] {
                self.batch.asked_v[step][lane] = v;
                self.batch.asked_w[step][lane] = w;
            }
        }
    }

    /// True when the outline is free along a sample for as long as a stop lasts.
    fn is_free(&self, scene: &Scene<'_>, lane: usize) -> bool {
        let (robot, batch, seen) = (scene.situation.robot, &self.batch, &*scene.seen);
        let fastest_mps = batch.v.iter().map(|v| v[lane].abs()).fold(0.0, f32::max);
        let stop_s = scene.config.reaction_s + f64::from(fastest_mps) / robot.brake_mps2;
        let outline_m = |point| seen.surroundings.footprint.distance_m(point);
        let now_m = seen.dynamic.margin_m(&Pose::default(), 0.0, outline_m);
        let keep_m = seen.surroundings.need_m().max(0.0).min(now_m - NOISE_M);
        let (base_sin, base_cos) = scene.situation.map_from_base.yaw_rad.sin_cos();
        let (mut from, mut elapsed_s) = (Pose::default(), 0.0);
        for step in 0..batch.steps {
            let (x, y) = (
                f64::from(batch.x[step][lane]),
                f64::from(batch.y[step][lane]),
            );
            let (sin, cos) = (
                f64::from(batch.sin[step][lane]),
                f64::from(batch.cos[step][lane]),
            );
            let yaw_rad = (sin * base_cos - cos * base_sin).atan2(cos * base_cos + sin * base_sin);
            let at = Point2::new(base_cos * x + base_sin * y, base_cos * y - base_sin * x);
            let way: Vector2<f64> = at - from.point();
            let turn_rad = zeronav_msgs::pose::wrap_angle(yaw_rad - from.yaw_rad);
            let outer_m = seen.surroundings.footprint.circumscribed_m;
            let pieces = ((way.norm() + turn_rad.abs() * outer_m) / CHECK_SPACING_M)
                .ceil()
                .max(1.0);
            let mut piece = 1.0;
            while piece <= pieces {
                let share = piece / pieces;
                let pose = Pose::new(
                    from.x_m + way.x * share,
                    from.y_m + way.y * share,
                    from.yaw_rad + turn_rad * share,
                );
                let then_s = elapsed_s + self.config.step_s * share;
                let clear = seen.dynamic.margin_m(&pose, then_s, outline_m) >= keep_m;
                if !clear || !seen.surroundings.keeps_margin(&pose) {
                    return false;
                }
                piece += 1.0;
            }
            from = Pose::new(at.x, at.y, yaw_rad);
            elapsed_s += self.config.step_s;
            if elapsed_s >= stop_s.max(CHECK_S_MIN) {
                break;
            }
        }
        true
    }

    fn clear_sums(&mut self) {
        self.least = f32::INFINITY;
        let sums = self.sum_v.iter_mut().chain(&mut self.sum_w);
        for sum in sums.chain(core::iter::once(&mut self.sum)) {
            *sum = [0.0; LANES];
        }
    }

    /// Draws all samples and takes them into the mean. `window` is the twist of the window's choice.
    fn explore(
        &mut self,
        limits: &Limits,
        cycle: &Cycle<'_>,
        scene: &Scene<'_>,
        window: (f32, f32),
        mut record: Option<&mut Record>,
    ) {
        self.noise.shuffle();
        self.clear_sums();
        let mut costs = [0.0; LANES];
        for row in 0..self.noise.rows() {
            self.ask(row, narrow(cycle.robot.v_mps_min), window);
            self.judge(limits, cycle, scene, &mut costs);
            self.weigh(&costs);
            if let Some(record) = &mut record {
                tell::samples(record, cycle, &self.batch, &costs);
            }
        }
        self.looked_at = u32::try_from(self.noise.rows() * LANES).unwrap_or(u32::MAX);
    }

    /// The lane of the cheapest finalist that is free.
    fn cheapest_free(&self, scene: &Scene<'_>, costs: &Lanes) -> Option<usize> {
        let mut order = by_cost(costs).into_iter();
        order.find(|lane| self.is_free(scene, *lane))
    }

    /// The first twist of the cheapest free sequence, and what speaks against a faster one; `None` =
    /// none that is better than `best`, the window's choice.
    fn refine(
        &mut self,
        scene: &mut Scene<'_>,
        fastest_mps: f64,
        best: Option<Twist>,
        mut record: Option<&mut Record>,
    ) -> Option<(Twist, Option<RequestCause>)> {
        let situation = scene.situation;
        let (robot, goal) = (situation.robot, situation.goal);
        let steps = self.batch.steps;
        let here = situation.map_from_base.point();
        let beside_m = (scene.place.cross_track_m - goal.tolerance_m).max(0.0);
        let stop = (
            scene.place.remaining_m + beside_m,
            COMFORT_SHARE * robot.brake_mps2,
        );
        let limits = Limits::new(robot, fastest_mps, self.config.step_s, stop);
        let horizon_s = self.config.step_s * f64::from(self.config.steps);
        self.path.sample(
            &scene.seen.tracker,
            situation.path,
            &scene.place,
            here,
            robot.v_mps_max * horizon_s + 0.5,
        );
        let window = pair(best.unwrap_or(Twist::REST));
        if self.plan.is_known() {
            self.plan
                .advance(narrow(situation.period_s / self.config.step_s));
        } else {
            self.plan.hold(window);
        }
        scene.seen.dynamic.tabulate(steps, self.config.step_s, 0.0);
        scene.find_cost_to_go(false);
        let (scene, seen) = (&*scene, &*scene.seen);
        let path = core::mem::take(&mut self.path);
        let config = self.config;
        let any_yaw = goal.yaw_tolerance_rad >= core::f64::consts::PI;
        let (goal_sin, goal_cos) = goal.pose.yaw_rad.sin_cos();
        let need_m = seen.surroundings.need_m();
        let cycle = Cycle {
            robot,
            config: &config,
            radius_m: narrow(seen.surroundings.footprint.circumscribed_m),
            soft_m: narrow(scene.config.soft_clearance_m.max(need_m)),
            need_m: narrow(need_m),
            path: &path,
            cost_to_go: seen
                .cost_to_go()
                .filter(|_| situation.map.is_some())
                .map(|cost_to_go| (cost_to_go, cost_to_go.at(here))),
            here,
            dynamic: &seen.dynamic,
            goal: (
                narrow(goal.pose.x_m - here.x),
                narrow(goal.pose.y_m - here.y),
            ),
            goal_heading: (!any_yaw).then(|| (narrow(goal_cos), narrow(goal_sin))),
            remaining_m: narrow(scene.place.remaining_m),
        };
        self.explore(&limits, &cycle, scene, window, record.as_deref_mut());
        self.finalists(window, narrow(fastest_mps));
        let mut costs = [0.0; LANES];
        self.judge(&limits, &cycle, scene, &mut costs);
        let chosen = self.cheapest_free(scene, &costs);
        if let Some(record) = record {
            let order = by_cost(&costs);
            tell::finalists(record, &cycle, &self.batch, (order, chosen), &costs);
        }
        let slower =
            chosen.and_then(|lane| decisive(&cycle, &self.batch, &config.critics, (lane, BRISK)));
        self.path = path;
        let Some(lane) = chosen else {
            self.plan.forget();
            return None;
        };
        self.plan.take(&self.batch, lane);
        let (v, w) = self.plan.at(0);
        Some((Twist::new(f64::from(v), f64::from(w)), slower))
    }
}

/// The finalists, the cheapest first.
fn by_cost(costs: &Lanes) -> [usize; 4] {
    let mut order = [MEAN, BEST, WINDOW, BRISK];
    order.sort_by(|a, b| costs[*a].total_cmp(&costs[*b]));
    order
}

/// [m] by which a robot may come nearer to a prediction in one check: noise, not motion.
const NOISE_M: f64 = 0.002;

fn pair(twist: Twist) -> (f32, f32) {
    (narrow(twist.v_mps), narrow(twist.w_radps))
}
