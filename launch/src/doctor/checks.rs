//! What is wrong with a machine, from what its files say.

use super::logind::Facts;
use crate::open_files;
use serde::Serialize;
use std::path::PathBuf;
use zeronav_supervise::shared_memory::most_bytes;

/// Clocks that are read without a system call.
const FAST_CLOCKS: [&str; 6] = [
    "tsc",
    "kvm-clock",
    "hyperv_clocksource_tsc_page",
    "xen",
    "arch_sys_counter",
    "riscv_clocksource",
];

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Level {
    /// As it should be.
    Ok,
    /// Stacks run, but not as well or as safely as they could.
    Warning,
    /// Stacks do not run.
    Error,
}

/// The result of one check.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct Finding {
    /// What was looked at.
    pub check: &'static str,
    /// How it is.
    pub level: Level,
    /// What was seen.
    pub seen: String,
    /// What to do about it.
    pub fix: Option<String>,
}

impl Finding {
    pub(super) fn ok(check: &'static str, seen: impl Into<String>) -> Self {
        Self {
            check,
            level: Level::Ok,
            seen: seen.into(),
            fix: None,
        }
    }

    pub(super) fn bad(
        check: &'static str,
        level: Level,
        seen: impl Into<String>,
        fix: impl Into<String>,
    ) -> Self {
        Self {
            check,
            level,
            seen: seen.into(),
            fix: Some(fix.into()),
        }
    }
}

/// Runs that go on, domains that were removed, and segments whose domain is gone.
pub(super) fn leftovers(alive: usize, removed: &[PathBuf], stray: &[PathBuf]) -> Finding {
    const CHECK: &str = "leftovers";
    let names = |paths: &[PathBuf]| {
        let names: Vec<String> = paths
            .iter()
            .map(|path| path.display().to_string())
            .collect();
        names.join(" ")
    };
    if !stray.is_empty() {
        return Finding::bad(
            CHECK,
            Level::Warning,
            format!("{} segments of runs that are gone", stray.len()),
            format!("rm {}", names(stray)),
        );
    }
    let removed = match removed {
        [] => "none".to_owned(),
        removed => format!("removed {}", names(removed)),
    };
    Finding::ok(CHECK, format!("{removed}; runs that go on: {alive}"))
}

/// Size of /dev/shm and what is free of it, [bytes]; `None` without one.
pub(super) fn shared_memory(shm: Option<[u64; 2]>) -> Finding {
    const CHECK: &str = "shared memory";
    let Some([size, free]) = shm else {
        return Finding::bad(
            CHECK,
            Level::Error,
            "no /dev/shm",
            "mount -t tmpfs -o mode=1777,size=1G tmpfs /dev/shm",
        );
    };
    let needed = most_bytes();
    let seen = format!(
        "/dev/shm has {} MB, {} MB are free; a stack takes up to {} MB",
        size / 1_000_000,
        free / 1_000_000,
        needed.div_ceil(1_000_000)
    );
    let fix = "mount -o remount,size=1G /dev/shm (docker: --shm-size=1g), or remove what fills it";
    // A small map takes a quarter of that.
    match free {
        free if free < needed / 4 => Finding::bad(CHECK, Level::Error, seen, fix),
        free if free < needed => Finding::bad(CHECK, Level::Warning, seen, fix),
        _ => Finding::ok(CHECK, seen),
    }
}

/// Limit of open files, soft and hard; `None` is no limit.
pub(super) fn open_files(soft: Option<u64>, hard: Option<u64>) -> Finding {
    const CHECK: &str = "open files";
    let needed = open_files::NEEDED;
    let seen = format!("{} (at most {})", limit(soft), limit(hard));
    if hard.is_some_and(|hard| hard < needed) {
        let fix = format!("ulimit -n {needed}, or LimitNOFILE={needed} of the systemd unit");
        return Finding::bad(CHECK, Level::Error, seen, fix);
    }
    // The soft limit is raised when a stack starts.
    Finding::ok(CHECK, seen)
}

fn limit(limit: Option<u64>) -> String {
    limit.map_or_else(|| "no limit".to_owned(), |limit| limit.to_string())
}

/// Limit of locked memory, [bytes], and /proc/swaps: a stack locks no memory, so where there is swap
/// its shared memory may be written to a disk.
pub(super) fn locked_memory(soft: Option<u64>, swaps: &str) -> Finding {
    const CHECK: &str = "locked memory";
    let limit = soft.map_or_else(|| "no limit".to_owned(), |bytes| format!("{bytes} bytes"));
    // The first line is the heading.
    let swaps: Vec<&str> = (swaps.lines().skip(1))
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    if swaps.is_empty() {
        return Finding::ok(CHECK, format!("{limit}; no swap"));
    }
    Finding::bad(
        CHECK,
        Level::Warning,
        format!("{limit}; memory may be swapped to {}", swaps.join(", ")),
        "swapoff -a on a robot, or sysctl vm.swappiness=1",
    )
}

/// The clock that the kernel uses; `None` when it does not say.
pub(super) fn clock_source(name: Option<&str>) -> Finding {
    const CHECK: &str = "clock";
    let name = name.map_or("", str::trim);
    if FAST_CLOCKS.contains(&name) {
        return Finding::ok(CHECK, name);
    }
    let seen = match name {
        "" => "the kernel does not say which".to_owned(),
        name => format!("{name}, which takes a system call to read"),
    };
    Finding::bad(
        CHECK,
        Level::Warning,
        seen,
        "latencies are measured less exactly; choose another in \
         /sys/devices/system/clocksource/clocksource0/current_clocksource",
    )
}

