//! `zeronav import`: the log of another robot as a recording that is played in open loop.
//!
//! Every format is read into a [`Log`], times are put in order (`clock.rs`), and that becomes ticks ([`recording`]). What
//! was missing and what was assumed is said by each step.

mod carmen;
mod clock;
pub mod log;
pub mod nav2;
pub mod recording;
mod ros;
mod sqlite;

pub use log::{Log, LogMap, Report, Topics};

use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use zeronav_files::read;

/// Most of a file that is read, unpacked. [bytes]
const BYTES_MAX: u64 = 4 << 30;

/// What MCAP and `SQLite` files and compressed ones begin with.
const SQLITE: &[u8] = b"SQLite format 3\0";
const GZIP: &[u8] = &[0x1f, 0x8b];

/// Why a log cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {why}", file.display())]
pub struct ImportError {
    /// Which file.
    pub file: PathBuf,
    /// What is wrong, and what to do.
    pub why: String,
}

/// Reads a log: a bag of ROS 2 (an MCAP or `SQLite` file, or a folder with some), or a CARMEN log, which may be compressed
/// by gzip.
///
/// # Errors
/// [`ImportError`].
pub fn log_in(path: &Path, topics: &Topics) -> Result<Log, ImportError> {
    let wrong = |why: String| ImportError {
        file: path.to_owned(),
        why,
    };
    if path.is_dir() {
        let mut bag = ros::Bag::new(topics);
        let mut n = 0;
        for file in files_in(path).map_err(|error| wrong(error.to_string()))? {
            let name = file.extension().and_then(|it| it.to_str());
            if matches!(name, Some("mcap" | "db3")) {
                n += 1;
                read_bag(&file, &mut bag)?;
            }
        }
        if n == 0 {
            return Err(wrong("no MCAP file and no .db3 file is in it".to_owned()));
        }
        return bag.into_log().map_err(wrong);
    }
    let start = start_of(path).map_err(|error| wrong(error.to_string()))?;
    if start.starts_with(mcap::MAGIC) || start.starts_with(SQLITE) {
        let mut bag = ros::Bag::new(topics);
        read_bag(path, &mut bag)?;
        return bag.into_log().map_err(wrong);
    }
    if *topics != Topics::default() {
        return Err(wrong(
            "no bag, so it has no topics: leave out --scan, --odometry and --map".to_owned(),
        ));
    }
    let input = read::open(path).map(BufReader::new);
    let input = input.map_err(|error| wrong(error.to_string()))?;
    let log = if start.starts_with(GZIP) {
        carmen::read(flate2::read::GzDecoder::new(input).take(BYTES_MAX))
    } else {
        carmen::read(input.take(BYTES_MAX))
    };
    log.map_err(wrong)
}

/// Reads a file of a bag.
fn read_bag(path: &Path, bag: &mut ros::Bag<'_>) -> Result<(), ImportError> {
    let wrong = |why: String| ImportError {
        file: path.to_owned(),
        why,
    };
    let start = start_of(path).map_err(|error| wrong(error.to_string()))?;
    if start.starts_with(SQLITE) {
        return sqlite::read(path, bag).map_err(wrong);
    }
    let file = read::open(path).map_err(|error| wrong(error.to_string()))?;
    bag.read_mcap(BufReader::new(file)).map_err(wrong)
}

/// The first bytes of a file.
fn start_of(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut start = Vec::new();
    read::open(path)?.take(32).read_to_end(&mut start)?;
    Ok(start)
}

/// The files of a folder, by name.
fn files_in(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        files.push(entry?.path());
    }
    files.sort();
    Ok(files)
}
