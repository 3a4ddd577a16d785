//! Tokens of a source file without its test code.

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};
use std::path::Path;
use std::str::FromStr;

/// The tokens of a source file. Comments are gone; doc comments are attributes.
///
/// # Panics
/// When the file cannot be read or is no Rust.
pub(super) fn of_file(file: &Path) -> Vec<TokenTree> {
    let text =
        std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let stream =
        TokenStream::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    stream.into_iter().collect()
}

/// `tokens` without the items under `#[cfg(test)]`.
pub(super) fn without_tests(tokens: Vec<TokenTree>) -> Vec<TokenTree> {
    let mut kept = Vec::with_capacity(tokens.len());
    let mut tokens = tokens.into_iter().peekable();
    while let Some(token) = tokens.next() {
        let is_attribute = is_punct(&token, '#')
            && matches!(tokens.peek(), Some(TokenTree::Group(group)) if is_cfg_test(group));
        if !is_attribute {
            kept.push(token);
            continue;
        }
        // An item ends with its body or with a semicolon.
        for skipped in tokens.by_ref() {
            let body = matches!(&skipped, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace);
            if body || is_punct(&skipped, ';') {
                break;
            }
        }
    }
    kept
}

/// True for `[cfg(test)]` and `[cfg(all(test, ..))]`.
fn is_cfg_test(attribute: &Group) -> bool {
    let words: String = attribute.stream().to_string().split_whitespace().collect();
    words.starts_with("cfg(test)") || words.starts_with("cfg(all(test,")
}

/// True for this punctuation.
pub(super) fn is_punct(token: &TokenTree, character: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == character)
}

/// The text of an identifier.
pub(super) fn ident(token: &TokenTree) -> Option<String> {
    match token {
        TokenTree::Ident(ident) => Some(ident.to_string()),
        _ => None,
    }
}
