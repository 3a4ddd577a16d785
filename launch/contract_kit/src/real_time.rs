//! Clauses that need a clock: latency, lost input, hostile input, memory, and the end.

use super::bench::{Bench, seat_row};
use super::clause::Clause;
use super::hostile::{Hostile, Noise};
use super::legal;
use super::lockstep::wanted;
use super::others::Missing;
use super::program::Program;
use super::raw::Received;
use super::report::Report;
use super::robot::{Robot, SCAN_TICKS, TICK_NS, scan_due};
use super::room::Room;
use rustix::process::Signal;
use std::time::{Duration, Instant};
use zeronav_console::environment;
use zeronav_msgs::command::Validity;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::seats::Answers;
use zeronav_msgs::topics::{ControlRequest, MapUpdate, RobotCommand};
use zeronav_observe::statistics::percentile;
use zeronav_supervise::own_time::Patience;

/// Ticks in which latencies are measured, and how often at most: a busy machine may be in the way.
const LATENCY_TICKS: u64 = 125;
const LATENCY_TRIES: u64 = 3;

/// Ticks without a scan: 1.2 s.
const LOST_TICKS: u64 = 60;

/// Ticks after hostile messages in which an answer has to come.
const RECOVERY_TICKS: u64 = 100;

/// Hostile messages on each topic between two rings.
const BATCH: usize = 2;

/// Time between two rings.
const PAUSE: Duration = Duration::from_micros(150);

/// Most that hostile messages may add to a program's own memory. [bytes]
const GROWTH_BYTES_MAX: u64 = 16 << 20;

/// Own time that a program may take to end when it is asked to: launch kills it then.
const STOP_LIMIT: Duration = Duration::from_secs(2);

/// Own time that it may take when launch is gone.
const ORPHAN_LIMIT: Duration = Duration::from_millis(1600);

/// What both may take by the clock, on a machine that has no time for it.
const END_WALL_LIMIT: Duration = Duration::from_secs(15);

/// Ticks of a drive before launch goes.
const ORPHAN_TICKS: u64 = 50;

/// The play of one bench in real time.
struct Play {
    bench: Bench,
    robot: Robot,
    tick: u64,
    next: Instant,
}

/// Tests the clauses.
pub(crate) fn test(program: &Program, hostile: u64, report: &mut Report) {
    let clauses = [
        Clause::Latency,
        Clause::LostInput,
        Clause::Hostile,
        Clause::Bounded,
        Clause::Stop,
    ];
    match Play::begin(program) {
        Ok(mut play) => {
            play.test(hostile, report);
            play.bench.close();
        }
        Err(why) => report.add(Clause::Latency, Err(why)),
    }
    report.skip_rest(&clauses, "the program was gone");
    match Play::begin(program) {
        Ok(play) => report.add(Clause::Orphan, play.orphan()),
        Err(why) => report.add(Clause::Orphan, Err(why)),
    }
}

impl Play {
    fn begin(program: &Program) -> Result<Self, String> {
        let mut bench = Bench::make(program, RunMode::RealTime, "")?;
        let ready = bench.start().and_then(|()| bench.await_ready());
        if let Err(why) = ready {
            bench.close();
            return Err(why);
        }
        bench.send_goal(0);
        Ok(Self {
            bench,
            robot: Robot::new(),
            tick: 0,
            next: Instant::now(),
        })
    }

    fn test(&mut self, hostile: u64, report: &mut Report) {
        report.add(Clause::Latency, self.latency());
        if self.bench.ended().is_none() {
            report.add(Clause::LostInput, self.lost_input());
        }
        if self.bench.ended().is_none() {
            let before = self.memory_bytes();
            let survived = self.hostile(hostile);
            let lives = survived.is_ok();
            report.add(Clause::Hostile, survived);
            if lives {
                report.add(Clause::Bounded, grown(before, self.memory_bytes()));
            } else {
                report.skip(Clause::Bounded, "hostile input was not survived");
            }
        }
        if self.bench.ended().is_none() {
            report.add(Clause::Stop, self.stop());
        }
    }

