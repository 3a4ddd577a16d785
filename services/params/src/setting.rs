//! The types that a parameter can have.

use crate::value::{Choice, Type, Value};
use std::path::PathBuf;
use zeronav_casts::Cast;

/// A type that a parameter can have. [`crate::choices!`] implements it for enums.
pub trait Setting {
    /// What its bounds are written as.
    type Bound;
    /// Type.
    const TYPE: Type;

    /// A bound as a number.
    fn bound(bound: Self::Bound) -> f64;
    /// The value.
    fn value(&self) -> Value;
    /// The allowed values of a string; empty when any may be.
    #[must_use]
    fn choices() -> Vec<Choice> {
        Vec::new()
    }
}

impl Setting for f64 {
    type Bound = Self;
    const TYPE: Type = Type::Number;

    fn bound(bound: Self) -> f64 {
        bound
    }

    fn value(&self) -> Value {
        Value::Number(*self)
    }
}

macro_rules! integers {
    ($($type:ty),*) => {$(
        impl Setting for $type {
            type Bound = Self;
            const TYPE: Type = Type::Integer;

            fn bound(bound: Self) -> f64 {
                bound.to_f64()
            }

            fn value(&self) -> Value {
                Value::Integer(i64::try_from(*self).unwrap_or(i64::MAX))
            }
        }
    )*};
}

integers!(i16, i32, u32, u64, usize);

impl Setting for bool {
    type Bound = core::convert::Infallible;
    const TYPE: Type = Type::Boolean;

    fn bound(bound: Self::Bound) -> f64 {
        match bound {}
    }

    fn value(&self) -> Value {
        Value::Boolean(*self)
    }
}

impl Setting for String {
    type Bound = core::convert::Infallible;
    const TYPE: Type = Type::String;

    fn bound(bound: Self::Bound) -> f64 {
        match bound {}
    }

    fn value(&self) -> Value {
        Value::String(self.clone())
    }
}

impl Setting for PathBuf {
    type Bound = core::convert::Infallible;
    const TYPE: Type = Type::String;

    fn bound(bound: Self::Bound) -> f64 {
        match bound {}
    }

    fn value(&self) -> Value {
        Value::String(self.display().to_string())
    }
}

impl<T: Setting> Setting for Option<T> {
    type Bound = T::Bound;
    const TYPE: Type = T::TYPE;

    fn bound(bound: Self::Bound) -> f64 {
        T::bound(bound)
    }

    fn value(&self) -> Value {
        self.as_ref().map_or(Value::Unset, Setting::value)
    }

    fn choices() -> Vec<Choice> {
        T::choices()
    }
}

impl<T: Setting> Setting for Vec<T> {
    type Bound = T::Bound;
    const TYPE: Type = Type::Array;

    fn bound(bound: Self::Bound) -> f64 {
        T::bound(bound)
    }

    fn value(&self) -> Value {
        Value::Array(self.iter().map(Setting::value).collect())
    }
}

impl<T: Setting, const N: usize> Setting for [T; N] {
    type Bound = T::Bound;
    const TYPE: Type = Type::Array;

    fn bound(bound: Self::Bound) -> f64 {
        T::bound(bound)
    }

    fn value(&self) -> Value {
        Value::Array(self.iter().map(Setting::value).collect())
    }
}
