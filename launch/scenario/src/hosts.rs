//! Hosts: which computer fills which seats of a stack that two of them drive.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;
use zeronav_msgs::Role;
use zeronav_shell::nearest::unknown;
use zeronav_world::error::SpecError;

/// Hosts of a stack.
pub const HOSTS: usize = 2;

/// Longest name. [characters]
const NAME_CHARS_MAX: usize = 32;

/// A computer that fills seats.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HostSpec {
    /// The seats, by their labels.
    pub seats: Vec<String>,
    /// Where it waits for the other host: `tcp/ADDRESS:PORT`, or `tls/NAME:PORT` with keys. One of the two hosts
    /// says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub listen: Option<String>,
    /// Where it finds the other host, if not where that listens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub connect: Option<String>,
    /// Folder on this computer with `ca.pem`, `HOST.pem` and `HOST.key`, for `tls/`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keys: Option<PathBuf>,
}

impl HostSpec {
    /// The seats that it fills.
    #[must_use]
    pub fn roles(&self) -> Vec<Role> {
        let roles = Role::SERVICES.into_iter();
        roles
            .filter(|role| self.seats.iter().any(|label| label == role.label()))
            .collect()
    }
}

/// The host of launch: it has the robot, and its launch drives.
#[must_use]
pub fn commands(hosts: &BTreeMap<String, HostSpec>) -> Option<&str> {
    let mut all = hosts.iter();
    let (name, _) = all.find(|(_, host)| host.roles().contains(&Role::Robot))?;
    Some(name)
}

/// The end of the way between the two hosts, as host `name` opens it: where it listens, and where it connects to; one
/// of them is empty.
#[must_use]
pub fn ends(hosts: &BTreeMap<String, HostSpec>, name: &str) -> (String, String) {
    let own = hosts.get(name);
    let listen = own.and_then(|own| own.listen.clone());
    let listens =
        |(other, host): (&String, &HostSpec)| host.listen.clone().filter(|_| other != name);
    let connect = own
        .and_then(|own| own.connect.clone())
        .or_else(|| hosts.iter().find_map(listens));
    match listen {
        Some(listen) => (listen, String::new()),
        None => (String::new(), connect.unwrap_or_default()),
    }
}

/// Everything that is wrong with the hosts of a scenario, by field.
pub(super) fn check(hosts: &BTreeMap<String, HostSpec>) -> Vec<SpecError> {
    if hosts.is_empty() {
        return Vec::new();
    }
    let mut wrong = Vec::new();
    if hosts.len() != HOSTS {
        let why = format!(
            "{} of them; a stack is driven by one host or by {HOSTS}",
            hosts.len()
        );
        wrong.push(SpecError::new("hosts", why));
    }
    for (name, host) in hosts {
        let field = format!("hosts.{name}");
        if !is_name(name) {
            let why = format!(
                "a name is a letter a to z and up to {} more of a to z, 0 to 9 and _",
                NAME_CHARS_MAX - 1
            );
            wrong.push(SpecError::new(field.clone(), why));
        }
        for (at, label) in host.seats.iter().enumerate() {
            if !Role::SERVICES.iter().any(|role| role.label() == label) {
                let known: Vec<&str> = Role::SERVICES.iter().map(|role| role.label()).collect();
                let field = format!("{field}.seats[{at}]");
                wrong.push(SpecError::new(field, unknown("seat", label, known)));
            }
        }
        for (key, end) in [("listen", &host.listen), ("connect", &host.connect)] {
            let why = end
                .as_deref()
                .and_then(|end| refused_end(end, host.keys.is_some()));
            wrong.extend(why.map(|why| SpecError::new(format!("{field}.{key}"), why)));
        }
        if host.listen.is_some() && host.connect.is_some() {
            let why = "a host that listens connects to none";
            wrong.push(SpecError::new(format!("{field}.connect"), why));
        }
    }
    wrong.extend(check_seats(hosts));
    if hosts.values().filter(|host| host.listen.is_some()).count() != 1 {
        let why = "one of the hosts says where it listens: listen = \"tcp/ADDRESS:PORT\"";
        wrong.push(SpecError::new("hosts", why));
    }
    if hosts.values().any(|host| host.keys.is_some())
        && !hosts.values().all(|host| host.keys.is_some())
    {
        let why = "both hosts have keys, or none";
        wrong.push(SpecError::new("hosts", why));
    }
    wrong
}

/// Every seat is filled once, and the guard stands beside the robot: no way that is cut may be between them.
fn check_seats(hosts: &BTreeMap<String, HostSpec>) -> Option<SpecError> {
    let fill = |role: Role| {
        let hosts = hosts.iter();
        let of_host =
            hosts.flat_map(|(name, host)| host.seats.iter().map(move |label| (name, label)));
        let fill = of_host.filter(|(_, label)| *label == role.label());
        fill.map(|(name, _)| name.as_str()).collect::<Vec<_>>()
    };
    for role in Role::SERVICES {
        match fill(role)[..] {
            [_] => {}
            [] => {
                return Some(SpecError::new(
                    "hosts",
                    format!("no host fills the seat of {role}"),
                ));
            }
            [name, ..] => {
                let why = format!("the seat of {role} is filled more than once");
                return Some(SpecError::new(format!("hosts.{name}.seats"), why));
            }
        }
    }
    let (robot, guard) = (fill(Role::Robot), fill(Role::CollisionGuard));
    (robot != guard).then(|| {
        let why = format!(
            "collision_guard stands beside the robot, on {}: it stops the robot when the way between the hosts is cut",
            robot.join(", ")
        );
        SpecError::new(format!("hosts.{}.seats", guard.join(", ")), why)
    })
}

