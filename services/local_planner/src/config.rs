//! What a user may set. Numbers of the robot are not here: they come with its description.

use crate::beam::WIDTH_MAX;
use crate::critics::CRITICS;
use crate::moving::Growth;
use serde::{Deserialize, Serialize};

/// Configuration of the local planner.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LocalPlannerConfig {
    /// Key of a row in [`crate::table::CONTROLLERS`].
    pub controller: String,
    /// For the controller `dwa`.
    pub dwa: DwaConfig,
    /// For the controller `dwa_t`, which takes the rest from `dwa`.
    pub dwa_t: DwaTConfig,
    /// For the controller `mppi`, which takes the rest from `dwa` and `dwa_t`.
    pub mppi: MppiConfig,
    /// For the controller `beam`, which takes the rest from `dwa` and `dwa_t`.
    pub beam: BeamConfig,
    /// How fast accelerations change.
    pub shaping: ShapingConfig,
    /// What is done when the robot does not get on.
    pub recovery: RecoveryConfig,
    /// For the controllers of the papers: obstacles are points, as printed, instead of areas.
    pub literal: bool,
    /// When a task has succeeded or failed.
    pub task: TaskConfig,
    /// When another path is asked for.
    pub requests: RequestConfig,
    /// How old inputs may be.
    pub staleness: StalenessConfig,
}

impl Default for LocalPlannerConfig {
    fn default() -> Self {
        Self {
            controller: "dwa_t".to_owned(),
            dwa: DwaConfig::default(),
            dwa_t: DwaTConfig::default(),
            mppi: MppiConfig::default(),
            beam: BeamConfig::default(),
            shaping: ShapingConfig::default(),
            recovery: RecoveryConfig::default(),
            literal: false,
            task: TaskConfig::default(),
            requests: RequestConfig::default(),
            staleness: StalenessConfig::default(),
        }
    }
}

/// Parameters of the dynamic window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DwaConfig {
    /// [s] length of a rollout; a robot that needs longer to stop gets longer ones.
    pub horizon_s: f64,
    /// [s] from pose to pose of a rollout.
    pub step_s: f64,
    /// [s] of acceleration that the sampled window spans. One control period would leave nothing
    /// to choose from; the published twist is the part of the way there that one period allows.
    pub window_s: f64,
    /// Speeds in the window, 2 to 64.
    pub speeds: u32,
    /// Yaw rates in the window, 3 to 256.
    pub yaw_rates: u32,
    /// [m] that must stay free around the footprint. Less leads through narrower gaps; there has to
    /// be a band beside the path's line to drive in.
    pub safety_margin_m: f64,
    /// [m] around the footprint in which nearness costs something.
    pub soft_clearance_m: f64,
    /// [m] that must stay free at the end of a stop along the arc.
    pub stop_margin_m: f64,
    /// [s] that pass before braking begins, at worst: transport, the guard, the drives.
    pub reaction_s: f64,
    /// [s] of acceleration by which the last command may lead the measured twist. Commands start
    /// from the last command, not from the measurement, so latency does not halve the
    /// acceleration; this bounds how far.
    pub command_lead_s: f64,
    /// [m] shortest look-ahead along the path.
    pub lookahead_m_min: f64,
    /// [s] of driving that the look-ahead spans.
    pub lookahead_s: f64,
    /// [m] by which a corner of the path may be cut or overrun; bounds the speed there.
    pub corner_deviation_m: f64,
    /// Share of `brake_mps2` used when slowing down in good order.
    pub comfort_share: f64,
    /// [rad] heading error above which the robot turns on the spot.
    pub turn_above_rad: f64,
    /// [rad] heading error above which a standing robot turns on the spot.
    pub turn_above_standing_rad: f64,
    /// [rad] heading error below which a turn on the spot ends.
    pub turn_until_rad: f64,
    /// [s] of standing blocked after which a robot that can drives backwards.
    pub back_up_after_s: f64,
    /// [m] driven backwards at most.
    pub back_up_m: f64,
    /// Weights of the evaluation.
    pub weights: DwaWeights,
}

/// Weights of the evaluation, in metres of progress.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DwaWeights {
    /// Of a metre of progress along the path.
    pub progress: f64,
    /// Of a metre beside the path, on average over the rollout.
    pub cross_track: f64,
    /// Of heading against the path at the end (1 - cos of the error).
    pub heading: f64,
    /// Of touching the safety margin at full speed.
    pub clearance: f64,
    /// Of full speed.
    pub speed: f64,
    /// Of changing the chosen yaw rate by its largest value.
    pub turn_change: f64,
}

