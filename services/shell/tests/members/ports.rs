//! The ports over real shared memory: several members of one domain in one process.

use super::support::House;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::description::Description;
use zeronav_msgs::grid::{Cell, GridGeometry};
use zeronav_msgs::header::Id;
use zeronav_msgs::map::{COST_LETHAL, MapCell, MapInfo, MapTile};
use zeronav_msgs::obstacles::{Obstacle, Obstacles};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::Seat;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::topics::{
    ControlRequest, MapKeyframe, MapObstacles, MapUpdate, RobotDescription, RobotOdometry,
};
use zeronav_shell::{Draft, Input, MapInput, Peer, Received, Roster, StartError, memory};

fn roster(seats: &[(Role, u32)]) -> Roster {
    Roster {
        seats: seats
            .iter()
            .map(|(role, epoch)| Seat {
                role: role.code(),
                epoch: *epoch,
                ..Seat::default()
            })
            .collect(),
        ..Roster::default()
    }
}

fn ask(v_mps: f64) -> VelocityRequest {
    VelocityRequest {
        v_mps,
        validity: Validity::Drive.code(),
        ..VelocityRequest::default()
    }
}

fn description() -> Description {
    Description {
        inscribed_radius_m: 0.2,
        circumscribed_radius_m: 0.2,
        v_mps_max: 1.0,
        w_radps_max: 1.0,
        a_mps2_max: 1.0,
        brake_mps2: 1.0,
        alpha_radps2_max: 1.0,
        angle_increment_rad: 0.1,
        range_m_max: 10.0,
        scan_period_ns: 100,
        n_beams: 3,
        ..Description::default()
    }
}

#[test]
fn latched_topics_reach_readers_that_join_late() {
    let house = House::new();
    let robot = house.join(Role::Robot, 1);
    let mut writer = robot.writer::<RobotDescription>(0).expect("a writer");
    writer
        .publish(&Draft::default(), description(), &[])
        .expect("sent");
    let mapping = house.join(Role::Mapping, 1);
    let mut reader = mapping.latest::<RobotDescription>().expect("a reader");
    let roster = roster(&[(Role::Robot, 1)]);
    assert!(
        !reader.poll(&roster),
        "nothing before the writer's next wake"
    );
    writer.refresh();
    assert!(
        !reader.poll(&Roster::default()),
        "messages are left before it is known which processes are obeyed"
    );
    assert!(reader.poll(&roster), "and nothing is lost by it");
    assert!((reader.get().expect("a message").meta.v_mps_max - 1.0).abs() < 1e-12);
}

#[test]
fn the_newest_of_the_obeyed_writer_wins_and_zombies_are_ignored() {
    let house = House::new();
    let (old, new) = (
        house.join(Role::LocalPlanner, 1),
        house.join(Role::LocalPlanner, 2),
    );
    let guard = house.join(Role::CollisionGuard, 1);
    let mut reader = guard.latest::<ControlRequest>().expect("a reader");
    let mut zombie = old.writer::<ControlRequest>(0).expect("a writer");
    let mut writer = new.writer::<ControlRequest>(0).expect("a writer");
    let draft = Draft::default();
    let obeyed = roster(&[(Role::LocalPlanner, 2)]);
    for n in 1..=5 {
        writer
            .publish(&draft, ask(f64::from(n)), &[])
            .expect("sent");
        zombie.publish(&draft, ask(-1.0), &[]).expect("sent");
    }
    assert!(reader.poll(&obeyed));
    let view = reader.get().expect("a message");
    assert_eq!(view.header.id(), Id::new(2, 5));
    assert!((view.meta.v_mps - 5.0).abs() < 1e-12);
    assert!(reader.superseded() >= 1);
    zombie.publish(&draft, ask(-1.0), &[]).expect("sent");
    assert!(!reader.poll(&obeyed), "the zombie was heard");
    // Rolled back: the first writer is obeyed again, although its ids are lower.
    zombie.publish(&draft, ask(-2.0), &[]).expect("sent");
    assert!(reader.poll(&roster(&[(Role::LocalPlanner, 1)])));
    assert!((reader.get().expect("a message").meta.v_mps + 2.0).abs() < 1e-12);
}

