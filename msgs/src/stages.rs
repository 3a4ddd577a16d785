//! The stages of a cycle: the big parts of the work behind an answer, and what takes their times.
//!
//! An algorithm marks the end of each stage on a [`StageTimer`] that is handed to it, and reads no
//! clock itself: by default the timer is off, and a mark does nothing.

use crate::role::Role;

/// Most stages of a cycle.
pub const STAGES_MAX: usize = 4;

/// A big part of the work of a role. In a cycle the stages run in the order of [`Self::of`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Robot: moves the simulated robot and its world.
    Step,
    /// Robot: casts the rays of the lidar.
    Cast,
    /// Mapping: places the beams and corrects the pose.
    Localise,
    /// Mapping: follows what moves.
    Track,
    /// Mapping: casts the beams into the grid of beliefs.
    Integrate,
    /// Mapping: clearance and cost of the cells that changed, and regularisation.
    Clearance,
    /// Global planner: takes in the map, and decides whether to search.
    Map,
    /// Global planner: the search.
    Search,
    /// Global planner: rounds the path and makes its waypoints.
    Smooth,
    /// Global planner: holds the path against the newest map.
    Settle,
    /// Local planner: the scan in the robot's frame, task and path.
    Prepare,
    /// Local planner: gathers what is near the robot.
    Look,
    /// Local planner: the controller's choice, by rollouts, a search or a law.
    Rollouts,
    /// Local planner: checks that the robot can stop from the command.
    Verify,
}

impl Stage {
    /// The stages of a role, in the order in which they run; at most [`STAGES_MAX`].
    #[must_use]
    pub const fn of(role: Role) -> &'static [Self] {
        match role {
            Role::Robot => &[Self::Step, Self::Cast],
            Role::Mapping => &[
                Self::Localise,
                Self::Track,
                Self::Integrate,
                Self::Clearance,
            ],
            Role::GlobalPlanner => &[Self::Map, Self::Search, Self::Smooth, Self::Settle],
            Role::LocalPlanner => &[Self::Prepare, Self::Look, Self::Rollouts, Self::Verify],
            _ => &[],
        }
    }

    /// Its place among the stages of its role.
    #[must_use]
    pub const fn place(self) -> usize {
        match self {
            Self::Step | Self::Localise | Self::Map | Self::Prepare => 0,
            Self::Cast | Self::Track | Self::Search | Self::Look => 1,
            Self::Integrate | Self::Smooth | Self::Rollouts => 2,
            Self::Clearance | Self::Settle | Self::Verify => 3,
        }
    }

    /// Words for people.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::Cast | Self::Integrate => "ray casting",
            Self::Localise => "localise",
            Self::Track => "track",
            Self::Clearance => "clearance",
            Self::Map => "map",
            Self::Search => "search",
            Self::Smooth => "smooth",
            Self::Settle => "settle",
            Self::Prepare => "prepare",
            Self::Look => "look",
            Self::Rollouts => "rollouts",
            Self::Verify => "verify",
        }
    }
}

/// Takes the times of the stages of one cycle.
#[derive(Debug, Clone, Copy, Default)]
pub struct StageTimer {
    /// `None` = off.
    clock: Option<fn() -> u64>,
    /// The end of the stage before. [ns]
    last_ns: u64,
    stages_ns: [u32; STAGES_MAX],
}

impl StageTimer {
    /// A timer of a cycle that began at `started_ns` of `clock`. [ns]
    #[must_use]
    pub const fn new(clock: fn() -> u64, started_ns: u64) -> Self {
        Self {
            clock: Some(clock),
            last_ns: started_ns,
            stages_ns: [0; STAGES_MAX],
        }
    }

    /// A stage ends here: the time since the mark before, or since the beginning, is added to it.
    #[inline]
    pub fn mark(&mut self, stage: Stage) {
        if let Some(clock) = self.clock {
            let now_ns = clock();
            let took_ns = now_ns.saturating_sub(self.last_ns);
            self.last_ns = now_ns;
            let sum_ns = &mut self.stages_ns[stage.place()];
            *sum_ns = sum_ns.saturating_add(u32::try_from(took_ns).unwrap_or(u32::MAX));
        }
    }

    /// The time of each stage so far. [ns]
    #[must_use]
    pub const fn stages_ns(&self) -> [u32; STAGES_MAX] {
        self.stages_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn every_stage_has_the_place_in_which_it_is_listed() {
        let mut places = 0;
        for role in Role::SERVICES {
            for (place, stage) in Stage::of(role).iter().enumerate() {
                assert_eq!(stage.place(), place, "{stage:?}");
                assert!(place < STAGES_MAX);
                places += 1;
            }
        }
        assert_eq!(
            places,
            Stage::Verify as usize + 1,
            "no stage without a role"
        );
    }

    #[test]
    fn a_mark_adds_the_time_since_the_one_before() {
        static NOW_NS: AtomicU64 = AtomicU64::new(0);
        fn clock() -> u64 {
            NOW_NS.load(Ordering::Relaxed)
        }
        let mut timer = StageTimer::new(clock, 100);
        let mut off = StageTimer::default();
        for (now_ns, stage) in [
            (130, Stage::Map),
            (180, Stage::Search),
            (190, Stage::Settle),
            (1190, Stage::Search),
            // A clock that goes backwards, and one that was stopped for long.
            (1000, Stage::Settle),
            (u64::MAX, Stage::Smooth),
        ] {
            NOW_NS.store(now_ns, Ordering::Relaxed);
            timer.mark(stage);
            off.mark(stage);
        }
        assert_eq!(timer.stages_ns(), [30, 1050, u32::MAX, 10]);
        assert_eq!(off.stages_ns(), [0; STAGES_MAX]);
    }
}
