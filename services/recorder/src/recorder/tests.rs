use super::*;
use crate::read::summary;
use crate::times::TimeBase;
use std::io::Cursor;
use zeronav_msgs::run::{RunClock, RunMode};
use zeronav_msgs::topics::SPANS;

/// Bytes of a message.
const BYTES: usize = 400;

fn messages(n: u8) -> VecDeque<Message> {
    let message = |at| Message {
        topic: 0,
        header: None,
        bytes: vec![at; BYTES],
        envelope_bytes: 0,
    };
    (0..n).map(message).collect()
}

/// A recorder of records beside a stack in real time, and what it writes.
fn recorder() -> (Recorder, tempfile::NamedTempFile) {
    let file = tempfile::NamedTempFile::new().expect("a file");
    let clock = RunClock {
        mode: RunMode::RealTime.code(),
        ..RunClock::default()
    };
    let start = Start {
        times: TimeBase::new(&clock, 1_000, 0),
        mode: RunMode::RealTime.label(),
        ..Start::default()
    };
    let opened = file.reopen().expect("it");
    let recorder = Recorder::start(opened, &[&SPANS], &start, None);
    (recorder.expect("a recorder"), file)
}

fn verdict() -> BTreeMap<String, String> {
    [("valid".to_owned(), "true".to_owned())].into()
}

/// Messages in a whole file.
fn written(file: &tempfile::NamedTempFile) -> u64 {
    let bytes = std::fs::read(file.path()).expect("it");
    let (found, damage) = summary(Cursor::new(bytes));
    assert!(damage.is_none(), "{damage:?}");
    assert_eq!(found.metadata["zeronav"], verdict());
    found.channels.values().map(|it| it.messages).sum()
}

#[test]
fn a_writer_that_gets_no_processor_hands_over_and_nothing_is_lost() {
    let (mut recorder, file) = recorder();
    let writer = |recorder: &Recorder| recorder.writer.as_ref().map(|it| it.thread().id());
    let first = writer(&recorder);
    assert!(recorder.write(&mut messages(40)));
    recorder.shared.hurry.store(true, Ordering::Relaxed);
    assert!(recorder.write(&mut messages(40)));
    while writer(&recorder) == first {
        assert!(recorder.write(&mut VecDeque::new()));
        std::thread::yield_now();
    }
    assert!(recorder.write(&mut messages(20)));
    recorder.finish(verdict()).expect("finished");
    assert_eq!(written(&file), 100);
}

#[test]
fn what_is_left_at_the_end_is_written_at_once() {
    let (mut recorder, file) = recorder();
    assert!(recorder.write(&mut messages(100)));
    recorder.finish(verdict()).expect("finished");
    assert_eq!(written(&file), 100);
}

#[test]
fn what_waits_for_long_hurries_the_writer() {
    let (mut recorder, _file) = recorder();
    // As if there were something that the writer does not come to.
    recorder.shared.queued_bytes.store(1, Ordering::Relaxed);
    recorder.keep_up();
    assert!(!recorder.shared.hurry.load(Ordering::Relaxed));
    recorder.waits_since = Instant::now().checked_sub(2 * WAIT_MAX);
    recorder.keep_up();
    assert!(recorder.shared.hurry.load(Ordering::Relaxed));
    recorder.finish(verdict()).expect("finished");
}
