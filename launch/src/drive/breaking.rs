//! Faults of the scenario and of clients: begins them, ends them, and notes how the seats recover.

use super::faults::{Active, Faults, Hold};
use super::session::Session;
use crate::faults::{Awaited, Event};
use crate::result::fault::FaultResult;
use crate::scenario::StackFault;
use crate::supervise::stack::Stack;
use rustix::process::Signal;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::time::{nanoseconds, seconds};
use zeronav_shell::clock::now_ns;

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
    pub(super) fn see_to_faults(&mut self, stack: &mut Stack) {
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
            None => self.keeper.is_busy(),
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
        if self.shuttle.is_some() {
            return Err("the run measures latencies; a fault would change them".to_owned());
        }
        let mode = self.prepared.mode;
        fault.check().map_err(|error| error.why)?;
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
        if mode == RunMode::Lockstep && self.is_ready {
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
            if self.prepared.mode == RunMode::Lockstep && self.is_ready {
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

    fn begin_fault(&mut self, stack: &mut Stack, fault: &StackFault) -> Result<(), String> {
        let role = fault.role().ok_or("no seat of that name")?;
        let mut children = stack.children.iter_mut().filter(|it| it.role == role);
        let epoch = children.find_map(|it| it.ended().is_none().then_some(it.epoch));
        let epoch = epoch.ok_or_else(|| no_process(role))?;
        let since_ns = now_ns();
        let signal = match fault {
            StackFault::Kill { .. } => Some(Signal::KILL),
            StackFault::Stop { .. } => Some(Signal::STOP),
            StackFault::Slow { .. } => {
                stack.delay(role, fault.delay_steps());
                None
            }
        };
        let record = self.new_record(fault, None);
        let (id, tick) = (record.id, record.tick);
        tracing::info!(id, kind = fault.kind(), %role, tick, "fault");
        self.faults.record(record);
        if let Some(signal) = signal {
            stack.signal(role, signal);
            self.collector.recoveries.wait_for(Awaited {
                id,
                role,
                not_epoch: epoch,
                after_tick: tick,
                since_ns,
            });
            if self.prepared.mode == RunMode::Lockstep && self.is_ready {
                self.faults.hold = Some(Hold { role, epoch, tick });
            }
        }
        if !matches!(fault, StackFault::Kill { .. }) {
            self.faults.active.push(Active {
                id,
                fault: fault.clone(),
                role,
                epoch,
            });
        }
        if let Some(lasts_s) = fault.lasts_s() {
            let lasts = nanoseconds(lasts_s) / self.prepared.scenario.run.tick_ns().max(1);
            self.faults
                .schedule
                .add(tick + lasts.max(1), Event::End(id));
        }
        Ok(())
    }

    /// Ends a fault, and waits for the next answer of its seat.
    fn end_fault(&mut self, stack: &mut Stack, id: u64) {
        let Some(Active { role, .. }) = self.undo(stack, id) else {
            return;
        };
        let tick = self.collector.robot_tick();
        let until_s = seconds(tick * self.prepared.scenario.run.tick_ns());
        if let Some(record) = self.faults.record_of(id) {
            record.until_s = Some(until_s);
        }
        self.collector.recoveries.wait_for(Awaited {
            id,
            role,
            not_epoch: 0,
            after_tick: tick,
            since_ns: now_ns(),
        });
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
        let (role, epoch) = (active.role, active.epoch);
        match active.fault {
            StackFault::Kill { .. } => {}
            StackFault::Stop { .. } => {
                let children = stack.children.iter_mut();
                for child in children.filter(|it| (it.role, it.epoch) == (role, epoch)) {
                    child.signal(Signal::CONT);
                }
            }
            StackFault::Slow { .. } => {
                // Another delay of the same seat goes on.
                let other = self.faults.active.iter().rfind(|other| {
                    other.role == role && matches!(other.fault, StackFault::Slow { .. })
                });
                let injected = self.prepared.delays.get(&role).copied().unwrap_or(0);
                stack.delay(role, other.map_or(injected, |it| it.fault.delay_steps()));
            }
        }
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
