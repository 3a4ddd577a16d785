//! The participant in the network of ROS 2, as the variables of ROS ask for.

use core::net::{IpAddr, Ipv4Addr};
use ros2_client::dds::rustdds::DomainParticipantBuilder;
use ros2_client::{Context, Node, NodeName, NodeOptions};
use std::env;
use zeronav_params::{choices, parameters};

/// Highest domain whose ports lie in the range that is not given out to others.
const DOMAIN_ID_MAX: u16 = 232;

/// With whom to speak.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// Everybody in the network.
    Subnet,
    /// This host alone.
    Localhost,
}

choices! {
    /// With whom to speak, as a scenario says it.
    pub enum DiscoveryRange {
        /// As the variables of ROS say: `ROS_AUTOMATIC_DISCOVERY_RANGE`, `ROS_LOCALHOST_ONLY`.
        #[default]
        Environment = "environment",
        /// Everybody in the network.
        Subnet = "subnet",
        /// This host alone.
        Localhost = "localhost",
    }
}

parameters! {
    /// Where a program of the stack meets those of ROS 2.
    pub struct NetworkConfig {
        /// Domain of ROS 2; without, `ROS_DOMAIN_ID`, or 0.
        domain_id: Option<u32> = None, [0, 232];
        /// With whom to speak.
        range: DiscoveryRange = DiscoveryRange::Environment;
    }
}

/// Where to meet others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Network {
    /// `ROS_DOMAIN_ID`.
    pub domain_id: u16,
    /// With whom.
    pub range: Range,
}

impl Network {
    /// As the configuration says, or else the variables `ROS_DOMAIN_ID`, `ROS_AUTOMATIC_DISCOVERY_RANGE` and
    /// `ROS_LOCALHOST_ONLY`.
    ///
    /// # Errors
    /// One line that names the variable and what it may be.
    pub fn new(config: &NetworkConfig) -> Result<Self, String> {
        Self::from(config, |name| env::var(name).ok())
    }

    fn from(
        config: &NetworkConfig,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Self, String> {
        let domain_id = config.domain_id.and_then(|id| u16::try_from(id).ok());
        let range = match config.range {
            DiscoveryRange::Environment => None,
            DiscoveryRange::Subnet => Some(Range::Subnet),
            DiscoveryRange::Localhost => Some(Range::Localhost),
        };
        if let (Some(domain_id), Some(range)) = (domain_id, range) {
            return Ok(Self { domain_id, range });
        }
        let of_variables = Self::of_variables(variable)?;
        Ok(Self {
            domain_id: domain_id.unwrap_or(of_variables.domain_id),
            range: range.unwrap_or(of_variables.range),
        })
    }

    fn of_variables(variable: impl Fn(&str) -> Option<String>) -> Result<Self, String> {
        let of = |name| variable(name).filter(|it| !it.is_empty());
        let domain_id = match of("ROS_DOMAIN_ID") {
            None => 0,
            Some(text) => match text.parse() {
                Ok(id) if id <= DOMAIN_ID_MAX => id,
                _ => {
                    return Err(format!(
                        "ROS_DOMAIN_ID is {text:?}, must be a number from 0 to {DOMAIN_ID_MAX}"
                    ));
                }
            },
        };
        let range = match of("ROS_AUTOMATIC_DISCOVERY_RANGE").as_deref() {
            None | Some("SYSTEM_DEFAULT") => {
                let only = of("ROS_LOCALHOST_ONLY").is_some_and(|it| it == "1");
                if only {
                    Range::Localhost
                } else {
                    Range::Subnet
                }
            }
            Some("SUBNET") => Range::Subnet,
            Some("LOCALHOST") => Range::Localhost,
            Some(other) => {
                return Err(format!(
                    "ROS_AUTOMATIC_DISCOVERY_RANGE is {other:?}: SUBNET and LOCALHOST are supported; static peers and \
                     OFF are not"
                ));
            }
        };
        Ok(Self { domain_id, range })
    }

    /// A node of this name in the network.
    ///
    /// # Errors
    /// One line that says what is wrong.
    pub fn node(&self, name: &str) -> Result<(Context, Node), String> {
        let mut builder = DomainParticipantBuilder::new(self.domain_id);
        if self.range == Range::Localhost {
            builder = builder.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
        }
        let failed =
            |why: &dyn core::fmt::Debug| format!("joining ROS domain {}: {why:?}", self.domain_id);
        let participant = builder.build().map_err(|why| failed(&why))?;
        let context = Context::from_domain_participant(participant).map_err(|why| failed(&why))?;
        let node_name = NodeName::new("/", name).map_err(|why| failed(&why))?;
        let options = NodeOptions::new()
            .enable_rosout(false)
            .start_parameter_services(false);
        let node = (context.new_node(node_name, options)).map_err(|why| failed(&why))?;
        Ok((context, node))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn network(variables: &[(&str, &str)]) -> Result<Network, String> {
        Network::of_variables(|name| {
            let mut all = variables.iter();
            let found = all.find(|(of, _)| *of == name);
            found.map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn a_scenario_comes_before_the_variables() {
        let config = NetworkConfig {
            domain_id: Some(7),
            range: DiscoveryRange::Localhost,
        };
        let broken = |_: &str| Some("x".to_owned());
        let (domain_id, range) = (7, Range::Localhost);
        let network = Network::from(&config, broken);
        assert_eq!(network, Ok(Network { domain_id, range }));
        let config = NetworkConfig {
            domain_id: None,
            ..config
        };
        let why = Network::from(&config, broken).expect_err("no number");
        assert!(why.contains("ROS_DOMAIN_ID"), "{why}");
    }

    #[test]
    fn the_variables_of_ros_are_obeyed() {
        let (domain_id, range) = (0, Range::Subnet);
        assert_eq!(network(&[]), Ok(Network { domain_id, range }));
        let all = [
            ("ROS_DOMAIN_ID", "42"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"),
        ];
        let (domain_id, range) = (42, Range::Localhost);
        assert_eq!(network(&all), Ok(Network { domain_id, range }));
        let range = |variables: &[(&str, &str)]| network(variables).map(|it| it.range);
        let only = ("ROS_LOCALHOST_ONLY", "1");
        assert_eq!(range(&[only]), Ok(Range::Localhost));
        // The newer variable counts, as it does in ROS.
        let subnet = ("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET");
        assert_eq!(range(&[only, subnet]), Ok(Range::Subnet));
        for (name, value) in [
            ("ROS_DOMAIN_ID", "233"),
            ("ROS_DOMAIN_ID", "-1"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"),
        ] {
            let why = network(&[(name, value)]).expect_err(value);
            assert!(why.contains(name) && why.contains(value), "{why}");
        }
    }
}
