//! The tables of an `SQLite` file as rosbag2 writes it, read without `SQLite`: its library is most of the build of whoever
//! links it, and a bag needs two tables to be read from their beginning to their end.
//!
//! Source: `SQLite`, "Database File Format", sections 1.3, 1.6 and 2.1.

use crate::ros::{Bag, kind};
use std::collections::BTreeMap;
use std::fs::File;
use std::os::unix::fs::FileExt;

/// The header of the file, in front of its first page. [bytes]
const HEAD_BYTES: usize = 100;

/// Deepest tree, and longest record. [bytes]
const DEPTH_MAX: usize = 20;
const RECORD_BYTES_MAX: u64 = 256 << 20;

/// Pages of the two kinds of a table's tree.
const INTERIOR: u8 = 0x05;
const LEAF: u8 = 0x0d;

/// Reads the messages of a bag.
///
/// # Errors
/// Why it cannot be read.
pub(crate) fn read(file: &File, bag: &mut Bag<'_>) -> Result<(), String> {
    let tables = Tables::open(file)?;
    let mut roots: BTreeMap<String, u64> = BTreeMap::new();
    tables.rows(1, &mut |_, row| {
        if let (Some(Value::Text(kind)), Some(Value::Text(name)), Some(Value::Integer(root))) =
            (row.first(), row.get(1), row.get(3))
            && kind == "table"
        {
            roots.insert(name.clone(), u64::try_from(*root).unwrap_or(0));
        }
    })?;
    let root = |name: &str| {
        let root = roots.get(name).copied();
        root.ok_or_else(|| format!("it has no table `{name}`: rosbag2 has not written it"))
    };
    let mut topics: BTreeMap<i64, (String, &'static str)> = BTreeMap::new();
    tables.rows(root("topics")?, &mut |id, row| {
        if let (Some(Value::Text(name)), Some(Value::Text(of)), Some(Value::Text(format))) =
            (row.get(1), row.get(2), row.get(3))
            && format == "cdr"
            && let Some(kind) = kind(of)
        {
            topics.insert(id, (name.clone(), kind));
        }
    })?;
    let read = tables.rows(root("messages")?, &mut |_, row| {
        if let (Some(Value::Integer(topic)), Some(Value::Integer(ns)), Some(Value::Blob(data))) =
            (row.get(1), row.get(2), row.get(3))
            && let Some((name, kind)) = topics.get(topic)
        {
            bag.take(name, kind, u64::try_from(*ns).unwrap_or(0), data);
        }
    });
    // What can be read of a damaged one is used.
    if let Err(damage) = read {
        bag.is_damaged(&damage);
    }
    Ok(())
}

/// A value of a record.
#[derive(Debug, Clone, PartialEq)]
enum Value {
    Nothing,
    Integer(i64),
    Real,
    Text(String),
    Blob(Vec<u8>),
}

struct Tables<'a> {
    file: &'a File,
    page_bytes: usize,
    /// Of a page, without what is reserved at its end. [bytes]
    usable: usize,
    pages: u64,
}

/// Shows a row: its number, and its values.
type See<'a> = &'a mut dyn FnMut(i64, &[Value]);

impl<'a> Tables<'a> {
    fn open(file: &'a File) -> Result<Self, String> {
        let mut head = [0; HEAD_BYTES];
        let short = |_| "it is shorter than the header of an SQLite file".to_owned();
        file.read_exact_at(&mut head, 0).map_err(short)?;
        let page_bytes = match u16::from_be_bytes([head[16], head[17]]) {
            1 => 65_536,
            bytes => usize::from(bytes),
        };
        let usable = page_bytes.saturating_sub(usize::from(head[20]));
        if !page_bytes.is_power_of_two() || page_bytes < 512 || usable < 480 {
            return Err(format!("byte 16: no page of SQLite has {page_bytes} bytes"));
        }
        if u32::from_be_bytes([head[56], head[57], head[58], head[59]]) > 1 {
            return Err("byte 56: its texts are not in UTF-8".to_owned());
        }
        let len = file.metadata().map_err(|error| error.to_string())?.len();
        Ok(Self {
            file,
            page_bytes,
            usable,
            pages: len / page_bytes as u64,
        })
    }

    /// Shows every row of the table whose tree begins at this page.
    fn rows(&self, root: u64, see: See<'_>) -> Result<(), String> {
        let mut left = self.pages;
        self.tree(root, 0, &mut left, see)
    }

    fn page(&self, n: u64) -> Result<Vec<u8>, String> {
        let at = n.checked_sub(1).filter(|at| *at < self.pages);
        let at = at.ok_or_else(|| format!("page {n} is not in the file: it is cut or damaged"))?;
        let mut page = vec![0; self.page_bytes];
        let read = self
            .file
            .read_exact_at(&mut page, at * self.page_bytes as u64);
        read.map_err(|error| format!("page {n}: {error}"))?;
        Ok(page)
    }

