//! How the process in a seat is, by its heartbeat.

use zeronav_msgs::header::Header;
use zeronav_msgs::health::{
    Health, HealthState, REASON_CLOCK, REASON_LINK, REASON_ODOMETRY, REASON_PUBLISHERS,
    REASON_SCAN, REASON_TRANSFORM, SILENT_AFTER_NS, reason_labels,
};
use zeronav_msgs::role::Role;

/// Why a robot that is no simulation stands, in words after its name; the worst first. Lists of reasons have
/// the labels of [`reason_labels`].
const STANDS: [(u32, &str); 5] = [
    (
        REASON_PUBLISHERS,
        "is told by two nodes, which both publish scans or odometry, and stands",
    ),
    (
        REASON_CLOCK,
        "has a clock that was set or stands still, and stands",
    ),
    (
        REASON_TRANSFORM,
        "sends no transforms that say where its lidar is, and stands",
    ),
    (REASON_ODOMETRY, "sends no odometry, and stands"),
    (REASON_SCAN, "sends no scans, and stands"),
];

/// How the process in a seat is at a moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Condition {
    /// None has beaten yet.
    Absent,
    /// Its newest heartbeat is older than [`SILENT_AFTER_NS`].
    Silent,
    /// What its newest heartbeat says; `None` = a state that this program does not know.
    Beats(Option<HealthState>),
}

impl Condition {
    /// Its word.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Absent => "absent",
            Self::Silent => "silent",
            Self::Beats(Some(state)) => state.label(),
            Self::Beats(None) => "unknown",
        }
    }
}

/// The newest heartbeat of a seat.
#[derive(Debug, Clone, Copy, Default)]
pub struct Heart {
    /// What it says.
    pub beat: Health,
    /// Which start of the seat it is of; 0 = none has beaten yet.
    pub epoch: u32,
    /// When it was sent, monotonic. [ns]
    pub beaten_ns: u64,
}

impl Heart {
    /// After this heartbeat.
    #[must_use]
    pub const fn of(header: &Header, beat: &Health) -> Self {
        Self {
            beat: *beat,
            epoch: header.id().epoch(),
            beaten_ns: header.stamps.published_ns,
        }
    }

    /// How the process is at a moment. [ns]
    #[must_use]
    pub const fn condition(&self, now_ns: u64) -> Condition {
        if self.epoch == 0 {
            Condition::Absent
        } else if self.beaten_ns.saturating_add(SILENT_AFTER_NS) < now_ns {
            Condition::Silent
        } else {
            Condition::Beats(self.beat.state())
        }
    }

    /// Why it is degraded: a word for each reason.
    #[must_use]
    pub fn reasons(&self) -> Vec<&'static str> {
        reason_labels(self.beat.reasons)
    }

    /// True when the way to the host of the process is cut: only the link says that it lives.
    #[must_use]
    pub const fn is_cut(&self) -> bool {
        self.beat.reasons & REASON_LINK != 0
    }

    /// Why the process in the seat of `role` makes the robot stand, in words after its name.
    #[must_use]
    pub fn stands(&self, role: Role) -> Option<&'static str> {
        let named = STANDS.iter().filter(|_| role == Role::Robot);
        let mut named = named.filter(|(bit, _)| self.beat.reasons & bit != 0);
        named.next().map(|(_, words)| *words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::header::Id;

    fn heart(state: HealthState, reasons: u32) -> Heart {
        let mut header = Header {
            id: Id::new(2, 1).0,
            ..Header::default()
        };
        header.stamps.published_ns = 1_000_000_000;
        let beat = Health {
            state: state.code(),
            reasons,
            ..Health::default()
        };
        Heart::of(&header, &beat)
    }

    #[test]
    fn a_heart_beats_until_half_a_second_is_over() {
        assert_eq!(Heart::default().condition(9).label(), "absent");
        let ready = heart(HealthState::Ready, 0);
        assert_eq!(ready.condition(1_500_000_000).label(), "ready");
        assert_eq!(ready.condition(1_500_000_001), Condition::Silent);
    }

    #[test]
    fn the_worst_reason_of_a_robot_to_stand_is_named() {
        let two = heart(HealthState::Degraded, REASON_TRANSFORM | REASON_PUBLISHERS);
        assert_eq!(two.reasons(), ["transform", "publishers"]);
        let said = two.stands(Role::Robot).expect("two reasons");
        assert!(said.contains("two nodes"), "{said}");
        assert_eq!(two.stands(Role::Mapping), None);
        let one = heart(HealthState::Degraded, REASON_TRANSFORM);
        let said = one.stands(Role::Robot).expect("a reason");
        assert!(said.contains("where its lidar is"), "{said}");
        assert_eq!(heart(HealthState::Ready, 0).stands(Role::Robot), None);
        assert!(heart(HealthState::Degraded, REASON_LINK).is_cut());
    }
}
