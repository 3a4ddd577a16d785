//! `run/clock` and `run/control`: what time means, and who is obeyed.

use crate::header::SHADOW_EPOCH_MIN;
use crate::message::{Refusal, ZeroCopySend, ensure};
use crate::role::Role;
use crate::{codes, message};

/// Most seats of a roster.
pub const SEATS_MAX: usize = 16;

/// Unit of [`Seat::delay`]. [ns]
pub const DELAY_STEP_NS: u64 = 10_000;

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
    pub struct RunClock = "zeronav.RunClock.v1" {
        /// Code of [`RunMode`].
        pub mode: u16,
        /// Written as 0.
        pub spare: [u16; 3],
        /// [number] Seed of everything random in the run.
        pub seed: u64,
        /// [ns] `CLOCK_MONOTONIC` at run time 0.
        pub zero_ns: u64,
        /// [ns] of run time from tick to tick.
        pub tick_ns: u64,
    }
}

message! {
    /// Fixed fields of the control message. The slice holds the roster.
    pub struct RunControl = "zeronav.RunControl.v1" {
        /// [tick] Highest tick that the robot may start, lockstep only.
        pub lease: u64,
        /// [flag] 1 = the robot shall stand and run time stops.
        pub paused: u16,
        /// [flag] 1 = the run is ending: stop the robot.
        pub stopping: u16,
        /// [count] Seats in the slice.
        pub n_seats: u32,
    }
}

message! {
    /// One seat of the roster. Two processes can run in it: one is obeyed, the other is warm. At
    /// which tick the one takes over from the other is said in advance, so that no message is
    /// heard twice and none is missed.
    pub struct Seat = "zeronav.Seat.v2" {
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
        /// Written as 0.
        pub spare: u32,
    }
}

impl Seat {
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
        for seat in seats {
            Role::from_code(seat.role).ok_or(Refusal::Code("seat.role"))?;
            ensure(
                seat.off_tick <= seat.on_tick,
                Refusal::OutOfRange("seat.on_tick"),
            )?;
        }
        Ok(())
    }
}
