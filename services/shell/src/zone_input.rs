//! The zones as a service takes them in: the newest list that holds, and whether one is missing.

use crate::error::StartError;
use crate::input::Input;
use crate::peer::Peer;
use crate::reader::Latest;
use crate::roster::Roster;
use crate::shell::Shell;
use zeronav_msgs::ZoneSet;
use zeronav_msgs::health::REASON_ZONES;
use zeronav_msgs::topics::TaskZones;

/// Reads `task/zones`.
///
/// A list stays until a later one holds, so that a message that is lost or rejected opens no zone. A
/// process that has no list yet takes the first one at once, also when it holds from a later tick.
#[derive(Debug)]
pub struct ZoneInput {
    reader: Latest<TaskZones>,
    current: ZoneSet,
    /// The list that holds from a later tick on.
    next: Option<(u64, ZoneSet)>,
}

impl ZoneInput {
    /// Opens the topic.
    ///
    /// # Errors
    /// As [`Peer::latest`].
    pub fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            reader: peer.latest()?,
            current: ZoneSet::default(),
            next: None,
        })
    }

    /// Takes in what has come.
    pub fn poll(&mut self, roster: &Roster) {
        if !self.reader.poll(roster) {
            return;
        }
        let newest = self.newest();
        if let Some(view) = self.reader.get().filter(|view| view.meta.revision > newest) {
            let set = ZoneSet::of(view.meta, view.items);
            self.next = Some((view.meta.from_tick, set));
        }
        // A copy is held, and the message is large.
        self.reader.release();
    }

    /// Revision of the newest list that has come; 0 = none.
    fn newest(&self) -> u64 {
        let next = self.next.as_ref().map_or(0, |(_, set)| set.revision());
        next.max(self.current.revision())
    }

    /// True while `run/control` names a list that has not come.
    #[must_use]
    pub fn is_missing(&self, roster: &Roster) -> bool {
        roster.control.zones > self.newest()
    }

    /// Reports in the heartbeat whether the list that holds has not come.
    pub fn report(&self, shell: &mut Shell) {
        let is_missing = self.is_missing(shell.roster());
        shell.reason(REASON_ZONES, is_missing);
    }

    /// Lets the list hold that does at `tick`; true when it is another one than before.
    pub fn advance(&mut self, tick: u64) -> bool {
        let is_first = self.current.revision() == 0;
        let next = self
            .next
            .take_if(|(from_tick, _)| is_first || *from_tick <= tick);
        let Some((_, set)) = next else {
            return false;
        };
        self.current = set;
        true
    }

    /// The zones that hold.
    #[must_use]
    pub fn set(&self) -> &ZoneSet {
        &self.current
    }
}

impl Input for ZoneInput {
    fn refused(&self) -> u64 {
        self.reader.refused()
    }
}