#[test]
fn the_newest_message_is_the_one_with_the_highest_id_in_whatever_order_they_come() {
    let house = House::new();
    let planner = house.join(Role::LocalPlanner, 1);
    let guard = house.join(Role::CollisionGuard, 1);
    let mut reader = guard.latest::<ControlRequest>().expect("a reader");
    // The ports of one process: what they sent arrives port by port.
    let mut ahead = planner.writer::<ControlRequest>(0).expect("a writer");
    let mut behind = planner.writer::<ControlRequest>(0).expect("a writer");
    let draft = Draft::default();
    let roster = roster(&[(Role::LocalPlanner, 1)]);
    for n in 1..=5 {
        ahead.publish(&draft, ask(f64::from(n)), &[]).expect("sent");
    }
    assert!(reader.poll(&roster));
    behind.publish(&draft, ask(-1.0), &[]).expect("sent");
    assert!(!reader.poll(&roster), "an older message was taken for news");
    let view = reader.get().expect("a message");
    assert_eq!(view.header.id(), Id::new(1, 5));
    assert!((view.meta.v_mps - 5.0).abs() < 1e-12);
}

#[test]
fn nan_is_rejected_and_counted() {
    let house = House::new();
    let planner = house.join(Role::LocalPlanner, 1);
    let guard = house.join(Role::CollisionGuard, 1);
    let mut reader = guard.latest::<ControlRequest>().expect("a reader");
    let mut writer = planner.writer::<ControlRequest>(0).expect("a writer");
    let roster = roster(&[(Role::LocalPlanner, 1)]);
    writer
        .publish(&Draft::default(), ask(f64::NAN), &[])
        .expect("sent");
    assert!(!reader.poll(&roster));
    assert_eq!(reader.refused(), 1);
    writer
        .publish(&Draft::default(), ask(0.5), &[])
        .expect("sent");
    assert!(reader.poll(&roster));
}

#[test]
fn messages_of_a_role_that_may_not_write_the_topic_are_rejected() {
    let house = House::new();
    let impostor = house.join(Role::Mapping, 1);
    let guard = house.join(Role::CollisionGuard, 1);
    let mut reader = guard.latest::<ControlRequest>().expect("a reader");
    let mut writer = impostor.writer::<ControlRequest>(0).expect("a writer");
    writer
        .publish(&Draft::default(), ask(0.5), &[])
        .expect("sent");
    assert!(!reader.poll(&roster(&[(Role::Mapping, 1), (Role::LocalPlanner, 1)])));
    assert_eq!(reader.refused(), 1);
}

#[test]
fn streams_arrive_in_order_and_count_gaps() {
    let house = House::new();
    let robot = house.join(Role::Robot, 1);
    let guard = house.join(Role::CollisionGuard, 1);
    let mut reader = guard.stream::<RobotOdometry>().expect("a reader");
    let mut writer = robot.writer::<RobotOdometry>(0).expect("a writer");
    let roster = roster(&[(Role::Robot, 1)]);
    let mut send = |ticks: core::ops::Range<u64>| {
        for tick in ticks {
            let draft = Draft {
                tick,
                ..Draft::default()
            };
            writer
                .publish(&draft, Odometry::default(), &[])
                .expect("sent");
        }
    };
    let mut ticks = Vec::new();
    send(1..11);
    reader.drain(&roster, |view| ticks.push(view.header.tick));
    assert_eq!(ticks, (1..11).collect::<Vec<_>>());
    assert_eq!(reader.gaps(), 0);
    // The queue keeps the last 32.
    send(11..111);
    ticks.clear();
    reader.drain(&roster, |view| ticks.push(view.header.tick));
    assert_eq!(ticks, (79..111).collect::<Vec<_>>());
    assert_eq!(reader.gaps(), 1);
}

/// A map of two tiles.
fn map_info(revision: Id, part: u16, parts: u16, n_tiles: u32) -> MapInfo {
    MapInfo {
        geometry: GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 0.05,
            width: 64,
            height: 32,
        },
        revision: revision.0,
        part,
        parts,
        n_tiles,
        clearance_limit_mm: 1000,
        current: 1,
        ..MapInfo::default()
    }
}

/// Its tiles, with unknown cells of this clearance.
fn map_tiles(clearance_mm: u16) -> [MapTile; 2] {
    [0, 1].map(|tile_x| MapTile {
        tile_x,
        tile_y: 0,
        cells: [MapCell::unknown(clearance_mm); 1024],
    })
}

fn of_tick(tick: u64) -> Draft {
    Draft {
        tick,
        ..Draft::default()
    }
}

