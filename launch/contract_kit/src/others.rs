//! The other seats, as the kit plays them: what robot, mapping and both planners send for a tick.

use super::robot::{Robot, TICK_NS, description, scan_due};
use super::room::{BOX_TICK, CLEARANCE_LIMIT_MM, COST_MODEL, DETOUR_M, GOAL, Room, geometry};
use std::os::unix::net::UnixStream;
use std::path::Path as FilePath;
use zeronav_casts::Cast;
use zeronav_msgs::command::{Validity, VelocityRequest};
use zeronav_msgs::header::Parents;
use zeronav_msgs::map::{MapInfo, MapTile};
use zeronav_msgs::obstacles::Obstacles;
use zeronav_msgs::path::{Path, PathCause, PathStatus, WAYPOINTS_MAX, Waypoint};
use zeronav_msgs::role::Role;
use zeronav_msgs::task::{Goal, TaskState as State, TaskStatus};
use zeronav_msgs::topics::{
    ControlRequest, EVENT_NEED_KEYFRAME, MapKeyframe, MapObstacles, MapUpdate, PlanPath,
    RobotDescription, RobotOdometry, RobotScan, TaskState, Topic, TopicRow,
};
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::{Bells, Doorbell};
use zeronav_shell::{Domain, Draft, Peer, StartError, Writer};

/// The one goal of the tests.
pub(crate) const TASK_GOAL: Goal = Goal {
    pose: GOAL,
    tolerance_m: 0.25,
    yaw_tolerance_rad: 3.15,
    id: 7,
};

/// The robot's seat.
#[derive(Debug)]
struct RobotSeat {
    description: Writer<RobotDescription>,
    odometry: Writer<RobotOdometry>,
    scan: Writer<RobotScan>,
    bells: Bells,
    _peer: Peer,
}

/// Mapping's seat.
#[derive(Debug)]
struct MappingSeat {
    update: Writer<MapUpdate>,
    keyframe: Writer<MapKeyframe>,
    obstacles: Writer<MapObstacles>,
    revision: u64,
    bell: Doorbell,
    _peer: Peer,
}

/// The global planner's seat.
#[derive(Debug)]
struct PlannerSeat {
    path: Writer<PlanPath>,
    geometry: u64,
    _peer: Peer,
}

/// The local planner's seat.
#[derive(Debug)]
struct ControlSeat {
    request: Writer<ControlRequest>,
    status: Writer<TaskState>,
    _peer: Peer,
}

/// Every seat but the tested one.
#[derive(Debug)]
pub(crate) struct Others {
    role: Role,
    lockstep: bool,
    robot: RobotSeat,
    mapping: Option<MappingSeat>,
    planner: Option<PlannerSeat>,
    control: Option<ControlSeat>,
}

/// What is left out of a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Missing {
    Nothing,
    /// No scans come, so mapping and the global planner have nothing to answer.
    Scans,
}

impl Others {
    /// Joins the domain at `root` in every seat but that of `role`, as processes with this epoch.
    ///
    /// # Errors
    /// What the middleware says.
    pub(crate) fn open(
        root: &FilePath,
        role: Role,
        epoch: u32,
        lockstep: bool,
    ) -> Result<Self, StartError> {
        let join = |role| Peer::join(Domain::join(root)?, role, epoch);
        let peer = join(Role::Robot)?;
        let robot = RobotSeat {
            description: peer.writer(0)?,
            odometry: peer.writer(0)?,
            scan: peer.writer(180)?,
            bells: Bells::open(&peer)?,
            _peer: peer,
        };
        let mut others = Self {
            role,
            lockstep,
            robot,
            mapping: None,
            planner: None,
            control: None,
        };
        let tiles = Room::at(0).tiles().len();
        if role != Role::Mapping {
            let peer = join(Role::Mapping)?;
            others.mapping = Some(MappingSeat {
                update: peer.writer(tiles)?,
                keyframe: peer.writer(tiles)?,
                obstacles: peer.writer(1)?,
                revision: 0,
                bell: silent_doorbell(&peer)?,
                _peer: peer,
            });
        }
        if role != Role::GlobalPlanner {
            let peer = join(Role::GlobalPlanner)?;
            others.planner = Some(PlannerSeat {
                path: peer.writer(WAYPOINTS_MAX)?,
                geometry: 0,
                _peer: peer,
            });
        }
        if role != Role::LocalPlanner {
            let peer = join(Role::LocalPlanner)?;
            others.control = Some(ControlSeat {
                request: peer.writer(1)?,
                status: peer.writer(1)?,
                _peer: peer,
            });
        }
        Ok(others)
    }

