//! Keeps the logs of children from filling the disk.
//!
//! A child writes to a file, so nothing that happens to launch, to this process or to a reader can hold
//! it up, and no signal can come of it. The warden, which goes on when launch is stopped or dead, looks
//! at the files: of one that has grown beyond [`BYTES_MAX`] it keeps the beginning and the end. Children
//! open their logs for appending, so they go on behind what is kept.

use rustix::fs::{fstat, ftruncate};
use std::fs::File;
use std::io::Write;
use std::os::unix::fs::FileExt;
use std::time::Duration;

/// Most bytes of a log: twice what the services of this project write at most.
pub(super) const BYTES_MAX: u64 = 16 << 20;

/// What is kept of the beginning and of the end. [bytes]
const KEPT_BYTES: u64 = 2 << 20;

/// Between two looks: at 1 GB/s a log grows by 50 MB in this time.
pub(super) const PAUSE: Duration = Duration::from_millis(50);

/// A log that is looked at.
#[derive(Debug)]
struct Log {
    file: File,
    id: (u64, u64),
    /// What was dropped so far.
    dropped_bytes: u64,
}

/// The logs of all children, each once, however many write to it.
#[derive(Debug, Default)]
pub(super) struct Logs(Vec<Log>);

impl Logs {
    /// Looks at this one from now on.
    pub(super) fn add(&mut self, file: File) {
        let Ok(stat) = fstat(&file) else { return };
        let id = (stat.st_dev, stat.st_ino);
        // What was removed is nobody's any more.
        self.0
            .retain(|log| fstat(&log.file).is_ok_and(|stat| stat.st_nlink > 0));
        if !self.0.iter().any(|log| log.id == id) {
            self.0.push(Log {
                file,
                id,
                dropped_bytes: 0,
            });
        }
    }

    /// True when there is something to be looked at.
    pub(super) fn any(&self) -> bool {
        !self.0.is_empty()
    }

    /// Cuts what has become too long. A log that cannot be cut stays as it is.
    pub(super) fn cut(&mut self) {
        for log in &mut self.0 {
            let _ = log.cut(BYTES_MAX, KEPT_BYTES);
        }
    }
}

impl Log {
    /// Keeps beginning and end of a log beyond `most` bytes.
    fn cut(&mut self, most: u64, kept: u64) -> std::io::Result<()> {
        let length = self.file.metadata()?.len();
        if length <= most {
            return Ok(());
        }
        let head = self.line_end_before(kept)?;
        let mut tail = vec![0; usize::try_from(kept).unwrap_or(0)];
        let n = self.file.read_at(&mut tail, length - kept)?;
        tail.truncate(n);
        let whole_line = tail.iter().position(|byte| *byte == b'\n');
        let tail = &tail[whole_line.map_or(0, |at| at + 1)..];
        // What comes in between is lost without being counted.
        let dropped = self.file.metadata()?.len() - head - tail.len() as u64;
        self.dropped_bytes += dropped;
        ftruncate(&self.file, head)?;
        let line = format!(
            "zeronav: the log was too long, {} bytes were dropped here\n",
            self.dropped_bytes
        );
        self.file.write_all(&[line.as_bytes(), tail].concat())
    }

