//! Keeps what the stages said of why the robot did what it did: a moment for every change of their
//! words, in the order of the ticks whatever the order in which they were heard.

use crate::result::moment::{Command, Moment, Obstacle, Path, Request, Task, Zone, ZoneTold};
use std::collections::{BTreeMap, VecDeque};
use zeronav_msgs::command::{VelocityCommand, VelocityRequest};
use zeronav_msgs::task::TaskState;
use zeronav_msgs::time::seconds;

/// Moments that are kept; the oldest go first.
const MOMENTS_MAX: usize = 1000;

/// Ticks for which a tick is held back: its messages have come by then.
const HOLD_TICKS: u64 = 128;

/// Obstacles of a list that are kept.
const OBSTACLES_MAX: usize = 16;

/// What was said at one tick.
#[derive(Debug, Clone, Default)]
struct Tick {
    run_ns: u64,
    request: Option<VelocityRequest>,
    command: Option<VelocityCommand>,
    path: Option<Path>,
    task: Option<Task>,
    obstacles: Option<Vec<Obstacle>>,
    /// The zones that may make the robot slow, and stand.
    zones: Option<[Option<Zone>; 2]>,
}

/// What the stages said.
#[derive(Debug, Clone, Default)]
pub struct Reasons {
    held: BTreeMap<u64, Tick>,
    /// What holds at the last tick that was taken in.
    now: Moment,
    obstacles: Vec<Obstacle>,
    /// Run time and moment. [ns]
    moments: VecDeque<(u64, Moment)>,
    end_tick: Option<u64>,
    /// Ages of the inputs of the newest request. [ms]
    ages_ms: [u16; 4],
}

impl Reasons {
    /// What was said at a tick. What is said before the first one depends on who began when, and
    /// counts nowhere.
    fn tick(&mut self, tick: u64, run_ns: u64) -> &mut Tick {
        let held = self.held.entry(tick).or_default();
        held.run_ns = held.run_ns.max(run_ns);
        held
    }

    /// The local planner has asked for this.
    pub fn request(&mut self, tick: u64, run_ns: u64, request: &VelocityRequest) {
        self.tick(tick, run_ns).request = Some(*request);
        self.ages_ms = request.ages_ms;
        self.settle_before(tick.saturating_sub(HOLD_TICKS));
    }

    /// Ages of odometry, scan, map and path at the newest request. [ms]
    #[must_use]
    pub const fn ages_ms(&self) -> [u16; 4] {
        self.ages_ms
    }

    /// The guard has let this pass.
    pub fn command(&mut self, tick: u64, run_ns: u64, command: &VelocityCommand) {
        self.tick(tick, run_ns).command = Some(*command);
        // Requests settle what is held, as long as there is a local planner.
        self.settle_before(tick.saturating_sub(2 * HOLD_TICKS));
    }

    /// These zones may make the robot slow, and stand or without a path.
    pub fn zones(&mut self, tick: u64, run_ns: u64, zones: [Option<Zone>; 2]) {
        self.tick(tick, run_ns).zones = Some(zones);
    }

    /// A new path has come, or a new reason why there is none.
    pub fn path(&mut self, tick: u64, run_ns: u64, path: &zeronav_msgs::path::Path) {
        // The times of a moment are those of its run until it is read.
        self.tick(tick, run_ns).path = Path::of(path, Some(seconds(run_ns)));
    }

    /// The task is so, since this tick; 0 = its run time is not known. [ns] That it is active is told
    /// now and then only, so it is news only after an end, and while it waits or has just waited. A local planner without a task is none:
    /// an outcome stays until the next goal, whoever has told it.
    pub fn task(&mut self, tick: u64, run_ns: u64, task: Task) {
        if task.state == TaskState::Idle {
            return;
        }
        let held = self.held.values().rev().find_map(|tick| tick.task);
        let is_told = |task: Task| task.state != TaskState::Active || task.waits();
        if is_told(task) || held.or(self.now.task).is_some_and(is_told) {
            self.tick(tick, run_ns).task = Some(task);
        }
    }

    /// These obstacles are tracked.
    pub fn obstacles(
        &mut self,
        tick: u64,
        run_ns: u64,
        obstacles: &[zeronav_msgs::obstacles::Obstacle],
    ) {
        let kept = obstacles.iter().take(OBSTACLES_MAX).map(Obstacle::of);
        self.tick(tick, run_ns).obstacles = Some(kept.collect());
    }

