//! The contract for other languages is that of this build.

#[path = "../examples/bindings/contract.rs"]
mod contract;
#[path = "../examples/bindings/cpp.rs"]
mod cpp;
#[path = "../examples/bindings/python.rs"]
mod python;
#[path = "../examples/bindings/words.rs"]
mod words;

use std::path::Path;

fn kept(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn the_bindings_are_current() {
    let contract = contract::Contract::new();
    for (file, text) in [
        (python::FILE, python::text(&contract)),
        (cpp::FILE, cpp::text(&contract)),
    ] {
        let current = kept(file) == text;
        assert!(
            current,
            "{file} is not current: cargo run -p zeronav-tests --bin zeronav-regenerate"
        );
    }
}
