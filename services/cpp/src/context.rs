//! What a callback may do.

use crate::ports::{self, AnyReader, AnyWriter, RawView};
use core::ffi::{CStr, c_char, c_void};
use zeronav_msgs::header::Parents;
use zeronav_msgs::odometry::Odometry;
use zeronav_msgs::pose::Pose;
use zeronav_msgs::role::Role;
use zeronav_shell::{Draft, Due, Input, OdometryReader, Peer, Sent, Shell, StartError, Trigger};

/// The service's ports, and the answer that it is giving.
pub(crate) struct State {
    odometry: OdometryReader,
    readers: Vec<Box<dyn AnyReader>>,
    writers: Vec<Box<dyn AnyWriter>>,
    dues: Vec<Due>,
    draft: Option<Draft>,
    /// The answer's first message.
    sent: Option<Sent>,
    failure: Option<StartError>,
}

impl State {
    /// Opens odometry, which every service reads.
    pub(crate) fn open(peer: &Peer) -> Result<Self, StartError> {
        Ok(Self {
            odometry: OdometryReader::open(peer)?,
            readers: Vec::new(),
            writers: Vec::new(),
            dues: Vec::new(),
            draft: None,
            sent: None,
            failure: None,
        })
    }

    /// Takes in odometry, before every other input.
    pub(crate) fn poll(&mut self, shell: &mut Shell) {
        self.odometry.poll(shell.roster());
        let readers = self.readers.iter().map(|reader| reader.input());
        let inputs: Vec<&dyn Input> = readers.chain([&self.odometry as &dyn Input]).collect();
        shell.count(&inputs);
    }

    /// What kept the service from opening.
    pub(crate) fn failure(self, otherwise: &str) -> StartError {
        let unknown = || StartError::system("opening the service", otherwise);
        self.failure.unwrap_or_else(unknown)
    }

    /// What ends the process, if anything does.
    pub(crate) fn take_failure(&mut self) -> Result<(), StartError> {
        self.failure.take().map_or(Ok(()), Err)
    }

    /// True when the robot is stopped, by odometry.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.odometry.history().is_at_rest()
    }
}

/// The shell and the ports during one callback.
#[derive(Debug)]
pub struct Context<'a> {
    shell: &'a mut Shell,
    state: &'a mut State,
}

impl core::fmt::Debug for State {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let (readers, writers) = (self.readers.len(), self.writers.len());
        write!(f, "{readers} readers, {writers} writers")
    }
}

impl<'a> Context<'a> {
    pub(crate) fn new(shell: &'a mut Shell, state: &'a mut State) -> Self {
        Self { shell, state }
    }

    /// Number of what was opened; -1 when that failed, and the first failure is kept.
    fn opened(&mut self, opened: Result<usize, StartError>) -> i32 {
        match opened {
            Ok(number) => i32::try_from(number).unwrap_or(-1),
            Err(error) => {
                self.state.failure.get_or_insert(error);
                -1
            }
        }
    }
}

/// The context of a callback.
///
/// # Safety
/// `context` is the pointer that the callback was given, and the callback has not returned.
unsafe fn of<'a>(context: *mut Context<'_>) -> &'a mut Context<'_> {
    // SAFETY: as the caller promises; callbacks run on one thread, one after the other.
    unsafe { &mut *context }
}

/// A slice that may be empty.
///
/// # Safety
/// `first` points to `len` bytes, or `len` is 0.
unsafe fn bytes<'a>(first: *const c_void, len: usize) -> &'a [u8] {
    if len == 0 || first.is_null() {
        return &[];
    }
    // SAFETY: as the caller promises.
    unsafe { core::slice::from_raw_parts(first.cast(), len) }
}

/// How the run keeps time, and what launch asks.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct RunState {
    /// Run time from tick to tick. [ns]
    pub tick_ns: u64,
    /// Newest tick that was answered.
    pub answered_tick: u64,
    /// 1 in lockstep.
    pub lockstep: u8,
    /// 1 when the robot shall stop.
    pub stopping: u8,
    /// 1 when there are zones.
    pub zones: u8,
}

/// Newest odometry.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct Newest {
    /// Identity; 0 before the first message.
    pub id: u64,
    /// Tick.
    pub tick: u64,
    /// Run time. [ns]
    pub run_ns: u64,
    /// When it came in. [ns]
    pub came_ns: u64,
    /// The message.
    pub odometry: Odometry,
}

