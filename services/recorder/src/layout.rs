//! What the bytes of a message on a channel for replay mean, by what its channel says of them: a recording of
//! another version of the contract is read by its own description.

use serde_json::Value;
use std::collections::BTreeMap;
use zeronav_msgs::fields::{ID, Number, TEXT};
use zeronav_msgs::header::Id;
use zeronav_msgs::labels::label;

/// Most values of a message without its items, and of an item: more are in no contract.
const LEAVES_MAX: usize = 65_536;

/// Deepest nesting of types.
const DEPTH_MAX: usize = 16;

/// Largest message without its items, and largest item. [bytes]
const BYTES_MAX: u64 = 16 << 20;

/// Longest description, and longest path or unit of a value. [bytes]
const TEXT_BYTES_MAX: usize = 1 << 20;
const WORD_BYTES_MAX: usize = 256;

/// Fields that say when something happened by the clock of the machine, or follow from such: they differ
/// between two runs that do the same.
const CLOCK_FIELDS: [&str; 7] = [
    "woken_ns",
    "started_ns",
    "published_ns",
    "capture_ns",
    "zero_ns",
    "appeared_ns",
    "checksum",
];

/// Name of fields that hold nothing.
const SPARE: &str = "spare";

/// Why a channel's description cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("channel {channel}: its metadata has no usable `{what}`")]
pub struct LayoutError {
    /// Name of the channel.
    pub channel: String,
    /// What is missing or wrong.
    pub what: &'static str,
}

/// What a value is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A number.
    Number(Number),
    /// ASCII, padded with 0.
    Text,
}

/// One value in a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Leaf {
    /// Its name with those of what it lies in, such as `meta.v_mps` or `meta.corners[3].x_m`.
    pub path: String,
    /// Where it begins. [bytes]
    pub offset: usize,
    /// Its size. [bytes]
    pub bytes: usize,
    /// What it is.
    pub kind: Kind,
    /// Its unit, or what kind of number it is.
    pub unit: Option<String>,
    /// The enum whose code it is.
    pub code: Option<String>,
}

/// The values of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// Those of header and fixed fields, or of a record.
    pub envelope: Vec<Leaf>,
    /// Size of that part. [bytes]
    pub envelope_bytes: usize,
    /// Those of an item.
    pub item: Vec<Leaf>,
    /// Size of an item. [bytes]
    pub item_bytes: usize,
}

impl Layout {
    /// By the metadata of the channel.
    ///
    /// # Errors
    /// [`LayoutError`] naming the channel.
    pub fn of(channel: &str, metadata: &BTreeMap<String, String>) -> Result<Self, LayoutError> {
        let wrong = |what| LayoutError {
            channel: channel.to_owned(),
            what,
        };
        let bytes = |key: &'static str| {
            let text = metadata.get(key).and_then(|text| text.parse::<u64>().ok());
            let bytes = text.filter(|bytes| *bytes <= BYTES_MAX);
            let bytes = bytes.and_then(|bytes| usize::try_from(bytes).ok());
            bytes.ok_or_else(|| wrong(key))
        };
        let (envelope_bytes, item_bytes) = (bytes("envelope_bytes")?, bytes("item_bytes")?);
        let layout = metadata.get("layout").map(String::as_str);
        let layout = layout.filter(|layout| layout.len() <= TEXT_BYTES_MAX);
        let layout: Value =
            serde_json::from_str(layout.unwrap_or_default()).map_err(|_| wrong("layout"))?;
        let leaves = |part: &str, bytes: usize| {
            let mut flat = Flat {
                leaves: Vec::new(),
                steps: 0,
                used: 0,
                bytes,
            };
            let of = &layout[part];
            if !of.is_null() {
                let size = flat.add(of, "", 0, None, 0);
                size.ok_or_else(|| wrong("layout"))?;
            }
            Ok(flat.leaves)
        };
        Ok(Self {
            envelope: leaves("envelope", envelope_bytes)?,
            envelope_bytes,
            item: leaves("item", item_bytes)?,
            item_bytes,
        })
    }

    /// The value at this path of header and fixed fields, if it is an unsigned number.
    #[must_use]
    pub fn number(&self, envelope: &[u8], path: &str) -> Option<u64> {
        Self::unsigned(&self.envelope, envelope, path)
    }

    /// The value at this path of a part with these values, if it is an unsigned number.
    #[must_use]
    pub fn unsigned(leaves: &[Leaf], part: &[u8], path: &str) -> Option<u64> {
        let leaf = leaves.iter().find(|leaf| leaf.path == path)?;
        leaf.unsigned(leaf.of(part)?)
    }

    /// The value at this path of a part with these values, as a number.
    #[must_use]
    pub fn real(leaves: &[Leaf], part: &[u8], path: &str) -> Option<f64> {
        let leaf = leaves.iter().find(|leaf| leaf.path == path)?;
        leaf.text(leaf.of(part)?).parse().ok()
    }

    /// The value at this path of header and fixed fields as people read it.
    #[must_use]
    pub fn word(&self, envelope: &[u8], path: &str) -> Option<String> {
        let leaf = self.envelope.iter().find(|leaf| leaf.path == path)?;
        Some(leaf.text(leaf.of(envelope)?))
    }

    /// A message in its two parts; `None` when it is shorter than it can be.
    #[must_use]
    pub fn parts<'a>(&self, message: &'a [u8]) -> Option<(&'a [u8], &'a [u8])> {
        let (envelope, items) = message.split_at_checked(self.envelope_bytes)?;
        let is_whole = self.item_bytes == 0 || items.len().is_multiple_of(self.item_bytes);
        is_whole.then_some((envelope, items))
    }
}

