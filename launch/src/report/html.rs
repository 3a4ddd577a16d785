//! Elements of a page.

use core::fmt::Write;
use zeronav_casts::Cast;
use zeronav_console::svg::escape;
use zeronav_shell::printable::printable_json;

/// Longest text of a cell. [characters]
const TEXT_MAX: usize = 400;

/// Rows of a table at most: the first and the last ones of more.
const ROWS_MAX: usize = 300;

/// What stands in a cell.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cell {
    /// Text from anywhere.
    Text(String),
    /// A number, aligned to the right.
    Number(String),
    /// HTML that this room has made.
    Html(String),
}

impl Cell {
    /// A text.
    pub(super) fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// A number with these digits after the point; a dash for none.
    pub(super) fn number(value: impl Into<Option<f64>>, digits: usize) -> Self {
        Self::Number(number(value, digits))
    }

    /// A count.
    pub(super) fn count(value: impl core::fmt::Display) -> Self {
        Self::Number(value.to_string())
    }

    /// A time, which moves the player when it is pressed. [s]
    pub(super) fn moment(time_s: f64) -> Self {
        let time_s = if time_s.is_finite() { time_s } else { 0.0 };
        Self::Html(format!(
            "<a class=\"t\" href=\"#player\" data-t=\"{time_s:.3}\">{time_s:.2}&nbsp;s</a>"
        ))
    }

    fn write(&self, html: &mut String) {
        let _ = match self {
            Self::Text(text) => write!(html, "<td>{}</td>", text_of(text)),
            Self::Number(text) => write!(html, "<td class=\"n\">{}</td>", text_of(text)),
            Self::Html(made) => write!(html, "<td>{made}</td>"),
        };
    }
}

/// A text as HTML, cut when it is very long.
pub(super) fn text_of(text: &str) -> String {
    // What a terminal or a browser could obey or hide.
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    match text.char_indices().nth(TEXT_MAX) {
        Some((end, _)) => escape(&text[..end].replace(|c: char| c.is_control(), " ")) + "…",
        None => escape(&text.chars().map(plain).collect::<String>()),
    }
}

/// A number with these digits after the point; a dash for none.
pub(super) fn number(value: impl Into<Option<f64>>, digits: usize) -> String {
    match value.into().filter(|value| value.is_finite()) {
        Some(value) => format!("{value:.digits$}"),
        None => "–".to_owned(),
    }
}

/// A time in a unit that fits. Given in microseconds.
pub(super) fn time(us: impl Into<Option<f64>>) -> String {
    match us.into().filter(|us| us.is_finite()) {
        None => "–".to_owned(),
        Some(us) if us.abs() < 9.95 => format!("{us:.1} µs"),
        Some(us) if us.abs() < 999.5 => format!("{us:.0} µs"),
        Some(us) if us.abs() < 9_995.0 => format!("{:.2} ms", us / 1.0e3),
        Some(us) if us.abs() < 99_950.0 => format!("{:.1} ms", us / 1.0e3),
        Some(us) if us.abs() < 999_500.0 => format!("{:.0} ms", us / 1.0e3),
        Some(us) => format!("{:.2} s", us / 1.0e6),
    }
}

/// Bytes as megabytes.
pub(super) fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes.to_f64() / 1.0e6)
}

/// A word of the contract as words.
pub(super) fn words(label: &str) -> String {
    label.replace('_', " ")
}

