//! From the command to the first motion: who waited for whom.
//!
//! Every stage needs others; it can begin when the last of them is done, and that one it waited for.
//! Followed back from the first motion, this is the critical chain, and its stages add up.

use super::index::Records;
use crate::result::start_up::{Stage, StartUp};
use std::collections::BTreeMap;
use zeronav_msgs::path::PathStatus;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};

/// Moments of the start that launch itself notes, monotonic. [ns]
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[allow(clippy::struct_field_names, reason = "every time has its unit")]
pub struct StartStamps {
    /// The command began.
    pub command_ns: u64,
    /// The scenario was read, its world built, its binaries asked.
    pub prepared_ns: u64,
    /// Shared memory and topics were there.
    pub topics_ns: u64,
    /// The configurations were written.
    pub configs_ns: u64,
    /// The process of each seat was started.
    pub started_ns: BTreeMap<Role, u64>,
    /// The goals were sent; 0 = they were not.
    pub goals_ns: u64,
}

/// Stages while they are gathered.
struct Stages {
    command_ns: u64,
    done: Vec<(String, u64)>,
    gathered: Vec<Stage>,
}

impl Stages {
    /// A stage that was done at `at_ns` and needed `needs`; those that are not there need nothing.
    /// Nothing is noted when `at_ns` is `None`.
    fn add(&mut self, name: &str, who: &str, at_ns: Option<u64>, needs: &[&str]) {
        let Some(at_ns) = at_ns else { return };
        let needed = self
            .done
            .iter()
            .filter(|(done, _)| needs.contains(&done.as_str()));
        // What was done later can not have been needed: its message came too late for this one.
        let last = needed
            .filter(|(_, done_ns)| *done_ns <= at_ns)
            .max_by_key(|(_, done_ns)| *done_ns)
            .cloned();
        let from_ns = last
            .as_ref()
            .map_or(self.command_ns, |(_, done_ns)| *done_ns);
        let ms = |ns: u64| {
            let ns = ns.saturating_sub(self.command_ns);
            1.0e3 * zeronav_msgs::time::seconds(ns)
        };
        self.gathered.push(Stage {
            name: name.to_owned(),
            who: who.to_owned(),
            from_ms: ms(from_ns),
            to_ms: ms(at_ns),
            waited_for: last.map(|(name, _)| name),
        });
        self.done.push((name.to_owned(), at_ns));
    }
}

/// The start of a run; `None` when its first records are gone. `first_motion_tick` is the first
/// tick at which the wheels turned.
#[must_use]
pub fn start_up(
    stamps: &StartStamps,
    records: &Records,
    first_motion_tick: Option<u64>,
) -> Option<StartUp> {
    let spans = &records.spans;
    let idle = |role: Role| first(spans, role, |span| span.kind() == Some(SpanKind::Idle));
    // The records begin with the idle outputs; a long run has let them go.
    idle(Role::Robot)?;
    let mut stages = Stages {
        command_ns: stamps.command_ns,
        done: Vec::new(),
        gathered: Vec::new(),
    };
    let launch = Role::Launch.label();
    stages.add("scenario checked", launch, Some(stamps.prepared_ns), &[]);
    let needs = ["scenario checked"];
    stages.add("topics made", launch, Some(stamps.topics_ns), &needs);
    let needs = ["topics made"];
    stages.add(
        "configurations written",
        launch,
        Some(stamps.configs_ns),
        &needs,
    );
    let mut before = "configurations written".to_owned();
    for role in Role::SERVICES {
        let name = format!("{role} started");
        let started_ns = stamps.started_ns.get(&role).copied();
        stages.add(&name, launch, started_ns, &[&before]);
        if started_ns.is_some() {
            before = name;
        }
    }
    for role in Role::SERVICES {
        let ready_ns = idle(role).map(|span| span.published_ns);
        let needs = format!("{role} started");
        stages.add(&format!("{role} ready"), role.label(), ready_ns, &[&needs]);
    }
    let all_ready = Role::SERVICES.map(|role| format!("{role} ready"));
    let needs = all_ready.each_ref().map(String::as_str);
    let goals_ns = (stamps.goals_ns > 0).then_some(stamps.goals_ns);
    stages.add("goals sent", launch, goals_ns, &needs);
    data(&mut stages, records);
    let motion_ns = first_motion_tick.and_then(|tick| {
        let moved = first(spans, Role::Robot, |span| {
            span.tick >= tick && span.kind() == Some(SpanKind::Answer)
        });
        moved.map(|span| span.started_ns)
    });
    let robot = Role::Robot.label();
    stages.add("first motion", robot, motion_ns, &["first command applied"]);
    let mut done = stages.gathered;
    done.sort_by(|a, b| a.to_ms.total_cmp(&b.to_ms));
    let motion = done.iter().find(|stage| stage.name == "first motion");
    Some(StartUp {
        first_motion_ms: motion.map(|stage| stage.to_ms),
        stages: done,
    })
}

