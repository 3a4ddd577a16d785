//! Faults of the scenario and of clients: begins them, ends them, and notes how the seats recover.

use super::ballast::Ballast;
use super::faults::{Active, Faults, Hold};
use super::session::Session;
use rustix::process::Signal;
use std::path::Path;
use zeronav_measure::result::fault::FaultResult;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{RunMode, TOPIC_FAULTS_MAX, TopicFault};
use zeronav_msgs::time::{nanoseconds, seconds};
use zeronav_scenario::StackFault;
use zeronav_scenario::fault_plan::{Awaited, Event};
use zeronav_scenario::hosts::hits_process;
use zeronav_shell::clock::now_ns;
use zeronav_shell::memory::SHM;
use zeronav_supervise::stack::Stack;

impl Session<'_> {
    /// The tick beyond which a lockstep robot may not go yet because of a fault.
    pub(super) fn fault_limit(&self) -> u64 {
        let Faults {
            schedule,
            last,
            pace,
            hold,
            ..
        } = &self.faults;
        let due = schedule.limit(last, *pace);
        hold.map_or(due, |hold| due.min(hold.tick))
    }

    /// Begins and ends what is due. In lockstep everybody has answered then, and the robot waits.
    pub(super) fn update_faults(&mut self, stack: &mut Stack) {
        self.note_recoveries();
        let lockstep = self.prepared.mode == RunMode::Lockstep;
        for sight in self.collector.sights.drain(..) {
            let notice = lockstep.then_some(self.faults.pace);
            self.faults.schedule.see(&sight, notice);
            self.faults.last = sight;
        }
        let tick = self.collector.robot_tick();
        let is_early = lockstep && !self.collector.all_answered(tick, &stack.roster);
        if self.holds_on(stack) || is_early {
            return;
        }
        while let Some(event) = self.faults.schedule.next(tick) {
            match event {
                Event::Begin(fault) => {
                    if let Err(why) = self.begin_fault(stack, &fault) {
                        tracing::warn!(why, kind = fault.kind(), "the fault is not made");
                        let record = self.new_record(&fault, Some(why));
                        self.faults.record(record);
                    }
                }
                Event::End(id) => self.end_fault(stack, id),
            }
            if self.faults.hold.is_some() {
                return;
            }
        }
    }

    /// True while the seat of a process that was broken in lockstep has no successor.
    fn holds_on(&mut self, stack: &mut Stack) -> bool {
        let Some(Hold { role, epoch, .. }) = self.faults.hold else {
            return false;
        };
        let mut children = stack.children.iter_mut();
        let same = children.find(|it| (it.role, it.epoch) == (role, epoch));
        let holds = match same {
            // The swap that looks after the seat needs the next tick.
            Some(child) if self.swaps.keeps() == Some(role) => {
                child.ended().is_none() && !child.is_stopped()
            }
            Some(_) => true,
            None => self.restarter.is_busy(),
        };
        if !holds {
            self.faults.hold = None;
        }
        holds
    }

    /// Makes a fault of a client: at once, or in lockstep when everybody has answered what the robot
    /// may have begun.
    ///
    /// # Errors
    /// Why it cannot be made.
    pub(super) fn order_fault(
        &mut self,
        stack: &mut Stack,
        fault: &StackFault,
    ) -> Result<(), String> {
        if self.trial_runner.is_some() {
            return Err("the run measures latencies; a fault would change them".to_owned());
        }
        let mode = self.prepared.mode;
        fault.check().map_err(|error| error.to_string())?;
        self.prepared
            .scenario
            .check_delay(fault)
            .map_err(|error| error.why)?;
        if let Some((_, why)) = fault.unfit(mode) {
            return Err(why.to_owned());
        }
        if let Some(role) = fault.role()
            && !stack.children.iter().any(|child| child.role == role)
        {
            return Err(no_process(role));
        }
        if mode == RunMode::Lockstep && self.phase.is_ready() {
            let tick = stack.roster.control.lease;
            (self.faults.schedule).add(tick, Event::Begin(fault.clone()));
            return Ok(());
        }
        self.begin_fault(stack, fault)
    }

    /// Ends the faults of `target`, or all that go on.
    ///
    /// # Errors
    /// When there are none.
    pub(super) fn heal(&mut self, stack: &mut Stack, target: Option<&str>) -> Result<(), String> {
        let of = |active: &&Active| target.is_none_or(|target| active.fault.target() == target);
        let ids: Vec<u64> = self
            .faults
            .active
            .iter()
            .filter(of)
            .map(|it| it.id)
            .collect();
        if ids.is_empty() {
            let whose = target.map_or_else(String::new, |target| format!(" of {target}"));
            return Err(format!("no fault{whose} goes on"));
        }
        for id in ids {
            if self.prepared.mode == RunMode::Lockstep && self.phase.is_ready() {
                let tick = stack.roster.control.lease;
                self.faults.schedule.add(tick, Event::End(id));
            } else {
                self.end_fault(stack, id);
            }
        }
        Ok(())
    }

    /// Ends every fault, so that the run can.
    pub(super) fn heal_all(&mut self, stack: &mut Stack) {
        while let Some(active) = self.faults.active.last() {
            let id = active.id;
            self.undo(stack, id);
        }
    }

    fn new_record(&mut self, fault: &StackFault, why: Option<String>) -> FaultResult {
        self.faults.last_id += 1;
        let tick = self.collector.robot_tick();
        FaultResult {
            id: self.faults.last_id,
            kind: fault.kind().to_owned(),
            target: fault.target().to_owned(),
            figures: fault.figures(),
            tick,
            time_s: seconds(tick * self.prepared.scenario.run.tick_ns()),
            why,
            ..FaultResult::default()
        }
    }

    /// Begins a fault and notes it.
    ///
    /// # Errors
    /// Why it cannot be made; nothing has changed then.
    fn begin_fault(&mut self, stack: &mut Stack, fault: &StackFault) -> Result<(), String> {
        let process = match fault.role() {
            Some(role) => {
                if hits_process(fault.kind()) {
                    self.prepared.check_here(role)?;
                }
                let mut children = stack.children.iter_mut().filter(|it| it.role == role);
                let epoch = children.find_map(|it| it.ended().is_none().then_some(it.epoch));
                Some((role, epoch.ok_or_else(|| no_process(role))?))
            }
            None => None,
        };
        let is_of_topic = |active: &&Active| active.fault.topic().is_some();
        if fault.topic().is_some()
            && self.faults.active.iter().filter(is_of_topic).count() >= TOPIC_FAULTS_MAX
        {
            return Err(format!(
                "at most {TOPIC_FAULTS_MAX} topics are disturbed at a time"
            ));
        }
        let ballast = match fault {
            StackFault::FillShm { .. } => Some(Ballast::fill(Path::new(SHM))?),
            StackFault::DiskFull { .. } => Some(Ballast::fill(&self.prepared.directory)?),
            _ => None,
        };
        let since_ns = now_ns();
        let record = self.new_record(fault, None);
        let (id, tick) = (record.id, record.tick);
        let bytes = ballast.as_ref().map(|ballast| ballast.bytes);
        let target = fault.target();
        tracing::info!(id, kind = fault.kind(), target, tick, bytes, "fault");
        self.faults.record(record);
        if !matches!(fault, StackFault::Kill { .. }) {
            self.faults.active.push(Active {
                id,
                fault: fault.clone(),
                process,
                _ballast: ballast,
            });
        }
        self.set_faults(stack);
        let signal = match fault {
            StackFault::Kill { .. } => Some(Signal::KILL),
            StackFault::Stop { .. } => Some(Signal::STOP),
            _ => None,
        };
        if let (Some(signal), Some((role, epoch))) = (signal, process) {
            stack.signal(role, signal);
            self.restarter.strike(role, epoch);
            self.collector.recoveries.wait_for(Awaited {
                id,
                role,
                not_epoch: epoch,
                after_tick: tick,
                since_ns,
            });
            if self.prepared.mode == RunMode::Lockstep && self.phase.is_ready() {
                self.faults.hold = Some(Hold { role, epoch, tick });
            }
        }
        if let Some(lasts_s) = fault.lasts_s() {
            let lasts = nanoseconds(lasts_s) / self.prepared.scenario.run.tick_ns().max(1);
            self.faults
                .schedule
                .add(tick + lasts.max(1), Event::End(id));
        }
        Ok(())
    }

    /// Tells the services what the faults that go on do to their answers, clocks and topics. Of
    /// several delays or offsets of a seat the newest counts.
    fn set_faults(&mut self, stack: &mut Stack) {
        let seed = self.prepared.seed;
        let active = &self.faults.active;
        for role in Role::SERVICES {
            let mut own = active
                .iter()
                .rev()
                .filter(|it| it.fault.role() == Some(role));
            let injected = self.prepared.delays.get(&role).copied().unwrap_or(0);
            let delay = (own.clone().map(|it| it.fault.delay_steps())).find(|steps| *steps > 0);
            let offset_ms = own.find_map(|it| it.fault.clock_offset_ms());
            stack.impede(role, delay.unwrap_or(injected), offset_ms.unwrap_or(0));
        }
        let mut slots = [TopicFault::default(); TOPIC_FAULTS_MAX];
        let faults = active.iter().filter_map(|it| {
            // Another fault of the same kind loses other messages.
            let mixed = (seed ^ it.id.wrapping_mul(0x9e37_79b9)) & u64::from(u32::MAX);
            it.fault.topic_fault(u32::try_from(mixed).unwrap_or(0))
        });
        for (slot, fault) in slots.iter_mut().zip(faults) {
            *slot = fault;
        }
        stack.set_topic_faults(slots);
    }

    /// Ends a fault, and waits for the next answer of its seat.
    fn end_fault(&mut self, stack: &mut Stack, id: u64) {
        let Some(Active { fault, .. }) = self.undo(stack, id) else {
            return;
        };
        let tick = self.collector.robot_tick();
        let until_s = seconds(tick * self.prepared.scenario.run.tick_ns());
        if let Some(record) = self.faults.record_of(id) {
            record.until_s = Some(until_s);
        }
        if let Some(role) = fault.seat() {
            self.collector.recoveries.wait_for(Awaited {
                id,
                role,
                not_epoch: 0,
                after_tick: tick,
                since_ns: now_ns(),
            });
        }
    }

    fn undo(&mut self, stack: &mut Stack, id: u64) -> Option<Active> {
        let at = self
            .faults
            .active
            .iter()
            .position(|active| active.id == id)?;
        let active = self.faults.active.remove(at);
        self.faults.schedule.forget(id);
        tracing::info!(id, kind = active.fault.kind(), "the fault ends");
        if let (StackFault::Stop { .. }, Some(process)) = (&active.fault, active.process) {
            let children = stack.children.iter_mut();
            for child in children.filter(|it| (it.role, it.epoch) == process) {
                child.signal(Signal::CONT);
            }
        }
        self.set_faults(stack);
        Some(active)
    }

    fn note_recoveries(&mut self) {
        let lockstep = self.prepared.mode == RunMode::Lockstep;
        let tick_ns = self.prepared.scenario.run.tick_ns();
        for answered in self.collector.recoveries.take() {
            let awaited = answered.awaited;
            let took_ns = if lockstep {
                (answered.tick - awaited.after_tick) * tick_ns
            } else {
                answered.published_ns.saturating_sub(awaited.since_ns)
            };
            let until_s = seconds(answered.tick * tick_ns);
            // A process that was stopped and has a successor: that was its end.
            let ended = |active: &Active| active.id == awaited.id && awaited.not_epoch != 0;
            let was_active = self.faults.active.iter().any(ended);
            self.faults.active.retain(|active| !ended(active));
            if let Some(record) = self.faults.record_of(awaited.id) {
                record.recovery_ms = Some(seconds(took_ns) * 1.0e3);
                if was_active {
                    record.until_s = Some(until_s);
                }
            }
        }
    }
}

fn no_process(role: Role) -> String {
    format!("no process of this stack is in the seat of {role}")
}
