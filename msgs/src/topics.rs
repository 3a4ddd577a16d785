//! Every topic once: its name, its types, its discipline, its writers and whose doorbell it rings.
//!
//! | discipline | what a reader does |
//! |---|---|
//! | latest | takes the newest message over all writers, counts the superseded ones |
//! | stream | reads in order to the end; a gap starts a resync |
//! | latched | like latest; the last message also reaches readers that join later |
//! | records | self-contained records without header, read in order |

use crate::checksum::{HEADER_BYTES, checksum};
use crate::command::{VelocityCommand, VelocityRequest};
use crate::description::{Corner, Description, FOOTPRINT_CORNERS_MAX};
use crate::foresight::{FORESEEN_MAX, Foreseen, Foresight};
use crate::header::Header;
use crate::health::Health;
use crate::map::{MapInfo, MapTile, TILES_PER_KEYFRAME_MAX, TILES_PER_UPDATE_MAX};
use crate::message;
use crate::message::{FNV_OFFSET, Message, Refusal, Wire, ZeroCopySend, ensure, fnv1a};
use crate::obstacles::{OBSTACLES_MAX, Obstacle, Obstacles};
use crate::odometry::Odometry;
use crate::path::{Path, WAYPOINTS_MAX, Waypoint};
use crate::request::PlanRequest;
use crate::role::Role;
use crate::rollouts::{ROLLOUTS_MAX, Rollout, Rollouts};
pub use crate::row::{
    Discipline, EVENT_MAX, EVENT_NEED_KEYFRAME, NODES_MAX, READERS_MAX, RINGERS_MAX,
    SPAN_WRITERS_MAX, TopicRow, WRITERS_MAX,
};
use crate::run::{RunClock, RunControl, SEATS_MAX, Seat};
use crate::scan::{BEAMS_MAX, Scan};
use crate::span::Span;
use crate::task::{GOALS_MAX, Goal, GoalEnd, PoseEstimate, Task, TaskStatus};
use crate::truth::{Placement, Placements, TRUTH_OBSTACLES_MAX, Truth, TruthObstacle};
use crate::zones::{ZONE_PARTS_MAX, ZonePart, Zones};

/// Header and fixed fields of a topic's messages, as they stand in front of the slice.
pub trait Envelope: Message {
    /// The fixed fields.
    type Meta: Message;
    /// Puts both together.
    fn new(header: Header, meta: Self::Meta) -> Self;
    /// The header.
    fn header(&self) -> &Header;
    /// The fixed fields.
    fn meta(&self) -> &Self::Meta;
}

/// A topic as a type.
pub trait Topic: 'static {
    /// Header and fixed fields.
    type Envelope: Envelope<Meta = Self::Meta>;
    /// Fixed fields.
    type Meta: Message;
    /// What the slice holds.
    type Item: Message;
    /// Its row.
    const ROW: &'static TopicRow;

    /// Accepts fixed fields and slices that mean something.
    ///
    /// # Errors
    /// The first field that is wrong.
    fn check(meta: &Self::Meta, items: &[Self::Item]) -> Result<(), Refusal>;
}

/// Accepts a received message of topic `T`, found on `row`, or says why not.
///
/// # Errors
/// The first thing that is wrong in header, fixed fields or slice.
pub fn decode<T: Topic>(
    row: &TopicRow,
    envelope: &T::Envelope,
    items: &[T::Item],
) -> Result<(), Refusal> {
    envelope.header().check(row.schema, row.writers)?;
    ensure(items.len() <= row.len_max, Refusal::Length("items"))?;
    ensure(
        envelope.header().checksum == checksum_of::<T>(envelope, items),
        Refusal::Checksum,
    )?;
    T::check(envelope.meta(), items)
}

/// Header with its checksum, and fixed fields, of a message with these items.
#[must_use]
pub fn seal<T: Topic>(header: Header, meta: T::Meta, items: &[T::Item]) -> T::Envelope {
    let checksum = checksum_of::<T>(&T::Envelope::new(header, meta), items);
    T::Envelope::new(Header { checksum, ..header }, meta)
}

fn checksum_of<T: Topic>(envelope: &T::Envelope, items: &[T::Item]) -> u64 {
    let (header, meta) = (envelope.header(), envelope.meta());
    let header = &bytemuck::bytes_of(header)[..HEADER_BYTES];
    checksum(
        header,
        bytemuck::bytes_of(meta),
        bytemuck::cast_slice(items),
    )
}

/// Called once per topic by [`visit_topics`].
pub trait TopicVisitor {
    /// What may go wrong.
    type Error;
    /// One topic with a header.
    ///
    /// # Errors
    /// Whatever the visitor's work may meet.
    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), Self::Error>;
    /// The topic of records.
    ///
    /// # Errors
    /// Whatever the visitor's work may meet.
    fn records(&mut self, row: &'static TopicRow) -> Result<(), Self::Error>;
}

