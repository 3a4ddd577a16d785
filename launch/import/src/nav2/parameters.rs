//! The parameters of the nodes in a file, under the names that ROS 2 gives them.
//!
//! A file is a tree of nodes with `ros__parameters` at its leaves. Names of nodes may be written nested or with
//! slashes, below a namespace, or with the wildcards `*` (one part of a name) and `**` (any number). Where several
//! sections mean the same node, the last one in the file wins, as in `rclcpp`.

use super::yaml::{Node, Value};

/// Key below which the parameters of a node are.
const PARAMETERS: &str = "ros__parameters";

/// Names of nodes that are in a namespace of the same name: these parts are none of a robot's.
const COSTMAPS: [&str; 2] = ["local_costmap", "global_costmap"];

/// Most parts of a name, namespaces included.
const PARTS_MAX: usize = 16;

/// A parameter.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Parameter {
    /// Its name below its node, with dots.
    pub(super) name: String,
    /// Its value: no table.
    pub(super) value: Value,
    /// Line, from 1.
    pub(super) line: u64,
}

/// The parameters of a node, or of all that a wildcard means.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Section {
    /// Parts of its name.
    parts: Vec<String>,
    /// In the order of the file.
    pub(super) parameters: Vec<Parameter>,
}

/// Where a parameter is: index of its section, and in it.
pub(super) type Place = (usize, usize);

/// The sections of a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sections(Vec<Section>);

impl Section {
    /// The name of the node, or the wildcard, as ROS 2 writes it, without the slash in front.
    pub(super) fn name(&self) -> String {
        self.parts.join("/")
    }

    /// True for a section that means `node`, in whatever namespace.
    pub(super) fn means(&self, node: &str) -> bool {
        let node: Vec<&str> = node.split('/').collect();
        let is_namespace = |part: &String| !COSTMAPS.contains(&part.as_str());
        (0..self.parts.len())
            .take_while(|from| self.parts[..*from].iter().all(is_namespace))
            .any(|from| matches(&self.parts[from..], &node))
    }

    /// True for a section that names its node.
    pub(super) fn is_literal(&self) -> bool {
        self.parts.iter().all(|it| it != "*" && it != "**")
    }

    /// Namespace of a section that names `node`: empty, or with a slash in front.
    fn namespace(&self, node: &str) -> String {
        let n = node.split('/').count();
        let above = &self.parts[..self.parts.len().saturating_sub(n)];
        let above = above.iter().filter(|it| *it != "*" && *it != "**");
        above.flat_map(|it| ["/", it]).collect()
    }
}

/// Whether the parts of a pattern mean those of a name. Both are short.
fn matches(pattern: &[String], name: &[&str]) -> bool {
    match (pattern.split_first(), name.split_first()) {
        (None, None) => true,
        (Some((first, rest)), _) if first == "**" => {
            matches(rest, name)
                || name
                    .split_first()
                    .is_some_and(|(_, name)| matches(pattern, name))
        }
        (Some((first, rest)), Some((part, name))) => {
            (first == "*" || first == part) && matches(rest, name)
        }
        _ => false,
    }
}

impl Sections {
    /// The sections of a tree.
    ///
    /// # Errors
    /// Line and reason when it is no parameter file.
    pub(super) fn of(root: &Node) -> Result<Self, (u64, String)> {
        let Value::Table(entries) = &root.value else {
            let why = "is no table: a parameter file of ROS 2 names a node on its first line";
            return Err((root.line.max(1), why.to_owned()));
        };
        let has = |key: &str| entries.iter().any(|(known, _)| known == key);
        if has("rosbag2_bagfile_information") {
            let why = "describes a bag: name the folder that it is in";
            return Err((root.line, why.to_owned()));
        }
        if has("image") && has("resolution") {
            let why = "is the map of a map_server: give it with --map, beside a parameter file";
            return Err((root.line, why.to_owned()));
        }
        let mut sections = Vec::new();
        gather(entries, &mut Vec::new(), &mut sections)?;
        if sections.is_empty() {
            let why = format!("has no {PARAMETERS}: it is no parameter file of ROS 2");
            return Err((root.line, why));
        }
        Ok(Self(sections))
    }

