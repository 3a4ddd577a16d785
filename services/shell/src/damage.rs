//! Shared memory that a process of a stack has cut off or overwritten, as far as it can be seen from
//! outside, and whose it is; and what this process read last, when reading it was its end.

use crate::domain::{middleware_version, prefix_at};
use crate::folder::own_file;
use crate::memory::segments;
use rustix::fs::{CWD, OFlags};
use std::io::Read;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use zeronav_msgs::topics::TopicRow;

/// Numbers of topics that are told apart by [`read_last`].
const TOPICS_MAX: usize = 64;

/// The topics that this process reads, by number.
static READ: [OnceLock<&'static TopicRow>; TOPICS_MAX] = [const { OnceLock::new() }; TOPICS_MAX];

/// Number of the topic that was read last.
static LAST: AtomicUsize = AtomicUsize::new(usize::MAX);

/// True while the middleware looks for a message.
static IS_READING: AtomicBool = AtomicBool::new(false);

/// This process reads the topic from now on.
pub(crate) fn will_read(row: &'static TopicRow) {
    if let Some(place) = READ.get(row.number) {
        let _ = place.set(row);
    }
}

/// Reads a message of the topic with this number.
pub(crate) fn reading<R>(number: usize, read: impl FnOnce() -> R) -> R {
    LAST.store(number, Ordering::Relaxed);
    IS_READING.store(true, Ordering::Relaxed);
    let read = read();
    IS_READING.store(false, Ordering::Relaxed);
    read
}

/// True while some thread of this process looks for a message: the middleware aborts when what it finds
/// there cannot be. For signal handlers, too.
#[must_use]
pub fn is_reading() -> bool {
    IS_READING.load(Ordering::Relaxed)
}

/// The topic whose messages this process read last, in whichever thread. For signal handlers, too.
#[must_use]
pub fn read_last() -> Option<&'static TopicRow> {
    let place = READ.get(LAST.load(Ordering::Relaxed))?;
    place.get().copied()
}

/// A segment of a domain that somebody has cut off or overwritten.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damaged {
    /// Its file name in /dev/shm.
    pub name: String,
    /// The processes whose numbers are in its name: the one that made it, or both ends of a connection.
    pub pids: Vec<u32>,
}

/// The segments of the domain at `root` that do not begin as the middleware's do, or end before that.
#[must_use]
pub fn damaged(root: &Path) -> Vec<Damaged> {
    let Some(prefix) = prefix_at(root) else {
        return Vec::new();
    };
    let mut damaged: Vec<Damaged> = segments(&prefix)
        // One that is being made cannot be read yet.
        .filter(|(_, file)| file.mode() & 0o400 != 0)
        .filter_map(|(path, _)| {
            let mut begin = [0; 8];
            let mut file = own_file(CWD, &path, OFlags::RDONLY).ok()?;
            let is_whole =
                file.read_exact(&mut begin).is_ok() && begin == middleware_version().to_ne_bytes();
            let name = path.file_name()?.to_str()?;
            (!is_whole).then(|| Damaged {
                name: name.to_owned(),
                pids: pids_in(&name[prefix.len()..]),
            })
        })
        .collect();
    damaged.sort_by(|one, other| one.name.cmp(&other.name));
    damaged
}

/// The middleware's numbers of ports and services hold the id of the process that made them.
fn pids_in(name: &str) -> Vec<u32> {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let numbers = stem.split('_').filter_map(|part| part.parse::<u128>().ok());
    // Seconds, nanoseconds, process id, counter, from the lowest 32 bits up.
    let mut pids: Vec<u32> = numbers
        .filter_map(|number| u32::try_from((number >> 64) & u128::from(u32::MAX)).ok())
        .filter(|pid| *pid != 0)
        .collect();
    pids.dedup();
    pids
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Domain;
    use crate::memory::SHM;
    use zeronav_msgs::topics::{MapUpdate, Topic};

    #[test]
    fn what_was_read_last_is_named_by_its_topic() {
        // Other tests of this process may read other topics meanwhile.
        will_read(MapUpdate::ROW);
        let named = || {
            reading(MapUpdate::ROW.number, || {
                is_reading() && read_last().is_some_and(|row| row.name == MapUpdate::ROW.name)
            })
        };
        assert!((0..1000).any(|_| named()));
        assert!(MapUpdate::ROW.number < TOPICS_MAX);
    }

    #[test]
    fn segments_that_are_cut_off_or_overwritten_are_found_with_their_makers() {
        let domain = Domain::create().unwrap();
        assert_eq!(damaged(domain.root()), []);
        let make = |name: &str, bytes: &[u8]| {
            let path = Path::new(SHM).join(format!("{}{name}", domain.prefix()));
            std::fs::write(path, bytes).unwrap();
        };
        let number = |pid: u128, counter: u128| (counter << 96) + (pid << 64) + 77;
        let version = middleware_version().to_ne_bytes();
        make(&format!("ab12_{}.data", number(41, 1)), &version);
        make(&format!("ab12_{}.data", number(42, 2)), &version[..4]);
        let ends = format!("ab12_{}_{}.connection", number(43, 1), number(44, 9));
        make(&ends, &[b'x'; 64]);
        let mut found = damaged(domain.root());
        found.sort_by_key(|segment| segment.pids.clone());
        let pids: Vec<&[u32]> = found.iter().map(|it| it.pids.as_slice()).collect();
        assert_eq!(pids, [&[42][..], &[43, 44]]);
        assert_eq!(found[1].name, format!("{}{ends}", domain.prefix()));
        assert!(domain.close().unwrap());
    }
}
