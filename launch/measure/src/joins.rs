//! The records of a run, sorted so that ids can be followed from message to message.

use super::index::Records;
use std::collections::HashMap;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};

/// Why an id leads to no record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// There was no such message: the id is 0, the message was an idle output, or it is older than
    /// the records.
    Nothing,
    /// The message was sent, but its record is missing.
    Missing,
}

/// Sorted views of [`Records`].
#[derive(Debug, Default)]
pub struct Joins<'a> {
    /// By role and main message, idle outputs included.
    outputs: HashMap<(u16, u64), &'a Span>,
    /// Oldest main message by role.
    oldest: HashMap<u16, u64>,
    oldest_scan: Option<u64>,
    /// The robot's, by scan.
    scans: HashMap<u64, &'a Span>,
    /// Answers of mapping, local planner and guard, by main message.
    maps: Vec<&'a Span>,
    requests: Vec<&'a Span>,
    commands: Vec<&'a Span>,
    /// Commands that reached the wheels, by their id.
    applied: Vec<&'a Span>,
}

impl<'a> Joins<'a> {
    /// Sorts `records`.
    #[must_use]
    pub fn of(records: &'a Records) -> Self {
        let mut joins = Self::default();
        for span in &records.spans {
            if span.kind() == Some(SpanKind::Applied) {
                joins.applied.push(span);
                continue;
            }
            if span.output != 0 {
                joins.outputs.insert((span.role, span.output), span);
                let oldest = joins.oldest.entry(span.role).or_insert(span.output);
                *oldest = (*oldest).min(span.output);
            }
            if span.kind() == Some(SpanKind::Idle) {
                continue;
            }
            match span.role() {
                Some(Role::Robot) if span.scan != 0 => {
                    joins.scans.insert(span.scan, span);
                    let oldest = joins.oldest_scan.get_or_insert(span.scan);
                    *oldest = (*oldest).min(span.scan);
                }
                Some(Role::Mapping) if span.output != 0 => joins.maps.push(span),
                Some(Role::LocalPlanner) if span.output != 0 => joins.requests.push(span),
                Some(Role::CollisionGuard) if span.output != 0 => joins.commands.push(span),
                _ => {}
            }
        }
        for sorted in [&mut joins.maps, &mut joins.requests, &mut joins.commands] {
            sorted.sort_by_key(|span| span.output);
        }
        joins.applied.sort_by_key(|span| span.request);
        joins
    }

    /// Follows the id of a main message of `role`.
    ///
    /// # Errors
    /// [`End`].
    pub fn link(&self, role: Role, output: u64) -> Result<&'a Span, End> {
        match self.outputs.get(&(role.code(), output)) {
            Some(span) if span.kind() != Some(SpanKind::Idle) => Ok(span),
            Some(_) => Err(End::Nothing),
            None => Err(self.end(role, output)),
        }
    }

    /// Follows the id of a scan.
    ///
    /// # Errors
    /// [`End`].
    pub fn scan_link(&self, scan: u64) -> Result<&'a Span, End> {
        let found = self.scans.get(&scan).copied();
        found.ok_or_else(|| self.end(Role::Robot, scan))
    }

    /// Why a message is not in the records: what the collector has let go, or what came before it
    /// listened, is older than all that is there.
    fn end(&self, role: Role, id: u64) -> End {
        let oldest = match role {
            Role::Robot => self.oldest_scan,
            _ => self.oldest.get(&role.code()).copied(),
        };
        if id == 0 || oldest.is_none_or(|oldest| id < oldest) {
            End::Nothing
        } else {
            End::Missing
        }
    }

    /// The record of the answer of `role` whose main message is `output`.
    #[must_use]
    pub fn output(&self, role: Role, output: u64) -> Option<&'a Span> {
        self.link(role, output).ok()
    }

    /// The robot's record of the tick whose scan is `scan`.
    #[must_use]
    pub fn scan(&self, scan: u64) -> Option<&'a Span> {
        self.scans.get(&scan).copied()
    }

    /// The records behind a command that reached the wheels: the scan whose points its author checked,
    /// the request, the guard's command, and `applied`.
    ///
    /// # Errors
    /// [`End`] when the ids lead to no scan.
    pub fn direct(&self, applied: &'a Span) -> Result<[&'a Span; 4], End> {
        let guard = self.link(Role::CollisionGuard, applied.request)?;
        let local = self.link(Role::LocalPlanner, guard.request)?;
        Ok([self.scan_link(local.scan)?, local, guard, applied])
    }

    /// The records behind a command that reached the wheels, through the path that was followed: of the
    /// scan, map, path, request, the guard's command, and `applied`.
    ///
    /// # Errors
    /// [`End`] when the ids lead to no scan.
    pub fn through_map(&self, applied: &'a Span) -> Result<[&'a Span; 6], End> {
        let guard = self.link(Role::CollisionGuard, applied.request)?;
        let local = self.link(Role::LocalPlanner, guard.request)?;
        let global = self.link(Role::GlobalPlanner, local.path)?;
        let mapping = self.link(Role::Mapping, global.map)?;
        let scan = self.scan_link(mapping.scan)?;
        Ok([scan, mapping, global, local, guard, applied])
    }

    /// The same from the scan behind the map revision `map` through the path `path` to the first command
    /// that follows it or a later one; `None` while a record is missing.
    #[must_use]
    pub fn of_path(&self, path: u64, map: u64) -> Option<[&'a Span; 6]> {
        let global = self.output(Role::GlobalPlanner, path)?;
        let mapping = self.output(Role::Mapping, map)?;
        let scan = self.scan(mapping.scan)?;
        let local = self.first_request_with_path(path)?;
        let guard = self.first_command(local.output)?;
        let applied = self.first_applied(guard.output)?;
        Some([scan, mapping, global, local, guard, applied])
    }

    /// The first map revision that is current as of `scan` or later.
    #[must_use]
    pub fn first_map_as_of(&self, scan: u64) -> Option<u64> {
        let maps = self.maps.iter().filter(|span| span.scan >= scan);
        maps.map(|span| span.output).next()
    }

    /// The first velocity request made with `path` or a later one.
    #[must_use]
    pub fn first_request_with_path(&self, path: u64) -> Option<&'a Span> {
        self.requests.iter().find(|span| span.path >= path).copied()
    }

    /// The first command made from `request` or a later one.
    #[must_use]
    pub fn first_command(&self, request: u64) -> Option<&'a Span> {
        let made = |span: &&&Span| span.request >= request;
        self.commands.iter().find(made).copied()
    }

    /// The robot's record of `command` or a later one reaching the wheels.
    #[must_use]
    pub fn first_applied(&self, command: u64) -> Option<&'a Span> {
        let at = self.applied.partition_point(|span| span.request < command);
        self.applied.get(at).copied()
    }

    /// All velocity requests in order.
    #[must_use]
    pub fn requests(&self) -> &[&'a Span] {
        &self.requests
    }

    /// All commands in order.
    #[must_use]
    pub fn commands(&self) -> &[&'a Span] {
        &self.commands
    }

    /// All commands that reached the wheels, in order.
    #[must_use]
    pub fn applied(&self) -> &[&'a Span] {
        &self.applied
    }

    /// The robot's records of scans, in no order.
    pub fn scans(&self) -> impl Iterator<Item = &'a Span> + '_ {
        self.scans.values().copied()
    }
}
