//! Topics of a user's own: `user/NAME`, made by whoever opens one first, for messages that no seat of the
//! stack writes or reads.
//!
//! A message is the common header and bytes. What the bytes mean is said by a [`Form`], a short text that
//! every reader and writer of the topic declares; it is part of the schema hash, so that a reader with
//! another form is rejected when it opens the topic. A form such as `distance_m: f64, bearing_rad: f64`
//! names little-endian numbers without padding, one record after the other; any other text is a name
//! for bytes that its programs agree on.

use crate::fields::{Field, Number, Shape};
use crate::header::Header;
use crate::message;
use crate::message::{FNV_OFFSET, Refusal, Wire, ZeroCopySend, fnv1a};
use crate::role::Role;
use crate::row::{Discipline, TopicRow};
use crate::topics::{Envelope, Topic, USER_PREFIX, topic_schema};
use std::sync::{Mutex, PoisonError};

/// Longest name behind the prefix. [bytes]
pub const USER_NAME_BYTES_MAX: usize = 40;

/// Longest form. [bytes]
pub const FORM_BYTES_MAX: usize = 200;

/// Most bytes of a message behind its header.
pub const USER_BYTES_MAX: usize = 65_536;

/// Messages that the middleware keeps for a reader of such a topic.
pub const USER_BUFFER: usize = UserTopic::ROW.buffer();

/// Messages that a reader may hold at a time.
pub const USER_BORROWED: usize = UserTopic::ROW.borrowed();

/// Messages for which a writer holds memory.
pub const USER_POOL: usize = UserTopic::ROW.pool();

/// Event id of topics that ring nobody.
const RINGS_NOBODY: usize = crate::row::EVENT_MAX;

message! {
    /// Fixed fields of a message on a user's own topic; the slice holds its bytes.
    pub struct UserMessage = "zeronav.UserMessage.v1" {
        /// [number] FNV-1a of the text of the form.
        pub form: u64,
    }
}

message! {
    /// Header and fixed fields of a message on a user's own topic.
    pub struct UserEnvelope = "zeronav.user.v1" {
        /// The header.
        pub header: Header,
        /// The fixed fields.
        pub meta: UserMessage,
    }
}

impl Envelope for UserEnvelope {
    type Meta = UserMessage;

    fn new(header: Header, meta: UserMessage) -> Self {
        Self { header, meta }
    }

    fn header(&self) -> &Header {
        &self.header
    }

    fn meta(&self) -> &UserMessage {
        &self.meta
    }
}

/// Any topic of a user's own; the row of one of them is made by [`row`].
#[derive(Debug)]
pub enum UserTopic {}

impl Topic for UserTopic {
    type Envelope = UserEnvelope;
    type Meta = UserMessage;
    type Item = u8;
    const ROW: &'static TopicRow = &of(USER_PREFIX, 0);

    fn check(_: &UserMessage, _: &[u8]) -> Result<(), Refusal> {
        Ok(())
    }
}

/// Why a name or a form cannot be.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum UserError {
    /// The name.
    #[error(
        "user topic `{0}`: a name is a letter a to z and up to {rest} more of a to z, 0 to 9 and _",
        rest = USER_NAME_BYTES_MAX - 1
    )]
    Name(String),
    /// The form.
    #[error(
        "form {0:?}: 1 to {FORM_BYTES_MAX} printable ASCII characters that begin and end with no space, \
         such as `distance_m: f64`"
    )]
    Form(String),
}

/// What the bytes of a user's own topic mean.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Form(String);

impl Form {
    /// The form that this text declares.
    ///
    /// # Errors
    /// [`UserError::Form`] for a text that is empty, too long, or not of printable ASCII characters.
    pub fn new(text: &str) -> Result<Self, UserError> {
        let printable = text.bytes().all(|byte| (b' '..=b'~').contains(&byte));
        if text.is_empty() || text.len() > FORM_BYTES_MAX || !printable || text.trim() != text {
            return Err(UserError::Form(text.to_owned()));
        }
        Ok(Self(text.to_owned()))
    }

    /// The text.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0
    }

    /// FNV-1a of the text.
    #[must_use]
    pub const fn hash(&self) -> u64 {
        fnv1a(FNV_OFFSET, self.0.as_bytes())
    }

    /// Name and type of the numbers of a record in their order; `None` for a form that names none.
    #[must_use]
    pub fn numbers(&self) -> Option<Vec<(&str, Number)>> {
        let field = |part| {
            let (name, kind): (&str, &str) = str::split_once(part, ':')?;
            let (name, kind) = (name.trim(), kind.trim());
            let (_, number) = NUMBERS.iter().find(|(known, _)| *known == kind)?;
            is_word(name).then_some((name, *number))
        };
        self.0.split(',').map(field).collect()
    }

    /// What one item of the slice is: a record of the numbers of the form, or a byte. The description is
    /// kept for the life of the process.
    #[must_use]
    pub fn shape(&self) -> &'static Shape {
        let Some(numbers) = self.numbers() else {
            return u8::SHAPE;
        };
        let mut bytes = 0;
        let field = |(name, number): (&str, Number)| {
            let offset = bytes;
            bytes += number.bytes();
            Field {
                name: kept(name),
                doc: "",
                offset,
                shape: number.shape(),
            }
        };
        let fields: Vec<Field> = numbers.into_iter().map(field).collect();
        Box::leak(Box::new(Shape::Message {
            name: kept(&self.0),
            doc: "",
            fields: fields.leak(),
            bytes,
            schema: self.hash(),
        }))
    }
}

