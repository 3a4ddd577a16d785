//! `zeronav bag export`: the messages of the contract as tables.

use super::input::{is_unit, open};
use crate::output_file::Problem;
use core::iter::once;
use csv::Writer;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use zeronav_files::Folder;
use zeronav_recorder::layout::{Kind, Layout, Leaf};
use zeronav_recorder::messages::native_messages;
use zeronav_shell::printable::printable_cell;

/// Most values of an item that become columns: those of a map's tile do not.
const COLUMNS_MAX: usize = 256;

/// The tables of one topic.
struct Tables {
    messages: Writer<File>,
    items: Option<Writer<File>>,
    /// Their files.
    names: Vec<String>,
    stem: String,
    rows: u64,
}

/// Writes `TOPIC.csv` for each topic, with a row for each message, and `TOPIC.items.csv` with a row for each item of
/// those that have some; `/` in names becomes `-`. Without `topics` all of them. How many rows of messages there are
/// in each.
pub(super) fn export(
    file: &Path,
    folder: &Path,
    topics: &[String],
) -> Result<BTreeMap<String, u64>, Problem> {
    let input = open(file).map_err(Problem::Input)?;
    let failed = |why: &dyn core::fmt::Display| Problem::writing(folder, why);
    let made: Vec<&Path> = folder
        .ancestors()
        .take_while(|it| !it.as_os_str().is_empty() && it.symlink_metadata().is_err())
        .collect();
    let folder = Folder::make(folder).map_err(|error| failed(&error))?;
    if !folder.names().map_err(|error| failed(&error))?.is_empty() {
        let why = format!(
            "{}: it is not empty; name another folder",
            folder.path().display()
        );
        return Err(Problem::Input(why));
    }
    let mut tables: BTreeMap<String, Tables> = BTreeMap::new();
    let mut problem = None;
    let wants = |name: &str| topics.is_empty() || topics.iter().any(|topic| topic == name);
    let read = native_messages(input, wants, |name, layout, parts| {
        if problem.is_none() {
            problem = write(&folder, &mut tables, name, layout, parts).err();
        }
    });
    for tables in tables.values_mut() {
        let mut files = once(&mut tables.messages).chain(tables.items.as_mut());
        let flushed = files.try_for_each(Writer::flush);
        problem = problem.or(flushed.err().map(csv::Error::from));
    }
    let missing = topics.iter().find(|topic| !tables.contains_key(*topic));
    let wrong = |why: &dyn core::fmt::Display| Problem::Input(format!("{}: {why}", file.display()));
    let result = match (problem, read, missing) {
        (Some(error), _, _) => Err(failed(&error)),
        (None, Err(error), _) => Err(wrong(&error)),
        (None, Ok(_), Some(topic)) => Err(wrong(&format!("no message on {topic} is in it"))),
        (None, Ok(_), None) => Ok(()),
    };
    if result.is_err() {
        tables
            .values()
            .flat_map(|tables| &tables.names)
            .for_each(|name| folder.remove(name));
        // An export that failed leaves nothing behind, not even its folder.
        for folder in made {
            let _ = std::fs::remove_dir(folder);
        }
    }
    result.map(|()| {
        tables
            .into_iter()
            .map(|(name, tables)| (name, tables.rows))
            .collect()
    })
}

fn write(
    folder: &Folder,
    tables: &mut BTreeMap<String, Tables>,
    name: &str,
    layout: &Layout,
    [envelope, items]: [&[u8]; 2],
) -> csv::Result<()> {
    if !tables.contains_key(name) {
        let begun = Tables::begin(folder, name, layout)?;
        tables.insert(name.to_owned(), begun);
    }
    let Some(tables) = tables.get_mut(name) else {
        return Ok(());
    };
    let row = tables.rows.to_string();
    let n = (items.len() / layout.item_bytes.max(1)).to_string();
    let values = cells(&layout.envelope, envelope);
    let cells_of_row = [row.clone()].into_iter().chain(values).chain([n]);
    tables.messages.write_record(cells_of_row)?;
    if (1..=COLUMNS_MAX).contains(&layout.item.len()) {
        for (at, item) in items.chunks_exact(layout.item_bytes.max(1)).enumerate() {
            let place = [row.clone(), at.to_string()];
            let to = tables.items(folder, layout)?;
            to.write_record(place.into_iter().chain(cells(&layout.item, item)))?;
        }
    }
    tables.rows += 1;
    Ok(())
}

impl Tables {
    fn begin(folder: &Folder, topic: &str, layout: &Layout) -> csv::Result<Self> {
        let letter = |letter: char| match letter {
            'a'..='z' | 'A'..='Z' | '0'..='9' | '_' => letter,
            _ => '-',
        };
        let stem: String = topic.chars().map(letter).collect();
        let name = format!("{stem}.csv");
        let mut messages = Writer::from_writer(folder.new_file(&name)?);
        let heads = heads(&layout.envelope);
        let heads = once("message").chain(heads.iter().map(String::as_str));
        messages.write_record(heads.chain(once("items")))?;
        Ok(Self {
            messages,
            items: None,
            names: vec![name],
            stem,
            rows: 0,
        })
    }

    /// The table of the items, which is there from the first on.
    fn items(&mut self, folder: &Folder, layout: &Layout) -> csv::Result<&mut Writer<File>> {
        let begun = if let Some(items) = self.items.take() {
            items
        } else {
            let name = format!("{}.items.csv", self.stem);
            let mut items = Writer::from_writer(folder.new_file(&name)?);
            self.names.push(name);
            let heads = heads(&layout.item);
            let heads = heads.iter().map(String::as_str);
            items.write_record(["message", "item"].into_iter().chain(heads))?;
            items
        };
        Ok(self.items.insert(begun))
    }
}

/// The names of columns with their units.
fn heads(leaves: &[Leaf]) -> Vec<String> {
    let head = |leaf: &Leaf| {
        // An item that is a number alone has no name of its own.
        let name = match &*leaf.path {
            "" => "value",
            path => path,
        };
        match leaf.unit.as_deref().filter(|unit| is_unit(unit)) {
            Some(unit) => format!("{name} [{unit}]"),
            None => name.to_owned(),
        }
    };
    let heads = leaves.iter().map(head);
    heads
        .map(|head| printable_cell(&head).into_owned())
        .collect()
}

fn cells<'a>(leaves: &'a [Leaf], part: &'a [u8]) -> impl Iterator<Item = String> + 'a {
    leaves.iter().map(move |leaf| {
        let text = leaf.text(leaf.of(part).unwrap_or_default());
        match leaf.kind {
            Kind::Number(_) => text,
            Kind::Text => printable_cell(&text).into_owned(),
        }
    })
}
