//! What the robot does when it makes no progress: a state machine with a reason on every transition.
//!
//! A ladder of ever more expensive attempts: ask for another path, search for a manoeuvre with the true
//! outline and drive it, move back along the driven track, turn on the spot to look around, wait, and the same again; a dynamic obstacle in the way is
//! waited for first. Coming closer to the goal goes back to its foot. Every behaviour but following
//! the path ends after a bounded time, and every goal has a bounded number of attempts, so the end
//! is arrival or a failed task with a named cause. The machine is pure: `rules.rs` is the table of
//! its transitions, `escape.rs` drives its manoeuvres and checks every piece of the way.

mod behaviour;
pub(crate) mod escape;
pub mod options;
mod rules;
pub(crate) mod trail;

pub use behaviour::{Behaviour, Cause, Facts, Reason, Transition};
use options::RecoveryConfig;
use rules::{Next, RULES, View};

/// Rungs of the ladder beyond asking for a path: manoeuvre, back, back, back, turn, wait.
const RUNGS: u32 = 6;

/// The machine.
#[derive(Debug, Clone)]
pub struct Recovery {
    config: RecoveryConfig,
    behaviour: Behaviour,
    since_s: f64,
    /// When the last manoeuvre, wait or question ended. [s]
    tried_s: f64,
    goal: u64,
    /// Of the path when the behaviour began.
    geometry: u64,
    /// Since when no motion is admissible. [s]
    blocked_since_s: Option<f64>,
    /// Since when the robot turns on the spot. [s]
    turning_since_s: Option<f64>,
    /// When the first attempt since the robot last came closer was made. [s]
    escalated_s: Option<f64>,
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
            turning_since_s: None,
            escalated_s: None,
            asks: 0,
            rung: 0,
            attempts: 0,
        }
    }

    /// What the robot does.
    #[must_use]
    pub const fn behaviour(&self) -> Behaviour {
        self.behaviour
    }

    /// Manoeuvres and waits for the current goal so far.
    #[must_use]
    pub const fn attempts(&self) -> u32 {
        self.attempts
    }

    /// One period in which the robot drives; the transition, if there is one.
    pub fn step(&mut self, facts: &Facts) -> Option<Transition> {
        let now = (facts.now_s, facts.geometry);
        if facts.goal != self.goal {
            return self.begin(now, facts.goal);
        }
        if facts.goal == 0 || self.has_given_up() {
            return None;
        }
        if self
            .escalated_s
            .is_some_and(|since_s| facts.stalled_s < facts.now_s - since_s)
        {
            // It has come closer since.
            (self.escalated_s, self.asks, self.rung) = (None, 0, 0);
        }
        note(&mut self.blocked_since_s, facts.blocked, facts.now_s);
        note(&mut self.turning_since_s, facts.turns, facts.now_s);
        if facts.stuck {
            return self.give_up(now);
        }
        let config = self.config;
        let lasted_s = |since_s: Option<f64>| since_s.map_or(0.0, |since_s| facts.now_s - since_s);
        let view = View {
            facts,
            config: &config,
            lasted_s: facts.now_s - self.since_s,
            blocked_s: lasted_s(self.blocked_since_s),
            turning_s: lasted_s(self.turning_since_s),
            since_tried_s: facts.now_s - self.tried_s,
            escalated: self.escalated_s.is_some(),
            // One on which it stands as blocked as before is the same in another message, or no help.
            another_path: facts.geometry != 0 && facts.geometry != self.geometry && !facts.blocked,
        };
        let rule = RULES
            .iter()
            .find(|rule| rule.from.contains(&self.behaviour) && (rule.holds)(&view))?;
        match rule.next {
            Next::Go(to) => self.enter(now, to, rule.reason),
            Next::Attempt(to) => self.attempt(now, to, rule.reason),
            Next::Escalate => self.escalate(facts, rule.reason),
            Next::EscalateAfresh => {
                self.asks = 0;
                self.escalate(facts, rule.reason)
            }
            Next::Climb => self.climb(facts, rule.reason),
        }
    }

    /// A period in which the robot does not drive: no path, an old input, no goal, or a task that
    /// has just failed as `stuck`. The time of a behaviour goes on.
    pub fn idle(&mut self, now_s: f64, goal: u64, stuck: bool) -> Option<Transition> {
        let now = (now_s, self.geometry);
        if stuck && !self.has_given_up() {
            return (self.goal != 0).then(|| self.give_up(now)).flatten();
        }
        if goal == self.goal {
            return None;
        }
        self.begin(now, goal)
    }

    const fn has_given_up(&self) -> bool {
        matches!(self.behaviour, Behaviour::GiveUp(_))
    }

    /// Another goal: nothing has been tried for it.
    fn begin(&mut self, now: (f64, u64), goal: u64) -> Option<Transition> {
        *self = Self {
            goal,
            behaviour: self.behaviour,
            ..Self::new(self.config)
        };
        self.enter(now, Behaviour::Follow, Reason::AnotherGoal)
    }

    fn give_up(&mut self, now: (f64, u64)) -> Option<Transition> {
        let cause = if self.blocked_since_s.is_some() || self.behaviour == Behaviour::Wait {
            Cause::Blocked
        } else {
            Cause::NoProgress
        };
        self.enter(now, Behaviour::GiveUp(cause), Reason::Stuck)
    }

    /// `now` is the run time [s] and the geometry of the path.
    fn enter(&mut self, now: (f64, u64), to: Behaviour, reason: Reason) -> Option<Transition> {
        let from = self.behaviour;
        if from != Behaviour::Follow {
            self.tried_s = now.0;
        }
        self.turning_since_s = None;
        self.behaviour = to;
        (self.since_s, self.geometry) = now;
        (from != to).then_some(Transition { from, to, reason })
    }

    /// Another attempt, unless none is left.
    fn attempt(&mut self, now: (f64, u64), to: Behaviour, reason: Reason) -> Option<Transition> {
        if self.attempts >= self.config.attempts {
            let to = Behaviour::GiveUp(Cause::TooManyAttempts);
            return self.enter(now, to, Reason::OutOfAttempts);
        }
        self.attempts += 1;
        self.escalated_s.get_or_insert(now.0);
        self.enter(now, to, reason)
    }

    /// A path first; when paths do not help, the next rung.
    fn escalate(&mut self, facts: &Facts, reason: Reason) -> Option<Transition> {
        if self.asks < self.config.asks {
            self.asks += 1;
            self.escalated_s.get_or_insert(facts.now_s);
            let now = (facts.now_s, facts.geometry);
            return self.enter(now, Behaviour::AskForPath, reason);
        }
        self.climb(facts, reason)
    }

    /// The next rung that is possible.
    fn climb(&mut self, facts: &Facts, reason: Reason) -> Option<Transition> {
        let now = (facts.now_s, facts.geometry);
        for _ in 0..RUNGS {
            let rung = self.rung % RUNGS;
            self.rung += 1;
            match rung {
                0 if facts.manoeuvrable => {
                    return self.attempt(now, Behaviour::Manoeuvre, reason);
                }
                1..=3 if facts.free_behind => {
                    return self.attempt(now, Behaviour::BackUp, reason);
                }
                4 if facts.room_to_turn && self.config.rotate_rad > 0.0 => {
                    return self.attempt(now, Behaviour::Rotate, reason);
                }
                5 => return self.attempt(now, Behaviour::Wait, reason),
                _ => {}
            }
        }
        None
    }
}

/// Keeps since when something holds. [s]
fn note(since_s: &mut Option<f64>, holds: bool, now_s: f64) {
    *since_s = holds.then(|| since_s.unwrap_or(now_s));
}
