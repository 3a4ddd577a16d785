//! Several logs as one, by time, in bounded memory: a piece of each at a time.

use rustix::fs::{CWD, Mode, OFlags, openat};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{ErrorKind, Read, Result, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Longest line that is shown whole. [bytes]
const LINE_BYTES_MAX: usize = 16 * 1024;

/// Bytes that one look reads of a log.
const PIECE_BYTES: usize = 64 * 1024;

/// Logs of a folder at most; a run has six.
const LOGS_MAX: usize = 64;

/// Behind a line that is not shown whole.
const CUT: &[u8] = b" ... (cut)";

/// A line of a log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Line {
    /// Name of the log: a service, or `launch`.
    pub name: String,
    /// When it was written, as the log says; of a line without time, that of the line before.
    pub time: String,
    /// Its bytes without the end of the line.
    pub bytes: Vec<u8>,
}

/// The logs of a folder.
#[derive(Debug)]
pub(super) struct Merge {
    folder: PathBuf,
    /// Only this one.
    only: Option<String>,
    logs: BTreeMap<String, Log>,
}

/// One log as far as it was read.
#[derive(Debug)]
struct Log {
    file: File,
    /// Bytes that were read of it.
    at: u64,
    /// What was read last.
    rest: Vec<u8>,
    /// Bytes of `rest` that were taken as lines.
    taken: usize,
    /// Nothing more had been written at the last look.
    is_dry: bool,
    /// The line that began in `rest` is longer than is shown.
    is_cut: bool,
    /// Time of the last line.
    time: String,
    next: Option<(String, Vec<u8>)>,
}

impl Merge {
    /// The logs in `folder`, or only that of one service.
    pub(super) fn new(folder: &Path, only: Option<&str>) -> Self {
        Self {
            folder: folder.to_owned(),
            only: only.map(str::to_owned),
            logs: BTreeMap::new(),
        }
    }

    /// Finds logs that were made since the last look, and lets all be read again.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub(super) fn look(&mut self) -> Result<()> {
        for log in self.logs.values_mut() {
            log.is_dry = false;
        }
        for entry in std::fs::read_dir(&self.folder)?.flatten() {
            let path = entry.path();
            let is_log = path.extension().is_some_and(|extension| extension == "log");
            let Some(name) = path.file_stem().and_then(|name| name.to_str()) else {
                continue;
            };
            let wanted = self.only.as_deref().is_none_or(|only| only == name);
            let is_new = !self.logs.contains_key(name) && self.logs.len() < LOGS_MAX;
            if is_log
                && wanted
                && is_new
                && let Some(log) = Log::open(&path)
            {
                self.logs.insert(name.to_owned(), log);
            }
        }
        Ok(())
    }

    /// Names of the logs that were found.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.logs.keys().map(String::as_str)
    }

    /// The oldest line of those that are next in their logs, as they were at the last look. A line
    /// without end is left for later, unless it is `last`.
    pub(super) fn next(&mut self, last: bool) -> Option<Line> {
        for log in self.logs.values_mut() {
            log.fill(last);
        }
        let next = (self.logs.iter_mut()).filter_map(|(name, log)| {
            let (time, _) = log.next.as_ref()?;
            Some(((time.clone(), name), &mut log.next))
        });
        let ((_, name), next) = next.min_by(|(one, _), (other, _)| one.cmp(other))?;
        let (time, bytes) = next.take()?;
        Some(Line {
            name: name.clone(),
            time,
            bytes,
        })
    }
}

impl Log {
    /// Opens a regular file; `None` for anything else.
    fn open(path: &Path) -> Option<Self> {
        let flags = OFlags::RDONLY | OFlags::NONBLOCK | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let file = File::from(openat(CWD, path, flags, Mode::empty()).ok()?);
        file.metadata().ok().filter(std::fs::Metadata::is_file)?;
        Some(Self {
            file,
            at: 0,
            rest: Vec::new(),
            taken: 0,
            is_dry: false,
            is_cut: false,
            time: String::new(),
            next: None,
        })
    }

    /// Makes sure that the next line is there, if it was written.
    fn fill(&mut self, last: bool) {
        while self.next.is_none() {
            let rest = &self.rest[self.taken..];
            if let Some(end) = rest.iter().position(|byte| *byte == b'\n') {
                let line = rest[..end].to_vec();
                self.taken += end + 1;
                self.found(line);
            } else if !self.is_dry && self.read() {
                self.bound();
            } else if last && (self.taken < self.rest.len() || self.is_cut) {
                let line = self.rest[self.taken..].to_vec();
                self.taken = self.rest.len();
                self.found(line);
            } else {
                return;
            }
        }
    }

    /// Reads what was written, a piece at a time; false when nothing was.
    fn read(&mut self) -> bool {
        self.rest.drain(..self.taken);
        self.taken = 0;
        if self
            .file
            .metadata()
            .is_ok_and(|metadata| metadata.len() < self.at)
        {
            // It was emptied, and is written anew.
            (self.at, self.is_cut) = (0, false);
            self.rest.clear();
            if self.file.seek(SeekFrom::Start(0)).is_err() {
                return false;
            }
        }
        let mut piece = vec![0; PIECE_BYTES];
        let read = loop {
            match self.file.read(&mut piece) {
                Ok(read) => break read,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => return false,
            }
        };
        self.at += read as u64;
        self.rest.extend_from_slice(&piece[..read]);
        self.is_dry = read == 0;
        read > 0
    }

    /// Forgets what is too much of a line that has no end yet.
    fn bound(&mut self) {
        let end = self.rest.iter().position(|byte| *byte == b'\n');
        let len = end.unwrap_or(self.rest.len());
        if len > LINE_BYTES_MAX {
            self.rest.drain(LINE_BYTES_MAX..len);
            self.is_cut = true;
        }
    }

