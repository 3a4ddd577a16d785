//! Why the local planner drives as it does, or stands although it has a path.

use super::words::{input, stale, way};
use zeronav_measure::result::moment::{Command, Moment, Request};
use zeronav_msgs::command::{RecoveryReason, RequestCause, Validity};

/// [m/s] below its limit at which a robot is still getting faster.
const SPEEDING_UP_MPS: f64 = 0.02;

const SEEKS_POSE: &str = "The robot does not know where it is: it looks around, turns on the spot and drives short ways in free sight, \
                          until one place alone fits what it has seen.";

/// Why the robot drives as it does, or does not although it has a path.
pub(super) fn driving(request: &Request, moment: &Moment) -> String {
    let limit = format!("{:.2} m/s", request.limit_mps);
    let obstacle = request.obstacle.map_or_else(String::new, |obstacle| {
        let [x_m, y_m] = obstacle.at_m;
        format!(
            " Tracked obstacle {} is near, at ({x_m:.2}, {y_m:.2}), with {:.2} m/s.",
            obstacle.track, obstacle.speed_mps
        )
    });
    let ahead = if request.blocked_arc_m > 0.0 {
        format!(
            " An obstacle is on the path, {:.2} m ahead.",
            request.blocked_arc_m
        )
    } else {
        String::new()
    };
    let cause = match request.cause {
        RequestCause::None if request.validity == Validity::Blocked => {
            "The local planner finds no admissible motion.".to_owned()
        }
        RequestCause::None => "The local planner follows the path; it tells no more.".to_owned(),
        RequestCause::Free => free(request, moment.command.as_ref()),
        RequestCause::Goal | RequestCause::SpeedZone | RequestCause::Corner => {
            format!(
                "The local planner slows down for {}, to {limit}.",
                limiting(request.cause)
            )
        }
        RequestCause::Critics
        | RequestCause::ClearanceCritic
        | RequestCause::PathCritic
        | RequestCause::ProgressCritic
        | RequestCause::DynamicObstacleCritic
        | RequestCause::SmoothnessCritic
        | RequestCause::StoppingDistance
        | RequestCause::TimedSearch
        | RequestCause::PotentialField
        | RequestCause::NoFit
        | RequestCause::Yield => {
            format!("{}{ahead}{obstacle}", slower(request.cause, &limit))
        }
        RequestCause::Ageing => format!(
            "The local planner slows down to {limit} because {} is getting old.",
            input(request.input)
        ),
        RequestCause::SeekPose => return SEEKS_POSE.to_owned(),
        RequestCause::Heading => format!(
            "The robot faces away from the path: the local planner slows down to {limit} until it \
             faces it."
        ),
        RequestCause::Turn => "The local planner turns on the spot towards the path: it drives \
                               when it faces it."
            .to_owned(),
        RequestCause::TurnWait => format!(
            "The local planner waits for a moving obstacle to pass before it turns on the \
             spot.{obstacle}"
        ),
        RequestCause::Arrive => {
            "It is within the goal's tolerance and slows down to a stop.".to_owned()
        }
        RequestCause::GoalYaw => {
            "It is at the goal and turns on the spot to the goal's yaw.".to_owned()
        }
        RequestCause::Blocked => format!(
            "The local planner finds no admissible motion: from none of them the robot could stop \
             in time.{ahead}{obstacle} Its recovery begins when that lasts."
        ),
        RequestCause::Stale => stale(request),
        RequestCause::AskForPath
        | RequestCause::BackUp
        | RequestCause::Rotate
        | RequestCause::Manoeuvre
        | RequestCause::Wait
        | RequestCause::GiveUp => format!("{}{ahead}{obstacle}", recovery(request)),
    };
    let way = moment.path.as_ref().map_or_else(String::new, way);
    format!("{cause}{way}")
}

/// What of the way limits the speed.
const fn limiting(cause: RequestCause) -> &'static str {
    match cause {
        RequestCause::Goal => "the end of the path",
        RequestCause::SpeedZone => "the speed limit of a zone",
        _ => "a corner of the path",
    }
}

/// Why the controller prefers a slower motion.
fn slower(cause: RequestCause, limit: &str) -> String {
    let (who, why) = match cause {
        RequestCause::ClearanceCritic => ("clearance", "it keeps more clearance"),
        RequestCause::PathCritic => ("path", "it stays nearer to the path, or more along it"),
        RequestCause::ProgressCritic => ("progress", "it gets farther on the free way to the goal"),
        RequestCause::DynamicObstacleCritic => (
            "dynamic obstacle",
            "it stays out of the way of what moves, which a faster motion leads into",
        ),
        RequestCause::SmoothnessCritic => ("smoothness", "it changes its yaw rate less"),
        RequestCause::StoppingDistance => {
            return format!(
                "The local planner drives at {limit}: from no faster motion could it stop in time \
                 before an obstacle."
            );
        }
        RequestCause::PotentialField => {
            return format!(
                "The robot faces away from where the potential field leads it: the local planner \
                 slows down to {limit} until it faces there."
            );
        }
        RequestCause::NoFit => {
            return format!(
                "No curve that was fitted to the way is free of obstacles: the local planner goes \
                 without one, at {limit} at most."
            );
        }
        RequestCause::Yield => {
            return format!(
                "The local planner yields, at {limit}: a faster motion would soon touch a moving \
                 obstacle."
            );
        }
        RequestCause::TimedSearch => {
            return format!(
                "The local planner searched in time among moving obstacles: going towards {limit} \
                 now costs the least time and risk."
            );
        }
        _ => {
            return format!(
                "The critics of the local planner decided: at {limit} it keeps more clearance, or \
                 nearer to the path."
            );
        }
    };
    format!("The {who} critic of the local planner decided: at {limit} {why}.")
}

/// What a robot does that nothing holds back.
fn free(request: &Request, command: Option<&Command>) -> String {
    let now_mps = command.map_or(0.0, |command| command.v_mps);
    if now_mps + SPEEDING_UP_MPS < request.limit_mps {
        format!(
            "It speeds up to {:.2} m/s: nothing else limits it.",
            request.limit_mps
        )
    } else {
        "Nothing limits it but its own limits.".to_owned()
    }
}

/// What the recovery does, and why.
fn recovery(request: &Request) -> String {
    let why = match request.recovery {
        RecoveryReason::None => "",
        RecoveryReason::Blocked => " because no motion was admissible",
        RecoveryReason::NoProgress => " because the robot came no closer to its goal",
        RecoveryReason::DynamicObstacle => " because a moving obstacle is in the way",
        RecoveryReason::TimedOut => " because what it tried before took too long",
        RecoveryReason::Stuck => " because the time without coming closer is over",
        RecoveryReason::OutOfAttempts => " because no attempt is left",
    };
    let what = match request.cause {
        RequestCause::AskForPath => "has asked for another path and waits for it",
        RequestCause::BackUp => "drives back along the track that the robot came by",
        RequestCause::Rotate => "turns on the spot to look around",
        RequestCause::Manoeuvre => {
            "stops, searches for a manoeuvre with the true outline and drives it"
        }
        RequestCause::Wait => "waits for the way to become free",
        _ => "has nothing left to try",
    };
    format!("The recovery of the local planner {what}{why}.")
}
