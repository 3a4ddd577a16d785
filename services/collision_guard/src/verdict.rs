//! What becomes of a request that means motion: how fast the robot may go on the arc asked for.

use crate::config::GuardConfig;
use crate::explain::decider;
use crate::in_flight::InFlight;
use crate::limits::Limits;
use crate::outline::Outline;
use crate::sweep::{Leg, Space, Walked};
use crate::swept::Swept;
use crate::view::View;
use nalgebra::Vector2;
use zeronav_motion::Twist;
use zeronav_msgs::command::{Intervention, Validity};
use zeronav_msgs::odometry::Odometry;

/// [s] of acceleration by which the last command may be ahead of the measured twist when a ramp
/// begins there.
pub(crate) const LEAD_S: f64 = 0.06;

/// Shares of the reaction time after which braking may begin, and at which stops are looked at.
pub(crate) const STARTS: [f64; 3] = [1.0, 0.6, 0.25];

/// Halvings in the search for the fastest free speed on an arc.
const HALVINGS: u32 = 5;

/// What becomes of a request.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Verdict {
    /// Goes to the wheels.
    Pass(Twist, Intervention),
    /// A ramp from the last command to rest.
    Rest(Validity, Intervention),
}

/// Of a decision: the point that slowed or stopped the robot, in `base`, and its distance to the outline
/// on the way that was asked for. [m]
pub(crate) type Decider = Option<(Vector2<f64>, f64)>;

/// A robot that is asked to move.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mover<'a> {
    pub(crate) config: &'a GuardConfig,
    pub(crate) limits: &'a Limits,
    pub(crate) outline: &'a Outline,
    pub(crate) in_flight: &'a InFlight,
    /// [ns] from a command to its effect.
    pub(crate) delay_ns: u64,
}

impl Mover<'_> {
    /// The fastest twist on the arc asked for from which the robot can still stop, and what decided.
    pub(crate) fn judge(
        &self,
        asked: Twist,
        odometry: &Odometry,
        view: &mut View,
    ) -> (Verdict, Decider) {
        let (config, limits, outline) = (self.config, self.limits, self.outline);
        let clamped = limits.clamp(asked);
        let measured = Twist::measured(odometry);
        let enough_m = config.margin_m + config.slow_zone_m;
        let legs = || self.in_flight.legs(self.delay_ns);
        view.look(&odometry.pose, &self.swept((measured, clamped), enough_m));
        let space = Space::new(outline, &view.near, config.margin_m);
        // What is on its way to the wheels comes first, whatever is commanded now.
        let lead = space.lead(limits, Walked::none(measured, enough_m), legs(), enough_m);
        // Braking may begin with the next command or at the end of the reaction time, on another
        // curvature when the robot is still turning in: the stops must be free, those that reach
        // farthest first.
        let way = |twist: Twist| {
            STARTS
                .iter()
                .try_fold(f64::INFINITY, |least_m: f64, share| {
                    let reaction_s = share * config.reaction_s;
                    let here_m = space.way(limits, (lead?, twist), reaction_s, enough_m)?;
                    Some(least_m.min(here_m))
                })
        };
        // Near obstacles the robot may not be faster than this. It gets there on its arc: a yaw rate
        // for a speed that it does not have yet would lead it off the way that was looked at.
        let from = lead.map_or(measured, |lead| lead.twist);
        let slow = |twist: Twist, least_m: f64| {
            let speed_mps = outline.speed_mps(twist);
            let soon_mps = outline.speed_mps(from) - limits.brake_mps2 * LEAD_S;
            let most_mps = config.slow_mps.max(soon_mps);
            if least_m >= enough_m || speed_mps <= most_mps {
                return twist;
            }
            let slower = twist.scaled(most_mps / speed_mps);
            if way(slower).is_some() { slower } else { twist }
        };
        let verdict = if let Some(least_m) = way(clamped) {
            let slowed = slow(clamped, least_m);
            let intervention = if slowed != clamped {
                Intervention::Slowed
            } else if clamped != asked {
                Intervention::Clamped
            } else {
                Intervention::None
            };
            Verdict::Pass(slowed, intervention)
        } else {
            fastest_free(clamped, way).map_or(
                Verdict::Rest(Validity::Blocked, Intervention::StoppedShort),
                |(slower, least_m)| Verdict::Pass(slow(slower, least_m), Intervention::Slowed),
            )
        };
        let (Verdict::Pass(_, Intervention::Slowed) | Verdict::Rest(..)) = verdict else {
            return (verdict, None);
        };
        let nearest = STARTS.map(|share| {
            let own = [Leg::Obey(clamped, share * config.reaction_s), Leg::Brake];
            let walked = Walked::none(measured, enough_m);
            space.nearest_on_way(limits, walked, legs().chain(own), enough_m)
        });
        (verdict, decider(&nearest))
    }

    /// Where anything can matter on a way from one twist towards some share of another.
    fn swept(&self, (measured, clamped): (Twist, Twist), enough_m: f64) -> Swept {
        let lead_s: f64 = (self.in_flight.legs(self.delay_ns).map(Leg::lasts_s)).sum();
        let obeyed = self.in_flight.legs(self.delay_ns).filter_map(Leg::towards);
        let ends = [measured, clamped].into_iter().chain(obeyed);
        let reaction_s = lead_s + self.config.reaction_s;
        Swept::new(self.limits, self.outline, ends, reaction_s, enough_m)
    }
}

/// The fastest twist on the arc of `clamped` whose way is free, with the least distance there. [m]
pub(crate) fn fastest_free(
    clamped: Twist,
    way: impl Fn(Twist) -> Option<f64>,
) -> Option<(Twist, f64)> {
    let mut best = None;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let share = 0.5 * (low + high);
        let slower = clamped.scaled(share);
        if let Some(least_m) = way(slower) {
            best = Some((slower, least_m));
            low = share;
        } else {
            high = share;
        }
    }
    best
}
