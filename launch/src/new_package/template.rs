//! What a new package begins as: an example of this source tree, under another name.

use super::name::Name;
use clap::ValueEnum;
use zeronav_msgs::role::Role;

/// A language that a seat can be written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Language {
    /// Rust, with the shell as a library.
    Rust,
    /// Python 3.11 or later, with the package `zeronav`.
    Python,
    /// C++17, with the shell as a static library.
    Cpp,
}

/// An example of a seat.
#[derive(Debug)]
pub(crate) struct Template {
    pub role: Role,
    pub language: Language,
    /// Its text.
    source: &'static str,
    /// The type in it that takes the package's name.
    type_name: &'static str,
    /// The string in it that takes the package's name, without quotes.
    key: Option<&'static str>,
    /// Packages of the source tree that it needs beside the contract and the shell: name and folder.
    pub packages: &'static [(&'static str, &'static str)],
    /// Packages of the registry that it needs, as lines of a manifest.
    pub registry: &'static str,
}

/// Every seat and language that there is an example of.
pub(crate) const TEMPLATES: [Template; 8] = [
    Template {
        role: Role::GlobalPlanner,
        language: Language::Rust,
        source: include_str!("../../../services/shell/examples/own_planner/src/main.rs"),
        type_name: "OwnPlanner",
        key: Some("own_planner"),
        packages: &[],
        registry: "",
    },
    Template {
        role: Role::LocalPlanner,
        language: Language::Rust,
        source: include_str!("../../../tests/src/bin/minimal_local_planner.rs"),
        type_name: "MinimalPlanner",
        key: None,
        packages: &[],
        registry: "",
    },
    Template {
        role: Role::CollisionGuard,
        language: Language::Rust,
        source: include_str!("../../../tests/src/bin/minimal_guard.rs"),
        type_name: "MinimalGuard",
        key: None,
        packages: &[],
        registry: "",
    },
    Template {
        role: Role::Mapping,
        language: Language::Rust,
        source: include_str!("../../../tests/src/bin/minimal_mapping.rs"),
        type_name: "MinimalMapping",
        key: None,
        packages: &[
            ("zeronav-world", "services/world"),
            ("zeronav-world-files", "services/world_files"),
        ],
        registry: "serde = { version = \"1\", features = [\"derive\"] }\n",
    },
    Template {
        role: Role::GlobalPlanner,
        language: Language::Python,
        source: include_str!("../../../services/python/examples/astar.py"),
        type_name: "AStar",
        key: Some("astar_py"),
        packages: &[],
        registry: "",
    },
    Template {
        role: Role::LocalPlanner,
        language: Language::Python,
        source: include_str!("../../../services/python/examples/pure_pursuit.py"),
        type_name: "PurePursuit",
        key: None,
        packages: &[],
        registry: "",
    },
    Template {
        role: Role::CollisionGuard,
        language: Language::Python,
        source: include_str!("../../../services/python/examples/guard.py"),
        type_name: "Guard",
        key: None,
        packages: &[],
        registry: "",
    },
    Template {
        role: Role::CollisionGuard,
        language: Language::Cpp,
        source: include_str!("../../../services/cpp/examples/guard.cpp"),
        type_name: "Guard",
        key: None,
        packages: &[],
        registry: "",
    },
];

impl Template {
    /// The example of a seat in a language.
    ///
    /// # Errors
    /// There is none; those that there are.
    pub(crate) fn find(role: Role, language: Language) -> Result<&'static Self, String> {
        let found = TEMPLATES
            .iter()
            .find(|it| (it.role, it.language) == (role, language));
        found.ok_or_else(|| {
            let of_role = TEMPLATES.iter().filter(|it| it.role == role);
            let languages: Vec<String> = of_role.map(|it| it.language.word()).collect();
            let of_language = TEMPLATES.iter().filter(|it| it.language == language);
            let roles: Vec<&str> = of_language.map(|it| it.role.label()).collect();
            format!(
                "there is no {role} in {} to begin with: {role} is there in {}, and {} has {}",
                language.word(),
                listed(&languages),
                language.word(),
                listed(&roles),
            )
        })
    }

    /// The name of the service's type in a package of this name. A name that the example uses for
    /// something else is told apart.
    pub(crate) fn type_name(&self, name: &Name) -> String {
        let wished = name.type_name();
        let taken = wished != self.type_name && words(self.source).any(|word| word == wished);
        if taken {
            format!("Own{wished}")
        } else {
            wished
        }
    }

    /// The example's text, with the package's name in place of its own.
    pub(crate) fn text(&self, name: &Name) -> String {
        let text = with_word(self.source, self.type_name, &self.type_name(name));
        match self.key {
            Some(key) => text.replace(&format!("\"{key}\""), &format!("\"{}\"", name.as_str())),
            None => text,
        }
    }
}

impl Language {
    /// Its name on the command line.
    fn word(self) -> String {
        let value = self.to_possible_value();
        value.map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

fn listed<T: AsRef<str>>(words: &[T]) -> String {
    let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
    if words.is_empty() {
        "nothing yet".to_owned()
    } else {
        words.join(", ")
    }
}

/// The words of a text in any of the languages.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|letter: char| !letter.is_alphanumeric() && letter != '_')
}

/// The text with a whole word replaced wherever it stands.
fn with_word(text: &str, from: &str, to: &str) -> String {
    let mut made = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(from) {
        let (before, after) = (&rest[..at], &rest[at + from.len()..]);
        let joins = |letter: char| letter.is_alphanumeric() || letter == '_';
        let is_word = !before.ends_with(joins) && !after.starts_with(joins);
        made.push_str(before);
        made.push_str(if is_word { to } else { from });
        rest = after;
    }
    made + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_example_names_its_type_and_its_key() {
        let mut seen = BTreeSet::new();
        let name = Name::new("quite_another").unwrap();
        for it in &TEMPLATES {
            assert!(seen.insert(format!("{} {:?}", it.role, it.language)));
            assert!(
                words(it.source).any(|word| word == it.type_name),
                "{}",
                it.type_name
            );
            let text = it.text(&name);
            assert!(
                words(&text).all(|word| word != it.type_name),
                "{}",
                it.type_name
            );
            assert!(words(&text).any(|word| word == "QuiteAnother"));
            if let Some(key) = it.key {
                assert!(it.source.contains(&format!("\"{key}\"")), "{key}");
                assert!(text.contains("\"quite_another\""), "{key}");
            }
        }
    }

    #[test]
    fn a_name_that_the_example_uses_is_told_apart() {
        let planner = Template::find(Role::GlobalPlanner, Language::Rust).unwrap();
        assert_eq!(planner.type_name(&Name::new("path").unwrap()), "OwnPath");
        assert_eq!(
            planner.type_name(&Name::new("own_planner").unwrap()),
            "OwnPlanner"
        );
    }

    #[test]
    fn only_whole_words_are_replaced() {
        assert_eq!(
            with_word("Guard Guards x_Guard run<Guard>", "Guard", "G"),
            "G Guards x_Guard run<G>"
        );
    }

    #[test]
    fn what_is_not_there_is_answered_with_what_is() {
        let why = Template::find(Role::Robot, Language::Cpp).unwrap_err();
        assert!(why.contains("nothing yet"), "{why}");
    }
}