/// The first scan, map, path, request and command.
fn data(stages: &mut Stages, records: &Records) {
    let spans = &records.spans;
    let [robot, mapping, global, local, guard] = Role::SERVICES;
    let is_answer = |span: &Span| matches!(span.kind(), Some(SpanKind::Answer | SpanKind::Extra));
    let scan = first(spans, robot, |span| is_answer(span) && span.scan != 0);
    let sent = |span: &Span| span.published_ns;
    let needs = ["robot ready"];
    stages.add("first scan", robot.label(), scan.map(sent), &needs);
    let map = first(spans, mapping, |span| {
        is_answer(span) && span.scan != 0 && span.output != 0
    });
    let needs = ["mapping ready", "first scan"];
    stages.add("first map", mapping.label(), map.map(sent), &needs);
    let found = records
        .paths
        .iter()
        .find(|path| path.status == PathStatus::Found);
    let path = found.and_then(|found| first(spans, global, |span| span.output == found.id));
    let needs = ["global_planner ready", "first map", "goals sent"];
    stages.add("first path", global.label(), path.map(sent), &needs);
    let Some(path) = path else { return };
    let request = first(spans, local, |span| {
        span.path >= path.output && span.output != 0
    });
    let needs = ["local_planner ready", "first path"];
    stages.add("first request", local.label(), request.map(sent), &needs);
    let Some(request) = request else { return };
    let command = first(spans, guard, |span| {
        span.request >= request.output && span.output != 0
    });
    let needs = ["collision_guard ready", "first request"];
    stages.add("first command", guard.label(), command.map(sent), &needs);
    let Some(command) = command else { return };
    let applied = first(spans, robot, |span| {
        span.kind() == Some(SpanKind::Applied) && span.request >= command.output
    });
    let applied_ns = applied.map(|span| span.started_ns);
    let needs = ["first command"];
    stages.add("first command applied", robot.label(), applied_ns, &needs);
}

/// The first record of `role` of which `is` holds.
fn first(spans: &[Span], role: Role, is: impl Fn(&Span) -> bool) -> Option<&Span> {
    spans
        .iter()
        .find(|span| span.role == role.code() && is(span))
}

