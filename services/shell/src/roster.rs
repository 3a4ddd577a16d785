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
    /// The reader's own role and epoch, which decide from which tick on it hears; `None` hears
    /// everything.
    pub own: Option<(Role, u32)>,
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
        let own = self.own.and_then(|(own, epoch)| {
            let seat = self.seat(own)?;
            Some(seat.hears_from(epoch))
        });
        self.seat(role)
            .is_some_and(|seat| seat.obeys(header.id().epoch(), header.tick))
            && (header.tick == 0 || header.tick >= own.unwrap_or(0))
    }

    /// True when the author is the process that is obeyed in its seat from now on: at the end of a
    /// swap its messages take the place of those of the other, whose ids may be higher.
    #[must_use]
    pub fn is_current(&self, header: &Header) -> bool {
        let seat = header.role().and_then(|role| self.seat(role));
        seat.is_none_or(|seat| seat.epoch == header.id().epoch())
    }

    /// True when `role` has to answer `tick`.
    #[must_use]
    pub fn answers(&self, role: Role, tick: u64) -> bool {
        self.seat(role).is_some_and(|seat| seat.answers(tick))
    }

    /// True when this process, with role and epoch `own`, has to answer `tick`.
    #[must_use]
    pub fn owes(&self, tick: u64) -> bool {
        self.own.is_some_and(|(role, epoch)| {
            let seat = self.seat(role);
            seat.is_some_and(|seat| seat.answers_as(epoch, tick))
        })
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
            own: Some((Role::Mapping, 2)),
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

    #[test]
    fn of_two_processes_each_is_obeyed_at_its_own_ticks() {
        let seat = Seat {
            role: Role::Mapping.code(),
            epoch: 3,
            other: 2,
            since_tick: 20,
            hear_tick: 15,
            other_tick: 4,
            ..Seat::default()
        };
        let roster = |own| Roster {
            seats: vec![seat],
            own: Some((Role::Mapping, own)),
            ..Roster::default()
        };
        let header = |epoch, tick| Header {
            id: Id::new(epoch, 7).0,
            role: Role::Mapping.code(),
            tick,
            ..Header::default()
        };
        let old = roster(2);
        assert!(old.hears(&header(2, 19)) && !old.hears(&header(3, 19)));
        assert!(old.hears(&header(3, 20)) && !old.hears(&header(2, 20)));
        assert!(
            old.hears(&header(3, 0)) && !old.hears(&header(2, 0)),
            "keyframes"
        );
        assert!(!old.hears(&header(2, 3)), "a message from before");
        assert!(!roster(3).hears(&header(2, 14)), "a message from before");
        assert!(old.is_current(&header(3, 0)) && !old.is_current(&header(2, 25)));
        assert!(old.owes(4) && !old.owes(3));
    }
}
