//! One run: from a scenario to what was seen of it.

mod ballast;
mod breaking;
mod clients;
mod companions;
mod course;
mod current_task;
mod faults;
mod handed_pose;
mod last_pose;
mod pace;
mod phase;
mod progress;
mod reach;
mod resuming;
mod run_time;
mod serve;
mod session;
mod standstill;
mod stop;
mod swapping;
mod swaps;
mod verbs;
mod waiting;
mod zone_store;
mod zones;

use crate::collect::Collector;
use crate::command_start;
use crate::configs;
use crate::ending::Ending;
use crate::host;
use crate::prepare::Prepared;
use crate::recorder;
use crate::seat_report;
use crate::show::log;
use crate::trial_runner::{Quota, Trial, TrialRunner};
use session::{Session, reading};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use zeronav_measure::result::companion::CompanionResult;
use zeronav_measure::result::fault::FaultResult;
use zeronav_measure::result::link::LinkResult;
use zeronav_measure::result::swap::SwapResult;
use zeronav_measure::result::trials::Disturbance;
use zeronav_measure::result::{Redirect, Restart, ServiceResult, Starved};
use zeronav_measure::start_up::StartStamps;
use zeronav_msgs::run::RunClock;
use zeronav_shell::clock::now_ns;
use zeronav_supervise::stack::{self, Stack};
use zeronav_supervise::warden;

/// What was seen of a run.
#[derive(Debug)]
pub(crate) struct Driven {
    /// How it ended.
    pub ending: Ending,
    /// Everything that was heard.
    pub collector: Collector,
    /// Moment of run time 0, monotonic. [ns]
    pub zero_ns: u64,
    /// Moments of the start.
    pub start: StartStamps,
    /// Run time at which the goals were sent. [ns]
    pub goals_run_ns: u64,
    /// Run time of the end. [ns]
    pub end_run_ns: u64,
    /// Tick of the end.
    pub end_tick: u64,
    /// Wall time of the drive.
    pub wall: Duration,
    /// Shared memory of the run. [bytes]
    pub shared_memory_bytes: u64,
    /// The seats and their processes.
    pub services: Vec<ServiceResult>,
    /// The processes that ran beside them.
    pub companions: Vec<CompanionResult>,
    /// What the link between two hosts carried.
    pub link: Option<LinkResult>,
    /// The restarts that were made.
    pub restarts: Vec<Restart>,
    /// Services that got no processor.
    pub starved: Vec<Starved>,
    /// Why a lockstep run goes otherwise the next time, one line each.
    pub not_reproducible: Vec<String>,
    /// Faults that were made on purpose.
    pub faults: Vec<FaultResult>,
    /// Goals that were given by hand.
    pub redirects: Vec<Redirect>,
    /// What became of the swaps.
    pub swaps: Vec<SwapResult>,
    /// What became of the trials; empty without.
    pub trials: Vec<Trial>,
    /// Trials that did not count because no path led through the obstacle.
    pub trials_missed: u64,
    /// What disturbed the machine from the first goal to the end; in real time only.
    pub disturbance: Option<Disturbance>,
}

impl Driven {
    /// A run of which nothing was seen.
    pub(crate) fn unseen(ending: Ending) -> Self {
        let not_reproducible = ending.cut_short().into_iter().collect();
        Self {
            ending,
            collector: Collector::default(),
            zero_ns: 0,
            start: StartStamps::default(),
            goals_run_ns: 0,
            end_run_ns: 0,
            end_tick: 0,
            wall: Duration::ZERO,
            shared_memory_bytes: 0,
            services: Vec::new(),
            companions: Vec::new(),
            link: None,
            restarts: Vec::new(),
            starved: Vec::new(),
            not_reproducible,
            faults: Vec::new(),
            redirects: Vec::new(),
            swaps: Vec::new(),
            trials: Vec::new(),
            trials_missed: 0,
            disturbance: None,
        }
    }

    /// Of all answers. The last tick is left out: while it is answered, launch may already stop the robot.
    pub(crate) fn run_hash(&self) -> String {
        self.collector.hash.value(self.end_tick.saturating_sub(1))
    }
}