/// What the time-indexed dynamic window has besides [`DwaConfig`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DwaTConfig {
    /// [s] length of a rollout; a robot that needs longer to stop gets longer ones.
    pub horizon_s: f64,
    /// [s] of a rollout that are compared with the path and what stands where there is no room
    /// around the robot; 1.5 s in the open. Later only what moves counts.
    pub scored_s: f64,
    /// Poses of a rollout, 5 to 64.
    pub steps: u32,
    /// Speeds in the window, 2 to 64.
    pub speeds: u32,
    /// Yaw rates in the window, 3 to 64; multiples of 8 cost least.
    pub yaw_rates: u32,
    /// Standard deviations of a predicted position that are added to the radius.
    pub growth_sigmas: f64,
    /// [m/s] by which a predicted radius grows at least; it never grows by less than a fifth of the
    /// obstacle's speed.
    pub growth_mps_min: f64,
    /// [m] by which a predicted radius grows at most.
    pub growth_m_max: f64,
    /// [m/s] that cost nothing however near obstacles are.
    pub speed_base_mps: f64,
    /// [1/s] speed that costs nothing for each metre of space around the outline.
    pub speed_gain_hz: f64,
    /// Of a metre per second beyond that.
    pub weight_speed: f64,
    /// Of touching a predicted obstacle at once; later ones count less.
    pub weight_moving: f64,
}

impl Default for DwaTConfig {
    fn default() -> Self {
        let growth = Growth::default();
        Self {
            horizon_s: 2.4,
            scored_s: 0.8,
            steps: 30,
            speeds: 20,
            yaw_rates: 40,
            growth_sigmas: growth.sigmas,
            growth_mps_min: growth.least_mps,
            growth_m_max: growth.most_m,
            speed_base_mps: 0.7,
            speed_gain_hz: 6.0,
            weight_speed: 1.0,
            weight_moving: 6.0,
        }
    }
}

impl Default for DwaConfig {
    fn default() -> Self {
        Self {
            horizon_s: 1.5,
            step_s: 0.1,
            window_s: 0.3,
            speeds: 20,
            yaw_rates: 41,
            safety_margin_m: 0.02,
            soft_clearance_m: 0.20,
            stop_margin_m: 0.05,
            reaction_s: 0.1,
            command_lead_s: 0.06,
            lookahead_m_min: 0.35,
            lookahead_s: 0.6,
            corner_deviation_m: 0.15,
            comfort_share: 0.7,
            turn_above_rad: 0.9,
            turn_above_standing_rad: 0.45,
            turn_until_rad: 0.15,
            back_up_after_s: 1.0,
            back_up_m: 0.3,
            weights: DwaWeights::default(),
        }
    }
}

impl Default for DwaWeights {
    fn default() -> Self {
        Self {
            progress: 1.0,
            cross_track: 3.0,
            heading: 0.4,
            clearance: 1.0,
            speed: 0.1,
            turn_change: 0.1,
        }
    }
}

/// Parameters of model predictive path integral control.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MppiConfig {
    /// Samples of a cycle, rounded up to a multiple of 40.
    pub samples: u32,
    /// Steps of a sample, 14 to 64.
    pub steps: u32,
    /// [s] of a step.
    pub step_s: f64,
    /// [m/s] standard deviation of a sample's speeds.
    pub speed_std_mps: f64,
    /// [rad/s] standard deviation of a sample's yaw rates.
    pub yaw_rate_std_radps: f64,
    /// [m] of progress by which a sample must be worse to count 1 / e of another.
    pub temperature_m: f64,
    /// [m/s] that cost nothing however near obstacles are.
    pub speed_base_mps: f64,
    /// [1/s] speed that costs nothing for each metre of space around the outline.
    pub speed_gain_hz: f64,
    /// Of the noise.
    pub seed: u64,
    /// Weights of the critics.
    pub critics: CriticWeights,
}

