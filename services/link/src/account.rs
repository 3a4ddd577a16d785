//! What the link has carried and how well it knows the other clock, in a file for launch
//! ([`LINK_REPORT`]); its fields are those of the run's result.

use crate::clock_offset::Offset;
use rustix::fs::OFlags;
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Write;
use zeronav_casts::Cast;
use zeronav_shell::folder::Folder;
use zeronav_shell::remote_seats::LINK_REPORT;

/// Name of the file while it is written.
const PART: &str = "link.json.part";

/// Messages of a topic.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct Carried {
    sent: u64,
    sent_bytes: u64,
    received: u64,
    received_bytes: u64,
}

/// See the module's description.
#[derive(Debug, Default, Serialize)]
pub struct Account {
    other: String,
    ahead_us: Option<f64>,
    uncertainty_us: Option<f64>,
    uncertainty_us_max: Option<f64>,
    cuts: u64,
    lost: u64,
    time_s: f64,
    processor_s: f64,
    topics: BTreeMap<&'static str, Carried>,
    #[serde(skip)]
    since_ns: u64,
    /// That the file cannot be written has been logged.
    #[serde(skip)]
    is_unwritten: bool,
}

impl Account {
    /// Counts from `now_ns` on what is carried to and from host `other`.
    #[must_use]
    pub fn new(other: &str, now_ns: u64) -> Self {
        Self {
            other: other.to_owned(),
            since_ns: now_ns,
            ..Self::default()
        }
    }

    /// A message of a topic was sent, with so many bytes.
    pub fn sent(&mut self, topic: &'static str, bytes: usize) {
        let carried = self.topics.entry(topic).or_default();
        carried.sent += 1;
        carried.sent_bytes += bytes as u64;
    }

    /// A message of a topic came, with so many bytes, and its stamps were put into the own time by this offset.
    pub fn received(&mut self, topic: &'static str, bytes: usize, offset: Offset) {
        let carried = self.topics.entry(topic).or_default();
        carried.received += 1;
        carried.received_bytes += bytes as u64;
        let us = micros(offset.uncertainty_ns);
        self.uncertainty_us_max = Some(self.uncertainty_us_max.map_or(us, |most| most.max(us)));
    }

    /// The other host has fallen silent.
    pub fn cut(&mut self) {
        self.cuts += 1;
    }

    /// Writes the file.
    pub fn write(&mut self, folder: &Folder, offset: Option<Offset>, lost: u64, now_ns: u64) {
        self.ahead_us = offset.map(|offset| offset.ahead_ns.to_f64() / 1.0e3);
        self.uncertainty_us = offset.map(|offset| micros(offset.uncertainty_ns));
        self.lost = lost;
        self.time_s = now_ns.saturating_sub(self.since_ns).to_f64() / 1.0e9;
        let used = clock_gettime(ClockId::ProcessCPUTime);
        self.processor_s = used.tv_sec.to_f64() + used.tv_nsec.to_f64() / 1.0e9;
        let written = self.replace(folder);
        if let Err(error) = &written
            && !self.is_unwritten
        {
            tracing::warn!(%error, "what is carried cannot be written to {LINK_REPORT}");
        }
        self.is_unwritten = written.is_err();
    }

    /// Whoever reads finds the file before or after, and whole. Nothing waits for a disk: it is for this run alone.
    fn replace(&self, folder: &Folder) -> std::io::Result<()> {
        let bytes = serde_json::to_vec(self)?;
        let flags = OFlags::WRONLY | OFlags::CREATE | OFlags::TRUNC;
        folder.file(PART, flags)?.write_all(&bytes)?;
        std::fs::rename(folder.entry(PART), folder.entry(LINK_REPORT))
    }
}

/// Nanoseconds in microseconds.
fn micros(ns: u64) -> f64 {
    ns.to_f64() / 1.0e3
}