#[test]
fn a_map_is_complete_with_its_last_part_and_a_keyframe_repairs_a_gap() {
    let house = House::new();
    let mapping = house.join(Role::Mapping, 1);
    let planner = house.join(Role::GlobalPlanner, 1);
    let mut map = MapInput::open(&planner).expect("a reader");
    let mut updates = mapping.writer::<MapUpdate>(1).expect("a writer");
    let mut keyframes = mapping.writer::<MapKeyframe>(2).expect("a writer");
    let mut roster = roster(&[(Role::Mapping, 1)]);
    let tiles = map_tiles(0);
    assert!(map.is_lost() && map.view().is_none() && map.received().is_none());

    let first = updates.next_id();
    let empty = |revision| map_info(revision, 0, 1, 0);
    updates
        .publish(&of_tick(1), empty(first), &[])
        .expect("sent");
    let whole = |revision| map_info(revision, 0, 1, 2);
    let mut send_whole = |revision| {
        let sent = keyframes.publish(&Draft::default(), whole(revision), &tiles);
        assert!(sent.is_some(), "no place for a keyframe");
    };
    send_whole(first);
    roster.woken_ns = 7;
    assert!(map.take_in(&roster));
    assert!(map.has(1) && !map.has(2));
    assert_eq!(map.changed().len(), 1, "all of it");

    let tiles = map_tiles(50);
    let last = updates.next_id().next();
    let part = |part| map_info(last, part, 2, 1);
    updates
        .publish(&of_tick(2), part(0), &tiles[..1])
        .expect("sent");
    roster.woken_ns = 8;
    assert!(!map.take_in(&roster), "a part is no revision");
    assert_eq!((map.revision(), map.has(2)), (first, false));
    assert!(map.changed().is_empty());
    updates
        .publish(&of_tick(2), part(1), &tiles[1..])
        .expect("sent");
    roster.woken_ns = 9;
    assert!(map.take_in(&roster));
    assert_eq!((map.revision(), map.has(2)), (last, true));
    assert_eq!(map.changed().len(), 2);
    let received = Received {
        tick: 2,
        came_ns: 9,
        ..Received::default()
    };
    assert_eq!(map.received(), Some(received));

    // Unneeded keyframes are given back, or the writer would run out of places.
    for _ in 0..20 {
        send_whole(last);
        roster.woken_ns = 10;
        assert!(!map.take_in(&roster));
    }

    // The queue keeps the last 32.
    for tick in 3..43 {
        let revision = updates.next_id();
        updates
            .publish(&of_tick(tick), empty(revision), &[])
            .expect("sent");
    }
    roster.woken_ns = 11;
    assert!(map.take_in(&roster));
    assert!(
        map.is_lost() && !map.has(42),
        "it is unknown what was missed"
    );
    send_whole(Id(updates.next_id().0 - 1));
    roster.woken_ns = 12;
    map.take_in(&roster);
    assert!(map.has(42) && !map.is_lost());
    assert_eq!(map.refused(), 0);
}

#[test]
fn a_sleeping_reader_never_stops_a_writer() {
    let house = House::new();
    let planner = house.join(Role::LocalPlanner, 1);
    let sleepers: Vec<_> = (0..4)
        .map(|_| {
            let tap = house.join(Role::Tap, 1);
            let reader = tap.latest::<ControlRequest>().expect("a reader");
            (reader, tap)
        })
        .collect();
    let mut writer = planner.writer::<ControlRequest>(0).expect("a writer");
    for n in 0..1000 {
        let sent = writer.publish(&Draft::default(), ask(f64::from(n) * 0.001), &[]);
        assert!(sent.is_some(), "message {n}");
    }
    assert_eq!(writer.failed(), 0);
    drop(sleepers);
}

#[test]
fn spans_of_several_writers_all_arrive() {
    let house = House::new();
    let tap = house.join(Role::Tap, 1);
    let mut reader = tap.span_reader().expect("a reader");
    let peers: Vec<Peer> = Role::SERVICES
        .iter()
        .map(|role| house.join(*role, 1))
        .collect();
    let mut writers: Vec<_> = peers
        .iter()
        .map(|peer| peer.span_writer().expect("a writer"))
        .collect();
    for tick in 1..=500 {
        for (writer, peer) in writers.iter_mut().zip(&peers) {
            writer.write(Span {
                role: peer.role().code(),
                kind: SpanKind::Answer.code(),
                epoch: 1,
                tick,
                ..Span::default()
            });
        }
    }
    let mut count = 0;
    reader.drain(|_| count += 1);
    assert_eq!(count, 2500);
    assert_eq!(reader.refused(), 0);
}

