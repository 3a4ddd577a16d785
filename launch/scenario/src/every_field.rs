//! Every field that a scenario can have: a number that cannot be and a misspelt name are found in
//! each of them. The fields are those of the shipped scenarios and of the ones below; that none is
//! left out is seen from what the deserialiser expects.

mod others;

use super::{Library, Scenario};
pub(super) use others::OTHERS;
use std::collections::{BTreeMap, BTreeSet};
use tempfile::TempDir;
use toml::{Table, Value};
use zeronav_casts::Cast;
use zeronav_msgs::Role;

/// The shipped scenarios with their defaults written out, and the ones above.
pub(super) fn documents() -> Vec<Table> {
    let library = Library::of("/nowhere");
    let shipped = library.list().into_iter().map(|listed| {
        let scenario = Scenario::load_from(&library, &listed.name).unwrap();
        let mut table = Table::try_from(&scenario).unwrap();
        table.remove("name");
        table
    });
    let others = OTHERS.iter().map(|text| text.parse().unwrap());
    // One shadow at a time.
    let shadows = Role::SERVICES.into_iter().map(|role| {
        let text = format!(
            "title = \"A shadow and a schedule\"\nstart = [3.0, 2.5, 0.0]\n\
             [world]\narea_m = [[0.0, 0.0], [10.0, 5.0]]\n[services.{role}.shadow]\nbinary = \"b\"\nconfig.x = 1\n\
             [services.{role}.scheduling]\npolicy = \"fifo\"\npriority = 5\nnice = 0\ncpus = [0]\nlock_memory = true\n"
        );
        text.parse().unwrap()
    });
    others.chain(shadows).chain(shipped).collect()
}

/// A step to a value.
#[derive(Debug, Clone, PartialEq)]
enum Step {
    Key(String),
    Index(usize),
}

/// The way to a value, and how it reads with and without the numbers of lists.
#[derive(Debug, Clone, Default)]
struct FieldPath(Vec<Step>);

impl FieldPath {
    fn then(&self, step: Step) -> Self {
        Self(self.0.iter().cloned().chain([step]).collect())
    }

    /// `goals[].pose[]`.
    fn kind(&self) -> String {
        let word = |step: &Step| match step {
            Step::Key(key) => format!(".{key}"),
            Step::Index(_) => "[]".to_owned(),
        };
        let words: String = self.0.iter().map(word).collect();
        words.trim_start_matches('.').to_owned()
    }

    /// As `kind`; hosts have the same fields under whatever name.
    fn sort(&self) -> String {
        match &self.0[..] {
            [Step::Key(hosts), Step::Key(_)] if hosts == "hosts" => "hosts.NAME".to_owned(),
            _ => self.kind(),
        }
    }

    /// The innermost name.
    fn name(&self) -> &str {
        for step in self.0.iter().rev() {
            if let Step::Key(key) = step {
                return key;
            }
        }
        ""
    }

    fn value<'a>(&self, root: &'a mut Value) -> &'a mut Value {
        self.0.iter().fold(root, |value, step| match step {
            Step::Key(key) => &mut value[key.as_str()],
            Step::Index(index) => &mut value[*index],
        })
    }
}

/// All values below `value`, tables and lists, too.
fn walk(value: &Value, way: &FieldPath, visit: &mut impl FnMut(&FieldPath, &Value)) {
    visit(way, value);
    match value {
        // What a service is told is its own affair.
        Value::Table(_) if way.kind().ends_with(".config") => {}
        Value::Table(table) => {
            for (key, value) in table {
                walk(value, &way.then(Step::Key(key.clone())), visit);
            }
        }
        Value::Array(list) => {
            for (index, value) in list.iter().enumerate() {
                walk(value, &way.then(Step::Index(index)), visit);
            }
        }
        _ => {}
    }
}

/// A folder to read changed scenarios from.
struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn said_of(&self, document: &Value) -> String {
        let text = toml::to_string(document).unwrap();
        std::fs::write(self.0.path().join("it.toml"), text).unwrap();
        let read = Scenario::load_from(&Library::of(self.0.path()), "./it.toml");
        let checked = read.and_then(|scenario| {
            let checked = scenario.validate()?;
            // What a run makes of the numbers before it starts anything.
            let _ = (scenario.run.tick_ns(), scenario.run.time_limit_ns());
            let _ = scenario.restart.hang_after();
            Ok(checked)
        });
        checked.map_or_else(|error| error.to_string(), |_| String::new())
    }

    /// What is wrong with the document after `change` to the value at `way`; empty for nothing.
    fn complaint(
        &self,
        document: &Value,
        way: &FieldPath,
        change: impl FnOnce(&mut Value),
    ) -> String {
        let mut changed = document.clone();
        change(way.value(&mut changed));
        let complaint = self.said_of(&changed);
        // What is wrong with the document itself, such as a file that is not there, is said besides.
        let second = complaint.lines().nth(1);
        let of_document = second.map(|_| self.said_of(document)).unwrap_or_default();
        let what = |line: &str| line.splitn(3, ':').last().map(str::to_owned);
        let own = |line: &&str| !of_document.lines().any(|known| what(known) == what(line));
        let complaint = complaint.lines().filter(own).collect::<Vec<_>>().join("\n");
        assert!(!complaint.contains('\n'), "{complaint:?} has several lines");
        assert!(complaint.len() < 1000, "too long: {complaint}");
        complaint
    }
}

