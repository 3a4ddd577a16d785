//! YAML as a tree that still knows the line of every value.

use core::fmt;
use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde_saphyr::options::NonFiniteFloatPolicy;
use serde_saphyr::{Error, Spanned};
use zeronav_casts::Cast;

/// Most tables and lists inside each other.
const DEPTH_MAX: usize = 32;

/// Most values of a file. Aliases count as often as they are used.
const NODES_MAX: usize = 100_000;

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    /// No value.
    Nothing,
    /// A boolean.
    Switch(bool),
    /// A number, which may be NaN or infinite.
    Number(f64),
    /// A string.
    Text(String),
    /// A sequence.
    List(Vec<Node>),
    /// A mapping, in the order of the file.
    Table(Vec<(String, Node)>),
}

/// A value and where it is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    /// Line, from 1.
    pub(super) line: u64,
    /// What is there.
    pub(super) value: Value,
}

/// Why a text is not YAML that can be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct NotYaml {
    /// Line, from 1, where one is known.
    pub(super) line: Option<u64>,
    /// What is wrong.
    pub(super) why: String,
}

/// The tree of a text.
pub(super) fn read(text: &str) -> Result<Node, NotYaml> {
    let options = serde_saphyr::options! {
        budget: serde_saphyr::budget! {
            max_depth: DEPTH_MAX,
            max_nodes: NODES_MAX,
            max_documents: 1,
        },
        with_snippet: false,
        non_finite_float_policy: NonFiniteFloatPolicy::PassThrough,
    };
    let read = serde_saphyr::from_str_with_options::<Spanned<Value>>(text, options);
    read.map(node).map_err(|error| NotYaml {
        line: error.location().map(|it| it.line()),
        why: words(&error),
    })
}

/// What is wrong, in one line.
fn words(error: &Error) -> String {
    let text = error.to_string();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn node(spanned: Spanned<Value>) -> Node {
    Node {
        line: spanned.referenced.line(),
        value: spanned.value,
    }
}

impl fmt::Display for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => formatter.write_str("nothing"),
            Self::Switch(it) => write!(formatter, "{it}"),
            Self::Number(it) => write!(formatter, "{it}"),
            Self::Text(it) => write!(formatter, "{it:?}"),
            Self::List(items) => {
                let items: Vec<String> = items.iter().map(|it| it.value.to_string()).collect();
                write!(formatter, "[{}]", items.join(", "))
            }
            Self::Table(_) => formatter.write_str("a table"),
        }
    }
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OfAnyType)
    }
}

struct OfAnyType;

impl<'de> Visitor<'de> for OfAnyType {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Nothing)
    }

    fn visit_none<E>(self) -> Result<Value, E> {
        Ok(Value::Nothing)
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        Value::deserialize(deserializer)
    }

    fn visit_bool<E>(self, it: bool) -> Result<Value, E> {
        Ok(Value::Switch(it))
    }

    fn visit_i64<E>(self, it: i64) -> Result<Value, E> {
        Ok(Value::Number(it.to_f64()))
    }

    fn visit_u64<E>(self, it: u64) -> Result<Value, E> {
        Ok(Value::Number(it.to_f64()))
    }

    fn visit_i128<E>(self, it: i128) -> Result<Value, E> {
        Ok(Value::Number(it.to_f64()))
    }

    fn visit_u128<E>(self, it: u128) -> Result<Value, E> {
        Ok(Value::Number(it.to_f64()))
    }

    fn visit_f64<E>(self, it: f64) -> Result<Value, E> {
        Ok(Value::Number(it))
    }

    fn visit_str<E>(self, it: &str) -> Result<Value, E> {
        Ok(Value::Text(it.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut list = Vec::new();
        while let Some(item) = items.next_element::<Spanned<Value>>()? {
            list.push(node(item));
        }
        Ok(Value::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        let mut table = Vec::new();
        while let Some((key, value)) = entries.next_entry::<String, Spanned<Value>>()? {
            table.push((key, node(value)));
        }
        Ok(Value::Table(table))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(root: &Node, key: &str) -> Node {
        let Value::Table(entries) = &root.value else {
            panic!("{root:?} is no table");
        };
        let found = entries.iter().find(|(known, _)| known == key);
        found.expect(key).1.clone()
    }

    #[test]
    fn every_value_has_its_type_and_its_line() {
        let root = read(
            "a: 1\nb:\n  - 2.5\n  - .nan\ny: True\nc: \"0.5\"\nd: word\ne:\nn: -3\n8: eight\n",
        )
        .expect("YAML");
        assert_eq!(entry(&root, "a").value, Value::Number(1.0));
        let Value::List(items) = entry(&root, "b").value else {
            panic!("a list");
        };
        assert_eq!((items[0].line, &items[0].value), (3, &Value::Number(2.5)));
        assert!(matches!(items[1].value, Value::Number(it) if it.is_nan()));
        assert_eq!(
            (entry(&root, "y").line, entry(&root, "y").value),
            (5, Value::Switch(true))
        );
        assert_eq!(entry(&root, "c").value, Value::Text("0.5".to_owned()));
        assert_eq!(entry(&root, "d").value, Value::Text("word".to_owned()));
        assert_eq!(entry(&root, "e").value, Value::Nothing);
        assert_eq!(entry(&root, "n").value, Value::Number(-3.0));
        assert_eq!(entry(&root, "8").value, Value::Text("eight".to_owned()));
    }

    #[test]
    fn what_is_not_yaml_names_its_line_in_one_line() {
        let error = read("a: 1\nb: [1, 2\nc: }\n").expect_err("no YAML");
        assert!(error.line.is_some(), "{error:?}");
        assert!(!error.why.contains('\n'), "{error:?}");
        let twice = read("a: 1\na: 2\n").expect_err("a key twice");
        assert_eq!(twice.line, Some(2), "{twice:?}");
    }

    #[test]
    fn deep_and_many_values_are_rejected() {
        let deep = format!("{}1{}", "[".repeat(100_000), "]".repeat(100_000));
        read(&deep).expect_err("too deep");
        let mut deep = String::new();
        for n in 0..200 {
            deep += &" ".repeat(n);
            deep += "a:\n";
        }
        read(&deep).expect_err("too deep");
        let many = "- 1\n".repeat(NODES_MAX + 1);
        read(&many).expect_err("too many");
        let mut laughs = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n".to_owned();
        for n in 1..9 {
            let one = format!("*a{}", n - 1);
            let line = format!("a{n}: &a{n} [{}]\n", vec![one; 10].join(", "));
            laughs.push_str(&line);
        }
        read(&laughs).expect_err("a billion laughs");
    }
}
