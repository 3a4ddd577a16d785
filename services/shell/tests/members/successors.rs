//! What readers hear of a process that takes a seat over, and what such a process hears, over real
//! shared memory.

use super::support::House;
use zeronav_msgs::command::VelocityRequest;
use zeronav_msgs::grid::GridGeometry;
use zeronav_msgs::map::{MapCell, MapInfo, MapTile};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{RunClock, RunMode, Seat};
use zeronav_msgs::topics::{ControlRequest, MapKeyframe, MapUpdate};
use zeronav_shell::{Draft, MapInput, Roster, Writer};

/// A roster of lockstep with these seats.
fn lockstep(seats: &[Seat]) -> Roster {
    Roster {
        clock: RunClock {
            mode: RunMode::Lockstep.code(),
            ..RunClock::default()
        },
        seats: seats.to_vec(),
        ..Roster::default()
    }
}

/// A seat that was empty from `off_tick` to before `on_tick`.
fn seat(role: Role, epoch: u32, off_tick: u64, on_tick: u64) -> Seat {
    Seat {
        role: role.code(),
        epoch,
        off_tick,
        on_tick,
        hear_tick: on_tick,
        ..Seat::default()
    }
}

fn of_tick(tick: u64) -> Draft {
    Draft {
        tick,
        ..Draft::default()
    }
}

#[test]
fn in_lockstep_the_idle_output_of_a_successor_is_not_heard() {
    let house = House::new();
    let planner = house.join(Role::LocalPlanner, 2);
    let guard = house.join(Role::CollisionGuard, 1);
    let mut requests = planner.writer::<ControlRequest>(1).expect("a writer");
    let first = lockstep(&[seat(Role::LocalPlanner, 2, 0, 0)]);
    let successor = lockstep(&[seat(Role::LocalPlanner, 2, 9, 10)]);
    let in_real_time = Roster {
        clock: RunClock::default(),
        ..successor.clone()
    };
    for (roster, is_heard) in [(&first, true), (&successor, false), (&in_real_time, true)] {
        let mut reader = guard.latest::<ControlRequest>().expect("a reader");
        let request = VelocityRequest::default();
        assert!(requests.publish(&of_tick(0), request, &[]).is_some());
        assert_eq!(reader.poll(roster), is_heard);
        assert!(requests.publish(&of_tick(10), request, &[]).is_some());
        assert!(reader.poll(roster), "its first answer");
    }
}

/// Sends one tile as the revision of `tick`.
fn send_map(updates: &mut Writer<MapUpdate>, keyframes: &mut Writer<MapKeyframe>, tick: u64) {
    let info = MapInfo {
        geometry: GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 0.05,
            width: 32,
            height: 32,
        },
        revision: updates.next_id().0,
        parts: 1,
        clearance_limit_mm: 1000,
        current: 1,
        ..MapInfo::default()
    };
    let tile = MapTile {
        tile_x: 0,
        tile_y: 0,
        cells: [MapCell::unknown(0); 1024],
    };
    assert!(updates.publish(&of_tick(tick), info, &[]).is_some());
    let whole = MapInfo { n_tiles: 1, ..info };
    assert!(keyframes.publish(&of_tick(tick), whole, &[tile]).is_some());
}

#[test]
fn a_successor_begins_with_the_map_unless_mapping_was_gone_at_its_first_tick() {
    let house = House::new();
    let mapping = house.join(Role::Mapping, 1);
    let planner = house.join(Role::GlobalPlanner, 2);
    let mut map = MapInput::open(&planner).expect("a reader");
    let own_seat = seat(Role::GlobalPlanner, 2, 15, 20);
    let roster = |mapping_seat| Roster {
        own: Some((Role::GlobalPlanner, 2)),
        ..lockstep(&[mapping_seat, own_seat])
    };
    let present = roster(seat(Role::Mapping, 1, 0, 0));
    let mut updates = mapping.writer::<MapUpdate>(1).expect("a writer");
    let mut keyframes = mapping.writer::<MapKeyframe>(1).expect("a writer");
    send_map(&mut updates, &mut keyframes, 10);
    assert!(
        map.take_in(&present) && map.has(10),
        "older than its first tick"
    );
    // Mapping goes after its first tick: what it has learnt stays.
    let later = roster(seat(Role::Mapping, 2, 25, 30));
    map.take_in(&later);
    assert!(map.view().is_some());
    // Mapping was gone by its first tick.
    let gone = roster(seat(Role::Mapping, 2, 16, 30));
    map.take_in(&gone);
    assert!(map.view().is_none() && map.received().is_none() && map.is_lost());
}

/// A message whose content is rejected is an answer, so that nobody waits for it; but its tick may be any.
#[test]
fn a_rejected_message_counts_as_an_answer_until_the_next_one() {
    let house = House::new();
    let planner = house.join(Role::LocalPlanner, 2);
    let guard = house.join(Role::CollisionGuard, 1);
    let mut requests = planner.writer::<ControlRequest>(1).expect("a writer");
    let mut reader = guard.latest::<ControlRequest>().expect("a reader");
    let roster = lockstep(&[seat(Role::LocalPlanner, 2, 0, 0)]);
    let good = VelocityRequest::default();
    let bad = VelocityRequest {
        v_mps: f64::NAN,
        ..good
    };
    let mut spoken_after = |tick, request| {
        assert!(requests.publish(&of_tick(tick), request, &[]).is_some());
        reader.poll(&roster);
        reader.spoken_tick()
    };
    assert_eq!(spoken_after(8, good), 8);
    assert_eq!(spoken_after(9, bad), 9, "it is not waited for");
    assert_eq!(spoken_after(u64::MAX, bad), u64::MAX);
    assert_eq!(
        spoken_after(10, good),
        10,
        "the next one is an answer to its own tick"
    );
    assert_eq!(spoken_after(u64::MAX, bad), u64::MAX);
    assert_eq!(spoken_after(11, bad), 11, "a rejected one, too");
    assert_eq!(
        spoken_after(3, bad),
        10,
        "never before the newest accepted one"
    );
}
