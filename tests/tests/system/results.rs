//! The figures of the READMEs are what the results tool measured, and nothing else.

use zeronav_tests::generated::COMMAND;
use zeronav_tests::results::record::Table;
use zeronav_tests::results::{experiments::EXPERIMENTS, extract, page, page_file, readmes, record};
use zeronav_tests::zeronav;

fn stored() -> record::Records {
    record::load(&zeronav_tests::results::records_file()).expect("records")
}

#[test]
fn pages_match_the_stored_records() {
    let records = stored();
    let page = std::fs::read_to_string(page_file()).expect("tests/RESULTS.md");
    assert!(
        page == page::page(&records),
        "tests/RESULTS.md is not current: {COMMAND}"
    );
    for file in readmes() {
        let text = std::fs::read_to_string(&file).expect("a README");
        let rendered = page::filled(&text, &records);
        let rendered = rendered.unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        assert!(
            rendered == text,
            "{} is not current: {COMMAND}",
            file.display()
        );
    }
}

#[test]
fn readmes_have_no_figures_typed_by_hand() {
    for file in readmes() {
        let text = std::fs::read_to_string(&file).expect("a README");
        let by_hand = page::figures_by_hand(&text);
        assert!(by_hand.is_empty(), "{}: {by_hand:#?}", file.display());
    }
}

#[test]
fn records_hold_command_commit_machine_and_spread() {
    for (key, record) in stored() {
        assert!(
            EXPERIMENTS.iter().any(|one| one.key == key),
            "{key} is no experiment"
        );
        assert!(
            !record.commit.is_empty() && !record.commands.is_empty(),
            "{key}"
        );
        assert!(
            !record.machine.cpu.is_empty() && record.machine.cores > 0,
            "{key}"
        );
        assert!(
            record.text.is_some() || !record.tables.is_empty(),
            "{key} gave nothing"
        );
        for table in &record.tables {
            for row in &table.rows {
                assert_eq!(
                    row.figures.len(),
                    table.columns.len(),
                    "{key}, {}",
                    row.name
                );
            }
        }
    }
}

/// Every figure of the first `columns` has a value.
#[track_caller]
fn filled(table: &Table, columns: usize) {
    assert!(!table.rows.is_empty(), "{table:#?}");
    for row in &table.rows {
        let figures = &row.figures[..columns];
        assert!(
            figures.iter().all(|figure| figure.value.is_some()),
            "{row:#?}"
        );
        assert!(row.n > 0, "{row:#?}");
    }
}

#[test]
fn figures_are_extracted_from_real_results() {
    let run = || zeronav(&["run", "door_closes", "--lockstep", "--headless", "--json"]).expect(0);
    let results = [run(), run()];
    let lockstep = extract::lockstep("door_closes", &results);
    filled(&lockstep, 3);
    let hashes = &lockstep.rows[0].figures[2];
    assert_eq!(hashes.value, Some(1.0), "one hash");
    let memory = extract::memory(&results);
    filled(&memory, 1);
    assert_eq!(memory.rows.len(), 6, "shared memory and five services");
    filled(&extract::drives(&[("door_closes", results.to_vec())]), 5);
    let suite = [
        "suite",
        "generated",
        "--worlds",
        "0..2",
        "--headless",
        "--json",
    ];
    let report = zeronav(&suite).expect(0);
    let suites = extract::suites(&[("beam", report)]).expect("a table");
    filled(&suites, 4);
}
