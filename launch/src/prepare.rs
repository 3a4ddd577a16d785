//! Everything that can be wrong is found here, before anything is started.

use crate::configs;
use crate::live_view::PageArgs;
use crate::on_host::{self, OnHost};
use crate::open_files;
use crate::program;
use crate::recorder::{RecordTo, file_of_round};
use crate::run_plan::{MachineLoad, RunPlan, Source, TRIAL_ROUNDS};
use crate::swap_order::SwapOrder;
use crate::swap_order::require::Clause;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::time::Duration;
use zeronav_casts::Cast;
use zeronav_console::artifacts;
use zeronav_files::Folder;
use zeronav_msgs::role::Role;
use zeronav_msgs::run::{DELAY_STEP_NS, RunMode};
use zeronav_msgs::time::nanoseconds;
use zeronav_scenario::as_far::AsFar;
use zeronav_scenario::assignment::lay_over;
use zeronav_scenario::fault_plan;
use zeronav_scenario::hosts::host_of;
use zeronav_scenario::{Scenario, StackFault};
use zeronav_shell::clock::now_ns;
use zeronav_shell::memory;
use zeronav_supervise::binaries::{self, Needed};
use zeronav_supervise::child_log::LogPlace;
use zeronav_supervise::shared_memory;
use zeronav_world::spec::Trigger;
use zeronav_world::{Footprint, World};

/// A run that can be started.
#[derive(Debug)]
#[allow(clippy::struct_excessive_bools, reason = "independent choices")]
pub struct Prepared {
    /// The live page that is wanted.
    pub view: Option<PageArgs>,
    /// The file in which every message is recorded.
    pub recording: Option<PathBuf>,
    /// What to drive.
    pub scenario: Scenario,
    /// Its world.
    pub world: World,
    /// The robot's outline.
    pub footprint: Footprint,
    /// The binary of each seat that launch fills; the others are filled by hand.
    pub binaries: BTreeMap<Role, PathBuf>,
    /// Seats in which a program sits for a process on the other host.
    pub remote: Vec<Role>,
    /// The binary of each companion of the scenario.
    pub companions: BTreeMap<String, PathBuf>,
    /// Path of the run's own folder, for people.
    pub directory: PathBuf,
    /// That folder: what the run leaves is made in it.
    pub folder: Folder,
    /// The folder of the logs in it.
    pub logs: Folder,
    /// Real time or lockstep.
    pub mode: RunMode,
    /// Seed of everything random.
    pub seed: u64,
    /// What the services log.
    pub log_level: String,
    /// True when a line is wanted while it runs.
    pub progress: bool,
    /// Trials to make instead of the scenario's drive.
    pub trials: Option<u32>,
    /// True when the stack stays up and waits for goals.
    pub stays: bool,
    /// True when its robot shall be where the last one was left.
    pub resume_pose: bool,
    /// The tick before which a lockstep run is paused.
    pub stands_before: Option<u64>,
    /// True when the services time the stages of their cycles.
    pub stages: bool,
    /// What else the machine does.
    pub load: MachineLoad,
    /// Delays put into seats on purpose.
    pub delays: BTreeMap<Role, u16>,
    /// Swaps of the scenario, with the tick before which each begins.
    pub(crate) swaps: Vec<(u64, SwapOrder)>,
    /// Faults of the scenario, and those that were drawn from the seed.
    pub(crate) faults: Vec<StackFault>,
    /// When all of this was known, monotonic. [ns]
    pub(crate) ready_ns: u64,
}

impl Prepared {
    /// The log `name` of this run.
    pub(crate) fn log(&self, name: impl Into<String>) -> LogPlace {
        LogPlace::new(&self.logs, name)
    }

    /// The host that fills a seat; `None` when one computer fills all.
    pub(crate) fn host_of(&self, role: Role) -> Option<String> {
        let host = host_of(&self.scenario.hosts, role.label());
        host.filter(|_| !self.remote.is_empty()).map(str::to_owned)
    }

    /// Accepts a seat whose process is on this computer.
    ///
    /// # Errors
    /// One line for one on the other host, where a program stands in for it here.
    pub(crate) fn check_here(&self, role: Role) -> Result<(), String> {
        if !self.remote.contains(&role) {
            return Ok(());
        }
        let host = self.host_of(role).unwrap_or_default();
        Err(format!(
            "the process of {role} is on {host}: only what runs on this host can be killed or stopped here"
        ))
    }

    /// Time from scan to scan. [ns]
    #[must_use]
    pub fn scan_period_ns(&self) -> u64 {
        (1.0e9 / self.scenario.robot.lidar.rate_hz).round().to_u64()
    }
}

