//! The file `metadata.yaml` that makes a folder with a recording a bag of rosbag2.

use std::collections::BTreeMap;
use std::fmt::Write;
use zeronav_ros_messages::RosTopic;

/// Name of the file.
pub const FILE: &str = "metadata.yaml";

/// Version of its form: that of rosbag2 from ROS 2 Jazzy on.
const VERSION: u32 = 9;

/// What it says of a recording in the file `name` of the same folder: messages by topic, and the first and the last
/// moment of any. [ns] since 1970, in lockstep of run time
#[must_use]
pub fn metadata(name: &str, messages: &BTreeMap<RosTopic, u64>, range_ns: [u64; 2]) -> String {
    let [start_ns, end_ns] = range_ns;
    let duration_ns = end_ns.saturating_sub(start_ns);
    let count: u64 = messages.values().sum();
    // Every string of JSON is one of YAML.
    let name = serde_json::Value::from(name);
    let mut text = format!(
        "rosbag2_bagfile_information:\n  version: {VERSION}\n  storage_identifier: mcap\n  duration:\n    \
         nanoseconds: {duration_ns}\n  starting_time:\n    nanoseconds_since_epoch: {start_ns}\n  \
         message_count: {count}\n  topics_with_message_count:{}\n",
        if messages.is_empty() { " []" } else { "" }
    );
    for (topic, n) in messages {
        let (topic_name, type_name) = (topic.name(), topic.type_name());
        let _ = write!(
            text,
            "    - topic_metadata:\n        name: {topic_name}\n        type: {type_name}\n        \
             serialization_format: cdr\n        offered_qos_profiles:\n"
        );
        for line in topic.qos().yaml().lines() {
            let _ = writeln!(text, "          {line}");
        }
        let _ = writeln!(
            text,
            "        type_description_hash: \"\"\n      message_count: {n}"
        );
    }
    text + &format!(
        "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - {name}\n  files:\n    \
         - path: {name}\n      starting_time:\n        nanoseconds_since_epoch: {start_ns}\n      \
         duration:\n        nanoseconds: {duration_ns}\n      message_count: {count}\n  \
         custom_data: ~\n  ros_distro: unknown\n"
    )
}
