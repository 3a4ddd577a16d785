//! When this command began.

use std::sync::OnceLock;
use zeronav_shell::clock::now_ns;

static BEGAN_NS: OnceLock<u64> = OnceLock::new();

/// Notes that the command begins now. Called first of all.
pub fn note() {
    let _ = at_ns();
}

/// When it began, monotonic; the first question when nobody noted it. [ns]
#[must_use]
pub(crate) fn at_ns() -> u64 {
    *BEGAN_NS.get_or_init(now_ns)
}
