//! A sample as plain text.

use super::cells;
use super::view::View;
use core::fmt::Write;

/// Events that are printed.
const EVENTS_SHOWN: usize = 20;

/// What is shown, line by line.
pub(super) fn text(view: &View) -> String {
    let mut text = cells::run(view) + "\n\n";
    let services = view.services.iter().map(cells::service);
    let services = services.chain(view.companions.iter().map(cells::companion));
    table(&mut text, &cells::SERVICE_HEADINGS, services, &[0, 1, 8]);
    text.push('\n');
    let topics = view.topics.iter().map(cells::topic);
    table(&mut text, &cells::TOPIC_HEADINGS, topics, &[0]);
    let _ = writeln!(text, "\n{}", cells::reaction(view));
    if let Some(replanning) = &view.replanning {
        let _ = writeln!(
            text,
            "last replanning [us]: {:.0} in all, at {:.2} s",
            replanning.total_us, replanning.time_s
        );
        for hop in &replanning.hops {
            let _ = writeln!(text, "  {:<20} {:>7.0}", hop.hop, hop.us);
        }
    }
    text.push('\n');
    for event in &view.events[view.events.len().saturating_sub(EVENTS_SHOWN)..] {
        let _ = writeln!(
            text,
            "{:>9.2} s  {:<8} {}",
            event.time_s, event.kind, event.text
        );
    }
    let _ = writeln!(text, "{}", cells::own(view));
    text
}

/// Adds a table; the columns at the indices `left` are aligned to the left.
fn table<const N: usize>(
    text: &mut String,
    headings: &[&str; N],
    rows: impl Iterator<Item = [String; N]>,
    left: &[usize],
) {
    let mut all = vec![headings.map(str::to_owned)];
    all.extend(rows);
    let widths: [usize; N] =
        core::array::from_fn(|column| all.iter().map(|row| row[column].len()).max().unwrap_or(0));
    for row in &all {
        let cells: Vec<String> = (row.iter().zip(widths).enumerate())
            .map(|(column, (cell, width))| {
                if left.contains(&column) {
                    format!("{cell:<width$}")
                } else {
                    format!("{cell:>width$}")
                }
            })
            .collect();
        *text += cells.join("  ").trim_end();
        text.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::top::view::{CompanionLine, EventLine, RunLine, ServiceLine, TopicLine};
    use zeronav_measure::result::latency::Figures;
    use zeronav_observe::usage::Usage;

    #[test]
    fn a_sample_is_a_page_of_aligned_text() {
        let view = View {
            run: RunLine {
                scenario: "blocked_aisle".to_owned(),
                mode: "real_time".to_owned(),
                time_s: 3.25,
                task: "active".to_owned(),
                remaining_m: Some(20.04),
                v_mps: Some(0.8),
                ..RunLine::default()
            },
            services: vec![ServiceLine {
                role: "mapping",
                epoch: 2,
                restarts: Some(1),
                state: "degraded",
                usage: Usage {
                    pid: 7,
                    cpu_percent: Some(3.26),
                    memory_bytes: Some(16_000_000),
                },
                reasons: vec!["scan"],
                ..ServiceLine::default()
            }],
            companions: vec![CompanionLine {
                name: "page".to_owned(),
                state: "running".to_owned(),
                restarts: 2,
                end: "killed".to_owned(),
                ..CompanionLine::default()
            }],
            topics: vec![
                TopicLine {
                    topic: "fast",
                    hz: 60.0,
                    bytes_per_s: 14_400.0,
                    age_s: Some(0.012),
                    missed: 0,
                },
                TopicLine {
                    topic: "never",
                    ..TopicLine::default()
                },
            ],
            reaction: Figures {
                n: 100,
                p50_us: Some(430.0),
                p99_us: Some(699.0),
                max_us: Some(893.0),
                ..Figures::default()
            },
            events: vec![EventLine {
                time_s: 1.5,
                kind: "restart",
                text: "mapping: killed".to_owned(),
            }],
            ..View::default()
        };
        let expected = "\
blocked_aisle  real_time  3.2 s  task active, 20.0 m left  0.80 m/s

service  state     epoch  restarts  cpu %    MB  rejected  superseded  reasons
mapping  degraded      2         1    3.3  16.0         0           0  scan
page     running       -         2      -     -         -           -  killed

topic    Hz  kB/s    age
fast   60.0  14.4  12 ms
never     -     -      -

reaction [us]: p50 430, p99 699, max 893, 100 scans

     1.50 s  restart  mapping: killed
top: cpu - %, - MB
";
        assert_eq!(text(&view), expected);
    }
}
