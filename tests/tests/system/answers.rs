//! What the table of seats says, held against the stock processes in lockstep: which ticks a seat
//! answers, what an answer holds, whose answer it waits for, and the idle output that says that the
//! process runs.

use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::{Duration, Instant};
use zeronav_msgs::command::{Validity, VelocityCommand, VelocityRequest};
use zeronav_msgs::header::Id;
use zeronav_msgs::path as plan;
use zeronav_msgs::role::Role;
use zeronav_msgs::seats::{Answers, SEATS, SeatRow};
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::topics::{
    ControlRequest, DebugRollouts, MapUpdate, PlanPath, RobotScan, Topic, TopicRow, TopicVisitor,
    visit_topics,
};
use zeronav_shell::records::SpanReader;
use zeronav_shell::roster_reader::RosterReader;
use zeronav_shell::{Domain, Peer, Roster, StartError, Stream};
use zeronav_tests::rooms::short_drive;
use zeronav_tests::{Stranger, Zeronav};

/// Ticks that are looked at, whose records fit into the queue of a reader.
const TICKS: u64 = 190;

/// Ticks that must have been seen whole: a run in lockstep does not wait for guests, who miss
/// messages on a busy machine.
const SEEN_MIN: usize = 60;

/// Runs that are watched until one was seen from its first message on: on a busy machine the guest may get
/// no processor for longer than the queue of a reader lasts.
const TRIES_MAX: usize = 8;

/// No run needs longer.
const LIMIT: Duration = Duration::from_secs(240);

/// What was sent: topic, tick and identity of every message, and every record; and the ticks of which
/// messages were missed.
#[derive(Default)]
struct Seen {
    messages: BTreeMap<&'static str, BTreeMap<u64, Vec<u64>>>,
    spans: BTreeMap<(u16, u64), Span>,
    missed: BTreeSet<u64>,
    /// Seats of which the first message of a topic was missed.
    late: BTreeSet<u16>,
}

type Reader = Box<dyn FnMut(&Roster, &mut Seen)>;

/// Opens every topic that a seat writes.
struct Opener<'a> {
    peer: &'a Peer,
    readers: Vec<Reader>,
}

impl TopicVisitor for Opener<'_> {
    type Error = StartError;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), StartError> {
        let written = SEATS.iter().flat_map(SeatRow::writes);
        if !written.into_iter().any(|written| written.name == row.name) {
            return Ok(());
        }
        let mut stream: Stream<T> = self.peer.stream()?;
        let mut last = (0, 0);
        self.readers.push(Box::new(move |roster, seen| {
            stream.drain(roster, |view| {
                let header = view.header;
                if header.tick == 0 {
                    idle(view.meta);
                }
                if last.0 != 0 && header.id > last.0 + 1 {
                    seen.missed.extend(last.1..=header.tick);
                }
                let is_first = header.id == Id::new(header.id().epoch(), 1).0;
                if last.0 == 0 && !is_first {
                    seen.late.insert(header.role);
                }
                last = (header.id, header.tick);
                let ticks = seen.messages.entry(row.name).or_default();
                ticks.entry(header.tick).or_default().push(header.id);
            });
        }));
        Ok(())
    }

    fn records(&mut self, _: &'static TopicRow) -> Result<(), StartError> {
        Ok(())
    }
}

/// An idle output moves nothing and promises nothing.
fn idle(meta: &dyn Any) {
    if let Some(request) = meta.downcast_ref::<VelocityRequest>() {
        assert_eq!((request.v_mps, request.w_radps), (0.0, 0.0));
        assert_ne!(request.validity(), Some(Validity::Drive));
    }
    if let Some(command) = meta.downcast_ref::<VelocityCommand>() {
        assert_eq!((command.v_mps, command.w_radps), (0.0, 0.0));
        assert_eq!(command.validity(), Some(Validity::NoRequest));
    }
    if let Some(path) = meta.downcast_ref::<plan::Path>() {
        assert_eq!((path.n_waypoints, path.goal), (0, 0));
    }
}

/// A guest of the run that sees every message of the seats from the first one on.
struct Guest {
    roster: RosterReader,
    spans: SpanReader,
    readers: Vec<Reader>,
    seen: Seen,
    _peer: Peer,
}

