//! What is done with the messages of a topic: shown, or counted.

use super::message::Message;
use super::rate::Rate;
use super::tap::Watch;
use super::value::{Elements, Value, units, write_all};
use serde::ser::{Serialize, SerializeMap, Serializer};
use std::io::{Result, Write};
use std::num::NonZeroU64;
use std::time::{Duration, Instant};
use zeronav_console::terminal::{pour, say};
use zeronav_msgs::header::Header;
use zeronav_msgs::message::Wire;

/// Time between two lines about a rate.
const WINDOW: Duration = Duration::from_secs(1);

/// How many messages are wanted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    most: Option<NonZeroU64>,
    seen: u64,
}

impl Wanted {
    /// `None` takes all.
    pub(super) fn new(most: Option<NonZeroU64>) -> Self {
        Self { most, seen: 0 }
    }

    /// One more; false when that was the last one.
    fn count(&mut self) -> bool {
        self.seen += 1;
        self.is_short()
    }

    /// True while more are wanted.
    pub(super) fn is_short(&self) -> bool {
        self.most.is_none_or(|most| self.seen < most.get())
    }

    /// True when a number was asked for and not reached.
    pub(super) fn is_missed(&self) -> bool {
        self.most.is_some() && self.is_short()
    }
}

/// Shows every message.
#[derive(Debug)]
pub(super) struct Echo {
    json: bool,
    pub(super) wanted: Wanted,
    /// Path and unit of every field, once there was a message.
    units: Vec<(String, &'static str)>,
}

impl Echo {
    /// For people or as JSON, so many.
    pub(super) fn new(json: bool, wanted: Wanted) -> Self {
        Self {
            json,
            wanted,
            units: Vec::new(),
        }
    }
}

impl Watch for Echo {
    fn see(&mut self, message: &Message) -> bool {
        if self.json && self.units.is_empty() {
            self.units = units_of(message);
        }
        let (units, json) = (&self.units, self.json);
        let is_read = pour(|to| {
            if json {
                serde_json::to_writer(&mut *to, &Line { message, units })?;
                writeln!(to)
            } else {
                write_message(to, message)
            }
        });
        is_read && self.wanted.count()
    }
}

/// Path and unit of everything that a message holds.
pub(super) fn units_of(message: &Message) -> Vec<(String, &'static str)> {
    let mut all = Vec::new();
    if let Some(fields) = message.fields {
        units("header", Header::SHAPE, &mut all);
        units("fields", fields, &mut all);
    }
    units("items", message.item, &mut all);
    if !message.item_unit().is_empty() {
        all.push(("items".to_owned(), message.item_unit()));
    }
    all
}

/// A message as a JSON object.
struct Line<'a> {
    message: &'a Message,
    units: &'a [(String, &'static str)],
}

impl Serialize for Line<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> core::result::Result<S::Ok, S::Error> {
        let message = self.message;
        let mut map = to.serialize_map(None)?;
        map.serialize_entry("topic", message.row.name)?;
        map.serialize_entry("missed", &message.missed)?;
        if let (Some(header), Some(fields)) = (&message.header, message.fields) {
            let header = bytemuck::bytes_of(header);
            map.serialize_entry("header", &Value::of(Header::SHAPE, header))?;
            map.serialize_entry("fields", &Value::of(fields, &message.field_bytes))?;
        }
        let items = Elements {
            of: message.item,
            bytes: &message.item_bytes,
            field: None,
        };
        map.serialize_entry("items", &items)?;
        map.serialize_entry("units", &Units(self.units))?;
        map.end()
    }
}

/// Path and unit of fields as a JSON object.
pub(super) struct Units<'a>(pub &'a [(String, &'static str)]);

impl Serialize for Units<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> core::result::Result<S::Ok, S::Error> {
        to.collect_map(self.0.iter().map(|(path, unit)| (path, unit)))
    }
}

fn write_message(to: &mut dyn Write, message: &Message) -> Result<()> {
    if message.missed > 0 {
        writeln!(to, "# {} messages were missed", message.missed)?;
    }
    write!(to, "{}", message.row.name)?;
    if let Some(id) = message.id() {
        write!(to, " {id}")?;
    }
    writeln!(to)?;
    if let (Some(header), Some(fields)) = (&message.header, message.fields) {
        Value::of(Header::SHAPE, bytemuck::bytes_of(header)).write(to, 2, "header", "")?;
        Value::of(fields, &message.field_bytes).write_fields(to, 2)?;
    }
    if !message.item_bytes.is_empty() {
        let unit = match message.item_unit() {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        write_all(
            to,
            2,
            "items",
            &unit,
            message.item,
            &message.item_bytes,
            None,
        )?;
    }
    writeln!(to, "---")
}

/// What a meter says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unit {
    /// Messages.
    Hz,
    /// Bytes.
    Bytes,
}

/// Counts messages and bytes, a line every second and one about all.
#[derive(Debug)]
pub(super) struct Meter {
    unit: Unit,
    topic: String,
    json: bool,
    pub(super) wanted: Wanted,
    all: Rate,
    window: Rate,
    window_began: Instant,
    before_ns: u64,
}

impl Meter {
    /// Nothing was counted yet.
    pub(super) fn new(unit: Unit, topic: &str, json: bool, wanted: Wanted) -> Self {
        Self {
            unit,
            topic: topic.to_owned(),
            json,
            wanted,
            all: Rate::default(),
            window: Rate::default(),
            window_began: Instant::now(),
            before_ns: 0,
        }
    }

    /// The line about all messages.
    pub(super) fn finish(&self) {
        if !self.json {
            say("in all: ");
        }
        self.line(&self.all, None);
    }

    fn line(&self, rate: &Rate, window_s: Option<f64>) {
        say(&match (self.json, self.unit) {
            (true, _) => format!("{}\n", rate.to_json(&self.topic, window_s)),
            (false, Unit::Hz) => rate.hz_line(window_s) + "\n",
            (false, Unit::Bytes) => rate.bw_line(window_s) + "\n",
        });
    }
}

impl Watch for Meter {
    fn see(&mut self, message: &Message) -> bool {
        self.window.add(message, self.before_ns);
        self.all.add(message, self.before_ns);
        self.before_ns = message.published_ns;
        self.wanted.count()
    }

    fn look(&mut self) {
        let elapsed = self.window_began.elapsed();
        if elapsed >= WINDOW {
            let window = core::mem::take(&mut self.window);
            self.line(&window, Some(elapsed.as_secs_f64()));
            self.window_began = Instant::now();
        }
    }
}
