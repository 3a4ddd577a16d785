//! The guard beside an oracle: slow, simple and written apart from the guard and from
//! `zeronav_motion`. Random robots, scans, odometry, requests and limits; whatever the guard lets
//! through must keep the clearance that its README promises, at every moment of each stop.

#![allow(clippy::print_stdout, reason = "seeds and counts of a run")]

mod draw;
mod past;
mod slow;

use draw::Draw;
use slow::{Hit, Obeyed, Outline, Robot, Stop};
use zeronav_collision_guard::{Guard, GuardConfig, GuardInputs, OdometryInput, ScanInput};
use zeronav_msgs::command::{Intervention, Validity};

/// Calls with one robot, one guard and one configuration.
const CALLS_EACH: u64 = 100;

/// Shares of the reaction time after which the README lets braking begin.
const STARTS: [f64; 3] = [0.25, 0.6, 1.0];

/// [m] Half of what the README lets the outline move between two looks.
const BETWEEN_M: f64 = 0.01;

/// What came of many calls.
#[derive(Debug, Default)]
struct Tally {
    calls: u64,
    passed: u64,
    slowed: u64,
    stopped: u64,
    /// Passed, with a hit that the same request at full speed would have touched.
    mattered: u64,
    /// Passed to a robot that obeys late.
    late: u64,
    /// Hits that were dust.
    dust: u64,
    /// [m] least clearance beyond what is promised.
    spare_m: Option<f64>,
    unsafe_calls: Vec<String>,
}

impl Tally {
    fn add(&mut self, other: Self) {
        self.calls += other.calls;
        self.passed += other.passed;
        self.slowed += other.slowed;
        self.stopped += other.stopped;
        self.mattered += other.mattered;
        self.late += other.late;
        self.dust += other.dust;
        self.spare_m = self
            .spare_m
            .into_iter()
            .chain(other.spare_m)
            .reduce(f64::min);
        self.unsafe_calls.extend(other.unsafe_calls);
    }
}

/// What a hit may come down to: the margin, or what there is now if that is less. Points inside the
/// outline count one by one. [m]
fn promised_m(outline: &Outline, hits: &[Hit], margin_m: f64) -> Vec<f64> {
    let now: Vec<f64> = hits.iter().map(|hit| outline.distance_m(*hit)).collect();
    let least_m = now.iter().copied().fold(f64::INFINITY, f64::min);
    let of = |now_m: f64| if least_m > 0.0 { least_m } else { now_m };
    now.into_iter()
        .map(|now_m| margin_m.min(of(now_m)))
        .collect()
}

/// [m] by which all hits stay clear of what is promised on the stops from `from` by `command`, which
/// takes effect when the commands on their way, each with its end [s], have been obeyed; negative =
/// unsafe. What may happen between two looks of the guard is `between_m`.
fn spare_m(
    robot: &Robot,
    hits: &[Hit],
    (from, on_their_way, command): ([f64; 2], &[Obeyed], [f64; 2]),
    config: &GuardConfig,
    between_m: f64,
) -> f64 {
    let effect_s = on_their_way.last().map_or(0.0, |last| last.1);
    let promised = promised_m(&robot.outline, hits, config.margin_m);
    let mut least_m = f64::INFINITY;
    for share in STARTS {
        let own = (command, effect_s + share * config.reaction_s);
        let commands: Vec<_> = on_their_way.iter().copied().chain([own]).collect();
        let stop = Stop::new(robot, from, &commands);
        for (hit, promised_m) in hits.iter().zip(&promised) {
            let keep_m = promised_m - between_m;
            least_m = least_m.min(stop.least_beyond_m(&robot.outline, *hit, keep_m));
        }
    }
    least_m
}