/// A table; heads that begin with `#` stand over numbers. Nothing without rows.
pub(super) fn table(heads: &[&str], rows: &[Vec<Cell>]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let mut html = "<div class=\"scroll\"><table><thead><tr>".to_owned();
    for head in heads {
        let _ = match head.strip_prefix('#') {
            Some(head) => write!(html, "<th class=\"n\">{}</th>", text_of(head)),
            None => write!(html, "<th>{}</th>", text_of(head)),
        };
    }
    html.push_str("</tr></thead><tbody>\n");
    let left_out = rows.len().saturating_sub(ROWS_MAX);
    let first = ROWS_MAX / 2;
    for (at, row) in rows.iter().enumerate() {
        if left_out > 0 && at == first {
            let _ = writeln!(
                html,
                "<tr><td class=\"quiet\" colspan=\"{}\">{left_out} more</td></tr>",
                heads.len()
            );
        }
        if left_out > 0 && (first..first + left_out).contains(&at) {
            continue;
        }
        html.push_str("<tr>");
        for cell in row {
            cell.write(&mut html);
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody></table></div>\n");
    html
}

/// A part of the page; nothing when it has no body.
pub(super) fn section(id: &str, title: &str, body: &str) -> String {
    if body.is_empty() {
        return String::new();
    }
    format!("<section id=\"{id}\"><h2>{title}</h2>\n{body}</section>\n")
}

/// A quiet sentence.
pub(super) fn note(text: &str) -> String {
    format!("<p class=\"quiet\">{}</p>\n", text_of(text))
}

/// Names and values side by side.
pub(super) fn pairs(pairs: &[(&str, String)]) -> String {
    let mut html = "<dl>".to_owned();
    for (name, value) in pairs {
        let _ = write!(
            html,
            "<div><dt>{name}</dt><dd>{}</dd></div>",
            text_of(value)
        );
    }
    html.push_str("</dl>\n");
    html
}

/// A text of JSON as it may stand in a `script` element: no `<` ends the element early, and nothing in it
/// is obeyed by who reads the page as text.
pub(super) fn json_in_script(json: &str) -> String {
    printable_json(json).replace('<', "\\u003c")
}

/// A whole page. `body` is HTML that this room has made.
pub(super) fn document(title: &str, body: &str) -> String {
    const STYLE: &str = include_str!("page/style.css");
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:\">\n\
         <link rel=\"icon\" href=\"data:,\">\n\
         <title>{}</title>\n<style>\n{STYLE}</style></head>\n<body>\n{body}</body></html>\n",
        text_of(title)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_wherever_it_stands() {
        let evil = "</script><script>alert(1)</script>\u{1b}[2J\u{202e}";
        let page = document(
            evil,
            &(table(
                &["what"],
                &[vec![Cell::text(evil)], vec![Cell::Number(evil.into())]],
            ) + &note(evil)
                + &pairs(&[("name", evil.to_owned())])),
        );
        assert!(!page.contains("<script>alert"), "{page}");
        assert!(!page.contains(['\u{1b}', '\u{202e}']), "{page}");
        assert_eq!(page.matches("&lt;/script&gt;").count(), 10);
        assert!(!json_in_script("{\"a\":\"</script>\u{202e}\"}").contains(['<', '\u{202e}']));
        let back: serde_json::Value =
            serde_json::from_str(&json_in_script("\"</script>\u{2028}\"")).expect("JSON");
        assert_eq!(back, "</script>\u{2028}");
    }

    #[test]
    fn long_texts_and_tables_are_cut() {
        let long = "ä".repeat(100_000);
        assert_eq!(text_of(&long).chars().count(), TEXT_MAX + 1);
        let rows: Vec<Vec<Cell>> = (0..100_000).map(|n| vec![Cell::count(n)]).collect();
        let html = table(&["#n"], &rows);
        assert_eq!(html.matches("<tr>").count(), ROWS_MAX + 2);
        for kept in [">0<", ">149<", ">99850<", ">99999<", ">99700 more<"] {
            assert!(html.contains(kept), "{kept}");
        }
        assert!(!html.contains(">150<"));
    }

    #[test]
    fn times_have_a_unit_that_fits() {
        let texts = [0.04, 9.96, 430.4, 999.6, 1629.0, 21_660.0, 105_000.0, 5.0e6].map(time);
        let expected = [
            "0.0 µs", "10 µs", "430 µs", "1.00 ms", "1.63 ms", "21.7 ms", "105 ms", "5.00 s",
        ];
        assert_eq!(texts, expected);
        assert_eq!(time(f64::NAN), "–");
        assert_eq!(time(None), "–");
    }
}
