//! The values in a message's bytes, by the declaration of their fields: for people and as JSON.

use serde::ser::{Serialize, SerializeMap, SerializeSeq, Serializer};
use std::io::{Result, Write};
use zeronav_msgs::fields::{Field, ID, KINDS, Number, Shape, TEXT};
use zeronav_msgs::header::Id;
use zeronav_msgs::labels::label;

/// Elements of an array that are shown to people.
const SHOWN_MAX: usize = 12;

/// Bytes of a message with what they are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Value<'a> {
    /// What they are.
    pub shape: &'static Shape,
    /// As many bytes as the shape has.
    pub bytes: &'a [u8],
    /// The field in which they lie; `None` for a whole message or an item.
    pub field: Option<&'static Field>,
}

/// What a number is to its reader.
enum Scalar {
    Word(String),
    Unsigned(u64),
    Signed(i64),
    Single(f32),
    Double(f64),
}

impl<'a> Value<'a> {
    /// A message.
    pub(super) fn of(shape: &'static Shape, bytes: &'a [u8]) -> Self {
        Self {
            shape,
            bytes,
            field: None,
        }
    }

    /// Its fields that hold something; none unless it is a message.
    fn fields(&self) -> impl Iterator<Item = (&'static Field, Value<'a>)> + use<'a> {
        let fields = match self.shape {
            Shape::Message { fields, .. } => *fields,
            Shape::Number(_) | Shape::Array { .. } => &[],
        };
        let bytes = self.bytes;
        fields
            .iter()
            .filter(|field| !field.is_spare())
            .map(|field| {
                let value = Value {
                    shape: field.shape,
                    bytes: &bytes[field.offset..field.offset + field.shape.bytes()],
                    field: Some(field),
                };
                (field, value)
            })
    }

    fn is_text(&self) -> bool {
        self.field.and_then(Field::unit) == Some(TEXT)
    }

    /// Bytes up to the first 0. [`zeronav_msgs::topics::decode`] accepts none but ASCII.
    fn text(&self) -> String {
        let text = self.bytes.split(|byte| *byte == 0).next();
        String::from_utf8_lossy(text.unwrap_or_default()).into_owned()
    }

    fn scalar(&self, number: Number) -> Scalar {
        let bytes = self.bytes;
        let scalar = match number {
            Number::U8 => Scalar::Unsigned(read::<u8>(bytes).into()),
            Number::U16 => Scalar::Unsigned(read::<u16>(bytes).into()),
            Number::U32 => Scalar::Unsigned(read::<u32>(bytes).into()),
            Number::U64 => Scalar::Unsigned(read(bytes)),
            Number::I16 => Scalar::Signed(read::<i16>(bytes).into()),
            Number::I32 => Scalar::Signed(read::<i32>(bytes).into()),
            Number::I64 => Scalar::Signed(read(bytes)),
            Number::F32 => Scalar::Single(read(bytes)),
            Number::F64 => Scalar::Double(read(bytes)),
        };
        match (scalar, self.field) {
            (Scalar::Unsigned(code), Some(field)) if field.code().is_some() => {
                let code16 = u16::try_from(code).ok();
                let word = code16.and_then(|code| label(field.code().unwrap_or(""), code));
                word.map_or(Scalar::Unsigned(code), |word| Scalar::Word(word.to_owned()))
            }
            (Scalar::Unsigned(id), Some(field)) if field.unit() == Some(ID) => {
                Scalar::Word(Id(id).to_string())
            }
            // JSON has no such numbers.
            (Scalar::Single(real), _) if !real.is_finite() => Scalar::Word(irregular(real.into())),
            (Scalar::Double(real), _) if !real.is_finite() => Scalar::Word(irregular(real)),
            (scalar, _) => scalar,
        }
    }

    /// Writes it for people: `name: value unit`, what it consists of indented below.
    pub(super) fn write(
        &self,
        to: &mut dyn Write,
        indent: usize,
        name: &str,
        unit: &str,
    ) -> Result<()> {
        let unit = match unit {
            "" | "-" => String::new(),
            unit if KINDS.contains(&unit) => String::new(),
            unit => format!(" {unit}"),
        };
        match self.shape {
            _ if self.is_text() => writeln!(to, "{:indent$}{name}: {}", "", self.text()),
            Shape::Number(number) => {
                writeln!(to, "{:indent$}{name}: {}{unit}", "", self.scalar(*number))
            }
            Shape::Array { of, .. } => {
                write_all(to, indent, name, &unit, of, self.bytes, self.field)
            }
            Shape::Message { .. } => {
                writeln!(to, "{:indent$}{name}:", "")?;
                self.write_fields(to, indent + 2)
            }
        }
    }

    /// Writes the fields of a message.
    pub(super) fn write_fields(&self, to: &mut dyn Write, indent: usize) -> Result<()> {
        for (field, value) in self.fields() {
            value.write(to, indent, field.name, field.unit().unwrap_or(""))?;
        }
        Ok(())
    }
}

/// Writes equal elements: numbers on a line, messages below each other, the first of many.
pub(super) fn write_all(
    to: &mut dyn Write,
    indent: usize,
    name: &str,
    unit: &str,
    of: &'static Shape,
    bytes: &[u8],
    field: Option<&'static Field>,
) -> Result<()> {
    let elements = bytes.chunks_exact(of.bytes().max(1));
    let (len, shown) = (elements.len(), elements.take(SHOWN_MAX));
    let more = len.saturating_sub(SHOWN_MAX);
    if let Shape::Number(number) = of {
        let shape = of;
        let mut words: Vec<String> = shown
            .map(|bytes| {
                let value = Value {
                    shape,
                    bytes,
                    field,
                };
                value.scalar(*number).to_string()
            })
            .collect();
        if more > 0 {
            words.push(format!("... {len} in all"));
        }
        return writeln!(to, "{:indent$}{name}: [{}]{unit}", "", words.join(", "));
    }
    writeln!(to, "{:indent$}{name}: {len}", "")?;
    for (n, bytes) in shown.enumerate() {
        Value::of(of, bytes).write(to, indent + 2, &n.to_string(), "")?;
    }
    if more > 0 {
        writeln!(to, "{:indent$}  ... and {more} more", "")?;
    }
    Ok(())
}

