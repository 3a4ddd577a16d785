//! Every field of every message says what it is: its unit, its code, or what it counts.

use std::convert::Infallible;
use zeronav_msgs::fields::{Field, ID, KINDS, Number, Shape, TEXT};
use zeronav_msgs::labels::label;
use zeronav_msgs::message::Wire;
use zeronav_msgs::span::Span;
use zeronav_msgs::topics::{Topic, TopicRow, TopicVisitor, visit_topics};

/// Units that are in use. A `,` separates those of an array with several.
const UNITS: [&str; 19] = [
    "m", "rad", "s", "m/s", "rad/s", "m/s^2", "rad/s^2", "m^2", "rad^2", "m^2/s", "m^2/s^2", "1/m",
    "mm", "ms", "us", "ns", "10 us", "ppm", "-",
];

/// What a suffix of a name says, longest first.
const SUFFIXES: [(&str, &str); 10] = [
    ("_per_m", "1/m"),
    ("_radps2_max", "rad/s^2"),
    ("_mps2_max", "m/s^2"),
    ("_mps2", "m/s^2"),
    ("_radps", "rad/s"),
    ("_mps", "m/s"),
    ("_rad", "rad"),
    ("_mm", "mm"),
    ("_ns", "ns"),
    ("_m", "m"),
];

/// Collects the fields of every message at any depth, with the name of the type that has them.
#[derive(Default)]
struct Collector {
    fields: Vec<(&'static str, &'static Field)>,
    numbers: Vec<(&'static TopicRow, &'static Shape)>,
}

impl Collector {
    fn shape(&mut self, shape: &'static Shape) {
        match shape {
            Shape::Number(_) => {}
            Shape::Array { of, .. } => self.shape(of),
            Shape::Message { name, fields, .. } => {
                for field in *fields {
                    self.fields.push((name, field));
                    self.shape(field.shape);
                }
            }
        }
    }
}

impl TopicVisitor for Collector {
    type Error = Infallible;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), Infallible> {
        self.shape(T::Envelope::SHAPE);
        self.shape(T::Item::SHAPE);
        if row.len_max > 1 && matches!(T::Item::SHAPE, Shape::Number(_)) {
            self.numbers.push((row, T::Meta::SHAPE));
        }
        Ok(())
    }

    fn records(&mut self, _: &'static TopicRow) -> Result<(), Infallible> {
        self.shape(Span::SHAPE);
        Ok(())
    }
}

fn collect() -> Collector {
    let mut collector = Collector::default();
    let Ok(()) = visit_topics(&mut collector);
    collector
}

/// The number that an array repeats, or the field itself; `None` for messages.
fn number_of(shape: &Shape) -> Option<Number> {
    match shape {
        Shape::Number(number) => Some(*number),
        Shape::Array { of, .. } => number_of(of),
        Shape::Message { .. } => None,
    }
}

/// What is wrong with the description of a field.
fn problem(field: &Field) -> Option<String> {
    let number = number_of(field.shape)?;
    if field.is_spare() {
        return None;
    }
    if let Some(code) = field.code() {
        let known = (0..u16::MAX).any(|n| label(code, n).is_some());
        return (!known).then(|| format!("no enum {code} in labels.rs"));
    }
    let Some(unit) = field.unit() else {
        return Some("no unit, code or kind".to_owned());
    };
    let is_kind = KINDS.contains(&unit);
    if !is_kind && !unit.split(", ").all(|unit| UNITS.contains(&unit)) {
        return Some(format!("unknown unit {unit}"));
    }
    if is_kind && matches!(number, Number::F32 | Number::F64) {
        return Some(format!("a real number cannot be [{unit}]"));
    }
    if (unit == ID && number != Number::U64)
        || ((unit == TEXT) != (number == Number::U8 && is_array(field)))
    {
        return Some(format!("[{unit}] of another type"));
    }
    let suffix = SUFFIXES.iter().find(|(suffix, _)| {
        let name = field.name.trim_end_matches("_max").trim_end_matches("_min");
        field.name.ends_with(suffix) || name.ends_with(suffix)
    });
    suffix
        .filter(|(_, said)| *said != unit)
        .map(|(suffix, _)| format!("{suffix} is not {unit}"))
}

fn is_array(field: &Field) -> bool {
    matches!(field.shape, Shape::Array { .. })
}

#[test]
fn every_field_has_a_unit_a_code_or_a_kind() {
    let fields = collect().fields;
    assert!(fields.len() > 300, "{} fields", fields.len());
    let wrong: std::collections::BTreeSet<String> = fields
        .iter()
        .filter_map(|(name, field)| Some(format!("{name} {}: {}", field.name, problem(field)?)))
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn slices_of_plain_numbers_have_a_unit() {
    let numbers = collect().numbers;
    assert_eq!(numbers.len(), 1, "the ranges of a scan");
    for (row, meta) in numbers {
        assert_eq!(meta.item_unit(), Some("m"), "{}", row.name);
    }
}

#[test]
fn fields_fill_their_message_without_a_gap() {
    fn check(shape: &Shape) {
        match shape {
            Shape::Number(_) => {}
            Shape::Array { of, .. } => check(of),
            Shape::Message {
                name,
                fields,
                bytes,
                ..
            } => {
                let mut end = 0;
                for field in *fields {
                    assert_eq!(field.offset, end, "{name}.{}", field.name);
                    end += field.shape.bytes();
                    check(field.shape);
                }
                assert_eq!(end, *bytes, "{name}");
            }
        }
    }
    check(Span::SHAPE);
    for (_, field) in collect().fields {
        check(field.shape);
    }
}

#[test]
fn codes_are_shown_by_name_and_unknown_ones_by_number() {
    assert_eq!(label("Role", 4), Some("global_planner"));
    assert_eq!(label("Role", 99), None);
    assert_eq!(label("Nothing", 0), None);
}

#[test]
fn spare_fields_are_those_that_say_so() {
    let fields = collect().fields;
    let spare: Vec<_> = fields
        .iter()
        .filter(|(_, field)| field.is_spare())
        .collect();
    assert!(
        spare
            .iter()
            .all(|(_, field)| field.name.starts_with("spare"))
    );
    let named = fields
        .iter()
        .filter(|(_, field)| field.name.starts_with("spare"));
    assert_eq!(spare.len(), named.count());
    assert!(spare.len() > 5);
}
