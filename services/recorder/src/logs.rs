//! The logs of a run as they grow: every line once, whoever wrote it.

use std::collections::BTreeMap;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::time::{Duration, Instant, SystemTime};
use zeronav_files::Folder;
use zeronav_ros_messages::messages::Log;
use zeronav_ros_messages::reasons::{DEBUG, ERROR, INFO, WARN};
use zeronav_ros_messages::view::time;

/// Time between two looks at the logs.
const PAUSE: Duration = Duration::from_millis(100);

/// Time between two looks at whether there are more of them.
const LIST_PAUSE: Duration = Duration::from_secs(1);

/// Most logs of a run.
const LOGS_MAX: usize = 64;

/// Most that is read of a log at one look, and the longest line. [bytes]
const PIECE_BYTES: usize = 64 << 10;
const LINE_BYTES_MAX: usize = 4 << 10;

/// What the logs of a run are called.
const EXTENSION: &str = ".log";

/// A line of a log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct LogLine {
    /// Whose log: a service, a companion or `launch`.
    name: String,
    /// When it was written, if it says so. [ns] since 1970
    pub unix_ns: Option<u64>,
    level: u8,
    text: String,
}

impl LogLine {
    /// A line of the log `name`: `2026-11-23T16:52:19.123456Z  INFO text`; of any other form it is text.
    fn of(name: &str, line: &str) -> Self {
        let words = line.split_once(' ').and_then(|(time, rest)| {
            let (level, text) = rest.trim_start().split_once(' ')?;
            Some((unix_ns(time)?, level_of(level)?, text))
        });
        let (unix_ns, level, text) = match words {
            Some((unix_ns, level, text)) => (Some(unix_ns), level, text),
            None => (None, INFO, line),
        };
        Self {
            name: name.to_owned(),
            unix_ns,
            level,
            text: text.to_owned(),
        }
    }

    /// As a message of the moment `ns`.
    pub(crate) fn message(&self, ns: u64) -> Log {
        Log {
            stamp: time(ns),
            level: self.level,
            name: self.name.clone(),
            msg: self.text.clone(),
            file: String::new(),
            function: String::new(),
            line: 0,
        }
    }
}

fn level_of(word: &str) -> Option<u8> {
    Some(match word {
        "TRACE" | "DEBUG" => DEBUG,
        "INFO" => INFO,
        "WARN" => WARN,
        "ERROR" => ERROR,
        _ => return None,
    })
}

/// The moment that a time like `2026-11-23T16:52:19.123456Z` means. [ns] since 1970
fn unix_ns(text: &str) -> Option<u64> {
    let time = humantime::parse_rfc3339(text).ok()?;
    let since = time.duration_since(SystemTime::UNIX_EPOCH).ok()?;
    u64::try_from(since.as_nanos()).ok()
}

/// One log as far as it was read.
#[derive(Debug)]
struct GrowingLog {
    file: File,
    at: u64,
    /// The line that has no end yet.
    rest: Vec<u8>,
}

/// The logs in a folder.
#[derive(Debug)]
pub(crate) struct Logs {
    folder: Folder,
    /// The one that is left out: that of the recorder itself.
    but: &'static str,
    growing: BTreeMap<String, GrowingLog>,
    looked_at: Option<Instant>,
    listed_at: Option<Instant>,
}

impl Logs {
    pub(crate) fn new(folder: Folder, but: &'static str) -> Self {
        Self {
            folder,
            but,
            growing: BTreeMap::new(),
            looked_at: None,
            listed_at: None,
        }
    }

    /// The lines that were written since the last look; nothing when that was just now, unless it is the `last`. What
    /// cannot be read is left out: logs are no part of what a recording has to have.
    pub(crate) fn look(&mut self, last: bool) -> Vec<LogLine> {
        let now = Instant::now();
        let is_due =
            |at: Option<Instant>, pause| at.is_none_or(|at| now.duration_since(at) >= pause);
        if !last && !is_due(self.looked_at, PAUSE) {
            return Vec::new();
        }
        self.looked_at = Some(now);
        if last || is_due(self.listed_at, LIST_PAUSE) {
            self.listed_at = Some(now);
            self.find();
        }
        let mut lines = Vec::new();
        for (name, log) in &mut self.growing {
            while log.read(|line| lines.push(LogLine::of(name, line)), last) && last {}
        }
        lines.sort_by_key(|line| line.unix_ns);
        lines
    }

