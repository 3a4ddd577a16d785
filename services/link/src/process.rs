//! The link's process: one look takes in what has come, from here and from there, and hands it on.

use crate::clock_offset::{ClockFilter, Exchange, Offset};
use crate::config::LinkConfig;
use crate::frame::{Beat, Frame, decode};
use crate::lanes::{Lanes, rung};
use crate::seats::Hearts;
use crate::session::Session;
use crate::socket::{Sitter, Socket};
use std::time::{Duration, Instant};
use zeronav_msgs::message::{FNV_OFFSET, fnv1a};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::topics::{EVENT_NEED_KEYFRAME, TopicRow, health_of, topics};
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::{Bells, Overheard, Rung};
use zeronav_shell::{Companion, Guest, StartError};

/// Longest wait of a look: topics that ring nobody are looked at as often.
const WAIT: Duration = Duration::from_millis(4);

/// Time between two beats. [ns]
const BEAT_NS: u64 = 50_000_000;

/// Time between two looks at who reads what here, and at latched topics. [ns]
const READS_NS: u64 = 200_000_000;

/// Frames of the other host that one look takes in.
const FRAMES_MAX: usize = 256;

/// For how long the other end may be silent before it counts as gone. [ns]
const GONE_NS: u64 = 1_000_000_000;

/// For how long the host of launch may be silent before another run takes the place of its run. [ns]
const ABANDONED_NS: u64 = 3_000_000_000;

/// For how long messages that find no memory are tried again: in lockstep nothing may be lost.
const HELD_LIMIT: Duration = Duration::from_secs(10);
const HELD_PAUSE: Duration = Duration::from_micros(200);

/// What is known of the other host.
#[derive(Debug, Default)]
struct Other {
    /// The newest beat, and when it came. [ns]
    beat: Option<Beat>,
    came_ns: u64,
    /// Number of the newest frame, and how many were lost.
    number: u64,
    lost: u64,
    is_there: bool,
}

/// See the module's description.
#[derive(Debug)]
pub struct Link {
    config: LinkConfig,
    contract: u64,
    /// Name of the run, once it is known.
    run: String,
    /// The run of the host of launch is over, or it has begun another one.
    over: bool,
    bells: Bells,
    overheard: Overheard,
    session: Session,
    socket: Socket,
    lanes: Lanes,
    hearts: Hearts,
    clock: ClockFilter,
    other: Other,
    lockstep: bool,
    /// Frames that were sent.
    number: u64,
    beaten_ns: u64,
    looked_ns: u64,
    reads: u64,
    said: Beat,
    /// What was complained about last.
    complaint: String,
}

impl Companion for Link {
    type Config = LinkConfig;
    // A look waits for rings itself.
    const PAUSE: Duration = Duration::ZERO;
    // Commands go through it.
    const NICER: i32 = 0;
    // On one of the hosts it is the link that brings what launch says.
    const AWAITS_LAUNCH: bool = false;

    fn check(config: &LinkConfig) -> Result<(), StartError> {
        config.check()
    }

    fn open(guest: &Guest, config: LinkConfig) -> Result<Self, StartError> {
        let peer = guest.peer();
        let overheard = Overheard::open(peer, &config.there())?;
        let waker = overheard.waker();
        let waker = waker.map_err(|error| StartError::system("making a waker", error))?;
        let root = peer.domain().root().file_name().unwrap_or_default();
        let run = if config.commands {
            root.to_string_lossy().into_owned()
        } else {
            String::new()
        };
        Ok(Self {
            contract: contract(),
            run,
            over: false,
            bells: Bells::open(peer)?,
            overheard,
            session: Session::open(&config, waker)?,
            socket: Socket::open(peer.domain().folder())?,
            lanes: Lanes::default(),
            hearts: Hearts::default(),
            clock: ClockFilter::default(),
            other: Other::default(),
            lockstep: false,
            number: 0,
            beaten_ns: 0,
            looked_ns: 0,
            reads: 0,
            said: Beat::default(),
            complaint: String::new(),
            config,
        })
    }

    fn look(&mut self, guest: &Guest) -> Result<(), StartError> {
        let rings = self.overheard.wait(WAIT);
        self.lockstep = guest.roster().clock.mode == RunMode::Lockstep.code();
        self.socket.poll();
        let sitters = self.socket.sitters();
        self.hearts.keep(&sitters);
        for _ in 0..FRAMES_MAX {
            let Some(bytes) = self.session.inbox.take() else {
                break;
            };
            self.receive(guest, &sitters, &bytes)?;
        }
        let now_ns = now_ns();
        self.see_other(now_ns);
        for (row, parts) in self.hearts.due(&sitters, !self.other.is_there, now_ns) {
            let number = u8::try_from(row.number).unwrap_or(u8::MAX);
            if let Some(lane) = self.lanes.lane(number) {
                lane.write(guest.peer(), &parts)?;
            }
        }
        self.send(guest, &rings, now_ns)?;
        self.beat(&sitters, now_ns);
        Ok(())
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        let beat = Beat {
            leaving: true,
            sent_ns: now_ns(),
            ..self.said.clone()
        };
        self.number += 1;
        let frame = Frame::Beat(Box::new(beat)).encode(self.number);
        self.session.outbox.push(frame);
    }
}

