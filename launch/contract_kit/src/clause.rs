//! The clauses of the contract that a program in a seat keeps, as `services/README.md` numbers them.

use serde::Serialize;
use std::fmt;

/// A clause that is tested, by its number and name in the table "The contract, clause by clause".
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Clause {
    Help,
    PrintConfig,
    UnknownFlag,
    BadConfig,
    Contract,
    Memory,
    Seat,
    Topics,
    Idle,
    Heartbeat,
    Lockstep,
    Records,
    Repeatable,
    Epoch,
    Obeyed,
    Legal,
    Latency,
    LostInput,
    Hostile,
    Bounded,
    Stop,
    Orphan,
}

impl Clause {
    /// Every clause, in the order of the table.
    pub const ALL: [Self; 22] = [
        Self::Help,
        Self::PrintConfig,
        Self::UnknownFlag,
        Self::BadConfig,
        Self::Contract,
        Self::Memory,
        Self::Seat,
        Self::Topics,
        Self::Idle,
        Self::Heartbeat,
        Self::Lockstep,
        Self::Records,
        Self::Repeatable,
        Self::Epoch,
        Self::Obeyed,
        Self::Legal,
        Self::Latency,
        Self::LostInput,
        Self::Hostile,
        Self::Bounded,
        Self::Stop,
        Self::Orphan,
    ];

    /// Its name in the table.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Help => "help",
            Self::PrintConfig => "print_config",
            Self::UnknownFlag => "unknown_flag",
            Self::BadConfig => "bad_config",
            Self::Contract => "other_contract",
            Self::Memory => "no_memory",
            Self::Seat => "one_per_seat",
            Self::Topics => "topics",
            Self::Idle => "idle_output",
            Self::Heartbeat => "heartbeat",
            Self::Lockstep => "lockstep",
            Self::Records => "records",
            Self::Repeatable => "repeatable",
            Self::Epoch => "epoch",
            Self::Obeyed => "obeyed_only",
            Self::Legal => "legal_output",
            Self::Latency => "latency",
            Self::LostInput => "lost_input",
            Self::Hostile => "hostile_input",
            Self::Bounded => "bounded_memory",
            Self::Stop => "stop",
            Self::Orphan => "orphan",
        }
    }

    /// Its number in the table, from 1.
    pub fn number(self) -> usize {
        let at = Self::ALL.iter().position(|clause| *clause == self);
        at.map_or(0, |at| at + 1)
    }
}

impl fmt::Display for Clause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:2} {}", self.number(), self.name())
    }
}

/// What came out for a clause.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It is kept.
    Ok,
    /// It is not.
    Failed,
    /// It was not tested.
    Skipped,
}

impl Verdict {
    pub const fn label(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Failed => "FAILED",
            Self::Skipped => "skipped",
        }
    }
}
