//! Who publishes and who hears what, as the network says.

use crate::publishers::Gid;
use ros2_client::dds::rustdds::no_key::DataReader;
use ros2_client::dds::rustdds::policy::{Durability, History, Reliability};
use ros2_client::dds::rustdds::{
    CDRDeserializerAdapter, Duration, QosPolicies, QosPolicyBuilder, TopicKind,
};
use ros2_client::{Context, Gid as RosGid};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Most nodes and ends that are held.
const ENDS_MAX: usize = 10_000;

/// Messages about nodes that are taken in at a look.
const TURN: usize = 256;

/// One end of a topic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct End {
    /// The topic, such as `/scan`.
    pub topic: String,
    /// Its type, such as `sensor_msgs/LaserScan`.
    pub kind: String,
    /// Full name of the node; empty when it is not known.
    pub node: String,
    /// True of a publisher, false of a subscription.
    pub publishes: bool,
    /// Reliable; otherwise best effort.
    pub reliable: bool,
    /// What was published before is sent to those that come later (transient local); otherwise it is volatile.
    pub latched: bool,
}

/// The ends of others, and how many participants they belong to.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Graph {
    /// In the order of topics.
    pub ends: Vec<End>,
    /// Programs, roughly: each has one participant.
    pub participants: usize,
}

impl Graph {
    /// Those that publish the topic, or those that hear it.
    pub fn of<'a>(&'a self, topic: &'a str, publishes: bool) -> impl Iterator<Item = &'a End> {
        let all = self.ends.iter();
        all.filter(move |end| end.topic == topic && end.publishes == publishes)
    }

    /// Topics that somebody publishes with this type.
    #[must_use]
    pub fn topics_of(&self, kind: &str) -> Vec<&str> {
        let all = self.ends.iter();
        let mut topics: Vec<&str> = all
            .filter(|end| end.publishes && end.kind == kind)
            .map(|end| end.topic.as_str())
            .collect();
        topics.dedup();
        topics
    }
}

/// The topic of ROS with this name in DDS; `None` for what is no topic, such as a service.
fn topic(name: &str) -> Option<String> {
    name.strip_prefix("rt/").map(|name| format!("/{name}"))
}

/// The type of ROS with this name in DDS.
fn kind(name: &str) -> String {
    let plain = name.replace("::msg::dds_::", "/");
    plain.strip_suffix('_').unwrap_or(&plain).to_owned()
}

/// `rmw_dds_common/ParticipantEntitiesInfo`: the nodes of a participant. The library's own gives no ends away.
#[derive(Debug, Clone, Deserialize)]
struct Participant {
    #[allow(dead_code, reason = "a field of the message")]
    gid: RosGid,
    nodes: Vec<Node>,
}

/// `rmw_dds_common/NodeEntitiesInfo`.
#[derive(Debug, Clone, Deserialize)]
struct Node {
    space: String,
    name: String,
    readers: Vec<RosGid>,
    writers: Vec<RosGid>,
}

type Nodes = DataReader<Participant, CDRDeserializerAdapter<Participant>>;

/// Watches the network.
pub(super) struct Watch {
    context: Context,
    nodes: Nodes,
    /// Names of nodes by the identities of their ends.
    names: BTreeMap<Gid, String>,
}

impl Watch {
    /// Begins to look.
    ///
    /// # Errors
    /// One line that says what cannot be made.
    pub(super) fn begin(context: &Context) -> Result<Self, String> {
        let failed = |why: &dyn core::fmt::Debug| format!("looking at nodes: {why:?}");
        let qos = QosPolicyBuilder::new()
            .durability(Durability::TransientLocal)
            .reliability(Reliability::Reliable {
                max_blocking_time: Duration::ZERO,
            })
            .history(History::KeepLast { depth: 1_000 })
            .build();
        let participant = context.domain_participant();
        let topic = participant.create_topic(
            "ros_discovery_info".to_owned(),
            "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_".to_owned(),
            &qos,
            TopicKind::NoKey,
        );
        let topic = topic.map_err(|why| failed(&why))?;
        let subscriber = participant.create_subscriber(&qos);
        let subscriber = subscriber.map_err(|why| failed(&why))?;
        let nodes = subscriber.create_datareader_no_key_cdr(&topic, Some(qos));
        Ok(Self {
            context: context.clone(),
            nodes: nodes.map_err(|why| failed(&why))?,
            names: BTreeMap::new(),
        })
    }

    /// Takes in who has come.
    pub(super) fn look(&mut self) {
        for _ in 0..TURN {
            let Ok(Some(sample)) = self.nodes.take_next_sample() else {
                return;
            };
            for node in &sample.value().nodes {
                let name = format!("{}/{}", node.space.trim_end_matches('/'), node.name);
                for gid in node.readers.iter().chain(&node.writers) {
                    if self.names.len() < ENDS_MAX {
                        self.names.insert(gid.to_bytes16(), name.clone());
                    }
                }
            }
        }
    }

    fn end(&self, gid: Gid, names: [&str; 2], publishes: bool, qos: &QosPolicies) -> Option<End> {
        let [topic_name, type_name] = names;
        Some(End {
            topic: topic(topic_name)?,
            kind: kind(type_name),
            node: self.names.get(&gid).cloned().unwrap_or_default(),
            publishes,
            reliable: matches!(qos.reliability(), Some(Reliability::Reliable { .. })),
            latched: matches!(qos.durability(), Some(it) if it >= Durability::TransientLocal),
        })
    }

    /// What is known now, without what belongs to this participant.
    pub(super) fn graph(&self) -> Graph {
        let participant = self.context.domain_participant();
        let mut ends = Vec::new();
        let mut prefixes = Vec::new();
        for it in participant.discovered_writers().into_iter().take(ENDS_MAX) {
            let guid = it.writer_proxy.remote_writer_guid;
            prefixes.push(guid.prefix);
            let data = &it.publication_topic_data;
            let names = [data.topic_name.as_str(), data.type_name.as_str()];
            ends.extend(self.end(guid.to_bytes(), names, true, &data.qos()));
        }
        for it in participant.discovered_readers().into_iter().take(ENDS_MAX) {
            let guid = it.reader_proxy.remote_reader_guid;
            prefixes.push(guid.prefix);
            let data = &it.subscription_topic_data;
            let names = [data.topic_name().as_str(), data.type_name().as_str()];
            ends.extend(self.end(guid.to_bytes(), names, false, &data.qos()));
        }
        prefixes.sort_unstable();
        prefixes.dedup();
        ends.sort_by(|a, b| (&a.topic, !a.publishes).cmp(&(&b.topic, !b.publishes)));
        Graph {
            ends,
            participants: prefixes.len(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_dds_are_those_of_ros() {
        assert_eq!(topic("rt/front/scan"), Some("/front/scan".to_owned()));
        assert_eq!(topic("rq/bt_navigator/get_stateRequest"), None);
        let name = kind("sensor_msgs::msg::dds_::LaserScan_");
        assert_eq!(name, "sensor_msgs/LaserScan");
    }
}
