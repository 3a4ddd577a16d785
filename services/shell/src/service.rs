//! The loop that every service shares.

use crate::clock::{now_ns, thread_cpu_ns};
use crate::domain::Domain;
use crate::doorbell::{Bells, Doorbell, Rung, WAKE_AT_LEAST_NS};
use crate::error::{EXIT_STOPPED, EXIT_USAGE, StartError};
use crate::flags::{Flags, one_line};
use crate::leaving::Leaving;
use crate::peer::Peer;
use crate::printable::printable;
use crate::records::SpanWriter;
use crate::roster::{Roster, RosterReader};
use crate::seat::{self, SeatLock};
use crate::signals;
use crate::turn::{self, Trigger, Turn};
use crate::writer::{Draft, Sent, Writer};
use clap::Parser;
use core::num::NonZeroU64;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io::Write;
use std::os::unix::net::UnixStream;
use std::process::ExitCode;
use std::time::Duration;
use zeronav_msgs::header::Parents;
use zeronav_msgs::health::{Health, HealthState, REASON_NO_LOAN, REASON_REFUSED, REASON_TOO_LONG};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::Seat;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::topics::{HealthTopic, SPANS, Topic, TopicRow, health_of};
use zeronav_params::Parameter;

/// Time between two heartbeats when nothing changes. [ns]
const BEAT_NS: u64 = 20_000_000;

/// What a service is to the shell.
pub trait Service: Sized {
    /// The seat it takes.
    const ROLE: Role;
    /// Its configuration, TOML; an empty file gives the defaults.
    type Config: Serialize + DeserializeOwned;

    /// The algorithms that the configuration can name: key and one line for people.
    #[must_use]
    fn algorithms() -> Vec<(&'static str, String)> {
        Vec::new()
    }

    /// The parameters of its configuration, printed by `--print-params`.
    #[must_use]
    fn parameters() -> Vec<Parameter> {
        Vec::new()
    }

    /// Accepts configurations that it can work with, as far as that is known without a run: asked
    /// by `--print-config`, and before [`Self::open`].
    ///
    /// # Errors
    /// [`StartError::config`], naming the field.
    fn check(_config: &Self::Config) -> Result<(), StartError> {
        Ok(())
    }

    /// Opens the ports. Nothing is known yet about the run.
    ///
    /// # Errors
    /// What keeps the service from starting.
    fn open(shell: &mut Shell, config: Self::Config) -> Result<Self, StartError>;

    /// One wake: take in what has come, answer what is due, call [`Shell::finish`] per answer.
    /// Returns when it wants to be woken at the latest, in ns of the monotonic clock.
    ///
    /// # Errors
    /// What ends the process as a crash.
    fn wake(&mut self, shell: &mut Shell, rung: Rung) -> Result<Option<u64>, StartError>;

    /// Whether the robot stands, as far as this service knows. When launch is gone, a service
    /// between requests and wheels goes on until it does, or for 1.5 s.
    fn is_at_rest(&self) -> bool {
        false
    }
}

/// The common part of a running service.
#[derive(Debug)]
pub struct Shell {
    /// Held for life; a shadow has none.
    seat: Option<SeatLock>,
    peer: Peer,
    roster: RosterReader,
    doorbell: Doorbell,
    bells: Bells,
    spans: SpanWriter,
    health: Writer<HealthTopic>,
    beat: Health,
    beaten: Health,
    beaten_ns: u64,
    woken_ns: u64,
    /// Processor time of this thread at `woken_ns`. [ns]
    woken_cpu_ns: u64,
    rings: Vec<&'static TopicRow>,
    hash: u64,
    superseded_told: u64,
    idle_said: bool,
    answered_tick: u64,
    orphaned: bool,
}

/// What a finished cycle was; becomes a span.
#[derive(Debug, Clone, Copy)]
pub struct Cycle {
    /// What kind of answer it was.
    pub kind: SpanKind,
    /// What the answer says of itself.
    pub draft: Draft,
    /// Its main message.
    pub output: Option<Sent>,
    /// Work done in the role's own unit.
    pub work: u64,
}

