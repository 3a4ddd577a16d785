//! What the robot does when it does not get on: a state machine with a reason on every change.
//!
//! A ladder of ever more expensive answers: ask for another path, move back along the driven track,
//! turn on the spot to look around, wait, and the same again; something that moves in the way is
//! waited for first. Coming closer to the goal goes back to its foot. Every state but following the
//! path ends after a bounded time, and every goal has a bounded number of attempts, so the end is
//! arrival or a given-up task with a named cause. The machine is pure: what it does is driven by
//! `escape.rs`, which checks every piece of the way.

pub(crate) mod escape;
pub(crate) mod trail;

use zeronav_params::parameters;

parameters! {
    /// What the robot does when it makes no progress.
    #[derive(Copy)]
    pub struct RecoveryConfig {
        /// Whether the robot recovers. Without it the task waits until it is stuck, and the dynamic
        /// windows back up straight.
        enabled: bool = true;
        /// Also for the controllers of the papers, which have no recovery of their own.
        for_papers: bool = false;
        /// Time without an admissible motion after which recovery begins.
        patience_s: f64 = 0.5, [0.0, 60.0] "s";
        /// Time to wait for another path.
        ask_s: f64 = 1.0, [0.05, 60.0] "s";
        /// Paths requested in a row before the robot moves out of the way.
        asks: u32 = 1, [1, 1_000];
        /// Time to wait for a dynamic obstacle to pass.
        wait_s: f64 = 3.0, [0.05, 600.0] "s";
        /// Distance driven back along the track.
        back_up_m: f64 = 0.4, [0.0, 4.0] "m";
        /// Speed backwards.
        back_up_mps: f64 = 0.2, [0.01, 5.0] "m/s";
        /// Angle turned on the spot to look around.
        rotate_rad: f64 = 1.6, [0.0, core::f64::consts::PI] "rad";
        /// Longest duration of a manoeuvre.
        manoeuvre_s: f64 = 6.0, [0.1, 60.0] "s";
        /// Manoeuvres and waits for one goal before the task is given up.
        attempts: u32 = 20, [1, 10_000];
    }
}

/// What the robot is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Behaviour {
    /// Following the path, as the controller decides.
    Follow,
    /// Turning on the spot towards the path, as the controller decides.
    Align,
    /// Waiting for another path.
    AskForPath,
    /// Driving back along the track that it came by.
    BackUp,
    /// Turning on the spot to look around.
    Rotate,
    /// Waiting for the way to become free.
    Wait,
    /// Nothing more: the task has failed.
    GiveUp(Cause),
}

/// Why a task was given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Cause {
    /// No motion was admissible.
    Blocked,
    /// The robot moved, but came no closer.
    NoProgress,
    /// It came closer between them, but needed too many attempts.
    TooManyAttempts,
}

impl Behaviour {
    /// True for what is tried to get on again.
    #[must_use]
    pub const fn is_attempt(self) -> bool {
        matches!(self, Self::BackUp | Self::Rotate | Self::Wait)
    }
}

/// Why a behaviour ended and the next one began.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Reason {
    /// Another goal is at hand, or none.
    AnotherGoal,
    /// The controller turns on the spot.
    TurnsOnTheSpot,
    /// It has turned.
    Aligned,
    /// No motion is admissible.
    Blocked,
    /// The robot does not come closer.
    NoProgress,
    /// Something that moves is in the way.
    SomethingMoves,
    /// Another path came.
    AnotherPath,
    /// A motion is admissible again.
    Cleared,
    /// As far as it was meant to go.
    Done,
    /// The way behind is not free or not known.
    NotFreeBehind,
    /// There is no room to turn.
    NoRoomToTurn,
    /// It took too long.
    TimedOut,
    /// The task's time without coming closer is over.
    Stuck,
    /// No attempt is left.
    OutOfAttempts,
}

/// A change of behaviour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transition {
    /// What ended.
    pub from: Behaviour,
    /// What begins.
    pub to: Behaviour,
    /// Why.
    pub reason: Reason,
}

/// What a period is judged by.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "observations that have nothing to do with each other"
)]
pub struct Facts {
    /// [s] run time.
    pub now_s: f64,
    /// The goal at hand; 0 = none.
    pub goal: u64,
    /// Id of the path's geometry; 0 = no path.
    pub geometry: u64,
    /// The controller finds no admissible motion.
    pub blocked: bool,
    /// The controller turns on the spot.
    pub turns: bool,
    /// [s] since the robot came closer to the goal.
    pub stalled_s: f64,
    /// That is long.
    pub no_progress: bool,
    /// That is too long.
    pub stuck: bool,
    /// Something that moves is near.
    pub something_moves: bool,
    /// The way back along the track is free, and the robot drives backwards at all.
    pub free_behind: bool,
    /// There is room to turn on the spot.
    pub room_to_turn: bool,
    /// [m] driven back since that began.
    pub backed_m: f64,
    /// [rad] turned since that began.
    pub rotated_rad: f64,
}

