//! The text of a scenario and of the files that it builds on, as one table that still knows the
//! file and line of every value.
//!
//! `base = [...]` names files whose values a scenario starts from. Tables are merged key by key,
//! everything else (numbers, texts, lists) is replaced; a later file wins over an earlier one and
//! the scenario over all. `variant = "name"` lays the table `[variants.name]` over that. All texts lie,
//! one after the other, on one number line, so a span of the TOML parser says which file it means.

use super::error::ScenarioError;
use super::library::{Kind, Library, Origin, VARIANTS};
use super::tolerant;
use core::ops::Range;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use zeronav_msgs::message::{FNV_OFFSET, fnv1a};
use zeronav_shell::nearest::{hinted, unknown};
use zeronav_shell::places::{Places, line_of};

/// Most files of one scenario, also when one builds on itself.
const FILES_MAX: usize = 16;

/// The key that names the files to build on.
const BASE: &str = "base";

/// The key that names one of them.
const VARIANT: &str = "variant";

#[derive(Debug, Clone)]
struct Source {
    origin: Origin,
    text: String,
    /// Where it begins on the number line of all texts.
    start: usize,
}

/// Keys that scenarios had once, and what takes their place.
const REPLACED: [(&str, &str); 1] = [(
    "kills",
    "is gone: write [[faults]] with kind = \"kill\", service and begins = { at_s = ... }",
)];

/// The files of a scenario and where every value is in them.
#[derive(Debug, Clone, Default)]
pub(super) struct Document {
    /// In the order in which they are merged; the scenario's own is the last.
    texts: Vec<Source>,
    places: Places,
}

impl Document {
    /// A hash of all texts, in the order in which they are merged.
    pub(super) fn fingerprint(&self) -> u64 {
        let texts = self.texts.iter();
        texts.fold(FNV_OFFSET, |hash, text| {
            fnv1a(fnv1a(hash, text.text.as_bytes()), &[0])
        })
    }
}

/// What could be read of a scenario.
#[derive(Debug)]
pub(super) struct Reading<T> {
    /// The value; `None` when too much of it could not be read.
    pub(super) value: Option<T>,
    pub(super) document: Document,
    /// Everything that is wrong with what was read.
    pub(super) wrong: Vec<ScenarioError>,
    /// Fields whose value is not that of the file, because that cannot be read.
    pub(super) doubtful: Vec<String>,
}

impl<T> Reading<T> {
    /// The value when nothing is wrong with it.
    pub(super) fn faultless(self) -> Result<(T, Document), ScenarioError> {
        match (ScenarioError::of(self.wrong), self.value) {
            (Some(error), _) => Err(error),
            (None, Some(value)) => Ok((value, self.document)),
            (None, None) => Err(self.document.at_field("scenario", "cannot be read")),
        }
    }
}

/// Reads the scenario at `origin` and what it builds on, as its variant of that name if there is
/// one. What is wrong with single values is in the reading.
pub(super) fn read<T: Serialize + DeserializeOwned>(
    library: &Library,
    origin: Origin,
    variant: Option<&str>,
) -> Result<Reading<T>, ScenarioError> {
    let mut texts = Vec::new();
    gather(library, origin, &mut texts)?;
    let mut merged = DeTable::new();
    for text in &texts {
        let table = parse(text)?;
        merge(&mut merged, table);
    }
    merged.remove(BASE);
    let named = merged.remove(VARIANT);
    let variants = merged.remove(VARIANTS);
    let named = named.as_ref().map(|named| (named.span(), named.get_ref()));
    let wanted = variant.or_else(|| named.as_ref().and_then(|(_, named)| named.as_str()));
    let mut variants = match variants.map(Spanned::into_inner) {
        Some(DeValue::Table(variants)) => variants,
        _ => DeTable::new(),
    };
    let changes = wanted.and_then(|wanted| variants.remove(wanted));
    if let Some(DeValue::Table(changes)) = changes.map(Spanned::into_inner) {
        merge(&mut merged, changes);
    } else if let Some((span, wanted)) = named {
        let known: Vec<&str> = variants
            .keys()
            .map(|name| name.get_ref().as_ref())
            .collect();
        let why = match wanted.as_str() {
            Some(wanted) if !known.is_empty() => unknown("variant", wanted, known),
            _ => "must be the name of one of the variants".to_owned(),
        };
        let places = Places::default();
        return Err(Document { texts, places }.error(span.start, VARIANT.to_owned(), &why));
    }
    let places = Places::of(&merged);
    let has = |key: &str| merged.keys().any(|known| known.get_ref() == key);
    if let Some((key, why)) = REPLACED.iter().find(|(key, _)| has(key)) {
        return Err(Document { texts, places }.at_field(key, why));
    }
    let own = texts.last().map_or(0, |text| text.start);
    let read = tolerant::read::<T>(merged, &places, own);
    let document = Document { texts, places };
    let error = |error: &toml::de::Error| {
        let span = error.span().unwrap_or(own..own);
        document.at_span(&span, error.message())
    };
    let mut wrong: Vec<ScenarioError> = read.errors.iter().map(error).collect();
    let mut doubtful = read.doubtful;
    let surplus = read
        .value
        .as_ref()
        .and_then(|value| document.places.surplus(value));
    if let Some((field, why)) = surplus.filter(|(field, _)| !doubtful.contains(field)) {
        wrong.push(document.at_field(&field, &why));
        doubtful.push(field);
    }
    Ok(Reading {
        value: read.value,
        document,
        wrong,
        doubtful,
    })
}

