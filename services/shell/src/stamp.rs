//! How old a message is.

use zeronav_msgs::header::Header;

/// When a message was captured and when it came in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stamp {
    /// Tick.
    pub tick: u64,
    /// Run time. [ns]
    pub run_ns: u64,
    /// Capture of the newest sensor data in it, monotonic, as its author says. [ns]
    pub capture_ns: u64,
    /// When it came in, by this process's own clock. [ns]
    pub came_ns: u64,
}

impl Stamp {
    /// The stamp of a message that came in at `came_ns`.
    #[must_use]
    pub fn of(header: &Header, came_ns: u64) -> Self {
        Self {
            tick: header.tick,
            run_ns: header.run_ns,
            capture_ns: header.capture_ns,
            came_ns,
        }
    }
}
