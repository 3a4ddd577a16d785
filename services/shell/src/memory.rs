//! Shared memory is known before it is needed: checked before the first port, then reserved.
//!
//! The middleware maps its segments without reserving them, so a full /dev/shm would kill the
//! writer with SIGBUS in the middle of a drive instead of failing at the start.

use crate::error::StartError;
use crate::folder::own_file;
use crate::shm;
pub use crate::shm::SHM;
use rustix::fs::{CWD, FallocateFlags, OFlags, fallocate};
use rustix::io::Errno;
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;

/// Room that is left for connections, which cannot be reserved. [bytes]
pub(crate) const HEADROOM_BYTES: u64 = 1 << 20;

/// Inodes of /dev/shm that a stack takes: a shipped one has 440 files there.
const STACK_INODES: u64 = 512;

/// The caller's own files in /dev/shm whose names begin with `prefix`. Other users may have made
/// files with such names.
pub(crate) fn segments(prefix: &str) -> impl Iterator<Item = (PathBuf, std::fs::Metadata)> {
    let entries = std::fs::read_dir(SHM).into_iter().flatten().flatten();
    let uid = rustix::process::geteuid().as_raw();
    entries
        .filter(move |entry| {
            let name = entry.file_name();
            name.to_str().is_some_and(|name| name.starts_with(prefix))
        })
        .filter_map(move |entry| {
            // Of the entry itself, whatever it links to.
            let metadata = entry.metadata().ok()?;
            (metadata.is_file() && metadata.uid() == uid).then(|| (entry.path(), metadata))
        })
}

/// Bytes free in /dev/shm.
///
/// # Errors
/// [`StartError::System`] when there is no /dev/shm.
pub(crate) fn free_bytes() -> Result<u64, StartError> {
    shm::free_bytes().map_err(|error| StartError::system(SHM, error))
}

/// True when /dev/shm has less room than connections need.
#[must_use]
pub fn is_full() -> bool {
    free_bytes().is_ok_and(|free| free < HEADROOM_BYTES)
}

/// Accepts `needed` more bytes and the headroom.
///
/// # Errors
/// [`StartError::Memory`] when they do not fit.
pub fn check(needed: u64) -> Result<(), StartError> {
    let free = free_bytes()?;
    let needed = needed + HEADROOM_BYTES;
    if free < needed {
        Err(StartError::Memory { needed, free })
    } else {
        Ok(())
    }
}

/// Accepts one more stack.
///
/// # Errors
/// [`StartError::Inodes`] when there are too few for its files.
pub fn check_inodes() -> Result<(), StartError> {
    match shm::free_inodes() {
        Some(free) if free < STACK_INODES => Err(StartError::Inodes {
            needed: STACK_INODES,
            free,
        }),
        _ => Ok(()),
    }
}

/// Reserves the data segment of the writer with the middleware's number `publisher`.
///
/// # Errors
/// [`StartError::Memory`] when the memory is not there, [`StartError::System`] when the segment is
/// not found.
pub fn reserve(prefix: &str, publisher: u128, topic: &str) -> Result<u64, StartError> {
    let tail = format!("_{publisher}.data");
    let failed = |error: &dyn core::fmt::Display| {
        StartError::system(format!("reserving shared memory of {topic}"), error)
    };
    let mut reserved = 0;
    for (path, _) in segments(prefix) {
        let name = path.file_name().and_then(|name| name.to_str());
        if name.is_some_and(|name| name.ends_with(&tail)) {
            let file = own_file(CWD, &path, OFlags::RDWR).map_err(|error| failed(&error))?;
            let bytes = file.metadata().map_err(|error| failed(&error))?.len();
            match fallocate(&file, FallocateFlags::empty(), 0, bytes) {
                Ok(()) => {}
                // Another process took what was free since it was checked.
                Err(Errno::NOSPC) => {
                    let free = free_bytes()?;
                    return Err(StartError::Memory {
                        needed: bytes,
                        free,
                    });
                }
                Err(error) => return Err(failed(&error)),
            }
            reserved += bytes;
        }
    }
    if reserved == 0 {
        Err(failed(&"segment not found"))
    } else {
        Ok(reserved)
    }
}
