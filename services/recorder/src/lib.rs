//! Records a running stack into one MCAP file, in two layers:
//!
//! - for the world ([`zeronav_ros_messages`]): messages of ROS 2 in CDR with their definitions (`ros2msg`), as rosbag2
//!   writes them, so that the tools of ROS 2 open the file without a conversion;
//! - for replay ([`native`]): every message of every topic byte for byte on `zeronav/<topic>`.
//!
//! Everything but the feature `process` is pure: it turns messages into bytes ([`file`]) and bytes of
//! a file into what is in it ([`read`], [`recover`]).

pub mod accepted;
pub mod bag_folder;
mod channels;
pub mod compare;
pub mod domain_files;
pub mod ending;
pub mod figures;
pub mod file;
#[cfg(test)]
pub(crate) mod fixture;
pub mod holders;
#[cfg(feature = "process")]
mod kept;
pub mod layout;
#[cfg(feature = "process")]
mod logs;
pub mod made;
pub mod messages;
pub mod native;
#[cfg(feature = "process")]
mod orders;
#[cfg(feature = "process")]
mod priority;
#[cfg(feature = "process")]
pub mod process;
pub mod read;
#[cfg(feature = "process")]
mod recorder;
pub mod recover;
#[cfg(feature = "process")]
mod taps;
#[cfg(feature = "process")]
mod user_taps;
pub mod verdict;
#[cfg(feature = "process")]
mod writer;
