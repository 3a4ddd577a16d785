//! One decision per control period: pass on, clamp, slow down, or ramp to rest.

use crate::blindness::{Blindness, Look};
use crate::config::GuardConfig;
use crate::explain::explained;
use crate::in_flight::InFlight;
use crate::limits::Limits;
use crate::outline::Outline;
use crate::ramp::Ramp;
use crate::verdict::{Decider, Mover, Verdict};
use crate::view::View;
use crate::watch::{FrozenScan, OdometrySense, Order};
use crate::zones::{Held, ZoneRules};
use zeronav_casts::Cast;
use zeronav_motion::Twist;
use zeronav_msgs::command::{Intervention, Validity, VelocityCommand, VelocityRequest};
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::map::MapInfo;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::time::seconds;
use zeronav_msgs::{Pose, ZoneSet};

/// Share of beams that must say anything (a range or "no return"); a scan with fewer is a blind
/// sensor.
const VALID_SHARE_MIN: f64 = 0.1;

/// [rad] by which a scan's geometry may differ from the description's at its ends.
const GEOMETRY_RAD: f64 = 0.02;

/// A scan as the guard takes it in.
#[derive(Debug, Clone, Copy)]
pub struct ScanInput<'a> {
    /// Its fixed fields.
    pub scan: &'a Scan,
    /// Its ranges. [m]
    pub ranges: &'a [f32],
    /// Id of the message.
    pub id: u64,
    /// [ns] run time of its capture.
    pub run_ns: u64,
    /// [ns] since its capture.
    pub age_ns: u64,
    /// `odom_from_base` at its capture; `None` = odometry does not reach there yet.
    pub odom_from_base: Option<Pose>,
}

/// Odometry as the guard takes it in.
#[derive(Debug, Clone, Copy)]
pub struct OdometryInput<'a> {
    /// The message.
    pub odometry: &'a Odometry,
    /// Id of the message.
    pub id: u64,
    /// [ns] run time of its capture.
    pub run_ns: u64,
    /// [ns] since its capture.
    pub age_ns: u64,
}

/// What the guard knows in one control period. `None` = never received. Nothing here is believed
/// before the guard has checked it.
#[derive(Debug, Clone, Copy)]
pub struct GuardInputs<'a> {
    /// The robot, the home of the limits, and its footprint.
    pub robot: Option<(&'a Description, &'a [Corner])>,
    /// Newest request of the obeyed local planner and its age. [ns]
    pub request: Option<(VelocityRequest, u64)>,
    /// Newest scan.
    pub scan: Option<ScanInput<'a>>,
    /// Newest odometry.
    pub odometry: Option<OdometryInput<'a>>,
    /// [ns] since the tick of the previous decision: normally one control period, 0 for another
    /// answer within the same tick, and the time itself while odometry is late. Ramps advance by this
    /// much.
    pub period_ns: u64,
    /// The run is stopping.
    pub stopping: bool,
}

/// The guard. Remembers its last command, from which ramps start, and the last two scans.
#[derive(Debug, Clone)]
pub struct Guard {
    config: GuardConfig,
    last: Twist,
    /// The last command was a step of this ramp.
    ramp: Option<Ramp>,
    had_request: bool,
    view: View,
    scan_order: Order,
    odometry_order: Order,
    frozen_scan: FrozenScan,
    sense: OdometrySense,
    /// Id and run time of the newest scan in the view.
    seen: Option<(u64, u64)>,
    in_flight: InFlight,
    blindness: Blindness,
    /// Scans captured before this run time are of no use: odometry has jumped since. [ns]
    blind_before_ns: u64,
    described: Option<(Description, Limits, Outline)>,
    corners: Vec<Corner>,
    zones: ZoneRules,
    /// Zones were announced and have not come.
    lacks_zones: bool,
    /// Of this decision.
    decider: Decider,
}

