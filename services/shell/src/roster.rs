//! Who is obeyed, who has to answer, and how the run keeps time.

use crate::error::StartError;
use crate::peer::Peer;
use crate::reader::Latest;
use std::time::{Duration, Instant};
use zeronav_msgs::header::Header;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{RunClock, RunControl, RunMode, Seat};
use zeronav_msgs::topics::{RunClockTopic, RunControlTopic};

/// How long launch may take to say who is obeyed.
const KNOWN_LIMIT: Duration = Duration::from_secs(5);

/// Time between two looks at what launch says.
const KNOWN_PAUSE: Duration = Duration::from_millis(5);

/// What `run/clock` and `run/control` say, as this process last read it.
#[derive(Debug, Clone, Default)]
pub struct Roster {
    /// How time runs; all zero until launch has said it.
    pub clock: RunClock,
    /// Lease, pause, stop.
    pub control: RunControl,
    /// The seats.
    pub seats: Vec<Seat>,
    /// The reader's own role, whose `hear_tick` counts; `None` hears everything.
    pub own: Option<Role>,
}

impl Roster {
    /// The seat of `role`.
    #[must_use]
    pub fn seat(&self, role: Role) -> Option<&Seat> {
        self.seats.iter().find(|seat| seat.role == role.code())
    }

    /// True when messages of this author are heard: it is the one that is obeyed in its seat,
    /// and not of a tick before this reader was there.
    #[must_use]
    pub fn hears(&self, header: &Header) -> bool {
        let Some(role) = header.role() else {
            return false;
        };
        if role == Role::Launch {
            return true;
        }
        let hear_tick = self
            .own
            .and_then(|own| self.seat(own))
            .map_or(0, |seat| seat.hear_tick);
        self.seat(role)
            .is_some_and(|seat| seat.epoch == header.id().epoch())
            && (header.tick == 0 || header.tick >= hear_tick)
    }

    /// True when `role` has to answer `tick`.
    #[must_use]
    pub fn answers(&self, role: Role, tick: u64) -> bool {
        self.seat(role).is_some_and(|seat| seat.answers(tick))
    }

    /// True when every stage answers every tick of its trigger exactly once.
    #[must_use]
    pub fn lockstep(&self) -> bool {
        self.clock.mode() == Some(RunMode::Lockstep)
    }

    /// True when launch has said how time runs and who is obeyed.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.has_clock() && !self.seats.is_empty()
    }

    /// True when the clock is known.
    #[must_use]
    pub fn has_clock(&self) -> bool {
        matches!(
            self.clock.mode(),
            Some(RunMode::RealTime | RunMode::Lockstep)
        )
    }
}

/// Reads `run/clock` and `run/control`.
#[derive(Debug)]
pub struct RosterReader {
    clock: Latest<RunClockTopic>,
    control: Latest<RunControlTopic>,
    roster: Roster,
    /// Launch is gone: what it said last about going on does not hold any more.
    rest: bool,
}

impl RosterReader {
    /// Opens both topics.
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            clock: peer.latest()?,
            control: peer.latest()?,
            roster: Roster {
                own: Some(peer.role()),
                ..Roster::default()
            },
            rest: false,
        })
    }

    /// From now on the roster says that the robot shall stop.
    pub(crate) fn come_to_rest(&mut self) {
        self.rest = true;
        self.poll();
    }

    /// Makes sure that `epoch` is the one that is obeyed in the seat of `role`, once launch says
    /// who is.
    ///
    /// # Errors
    /// [`StartError::Usage`] naming the epoch that launch expects.
    pub fn expects(&mut self, role: Role, epoch: u32) -> Result<(), StartError> {
        let started = Instant::now();
        while !self.roster.is_known() {
            if started.elapsed() > KNOWN_LIMIT {
                return Err(StartError::system(
                    "reading run/control",
                    "launch says nothing",
                ));
            }
            std::thread::sleep(KNOWN_PAUSE);
            self.poll();
        }
        match self.roster.seat(role) {
            Some(seat) if seat.epoch == epoch => Ok(()),
            Some(seat) => Err(StartError::Usage(format!(
                "--epoch {epoch}: the seat of {role} expects --epoch {}, no other is obeyed",
                seat.epoch
            ))),
            None => Err(StartError::Usage(format!(
                "this run has no seat for {role}"
            ))),
        }
    }

    /// Takes in what has come.
    pub fn poll(&mut self) {
        if self.clock.poll(&self.roster)
            && let Some(clock) = self.clock.get()
        {
            self.roster.clock = *clock.meta;
        }
        if self.control.poll(&self.roster)
            && let Some(control) = self.control.get()
        {
            self.roster.control = *control.meta;
            self.roster.seats.clear();
            self.roster.seats.extend_from_slice(control.items);
        }
        if self.rest {
            (self.roster.control.stopping, self.roster.control.paused) = (1, 0);
        }
    }

    /// What was read last.
    #[must_use]
    pub fn roster(&self) -> &Roster {
        &self.roster
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::header::Id;

    #[test]
    fn a_successor_hears_nothing_from_before_its_first_tick() {
        let seat = |role: Role, epoch, hear_tick| Seat {
            role: role.code(),
            epoch,
            hear_tick,
            ..Seat::default()
        };
        let mut roster = Roster {
            seats: vec![seat(Role::Robot, 1, 0), seat(Role::Mapping, 2, 10)],
            own: Some(Role::Mapping),
            ..Roster::default()
        };
        let header = |tick| Header {
            id: Id::new(1, 7).0,
            role: Role::Robot.code(),
            tick,
            ..Header::default()
        };
        assert!(!roster.hears(&header(9)), "a message from before");
        assert!(roster.hears(&header(10)));
        assert!(roster.hears(&header(0)), "what belongs to no tick");
        roster.own = None;
        assert!(roster.hears(&header(9)), "a guest hears everything");
    }
}
