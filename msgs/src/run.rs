//! `run/clock` and `run/control`: what time means, and who is obeyed.

use crate::foresight::{FORESIGHT_PERCEIVE, FORESIGHT_PREDICT};
use crate::header::SHADOW_EPOCH_MIN;
use crate::message::{Refusal, ZeroCopySend, ensure};
use crate::role::Role;
use crate::{codes, message};

/// Most seats of a roster.
pub const SEATS_MAX: usize = 16;

/// Unit of [`Seat::delay`]. [ns]
pub const DELAY_STEP_NS: u64 = 10_000;

/// Most topics that are disturbed on purpose at a time.
pub const TOPIC_FAULTS_MAX: usize = 4;

/// [`TopicFault::share`] of all messages.
pub const SHARE_ALL: u32 = 1_000_000;

/// Longest delay of a message on purpose. [us]
pub const DELAY_US_MAX: u32 = 10_000_000;

/// Largest offset of a process's clock on purpose, either sign. [ms]
pub const CLOCK_OFFSET_MS_MAX: i32 = 10_000;

codes! {
    /// How the run keeps time.
    pub enum RunMode: u16 {
        /// Not yet known.
        None = 0 => "none",
        /// The robot's clock drives; every stage answers the newest input of every wake.
        RealTime = 1 => "real_time",
        /// The lease drives; every stage answers every tick of its trigger exactly once.
        Lockstep = 2 => "lockstep",
    }
}

message! {
    /// Fixed fields of the clock; the slice is empty. Written once, before any child starts.
    pub struct RunClock = "zeronav.RunClock.v3" {
        /// Code of [`RunMode`].
        pub mode: u16,
        /// [flag] 1 = services time the stages of their cycles and say it in their records; 0 = they
        /// read no clock for it. Always 0 in lockstep.
        pub stages: u16,
        /// [bits] What services are told of what moves on `sim/foresight`: 1 = mapping what there is, 2 =
        /// the local planner what will be; 0 in earnest.
        pub foresight: u16,
        /// Written as 0.
        pub spare: u16,
        /// [number] Seed of everything random in the run.
        pub seed: u64,
        /// [ns] `CLOCK_MONOTONIC` at run time 0.
        pub zero_ns: u64,
        /// [ns] of run time from tick to tick.
        pub tick_ns: u64,
    }
}

codes! {
    /// What is done to the messages of a topic on purpose.
    pub enum TopicFaultKind: u16 {
        /// Nothing.
        None = 0 => "none",
        /// Some are lost.
        Drop = 1 => "drop",
        /// All are late.
        Delay = 2 => "delay",
        /// In some, one bit is flipped.
        Corrupt = 3 => "corrupt",
    }
}

message! {
    /// A topic whose messages are disturbed on purpose on their way to each service that reads it, in
    /// real time only: lockstep waits for every message.
    pub struct TopicFault = "zeronav.TopicFault.v1" {
        /// [number] of the topic.
        pub topic: u16,
        /// Code of [`TopicFaultKind`].
        pub kind: u16,
        /// [ppm] of the messages that are dropped or corrupted.
        pub share: u32,
        /// [us] by which each message is late.
        pub delay_us: u32,
        /// [number] Seed of which messages, and which bits.
        pub seed: u32,
    }
}

message! {
    /// Fixed fields of the control message. The slice holds the roster.
    pub struct RunControl = "zeronav.RunControl.v3" {
        /// [tick] Highest tick that the robot may start, lockstep only.
        pub lease: u64,
        /// [flag] 1 = the robot shall stand and run time stops.
        pub paused: u16,
        /// [flag] 1 = the run is ending: stop the robot.
        pub stopping: u16,
        /// [count] Seats in the slice.
        pub n_seats: u32,
        /// [number] Revision of `task/zones` that holds; 0 = there were never any.
        pub zones: u64,
        /// Topics that are disturbed on purpose; all zero in earnest.
        pub topic_faults: [TopicFault; TOPIC_FAULTS_MAX],
    }
}

message! {
    /// One seat of the roster. Two processes can run in it: one is obeyed, the other is warm. At
    /// which tick the one takes over from the other is said in advance, so that no message is
    /// heard twice and none is missed.
    pub struct Seat = "zeronav.Seat.v3" {
        /// Code of the [`Role`].
        pub role: u16,
        /// [10 us] by which the seat delays each of its answers; 0 in earnest. A delay put in on
        /// purpose must appear in this seat's hop and nowhere else.
        pub delay: u16,
        /// [number] The epoch that is obeyed in this seat from `since_tick` on; 0 = none yet.
        pub epoch: u32,
        /// [tick] First tick at which the seat is empty.
        pub off_tick: u64,
        /// [tick] First tick at which it is taken again; `off_tick == on_tick` = never empty.
        pub on_tick: u64,
        /// [tick] Messages of ticks below this one are not heard by `epoch`.
        pub hear_tick: u64,
        /// [tick] First tick at which `epoch` is obeyed; before it, `other` is.
        pub since_tick: u64,
        /// [tick] `other` answers from this tick on, and hears no message of an earlier one.
        pub other_tick: u64,
        /// [number] Epoch of the second process in this seat: a newcomer that is not obeyed yet, or
        /// a predecessor that still runs; 0 = none.
        pub other: u32,
        /// [ms] by which the clocks of its processes are put forward on purpose; 0 in earnest.
        pub clock_offset_ms: i32,
    }
}

