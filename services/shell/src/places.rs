//! The position of every value of a TOML text, so that an error can name line and field.

use core::ops::Range;
use serde::Serialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Position of a value.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Place {
    path: String,
    key: Range<usize>,
    value: Range<usize>,
}

/// The places of all values of a table. Paths read like `world.shapes[3].size_m`.
#[derive(Debug, Clone, Default)]
pub struct Places(Vec<Place>);

impl Places {
    /// The places of the values of `table`, as its spans say.
    #[must_use]
    pub fn of(table: &DeTable<'_>) -> Self {
        let mut places = Vec::new();
        note_table(table, "", &mut places);
        Self(places)
    }

    /// Where the key of `field` begins, or that of the innermost table that could hold it; `None`
    /// for what belongs to the whole text.
    #[must_use]
    pub fn key_of(&self, field: &str) -> Option<usize> {
        let mut path = field;
        loop {
            if let Some(place) = self.0.iter().find(|place| place.path == path) {
                return Some(place.key.start);
            }
            path = &path[..path.rfind(['.', '['])?];
        }
    }

    /// Where the value of `field` begins, if it is there.
    #[must_use]
    pub fn value_of(&self, field: &str) -> Option<usize> {
        let place = self.0.iter().find(|place| place.path == field)?;
        Some(place.value.start)
    }

    /// The field whose key begins within `range`, the outermost of several.
    #[must_use]
    pub fn field_within(&self, range: &Range<usize>) -> Option<&str> {
        let inside = self
            .0
            .iter()
            .filter(|place| range.contains(&place.key.start));
        inside
            .min_by_key(|place| place.path.len())
            .map(|place| place.path.as_str())
    }

    /// What the message `why` of a deserialiser about `span` is about: field and reason.
    #[must_use]
    pub fn at_span(&self, span: &Range<usize>, why: &str) -> (String, String) {
        let exact = self
            .0
            .iter()
            .find(|place| place.key == *span || place.value == *span);
        let around = || {
            let holds = |range: &Range<usize>| range.start <= span.start && span.end <= range.end;
            self.0
                .iter()
                .filter(|place| holds(&place.value) || holds(&place.key))
                .min_by_key(|place| place.value.len())
        };
        // The span of the whole text is empty.
        let place = exact.or_else(around).filter(|_| !span.is_empty());
        let field = place.map(|place| place.path.clone());
        // A missing field belongs to the table that should hold it.
        let missing = why
            .strip_prefix("missing field `")
            .and_then(|rest| rest.strip_suffix('`'));
        let field = match (field, missing) {
            (Some(table), Some(missing)) => format!("{table}.{missing}"),
            (None, Some(missing)) => missing.to_owned(),
            (Some(field), None) => field,
            (None, None) => String::new(),
        };
        let why = if missing.is_some() {
            "is missing".to_owned()
        } else {
            crate::nearest::hinted(why)
        };
        (field, why)
    }

    /// The first list that is longer than what was `read` from it, and why that is wrong: a
    /// deserialiser takes the first numbers for a pose and forgets the others.
    #[must_use]
    pub fn surplus(&self, read: &impl Serialize) -> Option<(String, String)> {
        let read = toml::Value::try_from(read).ok()?;
        self.0.iter().find_map(|place| {
            let (list, index) = place.path.strip_suffix(']')?.rsplit_once('[')?;
            let index: usize = index.parse().ok()?;
            let kept = value_at(&read, list)?.as_array()?.len();
            let why = || format!("has more than {kept} entries, the others mean nothing");
            (index >= kept).then(|| (list.to_owned(), why()))
        })
    }
}

/// Line of a place in a text, from 1.
#[must_use]
pub fn line_of(text: &str, offset: usize) -> usize {
    let before = text.get(..offset).unwrap_or(text);
    1 + before.matches('\n').count()
}

fn note_table(table: &DeTable<'_>, prefix: &str, places: &mut Vec<Place>) {
    for (key, value) in table {
        let dot = if prefix.is_empty() { "" } else { "." };
        let path = format!("{prefix}{dot}{}", key.get_ref());
        note(value, path, key.span(), places);
    }
}

fn note(value: &Spanned<DeValue<'_>>, path: String, key: Range<usize>, places: &mut Vec<Place>) {
    match value.get_ref() {
        DeValue::Table(table) => note_table(table, &path, places),
        DeValue::Array(array) => {
            for (index, item) in array.iter().enumerate() {
                note(item, format!("{path}[{index}]"), item.span(), places);
            }
        }
        _ => {}
    }
    places.push(Place {
        path,
        key,
        value: value.span(),
    });
}

fn value_at<'a>(root: &'a toml::Value, path: &str) -> Option<&'a toml::Value> {
    let words = path
        .split(['.', '['])
        .map(|word| word.trim_end_matches(']'));
    let mut value = root;
    for word in words {
        value = match value {
            toml::Value::Array(array) => array.get(word.parse::<usize>().ok()?)?,
            toml::Value::Table(table) => table.get(word)?,
            _ => return None,
        };
    }
    Some(value)
}
