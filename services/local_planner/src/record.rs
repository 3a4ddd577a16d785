//! What a control period looked at, for `debug/rollouts`: kept only while it is asked for. Nothing is
//! decided by it.
//!
//! Choosers offer every rollout that they look at, and say which one they lead with. Of each outcome
//! a spread is kept whose size does not depend on how many are offered, and the cheapest. At the end
//! of the period the pilot tells which one it follows.

mod pool;

use crate::lanes::data::narrow;
use pool::{Pool, is_same};
use zeronav_casts::Cast;
use zeronav_motion::{Twist, reachable};
use zeronav_msgs::Pose;
use zeronav_msgs::description::Description;
use zeronav_msgs::message::COORDINATE_M_MAX;
use zeronav_msgs::rollouts::{
    ROLLOUT_COST_MAX, ROLLOUT_POINTS_MAX, ROLLOUTS_MAX, Rollout, RolloutOutcome, Rollouts,
};

/// Outcomes that may be offered, the gravest first, and how many rollouts of each are spread. With
/// the cheapest of each, the chosen one and one that could not be followed they fit into a message.
const POOLS: [(RolloutOutcome, usize); 4] = [
    (RolloutOutcome::NoStop, 10),
    (RolloutOutcome::MovingCollision, 10),
    (RolloutOutcome::Collision, 10),
    (RolloutOutcome::Costlier, 28),
];

/// Steps between two points of a motion that is drawn ahead.
const SUBSTEPS: u8 = 4;

/// A rollout as its chooser knows it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DrawnRollout {
    /// Towards which it goes at first. [m/s], [rad/s]
    pub(crate) twist: (f32, f32),
    /// Less is better; 0 = not rated.
    pub(crate) cost: f32,
    /// Why it is not chosen.
    pub(crate) outcome: RolloutOutcome,
    /// Steps that were looked at, or those until it touches something.
    pub(crate) steps: usize,
}

/// The rollouts of a period.
#[derive(Debug)]
pub(crate) struct Record {
    here: Pose,
    offered: u32,
    pools: [Pool; POOLS.len()],
    /// What the chooser goes for.
    lead: Option<Rollout>,
    /// The period goes on with a choice that was told before.
    held: bool,
    meta: Rollouts,
    /// The message, once the period is over.
    told: Vec<Rollout>,
}

impl Default for Record {
    fn default() -> Self {
        Self {
            here: Pose::default(),
            offered: 0,
            pools: POOLS.map(|(_, most)| Pool::new(most)),
            lead: None,
            held: false,
            meta: Rollouts::default(),
            told: Vec::with_capacity(ROLLOUTS_MAX),
        }
    }
}

impl Record {
    /// A period begins with the robot at this pose of the map, or all that was offered is void.
    pub(crate) fn begin(&mut self, map_from_base: Pose) {
        self.here = map_from_base;
        self.clear();
    }

    /// Nothing was looked at.
    pub(crate) fn clear(&mut self) {
        self.offered = 0;
        self.pools.iter_mut().for_each(Pool::clear);
        self.lead = None;
        self.held = false;
        self.told.clear();
    }

    /// Nothing is looked at, because an older choice goes on.
    pub(crate) fn hold(&mut self) {
        self.held = true;
    }

    /// A rollout that was looked at; `at` is its place at the end of a step, relative to the robot
    /// along the axes of the map. [m]
    pub(crate) fn offer(&mut self, seen: &DrawnRollout, at: impl Fn(usize) -> (f32, f32)) {
        let number = self.offered;
        self.offered = number.wrapping_add(1);
        let here = self.here;
        let pool = POOLS
            .iter()
            .position(|(outcome, _)| *outcome == seen.outcome);
        if let Some(pool) = pool {
            self.pools[pool].offer(number, seen.cost, || drawn(&here, seen, at));
        }
    }

    /// What the chooser goes for; the last one counts.
    pub(crate) fn lead(&mut self, seen: &DrawnRollout, at: impl Fn(usize) -> (f32, f32)) {
        self.lead = Some(drawn(&self.here, seen, at));
    }

