//! Text in lines of bounded length.

use core::fmt::Write;

/// Longest line. [characters]
const WIDTH: usize = 99;

/// A doc comment without the links of Rust, in one line.
pub(crate) fn plain(doc: &str) -> String {
    let words: Vec<&str> = doc.split_whitespace().collect();
    words.join(" ").replace("[`", "`").replace("`]", "`")
}

/// Adds `words` in lines that begin with `indent`, the further ones with `hang` behind it.
pub(crate) fn wrap(text: &mut String, words: &str, indent: &str, hang: &str) {
    let mut line = indent.to_owned();
    let mut n_words = 0;
    for word in words.split(' ') {
        let length = line.chars().count() + word.chars().count();
        if length > WIDTH && n_words > 0 {
            let _ = writeln!(text, "{}", line.trim_end());
            line = format!("{indent}{hang}");
            n_words = 0;
        }
        line.push_str(word);
        line.push(' ');
        n_words += 1;
    }
    let _ = writeln!(text, "{}", line.trim_end());
}
