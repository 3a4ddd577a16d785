//! The view on a terminal.

use super::cells;
use super::view::{EventLine, Sort, View};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Cell, Paragraph, Row, Table};

/// Columns from which on latencies stand beside the topics.
const WIDE_COLUMNS: u16 = 100;

/// Columns of the latencies.
const LATENCY_COLUMNS: u16 = 44;

/// Draws `view`, with the topics sorted by `sort`.
pub(super) fn draw(frame: &mut Frame<'_>, view: &View, sort: Sort) {
    let services = view.services.len() + view.companions.len();
    let services = u16::try_from(services).unwrap_or(u16::MAX);
    let narrow = frame.area().width < WIDE_COLUMNS;
    let [title, service_area, middle, latency, events, footer] = Layout::vertical([
        Constraint::Length(2),
        Constraint::Length(services.saturating_add(2)),
        Constraint::Fill(3),
        Constraint::Length(if narrow { 2 } else { 0 }),
        Constraint::Fill(1),
        Constraint::Length(1),
    ])
    .areas(frame.area());
    let bold = Style::new().add_modifier(Modifier::BOLD);
    frame.render_widget(Paragraph::new(cells::run(view)).style(bold), title);
    draw_services(frame, view, service_area);
    if narrow {
        draw_topics(frame, view, sort, middle);
        frame.render_widget(Paragraph::new(cells::reaction(view)), latency);
    } else {
        let [topics, beside] =
            Layout::horizontal([Constraint::Fill(1), Constraint::Length(LATENCY_COLUMNS)])
                .areas(middle);
        draw_topics(frame, view, sort, topics);
        draw_latency(frame, view, beside);
    }
    draw_events(frame, &view.events, events);
    let keys = format!(
        "q quit   s topics by {}   {}",
        sort.next().heading(),
        cells::own(view)
    );
    frame.render_widget(Paragraph::new(keys).style(dim()), footer);
}

fn draw_services(frame: &mut Frame<'_>, view: &View, area: Rect) {
    let services = view.services.iter().map(cells::service);
    let companions = view.companions.iter().map(cells::companion);
    let lines: Vec<_> = services.chain(companions).collect();
    let names = lines.iter().map(|cells| cells[0].chars().count());
    let names = u16::try_from(names.max().unwrap_or(0)).unwrap_or(u16::MAX);
    let rows = lines.into_iter().map(|cells| {
        let colour = match cells[1].as_str() {
            "ready" | "running" => Color::Green,
            "silent" | "absent" | "ended" => Color::Red,
            _ => Color::Yellow,
        };
        Row::new(
            cells
                .into_iter()
                .enumerate()
                .map(|(column, text)| match column {
                    1 => Cell::new(text).style(Style::new().fg(colour)),
                    2..=7 => Cell::new(Line::from(text).right_aligned()),
                    _ => Cell::new(text),
                }),
        )
    });
    let names = names.clamp(16, 40);
    let widths = [names, 9, 5, 8, 5, 6, 8, 10].map(Constraint::Length);
    let widths = widths.into_iter().chain([Constraint::Fill(1)]);
    let headings = headings(&cells::SERVICE_HEADINGS, 2..=7);
    frame.render_widget(Table::new(rows, widths).header(headings), area);
}

fn draw_topics(frame: &mut Frame<'_>, view: &View, sort: Sort, area: Rect) {
    let mut lines = view.topics.clone();
    sort.sort(&mut lines);
    let rows = lines.iter().map(|line| {
        let cells = cells::topic(line).into_iter().enumerate();
        Row::new(cells.map(|(column, text)| match column {
            0 => Cell::new(text),
            _ => Cell::new(Line::from(text).right_aligned()),
        }))
    });
    let widths = [28, 9, 10, 9].map(Constraint::Length);
    let headings = headings(&cells::TOPIC_HEADINGS, 1..=3);
    frame.render_widget(Table::new(rows, widths).header(headings), area);
}

fn draw_latency(frame: &mut Frame<'_>, view: &View, area: Rect) {
    let figures = view.reaction.supported();
    let mut lines = vec![Line::styled("reaction [us]", heading())];
    let row = |name: &str, us: Option<f64>| {
        let us = us.map_or_else(|| "-".to_owned(), |us| format!("{us:.0}"));
        Line::from(format!("  {name:<20} {us:>8}"))
    };
    lines.push(row("p50", figures.p50_us));
    lines.push(row("p99", figures.p99_us));
    lines.push(row("max", figures.max_us));
    lines.push(Line::from(format!("  {:<20} {:>8}", "scans", figures.n)));
    lines.push(Line::default());
    lines.push(Line::styled("last replanning [us]", heading()));
    match &view.replanning {
        None => lines.push(Line::styled("  none yet", dim())),
        Some(replanning) => {
            let hops = replanning.hops.iter();
            lines.extend(hops.map(|hop| row(hop.hop, Some(hop.us))));
            lines.push(row("in all", Some(replanning.total_us)));
        }
    }
    frame.render_widget(Paragraph::new(lines), area);
}

