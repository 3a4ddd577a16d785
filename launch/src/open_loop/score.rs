//! What is played: the messages of a recording, but those of the open seats, in the order in which they were sent.

use crate::bag::input::open;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use zeronav_msgs::header::Header;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::role::Role;
use zeronav_msgs::seats::{Answers, SEATS, SeatRow};
use zeronav_msgs::topics::{
    DebugRollouts, Envelope, HEALTH, RobotOdometry, RunClockTopic, RunControlTopic, SPANS, Topic,
    TopicRow, TopicVisitor, topics, visit_topics,
};
use zeronav_recorder::accepted::{Check, accepted};
use zeronav_recorder::holders::Holders;
use zeronav_recorder::messages::native_messages;
use zeronav_recorder::native::PREFIX;
use zeronav_recorder::read::Summary;

/// Most that is held in memory. [bytes]
const BYTES_MAX: usize = 2 << 30;

/// A message to be played.
#[derive(Debug, Clone)]
pub(super) struct Note {
    pub row: &'static TopicRow,
    /// Who sent it; launch, too.
    pub role: Role,
    pub epoch: u32,
    pub tick: u64,
    /// When. [ns] by the clock of the machine that recorded it
    pub sent_ns: u64,
    /// Header and fixed fields, then items.
    pub bytes: Vec<u8>,
}

impl Note {
    /// Header with fixed fields, and items.
    pub(super) fn parts(&self) -> (&[u8], &[u8]) {
        self.bytes
            .split_at(self.row.envelope_bytes.min(self.bytes.len()))
    }

    /// Its header.
    pub(super) fn header(&self) -> Header {
        let bytes = self.bytes.get(..size_of::<Header>());
        bytes.map_or_else(Header::default, bytemuck::pod_read_unaligned)
    }

    /// What it says when it is odometry.
    pub(super) fn odometry(&self) -> Option<Odometry> {
        type OfOdometry = <RobotOdometry as Topic>::Envelope;
        if self.row.number != RobotOdometry::ROW.number {
            return None;
        }
        let envelope: OfOdometry = bytemuck::try_pod_read_unaligned(self.parts().0).ok()?;
        Some(*envelope.meta())
    }
}

/// All that is played.
#[derive(Debug, Default)]
pub(super) struct Score {
    /// In the order in which they were sent.
    pub notes: Vec<Note>,
    /// The ticks of the robot, and whether each came with a scan.
    pub ticks: BTreeMap<u64, bool>,
    /// The ticks that each seat has answered in the recording.
    pub answered: BTreeMap<Role, BTreeSet<u64>>,
    /// The first process of each seat that is played.
    pub epochs: BTreeMap<Role, u32>,
}

/// The row of a seat.
pub(super) fn seat_row(role: Role) -> Option<&'static SeatRow> {
    SEATS.iter().find(|seat| seat.role == role)
}

/// Every message of the recording in `file`, summed up as `found`, that was obeyed: in the order in which they were sent.
///
/// # Errors
/// One line naming the file.
pub(super) fn notes_of(file: &Path, found: &Summary) -> Result<Vec<Note>, String> {
    let wrong = |why: &dyn core::fmt::Display| format!("{}: {why}", file.display());
    same_contract(found).map_err(|why| wrong(&why))?;
    let mut checks = Checks::default();
    match visit_topics(&mut checks) {
        Ok(()) => {}
    }
    let mut reading = Reading {
        notes: Vec::new(),
        holders: Holders::default(),
        checks: checks.0,
        bytes: 0,
    };
    let wants = |name: &str| {
        let left_out = [RunClockTopic::ROW.name, SPANS.name, DebugRollouts::ROW.name];
        !left_out.contains(&name) && HEALTH.iter().all(|row| row.name != name)
    };
    native_messages(open(file)?, wants, |name, layout, parts| {
        if name == RunControlTopic::ROW.name {
            reading.holders.see(layout, parts[1]);
        } else {
            reading.take(name, parts);
        }
    })
    .map_err(|error| wrong(&error))?;
    if reading.bytes > BYTES_MAX {
        return Err(wrong(&"it is too long to be played: name a shorter one"));
    }
    let mut notes = reading.notes;
    // Processes of one machine have one clock. What a recorder wrote first stays first.
    notes.sort_by_key(|note| note.sent_ns);
    if !notes.iter().any(|note| note.odometry().is_some()) {
        let why = format!("it has no message on {}", RobotOdometry::ROW.name);
        return Err(wrong(&why));
    }
    Ok(notes)
}

