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

pub(crate) mod critics;
pub mod options;
mod rollout_grid;
pub(crate) mod rows;
pub(crate) mod window;

use crate::pilot::Pilot;
use crate::pilot::perception::Tracks;
use crate::pilot::scene::{Choose, ControlOutput, Heading, Scene};
use critics::Critics;
use options::DwaConfig;
use rows::Rows;
use zeronav_motion::Twist;

/// The controller `dwa` at rest. The numbers must be within the ranges of [`DwaConfig`].
#[must_use]
pub fn dwa(config: DwaConfig) -> Pilot {
    Pilot::new(config, Tracks::Ignored, Box::new(DynamicWindow::default()))
}

/// Samples the window on a grid and takes the best admissible twist.
#[derive(Debug, Default)]
struct DynamicWindow {
    rows: Rows,
}

impl Choose for DynamicWindow {
    fn choose(&mut self, scene: &mut Scene<'_>) -> ControlOutput {
        match scene.heading() {
            Ok(heading) => {
                let best = self.best(scene, &heading);
                scene.steer_or_rest(best)
            }
            Err(turn) => turn,
        }
    }
}

impl DynamicWindow {
    /// The best admissible twist of the window.
    fn best(&mut self, scene: &mut Scene<'_>, heading: &Heading) -> Option<Twist> {
        let (window, config) = (scene.window(heading), scene.config);
        let mut record = scene.memory.record.take();
        let rows = &mut self.rows;
        rows.prepare(&window, scene, (config.speeds, config.yaw_rates));
        let last = rows.grid.steps - 1;
        let mut best: Option<(f64, Twist)> = None;
        let mut critics = Critics::default();
        for speed in 0..rows.grid.speeds.len() {
            let terms = scene.worth_at(rows.grid.speeds[speed]);
            let found = rows.rate(scene, &window, (speed, last), &terms);
            if let Some(record) = &mut record {
                rows.tell(record, speed, |lane| rows.rated.worth[lane]);
            }
            if let Some(lane) = found {
                let (v_mps, worth) = (rows.grid.speeds[speed], rows.rated.worth[lane]);
                critics.offer(v_mps, rows.terms(&terms, lane));
                if best.is_none_or(|(most, _)| worth > most) {
                    best = Some((worth, rows.twist(speed, lane)));
                    if let Some(record) = &mut record {
                        rows.lead(record, (speed, lane), worth);
                    }
                }
            }
        }
        scene.memory.record = record;
        scene.memory.limit.slower = critics.decisive();
        best.map(|(_, twist)| twist)
    }
}
