//! The contract in Python: `ctypes` structures and a row per topic.

use crate::contract::{Codes, Contract, Structure, TopicLayout, name_of};
use crate::words::{plain, wrap};
use core::fmt::Write;
use zeronav_msgs::fields::{Field, Shape};
use zeronav_msgs::role::Role;

/// Where it is kept, from the root of the workspace.
pub(crate) const FILE: &str = "services/python/zeronav/contract.py";

const HEAD: &str = r#""""The contract between the processes of zeronav: messages, codes, topics.

Written by `cargo run -p zeronav-msgs --example bindings`; changes belong into the crate `msgs`.
Importing this module computes size, offsets and schema hash of every message again and compares.
"""

from enum import IntEnum

from .layout import Message, Topic, f32, f64, i32, u8, u16, u32, u64, verify
"#;

/// The text of the file.
pub(crate) fn text(contract: &Contract) -> String {
    let mut text = HEAD.to_owned();
    for codes in &contract.codes {
        write_codes(&mut text, codes);
    }
    text.push('\n');
    for (name, value) in &contract.constants {
        let _ = write!(text, "\n{name} = {value}");
    }
    text.push('\n');
    for message in &contract.messages {
        write_message(&mut text, message);
    }
    text.push('\n');
    for topic in &contract.topics {
        write_topic(&mut text, topic);
    }
    text.push_str("\nTOPICS = (\n");
    for topic in &contract.topics {
        let _ = writeln!(text, "    {},", constant(topic.row.name));
    }
    text.push_str(")\n\nHEALTH = {\n");
    for role in Role::SERVICES {
        let _ = writeln!(text, "    Role.{}: HEALTH_{},", upper(role), upper(role));
    }
    text.push_str("}\n\nfor _message in (\n");
    for message in &contract.messages {
        let _ = writeln!(text, "    {},", message.name);
    }
    text.push_str("):\n    verify(_message)\nfor _topic in TOPICS:\n    _topic.verify()\n");
    text
}

fn write_codes(text: &mut String, codes: &Codes) {
    let _ = writeln!(text, "\n\nclass {}(IntEnum):", codes.name);
    for (code, label) in &codes.values {
        let _ = writeln!(text, "    {} = {code}", label.to_uppercase());
    }
}

fn write_message(text: &mut String, message: &Structure) {
    let _ = writeln!(text, "\n\nclass {}(Message):", message.name);
    let doc = plain(message.doc);
    wrap(text, &format!("\"\"\"{doc}\"\"\""), "    ", "");
    let Structure {
        type_name,
        bytes,
        schema,
        ..
    } = message;
    let _ = writeln!(text, "\n    NAME = \"{type_name}\"");
    let _ = writeln!(text, "    SIZE = {bytes}");
    let _ = writeln!(text, "    SCHEMA = 0x{schema:016x}");
    let offsets: Vec<String> = message.fields.iter().map(offset).collect();
    let comma = if offsets.len() == 1 { "," } else { "" };
    let offsets = format!("OFFSETS = ({}{comma})", offsets.join(", "));
    wrap(text, &offsets, "    ", "    ");
    text.push_str("    _fields_ = [\n");
    for field in message.fields {
        wrap(text, &format!("# {}", plain(field.doc)), "        ", "# ");
        let _ = writeln!(
            text,
            "        (\"{}\", {}),",
            field.name,
            type_of(field.shape)
        );
    }
    text.push_str("    ]\n");
}

fn offset(field: &Field) -> String {
    field.offset.to_string()
}

fn write_topic(text: &mut String, topic: &TopicLayout) {
    let row = topic.row;
    let roles = |roles: &[Role]| {
        let names: Vec<String> = roles
            .iter()
            .map(|role| format!("Role.{}", upper(*role)))
            .collect();
        let comma = if names.len() == 1 { "," } else { "" };
        format!("({}{comma})", names.join(", "))
    };
    let envelope = topic.envelope.as_deref().unwrap_or("None");
    let lines = [
        format!("number={}", row.number),
        format!("name=\"{}\"", row.name),
        format!("discipline=\"{}\"", discipline(topic)),
        format!("envelope={envelope}"),
        format!("item={}", type_of(topic.item)),
        format!("writers={}", roles(row.writers)),
        format!("rings={}", roles(row.rings)),
        format!("rings_in_lockstep={}", roles(row.rings_in_lockstep)),
        format!("len_max={}", row.len_max),
        format!("buffer={}", row.service_buffer()),
        format!("pool={}", row.pool()),
        format!("schema=0x{:016x}", row.schema),
    ];
    let _ = writeln!(text, "\n{} = Topic(", constant(row.name));
    for line in lines {
        wrap(text, &format!("{line},"), "    ", "    ");
    }
    text.push_str(")\n");
}

fn discipline(topic: &TopicLayout) -> String {
    format!("{:?}", topic.row.discipline).to_lowercase()
}

fn type_of(shape: &Shape) -> String {
    match shape {
        Shape::Number(number) => format!("{number:?}").to_lowercase(),
        Shape::Array { of, len } => format!("{} * {len}", type_of(of)),
        Shape::Message { name, .. } => name_of(name),
    }
}

/// `ROBOT_SCAN` for `robot/scan`.
fn constant(topic: &str) -> String {
    topic.replace('/', "_").to_uppercase()
}

fn upper(role: Role) -> String {
    role.label().to_uppercase()
}
