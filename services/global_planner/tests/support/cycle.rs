//! A planner process without the process: cycles on a drawn map.

#![allow(dead_code, reason = "every test uses its own part")]

use super::{Map, of_cost};
use zeronav_global_planner::{
    Control, GlobalPlannerConfig, News, Replanner, Request, Situation, Step, Target,
};
use zeronav_msgs::path::{Path, PathCause, PathStatus};
use zeronav_msgs::{Cell, CellRect, Pose};

/// What such a process holds.
pub(crate) struct Bench {
    pub(crate) replanner: Replanner,
    pub(crate) map: Map,
    pub(crate) revision: u64,
    pub(crate) changed: Vec<CellRect>,
    pub(crate) robot: Pose,
    pub(crate) target: Option<Target>,
    pub(crate) request: Option<Request>,
    pub(crate) messages: u64,
}

impl Bench {
    /// With the robot at S and goal 1 of task 7 at G.
    pub(crate) fn new(text: &str) -> (Self, impl Fn(char) -> Cell) {
        let (map, at) = Map::drawn(text);
        let config = GlobalPlannerConfig::default();
        let bench = Self {
            replanner: Replanner::new(&config).unwrap(),
            robot: map.pose(at('S')),
            target: Some(Target {
                task: 7,
                goal: 1,
                pose: map.pose(at('G')),
                tolerance_m: 0.04,
            }),
            map,
            revision: 1,
            changed: Vec::new(),
            request: None,
            messages: 0,
        };
        (bench, at)
    }

    pub(crate) fn situation(&self) -> Situation<'_> {
        Situation {
            robot: self.robot,
            map: Some(self.map.view()),
            revision: self.revision,
            changed: &self.changed,
            target: self.target,
            request: self.request,
        }
    }

    /// A map update that gives these cells a cost.
    pub(crate) fn update(&mut self, cells: &[Cell], cost: u8) {
        self.revision += 1;
        self.changed.clear();
        for cell in cells {
            self.map.put(*cell, of_cost(cost));
            let max = Cell::new(cell.x + 1, cell.y + 1);
            self.changed.push(CellRect { min: *cell, max });
        }
    }

    /// One cycle without anything coming in between; what was searched for and what came out.
    pub(crate) fn cycle(&mut self) -> (Vec<PathCause>, News) {
        self.cycle_with(|_| {})
    }

    /// One cycle with `meanwhile` between search and settling.
    pub(crate) fn cycle_with(
        &mut self,
        mut meanwhile: impl FnMut(&mut Self),
    ) -> (Vec<PathCause>, News) {
        let mut replanner = core::mem::replace(
            &mut self.replanner,
            Replanner::new(&GlobalPlannerConfig::default()).unwrap(),
        );
        let mut causes = Vec::new();
        let mut step = replanner.begin(&self.situation());
        let news = loop {
            match step {
                Step::Publish(news) => break news,
                Step::Search(cause) => {
                    causes.push(cause);
                    assert!(causes.len() <= 2, "searched more than twice in a cycle");
                    replanner.search(&self.situation(), &mut |_| Control::Go);
                    meanwhile(self);
                    step = replanner.settle(&self.situation());
                }
            }
        };
        self.messages += 1;
        if news == News::New {
            replanner.name_geometry(self.messages);
        }
        self.replanner = replanner;
        self.check_message();
        (causes, news)
    }

    /// Whatever happens, what would be published is a valid message.
    pub(crate) fn check_message(&self) {
        let plan = self.replanner.plan();
        let mut message = Path::default();
        plan.fill(&mut message);
        message.check(&plan.waypoints).unwrap();
        assert_eq!(message.planner(), GlobalPlannerConfig::default().planner);
        assert_eq!(message.goal, plan.target.map_or(0, |target| target.goal));
    }

    #[track_caller]
    pub(crate) fn expect_new(&mut self, cause: PathCause, status: PathStatus) {
        let (causes, news) = self.cycle();
        assert_eq!((causes, news), (vec![cause], News::New));
        assert_eq!(self.replanner.plan().cause, cause);
        assert_eq!(self.replanner.plan().status, status);
    }

    #[track_caller]
    pub(crate) fn expect_unchanged(&mut self) {
        let before = self.replanner.plan().geometry;
        assert_eq!(self.cycle(), (vec![], News::Unchanged));
        assert_eq!(self.replanner.plan().geometry, before);
    }

    pub(crate) fn path(&self) -> &[Cell] {
        &self.replanner.plan().cells.cells
    }
}

/// A pillar in a room.
pub(crate) const ROOM: &str = "S.........
                    ..........
                    .....#....
                    ..........
                    .........G";