impl Guest {
    fn join(root: &Path) -> Self {
        let domain = Domain::join(root).expect("the run's domain");
        let peer = Peer::join(domain, Role::Tap, 1).expect("a guest");
        let mut opener = Opener {
            peer: &peer,
            readers: Vec::new(),
        };
        visit_topics(&mut opener).expect("every topic");
        Self {
            readers: opener.readers,
            roster: RosterReader::open(&peer).expect("the roster"),
            spans: peer.span_reader().expect("the records"),
            seen: Seen::default(),
            _peer: peer,
        }
    }

    /// Takes in what has come.
    fn poll(&mut self) {
        self.roster.poll();
        if !self.roster.roster().is_known() {
            return;
        }
        let seen = &mut self.seen;
        self.spans.drain(|span| {
            if matches!(span.kind(), Some(SpanKind::Answer | SpanKind::Idle)) {
                let twice = seen.spans.insert((span.role, span.tick), *span);
                assert!(twice.is_none(), "answered twice: {span:?}");
            }
        });
        for reader in &mut self.readers {
            reader(self.roster.roster(), seen);
        }
    }
}

impl Seen {
    /// True once every seat has left the record of its last answer that is looked at. It does so after others
    /// may have gone on with what the answer holds.
    fn is_complete(&self) -> bool {
        let scans = self.ticks_of(RobotScan::ROW);
        let last_scan = scans.range(..=TICKS).next_back().copied();
        SEATS.iter().all(|seat| {
            let last = match seat.answers {
                Answers::EveryTick => TICKS,
                Answers::TicksWithScan => last_scan.unwrap_or(TICKS),
            };
            let role = seat.role.code();
            let from_then_on = self.spans.range((role, last)..=(role, u64::MAX));
            from_then_on.count() > 0
        })
    }

    /// Ticks that a seat has answered, the idle output not counted.
    fn answered(&self, seat: &SeatRow) -> Vec<u64> {
        let role = seat.role.code();
        let all = self.spans.range((role, 1)..=(role, u64::MAX));
        all.map(|((_, tick), _)| *tick).collect()
    }

    /// Those of the ticks that are looked at of which nothing was missed.
    fn whole(&self, ticks: impl IntoIterator<Item = u64>) -> impl Iterator<Item = u64> {
        let ticks = ticks.into_iter();
        ticks.filter(|tick| (1..=TICKS).contains(tick) && !self.missed.contains(tick))
    }

    /// Names of a seat's topics with a message of this tick.
    fn written(&self, seat: &SeatRow, tick: u64) -> BTreeSet<&'static str> {
        let rows = seat.writes().into_iter();
        let sent = |row: &&TopicRow| self.ids(row, tick).is_some();
        rows.filter(sent).map(|row| row.name).collect()
    }

    fn ids(&self, row: &TopicRow, tick: u64) -> Option<&Vec<u64>> {
        self.messages.get(row.name)?.get(&tick)
    }

    fn ticks_of(&self, row: &TopicRow) -> BTreeSet<u64> {
        let all = self.messages.get(row.name).into_iter().flatten();
        all.map(|(tick, _)| *tick).collect()
    }

    /// The ticks that a seat answers, and what its answers hold.
    fn check_answers(&self, seat: &SeatRow) {
        let answered: Vec<u64> = self.whole(self.answered(seat)).collect();
        let expected: Vec<u64> = match seat.answers {
            Answers::EveryTick => self.whole(1..=TICKS).collect(),
            Answers::TicksWithScan => self.whole(self.ticks_of(RobotScan::ROW)).collect(),
        };
        assert_eq!(answered, expected, "{}: ticks", seat.role);
        let written = answered.iter().map(|tick| self.written(seat, *tick));
        let mut always = written.reduce(|all, these| &all & &these).expect("answers");
        // They are sent because this test reads them.
        always.remove(DebugRollouts::ROW.name);
        assert_eq!(always, names(seat.owes), "{}: an answer", seat.role);
    }

    /// True when every answer of `seat` is made from the answer of `other` to the same
    /// tick, where there is one.
    fn waits_for(&self, seat: &SeatRow, other: &SeatRow) -> bool {
        let cited = other.owes.iter().filter(|owed| {
            cited(&Span::default(), owed).is_some()
                && seat.reads.iter().any(|read| read.name == owed.name)
        });
        let both: Vec<u64> = (self.whole(self.answered(seat)))
            .filter(|tick| self.spans.contains_key(&(other.role.code(), *tick)))
            .collect();
        assert!(both.len() > 5, "{}: {} answers", seat.role, both.len());
        let mut cited = cited.peekable();
        cited.peek().is_some()
            && cited.all(|row| {
                both.iter().all(|tick| {
                    let span = &self.spans[&(seat.role.code(), *tick)];
                    let ids = self.ids(row, *tick);
                    ids.is_some_and(|ids| ids.contains(&cited_id(span, row)))
                })
            })
    }
}