impl Seat {
    /// Offset of the clocks of its processes. [ns]
    #[must_use]
    pub const fn clock_offset_ns(&self) -> i64 {
        self.clock_offset_ms as i64 * 1_000_000
    }

    /// Delay of each answer. [ns]
    #[must_use]
    pub const fn delay_ns(&self) -> u64 {
        self.delay as u64 * DELAY_STEP_NS
    }

    /// True when the seat has to answer `tick`.
    #[must_use]
    pub const fn answers(&self, tick: u64) -> bool {
        self.epoch != 0 && !(tick >= self.off_tick && tick < self.on_tick)
    }

    /// True when the process with this epoch is obeyed at `tick`. What belongs to no tick (0), such
    /// as an idle output, is heard from `epoch` only.
    #[must_use]
    pub const fn obeys(&self, epoch: u32, tick: u64) -> bool {
        epoch != 0
            && epoch
                == if tick != 0 && tick < self.since_tick {
                    self.other
                } else {
                    self.epoch
                }
    }

    /// True when the process that is obeyed has taken the seat over from another.
    #[must_use]
    pub const fn is_taken_over(&self) -> bool {
        self.hear_tick > 0 || self.since_tick > 0
    }

    /// True when the process with this epoch answers `tick`, obeyed or not: a successor that the
    /// seat does not name yet answers none, a shadow started by hand answers as the seat does.
    #[must_use]
    pub const fn answers_as(&self, epoch: u32, tick: u64) -> bool {
        if epoch != 0 && epoch == self.other {
            tick >= self.other_tick
        } else {
            self.names(epoch) && self.answers(tick)
        }
    }

    /// First tick of which the process with this epoch hears messages; `u64::MAX` for a successor
    /// that the seat does not name yet.
    #[must_use]
    pub const fn hears_from(&self, epoch: u32) -> u64 {
        if epoch != 0 && epoch == self.other {
            self.other_tick
        } else if self.names(epoch) {
            self.hear_tick
        } else {
            u64::MAX
        }
    }

    /// True for the process in the seat, and for shadows started by hand, which run beside it.
    const fn names(&self, epoch: u32) -> bool {
        epoch == self.epoch || epoch >= SHADOW_EPOCH_MIN
    }
}

impl TopicFault {
    /// What is done.
    #[must_use]
    pub const fn kind(&self) -> Option<TopicFaultKind> {
        TopicFaultKind::from_code(self.kind)
    }

    /// Delay of each message. [ns]
    #[must_use]
    pub const fn delay_ns(&self) -> u64 {
        self.delay_us as u64 * 1000
    }

    /// A number that decides about the message with this id in the eyes of the reader with the code
    /// `role`: the same for the same fault, and spread evenly.
    ///
    /// Source: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", the mixing
    /// function of `SplitMix64`.
    #[must_use]
    pub const fn draw(&self, role: u16, id: u64) -> u64 {
        let mut mixed = (self.seed as u64) << 32 | (self.topic as u64) << 16 | role as u64;
        mixed ^= id.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// True when a message with this [`Self::draw`] is one of the share.
    #[must_use]
    pub const fn hits(&self, draw: u64) -> bool {
        draw % (SHARE_ALL as u64) < self.share as u64
    }

    fn check(&self) -> Result<(), Refusal> {
        self.kind().ok_or(Refusal::Code("topic_fault.kind"))?;
        ensure(
            self.share <= SHARE_ALL,
            Refusal::OutOfRange("topic_fault.share"),
        )?;
        ensure(
            self.delay_us <= DELAY_US_MAX,
            Refusal::OutOfRange("topic_fault.delay_us"),
        )
    }
}

impl RunClock {
    /// The mode.
    #[must_use]
    pub const fn mode(&self) -> Option<RunMode> {
        RunMode::from_code(self.mode)
    }

    /// Accepts known modes with a tick between 1 ms and 1 s.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), Refusal> {
        self.mode().ok_or(Refusal::Code("mode"))?;
        ensure(
            self.foresight <= (FORESIGHT_PERCEIVE | FORESIGHT_PREDICT),
            Refusal::Code("foresight"),
        )?;
        ensure(
            (1_000_000..=1_000_000_000).contains(&self.tick_ns),
            Refusal::OutOfRange("tick_ns"),
        )
    }
}