    /// The period is over. `picked` is the twist that the pilot goes towards, `from` the one that it
    /// starts from; a motion that the chooser did not lead with is drawn ahead for `horizon_s`.
    pub(crate) fn end(
        &mut self,
        robot: &Description,
        (from, picked): (Twist, Option<Twist>),
        horizon_s: f64,
        looked_at: u32,
    ) {
        self.told.clear();
        if self.held {
            return;
        }
        let lead = self.lead.take();
        let is_followed = lead
            .zip(picked)
            .is_some_and(|(lead, picked)| (lead.v_mps, lead.w_radps) == pair(picked));
        if let Some(refused) = lead.filter(|_| !is_followed) {
            self.told.push(with(refused, RolloutOutcome::NoStop));
        }
        // A chooser offers what it leads with, too.
        let is_lead = |rollout: &&Rollout| lead.is_some_and(|lead| is_same(&lead, rollout));
        for pool in &self.pools {
            self.told.extend(pool.all().filter(|one| !is_lead(one)));
        }
        let here = self.here;
        let ahead = || picked.map(|picked| ahead(&here, robot, (from, picked), horizon_s));
        let chosen = lead.filter(|_| is_followed).or_else(ahead);
        let chosen = chosen.map(|chosen| with(chosen, RolloutOutcome::Chosen));
        self.told.extend(chosen);
        self.meta = Rollouts {
            n_rollouts: self.told.len() as u64,
            n_looked_at: u64::from(looked_at),
            map_from_base: self.here,
        };
    }

    /// The message of the period; `None` when there is nothing to tell.
    pub(crate) fn message(&self) -> Option<(Rollouts, &[Rollout])> {
        (!self.told.is_empty()).then_some((self.meta, &self.told[..]))
    }
}

fn with(rollout: Rollout, outcome: RolloutOutcome) -> Rollout {
    Rollout {
        outcome: outcome.code(),
        ..rollout
    }
}

fn pair(twist: Twist) -> (f32, f32) {
    (narrow(twist.v_mps), narrow(twist.w_radps))
}

/// The rollout as a message has it: the robot's place, then places as evenly spread over its steps as
/// there is room for.
fn drawn(here: &Pose, seen: &DrawnRollout, at: impl Fn(usize) -> (f32, f32)) -> Rollout {
    let steps = seen.steps.min(ROLLOUT_POINTS_MAX - 1);
    let limit = narrow(ROLLOUT_COST_MAX);
    let cost = seen.cost.clamp(-limit, limit);
    let mut rollout = Rollout {
        v_mps: seen.twist.0,
        w_radps: seen.twist.1,
        cost: if cost.is_nan() { 0.0 } else { cost },
        outcome: seen.outcome.code(),
        ..Rollout::default()
    };
    mark(&mut rollout, here.x_m, here.y_m);
    for point in 1..=steps {
        let (x, y) = at((point * seen.steps).div_ceil(steps) - 1);
        mark(
            &mut rollout,
            here.x_m + f64::from(x),
            here.y_m + f64::from(y),
        );
    }
    rollout
}

/// Adds a point of the map. [m]
fn mark(rollout: &mut Rollout, x_m: f64, y_m: f64) {
    let at = usize::from(rollout.n_points);
    let inside = |along_m: f64| narrow(along_m.clamp(-COORDINATE_M_MAX, COORDINATE_M_MAX));
    rollout.x_m[at] = inside(x_m);
    rollout.y_m[at] = inside(y_m);
    rollout.n_points += 1;
}