impl Leaf {
    /// The bytes of this value in those of its part.
    #[must_use]
    pub fn of<'a>(&self, part: &'a [u8]) -> Option<&'a [u8]> {
        part.get(self.offset..self.offset.checked_add(self.bytes)?)
    }

    /// The bytes of a value that say what it is in every run that does the same: none of what the machine's clock
    /// says, and of an identity those of its count.
    #[must_use]
    pub fn repeatable<'a>(&self, value: &'a [u8]) -> &'a [u8] {
        let name = self.path.rsplit('.').next().unwrap_or_default();
        if CLOCK_FIELDS.contains(&name) {
            return &[];
        }
        match self.unit.as_deref() {
            // The upper three say which start of its author it was.
            Some(ID) if value.len() == 8 => &value[..5],
            _ => value,
        }
    }

    fn unsigned(&self, value: &[u8]) -> Option<u64> {
        match self.kind {
            Kind::Number(Number::U8 | Number::U16 | Number::U32 | Number::U64) => {
                let mut wide = [0; 8];
                wide.get_mut(..value.len())?.copy_from_slice(value);
                Some(u64::from_le_bytes(wide))
            }
            Kind::Number(_) | Kind::Text => None,
        }
    }

    /// A value as people read it, without its unit.
    #[must_use]
    pub fn text(&self, value: &[u8]) -> String {
        let Kind::Number(number) = self.kind else {
            let text = value.split(|byte| *byte == 0).next().unwrap_or_default();
            return String::from_utf8_lossy(text).into_owned();
        };
        if let Some(unsigned) = self.unsigned(value) {
            let code = self.code.as_deref().zip(u16::try_from(unsigned).ok());
            return match (code.and_then(|(name, code)| label(name, code)), &self.unit) {
                (Some(word), _) => word.to_owned(),
                (None, Some(unit)) if unit == ID => Id(unsigned).to_string(),
                (None, _) => unsigned.to_string(),
            };
        }
        match number {
            Number::F32 => read::<4>(value)
                .map(f32::from_le_bytes)
                .map(|it| it.to_string()),
            Number::F64 => read::<8>(value)
                .map(f64::from_le_bytes)
                .map(|it| it.to_string()),
            Number::I16 => read::<2>(value)
                .map(i16::from_le_bytes)
                .map(|it| it.to_string()),
            Number::I32 => read::<4>(value)
                .map(i32::from_le_bytes)
                .map(|it| it.to_string()),
            Number::I64 => read::<8>(value)
                .map(i64::from_le_bytes)
                .map(|it| it.to_string()),
            Number::U8 | Number::U16 | Number::U32 | Number::U64 => None,
        }
        .unwrap_or_default()
    }
}

fn read<const N: usize>(value: &[u8]) -> Option<[u8; N]> {
    value.try_into().ok()
}

/// What a field says of what lies in it.
#[derive(Clone, Copy)]
struct About<'a> {
    unit: Option<&'a str>,
    code: Option<&'a str>,
}

/// The values of a part, one after the other.
struct Flat {
    leaves: Vec<Leaf>,
    /// Parts that were looked at, which may be without a value.
    steps: usize,
    /// Bytes of the values so far.
    used: usize,
    /// Size of the part. [bytes]
    bytes: usize,
}

