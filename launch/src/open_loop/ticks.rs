//! A recording of a run in real time as one in ticks, so that it can be played in lockstep.
//!
//! In real time a scan may be captured between two ticks, a stage answers when something comes, and the robot ticks before
//! the others are ready. Here a scan belongs to the next tick, and so does what mapping and the global planner made of it;
//! all others belong to the tick that they answer. Within a tick messages come in the order of the data flow, of each stage
//! behind mapping one (`once.rs`), and idle outputs come before the first tick. Otherwise what an open seat sees would depend
//! on the moment at which it looks.

use super::once::{LeftOut, once};
use crate::prepare::Prepared;
use crate::recorded::notes::Note;
use std::collections::BTreeMap;
use std::io::BufWriter;
use std::path::PathBuf;
use zeronav_msgs::header::{Header, Stamps};
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::path::Path;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::topics::{
    Envelope, MapUpdate, PlanPath, RobotOdometry, RobotScan, Topic, TopicRow, TopicVisitor, seal,
    visit_topics,
};
use zeronav_msgs::user::Form;
use zeronav_recorder::file::DRIVEN_BY;
use zeronav_recorder::made::Made;
use zeronav_recorder::native::NativeTopic;

/// The file in the run's folder.
const FILE: &str = "played.mcap";

/// Where a message belongs: its tick, its place in the data flow, and when it was sent.
type Place = (u64, usize, u64);