    /// Lets one tick pass: when its input was sent. [ns]
    fn step(&mut self, missing: Missing) -> u64 {
        self.tick += 1;
        self.next = (self.next + Duration::from_nanos(TICK_NS)).max(Instant::now());
        let sent_ns = self.bench.others.send(self.tick, &self.robot, missing);
        self.pass();
        sent_ns
    }

    /// Waits for the end of the tick, then lets the robot drive.
    fn pass(&mut self) {
        let left = self.next.saturating_duration_since(Instant::now());
        self.bench.wait(left, |_| false);
        let (v_mps, w_radps) = wanted(&self.bench, &self.robot, self.tick);
        self.robot.step(v_mps, w_radps, Room::at(self.tick));
    }

    /// From an input to the answer, for every tick that has to be answered.
    fn latency(&mut self) -> Result<String, String> {
        let seat = seat_row(self.bench.program.role);
        let every_tick = seat.answers == Answers::EveryTick;
        let limit_ns = if every_tick {
            TICK_NS
        } else {
            SCAN_TICKS * TICK_NS
        };
        let owed = seat.owes.last().map_or("", |row| row.name);
        let mut worst = String::new();
        for _ in 0..LATENCY_TRIES {
            let first = self.tick + 1;
            let mut sent = Vec::new();
            for _ in 0..LATENCY_TICKS {
                let sent_ns = self.step(Missing::Nothing);
                if every_tick || scan_due(self.tick) {
                    sent.push((self.tick, sent_ns));
                }
            }
            self.bench.wait(Duration::from_nanos(limit_ns), |_| false);
            self.next = Instant::now();
            if let Some(status) = self.bench.ended() {
                return Err(format!("it ended ({status}): {}", self.bench.last_words()));
            }
            let answers = self.bench.seen.iter().filter(|seen| seen.row.name == owed);
            let answers: Vec<(u64, u64)> = answers
                .map(|seen| (seen.header.tick, seen.header.stamps.published_ns))
                .filter(|(tick, _)| *tick >= first)
                .collect();
            let mut latencies: Vec<u64> = sent.iter().map(|sent| since(*sent, &answers)).collect();
            let [p99_ns, p50_ns] =
                [0.99, 0.5].map(|share| percentile(&mut latencies, share).unwrap_or(u64::MAX));
            let text = format!(
                "p99 {}, p50 {} of {} answers, the limit is {} ms",
                in_ms(p99_ns),
                in_ms(p50_ns),
                latencies.len(),
                limit_ns / 1_000_000
            );
            if p99_ns < limit_ns {
                return Ok(text);
            }
            worst = text;
        }
        if let Some(busy) = environment::busy() {
            worst = format!("{worst}; {busy}");
        }
        Err(worst)
    }

    /// No scans, or more map updates than can be read.
    fn lost_input(&mut self) -> Result<String, String> {
        if self.bench.program.role == Role::GlobalPlanner {
            return self.lost_update();
        }
        // A busy machine delays the ramp to rest: twice as long is enough for it.
        self.without_scans().or_else(|_| self.without_scans())
    }

    /// 1.2 s without scans, or as long again.
    fn without_scans(&mut self) -> Result<String, String> {
        self.bench.seen.clear();
        for _ in 0..LOST_TICKS {
            self.step(Missing::Scans);
        }
        let seen = &self.bench.seen;
        let stale = seen
            .iter()
            .filter_map(Received::meta::<MapUpdate>)
            .any(|it| it.current == 0);
        let request = seen.iter().rev().find_map(Received::meta::<ControlRequest>);
        let command = seen.iter().rev().find_map(Received::meta::<RobotCommand>);
        let twist = request.map(|it| (it.v_mps, it.w_radps, it.validity()));
        let twist = twist.or(command.map(|it| (it.v_mps, it.w_radps, None)));
        match (self.bench.program.role, twist) {
            (Role::Mapping, _) if stale => Ok("no scan: an update that is not current".to_owned()),
            (Role::Mapping, _) => Err("2.4 s without a scan, and the map is current".to_owned()),
            (_, None) => Err("2.4 s without a scan, and no output at all".to_owned()),
            (_, Some((v_mps, w_radps, validity))) => {
                let drives = validity == Some(Validity::Drive);
                if v_mps == 0.0 && w_radps == 0.0 && !drives {
                    Ok("no scan: it asks for rest".to_owned())
                } else {
                    Err(format!(
                        "2.4 s without a scan, and it asks for {v_mps} m/s, {w_radps} rad/s"
                    ))
                }
            }
        }
    }

