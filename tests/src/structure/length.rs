//! How long files and functions are, and where a longer one gives its reason.

use super::tokens::{ident, of_file};
use proc_macro2::{Delimiter, TokenTree};
use std::path::Path;

/// The comment that gives the reason for a long file or function begins like this.
const REASON: &str = "// long: ";

/// Lines of a file when there are more than `most` and no line of the file gives a reason.
///
/// # Panics
/// When the file cannot be read.
#[must_use]
pub fn long_file(file: &Path, most: usize) -> Option<usize> {
    let text = read(file);
    let lines = text.lines().count();
    let first = text.lines().find(|line| !line.starts_with("//!"));
    let reasoned = first.is_some_and(|line| line.starts_with(REASON));
    (lines > most && !reasoned).then_some(lines)
}

/// Functions of a file with more than `most` lines from `fn` to the closing brace: line, name and
/// number of lines. A comment `// long: reason` in the line above the function, its attributes or
/// its documentation excuses one.
///
/// # Panics
/// When the file cannot be read or is no Rust.
#[must_use]
pub fn long_functions(file: &Path, most: usize) -> Vec<(usize, String, usize)> {
    let text = read(file);
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    functions(&of_file(file), &mut found);
    found.retain(|(line, _, length)| *length > most && !has_reason(&lines, *line));
    found
}

fn read(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// True when a reason is given right above the line with this number, counted from 1.
fn has_reason(lines: &[&str], number: usize) -> bool {
    let above = lines[..number - 1].iter().rev();
    above
        .map(|line| line.trim_start())
        .take_while(|line| !line.is_empty() && !line.ends_with(['{', '}', ';']))
        .any(|line| line.starts_with(REASON))
}

/// Adds every function: line, name, number of lines.
fn functions(tokens: &[TokenTree], found: &mut Vec<(usize, String, usize)>) {
    let mut open: Option<(usize, String)> = None;
    for (at, token) in tokens.iter().enumerate() {
        if ident(token).as_deref() == Some("fn")
            && let Some(name) = tokens.get(at + 1).and_then(ident)
        {
            open = Some((token.span().start().line, name));
        }
        let TokenTree::Group(group) = token else {
            continue;
        };
        let is_body = group.delimiter() == Delimiter::Brace;
        if let (true, Some((line, name))) = (is_body, open.take_if(|_| is_body)) {
            found.push((line, name, group.span_close().end().line + 1 - line));
        }
        let inner: Vec<TokenTree> = group.stream().into_iter().collect();
        functions(&inner, found);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_functions_are_found_with_their_lines() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.rs");
        let text = "fn short() {}\n\nimpl A {\n    pub fn long(\n        &self,\n    ) {\n    }\n}\n\
            // long: a table\n#[must_use]\nfn excused() {\n\n\n\n}\nfn f(g: fn(u8)) {\n\n\n\n}\n";
        std::fs::write(&file, text).unwrap();
        let expected = [(4, "long".to_owned(), 4), (16, "f".to_owned(), 5)];
        assert_eq!(long_functions(&file, 3), expected);
        assert_eq!(long_file(&file, 20), None);
        assert_eq!(long_file(&file, 19), Some(20));
        std::fs::write(&file, format!("//! Doc.\n// long: a table\n{text}")).unwrap();
        assert_eq!(long_file(&file, 19), None);
    }
}
