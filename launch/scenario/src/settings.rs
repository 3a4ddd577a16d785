//! Keys of the configurations of services as a command line says them, in place of the scenario's:
//! `ROLE.KEY=VALUE`, with the syntax of `zeronav swap --set` behind the seat.

use crate::assignment::{assignment, lay_over};
use crate::methods::{Method, method};
use clap::Args;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use toml::{Table, Value};
use zeronav_console::arguments::service_role;
use zeronav_msgs::role::Role;

/// One of them: the seat and the key as a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    role: Role,
    keys: Table,
}

/// `global_planner.planner=jps` as a seat and a key.
///
/// # Errors
/// When it names no seat or no key.
pub fn setting(text: &str) -> Result<Setting, String> {
    let (role, rest) = text
        .split_once('.')
        .filter(|(role, _)| !role.contains('='))
        .ok_or_else(|| format!("`{text}` does not read like ROLE.KEY=VALUE"))?;
    Ok(Setting {
        role: service_role(role)?,
        keys: assignment(rest)?,
    })
}

/// The settings of a method, read.
#[derive(Debug, Clone, PartialEq)]
pub struct Preset(Vec<Setting>);

/// The settings of the method of this key.
///
/// # Errors
/// One line with the keys there are, or with the setting that is wrong.
fn preset(key: &str) -> Result<Preset, String> {
    read(method(key)?)
}

/// The settings of a method; one that cannot be read is a fault of the table.
fn read(method: &Method) -> Result<Preset, String> {
    let keys = method.keys.iter().map(|text| setting(text));
    keys.collect::<Result<_, _>>()
        .map(Preset)
        .map_err(|why| format!("method {}: {why}", method.key))
}

/// Who drives, as a command line says it.
#[derive(Debug, Clone, Default, Args)]
pub struct DriverArgs {
    /// Drive as the whole method of a paper, with its planner, its controller and its gains: tn, ju, zm, lwx
    /// or bao (see `zeronav list`).
    #[arg(long = "as", value_name = "METHOD", value_parser = preset)]
    pub method: Option<Preset>,
    /// One key of the configuration of a service, in place of the scenario's and of --as; may be given
    /// several times. A value that TOML cannot read is text.
    #[arg(long = "set", value_name = "ROLE.KEY=VALUE", value_parser = setting)]
    pub setting: Vec<Setting>,
}

impl DriverArgs {
    /// The keys of the method, and over them those that are said one by one; of the same key the last.
    #[must_use]
    pub fn settings(&self) -> Settings {
        let mut all = Settings::default();
        let of_method = self.method.iter().flat_map(|Preset(keys)| keys);
        for Setting { role, keys } in of_method.chain(&self.setting) {
            let table = all.0.entry(role.label().to_owned()).or_default();
            lay_over(table, keys.clone());
        }
        all
    }
}

/// Keys by the label of their seat.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Settings(BTreeMap<String, Table>);

impl Settings {
    /// True when nothing is said.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The keys of a seat.
    #[must_use]
    pub fn of(&self, role: Role) -> Option<&Table> {
        self.0.get(role.label())
    }

    /// The local planner's controller, when that is said.
    #[must_use]
    pub fn controller(&self) -> Option<&str> {
        self.of(Role::LocalPlanner)?.get("controller")?.as_str()
    }

    /// Lays the keys over the `config` of each seat in the text of a scenario.
    pub fn lay_over_sheet(&self, sheet: &mut Table) {
        let mut services = Table::new();
        for (role, keys) in &self.0 {
            let config = Table::from_iter([("config".to_owned(), Value::Table(keys.clone()))]);
            services.insert(role.clone(), config.into());
        }
        if !services.is_empty() {
            lay_over(
                sheet,
                Table::from_iter([("services".to_owned(), services.into())]),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::METHODS;

    #[test]
    fn a_setting_is_a_seat_and_the_assignment_of_a_swap() {
        let read = setting("global_planner.options.cost_weight=0").expect("a setting");
        assert_eq!(read.role, Role::GlobalPlanner);
        assert_eq!(read.keys, assignment("options.cost_weight=0").expect("one"));
        let text = setting("mapping.static_map=a.b=c").expect("a setting");
        assert_eq!(text.keys["static_map"].as_str(), Some("a.b=c"));
        for wrong in [
            "planner=jps",
            "global_planner",
            "pilot.x=1",
            "mapping.=1",
            "mapping.x",
        ] {
            assert!(setting(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn every_setting_of_the_table_of_methods_can_be_read() {
        for row in METHODS {
            let Preset(read) = preset(row.key).expect("its settings");
            assert_eq!(read.len(), row.keys.len());
            assert!(
                row.keys.contains(&"global_planner.options.cost_weight=0"),
                "{row:?}"
            );
        }
        assert_eq!(METHODS.len(), 5);
    }

    #[test]
    fn a_broken_table_and_an_unknown_method_are_errors() {
        let broken = Method {
            key: "x",
            title: "",
            keys: &["global_planner.planner=jps", "pilot.planner=jps"],
        };
        let why = read(&broken).expect_err("it was read");
        assert!(why.contains("method x") && why.contains("pilot"), "{why}");
        let why = preset("tm").expect_err("it was found");
        assert!(why.contains("tn"), "{why}");
    }

    #[test]
    fn what_is_said_one_by_one_lies_over_the_method() {
        let arguments = DriverArgs {
            method: preset("ju").ok(),
            setting: vec![
                setting("local_planner.papers.ju_fusion.repel=2").expect("a setting"),
                setting("local_planner.papers.ju_fusion.repel=3").expect("a setting"),
                setting("global_planner.options.cost_weight=1.5").expect("a setting"),
            ],
        };
        let settings = arguments.settings();
        assert_eq!(settings.controller(), Some("ju_fusion"));
        let local = settings.of(Role::LocalPlanner).expect("a seat");
        let repel = &local["papers"]["ju_fusion"]["repel"];
        assert_eq!(repel.as_integer(), Some(3));
        let global = settings.of(Role::GlobalPlanner).expect("a seat");
        assert_eq!(global["planner"].as_str(), Some("ju_astar"));
        assert_eq!(global["options"]["cost_weight"].as_float(), Some(1.5));
        assert!(DriverArgs::default().settings().is_empty());
        // A suite writes them into its scenarios and into its journal.
        let mut sheet: Table = "[services.local_planner]\nbinary = 'own'"
            .parse()
            .expect("TOML");
        settings.lay_over_sheet(&mut sheet);
        let seat = &sheet["services"]["local_planner"];
        assert_eq!(seat["binary"].as_str(), Some("own"));
        assert_eq!(seat["config"]["controller"].as_str(), Some("ju_fusion"));
        let line = serde_json::to_string(&settings).expect("JSON");
        assert_eq!(serde_json::from_str::<Settings>(&line).ok(), Some(settings));
    }
}