    fn lost_update(&mut self) -> Result<String, String> {
        let _ = self.bench.others.is_asked_for_keyframe();
        self.bench.others.overflow_updates(self.tick);
        let others = |bench: &mut Bench| bench.others.is_asked_for_keyframe();
        let asked = self.bench.wait(Duration::from_secs(1), others);
        self.bench.others.send_keyframe(self.tick);
        if asked {
            Ok("updates missed: it asks for a keyframe".to_owned())
        } else {
            Err("more updates than a queue holds, and no keyframe was asked for".to_owned())
        }
    }

    /// Sends `n` hostile messages and then sees whether the program still answers.
    fn hostile(&mut self, n: u64) -> Result<String, String> {
        let role = self.bench.program.role;
        let mut hostile = Hostile::open(&self.bench.raw, role)?;
        let mut noise = Noise(n);
        // What is illegal without hostile input is another clause.
        let judge = !(self.bench.seen.iter()).any(|seen| legal::check(seen).is_err());
        self.bench.seen.clear();
        let rejected_before = self.rejected();
        let (mut sent, mut rounds) = (0, 0_u64);
        while sent < n {
            for _ in 0..BATCH {
                sent += hostile.throw(&mut noise, self.tick);
            }
            for row in hostile.rows() {
                self.bench.others.ring(row);
            }
            std::thread::sleep(PAUSE);
            rounds += 1;
            if rounds % 64 == 0 {
                self.bench.poll();
                if let Some(status) = self.bench.ended() {
                    let words = self.bench.last_words();
                    return Err(format!(
                        "it ended ({status}) after {sent} messages: {words}"
                    ));
                }
                for seen in self.bench.seen.drain(..).filter(|_| judge) {
                    legal::check(&seen).map_err(|why| format!("after {sent} messages: {why}"))?;
                }
            }
        }
        drop(hostile);
        self.recover(judge)
            .map_err(|why| format!("after {sent} messages: {why}"))?;
        let rejected = self.rejected().saturating_sub(rejected_before);
        Ok(format!(
            "{sent} messages, {rejected} rejected by its own count; it answers"
        ))
    }

    /// Good input again: it has to be answered.
    fn recover(&mut self, judge: bool) -> Result<(), String> {
        self.bench.others.send_keyframe(self.tick);
        self.bench.seen.clear();
        let owed = seat_row(self.bench.program.role).owes.last();
        let owed = owed.map_or("", |row| row.name);
        let from = self.tick + 1;
        for _ in 0..RECOVERY_TICKS {
            self.step(Missing::Nothing);
            if let Some(status) = self.bench.ended() {
                return Err(format!("it ended ({status}): {}", self.bench.last_words()));
            }
            for seen in self.bench.seen.iter().filter(|_| judge) {
                legal::check(seen)?;
            }
            let answers = |seen: &Received| seen.row.name == owed && seen.header.tick >= from;
            if self.bench.seen.iter().any(answers) {
                return Ok(());
            }
        }
        Err("good input was not answered within 2 s".to_owned())
    }

    /// Messages that the program has rejected, by its heartbeat.
    fn rejected(&mut self) -> u64 {
        self.bench.poll();
        self.bench.beats.last().map_or(0, |(_, beat)| beat.refused)
    }

    fn pid(&self) -> u32 {
        let child = self.bench.child.as_ref();
        child.map_or(0, zeronav_supervise::Child::pid)
    }

