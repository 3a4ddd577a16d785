//! What is kept of a file that can be written no longer.

use crate::ending::{RESERVE_BYTES, ending};
use crate::verdict::{VALID, WHY};
use rustix::fs::{FallocateFlags, fallocate};
use rustix::io::Errno;
use rustix::process::{Resource, getrlimit};
use std::fs::File;
use std::io::Error;
use std::os::fd::AsRawFd;
use std::os::unix::fs::FileExt;
use std::sync::atomic::{AtomicU64, Ordering};

/// The file besides its writer, and how much of it is whole.
#[derive(Debug)]
pub(crate) struct Kept {
    file: File,
    whole_bytes: AtomicU64,
}

impl Kept {
    pub(crate) fn new(file: &File) -> std::io::Result<Self> {
        Ok(Self {
            file: file.try_clone()?,
            whole_bytes: AtomicU64::new(0),
        })
    }

    /// What was written so far is whole: room for the end is kept free behind it.
    ///
    /// # Errors
    /// When there is not even that much room.
    pub(crate) fn is_whole(&self) -> std::io::Result<()> {
        let len = self.file.metadata()?.len();
        self.whole_bytes.store(len, Ordering::Relaxed);
        let most = getrlimit(Resource::Fsize).current;
        if most.is_some_and(|most| len.saturating_add(RESERVE_BYTES) > most) {
            return Err(Error::from_raw_os_error(Errno::FBIG.raw_os_error()));
        }
        match fallocate(&self.file, FallocateFlags::KEEP_SIZE, len, RESERVE_BYTES) {
            // A file system that cannot do so keeps no room free.
            Ok(()) | Err(Errno::OPNOTSUPP | Errno::NOSYS | Errno::INVAL) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Gives back what was kept free behind a file that is finished.
    pub(crate) fn finished(&self) {
        let len = self.file.metadata().map(|it| it.len());
        let _ = len.and_then(|len| self.file.set_len(len));
    }

    /// Cuts off what was not whole, and ends the file with a verdict that says why it ends.
    pub(crate) fn end(&self, why: &str) {
        let whole_bytes = whole_until(&self.file, self.whole_bytes.load(Ordering::Relaxed));
        let fields = [
            (VALID, "false".to_owned()),
            (WHY, format!("the file could be written no longer: {why}")),
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ];
        let fields = fields.map(|(key, value)| (key.to_owned(), value)).into();
        if self.file.set_len(whole_bytes).is_err() {
            return;
        }
        // Whatever comes of it: `zeronav bag recover` makes a file of what is whole.
        if self
            .file
            .write_all_at(&ending(&fields), whole_bytes)
            .is_err()
        {
            let _ = self.file.set_len(whole_bytes);
        }
        let _ = self.file.sync_data();
    }
}

/// Where the last record of `file` ends that is there as a whole, at `from` or behind: chunks go to the file between two
/// looks at it, too. [bytes]
fn whole_until(file: &File, from: u64) -> u64 {
    /// Opcode and length in front of each record. [bytes]
    const HEAD_BYTES: usize = 9;
    let mut at = from;
    // The recording itself may be open for writing alone.
    let path = format!("/proc/self/fd/{}", file.as_raw_fd());
    let Ok((file, len)) = File::open(path).and_then(|file| {
        let len = file.metadata()?.len();
        Ok((file, len))
    }) else {
        return at;
    };
    let mut head = [0; HEAD_BYTES];
    while file.read_exact_at(&mut head, at).is_ok() {
        let [_, length @ ..] = head;
        let next = (at + HEAD_BYTES as u64).checked_add(u64::from_le_bytes(length));
        match next.filter(|next| *next <= len) {
            Some(next) => at = next,
            None => break,
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn what_was_not_whole_goes_and_the_end_takes_its_place() {
        let mut file = tempfile::tempfile().expect("a file");
        let kept = Kept::new(&file).expect("it");
        file.write_all(b"whole").expect("written");
        kept.is_whole().expect("room");
        // What was written since, and is there as a whole.
        file.write_all(b"\x06\x03\0\0\0\0\0\0\0abc")
            .expect("written");
        file.write_all(b"\x06\x09\0\0\0\0\0\0\0half")
            .expect("written");
        kept.end("no space");
        let len = file.metadata().expect("it").len();
        let mut bytes = vec![0; usize::try_from(len).expect("short")];
        file.read_exact_at(&mut bytes, 0).expect("read");
        let begin = b"whole\x06\x03\0\0\0\0\0\0\0abc\x0c";
        assert!(bytes.starts_with(begin), "{bytes:?}");
        assert!(bytes.ends_with(mcap::MAGIC));
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains("no longer: no space"), "{text}");
    }
}