impl Link {
    /// The offset of the other clock, as well as it is known.
    fn offset(&self) -> Option<Offset> {
        self.clock.offset(now_ns())
    }

    fn receive(
        &mut self,
        guest: &Guest,
        sitters: &[Sitter],
        bytes: &[u8],
    ) -> Result<(), StartError> {
        let (number, frame) = match decode(bytes) {
            Ok(read) => read,
            Err(error) => {
                tracing::warn!(%error, "rejected");
                return Ok(());
            }
        };
        // A link that was started again begins anew, and what was sent before anybody listened is not lost.
        if self.other.is_there && number > self.other.number {
            self.other.lost += number - self.other.number - 1;
        }
        self.other.number = number;
        match frame {
            Frame::Beat(beat) => self.hear(*beat),
            Frame::Ring { role, event } if self.takes() => {
                if self.config.here().contains(&role) {
                    self.bells.ring(role, usize::from(event));
                }
            }
            Frame::Message {
                topic,
                envelope,
                items,
            } if self.takes() => self.write(guest, sitters, topic, envelope, items)?,
            Frame::Ring { .. } | Frame::Message { .. } => self.other.lost += 1,
        }
        Ok(())
    }

    /// True while messages of the other host belong to the run of this one.
    fn takes(&self) -> bool {
        let beat = self.other.beat.as_ref();
        let is_of_run = |beat: &Beat| beat.run == self.run && self.refusal(beat).is_none();
        !self.over && beat.is_some_and(is_of_run)
    }

    fn write(
        &mut self,
        guest: &Guest,
        sitters: &[Sitter],
        topic: u8,
        envelope: &[u8],
        items: &[u8],
    ) -> Result<(), StartError> {
        let Some(offset) = self.offset() else {
            self.other.lost += 1;
            return Ok(());
        };
        let Some(lane) = self.lanes.lane(topic) else {
            tracing::warn!(topic, "a topic that there is not");
            return Ok(());
        };
        let row = lane.row();
        let (author, parts) = match lane.accept(envelope, items, offset.ahead_ns) {
            Ok(accepted) => accepted,
            Err(refusal) => {
                tracing::warn!(topic = row.name, %refusal, "rejected");
                return Ok(());
            }
        };
        let parts = if is_heartbeat(row) {
            self.hearts.heard(author, sitters, parts, now_ns())
        } else {
            parts
        };
        let since = Instant::now();
        while !lane.write(guest.peer(), &parts)? {
            // In real time the next message is the better one.
            if !self.lockstep || since.elapsed() > HELD_LIMIT {
                self.other.lost += 1;
                break;
            }
            std::thread::sleep(HELD_PAUSE);
        }
        let here = self.config.here();
        for role in rung(row, self.lockstep).filter(|role| here.contains(role)) {
            self.bells.ring(role, row.number);
        }
        Ok(())
    }

    fn hear(&mut self, beat: Beat) {
        let came_ns = now_ns();
        // A second robot's host waits until this run is over.
        if self.is_busy_with_another(&beat, came_ns) {
            return;
        }
        if beat.echo_sent_ns != 0 {
            self.clock.add(Exchange {
                sent_ns: beat.echo_sent_ns,
                came_there_ns: beat.echo_received_ns,
                sent_there_ns: beat.sent_ns,
                came_ns,
            });
        }
        if let Some(refusal) = self.refusal(&beat) {
            self.complain(refusal);
        } else {
            self.complaint.clear();
            if self.config.commands {
                self.socket.ended(&beat.held);
            } else if self.run.is_empty() {
                tracing::info!(run = beat.run, from = beat.host, "takes part");
                self.run.clone_from(&beat.run);
            }
        }
        let is_of_another = !self.config.commands && !self.run.is_empty() && self.run != beat.run;
        if !self.config.commands && (beat.leaving && !self.run.is_empty() || is_of_another) {
            self.over = true;
        }
        if beat.leaving {
            self.other.is_there = false;
            self.lanes.restart();
        }
        self.other.came_ns = came_ns;
        self.other.beat = Some(beat);
    }

    /// True on a host that takes part in a run which goes on, when `beat` is of another one.
    fn is_busy_with_another(&self, beat: &Beat, now_ns: u64) -> bool {
        !self.config.commands
            && !self.run.is_empty()
            && beat.run != self.run
            && now_ns.saturating_sub(self.other.came_ns) < ABANDONED_NS
    }