/// The types of the numbers of a form.
const NUMBERS: [(&str, Number); 9] = [
    ("u8", Number::U8),
    ("u16", Number::U16),
    ("u32", Number::U32),
    ("u64", Number::U64),
    ("i16", Number::I16),
    ("i32", Number::I32),
    ("i64", Number::I64),
    ("f32", Number::F32),
    ("f64", Number::F64),
];

/// Rows that were made, each once: topics are opened again and again.
static ROWS: Mutex<Vec<&'static TopicRow>> = Mutex::new(Vec::new());

/// The row of the topic `name` (without the prefix) whose bytes have this form. It is kept for the life of
/// the process.
///
/// # Errors
/// [`UserError::Name`].
pub fn row(name: &str, form: &Form) -> Result<&'static TopicRow, UserError> {
    let name = full_name(name)?;
    let schema = schema(&name, form);
    let mut rows = ROWS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(row) = rows
        .iter()
        .find(|row| row.name == name && row.schema == schema)
    {
        return Ok(row);
    }
    let row: &'static TopicRow = Box::leak(Box::new(of(kept(&name), schema)));
    rows.push(row);
    Ok(row)
}

/// The whole name of the topic `name`.
///
/// # Errors
/// [`UserError::Name`].
pub fn full_name(name: &str) -> Result<String, UserError> {
    if name.len() > USER_NAME_BYTES_MAX || !is_word(name) {
        return Err(UserError::Name(name.to_owned()));
    }
    Ok(format!("{USER_PREFIX}{name}"))
}

/// What stands behind the prefix of a user's own topic; `None` for another name.
#[must_use]
pub fn name_in(topic: &str) -> Option<&str> {
    let name = topic.strip_prefix(USER_PREFIX)?;
    full_name(name).is_ok().then_some(name)
}

fn schema(name: &str, form: &Form) -> u64 {
    let layout = topic_schema(name, <UserEnvelope as Wire>::SCHEMA, <u8 as Wire>::SCHEMA);
    fnv1a(layout, form.text().as_bytes())
}

const fn of(name: &'static str, schema: u64) -> TopicRow {
    TopicRow {
        number: RINGS_NOBODY,
        name,
        discipline: Discipline::Latest,
        writers: Role::ALL,
        rings: &[],
        rings_in_lockstep: &[],
        len_max: USER_BYTES_MAX,
        envelope_bytes: size_of::<UserEnvelope>(),
        item_bytes: 1,
        schema,
    }
}

fn is_word(text: &str) -> bool {
    text.starts_with(|first: char| first.is_ascii_lowercase())
        && text
            .bytes()
            .all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_')
}

fn kept(text: &str) -> &'static str {
    String::leak(text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn form(text: &str) -> Form {
        Form::new(text).expect("a form")
    }

    #[test]
    fn names_are_words_behind_the_prefix() {
        let long = "a".repeat(USER_NAME_BYTES_MAX);
        for good in ["nearest", "a", "a_1", &long] {
            let name = full_name(good).expect("a name");
            assert_eq!(name_in(&name), Some(good));
        }
        let longer = format!("{long}a");
        for bad in ["", "1a", "A", "a/b", "a b", "ä", "_a", &longer] {
            assert!(full_name(bad).is_err(), "{bad:?}");
            assert_eq!(name_in(&format!("{USER_PREFIX}{bad}")), None);
        }
        assert_eq!(name_in("robot/nearest"), None);
    }

    #[test]
    fn a_form_names_numbers_or_bytes() {
        let numbers = form("distance_m: f64,n:u16 , x_m :f32");
        let read = numbers.numbers().expect("numbers");
        let expected = [
            ("distance_m", Number::F64),
            ("n", Number::U16),
            ("x_m", Number::F32),
        ];
        assert_eq!(read, expected);
        assert_eq!(numbers.shape().bytes(), 14);
        for bytes in ["json", "distance_m: f65", "a: u8,", "A: u8", "my::Type v2"] {
            assert_eq!(form(bytes).numbers(), None, "{bytes}");
            assert_eq!(form(bytes).shape().bytes(), 1);
        }
        let long = "x".repeat(FORM_BYTES_MAX + 1);
        for bad in ["", " a", "a ", "a\n", "ä", &long] {
            assert!(Form::new(bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn another_form_or_name_is_another_schema() {
        let of = |name, text| row(name, &form(text)).expect("a row");
        let one = of("nearest", "distance_m: f64");
        assert!(core::ptr::eq(one, of("nearest", "distance_m: f64")));
        assert_ne!(one.schema, of("nearest", "distance_m: f32").schema);
        assert_ne!(one.schema, of("farthest", "distance_m: f64").schema);
        // A reader in another language has the same.
        assert_eq!(one.schema, 0x096a_19e2_c7b9_1c46);
    }
}
