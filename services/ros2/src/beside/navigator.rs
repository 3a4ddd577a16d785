//! Goals of ROS 2, of all sources, on their way to launch: the newest takes the place of the one before.

use super::actions::{Action, Asked};
use super::launch::{self, GoalReport, Tolerance};
use super::layouts::{End, Progress};
use ros2_client::action::{GoalId, GoalStatusEnum};
use std::time::{Duration, Instant};
use zeronav_msgs::task::GOALS_MAX;
use zeronav_ros_messages::frame;
use zeronav_ros_messages::messages::PoseStamped;
use zeronav_ros_messages::received::{plain_frame, planar_pose};
use zeronav_shell::Domain;

/// Time between two questions of what becomes of a goal, and between two feedbacks.
const PAUSE: Duration = Duration::from_millis(100);

/// For how long launch may not answer until a goal has failed.
const SILENT: Duration = Duration::from_secs(10);

/// Error codes of Nav2 where the meaning is the same: of the servers of its planners and controllers, and of the
/// navigators.
mod code {
    pub(super) const FAILED_TO_MAKE_PROGRESS: u16 = 105;
    pub(super) const GOAL_OUTSIDE_MAP: u16 = 204;
    pub(super) const GOAL_OCCUPIED: u16 = 206;
    pub(super) const NO_VALID_PATH: u16 = 208;
    pub(super) const UNKNOWN: u16 = 9000;
    pub(super) const TIMEOUT: u16 = 9003;
}

/// The goal that is driven to.
struct Job {
    /// Place of its action, and its id there.
    action: usize,
    id: GoalId,
    poses: Vec<PoseStamped>,
    /// Launch's number.
    number: u64,
    asked_at: Instant,
    heard_at: Instant,
    is_cancelled: bool,
}

/// See the module's description.
pub(super) struct Navigator {
    actions: Vec<Box<dyn Action>>,
    tolerance: Tolerance,
    job: Option<Job>,
    rejected: u64,
}

/// A pose in the map, `map_from_base`. [m, m, rad]
///
/// # Errors
/// Why it is none.
pub(super) fn in_map(it: &PoseStamped) -> Result<[f64; 3], &'static str> {
    if plain_frame(&it.header.frame_id) != frame::MAP {
        return Err("its frame is not `map`");
    }
    let pose = planar_pose(&it.pose.position, &it.pose.orientation);
    let pose = pose.filter(|pose| pose.check("pose").is_ok());
    let pose = pose.ok_or("it is not finite, or too far away")?;
    Ok([pose.x_m, pose.y_m, pose.yaw_rad])
}

/// Nav2's code for the way in which launch says that a goal has ended.
#[must_use]
pub(super) fn error_code(outcome: &str) -> u16 {
    match outcome {
        "reached" | "cancelled" => 0,
        "unreachable" | "no_path" => code::NO_VALID_PATH,
        "goal_blocked" => code::GOAL_OCCUPIED,
        "goal_outside_map" => code::GOAL_OUTSIDE_MAP,
        "stuck" => code::FAILED_TO_MAKE_PROGRESS,
        "time_limit" => code::TIMEOUT,
        _ => code::UNKNOWN,
    }
}

/// Nav2's code for the reason for which launch does not take goals.
fn refusal_code(why: &str) -> u16 {
    if why.contains("not on the map") {
        code::GOAL_OUTSIDE_MAP
    } else if why.contains("no room") {
        code::GOAL_OCCUPIED
    } else {
        code::UNKNOWN
    }
}

impl Navigator {
    /// Nobody has asked for anything.
    #[must_use]
    pub(super) fn new(actions: Vec<Box<dyn Action>>, tolerance: Tolerance) -> Self {
        Self {
            actions,
            tolerance,
            job: None,
            rejected: 0,
        }
    }

    /// Drives to a pose that somebody has published.
    pub(super) fn go(&mut self, domain: &Domain, pose: &PoseStamped) {
        let gone = in_map(pose)
            .map_err(str::to_owned)
            .and_then(|pose| launch::go(domain, &[pose], self.tolerance));
        match gone {
            // Launch has replaced the goal of an action, which learns it with the next look.
            Ok(_) => {}
            Err(why) => self.reject("/goal_pose", &why),
        }
    }

    /// One look: what clients want, and how far the robot has come, which is at `pose`.
    pub(super) fn look(&mut self, domain: &Domain, pose: Option<&PoseStamped>) {
        for at in 0..self.actions.len() {
            while let Some(asked) = self.actions[at].next_goal() {
                self.begin(domain, at, &asked);
            }
            let active = self.job.as_ref().filter(|job| job.action == at);
            let active = active.map(|job| job.id);
            if self.actions[at].next_cancelled(active).is_some()
                && let Some(job) = &mut self.job
            {
                job.is_cancelled = true;
                let _ = launch::cancel(domain, job.number);
            }
            self.actions[at].serve();
        }
        self.follow(domain, pose);
    }