    /// What comes before the first tick: the robot, and the map as it is without a scan.
    pub(crate) fn introduce(&mut self) {
        (self.robot.description).publish(&Draft::default(), description(), &[]);
        self.send_map(0, &[]);
        self.send_keyframe(0);
        self.refresh();
    }

    /// Brings latched messages to a reader that joined since.
    pub(crate) fn refresh(&self) {
        self.robot.description.refresh();
        if let Some(mapping) = &self.mapping {
            mapping.keyframe.refresh();
        }
    }

    /// Rings the tested program for a message on `row`.
    pub(crate) fn ring(&self, row: &TopicRow) {
        let more: &[Role] = if self.lockstep {
            row.rings_in_lockstep
        } else {
            &[]
        };
        if row.rings.iter().chain(more).any(|role| *role == self.role) {
            self.robot.bells.ring(self.role, row.number);
        }
    }

    /// True when mapping was asked for a keyframe since the last call.
    pub(crate) fn is_asked_for_keyframe(&self) -> bool {
        let rung = self.mapping.as_ref().map(|mapping| mapping.bell.wait(0));
        rung.is_some_and(|rung| rung.has(EVENT_NEED_KEYFRAME))
    }

    /// Sends what all of them have to say at `tick`, in the order of the data flow; when the message
    /// was sent that the program answers. [ns]
    pub(crate) fn send(&mut self, tick: u64, robot: &Robot, missing: Missing) -> u64 {
        let with_scan = scan_due(tick) && missing != Missing::Scans;
        let room = Room::at(tick);
        let draft = draft(tick);
        if with_scan {
            let (scan, ranges) = robot.scan(room);
            self.robot.scan.publish(&draft, scan, &ranges);
            self.ring(RobotScan::ROW);
        }
        let mut odometry = robot.odometry(tick);
        odometry.scan_due = u32::from(with_scan);
        self.robot.odometry.publish(&draft, odometry, &[]);
        self.ring(RobotOdometry::ROW);
        let mut sent_ns = now_ns();
        if with_scan {
            let tiles = if tick == BOX_TICK + 1 {
                let before = Room::at(0).tiles();
                let mut tiles = room.tiles();
                tiles.retain(|tile| !before.contains(tile));
                tiles
            } else {
                Vec::new()
            };
            self.send_map(tick, &tiles);
            if self.role == Role::GlobalPlanner {
                sent_ns = now_ns();
            }
            self.send_path(tick, robot);
        }
        self.send_request(tick, robot);
        if self.role == Role::CollisionGuard {
            sent_ns = now_ns();
        }
        sent_ns
    }

    fn send_map(&mut self, tick: u64, tiles: &[MapTile]) {
        let Some(mapping) = &mut self.mapping else {
            return;
        };
        mapping.revision = mapping.update.next_id().0;
        let draft = draft(tick);
        let info = map_info(mapping.revision, tiles.len());
        if tick > 0 {
            (mapping.obstacles).publish(&draft, Obstacles::default(), &[]);
        }
        mapping.update.publish(&draft, info, tiles);
        self.ring(MapUpdate::ROW);
    }

    /// Sends the whole map as it is at `tick`.
    pub(crate) fn send_keyframe(&mut self, tick: u64) {
        let Some(mapping) = &mut self.mapping else {
            return;
        };
        let tiles = Room::at(tick).tiles();
        let info = map_info(mapping.revision, tiles.len());
        mapping.keyframe.publish(&draft(tick), info, &tiles);
        self.ring(MapKeyframe::ROW);
    }

    /// More updates at once than a queue holds, without a ring: the reader misses some of them.
    pub(crate) fn overflow_updates(&mut self, tick: u64) {
        let Some(mapping) = &mut self.mapping else {
            return;
        };
        for _ in 0..3 * MapUpdate::ROW.buffer() {
            mapping.revision = mapping.update.next_id().0;
            let info = map_info(mapping.revision, 0);
            mapping.update.publish(&draft(tick), info, &[]);
        }
        self.ring(MapUpdate::ROW);
    }

