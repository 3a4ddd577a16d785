//! The seat of a role: one process at a time holds it.
//!
//! A seat is the file `ROOT/seat.ROLE`, locked exclusively for as long as it is taken; it names its
//! owner's process id. The kernel lets go of the lock when the last process that holds the open file
//! ends. Launch holds the seats that it fills and gives the open file to the service that it starts,
//! as standard input: so the seat stays taken between a death and the successor, and the
//! holder of the file needs no code for it. A seat that launch leaves to others (`--external`) is taken by the
//! first process that comes. A process that comes second ends with the owner's process id, unless it
//! is started as a shadow: that one has an epoch which is never obeyed.

use crate::domain::Domain;
use crate::error::StartError;
use crate::folder::Folder;
use rustix::fs::{FlockOperation, OFlags, flock};
use rustix::io::Errno;
use std::fs::File;
use std::os::fd::AsFd;
use std::os::unix::fs::{FileExt, MetadataExt};
use std::process::Stdio;
use std::time::{Duration, Instant};
use zeronav_msgs::header::SHADOW_EPOCH_MIN;
use zeronav_msgs::role::Role;

/// For how long a taken seat is tried again: others look at the lock by taking it for a moment.
const TAKE_LIMIT: Duration = Duration::from_millis(200);

/// Time between two tries.
const TAKE_PAUSE: Duration = Duration::from_millis(5);

/// Digits of a process id, and one line end.
const OWNER_BYTES_MAX: usize = 16;

/// A taken seat. It is free again when this and every descriptor given to a child are closed.
#[derive(Debug)]
pub struct SeatLock {
    file: File,
    from_launch: bool,
}

impl SeatLock {
    /// Takes the seat of `role` in `domain`: the one that launch handed over, or a free one.
    ///
    /// # Errors
    /// [`StartError::Usage`] with the owner's process id when the seat is taken.
    pub fn take(domain: &Domain, role: Role) -> Result<Self, StartError> {
        match Self::handed_over(domain, role) {
            Some(seat) => Ok(seat),
            None => Self::take_free(domain, role),
        }
    }

    /// The seat that launch handed over as standard input, if it did.
    ///
    /// Any file may be there: it counts only when it is the seat's own file and holds its lock. A
    /// descriptor of another open file cannot get the lock while another process has it.
    #[must_use]
    pub fn handed_over(domain: &Domain, role: Role) -> Option<Self> {
        let given = rustix::fs::fstat(std::io::stdin()).ok()?;
        let seat = domain.folder().file(&name(role), OFlags::RDONLY).ok()?;
        let seat = seat.metadata().ok()?;
        if (given.st_dev, given.st_ino) != (seat.dev(), seat.ino()) {
            return None;
        }
        let file = File::from(std::io::stdin().as_fd().try_clone_to_owned().ok()?);
        flock(&file, FlockOperation::NonBlockingLockExclusive).ok()?;
        let seat = Self {
            file,
            from_launch: true,
        };
        seat.name_owner(std::process::id()).ok()?;
        Some(seat)
    }

    /// Takes a free seat for this process.
    ///
    /// # Errors
    /// As [`Self::take`].
    pub fn take_free(domain: &Domain, role: Role) -> Result<Self, StartError> {
        let name = name(role);
        let failed = |error| StartError::system(format!("taking {name}"), error);
        let file = domain
            .folder()
            .file(&name, OFlags::CREATE | OFlags::RDWR)
            .map_err(failed)?;
        let started = Instant::now();
        loop {
            match flock(&file, FlockOperation::NonBlockingLockExclusive) {
                Ok(()) => break,
                Err(Errno::WOULDBLOCK) if started.elapsed() < TAKE_LIMIT => {
                    std::thread::sleep(TAKE_PAUSE);
                }
                Err(Errno::WOULDBLOCK) => {
                    let owner = owner(&file).map_or_else(
                        || "another process".to_owned(),
                        |pid| format!("process {pid}"),
                    );
                    return Err(StartError::Usage(format!(
                        "the seat of {role} is taken by {owner}; \
                         with --shadow a process runs beside it and is never obeyed"
                    )));
                }
                Err(error) => return Err(failed(error.into())),
            }
        }
        let seat = Self {
            file,
            from_launch: false,
        };
        seat.name_owner(std::process::id()).map_err(failed)?;
        Ok(seat)
    }

    /// True when launch handed it over, so that the process is the one that launch expects.
    #[must_use]
    pub fn is_from_launch(&self) -> bool {
        self.from_launch
    }

    /// Writes the owner's process id into the seat.
    ///
    /// # Errors
    /// What the file system says.
    pub fn name_owner(&self, pid: u32) -> std::io::Result<()> {
        let text = format!("{pid}\n");
        self.file.write_all_at(text.as_bytes(), 0)?;
        self.file.set_len(text.len() as u64)
    }

    /// The seat as the standard input of a child, which holds it from then on, too.
    ///
    /// # Errors
    /// What the system says when there is no descriptor left.
    pub fn for_child(&self) -> std::io::Result<Stdio> {
        Ok(self.file.try_clone()?.into())
    }
}

/// True while a process sits in the seat of `role`.
#[must_use]
pub fn is_taken(folder: &Folder, role: Role) -> bool {
    // A seat that was never taken is not made by looking.
    let file = folder.file(&name(role), OFlags::RDONLY);
    file.is_ok_and(|file| {
        flock(&file, FlockOperation::NonBlockingLockShared) == Err(Errno::WOULDBLOCK)
    })
}

/// The epoch of a shadow: no epoch that launch gives out is as high, and no two shadows share one.
#[must_use]
pub fn shadow_epoch() -> u32 {
    SHADOW_EPOCH_MIN | (std::process::id() & (SHADOW_EPOCH_MIN - 1))
}

/// Name of the file in the domain's folder.
fn name(role: Role) -> String {
    format!("seat.{role}")
}

fn owner(file: &File) -> Option<u32> {
    let mut bytes = [0; OWNER_BYTES_MAX];
    let n = file.read_at(&mut bytes, 0).ok()?;
    core::str::from_utf8(&bytes[..n]).ok()?.trim().parse().ok()
}