/// The message of a topic that an answer names as one of its inputs; `None` for topics that no
/// record names.
fn cited(span: &Span, row: &TopicRow) -> Option<u64> {
    let id = |named: &TopicRow, id| (named.name == row.name).then_some(id);
    id(MapUpdate::ROW, span.map)
        .or(id(PlanPath::ROW, span.path))
        .or(id(ControlRequest::ROW, span.request))
}

fn cited_id(span: &Span, row: &TopicRow) -> u64 {
    cited(span, row).unwrap_or(0)
}

fn names(rows: &[&'static TopicRow]) -> BTreeSet<&'static str> {
    rows.iter().map(|row| row.name).collect()
}

/// A run in lockstep; the process in the seat is started once the guest is there, so that its very
/// first messages are seen, too.
fn watch(seat: &SeatRow, binary: &str) -> Seen {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), short_drive("")).expect("written");
    let role = seat.role.label();
    let arguments = [
        "run",
        "./it.toml",
        "--lockstep",
        "--headless",
        "--external",
        role,
    ];
    let mut run = Zeronav::start_in(folder, &arguments);
    run.wait_until("the others run", |run| run.children().len() == 4);
    let root = run.domains().pop().expect("a domain");
    let mut guest = Guest::join(&root);
    let started = Instant::now();
    while !guest.roster.roster().is_known() {
        assert!(started.elapsed() < LIMIT, "no message from launch");
        guest.poll();
    }
    let config = root.join(format!("{role}.toml")).display().to_string();
    let _service = Stranger::start(binary, &root, &["--epoch", "1", "--config", &config]);
    while !guest.seen.is_complete() {
        guest.poll();
        assert!(started.elapsed() < LIMIT, "{role}: the run does not go on");
        if run.has_ended() {
            guest.poll();
            if !guest.seen.is_complete() {
                // On a busy machine the guest has not seen its end: nothing is known of it.
                guest.seen.missed.extend(0..=TICKS);
            }
            break;
        }
        std::thread::yield_now();
    }
    // What an answer holds is sent before its record, but another topic may have been read first.
    guest.poll();
    guest.seen
}

fn check(role: Role, binary: &str) {
    let seat = SEATS.iter().find(|seat| seat.role == role).expect("a seat");
    let seen = (0..TRIES_MAX)
        .map(|_| watch(seat, binary))
        .find(|seen| {
            let is_late = seen.late.contains(&role.code()) || seen.missed.contains(&0);
            let whole = seen.whole(1..=TICKS).count();
            eprintln!("{role}: {whole} ticks were seen whole, its first message missed: {is_late}");
            !is_late && whole >= SEEN_MIN
        })
        .expect("a run that was seen");
    assert_eq!(
        seen.written(seat, 0),
        names(seat.idle),
        "{role}: the idle output"
    );
    let idle = &seen.spans[&(role.code(), 0)];
    assert_eq!(idle.kind(), Some(SpanKind::Idle), "{idle:?}");
    for seat in &SEATS {
        seen.check_answers(seat);
        let others = SEATS.iter().filter(|other| other.role != seat.role);
        let waits = others.filter(|other| other.role != Role::Robot && seen.waits_for(seat, other));
        let waits: BTreeSet<Role> = waits.map(|other| other.role).collect();
        let after: BTreeSet<Role> = seat.after.iter().copied().collect();
        assert_eq!(waits, after, "{}: whose answers it waits for", seat.role);
    }
}

#[test]
fn a_robot_answers_as_its_seat_says() {
    check(Role::Robot, "zeronav-robot-sim");
}

#[test]
fn mapping_answers_as_its_seat_says() {
    check(Role::Mapping, "zeronav-mapping");
}

#[test]
fn a_global_planner_answers_as_its_seat_says() {
    check(Role::GlobalPlanner, "zeronav-global-planner");
}

#[test]
fn a_local_planner_answers_as_its_seat_says() {
    check(Role::LocalPlanner, "zeronav-local-planner");
}

#[test]
fn a_guard_answers_as_its_seat_says() {
    check(Role::CollisionGuard, "zeronav-collision-guard");
}
