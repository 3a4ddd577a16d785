//! Which processor time the threads of a recorder take from the stack beside it.
//!
//! Where the system does not allow it, a thread goes on as it is: recording is worth more than the priority.
//!
//! The two threads share the allocator and a channel. An idle thread that is preempted while it holds a lock of theirs
//! holds up the reader; should that take longer than the stack's queues last, the verdict counts what was missed.

/// How much lower than that of the stack the priority of the reading thread is.
const NICER: i32 = 5;

/// The calling thread, and those that it starts, come behind the stack: they wait until a processor is free rather than
/// take one away when they wake. They still get their share of a busy machine.
pub(crate) fn behind_the_stack() {
    let _ = rustix::process::nice(NICER);
    set(libc::SCHED_BATCH);
}

/// The calling thread runs on otherwise idle processors only, and is preempted at once. On a busy machine it gets next to
/// nothing.
pub(crate) fn when_idle() {
    set(libc::SCHED_IDLE);
}

#[allow(
    unsafe_code,
    reason = "no safe crate of the project sets the policy of a thread"
)]
fn set(policy: i32) {
    let parameters = libc::sched_param { sched_priority: 0 };
    // SAFETY: 0 is the calling thread, and `parameters` outlives the call.
    unsafe {
        libc::sched_setscheduler(0, policy, &raw const parameters);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Policy and nice value of the calling thread, fields 41 and 19 of `proc_pid_stat(5)`.
    fn own() -> (i32, i32) {
        let stat = std::fs::read_to_string("/proc/thread-self/stat").expect("this thread");
        let (_, fields) = stat.rsplit_once(") ").expect("a name");
        let fields: Vec<&str> = fields.split_ascii_whitespace().collect();
        let field = |number: usize| fields[number - 3].parse().expect("a number");
        (field(41), field(19))
    }

    #[test]
    fn a_thread_steps_behind_the_others_and_one_that_it_starts_does_too() {
        let before = own();
        let seen = std::thread::spawn(|| {
            behind_the_stack();
            let reading = own();
            let inherited = std::thread::spawn(own).join().expect("it ran");
            when_idle();
            (reading, inherited, own())
        });
        let (reading, inherited, idle) = seen.join().expect("it ran");
        let nice = (before.1 + NICER).min(19);
        assert_eq!(reading, (libc::SCHED_BATCH, nice));
        assert_eq!(inherited, reading);
        assert_eq!(idle.0, libc::SCHED_IDLE);
        assert_eq!(own(), before, "the thread that started them");
    }
}
