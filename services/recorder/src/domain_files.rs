//! Files in the folder of a domain by which a recorder and launch know of each other. Each begins with 8 bytes,
//! little-endian.

/// The tick up to which the recorder has read everything, for a launch that waits in lockstep. The file is there as
/// soon as the recording has begun.
pub const RECORDED: &str = "recorded";

/// The tick with which the run ended, then the outcome of the run in one word, by launch: what the robot does then, until
/// everything has stopped, follows the clock of the machine.
pub const END: &str = "run_end";

/// Longest outcome. [bytes]
pub const OUTCOME_BYTES_MAX: usize = 64;
