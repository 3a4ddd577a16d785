//! Why a velocity request is what it is, in the terms of the message. Nothing is decided by it.

use crate::dynamic_obstacles::nearest_dynamic;
use crate::recovery::{Behaviour, Reason};
use crate::situation::Decision;
use crate::staleness::{Ageing, Ages, StaleInput};
use zeronav_msgs::Pose;
use zeronav_msgs::command::{
    AGE_MS_MAX, PlannerInput, RecoveryReason, RequestCause, Validity, VelocityRequest,
};
use zeronav_msgs::obstacles::Obstacle;

/// What a period was decided by, besides the controller's own cause.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Circumstances<'a> {
    /// Ages of the inputs.
    pub(crate) ages: &'a Ages,
    /// Tracked obstacles.
    pub(crate) obstacles: &'a [Obstacle],
    /// The input because of which the robot stops.
    pub(crate) stale: Option<StaleInput>,
    /// The inputs because of which it slows down.
    pub(crate) ageing: Ageing,
    /// What the robot is about.
    pub(crate) behaviour: Behaviour,
    /// Why.
    pub(crate) reason: RecoveryReason,
    /// `map_from_base`.
    pub(crate) map_from_base: Option<Pose>,
}

/// The request of a decision, with everything that explains it.
pub(crate) fn request(decision: &Decision, about: &Circumstances<'_>) -> VelocityRequest {
    let cause = cause(decision, about);
    let input = match cause {
        RequestCause::Stale => about.stale.map_or(PlannerInput::Description, input_of),
        RequestCause::Ageing => about.ageing.first().map_or(PlannerInput::None, input_of),
        _ => PlannerInput::None,
    };
    let recovery = if cause.is_recovery() {
        about.reason
    } else {
        RecoveryReason::None
    };
    let dynamic = (about.map_from_base).and_then(|pose| nearest_dynamic(about.obstacles, &pose));
    VelocityRequest {
        v_mps: decision.v_mps,
        w_radps: decision.w_radps,
        validity: decision.validity.code(),
        cause: cause.code(),
        input: input.code(),
        recovery: recovery.code(),
        braking_arc_m: decision.braking_arc_m,
        ages_ms: ages_ms(about.ages),
        limit_mps: if cause == decision.cause {
            decision.limit_mps
        } else {
            0.0
        },
        blocked_arc_m: decision.blocked_arc_m.unwrap_or(0.0).max(0.0),
        obstacle: dynamic.map_or(0, |obstacle| obstacle.track),
    }
}

fn cause(decision: &Decision, about: &Circumstances<'_>) -> RequestCause {
    if decision.validity == Validity::Stale {
        return RequestCause::Stale;
    }
    if decision.cause == RequestCause::SeekPose {
        return RequestCause::SeekPose;
    }
    let recovers = matches!(decision.validity, Validity::Drive | Validity::Blocked);
    match about.behaviour {
        Behaviour::BackUp if recovers => RequestCause::BackUp,
        Behaviour::Rotate if recovers => RequestCause::Rotate,
        Behaviour::Manoeuvre if recovers => RequestCause::Manoeuvre,
        Behaviour::Wait if recovers => RequestCause::Wait,
        Behaviour::GiveUp(_) if recovers => RequestCause::GiveUp,
        // While it waits for the path the controller goes on.
        Behaviour::AskForPath if decision.validity == Validity::Blocked => RequestCause::AskForPath,
        _ => decision.cause,
    }
}

fn input_of(input: StaleInput) -> PlannerInput {
    match input {
        StaleInput::Odometry => PlannerInput::Odometry,
        StaleInput::Scan => PlannerInput::Scan,
        StaleInput::Map => PlannerInput::Map,
        StaleInput::Path => PlannerInput::Path,
        StaleInput::Pose => PlannerInput::Pose,
    }
}

