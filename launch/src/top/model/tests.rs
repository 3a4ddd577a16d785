use super::*;
use crate::control::request::{CompanionReport, ServiceReport};
use zeronav_measure::result::Restart;
use zeronav_measure::result::fault::FaultResult;
use zeronav_msgs::header::Id;
use zeronav_msgs::health::{REASON_MAP, REASON_SCAN, SILENT_AFTER_NS};
use zeronav_msgs::path::Waypoint;

const S: u64 = 1_000_000_000;

fn header(role: Role, epoch: u32, count: u64, at_ns: u64) -> Header {
    let mut header = Header {
        role: role.code(),
        id: Id::new(epoch, count).0,
        tick: count,
        run_ns: at_ns,
        ..Header::default()
    };
    header.stamps.published_ns = at_ns;
    header
}

fn beat(epoch: u32, at_ns: u64, state: HealthState, reasons: u32) -> Heard {
    let beat = Health {
        state: state.code(),
        reasons,
        pid: 70 + epoch,
        refused: 3,
        superseded: 4,
        ..Health::default()
    };
    Heard::Beat(header(Role::Mapping, epoch, 1, at_ns), beat)
}

fn model() -> Model {
    Model::new(vec!["a"], false)
}

fn mapping(model: &Model, now_ns: u64) -> ServiceLine {
    let view = model.view(now_ns);
    let line = view
        .services
        .into_iter()
        .find(|line| line.role == "mapping");
    line.expect("its line")
}

fn events(model: &Model) -> Vec<String> {
    let events = model.view(0).events;
    let line = |event: crate::top::view::EventLine| format!("{} {}", event.kind, event.text);
    events.into_iter().map(line).collect()
}

#[test]
fn a_seat_shows_its_heartbeat_until_that_is_too_old() {
    let mut model = model();
    assert_eq!(mapping(&model, 0).state, "absent");
    model.ingest(&beat(1, S, HealthState::Ready, 0));
    let line = mapping(&model, S + SILENT_AFTER_NS);
    assert_eq!((line.state, line.epoch), ("ready", 1));
    assert_eq!((line.rejected, line.superseded), (3, 4));
    assert_eq!(line.restarts, None, "the stack has said nothing yet");
    assert_eq!(mapping(&model, S + SILENT_AFTER_NS + 1).state, "silent");
    model.ingest(&beat(
        1,
        2 * S,
        HealthState::Degraded,
        REASON_SCAN | REASON_MAP,
    ));
    let line = mapping(&model, 2 * S);
    assert_eq!(line.reasons, ["scan", "map"]);
    assert_eq!(events(&model), ["state mapping: degraded (scan, map)"]);
}

#[test]
fn a_successor_is_an_event_and_the_restarts_come_from_the_stack() {
    let mut model = model();
    model.ingest(&beat(1, S, HealthState::Ready, 0));
    model.read(Whose::Seat(Role::Mapping), Some(reading(71, S, 0)));
    model.read(Whose::Seat(Role::Mapping), Some(reading(71, 2 * S, S / 2)));
    assert_eq!(mapping(&model, S).usage.cpu_percent, Some(50.0));
    model.ingest(&beat(2, 2 * S, HealthState::Ready, 0));
    model.read(Whose::Seat(Role::Mapping), Some(reading(72, 3 * S, 5)));
    let report = RunReport {
        services: vec![ServiceReport {
            role: "mapping".to_owned(),
            restarts: 1,
            ..ServiceReport::default()
        }],
        restarts: vec![Restart {
            service: "mapping".to_owned(),
            time_s: 1.5,
            how: "killed by signal 9".to_owned(),
            wait_ms: 0,
        }],
        ..RunReport::default()
    };
    model.report(report.clone());
    model.report(report);
    let line = mapping(&model, 2 * S);
    assert_eq!((line.epoch, line.restarts), (2, Some(1)));
    assert_eq!((line.usage.pid, line.usage.cpu_percent), (72, None));
    let said = events(&model);
    assert_eq!(said.len(), 2, "each is said once: {said:?}");
    assert!(
        said.contains(&"state mapping: epoch 2 after 1".to_owned()),
        "{said:?}"
    );
    assert!(
        said.contains(&"restart mapping: killed by signal 9".to_owned()),
        "{said:?}"
    );
    model.read(Whose::Seat(Role::Mapping), None);
    assert_eq!(
        mapping(&model, 2 * S).usage.memory_bytes,
        None,
        "it is gone"
    );
}

