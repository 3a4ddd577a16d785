//! What a program in the robot's seat leaves in the run's folder, so that its successor goes on where it was, and the
//! companion knows how the frames of both sides lie.

use rustix::fs::OFlags;
use serde::{Deserialize, Serialize};
use std::io::Read;
use std::os::unix::fs::FileExt;
use zeronav_msgs::pose::Pose;
use zeronav_shell::folder::Folder;

/// Name of the file.
const FILE: &str = "ros2_anchor";

/// Longest file. [bytes]
const BYTES_MAX: u64 = 4_096;

/// Where run time and the stack's odometry begin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Anchor {
    /// `stack_from_odom`: `odom` of the contract from that of the robot, as `[x, y, yaw]`. [m, m, rad]
    pub stack_from_odom: [f64; 3],
    /// The moment at run time 0, `CLOCK_MONOTONIC`. [ns]
    pub zero_ns: u64,
}

impl Anchor {
    /// `stack_from_odom`.
    #[must_use]
    pub fn pose(&self) -> Pose {
        let [x, y, yaw] = self.stack_from_odom;
        Pose::new(x, y, yaw)
    }
}

/// The anchor of the program before this one in the seat; `None` when there was none.
#[must_use]
pub fn read(folder: &Folder) -> Option<Anchor> {
    let file = folder.file(FILE, OFlags::RDONLY).ok()?;
    let mut text = String::new();
    file.take(BYTES_MAX).read_to_string(&mut text).ok()?;
    let anchor: Anchor = serde_json::from_str(&text).ok()?;
    anchor.pose().check("anchor").ok().map(|()| anchor)
}

/// Writes it.
///
/// # Errors
/// What the system says.
pub fn write(folder: &Folder, anchor: &Anchor) -> std::io::Result<()> {
    let bytes = serde_json::to_vec(anchor).map_err(std::io::Error::other)?;
    let file = folder.file(FILE, OFlags::RDWR | OFlags::CREATE)?;
    file.write_all_at(&bytes, 0)?;
    file.set_len(bytes.len() as u64)
}