/// Where the robot gets to that goes from one twist towards another within its accelerations.
fn ahead(
    here: &Pose,
    robot: &Description,
    (from, wanted): (Twist, Twist),
    horizon_s: f64,
) -> Rollout {
    let (v_mps, w_radps) = pair(wanted);
    let mut rollout = Rollout {
        v_mps,
        w_radps,
        ..Rollout::default()
    };
    mark(&mut rollout, here.x_m, here.y_m);
    let (mut pose, mut twist) = (*here, from);
    let points = (ROLLOUT_POINTS_MAX - 1).to_f64();
    let step_s = horizon_s / (points * f64::from(SUBSTEPS));
    while usize::from(rollout.n_points) < ROLLOUT_POINTS_MAX {
        for _ in 0..SUBSTEPS {
            let next = reachable(robot, twist, wanted, step_s);
            pose = pose.then(&twist.mean(next).arc(step_s));
            twist = next;
        }
        mark(&mut rollout, pose.x_m, pose.y_m);
    }
    rollout
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_robot::robot;

    fn seen(number: u16, outcome: RolloutOutcome) -> DrawnRollout {
        DrawnRollout {
            twist: (0.5, 0.001 * f32::from(number)),
            // The 700th costs least.
            cost: (f32::from(number) - 700.0).abs() - 3.0,
            outcome,
            steps: 30,
        }
    }

    fn offer(record: &mut Record, seen: &DrawnRollout) {
        let w = seen.twist.1;
        record.offer(seen, |step| (0.05 * (step + 1).to_f32(), w * step.to_f32()));
    }

    fn end(record: &mut Record, picked: Option<Twist>) -> Vec<Rollout> {
        record.end(&robot(), (Twist::new(0.5, 0.0), picked), 2.0, 800);
        let (meta, rollouts) = record.message().expect("rollouts");
        assert_eq!(meta.check(rollouts), Ok(()));
        assert_eq!(meta.n_looked_at, 800);
        rollouts.to_vec()
    }

    fn of(rollouts: &[Rollout], outcome: RolloutOutcome) -> Vec<Rollout> {
        let all = rollouts.iter().copied();
        all.filter(|one| one.outcome() == Some(outcome)).collect()
    }

    #[test]
    fn of_thousands_a_spread_is_kept_with_the_cheapest_of_every_reason() {
        let mut record = Record::default();
        record.begin(Pose::new(3.0, -2.0, 0.4));
        for number in 0..2000 {
            for (outcome, _) in POOLS {
                offer(&mut record, &seen(number, outcome));
            }
        }
        let best = seen(700, RolloutOutcome::Costlier);
        record.lead(&best, |_| (0.1, 0.1));
        let rollouts = end(&mut record, Some(Twist::new(0.5, f64::from(best.twist.1))));
        assert!(
            (24..=ROLLOUTS_MAX).contains(&rollouts.len()),
            "{}",
            rollouts.len()
        );
        assert_eq!(of(&rollouts, RolloutOutcome::Chosen).len(), 1);
        for (outcome, most) in POOLS {
            let these = of(&rollouts, outcome);
            assert!(these.len() + 1 >= most / 2, "{} {outcome}", these.len());
            let least = these
                .iter()
                .map(|one| one.cost)
                .fold(f32::INFINITY, f32::min);
            assert!((least + 3.0).abs() < 1e-6, "{outcome}: {least}");
            // From both ends of what was offered.
            let few = these.iter().filter(|one| one.w_radps < 1.0).count();
            assert!((1..these.len()).contains(&few), "{few} of {}", these.len());
        }
        for rollout in &rollouts {
            let first = rollout.points_m().next().expect("a point");
            assert!((first[0] - 3.0).abs() < 1e-6 && (first[1] + 2.0).abs() < 1e-6);
        }
        let long = of(&rollouts, RolloutOutcome::Costlier)[0];
        assert_eq!(long.points_m().count(), ROLLOUT_POINTS_MAX);
        let last = long.points_m().last().expect("a point");
        assert!(
            (last[0] - 4.5).abs() < 1e-5,
            "the end of 30 steps: {last:?}"
        );
    }

    #[test]
    fn what_the_pilot_could_not_follow_has_no_stop_and_its_own_choice_is_drawn_ahead() {
        let mut record = Record::default();
        record.begin(Pose::default());
        let lead = seen(5, RolloutOutcome::Costlier);
        offer(&mut record, &lead);
        record.lead(&lead, |_| (1.0, 0.0));
        let rollouts = end(&mut record, Some(Twist::new(0.25, 0.0)));
        let refused = of(&rollouts, RolloutOutcome::NoStop);
        assert_eq!(refused.len(), 1);
        assert!((refused[0].v_mps - 0.5).abs() < 1e-6);
        let [chosen] = of(&rollouts, RolloutOutcome::Chosen)[..] else {
            panic!("{rollouts:?}");
        };
        // Braking from 0.5 to 0.25 m/s takes an eighth of a second.
        let last = chosen.points_m().last().expect("a point");
        assert!(
            (last[0] - 0.5156).abs() < 0.01 && last[1].abs() < 1e-6,
            "{last:?}"
        );
        assert!((chosen.v_mps - 0.25).abs() < 1e-6);
        // At rest none is chosen.
        record.begin(Pose::default());
        offer(&mut record, &seen(1, RolloutOutcome::NoStop));
        let rollouts = end(&mut record, None);
        assert_eq!(
            (rollouts.len(), of(&rollouts, RolloutOutcome::Chosen).len()),
            (1, 0)
        );
    }

    #[test]
    fn a_period_that_holds_an_older_choice_tells_nothing() {
        let mut record = Record::default();
        record.begin(Pose::default());
        record.hold();
        record.end(&robot(), (Twist::REST, Some(Twist::REST)), 2.0, 1);
        assert_eq!(record.message(), None);
        record.begin(Pose::default());
        record.end(&robot(), (Twist::REST, Some(Twist::REST)), 2.0, 1);
        assert_eq!(record.message().map(|(_, all)| all.len()), Some(1));
    }
}
