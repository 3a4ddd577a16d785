//! The paths that a module's code names, and what its `use` lines import.

use super::tokens::{ident, is_punct};
use proc_macro2::{Delimiter, TokenTree};

/// One name of a `use` line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Import {
    /// The path, segment by segment; `*` is the last segment of a glob.
    pub(super) path: Vec<String>,
    /// The name that it has in this module; empty for a glob.
    pub(super) name: String,
    /// True for `pub use` and `pub(crate) use`.
    pub(super) exported: bool,
}

/// What the code of one module names.
#[derive(Debug, Default)]
pub(super) struct Named {
    /// Imports.
    pub(super) imports: Vec<Import>,
    /// Paths of two segments and more outside `use` lines.
    pub(super) paths: Vec<Vec<String>>,
    /// Every identifier outside `use` lines and `mod` declarations.
    pub(super) words: Vec<String>,
    /// Items that the module declares.
    pub(super) items: Vec<String>,
    /// Child modules: name, the `#[path]` when there is one, and the body of an inline module.
    pub(super) children: Vec<(String, Option<String>, Option<Vec<TokenTree>>)>,
}

/// Reads the tokens of a module.
pub(super) fn read(tokens: &[TokenTree]) -> Named {
    let mut named = Named::default();
    items(tokens, &mut named);
    named
}

/// Reads the items of a module: `use` lines, child modules, declarations; the rest is code.
fn items(tokens: &[TokenTree], named: &mut Named) {
    const DECLARES: [&str; 9] = [
        "fn",
        "struct",
        "enum",
        "trait",
        "type",
        "const",
        "static",
        "union",
        "macro_rules",
    ];
    let mut at = 0;
    let mut exported = false;
    let mut path_attribute = None;
    while at < tokens.len() {
        match ident(&tokens[at]).as_deref() {
            Some("pub") => {
                exported = true;
                at = after_visibility(tokens, at);
                continue;
            }
            Some("use") => {
                let end = tokens[at..].iter().position(|token| is_punct(token, ';'));
                let end = at + end.unwrap_or(tokens.len() - at);
                use_tree(&tokens[at + 1..end], &[], exported, &mut named.imports);
                at = end;
            }
            Some("mod") => {
                let name = tokens.get(at + 1).and_then(ident).unwrap_or_default();
                let body = match tokens.get(at + 2) {
                    Some(TokenTree::Group(group)) => Some(group.stream().into_iter().collect()),
                    _ => None,
                };
                named.children.push((name, path_attribute.take(), body));
                at += 2;
            }
            Some(word) if DECLARES.contains(&word) => {
                // `const fn`, `unsafe fn`: the name follows the last keyword.
                let name = tokens[at + 1..].iter().take(2).filter_map(ident);
                named
                    .items
                    .extend(name.filter(|name| !DECLARES.contains(&name.as_str())));
                at = code(tokens, at, named);
                continue;
            }
            _ => {
                if let Some(path) = path_of_attribute(tokens, at) {
                    path_attribute = Some(path);
                }
                at = code(tokens, at, named);
                continue;
            }
        }
        exported = false;
        at += 1;
    }
}

/// Where the item after the `pub` at `at` begins. `pub(in crate::x)` says where an item is visible,
/// not what it uses.
fn after_visibility(tokens: &[TokenTree], at: usize) -> usize {
    let restricted = matches!(tokens.get(at + 1),
        Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Parenthesis);
    at + 1 + usize::from(restricted)
}

/// The file in `#[path = "file"]` at `at`.
fn path_of_attribute(tokens: &[TokenTree], at: usize) -> Option<String> {
    let (TokenTree::Group(group), true) = (tokens.get(at + 1)?, is_punct(&tokens[at], '#')) else {
        return None;
    };
    let words: Vec<TokenTree> = group.stream().into_iter().collect();
    let is_path = words.first().and_then(ident).as_deref() == Some("path");
    is_path.then(|| {
        words
            .last()
            .map(|text| text.to_string().trim_matches('"').to_owned())
    })?
}

/// Reads one token of code, or one path; returns where the next one begins.
fn code(tokens: &[TokenTree], at: usize, named: &mut Named) -> usize {
    match &tokens[at] {
        TokenTree::Group(group) => {
            let inner: Vec<TokenTree> = group.stream().into_iter().collect();
            // A function can have `use` lines of its own; they count like those of the module.
            if inner
                .iter()
                .any(|token| ident(token).as_deref() == Some("use"))
            {
                items(&inner, named);
            } else {
                let mut next = 0;
                while next < inner.len() {
                    next = code(&inner, next, named);
                }
            }
            at + 1
        }
        TokenTree::Ident(first) if first == "pub" => after_visibility(tokens, at),
        TokenTree::Ident(first) => {
            let mut path = vec![first.to_string()];
            let mut next = at + 1;
            while let (Some(one), Some(two), Some(TokenTree::Ident(segment))) =
                (tokens.get(next), tokens.get(next + 1), tokens.get(next + 2))
                && is_punct(one, ':')
                && is_punct(two, ':')
            {
                path.push(segment.to_string());
                next += 3;
            }
            named.words.extend(path.iter().cloned());
            if path.len() > 1 {
                named.paths.push(path);
            }
            next
        }
        _ => at + 1,
    }
}

/// Adds the names of a `use` tree after `prefix`.
fn use_tree(tokens: &[TokenTree], prefix: &[String], exported: bool, found: &mut Vec<Import>) {
    for branch in tokens.split(|token| is_punct(token, ',')) {
        let mut path = prefix.to_vec();
        let mut name = None;
        let mut has_more = false;
        let mut words = branch.iter().peekable();
        while let Some(token) = words.next() {
            match token {
                TokenTree::Group(group) => {
                    let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                    use_tree(&inner, &path, exported, found);
                    has_more = true;
                }
                TokenTree::Ident(word) if word == "as" => {
                    name = words.next().and_then(ident);
                }
                // `a::{self}` names `a`; at the front it is a path of its own.
                TokenTree::Ident(word) if word == "self" && !path.is_empty() => {}
                TokenTree::Ident(word) => path.push(word.to_string()),
                TokenTree::Punct(punct) if punct.as_char() == '*' => path.push("*".to_owned()),
                _ => {}
            }
        }
        if has_more || path.is_empty() {
            continue;
        }
        let last = path.last().cloned().unwrap_or_default();
        let name = name.unwrap_or_else(|| if last == "*" { String::new() } else { last });
        found.push(Import {
            path,
            name,
            exported,
        });
    }
}
