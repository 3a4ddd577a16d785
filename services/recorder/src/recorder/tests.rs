use super::*;
use crate::read::summary;
use std::io::Cursor;
use zeronav_msgs::run::{RunClock, RunMode};
use zeronav_msgs::topics::SPANS;
use zeronav_ros_messages::times::TimeBase;

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

/// Looks until another thread writes, for 60 s at most.
fn await_successor(recorder: &mut Recorder) {
    let writer = |recorder: &Recorder| recorder.writer.as_ref().map(|it| it.thread().id());
    let (first, began) = (writer(recorder), Instant::now());
    while writer(recorder) == first {
        assert!(recorder.keep_up());
        assert!(began.elapsed() < Duration::from_secs(60), "no handover");
        std::thread::yield_now();
    }
}

#[test]
fn a_writer_that_gets_no_processor_hands_over_and_nothing_is_lost() {
    let (mut recorder, file) = recorder();
    assert!(recorder.write(&mut messages(40)));
    recorder.shared.hurry.store(true, Ordering::Relaxed);
    assert!(recorder.write(&mut messages(40)));
    await_successor(&mut recorder);
    assert!(recorder.write(&mut messages(20)));
    recorder.finish(verdict()).expect("finished");
    assert_eq!(written(&file), 100);
}

#[test]
fn a_full_queue_gets_a_successor_that_makes_room() {
    let (mut recorder, file) = recorder();
    // As if that much had been handed on, and waited for too long.
    let much = QUEUE_BYTES_MAX + 1;
    recorder.shared.queued_bytes.store(much, Ordering::Relaxed);
    recorder.handed_bytes = much;
    recorder.waits = Instant::now()
        .checked_sub(2 * WAIT_MAX)
        .map(|since| (since, much));
    assert!(recorder.is_full());
    await_successor(&mut recorder);
    recorder.shared.queued_bytes.store(0, Ordering::Relaxed);
    assert!(recorder.write(&mut messages(10)) && !recorder.is_full());
    recorder.finish(verdict()).expect("finished");
    assert_eq!(written(&file), 10);
}

#[test]
fn what_is_left_at_the_end_is_written() {
    let (mut recorder, file) = recorder();
    assert!(recorder.write(&mut messages(100)));
    recorder.finish(verdict()).expect("finished");
    assert_eq!(written(&file), 100);
}

#[test]
fn only_a_message_that_waits_for_long_hurries_the_writer() {
    let (mut recorder, _file) = recorder();
    let hurries = |recorder: &Recorder| recorder.shared.hurry.load(Ordering::Relaxed);
    let long_ago = Instant::now().checked_sub(2 * WAIT_MAX).expect("a moment");
    // Something waits, but of what waited long ago all is written.
    recorder.handed_bytes = 500;
    recorder.shared.queued_bytes.store(100, Ordering::Relaxed);
    recorder.waits = Some((long_ago, 400));
    assert!(recorder.keep_up() && !hurries(&recorder));
    recorder.waits = Some((long_ago, 401));
    recorder.keep_up();
    assert!(hurries(&recorder));
    recorder.finish(verdict()).expect("finished");
}
