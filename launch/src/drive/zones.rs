//! The zones of a run: launch keeps them, so that they survive every service.

use super::session::Session;
use super::zone_store::ZoneStore;
use std::time::{Duration, Instant};
use zeronav_scenario::zones::{ReadZone, ZoneSpec, message};
use zeronav_supervise::stack::Stack;
use zeronav_world::error::SpecError;

/// Between two messages of the same zones in real time, for a reader that has lost one.
const RESEND: Duration = Duration::from_secs(1);

/// A complaint of the list in words.
fn in_words(error: &SpecError) -> String {
    let field = error
        .field
        .trim_start_matches(|at: char| at != ']')
        .trim_start_matches([']', '.']);
    if field.is_empty() {
        error.why.clone()
    } else {
        format!("{field}: {}", error.why)
    }
}

impl Session<'_> {
    /// Sends the scenario's zones, before any service is started.
    pub(super) fn begin_zones(&mut self, stack: &mut Stack) -> Result<(), String> {
        let zones = &self.prepared.scenario.zones;
        if zones.is_empty() {
            return Ok(());
        }
        let read = ReadZone::all(zones).map_err(|error| error.within("zones").to_string())?;
        self.change_zones(stack, read, 0)
    }

    /// Puts a zone, in place of one of the same name.
    pub(super) fn add_zone(&mut self, stack: &mut Stack, zone: ZoneSpec) -> Result<(), String> {
        let read = ReadZone::of(zone).map_err(|error| error.to_string())?;
        let mut zones = self.zones.zones.clone();
        match zones.iter_mut().find(|it| it.spec.name == read.spec.name) {
            Some(before) => *before = read,
            None => zones.push(read),
        }
        let from_tick = self.next_tick(stack);
        self.change_zones(stack, zones, from_tick)
    }

    /// Takes a zone away.
    pub(super) fn remove_zone(&mut self, stack: &mut Stack, name: &str) -> Result<(), String> {
        let mut zones = self.zones.zones.clone();
        zones.retain(|it| it.spec.name != name);
        if zones.len() == self.zones.zones.len() {
            let names: Vec<&str> = zones.iter().map(|it| it.spec.name.as_str()).collect();
            return Err(match names.as_slice() {
                [] => format!("there is no zone `{name}`: there are none"),
                names => format!("there is no zone `{name}`: there are {}", names.join(", ")),
            });
        }
        let from_tick = self.next_tick(stack);
        self.change_zones(stack, zones, from_tick)
    }

    /// Lets other zones hold from a tick on.
    fn change_zones(
        &mut self,
        stack: &mut Stack,
        zones: Vec<ReadZone>,
        from_tick: u64,
    ) -> Result<(), String> {
        if self.trial_runner.is_some() && self.phase.is_ready() {
            return Err("the run measures latencies; a zone would change them".to_owned());
        }
        let revision = self.zones.message.revision + 1;
        let (mut message, parts) = message(&zones, revision).map_err(|error| in_words(&error))?;
        message.from_tick = from_tick;
        let is_sent = stack
            .send_zones(message, &parts)
            .map_err(|error| error.to_string())?;
        if !is_sent {
            return Err("no memory for the message; try again".to_owned());
        }
        tracing::info!(
            revision,
            n_zones = zones.len(),
            n_parts = parts.len(),
            "zones"
        );
        self.collector.take_zones(&message, &parts);
        self.zones = ZoneStore {
            zones,
            message,
            parts,
            sent: Some(Instant::now()),
        };
        Ok(())
    }

    /// Says again in real time which zones hold while somebody lacks them: to who has them it is no news.
    pub(super) fn keep_zones(&mut self, stack: &mut Stack) {
        let is_due = self.zones.sent.is_some_and(|sent| sent.elapsed() >= RESEND);
        if is_due && !self.lockstep() && stack.lacks_zones() {
            if let Err(error) = stack.send_zones(self.zones.message, &self.zones.parts) {
                tracing::warn!(%error, "the zones could not be sent again");
            }
            self.zones.sent = Some(Instant::now());
        }
    }
}