    /// Where the last line ends that lies in the first `bytes`.
    fn line_end_before(&self, bytes: u64) -> std::io::Result<u64> {
        const LOOKED_AT: u64 = 4096;
        let from = bytes.saturating_sub(LOOKED_AT);
        let mut end = vec![0; usize::try_from(bytes - from).unwrap_or(0)];
        let n = self.file.read_at(&mut end, from)?;
        let line = end[..n].iter().rposition(|byte| *byte == b'\n');
        Ok(line.map_or(bytes, |at| from + at as u64 + 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::{Path, PathBuf};

    #[test]
    fn begin_and_end_of_a_long_log_are_kept_and_its_writer_goes_on() {
        let place = tempfile::tempdir().expect("a folder");
        let path = place.path().join("it.log");
        let open = || {
            File::options()
                .create(true)
                .append(true)
                .read(true)
                .open(&path)
        };
        let mut writer = open().expect("opened");
        let mut logs = Logs::default();
        logs.add(open().expect("opened"));
        logs.add(open().expect("opened again"));
        assert_eq!(logs.0.len(), 1);
        let log = &mut logs.0[0];
        for round in 0..5 {
            for line in 0..1000 {
                writeln!(writer, "round {round} line {line:03}").expect("written");
            }
            log.cut(4000, 1000).expect("cut");
            let text = std::fs::read_to_string(&path).expect("read");
            assert!(text.len() < 2200, "{}", text.len());
            assert!(text.starts_with("round 0 line 000\n"));
            assert!(
                text.ends_with(&format!("round {round} line 999\n")),
                "{text}"
            );
            assert_eq!(text.matches("bytes were dropped here").count(), 1);
            let whole = text.lines().all(|line| line.len() == 16 || line.len() > 40);
            assert!(whole, "{text}");
        }
        assert!(log.dropped_bytes > 5 * 17_000 - 4_000);
    }
    /// An empty log, and its path.
    fn log(place: &Path) -> (File, PathBuf) {
        let path = place.join("it.log");
        let mut options = File::options();
        let file = options.create(true).append(true).read(true).open(&path);
        (file.expect("opened"), path)
    }

    #[test]
    fn a_log_is_cut_when_it_is_a_byte_too_long() {
        let place = tempfile::tempdir().expect("a folder");
        let (file, path) = log(place.path());
        let length = || std::fs::metadata(&path).expect("it").len();
        let mut logs = Logs::default();
        assert!(!logs.any());
        logs.add(file.try_clone().expect("a handle"));
        assert!(logs.any());
        file.set_len(BYTES_MAX).expect("so long");
        logs.cut();
        assert_eq!(length(), BYTES_MAX);
        file.set_len(BYTES_MAX + 1).expect("longer");
        logs.cut();
        // Beginning and end without a line in them, and the line about what is missing.
        let line = "zeronav: the log was too long, 12582913 bytes were dropped here\n";
        assert_eq!(length(), 2 * KEPT_BYTES + line.len() as u64);
        assert_eq!(logs.0[0].dropped_bytes, BYTES_MAX + 1 - 2 * KEPT_BYTES);
    }

    #[test]
    fn whole_lines_are_kept_of_the_beginning_and_of_the_end() {
        let place = tempfile::tempdir().expect("a folder");
        let (mut file, path) = log(place.path());
        // Ten bytes each: the third ends at 30, the last three begin at 70.
        for line in 0..10 {
            writeln!(file, "line    {line}").expect("written");
        }
        let mut logs = Logs::default();
        logs.add(file);
        logs.0[0].cut(99, 35).expect("cut");
        let text = std::fs::read_to_string(&path).expect("read");
        let lines: Vec<&str> = text.lines().collect();
        let dropped = "zeronav: the log was too long, 40 bytes were dropped here";
        let kept = ["line    0", "line    1", "line    2", dropped];
        assert_eq!(lines[..4], kept);
        assert_eq!(lines[4..], ["line    7", "line    8", "line    9"]);
        // Counted on, and neither a line of its own nor one that is exactly at the edge is lost.
        logs.0[0].cut(20, 10).expect("cut");
        let text = std::fs::read_to_string(&path).expect("read");
        assert!(text.starts_with("line    0\nzeronav: "), "{text}");
        let left = 30 + dropped.len() as u64 + 1 + 30 - 10;
        assert!(
            text.contains(&format!("long, {} bytes", 40 + left)),
            "{text}"
        );
    }

    #[test]
    fn a_log_that_was_removed_is_forgotten() {
        let place = tempfile::tempdir().expect("a folder");
        let (file, path) = log(place.path());
        let mut logs = Logs::default();
        logs.add(file);
        std::fs::remove_file(&path).expect("removed");
        let (other, _) = log(place.path());
        logs.add(other);
        assert_eq!(logs.0.len(), 1);
        assert_eq!(fstat(&logs.0[0].file).expect("it").st_nlink, 1);
    }
}
