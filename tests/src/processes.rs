//! The processes of a run, as the kernel lists them.

use std::path::PathBuf;

/// The services among the children of `pid`: process ids and command lines.
#[must_use]
pub fn services_of(pid: u32) -> Vec<(u32, String)> {
    let mut children = children_of(pid);
    children.retain(|(_, line)| line.contains(" --domain "));
    children
}

/// Root folders of the domains that the services among the children of `pid` are in.
#[must_use]
pub fn domains_of(pid: u32) -> Vec<PathBuf> {
    let services = services_of(pid).into_iter();
    let mut roots: Vec<PathBuf> = services
        .filter_map(|(_, line)| {
            let mut words = line.split(' ');
            words.find(|word| *word == "--domain")?;
            words.next().map(PathBuf::from)
        })
        .collect();
    roots.sort();
    roots.dedup();
    roots
}

/// Process ids and command lines of the children of `pid` that are at work.
#[must_use]
pub fn children_of(pid: u32) -> Vec<(u32, String)> {
    let mut children = Vec::new();
    for entry in std::fs::read_dir("/proc").into_iter().flatten().flatten() {
        let Some(child) = entry
            .file_name()
            .to_str()
            .and_then(|name| name.parse().ok())
        else {
            continue;
        };
        let Ok(stat) = std::fs::read_to_string(entry.path().join("stat")) else {
            continue;
        };
        // The name in parentheses may hold anything; the parent is the second word after it.
        let parent = stat
            .rsplit(") ")
            .next()
            .and_then(|rest| rest.split(' ').nth(1));
        if parent.and_then(|word| word.parse::<u32>().ok()) == Some(pid) {
            let line = command_line(child);
            // Not one that has ended, is only asked for its configuration, or is still a copy of
            // its parent.
            let asked = line.contains("--print-config");
            if !line.is_empty() && !asked && line != command_line(pid) {
                children.push((child, line));
            }
        }
    }
    children
}

/// Command line of a process; empty when it has ended.
fn command_line(pid: u32) -> String {
    let line = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
    String::from_utf8_lossy(&line).replace('\0', " ")
}
