//! The seats of a stack.

use crate::codes;

codes! {
    /// Who a process is. A role is a seat: whatever binary sits there keeps the seat's contract.
    pub enum Role: u16 {
        /// The supervisor: creates the topics, sends goals, reads spans and health.
        Launch = 1 => "launch",
        /// The robot, simulated or real: sensors out, velocity commands in.
        Robot = 2 => "robot",
        /// Scans and odometry to a map.
        Mapping = 3 => "mapping",
        /// Map and goal to a path.
        GlobalPlanner = 4 => "global_planner",
        /// Path, map and scan to a velocity request.
        LocalPlanner = 5 => "local_planner",
        /// The last check before the wheels.
        CollisionGuard = 6 => "collision_guard",
        /// A guest that only reads, such as a recorder or a viewer.
        Tap = 7 => "tap",
    }
}

impl Role {
    /// The roles that run as services, in the order of the data flow.
    pub const SERVICES: [Self; 5] = [
        Self::Robot,
        Self::Mapping,
        Self::GlobalPlanner,
        Self::LocalPlanner,
        Self::CollisionGuard,
    ];

    /// The role with this label.
    #[must_use]
    pub fn from_label(label: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|role| role.label() == label)
    }

    /// Name of the role's doorbell, an event service of the domain.
    #[must_use]
    pub fn doorbell(self) -> String {
        format!("doorbell/{}", self.label())
    }
}