    /// Memory of the program's own. [bytes]
    fn memory_bytes(&self) -> u64 {
        let file = format!("/proc/{}/status", self.pid());
        let status = std::fs::read_to_string(file).unwrap_or_default();
        let line = status
            .lines()
            .find_map(|line| line.strip_prefix("RssAnon:"));
        let kibibytes =
            line.and_then(|line| line.trim().trim_end_matches("kB").trim().parse().ok());
        kibibytes.map_or(0, |kibibytes: u64| kibibytes * 1024)
    }

    fn stop(&mut self) -> Result<String, String> {
        let started = Instant::now();
        let mut patience = Patience::with(self.pid());
        self.bench.signal(Signal::TERM);
        let _ = self.bench.wait(END_WALL_LIMIT, |bench| {
            bench.ended().is_some() || patience.is_over(STOP_LIMIT)
        });
        let took_ms = started.elapsed().as_millis();
        match self.bench.ended() {
            Some(status) if status.code() == Some(0) => {
                Ok(format!("SIGTERM: exit code 0 after {took_ms} ms"))
            }
            Some(status) => Err(format!("SIGTERM: {status}")),
            None => Err("it did not end within 2 s of its own time after SIGTERM".to_owned()),
        }
    }

    /// Launch goes; the robot drives on until the program stops it.
    fn orphan(mut self) -> Result<String, String> {
        for _ in 0..ORPHAN_TICKS {
            self.step(Missing::Nothing);
        }
        self.bench.leave_launch();
        let started = Instant::now();
        let mut patience = Patience::with(self.pid());
        let mut ended = None;
        while ended.is_none()
            && !patience.is_over(ORPHAN_LIMIT)
            && started.elapsed() < END_WALL_LIMIT
        {
            self.tick += 1;
            self.next = (self.next + Duration::from_nanos(TICK_NS)).max(Instant::now());
            self.bench
                .others
                .send_without_launch(self.tick, &self.robot);
            self.pass();
            ended = self.bench.ended();
        }
        let took_ms = started.elapsed().as_millis();
        self.bench.poll();
        let (v_mps, w_radps) = wanted(&self.bench, &self.robot, self.tick);
        let role = self.bench.program.role;
        let at_the_wheels = matches!(role, Role::LocalPlanner | Role::CollisionGuard);
        self.bench.close();
        match ended {
            None => Err(format!("launch was gone, and it ran on for {took_ms} ms")),
            Some(status) if status.code() != Some(0) => Err(format!("launch was gone: {status}")),
            Some(_) if at_the_wheels && (v_mps.abs() > 0.02 || w_radps.abs() > 0.05) => {
                Err(format!("it left the robot at {v_mps} m/s, {w_radps} rad/s"))
            }
            Some(_) => Ok(format!(
                "launch gone: exit code 0 after {took_ms} ms, robot at rest"
            )),
        }
    }
}

fn grown(before: u64, after: u64) -> Result<String, String> {
    let (grown, limit) = (after.saturating_sub(before) >> 10, GROWTH_BYTES_MAX >> 10);
    if before == 0 || after == 0 {
        return Err("its memory could not be read".to_owned());
    }
    if grown <= limit {
        Ok(format!(
            "hostile messages added {grown} kB, the limit is {limit} kB"
        ))
    } else {
        Err(format!(
            "hostile messages added {grown} kB, more than {limit} kB"
        ))
    }
}

/// Time from an input to the first answer to it or to a later one. [ns]
fn since((tick, sent_ns): (u64, u64), answers: &[(u64, u64)]) -> u64 {
    let answer = answers.iter().find(|(answered, _)| *answered >= tick);
    answer.map_or(u64::MAX, |(_, answered_ns)| {
        answered_ns.saturating_sub(sent_ns)
    })
}

fn in_ms(time_ns: u64) -> String {
    if time_ns == u64::MAX {
        return "never".to_owned();
    }
    format!("{:.2} ms", 1.0e3 * zeronav_msgs::time::seconds(time_ns))
}
