//! The thread that writes the file.

use crate::channels::Channels;
use crate::file::{DRIVEN_BY, PARAMETERS, RecordingFile, SCENARIO_TYPE, START, Stamped, low32};
use crate::kept::Kept;
use crate::logs::{LogLine, Logs};
use crate::native::{self, NativeTopic};
use crate::orders::{Order, Shared, Start, World, WriteError, in_words};
use crate::taps::Message;
use crate::verdict::VERDICT;
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};
use zeronav_msgs::topics::TopicRow;
use zeronav_ros_messages::times::TimeBase;
use zeronav_ros_messages::{Bytes, Ros, RosMessage, RosTopic, cdr};

/// How often what has come is handed to the system.
const FLUSH_PAUSE: Duration = Duration::from_secs(1);

/// Size of the buffer in front of the file. [bytes]
const BUFFER_BYTES: usize = 512 << 10;

/// How writing has ended on one thread.
pub(crate) enum Ended {
    /// The file is finished, or can be written no longer.
    Done(Result<World, WriteError>),
    /// Another thread is to go on: this one gets too little of the processor.
    HandedOver(Box<Writer>),
}

/// The end that writes.
pub(crate) struct Writer {
    file: RecordingFile<BufWriter<File>>,
    kept: Kept,
    orders: Receiver<Order>,
    /// Messages that were read and are not written yet, and the fields of the verdict that comes behind them.
    waiting: VecDeque<Message>,
    verdict: Option<BTreeMap<String, String>>,
    logs: Option<Logs>,
    flushed: Instant,
    /// True while it hands over when it is asked to hurry.
    pub gives_way: bool,
    shared: Arc<Shared>,
    topics: Vec<NativeTopic>,
    channels: Channels,
    /// Messages of each of its topics, and the first and the last moment that they are about. [ns]
    world_messages: BTreeMap<RosTopic, u64>,
    world_range_ns: Option<[u64; 2]>,
    times: TimeBase,
    ros: Ros,
    /// The newest moment that a message was about. [ns]
    newest_ns: u64,
    /// Number of the next record, and of the next line of a log, which have none of their own.
    record: u32,
    log_line: u32,
}

