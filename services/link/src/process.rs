//! The link's process: one look takes in what has come, from here and from there, and hands it on.

use crate::account::Account;
use crate::config::LinkConfig;
use crate::frame::{Beat, Frame, Origin, decode};
use crate::lanes::{Lanes, read_by, rung};
use crate::other::{Heard, Other, Own};
use crate::seats::Hearts;
use crate::session::Session;
use crate::socket::{Sitter, Socket};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};
use zeronav_msgs::message::{FNV_OFFSET, fnv1a};
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::topics::{EVENT_NEED_KEYFRAME, TopicRow, health_of, topics};
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::{Bells, Overheard, Rung};
use zeronav_shell::printable::printable;
use zeronav_shell::{Companion, Guest, StartError};

/// Longest wait of a look: topics that ring nobody are looked at as often.
const WAIT: Duration = Duration::from_millis(4);

/// Time between two beats. [ns]
const BEAT_NS: u64 = 50_000_000;

/// Time between two looks at who reads what here, and between two repetitions of what is latched. [ns]
const READS_NS: u64 = 1_000_000_000;

/// Frames of the other host that one look takes in.
const FRAMES_MAX: usize = 256;

/// Complaints that are remembered, so that each is made once.
const COMPLAINTS_MAX: usize = 64;

/// Exit code of processes on a host that was started again.
const LOST: u8 = 1;

/// For how long messages that find no memory are tried again: in lockstep nothing may be lost, but the other end counts
/// this one as gone after 4 s in which it takes nothing in.
const HELD_LIMIT: Duration = Duration::from_secs(3);
const HELD_PAUSE: Duration = Duration::from_micros(200);

/// See the module's description.
#[derive(Debug)]
pub struct Link {
    own: Own,
    /// The seats on this host, and who writes on the other one.
    here: Vec<Role>,
    authors: Vec<Role>,
    bells: Bells,
    overheard: Overheard,
    session: Session,
    socket: Socket,
    lanes: Lanes,
    hearts: Hearts,
    other: Other,
    account: Account,
    was_there: bool,
    lockstep: bool,
    /// It cannot go on, and is to be started again.
    has_failed: bool,
    /// The newest frame that was sent.
    origin: Origin,
    beaten_ns: u64,
    /// When it was looked at who reads what, and when what is latched was repeated. [ns]
    looked_ns: u64,
    repeated_ns: u64,
    reads: u64,
    said: Beat,
    complaints: BTreeSet<String>,
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
        let mut lanes = Lanes::default();
        lanes.listen(peer, read_by(&config.there()))?;
        let root = peer.domain().root().file_name().unwrap_or_default();
        let mut authors = config.there();
        if !config.commands {
            authors.push(Role::Launch);
        }
        Ok(Self {
            bells: Bells::open(peer)?,
            overheard,
            session: Session::open(&config, waker)?,
            socket: Socket::open(peer.domain().folder())?,
            lanes,
            hearts: Hearts::default(),
            other: Other::default(),
            account: Account::new(&config.other, now_ns()),
            was_there: false,
            lockstep: false,
            has_failed: false,
            origin: Origin {
                sender: now_ns(),
                number: 0,
            },
            beaten_ns: 0,
            looked_ns: 0,
            repeated_ns: 0,
            reads: 0,
            said: Beat::default(),
            complaints: BTreeSet::new(),
            here: config.here(),
            authors,
            own: Own {
                contract: contract(),
                host: config.host,
                other: config.other,
                scenario: config.scenario,
                instance: root.to_string_lossy().into_owned(),
                commands: config.commands,
            },
        })
    }

    fn look(&mut self, guest: &Guest) -> Result<(), StartError> {
        let looked = self.look_once(guest);
        self.has_failed = looked.is_err();
        looked
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        // One that fails is started again: the run goes on.
        if self.has_failed || std::thread::panicking() {
            return;
        }
        let beat = Beat {
            leaving: true,
            sent_ns: now_ns(),
            ..self.said.clone()
        };
        self.push(&Frame::Beat(Box::new(beat)));
    }
}

