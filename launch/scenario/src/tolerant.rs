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
    let mut is_whole = true;
    // Every round takes out or replaces a value; a wrong file ends it in any case.
    for _ in 0..4 * ERRORS_MAX {
        let root = Spanned::new(own..own, table.clone());
        let error = match T::deserialize(toml::Deserializer::from(root)) {
            Ok(value) => {
                reading.value = is_whole.then_some(value);
                return reading;
            }
            Err(error) => error,
        };
        let span = error.span().unwrap_or(own..own);
        let (field, _) = places.at_span(&span, "");
        let message = error.message().to_owned();
        let follows = follows(&message, &field, &reading.doubtful);
        if !follows {
            reading.errors.push(error);
        }
        if reading.errors.len() >= ERRORS_MAX {
            return reading;
        }
        match mend(&mut table, &field, &message) {
            Some(_) => {
                // Without a value it is another scenario, of which nothing is to be said.
                is_whole &= message.starts_with(UNKNOWN_FIELD) || substitute(&message).is_some();
            }
            None => return reading,
        }
        // Of a renamed value the places do not know the folder that its path counts from.
        reading.doubtful.push(match misspelt(&message) {
            Some((word, meant)) => {
                field.trim_end_matches(&word).to_owned() + &meant.unwrap_or(word)
            }
            None => field,
        });
    }
    reading
}

/// True for what is only said because of a value that was taken out or replaced before.
fn follows(message: &str, field: &str, doubtful: &[String]) -> bool {
    let Some(missing) = message.strip_prefix("missing field `") else {
        return doubtful.iter().any(|path| path == field);
    };
    let missing = missing.trim_end_matches('`');
    doubtful.iter().any(|path| {
        let is_within = field.is_empty() || path.starts_with(&format!("{field}."));
        let mut words = path.split('.').filter_map(|word| word.split('[').next());
        is_within && words.any(|word| word == missing)
    })
}

/// Makes a value that is read differently of the one at `path`: the path of what was changed or
/// taken out, if there is such a value.
fn mend(table: &mut DeTable<'_>, path: &str, message: &str) -> Option<String> {
    if substitute(message).is_some()
        && let Some(value) = value_at(table, path)
    {
        return replace(value, message).then(|| path.to_owned());
    }
    if let Some((word, meant)) = misspelt(message) {
        // Of a table with a kind, the table is named in place of its field.
        let within = path
            .strip_suffix(&word)
            .map_or(path, |parent| parent.trim_end_matches('.'));
        let within = table_at(table, within)?;
        let key = within
            .keys()
            .find(|key| key.get_ref() == word.as_str())
            .cloned()?;
        let value = within.remove(&key)?;
        if let Some(meant) = meant.filter(|meant| !within.contains_key(meant.as_str())) {
            within.insert(Spanned::new(key.span(), meant.into()), value);
        }
        return Some(path.to_owned());
    }
    // Lists keep their order, so that the places of their entries stay: they are taken out as a whole.
    let mut path = path;
    while path.ends_with(']') {
        path = path.rsplit_once('[').map_or("", |(list, _)| list);
    }
    let (parent, name) = path.rsplit_once('.').unwrap_or(("", path));
    let parent = table_at(table, parent)?;
    let key = parent.keys().find(|key| key.get_ref() == name).cloned()?;
    parent.remove(&key).map(|_| path.to_owned())
}

const UNKNOWN_FIELD: &str = "unknown field `";

/// The field that is not known, and the one that it was meant to be.
fn misspelt(message: &str) -> Option<(String, Option<String>)> {
    let rest = message.strip_prefix(UNKNOWN_FIELD)?;
    let (word, expected) = rest.split_once("`, expected ")?;
    let meant = nearest(word, expected.split('`').skip(1).step_by(2));
    Some((word.to_owned(), meant.map(str::to_owned)))
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
    let expected = rest.split_once("expected ")?.1;
    let length = expected.split(' ').find_map(|word| word.parse().ok())?;
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
            value = list.get_mut(index.parse::<usize>().ok()?)?;
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