    fn send_path(&mut self, tick: u64, robot: &Robot) {
        let revision = self.mapping.as_ref().map_or(0, |mapping| mapping.revision);
        let Some(planner) = &mut self.planner else {
            return;
        };
        let around = tick > BOX_TICK;
        if planner.geometry == 0 || tick == BOX_TICK + 1 {
            planner.geometry = planner.path.next_id().0;
        }
        let waypoints = waypoints(&way_m(around), robot);
        let cause = if around {
            PathCause::Obstacle
        } else {
            PathCause::Goal
        };
        let path = Path {
            geometry: planner.geometry,
            searched_map: revision,
            ..Path::new("kit", PathStatus::Found, cause, TASK_GOAL.id, &waypoints)
        };
        let mut draft = draft(tick);
        draft.parents.map = revision;
        planner.path.publish(&draft, path, &waypoints);
        self.ring(PlanPath::ROW);
    }

    fn send_request(&mut self, tick: u64, robot: &Robot) {
        let Some(control) = &mut self.control else {
            return;
        };
        let (v_mps, w_radps) = match self.role {
            Role::CollisionGuard => blunt_request(tick),
            _ => robot.pursue(&way_m(tick > BOX_TICK)),
        };
        let request = VelocityRequest {
            v_mps,
            w_radps,
            validity: Validity::Drive.code(),
            ..VelocityRequest::default()
        };
        let draft = draft(tick);
        control.request.publish(&draft, request, &[]);
        if tick == 1 {
            let status = TaskStatus {
                state: State::Active.code(),
                goal: TASK_GOAL.id,
                ..TaskStatus::default()
            };
            control.status.publish(&draft, status, &[]);
        }
        self.ring(ControlRequest::ROW);
    }

    /// Sends odometry, and a request to stand, for a robot without launch.
    pub(crate) fn send_without_launch(&mut self, tick: u64, robot: &Robot) {
        let draft = draft(tick);
        (self.robot.odometry).publish(&draft, robot.odometry(tick), &[]);
        self.ring(RobotOdometry::ROW);
        if let Some(control) = &mut self.control {
            let request = VelocityRequest {
                validity: Validity::Stopped.code(),
                ..VelocityRequest::default()
            };
            control.request.publish(&draft, request, &[]);
        }
        self.ring(ControlRequest::ROW);
    }
}

/// A doorbell that no signal wakes.
fn silent_doorbell(peer: &Peer) -> Result<Doorbell, StartError> {
    let failed = |error| StartError::system("making a socket", error);
    let (signals, _) = UnixStream::pair().map_err(failed)?;
    signals.set_nonblocking(true).map_err(failed)?;
    Doorbell::open(peer, signals)
}

fn draft(tick: u64) -> Draft {
    let now_ns = now_ns();
    Draft {
        tick,
        run_ns: tick * TICK_NS,
        capture_ns: if tick == 0 { 0 } else { now_ns },
        parents: Parents::default(),
        woken_ns: now_ns,
        started_ns: now_ns,
        ..Draft::default()
    }
}

fn map_info(revision: u64, n_tiles: usize) -> MapInfo {
    MapInfo {
        geometry: geometry(),
        revision,
        parts: 1,
        n_tiles: u32::try_from(n_tiles).unwrap_or(0),
        clearance_limit_mm: u32::from(CLEARANCE_LIMIT_MM),
        current: 1,
        cost_model: COST_MODEL,
        ..MapInfo::default()
    }
}

/// What the kit's planner says: straight to the goal, and around the box when it is there. [m]
pub(crate) fn way_m(around: bool) -> Vec<[f64; 2]> {
    if around {
        DETOUR_M.to_vec()
    } else {
        vec![[GOAL.x_m, GOAL.y_m]]
    }
}

fn waypoints(way_m: &[[f64; 2]], robot: &Robot) -> Vec<Waypoint> {
    let ahead = |point: &&[f64; 2]| point[0] > robot.pose.x_m + 0.1;
    let mut corners = vec![[robot.pose.x_m, robot.pose.y_m]];
    corners.extend(way_m.iter().filter(ahead));
    if corners.len() == 1 {
        corners.push([GOAL.x_m, GOAL.y_m]);
    }
    let next = corners.iter().skip(1).map(Some).chain([None]);
    let pairs = corners.iter().zip(next);
    pairs
        .map(|(at, next)| Waypoint {
            x_m: at[0],
            y_m: at[1],
            yaw_rad: next.map_or(0.0, |next| {
                (next[1] - at[1]).atan2(next[0] - at[0]).to_f32()
            }),
            clearance_m: 0.3,
        })
        .collect()
}

/// What no local planner should ask: full speed at the box, then more than the robot can.
fn blunt_request(tick: u64) -> (f64, f64) {
    match tick {
        0..130 => (1.0, 0.0),
        130..140 => (3.0, 9.0),
        _ => (0.0, 1.0),
    }
}
