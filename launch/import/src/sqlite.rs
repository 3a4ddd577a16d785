//! Bags of rosbag2 in `SQLite` files.

use crate::ros::{Bag, kind};
use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, Error, OpenFlags};
use std::collections::BTreeMap;
use std::path::Path;

/// Longest message. [bytes]
const MESSAGE_BYTES_MAX: i32 = 256 << 20;

/// The tables that rosbag2 writes: no views and no virtual ones, which are programs.
const TABLES: &str = "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name IN ('topics', 'messages') \
                      AND sql NOT LIKE 'CREATE VIRTUAL%'";

/// Reads the messages of a bag. One that is damaged is read as far as it goes.
///
/// # Errors
/// Why nothing of it can be read.
pub(crate) fn read(path: &Path, bag: &mut Bag<'_>) -> Result<(), String> {
    let opened = open(path).and_then(|file| Ok((topics(&file)?, file)));
    let (topics, file) = opened.map_err(|error| error.to_string())?;
    let topics =
        topics.ok_or("it has no tables `topics` and `messages`: rosbag2 has not written it")?;
    if let Err(damage) = messages(&file, &topics, bag) {
        bag.is_damaged(&damage.to_string());
    }
    Ok(())
}

/// Opens a file of which nothing is trusted.
fn open(path: &Path) -> rusqlite::Result<Connection> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let file = Connection::open_with_flags(path, flags)?;
    file.set_db_config(DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false)?;
    file.set_limit(Limit::SQLITE_LIMIT_LENGTH, MESSAGE_BYTES_MAX)?;
    file.pragma_update(None, "cell_size_check", true)?;
    Ok(file)
}

/// The topics that are read, by their id: name and type. `None` when the file is no bag.
fn topics(file: &Connection) -> rusqlite::Result<Option<BTreeMap<i64, (String, &'static str)>>> {
    let n: i64 = file.query_row(TABLES, [], |row| row.get(0))?;
    if n != 2 {
        return Ok(None);
    }
    let mut topics = BTreeMap::new();
    let mut all =
        file.prepare("SELECT id, name, type FROM topics WHERE serialization_format = 'cdr'")?;
    let mut rows = all.query([])?;
    while let Some(row) = rows.next()? {
        let name: String = row.get(2)?;
        if let Some(kind) = kind(&name) {
            topics.insert(row.get(0)?, (row.get(1)?, kind));
        }
    }
    Ok(Some(topics))
}

fn messages(
    file: &Connection,
    topics: &BTreeMap<i64, (String, &'static str)>,
    bag: &mut Bag<'_>,
) -> Result<(), Error> {
    let mut all = file.prepare("SELECT topic_id, timestamp, data FROM messages ORDER BY id")?;
    let mut rows = all.query([])?;
    while let Some(row) = rows.next()? {
        if let (ValueRef::Integer(topic), ValueRef::Integer(ns), ValueRef::Blob(data)) =
            (row.get_ref(0)?, row.get_ref(1)?, row.get_ref(2)?)
            && let Some((name, kind)) = topics.get(&topic)
        {
            bag.take(name, kind, u64::try_from(ns).unwrap_or(0), data);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Topics;

    fn read_made_by(sql: &str) -> Result<(), String> {
        let place = tempfile::tempdir().expect("a folder");
        let path = place.path().join("it.db3");
        let file = Connection::open(&path).expect("made");
        file.execute_batch(sql).expect("written");
        drop(file);
        let topics = Topics::default();
        read(&path, &mut Bag::new(&topics))
    }

    #[test]
    fn what_rosbag2_has_not_written_is_rejected() {
        const GOOD: &str = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format); \
                            CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data); \
                            INSERT INTO topics VALUES(1, '/scan', 'sensor_msgs/msg/LaserScan', 'cdr'); \
                            INSERT INTO messages VALUES(1, 'no', NULL, 7);";
        assert_eq!(
            read_made_by(GOOD),
            Ok(()),
            "values of other types are left out"
        );
        let never_ends = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format); \
                          CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n) \
                          SELECT id, 1 AS topic_id, 1 AS timestamp, x'00' AS data FROM n;";
        for sql in ["CREATE TABLE it(id)", never_ends] {
            let why = read_made_by(sql).expect_err("no bag");
            assert!(why.contains("rosbag2 has not written it"), "{why}");
        }
    }
}
