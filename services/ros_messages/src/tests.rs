//! Golden bytes are those of an independent implementation, `rosbags` 0.11.9, for the same messages.

use super::*;
use zeronav_msgs::command::VelocityCommand;
use zeronav_msgs::health::HealthState;
use zeronav_msgs::map::{MapCell, MapInfo, MapTile};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::run::{RunClock, RunControl, RunMode};
use zeronav_msgs::scan::Scan;
use zeronav_msgs::task::{Task, TaskStatus};
use zeronav_msgs::topics::seal;
use zeronav_msgs::{Cell, GridGeometry, Pose};

fn hex(bytes: &[u8]) -> String {
    let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    bytes.concat()
}

fn golden(text: &str) -> String {
    text.split_whitespace().collect()
}

#[test]
fn a_twist_has_the_bytes_of_ros() {
    let command = VelocityCommand {
        v_mps: 0.5,
        w_radps: -0.25,
        ..VelocityCommand::default()
    };
    let bytes = cdr(&view::command(7_500_000_000, &command)).expect("CDR");
    let expected = golden(
        "00010000070000000065cd1d0a000000626173655f6c696e6b000000000000000000e03f00000000 \
         00000000000000000000000000000000000000000000000000000000000000000000d0bf",
    );
    assert_eq!(hex(&bytes), expected);
}

#[test]
fn a_scan_has_the_bytes_of_ros() {
    let scan = Scan {
        n_beams: 3,
        angle_min_rad: -1.5,
        angle_increment_rad: 1.5,
        range_m_min: 0.05,
        range_m_max: 10.0,
        ..Scan::default()
    };
    let description = Description {
        scan_period_ns: 100_000_000,
        ..Description::default()
    };
    let ranges = [1.0, f32::INFINITY, 2.5];
    let message = view::scan(1_000_000_002, &scan, &ranges, Some(&description));
    let expected = golden(
        "000100000100000002000000060000006c617365720000000000c0bf0000c03f0000c03f00000000 \
         cdcccc3dcdcc4c3d00002041030000000000803f0000807f0000204000000000",
    );
    assert_eq!(hex(&cdr(&message).expect("CDR")), expected);
    let points = view::hits(0, &scan, &ranges);
    assert_eq!((points.width, points.data.len()), (2, 24));
}

#[test]
fn diagnostics_have_the_bytes_of_ros() {
    let health = Health {
        state: HealthState::Degraded.code(),
        reasons: zeronav_msgs::health::REASON_SCAN,
        pid: 42,
        superseded: 3,
        ..Health::default()
    };
    let array = messages::DiagnosticArray {
        header: view::header(0, ""),
        status: vec![view::diagnostic(Role::Mapping, &health)],
    };
    let expected = golden(
        "00010000000000000000000001000000000000000100000001000000110000007a65726f6e61763a \
         206d617070696e67000000000f00000064656772616465643a207363616e00000100000000000000 \
         03000000040000007069640003000000343200000900000072656a65637465640000000002000000 \
         300000000b000000737570657273656465640000020000003300",
    );
    assert_eq!(hex(&cdr(&array).expect("CDR")), expected);
}

/// Shows a message of topic `T` to `ros`; what comes of it.
fn show<T: Topic>(
    ros: &mut Ros,
    (role, epoch, count): (Role, u32, u64),
    run_ns: u64,
    meta: T::Meta,
    items: &[T::Item],
) -> Vec<RosMessage> {
    let header = Header {
        role: role.code(),
        id: Id::new(epoch, count).0,
        tick: run_ns / 20_000_000,
        run_ns,
        ..Header::default()
    };
    let envelope = seal::<T>(header, meta, items);
    let message = Bytes {
        row: T::ROW,
        log_ns: run_ns,
        envelope: bytemuck::bytes_of(&envelope),
        items: bytemuck::cast_slice(items),
    };
    ros.see(&message).expect("CDR")
}

fn topics(made: &[RosMessage]) -> Vec<&'static str> {
    made.iter().map(|message| message.topic.name()).collect()
}

#[test]
fn only_who_is_obeyed_moves_the_robot() {
    let clock = RunClock {
        mode: RunMode::Lockstep.code(),
        ..RunClock::default()
    };
    let mut ros = Ros::new(TimeBase::new(&clock, 0, 0));
    let seat = Seat {
        role: Role::Robot.code(),
        epoch: 5,
        ..Seat::default()
    };
    let control = RunControl {
        n_seats: 1,
        ..RunControl::default()
    };
    show::<RunControlTopic>(&mut ros, (Role::Launch, 1, 1), 0, control, &[seat]);
    let odometry = Odometry {
        pose: Pose::new(1.0, 2.0, 0.5),
        ..Odometry::default()
    };
    let at = 40_000_000;
    let made = show::<RobotOdometry>(&mut ros, (Role::Robot, 5, 1), at, odometry, &[]);
    assert_eq!(topics(&made), ["/odom", "/tf"]);
    assert!(made.iter().all(|message| message.log_ns == at));
    // The x of a pose begins after two frame names and the stamp.
    let x = &made[0].bytes[4 + 8 + 12 + 20..][..8];
    assert_eq!(x, 1.0_f64.to_le_bytes());
    let made = show::<RobotOdometry>(&mut ros, (Role::Robot, 6, 1), at, odometry, &[]);
    assert_eq!(made, [], "a shadow");
}

