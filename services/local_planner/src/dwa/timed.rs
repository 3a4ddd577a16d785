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
use super::{Dwa, Mode, PATH_HORIZON_S};
use crate::config::DwaTConfig;
use crate::controller::Situation;
use crate::fan::{Fan, LANES_MAX};
use crate::funnel::{Funnel, FunnelInputs};
use crate::local_path::Projection;
use crate::motion::{Twist, stop_angle_rad, stop_distance_m};
use crate::moving::Growth;
use crate::progress::Place;
use crate::rollout::{Outcome, TURNING_MPS, cost_beside};
use crate::surroundings::narrow;
use crate::window::Window;
use nalgebra::Point2;
use zeronav_msgs::scan::BEAMS_MAX;

/// [m] by which the free way may be longer than the way along the path before it counts.
const DEAD_END_M: f32 = 0.3;

/// [m/s] below which being hit is not the robot's doing.
const STANDING_MPS: f64 = 0.05;

/// No place yet.
const PLACE: Projection = Projection {
    along: 0.0,
    beside: 0.0,
    direction: (0.0, 0.0),
};

/// What `dwa_t` has besides the dynamic window.
#[derive(Debug, Clone)]
pub(super) struct Timed {
    pub(super) config: DwaTConfig,
    funnel: Funnel,
    fan: Fan,
    /// Points of the scan that belong to nothing that moves.
    stamped: Vec<Point2<f64>>,
    /// Last step of every rollout of a row that is scored.
    ends: [usize; LANES_MAX],
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
            ends: [0; LANES_MAX],
            reserve: Vec::with_capacity(LANES_MAX),
        }
    }

    /// The cost-to-go.
    pub(super) const fn funnel(&self) -> &Funnel {
        &self.funnel
    }

    /// [m] how fast uncertainty grows.
    const fn growth(&self) -> Growth {
        Growth {
            sigmas: self.config.growth_sigmas,
            least_mps: self.config.growth_mps_min,
            most_m: self.config.growth_m_max,
        }
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
            self.growth(),
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
    pub(super) fn guide(&mut self, situation: &Situation<'_>, place: &Place, reach_m: f64) {
        let (Some(timed), Some(map)) = (&mut self.timed, situation.map) else {
            return;
        };
        let inputs = FunnelInputs {
            map,
            map_cells: situation.map_cells,
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
        let creeping = !self.last.is_standing() && self.last.v_mps.abs() < creep_mps;
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
        for speed in 0..fan.speeds.len() {
            let v_mps = fan.speeds[speed];
            let ahead = narrow(self.path.ahead_m);
            let arcs = fan.arcs_m(speed);
            let scored = arcs.partition_point(|arc| *arc < ahead).min(judged);
            let looked = looked(fan, window, speed, scored);
            fan.drive(speed, &self.surroundings, window.soft_m, (scored, looked));
            let lanes = fan.yaw_rates.len();
            for lane in 0..lanes {
                let free = steps_until(fan.row.hit[lane], steps);
                timed.ends[lane] = scored.min(free.saturating_sub(1));
            }
            let (mut then, mut half) = ([PLACE; LANES_MAX], [PLACE; LANES_MAX]);
            for (found, share) in [(&mut then, 1), (&mut half, 2)] {
                let (mut x, mut y) = ([0.0; LANES_MAX], [0.0; LANES_MAX]);
                for (lane, end) in timed.ends[..lanes].iter().enumerate() {
                    x[lane] = fan.row.x[end / share][lane];
                    y[lane] = fan.row.y[end / share][lane];
                }
                self.path.project_all(&x[..lanes], &y[..lanes], found);
            }
            let mut best: Option<(f64, Twist)> = None;
            for lane in 0..lanes {
                let w_radps = fan.yaw_rates[lane];
                let free = steps_until(fan.row.hit[lane], steps);
                let struck = steps_until(fan.row.struck[lane], steps);
                if !can_stop(fan, window, (speed, lane), free, struck) {
                    continue;
                }
                let end = timed.ends[lane];
                let (place_then, half) = (then[lane], half[lane]);
                let direction = place_then.direction;
                let heading = fan.heading(end, lane);
                let cos = heading.0 * direction.0 + heading.1 * direction.1;
                let pathless = direction == (0.0, 0.0);
                let mut outcome = Outcome {
                    progress_m: f64::from(place_then.along),
                    beside_m: 0.5
                        * f64::from(cost_beside(place_then.beside) + cost_beside(half.beside)),
                    heading: if pathless { 0.0 } else { 1.0 - f64::from(cos) },
                    margin_m: f64::from(fan.row.space[lane]),
                };
                let twist = Twist::new(v_mps, w_radps);
                let calm_mps = config.speed_base_mps + config.speed_gain_hz * outcome.margin_m;
                let worth_of = |outcome: &Outcome| {
                    self.worth(situation, place, twist, outcome)
                        - config.weight_speed * (v_mps - calm_mps).max(0.0)
                        - config.weight_moving * badness(struck, steps)
                };
                let mut worth = worth_of(&outcome);
                // The free way can only make it worth less.
                if best.is_some_and(|(most, _)| worth <= most) {
                    continue;
                }
                let (x, y) = (fan.row.x[end][lane], fan.row.y[end][lane]);
                let at = Point2::new(here.x + f64::from(x), here.y + f64::from(y));
                // Along the path, unless the free way from there is longer than that.
                let nearer = timed.funnel.at(at).zip(now).map(|(then, now)| now - then);
                if let Some(nearer) = nearer
                    && nearer < place_then.along - DEAD_END_M
                {
                    outcome.progress_m = f64::from(nearer);
                    worth = worth_of(&outcome);
                }
                if best.is_none_or(|(most, _)| worth > most) {
                    best = Some((worth, twist));
                }
            }
            timed.reserve.extend(best);
        }
        timed.reserve.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (_, twist) = *timed.reserve.first()?;
        self.steered_radps = twist.w_radps;
        Some(twist)
    }
}

/// How many steps must be free of what stands for a row to be judged: the scored ones, and as many
/// as a stop needs. Whatever lies beyond neither [`can_stop`] nor the evaluation asks for.
fn looked(fan: &Fan, window: &Window<'_>, speed: usize, scored: usize) -> usize {
    let v = fan.speeds[speed];
    if v.abs() < TURNING_MPS {
        return fan.steps;
    }
    let needed_m = stop_distance_m(window.robot, v, window.reaction_s) + window.stop_margin_m;
    let arcs = fan.arcs_m(speed);
    let stopped = arcs.partition_point(|arc| f64::from(*arc) < needed_m) + 1;
    stopped.max(scored + 1).min(fan.steps)
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
    if mark.is_finite() { mark as usize } else { n }
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

/// True when the robot can stop before what stands (`v^2 / 2a + v t_reaction + margin <= free
/// arc`, on the spot the same with angles) and before what comes.
fn can_stop(
    fan: &Fan,
    window: &Window<'_>,
    (speed, lane): (usize, usize),
    free: usize,
    struck: usize,
) -> bool {
    let (v, w) = (fan.speeds[speed], fan.yaw_rates[lane]);
    let n = fan.steps;
    if v.abs() < TURNING_MPS {
        let free_rad = match free.checked_sub(1) {
            Some(last) => f64::from(fan.turned_rad(last, lane)).abs(),
            None => 0.0,
        };
        return free == n || stop_angle_rad(window.robot, w, window.reaction_s) <= free_rad;
    }
    let arc_m = |free: usize| {
        free.checked_sub(1)
            .map_or(0.0, |last| f64::from(fan.arcs_m(speed)[last]))
    };
    let needed_m = stop_distance_m(window.robot, v, window.reaction_s);
    let stands = free == n || needed_m + window.stop_margin_m <= arc_m(free);
    let comes = struck == n || v.abs() < STANDING_MPS || needed_m <= arc_m(struck);
    stands && comes
}
