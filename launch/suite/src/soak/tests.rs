use super::super::case::Case;
use super::super::journal::{Journal, Order};
use super::super::plan::{Setup, SuitePlan};
use super::super::soaked::Soaked;
use super::super::soaked::verdict::{End, SoakReport, Totals, Verdict};
use super::drives::{Drive, REAL_TIME_EVERY, SWAPS_EVERY};
use super::{Budget, inner};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};
use zeronav_files::Folder;
use zeronav_scenario::{ForesightSpec, KINDS, Scenario, mortals};

fn plan(out: &tempfile::TempDir) -> SuitePlan {
    SuitePlan {
        hours: Some(2.0),
        out: out.path().to_owned(),
        ..SuitePlan::of("soak")
    }
}

#[test]
fn a_number_is_a_drive_and_every_seat_and_kind_of_fault_comes_soon() {
    /// Drives after which every seat has died in both ways.
    const SOON: u32 = 5;
    let (mut kinds, mut places, mut swapped) = (BTreeSet::new(), Vec::new(), BTreeSet::new());
    let mut hits = BTreeSet::new();
    for number in 0..40 {
        let drive = Drive::of(number);
        assert_eq!(drive, Drive::of(number), "seed {number}");
        assert_ne!(drive.faults, Drive::of(number + 1).faults);
        assert_eq!(drive.is_real_time(), number % REAL_TIME_EVERY == 3);
        assert_eq!(drive.swaps.is_empty(), number % SWAPS_EVERY != 4);
        if number < SOON {
            let deaths = drive.faults.iter();
            hits.extend(deaths.map(|fault| (fault.kind(), fault.role())));
        }
        kinds.extend(
            drive
                .faults
                .iter()
                .map(|fault| (drive.is_real_time(), fault.kind())),
        );
        swapped.extend(drive.swaps.iter().map(|swap| swap.service.clone()));
        if !places.contains(&drive.place) {
            places.push(drive.place);
        }
    }
    for role in mortals() {
        for kind in ["kill", "stop"] {
            assert!(hits.contains(&(kind, Some(role))), "no {kind} of {role}");
        }
    }
    for kind in KINDS.into_iter().filter(|kind| kind.is_drawn) {
        assert!(kinds.contains(&(true, kind.name)), "{}", kind.name);
        let in_lockstep = kinds.contains(&(false, kind.name));
        assert_eq!(in_lockstep, kind.lockstep, "{}", kind.name);
    }
    // What would disturb every program on the machine is left to the tests that have one of their own.
    assert!(
        kinds
            .iter()
            .all(|(_, kind)| !["fill_shm", "disk_full"].contains(kind))
    );
    assert_eq!((places.len(), swapped.len()), (6, 4));
}

#[test]
fn drives_are_scenarios_that_can_be_driven_with_their_faults_and_without() {
    let out = tempfile::tempdir().expect("a folder");
    let plan = plan(&out);
    let folder = Folder::open(out.path()).expect("a folder");
    let (scenarios, temp) = (inner(&folder, "scenarios"), inner(&folder, "temp"));
    let (scenarios, temp) = (scenarios.expect("a folder"), temp.expect("a folder"));
    let setup = Setup {
        plan: &plan,
        controller: None,
        scenarios: &scenarios,
    };
    let mut places = Vec::new();
    for number in 0.. {
        let drive = Drive::of(number);
        if places.contains(&drive.place) && (drive.swaps.is_empty() || number > 9) {
            continue;
        }
        let load = |case: &Case| {
            let name = case.scenario.display().to_string();
            let scenario = Scenario::load(&name).expect("a scenario");
            scenario.validate().expect("a drive");
            scenario
        };
        let case = drive.case(&setup, &temp, false).expect("a case");
        let calm = drive.case(&setup, &temp, true).expect("a case");
        assert_ne!(case.manner.temp, calm.manner.temp);
        assert_eq!((case.seed, &case.world), (calm.seed, &calm.world));
        let (loud, quiet) = (load(&case), load(&calm));
        assert_eq!((&loud.faults, &loud.swaps), (&drive.faults, &drive.swaps));
        assert!(quiet.faults.is_empty() && quiet.swaps.is_empty());
        assert_eq!((&loud.goals, loud.start), (&quiet.goals, quiet.start));
        places.push(drive.place);
        if places.len() > 6 {
            break;
        }
    }
}

fn order() -> Order {
    Order {
        suite: "soak".to_owned(),
        controller: None,
        settings: zeronav_scenario::settings::Settings::default(),
        seeds: 1,
        worlds: None,
        noise: "default".to_owned(),
        foresight: ForesightSpec::default(),
        data: None,
        hours: Some(1.0),
        build: "00ff".to_owned(),
        shard: None,
    }
}