/// Cores that this process may use.
pub(super) fn cores(cores: usize) -> Finding {
    const CHECK: &str = "cores";
    if cores >= 2 {
        return Finding::ok(CHECK, cores.to_string());
    }
    Finding::bad(
        CHECK,
        Level::Warning,
        format!("{cores}: services wait for each other"),
        "give the stack two cores (taskset, docker --cpus, CPUQuota=), or run with --lockstep",
    )
}

/// The frequency governor of every core that has one.
pub(super) fn governor(governors: &[String]) -> Finding {
    const CHECK: &str = "governor";
    let mut names: Vec<&str> = governors.iter().map(|name| name.trim()).collect();
    names.sort_unstable();
    names.dedup();
    match names.as_slice() {
        [] => Finding::ok(CHECK, "none: the frequency is not the kernel's"),
        ["performance"] => Finding::ok(CHECK, "performance"),
        names => Finding::bad(
            CHECK,
            Level::Warning,
            format!(
                "{}: cores slow down while the stack waits",
                names.join(", ")
            ),
            "cpupower frequency-set -g performance",
        ),
    }
}

/// What keeps logind from deleting the shared memory of `user`.
pub(super) fn ways_out(user: &str) -> String {
    format!(
        "loginctl enable-linger {user}, or run the stack as a system user, or RemoveIPC=no in \
         /etc/systemd/logind.conf"
    )
}

/// Whether logind deletes the caller's shared memory.
pub(super) fn remove_ipc(facts: &Facts) -> Finding {
    const CHECK: &str = "logind";
    if facts.are_a_danger() {
        let by = facts.removes.as_ref().map_or_else(
            || "its default".to_owned(),
            |(_, file)| file.display().to_string(),
        );
        return Finding::bad(
            CHECK,
            Level::Warning,
            format!(
                "RemoveIPC=yes ({by}): the shared memory of {} is deleted at logout, and with it a \
                 stack that was left running",
                facts.user
            ),
            ways_out(&facts.user),
        );
    }
    let seen = match facts {
        Facts { runs: false, .. } => "not there".to_owned(),
        Facts {
            removes: Some((false, file)),
            ..
        } => format!("RemoveIPC=no ({})", file.display()),
        Facts {
            lingers: true,
            user,
            ..
        } => format!("{user} lingers"),
        Facts { user, .. } => format!("{user} is a system user"),
    };
    Finding::ok(CHECK, seen)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GIB: u64 = 1 << 30;

    #[test]
    fn shared_memory_is_compared_with_what_a_stack_takes() {
        let needed = most_bytes();
        assert!(
            (10_000_000..200_000_000).contains(&needed),
            "{needed} bytes"
        );
        let level = |free| shared_memory(Some([GIB, free])).level;
        assert_eq!(level(needed), Level::Ok);
        assert_eq!(level(needed - 1), Level::Warning);
        assert_eq!(level(needed / 4 - 1), Level::Error);
        assert_eq!(shared_memory(None).level, Level::Error);
    }

    #[test]
    fn limits_that_cannot_be_raised_are_errors() {
        assert_eq!(open_files(Some(256), Some(4096)).level, Level::Ok);
        assert_eq!(open_files(Some(256), Some(256)).level, Level::Error);
        assert_eq!(open_files(None, None).level, Level::Ok);
    }

    #[test]
    fn swap_is_seen_in_the_kernels_table() {
        let heading = "Filename\t\t\t\tType\t\tSize\t\tUsed\t\tPriority\n";
        assert_eq!(locked_memory(Some(8 << 20), heading).level, Level::Ok);
        assert_eq!(locked_memory(None, "").level, Level::Ok);
        let one = format!("{heading}/swapfile file 2097148 0 -2\n\n");
        let found = locked_memory(None, &one);
        assert_eq!(found.level, Level::Warning);
        assert!(
            found.seen.ends_with("swapped to /swapfile"),
            "{}",
            found.seen
        );
    }

    #[test]
    fn clocks_and_governors_are_known_by_name() {
        assert_eq!(clock_source(Some("tsc\n")).level, Level::Ok);
        for bad in [Some("hpet\n"), Some("\u{1b}[2J"), Some(""), None] {
            assert_eq!(clock_source(bad).level, Level::Warning, "{bad:?}");
        }
        let governor = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|name| format!("{name}\n")).collect();
            super::governor(&names)
        };
        assert_eq!(governor(&[]).level, Level::Ok);
        assert_eq!(governor(&["performance", "performance"]).level, Level::Ok);
        let mixed = governor(&["powersave", "performance", "powersave"]);
        assert_eq!(mixed.level, Level::Warning);
        assert!(
            mixed.seen.starts_with("performance, powersave:"),
            "{}",
            mixed.seen
        );
        assert_eq!(cores(1).level, Level::Warning);
        assert_eq!(cores(2).level, Level::Ok);
    }

    #[test]
    fn logind_is_named_with_the_three_ways_out() {
        let facts = Facts {
            runs: true,
            removes: None,
            uid: 1000,
            user: "robot".to_owned(),
            system_uid_max: 999,
            lingers: false,
        };
        let found = remove_ipc(&facts);
        assert_eq!(found.level, Level::Warning);
        let fix = found.fix.expect("a fix");
        for way in ["enable-linger robot", "system user", "RemoveIPC=no"] {
            assert!(fix.contains(way), "{fix}");
        }
        let spared = Facts {
            lingers: true,
            ..facts
        };
        assert_eq!(remove_ipc(&spared).level, Level::Ok);
    }

    #[test]
    fn stray_segments_are_named_and_left_alone() {
        let stray = [PathBuf::from("/dev/shm/zn_a_b.data")];
        let found = leftovers(1, &[], &stray);
        assert_eq!(found.fix.as_deref(), Some("rm /dev/shm/zn_a_b.data"));
        assert_eq!(leftovers(0, &[], &[]).level, Level::Ok);
    }
}
