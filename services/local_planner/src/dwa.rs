//! `dwa`: a dynamic window that follows a path.
//!
//! Source: Fox, Burgard, Thrun, "The Dynamic Window Approach to Collision Avoidance", IEEE
//! Robotics and Automation Magazine 4(1), 1997: sample the twists that the accelerations allow,
//! drop those from which the robot could not stop, take the best of the rest. The differences:
//!
//! - **Guidance is the path, not the goal's direction**: progress along it, distance from it and
//!   heading against it, all at places of the rollout. A robot that faces away from the path turns
//!   on the spot first; the speed is bounded ahead of corners and the goal.
//! - **The window is longer than a control period.** At 50 Hz one period allows a change of some
//!   2 cm/s, within which nothing can be told apart. The window spans
//!   [`DwaConfig::window_s`]; rollouts ramp to their target as the robot would; the published
//!   twist is the part of the way that this period allows ([`crate::pilot`]).

pub mod options;
pub(crate) mod rollouts;
pub(crate) mod window;

use crate::pilot::Pilot;
use crate::pilot::perception::Tracks;
use crate::pilot::scene::{Choose, Scene, Wish};
use options::DwaConfig;
use rollouts::Rollouts;
use window::Window;
use zeronav_motion::Twist;

/// The controller `dwa` at rest. The numbers must be within the ranges of [`DwaConfig`].
#[must_use]
pub fn dwa(config: DwaConfig) -> Pilot {
    Pilot::new(config, Tracks::Ignored, Box::new(DynamicWindow::default()))
}

/// Samples the window on a grid and takes the best admissible twist.
#[derive(Debug, Default)]
struct DynamicWindow {
    rollouts: Rollouts,
}

impl Choose for DynamicWindow {
    fn choose(&mut self, scene: &mut Scene<'_>) -> Wish {
        let heading = match scene.heading() {
            Ok(heading) => heading,
            Err(turn) => return turn,
        };
        let best = best(&mut self.rollouts, scene, &scene.window(&heading));
        scene.memory.rollouts = u32::try_from(self.rollouts.len()).unwrap_or(u32::MAX);
        scene.steer_or_rest(best)
    }
}

/// The best admissible twist of the window.
fn best(rollouts: &mut Rollouts, scene: &Scene<'_>, window: &Window<'_>) -> Option<Twist> {
    let config = scene.config;
    rollouts.prepare(window, config.speeds as usize, config.yaw_rates as usize);
    let mut best: Option<(f64, Twist)> = None;
    for (i, &v_mps) in rollouts.speeds.iter().enumerate() {
        let terms = scene.worth_at(v_mps);
        for (j, &w_radps) in rollouts.yaw_rates.iter().enumerate() {
            let seen = &*scene.seen;
            let outcome = rollouts.outcome(window, &seen.surroundings, &seen.path, i, j);
            if let Some(outcome) = outcome {
                let worth = terms.of(w_radps, &outcome);
                if best.is_none_or(|(most, _)| worth > most) {
                    best = Some((worth, Twist::new(v_mps, w_radps)));
                }
            }
        }
    }
    best.map(|(_, twist)| twist)
}
