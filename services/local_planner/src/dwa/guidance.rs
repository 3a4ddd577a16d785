//! Following the path: where to steer, how fast, and which twist of the window is best.

use super::Dwa;
use super::row::Worth;
use crate::controller::Situation;
use crate::dwa::options::DwaWeights;
use crate::progress::Place;
use crate::window::{Range, Window};
use nalgebra::Vector2;
use zeronav_motion::Twist;

/// [m/s] slowest speed asked for at a corner, and speed at which a robot that must turn steers.
pub(super) const CREEP_MPS: f64 = 0.12;

/// [m] of path that are left when rotation room no longer matters.
const FINAL_M: f64 = 0.5;

impl Dwa {
    /// The local goal in `base`. [m]
    pub(super) fn to_local_goal(
        &self,
        situation: &Situation<'_>,
        place: &Place,
        from: Twist,
    ) -> Vector2<f64> {
        // Beside the path it is approached at an angle, and a corner cut on the inside is left
        // forwards.
        let lookahead_m = self
            .config
            .lookahead_m_min
            .max(self.config.lookahead_s * from.v_mps.abs())
            + 1.5 * place.cross_track_m;
        let inscribed_m = self.surroundings.footprint.inscribed_m;
        let in_map = self
            .path
            .local_goal(&self.surroundings.field, inscribed_m, lookahead_m);
        let (sin, cos) = situation.map_from_base.yaw_rad.sin_cos();
        Vector2::new(
            cos * in_map.x + sin * in_map.y,
            cos * in_map.y - sin * in_map.x,
        )
    }

    /// [m/s] fastest speed that the goal, the corners ahead and the age of the inputs allow.
    pub(super) fn fastest_mps(
        &self,
        situation: &Situation<'_>,
        place: &Place,
        astray: bool,
    ) -> f64 {
        let (config, robot) = (&self.config, situation.robot);
        let decel_mps2 = config.comfort_share * robot.brake_mps2;
        let beside_m = (place.cross_track_m - situation.goal.tolerance_m).max(0.0);
        let goal_mps = (2.0 * decel_mps2 * (place.remaining_m + beside_m)).sqrt();
        let corner_mps = self.path.corner_speed_mps(
            config.corner_deviation_m,
            0.8 * robot.w_radps_max,
            decel_mps2,
            CREEP_MPS.min(robot.v_mps_max),
        );
        let astray_mps = if astray { CREEP_MPS } else { f64::INFINITY };
        (robot.v_mps_max * situation.speed_factor.clamp(0.0, 1.0))
            .min(goal_mps.max(0.03))
            .min(corner_mps)
            .min(astray_mps)
    }

    /// The best admissible twist of the window.
    pub(super) fn best(
        &mut self,
        situation: &Situation<'_>,
        place: &Place,
        from: Twist,
        fastest_mps: f64,
        to_goal: Vector2<f64>,
    ) -> Option<Twist> {
        let (config, robot) = (self.config, situation.robot);
        let (circumscribed_m, inscribed_m) = {
            let footprint = &self.surroundings.footprint;
            (footprint.circumscribed_m, footprint.inscribed_m)
        };
        let blocked = self.blocked_arc_m().is_some();
        let low = (from.v_mps - robot.brake_mps2 * config.window_s).max(0.0);
        let high = (from.v_mps + robot.a_mps2_max * config.window_s).min(fastest_mps);
        let about = robot.alpha_radps2_max * config.window_s;
        // Pure pursuit: the arc through the local goal has the curvature 2 y / l^2.
        let curvature = 2.0 * to_goal.y / to_goal.norm_squared().max(0.01);
        // Before an obstacle across the path there must be room to turn away from it.
        let rotation_room_m = if blocked && place.remaining_m > FINAL_M {
            circumscribed_m - inscribed_m
        } else {
            0.0
        };
        let window = Window {
            robot,
            from,
            speeds: Range {
                low,
                high: high.max(low),
            },
            yaw_rates: Range {
                low: (from.w_radps - about).max(-robot.w_radps_max),
                high: (from.w_radps + about).min(robot.w_radps_max),
            },
            preferred_radps: curvature * fastest_mps.clamp(low, high.max(low)),
            yaw_rad: situation.map_from_base.yaw_rad,
            step_s: config.step_s,
            horizon_s: self.horizon_s(situation),
            reaction_s: config.reaction_s,
            stop_margin_m: config.stop_margin_m + rotation_room_m,
            soft_m: config.soft_clearance_m,
        };
        if let Some(mut timed) = self.timed.take() {
            let best = self.best_timed(&mut timed, situation, place, &window);
            self.timed = Some(timed);
            return best;
        }
        self.rollouts
            .prepare(&window, config.speeds as usize, config.yaw_rates as usize);
        self.looked_at = u32::try_from(self.rollouts.len()).unwrap_or(u32::MAX);
        let mut best: Option<(f64, Twist)> = None;
        for (i, &v_mps) in self.rollouts.speeds.iter().enumerate() {
            let terms = self.worth_at(situation, place, v_mps);
            for (j, &w_radps) in self.rollouts.yaw_rates.iter().enumerate() {
                let outcome = self
                    .rollouts
                    .outcome(&window, &self.surroundings, &self.path, i, j);
                if let Some(outcome) = outcome {
                    let twist = Twist::new(v_mps, w_radps);
                    let worth = terms.of(w_radps, &outcome);
                    if best.is_none_or(|(most, _)| worth > most) {
                        best = Some((worth, twist));
                    }
                }
            }
        }
        let (_, twist) = best?;
        self.steered_radps = twist.w_radps;
        Some(twist)
    }

    /// What a rollout at a speed is worth besides what it leads to.
    pub(super) fn worth_at(&self, situation: &Situation<'_>, place: &Place, v_mps: f64) -> Worth {
        let (config, robot) = (&self.config, situation.robot);
        // A goal beside a wall must be reached: nearness costs less and less on the last metre.
        let clearance = config.weights.clearance * place.remaining_m.min(1.0);
        Worth {
            weights: DwaWeights {
                clearance,
                ..config.weights
            },
            speed: v_mps / robot.v_mps_max,
            steered_radps: self.steered_radps,
            w_radps_max: robot.w_radps_max,
            soft_m: config.soft_clearance_m,
            hard_m: config.safety_margin_m.min(0.9 * config.soft_clearance_m),
        }
    }
}
