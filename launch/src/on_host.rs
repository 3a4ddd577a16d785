//! What a scenario is on one of its hosts: programs that sit in seats for processes on the other one, and the link.

use crate::run_plan::RunPlan;
use std::collections::BTreeMap;
use std::path::PathBuf;
use zeronav_msgs::role::Role;
use zeronav_scenario::Scenario;
use zeronav_scenario::companions::CompanionSpec;
use zeronav_scenario::hosts::{HostSpec, commands, ends};
use zeronav_shell::nearest::unknown;

/// The program that sits in a seat for a process on the other host.
const REMOTE_SEAT: &str = "zeronav-remote-seat";

/// The program that carries the topics, and the companion's name.
pub(crate) const LINK_PROGRAM: &str = "zeronav-link";
pub(crate) const LINK: &str = "link";

/// How often a link that has ended with failure is started again.
const LINK_RESTARTS: u32 = 100;

/// True when `host` fills its seats for the launch of another one.
///
/// # Errors
/// One line when the scenario has no such host.
pub(crate) fn is_beside(scenario: &Scenario, host: &str) -> Result<bool, String> {
    if scenario.hosts.contains_key(host) {
        return Ok(commands(&scenario.hosts) != Some(host));
    }
    let known: Vec<&str> = scenario.hosts.keys().map(String::as_str).collect();
    let why = match known[..] {
        [] => "the scenario has no [hosts]".to_owned(),
        _ => unknown("host", host, known),
    };
    Err(format!("--host {host}: {why}"))
}

/// The seats that other hosts fill.
fn elsewhere(hosts: &BTreeMap<String, HostSpec>, host: &str) -> Vec<Role> {
    let here = hosts.get(host).map(HostSpec::roles).unwrap_or_default();
    let roles = Role::SERVICES.into_iter();
    roles.filter(|role| !here.contains(role)).collect()
}

/// What a scenario is on one of its hosts.
#[derive(Debug)]
pub(crate) struct OnHost {
    /// Seats that are left alone here.
    pub left_out: Vec<Role>,
    /// Seats in which a program sits for a process on the other host.
    pub remote: Vec<Role>,
}

impl OnHost {
    /// Seats that the other host fills.
    pub(crate) fn elsewhere(&self) -> Vec<Role> {
        [&self.left_out[..], &self.remote].concat()
    }

    /// Accepts programs and settings for seats of this host: on the other one they would be needed.
    ///
    /// # Errors
    /// One line that names the seat.
    pub(crate) fn accept(&self, plan: &RunPlan) -> Result<(), String> {
        let mut others = self.remote.iter().chain(&self.left_out);
        let is_told =
            |role: &&Role| plan.binaries.contains_key(role) || plan.settings.of(**role).is_some();
        others.find(is_told).map_or(Ok(()), |role| {
            Err(format!(
                "{role}: its process is on the other host; say there what it is and how it is set"
            ))
        })
    }
}

/// Puts into the scenario what fills its seats on `host`.
///
/// # Errors
/// One line when there is no such host, or it cannot be.
pub(crate) fn lay_over(scenario: &mut Scenario, host: &str) -> Result<OnHost, String> {
    let is_beside = is_beside(scenario, host)?;
    let elsewhere = elsewhere(&scenario.hosts, host);
    if scenario.companions.contains_key(LINK) {
        let why =
            format!("`{LINK}` is the name of a part of a stack with hosts: choose another one");
        return Err(scenario.error_at("companions.link", &why).to_string());
    }
    if is_beside {
        // They run beside launch.
        scenario.companions.clear();
    } else {
        for (role, service) in scenario.services.each_mut() {
            if elsewhere.contains(&role) {
                service.binary = Some(PathBuf::from(REMOTE_SEAT));
            }
        }
    }
    let link = CompanionSpec {
        binary: PathBuf::from(LINK_PROGRAM),
        config: link_config(scenario, host),
        restarts: LINK_RESTARTS,
    };
    scenario.companions.insert(LINK.to_owned(), link);
    Ok(if is_beside {
        OnHost {
            left_out: elsewhere,
            remote: Vec::new(),
        }
    } else {
        OnHost {
            left_out: Vec::new(),
            remote: elsewhere,
        }
    })
}

/// What the link of `host` is told.
fn link_config(scenario: &Scenario, host: &str) -> toml::Table {
    let hosts = &scenario.hosts;
    let other = hosts.keys().find(|name| *name != host);
    let own = hosts.get(host).cloned().unwrap_or_default();
    let (listen, connect) = ends(hosts, host);
    let mut config = toml::Table::new();
    let mut set = |key: &str, value: toml::Value| config.insert(key.to_owned(), value);
    set("host", host.into());
    set("other", other.cloned().unwrap_or_default().into());
    set("seats", own.seats.into());
    set("commands", (commands(hosts) == Some(host)).into());
    set(
        "scenario",
        format!("{:016x}", scenario.fingerprint()).into(),
    );
    if !listen.is_empty() {
        set("listen", listen.into());
    }
    if !connect.is_empty() {
        set("connect", connect.into());
    }
    if let Some(keys) = own.keys {
        set("keys", keys.display().to_string().into());
    }
    config
}
