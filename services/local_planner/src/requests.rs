//! When the current path does not serve: asking for another one, not too often.

use zeronav_msgs::request::{PlanRequest, RequestReason};
use zeronav_msgs::time::seconds;
use zeronav_params::parameters;

parameters! {
    /// When another path is requested.
    #[derive(Copy)]
    pub struct RequestConfig {
        /// Shortest run time between two requests.
        every_s: f64 = 0.5, [0.0, 60.0] "s";
        /// Distance from the path beyond which the robot is off it.
        off_path_m: f64 = 0.6, [0.05, 100.0] "m";
    }
}

/// [m] beyond the braking distance within which a blocked path is reported, so that another
/// path can come before the robot has to brake.
const BLOCKED_ZONE_M: f64 = 0.5;

/// [s] of run time without an admissible motion after which the path counts as blocked: three scans
/// at 10 Hz, so that one bad scan does not.
const BLOCKED_AFTER_S: f64 = 0.3;

/// What a request is decided by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RequestInputs {
    /// [ns] run time.
    pub run_ns: u64,
    /// Id of the path's geometry.
    pub geometry: u64,
    /// [m] along the path to the first obstacle in sight, by map and scan.
    pub blocked_arc_m: Option<f64>,
    /// [m] that the robot needs to stop.
    pub stop_distance_m: f64,
    /// No motion is admissible.
    pub blocked: bool,
    /// [m] of the robot from the path.
    pub cross_track_m: f64,
    /// The task's progress checker asks for another path.
    pub no_progress: bool,
    /// The recovery waits for one.
    pub wanted: bool,
}

/// Decides when to ask.
#[derive(Debug, Clone)]
pub struct PathRequests {
    config: RequestConfig,
    asked_ns: Option<u64>,
    blocked_since_ns: Option<u64>,
    geometry: u64,
}

impl PathRequests {
    /// Nothing asked yet.
    #[must_use]
    pub const fn new(config: RequestConfig) -> Self {
        Self {
            config,
            asked_ns: None,
            blocked_since_ns: None,
            geometry: 0,
        }
    }

    /// The request of this period, if any; at most one per [`RequestConfig::every_s`].
    ///
    /// Reasons in this order: an obstacle on the path within braking distance plus 0.5 m, or no
    /// admissible motion for 0.3 s (the wait restarts with a new path); too far from the path; no
    /// progress.
    pub fn step(&mut self, inputs: &RequestInputs) -> Option<PlanRequest> {
        let since = |then_ns: u64| seconds(inputs.run_ns.saturating_sub(then_ns));
        if inputs.geometry != self.geometry {
            self.geometry = inputs.geometry;
            self.blocked_since_ns = None;
        }
        self.blocked_since_ns = match self.blocked_since_ns {
            _ if !inputs.blocked => None,
            None => Some(inputs.run_ns),
            since => since,
        };
        let zone_m = inputs.stop_distance_m + BLOCKED_ZONE_M;
        let cut = inputs.blocked_arc_m.is_some_and(|arc_m| arc_m <= zone_m);
        let waited = self
            .blocked_since_ns
            .is_some_and(|then| since(then) > BLOCKED_AFTER_S);
        let reason = if cut || waited || (inputs.wanted && inputs.blocked) {
            RequestReason::Blocked
        } else if inputs.cross_track_m > self.config.off_path_m {
            RequestReason::OffPath
        } else if inputs.no_progress || inputs.wanted {
            RequestReason::NoProgress
        } else {
            return None;
        };
        if self
            .asked_ns
            .is_some_and(|then| since(then) < self.config.every_s)
        {
            return None;
        }
        self.asked_ns = Some(inputs.run_ns);
        Some(PlanRequest {
            reason: reason.code(),
            spare: [0; 3],
            blocked_arc_m: inputs.blocked_arc_m.unwrap_or(0.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn fine(run_ns: u64) -> RequestInputs {
        RequestInputs {
            run_ns,
            geometry: 1,
            blocked_arc_m: None,
            stop_distance_m: 0.4,
            blocked: false,
            cross_track_m: 0.1,
            no_progress: false,
            wanted: false,
        }
    }

    fn reason(requests: &mut PathRequests, inputs: &RequestInputs) -> Option<RequestReason> {
        requests.step(inputs).and_then(|request| request.reason())
    }

    #[test]
    fn a_good_path_is_left_alone() {
        let mut requests = PathRequests::new(RequestConfig::default());
        for i in 0..100 {
            assert_eq!(requests.step(&fine(i * 20 * MS)), None);
        }
    }

    #[test]
    fn an_obstacle_counts_within_the_braking_zone() {
        let mut requests = PathRequests::new(RequestConfig::default());
        let at = |arc_m| RequestInputs {
            blocked_arc_m: Some(arc_m),
            ..fine(0)
        };
        assert_eq!(requests.step(&at(1.0)), None);
        let request = requests.step(&at(0.8)).expect("within 0.9 m");
        assert_eq!(request.reason(), Some(RequestReason::Blocked));
        assert!((request.blocked_arc_m - 0.8).abs() < 1e-12);
    }

    #[test]
    fn requests_keep_their_distance() {
        let mut requests = PathRequests::new(RequestConfig::default());
        let asked = (0..100)
            .filter(|i| {
                let inputs = RequestInputs {
                    cross_track_m: 0.7,
                    ..fine(i * 20 * MS)
                };
                reason(&mut requests, &inputs) == Some(RequestReason::OffPath)
            })
            .count();
        assert_eq!(asked, 4, "two seconds");
    }

    #[test]
    fn standing_blocked_waits_and_a_new_path_starts_the_wait_anew() {
        let mut requests = PathRequests::new(RequestConfig::default());
        let blocked = |ms, geometry| RequestInputs {
            blocked: true,
            geometry,
            ..fine(ms * MS)
        };
        assert_eq!(requests.step(&blocked(0, 1)), None);
        assert_eq!(requests.step(&blocked(280, 1)), None);
        assert_eq!(requests.step(&blocked(300, 2)), None);
        assert_eq!(requests.step(&blocked(580, 2)), None);
        let found = reason(&mut requests, &blocked(620, 2));
        assert_eq!(found, Some(RequestReason::Blocked));
    }

    #[test]
    fn a_recovery_that_waits_for_a_path_gets_its_request_at_once() {
        let mut requests = PathRequests::new(RequestConfig::default());
        let blocked = RequestInputs {
            wanted: true,
            blocked: true,
            ..fine(0)
        };
        assert_eq!(
            reason(&mut requests, &blocked),
            Some(RequestReason::Blocked)
        );
        let stalled = RequestInputs {
            wanted: true,
            ..fine(600 * MS)
        };
        let found = reason(&mut requests, &stalled);
        assert_eq!(found, Some(RequestReason::NoProgress));
    }

    #[test]
    fn no_progress_asks() {
        let mut requests = PathRequests::new(RequestConfig::default());
        let inputs = RequestInputs {
            no_progress: true,
            ..fine(0)
        };
        assert_eq!(
            reason(&mut requests, &inputs),
            Some(RequestReason::NoProgress)
        );
    }
}
