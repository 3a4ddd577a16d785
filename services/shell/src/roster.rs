//! Which processes are obeyed, which roles have to answer, and how the run keeps time.

use zeronav_msgs::header::Header;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{RunClock, RunControl, RunMode, Seat};

/// What `run/clock` and `run/control` say, as this process last read it.
#[derive(Debug, Clone, Default)]
pub struct Roster {
    /// How time runs; all zero until launch has published it.
    pub clock: RunClock,
    /// Lease, pause, stop.
    pub control: RunControl,
    /// The seats.
    pub seats: Vec<Seat>,
    /// The reader's own role, whose `hear_tick` counts; `None` hears everything.
    pub own: Option<Role>,
    /// When the reader woke: what it polls with this roster came in by then. Monotonic. [ns]
    pub woken_ns: u64,
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

    /// True when an answer to `tick` still waits for that of `role`, which has answered up to
    /// `spoken_tick`; lockstep only.
    #[must_use]
    pub fn awaits(&self, role: Role, tick: u64, spoken_tick: u64) -> bool {
        self.lockstep() && self.answers(role, tick) && spoken_tick < tick
    }

    /// True when every stage answers every tick of its trigger exactly once.
    #[must_use]
    pub fn lockstep(&self) -> bool {
        self.clock.mode() == Some(RunMode::Lockstep)
    }

    /// True when launch has published how time runs and which processes are obeyed.
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
