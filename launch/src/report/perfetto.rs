//! The button that opens the trace of a run in Perfetto.
//!
//! A page that was opened from a file cannot read the file beside it, so the trace lies in the page,
//! compressed. Where it is too large for that, the reader chooses the file first.

use super::folder::{RunFolder, read_text};
use super::html::{note, section, text_of};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write as _;

/// Name of the trace in the folder of a run.
const FILE: &str = "trace.json";

/// The page that draws traces.
const PAGE: &str = "https://ui.perfetto.dev";

/// The script behind the button.
pub(super) const PERFETTO_JS: &str = include_str!("page/perfetto.js");

/// The section with the trace in it, and the same without it, for pages that have no room.
#[derive(Debug, Default)]
pub(super) struct TraceSection {
    pub with_data: String,
    pub without_data: String,
}

/// The section about the trace; empty when the run left none.
pub(super) fn trace_section(run: &RunFolder) -> TraceSection {
    let file = run.path.join(FILE);
    if !file.exists() {
        return TraceSection::default();
    }
    let data = read_text(&file).ok().and_then(|text| packed(&text));
    let choose = format!(
        "<p>The trace is not in this page, which would be too large: choose {FILE} beside it. \
         <input id=\"trace-file\" type=\"file\" accept=\".json\" aria-label=\"{FILE}\"></p>\n"
    );
    let without_data = html(run, &choose);
    let with_data = data.map_or_else(
        || without_data.clone(),
        |data| {
            let data = format!("<script type=\"text/plain\" id=\"trace-data\">{data}</script>\n");
            html(run, &data)
        },
    );
    TraceSection {
        with_data,
        without_data,
    }
}

fn html(run: &RunFolder, source: &str) -> String {
    let title = format!("{}, {}", run.scenario(), run.name());
    let about = note(
        "Every cycle of every process with its stages, how long each message lay before its reader, \
         and flows from scan to wheel. Perfetto comes from the network; the trace goes to its window \
         on this machine and nowhere else. Perfetto asks first whether to trust an unknown origin: \
         that is this file.",
    );
    let body = format!(
        "<p><button id=\"perfetto\" data-page=\"{PAGE}\" data-title=\"{}\">Open in Perfetto</button> \
         <a href=\"{FILE}\">{FILE}</a> <output id=\"perfetto-said\" class=\"quiet\"></output></p>\n\
         {about}{source}<script>\n{PERFETTO_JS}</script>\n",
        text_of(&title)
    );
    section("trace", "Trace", &body)
}

/// Compressed, as text.
fn packed(text: &str) -> Option<String> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(text.as_bytes()).ok()?;
    Some(STANDARD.encode(encoder.finish().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::read::GzDecoder;
    use std::io::Read as _;

    #[test]
    fn what_is_packed_is_unpacked_to_the_same() {
        let text = "{\"traceEvents\":[{\"name\":\"</script>\"}]}".repeat(1000);
        let packed = packed(&text).expect("packed");
        assert!(!packed.contains('<') && packed.len() < text.len() / 10);
        let bytes = STANDARD.decode(packed).expect("base64");
        let mut back = String::new();
        let read = GzDecoder::new(bytes.as_slice()).read_to_string(&mut back);
        assert!(read.is_ok() && back == text);
    }
}