    /// The run ended at this tick: nothing after it counts. While it is answered launch may already
    /// stop the robot, so its command does not count either.
    pub fn end_at(&mut self, tick: u64) {
        self.end_tick = Some(tick);
    }

    /// The moments from `from_ns` to `until_ns`, with times since `from_ns`.
    #[must_use]
    pub fn moments(&self, from_ns: u64, until_ns: u64) -> Vec<Moment> {
        let mut all = self.clone();
        all.settle_before(u64::MAX);
        let from_s = seconds(from_ns);
        let moments = all.moments.into_iter();
        let inside = moments.filter(|(run_ns, _)| (from_ns..=until_ns).contains(run_ns));
        inside
            .map(|(run_ns, mut moment)| {
                moment.time_s = seconds(run_ns - from_ns);
                if let Some(path) = &mut moment.path {
                    path.time_s = path.time_s.map(|time_s| (time_s - from_s).max(0.0));
                }
                moment
            })
            .collect()
    }

    /// What held at a run time, with the run time since which; `None` when that is not kept. [ns]
    #[must_use]
    pub fn at(&self, run_ns: u64) -> Option<Moment> {
        self.moments(0, run_ns).pop()
    }

    /// Takes in the ticks before this one.
    fn settle_before(&mut self, tick: u64) {
        while let Some(first) = self.held.first_entry().filter(|first| *first.key() < tick) {
            let (tick, mut held) = first.remove_entry();
            let end_tick = self.end_tick.unwrap_or(u64::MAX);
            if tick >= end_tick {
                held.command = None;
            }
            if (1..=end_tick).contains(&tick) {
                self.settle(held);
            }
        }
    }

    fn settle(&mut self, tick: Tick) {
        if let Some(obstacles) = tick.obstacles {
            self.obstacles = obstacles;
        }
        let mut next = self.now.clone();
        next.path = tick.path.or(next.path);
        next.task = tick.task.or(next.task);
        if let Some(request) = &tick.request {
            let mut named = self.obstacles.iter();
            let named = named.find(|obstacle| obstacle.track == request.obstacle);
            let obstacle = named.filter(|_| request.obstacle != 0).copied();
            next.request = Request::of(request, obstacle);
        }
        if let Some(command) = &tick.command {
            next.command = Command::of(command);
        }
        if let Some([slow, keepout]) = tick.zones {
            next.zone = match next.zone_told() {
                Some(ZoneTold::Slow) => slow,
                Some(ZoneTold::Keepout) => keepout,
                None => None,
            };
        }
        if words(&next) != words(&self.now) {
            if self.moments.len() == MOMENTS_MAX {
                self.moments.pop_front();
            }
            self.moments.push_back((tick.run_ns, next.clone()));
        }
        self.now = next;
    }
}

