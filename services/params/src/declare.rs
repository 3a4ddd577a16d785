//! The macros that declare parameters.

/// Declares a struct of parameters, see the crate's front page.
///
/// A field is one of
///
/// - `name: TYPE = DEFAULT, [MIN, MAX] "UNIT";`, a number; both bounds are allowed values, and the
///   unit may be left out;
/// - `name: TYPE = DEFAULT;`, a truth value, a text or an enum of [`crate::choices!`];
/// - `name: GROUP;`, a group of parameters, which is another such struct.
///
/// `relations |own| { name: CONDITION, "must ..."; }` adds what must hold between parameters of the
/// struct. The crate that uses the macro needs `serde`.
#[macro_export]
macro_rules! parameters {
    (
        $(#[doc = $doc:literal])*
        $(#[derive($($derive:ident),*)])?
        pub struct $struct:ident {
            $(
                $(#[doc = $field_doc:literal])*
                $(#[serde($($serde:tt)*)])?
                $field:ident: $type:ty
                    $(= $default:expr $(, [$min:expr, $max:expr] $($unit:literal)?)?)?;
            )*
        }
        $(relations |$own:ident| {
            $($related:ident: $holds:expr, $rule:literal;)*
        })?
    ) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        $(#[derive($($derive),*)])?
        #[serde(deny_unknown_fields, default)]
        pub struct $struct {
            $(
                $(#[doc = $field_doc])*
                $(
                    #[doc = concat!("\n\nDefault `", stringify!($default), "`")]
                    $(
                        #[doc = concat!(", `", stringify!($min), "` to `", stringify!($max), "`")]
                        $(#[doc = concat!(" [", $unit, "]")])?
                    )?
                    #[doc = "."]
                )?
                $(#[serde($($serde)*)])?
                pub $field: $type,
            )*
        }

        impl Default for $struct {
            fn default() -> Self {
                Self { $($field: $crate::parameters!(@default $($default)?),)* }
            }
        }

        impl $crate::Parameters for $struct {
            fn visit(&self, path: &str, visitor: &mut dyn FnMut($crate::Parameter)) {
                #[allow(unused_mut, reason = "a struct may have no relations")]
                let mut relations: Vec<(&str, $crate::Relation)> = Vec::new();
                $(
                    let $own = self;
                    $(
                        relations.push((
                            stringify!($related),
                            $crate::Relation { rule: $rule.to_owned(), holds: $holds },
                        ));
                        // A relation is one of a parameter.
                        let _ = &self.$related;
                    )*
                )?
                $(
                    $crate::parameters!(@visit
                        (self.$field, stringify!($field), path, visitor, relations, $type)
                        (concat!("" $(, $field_doc)*))
                        $(= $default $(, [$min, $max] $($unit)?)?)?
                    );
                )*
            }
        }
    };

    (@default) => { Default::default() };
    (@default $default:expr) => { $default };

    (@visit ($value:expr, $name:expr, $path:ident, $visitor:ident, $relations:ident, $type:ty)
        ($doc:expr)
    ) => {
        $crate::Parameters::visit(&$value, &$crate::Parameter::path_of($path, $name), $visitor)
    };
    (@visit ($value:expr, $name:expr, $path:ident, $visitor:ident, $relations:ident, $type:ty)
        ($doc:expr) = $default:expr
    ) => {
        $visitor($crate::Parameter::new(&$value, $path, $name, "", None, &$relations, $doc))
    };
    (@visit ($value:expr, $name:expr, $path:ident, $visitor:ident, $relations:ident, $type:ty)
        ($doc:expr) = $default:expr, [$min:expr, $max:expr] $($unit:literal)?
    ) => {
        $visitor($crate::Parameter::new(
            &$value,
            $path,
            $name,
            concat!("" $(, $unit)?),
            Some((
                <$type as $crate::Setting>::bound($min),
                <$type as $crate::Setting>::bound($max),
            )),
            &$relations,
            $doc,
        ))
    };
}

/// Declares an enum whose variants are the allowed values of a string. One variant may be the
/// `#[default]`.
#[macro_export]
macro_rules! choices {
    (
        $(#[doc = $doc:literal])*
        pub enum $enum:ident {
            $(
                $(#[doc = $variant_doc:literal])*
                $(#[default $($default:tt)?])?
                $variant:ident = $key:literal
            ),* $(,)?
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(
            Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize,
        )]
        pub enum $enum {
            $(
                $(#[doc = $variant_doc])*
                #[serde(rename = $key)]
                $variant,
            )*
        }

        $($crate::choices!(@default $enum $variant $(#[default $($default)?])?);)*

        impl $crate::Setting for $enum {
            type Bound = core::convert::Infallible;
            const TYPE: $crate::Type = $crate::Type::String;

            fn bound(bound: Self::Bound) -> f64 {
                match bound {}
            }

            fn value(&self) -> $crate::Value {
                $crate::Value::String(match self { $(Self::$variant => $key,)* }.to_owned())
            }

            fn choices() -> Vec<$crate::Choice> {
                vec![$($crate::Choice {
                    key: $key.to_owned(),
                    description: concat!("" $(, $variant_doc)*).trim().to_owned(),
                },)*]
            }
        }
    };

    (@default $enum:ident $variant:ident) => {};
    (@default $enum:ident $variant:ident #[default]) => {
        impl Default for $enum {
            fn default() -> Self {
                Self::$variant
            }
        }
    };
}