impl Guard {
    /// A guard that has not seen a request yet; its commands are zero until then.
    #[must_use]
    pub fn new(config: GuardConfig) -> Self {
        Self {
            config,
            last: Twist::REST,
            ramp: None,
            had_request: false,
            view: View::default(),
            scan_order: Order::default(),
            odometry_order: Order::default(),
            frozen_scan: FrozenScan::default(),
            sense: OdometrySense::default(),
            seen: None,
            in_flight: InFlight::default(),
            blindness: Blindness::default(),
            blind_before_ns: 0,
            described: None,
            corners: Vec::new(),
            zones: ZoneRules::default(),
            lacks_zones: false,
            decider: None,
        }
    }

    /// Takes in the zones that hold from now on.
    pub fn take_zones(&mut self, set: &ZoneSet) {
        self.zones.set(set);
    }

    /// Takes in what the newest map says of itself: how it lies to odometry, whether mapping knows where the robot is on it,
    /// and the way out of a keepout zone.
    pub fn locate(&mut self, map: &MapInfo) {
        self.zones.locate(map);
    }

    /// Takes in whether zones were announced that have not come: then the robot stops.
    pub fn lacks_zones(&mut self, lacks: bool) {
        self.lacks_zones = lacks;
    }

    /// The command of this period: always finite and within the limits.
    ///
    /// Only a request that means [`Validity::Drive`] moves the robot; any other meaning, a stale,
    /// missing, frozen or malformed input (`RequestStale`, `ScanStale`, `OdometryStale`, in this
    /// order), a request that is no number (`Refused`) and the end of the run become
    /// [`Limits::towards_rest`]. A request whose way (obeyed for the reaction time, then braked) is
    /// not free is slowed down on its arc as far as needed (`Slowed`), and when no speed is slow
    /// enough the robot stops (`StoppedShort`); the same is done for zones (`ZoneSlowed`, `ZoneStopped`). Without a usable description the command is zero,
    /// because nothing bounds a ramp.
    pub fn decide(&mut self, inputs: &GuardInputs<'_>) -> VelocityCommand {
        self.decider = None;
        self.had_request |= inputs.request.is_some();
        self.take_in(inputs);
        let odometry_ns = inputs.odometry.as_ref().map(|input| input.run_ns);
        self.in_flight.begin(odometry_ns, inputs.period_ns);
        let limits = self.described.as_ref().map(|(_, limits, _)| *limits);
        let verdict = self.verdict(inputs);
        let (twist, validity, intervention) = match (verdict, limits) {
            (Verdict::Pass(twist, intervention), Some(_)) => (twist, Validity::Drive, intervention),
            (Verdict::Rest(validity, intervention), Some(limits)) => {
                let start = || Ramp::begin(self.soon(inputs), self.last, &limits);
                let mut ramp = self.ramp.unwrap_or_else(start);
                let twist = ramp.step(&limits, seconds(inputs.period_ns));
                self.ramp = Some(ramp);
                (twist, validity, intervention)
            }
            (Verdict::Pass(..), None) => (Twist::REST, Validity::Stale, Intervention::Refused),
            (Verdict::Rest(validity, intervention), None) => (Twist::REST, validity, intervention),
        };
        self.last = twist;
        self.in_flight.send(twist);
        if validity == Validity::Drive {
            self.ramp = None;
        } else if limits.is_none() {
            self.ramp = Some(Ramp::from(Twist::REST));
        }
        let command = VelocityCommand {
            v_mps: twist.v_mps,
            w_radps: twist.w_radps,
            validity: validity.code(),
            intervention: intervention.code(),
            ..VelocityCommand::default()
        };
        let description = self.described.as_ref().map(|(description, ..)| description);
        explained(command, self.decider, description)
    }

    /// Takes in robot, odometry and scan, as far as they are new. [`Self::decide`] does so, too: what has come before the
    /// request is out of its way.
    pub fn take_in(&mut self, inputs: &GuardInputs<'_>) {
        self.describe(inputs.robot);
        self.take_odometry(inputs);
        self.take_scan(inputs);
    }