/// What the names of topics begin with that are a user's own, see [`crate::user`].
pub const USER_PREFIX: &str = "user/";

/// Schema hash of a topic by its name and the hashes of its types.
pub(crate) const fn topic_schema(name: &str, envelope: u64, item: u64) -> u64 {
    let hash = fnv1a(FNV_OFFSET, name.as_bytes());
    fnv1a(fnv1a(hash, &envelope.to_le_bytes()), &item.to_le_bytes())
}

macro_rules! topics {
    ($($(#[$doc:meta])* $marker:ident = $number:literal $name:literal {
        envelope: $envelope:ident = $type_name:literal ($meta_type:ty),
        item: $item:ty,
        $discipline:ident,
        writers: [$($writer:ident),*],
        rings: [$($rung:ident),*],
        in_lockstep: [$($rung_in_lockstep:ident),*],
        len_max: $len_max:expr,
        check: |$meta:ident, $items:ident| $check:expr $(,)?
    })*) => {
        $(
            message! {
                /// Header and fixed fields of the topic's messages.
                pub struct $envelope = $type_name {
                    /// The header.
                    pub header: Header,
                    /// The fixed fields.
                    pub meta: $meta_type,
                }
            }

            impl Envelope for $envelope {
                type Meta = $meta_type;
                fn new(header: Header, meta: $meta_type) -> Self { Self { header, meta } }
                fn header(&self) -> &Header { &self.header }
                fn meta(&self) -> &$meta_type { &self.meta }
            }

            $(#[$doc])*
            #[derive(Debug)]
            pub enum $marker {}

            impl Topic for $marker {
                type Envelope = $envelope;
                type Meta = $meta_type;
                type Item = $item;
                const ROW: &'static TopicRow = &TopicRow {
                    number: $number,
                    name: $name,
                    discipline: Discipline::$discipline,
                    writers: &[$(Role::$writer),*],
                    rings: &[$(Role::$rung),*],
                    rings_in_lockstep: &[$(Role::$rung_in_lockstep),*],
                    len_max: $len_max,
                    envelope_bytes: size_of::<$envelope>(),
                    item_bytes: size_of::<$item>(),
                    schema: topic_schema(
                        $name,
                        <$envelope as Wire>::SCHEMA,
                        <$item as Wire>::SCHEMA,
                    ),
                };

                fn check($meta: &$meta_type, $items: &[$item]) -> Result<(), Refusal> { $check }
            }
        )*

        /// Every topic, in the order of the table; the health of each role and the records last.
        #[must_use]
        pub fn topics() -> Vec<&'static TopicRow> {
            let mut rows = vec![$(<$marker as Topic>::ROW),*];
            rows.retain(|row| row.number != HealthTopic::ROW.number);
            rows.extend(HEALTH.iter());
            rows.push(&SPANS);
            rows
        }

        /// Shows every topic to `visitor`.
        ///
        /// # Errors
        /// The visitor's first error.
        pub fn visit_topics<V: TopicVisitor>(visitor: &mut V) -> Result<(), V::Error> {
            $(
                if <$marker as Topic>::ROW.number != HealthTopic::ROW.number {
                    visitor.topic::<$marker>(<$marker as Topic>::ROW)?;
                }
            )*
            for row in &HEALTH {
                visitor.topic::<HealthTopic>(row)?;
            }
            visitor.records(&SPANS)
        }
    };
}

fn no_items<T>(items: &[T]) -> Result<(), Refusal> {
    ensure(items.is_empty(), Refusal::Length("items"))
}

