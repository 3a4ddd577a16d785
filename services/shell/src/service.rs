//! A service, and the loop that all of them share.

use crate::clock::{host_ns, now_ns};
use crate::doorbell::{Rung, WAKE_AT_LEAST_NS};
use crate::error::{EXIT_STOPPED, StartError};
use crate::flags::{Flags, MemberFlags, Rates};
use crate::leaving::Leaving;
use crate::program;
use crate::shell::Shell;
use crate::signals;
use core::num::NonZeroU64;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::process::ExitCode;
use zeronav_msgs::role::Role;
use zeronav_params::Parameter;

/// A program that takes a seat.
pub trait Service: Sized {
    /// The seat.
    const ROLE: Role;
    /// Its configuration, TOML; an empty file gives the defaults.
    type Config: Serialize + DeserializeOwned;

    /// The algorithms that the configuration can name: key and one line of description.
    #[must_use]
    fn algorithms() -> Vec<(&'static str, String)> {
        Vec::new()
    }

    /// The parameters of its configuration, printed by `--print-params`.
    #[must_use]
    fn parameters() -> Vec<Parameter> {
        Vec::new()
    }

    /// Accepts configurations that it can work with, as far as that is known without a run. Called
    /// for `--print-config`, and before [`Self::open`].
    ///
    /// # Errors
    /// [`StartError::config`], naming the field.
    fn check(_config: &Self::Config) -> Result<(), StartError> {
        Ok(())
    }

    /// Accepts configurations that it can work with in a run with these rates. Called after
    /// [`Self::check`] when launch asks for a scenario.
    ///
    /// # Errors
    /// [`StartError::config`], naming the field and a value that would do.
    fn check_rates(_config: &Self::Config, _rates: Rates) -> Result<(), StartError> {
        Ok(())
    }

    /// Opens the ports. Nothing is known yet about the run.
    ///
    /// # Errors
    /// What keeps the service from starting.
    fn open(shell: &mut Shell, config: Self::Config) -> Result<Self, StartError>;

    /// One wake: poll the inputs, odometry first, and give the answers that are due. The next wake
    /// comes with the next ring, and not later than [`Shell::wake_by`] says.
    ///
    /// # Errors
    /// What ends the process as a crash.
    fn wake(&mut self, shell: &mut Shell, rung: Rung) -> Result<(), StartError>;

    /// True when the robot is stopped, as far as this service knows. When launch is gone, a service
    /// between requests and wheels goes on until then, or for 1.5 s.
    fn is_at_rest(&self) -> bool {
        false
    }
}

/// `main` of a service: flags, configuration, ports, loop, exit code.
#[must_use]
pub fn run<S: Service>() -> ExitCode {
    let flags: Flags = match program::flags() {
        Ok(flags) => flags,
        Err(code) => return code,
    };
    crate::logs::start(&flags.member.log_level);
    match start::<S>(&flags) {
        Ok(()) => ExitCode::from(EXIT_STOPPED),
        Err(error) if flags.member.print_config => {
            program::complain(&error.to_string());
            error.exit_code()
        }
        Err(error) => {
            tracing::error!(role = %S::ROLE, "{error}");
            error.exit_code()
        }
    }
}

fn start<S: Service>(flags: &Flags) -> Result<(), StartError> {
    if flags.list {
        for (key, line) in S::algorithms() {
            program::print(&format!("{key}\t{line}\n"))?;
        }
        return Ok(());
    }
    if flags.member.print_params {
        return program::print_parameters(&S::parameters());
    }
    let config: S::Config = flags.member.read_config(|config| {
        S::check(config)?;
        (flags.rates).map_or(Ok(()), |rates| S::check_rates(config, rates))
    })?;
    if flags.member.print_config {
        return program::print(&MemberFlags::config_text(&config)?);
    }
    let (stop, signals) = signals::catch()?;
    // The default slack of 50 us would be the largest part of every wait.
    if let Some(one) = NonZeroU64::new(1) {
        let _ = rustix::thread::set_current_timer_slack(Some(one));
    }
    crate::locked::lock_if_asked();
    let mut shell = Shell::open(flags, S::ROLE, signals)?;
    let mut service = S::open(&mut shell, config)?;
    let mut leaving = Leaving::new(stop);
    serve(&mut shell, &mut service, &mut leaving)?;
    shell.heartbeat.stopping();
    shell.beat(now_ns());
    if !leaving.is_orphaned() {
        tracing::debug!(role = %S::ROLE, "asked to stop");
        return Ok(());
    }
    // Ports first. With launch gone, the last service removes what is left of the run.
    drop(service);
    let domain = shell.leave();
    let root = domain.root().to_owned();
    if let Err(error) = domain.close() {
        tracing::warn!(root = %root.display(), %error, "the domain could not be removed");
    }
    Ok(())
}

/// Wakes the service until it has to leave.
fn serve<S: Service>(
    shell: &mut Shell,
    service: &mut S,
    leaving: &mut Leaving,
) -> Result<(), StartError> {
    let mut deadline_ns = 0;
    loop {
        let rung = shell.wait(deadline_ns);
        if leaving.look(shell, host_ns()) {
            return Ok(());
        }
        shell.heartbeat.progress();
        // Before it is known which processes are obeyed, every message on a stream would be
        // rejected and lost.
        if shell.roster().is_known() {
            service.wake(shell, rung)?;
        }
        shell.ring();
        let now = now_ns();
        shell.beat(now);
        if leaving.rests(shell, host_ns(), || service.is_at_rest()) {
            return Ok(());
        }
        deadline_ns = shell
            .wake_by_ns()
            .min(now + WAKE_AT_LEAST_NS)
            .min(leaving.deadline_ns());
    }
}
