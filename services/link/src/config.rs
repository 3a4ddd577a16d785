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
    /// Accepts one end, seats that there are, and keys where the end is one of TLS.
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
        let (field, end) = match (self.listen.is_empty(), self.connect.is_empty()) {
            (false, true) => ("listen", &self.listen),
            (true, false) => ("connect", &self.connect),
            _ => {
                return Err(StartError::config(
                    "listen",
                    "a link has one end: `listen` or `connect`",
                ));
            }
        };
        let is_tls = match end.split_once('/') {
            Some(("tcp", address)) if !address.is_empty() => false,
            Some(("tls", address)) if !address.is_empty() => true,
            _ => {
                let why = format!("`{end}` is not `tcp/ADDRESS:PORT` or `tls/NAME:PORT`");
                return Err(StartError::config(field, why));
            }
        };
        if is_tls == self.keys.as_os_str().is_empty() {
            let why = "names the folder of the keys of a `tls/` end, and of no other";
            return Err(StartError::config("keys", why));
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
