//! What a reader counts for the heartbeat.

/// A reader of one or more topics.
pub trait Input {
    /// Messages that were rejected since the start.
    fn refused(&self) -> u64;

    /// Messages that were superseded before they were used, since the start.
    fn superseded(&self) -> u64 {
        0
    }
}
