//! Faults of the stack that a scenario asks for: what breaks, when, and for how long.
//!
//! ```toml
//! [[faults]]
//! kind = "kill"
//! service = "local_planner"
//! begins = { at_s = 3.0 }          # or { robot_near = { point_m = [9.0, 6.4], distance_m = 1.2 } }
//!
//! [random_faults]                  # and so many more, drawn from the seed of the run
//! count = 40
//! until_s = 60.0
//! ```

use super::limits::{COORDINATE_M_MAX, TIME_LIMIT_S_MAX};
use serde::{Deserialize, Serialize};
use zeronav_casts::Cast;
use zeronav_msgs::Role;
use zeronav_msgs::run::{DELAY_STEP_NS, RunMode, SHARE_ALL, TopicFault, TopicFaultKind};
use zeronav_msgs::time::seconds;
use zeronav_msgs::topics::{TopicRow, topics};
use zeronav_shell::nearest::unknown;
use zeronav_world::error::{SpecError, number};
use zeronav_world::spec::{Near, Trigger};
use zeronav_world::world::{LASTS_S_MIN, NEAR_M};

/// Most faults of one scenario, random ones included.
pub const FAULTS_MAX: usize = 10_000;

/// Delays of an answer that the roster can hold. [ms]
pub const SLOW_MS: [f64; 2] = [0.01, 655.35];

/// Delays of a message. [ms]
pub const DELAY_MS: [f64; 2] = [0.001, 10_000.0];

/// Offsets of a clock. [ms]
pub const CLOCK_MS: [f64; 2] = [-10_000.0, 10_000.0];

/// Shares of the messages that are lost or corrupted: a millionth to all.
pub const SHARE: [f64; 2] = [1.0e-6, 1.0];

/// A kind of fault.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    /// Its name.
    pub name: &'static str,
    /// True when a lockstep run with it is the same every time, and not the same as without it.
    pub lockstep: bool,
    /// True when it touches this stack alone, so that it is drawn unless other kinds are named.
    pub is_drawn: bool,
}

/// Every kind.
pub const KINDS: [Kind; 9] = [
    kind("kill", true, true),
    kind("stop", true, true),
    kind("slow", true, true),
    kind("drop", false, true),
    kind("delay", false, true),
    kind("corrupt", false, true),
    kind("clock", false, true),
    kind("fill_shm", false, false),
    kind("disk_full", true, false),
];

const fn kind(name: &'static str, lockstep: bool, is_drawn: bool) -> Kind {
    Kind {
        name,
        lockstep,
        is_drawn,
    }
}

/// One fault.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum StackFault {
    /// A service is killed (SIGKILL), as if it had crashed.
    Kill {
        /// Its seat: `mapping`, `global_planner`, `local_planner` or `collision_guard`.
        service: String,
        /// When; without, at once. A scenario needs it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        begins: Option<Trigger>,
    },
    /// A service is stopped (SIGSTOP), so that it hangs until it is restarted.
    Stop {
        /// Its seat.
        service: String,
        /// When; without, at once. A scenario needs it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        begins: Option<Trigger>,
        /// It goes on after this time if nothing has restarted it by then; real time only. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
    },
    /// Each answer of a service is late. In lockstep, which waits for it, that changes nothing but
    /// the time that the run takes.
    Slow {
        /// Its seat.
        service: String,
        /// By how much. [ms]
        by_ms: f64,
        /// When it begins; without, at once. A scenario needs it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        begins: Option<Trigger>,
        /// For how long; without, to the end. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
    },
    /// Messages of a topic are lost on their way to each of its readers; real time only.
    Drop {
        /// Its name.
        topic: String,
        /// Share of the messages, up to 1.
        share: f64,
        /// When it begins; without, at once. A scenario needs it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        begins: Option<Trigger>,
        /// For how long; without, to the end. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
    },
    /// Messages of a topic are late for all of its readers; real time only.
    Delay {
        /// Its name.
        topic: String,
        /// By how much. [ms]
        by_ms: f64,
        /// When it begins; without, at once. A scenario needs it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        begins: Option<Trigger>,
        /// For how long; without, to the end. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
    },
    /// In messages of a topic, one bit is flipped: of the header, the fixed fields or the slice. Real
    /// time only.
    Corrupt {
        /// Its name.
        topic: String,
        /// Share of the messages, up to 1.
        #[serde(default = "all")]
        share: f64,
        /// When it begins; without, at once. A scenario needs it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        begins: Option<Trigger>,
        /// For how long; without, to the end. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
    },
    /// The clock of a service is put forward, or back; real time only, as lockstep goes by run time.
    Clock {
        /// Its seat.
        service: String,
        /// By how much. [ms]
        by_ms: f64,
        /// When it begins; without, at once. A scenario needs it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        begins: Option<Trigger>,
        /// For how long; without, to the end. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
    },
    /// The machine's shared memory is full; real time only, where a successor waits for it.
    FillShm {
        /// When it begins; without, at once. A scenario needs it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        begins: Option<Trigger>,
        /// For how long; without, to the end. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
    },
    /// The file system of the run's folder is full.
    DiskFull {
        /// When it begins; without, at once. A scenario needs it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        begins: Option<Trigger>,
        /// For how long; without, to the end. [s]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lasts_s: Option<f64>,
    },
}