#[test]
fn wall_time_counts_over_all_calls_and_another_budget_is_the_same_soak() {
    let out = tempfile::tempdir().expect("a folder");
    let folder = Folder::open(out.path()).expect("a folder");
    let mut first = Journal::begin(&folder, &order()).expect("a journal");
    assert!(first.used_s().abs() < 1e-12);
    first.use_up(1000.0).expect("written");
    first.use_up(1800.0).expect("written");
    drop(first);
    let (begun, mut second) = Journal::resume(out.path()).expect("a journal");
    assert!((second.used_s() - 1800.0).abs() < 1e-9);
    let longer = Order {
        hours: Some(3.0),
        ..order()
    };
    assert!(begun.is_same(&order()) && begun.is_same(&longer));
    let other = Order {
        build: "0100".to_owned(),
        shard: None,
        ..order()
    };
    assert!(!begun.is_same(&other));
    let budget = |before_s: f64, ago_s: u64| Budget {
        hours: 1.0,
        before_s,
        since: Instant::now()
            .checked_sub(Duration::from_secs(ago_s))
            .expect("a machine that has been up for so long"),
    };
    assert!(!budget(second.used_s(), 2).is_used_up());
    second.use_up(budget(3598.0, 3).used_s()).expect("written");
    drop(second);
    let (_, third) = Journal::resume(out.path()).expect("a journal");
    assert!(budget(third.used_s(), 0).is_used_up(), "{}", third.used_s());
}

/// A drive with this many faults, and this many restarts of each seat.
fn drive(faults: u64, restarts: u64) -> Soaked {
    Soaked {
        mode: "lockstep".to_owned(),
        arrived: true,
        outcome: Some("reached".to_owned()),
        kinds: [("kill".to_owned(), faults)].into(),
        restarts: mortals().map(|role| (role.to_string(), restarts)).collect(),
        ..Soaked::default()
    }
}

fn verdict_of(report: &SoakReport, name: &str) -> (u64, Verdict) {
    let of_name = report
        .criteria
        .iter()
        .find(|criterion| criterion.name == name);
    let criterion = of_name.expect("a criterion");
    (criterion.found, criterion.verdict)
}

#[test]
fn every_count_has_its_verdict() {
    let report = |drives: Vec<Soaked>| SoakReport::new(End::Hours, (1.0, 3600.0), drives);
    let enough = report(vec![drive(600, 500), drive(600, 500)]);
    assert_eq!(enough.verdict, Verdict::Met, "{enough:?}");
    let contacts = enough
        .criteria
        .iter()
        .find(|it| it.name == "contacts of own fault");
    // 1 - 0.05^(1/1200): about 3 / n.
    let upper_95 = contacts.and_then(|it| it.upper_95).expect("a bound");
    assert!((upper_95 - 0.002_493).abs() < 1e-6, "{upper_95}");

    let few = report(vec![drive(600, 500), drive(300, 600)]);
    assert_eq!(few.verdict, Verdict::Open);
    assert_eq!(verdict_of(&few, "faults"), (900, Verdict::Open));
    assert_eq!(
        verdict_of(&few, "restarts of mapping"),
        (1100, Verdict::Met)
    );

    let lost = |outcome: Option<&str>, arrives_without_faults| Soaked {
        arrived: false,
        outcome: outcome.map(str::to_owned),
        arrives_without_faults,
        ..drive(1000, 1000)
    };
    let bad = report(vec![
        Soaked {
            contacts_own_fault: 2,
            left: vec!["/dev/shm/zn_0123456789".to_owned()],
            unasked: vec!["mapping at 3.00 s: exit code 101".to_owned()],
            ..drive(1000, 1000)
        },
        lost(Some("stuck"), Some(true)),
        lost(Some("unreachable"), None),
        lost(Some("timeout"), Some(false)),
        lost(None, Some(true)),
    ]);
    assert_eq!(bad.verdict, Verdict::NotMet);
    for (name, found) in [
        ("contacts of own fault", 2),
        ("stuck", 2),
        ("failed", 1),
        ("left over", 1),
    ] {
        assert_eq!(verdict_of(&bad, name), (found, Verdict::NotMet), "{name}");
    }
    assert_eq!((bad.totals.hopeless, bad.totals.unasked), (1, 1));
    let mut page = String::new();
    bad.write(&mut page);
    assert!(page.contains("/dev/shm/zn_0123456789"), "{page}");

    assert_eq!(
        report(Vec::new()).verdict,
        Verdict::Open,
        "nothing was driven"
    );
}

#[test]
fn a_soak_is_enough_when_the_seat_with_the_fewest_restarts_has_enough() {
    let mut totals = Totals::default();
    totals.add(&drive(1000, 999));
    assert!(!totals.is_enough());
    let mut one_seat = drive(1, 1);
    one_seat.restarts.retain(|seat, _| seat == "mapping");
    totals.add(&one_seat);
    assert!(!totals.is_enough(), "the other seats have 999");
    totals.add(&drive(1, 1));
    assert!(totals.is_enough(), "{totals:?}");
}
