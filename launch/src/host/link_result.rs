//! What the link has counted: it keeps a file in the domain's root folder.

use std::path::Path;
use zeronav_files::read;
use zeronav_measure::result::link::LinkResult;
use zeronav_shell::remote_seats::LINK_REPORT;

/// Longest file. [bytes]
const BYTES_MAX: u64 = 64 * 1024;

/// The newest counts of the link of this host; `None` without a link, and while it has counted nothing.
pub(crate) fn link_result(root: &Path) -> Option<LinkResult> {
    let text = read::text(&root.join(LINK_REPORT), BYTES_MAX).ok()?;
    match serde_json::from_str(&text) {
        Ok(result) => Some(result),
        Err(error) => {
            tracing::warn!(%error, "what the link has counted cannot be read");
            None
        }
    }
}
