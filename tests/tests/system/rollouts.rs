//! `debug/rollouts` on the real stack: who reads it is told what the local planner looked at, nobody
//! else costs anything, and the run is the same.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use zeronav_msgs::command::Validity;
use zeronav_msgs::header::Id;
use zeronav_msgs::role::Role;
use zeronav_msgs::rollouts::{Rollout, RolloutOutcome, Rollouts};
use zeronav_msgs::topics::{ControlRequest, DebugRollouts, GroundTruth, Topic};
use zeronav_shell::roster_reader::RosterReader;
use zeronav_shell::{Domain, Peer, Stream};
use zeronav_tests::{Zeronav, leftovers, zeronav};

/// Between two looks at most: a queue holds 32 messages.
const PAUSE: Duration = Duration::from_micros(500);

/// No run needs longer.
const LIMIT: Duration = Duration::from_secs(120);

/// Up and down an aisle for minutes of run time.
fn start() -> Zeronav {
    let goals = (0..40).map(|leg| {
        let x_m = if leg % 2 == 0 { 12.5 } else { 5.0 };
        format!("[[goals]]\npose = [{x_m}, 6.425, 0.0]\nyaw_tolerance_rad = 3.15\n")
    });
    let text = "title = \"test\"\nbase = [\"warehouse\", \"porter\"]\n\
                start = [4.0, 6.425, 0.0]\n[run]\ntime_limit_s = 1000.0\n"
        .to_owned()
        + &goals.collect::<String>();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    Zeronav::start_in(folder, &arguments)
}

/// A message with its header's identity and that of the request.
struct Told {
    id: Id,
    request: u64,
    meta: Rollouts,
    rollouts: Vec<Rollout>,
}

/// What a guest has heard, by tick.
#[derive(Default)]
struct Heard {
    told: BTreeMap<u64, Told>,
    requests: BTreeMap<u64, (u64, Option<Validity>)>,
    places: BTreeMap<u64, (f64, f64)>,
}

/// A guest that reads the topic and what it is compared with.
struct Guest {
    rollouts: Stream<DebugRollouts>,
    requests: Stream<ControlRequest>,
    truth: Stream<GroundTruth>,
    roster: RosterReader,
    peer: Peer,
}

impl Guest {
    fn join(root: &Path) -> Self {
        let peer = Peer::join(Domain::join(root).expect("the domain"), Role::Tap, 1);
        let peer = peer.expect("a place");
        let mut roster = RosterReader::open(&peer).expect("the roster");
        roster.await_known().expect("the roster, which is latched");
        Self {
            requests: peer.stream().expect("a reader"),
            truth: peer.stream().expect("a reader"),
            rollouts: peer.stream().expect("a reader"),
            roster,
            peer,
        }
    }

    /// Listens until so many messages have come since it joined.
    fn ingest(&mut self, heard: &mut Heard, least: usize) {
        let (began, before) = (Instant::now(), heard.told.len());
        while heard.told.len() < before + least {
            assert!(began.elapsed() < LIMIT, "{} messages", heard.told.len());
            self.roster.poll();
            let roster = self.roster.roster();
            self.requests.drain(roster, |view| {
                let request = (view.header.id, view.meta.validity());
                heard.requests.insert(view.header.tick, request);
            });
            self.truth.drain(roster, |view| {
                let at = (view.meta.pose.x_m, view.meta.pose.y_m);
                heard.places.insert(view.header.tick, at);
            });
            self.rollouts.drain(roster, |view| {
                let told = Told {
                    id: view.header.id(),
                    request: view.header.parents.request,
                    meta: *view.meta,
                    rollouts: view.items.to_vec(),
                };
                let twice = heard.told.insert(view.header.tick, told);
                assert!(twice.is_none(), "tick {} twice", view.header.tick);
            });
            std::thread::sleep(PAUSE);
        }
    }

    fn leave(self) {
        let Self {
            peer,
            roster,
            rollouts,
            requests,
            truth,
        } = self;
        drop((roster, rollouts, requests, truth));
        let _ = peer.leave().close();
    }
}

