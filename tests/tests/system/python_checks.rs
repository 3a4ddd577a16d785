//! Python accepts and rejects the same messages as Rust: right ones with one word
//! changed.

use bytemuck::bytes_of;
use core::fmt::Write as _;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::process::{Command, Stdio};
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::grid::GridGeometry;
use zeronav_msgs::header::{Header, Id};
use zeronav_msgs::map::{CostModel, MapInfo, MapTile};
use zeronav_msgs::obstacles::{Obstacle, Obstacles};
use zeronav_msgs::path::{Path, PathCause, PathStatus, Waypoint};
use zeronav_msgs::role::Role;
use zeronav_msgs::rollouts::{Rollout, RolloutOutcome, Rollouts};
use zeronav_msgs::run::{RunClock, RunControl, RunMode, Seat};
use zeronav_msgs::scan::Scan;
use zeronav_msgs::task::{Goal, GoalEnd, Task, TaskKind, TaskState, TaskStatus};
use zeronav_msgs::topics::{Envelope, Topic, TopicRow, TopicVisitor, decode, seal, visit_topics};
use zeronav_msgs::zones::{ZoneKind, ZonePart, Zones};
use zeronav_tests::python::python;

/// Bytes of header, fixed fields and first item that are changed; an item of the map is larger, and
/// all its cells are alike.
const CHANGED_BYTES: usize = 176;

fn two_parts() -> Zones {
    Zones {
        revision: 1,
        n_parts: 2,
        ..Zones::default()
    }
}

/// Fixed fields and items of a message that is accepted, as bytes; empty where zeros are.
fn right(topic: &str) -> (Vec<u8>, Vec<Vec<u8>>) {
    let bytes = |meta: &[u8], items: &[&[u8]]| {
        let items = items.iter().map(|item| item.to_vec()).collect();
        (meta.to_vec(), items)
    };
    match topic.rsplit('/').next().unwrap_or("") {
        "description" => description(),
        "scan" => scan(),
        "update" | "keyframe" => map(),
        "obstacles" => {
            let list = Obstacles { n_obstacles: 2 };
            let one = Obstacle {
                radius_m: 0.3,
                ..Obstacle::default()
            };
            bytes(bytes_of(&list), &[bytes_of(&one), bytes_of(&one)])
        }
        "rollouts" => rollouts(),
        "path" => {
            let found = (PathStatus::Found, PathCause::Goal);
            let waypoints = [Waypoint::default(); 3];
            let path = Path::new("right", found.0, found.1, 4, &waypoints);
            bytes(bytes_of(&path), &waypoints.each_ref().map(bytes_of))
        }
        "goal" => {
            let task = Task {
                kind: TaskKind::Go.code(),
                n_goals: 2,
                ..Task::default()
            };
            let goal = Goal {
                tolerance_m: 0.2,
                yaw_tolerance_rad: 0.3,
                id: 1,
                ..Goal::default()
            };
            bytes(bytes_of(&task), &[bytes_of(&goal), bytes_of(&goal)])
        }
        "zones" => {
            let zones = two_parts();
            let part = ZonePart::new("ramp", ZoneKind::SpeedLimit, 0.3, &[[1.0; 2]; 3]);
            bytes(bytes_of(&zones), &[bytes_of(&part), bytes_of(&part)])
        }
        "status" => {
            let status = TaskStatus {
                n_ended: 1,
                ..TaskStatus::default()
            };
            let end = GoalEnd {
                state: TaskState::Reached.code(),
                ..GoalEnd::default()
            };
            bytes(bytes_of(&status), &[bytes_of(&end)])
        }
        "clock" => {
            let clock = RunClock {
                mode: RunMode::Lockstep.code(),
                tick_ns: 20_000_000,
                ..RunClock::default()
            };
            bytes(bytes_of(&clock), &[])
        }
        "control" => {
            let control = RunControl {
                n_seats: 2,
                ..RunControl::default()
            };
            let seat = Seat {
                role: Role::Mapping.code(),
                epoch: 1,
                ..Seat::default()
            };
            bytes(bytes_of(&control), &[bytes_of(&seat), bytes_of(&seat)])
        }
        _ => bytes(&[], &[]),
    }
}

fn rollouts() -> (Vec<u8>, Vec<Vec<u8>>) {
    let list = Rollouts {
        n_rollouts: 2,
        ..Rollouts::default()
    };
    let one = |outcome: RolloutOutcome| Rollout {
        outcome: outcome.code(),
        n_points: 2,
        ..Rollout::default()
    };
    let both = [RolloutOutcome::Chosen, RolloutOutcome::NoStop].map(one);
    let items = both.iter().map(|one| bytes_of(one).to_vec());
    (bytes_of(&list).to_vec(), items.collect())
}

