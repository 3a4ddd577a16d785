//! The contract in C++17: plain structures whose layout the compiler checks, and a type per topic.

use crate::contract::{Codes, Contract, Structure, TopicLayout, name_of};
use crate::words::{plain, wrap};
use core::fmt::Write;
use zeronav_msgs::fields::{Number, Shape};
use zeronav_msgs::role::Role;

/// Where it is kept, from the root of the workspace.
pub(crate) const FILE: &str = "services/cpp/zeronav.hpp";

const HEAD: &str = r#"// The contract between the processes of zeronav: messages, codes, topics.
//
// Written by `cargo run -p zeronav-msgs --example bindings`; changes belong into the crate `msgs`.
// The compiler checks size, offsets and schema hash of every message.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <type_traits>

namespace zeronav {

/// 64-bit FNV-1a of `bytes`, continued from `state`.
constexpr std::uint64_t fnv1a(std::uint64_t state, std::string_view bytes) {
    for (const char byte : bytes) {
        state = (state ^ static_cast<unsigned char>(byte)) * 0x0000'0100'0000'01b3;
    }
    return state;
}

/// 64-bit FNV-1a of the bytes of `number`, the lowest first, continued from `state`.
constexpr std::uint64_t fnv1a_number(std::uint64_t state, std::uint64_t number) {
    for (int byte = 0; byte < 8; ++byte) {
        state = (state ^ ((number >> (8 * byte)) & 0xff)) * 0x0000'0100'0000'01b3;
    }
    return state;
}

/// Start value of the hash.
inline constexpr std::uint64_t FNV_OFFSET = 0xcbf2'9ce4'8422'2325;

/// The schema hash of a type: over names, order, types and offsets.
template <typename T>
struct Schema {
    static constexpr std::uint64_t value = T::SCHEMA;
};
template <typename T, std::size_t N>
struct Schema<T[N]> {
    static constexpr std::uint64_t value = fnv1a_number(fnv1a(Schema<T>::value, "["), N);
};
"#;

/// The numbers of the contract in C++.
const NUMBERS: [(Number, &str); 7] = [
    (Number::U8, "std::uint8_t"),
    (Number::U16, "std::uint16_t"),
    (Number::U32, "std::uint32_t"),
    (Number::U64, "std::uint64_t"),
    (Number::I32, "std::int32_t"),
    (Number::F32, "float"),
    (Number::F64, "double"),
];

/// The text of the file.
pub(crate) fn text(contract: &Contract) -> String {
    let mut text = HEAD.to_owned();
    for (number, name) in NUMBERS {
        let known = format!("{number:?}").to_lowercase();
        let value =
            format!("static constexpr std::uint64_t value = fnv1a(FNV_OFFSET, \"{known}\");");
        let _ = write!(
            text,
            "template <>\nstruct Schema<{name}> {{\n    {value}\n}};\n"
        );
    }
    for codes in &contract.codes {
        write_codes(&mut text, codes);
    }
    text.push('\n');
    for (name, value) in &contract.constants {
        let kind = if value.fract() == 0.0 {
            "int"
        } else {
            "double"
        };
        let _ = writeln!(text, "inline constexpr {kind} {name} = {value};");
    }
    for message in &contract.messages {
        write_message(&mut text, message);
    }
    text.push_str(
        "\n/// Every topic: name, types, who writes it and whose doorbell a message rings.\n",
    );
    text.push_str("namespace topics {\n");
    for topic in &contract.topics {
        write_topic(&mut text, topic);
    }
    let names: Vec<String> = contract.topics.iter().map(type_name).collect();
    text.push_str("\n/// All of them.\n");
    let all = format!("using All = std::tuple<{}>;", names.join(", "));
    wrap(&mut text, &all, "", "    ");
    text.push_str("\n}  // namespace topics\n\n}  // namespace zeronav\n");
    text
}

fn write_codes(text: &mut String, codes: &Codes) {
    let _ = writeln!(text, "\nenum class {} : std::uint16_t {{", codes.name);
    for (code, label) in &codes.values {
        let _ = writeln!(text, "    {label} = {code},");
    }
    text.push_str("};\n");
}

fn write_message(text: &mut String, message: &Structure) {
    text.push('\n');
    wrap(text, &format!("/// {}", plain(message.doc)), "", "/// ");
    let Structure {
        name,
        type_name,
        bytes,
        schema,
        ..
    } = message;
    let _ = writeln!(text, "struct {name} {{");
    let _ = writeln!(
        text,
        "    static constexpr const char* NAME = \"{type_name}\";"
    );
    let _ = writeln!(
        text,
        "    static constexpr std::uint64_t SCHEMA = 0x{schema:016x};"
    );
    for field in message.fields {
        wrap(text, &format!("/// {}", plain(field.doc)), "    ", "/// ");
        let (kind, lengths) = declared(field.shape);
        let _ = writeln!(text, "    {kind} {}{lengths}{{}};", field.name);
    }
    text.push_str("};\n");
    let _ = writeln!(text, "static_assert(sizeof({name}) == {bytes});");
    let plain_old =
        format!("std::is_trivially_copyable_v<{name}> && std::is_standard_layout_v<{name}>");
    let _ = writeln!(text, "static_assert({plain_old});");
    for field in message.fields {
        let _ = writeln!(
            text,
            "static_assert(offsetof({name}, {}) == {});",
            field.name, field.offset
        );
    }
    write_schema(text, message);
}

/// The schema hash once more, by the compiler.
fn write_schema(text: &mut String, message: &Structure) {
    let Structure { name, .. } = message;
    let _ = writeln!(text, "static_assert({name}::SCHEMA == [] {{");
    let _ = writeln!(
        text,
        "    std::uint64_t hash = fnv1a(FNV_OFFSET, {name}::NAME);"
    );
    for field in message.fields {
        let field = field.name;
        let _ = writeln!(text, "    hash = fnv1a(hash, \"{field}\");");
        let kind = format!("decltype({name}::{field})");
        let _ = writeln!(
            text,
            "    hash = fnv1a_number(hash, Schema<{kind}>::value);"
        );
        let _ = writeln!(
            text,
            "    hash = fnv1a_number(hash, offsetof({name}, {field}));"
        );
    }
    text.push_str("    return hash;\n}());\n");
}

fn write_topic(text: &mut String, topic: &TopicLayout) {
    let row = topic.row;
    let (item, _) = declared(topic.item);
    let envelope = topic.envelope.as_deref().unwrap_or("void");
    let roles = |name: &str, roles: &[Role]| {
        let values: Vec<String> = roles
            .iter()
            .map(|role| format!("Role::{}", role.label()))
            .collect();
        let n = values.len();
        format!(
            "static constexpr std::array<Role, {n}> {name}{{{}}}",
            values.join(", ")
        )
    };
    let number =
        |name: &str, value: usize| format!("static constexpr std::size_t {name} = {value}");
    let _ = writeln!(text, "\nstruct {} {{", type_name(topic));
    for line in [
        format!("using Envelope = {envelope}"),
        format!("using Item = {item}"),
        format!("static constexpr const char* NAME = \"{}\"", row.name),
        format!(
            "static constexpr std::uint64_t SCHEMA = 0x{:016x}",
            row.schema
        ),
        number("NUMBER", row.number),
        number("LEN_MAX", row.len_max),
        number("BUFFER", row.service_buffer()),
        number("POOL", row.pool()),
        roles("WRITERS", row.writers),
        roles("RINGS", row.rings),
        roles("RINGS_IN_LOCKSTEP", row.rings_in_lockstep),
    ] {
        wrap(text, &format!("{line};"), "    ", "    ");
    }
    text.push_str("};\n");
}

/// Name of a topic's type: `robot_scan` for `robot/scan`.
fn type_name(topic: &TopicLayout) -> String {
    topic.row.name.replace('/', "_")
}

/// Type and array lengths of a declaration.
fn declared(shape: &Shape) -> (String, String) {
    match shape {
        Shape::Number(number) => {
            let known = NUMBERS.iter().find(|(known, _)| known == number);
            let name = known.map_or("void", |(_, name)| *name);
            (name.to_owned(), String::new())
        }
        Shape::Array { of, len } => {
            let (kind, lengths) = declared(of);
            (kind, format!("[{len}]{lengths}"))
        }
        Shape::Message { name, .. } => (name_of(name), String::new()),
    }
}
