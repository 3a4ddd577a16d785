//! Swaps while a stack runs.

use super::serve::LISTED_MAX;
use super::session::Session;
use crate::swap::config::merged;
use crate::swap::{Failure, Files, Scene, Swap};
use crate::swap_order::SwapOrder;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use toml::Table;
use zeronav_console::arguments::service_role;
use zeronav_files::read;
use zeronav_measure::result::swap::SwapResult;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_scenario::assignment::lay_over;
use zeronav_shell::remote_seats::{BINARY_BYTES_MAX, KEYS_BYTES_MAX, Program};
use zeronav_supervise::binaries;
use zeronav_supervise::question::{self, Silence};
use zeronav_supervise::stack::Stack;

/// What the configuration of a newcomer has in its name.
const OF_A_SWAP: &str = ".swap";

fn is_of_a_swap(config: &Path) -> bool {
    let name = config.file_name().and_then(|name| name.to_str());
    name.is_some_and(|name| name.contains(OF_A_SWAP))
}

impl Session<'_> {
    /// The tick beyond which a lockstep robot may not go yet because of a swap.
    pub(super) fn swap_limit(&self) -> u64 {
        let next = self.prepared.swaps.get(self.swaps.begun);
        let next = next.map_or(u64::MAX, |(tick, _)| *tick);
        (self.swaps.current.as_ref()).map_or(next, |swap| swap.lease_limit(next))
    }

    /// Begins the scenario's swap whose time has come.
    fn begin_due_swap(&mut self, stack: &Stack) {
        let Some((tick, order)) = self.prepared.swaps.get(self.swaps.begun) else {
            return;
        };
        // The robot may be farther when the swap before took longer than planned.
        let tick = (*tick).max(stack.roster.control.lease);
        let is_due = match self.prepared.mode {
            RunMode::Lockstep => self.collector.all_answered(tick, &stack.roster),
            _ => self.collector.robot_tick() >= tick,
        };
        if self.swaps.is_busy() || !is_due {
            return;
        }
        self.swaps.begun += 1;
        if let Err(why) = self.begin_swap(stack, order.clone(), tick) {
            tracing::warn!(why, "the swap is not made");
            self.swaps.last_id += 1;
            let id = self.swaps.last_id;
            self.swaps.remember(SwapResult {
                id,
                role: order.role.clone(),
                state: "rejected".to_owned(),
                why: Some(why),
                ..SwapResult::default()
            });
        }
    }

    /// The binaries that the scenario names for each seat that can be swapped, the stock one first.
    pub(super) fn listed_binaries(&self) -> BTreeMap<String, Vec<PathBuf>> {
        let scenario = &self.prepared.scenario;
        let listed = |role: Role| {
            let own = scenario
                .services
                .of(role)
                .and_then(|service| service.binary.as_ref());
            let shadows = scenario.shadows().filter(|(seat, _)| *seat == role);
            let swaps = scenario.swaps.iter();
            let swaps = swaps.filter(|swap| swap.service == role.label());
            let mut all = vec![PathBuf::from(binaries::stock(role))];
            // What stands for a process on the other host is none that one chooses.
            all.extend(
                own.filter(|_| !self.prepared.remote.contains(&role))
                    .cloned(),
            );
            all.extend(shadows.filter_map(|(_, shadow)| shadow.binary.clone()));
            all.extend(swaps.filter_map(|swap| swap.binary.clone()));
            let mut seen = BTreeSet::new();
            all.retain(|binary| seen.insert(binary.clone()));
            all.truncate(LISTED_MAX);
            (role.to_string(), all)
        };
        let roles = Role::SERVICES.into_iter();
        roles
            .filter(|role| *role != Role::Robot)
            .map(listed)
            .collect()
    }

    /// Begins a swap. In lockstep the robot waits at `hold_tick` until the newcomer is ready.
    ///
    /// # Errors
    /// Why it cannot be.
    pub(super) fn begin_swap(
        &mut self,
        stack: &Stack,
        order: SwapOrder,
        hold_tick: u64,
    ) -> Result<SwapResult, String> {
        let role = service_role(&order.role)?;
        if role == Role::Robot {
            return Err("the robot keeps the time and is not swapped".to_owned());
        }
        order.check()?;
        let timed = order.require.iter().find(|clause| clause.is_timed());
        if let Some(clause) = timed.filter(|_| self.prepared.mode == RunMode::Lockstep) {
            return Err(format!(
                "{clause}: a lockstep run does not measure times; require `agree`, or run in real time"
            ));
        }
        if let Some(current) = &self.swaps.current {
            return Err(format!(
                "a swap of {} goes on ({}); wait until it is over, or `zeronav swap --cancel`",
                current.role(),
                current.result.state
            ));
        }
        let Some((binary, config)) = self.restarter.files(role) else {
            return Err(format!(
                "{role} was started by hand (--external): launch does not swap it"
            ));
        };
        let (newcomer, table) = if self.prepared.remote.contains(&role) {
            (binary.to_owned(), program_there(table_in(config)?, &order)?)
        } else {
            let newcomer = order.binary.as_deref().map(binaries::find).transpose()?;
            let newcomer = newcomer.unwrap_or_else(|| binary.to_owned());
            let keys = order.config.clone();
            let table = merged(table_in(config)?, role, newcomer == binary, keys);
            (newcomer, table)
        };
        self.swaps.last_id += 1;
        let id = self.swaps.last_id;
        let file = stack.root().join(format!("{role}{OF_A_SWAP}{id}.toml"));
        std::fs::write(&file, table.to_string())
            .map_err(|error| format!("writing {}: {error}", file.display()))?;
        let files = Files {
            binary: newcomer,
            config: file,
            log: self.prepared.log(format!("{role}.log")),
            log_level: self.prepared.log_level.clone(),
        };
        let ask = asking(&files);
        let swap = Swap::begin(id, role, order, files, hold_tick, ask);
        let result = swap.result.clone();
        self.swaps.current = Some(swap);
        Ok(result)
    }

    /// Looks after the swap that goes on.
    pub(super) fn update_swap(&mut self, stack: &mut Stack) {
        self.begin_due_swap(stack);
        let Some(mut swap) = self.swaps.current.take() else {
            return;
        };
        if swap.look(&mut self.scene(stack, swap.role())) {
            let Files { binary, config, .. } = swap.files().clone();
            let before = self.restarter.refit(swap.role(), binary, config);
            if let Some(before) = before.filter(|file| is_of_a_swap(file)) {
                let _ = std::fs::remove_file(before);
            }
        }
        self.put_back(swap);
    }

    /// Goes on with a swap, or removes what it leaves in the domain.
    fn put_back(&mut self, swap: Swap) {
        let config = &swap.files().config;
        let used = self.restarter.files(swap.role());
        if swap.is_over() && used.is_none_or(|(_, used)| used != config) {
            let _ = std::fs::remove_file(config);
        }
        self.swaps.put_back(swap);
    }

    /// Ends the swap that goes on.
    ///
    /// # Errors
    /// When there is none.
    pub(super) fn cancel_swap(&mut self, stack: &mut Stack) -> Result<(), String> {
        let none = || "no swap goes on".to_owned();
        let mut swap = self.swaps.current.take().ok_or_else(none)?;
        let cancelled = swap.cancel(&mut self.scene(stack, swap.role()));
        self.put_back(swap);
        cancelled
    }

    fn scene<'s>(&'s mut self, stack: &'s mut Stack, role: Role) -> Scene<'s> {
        let lockstep = self.prepared.mode == RunMode::Lockstep;
        Scene {
            stack,
            lockstep,
            tick_ns: self.prepared.scenario.run.tick_ns(),
            hang: self.prepared.hang_limit(role),
            is_vacant: self.restarter.is_vacant(role),
            collector: &mut self.collector,
        }
    }
}