impl Score {
    /// What of these messages is played when the seats in `live` are open.
    pub(super) fn of(notes: Vec<Note>, live: &[Role]) -> Self {
        let mut score = Self::default();
        for note in notes.iter().filter(|note| note.tick > 0) {
            if let Some(odometry) = note.odometry() {
                let with_scan = score.ticks.entry(note.tick).or_default();
                *with_scan |= odometry.scan_due();
            }
            let owed = seat_row(note.role).and_then(|seat| seat.owes.last());
            if owed.is_some_and(|owed| owed.name == note.row.name) {
                let answered = score.answered.entry(note.role).or_default();
                answered.insert(note.tick);
            }
            score.epochs.entry(note.role).or_insert(note.epoch);
        }
        score.notes = in_order(notes);
        score.notes.retain(|note| !live.contains(&note.role));
        score
    }

    /// True when the seat of `role` has to answer this tick.
    pub(super) fn is_due(&self, role: Role, tick: u64) -> bool {
        let with_scan = self.ticks.get(&tick);
        match seat_row(role).map(|seat| seat.answers) {
            Some(Answers::EveryTick) => with_scan.is_some(),
            Some(Answers::TicksWithScan) => with_scan == Some(&true),
            None => false,
        }
    }

    /// From `tick` on, the ticks that the seat of `role` has not answered in the recording although it was to; `None`
    /// when it has.
    pub(super) fn gap(&self, role: Role, tick: u64) -> Option<[u64; 2]> {
        let none = BTreeSet::new();
        let answered = self.answered.get(&role).unwrap_or(&none);
        if !self.is_due(role, tick) || answered.contains(&tick) {
            return None;
        }
        let next = answered.range(tick..).next();
        Some([tick, next.copied().unwrap_or(u64::MAX)])
    }

    /// The last tick.
    pub(super) fn last_tick(&self) -> u64 {
        self.ticks.keys().next_back().copied().unwrap_or(0)
    }
}

/// The messages of a tick in the order of the data flow: a seat behind an empty one has not waited for it, and an open seat
/// is never empty.
fn in_order(notes: Vec<Note>) -> Vec<Note> {
    let mut newest = 0;
    let mut placed: Vec<((u64, usize), Note)> = notes
        .into_iter()
        .map(|note| {
            let rank = Role::SERVICES.iter().position(|role| *role == note.role);
            // What belongs to no tick comes behind the one in which it was sent.
            let place = match rank.filter(|_| note.tick > 0) {
                Some(rank) => (note.tick, rank),
                None => (newest, Role::SERVICES.len()),
            };
            if note.role == Role::Robot {
                newest = newest.max(note.tick);
            }
            (place, note)
        })
        .collect();
    // Those of one place stay as they were sent.
    placed.sort_by_key(|(place, _)| *place);
    placed.into_iter().map(|(_, note)| note).collect()
}

/// Accepts a recording whose topics have the layout of this build.
fn same_contract(found: &Summary) -> Result<(), String> {
    for row in topics() {
        let name = format!("{PREFIX}{}", row.name);
        let mut channels = found.channels.values();
        let channel = channels.find(|channel| channel.topic == name);
        let expected = format!("{:016x}", row.schema);
        let schema = channel.and_then(|channel| channel.metadata.get("schema_hash"));
        if channel.is_some() && schema != Some(&expected) {
            let library = &found.library;
            return Err(format!(
                "{} has another layout than in this build: replay it with the version that recorded it ({library})",
                row.name
            ));
        }
    }
    Ok(())
}

/// How each topic is checked.
#[derive(Default)]
struct Checks(BTreeMap<&'static str, (&'static TopicRow, Check)>);

impl TopicVisitor for Checks {
    type Error = core::convert::Infallible;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), Self::Error> {
        self.0.insert(row.name, (row, accepted::<T>));
        Ok(())
    }

    fn records(&mut self, _: &'static TopicRow) -> Result<(), Self::Error> {
        Ok(())
    }
}

/// A recording while it is read.
struct Reading {
    notes: Vec<Note>,
    holders: Holders,
    checks: BTreeMap<&'static str, (&'static TopicRow, Check)>,
    bytes: usize,
}

impl Reading {
    fn take(&mut self, name: &str, [envelope, items]: [&[u8]; 2]) {
        let Some((row, check)) = self.checks.get(name).copied() else {
            return;
        };
        let Some(header) = check(row, envelope, items) else {
            return;
        };
        let Some(role) = header.role().filter(|role| self.is_obeyed(*role, &header)) else {
            return;
        };
        self.bytes += envelope.len() + items.len();
        if self.bytes > BYTES_MAX {
            return;
        }
        self.notes.push(Note {
            row,
            role,
            epoch: header.id().epoch(),
            tick: header.tick,
            sent_ns: header.stamps.published_ns,
            bytes: [envelope, items].concat(),
        });
    }

    fn is_obeyed(&self, role: Role, header: &Header) -> bool {
        let epoch = u64::from(header.id().epoch());
        let author = [Some(u64::from(role.code())), Some(epoch), Some(header.tick)];
        role == Role::Launch || self.holders.obey(author)
    }
}