const fn all() -> f64 {
    1.0
}

/// The topics whose messages may be disturbed: those between services, not those of launch itself.
pub fn faultable() -> impl Iterator<Item = &'static TopicRow> {
    let of_launch = |row: &&TopicRow| {
        let name = row.name;
        ["run/", "health/", "sim/", "debug/"]
            .iter()
            .any(|it| name.starts_with(it))
    };
    topics().into_iter().filter(move |row| !of_launch(row))
}

/// The seats whose services may break: all but the robot's, which nothing restarts.
pub fn mortals() -> impl Iterator<Item = Role> + Clone {
    let services = Role::SERVICES.into_iter();
    services.filter(|role| *role != Role::Robot)
}

impl StackFault {
    /// What kind it is.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::Kill { .. } => "kill",
            Self::Stop { .. } => "stop",
            Self::Slow { .. } => "slow",
            Self::Drop { .. } => "drop",
            Self::Delay { .. } => "delay",
            Self::Corrupt { .. } => "corrupt",
            Self::Clock { .. } => "clock",
            Self::FillShm { .. } => "fill_shm",
            Self::DiskFull { .. } => "disk_full",
        }
    }

    /// What breaks: a seat, a topic, `shared_memory` or `disk`.
    #[must_use]
    pub fn target(&self) -> &str {
        match self {
            Self::Kill { service, .. }
            | Self::Stop { service, .. }
            | Self::Slow { service, .. }
            | Self::Clock { service, .. } => service,
            Self::Drop { topic, .. } | Self::Delay { topic, .. } | Self::Corrupt { topic, .. } => {
                topic
            }
            Self::FillShm { .. } => "shared_memory",
            Self::DiskFull { .. } => "disk",
        }
    }

    /// The seat whose service breaks; `None` when there is none of that name that may break.
    #[must_use]
    pub fn role(&self) -> Option<Role> {
        mortals().find(|role| role.label() == self.target())
    }

    /// The topic that is disturbed; `None` when there is none of that name.
    #[must_use]
    pub fn topic(&self) -> Option<&'static TopicRow> {
        faultable().find(|row| row.name == self.target())
    }

    /// The seat whose next answer shows that the fault is over: that which breaks, or the first whose
    /// doorbell the topic rings; `None` for the machine's own.
    #[must_use]
    pub fn seat(&self) -> Option<Role> {
        let of_topic = |row: &TopicRow| {
            let first = row.rings.first().or(row.writers.first()).copied();
            first.filter(|role| *role != Role::Launch)
        };
        self.role().or_else(|| of_topic(self.topic()?))
    }

    /// When it begins; `None` = at once.
    #[must_use]
    pub const fn begins(&self) -> Option<&Trigger> {
        match self {
            Self::Kill { begins, .. }
            | Self::Stop { begins, .. }
            | Self::Slow { begins, .. }
            | Self::Drop { begins, .. }
            | Self::Delay { begins, .. }
            | Self::Corrupt { begins, .. }
            | Self::Clock { begins, .. }
            | Self::FillShm { begins, .. }
            | Self::DiskFull { begins, .. } => begins.as_ref(),
        }
    }

    /// For how long it lasts; `None` = to the end, or without an end. [s]
    #[must_use]
    pub const fn lasts_s(&self) -> Option<f64> {
        match self {
            Self::Kill { .. } => None,
            Self::Stop { lasts_s, .. }
            | Self::Slow { lasts_s, .. }
            | Self::Drop { lasts_s, .. }
            | Self::Delay { lasts_s, .. }
            | Self::Corrupt { lasts_s, .. }
            | Self::Clock { lasts_s, .. }
            | Self::FillShm { lasts_s, .. }
            | Self::DiskFull { lasts_s, .. } => *lasts_s,
        }
    }

    /// Its figures, in words; empty when there are none.
    #[must_use]
    pub fn figures(&self) -> String {
        match self {
            Self::Slow { by_ms, .. } | Self::Delay { by_ms, .. } => format!("{by_ms} ms"),
            Self::Clock { by_ms, .. } => format!("{by_ms:+} ms"),
            Self::Drop { share, .. } | Self::Corrupt { share, .. } => {
                let percent = (1.0e5 * share).round() / 1.0e3;
                format!("{percent} % of the messages")
            }
            _ => String::new(),
        }
    }

    /// Accepts known targets and usable numbers.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), SpecError> {
        match self {
            Self::Kill { .. } | Self::Stop { .. } | Self::Slow { .. } | Self::Clock { .. }
                if self.role().is_none() =>
            {
                let why = if self.target() == Role::Robot.label() {
                    "the robot is not restarted; `zeronav down` ends the stack".to_owned()
                } else {
                    unknown(
                        "service that may break",
                        self.target(),
                        mortals().map(Role::label),
                    )
                };
                return Err(SpecError::new("service", why));
            }
            Self::Drop { .. } | Self::Delay { .. } | Self::Corrupt { .. }
                if self.topic().is_none() =>
            {
                let known: Vec<&str> = faultable().map(|row| row.name).collect();
                let why = unknown("topic between services", self.target(), known);
                return Err(SpecError::new("topic", why));
            }
            _ => {}
        }
        if let Some(lasts_s) = self.lasts_s() {
            number(lasts_s, LASTS_S_MIN, TIME_LIMIT_S_MAX, "lasts_s")?;
        }
        match self {
            Self::Slow { by_ms, .. } => number(*by_ms, SLOW_MS[0], SLOW_MS[1], "by_ms")?,
            Self::Delay { by_ms, .. } => number(*by_ms, DELAY_MS[0], DELAY_MS[1], "by_ms")?,
            Self::Clock { by_ms, .. } => number(*by_ms, CLOCK_MS[0], CLOCK_MS[1], "by_ms")?,
            Self::Drop { share, .. } | Self::Corrupt { share, .. } => {
                number(*share, SHARE[0], SHARE[1], "share")?;
            }
            _ => {}
        }
        match self.begins() {
            Some(begins) => check_trigger(begins).map_err(|error| error.within("begins")),
            None => Ok(()),
        }
    }

    /// What it does to the messages of its topic; `None` for other faults.
    #[must_use]
    pub fn topic_fault(&self, seed: u32) -> Option<TopicFault> {
        let (kind, share, delay_ms) = match self {
            Self::Drop { share, .. } => (TopicFaultKind::Drop, *share, 0.0),
            Self::Delay { by_ms, .. } => (TopicFaultKind::Delay, 0.0, *by_ms),
            Self::Corrupt { share, .. } => (TopicFaultKind::Corrupt, *share, 0.0),
            _ => return None,
        };
        Some(TopicFault {
            topic: u16::try_from(self.topic()?.number).ok()?,
            kind: kind.code(),
            share: (share * f64::from(SHARE_ALL)).round().to_u32(),
            delay_us: (delay_ms * 1.0e3).round().to_u32(),
            seed,
        })
    }

    /// By how much it puts a clock forward; `None` for other faults. [ms]
    #[must_use]
    pub fn clock_offset_ms(&self) -> Option<i32> {
        match self {
            Self::Clock { by_ms, .. } => Some(by_ms.round().to_i32()),
            _ => None,
        }
    }

    /// The delay of each answer in steps of [`DELAY_STEP_NS`]; 0 for other faults.
    #[must_use]
    pub fn delay_steps(&self) -> u16 {
        match self {
            Self::Slow { by_ms, .. } => (by_ms / (seconds(DELAY_STEP_NS) * 1.0e3)).round().to_u16(),
            _ => 0,
        }
    }

    /// Which field keeps it out of a run in this mode, and why; `None` when none does.
    #[must_use]
    pub fn unfit(&self, mode: RunMode) -> Option<(&'static str, &'static str)> {
        if mode != RunMode::Lockstep {
            return None;
        }
        match self {
            Self::Stop {
                lasts_s: Some(_), ..
            } => Some((
                "lasts_s",
                "lockstep waits for a service that hangs until it is restarted",
            )),
            Self::Drop { .. } | Self::Delay { .. } | Self::Corrupt { .. } => Some((
                "kind",
                "lockstep waits for every message; run it in real time",
            )),
            Self::Clock { .. } => Some(("kind", "lockstep has no clock; run it in real time")),
            Self::FillShm { .. } => Some((
                "kind",
                "lockstep would wait for a successor that waits for memory; run it in real time",
            )),
            _ => None,
        }
    }
}

/// Accepts a run time or a place.
fn check_trigger(begins: &Trigger) -> Result<(), SpecError> {
    match (begins.at_s, &begins.robot_near) {
        (Some(at_s), None) => number(at_s, 0.0, TIME_LIMIT_S_MAX, "at_s"),
        (
            None,
            Some(Near {
                point_m,
                distance_m,
            }),
        ) => {
            for (axis, value) in point_m.iter().enumerate() {
                let most = COORDINATE_M_MAX;
                number(*value, -most, most, &format!("robot_near.point_m[{axis}]"))?;
            }
            number(*distance_m, NEAR_M[0], NEAR_M[1], "robot_near.distance_m")
        }
        _ => Err(SpecError::new(
            "",
            "give exactly one of at_s and robot_near",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_told_in_percent_without_idle_digits() {
        for (share, told) in [
            (1.0, "100 % of the messages"),
            (0.3, "30 % of the messages"),
            (0.000_01, "0.001 % of the messages"),
        ] {
            let fault = StackFault::Drop {
                topic: "any".to_owned(),
                share,
                begins: None,
                lasts_s: None,
            };
            assert_eq!(fault.figures(), told);
        }
    }
}