#[test]
fn every_number_has_a_range() {
    let (desk, mut seen) = (Desk::new(), BTreeSet::new());
    for document in documents().into_iter().map(Value::Table) {
        let mut numbers = Vec::new();
        walk(&document, &FieldPath::default(), &mut |way, value| {
            let is_number = value.is_float() || value.is_integer();
            if is_number && !way.kind().contains(".config") && seen.insert(way.kind()) {
                numbers.push((way.clone(), value.is_float()));
            }
        });
        for (way, is_float) in numbers {
            let (nan, infinite) = (f64::NAN, f64::INFINITY);
            for wrong in [nan, infinite, -infinite, 1.0e300, -1.0e300] {
                let complaint = desk.complaint(&document, &way, |value| *value = wrong.into());
                let place = way.kind();
                assert!(!complaint.is_empty(), "{place} = {wrong:?} was accepted");
                let named = !is_float || complaint.contains(way.name());
                assert!(named, "{place} = {wrong:?} is not named: {complaint}");
            }
            // These may be, but nothing may panic.
            for odd in [-1_i64, 0, i64::MAX] {
                let as_read = if is_float {
                    Value::from(odd.to_f64())
                } else {
                    Value::from(odd)
                };
                desk.complaint(&document, &way, |value| *value = as_read);
            }
        }
    }
    assert!(seen.len() > 80, "only {} numbers were found", seen.len());
}

#[test]
fn every_list_of_fixed_length_is_counted() {
    let (desk, mut seen) = (Desk::new(), BTreeSet::new());
    for document in documents().into_iter().map(Value::Table) {
        let mut lists = Vec::new();
        walk(&document, &FieldPath::default(), &mut |way, value| {
            let of_numbers = value.as_array().is_some_and(|list| {
                !list.is_empty() && list.iter().all(|item| item.is_float() || item.is_integer())
            });
            if of_numbers && seen.insert(way.kind()) {
                lists.push(way.clone());
            }
        });
        for way in lists {
            let complaint = desk.complaint(&document, &way, |value| {
                let list = value.as_array_mut().unwrap();
                list.push(list[0].clone());
            });
            assert!(!complaint.is_empty(), "{} may be longer", way.kind());
        }
    }
    assert!(seen.contains("start") && seen.contains("world.shapes[].centre_m"));
}

/// The words between backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

#[test]
fn every_misspelt_field_is_found_and_no_field_is_left_out() {
    const UNKNOWN: &str = "zqzqzqzqzqzq";
    let desk = Desk::new();
    let documents: Vec<Value> = documents().into_iter().map(Value::Table).collect();
    // Which fields there are in each table, by its place and, where tables differ in kind, that.
    let mut fields: BTreeMap<(String, String), BTreeSet<String>> = BTreeMap::new();
    let mut tables = Vec::new();
    for document in &documents {
        walk(document, &FieldPath::default(), &mut |way, value| {
            let Some(table) = value
                .as_table()
                .filter(|_| !way.kind().ends_with(".config"))
            else {
                return;
            };
            let kind = table.get("kind").and_then(Value::as_str).unwrap_or("");
            let known = fields.entry((way.sort(), kind.to_owned())).or_default();
            if table.keys().any(|key| !known.contains(key)) {
                known.extend(table.keys().cloned());
                tables.push((document, way.clone(), table.clone(), kind.to_owned()));
            }
        });
    }
    for (document, way, table, kind) in tables {
        let place = way.kind();
        let complaint = desk.complaint(document, &way, |value| {
            let table = value.as_table_mut().unwrap();
            table.insert(UNKNOWN.to_owned(), 1.into());
        });
        assert!(
            complaint.contains(UNKNOWN),
            "unknown in {place}: {complaint:?}"
        );
        // A list of labels is checked against other words.
        if let Some((_, expected)) = complaint.split_once(", expected ") {
            let known = &fields[&(way.sort(), kind)];
            for field in quoted(expected) {
                let bases = place.is_empty() && ["base", "variant", "variants"].contains(&field);
                assert!(
                    bases || known.contains(field),
                    "no test has {place}.{field}"
                );
            }
        }
        // The names of companions and hosts are their author's.
        let named = ["companions", "hosts"].contains(&place.as_str());
        let is_named = |key: &&String| *key != "kind" && !named;
        for key in table.keys().filter(is_named) {
            let complaint = desk.complaint(document, &way, |value| {
                let table = value.as_table_mut().unwrap();
                let old = table.remove(key).unwrap();
                table.insert(format!("{key}x"), old);
            });
            let said = format!("did you mean `{key}`?");
            assert!(complaint.contains(&said), "{place}.{key}x: {complaint:?}");
        }
    }
}