impl Link {
    fn look_once(&mut self, guest: &Guest) -> Result<(), StartError> {
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
        for (row, parts) in self.hearts.due(&sitters, self.other.is_cut(now_ns), now_ns) {
            let number = u8::try_from(row.number).unwrap_or(u8::MAX);
            if let Some(lane) = self.lanes.lane(number) {
                lane.write(guest.peer(), &parts)?;
            }
        }
        // First of all the other host hears whom this one hears: before that it takes no message.
        self.beat(now_ns);
        self.send(guest, &rings, now_ns)
    }

    fn push(&mut self, frame: &Frame<'_>) {
        self.origin.number += 1;
        self.session.outbox.push(frame.encode(self.origin));
    }

    fn receive(
        &mut self,
        guest: &Guest,
        sitters: &[Sitter],
        bytes: &[u8],
    ) -> Result<(), StartError> {
        let (origin, frame) = match decode(bytes) {
            Ok(read) => read,
            Err(error) => {
                self.complain(format!("rejected: {error}"));
                return Ok(());
            }
        };
        if let Frame::Beat(beat) = frame {
            self.ingest(origin, *beat);
            return Ok(());
        }
        if !self.other.counts(origin) {
            return Ok(());
        }
        match frame {
            Frame::Ring { role, event } if self.is_paired() => {
                if self.here.contains(&role) {
                    self.bells.ring(role, usize::from(event));
                }
            }
            Frame::Message {
                topic,
                envelope,
                items,
            } if self.is_paired() => self.write(guest, sitters, topic, envelope, items)?,
            _ => self.other.lose(1),
        }
        Ok(())
    }

    /// True while both hosts hear each other, and the run goes on.
    fn is_paired(&self) -> bool {
        self.other.partner(&self.own).is_some()
    }

    fn write(
        &mut self,
        guest: &Guest,
        sitters: &[Sitter],
        topic: u8,
        envelope: &[u8],
        items: &[u8],
    ) -> Result<(), StartError> {
        let Some(offset) = self.other.offset(now_ns()) else {
            self.other.lose(1);
            return Ok(());
        };
        let Some(lane) = self.lanes.lane(topic) else {
            self.complain(format!("rejected: there is no topic {topic}"));
            return Ok(());
        };
        let row = lane.row();
        let accepted = lane.accept(envelope, items, offset.ahead_ns, &self.authors);
        let (author, parts) = match accepted {
            Ok(accepted) => accepted,
            Err(refusal) => {
                self.complain(format!("{} rejected: {refusal}", row.name));
                return Ok(());
            }
        };
        let bytes = envelope.len() + items.len();
        self.account.received(row.name, bytes, offset);
        let parts = if is_heartbeat(row) {
            self.hearts.heard(author, sitters, parts, now_ns())
        } else {
            parts
        };
        let since = Instant::now();
        while !lane.write(guest.peer(), &parts)? {
            // In real time the next message is the better one.
            if !self.lockstep || since.elapsed() > HELD_LIMIT {
                self.other.lose(1);
                break;
            }
            std::thread::sleep(HELD_PAUSE);
        }
        for role in rung(row, self.lockstep).filter(|role| self.here.contains(role)) {
            self.bells.ring(role, row.number);
        }
        Ok(())
    }

    fn ingest(&mut self, origin: Origin, beat: Beat) {
        let was_partner = self.other.was_partner();
        let held = beat.held.clone();
        match self.other.ingest(&self.own, origin, beat, now_ns()) {
            Heard::Taken => {
                if !was_partner && self.other.was_partner() {
                    let (other, instance) = (&self.own.other, self.other.instance());
                    tracing::info!(other, instance = %printable(instance), "takes part");
                }
            }
            Heard::Restarted => {
                let other = &self.own.other;
                tracing::warn!(other, "was started again: its processes have ended");
                self.complaints.clear();
                self.socket.all_ended(LOST, "its host was started again");
            }
            Heard::Late => return,
            Heard::Refused(why) => return self.complain(why),
        }
        if self.own.commands {
            self.socket.ended(&held);
        }
    }