impl Shell {
    fn open(flags: &Flags, role: Role, signals: UnixStream) -> Result<Self, StartError> {
        let root = flags
            .domain
            .as_ref()
            .ok_or_else(|| StartError::Usage("--domain is missing".to_owned()))?;
        let domain = Domain::join(root)?;
        let (seat, epoch) = match flags.epoch {
            Some(epoch) if !flags.shadow => (Some(SeatLock::take(&domain, role)?), epoch),
            _ => (None, seat::shadow_epoch()),
        };
        let peer = Peer::join(domain, role, epoch)?;
        let mut roster = RosterReader::open(&peer)?;
        if seat.as_ref().is_some_and(|seat| !seat.is_from_launch()) {
            roster.expects(role, epoch)?;
        }
        let row = health_of(role)
            .ok_or_else(|| StartError::Usage(format!("{role} is not the role of a service")))?;
        Ok(Self {
            seat,
            orphaned: false,
            roster,
            doorbell: Doorbell::open(&peer, signals)?,
            bells: Bells::open(&peer)?,
            spans: peer.span_writer()?,
            health: peer.writer_on(row, 1)?,
            beat: Health {
                pid: std::process::id(),
                ..Health::default()
            },
            beaten: Health::default(),
            beaten_ns: 0,
            woken_ns: now_ns(),
            woken_cpu_ns: thread_cpu_ns(),
            rings: Vec::with_capacity(8),
            hash: 0,
            superseded_told: 0,
            idle_said: false,
            answered_tick: 0,
            peer,
        })
    }

    /// Closes the own ports, then leaves the middleware.
    fn leave(self) -> Domain {
        let Self {
            peer,
            roster,
            doorbell,
            bells,
            spans,
            health,
            ..
        } = self;
        drop((roster, doorbell, bells, spans, health));
        peer.leave()
    }

    /// The membership, to open ports with.
    #[must_use]
    pub fn peer(&self) -> &Peer {
        &self.peer
    }

    /// Who is obeyed and how time runs.
    #[must_use]
    pub fn roster(&self) -> &Roster {
        self.roster.roster()
    }

    /// True when launch is gone: the robot comes to rest, whatever it is told.
    #[must_use]
    pub fn is_orphaned(&self) -> bool {
        self.orphaned
    }

    /// True when this process holds its seat; a shadow does not.
    pub(crate) fn is_obeyable(&self) -> bool {
        self.seat.is_some()
    }

    /// Behaves from now on as if launch had asked for a stop.
    pub(crate) fn come_to_rest(&mut self) {
        self.orphaned = true;
        self.roster.come_to_rest();
    }

    /// Moment of the return from the wait. [ns]
    #[must_use]
    pub fn woken_ns(&self) -> u64 {
        self.woken_ns
    }

    /// Reads `run/clock` and `run/control` again, in the middle of long work.
    pub fn poll_roster(&mut self) {
        self.roster.poll();
    }

    /// The answers that are due: first of all, once the clock is known, the idle output, then what
    /// `trigger` asks for. [`Self::finish`] notes them as given.
    pub fn turns(&self, trigger: &Trigger) -> impl Iterator<Item = Turn> + use<> {
        let roster = self.roster();
        let idle = (!self.idle_said).then_some(Turn::IDLE);
        let due = turn::due(roster, self.peer.role(), self.answered_tick, trigger);
        let turns = if roster.has_clock() {
            [idle, due]
        } else {
            [None, None]
        };
        turns.into_iter().flatten()
    }

    /// Begins an answer: all inputs are taken in. In lockstep, answers to ticks count for the
    /// run's hash. A delay that launch put into this seat is spent here, as if the work took longer.
    #[must_use]
    pub fn draft(&self, tick: u64, run_ns: u64, capture_ns: u64, parents: Parents) -> Draft {
        let draft = Draft {
            tick,
            run_ns,
            capture_ns,
            parents,
            woken_ns: self.woken_ns,
            started_ns: now_ns(),
            raw_ns: 0,
            hashed: tick > 0 && self.roster().lockstep(),
        };
        let seat = self.roster().seat(self.peer.role());
        if let Some(delay_ns) = seat.map(Seat::delay_ns).filter(|ns| *ns > 0 && tick > 0) {
            std::thread::sleep(Duration::from_nanos(delay_ns));
        }
        draft
    }

    /// Notes a sent message: whom to ring for it, and its share of the cycle's hash.
    pub fn sent<T: Topic>(&mut self, writer: &Writer<T>, sent: Option<Sent>) -> Option<Sent> {
        match sent {
            Some(sent) => {
                self.hash = self.hash.wrapping_mul(0x0000_0100_0000_01b3) ^ sent.hash;
                self.rings.push(writer.row());
            }
            None if writer.too_long() > 0 => self.reason(REASON_TOO_LONG, true),
            None => self.reason(REASON_NO_LOAN, true),
        }
        sent
    }

