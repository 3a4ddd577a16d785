//! What a period of the local planner results in.

use crate::explain::ages_ms;
use crate::recovery::Transition;
use crate::staleness::{Ageing, Ages, StaleInput};
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::request::PlanRequest;

/// What the local planner answers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs {
    /// For `control/velocity_request`, always.
    pub request: VelocityRequest,
    /// For `plan/request`, when another path is needed.
    pub plan_request: Option<PlanRequest>,
    /// The task's status changed: send [`LocalPlanner::status`].
    pub status_changed: bool,
    /// The input because of which the robot stops, if so.
    pub stale: Option<StaleInput>,
    /// The inputs because of which it slows down or stops.
    pub ageing: Ageing,
    /// What the recovery does instead from now on, and why.
    pub recovery: Option<Transition>,
    /// Motions looked at.
    pub rollouts: u32,
    /// [m] along the path to the first obstacle in sight.
    pub blocked_arc_m: Option<f64>,
    /// [m] beside the path; 0 without one.
    pub cross_track_m: f64,
}

impl Outputs {
    /// The idle output: a request to stand, with the ages of the inputs. It is no tick of the run, so
    /// the task is not judged by it: a successor that began its task at run time 0 would find the
    /// robot without progress since then.
    #[must_use]
    pub fn idle(ages: &Ages) -> Self {
        Self {
            request: VelocityRequest {
                validity: Validity::NoPath.code(),
                ages_ms: ages_ms(ages),
                ..VelocityRequest::default()
            },
            plan_request: None,
            status_changed: true,
            stale: None,
            ageing: Ageing::default(),
            recovery: None,
            rollouts: 0,
            blocked_arc_m: None,
            cross_track_m: 0.0,
        }
    }
}