    /// Says what is wrong, once.
    fn complain(&mut self, what: String) {
        if self.complaints.len() < COMPLAINTS_MAX && !self.complaints.contains(&what) {
            tracing::error!("{what}");
            self.complaints.insert(what);
        }
    }

    /// Says when the other host comes and goes.
    fn see_other(&mut self, now_ns: u64) {
        let is_there = self.other.is_there(now_ns);
        if is_there == self.was_there {
            return;
        }
        self.was_there = is_there;
        let other = &self.own.other;
        if is_there {
            tracing::info!(other, "is there");
        } else {
            tracing::warn!(other, lost = self.other.lost(), "is silent");
            self.account.cut();
            self.other.may_have_missed();
        }
    }

    fn send(
        &mut self,
        guest: &Guest,
        rings: &[(Role, Rung)],
        now_ns: u64,
    ) -> Result<(), StartError> {
        // Late readers get what is latched also while the way is cut, or without room.
        self.lanes.refresh();
        let beat = self.other.partner(&self.own);
        let beat = beat.filter(|beat| self.was_there && beat.synchronised);
        if let Some(reads) = beat.map(|beat| beat.reads) {
            self.lanes.listen(guest.peer(), reads)?;
            let may_repeat = now_ns.saturating_sub(self.repeated_ns) > READS_NS;
            if may_repeat && self.other.take_new() {
                self.repeated_ns = now_ns;
                self.lanes.repeat(guest.peer())?;
            }
            // Without room everything stays in its topic, where the newest message takes the place of the oldest.
            if self.session.outbox.has_room() {
                let taken = self.lanes.take(zeronav_shell::clock::now_ns);
                // Who says here that it is ready has the goal and all else that is latched before the other host hears so.
                self.lanes.refresh();
                for (topic, (envelope, items)) in taken {
                    if let Some(lane) = self.lanes.lane(topic) {
                        let bytes = envelope.len() + items.len();
                        self.account.sent(lane.row().name, bytes);
                    }
                    self.push(&Frame::Message {
                        topic,
                        envelope: &envelope,
                        items: &items,
                    });
                }
            }
            // Topics ring on the other host by themselves.
            for (role, _) in rings
                .iter()
                .filter(|(_, rung)| rung.has(EVENT_NEED_KEYFRAME))
            {
                let event = u8::try_from(EVENT_NEED_KEYFRAME).unwrap_or(u8::MAX);
                self.push(&Frame::Ring { role: *role, event });
            }
        }
        if now_ns.saturating_sub(self.looked_ns) > READS_NS {
            self.looked_ns = now_ns;
            self.reads = self.lanes.read(guest.peer());
            let (offset, lost) = (self.other.offset(now_ns), self.other.lost());
            let folder = guest.peer().domain().folder();
            self.account.write(folder, offset, lost, now_ns);
        }
        Ok(())
    }

    fn beat(&mut self, now_ns: u64) {
        let partner = self.other.partner(&self.own);
        let is_over = self.other.is_over();
        if !self.own.commands && (is_over || partner.is_some()) {
            let wanted = partner.map_or(&[][..], |beat| &beat.wanted);
            self.socket.want(self.other.instance(), wanted, is_over);
        }
        let Own {
            contract,
            host,
            scenario,
            instance,
            ..
        } = self.own.clone();
        let beat = Beat {
            contract,
            host,
            instance,
            hears: self.other.instance().to_owned(),
            scenario,
            leaving: false,
            synchronised: self.other.offset(now_ns).is_some(),
            sent_ns: 0,
            echo_sent_ns: 0,
            echo_received_ns: 0,
            reads: self.reads,
            lost: self.other.lost(),
            wanted: self.socket.wanted(),
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
        let came = self.other.beat();
        let beat = Beat {
            sent_ns: zeronav_shell::clock::now_ns(),
            echo_sent_ns: came.map_or(0, |(came, _)| came.sent_ns),
            echo_received_ns: came.map_or(0, |(_, came_ns)| came_ns),
            ..beat
        };
        self.push(&Frame::Beat(Box::new(beat)));
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
