//! Getting on where the outline has no room to turn: a manoeuvre of arcs ahead and back and of turns on
//! the spot, searched for with the true outline and then driven.
//!
//! The controllers choose among motions of a second or two and turn on the spot where that is free. A
//! robot with corners that stands beside a wall, in an aisle or before a bend has often neither. A
//! [`Manoeuvre`] stops the robot, searches for a way to a pose on the path from which the controller
//! gets on, or to the goal with its yaw (`search.rs`, some periods long), and drives it (`track.rs`). It
//! only wants twists: the pilot checks the stop from each as from every other command.

mod ends;
mod motions;
mod search;
mod space;
mod targets;
mod track;
mod view;

use crate::situation::Situation;
use core::f64::consts::PI;
use motions::Motion;
use search::{Progress, Search};
use targets::Target;
use track::{Step, Track, sees_behind};
pub(crate) use view::View;
use zeronav_casts::Cast;
use zeronav_motion::Twist;
use zeronav_msgs::Pose;
use zeronav_msgs::map::FLAG_UNKNOWN;
use zeronav_msgs::pose::wrap_angle;

/// [m] that the surroundings must reach when a search begins.
pub(crate) const SIGHT_M: f64 = space::HALF_M;

/// [m] within which two manoeuvres begin at the same place.
const SAME_PLACE_M: f64 = 0.8;

/// [s] after a search without a result before the next one in the same place.
const AGAIN_S: f64 = 5.0;

/// [m] from where a search has found nothing to another place.
const ELSEWHERE_M: f64 = 0.1;
const ELSEWHERE_RAD: f64 = 0.15;

/// [s] that a manoeuvre waits for its next piece to become free, for the pilot and for who checks its
/// commands; and [s] less with every pose of it that is passed: by steps of noise beside an obstacle it does not
/// get on.
const PATIENCE_S: f64 = 3.0;
const REGAINED_S: f64 = 0.5;

/// [m] kept besides the margin that every command is checked with: errors of following.
const SPARE_M: f64 = 0.004;

/// [m] the same after a manoeuvre that has not got on: the noise by which another scan sees less room.
const CAREFUL_M: f64 = 0.02;

/// [m] beyond its circle by which a robot backs where it sees nothing.
const UNSEEN_M: f64 = 0.15;

/// Share of the goal's tolerances within which a manoeuvre ends there.
const AIM: f64 = 0.6;

/// [m] by which any point of the outline moves from one checked pose of a turn to the next.
const TURN_SPACING_M: f64 = 0.03;

/// Motions of a manoeuvre that are expected; more need more memory.
const MOTIONS: usize = 256;

/// Of the twist wanted, what is tried in turn.
const SHARES: [f64; 3] = [1.0, 0.5, 0.2];

/// Why a manoeuvre is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    /// It has been driven.
    Done,
    /// There is none.
    NotFound,
    /// Its next piece does not become free, or the robot has left it.
    Blocked,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Stopping,
    /// From where the robot is to arrive: the goal.
    SearchingBack,
    Searching,
    Driving,
    Over(End),
}

/// Where and when a search has found nothing.
#[derive(Debug, Clone, Copy)]
struct Failure {
    odom_from_base: Pose,
    geometry: u64,
    at_s: f64,
}

/// A manoeuvre.
#[derive(Debug)]
pub(crate) struct Manoeuvre {
    phase: Phase,
    search: Search,
    track: Track,
    motions: Vec<(Motion, f64)>,
    /// The goal, where it is near, and whether it is to end there alone.
    goal: Option<Target>,
    is_for_goal: bool,
    /// Where the search began, and the geometry of the path that it was to get on to.
    begun: Pose,
    geometry: u64,
    /// Where the last ones began, and how many of them there.
    place: Pose,
    times: u32,
    failure: Option<Failure>,
    /// Of a goal and a path: whether the goal's yaw asks for an approach.
    approach: Option<((u64, u64), bool)>,
    /// Without getting on along the manoeuvre. [s]
    waited_s: f64,
    driven: usize,
    /// One has not got on here, though it was free as far as the search saw.
    careful: bool,
}