    /// Takes in the robot; its outline is prepared again only when it changed.
    fn describe(&mut self, robot: Option<(&Description, &[Corner])>) {
        let Some((description, corners)) = robot else {
            self.described = None;
            return;
        };
        let known = self.described.as_ref().map(|(known, ..)| known);
        if known == Some(description) && self.corners == corners {
            return;
        }
        self.corners.clear();
        self.corners.extend_from_slice(corners);
        self.described = Limits::of(description)
            .filter(|_| description.check(corners).is_ok())
            .map(|limits| (*description, limits, Outline::new(description, corners)));
        self.zones.describe(description, corners);
    }

    fn take_odometry(&mut self, inputs: &GuardInputs<'_>) {
        let (Some(input), Some((_, limits, _))) = (&inputs.odometry, &self.described) else {
            return;
        };
        let fastest = (limits.v_mps_max.max(-limits.v_mps_min), limits.w_radps_max);
        if !self.odometry_order.take(input.id, input.run_ns) || input.odometry.check().is_err() {
            return;
        }
        let jumped = self.sense.take(input.odometry, input.run_ns, fastest);
        if jumped || !self.odometry_order.is_forward() {
            self.forget();
            self.zones.forget_pose();
            self.blind_before_ns = input.run_ns;
        }
    }

    fn take_scan(&mut self, inputs: &GuardInputs<'_>) {
        let Some(input) = inputs.scan.as_ref().filter(|_| self.described.is_some()) else {
            return;
        };
        let Some(odom_from_base) = input.odom_from_base else {
            return;
        };
        if !self.scan_order.take(input.id, input.run_ns) {
            return;
        }
        if !self.scan_order.is_forward() {
            self.forget();
        }
        let Some((description, _, outline)) = &self.described else {
            return;
        };
        if input.run_ns < self.blind_before_ns || !is_usable(input.scan, input.ranges, description)
        {
            return;
        }
        let odometry = inputs.odometry.map(|input| input.odometry);
        let twist = odometry.map_or(Twist::REST, Twist::measured);
        self.frozen_scan.take(input.ranges, &odom_from_base);
        let base_from_laser = description.base_from_laser.isometry();
        self.blindness.take(&Look {
            scan: input.scan,
            ranges: input.ranges,
            directions: self.view.directions(input.scan),
            odom_from_laser: odom_from_base.isometry() * base_from_laser,
            laser_yaw_rad: description.base_from_laser.yaw_rad,
        });
        let laser = (&description.base_from_laser, outline);
        let since_ns = |(_, seen_ns): (u64, u64)| input.run_ns.saturating_sub(seen_ns);
        if self
            .seen
            .is_none_or(|seen| seconds(since_ns(seen)) > self.config.scan_age_s)
        {
            self.view.trust_no_more();
        }
        self.view.take(
            input.scan,
            input.ranges,
            laser,
            &odom_from_base,
            (twist, input.run_ns),
        );
        self.seen = Some((input.id, input.run_ns));
    }

    /// What was seen is of no use any more.
    fn forget(&mut self) {
        self.view.clear();
        self.blindness.clear();
        self.seen = None;
    }

    fn verdict(&mut self, inputs: &GuardInputs<'_>) -> Verdict {
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
        let (Ok(()), Some(validity), true) = (
            request.check(),
            request.validity(),
            self.described.is_some(),
        ) else {
            return Verdict::Rest(Validity::Stale, Intervention::Refused);
        };
        if validity != Validity::Drive {
            return Verdict::Rest(validity, Intervention::None);
        }
        if self.lacks_zones {
            return Verdict::Rest(Validity::Stale, Intervention::ZonesMissing);
        }
        let asked = Twist {
            v_mps: request.v_mps,
            w_radps: request.w_radps,
        };
        if !self.valid_scan(inputs) || self.blindness.is_towards(asked) {
            return Verdict::Rest(Validity::Stale, Intervention::ScanStale);
        }
        let Some(odometry) = self.valid_odometry(inputs) else {
            return Verdict::Rest(Validity::Stale, Intervention::OdometryStale);
        };
        self.drive(asked, odometry)
    }

