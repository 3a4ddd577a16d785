//! Hosts: which computer fills which seats of a stack that two of them drive.

use crate::{KINDS, RandomFaults, StackFault, mortals};
use core::net::IpAddr;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;
use zeronav_msgs::Role;
use zeronav_shell::nearest::unknown;
use zeronav_world::error::SpecError;

/// Hosts of a stack.
pub const HOSTS: usize = 2;

/// Shortest time after which a service may count as hung: the link beats for those of the other host once it has heard
/// nothing for 0.25 s. [s]
const HANG_AFTER_S_MIN: f64 = 0.5;

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
    /// Folder on this computer with `ca.pem`, `HOST.pem` and `HOST.key`, for `tls/`. Once it was read, an absolute path.
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

/// The host that fills the seat with this label.
#[must_use]
pub fn host_of<'a>(hosts: &'a BTreeMap<String, HostSpec>, seat: &str) -> Option<&'a str> {
    let fills = |(_, host): &(&String, &HostSpec)| host.seats.iter().any(|label| label == seat);
    let (name, _) = hosts.iter().find(fills)?;
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

/// The folders of keys, and where they are named.
pub(super) fn keys_of(
    hosts: &mut BTreeMap<String, HostSpec>,
) -> impl Iterator<Item = (String, &mut PathBuf)> {
    hosts.iter_mut().filter_map(|(name, host)| {
        let field = format!("hosts.{name}.keys");
        Some((field, host.keys.as_mut()?))
    })
}

/// True for a fault that hits the process in a seat: where that is on the other host, it would hit the program that stands
/// in for it. The others are told to the seat.
#[must_use]
pub fn hits_process(kind: &str) -> bool {
    ["kill", "stop"].contains(&kind)
}

/// What a scenario with hosts cannot ask for, by field: launch has the processes of its own host alone.
pub(super) fn check_services(
    hosts: &BTreeMap<String, HostSpec>,
    (faults, random): (&[StackFault], Option<&RandomFaults>),
    hang_after_s: f64,
) -> Vec<SpecError> {
    let Some(host) = commands(hosts) else {
        return Vec::new();
    };
    let is_remote = |seat: &str| host_of(hosts, seat).is_some_and(|other| other != host);
    let why = |seat: &str| format!("{seat} is not on {host}, where alone kill and stop work");
    let mut wrong = Vec::new();
    for (index, fault) in faults.iter().enumerate() {
        if hits_process(fault.kind()) && is_remote(fault.target()) {
            let field = format!("faults[{index}].service");
            wrong.push(SpecError::new(field, why(fault.target())));
        }
    }
    if let Some(random) = random {
        let drawn = KINDS.iter().filter(|kind| kind.is_drawn);
        let kinds: Vec<&str> = match &random.kinds[..] {
            [] => drawn.map(|kind| kind.name).collect(),
            kinds => kinds.iter().map(String::as_str).collect(),
        };
        let services: Vec<&str> = match &random.services[..] {
            [] => mortals().map(Role::label).collect(),
            services => services.iter().map(String::as_str).collect(),
        };
        let remote = services.into_iter().find(|seat| is_remote(seat));
        let remote = remote.filter(|_| kinds.into_iter().any(hits_process));
        wrong.extend(remote.map(|seat| SpecError::new("random_faults.services", why(seat))));
    }
    if hang_after_s > 0.0 && hang_after_s < HANG_AFTER_S_MIN {
        let why =
            format!("with hosts at least {HANG_AFTER_S_MIN}, as a way that is cut is no hang");
        wrong.push(SpecError::new("restart.hang_after_s", why));
    }
    wrong
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
    for (name, host) in hosts {
        let connects =
            |(other, host): (&String, &HostSpec)| other != name && host.connect.is_some();
        if host.listen.as_deref().is_some_and(is_anywhere) && !hosts.iter().any(connects) {
            let why = "listens everywhere: the other host says with `connect` where it finds it";
            wrong.push(SpecError::new(format!("hosts.{name}.listen"), why));
        }
    }
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

/// True for an end at every address of a computer, to which nobody can connect.
fn is_anywhere(end: &str) -> bool {
    let address = end.split_once('/').map_or(end, |(_, address)| address);
    let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
    let host = host.trim_start_matches('[').trim_end_matches(']');
    host.parse().is_ok_and(|host: IpAddr| host.is_unspecified())
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
    fn the_folder_of_keys_lies_beside_the_scenario() {
        let folder = tempfile::tempdir().expect("a folder");
        let text = "title = \"t\"\nstart = [1.0, 1.0, 0.0]\n[world]\narea_m = [[0.0, 0.0], [3.0, 3.0]]\n\
                    [robot]\npreset = \"jackal\"\n[hosts.robot]\nseats = []\nkeys = \"its/keys\"\n";
        std::fs::write(folder.path().join("it.toml"), text).expect("written");
        let library = crate::Library::of(folder.path());
        let read = crate::Scenario::load_from(&library, "./it.toml").expect("a scenario");
        let keys = read.hosts["robot"].keys.as_deref();
        assert_eq!(keys, Some(&*folder.path().join("its/keys")));
    }

    #[test]
    fn what_is_killed_or_stopped_is_on_the_host_of_launch() {
        let kill = |service: &str| StackFault::Kill {
            service: service.to_owned(),
            begins: None,
        };
        let fields = |faults: &[StackFault], random: Option<&RandomFaults>| {
            let wrong = check_services(&two(), (faults, random), 0.5);
            wrong
                .into_iter()
                .map(|error| error.field)
                .collect::<Vec<_>>()
        };
        assert!(fields(&[kill("collision_guard")], None).is_empty());
        let faults = [kill("collision_guard"), kill("mapping")];
        assert_eq!(fields(&faults, None), ["faults[1].service"]);
        let mut random = RandomFaults {
            count: 1,
            from_s: 0.0,
            until_s: 1.0,
            seed: None,
            kinds: Vec::new(),
            services: Vec::new(),
        };
        assert_eq!(fields(&[], Some(&random)), ["random_faults.services"]);
        random.kinds = vec!["slow".to_owned()];
        assert!(fields(&[], Some(&random)).is_empty());
        random.kinds = vec!["stop".to_owned()];
        random.services = vec!["collision_guard".to_owned()];
        assert!(fields(&[], Some(&random)).is_empty());
    }

    #[test]
    fn a_host_that_listens_everywhere_is_found_somewhere() {
        for end in ["tcp/0.0.0.0:7447", "tcp/[::]:7447"] {
            let mut hosts = two();
            hosts.get_mut("base").expect("a host").listen = Some(end.to_owned());
            assert_eq!(fields(&hosts), ["hosts.base.listen"]);
            let robot = hosts.get_mut("robot").expect("a host");
            robot.connect = Some("tcp/10.0.0.2:7447".to_owned());
            assert_eq!(check(&hosts), []);
        }
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
