//! The page of all claims, written from the rows.

use crate::claims::{Claim, Judged, claims, papers};
use crate::report::{Report, is_change, number};
use crate::row::Row;
use std::fmt::Write as _;

/// Head of the page.
const HEAD: &str = "# The papers' claims, measured

Five papers gave this project its algorithms. None gives its maps, so that no table can be repeated cell by cell;
what can be tested is the claim, on many random maps of the printed size. This page is written by

    cargo run --release --bin papers -- --all --seeds SEEDS --drives DRIVES --page tests/papers/README.md

and nobody edits it by hand.

A change is (ours - base) / base, the mean over maps that both sides solve, with a 95 % interval by bootstrap; a
share has Wilson's. The verdicts:

- **Reproduced**: the printed sign, an interval without zero, half to twice the printed size. A count: within a factor
  of two. A share: within five points. \"About the same\": the interval within a quarter more and a fifth less. What is
  said of all maps: no counterexample.
- **Qualitative**: the same sign, another size, or no size printed. A count: within a factor of three. \"About the same\":
  within twice and half.
- **Not reproduced**: zero in the interval, the other sign, or one map against what is said of all.
- **Artefact**: only with a fault of the printed method switched on, and not without.
- **Theorem**: it cannot be otherwise, and was checked on every map.
- **Not comparable**: no number is printed, or the setup is missing.
- **Too few maps**: fewer than ten could be counted.

\"Excluded\" is the share of the maps that one of the two sides did not solve; of a time, of the maps that were timed.
The summary shows the figures of one row of each claim and what all of them say: their verdict where they agree, \"not
reproduced\" where one stands against what is said of all maps, and else how many came out how. Times are ratios between
programs of the same making, never seconds; those of the papers are MATLAB's.

";

/// Foot of the page.
const FOOT: &str = "## Using it

    cargo run --release --bin papers -- --list
    cargo run --release --bin papers -- --paper BAO --table 3 --seeds 200
    cargo run --release --bin papers -- --all --format json --out papers
    cargo run --release --bin papers -- --feature ZM-ESC

`--out FOLDER` leaves `rows.md`, `rows.csv`, `rows.json` and for each table a picture of one map with all ways, and the
ways themselves in [BAO]'s numbering of cells (`.csv`); `--rows FOLDER/rows.json` prints them or their page again. Maps are
not stored: `seed`, `maps` and `zeronav_world::generate` draw them again. `--format json` prints one object: `seeds`,
`drives`, `seed`, `revision`, `machine`, `command`, `wall_s` and `rows`, each with `paper`, `table`, `claim`, `metric`,
`algorithm`, `maps`, `printed`, `ours`, `interval`, `n`, `excluded`, `acceptance`, `verdict`, `note`, `parameters`, `seed`
and `universal` (said of all maps). Exit codes: 0 complete (a claim that is not reproduced is a result), 1 an illegal
path, a broken theorem, or a stack that does not drive, 2 wrong arguments.

Each whole method drives any scenario of this project: `zeronav run blocked_aisle --as tn` (`ju`, `zm`, `lwx`, `bao`); what came
out there is asserted, with its reason, in `tests/tests/system/methods.rs`.

A table is a file in `src/tables/` and a row in `src/tables/mod.rs`; a claim is a row in `src/claims/`.
";

/// The row that stands for a claim.
#[must_use]
pub fn headline<'a>(claim: &Claim, rows: &'a [Row]) -> Option<&'a Row> {
    let head = &claim.headline;
    rows.iter().find(|row| {
        row.paper == claim.paper
            && row.table == head.table
            && row.claim == claim.id
            && row.metric == head.metric
            && row.algorithm == head.algorithm
            && row.maps.contains(&head.maps)
            && row.note.contains(&head.note)
    })
}

/// The page.
#[must_use]
pub fn page(report: &Report) -> String {
    let mut text = HEAD
        .replace("SEEDS", &report.seeds.to_string())
        .replace("DRIVES", &report.drives.to_string());
    let _ = writeln!(
        text,
        "{} maps of every kind from seed {}, {} drives of every scene; revision {}; {}; {:.0} min.\n",
        report.seeds,
        report.seed,
        report.drives,
        report.revision,
        report.machine,
        (report.wall_s / 60.0).ceil()
    );
    text += "## Summary\n\n| claim | what is said | printed | ours | verdict |\n|---|---|---|---|---|\n";
    for claim in claims() {
        let Some(row) = headline(claim, &report.rows) else {
            continue;
        };
        let (printed, ours) = figures(row);
        let _ = writeln!(
            text,
            "| {} {} | {} | {printed} | {ours} | {} |",
            claim.paper,
            claim.id,
            claim.text,
            of_all_rows(claim, row, &report.rows)
        );
    }
    for paper in papers() {
        let _ = write!(
            text,
            "\n## [{}] {}\n\n{}\n",
            paper.key, paper.title, paper.setup
        );
        for claim in &paper.claims {
            of_claim(&mut text, claim, &report.rows);
        }
    }
    text + "\n" + FOOT
}

