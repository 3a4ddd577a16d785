//! `dwa_t`: the time-indexed dynamic window. What it adds to [`super`]:
//!
//! - **Time.** Rollouts meet tracked obstacles where they will be, with a radius that grows with
//!   the uncertainty of the prediction; the scan's points of what moves are not taken for walls.
//!   What is published also keeps clear of them until it stands.
//! - **Cost-to-go.** Progress is measured by the shortest free way over the local window
//!   ([`crate::funnel`]), so a dead end beside the path attracts nobody.
//! - **Speed by clearance**: `v <= speed_base + speed_gain * space`.
//! - **All yaw rates at once** ([`crate::fan`]), and the best of every speed in reserve for the
//!   exact check.

use super::guidance::CREEP_MPS;
use super::row::{Rated, TimedWorth};
use super::{Dwa, Mode, PATH_HORIZON_S};
use crate::controller::Situation;
use crate::dwa_t::options::DwaTConfig;
use crate::fan::Fan;
use crate::funnel::{Funnel, FunnelInputs};
use crate::lanes::{LANES_MAX, WIDTH, rate};
use crate::moving::Growth;
use crate::progress::Place;
use crate::rollout::{Outcome, TURNING_MPS};
use crate::surroundings::narrow;
use crate::window::Window;
use nalgebra::Point2;
use zeronav_motion::{Twist, stop_angle_rad, stop_distance_m};
use zeronav_msgs::MapView;
use zeronav_msgs::scan::BEAMS_MAX;

/// [m] by which the free way may be longer than the way along the path before it counts.
const DEAD_END_M: f32 = 0.3;

/// [m/s] below which being hit is not the robot's doing.
const STANDING_MPS: f64 = 0.05;

/// What `dwa_t` has besides the dynamic window.
#[derive(Debug, Clone)]
pub(super) struct Timed {
    pub(super) config: DwaTConfig,
    funnel: Funnel,
    fan: Fan,
    /// Points of the scan that belong to nothing that moves.
    stamped: Vec<Point2<f64>>,
    /// The row at hand.
    rated: Box<Rated>,
    /// The best twist of each speed with its worth, best first.
    pub(super) reserve: Vec<(f64, Twist)>,
}

impl Timed {
    pub(super) fn new(config: DwaTConfig) -> Self {
        Self {
            config,
            funnel: Funnel::default(),
            fan: Fan::default(),
            stamped: Vec::with_capacity(BEAMS_MAX),
            rated: Box::default(),
            reserve: Vec::with_capacity(LANES_MAX),
        }
    }

    /// The cost-to-go.
    pub(super) const fn funnel(&self) -> &Funnel {
        &self.funnel
    }

    /// The points of the scan that stand.
    pub(super) fn standing_points(
        &mut self,
        situation: &Situation<'_>,
        moving: &mut crate::moving::Moving,
    ) -> &[Point2<f64>] {
        moving.take(
            situation.obstacles,
            situation.obstacles_age_s,
            &situation.map_from_base,
            Growth::from(&self.config),
        );
        let points = situation.scan_points_in_base.iter();
        self.stamped.clear();
        self.stamped
            .extend(points.filter(|point| !moving.owns(**point)));
        &self.stamped
    }
}

