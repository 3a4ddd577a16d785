//! Types and values of parameters.

use core::fmt;
use serde::{Deserialize, Serialize};
use zeronav_casts::Cast;

/// Type of a parameter, by the names of JSON schema.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Type {
    /// A floating-point number.
    Number,
    /// A whole number.
    Integer,
    /// True or false.
    Boolean,
    /// A text, see [`crate::Parameter::choices`].
    String,
    /// A list, or lists in a list.
    Array,
}

impl fmt::Display for Type {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Number => "number",
            Self::Integer => "integer",
            Self::Boolean => "boolean",
            Self::String => "string",
            Self::Array => "array",
        })
    }
}

/// Value of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// Of [`Type::Boolean`].
    Boolean(bool),
    /// Of [`Type::Integer`], saturated.
    Integer(i64),
    /// Of [`Type::Number`].
    Number(f64),
    /// Of [`Type::String`].
    String(String),
    /// Of [`Type::Array`].
    Array(Vec<Value>),
    /// An optional parameter that is not set.
    Unset,
}

impl Value {
    /// The first number of the value for which `wrong` holds.
    pub(crate) fn find(&self, wrong: &impl Fn(f64) -> bool) -> Option<&Self> {
        match self {
            Self::Integer(value) => wrong((*value).to_f64()).then_some(self),
            Self::Number(value) => wrong(*value).then_some(self),
            Self::Array(items) => items.iter().find_map(|item| item.find(wrong)),
            Self::Boolean(_) | Self::String(_) | Self::Unset => None,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Boolean(value) => write!(formatter, "{value}"),
            Self::Integer(value) => write!(formatter, "{value}"),
            Self::Number(value) => write!(formatter, "{value:?}"),
            Self::String(value) => write!(formatter, "{value}"),
            Self::Array(items) => {
                let items: Vec<String> = items.iter().map(ToString::to_string).collect();
                write!(formatter, "[{}]", items.join(", "))
            }
            Self::Unset => Ok(()),
        }
    }
}

/// An allowed value of a string.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Choice {
    /// The value.
    pub key: String,
    /// What it means.
    pub description: String,
}