/// What a scenario comes to before anything is started.
#[derive(Debug)]
pub(crate) struct Checked {
    /// What to drive.
    pub scenario: Scenario,
    /// Its world.
    pub world: World,
    /// The robot's outline.
    pub footprint: Footprint,
    /// Warnings: what is probably not intended.
    pub warnings: Vec<String>,
    /// The binary of each seat that launch fills. Each has accepted its configuration.
    pub binaries: BTreeMap<Role, PathBuf>,
    /// What it is on one of its hosts; `None` = this computer fills every seat.
    pub on_host: Option<OnHost>,
    /// The binary of each of its companions. Each has accepted its configuration.
    pub companions: BTreeMap<String, PathBuf>,
    /// Its swaps, with the tick before which each begins.
    pub swaps: Vec<(u64, SwapOrder)>,
}

/// Reads a scenario and looks for everything that is wrong with it and with the binaries in its
/// seats, but for those that are `external`.
///
/// # Errors
/// A line for each thing that is wrong, with the fix.
pub(crate) fn check(source: &Source, external: &[Role]) -> Result<Checked, String> {
    check_scenario(load(source)?, external, None)
}

fn load(source: &Source) -> Result<AsFar, String> {
    let scenario = match source {
        Source::Named(name_or_path) => Scenario::load_as_far(name_or_path),
        Source::Text { name, text } => Scenario::of_text(name, text),
        Source::Map { map, robot, start } => Scenario::of_map(map, robot, *start).map(AsFar::from),
    };
    scenario.map_err(|error| error.to_string())
}

/// The scenario of a plan, with what the plan puts in the place of its words.
pub(crate) fn scenario_of(plan: &RunPlan) -> Result<AsFar, String> {
    let mut read = load(&plan.scenario)?;
    let scenario = &mut read.scenario;
    if let Some(rate_hz) = plan.rate_hz {
        scenario.robot.lidar.rate_hz = rate_hz;
    }
    for (role, service) in scenario.services.each_mut() {
        if let Some(binary) = plan.binaries.get(&role) {
            service.binary = Some(binary.clone());
        }
        if let Some(keys) = plan.settings.of(role) {
            lay_over(&mut service.config, keys.clone());
        }
    }
    Ok(read)
}

fn check_scenario(
    mut read: AsFar,
    external: &[Role],
    host: Option<&str>,
) -> Result<Checked, String> {
    let checked = read.examine();
    let of_scenario = !read.wrong.is_empty();
    let AsFar {
        mut scenario,
        wrong,
        ..
    } = read;
    let mut wrong: Vec<String> = wrong.iter().map(ToString::to_string).collect();
    let on_host = host.map(|host| on_host::lay_over(&mut scenario, host));
    let on_host = on_host.transpose().unwrap_or_else(|why| {
        wrong.push(why);
        None
    });
    let left_out = on_host.as_ref().map_or(&[][..], |it| &it.left_out);
    let left_out = [external, left_out].concat();
    let binaries = binaries_of(&scenario, &left_out, &mut wrong)?;
    if let Some(checked) = &checked {
        // The robot is told of robot and world, of which it says what has been said.
        let asked = binaries.iter();
        let asked = asked.filter(|(role, _)| !of_scenario || **role != Role::Robot);
        wrong.extend(configs::check(&scenario, &checked.world, asked)?);
    }
    let companions = companions_of(&scenario, &mut wrong);
    wrong.extend(configs::check_companions(&scenario, &companions)?);
    let elsewhere = on_host.as_ref().map_or_else(Vec::new, OnHost::elsewhere);
    let swaps = swaps_of(&scenario, &elsewhere, &mut wrong);
    let Some(zeronav_scenario::Checked {
        world,
        footprint,
        warnings,
    }) = checked.filter(|_| wrong.is_empty())
    else {
        return Err(wrong.join("\n"));
    };
    Ok(Checked {
        swaps,
        scenario,
        world,
        footprint,
        warnings: warnings.iter().map(ToString::to_string).collect(),
        binaries,
        on_host,
        companions,
    })
}

/// The binaries of the companions; those that there are not are `wrong`.
fn companions_of(scenario: &Scenario, wrong: &mut Vec<String>) -> BTreeMap<String, PathBuf> {
    let mut found = BTreeMap::new();
    for (name, companion) in &scenario.companions {
        let field = format!("companions.{name}.binary");
        let binary = program::named(scenario, &field, &companion.binary, wrong);
        found.extend(binary.map(|binary| (name.clone(), binary)));
    }
    found
}