/// The newest events that there is room for.
fn draw_events(frame: &mut Frame<'_>, events: &[EventLine], area: Rect) {
    let room = usize::from(area.height.saturating_sub(1));
    let newest = &events[events.len().saturating_sub(room)..];
    let mut lines = vec![Line::styled("events", heading())];
    lines.extend(newest.iter().map(|event| {
        let colour = match event.kind {
            "restart" | "fault" => Color::Red,
            "guard" => Color::Yellow,
            "path" => Color::Cyan,
            _ => Color::Reset,
        };
        let kind = Span::styled(format!("{:<8} ", event.kind), Style::new().fg(colour));
        Line::from(vec![
            Span::styled(format!("{:>9.2} s  ", event.time_s), dim()),
            kind,
            Span::raw(event.text.as_str()),
        ])
    }));
    frame.render_widget(Paragraph::new(lines), area);
}

fn headings<const N: usize>(
    names: &[&'static str; N],
    right: core::ops::RangeInclusive<usize>,
) -> Row<'static> {
    let cells = names.iter().enumerate().map(|(column, name)| {
        let line = Line::from(*name);
        if right.contains(&column) {
            line.right_aligned()
        } else {
            line
        }
    });
    Row::new(cells.collect::<Vec<_>>()).style(heading())
}

fn heading() -> Style {
    Style::new().add_modifier(Modifier::REVERSED)
}

fn dim() -> Style {
    Style::new().add_modifier(Modifier::DIM)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::top::view::{HopLine, Replanning, RunLine, ServiceLine, TopicLine};
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    fn view() -> View {
        let topic = |topic, hz| TopicLine {
            topic,
            hz,
            bytes_per_s: 100.0 * hz,
            age_s: Some(0.01),
            missed: 0,
        };
        let event = |n: u32| EventLine {
            time_s: f64::from(n),
            kind: "path",
            text: format!("event {n}"),
        };
        View {
            run: RunLine {
                scenario: "it".to_owned(),
                ..RunLine::default()
            },
            services: ["ready", "silent"]
                .map(|state| ServiceLine {
                    role: "mapping",
                    state,
                    ..ServiceLine::default()
                })
                .to_vec(),
            topics: vec![topic("slow/topic", 1.0), topic("fast/topic", 60.0)],
            replanning: Some(Replanning {
                time_s: 1.0,
                total_us: 1629.0,
                hops: vec![HopLine {
                    hop: "to_mapping",
                    us: 117.0,
                }],
            }),
            events: (0..50).map(event).collect(),
            ..View::default()
        }
    }

    /// The lines of a terminal of this size.
    fn drawn(width: u16, height: u16, sort: Sort) -> (Vec<String>, ratatui::buffer::Buffer) {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a terminal");
        let view = view();
        (terminal.draw(|frame| draw(frame, &view, sort))).expect("drawn");
        let buffer = terminal.backend().buffer().clone();
        let line = |y| (0..width).map(|x| buffer[(x, y)].symbol()).collect();
        ((0..height).map(line).collect(), buffer)
    }

    fn at(lines: &[String], word: &str) -> usize {
        let found = lines.iter().position(|line| line.contains(word));
        found.unwrap_or_else(|| panic!("no {word} in\n{}", lines.join("\n")))
    }

    #[test]
    fn a_wide_terminal_has_latencies_beside_the_topics() {
        let (lines, buffer) = drawn(120, 40, Sort::Topic);
        assert!(lines[0].starts_with("it "), "{}", lines[0]);
        assert!(at(&lines, "slow/topic") < at(&lines, "fast/topic"));
        assert_eq!(at(&lines, "reaction [us]"), at(&lines, "topic "));
        assert!(lines[at(&lines, "to_mapping")].contains(" 117"));
        assert!(lines[at(&lines, "in all")].contains("1629"));
        // The newest event is the last line above the footer.
        assert!(lines[38].contains("event 49"), "{}", lines[38]);
        assert!(lines[39].starts_with("q quit   s topics by rate   top: cpu"));
        let colour = |state: &str| {
            let y = at(&lines, state);
            let x = lines[y].find(state).expect("it is there");
            let cell = (
                u16::try_from(x).expect("a column"),
                u16::try_from(y).expect("a line"),
            );
            buffer[cell].fg
        };
        assert_eq!(
            (colour("ready"), colour("silent")),
            (Color::Green, Color::Red)
        );
    }

    #[test]
    fn topics_are_drawn_in_the_order_that_was_asked_for() {
        let (lines, _) = drawn(120, 40, Sort::Rate);
        assert!(at(&lines, "fast/topic") < at(&lines, "slow/topic"));
        assert!(lines[39].contains("s topics by bandwidth"));
    }

    #[test]
    fn a_small_terminal_keeps_the_essentials() {
        let (lines, _) = drawn(80, 24, Sort::Topic);
        at(&lines, "reaction: nothing measured");
        at(&lines, "event 49");
        assert!(lines[23].starts_with("q quit"));
        // One that has no room for anything is no error.
        for (width, height) in [(1, 1), (20, 3), (300, 2)] {
            drawn(width, height, Sort::Age);
        }
    }
}
