//! How each seat did: who answered there last, and how it ended.

use crate::prepare::Prepared;
use crate::restarter::Restarter;
use zeronav_measure::result::ServiceResult;
use zeronav_msgs::role::Role;
use zeronav_supervise::Stack;
use zeronav_supervise::child::Child;
use zeronav_supervise::occupant::{Occupant, file_name};

/// Ends the processes and says how each seat did, in the order of the roles.
#[must_use]
pub(crate) fn stop(
    stack: &mut Stack,
    restarter: &Restarter<'_>,
    prepared: &Prepared,
) -> Vec<ServiceResult> {
    let died: Vec<Role> = stack
        .children
        .iter_mut()
        .filter_map(|child| child.ended().map(|_| child.role))
        .collect();
    let killed = stack.stop_processes();
    let mut reports = Vec::new();
    for role in Role::SERVICES {
        let occupant = stack.occupants.get(&role);
        let child = stack.children.iter_mut().find(|child| child.role == role);
        let Some(child) = child else {
            let external = !prepared.binaries.contains_key(&role);
            reports.extend(external.then(|| external_service(role, occupant)));
            continue;
        };
        let end = if killed.contains(&role) {
            "did not stop when asked, killed".to_owned()
        } else if died.contains(&role) {
            child.ended().map_or_else(String::new, Child::end_in_words)
        } else {
            "stopped".to_owned()
        };
        // A process that answers in the place of the one that was started is named as what it is.
        let other = occupant.filter(|other| other.epoch == child.epoch && other.pid != child.pid());
        reports.push(ServiceResult {
            name: role.to_string(),
            pid: other.map_or(child.pid(), |other| other.pid),
            binary: other.map_or_else(|| file_name(&child.binary), |other| other.binary.clone()),
            host: prepared.host_of(role),
            external: false,
            key: None,
            starts: restarter.starts(role),
            scheduling: child.scheduling().cloned(),
            memory_peak_bytes: (restarter.memory_peak_bytes(role)).max(child.memory_peak_bytes()),
            end,
        });
    }
    reports
}

/// A seat that was left to a process that was started by hand.
fn external_service(role: Role, occupant: Option<&Occupant>) -> ServiceResult {
    ServiceResult {
        name: role.to_string(),
        pid: occupant.map_or(0, |occupant| occupant.pid),
        binary: occupant.map_or_else(|| "none".to_owned(), |occupant| occupant.binary.clone()),
        host: None,
        external: true,
        key: None,
        starts: 0,
        memory_peak_bytes: 0,
        scheduling: None,
        end: "not ours to end".to_owned(),
    }
}
