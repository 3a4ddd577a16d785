//! The topics of a run as a table.

use super::message::Message;
use super::tap::Tap;
use super::user;
use super::watches::{Units, units_of};
use serde_json::{Value, json};
use zeronav_console::terminal::{say, say_json};
use zeronav_msgs::fields::Shape;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{Discipline, READERS_MAX, Topic, TopicRow, TopicVisitor, visit_topics};
use zeronav_msgs::user::Form;
use zeronav_shell::Peer;

/// What is shown of a topic.
struct Line {
    row: &'static TopicRow,
    message: Message,
    /// What the bytes of a user's own topic mean.
    form: Option<Form>,
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
            form: None,
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
    let mut lines = lister.lines;
    for found in user::all(tap.peer()).map_err(|error| error.to_string())? {
        let ports = found.ports(tap.peer());
        let [writers, readers] = ports.map_err(|error| error.to_string())?;
        lines.push(Line {
            row: found.row,
            message: found.message(),
            form: Some(found.form),
            writers,
            readers,
        });
    }
    if json {
        let rows: Vec<_> = lines.iter().map(to_json).collect();
        say_json(&json!({ "topics": rows }));
        return Ok(());
    }
    let mut table = vec![COLUMNS.map(|column| column.heading.to_owned())];
    table.extend(
        lines
            .iter()
            .map(|line| COLUMNS.map(|column| (column.text)(line))),
    );
    let width = |column: usize| table.iter().map(|cells| cells[column].len()).max();
    let widths: [usize; COLUMNS.len()] = core::array::from_fn(|column| width(column).unwrap_or(0));
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

/// What is printed about every topic.
#[derive(Clone, Copy)]
struct Column {
    heading: &'static str,
    text: fn(&Line) -> String,
    /// Its fields as JSON: an object.
    json: fn(&Line) -> Value,
}

const COLUMNS: [Column; 8] = [
    Column {
        heading: "topic",
        text: |line| line.row.name.to_owned(),
        json: |line| json!({ "topic": line.row.name }),
    },
    Column {
        heading: "type",
        text: |line| match &line.form {
            Some(form) => form.text().to_owned(),
            None => type_name(&line.message).to_owned(),
        },
        json: |line| {
            let message = &line.message;
            json!({
                "type": type_name(message),
                "item_type": item_type(message),
                "form": line.form.as_ref().map(Form::text),
                "schema": format!("{:016x}", line.row.schema),
                "units": Units(&units_of(message)),
            })
        },
    },
    Column {
        heading: "written by",
        text: |line| match line.row.writers {
            all if all.len() == Role::ALL.len() => "anybody".to_owned(),
            all if all.len() == Role::SERVICES.len() => "every service".to_owned(),
            _ => writers(line.row).join(", "),
        },
        json: |line| json!({ "written_by": writers(line.row) }),
    },
    Column {
        heading: "reading",
        text: |line| discipline(line.row).to_owned(),
        json: |line| json!({ "reading": discipline(line.row) }),
    },
    Column {
        heading: "queue",
        text: |line| line.row.buffer().to_string(),
        json: |line| json!({ "queue": line.row.buffer() }),
    },
    Column {
        heading: "bytes",
        text: bytes,
        json: |line| {
            json!({
                "envelope_bytes": line.row.envelope_bytes,
                "item_bytes": line.row.item_bytes,
                "items_max": line.row.len_max,
            })
        },
    },
    Column {
        heading: "writers",
        text: |line| format!("{} of {}", line.writers, line.row.writers_max()),
        json: |line| json!({ "writers": line.writers, "writers_max": line.row.writers_max() }),
    },
    Column {
        heading: "readers",
        text: |line| format!("{} of {READERS_MAX}", line.readers),
        json: |line| json!({ "readers": line.readers, "readers_max": READERS_MAX }),
    },
];

fn writers(row: &TopicRow) -> Vec<&'static str> {
    row.writers.iter().map(|role| role.label()).collect()
}

/// Bytes of the fixed part and of the items.
fn bytes(line: &Line) -> String {
    let row = line.row;
    if line.form.is_some() {
        return format!("{} + {} at most", row.envelope_bytes, row.len_max);
    }
    match (line.message.fields, item_type(&line.message)) {
        (None, _) => row.item_bytes.to_string(),
        (_, None) => row.envelope_bytes.to_string(),
        _ => format!(
            "{} + {} each, {} at most",
            row.envelope_bytes, row.item_bytes, row.len_max
        ),
    }
}

fn to_json(line: &Line) -> Value {
    let mut all = serde_json::Map::new();
    for column in COLUMNS {
        if let Value::Object(fields) = (column.json)(line) {
            all.extend(fields);
        }
    }
    Value::Object(all)
}
