//! Reading on after a wrong value, so that one reading finds all of them: what cannot be read is taken
//! out, or replaced by what can, and the rest is read again.

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use zeronav_shell::nearest::nearest;
use zeronav_shell::places::Places;

/// Most errors that are looked for.
const ERRORS_MAX: usize = 64;

/// What could be read of a table, and the errors of the deserialiser on the way.
pub(super) struct Reading<T> {
    /// The value, if everything that it needs could be read.
    pub(super) value: Option<T>,
    /// What is wrong, in the order in which it was found.
    pub(super) errors: Vec<toml::de::Error>,
    /// The values that were taken out or replaced: what is said of them says nothing of the file.
    pub(super) doubtful: Vec<String>,
}

/// Reads all that can be read of `table`, whose values have these `places`.
pub(super) fn read<T: DeserializeOwned>(
    mut table: DeTable<'_>,
    places: &Places,
    own: usize,
) -> Reading<T> {
    let mut reading = Reading {
        value: None,
        errors: Vec::new(),
        doubtful: Vec::new(),
    };
    // Every round takes out or replaces a value; a wrong file ends it in any case.
    for _ in 0..4 * ERRORS_MAX {
        let root = Spanned::new(own..own, table.clone());
        let error = match T::deserialize(toml::Deserializer::from(root)) {
            Ok(value) => {
                reading.value = Some(value);
                return reading;
            }
            Err(error) => error,
        };
        let span = error.span().unwrap_or(own..own);
        let (field, _) = places.at_span(&span, "");
        let message = error.message().to_owned();
        if !follows(&message, &field, &reading.doubtful) {
            reading.errors.push(error);
        }
        if reading.errors.len() >= ERRORS_MAX || !mend(&mut table, &field, &message) {
            return reading;
        }
        reading.doubtful.push(field);
    }
    reading
}

/// True when the value that is missing at `table` was taken out before, or is what a misspelt one
/// was meant to be.
fn follows(message: &str, table: &str, doubtful: &[String]) -> bool {
    let Some(missing) = message.strip_prefix("missing field `") else {
        return false;
    };
    let missing = missing.trim_end_matches('`');
    doubtful.iter().any(|path| {
        let (parent, name) = path.rsplit_once('.').unwrap_or(("", path));
        parent == table && nearest(name, [missing]).is_some()
    })
}

/// Makes a value that is read differently of the one at `path`; false when there is none.
fn mend(table: &mut DeTable<'_>, path: &str, message: &str) -> bool {
    // Lists keep their order, so that the places of their entries stay: they are taken out as a whole.
    let path = match path.strip_suffix(']') {
        Some(list) if !is_value_at_fault(message) => {
            list.rsplit_once('[').map_or("", |(list, _)| list)
        }
        _ => path,
    };
    if path.is_empty() {
        return false;
    }
    if let Some(value) = value_at(table, path).filter(|_| is_value_at_fault(message)) {
        return replace(value, message);
    }
    let (parent, name) = path.rsplit_once('.').unwrap_or(("", path));
    let Some(parent) = table_at(table, parent) else {
        return false;
    };
    let Some(index) = parent.keys().position(|key| key.get_ref() == name) else {
        return false;
    };
    let key = parent.keys().nth(index).cloned();
    key.is_some_and(|key| parent.remove(&key).is_some())
}

/// True for a word or a list in whose place another one can be read.
fn is_value_at_fault(message: &str) -> bool {
    substitute(message).is_some()
}

fn replace(value: &mut Spanned<DeValue<'_>>, message: &str) -> bool {
    let Some(other) = substitute(message) else {
        return false;
    };
    let span = value.span();
    let kept = core::mem::replace(value, Spanned::new(span.clone(), DeValue::Boolean(false)));
    *value = Spanned::new(
        span.clone(),
        match (other, kept.into_inner()) {
            (Substitute::Word(word), _) => DeValue::String(word.into()),
            (Substitute::Length(length), DeValue::Array(list)) => {
                let last = list.iter().next_back().cloned();
                let last = last.unwrap_or_else(|| Spanned::new(span, DeValue::Boolean(false)));
                let mut entries: Vec<_> = list.into_iter().take(length).collect();
                entries.resize(length, last);
                DeValue::Array(entries.into_iter().collect())
            }
            (Substitute::Length(_), other) => other,
        },
    );
    true
}

enum Substitute {
    Word(String),
    Length(usize),
}

/// What the deserialiser would have read in place of a word that it does not know, or of a list of
/// another length.
fn substitute(message: &str) -> Option<Substitute> {
    if let Some((word, expected)) = message
        .strip_prefix("unknown variant `")
        .and_then(|rest| rest.split_once("`, expected "))
    {
        let known = || expected.split('`').skip(1).step_by(2);
        let meant = nearest(word, known()).or_else(|| known().next())?;
        return Some(Substitute::Word(meant.to_owned()));
    }
    let rest = message.strip_prefix("invalid length ")?;
    let length = rest.rsplit_once(' ')?.1.trim().parse().ok()?;
    Some(Substitute::Length(length))
}

fn table_at<'a, 'b>(root: &'a mut DeTable<'b>, path: &str) -> Option<&'a mut DeTable<'b>> {
    if path.is_empty() {
        return Some(root);
    }
    match value_at(root, path)?.get_mut() {
        DeValue::Table(table) => Some(table),
        _ => None,
    }
}

fn value_at<'a, 'b>(root: &'a mut DeTable<'b>, path: &str) -> Option<&'a mut Spanned<DeValue<'b>>> {
    let (first, rest) = path.split_at(path.find(['.', '[']).unwrap_or(path.len()));
    let found = root.iter_mut().find(|(key, _)| key.get_ref() == first);
    let mut value = found?.1;
    let mut rest = rest;
    while !rest.is_empty() {
        if let Some(indexed) = rest.strip_prefix('[') {
            let (index, after) = indexed.split_once(']')?;
            let DeValue::Array(list) = value.get_mut() else {
                return None;
            };
            value = list.iter_mut().nth(index.parse().ok()?)?;
            rest = after;
        } else {
            let DeValue::Table(table) = value.get_mut() else {
                return None;
            };
            return value_at(table, rest.strip_prefix('.')?);
        }
    }
    Some(value)
}
