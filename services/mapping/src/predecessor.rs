//! What the process that is in the seat has learnt, for one that comes to take its place.

use zeronav_mapping::Mapping;
use zeronav_msgs::role::Role;
use zeronav_shell::clock::now_ns;
use zeronav_shell::{MapInput, Shell, StartError};

/// How long the map of the process in the seat is waited for; in lockstep launch decides how long. [ns]
const WAIT_NS: u64 = 2_000_000_000;

/// Between two looks. [ns]
const PAUSE_NS: u64 = 5_000_000;

/// Reads the map of the process in the seat.
pub(crate) struct Predecessor {
    map: MapInput,
    until_ns: u64,
}

impl Predecessor {
    /// Opens the map when launch has announced this process as a newcomer.
    ///
    /// # Errors
    /// As [`MapInput::open`].
    pub(crate) fn open(shell: &Shell) -> Result<Option<Self>, StartError> {
        let seat = shell.roster().seat(Role::Mapping);
        let is_newcomer = seat.is_some_and(|seat| seat.other == shell.peer().epoch());
        if !is_newcomer {
            return Ok(None);
        }
        Ok(Some(Self {
            map: MapInput::open(shell.peer())?,
            until_ns: now_ns() + WAIT_NS,
        }))
    }

    /// Hands the map over as soon as it is whole, and gives its tick; `None` while it is still to come.
    ///
    /// # Errors
    /// When no map comes, or one of another grid: what was learnt would be lost.
    pub(crate) fn hand_over(
        &mut self,
        shell: &mut Shell,
        mapping: &mut Mapping,
    ) -> Result<Option<u64>, StartError> {
        self.map.poll(shell);
        let what = "taking over the map of the process in the seat";
        if self.map.is_lost() || self.map.view().is_none() {
            shell.wake_by(now_ns() + PAUSE_NS);
            if shell.roster().lockstep() || now_ns() < self.until_ns {
                return Ok(None);
            }
            let why = format!("none came within {} s", WAIT_NS / 1_000_000_000);
            return Err(StartError::system(what, why));
        }
        let info = *self.map.info();
        let fits = (self.map.view()).is_some_and(|map| mapping.resume(&info, &map));
        if !fits {
            let why = "its grid is another one; a stack is started anew for another grid";
            return Err(StartError::system(what, why));
        }
        tracing::info!("goes on with the map of the process in the seat");
        Ok(Some(self.map.tick()))
    }
}
