//! The exit codes of `zeronav`.

/// The expectations of the scenario were met.
pub const EXIT_PASS: u8 = 0;
/// An expectation was not met.
pub const EXIT_FAIL: u8 = 1;
/// Usage or configuration.
pub const EXIT_USAGE: u8 = 2;
/// A service exceeded its restart budget.
pub const EXIT_SERVICE: u8 = 3;
/// A result could not be written to a file or to standard output.
pub const EXIT_OUTPUT: u8 = 4;
/// Interrupted.
pub const EXIT_INTERRUPTED: u8 = 130;
