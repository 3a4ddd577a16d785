//! What is known besides what the stages said.

/// What is known of the stack at a moment besides what its stages said.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Around {
    /// Run time is held.
    pub paused: bool,
    /// The run is ending.
    pub stopping: bool,
    /// Services that do not answer, and why, as far as that is known.
    pub missing: Vec<Missing>,
    /// Faults that were made on purpose and go on.
    pub faults: Vec<String>,
}

/// A service that does not answer.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Missing {
    /// Its seat.
    pub role: String,
    /// How its process ended and when, or that it only does not answer.
    pub how: String,
}