    /// Answers with one message and no more: sends it and ends the answer. `None` as
    /// [`Writer::publish`].
    pub fn answer<T: Topic>(
        &mut self,
        kind: SpanKind,
        draft: &Draft,
        writer: &mut Writer<T>,
        meta: T::Meta,
        items: &[T::Item],
    ) -> Option<Sent> {
        let sent = writer.publish(draft, meta, items);
        let output = self.sent(writer, sent);
        self.finish(&Cycle {
            kind,
            draft: *draft,
            output,
            work: 0,
        });
        output
    }

    /// Rings for everything sent since the last time. [`Self::finish`] does it, too.
    pub fn ring(&mut self) {
        let lockstep = self.roster().lockstep();
        for row in self.rings.drain(..) {
            let more: &[Role] = if lockstep { row.rings_in_lockstep } else { &[] };
            for role in row.rings.iter().chain(more) {
                self.bells.ring(*role, row.number);
            }
        }
    }

    /// Rings `role` with an event that belongs to no message.
    pub fn ring_event(&self, role: Role, event: usize) {
        self.bells.ring(role, event);
    }

    /// Ends an answer: rings, then leaves the span. With its first output the service is ready.
    pub fn finish(&mut self, cycle: &Cycle) {
        self.ring();
        match cycle.kind {
            SpanKind::Idle if cycle.output.is_some() => {
                self.idle_said = true;
                self.ready();
            }
            SpanKind::Answer => self.answered_tick = self.answered_tick.max(cycle.draft.tick),
            _ => {}
        }
        let draft = &cycle.draft;
        let Parents {
            odometry,
            scan,
            map,
            path,
            request,
            goal,
        } = draft.parents;
        self.spans.write(Span {
            role: self.peer.role().code(),
            kind: cycle.kind.code(),
            epoch: self.peer.epoch(),
            tick: draft.tick,
            odometry,
            scan,
            map,
            path,
            request,
            goal,
            output: cycle.output.map_or(0, |sent| sent.id.0),
            capture_ns: draft.capture_ns,
            woken_ns: draft.woken_ns,
            started_ns: draft.started_ns,
            published_ns: cycle.output.map_or(0, |sent| sent.published_ns),
            superseded: u32::try_from(self.beat.superseded - self.superseded_told)
                .unwrap_or(u32::MAX),
            work: u32::try_from(cycle.work).unwrap_or(u32::MAX),
            hash: core::mem::take(&mut self.hash),
            off_processor_ns: self.off_processor_ns(),
            raw_ns: draft.raw_ns,
        });
        self.superseded_told = self.beat.superseded;
        if self.roster().lockstep() {
            for role in SPANS.rings_in_lockstep {
                self.bells.ring(*role, SPANS.number);
            }
        }
    }

    /// Time since the wake in which this thread did not run. [ns]
    fn off_processor_ns(&self) -> u64 {
        let ran_ns = thread_cpu_ns().saturating_sub(self.woken_cpu_ns);
        now_ns()
            .saturating_sub(self.woken_ns)
            .saturating_sub(ran_ns)
    }

    /// Sets or clears a reason in the heartbeat.
    pub fn reason(&mut self, bit: u32, holds: bool) {
        if holds {
            self.beat.reasons |= bit;
        } else {
            self.beat.reasons &= !bit;
        }
    }

    /// Totals since the start, for heartbeat and spans: messages refused, inputs overtaken.
    pub fn totals(&mut self, refused: u64, superseded: u64) {
        self.reason(REASON_REFUSED, refused > self.beaten.refused);
        self.beat.refused = refused;
        self.beat.superseded = self.beat.superseded.max(superseded);
    }

    /// Run time that was lost because the process was late, for the heartbeat. [ns]
    pub fn slipped(&mut self, slipped_ns: u64) {
        self.beat.slipped_ns = slipped_ns;
    }

    /// Says that long work goes on. Cheap enough for every thousand steps.
    pub fn progress(&mut self) {
        self.beat.progress += 1;
        self.publish_beat(now_ns());
    }

    /// True once the service has answered for the first time.
    pub fn ready(&mut self) {
        if self.beat.state == HealthState::Starting.code() {
            self.beat.state = HealthState::Ready.code();
        }
    }

