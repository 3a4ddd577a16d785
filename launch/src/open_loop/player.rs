//! The ports of the seats that are played: what was recorded is sent again byte for byte, and whoever is to be rung
//! for it is.

use super::score::Score;
use crate::recorded::notes::Note;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{Discipline, Topic, TopicRow, TopicVisitor, visit_topics};
use zeronav_msgs::user::name_in;
use zeronav_shell::doorbell::Bells;
use zeronav_shell::{Domain, Peer, RawUnsent, RawWriter, StartError};

/// Guests are not restarted.
const EPOCH: u32 = 1;

/// How long readers may hold all memory of a topic, and time between two tries.
const HELD_LIMIT: Duration = Duration::from_secs(60);
const PAUSE: Duration = Duration::from_micros(200);

/// See the module's description.
pub(super) struct Player {
    writers: BTreeMap<&'static str, RawWriter>,
    bells: Bells,
    live: Vec<Role>,
    peer: Peer,
}

impl core::fmt::Debug for Player {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Player").finish_non_exhaustive()
    }
}

impl Player {
    /// Opens a writer of each topic of `score` in the domain at `root`.
    ///
    /// # Errors
    /// What the middleware says.
    pub(super) fn open(root: &Path, score: &Score, live: &[Role]) -> Result<Self, StartError> {
        let peer = Peer::join(Domain::join(root)?, Role::Tap, EPOCH)?;
        let mut most: BTreeMap<&str, usize> = BTreeMap::new();
        for note in &score.notes {
            let len = note.parts().1.len() / note.row.item_bytes.max(1);
            let before = most.entry(note.row.name).or_default();
            *before = len.max(*before);
        }
        let mut opener = Opener {
            peer: &peer,
            most,
            writers: BTreeMap::new(),
        };
        visit_topics(&mut opener)?;
        for (row, form) in &score.users {
            if let Some((name, len)) = name_in(row.name).zip(opener.most.get(row.name)) {
                let writer = peer.raw_user_writer(name, form, *len)?;
                opener.writers.insert(row.name, writer);
            }
        }
        Ok(Self {
            writers: opener.writers,
            bells: Bells::open(&peer)?,
            live: live.to_vec(),
            peer,
        })
    }

    /// Sends a message.
    ///
    /// # Errors
    /// One line when it cannot be sent.
    pub(super) fn play(&mut self, note: &Note) -> Result<(), String> {
        let Some(writer) = self.writers.get_mut(note.row.name) else {
            return Ok(());
        };
        let (envelope, items) = note.parts();
        let since = Instant::now();
        while let Err(unsent) = writer.send(envelope, items) {
            if unsent != RawUnsent::NoMemory || since.elapsed() > HELD_LIMIT {
                return Err(format!("{} of tick {}: {unsent}", note.row.name, note.tick));
            }
            std::thread::sleep(PAUSE);
        }
        let rows = note.row.rings.iter().chain(note.row.rings_in_lockstep);
        for role in rows.filter(|role| self.live.contains(role)) {
            self.bells.ring(*role, note.row.number);
        }
        Ok(())
    }

    /// Brings the last message of each latched topic to readers that joined since.
    pub(super) fn refresh(&self) {
        for writer in self.writers.values() {
            writer.refresh();
        }
    }

    /// Leaves the domain.
    pub(super) fn leave(self) {
        drop((self.writers, self.bells));
        // What is left of it goes with the stack.
        let _ = self.peer.leave().close();
    }
}

/// True for a topic whose last message reaches readers that join later.
pub(super) fn is_latched(row: &TopicRow) -> bool {
    row.discipline == Discipline::Latched
}

struct Opener<'a> {
    peer: &'a Peer,
    /// Most items in a message, of the topics that are played.
    most: BTreeMap<&'a str, usize>,
    writers: BTreeMap<&'static str, RawWriter>,
}

impl TopicVisitor for Opener<'_> {
    type Error = StartError;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), StartError> {
        if let Some(len) = self.most.get(row.name) {
            let writer = self.peer.raw_writer_on::<T>(row, *len)?;
            self.writers.insert(row.name, writer);
        }
        Ok(())
    }

    fn records(&mut self, _: &'static TopicRow) -> Result<(), StartError> {
        Ok(())
    }
}
