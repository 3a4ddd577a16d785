//! Suites of worlds with one controller or with several, and the papers' scenes.

use super::bench::{Bench, Measured};
use super::extract;

/// One suite with each of the controllers, on the same worlds and seeds.
fn suite(bench: &mut Bench, words: &[&str], controllers: &[&str]) -> Result<Measured, String> {
    let mut reports = Vec::new();
    for controller in controllers {
        let mut arguments = vec!["suite"];
        arguments.extend(words);
        arguments.extend(["--controller", controller]);
        reports.push((*controller, bench.zeronav(&arguments)?));
    }
    Ok(Measured::tables(vec![extract::suites(&reports)?]))
}

pub(super) fn generated(bench: &mut Bench) -> Result<Measured, String> {
    suite(
        bench,
        &["generated", "--seeds", "5"],
        &["beam", "dwa_t", "dwa"],
    )
}

pub(super) fn field(bench: &mut Bench) -> Result<Measured, String> {
    suite(bench, &["field"], &["beam"])
}

pub(super) fn barn(bench: &mut Bench) -> Result<Measured, String> {
    suite(bench, &["barn"], &["beam", "dwa_t"])
}

pub(super) fn barn_controllers(bench: &mut Bench) -> Result<Measured, String> {
    let controllers = [
        "dwa_t",
        "dwa",
        "mppi",
        "beam",
        "ju_fusion",
        "ju_apf",
        "ju_r6",
        "ju_r7",
        "zm_rep",
        "zm_esc",
        "zm_rv",
        "lwx_apf",
        "lwx_oapf",
        "lwx_lsq",
        "lwx_fusion",
        "bao_dwa",
    ];
    suite(bench, &["barn", "--worlds", "0..20"], &controllers)
}

pub(super) fn pedestrians(bench: &mut Bench) -> Result<Measured, String> {
    suite(bench, &["pedestrians", "--seeds", "20"], &["beam", "dwa_t"])
}

pub(super) fn dynabarn(bench: &mut Bench) -> Result<Measured, String> {
    suite(bench, &["dynabarn", "--seeds", "3"], &["beam", "dwa_t"])
}

/// What is possible, and what perception and prediction cost: the bound, then the default controller
/// with each of them told by the simulator.
pub(super) fn told(bench: &mut Bench) -> Result<Measured, String> {
    const BOUND: &[&str] = &["--bound"];
    const TOLD: [(&str, &[&str]); 5] = [
        ("bound", BOUND),
        ("both told", &["--perceive", "truth", "--predict", "truth"]),
        ("perception told", &["--perceive", "truth"]),
        ("prediction told", &["--predict", "truth"]),
        ("nothing told", &[]),
    ];
    let mut tables = Vec::new();
    for words in [
        ["dynabarn", "--seeds", "3"],
        ["pedestrians", "--seeds", "20"],
    ] {
        let mut reports = Vec::new();
        for (name, more) in TOLD {
            let mut arguments = vec!["suite"];
            arguments.extend(words);
            arguments.extend(more);
            let name = format!("{}, {name}", words[0]);
            reports.push((name, bench.zeronav(&arguments)?));
        }
        let named: Vec<(&str, _)> = (reports.iter())
            .map(|(name, report)| (name.as_str(), report.clone()))
            .collect();
        tables.push(extract::suites(&named)?);
    }
    Ok(Measured::tables(tables))
}

pub(super) fn papers_dyn(bench: &mut Bench) -> Result<Measured, String> {
    let text = bench.cargo(&[
        "test",
        "--release",
        "-p",
        "zeronav-tests",
        "--test",
        "system",
        "papers_dyn::",
        "--",
        "--show-output",
        "--test-threads",
        "1",
    ])?;
    let lines: Vec<&str> = text
        .lines()
        .filter(|line| line.starts_with("LWX-DYN") || line.starts_with("BAO-DYN"))
        .collect();
    if lines.is_empty() {
        return Err("papers_dyn printed no rates".to_owned());
    }
    Ok(Measured::printed(&lines.join("\n")))
}
