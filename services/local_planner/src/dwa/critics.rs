//! Which critic decided against a faster motion, to explain it. Nothing is decided by it.

use crate::rollout_scores::Terms;
use zeronav_msgs::command::RequestCause;

/// The best motion of a speed.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    v_mps: f64,
    terms: Terms,
}

impl Candidate {
    /// The terms by critic. Speed and straightness explain no slower motion.
    fn by_critic(&self) -> [(RequestCause, f64); 5] {
        let terms = &self.terms;
        [
            (RequestCause::ClearanceCritic, terms.clearance + terms.calm),
            (RequestCause::DynamicObstacleCritic, terms.dynamic_obstacles),
            (RequestCause::PathCritic, terms.cross_track + terms.heading),
            (RequestCause::ProgressCritic, terms.progress),
            (RequestCause::SmoothnessCritic, terms.turn_change),
        ]
    }
}

/// The best motion of all, and the best of the fastest speed from which the robot can stop.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Critics {
    best: Option<Candidate>,
    fastest: Option<Candidate>,
}

impl Critics {
    /// Takes in the best motion of a speed; of equal ones the first is the best.
    pub(crate) fn offer(&mut self, v_mps: f64, terms: Terms) {
        let candidate = Candidate { v_mps, terms };
        let worth = terms.worth();
        if (self.best).is_none_or(|best| worth > best.terms.worth()) {
            self.best = Some(candidate);
        }
        if self.fastest.is_none_or(|fastest| v_mps > fastest.v_mps) {
            self.fastest = Some(candidate);
        }
    }

    /// The critic that weighed most for the best motion and against the fastest.
    pub(crate) fn decisive(&self) -> RequestCause {
        let Some((best, fastest)) = self.best.zip(self.fastest) else {
            return RequestCause::Critics;
        };
        if best.v_mps >= fastest.v_mps {
            return RequestCause::StoppingDistance;
        }
        let mut most = (RequestCause::Critics, 0.0);
        for ((critic, chosen), (_, faster)) in best.by_critic().iter().zip(fastest.by_critic()) {
            if chosen - faster > most.1 {
                most = (*critic, chosen - faster);
            }
        }
        most.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A term of an evaluation.
    type Term = fn(&mut Terms) -> &mut f64;

    fn decisive(candidates: &[(f64, Terms)]) -> RequestCause {
        let mut critics = Critics::default();
        for (v_mps, terms) in candidates {
            critics.offer(*v_mps, *terms);
        }
        critics.decisive()
    }

    #[test]
    fn the_critic_with_the_greatest_difference_to_the_fastest_motion_is_named() {
        let fast = Terms {
            progress: 1.0,
            speed: 0.5,
            cross_track: -1.2,
            clearance: -0.9,
            turn_change: -0.8,
            dynamic_obstacles: -0.7,
            ..Terms::default()
        };
        // A little better for everyone, much better for one.
        let slow = Terms {
            progress: 1.01,
            speed: 0.1,
            cross_track: -1.15,
            clearance: -0.85,
            turn_change: -0.75,
            dynamic_obstacles: -0.65,
            ..fast
        };
        let none = Terms {
            progress: -9.0,
            ..Terms::default()
        };
        let terms: [(Term, RequestCause); 7] = [
            (|terms| &mut terms.clearance, RequestCause::ClearanceCritic),
            (|terms| &mut terms.calm, RequestCause::ClearanceCritic),
            (|terms| &mut terms.cross_track, RequestCause::PathCritic),
            (|terms| &mut terms.heading, RequestCause::PathCritic),
            (|terms| &mut terms.progress, RequestCause::ProgressCritic),
            (
                |terms| &mut terms.turn_change,
                RequestCause::SmoothnessCritic,
            ),
            (
                |terms| &mut terms.dynamic_obstacles,
                RequestCause::DynamicObstacleCritic,
            ),
        ];
        for (term, expected) in terms {
            let mut slow = slow;
            *term(&mut slow) += 2.0;
            assert_eq!(decisive(&[(0.2, slow), (0.5, none), (0.8, fast)]), expected);
        }
    }

    #[test]
    fn without_a_faster_motion_no_critic_decided() {
        let better = Terms {
            progress: 0.1,
            ..Terms::default()
        };
        assert_eq!(
            decisive(&[(0.1, Terms::default()), (0.4, better)]),
            RequestCause::StoppingDistance
        );
        assert_eq!(decisive(&[]), RequestCause::Critics);
    }
}