fn scan() -> (Vec<u8>, Vec<Vec<u8>>) {
    let scan = Scan {
        n_beams: 3,
        angle_min_rad: -1.0,
        angle_increment_rad: 0.5,
        range_m_min: 0.05,
        range_m_max: 12.0,
        ..Scan::default()
    };
    let ranges = [1.0_f32, f32::INFINITY, f32::NAN];
    let ranges = ranges.iter().map(|range| bytes_of(range).to_vec());
    (bytes_of(&scan).to_vec(), ranges.collect())
}

fn description() -> (Vec<u8>, Vec<Vec<u8>>) {
    let robot = Description {
        inscribed_radius_m: 0.2,
        circumscribed_radius_m: 0.3,
        v_mps_max: 1.0,
        v_mps_min: -0.2,
        w_radps_max: 1.0,
        a_mps2_max: 1.0,
        brake_mps2: 1.0,
        alpha_radps2_max: 2.0,
        angle_min_rad: -3.0,
        angle_increment_rad: 0.01,
        range_m_min: 0.05,
        range_m_max: 10.0,
        scan_period_ns: 100_000_000,
        n_beams: 360,
        n_corners: 3,
        ..Description::default()
    };
    let corner = bytes_of(&Corner { x_m: 0.3, y_m: 0.2 }).to_vec();
    (bytes_of(&robot).to_vec(), vec![corner; 3])
}

fn map() -> (Vec<u8>, Vec<Vec<u8>>) {
    let info = MapInfo {
        geometry: GridGeometry {
            resolution_m: 0.05,
            width: 70,
            height: 33,
            ..GridGeometry::default()
        },
        revision: Id::new(1, 1).0,
        parts: 2,
        n_tiles: 1,
        clearance_limit_mm: 1000,
        cost_model: CostModel {
            inscribed_radius_m: 0.2,
            ..CostModel::default()
        },
        ..MapInfo::default()
    };
    let tile = MapTile {
        tile_x: 2,
        tile_y: 1,
        ..MapTile::default()
    };
    (bytes_of(&info).to_vec(), vec![bytes_of(&tile).to_vec()])
}

/// Values at the edges of checks.
fn edges() -> Vec<Vec<u8>> {
    let doubles = [
        f64::NAN,
        f64::INFINITY,
        -1.0,
        -0.0,
        1.0e6,
        1.0e7,
        1.0e13,
        0.05,
        7.0,
    ];
    let singles = [f32::NAN, -1.0, f32::NEG_INFINITY, 5.0e3];
    let mut words: Vec<Vec<u8>> = doubles.iter().map(|one| bytes_of(one).to_vec()).collect();
    words.extend(singles.iter().map(|one| bytes_of(one).to_vec()));
    words.extend([0, u64::MAX].map(|one: u64| bytes_of(&one).to_vec()));
    words.extend([2, 70_000].map(|one: u32| bytes_of(&one).to_vec()));
    words.extend([0, 1, 9].map(|one: u16| bytes_of(&one).to_vec()));
    words.extend([64, 255].map(|one: u8| vec![one]));
    words
}

/// `bytes` with each aligned word of its first [`CHANGED_BYTES`] changed to each edge in turn.
fn changed(bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for word in edges() {
        let end = bytes.len().min(CHANGED_BYTES);
        for place in (0..=end.saturating_sub(word.len())).step_by(word.len()) {
            let mut other = bytes.to_vec();
            if let Some(words) = other.get_mut(place..place + word.len()) {
                words.copy_from_slice(&word);
                all.push(other);
            }
        }
    }
    all
}

/// Writes changed messages and what Rust says to them.
#[derive(Default)]
struct Changer {
    /// A line per message: topic, envelope and items in hexadecimal digits.
    lines: String,
    /// Topic and whether it was accepted, a message each.
    verdicts: Vec<(&'static str, bool)>,
}

impl Changer {
    /// A message with a checksum that fits.
    fn take<T: Topic>(&mut self, row: &'static TopicRow, parts: &[&[u8]], items: &[Vec<u8>]) {
        let (envelope, slice) = typed::<T>(parts, items);
        let envelope = seal::<T>(*envelope.header(), *envelope.meta(), &slice);
        self.say::<T>(row, envelope, &slice);
    }