impl Manoeuvre {
    pub(crate) fn new() -> Self {
        Self {
            phase: Phase::Over(End::Done),
            search: Search::new(),
            track: Track::new(),
            motions: Vec::with_capacity(MOTIONS),
            goal: None,
            is_for_goal: false,
            begun: Pose::default(),
            geometry: 0,
            place: Pose::default(),
            times: 0,
            failure: None,
            approach: None,
            waited_s: 0.0,
            driven: 0,
            careful: false,
        }
    }

    /// True where one has not been searched for in vain just now.
    pub(crate) fn is_worth_a_search(
        &self,
        now_s: f64,
        geometry: u64,
        odom_from_base: &Pose,
    ) -> bool {
        self.failure.is_none_or(|failure| {
            let turned_rad = wrap_angle(failure.odom_from_base.yaw_rad - odom_from_base.yaw_rad);
            failure.geometry != geometry
                || now_s - failure.at_s > AGAIN_S
                || failure.odom_from_base.distance_m(odom_from_base) > ELSEWHERE_M
                || turned_rad.abs() > ELSEWHERE_RAD
        })
    }

    /// Begins one.
    pub(crate) fn begin(&mut self, odom_from_base: &Pose) {
        if self.place.distance_m(odom_from_base) < SAME_PLACE_M {
            self.times = self.times.saturating_add(1);
        } else {
            self.times = 0;
            self.place = *odom_from_base;
            self.careful = false;
        }
        self.phase = Phase::Stopping;
        self.waited_s = 0.0;
    }

    /// Why it is over, when it is.
    pub(crate) const fn end(&self) -> Option<End> {
        match self.phase {
            Phase::Over(end) => Some(end),
            _ => None,
        }
    }

    /// [m] that the surroundings of this period must reach.
    pub(crate) fn reach_m(&self) -> f64 {
        if self.phase == Phase::Stopping {
            SIGHT_M
        } else {
            0.0
        }
    }

    /// The twists of this period, best first; none to stand.
    pub(crate) fn step(
        &mut self,
        view: &View<'_>,
        now_s: f64,
    ) -> impl Iterator<Item = Twist> + Clone + use<> {
        let situation = view.situation;
        let twist = Twist::new(situation.v_mps, situation.w_radps);
        if self.phase == Phase::Stopping && twist.is_stopped() {
            self.phase = self.set_targets(view);
        }
        if matches!(self.phase, Phase::SearchingBack | Phase::Searching) {
            match self.search.advance(&view.near.footprint) {
                Progress::Searching => {}
                Progress::NotFound if self.phase == Phase::SearchingBack => {
                    self.search.targets.all.clear();
                    self.search.targets.all.extend(self.goal);
                    self.phase = self.search_on(view);
                }
                // A window is too short for a flat arc to lead away from a wall.
                Progress::NotFound if !self.search.find_room() => {
                    self.phase = Phase::Over(End::NotFound);
                }
                Progress::Found | Progress::NotFound => {
                    self.search.found(&mut self.motions);
                    self.track.take(&self.begun, &self.motions);
                    self.phase = Phase::Driving;
                }
            }
        }
        if self.phase == Phase::Over(End::NotFound) {
            self.careful = false;
            // No approach from here: on by the path, as near as that leads.
            self.approach = Some(((situation.goal.id, situation.path_geometry), false));
            self.failure = Some(Failure {
                odom_from_base: *view.odom_from_base,
                geometry: situation.path_geometry,
                at_s: now_s,
            });
        }
        let mut wanted = None;
        if self.phase == Phase::Driving && self.stands_on_another_path(view) {
            self.phase = Phase::Over(End::Done);
        }
        if self.phase == Phase::Driving {
            match self.track.step(situation.robot, view.odom_from_base, twist) {
                Step::Towards(twist) => wanted = Some(twist),
                Step::Done => self.phase = Phase::Over(End::Done),
                Step::Lost => self.phase = Phase::Over(End::Blocked),
            }
        }
        wanted
            .into_iter()
            .flat_map(|twist| SHARES.map(|share| twist.scaled(share)))
    }

