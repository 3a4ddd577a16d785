//! The runs of a suite as test cases for a build server, in the `JUnit` format.

use super::row::Row;
use core::fmt::Write;
use zeronav_console::svg::escape;

/// One test case a run; a run that is no success is a failure with its cause.
#[must_use]
pub(super) fn text(suite: &str, rows: &[Row]) -> String {
    let failures = rows.iter().filter(|row| !row.success).count();
    let time_s: f64 = rows.iter().filter_map(|row| row.time_s).sum();
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n");
    let _ = writeln!(
        text,
        "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{failures}\" errors=\"0\" time=\"{time_s:.3}\">",
        escape(suite),
        rows.len()
    );
    for row in rows {
        let _ = write!(
            text,
            "    <testcase classname=\"{}\" name=\"{} seed {}\" time=\"{:.3}\"",
            escape(suite),
            escape(&row.world),
            row.seed,
            row.time_s.unwrap_or(0.0)
        );
        let _ = match &row.cause {
            None => writeln!(text, "/>"),
            Some(cause) => writeln!(
                text,
                "><failure message=\"{}\">{}</failure></testcase>",
                escape(cause),
                escape(row.directory.as_deref().unwrap_or_default())
            ),
        };
    }
    text + "  </testsuite>\n</testsuites>\n"
}

#[cfg(test)]
mod tests {
    use zeronav_console::svg::escape;

    #[test]
    fn what_xml_reserves_is_escaped() {
        assert_eq!(
            escape("a<b & \"c\"\u{1b}>"),
            "a&lt;b &amp; &quot;c&quot;\\u{1b}&gt;"
        );
    }
}
