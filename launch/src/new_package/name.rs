//! The name of a package: a word that every language, file system and message takes.

use std::path::Path;

/// Longest name: what a path in `plan/path` has room for. [bytes]
const LENGTH_MAX: usize = 24;

/// Words that mean something else to a compiler, an interpreter or cargo.
const RESERVED: &str = "abstract alignas alignof alloc and as assert async auto await become bool box \
    break build case catch char class const continue core crate decltype def default del delete deps do \
    double dyn elif else enum examples except explicit export extern false final finally float fn for \
    friend from gen global goto if impl import in incremental inline int is iceoryx2 lambda let long \
    loop macro main match mod move mut mutable namespace new noexcept none nonlocal not nullptr numpy \
    operator or override pass pip priv private proc_macro protected public pub raise ref register return \
    self setuptools short signed sizeof static std struct super switch template test this thread_local \
    throw trait true try type typedef typeid typename typeof union unsafe unsigned unsized use using \
    virtual void volatile wheel where while with xor yield";

/// A name that was checked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Name(String);

impl Name {
    /// Checks a name that was typed.
    ///
    /// # Errors
    /// Why it is none.
    pub(crate) fn new(text: &str) -> Result<Self, String> {
        let starts = text.starts_with(|first: char| first.is_ascii_lowercase());
        let word =
            |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '_';
        if !starts || !text.chars().all(word) {
            return Err(format!(
                "`{text}` is no name of a package: a letter, then letters, digits and underscores, all \
                 small; --name names it otherwise than its folder"
            ));
        }
        if text.len() > LENGTH_MAX {
            return Err(format!(
                "`{text}`: a name has {LENGTH_MAX} letters at most; --name gives another"
            ));
        }
        if RESERVED.split_whitespace().any(|word| word == text) || text.starts_with("zeronav") {
            return Err(format!(
                "`{text}` is taken by a language or by zeronav; --name gives another"
            ));
        }
        Ok(Self(text.to_owned()))
    }

    /// The name of a package in `folder`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn of(folder: &Path) -> Result<Self, String> {
        let last = folder.file_name().and_then(|name| name.to_str());
        Self::new(last.unwrap_or_default())
    }

    /// As it was typed.
    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }

    /// As the name of a type.
    pub(crate) fn type_name(&self) -> String {
        let upper = |part: &str| {
            let mut letters = part.chars();
            let first = letters.next().map(|letter| letter.to_ascii_uppercase());
            first.into_iter().chain(letters).collect::<String>()
        };
        self.0.split('_').map(upper).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_a_word_that_is_free_everywhere() {
        assert_eq!(
            Name::new("my_planner2").map(|name| name.type_name()),
            Ok("MyPlanner2".to_owned())
        );
        assert!(Name::new(&"a".repeat(LENGTH_MAX)).is_ok());
        for (wrong, why) in [
            ("", "no name"),
            ("my-planner", "--name"),
            ("MyPlanner", "all small"),
            ("2nd", "no name"),
            ("_x", "no name"),
            ("pl\u{e4}ner", "no name"),
            ("../x", "no name"),
            ("class", "taken"),
            ("zeronav_shell", "taken"),
            ("a_name_of_twenty_five_lett", "24"),
        ] {
            let said = Name::new(wrong).expect_err(wrong);
            assert!(said.contains(why), "{wrong}: {said}");
        }
        assert!(Name::of(Path::new("/")).is_err());
    }
}
