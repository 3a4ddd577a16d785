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

/// A reader that is only opened when it is asked for.
impl<T: Input> Input for Option<T> {
    fn refused(&self) -> u64 {
        self.as_ref().map_or(0, Input::refused)
    }

    fn superseded(&self) -> u64 {
        self.as_ref().map_or(0, Input::superseded)
    }
}
