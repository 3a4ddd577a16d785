//! One thread reads the stack, another one writes the file: a disk that stalls for a moment loses no
//! message. Between them lie at most [`QUEUE_BYTES_MAX`]; beyond that nothing is read, and what the
//! stack's queues then lose is counted.

use crate::channels::Channels;
use crate::file::{DRIVEN_BY, PARAMETERS, RecordingFile, SCENARIO_TYPE, START, Stamped};
use crate::kept::Kept;
use crate::logs::LogLine;
use crate::native::{self, NativeTopic};
use crate::ros::{Bytes, Ros, RosMessage, RosTopic, cdr};
use crate::taps::{Message, Taps};
use crate::times::TimeBase;
use crate::verdict::{END_TICK, OUTCOME, VERDICT, verdict};
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// Most that waits to be written. [bytes]
const QUEUE_BYTES_MAX: usize = 64 << 20;

/// How often what has come is handed to the system.
const FLUSH_PAUSE: Duration = Duration::from_secs(1);

/// Size of the buffer in front of the file. [bytes]
const BUFFER_BYTES: usize = 512 << 10;

/// Why a file cannot be written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum WriteError {
    /// The system, or the file's format.
    #[error("{}", in_words(.0))]
    File(#[from] mcap::McapError),
    /// The system.
    #[error("{0}")]
    System(#[from] std::io::Error),
    /// A message that has no form in CDR.
    #[error("a message has no form in CDR: {0}")]
    Cdr(#[from] cdr_encoding::Error),
    /// The thread is gone.
    #[error("the writing thread has ended unexpectedly")]
    Ended,
}

/// What is wrong with a file: what the system says of it, where it is the system.
fn in_words(error: &mcap::McapError) -> String {
    match error {
        mcap::McapError::Io(error) => error.to_string(),
        error => error.to_string(),
    }
}

/// What the reading thread tells the writing one.
enum Order {
    /// A topic that was found while the run went on: behind all others.
    Topic(NativeTopic),
    /// Messages that were read together.
    Write(VecDeque<Message>),
    /// Lines of logs.
    Logs(Vec<LogLine>),
    /// The end of the file, with the fields of its verdict.
    Finish(BTreeMap<String, String>),
}

/// The end of the recorder that takes messages.
#[derive(Debug)]
pub(crate) struct Recorder {
    orders: Sender<Order>,
    queued_bytes: Arc<AtomicUsize>,
    needs_keyframe: Arc<AtomicBool>,
    writer: std::thread::JoinHandle<Result<World, WriteError>>,
}

/// What of the layer for the world is in a file.
#[derive(Debug)]
pub(crate) struct World {
    /// Messages by topic.
    pub messages: BTreeMap<RosTopic, u64>,
    /// The first and the last moment that they are about. [ns]
    pub range_ns: [u64; 2],
}

/// Parameters by service or companion, and by their path.
pub(crate) type Parameters = BTreeMap<String, BTreeMap<String, String>>;

/// What a recording says of itself at its beginning.
#[derive(Debug, Clone, Default)]
pub(crate) struct Start {
    pub times: TimeBase,
    /// `real_time` or `lockstep`.
    pub mode: &'static str,
    pub seed: u64,
    pub tick_ns: u64,
    /// Name and text of the scenario that is driven, if that is known.
    pub scenario: Option<(String, String)>,
    /// What services and companions are started with: for each, its parameters by their path.
    pub parameters: Parameters,
    /// Who decides where the robot drives, if that is known.
    pub driven_by: Option<String>,
}

impl Recorder {
    /// Begins a recording of `taps` in `file`, of which something is on the disk when this returns.
    pub(crate) fn start(file: File, taps: &Taps, start: &Start) -> Result<Self, WriteError> {
        let writer = Writer::new(file, taps, start)?;
        let (orders, received) = channel();
        let queued_bytes = Arc::clone(&writer.queued_bytes);
        let needs_keyframe = Arc::clone(&writer.needs_keyframe);
        let thread = std::thread::Builder::new().name("writer".to_owned());
        let kept = Arc::clone(&writer.kept);
        let writer = thread.spawn(move || {
            let done = writer.run(&received);
            match &done {
                Ok(_) => kept.finished(),
                Err(error) => kept.end(&error.to_string()),
            }
            done
        })?;
        Ok(Self {
            orders,
            queued_bytes,
            needs_keyframe,
            writer,
        })
    }

    /// True while no more is to be read.
    pub(crate) fn is_full(&self) -> bool {
        self.queued_bytes.load(Ordering::Relaxed) > QUEUE_BYTES_MAX
    }

    /// True when the map can only be shown with a keyframe.
    pub(crate) fn needs_keyframe(&self) -> bool {
        self.needs_keyframe.load(Ordering::Relaxed)
    }

    /// Messages of one more topic will come.
    pub(crate) fn add(&self, topic: NativeTopic) {
        // When the writer has ended, it says why itself.
        let _ = self.orders.send(Order::Topic(topic));
    }

    /// Hands lines of logs on.
    pub(crate) fn log(&self, lines: Vec<LogLine>) {
        if !lines.is_empty() {
            let _ = self.orders.send(Order::Logs(lines));
        }
    }

    /// Hands messages on; false when the file can be written no longer.
    pub(crate) fn write(&self, messages: &mut VecDeque<Message>) -> bool {
        if messages.is_empty() {
            return !self.writer.is_finished();
        }
        let bytes = messages.iter().map(|it| it.bytes.len()).sum();
        self.queued_bytes.fetch_add(bytes, Ordering::Relaxed);
        self.orders
            .send(Order::Write(core::mem::take(messages)))
            .is_ok()
    }

    /// Ends the file with the verdict on `taps`, and the tick with which the run ended and its outcome, if it did.
    pub(crate) fn finish(
        self,
        taps: &Taps,
        end: Option<(u64, String)>,
    ) -> Result<(BTreeMap<String, String>, World), WriteError> {
        let mut fields = verdict(taps.tallies(), taps.problem());
        if let Some((tick, outcome)) = end {
            fields.insert(END_TICK.to_owned(), tick.to_string());
            fields.insert(OUTCOME.to_owned(), outcome);
        }
        // When the writer has ended, it says why itself.
        let _ = self.orders.send(Order::Finish(fields.clone()));
        let world = self.writer.join().map_err(|_| WriteError::Ended)??;
        Ok((fields, world))
    }
}

/// The end that writes.
struct Writer {
    file: RecordingFile<BufWriter<File>>,
    kept: Arc<Kept>,
    topics: Vec<NativeTopic>,
    channels: Channels,
    /// Messages of each of its topics, and the first and the last moment that they are about. [ns]
    world_messages: BTreeMap<RosTopic, u64>,
    world_range_ns: Option<[u64; 2]>,
    times: TimeBase,
    ros: Ros,
    /// The newest moment that a message was about. [ns]
    newest_ns: u64,
    queued_bytes: Arc<AtomicUsize>,
    needs_keyframe: Arc<AtomicBool>,
    /// Number of the next record, and of the next line of a log, which have none of their own.
    record: u32,
    log_line: u32,
}

impl Writer {
    fn new(file: File, taps: &Taps, start: &Start) -> Result<Self, WriteError> {
        let rows = taps.rows();
        let mut topics = native::topics();
        topics.retain(|topic| rows.iter().any(|row| row.number == topic.row.number));
        let kept = Arc::new(Kept::new(&file)?);
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
            channels: Channels::default(),
            topics,
            world_messages: BTreeMap::new(),
            world_range_ns: None,
            times: start.times,
            ros: Ros::new(start.times),
            newest_ns: start.times.base_ns(),
            queued_bytes: Arc::default(),
            needs_keyframe: Arc::default(),
            record: 0,
            log_line: 0,
        })
    }

    fn run(mut self, orders: &Receiver<Order>) -> Result<World, WriteError> {
        let mut flushed = Instant::now();
        loop {
            let wait = FLUSH_PAUSE.saturating_sub(flushed.elapsed());
            match orders.recv_timeout(wait) {
                Ok(Order::Write(messages)) => {
                    for message in messages {
                        self.write(&message)?;
                        let bytes = message.bytes.len();
                        self.queued_bytes.fetch_sub(bytes, Ordering::Relaxed);
                    }
                    let needs_keyframe = self.ros.needs_keyframe();
                    self.needs_keyframe.store(needs_keyframe, Ordering::Relaxed);
                }
                Ok(Order::Topic(topic)) => self.topics.push(topic),
                Ok(Order::Logs(lines)) => {
                    for line in lines {
                        self.write_log(&line)?;
                    }
                }
                Ok(Order::Finish(fields)) => {
                    // If there is no room for the index, these messages are there all the same.
                    self.flush()?;
                    self.file.metadata(VERDICT, fields)?;
                    let mut file = self.file.finish()?;
                    file.flush()?;
                    file.get_ref().sync_data()?;
                    return Ok(World {
                        messages: self.world_messages,
                        range_ns: self.world_range_ns.unwrap_or_default(),
                    });
                }
                Err(RecvTimeoutError::Timeout) => {}
                // Without a verdict: the reader has failed.
                Err(RecvTimeoutError::Disconnected) => {
                    self.flush()?;
                    return Err(WriteError::Ended);
                }
            }
            if flushed.elapsed() >= FLUSH_PAUSE {
                self.flush()?;
                flushed = Instant::now();
            }
        }
    }

    fn flush(&mut self) -> Result<(), WriteError> {
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

/// The last 32 bits: MCAP's numbers have no more.
fn low32(count: u64) -> u32 {
    u32::try_from(count & 0xffff_ffff).unwrap_or(0)
}