    fn found(&mut self, mut line: Vec<u8>) {
        if line.len() > LINE_BYTES_MAX || self.is_cut {
            line.truncate(LINE_BYTES_MAX);
            line.extend_from_slice(CUT);
            self.is_cut = false;
        }
        if let Some(time) = time_of(&line) {
            time.clone_into(&mut self.time);
        }
        self.next = Some((self.time.clone(), line));
    }
}

/// The time at the beginning of a line: `2026-11-23T16:52:19.123456Z`. Such times sort as text.
fn time_of(line: &[u8]) -> Option<&str> {
    let end = line.iter().position(|byte| *byte == b' ')?;
    let word = core::str::from_utf8(&line[..end]).ok()?;
    let form = "dddd-dd-ddTdd:dd:dd.ddddddZ";
    let fits = |(byte, form): (u8, u8)| match form {
        b'd' => byte.is_ascii_digit(),
        form => byte == form,
    };
    (word.len() == form.len() && word.bytes().zip(form.bytes()).all(fits)).then_some(word)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn folder(logs: &[(&str, &[u8])]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, bytes) in logs {
            std::fs::write(folder.path().join(name), bytes).expect("written");
        }
        folder
    }

    fn all(merge: &mut Merge, last: bool) -> Vec<String> {
        let mut lines = Vec::new();
        merge.look().expect("a folder");
        while let Some(line) = merge.next(last) {
            let text = String::from_utf8_lossy(&line.bytes).into_owned();
            lines.push(format!("{} {text}", line.name));
        }
        lines
    }

    fn at(second: u32, text: &str) -> String {
        format!("2026-11-23T16:52:{second:02}.000000Z  INFO {text}\n")
    }

    #[test]
    fn lines_of_several_logs_come_by_time_and_those_without_stay_where_they_are() {
        let mapping = at(1, "a") + "thread panicked\n  at here\n" + &at(5, "b");
        let guard = at(2, "c") + &at(6, "d");
        let folder = folder(&[
            ("mapping.log", mapping.as_bytes()),
            ("guard.log", guard.as_bytes()),
            ("notes.txt", b"no log\n"),
        ]);
        let mut merge = Merge::new(folder.path(), None);
        let words: Vec<String> = all(&mut merge, false)
            .iter()
            .map(|line| line.rsplit("  ").next().unwrap_or("").to_owned())
            .collect();
        let expected = [
            "INFO a",
            "mapping thread panicked",
            "at here",
            "INFO c",
            "INFO b",
            "INFO d",
        ];
        assert_eq!(words, expected);
        let mut only = Merge::new(folder.path(), Some("guard"));
        assert_eq!(all(&mut only, false).len(), 2);
    }

    #[test]
    fn what_is_appended_comes_later_and_half_a_line_not_before_its_end() {
        let folder = folder(&[("a.log", b"one\ntw")]);
        let mut merge = Merge::new(folder.path(), None);
        assert_eq!(all(&mut merge, false), ["a one"]);
        let mut file = File::options()
            .append(true)
            .open(folder.path().join("a.log"))
            .expect("it");
        file.write_all(b"o\nthree").expect("written");
        std::fs::write(folder.path().join("b.log"), b"late\n").expect("written");
        assert_eq!(all(&mut merge, false), ["a two", "b late"]);
        assert_eq!(all(&mut merge, true), ["a three"]);
        // Emptied and written anew.
        std::fs::write(folder.path().join("a.log"), b"new\n").expect("written");
        assert_eq!(all(&mut merge, false), ["a new"]);
    }

    #[test]
    fn a_log_is_read_again_at_the_next_look_only() {
        let folder = folder(&[("a.log", b"one\n"), ("b.log", b"two\n")]);
        let mut merge = Merge::new(folder.path(), None);
        merge.look().expect("a folder");
        let text = |line: Option<Line>| line.map(|line| line.bytes);
        assert_eq!(text(merge.next(false)), Some(b"one".to_vec()));
        assert_eq!(text(merge.next(false)), Some(b"two".to_vec()));
        assert_eq!(merge.next(false), None);
        std::fs::write(folder.path().join("a.log"), b"one\nlate\n").expect("written");
        assert_eq!(merge.next(false), None, "no system call for every line");
        assert_eq!(all(&mut merge, false), ["a late"]);
    }

    #[test]
    fn endless_lines_are_cut_in_bounded_memory() {
        let endless = [vec![b'x'; 40 * LINE_BYTES_MAX], b"\nshort\n".to_vec()].concat();
        let folder = folder(&[("a.log", &endless)]);
        let mut merge = Merge::new(folder.path(), None);
        merge.look().expect("a folder");
        let line = merge.next(false).expect("a line").bytes;
        assert_eq!(line.len(), LINE_BYTES_MAX + CUT.len());
        assert!(merge.logs["a"].rest.capacity() < 4 * PIECE_BYTES);
        assert_eq!(merge.next(false).expect("a line").bytes, b"short");
    }

    #[test]
    fn pipes_and_links_are_no_logs() {
        let folder = folder(&[("real.log", b"text\n")]);
        let pipe = folder.path().join("pipe.log");
        rustix::fs::mknodat(CWD, &pipe, rustix::fs::FileType::Fifo, Mode::RWXU, 0).expect("a pipe");
        std::os::unix::fs::symlink("/etc/passwd", folder.path().join("link.log")).expect("a link");
        let mut merge = Merge::new(folder.path(), None);
        assert_eq!(all(&mut merge, true), ["real text"]);
    }
}