fn reading(pid: u32, at_ns: u64, processor_ns: u64) -> Reading {
    Reading {
        pid,
        at_ns,
        processor_ns,
        memory_bytes: 1,
    }
}

#[test]
fn a_repeated_path_is_no_event() {
    let mut model = model();
    let points = [
        Waypoint::default(),
        Waypoint {
            x_m: 3.0,
            ..Waypoint::default()
        },
    ];
    let mut path = Path::new("astar", PathStatus::Found, PathCause::Obstacle, 1, &points);
    let first = header(Role::GlobalPlanner, 1, 5, S);
    path.geometry = first.id;
    model.ingest(&Heard::Path(first, path));
    model.ingest(&Heard::Path(header(Role::GlobalPlanner, 1, 6, 2 * S), path));
    assert_eq!(
        events(&model),
        ["path found, 3.0 m by astar, cause obstacle"]
    );
}

#[test]
fn faults_tasks_and_interventions_are_told_as_they_change() {
    let mut model = model();
    let mut fault = FaultResult {
        id: 1,
        kind: "slow".to_owned(),
        target: "mapping".to_owned(),
        figures: "20 ms".to_owned(),
        time_s: 0.5,
        ..FaultResult::default()
    };
    let report = |fault: &FaultResult| RunReport {
        faults: vec![fault.clone()],
        ..RunReport::default()
    };
    model.report(report(&fault));
    fault.until_s = Some(0.8);
    model.report(report(&fault));
    model.report(report(&fault));
    let task = |state: TaskState, reason: EndReason| TaskStatus {
        state: state.code(),
        reason: reason.code(),
        remaining_m: 4.0,
        ..TaskStatus::default()
    };
    let at = |count| header(Role::LocalPlanner, 1, count, count * S);
    let active = task(TaskState::Active, EndReason::None);
    model.ingest(&Heard::Task(at(1), active));
    model.ingest(&Heard::Task(at(2), active));
    assert_eq!(model.view(0).run.remaining_m, Some(4.0));
    let command = |why: Intervention| VelocityCommand {
        intervention: why.code(),
        ..VelocityCommand::default()
    };
    for (count, why) in [(3, Intervention::None), (4, Intervention::Slowed)] {
        model.ingest(&Heard::Command(at(count), command(why)));
    }
    model.ingest(&Heard::Task(
        at(5),
        task(TaskState::Failed, EndReason::Stuck),
    ));
    assert_eq!(model.view(0).run.remaining_m, None);
    let expected = [
        "fault slow mapping 20 ms",
        "fault slow mapping 20 ms is over",
        "task active",
        "guard slowed",
        "task failed: stuck",
    ];
    assert_eq!(events(&model), expected);
}

#[test]
fn companions_come_from_the_stack_with_what_they_take() {
    let mut model = model();
    let report = |pid, starts| RunReport {
        companions: vec![CompanionReport {
            name: "page".to_owned(),
            pid,
            state: "running".to_owned(),
            starts,
            ..CompanionReport::default()
        }],
        ..RunReport::default()
    };
    let page = || Whose::Companion("page".to_owned());
    model.report(report(71, 1));
    assert!(model.pids().contains(&(page(), 71)));
    model.read(page(), Some(reading(71, S, 0)));
    model.read(page(), Some(reading(71, 2 * S, S / 2)));
    let line = model.view(0).companions.remove(0);
    assert_eq!((line.name.as_str(), line.restarts), ("page", 0));
    assert_eq!((line.usage.pid, line.usage.cpu_percent), (71, Some(50.0)));
    model.report(report(72, 2));
    let line = model.view(0).companions.remove(0);
    assert_eq!((line.usage.pid, line.restarts), (72, 1));
    assert_eq!(line.usage.memory_bytes, None, "the old process is not it");
    model.report(report(0, 2));
    assert!(!model.pids().iter().any(|(whose, _)| *whose == page()));
    model.report(RunReport::default());
    assert_eq!(model.view(0).companions, []);
    assert!(!model.meters.contains_key(&page()));
}
