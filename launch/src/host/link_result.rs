//! What the link has counted: it keeps a file in the domain's root folder.

use std::io::ErrorKind;
use std::path::Path;
use zeronav_files::read;
use zeronav_measure::result::link::LinkResult;
use zeronav_shell::remote_seats::LINK_REPORT;

/// Longest file. [bytes]
const BYTES_MAX: u64 = 64 * 1024;

/// The newest counts of the link of this host; `None` without a link, and while it has counted nothing.
pub(crate) fn link_result(root: &Path) -> Option<LinkResult> {
    let text = match read::text(&root.join(LINK_REPORT), BYTES_MAX) {
        Err(error) if error.kind() == ErrorKind::NotFound => return None,
        text => text,
    };
    let result = text.and_then(|text| Ok(serde_json::from_str(&text)?));
    let warn = |error: &std::io::Error| tracing::warn!(%error, "what the link has counted");
    result.inspect_err(warn).ok()
}
