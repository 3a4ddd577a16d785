//! The process: its flags, its loop, and its end.

use crate::bag_folder;
use crate::domain_files::{END, OUTCOME_BYTES_MAX, RECORDED};
use crate::file::{DRIVEN_BY_SCENARIO, SCENARIO_BYTES_MAX};
use crate::logs::Logs;
use crate::orders::{Parameters, Start, World, WriteError};
use crate::priority;
use crate::recorder::Recorder;
use crate::taps::Taps;
use crate::verdict::{END_TICK, OUTCOME, verdict};
use clap::Parser;
use rustix::fs::OFlags;
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::Write;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use zeronav_files::{Folder, Replace, parts, read};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::EVENT_NEED_KEYFRAME;
use zeronav_ros_messages::times::TimeBase;
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Bells;
use zeronav_shell::error::EXIT_USAGE;
use zeronav_shell::roster_reader::RosterReader;
use zeronav_shell::{Domain, Peer, Roster, StartError, flags, logs, printable, signals};

/// Guests are not restarted.
const EPOCH: u32 = 1;

/// Time between two looks in real time, where the shortest queue holds the messages of 0.6 s: few, so that the stack is
/// seldom disturbed, and each of them short.
const PAUSE: Duration = Duration::from_millis(16);

/// The same in lockstep, where run time is a hundred times as fast.
const LOCKSTEP_PAUSE: Duration = Duration::from_micros(500);

/// Least time between two requests for the whole map, and how long it may take to come by itself.
const ASK_PAUSE: Duration = Duration::from_secs(1);

/// Records a running stack into one MCAP file until the stack or SIGTERM ends it; normally started
/// by `zeronav run --record`.
#[derive(Debug, Parser)]
#[command(name = "zeronav-recorder", version)]
struct Arguments {
    /// Root folder of the run, directly under /dev/shm.
    #[arg(long, value_name = "ROOT", env = "ZERONAV_DOMAIN")]
    domain: PathBuf,
    /// The file; its name ends in .mcap, as readers expect.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Take the place of a file that is there.
    #[arg(long)]
    force: bool,
    /// Put this file, the text of the scenario that is driven, into the recording, for `zeronav replay`.
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Say who decides where the robot drives.
    #[arg(long, value_name = "WHO", value_parser = [DRIVEN_BY_SCENARIO, "clients", "recording"])]
    driven_by: Option<String>,
    /// Put this file, a JSON object of parameters by service and path, into the recording.
    #[arg(long, value_name = "FILE")]
    parameters: Option<PathBuf>,
    /// Record the lines of the logs in this folder, as `/rosout`.
    #[arg(long, value_name = "FOLDER")]
    logs: Option<PathBuf>,
    /// Make the folder of the file a bag of rosbag2: write `metadata.yaml` there.
    #[arg(long)]
    metadata: bool,
    /// Record what the local planner looks at, too (`debug/rollouts`, `/local_plan`), which costs it time.
    #[arg(long)]
    rollouts: bool,
}

/// Why there is no recording, or none to the end.
#[derive(Debug, thiserror::Error)]
enum RecordError {
    /// The stack.
    #[error("{0}")]
    Start(#[from] StartError),
    /// The file.
    #[error("recording to {}: {why}", file.display())]
    File {
        /// Which one.
        file: PathBuf,
        /// What is wrong with it.
        why: WriteError,
    },
}

/// Joins a run, records it and ends with it.
#[must_use]
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) if error.use_stderr() => {
            say(&flags::one_line(&error));
            return ExitCode::from(EXIT_USAGE);
        }
        Err(error) => {
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
    };
    logs::quiet_middleware();
    match record(&arguments) {
        Ok(fields) => {
            say(&conclusion(&arguments.out, &fields));
            ExitCode::SUCCESS
        }
        Err(error) => {
            say(&error.to_string());
            match error {
                RecordError::Start(error) => error.exit_code(),
                RecordError::File { .. } => ExitCode::FAILURE,
            }
        }
    }
}