fn is_name(name: &str) -> bool {
    let is_one = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_';
    name.starts_with(|first: char| first.is_ascii_lowercase())
        && name.len() <= NAME_CHARS_MAX
        && name.bytes().all(is_one)
}

/// Why a way cannot have this end.
fn refused_end(end: &str, has_keys: bool) -> Option<String> {
    let (protocol, address) = end.split_once('/').unwrap_or((end, ""));
    let port = address.rsplit_once(':').and_then(|(host, port)| {
        let port: u16 = port.parse().ok()?;
        (!host.is_empty()).then_some(port)
    });
    let is_end = ["tcp", "tls"].contains(&protocol) && port.is_some_and(|port| port > 0);
    if !is_end {
        return Some(format!(
            "`{end}` is not `tcp/ADDRESS:PORT` or `tls/NAME:PORT`"
        ));
    }
    match (protocol, has_keys) {
        ("tls", false) => {
            Some("`tls/` needs `keys`, a folder that `zeronav link keys` makes".to_owned())
        }
        ("tcp", true) => Some("with `keys` it begins with `tls/`".to_owned()),
        _ => None,
    }
}

/// The JSON schema of `[hosts]`.
pub(super) fn schema() -> Value {
    let seats: Vec<&str> = Role::SERVICES.iter().map(|role| role.label()).collect();
    let end = json!({ "type": "string", "pattern": "^(tcp|tls)/.+:[0-9]+$" });
    json!({
        "type": "object",
        "maxProperties": HOSTS,
        "propertyNames": { "pattern": format!("^[a-z][a-z0-9_]{{0,{}}}$", NAME_CHARS_MAX - 1) },
        "additionalProperties": {
            "type": "object",
            "additionalProperties": false,
            "properties": {
                "seats": { "type": "array", "items": { "enum": seats } },
                "listen": end,
                "connect": end,
                "keys": { "type": "string" },
            },
            "required": ["seats"],
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn host(seats: &[&str], listen: Option<&str>) -> HostSpec {
        HostSpec {
            seats: seats.iter().map(|&seat| seat.to_owned()).collect(),
            listen: listen.map(str::to_owned),
            ..HostSpec::default()
        }
    }

    fn two() -> BTreeMap<String, HostSpec> {
        let robot = host(&["robot", "collision_guard"], None);
        let base = host(
            &["mapping", "global_planner", "local_planner"],
            Some("tcp/10.0.0.2:7447"),
        );
        [("robot".to_owned(), robot), ("base".to_owned(), base)].into()
    }

    fn fields(hosts: &BTreeMap<String, HostSpec>) -> Vec<String> {
        check(hosts).into_iter().map(|error| error.field).collect()
    }

    #[test]
    fn two_hosts_that_share_the_seats_are_accepted() {
        let hosts = two();
        assert_eq!(check(&hosts), []);
        assert_eq!(commands(&hosts), Some("robot"));
        let address = "tcp/10.0.0.2:7447".to_owned();
        assert_eq!(ends(&hosts, "base"), (address.clone(), String::new()));
        assert_eq!(ends(&hosts, "robot"), (String::new(), address));
        assert_eq!(check(&BTreeMap::new()), []);
    }

    #[test]
    fn where_a_host_connects_may_differ_from_where_the_other_listens() {
        let mut hosts = two();
        let robot = hosts.get_mut("robot").expect("a host");
        robot.connect = Some("tcp/example.org:80".to_owned());
        assert_eq!(check(&hosts), []);
        assert_eq!(ends(&hosts, "robot").1, "tcp/example.org:80");
    }

    #[test]
    fn a_guard_away_from_the_robot_and_seats_of_nobody_are_refused() {
        let mut hosts = two();
        hosts.get_mut("robot").expect("a host").seats.pop();
        assert_eq!(fields(&hosts), ["hosts"]);
        let base = hosts.get_mut("base").expect("a host");
        base.seats.push("collision_guard".to_owned());
        let wrong = check(&hosts);
        assert_eq!(wrong[0].field, "hosts.base.seats");
        assert!(
            wrong[0].why.contains("beside the robot"),
            "{}",
            wrong[0].why
        );
        let mut hosts = two();
        let base = hosts.get_mut("base").expect("a host");
        base.seats.push("robot".to_owned());
        assert_eq!(fields(&hosts).len(), 1);
        let mut hosts = two();
        hosts.get_mut("base").expect("a host").seats[0] = "maping".to_owned();
        assert_eq!(fields(&hosts), ["hosts.base.seats[0]", "hosts"]);
    }

    #[test]
    fn ends_and_keys_fit_each_other() {
        for end in [
            "tcp/:1",
            "udp/a:1",
            "tcp/a",
            "tcp/a:0",
            "tcp/a:70000",
            "a:1",
            "",
        ] {
            let mut hosts = two();
            hosts.get_mut("base").expect("a host").listen = Some(end.to_owned());
            assert_eq!(fields(&hosts), ["hosts.base.listen"], "{end}");
        }
        let mut hosts = two();
        hosts.get_mut("base").expect("a host").listen = None;
        assert_eq!(fields(&hosts), ["hosts"]);
        let mut hosts = two();
        hosts.get_mut("base").expect("a host").keys = Some("keys".into());
        assert_eq!(fields(&hosts), ["hosts.base.listen", "hosts"]);
        hosts.get_mut("base").expect("a host").listen = Some("tls/base:1".to_owned());
        hosts.get_mut("robot").expect("a host").keys = Some("keys".into());
        assert_eq!(check(&hosts), []);
        hosts.insert("third".to_owned(), host(&[], None));
        assert!(fields(&hosts).contains(&"hosts".to_owned()));
    }
}
