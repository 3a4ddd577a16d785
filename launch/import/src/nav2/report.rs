//! What became of the parameters of a file.

use std::fmt::Write;

/// A parameter that was carried over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Carried {
    /// Node and name of the parameter, or a part of the URDF.
    pub from: String,
    /// Line of the file, where it has one.
    pub line: Option<u64>,
    /// Its value, as in the file.
    pub value: String,
    /// Path of the field in the scenario.
    pub to: &'static str,
    /// The value there; `None` when another parameter has given it.
    pub ours: Option<String>,
}

/// A value that no parameter gives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Assumed {
    /// Path of the field in the scenario.
    pub to: &'static str,
    /// Its value.
    pub value: String,
    /// Why this one.
    pub why: String,
}

/// Something that was not carried over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Left {
    /// The parameter, plugin or node.
    pub what: String,
    /// What that means for the robot.
    pub means: String,
}

/// Parameters of a node without a counterpart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unknown {
    /// The node.
    pub node: String,
    /// How many there are.
    pub count: usize,
    /// The first few.
    pub first: Vec<String>,
}

/// What became of the parameters of a file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Report {
    /// What was carried over.
    pub carried: Vec<Carried>,
    /// What no parameter gives.
    pub assumed: Vec<Assumed>,
    /// What was not carried over, and what that means.
    pub left: Vec<Left>,
    /// What has no counterpart, by node.
    pub unknown: Vec<Unknown>,
}

impl Report {
    pub(super) fn leave(&mut self, what: impl Into<String>, means: impl Into<String>) {
        self.left.push(Left {
            what: what.into(),
            means: means.into(),
        });
    }

    /// The lines for people, by group.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let mut group = |title: &str, rows: Vec<String>| {
            if !rows.is_empty() {
                lines.push(format!("{title}:"));
                lines.extend(rows.into_iter().map(|row| format!("  {row}")));
            }
        };
        group("carried over", self.carried_by_field());
        let assumed = self.assumed.iter();
        let assumed = assumed.map(|it| format!("{} = {}: {}", it.to, it.value, it.why));
        group("assumed", assumed.collect());
        let left = self.left.iter();
        let left = left.map(|it| format!("{}: {}", it.what, it.means));
        group("not carried over, and what that means", left.collect());
        let unknown = self.unknown.iter().map(|it| {
            let more = if it.count > it.first.len() {
                ", ..."
            } else {
                ""
            };
            format!("{}: {} ({}{more})", it.node, it.count, it.first.join(", "))
        });
        group(
            "parameters without a counterpart, by node",
            unknown.collect(),
        );
        lines
    }

    /// A line for each field: the parameter that counts, and the others.
    fn carried_by_field(&self) -> Vec<String> {
        let mut fields: Vec<&str> = Vec::new();
        for it in &self.carried {
            if !fields.contains(&it.to) {
                fields.push(it.to);
            }
        }
        let of_field = |to: &&str| {
            let (given, beyond): (Vec<_>, Vec<_>) =
                (self.carried.iter().filter(|it| it.to == *to)).partition(|it| it.ours.is_some());
            let mut line = given.first().map_or_else(
                || (*to).to_owned(),
                |it| {
                    let ours = it.ours.as_deref().unwrap_or_default();
                    format!("{} = {} -> {to} = {ours}", it.from, it.value)
                },
            );
            let same: Vec<&str> = given.iter().skip(1).map(|it| it.from.as_str()).collect();
            if !same.is_empty() {
                let _ = write!(line, "; the same in {}", same.join(", "));
            }
            for it in beyond {
                let _ = write!(line, "; {} = {} is less strict", it.from, it.value);
            }
            line
        };
        fields.iter().map(of_field).collect()
    }
}