impl Flat {
    /// Adds what lies at `offset`; its size [bytes], or `None` when that cannot be.
    fn add(
        &mut self,
        of: &Value,
        path: &str,
        offset: usize,
        about: Option<About<'_>>,
        depth: usize,
    ) -> Option<usize> {
        self.steps += 1;
        if depth > DEPTH_MAX || self.steps > 2 * LEAVES_MAX {
            return None;
        }
        match of {
            Value::String(word) => {
                let number = number(word)?;
                self.leaf(path, offset, number.bytes(), Kind::Number(number), about)
            }
            Value::Object(fields) if fields.contains_key("of") => {
                let len = usize::try_from(fields.get("len")?.as_u64()?).ok()?;
                let of = &fields["of"];
                if about.is_some_and(|about| about.unit == Some(TEXT)) && of == "u8" {
                    return self.leaf(path, offset, len, Kind::Text, about);
                }
                // One unit for all, or one for each.
                let units: Vec<&str> = about
                    .and_then(|about| about.unit)
                    .map_or_else(Vec::new, |units| units.split(", ").collect());
                let mut end = 0;
                for n in 0..len {
                    let path = format!("{path}[{n}]");
                    let about = about.map(|about| About {
                        unit: if units.len() == len {
                            Some(units[n])
                        } else {
                            about.unit
                        },
                        ..about
                    });
                    let bytes = self.add(of, &path, offset.checked_add(end)?, about, depth + 1)?;
                    end = end.checked_add(bytes)?;
                }
                Some(end)
            }
            Value::Object(message) => {
                let dot = if path.is_empty() { "" } else { "." };
                for field in message.get("fields")?.as_array()? {
                    let name = field["name"].as_str()?;
                    if name == SPARE {
                        continue;
                    }
                    let at = usize::try_from(field["offset"].as_u64()?).ok()?;
                    let about = About {
                        unit: field["unit"].as_str(),
                        code: field["code"].as_str(),
                    };
                    let path = format!("{path}{dot}{name}");
                    let at = offset.checked_add(at)?;
                    self.add(&field["type"], &path, at, Some(about), depth + 1)?;
                }
                usize::try_from(message.get("bytes")?.as_u64()?).ok()
            }
            _ => None,
        }
    }

    fn leaf(
        &mut self,
        path: &str,
        offset: usize,
        bytes: usize,
        kind: Kind,
        about: Option<About<'_>>,
    ) -> Option<usize> {
        // No two values share bytes, so that there are no more of them than bytes.
        self.used = self.used.checked_add(bytes)?;
        let fits = offset.checked_add(bytes)? <= self.bytes && self.used <= self.bytes;
        let words = [
            Some(path),
            about.and_then(|it| it.unit),
            about.and_then(|it| it.code),
        ];
        let are_short = words
            .iter()
            .flatten()
            .all(|word| word.len() <= WORD_BYTES_MAX);
        if !fits || bytes == 0 || !are_short || self.leaves.len() >= LEAVES_MAX {
            return None;
        }
        self.leaves.push(Leaf {
            path: path.to_owned(),
            offset,
            bytes,
            kind,
            unit: about.and_then(|it| it.unit).map(str::to_owned),
            code: about.and_then(|it| it.code).map(str::to_owned),
        });
        Some(bytes)
    }
}

