//! The shell with a C interface, for `zeronav_service.hpp`.
//!
//! A service in C++ is linked with this library: it has the loop, the lockstep rules, the checks of
//! received messages and the exit codes of the services in Rust, and only its `wake` is its own. Ports
//! are numbered in the order in which they were opened; a number that was not given is answered with
//! nothing. Every pointer that is handed out is valid until the callback returns.

#![allow(unsafe_code, reason = "a C interface takes and gives bare pointers")]

mod context;
mod ports;

pub use context::{
    Begun, Context, Newest, RunState, zeronav_awaits, zeronav_begin, zeronav_due, zeronav_fail,
    zeronav_finish, zeronav_get, zeronav_newest, zeronav_poll, zeronav_pose_at, zeronav_reader,
    zeronav_reason, zeronav_refresh, zeronav_run_state, zeronav_send, zeronav_spoken_tick,
    zeronav_writer,
};
use core::ffi::c_void;
pub use ports::RawView;
use std::io::Write;
use std::process::ExitCode;
use std::sync::OnceLock;
use zeronav_msgs::role::Role;
use zeronav_shell::doorbell::Rung;
use zeronav_shell::{NoConfig, Service, Shell, StartError, run};

/// A service in C++.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Callbacks {
    /// Opens the ports; the service itself, or null when that failed.
    pub open: extern "C" fn(*mut Context<'_>) -> *mut c_void,
    /// One wake, with a bit for each event that rang.
    pub wake: extern "C" fn(*mut c_void, *mut Context<'_>, u64),
    /// Ends the service.
    pub close: extern "C" fn(*mut c_void),
}

/// Of this process.
static CALLBACKS: OnceLock<Callbacks> = OnceLock::new();

/// Runs the service in the seat with the code `role` until it is asked to stop; its exit code. The
/// flags are those of the process.
#[unsafe(no_mangle)]
pub extern "C" fn zeronav_run(role: u16, callbacks: Callbacks) -> i32 {
    let _ = CALLBACKS.set(callbacks);
    let code = match Role::from_code(role) {
        Some(Role::Mapping) => run::<Foreign<{ Role::Mapping.code() }>>(),
        Some(Role::GlobalPlanner) => run::<Foreign<{ Role::GlobalPlanner.code() }>>(),
        Some(Role::LocalPlanner) => run::<Foreign<{ Role::LocalPlanner.code() }>>(),
        Some(Role::CollisionGuard) => run::<Foreign<{ Role::CollisionGuard.code() }>>(),
        other => no_seat(other),
    };
    // An exit code has no other way out than this one.
    (0..=u8::MAX)
        .find(|one| ExitCode::from(*one) == code)
        .map_or(1, i32::from)
}

/// Says on standard error that no service in C++ can have this role.
fn no_seat(role: Option<Role>) -> ExitCode {
    let name = role.map_or("unknown", Role::label);
    let problem = format!(
        "no service in C++ can take the seat {name}; it takes mapping, global_planner, \
         local_planner or collision_guard"
    );
    // Nothing is left to which a failure to write could be told.
    let _ = writeln!(std::io::stderr(), "{problem}");
    ExitCode::from(2)
}

/// A service in the seat with the code `ROLE`.
struct Foreign<const ROLE: u16> {
    state: context::State,
    callbacks: Callbacks,
    service: *mut c_void,
}

impl<const ROLE: u16> Service for Foreign<ROLE> {
    const ROLE: Role = match Role::from_code(ROLE) {
        Some(role) => role,
        None => panic!("a role"),
    };
    type Config = NoConfig;

    fn open(shell: &mut Shell, _config: NoConfig) -> Result<Self, StartError> {
        let callbacks = *CALLBACKS
            .get()
            .ok_or_else(|| StartError::Usage("the service has no callbacks".to_owned()))?;
        let mut state = context::State::open(shell.peer())?;
        let mut context = Context::new(shell, &mut state);
        let service = (callbacks.open)(&raw mut context);
        if service.is_null() {
            return Err(state.failure("the service did not open"));
        }
        Ok(Self {
            state,
            callbacks,
            service,
        })
    }

    fn wake(&mut self, shell: &mut Shell, rung: Rung) -> Result<(), StartError> {
        self.state.poll(shell);
        let mut context = Context::new(shell, &mut self.state);
        (self.callbacks.wake)(self.service, &raw mut context, rung.0);
        self.state.take_failure()
    }

    fn is_at_rest(&self) -> bool {
        self.state.is_at_rest()
    }
}

impl<const ROLE: u16> Drop for Foreign<ROLE> {
    fn drop(&mut self) {
        (self.callbacks.close)(self.service);
    }
}
