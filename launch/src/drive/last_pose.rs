//! Where the robot of a stack that stays up was last known to be, for the next stack of the scenario.

use crate::prepare::Prepared;
use serde::{Deserialize, Serialize};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use zeronav_console::artifacts;
use zeronav_console::terminal::note;
use zeronav_files::read;
use zeronav_msgs::Pose;
use zeronav_msgs::checksum::checksum;
use zeronav_msgs::pose::wrap_angle;

/// Least time between two writes while the stack is up.
pub(super) const PAUSE: Duration = Duration::from_secs(10);

/// A robot that has moved less stays where it was. [m, rad]
const SAME: (f64, f64) = (0.05, 0.05);

/// Largest file that is read. [bytes]
const BYTES_MAX: u64 = 4096;

/// The file's content.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    /// Checksum of the static map.
    map: String,
    /// `map_from_base`. [m, m, rad]
    pose: [f64; 3],
}

/// The file, what was written to it last, and what is still to be done with what it held before.
#[derive(Debug)]
pub(super) struct LastPose {
    pub(super) file: PathBuf,
    map: String,
    /// Where the robot first was, and where it was when the file was written.
    pub(super) first: Option<Pose>,
    written: Option<Pose>,
    pub(super) looked: Instant,
    /// A file that is on its way to the disk, while the robot drives.
    pub(super) writing: Option<JoinHandle<()>>,
    /// Where the robot shall be put as soon as there is odometry.
    pub(super) resumes: Option<[f64; 3]>,
}

impl LastPose {
    /// Of a stack that stays up, beside its folder; `None` for a run.
    pub(super) fn of(prepared: &Prepared) -> Option<Self> {
        let folder = prepared.directory.parent().filter(|_| prepared.stays)?;
        let name = format!("last-pose-{}.json", prepared.scenario.name);
        let map = prepared.world.rasterise();
        let cells: Vec<u8> = map.cells.iter().map(|cell| *cell as u8).collect();
        let sum = checksum(&[], bytemuck::bytes_of(&map.geometry), &cells);
        let mut it = Self {
            file: folder.join(name),
            map: format!("{sum:016x}"),
            first: None,
            written: None,
            looked: Instant::now(),
            writing: None,
            resumes: None,
        };
        if prepared.resume_pose {
            match it.saved() {
                Ok(pose) => it.resumes = Some(pose),
                Err(why) => note(&format!("no pose is resumed: {why}")),
            }
        }
        Some(it)
    }

    /// What was saved.
    ///
    /// # Errors
    /// One line naming the file.
    fn saved(&self) -> Result<[f64; 3], String> {
        let file = self.file.display();
        let text = read::text(&self.file, BYTES_MAX).map_err(|error| match error.kind() {
            ErrorKind::NotFound => format!("there is no {file} yet"),
            _ => format!("reading {file}: {error}"),
        })?;
        let saved: Saved =
            serde_json::from_str(&text).map_err(|error| format!("{file}: {error}"))?;
        if saved.map == self.map {
            Ok(saved.pose)
        } else {
            Err(format!("{file} is of another map"))
        }
    }

    /// The text to write for a robot that is at `pose`, unless it has hardly moved since the last one. A robot that has not
    /// moved since the start knows no more than it was told there, unless it `was_told` since.
    pub(super) fn text(&mut self, pose: Pose, was_told: bool) -> Option<String> {
        let first = *self.first.get_or_insert(pose);
        let before = self.written.or((!was_told).then_some(first));
        if before.is_some_and(|before| is_same(&before, &pose)) {
            return None;
        }
        self.written = Some(pose);
        let saved = Saved {
            map: self.map.clone(),
            pose: [pose.x_m, pose.y_m, pose.yaw_rad],
        };
        serde_json::to_string(&saved).ok()
    }
}

fn is_same(one: &Pose, other: &Pose) -> bool {
    let turned_rad = wrap_angle(one.yaw_rad - other.yaw_rad).abs();
    one.distance_m(other) < SAME.0 && turned_rad < SAME.1
}

pub(super) fn write(file: &Path, text: &str) {
    if let Err(error) = artifacts::write(file, text) {
        tracing::warn!(error, "the robot's last pose is not saved");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_is_written_when_the_robot_has_moved_or_was_told() {
        let mut it = LastPose {
            file: PathBuf::new(),
            map: "m".to_owned(),
            first: None,
            written: None,
            looked: Instant::now(),
            writing: None,
            resumes: None,
        };
        let at = |x_m: f64, yaw_rad: f64| Pose::new(x_m, 0.0, yaw_rad);
        assert_eq!(it.text(at(0.0, 3.13), false), None, "it knows nothing new");
        assert_eq!(it.text(at(0.02, -3.13), false), None);
        let text = it.text(at(1.0, 3.13), false).unwrap();
        assert_eq!(text, r#"{"map":"m","pose":[1.0,0.0,3.13]}"#);
        assert_eq!(it.text(at(1.01, -3.13), false), None, "it has hardly moved");
        assert!(it.text(at(0.0, 3.13), false).is_some(), "it has come back");
        (it.first, it.written) = (None, None);
        assert!(it.text(at(5.0, 0.0), true).is_some(), "it was told");
        assert_eq!(it.text(at(5.0, 0.0), true), None);
    }
}