#[test]
fn the_map_is_shown_once_and_then_what_changes() {
    let mut ros = Ros::default();
    let geometry = GridGeometry {
        resolution_m: 0.05,
        width: 40,
        height: 20,
        ..GridGeometry::default()
    };
    let mut cells = vec![MapCell::default(); geometry.len()];
    let mut message = |count: u64, run_ns: u64, ros: &mut Ros, wall: Option<Cell>, whole: bool| {
        if let Some(wall) = wall {
            let index = geometry.index_of(wall).expect("on the map");
            cells[index].cost = zeronav_msgs::map::COST_LETHAL;
        }
        let tiles: Vec<MapTile> = (0..2)
            .map(|tile_x| {
                let mut tile = MapTile {
                    tile_x,
                    ..MapTile::default()
                };
                tile.fill_from(&geometry, &cells);
                tile
            })
            .collect();
        let info = MapInfo {
            geometry,
            revision: Id::new(2, count).0,
            parts: 1,
            n_tiles: 2,
            clearance_limit_mm: 1000,
            ..MapInfo::default()
        };
        let author = (Role::Mapping, 2, count);
        if whole {
            show::<MapKeyframe>(ros, author, run_ns, info, &tiles)
        } else {
            show::<MapUpdate>(ros, author, run_ns, info, &tiles)
        }
    };
    let second = 1_000_000_000;
    assert!(ros.needs_keyframe());
    let made = message(1, second, &mut ros, None, true);
    assert_eq!(topics(&made), ["/map"]);
    assert!(!ros.needs_keyframe());
    let made = message(2, 2 * second, &mut ros, None, false);
    assert_eq!(topics(&made), ["/tf"], "no cell is another one");
    let made = message(3, 3 * second, &mut ros, Some(Cell::new(35, 7)), false);
    assert_eq!(topics(&made), ["/tf", "/map_updates"]);
    // Header with stamp and `map`, x, y, width, height, and one occupied cell.
    let update = &made[1].bytes;
    assert_eq!(hex(&update[4..12]), "0300000000000000");
    let words = [35, 7, 1, 1, 1].map(|word: u32| hex(&word.to_le_bytes()));
    assert_eq!(hex(&update[20..]), words.concat() + "64");
    let made = message(4, 6 * second, &mut ros, None, false);
    assert_eq!(topics(&made), ["/tf", "/map"], "again after five seconds");
    let made = message(5, 20 * second, &mut ros, None, false);
    assert_eq!(topics(&made), ["/tf"], "nothing has changed since");
}

#[test]
fn every_goal_is_shown_when_its_turn_comes() {
    let mut ros = Ros::default();
    let goal = |id: u64| Goal {
        id,
        pose: Pose::new(1.0, 0.0, 0.0),
        ..Goal::default()
    };
    let task = Task {
        kind: TaskKind::Go.code(),
        n_goals: 2,
        ..Task::default()
    };
    let launch = (Role::Launch, 1, 1);
    let made = show::<TaskGoal>(&mut ros, launch, 0, task, &[goal(7), goal(8)]);
    assert_eq!(topics(&made), ["/goal_pose"]);
    let mut status = |goal| {
        let status = TaskStatus {
            goal,
            ..TaskStatus::default()
        };
        let local = (Role::LocalPlanner, 3, 1);
        topics(&show::<TaskState>(&mut ros, local, 20_000_000, status, &[])).len()
    };
    assert_eq!([7, 7, 8, 8, 0].map(&mut status), [0, 0, 1, 0, 0]);
}

#[test]
fn costs_are_those_of_nav2_and_cut_off_at_the_edge_of_the_map() {
    let cell = |cost| MapCell {
        cost,
        flags: 0,
        ..MapCell::default()
    };
    let costs = [0, 1, 2, 252, 253, 254, 255].map(|cost| view::cost(cell(cost)));
    assert_eq!(costs, [0, 1, 1, 98, 99, 100, -1]);

    let geometry = GridGeometry {
        resolution_m: 0.05,
        width: 32,
        height: 32,
        ..GridGeometry::default()
    };
    let mut cells = vec![cell(0); geometry.len()];
    cells[0].cost = zeronav_msgs::map::COST_LETHAL;
    let mut tile = MapTile::default();
    tile.fill_from(&geometry, &cells);
    let info = MapInfo {
        geometry,
        revision: Id::new(2, 1).0,
        parts: 1,
        n_tiles: 1,
        clearance_limit_mm: 1000,
        ..MapInfo::default()
    };
    let mut ros = Ros::default();
    let at = Pose::new(0.1, 0.1, 0.0);
    assert_eq!(ros.costs_around(0, &at, 0.25), None, "no map yet");
    show::<MapKeyframe>(&mut ros, (Role::Mapping, 2, 1), 0, info, &[tile]);
    let grid = ros.costs_around(0, &at, 0.25).expect("a window");
    // Two cells from the corner: 2 to the left, the own one, 5 to the right.
    assert_eq!((grid.info.width, grid.info.height), (8, 8));
    assert_eq!((grid.data[0], grid.data[1]), (100, 0));
    assert_eq!(ros.costs_around(0, &Pose::new(-9.0, 0.0, 0.0), 0.25), None);
}