fn number(word: &str) -> Option<Number> {
    Some(match word {
        "u8" => Number::U8,
        "u16" => Number::U16,
        "u32" => Number::U32,
        "u64" => Number::U64,
        "i16" => Number::I16,
        "i32" => Number::I32,
        "i64" => Number::I64,
        "f32" => Number::F32,
        "f64" => Number::F64,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::native;
    use proptest::prelude::*;
    use zeronav_msgs::topics::{PlanPath, RobotOdometry, Topic};

    fn metadata(number: usize) -> BTreeMap<String, String> {
        let topics = native::topics();
        let topic = topics.iter().find(|topic| topic.row.number == number);
        topic.expect("a topic").metadata()
    }

    #[test]
    fn every_topic_of_the_contract_is_laid_out() {
        for topic in native::topics() {
            let layout = Layout::of(topic.row.name, &topic.metadata()).expect("a layout");
            assert_eq!(layout.envelope_bytes, topic.row.envelope_bytes);
            assert_eq!(
                layout.item_bytes, topic.row.item_bytes,
                "{}",
                topic.row.name
            );
            let has = |path: &str| layout.envelope.iter().any(|leaf| leaf.path == path);
            assert_eq!(
                has("header.tick"),
                layout.envelope_bytes > 0,
                "{}",
                topic.row.name
            );
        }
    }

    #[test]
    fn values_are_read_by_their_names() {
        let layout = Layout::of("it", &metadata(RobotOdometry::ROW.number)).expect("a layout");
        let leaf = |path: &str| layout.envelope.iter().find(|leaf| leaf.path == path);
        let mut envelope = vec![0; layout.envelope_bytes];
        let v = leaf("meta.twist.v_mps").or_else(|| leaf("meta.v_mps"));
        let v = v.expect("a speed");
        envelope[v.offset..v.offset + 8].copy_from_slice(&0.5_f64.to_le_bytes());
        let id = leaf("header.id").expect("an identity");
        let value = Id::new(3, 7).0.to_le_bytes();
        envelope[id.offset..id.offset + 8].copy_from_slice(&value);
        let role = leaf("header.role").expect("a role");
        envelope[role.offset] = 2;
        let text = |leaf: &Leaf| leaf.text(leaf.of(&envelope).expect("inside"));
        assert_eq!([v, id, role].map(text), ["0.5", "3:7", "robot"]);
        assert_eq!(layout.number(&envelope, "header.role"), Some(2));
        assert_eq!(
            id.repeatable(&value),
            &[7, 0, 0, 0, 0],
            "whichever start it was"
        );
        let published = leaf("header.stamps.published_ns").expect("a stamp");
        assert_eq!(published.repeatable(&[1; 8]), b"");
    }

    #[test]
    fn a_message_is_cut_where_its_items_begin() {
        let layout = Layout::of("it", &metadata(PlanPath::ROW.number)).expect("a layout");
        let (envelope, item) = (layout.envelope_bytes, layout.item_bytes);
        let message = vec![0; envelope + 2 * item];
        assert!(
            layout
                .parts(&message)
                .is_some_and(|(_, items)| items.len() == 2 * item)
        );
        assert_eq!(layout.parts(&message[1..]), None, "half an item");
        assert_eq!(layout.parts(&message[..envelope - 1]), None, "too short");
    }

    #[test]
    fn what_cannot_be_is_an_error_that_names_the_channel() {
        let good = metadata(RobotOdometry::ROW.number);
        let with = |key: &str, text: &str| {
            let mut metadata = good.clone();
            metadata.insert(key.to_owned(), text.to_owned());
            Layout::of("x", &metadata)
                .map(|_| ())
                .map_err(|error| error.to_string())
        };
        let wrong = |what| Err(format!("channel x: its metadata has no usable `{what}`"));
        assert_eq!(
            with("envelope_bytes", "99999999999"),
            wrong("envelope_bytes")
        );
        assert_eq!(with("item_bytes", "x"), wrong("item_bytes"));
        for layout in [
            "",
            "{",
            r#"{"envelope":"u7"}"#,
            r#"{"envelope":{"of":"u64","len":18446744073709551615}}"#,
            r#"{"envelope":{"of":{"of":"u8","len":9999999},"len":9999999}}"#,
            r#"{"envelope":{"of":{"bytes":0,"fields":[]},"len":18446744073709551615}}"#,
            r#"{"envelope":{"of":"u8","len":65537}}"#,
            r#"{"envelope":{"bytes":8,"fields":[{"name":"a","offset":0,"type":{"of":"u64","len":90}}]}}"#,
            r#"{"envelope":{"bytes":8,"fields":[{"name":"a","offset":9999,"type":"u64"}]}}"#,
        ] {
            assert_eq!(with("layout", layout), wrong("layout"), "{layout}");
        }
    }

    proptest! {
        #[test]
        fn no_description_makes_it_panic(at in 0_usize..9_000, byte: u8, cut in 0_usize..9_000) {
            let mut metadata = metadata(PlanPath::ROW.number);
            let mut layout = metadata["layout"].clone().into_bytes();
            let n = layout.len();
            layout[at % n] = byte;
            layout.truncate(if cut < n { n } else { cut % n });
            metadata.insert("layout".to_owned(), String::from_utf8_lossy(&layout).into_owned());
            if let Ok(layout) = Layout::of("x", &metadata) {
                let message = vec![byte; layout.envelope_bytes + layout.item_bytes];
                let (envelope, item) = layout.parts(&message).expect("whole");
                for (leaves, part) in [(&layout.envelope, envelope), (&layout.item, item)] {
                    for leaf in leaves {
                        let _ = leaf.text(leaf.of(part).expect("inside"));
                    }
                }
            }
        }
    }
}
