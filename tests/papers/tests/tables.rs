//! The tables that need no stack, on few maps: complete, without a broken theorem, in every format.

use zeronav_papers::claims::claims;
use zeronav_papers::maps::MapFamily;
use zeronav_papers::page::{headline, page};
use zeronav_papers::report::{Format, Report};
use zeronav_papers::row::Row;
use zeronav_papers::table::Context;
use zeronav_papers::tables::TABLES;
use zeronav_papers::verdict::Verdict;

const SEEDS: u64 = 20;

#[test]
fn every_table_without_the_stack_is_complete_on_twenty_maps() {
    let mut context = Context {
        seeds: SEEDS,
        drives: 0,
        seed: 1,
        families: vec![MapFamily::Blocky, MapFamily::Iid],
        stack: None,
    };
    let (mut rows, mut drawn) = (Vec::new(), 0);
    for table in TABLES.iter().filter(|table| !table.is_driven) {
        let outcome = (table.run)(&mut context)
            .unwrap_or_else(|error| panic!("{} {}: {error}", table.paper, table.number));
        assert!(!outcome.rows.is_empty(), "{} {}", table.paper, table.number);
        for row in &outcome.rows {
            assert_eq!((&*row.paper, &*row.table), (table.paper, table.number));
            assert!((0.0..=1.0).contains(&row.excluded), "{row:?}");
            assert!(row.acceptance > 0.0 && row.acceptance <= 1.0, "{row:?}");
            if let (Some(ours), Some([low, high])) = (row.ours, row.interval) {
                assert!(low <= ours + 1e-9 && ours <= high + 1e-9, "{row:?}");
            }
        }
        drawn += usize::from(outcome.drawing.is_some());
        rows.extend(outcome.rows);
    }
    assert!(drawn >= 12, "{drawn} pictures");
    // What no number of maps changes.
    for row in rows
        .iter()
        .filter(|row| row.claim == "C1" && row.algorithm == "IAA = Dijkstra")
    {
        assert_eq!((row.verdict, row.ours), (Verdict::Theorem, Some(1.0)));
    }
    are_beside_each_other(&rows);
    let driven = |table: &str| {
        TABLES
            .iter()
            .any(|known| known.number == table && known.is_driven)
    };
    for claim in claims().filter(|claim| !driven(&claim.headline.table)) {
        let row = headline(claim, &rows);
        assert!(
            row.is_some_and(|row| row.n > 0),
            "{} {} has no row",
            claim.paper,
            claim.id
        );
    }
    let report = Report {
        seeds: SEEDS,
        drives: 0,
        seed: 1,
        revision: "a revision".to_owned(),
        machine: "a machine".to_owned(),
        command: "papers --all --no-drives".to_owned(),
        wall_s: 1.0,
        rows,
    };
    let json: serde_json::Value =
        serde_json::from_str(&report.print(Format::Json).unwrap()).unwrap();
    assert_eq!(
        json["rows"].as_array().map(Vec::len),
        Some(report.rows.len())
    );
    assert_eq!(
        report.print(Format::Csv).unwrap().lines().count(),
        report.rows.len() + 1
    );
    let text = page(&report);
    for method in ["tn", "ju", "zm", "lwx", "bao"] {
        assert!(text.contains(&format!("`{method}`")) || text.contains(&format!("--as {method}")));
    }
    for claim in claims() {
        assert!(
            text.contains(&claim.why),
            "{} {} is not told",
            claim.paper,
            claim.id
        );
    }
}

/// What a claim is measured for stands in rows of its own: the readings of a text, both bases, and what is
/// said without a table.
fn are_beside_each_other(rows: &[Row]) {
    let has = |paper: &str, claim: &str, metric: &str, algorithm: &str, is_printed: bool| {
        let found = rows.iter().any(|row| {
            (&*row.paper, &*row.claim, &*row.metric) == (paper, claim, metric)
                && row.algorithm == algorithm
                && row.n > 0
                && row.printed.is_some() == is_printed
        });
        assert!(found, "{paper} {claim} has no {metric} of {algorithm}");
    };
    for reading in ["memoryless", "visited", "backtracking"] {
        let name = format!("hybrid, {reading} vs A*");
        for (claim, metric) in [("C1", "cells examined"), ("C2", "time"), ("C3", "length")] {
            has("TN", claim, metric, &name, true);
        }
        let matched = format!("{name}, same corners");
        has("TN", "C3", "length", &matched, true);
        has("TN", "C6", "turning points", &name, false);
        has(
            "TN",
            "C7",
            "success (share)",
            &format!("hybrid, {reading}"),
            true,
        );
    }
    // The printed figures of the robot are against A*; Dijkstra was its planner before.
    for metric in ["length", "time"] {
        has("TN", "C5", metric, "hybrid with ladder vs A*", true);
        has("TN", "C5", metric, "hybrid with ladder vs Dijkstra", false);
    }
    has("JU", "C6", "length", "A* vs APF", true);
    let metric = "a step within a control period of 20 ms (share)";
    has("JU", "C7", metric, "fusion", true);
    has("ZM", "C6", "time", "H_W_A* vs TRA_A*", true);
    has("ZM", "C6", "time", "IM_APF_A* vs TRA_A*", true);
    has("ZM", "C7", "turning points", "IM_APF_A* vs TRA_A*", false);
    has("LWX", "C8", "time", "fusion vs A*", true);
    let greedy = "fusion vs its greedy path";
    has("LWX", "C9", "inflection points", greedy, false);
    has("LWX", "C10", "min_clearance", greedy, false);
    has("LWX", "C11", "arrives (share)", "fusion", true);
    has("BAO", "C10", "time", "IAA vs AAO", true);
    has("BAO", "C11", "length", "IAA vs full inflation", true);
    has("BAO", "C11", "time", "IAA vs full inflation", true);
    has("BAO", "C12", "moving grids", "IAA vs AAO", true);
    // Said without a number, and judged all the same.
    let judged = |row: &&Row| !matches!(row.verdict, Verdict::NotComparable | Verdict::TooFew);
    for (paper, claim) in [("TN", "C6"), ("ZM", "C7"), ("LWX", "C9"), ("LWX", "C10")] {
        let of = rows
            .iter()
            .filter(|row| row.paper == paper && row.claim == claim);
        assert!(
            of.filter(judged).count() > 0,
            "{paper} {claim} is not judged"
        );
    }
}

#[test]
fn rows_are_the_same_for_the_same_seed() {
    let measure = || {
        let mut context = Context {
            seeds: 5,
            drives: 0,
            seed: 3,
            families: vec![MapFamily::Blocky],
            stack: None,
        };
        let outcome = (TABLES[0].run)(&mut context).unwrap();
        let rows = outcome.rows.into_iter().filter(|row| row.metric != "time");
        rows.collect::<Vec<_>>()
    };
    assert_eq!(measure(), measure());
}
