use super::*;

/// The circles of files of a crate with these files below its root folder.
fn circles(files: &[(&str, &str)]) -> Vec<String> {
    of_files(files).circles()
}

/// A crate with these files below its root folder.
fn of_files(files: &[(&str, &str)]) -> Crate {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let file = folder.path().join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, text).unwrap();
    }
    Crate::read(&folder.path().join("lib.rs"))
}

#[test]
fn folders_that_use_each_other_are_a_circle_of_rooms_though_no_files_are() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        (
            "a.rs",
            "mod one; mod two; pub use one::One; pub use two::Two;",
        ),
        ("a/one.rs", "pub struct One;"),
        ("a/two.rs", "use crate::b::B; pub struct Two(B);"),
        ("b/mod.rs", "mod inner; pub use inner::B;"),
        ("b/inner.rs", "use crate::a::One; pub struct B(One);"),
    ];
    assert!(circles(&files).is_empty());
    let rooms = of_files(&files).circles_of_rooms();
    assert_eq!(rooms, ["a -(B)-> b -(One)-> a"]);
}

#[test]
fn a_circle_is_named_with_its_items() {
    let found = circles(&[
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "use crate::b::{self, B}; pub struct A(B);"),
        ("b.rs", "pub struct B; fn f() { super::c::c() }"),
        ("c.rs", "pub fn c() { let _ = crate::a::A::default(); }"),
    ]);
    assert_eq!(found, ["a.rs -(B)-> b.rs -(c)-> c.rs -(default)-> a.rs"]);
}

#[test]
fn reexports_are_followed_to_the_declaring_file() {
    let found = circles(&[
        ("lib.rs", "mod a; pub mod b; pub use b::Inner;"),
        ("a.rs", "pub use crate::Inner as Renamed;"),
        (
            "b/mod.rs",
            "mod inner; mod other; pub use inner::Inner; pub use other::*;",
        ),
        ("b/inner.rs", "use super::Other; pub struct Inner;"),
        (
            "b/other.rs",
            "use crate::a; pub struct Other; fn g() { a::Renamed; }",
        ),
    ]);
    assert_eq!(
        found,
        ["b/inner.rs -(Other)-> b/other.rs -(Renamed)-> b/inner.rs"]
    );
}

#[test]
fn a_parent_that_uses_its_child_is_in_a_circle_with_it() {
    let child = ("a/b.rs", "use super::A; pub struct B;");
    let uses = "mod b; pub use b::B; pub struct A { b: B }";
    let found = circles(&[("lib.rs", "mod a;"), ("a.rs", uses), child]);
    assert_eq!(found, ["a.rs -(B)-> a/b.rs -(A)-> a.rs"]);
    let exports = "mod b; pub use b::B; pub struct A;";
    assert!(circles(&[("lib.rs", "mod a;"), ("a.rs", exports), child]).is_empty());
}

#[test]
fn tests_comments_strings_and_visibility_are_no_uses() {
    let found = circles(&[
        ("lib.rs", "mod a; mod b;"),
        (
            "a.rs",
            "//! [`crate::b::B`]\nconst S: &str = \"crate::b::B\"; pub(in crate::b) fn f() {}\n\
             struct S { pub(in crate::b) x: u8 }\n\
             #[cfg(test)] mod tests { use crate::b::B; }\n\
             #[cfg(test)] use crate::b::B;",
        ),
        ("b.rs", "use crate::a::f; pub struct B;"),
    ]);
    assert!(found.is_empty(), "{found:?}");
}

#[test]
fn paths_in_macros_closures_and_functions_count() {
    for code in [
        "fn f() { assert!(crate::b::g()); }",
        "fn f() { use crate::b::g; g(); }",
        "use super::b; fn f() { [1].map(|_| b::g()); }",
        "fn f<T: crate::b::G>() {}",
        "use crate::{self as root}; fn f() { root::b::g(); }",
        "use crate::b::*;",
    ] {
        let b = ("b.rs", "pub fn g() { crate::a::f() } pub trait G {}");
        let found = circles(&[("lib.rs", "mod a; mod b;"), ("a.rs", code), b]);
        assert_eq!(found.len(), 1, "{code}");
    }
}
