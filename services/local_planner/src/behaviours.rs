//! What each behaviour of the recovery does in a period, and what the recovery is to know of it.

use crate::manoeuvre::{self, End, Manoeuvre};
use crate::pilot::Pilot;
use crate::progress::PathTracker;
use crate::recovery::escape::{Escape, has_room_to_turn, is_free_behind};
use crate::recovery::options::RecoveryConfig;
use crate::recovery::trail::Trail;
use crate::recovery::{Behaviour, Facts, Reason, Transition};
use crate::situation::{Decision, Situation};
use zeronav_msgs::Pose;
use zeronav_msgs::pose::wrap_angle;

/// [m] and [rad] from where a robot hardly moves, and [s] for which.
const STAYS_M: f64 = 0.1;
const STAYS_RAD: f64 = 0.2;
const STAYS_S: f64 = 3.0;

/// [m/s] below zero from which a robot drives backwards.
const BACKWARDS_MPS: f64 = -0.01;

/// A period.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment<'a> {
    pub(crate) situation: &'a Situation<'a>,
    pub(crate) odom_from_base: &'a Pose,
    pub(crate) tracker: &'a PathTracker,
    /// [s] run time.
    pub(crate) now_s: f64,
}

/// Where a robot that follows a path to a goal stays, and since when.
#[derive(Debug, Clone, Copy, Default)]
struct Stay {
    goal: u64,
    at: Pose,
    since_s: f64,
    last_s: f64,
}

impl Stay {
    /// True when it has stayed there for so long that it gets nowhere.
    fn lasts(&mut self, goal: u64, follows: bool, at: &Moment<'_>) -> bool {
        let pose = at.odom_from_base;
        let turned_rad = wrap_angle(pose.yaw_rad - self.at.yaw_rad);
        // Another goal, another behaviour, or periods without either.
        let is_new = goal != self.goal || !follows || at.now_s - self.last_s > STAYS_S;
        self.last_s = at.now_s;
        let moved = self.at.distance_m(pose) > STAYS_M || turned_rad.abs() > STAYS_RAD;
        if is_new || moved {
            (self.goal, self.at, self.since_s) = (goal, *pose, at.now_s);
        }
        at.now_s - self.since_s > STAYS_S
    }
}

/// The manoeuvres of the recovery.
#[derive(Debug)]
pub(crate) struct Behaviours {
    escape: Escape,
    trail: Trail,
    manoeuvre: Manoeuvre,
    stay: Stay,
    /// [m] that every command keeps free.
    margin_m: f64,
}

impl Behaviours {
    pub(crate) fn new(config: RecoveryConfig, margin_m: f64) -> Self {
        Self {
            escape: Escape::new(config),
            trail: Trail::new(),
            manoeuvre: Manoeuvre::new(),
            stay: Stay::default(),
            margin_m,
        }
    }

    /// Takes in where the robot is.
    pub(crate) fn note(&mut self, behaviour: Behaviour, odom_from_base: &Pose, v_mps: f64) {
        let backwards = match behaviour {
            Behaviour::BackUp => true,
            Behaviour::Manoeuvre => v_mps < BACKWARDS_MPS,
            _ => false,
        };
        if backwards {
            self.trail.retrace(odom_from_base);
        } else {
            self.trail.note(odom_from_base);
        }
    }

    /// The decision of the period: the pilot's, or that of a manoeuvre.
    pub(crate) fn decide(
        &mut self,
        behaviour: Behaviour,
        pilot: &mut Pilot,
        at: &Moment<'_>,
    ) -> Decision {
        let (situation, pose) = (at.situation, at.odom_from_base);
        match behaviour {
            Behaviour::BackUp => {
                let near = pilot.look_around(situation, 0.0);
                let wanted = self
                    .escape
                    .back_up(near, situation.robot, (&self.trail, pose));
                pilot.manoeuvre(situation, wanted.into_iter())
            }
            Behaviour::Rotate => {
                let near = pilot.look_around(situation, 0.0);
                let wanted = self.escape.rotate(near, situation.robot, pose);
                pilot.manoeuvre(situation, wanted.into_iter())
            }
            Behaviour::Manoeuvre => {
                let reach_m = self.manoeuvre.reach_m();
                let near = pilot.look_around(situation, reach_m);
                let view = at.view(near, self.margin_m);
                let wanted = self.manoeuvre.step(&view, at.now_s);
                let decision = pilot.manoeuvre(situation, wanted);
                self.manoeuvre.note(situation.period_s);
                decision
            }
            _ => pilot.decide(situation),
        }
    }

    /// Adds to the facts of a period what is possible from here and how a manoeuvre stands.
    pub(crate) fn complete(
        &mut self,
        facts: Facts,
        behaviour: Behaviour,
        pilot: &mut Pilot,
        at: &Moment<'_>,
    ) -> Facts {
        let (situation, pose) = (at.situation, at.odom_from_base);
        let follows = behaviour == Behaviour::Follow;
        let has_corners = !situation.corners.is_empty();
        let approach = follows && has_corners && {
            let view = at.view(pilot.seen(), self.margin_m);
            let decided = self.manoeuvre.wants_approach(situation);
            view.may_approach()
                && decided.unwrap_or_else(|| {
                    let near = pilot.look_around(situation, manoeuvre::SIGHT_M);
                    self.manoeuvre
                        .decide_approach(&at.view(near, self.margin_m))
                })
        };
        let manoeuvred = (behaviour == Behaviour::Manoeuvre)
            .then(|| self.manoeuvre.end())
            .flatten();
        // Only where a manoeuvre may begin or goes on.
        let near =
            (behaviour.is_manoeuvre() || facts.blocked).then(|| pilot.look_around(situation, 0.0));
        Facts {
            free_behind: near
                .is_some_and(|near| is_free_behind(near, situation.robot, &self.trail, pose)),
            room_to_turn: near.is_some_and(has_room_to_turn),
            manoeuvrable: has_corners
                && self
                    .manoeuvre
                    .is_worth_a_search(at.now_s, situation.path_geometry, pose),
            hardly_moves: self.stay.lasts(facts.goal, follows, at),
            approach,
            manoeuvred: manoeuvred.map(|end| match end {
                End::Done => Reason::Done,
                End::NotFound => Reason::NoManoeuvre,
                End::Blocked => Reason::NotFreeAhead,
            }),
            backed_m: self.escape.backed_m(pose),
            rotated_rad: self.escape.turned_rad(),
            ..facts
        }
    }

    /// Takes in a change of behaviour.
    pub(crate) fn change(&mut self, change: Transition, pilot: &mut Pilot, at: &Moment<'_>) {
        let pose = at.odom_from_base;
        if change.to == Behaviour::Manoeuvre {
            self.manoeuvre.begin(pose);
        }
        if change.to.is_manoeuvre() != change.from.is_manoeuvre() {
            let near = pilot.look_around(at.situation, 0.0);
            self.escape.begin(near, pose);
            pilot.interrupted();
        }
    }
}

impl<'a> Moment<'a> {
    fn view(
        &self,
        near: &'a crate::surroundings::Surroundings,
        margin_m: f64,
    ) -> manoeuvre::View<'a> {
        manoeuvre::View {
            situation: self.situation,
            near,
            odom_from_base: self.odom_from_base,
            tracker: self.tracker,
            margin_m,
        }
    }
}
