//! The first 128 bytes of every message: who, which, when, and because of what.

use crate::message;
use crate::message::{Refusal, ZeroCopySend, ensure};
use crate::role::Role;
use core::fmt;

/// Lowest epoch of a shadow: a process that runs beside the one in its seat and is never obeyed.
/// Launch gives out lower ones only.
pub const SHADOW_EPOCH_MIN: u32 = 0x80_0000;

/// Identity of a message on its topic: `epoch << 40 | count`.
///
/// It grows across restarts of the writer, so it is the sequence number, the map revision and the
/// name by which later messages cite this one. 0 means none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Id(pub u64);

impl Id {
    /// No message.
    pub const NONE: Self = Self(0);

    /// The `count`-th message (from 1) of the process started with `epoch`.
    #[must_use]
    pub const fn new(epoch: u32, count: u64) -> Self {
        Self(((epoch as u64) << 40) | (count & ((1 << 40) - 1)))
    }

    /// Which start of the writer wrote it; launch gives every started process a higher one.
    #[must_use]
    pub const fn epoch(self) -> u32 {
        (self.0 >> 40) as u32
    }

    /// Its place among the messages of that writer on that topic, from 1.
    #[must_use]
    pub const fn count(self) -> u64 {
        self.0 & ((1 << 40) - 1)
    }

    /// The identity of the writer's next message on the same topic.
    #[must_use]
    pub const fn next(self) -> Self {
        Self(self.0 + 1)
    }

    /// False for [`Id::NONE`].
    #[must_use]
    pub const fn is_some(self) -> bool {
        self.0 != 0
    }
}

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.epoch(), self.count())
    }
}

message! {
    /// The messages that the author itself took in for this one; 0 = none. Everything further
    /// back is found by joining spans.
    pub struct Parents = "zeronav.Parents.v1" {
        /// [id] Id on `robot/odometry`.
        pub odometry: u64,
        /// [id] Id on `robot/scan`.
        pub scan: u64,
        /// [id] Revision of the map.
        pub map: u64,
        /// [id] Id on `plan/path`.
        pub path: u64,
        /// [id] Id on `plan/request` for a path, on `control/velocity_request` for a
        /// command and for rollouts.
        pub request: u64,
        /// [id] Id on `task/goal`.
        pub goal: u64,
    }
}

message! {
    /// The author's own clock readings, [ns] of `CLOCK_MONOTONIC`.
    pub struct Stamps = "zeronav.Stamps.v1" {
        /// [ns] Return from the wait.
        pub woken_ns: u64,
        /// [ns] All inputs taken in, work begins.
        pub started_ns: u64,
        /// [ns] Just before the message was sent.
        pub published_ns: u64,
    }
}

message! {
    /// Fixed header of every message.
    pub struct Header = "zeronav.Header.v2" {
        /// Code of the author's [`Role`].
        pub role: u16,
        /// [number] Which robot; 0, because one domain is one robot.
        pub robot: u16,
        /// [number] Low 32 bits of the topic's schema hash.
        pub schema: u32,
        /// [number] Which clock the stamps belong to; 0 = the host of launch.
        pub clock: u32,
        /// Written as 0, ignored by readers.
        pub spare: u32,
        /// [id] Identity, see [`Id`].
        pub id: u64,
        /// [tick] Control tick that the message answers; 0 = an idle output before the first tick.
        /// That of a keyframe is the tick of its revision.
        pub tick: u64,
        /// Run time of that tick, for a scan of its capture. [ns]
        pub run_ns: u64,
        /// When the newest sensor data in it was captured, `CLOCK_MONOTONIC`; 0 = none. [ns]
        pub capture_ns: u64,
        /// What it was made from.
        pub parents: Parents,
        /// When it was made.
        pub stamps: Stamps,
        /// [number] Checksum of everything else in the message, see [`crate::checksum`].
        pub checksum: u64,
    }
}

impl Header {
    /// The identity as its type.
    #[must_use]
    pub const fn id(&self) -> Id {
        Id(self.id)
    }

    /// The role of the author.
    #[must_use]
    pub const fn role(&self) -> Option<Role> {
        Role::from_code(self.role)
    }

    /// Accepts headers of this domain, of this contract, written by a role of `writers`.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self, schema: u64, writers: &[Role]) -> Result<(), Refusal> {
        ensure(
            u64::from(self.schema) == schema & 0xffff_ffff,
            Refusal::Schema,
        )?;
        ensure(self.robot == 0, Refusal::Foreign("robot"))?;
        ensure(self.clock == 0, Refusal::Foreign("clock"))?;
        let role = self.role().ok_or(Refusal::Code("role"))?;
        ensure(writers.contains(&role), Refusal::Writer)?;
        ensure(
            self.id().epoch() > 0 && self.id().count() > 0,
            Refusal::Identity,
        )
    }
}
