//! Parts of messages in CDR.

use byteorder::{BigEndian, LittleEndian};
use cdr_encoding::from_bytes;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use zeronav_msgs::pose::{Pose, wrap_angle};

#[derive(Deserialize, Clone, Copy)]
pub(super) struct Time {
    pub sec: i32,
    pub nanosec: u32,
}

#[derive(Deserialize)]
pub(super) struct Header {
    pub stamp: Time,
    pub frame_id: String,
}

#[derive(Deserialize)]
pub(super) struct Vector3 {
    pub x: f64,
    pub y: f64,
    _z: f64,
}

#[derive(Deserialize)]
pub(super) struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

/// The name of a frame without a slash and a name space.
pub(super) fn plain(frame: &str) -> &str {
    frame.rsplit('/').next().unwrap_or(frame)
}

/// A pose in the plane; `None` when it is no number.
pub(super) fn pose(at: &Vector3, turn: &Quaternion) -> Option<Pose> {
    let sin = 2.0 * (turn.w * turn.z + turn.x * turn.y);
    let cos = 1.0 - 2.0 * (turn.y * turn.y + turn.z * turn.z);
    let yaw_rad = sin.atan2(cos);
    let is_sound = [at.x, at.y, yaw_rad].iter().all(|it| it.is_finite());
    is_sound.then(|| Pose::new(at.x, at.y, wrap_angle(yaw_rad)))
}

/// A message in CDR of either byte order; what stands behind its fields is left.
pub(super) fn decoded<T: DeserializeOwned>(data: &[u8]) -> Option<T> {
    let (head, body) = data.split_at_checked(4)?;
    match head[1] & 1 {
        1 => from_bytes::<T, LittleEndian>(body).ok().map(|(it, _)| it),
        _ => from_bytes::<T, BigEndian>(body).ok().map(|(it, _)| it),
    }
}