    /// A message as it is.
    fn take_raw<T: Topic>(&mut self, row: &'static TopicRow, parts: &[&[u8]], items: &[Vec<u8>]) {
        let (envelope, slice) = typed::<T>(parts, items);
        self.say::<T>(row, envelope, &slice);
    }

    fn say<T: Topic>(&mut self, row: &'static TopicRow, envelope: T::Envelope, slice: &[T::Item]) {
        let accepted = decode::<T>(row, &envelope, slice).is_ok();
        self.verdicts.push((row.name, accepted));
        let _ = write!(self.lines, "{} ", row.name);
        let items: &[u8] = bytemuck::cast_slice(slice);
        for byte in bytes_of(&envelope).iter().chain(items) {
            let _ = write!(self.lines, "{byte:02x}");
        }
        self.lines.push('\n');
    }
}

fn typed<T: Topic>(parts: &[&[u8]], items: &[Vec<u8>]) -> (T::Envelope, Vec<T::Item>) {
    let items = items.iter();
    let items = items.map(|item| bytemuck::pod_read_unaligned(item));
    (
        bytemuck::pod_read_unaligned(&parts.concat()),
        items.collect(),
    )
}

impl TopicVisitor for Changer {
    type Error = String;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), String> {
        // Of launch and the simulator, and of runs that measure; the package does not read them.
        if row.name.starts_with("sim/") {
            return Ok(());
        }
        let (mut meta, items) = right(row.name);
        meta.resize(row.envelope_bytes - size_of::<Header>(), 0);
        let header = Header {
            schema: u32::try_from(row.schema & 0xffff_ffff).expect("32 bits"),
            role: row.writers[0].code(),
            id: Id::new(1, 1).0,
            ..Header::default()
        };
        let head = bytes_of(&header);
        self.take::<T>(row, &[head, &meta], &items);
        if !self.verdicts.last().is_some_and(|(_, accepted)| *accepted) {
            return Err(format!("{}: the right message is rejected", row.name));
        }
        for head in changed(head) {
            self.take::<T>(row, &[&head, &meta], &items);
            self.take_raw::<T>(row, &[&head, &meta], &items);
        }
        for meta in changed(&meta) {
            self.take::<T>(row, &[head, &meta], &items);
        }
        for first in items.first().map(|item| changed(item)).unwrap_or_default() {
            let others = items.iter().skip(1).cloned();
            let items: Vec<Vec<u8>> = std::iter::once(first).chain(others).collect();
            self.take::<T>(row, &[head, &meta], &items);
        }
        let longer = [items.clone(), vec![vec![0; row.item_bytes]]].concat();
        self.take::<T>(row, &[head, &meta], &longer);
        let shorter: Vec<Vec<u8>> = items.iter().skip(1).cloned().collect();
        self.take::<T>(row, &[head, &meta], &shorter);
        Ok(())
    }

    fn records(&mut self, _row: &'static TopicRow) -> Result<(), String> {
        Ok(())
    }
}

/// Says for every line whether the package accepts the message.
const PROGRAM: &str = "
import ctypes, sys
import numpy as np
from zeronav import checks, contract
topics = {topic.name: topic for topic in contract.TOPICS}
for line in sys.stdin:
    name, digits = line.split()
    topic, data = topics[name], bytes.fromhex(digits)
    size = ctypes.sizeof(topic.envelope)
    items = np.frombuffer(data[size:], np.dtype(topic.item))
    try:
        checks.decode(topic, topic.envelope.from_buffer_copy(data), items)
        print(1)
    except checks.Refused as refusal:
        print(0, refusal)
";

#[test]
fn python_and_rust_accept_the_same_messages() {
    let mut changer = Changer::default();
    visit_topics(&mut changer).expect("right messages");
    let mut child = Command::new(python())
        .args(["-c", PROGRAM])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("Python runs");
    let (mut input, lines) = (child.stdin.take().expect("a pipe"), changer.lines);
    let writer = std::thread::spawn(move || input.write_all(lines.as_bytes()));
    let output = child.wait_with_output().expect("its output");
    writer.join().expect("no panic").expect("written");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.lines().count() == changer.verdicts.len());
    let mut counts: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for ((topic, accepted), said) in changer.verdicts.iter().zip(said.lines()) {
        assert_eq!(
            said.starts_with('1'),
            *accepted,
            "{topic}: Python says {said}"
        );
        counts.entry(topic).or_default()[usize::from(*accepted)] += 1;
    }
    for (topic, [rejected, accepted]) in counts {
        assert!(
            rejected >= 20 && accepted >= 20,
            "{topic}: {rejected}, {accepted}"
        );
    }
}