/// The binaries of the seats that are not `external`; those that there are not are `wrong`.
fn binaries_of(
    scenario: &Scenario,
    external: &[Role],
    wrong: &mut Vec<String>,
) -> Result<BTreeMap<Role, PathBuf>, String> {
    let named = |role: Role| scenario.services.of(role)?.binary.clone();
    let any_named = Role::SERVICES.iter().any(|role| named(*role).is_some())
        || scenario
            .shadows()
            .any(|(_, shadow)| shadow.binary.is_some())
        || scenario.swaps.iter().any(|swap| swap.binary.is_some())
        || !scenario.companions.is_empty();
    binaries::refresh_under_cargo(if any_named {
        Needed::Any
    } else {
        Needed::Stock
    })?;
    let mut binaries = BTreeMap::new();
    for role in Role::SERVICES {
        if external.contains(&role) {
            continue;
        }
        let name = named(role).unwrap_or_else(|| PathBuf::from(binaries::stock(role)));
        let field = format!("services.{role}.binary");
        let found = program::named(scenario, &field, &name, wrong);
        binaries.extend(found.map(|found| (role, found)));
    }
    Ok(binaries)
}

/// The swaps of a scenario, or its shadow, with the tick before which each begins. Programs for seats that are
/// filled `elsewhere` are not looked for here.
fn swaps_of(
    scenario: &Scenario,
    elsewhere: &[Role],
    wrong: &mut Vec<String>,
) -> Vec<(u64, SwapOrder)> {
    let mut found = |field: &str, seat: &str, binary: Option<&PathBuf>| {
        let name = binary?;
        if elsewhere.iter().any(|role| role.label() == seat) {
            return name.file_name().map(PathBuf::from);
        }
        program::named(scenario, field, name, wrong)
    };
    let (mut swaps, mut refused) = (Vec::new(), Vec::new());
    for (role, shadow) in scenario.shadows() {
        let order = SwapOrder {
            role: role.to_string(),
            binary: found(
                &format!("services.{role}.shadow.binary"),
                role.label(),
                shadow.binary.as_ref(),
            ),
            config: shadow.config.clone(),
            shadow_s: None,
            keep_s: None,
            require: Vec::new(),
        };
        swaps.push((0, order));
    }
    for (index, swap) in scenario.swaps.iter().enumerate() {
        let field = |name: &str| format!("swaps[{index}].{name}");
        let binary = found(&field("binary"), &swap.service, swap.binary.as_ref());
        let require = swap
            .require
            .as_deref()
            .map_or(Ok(Vec::new()), Clause::parse_all)
            .map_err(|why| refused.push(scenario.error_at(&field("require"), &why).to_string()));
        let order = SwapOrder {
            role: swap.service.clone(),
            binary,
            config: swap.config.clone(),
            shadow_s: Some(swap.shadow_s),
            keep_s: Some(swap.keep_s),
            require: require.unwrap_or_default(),
        };
        let tick = nanoseconds(swap.at_s) / scenario.run.tick_ns().max(1);
        swaps.push((tick, order));
    }
    wrong.append(&mut refused);
    swaps
}

/// Reads and checks everything that can be wrong before anything is started.
///
/// # Errors
/// One line that names the thing and the fix.
pub(crate) fn prepare(plan: &RunPlan) -> Result<Prepared, String> {
    let Checked {
        mut scenario,
        world,
        footprint,
        warnings,
        binaries,
        on_host,
        companions,
        swaps,
    } = check_scenario(scenario_of(plan)?, &plan.external, plan.host.as_deref())?;
    on_host.as_ref().map_or(Ok(()), |it| it.accept(plan))?;
    for warning in &warnings {
        tracing::warn!("{warning}");
    }
    if plan.trials.is_some() {
        await_trials(&mut scenario)?;
        check_recordings(plan)?;
    }
    for (role, steps) in &plan.delays {
        check_delay(*role, *steps, &scenario)?;
    }
    open_files::raise()?;
    memory::check(shared_memory::planned_bytes(&scenario, &world))
        .and_then(|()| memory::check_inodes())
        .map_err(|error| error.to_string())?;
    let seed = plan.seed.unwrap_or(scenario.run.seed);
    let faults = faults_of(&scenario, plan.mode, seed)?;
    let (folder, logs) = run_folder(plan, &scenario.name)?;
    // Nobody sees a lockstep run go by, and trials are not to be disturbed.
    let is_seen = plan.trials.is_none() && (plan.stays || plan.mode == RunMode::RealTime);
    Ok(Prepared {
        view: plan.view.clone().filter(|_| is_seen),
        recording: (plan.record.as_ref()).map(|to| to.file(folder.path())),
        seed,
        log_level: plan.log_level.clone(),
        progress: plan.progress,
        trials: plan.trials,
        stays: plan.stays,
        resume_pose: plan.resume_pose,
        stands_before: None,
        // For the trace, which a stack in real time leaves.
        stages: plan.stages && plan.mode == RunMode::RealTime,
        load: plan.load,
        delays: plan.delays.clone(),
        swaps,
        faults,
        scenario,
        world,
        footprint,
        binaries,
        remote: on_host.map(|it| it.remote).unwrap_or_default(),
        companions,
        directory: folder.path().to_owned(),
        folder,
        logs,
        mode: plan.mode,
        ready_ns: now_ns(),
    })
}

