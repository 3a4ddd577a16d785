//! The clients of a run, as far as they concern how it goes on.

use crate::control::socket::Server;
use std::collections::BTreeSet;

/// The run's end of the control socket, and what came of it.
#[derive(Debug, Default)]
pub(super) struct Clients {
    /// Once the socket is open.
    pub(super) server: Option<Server>,
    /// What clients did that the scenario does not know of.
    pub(super) interferences: BTreeSet<&'static str>,
    /// True once a client has asked for the end.
    pub(super) asked_for_end: bool,
}