/// The reason of a behaviour that is none of following the path.
pub(crate) fn reason_of(reason: Reason) -> RecoveryReason {
    match reason {
        Reason::Blocked
        | Reason::NotFreeBehind
        | Reason::NoRoomToTurn
        | Reason::NoManoeuvre
        | Reason::NotFreeAhead => RecoveryReason::Blocked,
        Reason::NoProgress => RecoveryReason::NoProgress,
        Reason::DynamicObstacle => RecoveryReason::DynamicObstacle,
        Reason::TimedOut => RecoveryReason::TimedOut,
        Reason::Stuck => RecoveryReason::Stuck,
        Reason::OutOfAttempts => RecoveryReason::OutOfAttempts,
        Reason::AnotherGoal
        | Reason::AnotherPath
        | Reason::Cleared
        | Reason::Done
        | Reason::Approach => RecoveryReason::None,
    }
}

/// Ages of odometry, scan, map (or what moves in it) and path. [ms] Before the first scan map and path are idle outputs at
/// most, and whether these have come yet depends on the speed of the machine: they are not told.
pub(crate) fn ages_ms(ages: &Ages) -> [u16; 4] {
    let ms = |age_ns: Option<u64>| {
        age_ns.map_or(AGE_MS_MAX, |age_ns| {
            u16::try_from(age_ns / 1_000_000).unwrap_or(AGE_MS_MAX)
        })
    };
    let of_scan = |age_ns: Option<u64>| age_ns.filter(|_| ages.scan_ns.is_some());
    let (map_ns, path_ns) = (of_scan(ages.oldest_of_map_ns()), of_scan(ages.path_ns));
    [ages.odometry_ns, ages.scan_ns, map_ns, path_ns].map(ms)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_age_that_does_not_fit_is_the_longest() {
        let ages = Ages {
            odometry_ns: Some(1_999_999),
            scan_ns: Some(50_000_000),
            map_ns: Some(u64::MAX),
            obstacles_ns: Some(0),
            path_ns: None,
        };
        assert_eq!(ages_ms(&ages), [1, 50, AGE_MS_MAX, AGE_MS_MAX]);
        let before_the_first_scan = Ages {
            odometry_ns: Some(0),
            map_ns: Some(20_000_000),
            obstacles_ns: Some(20_000_000),
            ..Ages::default()
        };
        assert_eq!(
            ages_ms(&before_the_first_scan),
            [0, AGE_MS_MAX, AGE_MS_MAX, AGE_MS_MAX]
        );
    }

    fn decision(validity: Validity, cause: RequestCause) -> Decision {
        Decision {
            v_mps: 0.0,
            w_radps: 0.0,
            validity,
            braking_arc_m: 0.0,
            turns: false,
            rollouts: 0,
            blocked_arc_m: None,
            against: None,
            cause,
            limit_mps: 0.0,
        }
    }

    #[test]
    fn the_recovery_explains_what_it_does_and_the_controller_the_rest() {
        let ages = Ages::default();
        let about = |behaviour| Circumstances {
            ages: &ages,
            obstacles: &[],
            stale: None,
            ageing: Ageing::default(),
            behaviour,
            reason: RecoveryReason::Blocked,
            map_from_base: None,
        };
        let drive = decision(Validity::Drive, RequestCause::Corner);
        let blocked = decision(Validity::Blocked, RequestCause::Blocked);
        let stale = decision(Validity::Stale, RequestCause::None);
        for (decision, behaviour, expected) in [
            (&drive, Behaviour::Follow, RequestCause::Corner),
            (&blocked, Behaviour::Follow, RequestCause::Blocked),
            (&drive, Behaviour::AskForPath, RequestCause::Corner),
            (&blocked, Behaviour::AskForPath, RequestCause::AskForPath),
            (&drive, Behaviour::BackUp, RequestCause::BackUp),
            (&blocked, Behaviour::Wait, RequestCause::Wait),
            (&stale, Behaviour::Wait, RequestCause::Stale),
        ] {
            assert_eq!(
                cause(decision, &about(behaviour)),
                expected,
                "{behaviour:?}"
            );
        }
    }
}
