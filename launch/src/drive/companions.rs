//! The companions of a run: those of its scenario, and the live page.

use super::session::Session;
use crate::companions::{Plan, Told};
use crate::configs;
use crate::live_view::{self, LivePage};
use zeronav_console::terminal::complain;
use zeronav_scenario::companions::{RESTARTS, VIEWER};
use zeronav_supervise::stack::Stack;

impl Session<'_> {
    /// Starts the companions of the scenario, before the services. They are not waited for.
    ///
    /// # Errors
    /// One line when a configuration cannot be written.
    pub(super) fn start_companions(&mut self, stack: &mut Stack) -> Result<(), String> {
        let prepared = self.prepared;
        let configs = configs::write_companions(&prepared.scenario, stack.root())?;
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
                told: Told::Flags {
                    config,
                    log_level: prepared.log_level.clone(),
                },
                name,
            };
            self.companions.start(stack, plan);
        }
        Ok(())
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
            told: Told::Page(LivePage::new(page)),
        };
        self.companions.start(stack, plan);
    }
}
