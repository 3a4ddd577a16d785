//! How the robot really moved: its motion in time, what it touched, and when its guard stepped in.

use std::collections::BTreeMap;
use zeronav_msgs::Pose;
use zeronav_msgs::command::Intervention;
use zeronav_msgs::truth::{Truth, TruthObstacle};

/// Run time from moment to moment. [ns]
const STEP_NS: u64 = 100_000_000;

/// Moments that are kept at most: more than five hours.
const MOMENTS_MAX: usize = 200_000;

/// Contacts that are kept at most.
const CONTACTS_MAX: usize = 256;

/// Poses of scripted obstacles that are kept at most, of all together.
const OBSTACLE_POSES_MAX: usize = 500_000;

/// Interventions that are kept at most.
const INTERVENTIONS_MAX: usize = 100_000;

/// Where the robot was and how fast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Run time. [ns]
    pub run_ns: u64,
    /// True `map_from_base`.
    pub pose: Pose,
    /// True forward speed. [m/s]
    pub v_mps: f64,
    /// True yaw rate. [rad/s]
    pub w_radps: f64,
}

/// The begin of a contact.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// The end of its tick, when the robot has been stopped.
    pub at: Moment,
    /// Forward speed one tick before. [m/s]
    pub v_before_mps: f64,
    /// True when the robot moved.
    pub moving: bool,
    /// The scripted obstacles at that moment: index and `map_from_shape`.
    pub obstacles: Vec<(usize, Pose)>,
}

/// See the module's description.
#[derive(Debug, Default)]
pub struct Motion {
    /// Ten a second.
    pub moments: Vec<Moment>,
    /// Scripted obstacles by index: run time [ns] and `map_from_shape` when it appeared, and ten
    /// times a second where it had changed.
    pub obstacles: BTreeMap<usize, Vec<(u64, Pose)>>,
    /// Every begin of a contact.
    pub contacts: Vec<Contact>,
    /// Run time [ns] at which the guard began to step in, and why. As long as it does so for the
    /// same reason, it is the same intervention.
    pub interventions: Vec<(u64, Intervention)>,
    /// Contacts before the newest truth: moving, standing.
    counted: (u32, u32),
    v_before_mps: f64,
    guard: Option<Intervention>,
    obstacle_poses: usize,
}

impl Motion {
    /// Takes in the truth at a run time. [ns]
    pub fn truth(&mut self, run_ns: u64, truth: &Truth, obstacles: &[TruthObstacle]) {
        let now = Moment {
            run_ns,
            pose: truth.pose,
            v_mps: truth.v_mps,
            w_radps: truth.w_radps,
        };
        let due = |last: &Moment| run_ns >= last.run_ns + STEP_NS;
        let is_due = self.moments.last().is_none_or(due);
        if is_due && self.moments.len() < MOMENTS_MAX {
            self.moments.push(now);
        }
        for obstacle in obstacles {
            let poses = self.obstacles.entry(obstacle.index as usize).or_default();
            let changed = |(_, last): &(u64, Pose)| is_due && *last != obstacle.pose;
            if poses.last().is_none_or(changed) && self.obstacle_poses < OBSTACLE_POSES_MAX {
                poses.push((run_ns, obstacle.pose));
                self.obstacle_poses += 1;
            }
        }
        let (moving, standing) = (truth.contacts_moving, truth.contacts_standing);
        if (moving, standing) != self.counted && self.contacts.len() < CONTACTS_MAX {
            self.contacts.push(Contact {
                at: now,
                v_before_mps: self.v_before_mps,
                moving: moving > self.counted.0,
                obstacles: obstacles
                    .iter()
                    .map(|obstacle| (obstacle.index as usize, obstacle.pose))
                    .collect(),
            });
        }
        self.counted = (moving, standing);
        self.v_before_mps = truth.v_mps;
    }

    /// Takes in what the guard did to a request.
    pub fn command(&mut self, run_ns: u64, intervention: Option<Intervention>) {
        let begins = intervention != self.guard;
        self.guard = intervention;
        if let Some(why) = intervention
            && begins
            && why != Intervention::None
            && self.interventions.len() < INTERVENTIONS_MAX
        {
            self.interventions.push((run_ns, why));
        }
    }
}

