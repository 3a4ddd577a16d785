//! What a `zeronav` that goes on has said so far.

use crate::Zeronav;
use std::os::fd::AsRawFd;

impl Zeronav {
    /// True once its standard output holds `text`.
    ///
    /// # Panics
    /// When it cannot be read.
    #[must_use]
    pub fn has_said(&self, text: &str) -> bool {
        // Opened anew: the handle's own position is that of the writer.
        let file = std::fs::read(format!("/proc/self/fd/{}", self.stdout.as_raw_fd()));
        String::from_utf8_lossy(&file.expect("its output")).contains(text)
    }
}