/// Puts the text at `origin` behind the texts that it builds on.
fn gather(library: &Library, origin: Origin, texts: &mut Vec<Source>) -> Result<(), ScenarioError> {
    gather_below(library, origin, texts, &mut 0)
}

fn gather_below(
    library: &Library,
    origin: Origin,
    texts: &mut Vec<Source>,
    n_files: &mut usize,
) -> Result<(), ScenarioError> {
    *n_files += 1;
    let mut own = Source {
        text: origin.text()?,
        origin,
        start: 0,
    };
    let table = parse(&own)?;
    let refused = |at: &Range<usize>, why: String| ScenarioError::Field {
        file: own.origin.to_string(),
        line: line_of(&own.text, at.start),
        field: BASE.to_owned(),
        why,
    };
    let mut bases = Vec::new();
    if let Some(base) = table.get(BASE) {
        let words = match base.get_ref() {
            DeValue::Array(names) => names.iter().collect(),
            _ => vec![base],
        };
        for word in words {
            let span = word.span();
            let Some(name) = word.get_ref().as_str() else {
                let why = "must be a name or a path, or a list of them".to_owned();
                return Err(refused(&span, why));
            };
            if *n_files + bases.len() >= FILES_MAX {
                let why = format!("more than {FILES_MAX} files; does one build on itself?");
                return Err(refused(&span, why));
            }
            let folder = own.origin.folder();
            let found = library.find(Kind::World, name, folder);
            bases.push(found.map_err(|why| refused(&span, why))?);
        }
    }
    for base in bases {
        gather_below(library, base, texts, n_files)?;
    }
    own.start = texts
        .last()
        .map_or(0, |last| last.start + last.text.len() + 1);
    texts.push(own);
    Ok(())
}

/// The table of a text, its spans on the number line of all texts.
fn parse(text: &Source) -> Result<DeTable<'_>, ScenarioError> {
    match DeTable::parse(&text.text) {
        Ok(table) => Ok(shifted_table(table.into_inner(), text.start)),
        Err(error) => Err(ScenarioError::Syntax {
            file: text.origin.to_string(),
            line: line_of(&text.text, error.span().map_or(0, |span| span.start)),
            why: hinted(error.message()),
        }),
    }
}

fn shifted_table(table: DeTable<'_>, by: usize) -> DeTable<'_> {
    table
        .into_iter()
        .map(|(key, value)| {
            let span = key.span();
            let key = Spanned::new(span.start + by..span.end + by, key.into_inner());
            (key, shifted(value, by))
        })
        .collect()
}

fn shifted(value: Spanned<DeValue<'_>>, by: usize) -> Spanned<DeValue<'_>> {
    let span = value.span();
    let inner = match value.into_inner() {
        DeValue::Table(table) => DeValue::Table(shifted_table(table, by)),
        DeValue::Array(array) => {
            DeValue::Array(array.into_iter().map(|item| shifted(item, by)).collect())
        }
        other => other,
    };
    Spanned::new(span.start + by..span.end + by, inner)
}

/// Lays `over` on `under`: tables are merged, everything else is replaced.
fn merge<'a>(under: &mut DeTable<'a>, over: DeTable<'a>) {
    for (key, value) in over {
        let span = value.span();
        let value = match (under.remove(&key), value.into_inner()) {
            (Some(old), DeValue::Table(new)) => match old.into_inner() {
                DeValue::Table(mut both) => {
                    merge(&mut both, new);
                    DeValue::Table(both)
                }
                _ => DeValue::Table(new),
            },
            (_, other) => other,
        };
        under.insert(key, Spanned::new(span, value));
    }
}

impl Document {
    /// The error that the value at `field` is wrong. A value that is in no file (a default) is
    /// reported where the table that could hold it is.
    pub(super) fn at_field(&self, field: &str, why: &str) -> ScenarioError {
        let start = self.places.key_of(field);
        let start = start.unwrap_or_else(|| self.texts.last().map_or(0, |text| text.start));
        self.error(start, field.to_owned(), why)
    }

    /// The folder of the file that holds the value at `field`.
    pub(super) fn folder_of(&self, field: &str) -> Option<&Path> {
        self.text_at(self.places.value_of(field)?)?.origin.folder()
    }

    /// The error at a span of the parser, and the value that it means.
    fn at_span(&self, span: &Range<usize>, why: &str) -> ScenarioError {
        let (field, why) = match self.places.at_span(span, why) {
            (field, why) if field.is_empty() => ("scenario".to_owned(), why),
            placed => placed,
        };
        self.error(span.start, field, &why)
    }

    fn error(&self, start: usize, field: String, why: &str) -> ScenarioError {
        let (file, line) = self.text_at(start).map_or_else(
            || ("scenario".to_owned(), 1),
            |text| {
                let line = line_of(&text.text, start - text.start);
                (text.origin.to_string(), line)
            },
        );
        ScenarioError::Field {
            file,
            line,
            field,
            why: why.to_owned(),
        }
    }

    fn text_at(&self, start: usize) -> Option<&Source> {
        self.texts.iter().rev().find(|text| text.start <= start)
    }
}
