//! The signals that stop zeronav: the robot comes to rest, the result is written, nothing is left.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;
use zeronav_shell::clock::now_ns;

/// A second Ctrl-C forces the end when it comes this much later than the first signal. Wrappers such
/// as `timeout` pass on what the terminal sends, too, so that one key press comes twice at once.
const SECOND_AFTER: Duration = Duration::from_millis(500);

/// A flag that SIGINT (Ctrl-C), SIGTERM, SIGQUIT and SIGHUP raise. A second Ctrl-C ends this process
/// at once; the services then see that launch is gone and bring the robot to rest by themselves.
///
/// # Errors
/// One line when the system refuses.
pub fn interrupts() -> Result<Arc<AtomicBool>, String> {
    let interrupted = Arc::new(AtomicBool::new(false));
    force_with_second_interrupt().map_err(|error| format!("catching signals: {error}"))?;
    for signal in zeronav_shell::signals::stopping() {
        signal_hook::flag::register(signal, Arc::clone(&interrupted))
            .map_err(|error| format!("catching signals: {error}"))?;
    }
    Ok(interrupted)
}

/// Flags that the keyboard raises (SIGINT, SIGQUIT), and that SIGTERM and SIGHUP do. For a command with another
/// program in its terminal, which gets what the keyboard sends, too: nothing forces the end.
///
/// # Errors
/// One line when the system refuses.
pub fn keyboard_and_others() -> Result<[Arc<AtomicBool>; 2], String> {
    use signal_hook::consts::{SIGINT, SIGQUIT};
    let flags = [(), ()].map(|()| Arc::new(AtomicBool::new(false)));
    for signal in zeronav_shell::signals::stopping() {
        let flag = &flags[usize::from(![SIGINT, SIGQUIT].contains(&signal))];
        signal_hook::flag::register(signal, Arc::clone(flag))
            .map_err(|error| format!("catching signals: {error}"))?;
    }
    Ok(flags)
}

#[allow(
    unsafe_code,
    reason = "a main loop that is stuck cannot end the process, only a signal handler can"
)]
fn force_with_second_interrupt() -> std::io::Result<()> {
    let exit_code = i32::from(crate::exit::EXIT_INTERRUPTED);
    let first_ns = AtomicU64::new(0);
    let force = move || {
        let now_ns = now_ns();
        let first = first_ns.compare_exchange(0, now_ns, Ordering::Relaxed, Ordering::Relaxed);
        if let Err(first_ns) = first
            && Duration::from_nanos(now_ns.saturating_sub(first_ns)) > SECOND_AFTER
        {
            signal_hook::low_level::exit(exit_code);
        }
    };
    // SAFETY: the handler reads a clock, compares atomics and may call `_exit`; all three are
    // async-signal-safe, and it neither allocates nor takes a lock nor panics.
    unsafe { signal_hook::low_level::register(signal_hook::consts::SIGINT, force) }?;
    Ok(())
}

/// A file that becomes larger than `ulimit -f` allows is an error of the write then, which is told, and
/// not the end of this process.
pub fn survive_file_limit() {
    let noted = Arc::new(AtomicBool::new(false));
    if let Err(error) = signal_hook::flag::register(libc::SIGXFSZ, noted) {
        tracing::warn!(%error, "SIGXFSZ ends this process");
    }
}