impl core::fmt::Display for Scalar {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Word(word) => f.write_str(word),
            Self::Unsigned(number) => number.fmt(f),
            Self::Signed(number) => number.fmt(f),
            Self::Single(number) => number.fmt(f),
            Self::Double(number) => number.fmt(f),
        }
    }
}

impl Serialize for Value<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> core::result::Result<S::Ok, S::Error> {
        match self.shape {
            _ if self.is_text() => to.serialize_str(&self.text()),
            Shape::Number(number) => match self.scalar(*number) {
                Scalar::Word(word) => to.serialize_str(&word),
                Scalar::Unsigned(number) => to.serialize_u64(number),
                Scalar::Signed(number) => to.serialize_i64(number),
                Scalar::Single(number) => to.serialize_f32(number),
                Scalar::Double(number) => to.serialize_f64(number),
            },
            Shape::Array { of, .. } => Elements {
                of,
                bytes: self.bytes,
                field: self.field,
            }
            .serialize(to),
            Shape::Message { .. } => {
                let mut map = to.serialize_map(None)?;
                for (field, value) in self.fields() {
                    map.serialize_entry(field.name, &value)?;
                }
                map.end()
            }
        }
    }
}

/// Equal elements, one behind the other.
pub(super) struct Elements<'a> {
    /// One of them.
    pub of: &'static Shape,
    /// All of them.
    pub bytes: &'a [u8],
    /// The field in which they lie.
    pub field: Option<&'static Field>,
}

impl Serialize for Elements<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> core::result::Result<S::Ok, S::Error> {
        let elements = self.bytes.chunks_exact(self.of.bytes().max(1));
        let mut seq = to.serialize_seq(Some(elements.len()))?;
        for bytes in elements {
            seq.serialize_element(&Value {
                shape: self.of,
                bytes,
                field: self.field,
            })?;
        }
        seq.end()
    }
}

/// Unit, kind or `code` of every number below `shape`, with the path to it.
pub(super) fn units(path: &str, shape: &'static Shape, into: &mut Vec<(String, &'static str)>) {
    match shape {
        Shape::Number(_) => {}
        Shape::Array { of, .. } => units(path, of, into),
        Shape::Message { fields, .. } => {
            for field in fields.iter().filter(|field| !field.is_spare()) {
                let path = format!("{path}.{}", field.name);
                let code = field.code().map(|_| "code");
                match code.or_else(|| field.unit()) {
                    Some(unit) => into.push((path, unit)),
                    None => units(&path, field.shape, into),
                }
            }
        }
    }
}

fn read<T: bytemuck::AnyBitPattern>(bytes: &[u8]) -> T {
    bytemuck::pod_read_unaligned(bytes)
}

fn irregular(real: f64) -> String {
    match real {
        real if real.is_nan() => "nan",
        real if real > 0.0 => "inf",
        _ => "-inf",
    }
    .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::message::Wire;
    use zeronav_msgs::path::{Path, PathCause, PathStatus, Waypoint};

    fn path() -> Path {
        Path {
            geometry: Id::new(3, 7).0,
            cost: f64::INFINITY,
            ..Path::new("jps", PathStatus::Found, PathCause::Request, 5, &[])
        }
    }

    #[test]
    fn numbers_codes_identities_and_text_come_by_name() {
        let path = path();
        let value = Value::of(Path::SHAPE, bytemuck::bytes_of(&path));
        let json = serde_json::to_value(value).expect("JSON");
        assert_eq!(json["planner"], "jps");
        assert_eq!(json["status"], "found");
        assert_eq!(json["cause"], "request");
        assert_eq!(json["geometry"], "3:7");
        assert_eq!(json["goal"], 5);
        assert_eq!(json["length_m"], 0.0);
        assert_eq!(json["cost"], "inf");
        assert_eq!(json["bound"], 0.0);
        assert_eq!(json.as_object().map(serde_json::Map::len), Some(18));
    }

    #[test]
    fn unknown_codes_come_as_numbers() {
        let path = Path {
            status: 999,
            ..path()
        };
        let value = Value::of(Path::SHAPE, bytemuck::bytes_of(&path));
        assert_eq!(serde_json::to_value(value).expect("JSON")["status"], 999);
    }

    #[test]
    fn people_see_units_and_the_first_of_many() {
        let waypoint = Waypoint {
            x_m: 1.5,
            yaw_rad: f32::NAN,
            ..Waypoint::default()
        };
        let mut text = Vec::new();
        let items = vec![waypoint; 20];
        let bytes = bytemuck::cast_slice(&items);
        write_all(&mut text, 0, "items", "", Waypoint::SHAPE, bytes, None).expect("written");
        let text = String::from_utf8(text).expect("text");
        assert!(
            text.starts_with("items: 20\n  0:\n    x_m: 1.5 m\n    y_m: 0 m\n"),
            "{text}"
        );
        assert!(text.contains("yaw_rad: nan rad\n"), "{text}");
        assert!(text.ends_with("  ... and 8 more\n"), "{text}");
    }
}
