//! The fields of a description: each declared once, with its type, default, range and unit.

use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::marker::PhantomData;
use zeronav_params::{Parameter, Setting};

/// A field that must be given and was not, worded as serde does.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("missing field `{0}`")]
pub(crate) struct Missing(pub(crate) &'static str);

/// How a field is declared.
pub(crate) struct Declared<'a> {
    pub(crate) group: &'a str,
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    pub(crate) range: Option<(f64, f64)>,
    pub(crate) doc: &'static str,
}

impl Declared<'_> {
    /// A whole struct.
    pub(crate) const fn group(name: &'static str) -> Self {
        Self {
            group: "",
            name,
            unit: "",
            range: None,
            doc: "",
        }
    }
}

/// A type that a field of a description can have.
pub(crate) trait Field: Clone {
    /// What a file says about it.
    type Words: DeserializeOwned;

    /// The value: the `words`, laid on `base`, which is a preset's value or else the default.
    fn laid(words: Option<Self::Words>, base: Option<Self>) -> Result<Option<Self>, Missing>;

    /// Visits the parameters of the field; `None` describes those of a field without a default.
    fn visit(value: Option<&Self>, declared: &Declared, visitor: &mut dyn FnMut(Parameter));
}

/// Visits a parameter.
pub(crate) fn visit<S: Setting>(
    value: &S,
    declared: &Declared,
    visitor: &mut dyn FnMut(Parameter),
) {
    let Declared {
        group,
        name,
        unit,
        range,
        doc,
    } = *declared;
    visitor(Parameter::new(value, group, name, unit, range, &[], doc));
}

/// Types whose words are their value.
macro_rules! plain {
    ($($type:ty),*) => {$(
        impl $crate::field::Field for $type {
            type Words = Self;

            fn laid(
                words: Option<Self>,
                base: Option<Self>,
            ) -> Result<Option<Self>, $crate::field::Missing> {
                Ok(words.or(base))
            }

            fn visit(
                value: Option<&Self>,
                declared: &$crate::field::Declared,
                visitor: &mut dyn FnMut(zeronav_params::Parameter),
            ) {
                $crate::field::visit(&value.cloned(), declared, visitor);
            }
        }
    )*};
}
pub(crate) use plain;

plain!(f64, u32, bool, [f64; 3]);

/// Types that may be left out.
macro_rules! optional {
    ($($type:ty),*) => {$(
        impl Field for Option<$type> {
            type Words = $type;

            fn laid(words: Option<$type>, base: Option<Self>) -> Result<Option<Self>, Missing> {
                Ok(Some(words.or(base.flatten())))
            }

            fn visit(
                value: Option<&Self>,
                declared: &Declared,
                visitor: &mut dyn FnMut(Parameter),
            ) {
                visit(&value.cloned().flatten(), declared, visitor);
            }
        }
    )*};
}

optional!(f64, Vec<[f64; 2]>);

/// A table, or `false` for none: so a preset's can be switched off.
#[derive(Debug)]
pub(crate) enum Perhaps<T> {
    Flag(bool),
    Table(T),
}

/// By hand: an untagged enum does not say what is wrong with the table.
impl<'de, T: Deserialize<'de>> Deserialize<'de> for Perhaps<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Either<T> {
            type Value = Perhaps<T>;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("true, false or a table")
            }

            fn visit_bool<E>(self, wanted: bool) -> Result<Self::Value, E> {
                Ok(Perhaps::Flag(wanted))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(Perhaps::Table)
            }
        }
        deserializer.deserialize_any(Either(PhantomData))
    }
}

