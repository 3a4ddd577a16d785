//! What is played: the messages of a recording, but those of the open seats, in the order in which they were sent.

use crate::recorded::notes::{Heard, Note, obeyed};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use zeronav_msgs::role::Role;
use zeronav_msgs::seats::{Answers, SEATS, SeatRow};
use zeronav_msgs::topics::{
    DebugRollouts, HEALTH, RobotOdometry, RunClockTopic, SPANS, Topic, TopicRow,
};
use zeronav_msgs::user::Form;
use zeronav_recorder::read::Summary;

/// Most that is held in memory. [bytes]
const BYTES_MAX: usize = 2 << 30;

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
    /// Topics of users, each with the form of its messages.
    pub users: Vec<(&'static TopicRow, Form)>,
}

/// The row of a seat.
pub(super) fn seat_row(role: Role) -> Option<&'static SeatRow> {
    SEATS.iter().find(|seat| seat.role == role)
}

/// Every message of the recording in `file`, summed up as `found`, that was obeyed: in the order in which they were sent.
///
/// # Errors
/// One line naming the file.
pub(super) fn notes_of(
    file: &Path,
    (found, users): (&Summary, &[(&'static TopicRow, Form)]),
) -> Result<Vec<Note>, String> {
    let wrong = |why: &dyn core::fmt::Display| format!("{}: {why}", file.display());
    let (mut notes, mut bytes) = (Vec::new(), 0);
    let wants = |name: &str| {
        let left_out = [RunClockTopic::ROW.name, SPANS.name, DebugRollouts::ROW.name];
        !left_out.contains(&name) && HEALTH.iter().all(|row| row.name != name)
    };
    obeyed(file, (found, users), wants, |heard| {
        if let Heard::Note(note) = heard {
            bytes += note.bytes.len();
            if bytes <= BYTES_MAX {
                notes.push(note);
            }
        }
    })?;
    if bytes > BYTES_MAX {
        return Err(wrong(&"it is too long to be played: name a shorter one"));
    }
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
