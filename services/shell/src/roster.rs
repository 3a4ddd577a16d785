//! Which processes are obeyed, which roles have to answer, and how the run keeps time.

use zeronav_msgs::header::Header;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{RunClock, RunControl, RunMode, Seat, TopicFault, TopicFaultKind};

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
        if header.role() == Some(Role::Launch) {
            return true;
        }
        self.obeys(header) && (header.tick == 0 || header.tick >= self.first_tick())
    }

    /// First tick of which this process hears messages.
    fn first_tick(&self) -> u64 {
        let seat = self
            .own
            .and_then(|(role, epoch)| Some((self.seat(role)?, epoch)));
        seat.map_or(0, |(seat, epoch)| seat.hears_from(epoch))
    }

    /// True when the author is obeyed in its seat at the message's tick.
    pub(crate) fn obeys(&self, header: &Header) -> bool {
        let seat = header.role().and_then(|role| self.seat(role));
        seat.is_some_and(|seat| seat.obeys(header.id().epoch(), header.tick))
    }

    /// True when the author is the process that is obeyed in its seat from now on: at the end of a
    /// swap its messages take the place of those of the other, whose ids may be higher.
    #[must_use]
    pub fn is_current(&self, header: &Header) -> bool {
        let seat = header.role().and_then(|role| self.seat(role));
        seat.is_none_or(|seat| seat.epoch == header.id().epoch())
    }

    /// True when this process began at a tick at which the seat of `role` was empty, which the
    /// process with this epoch had left.
    #[must_use]
    pub fn began_after(&self, role: Role, epoch: u32) -> bool {
        let first_tick = self.first_tick();
        let seat = self.seat(role).filter(|seat| seat.epoch != epoch);
        first_tick > 0 && seat.is_some_and(|seat| !seat.answers(first_tick))
    }

    /// True when the author's seat has been taken over since the run began.
    pub(crate) fn is_taken_over(&self, header: &Header) -> bool {
        let seat = header.role().and_then(|role| self.seat(role));
        seat.is_some_and(Seat::is_taken_over)
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

    /// What is done on purpose to the messages of the topic with this number on their way to this
    /// process: a service, in real time.
    pub(crate) fn topic_fault(&self, topic: usize) -> Option<&TopicFault> {
        let all = self.control.topic_faults.iter();
        let mut its = all.filter(|it| it.kind != 0 && usize::from(it.topic) == topic);
        let found = its.next()?;
        let is_service = self
            .own
            .is_some_and(|(role, _)| Role::SERVICES.contains(&role));
        (is_service && !self.lockstep()).then_some(found)
    }

    /// True while messages are late on purpose, and have to be looked for between two rings.
    pub(crate) fn has_delays(&self) -> bool {
        let all = self.control.topic_faults.iter();
        let mut kinds = all.map(TopicFault::kind);
        kinds.any(|kind| kind == Some(TopicFaultKind::Delay))
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
    use zeronav_msgs::header::{Id, SHADOW_EPOCH_MIN};

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
    fn a_successor_that_its_seat_does_not_name_yet_hears_and_owes_nothing() {
        let seat = |role: Role, epoch, (off_tick, on_tick)| Seat {
            role: role.code(),
            epoch,
            off_tick,
            on_tick,
            hear_tick: on_tick,
            ..Seat::default()
        };
        let mut roster = Roster {
            seats: vec![
                seat(Role::Mapping, 2, (10, 15)),
                seat(Role::LocalPlanner, 3, (8, 12)),
            ],
            own: Some((Role::LocalPlanner, 4)),
            ..Roster::default()
        };
        let header = |tick| Header {
            id: Id::new(2, 7).0,
            role: Role::Mapping.code(),
            tick,
            ..Header::default()
        };
        assert!(!roster.hears(&header(20)) && !roster.owes(20));
        assert!(
            roster.obeys(&header(20)),
            "its author is obeyed all the same"
        );
        roster.own = Some((Role::LocalPlanner, SHADOW_EPOCH_MIN));
        assert!(roster.hears(&header(20)) && roster.owes(20), "a shadow");
        roster.own = Some((Role::LocalPlanner, 3));
        assert!(roster.hears(&header(20)) && roster.owes(20));
        assert!(
            roster.began_after(Role::Mapping, 1),
            "at tick 12 there was none"
        );
        assert!(
            !roster.began_after(Role::Mapping, 2),
            "that is the successor"
        );
        roster.seats[1].hear_tick = 15;
        assert!(
            !roster.began_after(Role::Mapping, 1),
            "at tick 15 there was one"
        );
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