/// Rungs of the ladder beyond asking for a path: back, back, back, turn, wait.
const RUNGS: u32 = 5;

/// The machine.
#[derive(Debug, Clone)]
pub struct Recovery {
    config: RecoveryConfig,
    behaviour: Behaviour,
    since_s: f64,
    /// When the last manoeuvre or wait ended. [s]
    tried_s: f64,
    goal: u64,
    /// Of the path when it was asked for another one.
    geometry: u64,
    /// Since when no motion is admissible. [s]
    blocked_since_s: Option<f64>,
    /// When the ladder was begun. [s]
    begun_s: Option<f64>,
    asks: u32,
    rung: u32,
    attempts: u32,
}

impl Recovery {
    /// Following, with nothing tried yet.
    #[must_use]
    pub const fn new(config: RecoveryConfig) -> Self {
        Self {
            config,
            behaviour: Behaviour::Follow,
            since_s: 0.0,
            tried_s: f64::NEG_INFINITY,
            goal: 0,
            geometry: 0,
            blocked_since_s: None,
            begun_s: None,
            asks: 0,
            rung: 0,
            attempts: 0,
        }
    }

    /// What the robot is about.
    #[must_use]
    pub const fn behaviour(&self) -> Behaviour {
        self.behaviour
    }

    /// Manoeuvres and waits for the goal at hand so far.
    #[must_use]
    pub const fn attempts(&self) -> u32 {
        self.attempts
    }

    /// One period; the change of behaviour, if there is one.
    pub fn step(&mut self, facts: &Facts) -> Option<Transition> {
        if facts.goal != self.goal {
            *self = Self {
                goal: facts.goal,
                behaviour: self.behaviour,
                ..Self::new(self.config)
            };
            return self.enter(facts, Behaviour::Follow, Reason::AnotherGoal);
        }
        if facts.goal == 0 || matches!(self.behaviour, Behaviour::GiveUp(_)) {
            return None;
        }
        if self
            .begun_s
            .is_some_and(|begun_s| facts.stalled_s < facts.now_s - begun_s)
        {
            // It has come closer since.
            (self.begun_s, self.asks, self.rung) = (None, 0, 0);
        }
        self.blocked_since_s = match self.blocked_since_s {
            _ if !facts.blocked => None,
            None => Some(facts.now_s),
            since => since,
        };
        if facts.stuck {
            let cause = if self.blocked_since_s.is_some() || self.behaviour == Behaviour::Wait {
                Cause::Blocked
            } else {
                Cause::NoProgress
            };
            return self.enter(facts, Behaviour::GiveUp(cause), Reason::Stuck);
        }
        match self.behaviour {
            Behaviour::Follow | Behaviour::Align => self.follow(facts),
            Behaviour::AskForPath => self.ask(facts),
            Behaviour::Wait => self.wait(facts),
            Behaviour::BackUp => self.back_up(facts),
            Behaviour::Rotate => self.rotate(facts),
            Behaviour::GiveUp(_) => None,
        }
    }

    /// A period in which nobody drives: no path, an old input, no goal, or a task that has just
    /// failed as `stuck`. The time of a behaviour goes on.
    pub fn idle(&mut self, now_s: f64, goal: u64, stuck: bool) -> Option<Transition> {
        let given_up = matches!(self.behaviour, Behaviour::GiveUp(_));
        let facts = Facts {
            now_s,
            goal: if stuck && !given_up { self.goal } else { goal },
            geometry: self.geometry,
            blocked: self.blocked_since_s.is_some(),
            turns: false,
            stalled_s: f64::INFINITY,
            no_progress: false,
            stuck,
            something_moves: false,
            free_behind: false,
            room_to_turn: false,
            backed_m: 0.0,
            rotated_rad: 0.0,
        };
        if stuck || goal != self.goal {
            self.step(&facts)
        } else {
            None
        }
    }

    fn lasted_s(&self, facts: &Facts) -> f64 {
        facts.now_s - self.since_s
    }

    fn enter(&mut self, facts: &Facts, to: Behaviour, reason: Reason) -> Option<Transition> {
        let from = self.behaviour;
        if !matches!(from, Behaviour::Follow | Behaviour::Align) {
            self.tried_s = facts.now_s;
        }
        self.behaviour = to;
        self.since_s = facts.now_s;
        self.geometry = facts.geometry;
        (from != to).then_some(Transition { from, to, reason })
    }

