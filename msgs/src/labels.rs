//! The words for the codes in messages, by the name of their enum.

use crate::certainty::PoseCertainty;
use crate::command::{Intervention, PlannerInput, RecoveryReason, RequestCause, Validity};
use crate::health::HealthState;
use crate::map::ObstacleSource;
use crate::path::{PathBlock, PathCause, PathStatus};
use crate::request::RequestReason;
use crate::role::Role;
use crate::rollouts::RolloutOutcome;
use crate::run::{RunMode, TopicFaultKind};
use crate::span::SpanKind;
use crate::task::{EndReason, StuckCause, TaskKind, TaskState};
use crate::zones::ZoneKind;

macro_rules! labels {
    ($($name:ident),* $(,)?) => {
        /// The enums.
        pub const ENUMS: &[&str] = &[$(stringify!($name)),*];

        /// The word for `code` of the enum that [`Field::code`](crate::fields::Field::code) names;
        /// `None` for an unknown one.
        #[must_use]
        pub fn label(name: &str, code: u16) -> Option<&'static str> {
            match name {
                $(stringify!($name) => Some($name::from_code(code)?.label()),)*
                _ => None,
            }
        }
    };
}

labels!(
    EndReason,
    HealthState,
    Intervention,
    ObstacleSource,
    PathBlock,
    PathCause,
    PathStatus,
    PlannerInput,
    PoseCertainty,
    RecoveryReason,
    RequestCause,
    RequestReason,
    Role,
    RolloutOutcome,
    RunMode,
    TopicFaultKind,
    SpanKind,
    StuckCause,
    TaskKind,
    TaskState,
    Validity,
    ZoneKind,
);