/// Weights of the critics in `src/critics`, in metres of progress; 0 = not asked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CriticWeights {
    /// Of touching what stands at once; later ones count less.
    pub obstacles: f64,
    /// Of touching the safety margin at full speed.
    pub clearance: f64,
    /// Of a metre per second beyond what the clearance allows.
    pub calm: f64,
    /// Of touching a predicted obstacle at once; later ones count less.
    pub moving: f64,
    /// Of a metre of path that is left at the end.
    pub path_follow: f64,
    /// Of a metre beside the path, on average.
    pub path_align: f64,
    /// Of heading against the path, on average (1 - cos of the error).
    pub path_angle: f64,
    /// Of a metre from the goal at the end, on the last metre.
    pub goal: f64,
    /// Of heading against the goal's yaw at the end (1 - cos), on the last half metre.
    pub goal_angle: f64,
    /// Of a metre driven backwards.
    pub prefer_forward: f64,
    /// Of changing the yaw rate by its largest value.
    pub smooth: f64,
}

impl Default for MppiConfig {
    fn default() -> Self {
        Self {
            samples: 2000,
            steps: 56,
            step_s: 0.05,
            speed_std_mps: 0.2,
            yaw_rate_std_radps: 0.5,
            temperature_m: 0.05,
            speed_base_mps: 0.5,
            speed_gain_hz: 6.0,
            seed: 1,
            critics: CriticWeights::default(),
        }
    }
}

impl Default for CriticWeights {
    fn default() -> Self {
        Self {
            obstacles: 8.0,
            clearance: 1.0,
            calm: 1.0,
            moving: 6.0,
            path_follow: 1.0,
            path_align: 3.0,
            path_angle: 0.4,
            goal: 0.5,
            goal_angle: 0.3,
            prefer_forward: 1.0,
            smooth: 0.2,
        }
    }
}

/// Parameters of the search in time, see [`crate::beam`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BeamConfig {
    /// Nodes that are kept of every layer, 1 to 1024.
    pub width: u32,
    /// Manoeuvres one after the other, 1 to 16.
    pub layers: u32,
    /// [s] length of a manoeuvre.
    pub manoeuvre_s: f64,
    /// [s] after which it is searched again, at most the length of a manoeuvre.
    pub replan_s: f64,
    /// [m] kept from predicted obstacles.
    pub margin_m: f64,
    /// [m] beyond that in which nearness costs something.
    pub near_m: f64,
    /// Of touching that at 0.8 m/s, against the time that passes.
    pub weight_near: f64,
    /// [s] for which predictions are relied on; what is predicted to be touched later costs.
    pub certain_s: f64,
}

impl BeamConfig {
    /// [s] from pose to pose that is looked at.
    #[allow(clippy::cast_precision_loss, reason = "a handful")]
    pub(crate) fn look_s(&self) -> f64 {
        self.manoeuvre_s / crate::beam::LOOKS as f64
    }
}

impl Default for BeamConfig {
    fn default() -> Self {
        Self {
            width: 60,
            layers: 8,
            manoeuvre_s: 0.4,
            replan_s: 0.2,
            margin_m: 0.05,
            near_m: 0.4,
            weight_near: 3.0,
            certain_s: 1.5,
        }
    }
}

/// How fast accelerations change; braking in an emergency is exempt.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ShapingConfig {
    /// [m/s^3]
    pub jerk_mps3: f64,
    /// [rad/s^3]
    pub jerk_radps3: f64,
}

impl Default for ShapingConfig {
    fn default() -> Self {
        Self {
            jerk_mps3: 300.0,
            jerk_radps3: 2000.0,
        }
    }
}

impl ShapingConfig {
    /// Accelerations may jump.
    pub const OFF: Self = Self {
        jerk_mps3: 1.0e6,
        jerk_radps3: 1.0e6,
    };
}

/// What is done when the robot does not get on, see [`crate::recovery`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecoveryConfig {
    /// False: the task waits until it is stuck, and the dynamic windows back up straight.
    pub enabled: bool,
    /// Also for the controllers of the papers, which have no such thing.
    pub for_papers: bool,
    /// [s] without an admissible motion after which something is done.
    pub patience_s: f64,
    /// [s] for another path to come.
    pub ask_s: f64,
    /// Paths that are asked for in a row before the robot moves out of the way.
    pub asks: u32,
    /// [s] for something that moves to pass.
    pub wait_s: f64,
    /// [m] driven back along the track.
    pub back_up_m: f64,
    /// [m/s] backwards.
    pub back_up_mps: f64,
    /// [rad] turned on the spot to look around.
    pub rotate_rad: f64,
    /// [s] that any of it may take.
    pub manoeuvre_s: f64,
    /// Manoeuvres and waits for one goal before the task is given up.
    pub attempts: u32,
}

