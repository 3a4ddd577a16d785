//! The layer for replay: the channels on which every message of the contract lies byte for byte.

use serde_json::{Value, json};
use std::collections::BTreeMap;
use zeronav_msgs::fields::{Number, Shape};
use zeronav_msgs::message::Wire;
use zeronav_msgs::span::Span;
use zeronav_msgs::topics::{Topic, TopicRow, TopicVisitor, visit_topics};
use zeronav_msgs::user::{Form, UserEnvelope};

/// What stands before the name of a topic in the name of its channel.
pub const PREFIX: &str = "zeronav/";

/// Encoding of the messages: header with fixed fields, then items, as they lie in shared memory.
pub const ENCODING: &str = "zeronav";

/// A topic of the contract and what its channel says of it.
#[derive(Debug, Clone)]
pub struct NativeTopic {
    /// Its row.
    pub row: &'static TopicRow,
    /// Versioned name of the type of header and fixed fields, of a record for `run/spans`: the name
    /// of the channel's schema.
    pub type_name: &'static str,
    header_and_fields: Option<&'static Shape>,
    item: &'static Shape,
    /// What the bytes of a user's own topic mean.
    form: Option<Form>,
}

impl NativeTopic {
    /// The topic of a user with this row and form.
    #[must_use]
    pub fn of_user(row: &'static TopicRow, form: &Form) -> Self {
        Self {
            row,
            type_name: UserEnvelope::NAME,
            header_and_fields: Some(UserEnvelope::SHAPE),
            item: form.shape(),
            form: Some(form.clone()),
        }
    }

    /// Name of the channel.
    #[must_use]
    pub fn channel(&self) -> String {
        format!("{PREFIX}{}", self.row.name)
    }

    /// Everything that a reader needs to understand the bytes, whatever version it was built from:
    /// `schema_hash`, `envelope_bytes` and `item_bytes`, and `layout`, a JSON description of both parts
    /// with offset, type, unit and kind of every field. `form` of a user's own topic, whose items are its records.
    #[must_use]
    pub fn metadata(&self) -> BTreeMap<String, String> {
        let row = self.row;
        let layout = json!({
            "envelope": self.header_and_fields.map(shape),
            "item": shape(self.item),
        });
        let form = self.form.as_ref();
        let form = form.map(|form| ("form", form.text().to_owned()));
        [
            ("schema_hash", format!("{:016x}", row.schema)),
            ("envelope_bytes", row.envelope_bytes.to_string()),
            ("item_bytes", self.item.bytes().to_string()),
            ("topic_number", row.number.to_string()),
            ("layout", layout.to_string()),
        ]
        .into_iter()
        .chain(form)
        .map(|(key, value)| (key.to_owned(), value))
        .collect()
    }
}

/// Every topic of the contract, in the order of its table.
#[must_use]
pub fn topics() -> Vec<NativeTopic> {
    struct Collector(Vec<NativeTopic>);
    impl TopicVisitor for Collector {
        type Error = core::convert::Infallible;

        fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), Self::Error> {
            self.0.push(NativeTopic {
                row,
                type_name: T::Envelope::NAME,
                header_and_fields: Some(T::Envelope::SHAPE),
                item: T::Item::SHAPE,
                form: None,
            });
            Ok(())
        }

        fn records(&mut self, row: &'static TopicRow) -> Result<(), Self::Error> {
            self.0.push(NativeTopic {
                row,
                type_name: Span::NAME,
                header_and_fields: None,
                item: Span::SHAPE,
                form: None,
            });
            Ok(())
        }
    }
    let mut collector = Collector(Vec::new());
    match visit_topics(&mut collector) {
        Ok(()) => collector.0,
    }
}

/// A type as JSON: a word for a number, `{"of", "len"}` for an array, otherwise name and fields.
fn shape(shape: &Shape) -> Value {
    match shape {
        Shape::Number(number) => Value::from(word(*number)),
        Shape::Array { of, len } => json!({ "of": self::shape(of), "len": len }),
        Shape::Message {
            name,
            fields,
            bytes,
            ..
        } => {
            let fields: Vec<Value> = fields
                .iter()
                .map(|field| {
                    json!({
                        "name": field.name,
                        "offset": field.offset,
                        "unit": field.unit(),
                        "code": field.code(),
                        "type": self::shape(field.shape),
                    })
                })
                .collect();
            json!({ "name": name, "bytes": bytes, "fields": fields })
        }
    }
}

fn word(number: Number) -> &'static str {
    match number {
        Number::U8 => "u8",
        Number::U16 => "u16",
        Number::U32 => "u32",
        Number::U64 => "u64",
        Number::I16 => "i16",
        Number::I32 => "i32",
        Number::I64 => "i64",
        Number::F32 => "f32",
        Number::F64 => "f64",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::topics::{RobotOdometry, topics as rows};

    #[test]
    fn every_topic_has_a_channel_that_describes_its_bytes() {
        let topics = topics();
        assert_eq!(topics.len(), rows().len());
        for topic in &topics {
            let metadata = topic.metadata();
            let layout: Value = serde_json::from_str(&metadata["layout"]).expect("JSON");
            let bytes = |part: &str| layout[part]["bytes"].as_u64();
            let envelope = topic.row.envelope_bytes as u64;
            assert_eq!(
                bytes("envelope").unwrap_or(0),
                envelope,
                "{}",
                topic.row.name
            );
            assert_eq!(metadata["item_bytes"], topic.row.item_bytes.to_string());
        }
        let odometry = topics
            .iter()
            .find(|topic| topic.row.number == RobotOdometry::ROW.number)
            .expect("a channel");
        assert_eq!(
            odometry.channel(),
            format!("zeronav/{}", RobotOdometry::ROW.name)
        );
        let layout = &odometry.metadata()["layout"];
        assert!(
            layout.contains(r#""name":"v_mps","offset":24,"type":"f64","unit":"m/s""#),
            "{layout}"
        );
    }

    #[test]
    fn a_topic_of_a_user_says_what_its_records_are() {
        let form = Form::new("distance_m: f64, n: u16").expect("a form");
        let row = zeronav_msgs::user::row("nearest", &form).expect("a row");
        let topic = NativeTopic::of_user(row, &form);
        let metadata = topic.metadata();
        assert_eq!(metadata["form"], form.text());
        assert_eq!(metadata["item_bytes"], "10");
        let layout = crate::layout::Layout::of("it", &metadata).expect("a layout");
        let names: Vec<&str> = layout.item.iter().map(|leaf| &*leaf.path).collect();
        assert_eq!(names, ["distance_m", "n"]);
        let form = Form::new("json").expect("a form");
        let bytes = NativeTopic::of_user(row, &form).metadata();
        assert_eq!((&*bytes["item_bytes"], &*bytes["form"]), ("1", "json"));
    }
}