/// Calls with one random robot.
fn some_calls(seed: u64) -> Tally {
    let mut draw = Draw::new(seed);
    let mut guard = Guard::new(draw.config);
    let mut tally = Tally::default();
    for call in 0..CALLS_EACH {
        draw.step();
        let command = guard.decide(&GuardInputs {
            robot: Some((&draw.description, &draw.corners)),
            request: Some((draw.request, 1_000_000)),
            scan: Some(ScanInput {
                scan: &draw.scan,
                ranges: &draw.ranges,
                id: draw.scan_id,
                run_ns: draw.scan_ns,
                age_ns: draw.run_ns - draw.scan_ns,
                odom_from_base: Some(draw.scan_pose),
            }),
            odometry: Some(OdometryInput {
                odometry: &draw.odometry,
                id: call + 1,
                run_ns: draw.run_ns,
                age_ns: 0,
            }),
            period_ns: draw::PERIOD_NS,
            stopping: false,
        });
        tally.calls += 1;
        let on_their_way = draw.on_their_way();
        draw.sent(command.v_mps, command.w_radps);
        let by = command.intervention().expect("a known intervention");
        tally.stopped += u64::from(by == Intervention::StoppedShort);
        assert!(
            draw.holds(command.v_mps, command.w_radps),
            "seed {seed}, call {call}: beyond the limits: {command:?}"
        );
        if command.validity() != Some(Validity::Drive) {
            continue;
        }
        tally.passed += 1;
        let hits = draw.hits_in_base();
        let from = [draw.odometry.v_mps, draw.odometry.w_radps];
        let sent = [command.v_mps, command.w_radps];
        if by == Intervention::Slowed {
            tally.slowed += 1;
            let asked = (from, on_their_way.as_slice(), draw.clamped());
            tally.mattered +=
                u64::from(spare_m(&draw.robot, &hits, asked, &draw.config, 0.0) < 0.0);
        }
        tally.late += u64::from(!on_their_way.is_empty());
        let way = (from, on_their_way.as_slice(), sent);
        let spare_m = spare_m(&draw.robot, &hits, way, &draw.config, BETWEEN_M);
        tally.spare_m = Some(
            tally
                .spare_m
                .map_or(spare_m, |least_m| least_m.min(spare_m)),
        );
        if spare_m < 0.0 {
            let why = format!("seed {seed}, call {call}: {spare_m:.6} m beyond, {by:?} {sent:?}");
            tally.unsafe_calls.push(why);
        }
    }
    tally.dust = draw.dust;
    tally
}

/// So many calls from the seeds from `first` on, on so many threads.
fn calls(first: u64, n: u64, threads: u64) -> Tally {
    let seeds = n.div_ceil(CALLS_EACH);
    let mut all = Tally::default();
    std::thread::scope(|scope| {
        let part = |thread: u64| {
            scope.spawn(move || {
                let mut tally = Tally::default();
                let mine = (thread..seeds).step_by(usize::try_from(threads).unwrap_or(1));
                mine.for_each(|seed| tally.add(some_calls(first + seed)));
                tally
            })
        };
        let parts: Vec<_> = (0..threads).map(part).collect();
        for part in parts {
            all.add(part.join().expect("a thread that ends"));
        }
    });
    println!(
        "{} calls, seeds {first} to {}: {} let through, {} of them to robots that obey late, {} slowed \
         ({} would have come too near), {} stopped; {} hits were dust; least spare {:.6} m; {} unsafe",
        all.calls,
        first + seeds - 1,
        all.passed,
        all.late,
        all.slowed,
        all.mattered,
        all.stopped,
        all.dust,
        all.spare_m.unwrap_or(f64::INFINITY),
        all.unsafe_calls.len()
    );
    let some: Vec<&String> = all.unsafe_calls.iter().take(10).collect();
    assert!(some.is_empty(), "{some:#?}");
    assert!(all.passed > n / 10, "hardly anything was let through");
    assert!(all.dust > n / 50, "hardly any hit was dust");
    assert!(all.late > n / 50, "hardly any robot obeyed late");
    assert!(all.stopped + all.slowed > n / 10, "nothing was at stake");
    all
}

#[test]
fn what_the_guard_lets_through_is_safe_for_the_oracle() {
    calls(1_000_000, 20_000, 1);
}

/// A robot that speeds up faster than it brakes turns round: beyond rest it is faster than its brakes
/// alone would make it. A sweep whose steps went on through rest let these two come up to 16 mm
/// nearer than promised, and one of them into contact.
#[test]
fn reversing_is_swept_at_the_acceleration_that_holds_beyond_rest() {
    for seed in [1310, 3530] {
        assert_eq!(some_calls(seed).unsafe_calls, Vec::<String>::new());
    }
}

/// `ZERONAV_ORACLE_CALLS` is another number than ten million, `ZERONAV_ORACLE_SEED` another first seed
/// than 0: with both, what a line of a failure names is played again.
#[test]
#[ignore = "takes about an hour"]
fn ten_million_calls_are_safe_for_the_oracle() {
    let asked = |name, default| {
        let asked = std::env::var(name).ok();
        asked.map_or(default, |text| text.parse().expect("a number"))
    };
    let n = asked("ZERONAV_ORACLE_CALLS", 10_000_000);
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get() as u64);
    calls(asked("ZERONAV_ORACLE_SEED", 0), n, threads);
}