    fn begin(&mut self, domain: &Domain, at: usize, asked: &Asked) {
        let poses: Result<Vec<[f64; 3]>, &str> = asked.poses.iter().map(in_map).collect();
        let poses = match (asked.problem, poses) {
            (Some(why), _) | (None, Err(why)) => Err(why),
            (None, Ok(poses)) if poses.is_empty() => Err("it has no poses"),
            (None, Ok(poses)) if poses.len() > GOALS_MAX => Err("it has more than 64 poses"),
            (None, Ok(poses)) => Ok(poses),
        };
        let poses = match poses {
            Ok(poses) => poses,
            Err(why) => {
                self.reject("a goal", why);
                return self.actions[at].answer(asked, false);
            }
        };
        let report = match launch::go(domain, &poses, self.tolerance) {
            Ok(report) => report,
            Err(why) => {
                // As Nav2 does: it is accepted, and fails. The robot goes on as before.
                let end = End {
                    code: refusal_code(&why),
                    why,
                    goals_left: poses.len(),
                };
                let action = &mut self.actions[at];
                action.answer(asked, true);
                return action.end(asked.id, GoalStatusEnum::Aborted, &asked.poses, &end);
            }
        };
        // As Nav2 does: who is preempted has failed.
        self.end(
            GoalStatusEnum::Aborted,
            &End {
                why: "another goal took its place".to_owned(),
                ..End::default()
            },
        );
        self.actions[at].answer(asked, true);
        let now = Instant::now();
        self.job = Some(Job {
            action: at,
            id: asked.id,
            poses: asked.poses.clone(),
            number: report.id,
            asked_at: now,
            heard_at: now,
            is_cancelled: false,
        });
    }

    /// Asks launch what becomes of the goal, and says it.
    fn follow(&mut self, domain: &Domain, pose: Option<&PoseStamped>) {
        let Some(job) = &mut self.job else {
            return;
        };
        if job.asked_at.elapsed() < PAUSE {
            return;
        }
        job.asked_at = Instant::now();
        let report = match launch::status(domain, job.number) {
            Ok(report) => report,
            Err(why) => {
                if job.heard_at.elapsed() > SILENT {
                    let code = code::UNKNOWN;
                    let goals_left = job.poses.len();
                    let end = End {
                        code,
                        why,
                        goals_left,
                    };
                    self.end(GoalStatusEnum::Aborted, &end);
                }
                return;
            }
        };
        job.heard_at = job.asked_at;
        if report.goes_on() {
            if let Some(pose) = pose {
                let progress = progress(&report, pose);
                self.actions[job.action].feedback(job.id, &job.poses, &progress);
            }
            return;
        }
        let end = End {
            code: error_code(&report.outcome),
            why: match report.outcome.as_str() {
                "reached" | "cancelled" => String::new(),
                outcome if report.why.is_empty() => outcome.to_owned(),
                _ => report.why.clone(),
            },
            goals_left: report.goals_left,
        };
        let status = match report.outcome.as_str() {
            "reached" => GoalStatusEnum::Succeeded,
            _ if job.is_cancelled => GoalStatusEnum::Canceled,
            _ => GoalStatusEnum::Aborted,
        };
        self.end(status, &end);
    }

    fn end(&mut self, status: GoalStatusEnum, end: &End) {
        if let Some(job) = self.job.take() {
            self.actions[job.action].end(job.id, status, &job.poses, end);
        }
    }

    fn reject(&mut self, what: &str, why: &str) {
        self.rejected += 1;
        // A flood of them must not fill the log.
        if self.rejected.is_power_of_two() {
            tracing::warn!(n = self.rejected, "rejected: {what}: {why}");
        }
    }
}

fn progress(report: &GoalReport, pose: &PoseStamped) -> Progress {
    Progress {
        pose: pose.clone(),
        elapsed_s: report.elapsed_s,
        remaining_s: report.time_remaining_s,
        remaining_m: report.distance_remaining_m.unwrap_or(0.0),
        recoveries: report.recoveries,
        goals_left: report.goals_left,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::pose::Pose;
    use zeronav_ros_messages::view;

    #[test]
    fn poses_in_other_frames_and_nan_are_no_goals() {
        let it = view::pose_in_map(0, &Pose::new(1.0, 2.0, 0.5));
        let [x, y, yaw] = in_map(&it).expect("a goal");
        assert!((x - 1.0).abs() + (y - 2.0).abs() + (yaw - 0.5).abs() < 1e-9);
        let mut other = it.clone();
        other.header.frame_id = "odom".into();
        assert!(in_map(&other).is_err());
        let mut nan = it.clone();
        nan.pose.position.x = f64::NAN;
        assert!(in_map(&nan).is_err());
        let mut far = it;
        far.pose.position.y = 1.0e12;
        assert!(in_map(&far).is_err());
    }

    #[test]
    fn every_way_to_fail_has_a_code_of_nav2() {
        use zeronav_msgs::task::EndReason;
        let of = |reason: EndReason| error_code(reason.label());
        assert_eq!(of(EndReason::Unreachable), 208);
        assert_eq!(of(EndReason::NoPath), 208);
        assert_eq!(of(EndReason::GoalBlocked), 206);
        assert_eq!(of(EndReason::GoalOutsideMap), 204);
        assert_eq!(of(EndReason::Stuck), 105);
        assert_eq!([error_code("reached"), error_code("replaced")], [0, 9000]);
        assert_eq!(refusal_code("(9, 9) is not on the map; ..."), 204);
    }
}
