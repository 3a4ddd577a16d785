//! Fills a file system on purpose, and gives everything back when it is dropped, or when this process
//! dies.

use rustix::fs::{FallocateFlags, fallocate, fstatfs};
use rustix::io::Errno;
use std::fs::File;
use std::path::Path;
use zeronav_casts::Cast;

/// The largest piece that is asked for at a time, and the smallest. [bytes]
const PIECE_BYTES: [u64; 2] = [1 << 34, 4096];

/// `f_type` of a file system in memory.
const TMPFS_MAGIC: u64 = 0x0102_1994;

/// Share of the available memory that may be filled: the others have to live.
const MEMORY_SHARE: f64 = 0.5;

/// A file without a name that holds everything that was free.
#[derive(Debug)]
pub(super) struct Ballast {
    _file: File,
    /// Its size. [bytes]
    pub(super) bytes: u64,
}

impl Ballast {
    /// Fills the file system of `folder`.
    ///
    /// # Errors
    /// Why it cannot be filled, in one line; it is as it was then.
    pub(super) fn fill(folder: &Path) -> Result<Self, String> {
        let at = |error: &dyn core::fmt::Display| format!("{}: {error}", folder.display());
        let file = tempfile::tempfile_in(folder).map_err(|error| at(&error))?;
        spare_memory(&file, folder)?;
        let (mut bytes, mut piece) = (0, PIECE_BYTES[0]);
        while piece >= PIECE_BYTES[1] {
            match fallocate(&file, FallocateFlags::empty(), bytes, piece) {
                Ok(()) => bytes += piece,
                Err(Errno::NOSPC | Errno::FBIG) => piece /= 2,
                Err(Errno::INTR) => {}
                Err(error) => return Err(at(&error)),
            }
        }
        Ok(Self { _file: file, bytes })
    }
}

/// Rejects a file system in memory that could take most of it.
fn spare_memory(file: &File, folder: &Path) -> Result<(), String> {
    let stat = fstatfs(file).map_err(|error| format!("{}: {error}", folder.display()))?;
    let is_memory = u64::try_from(stat.f_type).is_ok_and(|kind| kind == TMPFS_MAGIC);
    let free = stat
        .f_bfree
        .saturating_mul(u64::try_from(stat.f_bsize).unwrap_or(0));
    let available = available_memory().unwrap_or(0);
    let is_too_much = free.to_f64() > MEMORY_SHARE * available.to_f64();
    if is_memory && is_too_much {
        return Err(format!(
            "{}: filling it would take {} MB of the {} MB of memory that are available; give the stack a \
             smaller one of its own (README of launch)",
            folder.display(),
            free / 1_000_000,
            available / 1_000_000
        ));
    }
    Ok(())
}

/// Memory that programs can still get. [bytes]
fn available_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}