    /// Why the other host cannot take part; `None` when it can.
    fn refusal(&self, beat: &Beat) -> Option<String> {
        let other = &self.config.other;
        if beat.host != *other {
            return Some(format!("`{}` answers in the place of `{other}`", beat.host));
        }
        if beat.contract != self.contract {
            return Some(format!("{other} was built from another contract"));
        }
        let is_elsewhere = !beat.run.is_empty() && beat.run != self.run;
        if self.config.commands && is_elsewhere {
            return Some(format!("{other} takes part in another run, {}", beat.run));
        }
        if beat.scenario != self.config.scenario {
            return Some(format!("{other} has another scenario than this host"));
        }
        None
    }

    fn complain(&mut self, refusal: String) {
        if self.complaint != refusal {
            tracing::error!("{refusal}");
            self.complaint = refusal;
        }
    }

    /// Says when the other host comes and goes.
    fn see_other(&mut self, now_ns: u64) {
        let is_there = self.other.beat.as_ref().is_some_and(|beat| !beat.leaving)
            && now_ns.saturating_sub(self.other.came_ns) < GONE_NS;
        if is_there == self.other.is_there {
            return;
        }
        self.other.is_there = is_there;
        let other = &self.config.other;
        if is_there {
            tracing::info!(other, "is there");
        } else {
            tracing::warn!(other, "is silent");
            // What is latched is sent again once it is there again.
            self.lanes.restart();
        }
    }

    fn send(
        &mut self,
        guest: &Guest,
        rings: &[(Role, Rung)],
        now_ns: u64,
    ) -> Result<(), StartError> {
        let beat = self.other.beat.as_ref();
        let is_known = self.other.is_there && self.takes();
        let wanted = beat.filter(|beat| is_known && beat.synchronised);
        let bits = wanted.map_or(0, |beat| beat.reads);
        self.lanes.listen(guest.peer(), bits)?;
        let (outbox, number) = (&self.session.outbox, &mut self.number);
        let mut push = |frame: Frame<'_>| {
            *number += 1;
            outbox.push(frame.encode(*number));
        };
        // Without any room everything stays where the newest message wins.
        if outbox.has_room() {
            self.lanes.take(
                || outbox.has_room(),
                |topic, (envelope, items)| {
                    push(Frame::Message {
                        topic,
                        envelope: &envelope,
                        items: &items,
                    });
                },
            );
        }
        // Topics ring on the other host by themselves.
        for (role, rung) in rings.iter().filter(|_| bits != 0) {
            if rung.has(EVENT_NEED_KEYFRAME) {
                let event = u8::try_from(EVENT_NEED_KEYFRAME).unwrap_or(u8::MAX);
                push(Frame::Ring { role: *role, event });
            }
        }
        if now_ns.saturating_sub(self.looked_ns) > READS_NS {
            self.looked_ns = now_ns;
            self.reads = self.lanes.read(guest.peer());
            self.lanes.refresh();
        }
        Ok(())
    }

    fn beat(&mut self, sitters: &[Sitter], now_ns: u64) {
        let wanted = self.other.beat.as_ref().filter(|_| self.takes());
        let wanted = wanted.map_or(&[][..], |beat| &beat.wanted);
        self.socket.want(&self.run, wanted, self.over);
        let came = self.other.beat.as_ref();
        let beat = Beat {
            contract: self.contract,
            host: self.config.host.clone(),
            run: self.run.clone(),
            scenario: self.config.scenario.clone(),
            leaving: false,
            synchronised: self.offset().is_some(),
            sent_ns: 0,
            echo_sent_ns: 0,
            echo_received_ns: 0,
            reads: self.reads,
            lost: self.other.lost,
            wanted: sitters.iter().map(|sitter| sitter.seat).collect(),
            held: self.socket.held(),
        };
        if beat == self.said && now_ns.saturating_sub(self.beaten_ns) < BEAT_NS {
            return;
        }
        // A queue without room would make the way of the beat longer than that of any other.
        if !self.session.outbox.has_room() {
            return;
        }
        self.said = beat.clone();
        self.beaten_ns = now_ns;
        let beat = Beat {
            sent_ns: zeronav_shell::clock::now_ns(),
            echo_sent_ns: came.map_or(0, |came| came.sent_ns),
            echo_received_ns: came.map_or(0, |_| self.other.came_ns),
            ..beat
        };
        self.number += 1;
        let frame = Frame::Beat(Box::new(beat)).encode(self.number);
        self.session.outbox.push(frame);
    }
}

/// True for the heartbeat of a service.
fn is_heartbeat(row: &TopicRow) -> bool {
    let of_role = |role: &Role| health_of(*role).is_some_and(|own| own.number == row.number);
    Role::SERVICES.iter().any(of_role)
}

/// A hash of all topics' schemas.
fn contract() -> u64 {
    let schemas = topics().into_iter().map(|row| row.schema.to_le_bytes());
    schemas.fold(FNV_OFFSET, |hash, schema| fnv1a(hash, &schema))
}
