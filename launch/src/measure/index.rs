//! The records of a run, and the joins that every measure needs.

use zeronav_msgs::path::{PathCause, PathStatus};
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};

/// A path as it was published, without repeats of an unchanged one.
#[derive(Debug, Clone, PartialEq)]
pub struct PathRecord {
    /// Id on `plan/path`.
    pub id: u64,
    /// Map revision it was checked with.
    pub map: u64,
    /// Run time. [ns]
    pub run_ns: u64,
    /// Its outcome.
    pub status: PathStatus,
    /// Its cause.
    pub cause: PathCause,
    /// Key of the planner.
    pub planner: String,
    /// Length. [m]
    pub length_m: f64,
    /// From its end to the goal. [m]
    pub beside_goal_m: f64,
    /// Nodes expanded.
    pub expanded: u64,
    /// Waypoints, `map` frame. [m]
    pub points_m: Vec<[f64; 2]>,
}

/// What launch saw of one scripted obstacle.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sighting {
    /// Place in the scenario's list.
    pub index: usize,
    /// Run time at which it appeared: one obstacle may appear several times. [ns]
    pub appeared_run_ns: u64,
    /// Moment at which it appeared, [ns] monotonic.
    pub appeared_ns: u64,
    /// First scan with any beam on it.
    pub first_beam_scan: Option<u64>,
    /// First scan with at least three beams on it.
    pub first_scan: Option<u64>,
    /// First map revision, current as of that scan or later, with a sensed lethal cell at its
    /// outline.
    pub first_map: Option<u64>,
}

/// Everything that launch collected.
#[derive(Debug, Clone, Default)]
pub struct Records {
    /// All spans, per process in order.
    pub spans: Vec<Span>,
    /// All paths that brought a new geometry or a new failure, in order.
    pub paths: Vec<PathRecord>,
    /// All scripted obstacles that appeared.
    pub sightings: Vec<Sighting>,
}

impl Records {
    /// Spans of `role` that are answers or extra answers, in order of their output.
    pub fn answers(&self, role: Role) -> impl Iterator<Item = &Span> {
        self.spans.iter().filter(move |span| {
            span.role == role.code()
                && matches!(span.kind(), Some(SpanKind::Answer | SpanKind::Extra))
        })
    }

    /// The robot's record of the tick whose scan is `scan`.
    #[must_use]
    pub fn scan(&self, scan: u64) -> Option<&Span> {
        self.answers(Role::Robot).find(|span| span.scan == scan)
    }

    /// The first velocity request made with `path` or a later one.
    #[must_use]
    pub fn first_request_with_path(&self, path: u64) -> Option<&Span> {
        self.answers(Role::LocalPlanner)
            .filter(|span| span.path >= path && span.output != 0)
            .min_by_key(|span| span.output)
    }

    /// The first velocity request that checked the points of `scan` or of a later one.
    #[must_use]
    pub fn first_request_with_scan(&self, scan: u64) -> Option<&Span> {
        self.answers(Role::LocalPlanner)
            .filter(|span| span.scan >= scan && span.output != 0)
            .min_by_key(|span| span.output)
    }

    /// The first command made from `request` or a later one.
    #[must_use]
    pub fn first_command(&self, request: u64) -> Option<&Span> {
        self.answers(Role::CollisionGuard)
            .filter(|span| span.request >= request && span.output != 0)
            .min_by_key(|span| span.output)
    }

    /// The robot's record of `command` or a later one reaching the wheels.
    #[must_use]
    pub fn applied(&self, command: u64) -> Option<&Span> {
        self.spans
            .iter()
            .filter(|span| {
                span.role == Role::Robot.code()
                    && span.kind() == Some(SpanKind::Applied)
                    && span.request >= command
            })
            .min_by_key(|span| span.request)
    }

    /// The record of `role` whose main message is `output`.
    #[must_use]
    pub fn output(&self, role: Role, output: u64) -> Option<&Span> {
        self.answers(role).find(|span| span.output == output)
    }
}
