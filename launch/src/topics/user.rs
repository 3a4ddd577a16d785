//! Topics of a user's own, which are made while a run goes on and say themselves what their bytes mean.

use super::message::Message;
use zeronav_msgs::header::Id;
use zeronav_msgs::topics::TopicRow;
use zeronav_msgs::user::{self, Form};
use zeronav_shell::{Peer, StartError, UserReader};

/// A topic that exists.
#[derive(Debug)]
pub(super) struct Found {
    /// Its row.
    pub row: &'static TopicRow,
    /// What its bytes mean.
    pub form: Form,
    /// What stands behind the prefix.
    name: String,
}

impl Found {
    /// No message yet.
    pub(super) fn message(&self) -> Message {
        Message::of_user(self.row, &self.form)
    }

    /// How many writers and readers it has now.
    ///
    /// # Errors
    /// As [`Peer::user_ports`].
    pub(super) fn ports(&self, peer: &Peer) -> Result<[usize; 2], StartError> {
        peer.user_ports(&self.name, &self.form)
    }

    /// Opens a reader.
    ///
    /// # Errors
    /// As [`Peer::user_reader`].
    pub(super) fn follow(&self, peer: &Peer) -> Result<Follower, StartError> {
        Ok(Follower {
            reader: peer.user_reader(&self.name, &self.form)?,
            last: (0, Id::NONE),
        })
    }
}

/// All that exist now, by name.
///
/// # Errors
/// One line when they cannot be listed.
pub(super) fn all(peer: &Peer) -> Result<Vec<Found>, StartError> {
    let found = peer.user_topics()?.into_iter().map(|listed| {
        Ok(Found {
            row: user::row(&listed.name, &listed.form)?,
            form: listed.form,
            name: listed.name,
        })
    });
    found.collect()
}

/// The one with this whole name.
///
/// # Errors
/// One line when it does not exist now.
pub(super) fn find(peer: &Peer, topic: &str) -> Result<Found, String> {
    let all = all(peer).map_err(|error| error.to_string())?;
    let found = all.into_iter().find(|found| found.row.name == topic);
    found.ok_or_else(|| {
        format!("there is no topic {topic} now: it exists while somebody has it open (see `zeronav topics`)")
    })
}

/// Reads one of them.
#[derive(Debug)]
pub(super) struct Follower {
    reader: UserReader,
    /// Role and identity of the last message.
    last: (u16, Id),
}

impl Follower {
    /// Copies the next message to `message`; false when there is no more.
    pub(super) fn copy_next(&mut self, message: &mut Message) -> bool {
        let last = self.last;
        let author = self.reader.take(|view| {
            message.copy(&view);
            (view.header.role, view.header.id())
        });
        let Some(author) = author else {
            return false;
        };
        let (role, id) = author;
        let is_next = role == last.0 && id.epoch() == last.1.epoch() && id > last.1;
        message.missed = if is_next { id.0 - last.1.next().0 } else { 0 };
        self.last = author;
        true
    }
}
