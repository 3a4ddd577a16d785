//! How the kernel is asked to schedule a service, and what it grants.
//!
//! Policy, nice value and processors are set between fork and exec, so that every thread of the
//! service inherits them, whatever language it is written in. Memory can only be locked by the
//! process itself: it is asked to by [`zeronav_shell::LOCK_MEMORY`].

use rustix::process::setpriority_process;
use rustix::thread::{CpuSet, sched_setaffinity};
use std::os::unix::process::CommandExt;
use std::process::Command;
use zeronav_measure::result::scheduling::Scheduling;
use zeronav_params::Setting;
use zeronav_scenario::scheduling::{Policy, SchedulingSpec};
use zeronav_shell::LOCK_MEMORY;

/// The kernel's number of a policy.
const fn number(policy: Policy) -> i32 {
    match policy {
        Policy::Other => libc::SCHED_OTHER,
        Policy::Fifo => libc::SCHED_FIFO,
        Policy::RoundRobin => libc::SCHED_RR,
        Policy::Batch => libc::SCHED_BATCH,
        Policy::Idle => libc::SCHED_IDLE,
    }
}

/// The word for the kernel's number.
fn word(policy: i32) -> String {
    let all = [
        Policy::Other,
        Policy::Batch,
        Policy::Idle,
        Policy::Fifo,
        Policy::RoundRobin,
    ];
    let found = all.into_iter().find(|one| number(*one) == policy);
    found.map_or_else(|| policy.to_string(), |one| one.value().to_string())
}

/// Has a process that `command` starts scheduled as `spec` says. What is not granted is left as it
/// is: [`read`] tells.
#[allow(
    unsafe_code,
    reason = "threads inherit only what is set between fork and exec"
)]
pub(super) fn ask(command: &mut Command, spec: &SchedulingSpec) {
    if spec.lock_memory {
        command.env(LOCK_MEMORY, "1");
    }
    let (policy, nice) = (number(spec.policy), spec.nice);
    let parameters = libc::sched_param {
        sched_priority: spec.priority,
    };
    let mut cpus = CpuSet::new();
    for cpu in &spec.cpus {
        cpus.set(*cpu);
    }
    // SAFETY: the closure runs in the forked child before exec and makes only system calls that are
    // async-signal-safe; it allocates nothing and takes no lock, and `parameters` outlives the call.
    unsafe {
        command.pre_exec(move || {
            if cpus.count() > 0 {
                let _ = sched_setaffinity(None, &cpus);
            }
            if policy != libc::SCHED_OTHER {
                libc::sched_setscheduler(0, policy, &raw const parameters);
            }
            if nice != 0 {
                let _ = setpriority_process(None, nice);
            }
            Ok(())
        });
    }
}

/// How the process is scheduled; `None` when there is none. `spec` is what was asked for.
#[must_use]
pub(super) fn read(pid: u32, spec: Option<&SchedulingSpec>) -> Option<Scheduling> {
    let read = |name: &str| std::fs::read_to_string(format!("/proc/{pid}/{name}")).ok();
    parse(&read("stat")?, &read("status")?, spec)
}

/// From `/proc/PID/stat`, fields 19, 40 and 41 of `proc_pid_stat(5)`, and `/proc/PID/status`.
fn parse(stat: &str, status: &str, spec: Option<&SchedulingSpec>) -> Option<Scheduling> {
    // The name in parentheses may hold anything; field 3 follows it.
    let fields: Vec<&str> = stat.rsplit(") ").next()?.split_ascii_whitespace().collect();
    let field = |number: usize| fields.get(number - 3)?.parse::<i32>().ok();
    let value = |key: &str| status.lines().find_map(|line| line.strip_prefix(key));
    let mut scheduling = Scheduling {
        policy: word(field(41)?),
        priority: u32::try_from(field(40)?).unwrap_or(0),
        nice: field(19)?,
        cpus: value("Cpus_allowed_list:")?.trim().to_owned(),
        memory_locked: value("VmLck:").is_some_and(|rest| rest.trim() != "0 kB"),
        refused: Vec::new(),
    };
    scheduling.refused = spec.map_or_else(Vec::new, |spec| refused(spec, &scheduling));
    Some(scheduling)
}

/// What was asked for and not granted.
fn refused(spec: &SchedulingSpec, granted: &Scheduling) -> Vec<String> {
    let mut refused = Vec::new();
    let policy = word(number(spec.policy));
    let priority = u32::try_from(spec.priority).unwrap_or(0);
    if (granted.policy != policy) || (granted.priority != priority) {
        refused.push(format!(
            "policy {policy} with priority {priority} (needs CAP_SYS_NICE, or `ulimit -r {priority}`)"
        ));
    }
    if spec.nice != granted.nice && !spec.policy.is_real_time() {
        let limit = 20 - spec.nice;
        refused.push(format!(
            "nice {} (needs CAP_SYS_NICE, or `ulimit -e {limit}`)",
            spec.nice
        ));
    }
    let allowed = listed(&granted.cpus);
    let missing: Vec<usize> = (spec.cpus.iter().copied())
        .filter(|cpu| !allowed.contains(cpu))
        .collect();
    if !missing.is_empty() {
        refused.push(format!(
            "cpus {missing:?} (it may use {} alone)",
            granted.cpus
        ));
    }
    if spec.lock_memory && !granted.memory_locked {
        refused.push("lock_memory (needs CAP_IPC_LOCK, or `ulimit -l unlimited`)".to_owned());
    }
    refused
}