impl RunControl {
    /// Accepts rosters of known roles.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self, seats: &[Seat]) -> Result<(), Refusal> {
        ensure(
            seats.len() == self.n_seats as usize && seats.len() <= SEATS_MAX,
            Refusal::Length("seats"),
        )?;
        ensure(self.paused <= 1, Refusal::Code("paused"))?;
        ensure(self.stopping <= 1, Refusal::Code("stopping"))?;
        for topic_fault in &self.topic_faults {
            topic_fault.check()?;
        }
        for seat in seats {
            Role::from_code(seat.role).ok_or(Refusal::Code("seat.role"))?;
            ensure(
                seat.off_tick <= seat.on_tick,
                Refusal::OutOfRange("seat.on_tick"),
            )?;
            ensure(
                seat.clock_offset_ms.unsigned_abs() <= CLOCK_OFFSET_MS_MAX.unsigned_abs(),
                Refusal::OutOfRange("seat.clock_offset_ms"),
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::header::Id;

    /// Obeys 7 from tick 100 on, 6 before it; empty from 200 to 299.
    const SEAT: Seat = Seat {
        role: 3,
        delay: 25,
        epoch: 7,
        off_tick: 200,
        on_tick: 300,
        hear_tick: 80,
        since_tick: 100,
        other_tick: 40,
        other: 6,
        clock_offset_ms: -3,
    };

    /// Nobody has been in it before.
    const FIRST: Seat = Seat {
        off_tick: 0,
        on_tick: 0,
        hear_tick: 0,
        since_tick: 0,
        other_tick: 0,
        other: 0,
        ..SEAT
    };

    #[test]
    fn a_seat_answers_but_while_it_is_empty() {
        let answers = [0, 199, 200, 299, 300].map(|tick| SEAT.answers(tick));
        assert_eq!(answers, [true, true, false, false, true]);
        assert!([0, 1, u64::MAX].map(|tick| FIRST.answers(tick)) == [true; 3]);
        let untaken = Seat { epoch: 0, ..SEAT };
        assert!(!untaken.answers(0));
    }

    #[test]
    fn one_process_is_obeyed_at_every_tick() {
        for (tick, obeyed) in [(0, 7), (1, 6), (99, 6), (100, 7), (101, 7)] {
            for epoch in [0, 5, 6, 7, 8] {
                let expected = epoch == obeyed;
                assert_eq!(SEAT.obeys(epoch, tick), expected, "{epoch} at {tick}");
            }
        }
        assert!(FIRST.obeys(7, 1));
        let untaken = Seat { epoch: 0, ..FIRST };
        assert!(!untaken.obeys(0, 1), "nobody is no process");
        assert!(SEAT.is_taken_over() && !FIRST.is_taken_over());
        let heard = Seat {
            hear_tick: 1,
            ..FIRST
        };
        let since = Seat {
            since_tick: 1,
            ..FIRST
        };
        assert!(heard.is_taken_over() && since.is_taken_over());
    }

    #[test]
    fn a_process_hears_and_answers_from_its_tick_on() {
        let shadow = SHADOW_EPOCH_MIN;
        for (epoch, tick, answers) in [
            (6, 39, false),
            (6, 40, true),
            // The other one goes on while the seat is empty.
            (6, 250, true),
            (7, 39, true),
            (7, 250, false),
            (8, 39, false),
            (shadow - 1, 39, false),
            (shadow, 39, true),
            (shadow, 250, false),
        ] {
            let found = SEAT.answers_as(epoch, tick);
            assert_eq!(found, answers, "{epoch} at {tick}");
        }
        let from = [0, 6, 7, 8, shadow].map(|epoch| SEAT.hears_from(epoch));
        assert_eq!(from, [u64::MAX, 40, 80, u64::MAX, 80]);
        let alone = Seat { epoch: 0, ..FIRST };
        assert_eq!((alone.hears_from(0), alone.answers_as(0, 1)), (0, false));
        assert_eq!(
            (SEAT.delay_ns(), SEAT.clock_offset_ns()),
            (250_000, -3_000_000)
        );
    }

    #[test]
    fn a_share_of_all_messages_is_hit_and_always_the_same() {
        let fault = TopicFault {
            topic: 3,
            share: 100_000,
            delay_us: 5,
            seed: 9,
            ..TopicFault::default()
        };
        assert_eq!(fault.delay_ns(), 5000);
        // The same in every build: a run can be repeated.
        assert_eq!(fault.draw(4, Id::new(1, 77).0), 0x431d_9c71_9997_1056);
        let hits = |fault: &TopicFault| {
            (0..20_000)
                .filter(|id| fault.hits(fault.draw(4, *id)))
                .count()
        };
        let n = hits(&fault);
        assert!((1850..2150).contains(&n), "{n} of 20000, not about a tenth");
        assert_eq!(hits(&TopicFault { share: 0, ..fault }), 0);
        assert_eq!(
            hits(&TopicFault {
                share: SHARE_ALL,
                ..fault
            }),
            20_000
        );
        // Another reader, topic or seed draws otherwise.
        let others = [
            fault.draw(5, 77),
            TopicFault { topic: 4, ..fault }.draw(4, 77),
            TopicFault { seed: 8, ..fault }.draw(4, 77),
        ];
        assert!(others.iter().all(|draw| *draw != fault.draw(4, 77)));
        let edge = TopicFault { share: 1, ..fault };
        assert_eq!(
            [0, 1, 1_000_000].map(|draw| edge.hits(draw)),
            [true, false, true]
        );
    }
}
