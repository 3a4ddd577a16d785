//! What decided in each stage, in a line, when that changes: the events of `/why`.

use super::messages as ros;
use super::view::time;
use core::fmt::{Display, Write};
use zeronav_msgs::command::{
    Intervention, PlannerInput, RecoveryReason, RequestCause, Validity, VelocityCommand,
    VelocityRequest,
};
use zeronav_msgs::path::{Path, PathCause, PathStatus};
use zeronav_msgs::role::Role;

/// Levels of `rcl_interfaces/Log`.
pub const DEBUG: u8 = 10;
/// As it goes.
pub const INFO: u8 = 20;
/// Something is in the way or missing.
pub const WARN: u8 = 30;
/// Something has failed.
pub const ERROR: u8 = 40;

/// An event.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reason {
    role: Role,
    level: u8,
    text: String,
}

/// What was said of each stage last.
#[derive(Debug, Default)]
pub struct Reasons {
    command: Option<[u16; 2]>,
    request: Option<[u16; 4]>,
    path: Option<(u16, u16, u64)>,
}

impl Reason {
    /// As a message of the moment `ns`.
    #[must_use]
    pub fn message(&self, ns: u64) -> ros::Log {
        ros::Log {
            stamp: time(ns),
            level: self.level,
            name: self.role.to_string(),
            msg: self.text.clone(),
            file: String::new(),
            function: String::new(),
            line: 0,
        }
    }
}

impl Reasons {
    /// What the guard does now and did not before.
    pub fn command(&mut self, it: &VelocityCommand) -> Option<Reason> {
        let is_news = self.command.replace([it.intervention, it.validity]);
        if is_news == Some([it.intervention, it.validity]) {
            return None;
        }
        let intervention = Intervention::from_code(it.intervention);
        let (v, w) = (it.v_mps, it.w_radps);
        let mut text = match intervention {
            Some(Intervention::None) => "passes the request on".to_owned(),
            other => word(other),
        };
        if matches!(
            intervention,
            Some(Intervention::Slowed | Intervention::StoppedShort)
        ) {
            let ([x, y], clearance) = (it.point_m, it.point_clearance_m);
            let _ = write!(
                text,
                ": point {x:.2}, {y:.2} m in base_link, {clearance:.2} m from the outline, beam {}",
                it.beam
            );
        }
        let _ = write!(text, "; {v:.2} m/s, {w:.2} rad/s");
        let is_calm = matches!(
            intervention,
            Some(Intervention::None | Intervention::Clamped)
        );
        Some(Reason {
            role: Role::CollisionGuard,
            level: if is_calm { INFO } else { WARN },
            text,
        })
    }

    /// What the local planner does now and did not before.
    pub fn request(&mut self, it: &VelocityRequest) -> Option<Reason> {
        let now = [it.validity, it.cause, it.input, it.recovery];
        if self.request.replace(now) == Some(now) {
            return None;
        }
        let mut text = word(it.validity());
        if it.cause() != Some(RequestCause::None) {
            let _ = write!(text, " because: {}", word(it.cause()));
        }
        if it.input() != Some(PlannerInput::None) {
            let _ = write!(text, " ({})", word(it.input()));
        }
        if it.recovery() != Some(RecoveryReason::None) {
            let _ = write!(text, " (recovery: {})", word(it.recovery()));
        }
        let _ = write!(text, "; asks {:.2} m/s, {:.2} rad/s", it.v_mps, it.w_radps);
        if it.limit_mps > 0.0 {
            let _ = write!(text, ", at most {:.2} m/s", it.limit_mps);
        }
        let is_calm = matches!(
            it.validity(),
            Some(Validity::Drive | Validity::AtGoal | Validity::Stopped)
        );
        Some(Reason {
            role: Role::LocalPlanner,
            level: if is_calm { INFO } else { WARN },
            text,
        })
    }

    /// Which path there is now and was not before.
    pub fn path(&mut self, it: &Path) -> Option<Reason> {
        let now = (it.status, it.cause, it.geometry);
        if self.path.replace(now) == Some(now) {
            return None;
        }
        let status = PathStatus::from_code(it.status);
        let mut text = word(status);
        let cause = PathCause::from_code(it.cause);
        if cause != Some(PathCause::None) {
            let _ = write!(text, " because: {}", word(cause));
        }
        if status == Some(PathStatus::Found) {
            let _ = write!(text, "; {:.2} m, cost {:.2}", it.length_m, it.cost);
        }
        let level = match status {
            Some(PathStatus::Found | PathStatus::NoGoal) => INFO,
            _ => WARN,
        };
        Some(Reason {
            role: Role::GlobalPlanner,
            level,
            text,
        })
    }
}

fn word(label: Option<impl Display>) -> String {
    label.map_or_else(|| "unknown".to_owned(), |label| label.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_decided_is_told_when_it_changes() {
        let mut reasons = Reasons::default();
        let mut command = VelocityCommand {
            v_mps: 0.5,
            ..VelocityCommand::default()
        };
        let first = reasons
            .command(&command)
            .expect("news")
            .message(1_500_000_000);
        assert_eq!((&*first.name, first.level), ("collision_guard", INFO));
        assert_eq!(first.msg, "passes the request on; 0.50 m/s, 0.00 rad/s");
        assert_eq!((first.stamp.sec, first.stamp.nanosec), (1, 500_000_000));
        command.v_mps = 0.4;
        assert_eq!(reasons.command(&command), None, "the same");
        command.intervention = Intervention::Slowed.code();
        command.point_m = [0.5, -0.1];
        let slowed = reasons.command(&command).expect("news").message(0);
        assert_eq!(slowed.level, WARN);
        assert!(
            slowed.msg.starts_with("slowed: point 0.50, -0.10 m"),
            "{}",
            slowed.msg
        );

        let mut request = VelocityRequest {
            validity: Validity::Drive.code(),
            cause: RequestCause::Corner.code(),
            limit_mps: 0.3,
            ..VelocityRequest::default()
        };
        let said = reasons.request(&request).expect("news").text;
        assert_eq!(
            said,
            "drive because: corner; asks 0.00 m/s, 0.00 rad/s, at most 0.30 m/s"
        );
        assert_eq!(reasons.request(&request), None);
        request.validity = Validity::Blocked.code();
        assert_eq!(reasons.request(&request).map(|it| it.level), Some(WARN));

        let mut path = Path {
            status: PathStatus::Found.code(),
            cause: PathCause::Obstacle.code(),
            geometry: 4,
            ..Path::default()
        };
        let said = reasons.path(&path).expect("news").text;
        assert_eq!(said, "found because: obstacle; 0.00 m, cost 0.00");
        path.length_m = 2.0;
        assert_eq!(reasons.path(&path), None, "a shorter rest of the same");
        path.geometry = 9;
        assert!(reasons.path(&path).is_some());
    }
}
