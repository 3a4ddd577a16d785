//! Removes from the middleware's registry what dead members have left there.
//!
//! The registry lies in files that are mapped, locked and waited for. A corrupt one can block or
//! kill its reader, so this runs in a process of its own, which can be killed.

use crate::domain;
use crate::error::StartError;
use crate::half_made;
use iceoryx2::node::{Node, NodeCleanupFailure, NodeState};
use iceoryx2::prelude::{CallbackProgression, ipc};
use std::path::Path;

/// Removes what the dead members of the domain at `root` have left.
///
/// # Errors
/// [`StartError::Usage`] when there is no such domain, [`StartError::System`] when something could
/// not be removed.
pub fn clean(root: &Path) -> Result<(), StartError> {
    let config = domain::look_up(root)?;
    half_made::remove(root);
    let mut left = Ok(());
    Node::<ipc::Service>::list(&config, |state| {
        if let NodeState::Dead(dead) = state {
            match dead.try_remove_stale_resources() {
                // A process that died while it joined has left nothing but its name.
                Ok(()) | Err(NodeCleanupFailure::ResourcesAlreadyCleanedUp) => {}
                Err(error) => left = Err(StartError::system("removing a dead member", error)),
            }
        }
        CallbackProgression::Continue
    })
    .map_err(|error| StartError::system("listing the members", error))?;
    left
}
