//! Foreign text as it may be shown on a terminal.
//!
//! File names, names in scenarios, logs of services and answers of a control socket may hold
//! sequences that move the cursor, change colours, clear the screen or reverse the direction of
//! what follows. They are shown, not obeyed.

use std::borrow::Cow;
use std::fmt::Write;

/// `text` on one line, every character that a terminal could obey escaped like `\u{1b}`.
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    escaped(text, |character| is_obeyed(character).then_some(Form::Rust))
}

/// As [`printable`], with the lines of `text` kept.
#[must_use]
pub fn printable_lines(text: &str) -> Cow<'_, str> {
    escaped(text, |character| {
        (character != '\n' && is_obeyed(character)).then_some(Form::Rust)
    })
}

/// An event of a log on one line: as [`printable`], and the line end behind it stays.
#[must_use]
pub fn printable_event(text: &str) -> Cow<'_, str> {
    let Some(line) = text.strip_suffix('\n') else {
        return printable(text);
    };
    match printable(line) {
        Cow::Borrowed(_) => Cow::Borrowed(text),
        Cow::Owned(line) => Cow::Owned(line + "\n"),
    }
}

/// A cell of a table for other programs: [`printable`], and what a spreadsheet would take for a formula
/// begins with an apostrophe. Numbers stay as they are.
#[must_use]
pub fn printable_cell(text: &str) -> Cow<'_, str> {
    let shown = printable(text);
    let is_formula = shown.starts_with(['=', '+', '-', '@']) && shown.parse::<f64>().is_err();
    if is_formula {
        Cow::Owned(format!("'{shown}"))
    } else {
        shown
    }
}

/// A JSON document without characters that a terminal could obey. Outside of strings it has none
/// but line ends, and inside it has no line ends: so `\u001b` always means the same.
#[must_use]
pub fn printable_json(json: &str) -> Cow<'_, str> {
    escaped(json, |character| {
        (character != '\n' && is_obeyed(character)).then_some(Form::Json)
    })
}

/// How a character is written out.
enum Form {
    Rust,
    Json,
}

fn escaped(text: &str, form: impl Fn(char) -> Option<Form>) -> Cow<'_, str> {
    if !text.chars().any(|character| form(character).is_some()) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        match form(character) {
            None => out.push(character),
            Some(Form::Rust) => out.extend(character.escape_default()),
            // All control characters are in the first plane: four digits suffice.
            Some(Form::Json) => {
                let _ = write!(out, "\\u{:04x}", u32::from(character));
            }
        }
    }
    Cow::Owned(out)
}

/// Control characters, what XML does not have, line and paragraph separators, and the marks that turn the direction of text.
fn is_obeyed(character: char) -> bool {
    character.is_control()
        || matches!(
            character,
            '\u{fffe}' | '\u{ffff}' | '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_text_stays_and_what_a_terminal_obeys_is_written_out() {
        assert_eq!(printable("Lager Süd, 3 m²"), "Lager Süd, 3 m²");
        assert_eq!(printable("\u{1b}[2J\u{9b}31m"), "\\u{1b}[2J\\u{9b}31m");
        assert_eq!(printable("a\nb\r\u{7}"), "a\\nb\\r\\u{7}");
        assert_eq!(printable("\u{202e}txt.exe"), "\\u{202e}txt.exe");
        assert_eq!(printable_lines("a\n\u{1b}b"), "a\n\\u{1b}b");
    }

    #[test]
    fn an_event_is_one_line_and_a_cell_no_formula() {
        assert_eq!(printable_event("a\n"), "a\n");
        assert_eq!(printable_event("a\nb\u{1b}\n"), "a\\nb\\u{1b}\n");
        for plain in ["-1.5", "+3", "1e-9", "hall", "", "-inf"] {
            assert_eq!(printable_cell(plain), plain);
        }
        for formula in ["=1+1", "@SUM(A1)", "+cmd|' /C calc'!A0", "-2+3"] {
            assert_eq!(printable_cell(formula), format!("'{formula}"));
        }
    }

    #[test]
    fn json_says_the_same_as_before() {
        let value = serde_json::json!({ "name": "\u{1b}[2J\u{9b}\u{7f}\u{202e}", "n": [1, 2] });
        let text = serde_json::to_string_pretty(&value).unwrap();
        let shown = printable_json(&text);
        assert!(
            !shown.chars().any(|it| it != '\n' && is_obeyed(it)),
            "{shown}"
        );
        let read: serde_json::Value = serde_json::from_str(&shown).unwrap();
        assert_eq!(read, value);
    }
}