impl Writer {
    /// Begins a recording of the topics in `rows`, of which something is on the disk when this returns.
    pub(crate) fn new(
        file: File,
        rows: &[&'static TopicRow],
        (start, logs): (&Start, Option<Logs>),
        (orders, shared): (Receiver<Order>, Arc<Shared>),
    ) -> Result<Self, WriteError> {
        let mut topics = native::topics();
        topics.retain(|topic| rows.iter().any(|row| row.number == topic.row.number));
        let kept = Kept::new(&file)?;
        let mut file = RecordingFile::new(BufWriter::with_capacity(BUFFER_BYTES, file))?;
        let times = match start.times.base_ns() {
            0 => "run time",
            _ => "system time",
        };
        let fields = [
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("mode", start.mode.to_owned()),
            ("seed", start.seed.to_string()),
            ("tick_ns", start.tick_ns.to_string()),
            ("times", times.to_owned()),
            ("run_zero_ns", start.times.base_ns().to_string()),
        ];
        let fields = fields.map(|(key, value)| (key.to_owned(), value));
        let driven_by = start.driven_by.clone();
        let driven_by = driven_by.map(|who| (DRIVEN_BY.to_owned(), who));
        file.metadata(START, fields.into_iter().chain(driven_by).collect())?;
        if let Some((name, text)) = &start.scenario {
            file.attach(name, SCENARIO_TYPE, text.as_bytes())?;
        }
        for (name, values) in &start.parameters {
            file.metadata(&format!("{PARAMETERS}{name}"), values.clone())?;
        }
        file.flush()?;
        kept.is_whole()?;
        Ok(Self {
            file,
            kept,
            orders,
            waiting: VecDeque::new(),
            verdict: None,
            logs,
            flushed: Instant::now(),
            gives_way: false,
            shared,
            channels: Channels::default(),
            topics,
            world_messages: BTreeMap::new(),
            world_range_ns: None,
            times: start.times,
            ros: Ros::new(start.times),
            newest_ns: start.times.base_ns(),
            record: 0,
            log_line: 0,
        })
    }

    /// Writes until the end, or until another thread is to go on.
    pub(crate) fn run(mut self: Box<Self>) -> Ended {
        match self.write_on() {
            Ok(None) => Ended::HandedOver(self),
            Ok(Some(verdict)) => self.finish(verdict),
            Err(error) => {
                self.give_up(&error.to_string());
                Ended::Done(Err(error))
            }
        }
    }

    /// Ends the file as far as it is whole, with the reason.
    pub(crate) fn give_up(self: Box<Self>, why: &str) {
        let Self { file, kept, .. } = *self;
        // First: what is still buffered goes to the file when it is dropped.
        drop(file);
        kept.end(why);
    }

    /// Writes all but the verdict, which it gives back; `None` when another thread is to go on.
    fn write_on(&mut self) -> Result<Option<BTreeMap<String, String>>, WriteError> {
        loop {
            if self.gives_way && self.shared.hurry.load(Ordering::Acquire) {
                return Ok(None);
            }
            if let Some(message) = self.waiting.pop_front() {
                self.write(&message)?;
                let bytes = message.bytes.len();
                self.shared.queued_bytes.fetch_sub(bytes, Ordering::Relaxed);
            } else {
                let needs_keyframe = self.ros.needs_keyframe();
                (self.shared.needs_keyframe).store(needs_keyframe, Ordering::Relaxed);
                self.look_at_logs()?;
                if let Some(fields) = self.verdict.take() {
                    // If there is no room for the index, these messages are there all the same.
                    self.flush()?;
                    return Ok(Some(fields));
                }
                self.receive()?;
            }
            if self.flushed.elapsed() >= FLUSH_PAUSE {
                self.flush()?;
            }
        }
    }

    /// Ends the file.
    fn finish(self: Box<Self>, verdict: BTreeMap<String, String>) -> Ended {
        let Self {
            mut file,
            kept,
            world_messages: messages,
            world_range_ns,
            ..
        } = *self;
        let done = file.metadata(VERDICT, verdict).and_then(|()| {
            let mut file = file.finish()?;
            file.flush()?;
            file.get_ref().sync_data()?;
            Ok(())
        });
        match &done {
            Ok(()) => kept.finished(),
            Err(error) => kept.end(&in_words(error)),
        }
        let range_ns = world_range_ns.unwrap_or_default();
        let world = World { messages, range_ns };
        Ended::Done(done.map(|()| world).map_err(WriteError::from))
    }

    /// Waits for what the reading thread says next, at most until it is time to flush.
    fn receive(&mut self) -> Result<(), WriteError> {
        let wait = FLUSH_PAUSE.saturating_sub(self.flushed.elapsed());
        match self.orders.recv_timeout(wait) {
            Ok(Order::Write(messages)) => self.waiting = messages,
            Ok(Order::Topic(topic)) => self.topics.push(topic),
            Ok(Order::Finish(fields)) => self.verdict = Some(fields),
            Err(RecvTimeoutError::Timeout) => {}
            // Without a verdict: the reader has failed.
            Err(RecvTimeoutError::Disconnected) => {
                self.flush()?;
                return Err(WriteError::Ended);
            }
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), WriteError> {
        self.flushed = Instant::now();
        self.file.flush()?;
        Ok(self.kept.is_whole()?)
    }

    fn write(&mut self, message: &Message) -> Result<(), WriteError> {
        let row = self.topics[message.topic].row;
        let header = message.header.as_ref();
        let run_ns = header.map_or(0, |header| header.run_ns);
        // Idle outputs, records and what launch says belong to no moment of their own.
        let log_ns = if run_ns > 0 {
            self.times.at_run(run_ns)
        } else {
            self.newest_ns
        };
        self.newest_ns = self.newest_ns.max(log_ns);
        let sent_ns = header.and_then(|it| self.times.at_monotonic(it.stamps.published_ns));
        let sequence = header.map_or(self.record, |header| low32(header.id().count()));
        if header.is_none() {
            self.record = self.record.wrapping_add(1);
        }
        let when = Stamped {
            sequence,
            log_ns,
            publish_ns: sent_ns.unwrap_or(log_ns),
        };
        let topic = &self.topics[message.topic];
        let channel = self.channels.native(&mut self.file, topic)?;
        self.file.write(channel, when, &message.bytes)?;
        if header.is_none() {
            return Ok(());
        }
        let (envelope, items) = message.bytes.split_at(message.envelope_bytes);
        let bytes = Bytes {
            row,
            log_ns,
            envelope,
            items,
        };
        for made in self.ros.see(&bytes)? {
            self.write_world(&made, when)?;
        }
        Ok(())
    }

    fn write_world(&mut self, made: &RosMessage, when: Stamped) -> Result<(), WriteError> {
        let channel = self.channels.world(&mut self.file, made.topic)?;
        let when = Stamped {
            log_ns: made.log_ns,
            ..when
        };
        self.file.write(channel, when, &made.bytes)?;
        *self.world_messages.entry(made.topic).or_default() += 1;
        let [first_ns, last_ns] = self.world_range_ns.unwrap_or([made.log_ns; 2]);
        self.world_range_ns = Some([first_ns.min(made.log_ns), last_ns.max(made.log_ns)]);
        Ok(())
    }

    /// Writes what has come into the logs, all of it at the end.
    fn look_at_logs(&mut self) -> Result<(), WriteError> {
        let is_last = self.verdict.is_some();
        let lines = self.logs.as_mut().map(|logs| logs.look(is_last));
        for line in lines.unwrap_or_default() {
            self.write_log(&line)?;
        }
        Ok(())
    }

    /// A line of a log: of the time that it says in real time, in lockstep of the newest moment.
    fn write_log(&mut self, line: &LogLine) -> Result<(), WriteError> {
        let log_ns = match line.unix_ns {
            Some(unix_ns) if self.times.is_real_time() => unix_ns,
            _ => self.newest_ns,
        };
        let made = RosMessage {
            topic: RosTopic::Rosout,
            log_ns,
            bytes: cdr(&line.message(log_ns))?,
        };
        let when = Stamped {
            sequence: self.log_line,
            log_ns,
            publish_ns: log_ns,
        };
        self.log_line = self.log_line.wrapping_add(1);
        self.write_world(&made, when)
    }
}
