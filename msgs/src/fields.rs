//! What a message consists of: name, place, unit and meaning of every field, from its declaration.
//!
//! The declaration is the `message!` block alone. The first words in square brackets of a field's
//! description are its unit in SI notation such as `m/s`, or what kind of number it is: [`ID`],
//! [`TEXT`], `count`, `number`, `tick`, `flag` or `bits`. A code names its enum instead.

/// Kind of a field that holds an identity (see [`crate::header::Id`]).
pub const ID: &str = "id";

/// Kind of an array of bytes that holds text, padded with 0.
pub const TEXT: &str = "text";

/// Kinds that are no units of measure.
pub const KINDS: [&str; 7] = [ID, TEXT, "count", "number", "tick", "flag", "bits"];

/// A plain number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "named like the types of Rust")]
pub enum Number {
    U8,
    U16,
    U32,
    U64,
    I16,
    I32,
    I64,
    F32,
    F64,
}

/// What lies in the bytes of a type.
#[derive(Debug)]
pub enum Shape {
    /// One number.
    Number(Number),
    /// Equal elements, one behind the other.
    Array {
        /// One of them.
        of: &'static Shape,
        /// How many.
        len: usize,
    },
    /// The fields of a message.
    Message {
        /// Explicit, versioned name of the type.
        name: &'static str,
        /// Its description.
        doc: &'static str,
        /// Its fields in order.
        fields: &'static [Field],
        /// Its size. [bytes]
        bytes: usize,
        /// Its schema hash.
        schema: u64,
    },
}

/// One field of a message.
#[derive(Debug)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// Its description, as it is declared.
    pub doc: &'static str,
    /// Where it begins. [bytes]
    pub offset: usize,
    /// What it is.
    pub shape: &'static Shape,
}

impl Shape {
    /// Size. [bytes]
    #[must_use]
    pub const fn bytes(&self) -> usize {
        match self {
            Self::Number(number) => number.bytes(),
            Self::Array { of, len } => of.bytes() * *len,
            Self::Message { bytes, .. } => *bytes,
        }
    }

    /// Unit of the numbers in the slice behind a message of this type, as its description says.
    #[must_use]
    pub fn item_unit(&self) -> Option<&'static str> {
        match self {
            Self::Message { doc, .. } => unit_in(doc),
            _ => None,
        }
    }
}

impl Number {
    /// Size. [bytes]
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// The shape of one.
    #[must_use]
    pub const fn shape(self) -> &'static Shape {
        match self {
            Self::U8 => &Shape::Number(Self::U8),
            Self::U16 => &Shape::Number(Self::U16),
            Self::U32 => &Shape::Number(Self::U32),
            Self::U64 => &Shape::Number(Self::U64),
            Self::I16 => &Shape::Number(Self::I16),
            Self::I32 => &Shape::Number(Self::I32),
            Self::I64 => &Shape::Number(Self::I64),
            Self::F32 => &Shape::Number(Self::F32),
            Self::F64 => &Shape::Number(Self::F64),
        }
    }
}

impl Field {
    /// Its unit or kind; of an array either one for all elements or one for each kind of element,
    /// as in `m, m, rad`.
    #[must_use]
    pub fn unit(&self) -> Option<&'static str> {
        unit_in(self.doc)
    }

    /// Name of the enum whose code it holds.
    #[must_use]
    pub fn code(&self) -> Option<&'static str> {
        let (_, after) = self.doc.split_once("Code of ")?;
        let (_, after) = after.split_once("[`")?;
        Some(after.split_once("`]")?.0)
    }

    /// True when it holds nothing yet.
    #[must_use]
    pub fn is_spare(&self) -> bool {
        self.doc.trim_start().starts_with("Written as 0")
    }
}

/// The first words of a description in square brackets that are no link.
fn unit_in(doc: &'static str) -> Option<&'static str> {
    let mut rest = doc;
    loop {
        let (_, after) = rest.split_once('[')?;
        let (inside, behind) = after.split_once(']')?;
        if !inside.starts_with('`') {
            return Some(inside);
        }
        rest = behind;
    }
}