/// Declares a struct and how it is written: `name: TYPE = DEFAULT, [MIN, MAX] "UNIT";`, all but the
/// name and the type optional. A field without a default must be given, by the file or by a preset;
/// an `Option` is `None`.
///
/// Makes the struct, a second one for what a file says (all fields optional) and the parameters. By
/// hand remains `Words::on(base)`, which finds the base (a preset) and ends with
/// `Words::over(base)`.
macro_rules! described {
    (
        $(#[doc = $doc:literal])*
        $(#[derive($($derive:ident),*)])?
        pub struct $struct:ident from $words:ident $(with preset $preset:ty)? {
            $(
                $(#[doc = $field_doc:literal])*
                $(#[serde($($serde:tt)*)])?
                $field:ident: $type:ty
                    $(= $default:expr)? $(, [$min:expr, $max:expr] $($unit:literal)?)?;
            )*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize)]
        $(#[derive($($derive),*)])?
        pub struct $struct {
            $(
                $(#[doc = $field_doc])*
                $(
                    #[doc = concat!("\n\n`", stringify!($min), "` to `", stringify!($max), "`")]
                    $(#[doc = concat!(" [", $unit, "]")])?
                    #[doc = "."]
                )?
                $(#[serde($($serde)*)])?
                pub $field: $type,
            )*
        }

        /// What a file says.
        #[derive(Debug, Default, serde::Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub(crate) struct $words {
            $(preset: Option<$preset>,)?
            /// Instead of a preset, by code.
            #[serde(skip)]
            start: Option<$struct>,
            $($field: Option<<$type as $crate::field::Field>::Words>,)*
        }

        impl $words {
            /// Each field: as it was written, else as `base` says, else its default.
            fn over(self, base: Option<$struct>) -> Result<$struct, $crate::field::Missing> {
                let base = self.start.or(base);
                Ok($struct {
                    $($field: {
                        let base = base.as_ref().map(|base| base.$field.clone());
                        let base = base.or_else(|| described!(@default $($default)?));
                        $crate::field::Field::laid(self.$field, base)?
                            .ok_or($crate::field::Missing(stringify!($field)))?
                    },)*
                })
            }
        }

        impl<'de> serde::Deserialize<'de> for $struct {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let words = $words::deserialize(deserializer)?;
                words.on(None).map_err(serde::de::Error::custom)
            }
        }

        impl $crate::field::Field for $struct {
            type Words = $words;

            fn laid(
                words: Option<$words>,
                base: Option<Self>,
            ) -> Result<Option<Self>, $crate::field::Missing> {
                match words {
                    Some(words) => words.on(base).map(Some),
                    None => Ok(base),
                }
            }

            fn visit(
                value: Option<&Self>,
                declared: &$crate::field::Declared,
                visitor: &mut dyn FnMut(zeronav_params::Parameter),
            ) {
                let group = zeronav_params::Parameter::path_of(declared.group, declared.name);
                $(if value.is_none() {
                    let doc = "Starting point; every other field that is given replaces its value.";
                    let preset = $crate::field::Declared {
                        group: &group, name: "preset", unit: "", range: None, doc,
                    };
                    $crate::field::visit(&None::<$preset>, &preset, visitor);
                })?
                $({
                    let declared = $crate::field::Declared {
                        group: &group,
                        name: stringify!($field),
                        unit: concat!("" $($(, $unit)?)?),
                        range: None::<(f64, f64)>$(.or(Some((f64::from($min), f64::from($max)))))?,
                        doc: concat!("" $(, $field_doc)*),
                    };
                    let default = described!(@default $($default)?);
                    let value = value.map(|value| &value.$field).or(default.as_ref());
                    <$type as $crate::field::Field>::visit(value, &declared, visitor);
                })*
            }
        }

        impl $struct {
            /// Its parameters, with defaults where there are any.
            #[must_use]
            pub fn parameters(group: &'static str) -> Vec<zeronav_params::Parameter> {
                let mut parameters = Vec::new();
                let declared = $crate::field::Declared::group(group);
                let visitor = &mut |parameter| parameters.push(parameter);
                <Self as $crate::field::Field>::visit(None, &declared, visitor);
                parameters
            }
        }

        impl zeronav_params::Parameters for $struct {
            fn visit(&self, _: &str, visitor: &mut dyn FnMut(zeronav_params::Parameter)) {
                let declared = $crate::field::Declared::group("");
                $crate::field::Field::visit(Some(self), &declared, visitor);
            }
        }
    };

    (@default) => { None };
    (@default $default:expr) => { Some($default) };
}
pub(crate) use described;

/// Structs that may be left out, or switched off with `false`.
macro_rules! switched {
    ($($type:ty),*) => {$(
        impl $crate::field::Field for Option<$type> {
            type Words = $crate::field::Perhaps<<$type as $crate::field::Field>::Words>;

            fn laid(
                words: Option<Self::Words>,
                base: Option<Self>,
            ) -> Result<Option<Self>, $crate::field::Missing> {
                let base = base.flatten();
                Ok(Some(match words {
                    None => base,
                    Some($crate::field::Perhaps::Flag(wanted)) => {
                        wanted.then(|| base.unwrap_or_default())
                    }
                    Some($crate::field::Perhaps::Table(words)) => Some(words.on(base)?),
                }))
            }

            fn visit(
                value: Option<&Self>,
                declared: &$crate::field::Declared,
                visitor: &mut dyn FnMut(zeronav_params::Parameter),
            ) {
                let value = match value {
                    None => Some(&<$type>::default()),
                    Some(value) => value.as_ref(),
                };
                if let Some(value) = value {
                    $crate::field::Field::visit(Some(value), declared, visitor);
                }
            }
        }
    )*};
}
pub(crate) use switched;