impl Default for RecoveryConfig {
    fn default() -> Self {
        Self {
            enabled: true,
            for_papers: false,
            patience_s: 0.5,
            ask_s: 1.0,
            asks: 1,
            wait_s: 3.0,
            back_up_m: 0.4,
            back_up_mps: 0.2,
            rotate_rad: 1.6,
            manoeuvre_s: 6.0,
            attempts: 20,
        }
    }
}

/// When a task has succeeded or failed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TaskConfig {
    /// [s] of run time that a planning failure must last, with the robot standing, before the task
    /// fails by it; a goal that something moving stands on is waited for.
    pub failure_s: f64,
    /// The same for a goal that is blocked but was not before. [s]
    pub blocked_goal_s: f64,
    /// [m] that count as coming closer.
    pub progress_m: f64,
    /// [s] of run time without coming closer after which another path is asked for.
    pub no_progress_s: f64,
    /// [s] of run time without coming closer after which the task fails as stuck.
    pub stuck_s: f64,
    /// [m/s] below which the robot stands.
    pub standing_mps: f64,
}

impl Default for TaskConfig {
    fn default() -> Self {
        Self {
            failure_s: 1.0,
            blocked_goal_s: 10.0,
            progress_m: 0.1,
            no_progress_s: 10.0,
            stuck_s: 30.0,
            standing_mps: 0.02,
        }
    }
}

/// When another path is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RequestConfig {
    /// [s] of run time between two requests at least.
    pub every_s: f64,
    /// [m] beyond the braking distance within which a blocked path is reported.
    pub blocked_zone_m: f64,
    /// [s] of run time without an admissible motion after which the path counts as blocked.
    pub blocked_after_s: f64,
    /// [m] beside the path beyond which the robot is off it.
    pub off_path_m: f64,
}

impl Default for RequestConfig {
    fn default() -> Self {
        Self {
            every_s: 0.5,
            blocked_zone_m: 0.5,
            blocked_after_s: 0.3,
            off_path_m: 0.6,
        }
    }
}

/// How old inputs may be. Within the last part of an age the robot slows down, beyond it stops.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StalenessConfig {
    /// [s] of a scan since its capture.
    pub scan_age_s: f64,
    /// [s] of odometry since its capture.
    pub odometry_age_s: f64,
    /// [s] of the map since the scan that it is current as of.
    pub map_age_s: f64,
    /// [s] of the path since it was last confirmed.
    pub path_age_s: f64,
    /// Share of an age from which on the robot slows down, 0 to 1.
    pub slow_from: f64,
    /// Share of the speed that is left just before the age ends, 0 to 1.
    pub slow_to: f64,
}

impl Default for StalenessConfig {
    fn default() -> Self {
        Self {
            scan_age_s: 0.35,
            odometry_age_s: 0.1,
            map_age_s: 1.0,
            path_age_s: 1.5,
            slow_from: 0.7,
            slow_to: 0.3,
        }
    }
}

/// A number is outside its range.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{field} is {value}, it must be {least} to {most}")]
pub struct ConfigError {
    /// Name of the field.
    pub field: &'static str,
    /// Its value.
    pub value: f64,
    /// Smallest value accepted.
    pub least: f64,
    /// Largest value accepted.
    pub most: f64,
}