/// The verdict on a claim in words, by all of its rows; that of the row which stands for it when none can be
/// judged.
fn of_all_rows(claim: &Claim, headline: &Row, rows: &[Row]) -> String {
    match claim.judged(rows) {
        None => headline.verdict.words().to_owned(),
        Some(Judged {
            verdict, rows: 1, ..
        }) => verdict.words().to_owned(),
        Some(Judged { mixed, .. }) if !mixed.is_empty() => {
            let parts = mixed
                .iter()
                .map(|(verdict, n)| format!("{n} {}", verdict.words()));
            format!("mixed: {}", parts.collect::<Vec<_>>().join(", "))
        }
        Some(Judged {
            verdict,
            rows,
            agree,
            ..
        }) => format!("{} ({agree} of {rows} rows)", verdict.words()),
    }
}

fn of_claim(text: &mut String, claim: &Claim, rows: &[Row]) {
    let _ = write!(
        text,
        "\n### {} {}: {}\n\n{}\n",
        claim.paper, claim.id, claim.text, claim.why
    );
    let own: Vec<&Row> = claim.rows(rows).filter(|row| row.n > 0).collect();
    if own.is_empty() {
        return;
    }
    *text += "\n| table | maps | algorithm | metric | printed | ours | n | excluded | verdict | note |\n\
              |---|---|---|---|---|---|---|---|---|---|\n";
    for row in own {
        let (printed, ours) = figures(row);
        let note = if row.parameters.is_null() {
            row.note.clone()
        } else {
            format!("{} `{}`", row.note, row.parameters)
                .trim()
                .to_owned()
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {printed} | {ours} | {} | {:.0} % | {} | {note} |",
            row.table,
            row.maps,
            row.algorithm,
            row.metric,
            row.n,
            100.0 * row.excluded,
            row.verdict.words()
        );
    }
}

/// The printed figure, and ours with its interval.
fn figures(row: &Row) -> (String, String) {
    let value = |value: f64| number(value, is_change(row));
    let printed = row.printed.map_or_else(|| "-".to_owned(), value);
    let ours = row.ours.zip(row.interval).map_or_else(
        || "-".to_owned(),
        |(ours, [low, high])| format!("{} [{}, {}]", value(ours), value(low), value(high)),
    );
    (printed, ours)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::{Figure, Place};
    use crate::stats::Estimate;
    use crate::tables::TABLES;
    use crate::verdict::{Printed, Standing, Verdict};

    /// A row of BAO C2 on these maps.
    fn row(maps: &str, ours: f64, n: usize) -> Row {
        let place = Place {
            paper: "BAO",
            table: "2",
            maps: maps.to_owned(),
            acceptance: 1.0,
            seed: 1,
        };
        place.row(Figure {
            claim: "C2",
            metric: "length".to_owned(),
            algorithm: "IAA vs AAO".to_owned(),
            printed: Printed::Change(-0.0572),
            ours: Some(Estimate {
                mean: ours,
                interval: [ours - 0.001, ours + 0.001],
                n,
            }),
            excluded: 0.0,
            standing: Standing::Fair,
            note: String::new(),
            parameters: serde_json::Value::Null,
        })
    }

    #[test]
    fn a_claim_is_judged_by_all_of_its_rows_and_not_by_the_best() {
        let claim = claims().find(|claim| (claim.paper, &*claim.id) == ("BAO", "C2"));
        let claim = claim.expect("a claim");
        let rows = [
            row("blocky 50x40", -0.05, 200),
            row("iid 50x40", 0.05, 200),
            row("iid 30x20", -0.05, 1),
        ];
        let headline = headline(claim, &rows).expect("a row");
        assert_eq!(headline.verdict, Verdict::Reproduced);
        let judged = claim.judged(&rows).expect("a verdict");
        assert_eq!(judged.verdict, Verdict::NotReproduced);
        assert_eq!((judged.agree, judged.rows), (1, 2));
        assert_eq!(
            of_all_rows(claim, headline, &rows),
            "mixed: 1 reproduced, 1 not reproduced"
        );
        // Of what is said of all maps one row is enough.
        let mut said_of_all = rows.clone();
        said_of_all[1].universal = true;
        assert_eq!(
            of_all_rows(claim, headline, &said_of_all),
            "not reproduced (1 of 2 rows)"
        );
        assert_eq!(of_all_rows(claim, headline, &rows[..1]), "reproduced");
    }

    #[test]
    fn every_claim_names_tables_that_are_measured() {
        for claim in claims() {
            assert!(
                claim.tables.contains(&claim.headline.table),
                "{} {}",
                claim.paper,
                claim.id
            );
            for table in &claim.tables {
                let known = TABLES
                    .iter()
                    .any(|known| known.paper == claim.paper && known.number == *table);
                assert!(known, "{} {table}", claim.paper);
            }
        }
    }
}
