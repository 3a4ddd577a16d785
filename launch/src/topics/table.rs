//! The topics of a run as a table.

use super::message::Message;
use super::tap::Tap;
use super::watches::{Units, units_of};
use crate::show::terminal::{say, say_json};
use serde_json::json;
use zeronav_msgs::fields::Shape;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{Discipline, READERS_MAX, Topic, TopicRow, TopicVisitor, visit_topics};
use zeronav_shell::Peer;

/// What is shown of a topic.
struct Line {
    row: &'static TopicRow,
    message: Message,
    writers: usize,
    readers: usize,
}

struct Lister<'a> {
    peer: &'a Peer,
    lines: Vec<Line>,
}

impl Lister<'_> {
    fn add(&mut self, message: Message, [writers, readers]: [usize; 2]) {
        self.lines.push(Line {
            row: message.row,
            message,
            writers,
            readers,
        });
    }
}

impl TopicVisitor for Lister<'_> {
    type Error = String;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), String> {
        let ports = self.peer.ports::<T>(row);
        let ports = ports.map_err(|error| error.to_string())?;
        self.add(Message::of_topic::<T>(row), ports);
        Ok(())
    }

    fn records(&mut self, _: &'static TopicRow) -> Result<(), String> {
        let ports = self.peer.span_ports();
        let ports = ports.map_err(|error| error.to_string())?;
        self.add(Message::of_records(), ports);
        Ok(())
    }
}

/// Prints the topics of the run.
///
/// # Errors
/// One line when a topic cannot be opened.
pub(super) fn list(tap: &Tap, json: bool) -> Result<(), String> {
    let mut lister = Lister {
        peer: tap.peer(),
        lines: Vec::new(),
    };
    visit_topics(&mut lister)?;
    let lines = lister.lines;
    if json {
        let rows: Vec<_> = lines.iter().map(to_json).collect();
        say_json(&json!({ "topics": rows }));
        return Ok(());
    }
    let mut table = vec![
        [
            "topic",
            "type",
            "written by",
            "reading",
            "queue",
            "bytes",
            "writers",
            "readers",
        ]
        .map(str::to_owned),
    ];
    table.extend(lines.iter().map(cells));
    let width = |column: usize| table.iter().map(|cells| cells[column].len()).max();
    let widths: [usize; 8] = core::array::from_fn(|column| width(column).unwrap_or(0));
    let mut text = String::new();
    for cells in &table {
        let padded: Vec<String> = (cells.iter().zip(widths))
            .map(|(cell, width)| format!("{cell:width$}"))
            .collect();
        text += padded.join("  ").trim_end();
        text.push('\n');
    }
    say(&text);
    Ok(())
}

fn discipline(row: &TopicRow) -> &'static str {
    match row.discipline {
        Discipline::Latest => "latest",
        Discipline::Stream => "stream",
        Discipline::Latched => "latched",
        Discipline::Records => "records",
    }
}

/// Name of the type of the fixed fields, of a record its own.
fn type_name(message: &Message) -> &'static str {
    match message.fields.unwrap_or(message.item) {
        Shape::Message { name, .. } => name,
        Shape::Number(_) | Shape::Array { .. } => "",
    }
}

/// What the slice holds; `None` when it stays empty.
fn item_type(message: &Message) -> Option<&'static str> {
    match message.item {
        Shape::Message { name, .. } => Some(name),
        // Topics without items have a slice of bytes that stays empty.
        _ => (message.row.len_max > 1).then_some("number"),
    }
}

fn cells(line: &Line) -> [String; 8] {
    let Line {
        row,
        message,
        writers,
        readers,
    } = line;
    let roles: Vec<&str> = match row.writers {
        all if all.len() == Role::SERVICES.len() => vec!["every service"],
        roles => roles.iter().map(|role| role.label()).collect(),
    };
    let size = match (message.fields, item_type(message)) {
        (None, _) => row.item_bytes.to_string(),
        (_, None) => row.envelope_bytes.to_string(),
        _ => format!(
            "{} + {} each, {} at most",
            row.envelope_bytes, row.item_bytes, row.len_max
        ),
    };
    [
        row.name.to_owned(),
        type_name(message).to_owned(),
        roles.join(", "),
        discipline(row).to_owned(),
        row.buffer().to_string(),
        size,
        format!("{writers} of {}", row.writers_max()),
        format!("{readers} of {READERS_MAX}"),
    ]
}

fn to_json(line: &Line) -> serde_json::Value {
    let Line {
        row,
        message,
        writers,
        readers,
    } = line;
    let roles: Vec<&str> = row.writers.iter().map(|role| role.label()).collect();
    json!({
        "topic": row.name,
        "type": type_name(message),
        "item_type": item_type(message),
        "written_by": roles,
        "reading": discipline(row),
        "queue": row.buffer(),
        "envelope_bytes": row.envelope_bytes,
        "item_bytes": row.item_bytes,
        "items_max": row.len_max,
        "schema": format!("{:016x}", row.schema),
        "writers": writers,
        "writers_max": row.writers_max(),
        "readers": readers,
        "readers_max": READERS_MAX,
        "units": Units(&units_of(message)),
    })
}