    /// What becomes of a motion that is asked for.
    fn drive(&mut self, asked: Twist, odometry: &Odometry) -> Verdict {
        let Some((description, limits, outline)) = &self.described else {
            return Verdict::Rest(Validity::Stale, Intervention::Refused);
        };
        let delay_s = seconds(description.actuation_delay_ns);
        let reaction_s = self.config.reaction_s + delay_s;
        let held = (self.zones).hold(asked, odometry, (description, limits), reaction_s);
        let (asked, by_zone) = match held {
            Held::Free(twist) => (twist, None),
            Held::Slowed(twist) => (twist, Some(Intervention::ZoneSlowed)),
            Held::Short(twist) => (twist, Some(Intervention::ZoneStopped)),
            Held::Stop => return Verdict::Rest(Validity::Blocked, Intervention::ZoneStopped),
        };
        let mover = Mover {
            config: &self.config,
            limits,
            outline,
            in_flight: &self.in_flight,
            delay_ns: description.actuation_delay_ns,
        };
        let (verdict, decider) = mover.judge(asked, odometry, &mut self.view);
        self.decider = decider;
        match (verdict, by_zone) {
            (Verdict::Pass(twist, Intervention::None | Intervention::Clamped), Some(by_zone)) => {
                Verdict::Pass(twist, by_zone)
            }
            _ => verdict,
        }
    }

    /// The twist of the robot when a command of now takes effect, as far as odometry can be believed.
    fn soon(&self, inputs: &GuardInputs<'_>) -> Option<Twist> {
        let odometry = self.valid_odometry(inputs)?;
        let (description, limits, _) = self.described.as_ref()?;
        let legs = self.in_flight.legs(description.actuation_delay_ns);
        Some(legs.fold(Twist::measured(odometry), |twist, leg| {
            leg.after(limits, twist)
        }))
    }

    /// True while there is a young, well-formed scan that is neither blind nor frozen.
    fn valid_scan(&self, inputs: &GuardInputs<'_>) -> bool {
        let (Some(input), Some((description, ..))) = (&inputs.scan, &self.described) else {
            return false;
        };
        let Some((seen_id, seen_ns)) = self.seen else {
            return false;
        };
        // While the newest one waits for its odometry, the one before is looked at.
        let behind_ns = if input.id == seen_id {
            0
        } else {
            input.run_ns.saturating_sub(seen_ns)
        };
        let age_ns = input.age_ns.saturating_add(behind_ns);
        seconds(age_ns) <= self.config.scan_age_s
            && is_usable(input.scan, input.ranges, description)
            && self.scan_order.is_forward()
            && !self.blindness.is_total()
            && !self
                .frozen_scan
                .is_frozen(self.config.frozen_m, self.config.frozen_rad)
    }

    /// Young, well-formed odometry that agrees with itself.
    fn valid_odometry<'a>(&self, inputs: &GuardInputs<'a>) -> Option<&'a Odometry> {
        let input = inputs.odometry.as_ref()?;
        let fine = seconds(input.age_ns) <= self.config.odometry_age_s
            && input.odometry.check().is_ok()
            && self.odometry_order.is_forward()
            && self.sense.frozen_s(input.run_ns) <= self.config.odometry_age_s;
        fine.then_some(input.odometry)
    }
}

/// True for a scan that describes its ranges, fits the robot's lidar and is not blind.
fn is_usable(scan: &Scan, ranges: &[f32], description: &Description) -> bool {
    let last = f64::from(scan.n_beams.saturating_sub(1));
    let first_off = f64::from(scan.angle_min_rad) - description.angle_min_rad;
    let step_off = f64::from(scan.angle_increment_rad) - description.angle_increment_rad;
    !ranges.is_empty()
        && scan.check(ranges).is_ok()
        && scan.n_beams == description.n_beams
        && first_off.abs() <= GEOMETRY_RAD
        && (first_off + last * step_off).abs() <= GEOMETRY_RAD
        && valid_share(ranges) >= VALID_SHARE_MIN
}

fn valid_share(ranges: &[f32]) -> f64 {
    let valid = ranges.iter().filter(|range| !range.is_nan()).count();
    valid.to_f64() / ranges.len().to_f64()
}
