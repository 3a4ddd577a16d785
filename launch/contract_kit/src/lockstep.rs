//! Clauses about the idle output, the heartbeat, and answers in lockstep.

use super::bench::{Bench, EPOCH, OTHERS_EPOCH, seat_row};
use super::clause::Clause;
use super::legal;
use super::others::{Missing, Others};
use super::program::Program;
use super::raw::Received;
use super::report::Report;
use super::robot::{Robot, scan_due};
use super::room::Room;
use std::collections::BTreeMap;
use std::time::Duration;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::seats::{Answers, SeatRow};
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::topics::{ControlRequest, RobotCommand, SPANS, TopicRow, health_of};

/// Ticks that are played.
const TICKS: u64 = 150;

/// Tick from which the goal holds.
const GOAL_TICK: u64 = 10;

/// How long an answer in lockstep may take.
const ANSWER_LIMIT: Duration = Duration::from_secs(3);

/// Answers that may be missing until the play ends.
const MISSING_MAX: usize = 2;

/// For how long the heartbeat is watched, how often at most, and the longest time between two beats.
const WATCH_NS: u64 = 500_000_000;
const WATCH: Duration = Duration::from_nanos(WATCH_NS);
const WATCHES: usize = 4;
const BEAT_NS_MAX: u64 = 100_000_000;

/// What the program did in one play.
struct Trace {
    messages: Vec<Received>,
    records: Vec<Span>,
    /// The first tick that was not answered.
    missing: Option<u64>,
    /// Ticks that were played.
    ticks: u64,
    robot: Robot,
}

/// Tests the clauses; false when the program does not start at all.
pub(crate) fn test(program: &Program, report: &mut Report) -> bool {
    let bench = Bench::make(program, RunMode::Lockstep, "");
    let first = bench.and_then(|mut bench| {
        let first = begin(&mut bench, report).and_then(|()| play(&mut bench, None));
        bench.close();
        first
    });
    let first = match first {
        Ok(first) => first,
        Err(why) => {
            report.add(Clause::Idle, Err(why));
            return false;
        }
    };
    let seat = seat_row(program.role);
    report.add(Clause::Lockstep, answers(&first, seat));
    report.add(Clause::Records, records(&first, seat));
    report.add(Clause::Epoch, epochs(&first, program.role));
    report.add(Clause::Legal, legal_output(&first, program.role));
    if first.missing.is_some() {
        let why = "answers were missing in the first play";
        report.skip_rest(&[Clause::Repeatable, Clause::Obeyed], why);
        return true;
    }
    let same = again(program, false).and_then(|second| {
        compare(&first, &second)?;
        let n = first.messages.len();
        Ok(format!("{n} messages are the same in a second run"))
    });
    let repeatable = same.is_ok();
    report.add(Clause::Repeatable, same);
    if repeatable {
        report.add(Clause::Obeyed, obeyed_only(program, &first));
    } else {
        report.skip(Clause::Obeyed, "two equal runs differ already");
    }
    true
}

/// A play in a domain of its own.
fn again(program: &Program, with_impostors: bool) -> Result<Trace, String> {
    let mut bench = Bench::make(program, RunMode::Lockstep, "")?;
    let played = bench.start().and_then(|()| {
        bench.await_ready()?;
        let impostors = with_impostors.then(|| {
            let (root, role) = (&bench.root, program.role);
            Others::open(root, role, OTHERS_EPOCH + 1, true).map_err(|error| error.to_string())
        });
        play(&mut bench, impostors.transpose()?)
    });
    bench.close();
    played
}

/// Every other seat has a second author with a higher epoch, which `run/control` does not name.
fn obeyed_only(program: &Program, first: &Trace) -> Result<String, String> {
    let third = again(program, true)?;
    compare(first, &third)?;
    Ok("a second author in every other seat changes nothing".to_owned())
}

/// Starts the program, and looks at it while there is nothing to do.
fn begin(bench: &mut Bench, report: &mut Report) -> Result<(), String> {
    let before = bench.ports()?;
    bench.start()?;
    bench.await_ready()?;
    let role = bench.program.role;
    report.add(Clause::Topics, topics(role, &before, &bench.ports()?));
    // The record of the idle output follows its messages.
    bench.wait(Duration::from_millis(500), |bench| {
        bench
            .records
            .iter()
            .any(|span| span.kind() == Some(SpanKind::Idle))
    });
    report.add(Clause::Idle, idle(bench));
    report.add(Clause::Heartbeat, heartbeat(bench));
    Ok(())
}