/// A message against what else was sent in its tick.
fn check(heard: &Heard, tick: u64, told: &Told) {
    let (meta, rollouts) = (&told.meta, &told.rollouts);
    assert_eq!(meta.check(rollouts), Ok(()), "tick {tick}");
    assert!(meta.n_looked_at > 0, "tick {tick}");
    let is_chosen = |one: &&Rollout| one.outcome() == Some(RolloutOutcome::Chosen);
    let chosen = rollouts.iter().filter(is_chosen).count();
    if let Some((id, validity)) = heard.requests.get(&tick) {
        assert_eq!(
            told.request, *id,
            "tick {tick}: the request that it explains"
        );
        if *validity == Some(Validity::Drive) {
            assert_eq!(chosen, 1, "tick {tick}");
        }
    }
    let here = &meta.map_from_base;
    if let Some((x_m, y_m)) = heard.places.get(&tick) {
        let away_m = (here.x_m - x_m).hypot(here.y_m - y_m);
        assert!(away_m < 0.2, "tick {tick}: {away_m} m from the robot");
    }
    for rollout in rollouts {
        let [x_m, y_m] = rollout.points_m().next().expect("a point");
        let away_m = (f64::from(x_m) - here.x_m).hypot(f64::from(y_m) - here.y_m);
        assert!(
            away_m < 1e-4,
            "tick {tick}: begins {away_m} m from the robot"
        );
    }
}

#[test]
fn who_reads_rollouts_gets_them_and_the_run_is_the_same() {
    let alone = start().finish().expect(0);
    let mut run = start();
    let passed_s = |run: &Zeronav| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().unwrap_or(0.0)
    };
    run.wait_until("the robot drives", |run| passed_s(run) > 10.0);
    let root = run.domains().pop().expect("a domain");
    let mut heard = Heard::default();
    let mut guest = Guest::join(&root);
    guest.ingest(&mut heard, 200);
    guest.leave();
    let (first, last) = (heard.told.iter().next(), heard.told.iter().next_back());
    let (first, last) = (first.expect("one").1.id, last.expect("one").1.id);
    // Five hundred ticks have passed; a few messages may be missed.
    let before = first.count();
    assert!(before < 250, "{before} were made before anybody read them");

    // While nobody reads none are made, for two thousand ticks.
    let left_s = passed_s(&run);
    run.wait_until("time has passed", |run| passed_s(run) > left_s + 40.0);
    let mut again = Heard::default();
    let mut guest = Guest::join(&root);
    guest.ingest(&mut again, 50);
    guest.leave();
    let next = again.told.values().next().expect("one").id;
    let made = next.count() - last.count();
    assert!((1..1000).contains(&made), "{made} were made for nobody");

    let result = run.finish().expect(0);
    assert_eq!(result["reached"], true, "{result:#}");
    assert!(alone["run_hash"].is_string(), "{alone:#}");
    assert_eq!(alone["run_hash"], result["run_hash"]);
    let (mut explained, mut placed) = (0, 0);
    for of in [&heard, &again] {
        for (tick, told) in &of.told {
            check(of, *tick, told);
            explained += u32::from(of.requests.contains_key(tick));
            placed += u32::from(of.places.contains_key(tick));
        }
    }
    // Ground truth comes with every fifth tick.
    assert!(explained > 100 && placed > 20, "{explained}, {placed}");
    assert_eq!(leftovers(&root), Vec::<PathBuf>::new());
}

#[test]
fn rollouts_are_shown_like_any_other_topic() {
    let mut run = start();
    run.wait_until("the robot drives", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().is_some_and(|time_s| time_s > 2.0)
    });
    let root = run.domains().pop().expect("a domain");
    let root = root.to_str().expect("a path");
    let name = DebugRollouts::ROW.name;
    let echo = [
        "topics", "--domain", root, "echo", name, "-n", "3", "--json",
    ];
    let echoed = zeronav(&echo);
    assert_eq!(echoed.code(), 0, "{}", echoed.stderr);
    let mut lines = echoed.stdout.lines();
    let last = lines.next_back().expect("a message");
    let message: serde_json::Value = serde_json::from_str(last).expect("JSON");
    let items = message["items"].as_array().expect("rollouts");
    assert_eq!(message["fields"]["n_rollouts"], items.len());
    assert_eq!(message["header"]["role"], "local_planner");
    assert_eq!(message["units"]["fields.map_from_base.x_m"], "m");
    let chosen = items.iter().filter(|one| one["outcome"] == "chosen");
    assert!(chosen.count() <= 1, "{message:#}");
    assert!(
        items.iter().all(|one| one["x_m"][0].is_number()),
        "{message:#}"
    );
}