    fn find(&mut self) {
        for file in self.folder.names().unwrap_or_default() {
            let Some(file) = file.to_str() else { continue };
            let Some(name) = file.strip_suffix(EXTENSION) else {
                continue;
            };
            let is_new = !self.growing.contains_key(name) && self.growing.len() < LOGS_MAX;
            if name != self.but
                && is_new
                && let Ok(opened) = self.folder.existing(file)
            {
                let log = GrowingLog {
                    file: opened,
                    at: 0,
                    rest: Vec::new(),
                };
                self.growing.insert(name.to_owned(), log);
            }
        }
    }
}

impl GrowingLog {
    /// Reads a piece of what was written; false when there was none.
    fn read(&mut self, mut see: impl FnMut(&str), last: bool) -> bool {
        let len = self.file.metadata().map_or(0, |it| it.len());
        // It was cut because it was too long: what is left was read before.
        self.at = self.at.min(len);
        let mut piece = vec![0; PIECE_BYTES];
        let n = self.file.read_at(&mut piece, self.at).unwrap_or(0);
        self.at += n as u64;
        for line in piece[..n].split_inclusive(|byte| *byte == b'\n') {
            let room = LINE_BYTES_MAX.saturating_sub(self.rest.len());
            self.rest.extend_from_slice(&line[..line.len().min(room)]);
            if line.ends_with(b"\n") {
                self.end(&mut see);
            }
        }
        if n == 0 && last {
            self.end(&mut see);
        }
        n > 0
    }

    fn end(&mut self, see: &mut impl FnMut(&str)) {
        let line = core::mem::take(&mut self.rest);
        let line = String::from_utf8_lossy(&line);
        let line = line.trim_end();
        if !line.is_empty() {
            see(line);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_line_has_its_time_and_level() {
        let line = LogLine::of(
            "mapping",
            "2026-11-23T16:52:19.123456Z  WARN zeronav: late by 3 ms",
        );
        // date -u -d 2026-11-23T16:52:19 +%s
        assert_eq!(line.unix_ns, Some(1_795_452_739_123_456_000));
        assert_eq!((line.level, &*line.text), (WARN, "zeronav: late by 3 ms"));
        let message = line.message(5_000_000_007);
        assert_eq!((message.stamp.sec, message.stamp.nanosec), (5, 7));
        assert_eq!(message.name, "mapping");
        for text in [
            "panicked at src/lib.rs",
            "",
            "2026-11-23T16:52:19Z",
            "2026-99-23T16:52:19.1Z INFO a",
        ] {
            let line = LogLine::of("it", text);
            assert_eq!((line.unix_ns, line.level, &*line.text), (None, INFO, text));
        }
        assert_eq!(unix_ns("1970-01-01T00:00:00.000000Z"), Some(0));
        assert_eq!(
            unix_ns("2024-02-29T23:59:59.5Z"),
            Some(1_709_251_199_500_000_000)
        );
    }

    #[test]
    fn every_line_comes_once_and_a_long_one_is_cut() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = Folder::open(place.path()).expect("it");
        let mut logs = Logs::new(folder, "recorder");
        let path = place.path().join("mapping.log");
        let mut log = File::create(&path).expect("a log");
        std::fs::write(place.path().join("recorder.log"), "not this\n").expect("written");
        std::fs::write(place.path().join("else.txt"), "nor this\n").expect("written");
        let texts = |lines: Vec<LogLine>| -> Vec<String> {
            lines.into_iter().map(|line| line.text).collect()
        };
        write!(log, "one\ntwo\nthr").expect("written");
        assert_eq!(texts(logs.look(false)), ["one", "two"]);
        assert_eq!(logs.look(false), [], "just now");
        writeln!(log, "ee").expect("written");
        writeln!(log, "{}", "x".repeat(3 * PIECE_BYTES)).expect("written");
        write!(log, "last").expect("written");
        let rest = texts(logs.look(true));
        assert_eq!(rest.len(), 3, "{rest:?}");
        assert_eq!((&*rest[0], &*rest[2]), ("three", "last"));
        assert_eq!(rest[1].len(), LINE_BYTES_MAX);
        assert_eq!(logs.look(true), []);
        // Cut by its keeper, then written on.
        File::create(&path).expect("cut");
        assert_eq!(logs.look(true), []);
        std::fs::write(&path, "more\n").expect("written");
        assert_eq!(texts(logs.look(true)), ["more"]);
    }
}
