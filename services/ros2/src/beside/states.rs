//! The nodes of Nav2 for which scripts wait, as far as they say that they are active.

use ros2_client::dds::Server;
use ros2_client::qos::{History, QosProfile};
use ros2_client::{Message, Name, Node, ServiceMapping, ServiceTypeName};
use serde::{Deserialize, Serialize};

/// Requests that are answered at a look.
const TURN: usize = 16;

/// A request without fields, which has a byte.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct NoFields(u8);

impl Message for NoFields {}

/// Of `lifecycle_msgs/GetState`.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct StateReply {
    id: u8,
    label: String,
}

impl Message for StateReply {}

/// Of `std_srvs/Trigger`.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct TriggerReply {
    success: bool,
    message: String,
}

impl Message for TriggerReply {}

/// `inactive` and `active` of `lifecycle_msgs/State`.
const INACTIVE: (u8, &str) = (2, "inactive");
const ACTIVE: (u8, &str) = (3, "active");

/// Nodes that are asked for their state.
const NODES: [&str; 2] = ["bt_navigator", "amcl"];

/// Nodes that are asked whether all is active.
const MANAGERS: [&str; 3] = [
    "lifecycle_manager",
    "lifecycle_manager_navigation",
    "lifecycle_manager_localization",
];

/// See the module's description.
pub(super) struct States {
    states: Vec<Server<NoFields, StateReply>>,
    managers: Vec<Server<NoFields, TriggerReply>>,
}

fn server<R: Message + 'static>(
    node: &mut Node,
    space: &str,
    [of, name]: [&str; 2],
    [package, kind]: [&str; 2],
) -> Result<Server<NoFields, R>, String> {
    let failed = |why: &dyn core::fmt::Debug| format!("offering {of}/{name}: {why:?}");
    let full = Name::parse(&format!("{space}/{of}/{name}")).map_err(|why| failed(&why))?;
    let qos = QosProfile::publisher_default().history(History::KeepLast { depth: 10 });
    let server = node.create_server(
        ServiceMapping::Enhanced,
        &full,
        &ServiceTypeName::new(package, kind),
        qos.clone(),
        qos,
    );
    server.map_err(|why| failed(&why))
}

impl States {
    /// Offers the services.
    ///
    /// # Errors
    /// One line that names the one that cannot be offered.
    pub(super) fn open(node: &mut Node, space: &str) -> Result<Self, String> {
        let mut states = Vec::new();
        for of in NODES {
            states.push(server(
                node,
                space,
                [of, "get_state"],
                ["lifecycle_msgs", "GetState"],
            )?);
        }
        let mut managers = Vec::new();
        for of in MANAGERS {
            managers.push(server(
                node,
                space,
                [of, "is_active"],
                ["std_srvs", "Trigger"],
            )?);
        }
        Ok(Self { states, managers })
    }

    /// Answers who asks; `is_active` is asked at most once for it.
    pub(super) fn look(&mut self, mut is_active: impl FnMut() -> bool) {
        let mut known = None;
        let mut is_active = || *known.get_or_insert_with(&mut is_active);
        for server in &self.states {
            answer(server, || {
                let (id, label) = if is_active() { ACTIVE } else { INACTIVE };
                let label = label.to_owned();
                StateReply { id, label }
            });
        }
        for server in &self.managers {
            answer(server, || TriggerReply {
                success: is_active(),
                message: String::new(),
            });
        }
    }
}

fn answer<R: Message + 'static>(server: &Server<NoFields, R>, mut reply: impl FnMut() -> R) {
    for _ in 0..TURN {
        match server.receive_request() {
            Ok(Some((request, _))) => {
                let _ = server.send_response(request, reply());
            }
            Ok(None) => return,
            Err(_) => {}
        }
    }
}