/// What sits in a seat of the other host is told which program is to be started there, and with which keys:
/// those of `order` over those of the one in the seat, when that is the same program.
fn program_there(incumbent: Table, order: &SwapOrder) -> Result<Table, String> {
    let said = |error: &dyn core::fmt::Display| error.to_string();
    let incumbent: Program = incumbent.try_into().map_err(|error| said(&error))?;
    let binary = match &order.binary {
        None => incumbent.binary.clone(),
        Some(path) if path.components().count() == 1 => path.display().to_string(),
        Some(path) => {
            let role = &order.role;
            return Err(format!(
                "the process of {role} is on the other host: name its program there without a folder, not {}",
                path.display()
            ));
        }
    };
    if binary.len() > BINARY_BYTES_MAX {
        return Err(format!(
            "the name of a program has at most {BINARY_BYTES_MAX} bytes, not {}",
            binary.len()
        ));
    }
    let mut keys = Table::new();
    if binary == incumbent.binary {
        keys = toml::from_str(&incumbent.keys).map_err(|error| said(&error))?;
    }
    lay_over(&mut keys, order.config.clone());
    let keys = keys.to_string();
    if keys.len() > KEYS_BYTES_MAX {
        return Err(format!(
            "the other host is told of at most {KEYS_BYTES_MAX} bytes of keys, not of {}",
            keys.len()
        ));
    }
    Table::try_from(Program { binary, keys }).map_err(|error| said(&error))
}

/// Asks a binary whether it can work with its configuration.
fn asking(files: &Files) -> impl FnOnce() -> Result<(), Failure> + Send + use<> {
    let (binary, config): (PathBuf, PathBuf) = (files.binary.clone(), files.config.clone());
    move || {
        let arguments = [
            "--print-config".as_ref(),
            "--config".as_ref(),
            config.as_os_str(),
        ];
        question::ask(&binary, &arguments)
            .map(|_| ())
            .map_err(|silence| Failure {
                why: format!("{}: {silence}", binary.display()),
                by_clock: matches!(silence, Silence::Late | Silence::Start(_)),
            })
    }
}

fn table_in(file: &Path) -> Result<Table, String> {
    let problem = |error: &dyn core::fmt::Display| format!("{}: {error}", file.display());
    let text = read::text(file, read::TEXT_BYTES_MAX).map_err(|error| problem(&error))?;
    toml::from_str(&text).map_err(|error| problem(&error))
}