    /// Another attempt, unless none is left.
    fn attempt(&mut self, facts: &Facts, to: Behaviour, reason: Reason) -> Option<Transition> {
        if self.attempts >= self.config.attempts {
            let to = Behaviour::GiveUp(Cause::TooManyAttempts);
            return self.enter(facts, to, Reason::OutOfAttempts);
        }
        self.attempts += 1;
        self.begun_s.get_or_insert(facts.now_s);
        self.enter(facts, to, reason)
    }

    fn follow(&mut self, facts: &Facts) -> Option<Transition> {
        let blocked_s = self
            .blocked_since_s
            .map_or(0.0, |since_s| facts.now_s - since_s);
        if blocked_s > self.config.patience_s {
            // Once per ladder; who stays in the way does not pass.
            if facts.something_moves && self.begun_s.is_none() {
                return self.attempt(facts, Behaviour::Wait, Reason::SomethingMoves);
            }
            return self.trouble(facts, Reason::Blocked);
        }
        let turned_s = self.lasted_s(facts);
        match self.behaviour {
            // What was tried needs time to show.
            Behaviour::Follow
                if facts.no_progress && facts.now_s - self.tried_s > self.config.wait_s =>
            {
                self.trouble(facts, Reason::NoProgress)
            }
            Behaviour::Follow if facts.turns => {
                self.enter(facts, Behaviour::Align, Reason::TurnsOnTheSpot)
            }
            Behaviour::Align if !facts.turns => {
                self.enter(facts, Behaviour::Follow, Reason::Aligned)
            }
            Behaviour::Align if turned_s > 2.0 * self.config.manoeuvre_s => {
                self.trouble(facts, Reason::TimedOut)
            }
            _ => None,
        }
    }

    /// A path first; when paths do not help, the next rung.
    fn trouble(&mut self, facts: &Facts, reason: Reason) -> Option<Transition> {
        if self.asks < self.config.asks {
            self.asks += 1;
            self.begun_s.get_or_insert(facts.now_s);
            return self.enter(facts, Behaviour::AskForPath, reason);
        }
        self.climb(facts, reason)
    }

    /// The next rung that is possible.
    fn climb(&mut self, facts: &Facts, reason: Reason) -> Option<Transition> {
        for _ in 0..RUNGS {
            let rung = self.rung % RUNGS;
            self.rung += 1;
            match rung {
                0..=2 if facts.free_behind => {
                    return self.attempt(facts, Behaviour::BackUp, reason);
                }
                3 if facts.room_to_turn && self.config.rotate_rad > 0.0 => {
                    return self.attempt(facts, Behaviour::Rotate, reason);
                }
                4 => return self.attempt(facts, Behaviour::Wait, reason),
                _ => {}
            }
        }
        None
    }

    fn ask(&mut self, facts: &Facts) -> Option<Transition> {
        if facts.geometry != 0 && facts.geometry != self.geometry {
            return self.enter(facts, Behaviour::Follow, Reason::AnotherPath);
        }
        if self.lasted_s(facts) <= self.config.ask_s {
            return None;
        }
        if facts.blocked {
            self.climb(facts, Reason::TimedOut)
        } else {
            self.enter(facts, Behaviour::Follow, Reason::Cleared)
        }
    }

    fn wait(&mut self, facts: &Facts) -> Option<Transition> {
        if !facts.blocked {
            return self.enter(facts, Behaviour::Follow, Reason::Cleared);
        }
        if facts.geometry != 0 && facts.geometry != self.geometry {
            return self.enter(facts, Behaviour::Follow, Reason::AnotherPath);
        }
        if self.lasted_s(facts) > self.config.wait_s {
            self.asks = 0;
            return self.trouble(facts, Reason::TimedOut);
        }
        None
    }

    fn back_up(&mut self, facts: &Facts) -> Option<Transition> {
        if facts.backed_m >= self.config.back_up_m {
            self.enter(facts, Behaviour::Follow, Reason::Done)
        } else if !facts.free_behind {
            self.enter(facts, Behaviour::Follow, Reason::NotFreeBehind)
        } else if self.lasted_s(facts) > self.config.manoeuvre_s {
            self.enter(facts, Behaviour::Follow, Reason::TimedOut)
        } else {
            None
        }
    }

    fn rotate(&mut self, facts: &Facts) -> Option<Transition> {
        if facts.rotated_rad >= self.config.rotate_rad {
            self.enter(facts, Behaviour::Follow, Reason::Done)
        } else if !facts.room_to_turn {
            self.enter(facts, Behaviour::Follow, Reason::NoRoomToTurn)
        } else if self.lasted_s(facts) > self.config.manoeuvre_s {
            self.enter(facts, Behaviour::Follow, Reason::TimedOut)
        } else {
            None
        }
    }
}
