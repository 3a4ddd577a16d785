//! Segments whose maker died while it made them.
//!
//! The middleware gives the right to read a segment with the last step, and whoever opens it waits for that
//! step. Time cannot tell a dead maker from one that gets no processor: a living one has the file open all the
//! while, and one that waits opens it for a moment at a time.

use crate::domain::prefix_at;
use crate::memory::segments;
use std::collections::BTreeSet;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Looks of which one finds nobody who has an abandoned segment open, and the time between them.
const LOOKS: usize = 20;
const PAUSE: Duration = Duration::from_millis(5);

/// A file: its device and its inode.
type FileId = (u64, u64);

/// Removes the segments of the domain at `root` that were never finished and that no process of this user has
/// open. Takes a tenth of a second while some are being made, and no time otherwise.
pub fn remove(root: &Path) {
    let Some(prefix) = prefix_at(root) else {
        return;
    };
    for look in 0..LOOKS {
        // First the files: one that is made after this look is not judged by it.
        let unfinished = half_made(&prefix);
        if unfinished.is_empty() {
            return;
        }
        if look > 0 {
            std::thread::sleep(PAUSE);
        }
        let open = open_files();
        for (path, file) in unfinished {
            // It may have been finished, or another one be there by now.
            let is_same = std::fs::symlink_metadata(&path)
                .is_ok_and(|now| id(&now) == file && is_unfinished(&now));
            if is_same && !open.contains(&file) {
                let _ = std::fs::remove_file(path);
            }
        }
    }
}

fn half_made(prefix: &str) -> Vec<(PathBuf, FileId)> {
    segments(prefix)
        .filter(|(_, metadata)| is_unfinished(metadata))
        .map(|(path, metadata)| (path, id(&metadata)))
        .collect()
}

fn is_unfinished(metadata: &std::fs::Metadata) -> bool {
    metadata.mode() & 0o400 == 0
}

fn id(metadata: &std::fs::Metadata) -> FileId {
    (metadata.dev(), metadata.ino())
}

/// The files that processes of this user have open.
fn open_files() -> BTreeSet<FileId> {
    let entries = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries(Path::new("/proc"))
        .filter(|entry| {
            let name = entry.file_name();
            name.to_str()
                .is_some_and(|name| name.parse::<u32>().is_ok())
        })
        .flat_map(|process| entries(&process.path().join("fd")))
        .filter_map(|file| std::fs::metadata(file.path()).ok())
        .map(|metadata| id(&metadata))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Domain;
    use crate::memory::SHM;
    use std::fs::{File, OpenOptions};
    use std::os::unix::fs::OpenOptionsExt;

    #[test]
    fn unfinished_segments_go_once_their_maker_has_and_others_stay() {
        let domain = Domain::create().unwrap();
        let make = |name: &str, mode: u32| -> (PathBuf, File) {
            let path = Path::new(SHM).join(format!("{}{name}", domain.prefix()));
            let mut options = OpenOptions::new();
            options.write(true).create_new(true).mode(mode);
            let file = options.open(&path).unwrap();
            (path, file)
        };
        let (abandoned, file) = make("a.connection", 0o200);
        drop(file);
        let (whole, file) = make("b.connection", 0o600);
        drop(file);
        let (being_made, maker) = make("c.connection", 0o200);
        remove(domain.root());
        assert!(!abandoned.exists());
        assert!(whole.exists());
        assert!(being_made.exists(), "its maker lives");
        drop(maker);
        remove(domain.root());
        assert!(!being_made.exists());
        assert!(domain.close().unwrap());
        assert!(!whole.exists());
    }
}