/// The faults of a scenario, those that are drawn from `seed` included.
///
/// # Errors
/// The first one that a run in this mode cannot have.
fn faults_of(scenario: &Scenario, mode: RunMode, seed: u64) -> Result<Vec<StackFault>, String> {
    for (index, fault) in scenario.faults.iter().enumerate() {
        if let Some((field, why)) = fault.unfit(mode) {
            let field = format!("faults[{index}].{field}");
            return Err(scenario.error_at(&field, why).to_string());
        }
    }
    let hang_after_s = scenario.restart.hang_after_s;
    let random = scenario.random_faults.as_ref();
    let drawn = random.map(|random| fault_plan::draw(random, seed, mode, hang_after_s));
    let mut all = scenario.faults.clone();
    all.extend(drawn.into_iter().flatten());
    let ends = |fault: &&StackFault| matches!(fault.kind(), "kill" | "stop");
    let (n, most) = (all.iter().filter(ends).count(), scenario.restart.per_run);
    if u32::try_from(n).is_ok_and(|n| n > most) {
        tracing::warn!("{n} services are killed or stopped, but restart.per_run is {most}");
    }
    Ok(all)
}

/// Accepts delays that the hang watch does not take for a hang: a service that sleeps through a delay
/// does not beat, and the work of the answer itself takes its time, too.
pub(crate) fn check_delay(role: Role, steps: u16, scenario: &Scenario) -> Result<(), String> {
    let delay = Duration::from_nanos(u64::from(steps) * DELAY_STEP_NS);
    let most = scenario.restart.hang_after() / 2;
    if delay <= most {
        return Ok(());
    }
    Err(format!(
        "a delay {role}={}ms would be taken for a hang: at most half of restart.hang_after_s, {} ms",
        delay.as_millis(),
        most.as_millis()
    ))
}

/// The recorder of a later round may not find a file in the place of its own, after the rounds before were measured.
fn check_recordings(plan: &RunPlan) -> Result<(), String> {
    // The folder of the run is new.
    let Some(RecordTo::File(file)) = &plan.record else {
        return Ok(());
    };
    let mut files = (1..=TRIAL_ROUNDS).map(|round| file_of_round(file, round));
    match files.find(|file| file.symlink_metadata().is_ok()) {
        None => Ok(()),
        Some(there) => Err(format!(
            "{}: it exists; give --record another file, or remove it",
            there.display()
        )),
    }
}

/// Takes the script of the trials' obstacle away: it comes when it is put somewhere.
fn await_trials(scenario: &mut Scenario) -> Result<(), String> {
    /// Later than any run. [s]
    const NEVER_S: f64 = 1.0e6;
    let Some(trials) = &scenario.trials else {
        return Err(format!(
            "{} has no [trials]: say there which obstacle is dropped, where, and between which goals",
            scenario.name
        ));
    };
    let obstacles = scenario.world.obstacles.iter_mut();
    for obstacle in obstacles.filter(|obstacle| obstacle.name == trials.obstacle) {
        obstacle.appears = Some(Trigger {
            at_s: Some(NEVER_S),
            robot_near: None,
        });
        obstacle.lasts_s = None;
    }
    Ok(())
}

/// Makes the run's own folder and that of its logs.
fn run_folder(plan: &RunPlan, scenario: &str) -> Result<(Folder, Folder), String> {
    let folder = match &plan.folder {
        Some(name) => {
            let path = plan.out.join(name);
            let made = Folder::make(&plan.out).and_then(|out| out.create(name));
            made.map_err(|error| match error.kind() {
                ErrorKind::PermissionDenied => format!(
                    "{}: name a folder of your own with --out",
                    artifacts::refused(&path, &error)
                ),
                ErrorKind::AlreadyExists => format!(
                    "{}: it is there already; give --folder another name",
                    path.display()
                ),
                _ => artifacts::refused(&path, &error),
            })?
        }
        None => artifacts::new_folder(&plan.out, scenario)?,
    };
    let logs = folder.create("logs");
    let logs = logs.map_err(|error| artifacts::refused(&folder.path().join("logs"), &error))?;
    Ok((folder, logs))
}
