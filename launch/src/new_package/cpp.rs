//! A package in C++17: one file, and a `Makefile` that links it with the shell of the sources.

use super::name::Name;
use super::place::Text;
use super::sources::Sources;
use super::template::Template;

/// Where `make` puts the program.
pub(crate) fn binary(name: &Name) -> String {
    format!("./{}", name.as_str())
}

/// What builds it, in its folder.
pub(crate) const BUILD: &str = "make";

/// What git ignores.
pub(crate) fn ignored(name: &Name) -> String {
    format!("/{}\n/runs\n", name.as_str())
}

/// The files.
///
/// # Errors
/// The sources are no folder that a `Makefile` can name.
pub(crate) fn files(
    template: &Template,
    name: &Name,
    sources: &Sources,
) -> Result<Vec<Text>, String> {
    let Sources::Folder(folder) = sources else {
        return Err(
            "--zeronav: C++ needs the sources in a folder: clone them, and name it".to_owned(),
        );
    };
    let root = folder.to_string_lossy();
    let plain = |letter: char| letter.is_ascii_alphanumeric() || "/-_.+,@".contains(letter);
    if !root.chars().all(plain) {
        return Err(format!(
            "{root}: `make` needs a path of letters, digits and -_.+,@ to the sources of zeronav"
        ));
    }
    let word = name.as_str();
    let makefile = format!(
        "# The sources of zeronav: its header, and its shell as a static library.\n\
         ZERONAV ?= {root}\n\
         CARGO_TARGET_DIR ?= $(ZERONAV)/target\n\
         LIBRARY := $(CARGO_TARGET_DIR)/debug/libzeronav_cpp.a\n\
         CXXFLAGS ?= -O2 -Wall -Wextra\n\n\
         {word}: {word}.cpp $(LIBRARY)\n\
         \t$(CXX) -std=c++17 $(CXXFLAGS) -I $(ZERONAV)/services/cpp $^ -lpthread -ldl -lm -o $@\n\n\
         # cargo knows whether it is up to date.\n\
         $(LIBRARY): always\n\
         \tcargo build --manifest-path $(ZERONAV)/Cargo.toml --workspace --lib --locked --target-dir $(CARGO_TARGET_DIR) $(CARGOFLAGS)\n\n\
         always:\n\n\
         .PHONY: always\n"
    );
    Ok(vec![
        ("Makefile".into(), makefile),
        (format!("{word}.cpp").into(), template.text(name)),
    ])
}

#[cfg(test)]
mod tests {
    use super::super::template::{Language, TEMPLATES};
    use super::*;

    #[test]
    fn a_makefile_names_a_folder_of_plain_letters() {
        let name = Name::new("mine").unwrap();
        let template = TEMPLATES
            .iter()
            .find(|it| it.language == Language::Cpp)
            .unwrap();
        let of = |sources: Sources| files(template, &name, &sources);
        assert!(of(Sources::Folder("/srv/zeronav".into())).is_ok());
        assert!(of(Sources::Folder("/srv/zero nav".into())).is_err_and(|why| why.contains("make")));
        let git = Sources::Git {
            url: "https://example.org/z".to_owned(),
            commit: None,
        };
        assert!(of(git).is_err_and(|why| why.contains("clone")));
    }
}