    /// Takes in that a period of so many seconds is over. What does not get on, whoever holds the robot, is
    /// searched for again once, so that nothing swings beside what the robot stands at.
    pub(crate) fn note(&mut self, period_s: f64) {
        let driven = self.track.driven();
        let passed = driven.saturating_sub(core::mem::replace(&mut self.driven, driven));
        if self.phase != Phase::Driving {
            self.waited_s = 0.0;
            return;
        }
        self.waited_s = waited_s(self.waited_s, period_s, passed);
        if self.waited_s > PATIENCE_S {
            self.phase = if self.careful {
                Phase::Over(End::Blocked)
            } else {
                Phase::Stopping
            };
            (self.careful, self.waited_s) = (true, 0.0);
        }
    }

    /// Prepares the search from where the robot stands and says what it begins with.
    fn set_targets(&mut self, view: &View<'_>) -> Phase {
        self.begun = *view.odom_from_base;
        self.geometry = view.situation.path_geometry;
        self.fill(view);
        let Some(place) = view.tracker.place() else {
            return Phase::Over(End::NotFound);
        };
        self.search.targets.all.clear();
        self.add_goal(view, &place);
        let alone = view.is_at_goal() || self.needs_approach(view);
        if !alone {
            self.add_path(view, &place);
        }
        self.is_for_goal = alone;
        let targets = &mut self.search.targets.all;
        self.goal = targets.first().copied();
        let Some(goal) = self.goal.filter(|goal| alone && goal.tolerance_rad < PI) else {
            return self.search_on(view);
        };
        // Where the goal is, there is less room than where the robot comes from.
        targets.clear();
        targets.push(Target {
            pose: view.here(),
            tolerance_m: 0.0,
            tolerance_rad: 0.0,
            either_way: false,
            clearance_m: 0.0,
        });
        self.begin_search(view, (goal.pose, true));
        Phase::SearchingBack
    }

    /// Begins the search from where the robot stands towards the targets.
    fn search_on(&mut self, view: &View<'_>) -> Phase {
        if self.search.targets.all.is_empty() {
            return Phase::Over(End::NotFound);
        }
        self.begin_search(view, (view.here(), false));
        Phase::Searching
    }

    fn begin_search(&mut self, view: &View<'_>, from: (Pose, bool)) {
        let footprint = &view.near.footprint;
        self.search.targets.find_ways(&self.search.space, footprint);
        let spare_m = if self.careful { CAREFUL_M } else { SPARE_M };
        let margin_m = view.margin_m + spare_m;
        self.search.careful = self.careful;
        self.search
            .begin(view.situation.robot, footprint, from, margin_m);
    }

    fn fill(&mut self, view: &View<'_>) {
        let (situation, near) = (view.situation, view.near);
        self.search.space.fill(
            (&near.field, &near.footprint),
            situation.map_from_base.yaw_rad,
            (
                situation.scan_points_in_base,
                situation.past_hits_in_base,
                sees_behind(situation.robot),
            ),
            situation.robot.base_from_laser.point(),
        );
        let map = situation.map.filter(|_| !sees_behind(situation.robot));
        let Some(map) = map else {
            return self.search.space.see_all();
        };
        let here = situation.map_from_base.point();
        let own_m = near.footprint.circumscribed_m + UNSEEN_M;
        self.search.space.fill_unseen(own_m, |at| {
            let index = map
                .geometry
                .index_of(map.geometry.unbounded_cell_at(here + at));
            index.is_none_or(|index| map.cells[index].flags & FLAG_UNKNOWN != 0)
        });
    }

    /// Whether the goal's yaw asks for an approach; `None` when that is not decided yet for this goal and
    /// this path.
    pub(crate) fn wants_approach(&self, situation: &Situation<'_>) -> Option<bool> {
        let of = (situation.goal.id, situation.path_geometry);
        let decided = self.approach.filter(|(decided, _)| *decided == of);
        decided.map(|(_, wanted)| wanted)
    }

    /// Decides it from surroundings that reach as far as [`SIGHT_M`].
    pub(crate) fn decide_approach(&mut self, view: &View<'_>) -> bool {
        let situation = view.situation;
        self.fill(view);
        let wanted = self.needs_approach(view);
        self.approach = Some(((situation.goal.id, situation.path_geometry), wanted));
        wanted
    }