/// These messages of a run that ended with `end_tick` in ticks, and the recording of them, which is left in the run's folder.
///
/// # Errors
/// One line when that cannot be written.
pub(super) fn in_ticks(
    (notes, users): (Vec<Note>, &[(&'static TopicRow, Form)]),
    prepared: &Prepared,
    end_tick: Option<u64>,
) -> Result<(Vec<Note>, PathBuf), String> {
    let notes = sorted(notes);
    let path = prepared.folder.path().join(FILE);
    let failed = |why: &dyn core::fmt::Display| format!("writing {}: {why}", path.display());
    let file = prepared
        .folder
        .new_file(FILE)
        .map_err(|error| failed(&error))?;
    let fields = [
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("mode", RunMode::Lockstep.label().to_owned()),
        ("seed", prepared.seed.to_string()),
        ("tick_ns", prepared.scenario.run.tick_ns().to_string()),
        ("times", "run time".to_owned()),
        ("run_zero_ns", "0".to_owned()),
        (DRIVEN_BY, "recording".to_owned()),
    ];
    let fields = fields.map(|(key, value)| (key.to_owned(), value));
    let mut made =
        Made::begin(BufWriter::new(file), fields.into(), None).map_err(|error| failed(&error))?;
    for (row, form) in users {
        made.add(NativeTopic::of_user(row, form));
    }
    let mut last_tick = 0;
    for note in &notes {
        let (envelope, items) = note.parts();
        last_tick = note.tick.max(last_tick);
        made.put(note.row, &note.header(), [envelope, items])
            .map_err(|error| failed(&error))?;
    }
    let end_tick = end_tick.unwrap_or(last_tick.saturating_add(1));
    made.finish(end_tick, None)
        .map_err(|error| failed(&error))?;
    Ok((notes, path))
}

/// The messages with their ticks, in the order of the data flow.
fn sorted(notes: Vec<Note>) -> Vec<Note> {
    let mut ticks = Ticks::default();
    // A scan is known by the odometry behind it, and what was made of it by its identity.
    let of_scans = ticks.scans(&notes);
    let mut placed: Vec<(Place, Note)> = notes
        .into_iter()
        .map(|note| ticks.place(&of_scans, note))
        .collect();
    placed.sort_by_key(|(place, _)| *place);
    let (notes, left_out) = once(placed.into_iter().map(|(_, note)| note).collect());
    let mut reseal = Reseal {
        by_topic: BTreeMap::new(),
        last_tick: 0,
        left_out,
    };
    match visit_topics(&mut reseal) {
        Ok(()) => {}
    }
    let with_scan: Vec<u64> = of_scans.values().copied().collect();
    let sealed = notes.into_iter().enumerate().map(|(n, note)| {
        let is_odometry = note.row.number == RobotOdometry::ROW.number;
        let is_first = is_odometry && note.tick > reseal.last_tick;
        if is_first {
            reseal.last_tick = note.tick;
        }
        let scan_due = is_odometry.then_some(is_first && with_scan.contains(&note.tick));
        reseal.again(note, n as u64 + 1, scan_due)
    });
    sealed.collect()
}

/// What is known of the ticks while messages are looked at in the order in which they were sent.
#[derive(Default)]
struct Ticks {
    /// The newest of the robot.
    newest: u64,
    /// Those of map updates by their identity.
    of_maps: BTreeMap<u64, u64>,
}

impl Ticks {
    /// The tick of every scan, by its identity: that of the next tick of the robot.
    fn scans(&self, notes: &[Note]) -> BTreeMap<u64, u64> {
        let (mut of_scans, mut waiting, mut newest) = (BTreeMap::new(), Vec::new(), self.newest);
        for note in notes.iter().filter(|note| note.role == Role::Robot) {
            if note.row.number == RobotScan::ROW.number {
                waiting.push(note.header().id);
            } else if note.row.number == RobotOdometry::ROW.number && note.tick > newest {
                newest = note.tick;
                of_scans.extend(waiting.drain(..).map(|scan| (scan, newest)));
            }
        }
        of_scans
    }

    /// Tick, place in the data flow and time of a message.
    fn place(&mut self, of_scans: &BTreeMap<u64, u64>, mut note: Note) -> (Place, Note) {
        let header = note.header();
        let tick = match note.role {
            Role::Robot if note.row.number == RobotScan::ROW.number => of_scans.get(&header.id),
            Role::Mapping => of_scans.get(&header.parents.scan),
            Role::GlobalPlanner => self.of_maps.get(&header.parents.map),
            _ => None,
        };
        if note.tick > 0 {
            note.tick = tick.copied().unwrap_or(note.tick);
        }
        if note.row.number == MapUpdate::ROW.number {
            self.of_maps.insert(header.id, note.tick);
        }
        if note.row.number == RobotOdometry::ROW.number {
            self.newest = self.newest.max(note.tick);
        }
        let services = Role::SERVICES;
        let rank = services.iter().position(|role| *role == note.role);
        // What belongs to no tick comes behind the one in which it was sent.
        let place = match rank {
            Some(rank) => (note.tick, rank, note.sent_ns),
            None => (self.newest, services.len(), note.sent_ns),
        };
        (place, note)
    }
}

/// A message's envelope with this header, the word for a scan where it is odometry, and the numbers of those that stay.
type Again = fn(&[u8], &[u8], Header, Option<bool>, &LeftOut) -> Option<Vec<u8>>;

struct Reseal {
    by_topic: BTreeMap<&'static str, Again>,
    last_tick: u64,
    left_out: LeftOut,
}

impl Reseal {
    /// The message with its tick, sent as the `n`-th.
    fn again(&self, mut note: Note, n: u64, scan_due: Option<bool>) -> Note {
        let header = Header {
            tick: note.tick,
            stamps: Stamps {
                woken_ns: n,
                started_ns: n,
                published_ns: n,
            },
            ..self.left_out.header(note.row.name, note.header())
        };
        let again = self.by_topic.get(note.row.name);
        let (envelope, items) = note.parts();
        let envelope =
            again.and_then(|again| again(envelope, items, header, scan_due, &self.left_out));
        if let Some(envelope) = envelope {
            note.bytes = [&envelope[..], items].concat();
            note.sent_ns = n;
        }
        note
    }
}

impl TopicVisitor for Reseal {
    type Error = core::convert::Infallible;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), Self::Error> {
        self.by_topic.insert(row.name, again::<T>);
        Ok(())
    }

    fn records(&mut self, _: &'static TopicRow) -> Result<(), Self::Error> {
        Ok(())
    }
}

fn again<T: Topic>(
    envelope: &[u8],
    items: &[u8],
    header: Header,
    scan_due: Option<bool>,
    left_out: &LeftOut,
) -> Option<Vec<u8>> {
    let envelope: T::Envelope = bytemuck::try_pod_read_unaligned(envelope).ok()?;
    let items: Vec<T::Item> = bytemuck::pod_collect_to_vec(items);
    let mut meta = *envelope.meta();
    if let Some(due) = scan_due {
        let odometry: &mut Odometry =
            bytemuck::try_from_bytes_mut(bytemuck::bytes_of_mut(&mut meta)).ok()?;
        odometry.scan_due = u32::from(due);
    } else if T::ROW.number == PlanPath::ROW.number {
        let path: &mut Path =
            bytemuck::try_from_bytes_mut(bytemuck::bytes_of_mut(&mut meta)).ok()?;
        path.geometry = left_out.geometry(path.geometry);
    }
    Some(bytemuck::bytes_of(&seal::<T>(header, meta, &items)).to_vec())
}
