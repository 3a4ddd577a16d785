//! One decision per control period: pass on, clamp, or ramp to rest.

use crate::config::GuardConfig;
use crate::limits::{Limits, Twist};
use zeronav_msgs::command::{Intervention, Validity, VelocityCommand, VelocityRequest};
use zeronav_msgs::description::Description;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::scan::Scan;

/// Share of beams that must say anything (a range or "no return"); a scan with fewer is a blind
/// sensor.
const VALID_SHARE_MIN: f64 = 0.1;

/// What the guard knows in one control period. `None` = never received. Ages are those of
/// [`GuardConfig`]; nothing here is believed before the guard has checked it.
#[derive(Debug, Clone, Copy)]
pub struct GuardInputs<'a> {
    /// The robot, the home of the limits.
    pub description: Option<&'a Description>,
    /// Newest request of the obeyed local planner and its age. [ns]
    pub request: Option<(VelocityRequest, u64)>,
    /// Newest scan, its ranges and its age since capture. [ns]
    pub scan: Option<(&'a Scan, &'a [f32], u64)>,
    /// Newest odometry and its age since capture. [ns]
    pub odometry: Option<(&'a Odometry, u64)>,
    /// [ns] since the tick of the previous decision: normally one control period, 0 for another
    /// answer within the same tick. Ramps advance by this much.
    pub period_ns: u64,
    /// The run is stopping.
    pub stopping: bool,
}

/// What becomes of a request.
enum Verdict {
    /// Goes to the wheels.
    Pass(Twist, Intervention),
    /// A ramp from the last command to rest.
    Rest(Validity, Intervention),
}

/// The guard. Remembers its last command, from which ramps start.
#[derive(Debug, Clone)]
pub struct Guard {
    config: GuardConfig,
    last: Twist,
    had_request: bool,
}

impl Guard {
    /// A guard that has not seen a request yet; its commands are zero until then.
    #[must_use]
    pub const fn new(config: GuardConfig) -> Self {
        Self {
            config,
            last: Twist::REST,
            had_request: false,
        }
    }

    /// The command of this period: always finite and within the limits.
    ///
    /// Only a request that means [`Validity::Drive`] moves the robot; any other meaning, a stale
    /// or missing input (`RequestStale`, `ScanStale`, `OdometryStale`, in this order), a request
    /// that is no number (`Refused`) and the end of the run become [`Limits::towards_rest`].
    /// Without a usable description the command is zero, because nothing bounds a ramp.
    pub fn decide(&mut self, inputs: &GuardInputs<'_>) -> VelocityCommand {
        self.had_request |= inputs.request.is_some();
        let limits = inputs.description.and_then(Limits::of);
        let (twist, validity, intervention) = match (self.verdict(inputs, limits.as_ref()), limits)
        {
            (Verdict::Pass(twist, intervention), Some(_)) => (twist, Validity::Drive, intervention),
            (Verdict::Rest(validity, intervention), Some(limits)) => {
                let ramped = limits.towards_rest(self.last, seconds(inputs.period_ns));
                (limits.clamp(ramped), validity, intervention)
            }
            (Verdict::Pass(..), None) => (Twist::REST, Validity::Stale, Intervention::Refused),
            (Verdict::Rest(validity, intervention), None) => (Twist::REST, validity, intervention),
        };
        self.last = twist;
        VelocityCommand {
            v_mps: twist.v_mps,
            w_radps: twist.w_radps,
            validity: validity.code(),
            intervention: intervention.code(),
            spare: [0; 2],
        }
    }

    fn verdict(&self, inputs: &GuardInputs<'_>, limits: Option<&Limits>) -> Verdict {
        if inputs.stopping {
            return Verdict::Rest(Validity::Stopped, Intervention::None);
        }
        let Some((request, age_ns)) = &inputs.request else {
            return if self.had_request {
                Verdict::Rest(Validity::Stale, Intervention::RequestStale)
            } else {
                Verdict::Rest(Validity::NoRequest, Intervention::None)
            };
        };
        if seconds(*age_ns) > self.config.request_age_s {
            return Verdict::Rest(Validity::Stale, Intervention::RequestStale);
        }
        let (Ok(()), Some(validity), Some(limits)) = (request.check(), request.validity(), limits)
        else {
            return Verdict::Rest(Validity::Stale, Intervention::Refused);
        };
        if validity != Validity::Drive {
            return Verdict::Rest(validity, Intervention::None);
        }
        if !self.sees(inputs) {
            return Verdict::Rest(Validity::Stale, Intervention::ScanStale);
        }
        if !self.feels(inputs) {
            return Verdict::Rest(Validity::Stale, Intervention::OdometryStale);
        }
        let asked = Twist {
            v_mps: request.v_mps,
            w_radps: request.w_radps,
        };
        let clamped = limits.clamp(asked);
        let intervention = if clamped == asked {
            Intervention::None
        } else {
            Intervention::Clamped
        };
        Verdict::Pass(clamped, intervention)
    }

    /// True while a young, well-formed scan is at hand that is not blind.
    fn sees(&self, inputs: &GuardInputs<'_>) -> bool {
        inputs.scan.is_some_and(|(scan, ranges, age_ns)| {
            seconds(age_ns) <= self.config.scan_age_s
                && !ranges.is_empty()
                && scan.check(ranges).is_ok()
                && valid_share(ranges) >= VALID_SHARE_MIN
        })
    }

    /// True while young, well-formed odometry is at hand.
    fn feels(&self, inputs: &GuardInputs<'_>) -> bool {
        inputs.odometry.is_some_and(|(odometry, age_ns)| {
            seconds(age_ns) <= self.config.odometry_age_s && odometry.check().is_ok()
        })
    }
}

#[allow(clippy::cast_precision_loss, reason = "at most 4096 beams")]
fn valid_share(ranges: &[f32]) -> f64 {
    let valid = ranges.iter().filter(|range| !range.is_nan()).count();
    valid as f64 / ranges.len() as f64
}

#[allow(
    clippy::cast_precision_loss,
    reason = "ages are compared with tenths of seconds"
)]
fn seconds(ns: u64) -> f64 {
    ns as f64 * 1.0e-9
}
