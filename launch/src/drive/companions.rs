//! The companions of a run: those of its scenario, and the live page.

use super::session::Session;
use crate::companions::{Plan, Told};
use crate::configs;
use crate::live_view::{self, LivePage};
use crate::recorder::{self, RecordedTicks, START_LIMIT, WALL_LIMIT, last_words};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use zeronav_console::leave;
use zeronav_console::terminal::{complain, note};
use zeronav_msgs::role::Role;
use zeronav_scenario::companions::{RECORDER, RESTARTS, VIEWER};
use zeronav_supervise::binaries;
use zeronav_supervise::child_log::LogPlace;
use zeronav_supervise::own_time::Patience;
use zeronav_supervise::stack::Stack;

impl Session<'_> {
    /// Starts the companions of the scenario, before the services. They are not waited for, except the
    /// recorder: a run that shall be recorded and cannot be does not begin.
    ///
    /// # Errors
    /// One line when a configuration cannot be written, or the recorder does not work.
    pub(super) fn start_companions(&mut self, stack: &mut Stack) -> Result<(), String> {
        let prepared = self.prepared;
        self.start_recorder(stack)
            .map_err(|why| format!("--record: {why}"))?;
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

    fn start_recorder(&mut self, stack: &mut Stack) -> Result<(), String> {
        let Some(file) = &self.prepared.recording else {
            return Ok(());
        };
        let plan = Plan {
            name: RECORDER.to_owned(),
            binary: binaries::find(Path::new(recorder::BINARY))?,
            restarts: 0,
            log: self.recorder_log(),
            told: Told::Recording {
                file: file.clone(),
                scenario: self.write_scenario()?,
                is_bag: file.parent() == Some(self.prepared.folder.path()),
            },
        };
        self.companions.start(stack, plan);
        let (pid, began) = (self.companions.pid_of(RECORDER), Instant::now());
        let mut patience = pid.map(Patience::with);
        let progress = loop {
            if let Some(progress) = stack.folder().and_then(RecordedTicks::open) {
                break progress;
            }
            if let Some(end) = self.companions.end_of(RECORDER) {
                let said = last_words(&self.recorder_log()).unwrap_or_default();
                return Err(format!("the recorder does not work ({end}: {said})"));
            }
            let is_late = patience.as_mut().is_some_and(|it| it.is_over(START_LIMIT));
            if is_late || began.elapsed() > WALL_LIMIT {
                let limit_s = START_LIMIT.as_secs();
                return Err(format!("the recorder does not begin within {limit_s} s"));
            }
            // What was said before it joined reaches it so.
            stack.refresh();
            std::thread::sleep(Duration::from_millis(2));
        };
        self.recorded = self.lockstep().then_some(progress);
        Ok(())
    }

    /// Leaves the scenario that is driven, with all that it builds on, in the run's folder. A stack that stays
    /// up drives where its clients say, and what sits in a seat by hand is not known.
    fn write_scenario(&self) -> Result<Option<PathBuf>, String> {
        let prepared = self.prepared;
        let is_filled = Role::SERVICES
            .iter()
            .all(|role| prepared.binaries.contains_key(role));
        if prepared.stays || !is_filled {
            return Ok(None);
        }
        let name = format!("{}.toml", prepared.scenario.name);
        let text = prepared.scenario.to_toml(prepared.seed)?;
        leave::write_in(&prepared.folder, &name, &text)?;
        Ok(Some(prepared.folder.path().join(name)))
    }

    fn recorder_log(&self) -> LogPlace {
        self.prepared.log(format!("{RECORDER}.log"))
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
            && let Some(said) = last_words(&self.recorder_log())
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
            told: Told::Page(LivePage::new(page)),
        };
        self.companions.start(stack, plan);
    }
}