/// The answer that was begun.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Begun {
    /// Tick that is answered.
    pub tick: u64,
    /// Run time of it. [ns]
    pub run_ns: u64,
    /// When all inputs were taken in. [ns]
    pub started_ns: u64,
}

/// Opens the reader of a topic; its number, or -1.
///
/// # Safety
/// `context` is that of the running callback.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_reader(context: *mut Context<'_>, topic: usize) -> i32 {
    // SAFETY: as the caller promises.
    let context = unsafe { of(context) };
    let reader = ports::reader(context.shell.peer(), topic).map(|reader| {
        context.state.readers.push(reader);
        context.state.readers.len() - 1
    });
    context.opened(reader)
}

/// Opens the writer of a topic with slices of up to `len` items; its number, or -1.
///
/// # Safety
/// `context` is that of the running callback.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_writer(
    context: *mut Context<'_>,
    topic: usize,
    len: usize,
) -> i32 {
    // SAFETY: as the caller promises.
    let context = unsafe { of(context) };
    let writer = ports::writer(context.shell.peer(), topic, len).map(|writer| {
        context.state.writers.push(writer);
        context.state.writers.len() - 1
    });
    context.opened(writer)
}

/// Ends the process after the callback as a crash, for the reason `why`.
///
/// # Safety
/// `context` is that of the running callback, `why` a text that ends with 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_fail(context: *mut Context<'_>, why: *const c_char) {
    // SAFETY: as the caller promises.
    let (context, why) = unsafe { (of(context), CStr::from_ptr(why)) };
    let error = StartError::system("the service failed", why.to_string_lossy());
    context.state.failure.get_or_insert(error);
}

/// How the run keeps time, and what launch asks.
///
/// # Safety
/// `context` is that of the running callback.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_run_state(context: *mut Context<'_>) -> RunState {
    // SAFETY: as the caller promises.
    let shell = unsafe { of(context) }.shell as &Shell;
    let roster = shell.roster();
    RunState {
        tick_ns: roster.clock.tick_ns,
        answered_tick: shell.answered_tick(),
        lockstep: u8::from(roster.lockstep()),
        stopping: u8::from(roster.control.stopping == 1),
        zones: u8::from(roster.control.zones != 0),
    }
}

/// True when an answer to `tick` waits for that of `role`, which has answered up to `spoken_tick`.
///
/// # Safety
/// `context` is that of the running callback.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_awaits(
    context: *mut Context<'_>,
    role: u16,
    tick: u64,
    spoken_tick: u64,
) -> bool {
    // SAFETY: as the caller promises.
    let roster = unsafe { of(context) }.shell.roster();
    Role::from_code(role).is_some_and(|role| roster.awaits(role, tick, spoken_tick))
}

/// Newest odometry; it was taken in before the callback.
///
/// # Safety
/// `context` is that of the running callback.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_newest(context: *mut Context<'_>) -> Newest {
    // SAFETY: as the caller promises.
    let newest = unsafe { of(context) }.state.odometry.newest();
    newest.map_or_else(Newest::default, |newest| Newest {
        id: newest.id.0,
        tick: newest.tick,
        run_ns: newest.run_ns,
        came_ns: newest.came_ns,
        odometry: newest.odometry,
    })
}

/// `odom_from_base` at a run time of the last second; false when that is not known.
///
/// # Safety
/// `context` is that of the running callback, `pose` a place to write to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_pose_at(
    context: *mut Context<'_>,
    run_ns: u64,
    pose: *mut Pose,
) -> bool {
    // SAFETY: as the caller promises.
    let history = unsafe { of(context) }.state.odometry.history();
    let Some(found) = history.pose_at(run_ns) else {
        return false;
    };
    // SAFETY: as the caller promises.
    unsafe { pose.write(found) };
    true
}

/// Takes in what has come; true when there is a newer message than before.
///
/// # Safety
/// `context` is that of the running callback.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_poll(context: *mut Context<'_>, reader: usize) -> bool {
    // SAFETY: as the caller promises.
    let Context { shell, state } = unsafe { of(context) };
    let reader = state.readers.get_mut(reader);
    reader.is_some_and(|reader| reader.poll(shell.roster()))
}

/// The newest message; false before the first.
///
/// # Safety
/// `context` is that of the running callback, `view` a place to write to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_get(
    context: *mut Context<'_>,
    reader: usize,
    view: *mut RawView,
) -> bool {
    // SAFETY: as the caller promises.
    let state = &unsafe { of(context) }.state;
    let Some(found) = state.readers.get(reader).and_then(|reader| reader.get()) else {
        return false;
    };
    // SAFETY: as the caller promises.
    unsafe { view.write(found) };
    true
}

