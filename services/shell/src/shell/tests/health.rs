//! What the heartbeat says of it.

use super::*;

#[test]
fn a_message_that_is_too_long_is_dropped_and_the_heartbeat_says_so() {
    let mut bench = Bench::new(RunMode::RealTime);
    let draft = bench.begin(answer_to(1));
    let items = [0; 2];
    let writer = &mut bench.writer;
    let sent = bench.shell.send_aside(&draft, writer, ask(0.1), &items);
    assert!(sent.is_none());
    assert_eq!(
        bench.how(SECOND_NS).1,
        0,
        "beside the answers nobody is told"
    );
    let sent = (bench.shell).send(&draft, &mut bench.writer, ask(0.1), &items);
    assert!(sent.is_none());
    assert_eq!(bench.how(2 * SECOND_NS).1, REASON_TOO_LONG);
    assert!(bench.send(&draft, 0.1).is_some(), "the next one is short");
    assert_eq!(
        bench.how(3 * SECOND_NS).1,
        REASON_TOO_LONG,
        "since the start"
    );
}

#[test]
fn a_message_without_memory_is_dropped_and_the_heartbeat_says_so() {
    let mut stage = stage(RunMode::RealTime);
    let mut shell = stage.open(Role::Mapping, 3);
    let mut beats = Beats::of(&stage, Role::Mapping);
    let tap = stage.join(Role::Tap, 1);
    let roster = stage.words().roster();
    let mut writer = shell.peer().writer::<MapKeyframe>(1).expect("a writer");
    let mut readers = [0, 1].map(|_| tap.latest::<MapKeyframe>().expect("a reader"));
    let draft = shell.begin(answer_to(1), 0, 0, Parents::default());
    let mut send = |shell: &mut Shell| shell.send(&draft, &mut writer, keyframe(), &[tile()]);
    // Each reader holds another keyframe, and two wait: that is all the memory.
    for reader in &mut readers {
        assert!(send(&mut shell).is_some());
        assert!(reader.poll(&roster));
    }
    for _ in 0..2 {
        assert!(send(&mut shell).is_some());
    }
    assert!(send(&mut shell).is_none());
    shell.beat(SECOND_NS);
    assert_eq!(beats.one().reasons, REASON_NO_LOAN);
    assert!(readers[0].poll(&roster), "a place is free");
    assert!(send(&mut shell).is_some());
    shell.beat(2 * SECOND_NS);
    assert_eq!(beats.one().reasons, 0);
}

fn keyframe() -> MapInfo {
    MapInfo {
        geometry: GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 0.05,
            width: 32,
            height: 32,
        },
        revision: Id::new(3, 1).0,
        parts: 1,
        n_tiles: 1,
        clearance_limit_mm: 1000,
        current: 1,
        ..MapInfo::default()
    }
}

fn tile() -> MapTile {
    MapTile {
        tile_x: 0,
        tile_y: 0,
        cells: [MapCell::unknown(0); 1024],
    }
}

/// An input with these counts.
struct Counts {
    refused: u64,
    superseded: u64,
}

impl Input for Counts {
    fn refused(&self) -> u64 {
        self.refused
    }

    fn superseded(&self) -> u64 {
        self.superseded
    }
}

#[test]
fn what_the_inputs_counted_is_summed_up_in_heartbeat_and_record() {
    let mut bench = Bench::new(RunMode::RealTime);
    let counts = |refused, superseded| Counts {
        refused,
        superseded,
    };
    bench.shell.count(&[&counts(1, 20), &counts(4, 3)]);
    bench.shell.beat(SECOND_NS);
    let health = bench.beats.one();
    assert_eq!((health.refused, health.superseded), (5, 23));
    assert_eq!(health.reasons, REASON_REFUSED);
    let draft = bench.begin(answer_to(1));
    bench.shell.finish(&draft, None, 0);
    assert_eq!(bench.span().superseded, 23);
    bench.shell.finish(&draft, None, 0);
    assert_eq!(bench.span().superseded, 0, "nothing since");
}

#[test]
fn reasons_readiness_and_lost_time_are_told_in_the_heartbeat() {
    let mut bench = Bench::new(RunMode::RealTime);
    bench.shell.wait(0);
    bench.shell.ready();
    bench.shell.reason(REASON_MAP, true);
    bench.shell.slipped(5);
    bench.shell.beat(SECOND_NS);
    let beats = bench.beats.take();
    assert_eq!(beats.len(), 1);
    let health = beats[0].health;
    assert_eq!(health.state(), Some(HealthState::Degraded));
    assert_eq!((health.reasons, health.slipped_ns), (REASON_MAP, 5));
    assert_eq!(beats[0].woken_ns, bench.shell.woken_ns());
    bench.shell.reason(REASON_MAP, false);
    assert_eq!(bench.how(SECOND_NS + 1), (Some(HealthState::Ready), 0));
}

#[test]
fn long_work_shows_that_it_goes_on() {
    let mut bench = Bench::new(RunMode::RealTime);
    bench.shell.progress();
    let health = bench.beats.one();
    assert_eq!(health.progress, 1, "it beats by itself");
}

#[test]
fn a_shell_that_leaves_gives_back_its_domain_without_ports_in_it() {
    let bench = Bench::new(RunMode::RealTime);
    drop(bench.writer);
    let domain = bench.shell.leave();
    assert_eq!(domain.root(), bench.stage.root());
    let row = zeronav_msgs::topics::health_of(Role::LocalPlanner).expect("a row");
    let ports = bench.tap.ports::<zeronav_msgs::topics::HealthTopic>(row);
    assert_eq!(ports.expect("a look")[0], 0, "writers");
}