impl LocalPlannerConfig {
    /// Accepts numbers that the algorithms can live with. The key of the controller is checked by
    /// [`crate::table::controller`].
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), ConfigError> {
        let (dwa, weights) = (&self.dwa, &self.dwa.weights);
        let timed = &self.dwa_t;
        let mppi = &self.mppi;
        let beam = &self.beam;
        let half_turn = core::f64::consts::PI;
        let weights_of_critics = CRITICS
            .iter()
            .map(|row| (row.key, (row.weight)(&mppi.critics), 0.0, 1.0e3));
        for (field, value, least, most) in [
            ("dwa.horizon_s", dwa.horizon_s, 0.2, 10.0),
            ("dwa.step_s", dwa.step_s, 0.02, 0.5),
            ("dwa.window_s", dwa.window_s, 0.01, 5.0),
            ("dwa.speeds", f64::from(dwa.speeds), 2.0, 64.0),
            ("dwa.yaw_rates", f64::from(dwa.yaw_rates), 3.0, 256.0),
            ("dwa.safety_margin_m", dwa.safety_margin_m, 0.005, 1.0),
            ("dwa.soft_clearance_m", dwa.soft_clearance_m, 0.01, 2.0),
            ("dwa.stop_margin_m", dwa.stop_margin_m, 0.0, 2.0),
            ("dwa.reaction_s", dwa.reaction_s, 0.0, 1.0),
            ("dwa.command_lead_s", dwa.command_lead_s, 0.0, 1.0),
            ("dwa.lookahead_m_min", dwa.lookahead_m_min, 0.05, 5.0),
            ("dwa.lookahead_s", dwa.lookahead_s, 0.0, 5.0),
            ("dwa.corner_deviation_m", dwa.corner_deviation_m, 0.01, 2.0),
            ("dwa.comfort_share", dwa.comfort_share, 0.1, 1.0),
            ("dwa.turn_above_rad", dwa.turn_above_rad, 0.1, half_turn),
            (
                "dwa.turn_above_standing_rad",
                dwa.turn_above_standing_rad,
                0.05,
                dwa.turn_above_rad,
            ),
            (
                "dwa.turn_until_rad",
                dwa.turn_until_rad,
                0.01,
                0.9 * dwa.turn_above_standing_rad,
            ),
            ("dwa.back_up_after_s", dwa.back_up_after_s, 0.0, 60.0),
            ("dwa.back_up_m", dwa.back_up_m, 0.0, 5.0),
            ("dwa.weights.progress", weights.progress, 0.0, 1.0e3),
            ("dwa.weights.cross_track", weights.cross_track, 0.0, 1.0e3),
            ("dwa.weights.heading", weights.heading, 0.0, 1.0e3),
            ("dwa.weights.clearance", weights.clearance, 0.0, 1.0e3),
            ("dwa.weights.speed", weights.speed, 0.0, 1.0e3),
            ("dwa.weights.turn_change", weights.turn_change, 0.0, 1.0e3),
            ("dwa_t.horizon_s", timed.horizon_s, 0.2, 10.0),
            ("dwa_t.scored_s", timed.scored_s, 0.1, timed.horizon_s),
            ("dwa_t.steps", f64::from(timed.steps), 5.0, 64.0),
            ("dwa_t.speeds", f64::from(timed.speeds), 2.0, 64.0),
            ("dwa_t.yaw_rates", f64::from(timed.yaw_rates), 3.0, 64.0),
            ("dwa_t.growth_sigmas", timed.growth_sigmas, 0.0, 5.0),
            ("dwa_t.growth_mps_min", timed.growth_mps_min, 0.0, 2.0),
            ("dwa_t.growth_m_max", timed.growth_m_max, 0.0, 5.0),
            ("dwa_t.speed_base_mps", timed.speed_base_mps, 0.01, 100.0),
            ("dwa_t.speed_gain_hz", timed.speed_gain_hz, 0.0, 1.0e3),
            ("dwa_t.weight_speed", timed.weight_speed, 0.0, 1.0e3),
            ("dwa_t.weight_moving", timed.weight_moving, 0.0, 1.0e3),
            (
                "beam.width",
                f64::from(beam.width),
                1.0,
                f64::from(WIDTH_MAX),
            ),
            ("beam.layers", f64::from(beam.layers), 1.0, 16.0),
            ("beam.manoeuvre_s", beam.manoeuvre_s, 0.1, 1.0),
            ("beam.replan_s", beam.replan_s, 0.0, beam.manoeuvre_s),
            ("beam.margin_m", beam.margin_m, 0.0, 1.0),
            ("beam.near_m", beam.near_m, 0.01, 2.0),
            ("beam.weight_near", beam.weight_near, 0.0, 1.0e3),
            ("beam.certain_s", beam.certain_s, 0.0, 20.0),
            ("mppi.samples", f64::from(mppi.samples), 40.0, 20_000.0),
            ("mppi.steps", f64::from(mppi.steps), 14.0, 64.0),
            ("mppi.step_s", mppi.step_s, 0.02, 0.1),
            ("mppi.speed_std_mps", mppi.speed_std_mps, 0.001, 10.0),
            (
                "mppi.yaw_rate_std_radps",
                mppi.yaw_rate_std_radps,
                0.001,
                10.0,
            ),
            ("mppi.temperature_m", mppi.temperature_m, 0.001, 10.0),
            ("mppi.speed_base_mps", mppi.speed_base_mps, 0.01, 100.0),
            ("mppi.speed_gain_hz", mppi.speed_gain_hz, 0.0, 1.0e3),
        ]
        .into_iter()
        .chain(weights_of_critics)
        .chain(self.rules())
        {
            // Written so that NaN is refused.
            if !(value >= least && value <= most) {
                return Err(ConfigError {
                    field,
                    value,
                    least,
                    most,
                });
            }
        }
        Ok(())
    }

    /// Names, values and ranges of what is around the controllers.
    fn rules(&self) -> impl Iterator<Item = (&'static str, f64, f64, f64)> {
        let (task, requests, ages) = (&self.task, &self.requests, &self.staleness);
        let (shaping, recovery) = (&self.shaping, &self.recovery);
        let half_turn = core::f64::consts::PI;
        [
            ("shaping.jerk_mps3", shaping.jerk_mps3, 0.1, 1.0e6),
            ("shaping.jerk_radps3", shaping.jerk_radps3, 0.1, 1.0e6),
            ("recovery.patience_s", recovery.patience_s, 0.0, 60.0),
            ("recovery.ask_s", recovery.ask_s, 0.05, 60.0),
            ("recovery.asks", f64::from(recovery.asks), 1.0, 1.0e3),
            ("recovery.wait_s", recovery.wait_s, 0.05, 600.0),
            ("recovery.back_up_m", recovery.back_up_m, 0.0, 4.0),
            ("recovery.back_up_mps", recovery.back_up_mps, 0.01, 5.0),
            ("recovery.rotate_rad", recovery.rotate_rad, 0.0, half_turn),
            ("recovery.manoeuvre_s", recovery.manoeuvre_s, 0.1, 60.0),
            (
                "recovery.attempts",
                f64::from(recovery.attempts),
                1.0,
                1.0e4,
            ),
            ("task.failure_s", task.failure_s, 0.0, 600.0),
            ("task.blocked_goal_s", task.blocked_goal_s, 0.0, 600.0),
            ("task.progress_m", task.progress_m, 0.001, 10.0),
            ("task.no_progress_s", task.no_progress_s, 0.1, 3600.0),
            ("task.stuck_s", task.stuck_s, task.no_progress_s, 3600.0),
            ("task.standing_mps", task.standing_mps, 0.001, 1.0),
            ("requests.every_s", requests.every_s, 0.0, 60.0),
            (
                "requests.blocked_zone_m",
                requests.blocked_zone_m,
                0.0,
                100.0,
            ),
            (
                "requests.blocked_after_s",
                requests.blocked_after_s,
                0.0,
                60.0,
            ),
            ("requests.off_path_m", requests.off_path_m, 0.05, 100.0),
            ("staleness.scan_age_s", ages.scan_age_s, 0.01, 10.0),
            ("staleness.odometry_age_s", ages.odometry_age_s, 0.01, 10.0),
            ("staleness.map_age_s", ages.map_age_s, 0.01, 60.0),
            ("staleness.path_age_s", ages.path_age_s, 0.01, 60.0),
            ("staleness.slow_from", ages.slow_from, 0.0, 1.0),
            ("staleness.slow_to", ages.slow_to, 0.0, 1.0),
        ]
        .into_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_accepted_and_a_nan_is_not() {
        let mut config = LocalPlannerConfig::default();
        assert_eq!(config.check(), Ok(()));
        config.dwa.reaction_s = f64::NAN;
        assert_eq!(config.check().map_err(|e| e.field), Err("dwa.reaction_s"));
    }

    #[test]
    fn every_critic_s_weight_is_checked() {
        let mut config = LocalPlannerConfig::default();
        config.mppi.critics.smooth = -1.0;
        let field = config.check().map_err(|e| e.field);
        assert_eq!(field, Err("mppi.critics.smooth"));
    }

    #[test]
    fn ranges_depend_on_each_other() {
        let mut config = LocalPlannerConfig::default();
        config.task.stuck_s = 5.0;
        assert_eq!(config.check().map_err(|e| e.field), Err("task.stuck_s"));
    }
}