fn topics(
    role: Role,
    before: &[(&'static TopicRow, [usize; 2])],
    after: &[(&'static TopicRow, [usize; 2])],
) -> Result<String, String> {
    let seat = seat_row(role);
    let own = [health_of(role), Some(&SPANS)];
    let named = |rows: &[&TopicRow], name: &str| rows.iter().any(|row| row.name == name);
    let (mut written, mut read) = (Vec::new(), Vec::new());
    for ((row, [writers, readers]), (_, [writers_now, readers_now])) in before.iter().zip(after) {
        if writers_now > writers {
            written.push(row.name);
        }
        if readers_now > readers && !row.writers.contains(&Role::Launch) {
            read.push(row.name);
        }
    }
    let may_write = |name: &str| {
        named(&seat.writes(), name) || own.iter().flatten().any(|row| row.name == name)
    };
    if let Some(name) = written.iter().find(|name| !may_write(name)) {
        return Err(format!(
            "it opened {name} for writing, which is not its own"
        ));
    }
    let owed = seat
        .owes
        .iter()
        .chain(seat.idle)
        .chain(own.iter().flatten());
    for row in owed {
        if !written.contains(&row.name) {
            return Err(format!("it did not open {} for writing", row.name));
        }
    }
    if let Some(name) = read.iter().find(|name| !named(seat.reads, name)) {
        return Err(format!(
            "it opened {name} for reading, which its seat does not"
        ));
    }
    Ok(format!(
        "writes {} topics, reads {}, all of its seat",
        written.len(),
        read.len()
    ))
}

fn idle(bench: &Bench) -> Result<String, String> {
    let seat = seat_row(bench.program.role);
    for row in seat.idle {
        let mut sent = bench.seen.iter();
        let found = sent.find(|seen| seen.row.name == row.name && seen.header.tick == 0);
        legal::check_idle(found.ok_or_else(|| format!("no {} of tick 0", row.name))?)?;
    }
    let is_idle = |span: &&Span| span.kind() == Some(SpanKind::Idle) && span.tick == 0;
    match bench.records.iter().filter(is_idle).count() {
        1 => Ok(format!("{} topics of tick 0, one record", seat.idle.len())),
        n => Err(format!("{n} idle records in place of one")),
    }
}

/// Watched several times at most: a busy machine may hold a process up.
fn heartbeat(bench: &mut Bench) -> Result<String, String> {
    let mut worst = String::new();
    for _ in 0..WATCHES {
        bench.beats.clear();
        bench.wait(WATCH, |_| false);
        let beats = &bench.beats;
        let Some((first, last)) = beats.first().zip(beats.last()) else {
            worst = format!("no beat within {} ms", WATCH.as_millis());
            continue;
        };
        let pairs = beats.iter().zip(beats.iter().skip(1));
        let gap_ns = pairs.map(|(one, next)| next.0.saturating_sub(one.0)).max();
        let advances = beats.iter().zip(beats.iter().skip(1));
        let stuck = advances
            .filter(|(one, next)| next.1.progress <= one.1.progress)
            .count();
        let whole = last.0.saturating_sub(first.0) + 2 * BEAT_NS_MAX >= WATCH_NS;
        let gap_ns = gap_ns.unwrap_or(u64::MAX);
        if whole && stuck == 0 && gap_ns <= BEAT_NS_MAX {
            return Ok(format!(
                "at most {} ms between two beats",
                gap_ns / 1_000_000
            ));
        }
        worst = format!(
            "{} beats in {} ms, {} ms apart at most, {stuck} without progress",
            beats.len(),
            WATCH.as_millis(),
            gap_ns / 1_000_000
        );
    }
    Err(worst)
}

/// Plays the ticks, each when the one before was answered.
fn play(bench: &mut Bench, mut impostors: Option<Others>) -> Result<Trace, String> {
    let role = bench.program.role;
    let seat = seat_row(role);
    let mut robot = Robot::new();
    let (mut missing, mut played) = (Vec::new(), 0);
    bench.send_goal(GOAL_TICK);
    if let Some(impostors) = &mut impostors {
        impostors.introduce();
    }
    for tick in 1..=TICKS {
        played = tick;
        if let Some(impostors) = &mut impostors {
            let mut elsewhere = robot;
            elsewhere.pose.x_m += 1.5;
            elsewhere.v_mps = -0.4;
            impostors.send(tick, &elsewhere, Missing::Nothing);
        }
        bench.others.send(tick, &robot, Missing::Nothing);
        let answers = |span: &Span| span.tick == tick && span.kind() == Some(SpanKind::Answer);
        if is_due(seat, tick)
            && !bench.wait(ANSWER_LIMIT, |bench| {
                bench.records.iter().rev().any(answers)
            })
        {
            missing.push(tick);
            if let Some(status) = bench.ended() {
                let words = bench.last_words();
                return Err(format!("it ended ({status}) at tick {tick}: {words}"));
            }
            if missing.len() > MISSING_MAX {
                break;
            }
        }
        let (v_mps, w_radps) = wanted(bench, &robot, tick);
        robot.step(v_mps, w_radps, Room::at(tick));
    }
    // What belongs to the last tick may come after its record.
    bench.wait(Duration::from_millis(20), |_| false);
    Ok(Trace {
        messages: std::mem::take(&mut bench.seen),
        records: std::mem::take(&mut bench.records),
        missing: missing.first().copied(),
        ticks: played,
        robot,
    })
}

/// Speed and yaw rate that reach the wheels after `tick`.
pub(crate) fn wanted(bench: &Bench, robot: &Robot, tick: u64) -> (f64, f64) {
    let mut newest = bench
        .seen
        .iter()
        .rev()
        .filter(|seen| seen.refusal.is_none());
    let twist = newest.find_map(|seen| {
        let request = seen
            .meta::<ControlRequest>()
            .map(|it| (it.v_mps, it.w_radps));
        request.or_else(|| seen.meta::<RobotCommand>().map(|it| (it.v_mps, it.w_radps)))
    });
    match bench.program.role {
        Role::LocalPlanner | Role::CollisionGuard => twist.unwrap_or((0.0, 0.0)),
        _ => robot.pursue(&super::others::way_m(tick > super::room::BOX_TICK)),
    }
}

fn is_due(seat: &SeatRow, tick: u64) -> bool {
    seat.answers == Answers::EveryTick || scan_due(tick)
}

fn answers(trace: &Trace, seat: &SeatRow) -> Result<String, String> {
    let expected: Vec<u64> = (1..=trace.ticks)
        .filter(|tick| is_due(seat, *tick))
        .collect();
    for row in seat.owes {
        let sent = trace
            .messages
            .iter()
            .filter(|seen| seen.row.name == row.name);
        let ticks: Vec<u64> = sent
            .map(|seen| seen.header.tick)
            .filter(|tick| *tick > 0)
            .collect();
        let differs =
            (0..expected.len().max(ticks.len())).find(|at| expected.get(*at) != ticks.get(*at));
        if let Some(at) = differs {
            let word = |tick: Option<&u64>| tick.map_or("none".to_owned(), u64::to_string);
            return Err(format!(
                "{}: answer {} is to tick {}, and tick {} was due",
                row.name,
                at + 1,
                word(ticks.get(at)),
                word(expected.get(at))
            ));
        }
    }
    // A message without a record is another clause.
    Ok(format!("{} ticks answered once, in order", expected.len()))
}

fn records(trace: &Trace, seat: &SeatRow) -> Result<String, String> {
    let mut counts: BTreeMap<u64, u64> = BTreeMap::new();
    let answers = trace
        .records
        .iter()
        .filter(|span| span.kind() == Some(SpanKind::Answer));
    for span in answers {
        *counts.entry(span.tick).or_default() += 1;
        if span.epoch != EPOCH {
            return Err(format!(
                "tick {}: a record of epoch {}",
                span.tick, span.epoch
            ));
        }
        let named = trace.messages.iter().any(|seen| {
            let is_owed = seat.owes.iter().any(|row| row.name == seen.row.name);
            is_owed && seen.header.tick == span.tick && seen.header.id == span.output
        });
        if !named {
            return Err(format!(
                "tick {}: its record names no message of the answer",
                span.tick
            ));
        }
    }
    let owed = seat.owes.first().map_or("", |row| row.name);
    let answered = trace.messages.iter().filter(|seen| seen.row.name == owed);
    for tick in answered
        .map(|seen| seen.header.tick)
        .filter(|tick| *tick > 0)
    {
        let n = counts.get(&tick).copied().unwrap_or(0);
        if n != 1 {
            return Err(format!("tick {tick}: {n} records in place of one"));
        }
    }
    Ok(format!("{} answers, one record each", counts.len()))
}

fn epochs(trace: &Trace, role: Role) -> Result<String, String> {
    for seen in &trace.messages {
        let (header, name) = (&seen.header, seen.row.name);
        if header.id().epoch() != EPOCH {
            let epoch = header.id().epoch();
            return Err(format!("{name}: epoch {epoch}, and --epoch was {EPOCH}"));
        }
        if header.role() != Some(role) {
            return Err(format!("{name}: role code {} in the header", header.role));
        }
    }
    Ok(format!(
        "{} messages with the given epoch",
        trace.messages.len()
    ))
}

fn legal_output(trace: &Trace, role: Role) -> Result<String, String> {
    for seen in &trace.messages {
        legal::check(seen)?;
    }
    let closest_m = trace.robot.closest_m;
    if role == Role::CollisionGuard && closest_m <= 0.0 {
        return Err("it let the robot drive into the box".to_owned());
    }
    let n = trace.messages.len();
    Ok(format!(
        "{n} messages decoded; closest {closest_m:.2} m to an obstacle"
    ))
}

/// Compares everything that was sent for a tick.
fn compare(first: &Trace, second: &Trace) -> Result<(), String> {
    if let Some(tick) = second.missing {
        return Err(format!("tick {tick} was not answered"));
    }
    let sent = |trace: &Trace| -> BTreeMap<(&'static str, u64, u64), u64> {
        let answers = trace.messages.iter().filter(|seen| seen.header.tick > 0);
        answers
            .map(|seen| {
                let id = seen.header.id().count();
                ((seen.row.name, seen.header.tick, id), seen.hash())
            })
            .collect()
    };
    let (one, other) = (sent(first), sent(second));
    let differs = one.iter().find(|(key, hash)| other.get(key) != Some(hash));
    let surplus = other.keys().find(|key| !one.contains_key(key));
    match differs.map(|(key, _)| key).or(surplus) {
        Some((name, tick, _)) => Err(format!("{name} of tick {tick} is another message")),
        None => Ok(()),
    }
}
