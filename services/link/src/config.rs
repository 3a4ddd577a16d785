//! The configuration of a link.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use zeronav_msgs::role::Role;
use zeronav_shell::StartError;

/// What a link is started with: launch writes it from the hosts of a scenario.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkConfig {
    /// Name of this host.
    pub host: String,
    /// Name of the other one.
    pub other: String,
    /// Labels of the seats that are filled on this host.
    pub seats: Vec<String>,
    /// True on the host of launch.
    pub commands: bool,
    /// Hash of the scenario, as text.
    pub scenario: String,
    /// Where this host listens, such as `tcp/192.168.1.7:7447`; empty where it connects.
    #[serde(default)]
    pub listen: String,
    /// Where the other one listens.
    #[serde(default)]
    pub connect: String,
    /// Folder with `ca.pem`, `HOST.pem` and `HOST.key`, for `tls/` ends.
    #[serde(default)]
    pub keys: PathBuf,
}

impl LinkConfig {
    /// Accepts one end, and seats that there are; the scenario's check has looked at the end and at its keys.
    ///
    /// # Errors
    /// [`StartError::Config`] naming the field.
    pub fn check(&self) -> Result<(), StartError> {
        for (at, label) in self.seats.iter().enumerate() {
            let role = Role::from_label(label).filter(|role| Role::SERVICES.contains(role));
            if role.is_none() {
                let field = format!("seats[{at}]");
                return Err(StartError::config(field, format!("`{label}` is no seat")));
            }
        }
        if self.listen.is_empty() == self.connect.is_empty() {
            let why = "a link has one end: `listen` or `connect`";
            return Err(StartError::config("listen", why));
        }
        Ok(())
    }

    /// The seats that are filled on this host.
    #[must_use]
    pub fn here(&self) -> Vec<Role> {
        let roles = Role::SERVICES.into_iter();
        roles
            .filter(|role| self.seats.iter().any(|label| label == role.label()))
            .collect()
    }

    /// The others.
    #[must_use]
    pub fn there(&self) -> Vec<Role> {
        let here = self.here();
        let roles = Role::SERVICES.into_iter();
        roles.filter(|role| !here.contains(role)).collect()
    }
}