/// What makes a moment another one: words, not numbers.
fn words(moment: &Moment) -> impl PartialEq + use<> {
    let request = moment.request.as_ref();
    let command = moment.command.as_ref();
    let path = moment.path.as_ref();
    (
        request.map(|said| (said.validity, said.cause, said.input, said.recovery)),
        command.map(|said| (said.validity, said.intervention)),
        path.map(|said| {
            (
                said.status,
                said.cause,
                said.block,
                said.time_s.map(f64::to_bits),
            )
        }),
        moment.zone.as_ref().map(|zone| zone.name.clone()),
        moment.task.map(|said| {
            let block = said.blocked.map(|blocked| blocked.block);
            (said.state, said.reason, said.stuck, block, said.waits())
        }),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_casts::Cast;
    use zeronav_msgs::command::{Intervention, RequestCause, Validity};
    use zeronav_msgs::task::{EndReason, StuckCause};

    const TICK_NS: u64 = 20_000_000;

    fn request(cause: RequestCause, v_mps: f64) -> VelocityRequest {
        VelocityRequest {
            v_mps,
            validity: Validity::Drive.code(),
            cause: cause.code(),
            obstacle: 7,
            ..VelocityRequest::default()
        }
    }

    fn say(reasons: &mut Reasons, tick: u64, cause: RequestCause, does: Intervention) {
        let run_ns = tick * TICK_NS;
        let command = VelocityCommand {
            intervention: does.code(),
            ..VelocityCommand::default()
        };
        // The guard is heard first now and then.
        if tick.is_multiple_of(2) {
            reasons.command(tick, run_ns, &command);
        }
        reasons.request(tick, run_ns, &request(cause, tick.to_f64()));
        if tick % 2 == 1 {
            reasons.command(tick, run_ns, &command);
        }
    }

    #[test]
    fn a_moment_is_kept_for_every_change_of_words() {
        let mut reasons = Reasons::default();
        for tick in 1..=200 {
            let cause = if tick < 50 {
                RequestCause::Free
            } else {
                RequestCause::Goal
            };
            let does = if (100..110).contains(&tick) {
                Intervention::Slowed
            } else {
                Intervention::None
            };
            say(&mut reasons, tick, cause, does);
        }
        let moments = reasons.moments(TICK_NS, 300 * TICK_NS);
        let told: Vec<(f64, RequestCause, Intervention)> = (moments.iter())
            .map(|moment| {
                let request = moment.request.as_ref().expect("a request");
                let command = moment.command.as_ref().expect("a command");
                (
                    (50.0 * moment.time_s).round() + 1.0,
                    request.cause,
                    command.intervention,
                )
            })
            .collect();
        let expected = [
            (1.0, RequestCause::Free, Intervention::None),
            (50.0, RequestCause::Goal, Intervention::None),
            (100.0, RequestCause::Goal, Intervention::Slowed),
            (110.0, RequestCause::Goal, Intervention::None),
        ];
        assert_eq!(told, expected);
    }

    #[test]
    fn a_request_names_its_obstacle_and_moments_are_bounded() {
        let mut reasons = Reasons::default();
        let obstacle = |track, x_m| zeronav_msgs::obstacles::Obstacle {
            track,
            x_m,
            vx_mps: 0.9,
            ..zeronav_msgs::obstacles::Obstacle::default()
        };
        reasons.obstacles(1, TICK_NS, &[obstacle(3, 1.0), obstacle(7, 2.0)]);
        for tick in 1..=1500_u64 {
            let cause = if tick.is_multiple_of(2) {
                RequestCause::Free
            } else {
                RequestCause::Goal
            };
            say(&mut reasons, tick, cause, Intervention::None);
        }
        let moments = reasons.moments(0, u64::MAX);
        assert_eq!(moments.len(), MOMENTS_MAX);
        let last = moments.last().and_then(|last| last.request.clone());
        let named = last
            .and_then(|request| request.obstacle)
            .expect("its obstacle");
        assert_eq!(named.track, 7);
        assert!((named.speed_mps - 0.9).abs() < 1e-12);
        // The words of tick 1200 held until the next one's.
        let held = reasons
            .at(1200 * TICK_NS + TICK_NS / 2)
            .expect("it is kept");
        assert!((held.time_s - 24.0).abs() < 1e-9, "{held:?}");
        assert_eq!(held.request.expect("a request").cause, RequestCause::Free);
        assert_eq!(reasons.at(100 * TICK_NS), None, "the oldest are gone");
    }

    #[test]
    fn an_outcome_stays_until_the_next_goal_whoever_answers() {
        let task = |state| Task {
            state,
            reason: EndReason::None,
            stuck: StuckCause::None,
            blocked: None,
            waits_s: 0,
        };
        let mut reasons = Reasons::default();
        let mut state_after = |tick: u64, state| {
            reasons.task(tick, tick * TICK_NS, task(state));
            say(&mut reasons, tick, RequestCause::None, Intervention::None);
            let moment = reasons.at(tick * TICK_NS).expect("it is kept");
            moment.task.map(|task| task.state)
        };
        assert_eq!(state_after(1, TaskState::Active), None, "no news");
        for (tick, outcome) in [(100, TaskState::Failed), (200, TaskState::Reached)] {
            assert_eq!(state_after(tick, outcome), Some(outcome));
            // A successor has no task.
            assert_eq!(state_after(tick + 1, TaskState::Idle), Some(outcome));
            let next = state_after(tick + 2, TaskState::Active);
            assert_eq!(next, Some(TaskState::Active), "the next goal");
        }
    }

    #[test]
    fn without_a_local_planner_nothing_piles_up() {
        let mut reasons = Reasons::default();
        for tick in 1..=5000 {
            reasons.command(tick, tick * TICK_NS, &VelocityCommand::default());
        }
        assert!(reasons.held.len() <= 300, "{}", reasons.held.len());
        assert_eq!(reasons.moments(0, u64::MAX).len(), 1);
    }
}