impl StartUp {
    /// The stages that nothing could have been done without, from the first one to the first motion,
    /// or to what was done last.
    #[must_use]
    pub fn critical_chain(&self) -> Vec<&Stage> {
        let named = |name: &str| self.stages.iter().find(|stage| stage.name == name);
        let mut chain = Vec::new();
        let mut next = named("first motion").or(self.stages.last());
        while let Some(stage) = next.filter(|_| chain.len() < self.stages.len()) {
            chain.push(stage);
            next = stage.waited_for.as_deref().and_then(named);
        }
        chain.reverse();
        chain
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::index::PathRecord;
    use zeronav_msgs::path::PathCause;

    const MS: u64 = 1_000_000;

    fn span(role: Role, kind: SpanKind, output: u64, at_ms: u64) -> Span {
        Span {
            role: role.code(),
            kind: kind.code(),
            epoch: 1,
            output,
            started_ns: at_ms * MS,
            published_ns: at_ms * MS,
            ..Span::default()
        }
    }

    /// A start in which `planner_ready_ms` is when the global planner is ready.
    fn start(planner_ready_ms: u64) -> StartUp {
        let [robot, mapping, global, local, guard] = Role::SERVICES;
        let (idle, answer) = (SpanKind::Idle, SpanKind::Answer);
        let goals_ms = planner_ready_ms.max(1130);
        let path_ms = goals_ms + 100;
        let mut records = Records::default();
        for (role, at_ms) in [
            (robot, 1100),
            (mapping, 1130),
            (global, planner_ready_ms),
            (local, 1120),
            (guard, 1110),
        ] {
            records.spans.push(span(role, idle, 1, at_ms));
        }
        records.spans.extend([
            Span {
                scan: 1,
                tick: 1,
                ..span(robot, answer, 2, 1150)
            },
            Span {
                scan: 1,
                ..span(mapping, answer, 2, 1160)
            },
            Span {
                map: 2,
                ..span(global, answer, 2, path_ms)
            },
            Span {
                path: 2,
                ..span(local, answer, 2, path_ms + 2)
            },
            Span {
                request: 2,
                ..span(guard, answer, 2, path_ms + 3)
            },
            Span {
                request: 2,
                ..span(robot, SpanKind::Applied, 0, path_ms + 4)
            },
            Span {
                tick: 9,
                ..span(robot, answer, 3, path_ms + 20)
            },
        ]);
        records.paths.push(PathRecord {
            id: 2,
            map: 2,
            run_ns: 0,
            status: PathStatus::Found,
            cause: PathCause::Goal,
            planner: String::new(),
            length_m: 1.0,
            beside_goal_m: 0.0,
            expanded: 0,
            points_m: Vec::new(),
        });
        let started = |(role, at_ms): (Role, u64)| (role, at_ms * MS);
        let started_ns = Role::SERVICES.into_iter().zip(1055..).map(started);
        let stamps = StartStamps {
            command_ns: 1000 * MS,
            prepared_ns: 1030 * MS,
            topics_ns: 1045 * MS,
            configs_ns: 1050 * MS,
            started_ns: started_ns.collect(),
            goals_ns: goals_ms * MS,
        };
        start_up(&stamps, &records, Some(9)).expect("a start")
    }

    fn chain(start: &StartUp) -> Vec<&str> {
        let chain = start.critical_chain();
        let mut at_ms = 0.0;
        for stage in &chain {
            assert!(
                (stage.from_ms - at_ms).abs() < 1.0e-6,
                "a gap before {stage:?}"
            );
            at_ms = stage.to_ms;
        }
        assert_eq!(Some(at_ms), start.first_motion_ms, "the stages add up");
        chain.iter().map(|stage| stage.name.as_str()).collect()
    }

    #[test]
    fn the_chain_leads_through_the_service_that_was_ready_last() {
        let slow = start(1900);
        let names = chain(&slow);
        assert!(names.contains(&"global_planner ready") && names.contains(&"goals sent"));
        assert!(!names.contains(&"first map"), "{names:?}");
        assert_eq!(names.first(), Some(&"scenario checked"));
        // With a quick planner the first map is what it waits for.
        let quick = start(1105);
        let names = chain(&quick);
        assert!(
            names.contains(&"first map") && names.contains(&"first scan"),
            "{names:?}"
        );
        assert!(names.contains(&"robot ready"), "{names:?}");
    }

    #[test]
    fn without_motion_or_without_its_records_nothing_is_made_up() {
        let mut records = Records::default();
        let stamps = StartStamps::default();
        assert_eq!(start_up(&stamps, &records, None), None);
        records.spans.push(span(Role::Robot, SpanKind::Idle, 1, 5));
        let start = start_up(&stamps, &records, None).expect("a start");
        assert_eq!(start.first_motion_ms, None);
        let last = start.critical_chain().pop().expect("a stage");
        assert_eq!(last.name, "robot ready");
    }
}
