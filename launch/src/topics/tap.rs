//! A guest of a run that only reads: it rings no doorbell and keeps no message, so that nothing in
//! the run depends on it. It polls.

use super::message::Message;
use super::user::find;
use crate::running;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use zeronav_console::terminal;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{Topic, TopicRow, TopicVisitor, visit_topics};
use zeronav_msgs::user;
use zeronav_shell::roster_reader::RosterReader;
use zeronav_shell::{Domain, Peer, Roster, StartError};
use zeronav_supervise::cleaner::Cleaner;

/// Time between two looks. A queue holds at least 32 messages, which is enough for lockstep, too.
pub(crate) const PAUSE: Duration = Duration::from_millis(2);

/// Guests are not restarted.
const EPOCH: u32 = 1;

/// A member of a run that reads.
#[derive(Debug)]
pub(crate) struct Tap {
    roster: RosterReader,
    peer: Peer,
}

/// Sees the messages of a topic.
pub(super) trait Watch {
    /// A message has come; false when that is enough.
    fn see(&mut self, message: &Message) -> bool;
    /// Time has passed.
    fn look(&mut self) {}
}

/// Why a tap ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// As many messages as were asked for have come, or the output is read no longer.
    Enough,
    /// A signal.
    Interrupted,
    /// The run is over.
    RunOver,
}

impl Tap {
    /// Joins the run with this root folder, or the only one.
    ///
    /// # Errors
    /// One line when there is none, or when it has no place left.
    pub(crate) fn join(root: Option<&Path>) -> Result<Self, String> {
        let run = running::find(root)?;
        let join = || {
            let peer = Peer::join(Domain::join(run.root())?, Role::Tap, EPOCH)?;
            let mut roster = RosterReader::open(&peer)?;
            roster.await_known()?;
            Ok(Self { roster, peer })
        };
        or_after_cleaning(run.root(), join)
    }

    /// The member.
    pub(crate) fn peer(&self) -> &Peer {
        &self.peer
    }

    /// Opens ports of the member.
    ///
    /// # Errors
    /// One line when there is no place left, or another problem.
    pub(crate) fn open<R>(
        &self,
        mut open: impl FnMut(&Peer) -> Result<R, StartError>,
    ) -> Result<R, String> {
        or_after_cleaning(self.peer.domain().root(), || open(&self.peer))
    }

    /// Which processes are obeyed now.
    pub(crate) fn poll(&mut self) -> &Roster {
        self.roster.poll();
        self.roster.roster()
    }

    /// Shows the messages of the topic `name` to `watch` until one of both ends, or the run.
    ///
    /// # Errors
    /// One line when the topic cannot be read.
    pub(super) fn listen(
        mut self,
        name: &str,
        watch: &mut impl Watch,
        interrupted: &Arc<AtomicBool>,
    ) -> Result<End, String> {
        let mut listener = Listener {
            name,
            tap: &mut self,
            watch,
            interrupted,
            end: None,
        };
        if user::name_in(name).is_some() {
            listener.follow_user()?;
        } else {
            visit_topics(&mut listener)?;
        }
        let end = listener.end.ok_or_else(|| format!("no topic {name}"))?;
        self.leave();
        Ok(end)
    }

    /// Leaves the run; the last one that does removes what is left of it.
    pub(crate) fn leave(self) {
        drop(self.roster);
        // Of a run that is over, launch removes what this cannot.
        let _ = self.peer.leave().close();
    }
}

/// What `open` opens. Guests that were killed hold places until these are cleaned: when there are
/// none left, that is done once.
fn or_after_cleaning<R>(
    root: &Path,
    mut open: impl FnMut() -> Result<R, StartError>,
) -> Result<R, String> {
    let first = open();
    let Err(StartError::Full { .. }) = first else {
        return first.map_err(|error| error.to_string());
    };
    let mut cleaner = Cleaner::new(root);
    let ticket = cleaner.ask();
    while !cleaner.is_done(ticket) {
        std::thread::sleep(PAUSE);
    }
    open().map_err(|error| error.to_string())
}

struct Listener<'a, W> {
    name: &'a str,
    tap: &'a mut Tap,
    watch: &'a mut W,
    interrupted: &'a AtomicBool,
    end: Option<End>,
}

impl<W: Watch> TopicVisitor for Listener<'_, W> {
    type Error = String;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), String> {
        if row.name != self.name {
            return Ok(());
        }
        let mut stream = self.tap.open(|peer| peer.stream_on::<T>(row))?;
        self.follow(Message::of_topic::<T>(row), |roster, message| {
            let before = stream.missed();
            let came = stream.take(roster, |view| message.copy(&view)).is_some();
            message.missed = stream.missed() - before;
            came
        });
        Ok(())
    }

    fn records(&mut self, row: &'static TopicRow) -> Result<(), String> {
        if row.name != self.name {
            return Ok(());
        }
        let mut reader = self.tap.open(Peer::span_reader)?;
        self.follow(Message::of_records(), |_, message| {
            reader
                .take()
                .map(|span| message.copy_record(&span))
                .is_some()
        });
        Ok(())
    }
}

impl<W: Watch> Listener<'_, W> {
    /// Shows the messages of a user's own topic.
    fn follow_user(&mut self) -> Result<(), String> {
        let found = find(self.tap.peer(), self.name)?;
        let mut follower = self.tap.open(|peer| found.follow(peer))?;
        self.follow(found.message(), |_, message| follower.copy_next(message));
        Ok(())
    }

    /// Shows what `take` copies until the end.
    fn follow(
        &mut self,
        mut message: Message,
        mut take: impl FnMut(&Roster, &mut Message) -> bool,
    ) {
        let end = loop {
            // Before the last messages are read, so that they are seen.
            let is_over = self.tap.peer.domain().is_orphaned();
            self.tap.roster.poll();
            let mut enough = false;
            while !enough
                && !self.interrupted.load(Ordering::Relaxed)
                && take(self.tap.roster.roster(), &mut message)
            {
                enough = !self.watch.see(&message);
            }
            self.watch.look();
            if enough || !terminal::is_read() {
                break End::Enough;
            }
            if self.interrupted.load(Ordering::Relaxed) {
                break End::Interrupted;
            }
            if is_over {
                break End::RunOver;
            }
            std::thread::sleep(PAUSE);
        };
        self.end = Some(end);
    }
}