/// Mean absolute jerk of the forward speed, from differences between moments; `None` for fewer
/// than three. [m/s^3]
///
/// The definition of common navigation benchmarks ("over-acceleration"): the speed is taken ten
/// times a second, so what happens within a tenth is not in it.
#[must_use]
pub fn jerk_mps3(moments: &[Moment]) -> Option<f64> {
    let (mut sum, mut duration_s) = (0.0, 0.0);
    for three in moments.windows(3) {
        let step_s =
            |from: &Moment, to: &Moment| zeronav_msgs::time::seconds(to.run_ns - from.run_ns);
        let (before_s, after_s) = (step_s(&three[0], &three[1]), step_s(&three[1], &three[2]));
        let a_before = (three[1].v_mps - three[0].v_mps) / before_s;
        let a_after = (three[2].v_mps - three[1].v_mps) / after_s;
        // |da / dt| dt: every difference counts for as long as it lasts.
        sum += (a_after - a_before).abs();
        duration_s += 0.5 * (before_s + after_s);
    }
    (duration_s > 0.0).then(|| sum / duration_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truth(v_mps: f64, moving: u32, standing: u32) -> Truth {
        Truth {
            v_mps,
            contacts_moving: moving,
            contacts_standing: standing,
            ..Truth::default()
        }
    }

    /// Fifty truths a second with the speed `v` at a time in seconds.
    fn driven(ticks: u32, v: impl Fn(f64) -> f64) -> Motion {
        let mut motion = Motion::default();
        for tick in 0..ticks {
            let speed = v(0.02 * f64::from(tick));
            motion.truth(u64::from(tick) * 20_000_000, &truth(speed, 0, 0), &[]);
        }
        motion
    }

    #[test]
    fn jerk_is_that_of_the_speed() {
        // v = t^2 / 2 has a = t and a jerk of 1; differences of a parabola are exact.
        let parabola = driven(200, |t| 0.5 * t * t);
        assert_eq!(parabola.moments.len(), 40);
        assert!((jerk_mps3(&parabola.moments).unwrap() - 1.0).abs() < 1e-9);
        let steady = driven(200, |t| 1.5 * t);
        assert!(jerk_mps3(&steady.moments).unwrap() < 1e-9);
        // Up to 1 m/s within a second and on: the acceleration changes once, by 1 m/s^2, in the
        // 3.9 s less the two halves at the ends: 1 / 3.8.
        let ramp = driven(200, |t| t.min(1.0));
        let jerk = jerk_mps3(&ramp.moments).unwrap();
        assert!((jerk - 1.0 / 3.8).abs() < 1e-9, "{jerk}");
        assert_eq!(jerk_mps3(&ramp.moments[..2]), None);
    }

    #[test]
    fn a_contact_is_noted_once_with_the_speed_before_it() {
        let mut motion = Motion::default();
        for (tick, (v_mps, moving, standing)) in
            [(0.8, 0, 0), (0.0, 1, 0), (0.0, 1, 0), (0.0, 1, 1)]
                .into_iter()
                .enumerate()
        {
            motion.truth(
                tick as u64 * 20_000_000,
                &truth(v_mps, moving, standing),
                &[],
            );
        }
        let seen: Vec<(u64, bool, f64)> = motion
            .contacts
            .iter()
            .map(|contact| (contact.at.run_ns, contact.moving, contact.v_before_mps))
            .collect();
        assert_eq!(seen, [(20_000_000, true, 0.8), (60_000_000, false, 0.0)]);
    }

    #[test]
    fn an_intervention_lasts_as_long_as_its_reason() {
        use Intervention::{None as Nothing, Slowed, StoppedShort};
        let mut motion = Motion::default();
        for (tick, why) in [Nothing, Slowed, Slowed, StoppedShort, Nothing, Slowed]
            .into_iter()
            .enumerate()
        {
            motion.command(tick as u64, Some(why));
        }
        let expected = [(1, Slowed), (3, StoppedShort), (5, Slowed)];
        assert_eq!(motion.interventions, expected);
    }
}