/// Tick up to which the writer of a reader's topic has answered.
///
/// # Safety
/// `context` is that of the running callback.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_spoken_tick(context: *mut Context<'_>, reader: usize) -> u64 {
    // SAFETY: as the caller promises.
    let state = &unsafe { of(context) }.state;
    let reader = state.readers.get(reader);
    reader.map_or(0, |reader| reader.spoken_tick())
}

/// The answers that are due, at most two, as ticks; a tick of 0 is the idle output. An incomplete
/// answer is due at `deadline_ns` of the monotonic clock, 0 = never.
///
/// # Safety
/// `context` is that of the running callback, `ticks` a place for two numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_due(
    context: *mut Context<'_>,
    tick: u64,
    complete: bool,
    deadline_ns: u64,
    news: bool,
    ticks: *mut u64,
) -> usize {
    // SAFETY: as the caller promises.
    let Context { shell, state } = unsafe { of(context) };
    let trigger = Trigger {
        tick,
        complete,
        deadline_ns: (deadline_ns > 0).then_some(deadline_ns),
        news,
    };
    state.dues = shell.due(&trigger).take(2).collect();
    for (index, due) in state.dues.iter().enumerate() {
        // SAFETY: there are at most two, as the caller promises.
        unsafe { ticks.add(index).write(due.tick) };
    }
    state.dues.len()
}

/// Begins the answer to one of the ticks that are due; false when it is not.
///
/// # Safety
/// `context` is that of the running callback, `parents` points to one, `begun` to a place to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_begin(
    context: *mut Context<'_>,
    tick: u64,
    capture_ns: u64,
    parents: *const Parents,
    begun: *mut Begun,
) -> bool {
    // SAFETY: as the caller promises.
    let (Context { shell, state }, parents) = unsafe { (of(context), parents.read()) };
    let Some(place) = state.dues.iter().position(|due| due.tick == tick) else {
        return false;
    };
    let due = state.dues.remove(place);
    let draft = shell.begin(due, shell.run_ns(tick), capture_ns, parents);
    // SAFETY: as the caller promises.
    unsafe {
        begun.write(Begun {
            tick,
            run_ns: draft.run_ns,
            started_ns: draft.started_ns,
        });
    };
    (state.draft, state.sent) = (Some(draft), None);
    true
}

/// Sends a message of the answer that was begun: `meta_bytes` of fixed fields, `item_bytes` of items.
/// The first one is its main message. False when it was dropped.
///
/// # Safety
/// `context` is that of the running callback, `meta` and `items` point to as many bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_send(
    context: *mut Context<'_>,
    writer: usize,
    meta: *const c_void,
    meta_bytes: usize,
    items: *const c_void,
    item_bytes: usize,
) -> bool {
    // SAFETY: as the caller promises.
    let Context { shell, state } = unsafe { of(context) };
    // SAFETY: as the caller promises.
    let (meta, items) = unsafe { (bytes(meta, meta_bytes), bytes(items, item_bytes)) };
    let (Some(draft), Some(writer)) = (&state.draft, state.writers.get_mut(writer)) else {
        return false;
    };
    let sent = writer.send(shell, draft, meta, items);
    state.sent = state.sent.or(sent);
    sent.is_some()
}

/// Ends the answer: rings, and leaves its record with the `work` done.
///
/// # Safety
/// `context` is that of the running callback.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_finish(context: *mut Context<'_>, work: u64) {
    // SAFETY: as the caller promises.
    let Context { shell, state } = unsafe { of(context) };
    if let Some(draft) = state.draft.take() {
        shell.finish(&draft, state.sent.take(), work);
    }
}

/// Brings the last message of a latched topic to readers that joined since.
///
/// # Safety
/// `context` is that of the running callback.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_refresh(context: *mut Context<'_>, writer: usize) {
    // SAFETY: as the caller promises.
    let state = &unsafe { of(context) }.state;
    if let Some(writer) = state.writers.get(writer) {
        writer.refresh();
    }
}

/// Sets or clears a reason in the heartbeat.
///
/// # Safety
/// `context` is that of the running callback.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn zeronav_reason(context: *mut Context<'_>, bit: u32, holds: bool) {
    // SAFETY: as the caller promises.
    unsafe { of(context) }.shell.reason(bit, holds);
}