topics! {
    /// `robot/description`: footprint, limits, lidar; the only home of these numbers.
    RobotDescription = 0 "robot/description" {
        envelope: DescriptionEnvelope = "zeronav.robot.description.v1" (Description),
        item: Corner, Latched,
        writers: [Robot],
        rings: [Mapping, GlobalPlanner, LocalPlanner, CollisionGuard], in_lockstep: [],
        len_max: FOOTPRINT_CORNERS_MAX,
        check: |meta, items| meta.check(items),
    }
    /// `robot/scan`: one turn of the lidar.
    RobotScan = 1 "robot/scan" {
        envelope: ScanEnvelope = "zeronav.robot.scan.v1" (Scan),
        item: f32, Latest,
        writers: [Robot], rings: [Mapping, LocalPlanner], in_lockstep: [],
        len_max: BEAMS_MAX,
        check: |meta, items| meta.check(items),
    }
    /// `robot/odometry`: pose and twist, the control tick.
    RobotOdometry = 2 "robot/odometry" {
        envelope: OdometryEnvelope = "zeronav.robot.odometry.v1" (Odometry),
        item: u8, Stream,
        writers: [Robot], rings: [LocalPlanner, CollisionGuard],
        in_lockstep: [Mapping, GlobalPlanner],
        len_max: 1,
        check: |meta, items| { no_items(items)?; meta.check() },
    }
    /// `map/update`: the tiles that changed.
    MapUpdate = 3 "map/update" {
        envelope: MapUpdateEnvelope = "zeronav.map.update.v1" (MapInfo),
        item: MapTile, Stream,
        writers: [Mapping], rings: [GlobalPlanner, LocalPlanner], in_lockstep: [],
        len_max: TILES_PER_UPDATE_MAX,
        check: |meta, items| meta.check(items, TILES_PER_UPDATE_MAX),
    }
    /// `map/keyframe`: all tiles.
    MapKeyframe = 4 "map/keyframe" {
        envelope: MapKeyframeEnvelope = "zeronav.map.keyframe.v1" (MapInfo),
        item: MapTile, Latched,
        writers: [Mapping], rings: [GlobalPlanner, LocalPlanner], in_lockstep: [],
        len_max: TILES_PER_KEYFRAME_MAX,
        check: |meta, items| meta.check(items, TILES_PER_KEYFRAME_MAX),
    }
    /// `map/obstacles`: tracked obstacles.
    MapObstacles = 5 "map/obstacles" {
        envelope: ObstaclesEnvelope = "zeronav.map.obstacles.v1" (Obstacles),
        item: Obstacle, Latest,
        writers: [Mapping], rings: [], in_lockstep: [],
        len_max: OBSTACLES_MAX,
        check: |meta, items| meta.check(items),
    }
    /// `plan/path`: the way to the goal.
    PlanPath = 6 "plan/path" {
        envelope: PathEnvelope = "zeronav.plan.path.v1" (Path),
        item: Waypoint, Latest,
        writers: [GlobalPlanner], rings: [LocalPlanner], in_lockstep: [],
        len_max: WAYPOINTS_MAX,
        check: |meta, items| meta.check(items),
    }
    /// `plan/request`: another path is needed.
    PlanRequests = 7 "plan/request" {
        envelope: PlanRequestEnvelope = "zeronav.plan.request.v1" (PlanRequest),
        item: u8, Latest,
        writers: [LocalPlanner], rings: [GlobalPlanner], in_lockstep: [],
        len_max: 1,
        check: |meta, items| { no_items(items)?; meta.check() },
    }
    /// `task/goal`: where to go.
    TaskGoal = 8 "task/goal" {
        envelope: TaskEnvelope = "zeronav.task.goal.v1" (Task),
        item: Goal, Latched,
        writers: [Launch], rings: [GlobalPlanner, LocalPlanner], in_lockstep: [],
        len_max: GOALS_MAX,
        check: |meta, items| meta.check(items),
    }
    /// `task/status`: what became of it.
    TaskState = 9 "task/status" {
        envelope: TaskStatusEnvelope = "zeronav.task.status.v1" (TaskStatus),
        item: GoalEnd, Latched,
        writers: [LocalPlanner], rings: [GlobalPlanner], in_lockstep: [],
        len_max: GOALS_MAX,
        check: |meta, items| meta.check(items),
    }
    /// `task/pose`: where the robot is.
    TaskPose = 24 "task/pose" {
        envelope: PoseEstimateEnvelope = "zeronav.task.pose.v1" (PoseEstimate),
        item: u8, Latched,
        writers: [Launch], rings: [Mapping], in_lockstep: [],
        len_max: 1,
        check: |meta, items| { no_items(items)?; meta.check() },
    }
    /// `task/zones`: where the robot may not go, where it is slow, which ways it prefers.
    TaskZones = 27 "task/zones" {
        envelope: ZonesEnvelope = "zeronav.task.zones.v1" (Zones),
        item: ZonePart, Latched,
        writers: [Launch], rings: [Mapping, LocalPlanner, CollisionGuard], in_lockstep: [],
        len_max: ZONE_PARTS_MAX,
        check: |meta, items| meta.check(items),
    }
    /// `control/velocity_request`: what the local planner wants.
    ControlRequest = 10 "control/velocity_request" {
        envelope: VelocityRequestEnvelope = "zeronav.control.velocity_request.v1" (VelocityRequest),
        item: u8, Latest,
        writers: [LocalPlanner], rings: [CollisionGuard], in_lockstep: [],
        len_max: 1,
        check: |meta, items| { no_items(items)?; meta.check() },
    }
    /// `robot/velocity_command`: what the wheels get.
    RobotCommand = 11 "robot/velocity_command" {
        envelope: VelocityCommandEnvelope = "zeronav.robot.velocity_command.v1" (VelocityCommand),
        item: u8, Latest,
        writers: [CollisionGuard], rings: [Robot], in_lockstep: [],
        len_max: 1,
        check: |meta, items| { no_items(items)?; meta.check() },
    }
    /// `run/clock`: what time means.
    RunClockTopic = 12 "run/clock" {
        envelope: RunClockEnvelope = "zeronav.run.clock.v1" (RunClock),
        item: u8, Latched,
        writers: [Launch],
        rings: [Robot, Mapping, GlobalPlanner, LocalPlanner, CollisionGuard], in_lockstep: [],
        len_max: 1,
        check: |meta, items| { no_items(items)?; meta.check() },
    }
    /// `run/control`: who is obeyed, how far the robot may go.
    RunControlTopic = 13 "run/control" {
        envelope: RunControlEnvelope = "zeronav.run.control.v1" (RunControl),
        item: Seat, Latched,
        writers: [Launch],
        rings: [Robot, Mapping, GlobalPlanner, LocalPlanner, CollisionGuard], in_lockstep: [],
        len_max: SEATS_MAX,
        check: |meta, items| meta.check(items),
    }
    /// `sim/ground_truth`: what is really so; for launch alone.
    GroundTruth = 14 "sim/ground_truth" {
        envelope: TruthEnvelope = "zeronav.sim.ground_truth.v1" (Truth),
        item: TruthObstacle, Latest,
        writers: [Robot], rings: [], in_lockstep: [],
        len_max: TRUTH_OBSTACLES_MAX,
        check: |meta, items| meta.check(items),
    }
    /// `sim/foresight`: what moves, and where it will be; only in a run that measures what perception
    /// and prediction cost.
    SimForesight = 26 "sim/foresight" {
        envelope: ForesightEnvelope = "zeronav.sim.foresight.v1" (Foresight),
        item: Foreseen, Latest,
        writers: [Robot], rings: [], in_lockstep: [],
        len_max: FORESEEN_MAX,
        check: |meta, items| meta.check(items),
    }
    /// `sim/placement`: obstacles that launch puts into a simulated world.
    SimPlacement = 22 "sim/placement" {
        envelope: PlacementEnvelope = "zeronav.sim.placement.v1" (Placements),
        item: Placement, Latest,
        writers: [Launch], rings: [Robot], in_lockstep: [],
        len_max: TRUTH_OBSTACLES_MAX,
        check: |meta, items| meta.check(items),
    }
    /// `debug/rollouts`: what the local planner looked at; sent only while somebody reads it.
    DebugRollouts = 25 "debug/rollouts" {
        envelope: RolloutsEnvelope = "zeronav.debug.rollouts.v1" (Rollouts),
        item: Rollout, Latest,
        writers: [LocalPlanner], rings: [], in_lockstep: [],
        len_max: ROLLOUTS_MAX,
        check: |meta, items| meta.check(items),
    }
    /// `health/<role>`: the heartbeat; its rows are in [`HEALTH`].
    HealthTopic = 15 "health" {
        envelope: HealthEnvelope = "zeronav.health.v1" (Health),
        item: u8, Latest,
        writers: [], rings: [], in_lockstep: [],
        len_max: 1,
        check: |meta, items| { no_items(items)?; meta.check() },
    }
}