impl Dwa {
    /// Takes in map and path for the cost-to-go.
    pub(super) fn guide(
        &mut self,
        situation: &Situation<'_>,
        map: Option<(MapView<'_>, u64)>,
        place: &Place,
        reach_m: f64,
    ) {
        let (Some(timed), Some((map, map_cells))) = (&mut self.timed, map) else {
            return;
        };
        let inputs = FunnelInputs {
            map,
            map_cells,
            path: situation.path,
            geometry: situation.path_geometry,
            place: *place,
            position: situation.map_from_base.point(),
            reach_m,
            // Narrower than that no stop is free, however the robot stands.
            inscribed_m: self.surroundings.footprint.inscribed_m + self.config.safety_margin_m,
            soft_m: self.config.soft_clearance_m,
        };
        timed.funnel.update(&self.tracker, &inputs);
    }

    /// [s] that rollouts are compared with the path and what stands: in the open as long as the
    /// weights are meant for, where there is no room around the robot `tight_s`. There ways bend
    /// within a metre, and a robot that wants one arc to fit them for longer goes at a crawl. Who is
    /// at a crawl already gets nowhere in `tight_s` and would find every motion as good as none.
    fn scored_s(&self, tight_s: f64, v_mps_max: f64) -> f64 {
        let soft_m = self.config.soft_clearance_m;
        let surroundings = &self.surroundings;
        let space_m = f64::from(surroundings.field.nearest_m(0.0, 0.0))
            - surroundings.footprint.circumscribed_m;
        let open = ((space_m - soft_m) / soft_m).clamp(0.0, 1.0);
        let open_s = PATH_HORIZON_S.max(tight_s);
        let creep_mps = CREEP_MPS.min(0.25 * v_mps_max);
        let creeping = !self.last.is_stopped() && self.last.v_mps.abs() < creep_mps;
        if creeping && self.mode == Mode::Follow {
            return open_s;
        }
        tight_s + open * (open_s - tight_s)
    }

    /// The best twist of the time-indexed window; the best of the other speeds go into the
    /// reserve.
    pub(super) fn best_timed(
        &mut self,
        timed: &mut Timed,
        situation: &Situation<'_>,
        place: &Place,
        window: &Window<'_>,
    ) -> Option<Twist> {
        let config = timed.config;
        let fan = &mut timed.fan;
        fan.prepare(window, config.speeds as usize, config.yaw_rates as usize);
        let steps = fan.steps;
        self.looked_at = u32::try_from(fan.len()).unwrap_or(u32::MAX);
        self.moving.tabulate(steps, window.step_s);
        fan.foresee(&self.moving, self.surroundings.footprint.circumscribed_m);
        let here = situation.map_from_base.point();
        let now = timed.funnel.at(here);
        // Beyond, only what moves counts.
        let scored_s = self.scored_s(config.scored_s, situation.robot.v_mps_max);
        let judged = steps_of(scored_s, window.step_s).clamp(1, steps) - 1;
        timed.reserve.clear();
        let lanes = fan.yaw_rates.len();
        for speed in 0..fan.speeds.len() {
            let v_mps = fan.speeds[speed];
            let ahead = narrow(self.path.ahead_m);
            let arcs = fan.arcs_m(speed);
            let scored = arcs.partition_point(|arc| *arc < ahead).min(judged);
            let looked = looked(fan, window, speed, scored);
            fan.drive(speed, &self.surroundings, window.soft_m, (scored, looked));
            let rated = &mut *timed.rated;
            settle(fan, window, speed, scored, rated);
            if rated.admissible == 0 {
                continue;
            }
            let padded = lanes.next_multiple_of(WIDTH);
            for (x, y, found) in [
                (&rated.x, &rated.y, &mut rated.then),
                (&rated.half_x, &rated.half_y, &mut rated.half),
            ] {
                self.path.project_all(&x[..padded], &y[..padded], found);
            }
            let terms = TimedWorth {
                worth: self.worth_at(situation, place, v_mps),
                v_mps,
                config,
            };
            rate(&terms, &fan.yaw_rates, rated);
            // Along the path, unless the free way from there is longer than that.
            let worth_of = |lane: usize| {
                let (x, y) = (f64::from(rated.x[lane]), f64::from(rated.y[lane]));
                let at = Point2::new(here.x + x, here.y + y);
                let nearer = timed.funnel.at(at).zip(now).map(|(then, now)| now - then);
                match nearer.filter(|nearer| *nearer < rated.then.along[lane] - DEAD_END_M) {
                    None => rated.worth[lane],
                    Some(nearer) => {
                        let outcome = Outcome {
                            progress_m: f64::from(nearer),
                            ..rated.outcome(lane)
                        };
                        terms.of(fan.yaw_rates[lane], &outcome, rated.badness[lane])
                    }
                }
            };
            // Which can only make it worth less: most are out of question once the most promising
            // one is known.
            let Some(first) = rated.most_promising(lanes) else {
                continue;
            };
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
            let twist = Twist::new(v_mps, fan.yaw_rates[best.1]);
            timed.reserve.push((best.0, twist));
        }
        timed.reserve.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (_, twist) = *timed.reserve.first()?;
        self.steered_radps = twist.w_radps;
        Some(twist)
    }
}

/// How many steps must be free of what stands for a row to be judged: the scored ones, and as many
/// as a stop needs. Whatever lies beyond neither [`settle`] nor the evaluation asks for.
fn looked(fan: &Fan, window: &Window<'_>, speed: usize, scored: usize) -> usize {
    let v = fan.speeds[speed];
    if v.abs() < TURNING_MPS {
        return fan.steps;
    }
    let needed_m = stop_distance_m(window.robot, v, window.reaction_s) + window.stop_margin_m;
    steps_to(fan, speed, needed_m).max((scored + 1).min(fan.steps))
}

/// Steps after which an arc has been driven, all of them at most.
fn steps_to(fan: &Fan, speed: usize, arc_m: f64) -> usize {
    let short = |arc: &f32| f64::from(*arc) < arc_m;
    (fan.arcs_m(speed).partition_point(short) + 1).min(fan.steps)
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

/// The step that a lane of [`Fan`] was marked with; `n` when it was not.
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

/// Takes in where the rollouts of a speed end: with the scored steps or before what stands, and
/// on which the robot can stop before what stands (`v^2 / 2a + v t_reaction + margin <= free arc`,
/// on the spot the same with angles) and before what comes.
#[allow(clippy::cast_precision_loss, reason = "at most 64 steps")]
fn settle(fan: &Fan, window: &Window<'_>, speed: usize, scored: usize, rated: &mut Rated) {
    let (v, steps, row) = (fan.speeds[speed], fan.steps, &fan.row);
    let needed_m = stop_distance_m(window.robot, v, window.reaction_s);
    let stands = steps_to(fan, speed, needed_m + window.stop_margin_m) as f32;
    let comes = if v.abs() < STANDING_MPS {
        0.0
    } else {
        steps_to(fan, speed, needed_m) as f32
    };
    rated.admissible = 0;
    for (lane, &w_radps) in fan.yaw_rates.iter().enumerate().take(LANES_MAX) {
        let stops = if v.abs() < TURNING_MPS {
            let free = steps_until(row.hit[lane], steps);
            let free_rad = free
                .checked_sub(1)
                .map_or(0.0, |last| f64::from(fan.turned_rad(last, lane)).abs());
            free == steps || stop_angle_rad(window.robot, w_radps, window.reaction_s) <= free_rad
        } else {
            row.hit[lane] >= stands && row.struck[lane] >= comes
        };
        rated.admissible |= u64::from(stops) << lane;
    }
    if rated.admissible == 0 {
        return;
    }
    (rated.x, rated.y) = (row.x[scored], row.y[scored]);
    (rated.half_x, rated.half_y) = (row.x[scored / 2], row.y[scored / 2]);
    (rated.cos, rated.sin) = (fan.cos[scored], fan.sin[scored]);
    rated.space = row.space;
    rated.badness.fill(0.0);
    for lane in 0..fan.yaw_rates.len() {
        if row.hit[lane] <= scored as f32 {
            let end = steps_until(row.hit[lane], steps).saturating_sub(1);
            (rated.x[lane], rated.y[lane]) = (row.x[end][lane], row.y[end][lane]);
            rated.half_x[lane] = row.x[end / 2][lane];
            rated.half_y[lane] = row.y[end / 2][lane];
            (rated.cos[lane], rated.sin[lane]) = (fan.cos[end][lane], fan.sin[end][lane]);
        }
        if row.struck[lane].is_finite() {
            rated.badness[lane] = badness(steps_until(row.struck[lane], steps), steps);
        }
    }
}