/// The processors of a list such as `0-3,6`.
fn listed(text: &str) -> Vec<usize> {
    let range = |part: &str| {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        Some(first.parse().ok()?..=last.parse().ok()?)
    };
    text.split(',').filter_map(range).flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATUS: &str = "Name:\tmapping\nCpus_allowed_list:\t0-1,3\nVmLck:\t       0 kB\n";

    /// A line of `/proc/PID/stat`, with a name like none.
    fn stat(nice: i32, priority: u32, policy: i32) -> String {
        let zeros = |n: usize| vec!["0"; n].join(" ");
        format!(
            "7 (a) b) S {} {nice} {} {priority} {policy} 0 0",
            zeros(15),
            zeros(20)
        )
    }

    #[test]
    fn the_kernels_lines_are_read_by_their_fields() {
        let granted = parse(&stat(-5, 10, 1), STATUS, None).expect("all fields are there");
        let expected = Scheduling {
            policy: "fifo".to_owned(),
            priority: 10,
            nice: -5,
            cpus: "0-1,3".to_owned(),
            memory_locked: false,
            refused: Vec::new(),
        };
        assert_eq!(granted, expected);
        assert_eq!(granted.in_words(), "fifo 10, nice -5 on 0-1,3");
        let locked = STATUS.replace("       0 kB", "    4096 kB");
        let granted = parse(&stat(0, 0, 6), &locked, None).expect("all fields are there");
        assert_eq!(
            granted.in_words(),
            "6 on 0-1,3, memory locked",
            "no policy of ours"
        );
        assert_eq!(parse("7 (a) S 1", STATUS, None), None);
    }

    #[test]
    fn what_was_not_granted_is_named_with_what_it_needs() {
        let spec = SchedulingSpec {
            policy: Policy::Fifo,
            priority: 10,
            cpus: vec![1, 2],
            lock_memory: true,
            ..SchedulingSpec::default()
        };
        assert_eq!(zeronav_params::check(&spec), Ok(()));
        let refused = |nice, priority, policy, spec: &SchedulingSpec| {
            let read = parse(&stat(nice, priority, policy), STATUS, Some(spec));
            read.expect("all fields are there").refused
        };
        let all = refused(0, 0, 0, &spec);
        assert_eq!(all.len(), 3, "{all:?}");
        for (said, word) in all.iter().zip(["ulimit -r 10", "[2]", "ulimit -l"]) {
            assert!(said.contains(word), "{said}");
        }
        assert_eq!(refused(0, 10, 1, &spec).len(), 2);
        let nice = SchedulingSpec {
            nice: -5,
            ..SchedulingSpec::default()
        };
        assert!(refused(0, 0, 0, &nice)[0].contains("ulimit -e 25"));
        assert!(refused(-5, 0, 0, &nice).is_empty());
    }

    #[test]
    fn values_belong_to_their_policies() {
        let check = |policy, priority, nice| {
            let spec = SchedulingSpec {
                policy,
                priority,
                nice,
                ..SchedulingSpec::default()
            };
            zeronav_params::check(&spec).map_err(|error| error.path)
        };
        assert_eq!(check(Policy::RoundRobin, 99, 0), Ok(()));
        assert_eq!(check(Policy::Batch, 0, 19), Ok(()));
        for (policy, priority, nice, field) in [
            (Policy::Fifo, 0, 0, "priority"),
            (Policy::Other, 5, 0, "priority"),
            (Policy::Fifo, 5, 1, "nice"),
            (Policy::Idle, 0, 1, "nice"),
        ] {
            assert_eq!(check(policy, priority, nice), Err(field.to_owned()));
        }
    }

    #[test]
    fn a_process_starts_as_it_was_asked_for_and_without_what_is_refused() {
        let own = read(std::process::id(), None).expect("this process");
        let first = listed(&own.cpus)[0];
        let spec = SchedulingSpec {
            policy: Policy::Batch,
            nice: 7,
            cpus: vec![first, 1023],
            ..SchedulingSpec::default()
        };
        let mut command = Command::new("sleep");
        command.arg("60");
        ask(&mut command, &spec);
        let mut child = command.spawn().expect("sleep");
        let scheduling = read(child.id(), Some(&spec));
        child.kill().and_then(|()| child.wait()).expect("it ran");
        let scheduling = scheduling.expect("it ran");
        let granted = (scheduling.policy.as_str(), scheduling.nice);
        assert_eq!(granted, ("batch", 7));
        assert_eq!(scheduling.cpus, first.to_string(), "the one that there is");
        assert_eq!(scheduling.refused.len(), 1, "{scheduling:?}");
        assert!(scheduling.refused[0].contains("1023"), "{scheduling:?}");
    }
}