    /// All of them.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Section> {
        self.0.iter()
    }

    /// True when a section names `node`.
    pub(super) fn names(&self, node: &str) -> bool {
        let mut sections = self.0.iter();
        sections.any(|it| it.is_literal() && it.means(node))
    }

    /// The namespace of `node`: empty, or with a slash in front.
    pub(super) fn namespace(&self, node: &str) -> String {
        let mut sections = self.0.iter();
        let named = sections.find(|it| it.is_literal() && it.means(node));
        named.map_or_else(String::new, |it| it.namespace(node))
    }

    /// Every place of a parameter of `node`; the last one counts.
    pub(super) fn places(&self, node: &str, parameter: &str) -> Vec<Place> {
        let sections = self.0.iter().enumerate().filter(|(_, it)| it.means(node));
        let all = sections.flat_map(|(section, it)| {
            let parameters = it.parameters.iter().enumerate();
            let named = parameters.filter(|(_, it)| it.name == parameter);
            named.map(move |(at, _)| (section, at))
        });
        all.collect()
    }

    /// The parameter at a place.
    pub(super) fn at(&self, (section, parameter): Place) -> &Parameter {
        &self.0[section].parameters[parameter]
    }

    /// The parameter of `node` that counts.
    pub(super) fn get(&self, node: &str, parameter: &str) -> Option<&Parameter> {
        self.places(node, parameter).last().map(|it| self.at(*it))
    }

    /// A parameter of `node` that is a string and not empty.
    pub(super) fn text(&self, node: &str, parameter: &str) -> Option<&str> {
        match &self.get(node, parameter)?.value {
            Value::Text(it) if !it.is_empty() => Some(it),
            _ => None,
        }
    }

    /// The strings in a parameter of `node` that is a list.
    pub(super) fn texts(&self, node: &str, parameter: &str) -> Vec<&str> {
        let Some(Value::List(items)) = self.get(node, parameter).map(|it| &it.value) else {
            return Vec::new();
        };
        let texts = items.iter().filter_map(|it| match &it.value {
            Value::Text(it) => Some(it.as_str()),
            _ => None,
        });
        texts.collect()
    }
}

/// Collects the sections below a table. The parser has bounded how deep it goes.
fn gather(
    entries: &[(String, Node)],
    parts: &mut Vec<String>,
    sections: &mut Vec<Section>,
) -> Result<(), (u64, String)> {
    for (key, node) in entries {
        match (&node.value, key.as_str()) {
            (Value::Table(values), PARAMETERS) => {
                let mut parameters = Vec::new();
                flatten("", values, &mut parameters);
                sections.push(Section {
                    parts: parts.clone(),
                    parameters,
                });
            }
            (Value::Nothing, PARAMETERS) => sections.push(Section {
                parts: parts.clone(),
                parameters: Vec::new(),
            }),
            (_, PARAMETERS) => {
                let why = format!("{PARAMETERS} of {} must be a table", parts.join("/"));
                return Err((node.line, why));
            }
            (Value::Table(entries), _) => {
                let n = parts.len();
                parts.extend(
                    key.split('/')
                        .filter(|it| !it.is_empty())
                        .map(str::to_owned),
                );
                if parts.len() > PARTS_MAX {
                    let why = format!("the name of a node has more than {PARTS_MAX} parts");
                    return Err((node.line, why));
                }
                gather(entries, parts, sections)?;
                parts.truncate(n);
            }
            _ => {}
        }
    }
    Ok(())
}

fn flatten(above: &str, entries: &[(String, Node)], parameters: &mut Vec<Parameter>) {
    for (key, node) in entries {
        let name = if above.is_empty() {
            key.clone()
        } else {
            format!("{above}.{key}")
        };
        match &node.value {
            Value::Table(inner) => flatten(&name, inner, parameters),
            value => parameters.push(Parameter {
                name,
                value: value.clone(),
                line: node.line,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nav2::yaml;

    fn sections(text: &str) -> Result<Sections, (u64, String)> {
        Sections::of(&yaml::read(text).expect("YAML"))
    }

    #[test]
    fn the_last_section_that_means_a_node_counts_whatever_its_wildcard() {
        let given = sections(
            "/**:\n  ros__parameters: {use_sim_time: true, a: 1}\n\
             robot1:\n  controller_server:\n    ros__parameters:\n      a: 2\n      F.b: 3\n\
             \u{20}     F: {c: 4}\n\
             /local_costmap/*:\n  ros__parameters: {a: 5}\n\
             '*':\n  ros__parameters: {d: 6}\n",
        )
        .expect("sections");
        let number = |node, name| match given.get(node, name).map(|it| &it.value) {
            Some(Value::Number(it)) => Some(*it),
            _ => None,
        };
        assert_eq!(number("controller_server", "a"), Some(2.0));
        assert_eq!(number("controller_server", "F.b"), Some(3.0));
        assert_eq!(number("controller_server", "F.c"), Some(4.0));
        assert_eq!(number("planner_server", "a"), Some(1.0));
        assert_eq!(number("local_costmap/local_costmap", "a"), Some(5.0));
        assert_eq!(number("planner_server", "d"), Some(6.0));
        assert_eq!(number("local_costmap/local_costmap", "d"), None);
        assert_eq!(given.places("controller_server", "a").len(), 2);
        assert_eq!(given.namespace("controller_server"), "/robot1");
        assert!(given.names("controller_server") && !given.names("planner_server"));
    }

    #[test]
    fn what_is_no_parameter_file_is_rejected_with_its_line() {
        for (text, line, word) in [
            ("- 1\n- 2\n", 1, "no table"),
            ("a:\n  b: 1\n", 1, "no ros__parameters"),
            ("image: a.pgm\nresolution: 0.05\n", 1, "--map"),
            ("rosbag2_bagfile_information: {version: 5}\n", 1, "folder"),
            ("amcl:\n  ros__parameters: 3\n", 2, "must be a table"),
            ("a/b/c/d/e/f/g/h/i/j/k/l/m/n/o/p/q:\n  r: 1\n", 2, "parts"),
        ] {
            let (at, why) = sections(text).expect_err(text);
            assert_eq!(at, line, "{text}: {why}");
            assert!(why.contains(word), "{text}: {why}");
        }
    }
}