#[test]
fn the_hash_covers_content_but_no_stamps() {
    let house = House::new();
    let planner = house.join(Role::LocalPlanner, 1);
    let send = |draft: Draft, v_mps| {
        let mut writer = planner.writer::<ControlRequest>(0).expect("a writer");
        writer.publish(&draft, ask(v_mps), &[]).expect("sent").hash
    };
    let draft = Draft {
        hashed: true,
        tick: 3,
        capture_ns: 5,
        woken_ns: 7,
        ..Draft::default()
    };
    let hash = send(draft, 0.5);
    assert_ne!(hash, 0);
    assert_eq!(
        hash,
        send(
            Draft {
                capture_ns: 6,
                woken_ns: 8,
                started_ns: 9,
                ..draft
            },
            0.5
        )
    );
    assert_ne!(hash, send(draft, 0.6));
    assert_ne!(hash, send(Draft { tick: 4, ..draft }, 0.5));
    assert_eq!(
        send(
            Draft {
                hashed: false,
                ..draft
            },
            0.5
        ),
        0
    );
}

#[test]
fn missing_memory_is_reported_before_anything_is_opened() {
    let error = memory::check(1 << 60).expect_err("more than any machine has");
    assert!(matches!(error, StartError::Memory { .. }));
    assert!(error.to_string().contains("/dev/shm"), "{error}");
    assert!(memory::check(1 << 20).is_ok());
}

#[test]
fn obstacles_are_on_the_map_of_a_reader_that_asks_for_them_while_they_are_young() {
    let house = House::new();
    let mapping = house.join(Role::Mapping, 1);
    let planner = house.join(Role::GlobalPlanner, 1);
    let mut stamped = MapInput::with_obstacles(&planner).expect("a reader");
    let mut plain = MapInput::open(&planner).expect("a reader");
    let slow = MapInput::with_obstacles(&planner).expect("a reader");
    let mut slow = slow.slower_than(0.3);
    let mut updates = mapping.writer::<MapUpdate>(1).expect("a writer");
    let mut keyframes = mapping.writer::<MapKeyframe>(2).expect("a writer");
    let mut obstacles = mapping.writer::<MapObstacles>(2).expect("a writer");
    let roster = roster(&[(Role::Mapping, 1)]);
    let free = MapCell {
        clearance_mm: 1000,
        ..MapCell::default()
    };
    let tiles = [0, 1].map(|tile_x| MapTile {
        tile_x,
        tile_y: 0,
        cells: [free; 1024],
    });
    let mut update_at = |run_ns| {
        let revision = updates.next_id();
        let draft = Draft {
            run_ns,
            ..of_tick(1)
        };
        let info = map_info(revision, 0, 1, 0);
        updates.publish(&draft, info, &[]).expect("sent");
        revision
    };
    let cost_at = |map: &MapInput, column: i32| {
        let view = map.view().expect("a map");
        view.get(Cell::new(column, 10)).expect("inside").cost
    };
    let first = update_at(1_000_000_000);
    let sent = keyframes.publish(&Draft::default(), map_info(first, 0, 1, 2), &tiles);
    assert!(sent.is_some());
    let walks = |x_m: f64, vy_mps: f64| Obstacle {
        x_m,
        y_m: 0.525,
        vy_mps,
        radius_m: 0.2,
        ..Obstacle::default()
    };
    let draft = Draft {
        run_ns: 1_000_000_000,
        ..of_tick(1)
    };
    let list = Obstacles { n_obstacles: 2 };
    let people = [walks(0.525, -0.29), walks(2.525, -0.31)];
    let sent = obstacles.publish(&draft, list, &people);
    assert!(sent.is_some());
    for map in [&mut stamped, &mut plain, &mut slow] {
        map.take_in(&roster);
    }
    assert_eq!(cost_at(&stamped, 10), COST_LETHAL);
    assert_eq!(cost_at(&stamped, 50), COST_LETHAL);
    assert_eq!(cost_at(&plain, 10), 0);
    assert_eq!(cost_at(&slow, 10), COST_LETHAL);
    assert_eq!(cost_at(&slow, 50), 0, "it walks away");

    update_at(1_500_000_000);
    stamped.take_in(&roster);
    assert_eq!(cost_at(&stamped, 10), COST_LETHAL, "0.5 s is young");
    update_at(1_500_000_001);
    stamped.take_in(&roster);
    assert_eq!(cost_at(&stamped, 10), 0);
    assert!(!stamped.changed().is_empty(), "it was taken off");
    assert_eq!(stamped.refused(), 0);
}