/// One line about a finished recording.
fn conclusion(file: &Path, fields: &BTreeMap<String, String>) -> String {
    let field = |name: &str| fields.get(name).map_or("", String::as_str);
    let messages = field("messages");
    let complete = match field("why") {
        "" => "complete".to_owned(),
        why => format!("NOT COMPLETE: {why}"),
    };
    format!("{}: {messages} messages, {complete}", file.display())
}

fn record(arguments: &Arguments) -> Result<BTreeMap<String, String>, RecordError> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in signals::stopping() {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(|error| StartError::system("catching signals", error))?;
    }
    // A file that may not grow any more is an error of writing, and no end of this process.
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default())
        .map_err(|error| StartError::system("catching signals", error))?;
    let failed = |why: WriteError| RecordError::File {
        file: arguments.out.clone(),
        why,
    };
    let file = create(&arguments.out, arguments.force).map_err(|error| failed(error.into()))?;
    let (scenario, parameters) = (
        scenario_in(arguments.scenario.as_deref())?,
        parameters_in(arguments.parameters.as_deref())?,
    );
    let logs = logs_in(arguments.logs.as_deref())?;
    let peer = Peer::join(Domain::join(&arguments.domain)?, Role::Tap, EPOCH)?;
    let mut taps = Taps::open(&peer, arguments.rollouts)?;
    let roster = known(&peer)?;
    if !roster.lockstep() {
        priority::behind_the_stack();
    }
    let start = Start {
        scenario,
        parameters,
        driven_by: arguments.driven_by.clone(),
        ..start_of(&roster)
    };
    let started = Recorder::start(file, &taps.rows(), &start, logs);
    let mut recorder = started.map_err(failed)?;
    for topic in taps.open_users(&peer) {
        recorder.add(topic);
    }
    let progress = peer
        .domain()
        .folder()
        .file(RECORDED, OFlags::RDWR | OFlags::CREATE)
        .map_err(|error| StartError::system("saying that the recording has begun", error))?;
    let said = (&roster, &progress);
    let done = listen(&peer, &mut taps, &mut recorder, said, || {
        stop.load(Ordering::Relaxed) || peer.domain().is_orphaned()
    });
    let end = peer.domain().folder().file(END, OFlags::RDONLY);
    let end = end.ok().and_then(|file| end_in(&file));
    let fields = fields_of(&taps, end);
    let finished = recorder.finish(fields.clone()).map_err(failed);
    drop(taps);
    // Of a run that is over, launch removes what this cannot.
    let _ = peer.leave().close();
    done?;
    let world = finished?;
    if arguments.metadata {
        describe(&arguments.out, &world).map_err(|error| failed(error.into()))?;
    }
    Ok(fields)
}

/// The verdict on `taps`, with the tick with which the run ended and its outcome, if it did.
fn fields_of(taps: &Taps, end: Option<(u64, String)>) -> BTreeMap<String, String> {
    let mut fields = verdict(taps.tallies(), taps.problem());
    if let Some((tick, outcome)) = end {
        fields.insert(END_TICK.to_owned(), tick.to_string());
        fields.insert(OUTCOME.to_owned(), outcome);
    }
    fields
}

/// Writes `metadata.yaml` beside a recording.
fn describe(file: &Path, world: &World) -> std::io::Result<()> {
    let (folder, name) = parts(file)?;
    let text = bag_folder::metadata(name, &world.messages, world.range_ns);
    Folder::open(folder)?.write(bag_folder::FILE, text.as_bytes(), Replace::Yes)
}