const fn health_row(number: usize, name: &'static str, writers: &'static [Role]) -> TopicRow {
    TopicRow {
        number,
        name,
        discipline: Discipline::Latest,
        writers,
        rings: &[],
        rings_in_lockstep: &[],
        len_max: 1,
        envelope_bytes: size_of::<HealthEnvelope>(),
        item_bytes: 1,
        schema: topic_schema(name, <HealthEnvelope as Wire>::SCHEMA, <u8 as Wire>::SCHEMA),
    }
}

/// The heartbeat of each service.
pub static HEALTH: [TopicRow; 5] = [
    health_row(16, "health/robot", &[Role::Robot]),
    health_row(17, "health/mapping", &[Role::Mapping]),
    health_row(18, "health/global_planner", &[Role::GlobalPlanner]),
    health_row(19, "health/local_planner", &[Role::LocalPlanner]),
    health_row(20, "health/collision_guard", &[Role::CollisionGuard]),
];

/// The row of a service's heartbeat; `None` for roles without one.
#[must_use]
pub fn health_of(role: Role) -> Option<&'static TopicRow> {
    HEALTH.iter().find(|row| row.writers.contains(&role))
}

/// `run/spans`: one record per cycle and process. In lockstep it rings the robot, which waits for
/// the answers.
pub static SPANS: TopicRow = TopicRow {
    number: 21,
    name: "run/spans",
    discipline: Discipline::Records,
    writers: &Role::SERVICES,
    rings: &[],
    rings_in_lockstep: &[Role::Robot],
    len_max: 1,
    envelope_bytes: 0,
    item_bytes: size_of::<Span>(),
    schema: topic_schema("run/spans", 0, <Span as Wire>::SCHEMA),
};
