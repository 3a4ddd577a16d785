//! Version and commit of this build.

/// The version, and the commit when it was built from a checkout: `0.1.0 (commit 0123456789)`.
pub const VERSION: &str = env!("ZERONAV_VERSION");