    /// True when the robot, arriving by the path, could not turn to the goal's yaw.
    fn needs_approach(&self, view: &View<'_>) -> bool {
        let (goal, footprint) = (view.situation.goal, &view.near.footprint);
        let at = view.relative_to_robot(&goal.pose);
        let Some(place) = view.tracker.place().filter(|_| view.may_approach()) else {
            return false;
        };
        let arrives = view.on_path(place.arc_m + place.remaining_m);
        let off_rad = wrap_angle(goal.pose.yaw_rad - arrives.yaw_rad);
        let is_free = |yaw_rad: f64| {
            let pose = Pose::new(at.x_m, at.y_m, yaw_rad);
            let (space, need_m) = (&self.search.space, view.margin_m);
            space.clearance_m(footprint, &pose, need_m, need_m) >= need_m
        };
        let turn_is_free = |angle_rad: f64| {
            let steps = (angle_rad.abs() * footprint.circumscribed_m / TURN_SPACING_M).ceil();
            let shares = core::iter::successors(Some(0.0), |step| Some(step + 1.0));
            shares
                .take_while(|step| *step <= steps)
                .all(|step| is_free(arrives.yaw_rad + angle_rad * step / steps.max(1.0)))
        };
        let other_rad = off_rad - (2.0 * PI).copysign(off_rad);
        off_rad.abs() > AIM * goal.yaw_tolerance_rad
            && is_free(goal.pose.yaw_rad)
            && !turn_is_free(off_rad)
            && !turn_is_free(other_rad)
    }
}

/// How long it has not got on after another period [s] in which so many poses were passed. [s]
fn waited_s(before_s: f64, period_s: f64, passed: usize) -> f64 {
    let regained_s = REGAINED_S * passed.to_f64();
    (before_s + period_s - regained_s).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_robot::robot;

    #[test]
    fn what_does_not_get_on_is_searched_for_again_once() {
        let mut manoeuvre = Manoeuvre::new();
        let ahead = Motion::arc(1.0, 0.0, 1.0, 0.3);
        manoeuvre.track.take(&Pose::default(), &[(ahead, 0.1)]);
        let waits = |manoeuvre: &mut Manoeuvre, periods: u32| {
            (0..periods).for_each(|_| manoeuvre.note(0.1));
            manoeuvre.phase
        };
        manoeuvre.phase = Phase::Driving;
        assert_eq!(waits(&mut manoeuvre, 29), Phase::Driving);
        // It gets on.
        let there = Pose::new(0.16, 0.0, 0.0);
        manoeuvre.track.step(&robot(), &there, Twist::REST);
        assert_eq!(waits(&mut manoeuvre, 29), Phase::Driving);
        assert!(!manoeuvre.careful);
        assert_eq!(waits(&mut manoeuvre, 3), Phase::Stopping);
        assert!(manoeuvre.careful);
        manoeuvre.phase = Phase::Driving;
        assert_eq!(waits(&mut manoeuvre, 32), Phase::Over(End::Blocked));
        // Here flat arcs again, elsewhere any.
        manoeuvre.begin(&Pose::new(0.2, 0.0, 0.0));
        assert!(manoeuvre.careful);
        manoeuvre.begin(&Pose::new(3.0, 0.0, 0.0));
        assert!(!manoeuvre.careful);
    }

    /// After how many periods of 20 ms it has waited too long when every `every`th passes a pose.
    fn given_up_after(every: u32) -> Option<u32> {
        let mut waited = 0.0;
        (1..=1500).find(|n| {
            waited = waited_s(waited, 0.02, usize::from(n % every == 0));
            waited > PATIENCE_S
        })
    }

    #[test]
    fn what_gets_on_by_steps_of_noise_alone_is_given_up() {
        let standing = given_up_after(2000).expect("given up");
        assert!((150..=151).contains(&standing), "{standing}");
        // 0.05 rad a second.
        let slow = given_up_after(50).expect("given up");
        assert!((250..350).contains(&slow), "{slow}");
        // As slow as an arc without clearance: 2 cm at 0.08 m/s.
        assert_eq!(given_up_after(12), None);
    }
}
