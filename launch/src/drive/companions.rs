//! The companions of a run: those of its scenario, and the live page.

use super::session::Session;
use crate::companions::{Invocation, Plan};
use crate::configs;
use crate::live_view::{self, LivePage};
use crate::recorder::{DrivenBy, RecordedTicks, file_of_round, last_words};
use crate::recorder_start::start_recorder;
use std::collections::BTreeMap;
use std::path::PathBuf;
use zeronav_console::terminal::{complain, note};
use zeronav_msgs::role::Role;
use zeronav_scenario::companions::{RECORDER, RESTARTS, VIEWER};
use zeronav_supervise::stack::Stack;

impl Session<'_> {
    /// Starts the companions of the scenario, before the services. They are not waited for, except the
    /// recorder: a run that shall be recorded and cannot be does not begin.
    ///
    /// # Errors
    /// One line when a configuration cannot be written, or the recorder does not work.
    pub(super) fn start_companions(&mut self, stack: &mut Stack) -> Result<(), String> {
        let prepared = self.prepared;
        let configs = configs::write_companions(&prepared.scenario, stack.root())?;
        self.start_recorder(stack, &configs)
            .map_err(|why| format!("--record: {why}"))?;
        for (name, config) in configs {
            let binary = prepared.companions.get(&name);
            let spec = prepared.scenario.companions.get(&name);
            let Some((binary, spec)) = binary.zip(spec) else {
                continue;
            };
            let plan = Plan {
                binary: binary.clone(),
                restarts: spec.restarts,
                log: prepared.log(format!("{name}.log")),
                invocation: Invocation::Flags {
                    config,
                    log_level: prepared.log_level.clone(),
                },
                name,
            };
            self.companions.start(stack, plan);
        }
        Ok(())
    }

    fn start_recorder(
        &mut self,
        stack: &mut Stack,
        configs: &BTreeMap<String, PathBuf>,
    ) -> Result<(), String> {
        let prepared = self.prepared;
        let Some(file) = &prepared.recording else {
            return Ok(());
        };
        let round = self.quota.map(|quota| quota.round);
        let file = round.map_or_else(|| file.clone(), |round| file_of_round(file, round));
        // A stack that stays up drives where its clients say, trials come when the robot is ready for one, and what
        // was started by hand in a seat is not known.
        let is_filled = Role::SERVICES
            .iter()
            .all(|role| prepared.binaries.contains_key(role));
        let driven_by = if prepared.stays || round.is_some() || !is_filled {
            DrivenBy::Clients
        } else {
            DrivenBy::Scenario
        };
        let who = (driven_by, configs);
        let progress = start_recorder(&mut self.companions, stack, prepared, file, who)?;
        self.recorded = self.lockstep().then_some(progress);
        Ok(())
    }

    /// The last tick that the robot may begin, so that the recorder misses nothing.
    pub(super) fn last_recorded_tick(&mut self) -> u64 {
        if self.companions.pid_of(RECORDER).is_none() {
            self.recorded = None;
        }
        self.recorded
            .as_mut()
            .map_or(u64::MAX, RecordedTicks::last_tick)
    }

    /// Says what became of the recording, once the recorder has ended.
    pub(super) fn conclude_recording(&self) {
        if self.prepared.recording.is_some()
            && let Some(said) = last_words(&self.prepared.log(format!("{RECORDER}.log")))
        {
            note(&format!("recording: {said}"));
        }
    }

    /// Starts the live page where one is wanted. It shows a stack that is ready, so that it takes no
    /// processor from services that start.
    pub(super) fn show_page(&mut self, stack: &mut Stack) {
        let Some(page) = &self.prepared.view else {
            return;
        };
        let binary = match live_view::binary() {
            Ok(binary) => binary,
            Err(problem) => return complain(&format!("no live page: {problem}")),
        };
        let plan = Plan {
            name: VIEWER.to_owned(),
            binary,
            restarts: RESTARTS,
            log: self.prepared.log(format!("{VIEWER}.log")),
            invocation: Invocation::Page(LivePage::new(page)),
        };
        self.companions.start(stack, plan);
    }
}