    fn tree(&self, n: u64, depth: usize, left: &mut u64, see: See<'_>) -> Result<(), String> {
        let damaged = || format!("page {n} is damaged");
        // No page belongs to a tree twice.
        *left = left.checked_sub(1).ok_or_else(damaged)?;
        if depth > DEPTH_MAX {
            return Err(damaged());
        }
        let page = self.page(n)?;
        let head = if n == 1 { HEAD_BYTES } else { 0 };
        let kind = page[head];
        let cells = usize::from(short(&page, head + 3).ok_or_else(damaged)?);
        let pointers = head + if kind == INTERIOR { 12 } else { 8 };
        for cell in 0..cells {
            let at = short(&page, pointers + 2 * cell).ok_or_else(damaged)?;
            let cell = page.get(usize::from(at)..).ok_or_else(damaged)?;
            if kind == INTERIOR {
                let child = word(cell, 0).ok_or_else(damaged)?;
                self.tree(u64::from(child), depth + 1, left, see)?;
            } else if kind == LEAF {
                let (id, record) = self.cell(cell).ok_or_else(damaged)??;
                let row = values(&record).ok_or_else(damaged)?;
                see(id, &row);
            } else {
                return Err(damaged());
            }
        }
        if kind == INTERIOR {
            let last = word(&page, head + 8).ok_or_else(damaged)?;
            self.tree(u64::from(last), depth + 1, left, see)?;
        }
        Ok(())
    }

    /// Number and record of a cell of a leaf, with what lies in other pages.
    fn cell(&self, cell: &[u8]) -> Option<Result<(i64, Vec<u8>), String>> {
        let (bytes, rest) = varint(cell)?;
        let (id, rest) = varint(rest)?;
        if bytes > RECORD_BYTES_MAX {
            return None;
        }
        let bytes = usize::try_from(bytes).ok()?;
        let most = self.usable - 35;
        let local = if bytes <= most {
            bytes
        } else {
            let least = (self.usable - 12) * 32 / 255 - 23;
            let fits = least + (bytes - least) % (self.usable - 4);
            if fits <= most { fits } else { least }
        };
        let mut record = rest.get(..local)?.to_vec();
        let mut next = if local < bytes { word(rest, local)? } else { 0 };
        while record.len() < bytes {
            let page = match self.page(u64::from(next)) {
                Ok(page) => page,
                Err(why) => return Some(Err(why)),
            };
            next = word(&page, 0)?;
            let more = (bytes - record.len()).min(self.usable - 4);
            record.extend_from_slice(page.get(4..4 + more)?);
        }
        Some(Ok((id.cast_signed(), record)))
    }
}

/// The values of a record.
fn values(record: &[u8]) -> Option<Vec<Value>> {
    let (head_bytes, _) = varint(record)?;
    let head_bytes = usize::try_from(head_bytes).ok()?;
    let (mut kinds, mut body) = record.split_at_checked(head_bytes)?;
    (_, kinds) = varint(kinds)?;
    let mut values = Vec::new();
    while !kinds.is_empty() {
        let kind;
        (kind, kinds) = varint(kinds)?;
        let bytes = match kind {
            0 | 8 | 9 => 0,
            1..=4 => usize::try_from(kind).ok()?,
            5 => 6,
            6 | 7 => 8,
            _ => usize::try_from(kind.checked_sub(12)? / 2).ok()?,
        };
        let value;
        (value, body) = body.split_at_checked(bytes)?;
        values.push(match kind {
            0 => Value::Nothing,
            1..=6 => Value::Integer(integer(value)),
            7 => Value::Real,
            8 => Value::Integer(0),
            9 => Value::Integer(1),
            kind if kind % 2 == 0 => Value::Blob(value.to_vec()),
            _ => Value::Text(String::from_utf8_lossy(value).into_owned()),
        });
    }
    Some(values)
}

/// A number of up to eight bytes, the highest first, with a sign.
fn integer(bytes: &[u8]) -> i64 {
    let is_negative = bytes.first().is_some_and(|first| first & 0x80 != 0);
    let start = if is_negative { -1 } else { 0 };
    bytes
        .iter()
        .fold(start, |number: i64, byte| (number << 8) | i64::from(*byte))
}

/// A number of one to nine bytes, and what follows.
fn varint(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let mut number = 0_u64;
    for (n, byte) in bytes.iter().enumerate().take(9) {
        if n == 8 {
            return Some(((number << 8) | u64::from(*byte), &bytes[9..]));
        }
        number = (number << 7) | u64::from(byte & 0x7f);
        if byte & 0x80 == 0 {
            return Some((number, &bytes[n + 1..]));
        }
    }
    None
}

fn short(bytes: &[u8], at: usize) -> Option<u16> {
    let two = bytes.get(at..at.checked_add(2)?)?;
    Some(u16::from_be_bytes(two.try_into().ok()?))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_be_bytes(four.try_into().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_records_are_read() {
        assert_eq!(varint(&[0x05, 1]), Some((5, &[1][..])));
        assert_eq!(varint(&[0x81, 0x00]), Some((128, &[][..])));
        assert_eq!(varint(&[0xff; 9]), Some((u64::MAX, &[][..])));
        assert_eq!(varint(&[0x81]), None);
        assert_eq!(integer(&[0xff, 0xfe]), -2);
        assert_eq!(integer(&[0x01, 0x00]), 256);
        // Nothing, 1 byte, text of 2, blob of 3, one.
        let record = [6, 0, 1, 17, 18, 9, 0x80, b'h', b'i', 1, 2, 3];
        let expected = [
            Value::Nothing,
            Value::Integer(-128),
            Value::Text("hi".to_owned()),
            Value::Blob(vec![1, 2, 3]),
            Value::Integer(1),
        ];
        assert_eq!(values(&record).as_deref(), Some(&expected[..]));
        assert_eq!(values(&record[..8]), None);
    }
}