/// Starts the stack, drives the scenario or the trials of `quota`, stops everything, leaves nothing
/// behind.
///
/// # Errors
/// One line when the stack could not be started at all.
pub(crate) fn drive(
    prepared: &Prepared,
    quota: Option<Quota>,
    interrupted: &Arc<AtomicBool>,
) -> Result<Driven, String> {
    let tick_ns = prepared.scenario.run.tick_ns();
    let clock = RunClock {
        mode: prepared.mode.code(),
        seed: prepared.seed,
        tick_ns,
        stages: u16::from(prepared.stages),
        foresight: prepared.scenario.foresight.bits(),
        ..RunClock::default()
    };
    warden::start();
    let mut stack = Stack::create(clock).map_err(|error| error.to_string())?;
    stack.scheduling = prepared.scenario.scheduling();
    stack.is_shared = !prepared.remote.is_empty();
    if let Err(error) = log::open(&prepared.logs) {
        tracing::warn!(%error, "no log of the supervisor");
    }
    tracing::info!(
        scenario = prepared.scenario.name,
        mode = %prepared.mode,
        seed = prepared.seed,
        domain = %stack.root().display(),
        "the run begins"
    );
    let topics_ns = now_ns();
    let mut driven = drive_stack(&mut stack, prepared, quota, interrupted);
    if let Ok(driven) = &mut driven {
        driven.start.topics_ns = topics_ns;
    }
    stack::close(stack);
    driven
}

fn drive_stack(
    stack: &mut Stack,
    prepared: &Prepared,
    quota: Option<Quota>,
    interrupted: &Arc<AtomicBool>,
) -> Result<Driven, String> {
    let started = Instant::now();
    let Prepared {
        scenario,
        world,
        remote,
        ..
    } = prepared;
    let configs = configs::write(scenario, world, remote, stack.root())?;
    let configs_ns = now_ns();
    for (role, delay) in &prepared.delays {
        stack.impede(*role, *delay, 0);
    }
    let mut session = Session::new(prepared, quota, interrupted, configs);
    let ending = session.run(stack)?;
    let wall = started.elapsed();
    let end_tick = session.end_tick(&ending);
    session.collector.totals.end_at(end_tick);
    session.collector.reasons.end_at(end_tick);
    tracing::info!(outcome = ending.outcome(), end_tick, "the run ends");
    if let Some(folder) = stack.folder() {
        recorder::say_end(folder, end_tick, ending.outcome());
    }
    let disturbance = session.begin.reading.take().map(|before| {
        let spans = session.collector.records.spans.iter();
        reading(stack).since(&before, spans)
    });
    let not_reproducible = session.not_reproducible(&ending);
    let starved = session.restarter.starved();
    session.heal_all(stack);
    session.stop(stack);
    let shared_memory_bytes = stack.shared_memory_bytes();
    let services = seat_report::stop(stack, &session.restarter, prepared);
    session.listen(stack);
    session.save_last_pose();
    session.collector.film.end();
    let link = host::link_result(stack.root());
    let companions = session.companions.stop();
    session.conclude_recording();
    let (trials, trials_missed) = session
        .trial_runner
        .take()
        .map(TrialRunner::into_trials)
        .unwrap_or_default();
    Ok(Driven {
        trials,
        trials_missed,
        disturbance,
        ending,
        zero_ns: stack.roster.clock.zero_ns,
        start: StartStamps {
            command_ns: command_start::at_ns(),
            prepared_ns: prepared.ready_ns,
            configs_ns,
            ..core::mem::take(&mut session.begin.stamps)
        },
        goals_run_ns: session.begin.goals_run_ns,
        end_run_ns: end_tick * prepared.scenario.run.tick_ns(),
        end_tick,
        wall,
        shared_memory_bytes,
        services,
        companions,
        link,
        restarts: session.restarter.records().to_vec(),
        starved,
        not_reproducible,
        faults: session.faults.results(),
        redirects: session.orders.records(),
        swaps: session.swaps.results(),
        collector: session.collector,
    })
}