/// Reads until `is_over` says so, and then what is left.
fn listen(
    peer: &Peer,
    taps: &mut Taps,
    recorder: &mut Recorder,
    (roster, progress): (&Roster, &File),
    mut is_over: impl FnMut() -> bool,
) -> Result<(), StartError> {
    let pause = if roster.lockstep() {
        LOCKSTEP_PAUSE
    } else {
        PAUSE
    };
    let mut messages = VecDeque::new();
    let mut may_ask = Instant::now() + ASK_PAUSE;
    loop {
        // Before the last messages are read, so that they are recorded.
        let last = is_over();
        if !recorder.keep_up() {
            return Ok(());
        }
        if !recorder.is_full() {
            while taps.drain(&mut messages) > 0 && last {}
            if !recorder.write(&mut messages) || last {
                return Ok(());
            }
            for topic in taps.open_users(peer) {
                recorder.add(topic);
            }
            if roster.lockstep() {
                // Nobody waits when it cannot be said.
                let _ = progress.write_all_at(&taps.tick().to_le_bytes(), 0);
            }
        }
        if !recorder.needs_keyframe() {
            may_ask = Instant::now() + ASK_PAUSE;
        } else if Instant::now() >= may_ask {
            may_ask = Instant::now() + ASK_PAUSE;
            Bells::open(peer)?.ring(Role::Mapping, EVENT_NEED_KEYFRAME);
        }
        std::thread::sleep(pause);
    }
}

/// The tick with which the run ended, and its outcome, as launch has written them.
fn end_in(file: &File) -> Option<(u64, String)> {
    let mut bytes = [0; 8 + OUTCOME_BYTES_MAX];
    let len = file.read_at(&mut bytes, 0).ok()?;
    let (tick, outcome) = bytes.get(..len)?.split_first_chunk::<8>()?;
    let outcome = String::from_utf8_lossy(outcome).into_owned();
    Some((u64::from_le_bytes(*tick), outcome))
}

/// Which processes are obeyed and how time runs, once launch has said so.
fn known(peer: &Peer) -> Result<Roster, StartError> {
    let mut reader = RosterReader::open(peer)?;
    reader.await_known()?;
    Ok(reader.roster().clone())
}

/// Name and text of a scenario's file.
fn scenario_in(file: Option<&Path>) -> Result<Option<(String, String)>, StartError> {
    let Some(file) = file else { return Ok(None) };
    let text = read::text(file, SCENARIO_BYTES_MAX)
        .map_err(|error| StartError::Usage(format!("--scenario {}: {error}", file.display())))?;
    let name = file.file_name().unwrap_or_default();
    Ok(Some((name.to_string_lossy().into_owned(), text)))
}

/// Parameters by service and path, in a file.
fn parameters_in(file: Option<&Path>) -> Result<Parameters, StartError> {
    let Some(file) = file else {
        return Ok(Parameters::new());
    };
    let wrong = |why: &dyn core::fmt::Display| {
        StartError::Usage(format!("--parameters {}: {why}", file.display()))
    };
    let text = read::text(file, SCENARIO_BYTES_MAX).map_err(|error| wrong(&error))?;
    serde_json::from_str(&text).map_err(|error| wrong(&error))
}

/// The logs in a folder, but that of this process.
fn logs_in(folder: Option<&Path>) -> Result<Option<Logs>, StartError> {
    let Some(folder) = folder else {
        return Ok(None);
    };
    let opened = Folder::open(folder)
        .map_err(|error| StartError::Usage(format!("--logs {}: {error}", folder.display())))?;
    Ok(Some(Logs::new(opened, "recorder")))
}

fn start_of(roster: &Roster) -> Start {
    let clock = &roster.clock;
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    let unix_ns = since.map_or(0, |since| u64::try_from(since.as_nanos()).unwrap_or(0));
    Start {
        times: TimeBase::new(clock, unix_ns, now_ns()),
        mode: clock.mode().map_or("none", |mode| mode.label()),
        seed: clock.seed,
        tick_ns: clock.tick_ns,
        ..Start::default()
    }
}

/// Makes the file, in the place of one that is there only when `force` is.
fn create(path: &Path, force: bool) -> std::io::Result<File> {
    let (folder, name) = parts(path)?;
    let folder = Folder::open(folder)?;
    if force {
        folder.remove(name);
    }
    folder.new_file(name).map_err(|error| match error.kind() {
        std::io::ErrorKind::AlreadyExists => {
            std::io::Error::other("it exists; name another file, or --force to replace it")
        }
        _ => error,
    })
}

fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "zeronav-recorder: {}", printable(text));
}