    fn publish_beat(&mut self, now_ns: u64) {
        let mut beat = self.beat;
        if beat.state == HealthState::Ready.code() && beat.reasons != 0 {
            beat.state = HealthState::Degraded.code();
        }
        let changed = beat.state != self.beaten.state || beat.reasons != self.beaten.reasons;
        if !changed && now_ns.saturating_sub(self.beaten_ns) < BEAT_NS {
            return;
        }
        let draft = Draft {
            woken_ns: self.woken_ns,
            started_ns: now_ns,
            ..Draft::default()
        };
        if self.health.publish(&draft, beat, &[]).is_some() {
            self.beaten = beat;
            self.beaten_ns = now_ns;
            self.beat.reasons &= !REASON_NO_LOAN;
        }
    }
}

/// `main` of a service: flags, configuration, ports, loop, exit code.
#[must_use]
pub fn run<S: Service>() -> ExitCode {
    let flags = match Flags::try_parse() {
        Ok(flags) => flags,
        Err(error) => {
            if error.use_stderr() {
                complain(&one_line(&error));
                return ExitCode::from(EXIT_USAGE);
            }
            let _ = error.print();
            return ExitCode::from(EXIT_STOPPED);
        }
    };
    crate::logs::start(&flags.log_level);
    match drive::<S>(&flags) {
        Ok(()) => ExitCode::from(EXIT_STOPPED),
        Err(error) if flags.print_config => {
            complain(&error.to_string());
            error.exit_code()
        }
        Err(error) => {
            tracing::error!(role = %S::ROLE, "{error}");
            error.exit_code()
        }
    }
}

fn drive<S: Service>(flags: &Flags) -> Result<(), StartError> {
    if flags.list {
        for (key, line) in S::algorithms() {
            print(&format!("{key}\t{line}\n"))?;
        }
        return Ok(());
    }
    if flags.print_params {
        let text = serde_json::to_string_pretty(&S::parameters())
            .map_err(|error| StartError::system("writing the parameters as JSON", error))?;
        return print(&format!("{text}\n"));
    }
    let config: S::Config = flags.read_config(S::check)?;
    if flags.print_config {
        return print(&Flags::config_text(&config)?);
    }
    let (stop, signals) = signals::catch()?;
    // The default slack of 50 us would be the largest part of every wait.
    if let Some(one) = NonZeroU64::new(1) {
        let _ = rustix::thread::set_current_timer_slack(Some(one));
    }
    let mut shell = Shell::open(flags, S::ROLE, signals)?;
    let mut service = S::open(&mut shell, config)?;
    let mut leaving = Leaving::new(stop);
    let mut deadline_ns = 0;
    loop {
        let rung = shell.doorbell.wait(deadline_ns);
        shell.woken_ns = now_ns();
        shell.woken_cpu_ns = thread_cpu_ns();
        shell.roster.poll();
        if leaving.look::<S>(&mut shell) {
            break;
        }
        shell.beat.progress += 1;
        // Whoever does not know yet who is obeyed would not believe anybody, and what comes on a
        // stream meanwhile would be gone.
        let wanted = if shell.roster().is_known() {
            service.wake(&mut shell, rung)?
        } else {
            None
        };
        shell.ring();
        let now = now_ns();
        shell.publish_beat(now);
        if leaving.rests(&shell, &service) {
            break;
        }
        deadline_ns = (wanted.unwrap_or(u64::MAX))
            .min(now + WAKE_AT_LEAST_NS)
            .min(leaving.deadline_ns());
    }
    shell.beat.state = HealthState::Stopping.code();
    shell.publish_beat(now_ns());
    if !leaving.is_orphaned() {
        tracing::debug!(role = %S::ROLE, "asked to stop");
        return Ok(());
    }
    // Ports first. Nobody else is there any more to remove what is left of the run.
    drop(service);
    let domain = shell.leave();
    let root = domain.root().to_owned();
    if let Err(error) = domain.close() {
        tracing::warn!(root = %root.display(), %error, "the domain could not be removed");
    }
    Ok(())
}

/// `--print-config` and `--list` are data for the caller.
fn print(text: &str) -> Result<(), StartError> {
    let mut output = std::io::stdout().lock();
    output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush())
        .map_err(|error| StartError::system("writing to standard output", error))
}

/// One line on standard error.
fn complain(problem: &str) {
    let _ = writeln!(std::io::stderr(), "{}", printable(problem));
}
