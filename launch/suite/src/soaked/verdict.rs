//! What a soak came to: counts by seat, and a verdict for each thing that is asked of it.

use super::Soaked;
use core::fmt::Write;
use serde::Serialize;
use std::collections::BTreeMap;
use zeronav_casts::Cast;
use zeronav_msgs::role::Role;
use zeronav_scenario::mortals;

/// Faults that are asked for, and restarts of each seat.
const FAULTS: u64 = 1000;
const RESTARTS: u64 = 1000;

/// Lines of anything that the page has at most; the files have them all.
const LINES_MAX: usize = 20;

/// Why a soak begins no more drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// Enough was broken and restarted.
    Enough,
    /// Its time is used up.
    Hours,
    /// All drives that were asked for were made.
    Worlds,
    /// It was stopped.
    Interrupted,
}

/// What is said of a thing that is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It is so.
    Met,
    /// There were too few drives.
    Open,
    /// It is not so.
    NotMet,
}

/// A thing that is asked of a soak.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Criterion {
    /// What is counted.
    pub name: String,
    /// How many of them are asked for: `at least 1000`, `0`.
    pub wanted: String,
    /// How many there were.
    pub found: u64,
    /// Whether that is so.
    pub verdict: Verdict,
    /// Of what there were none: upper bound at 95 % of their rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub upper_95: Option<f64>,
    /// Per what that rate is: `fault` or `drive`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per: Option<&'static str>,
    /// How many of those there were.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of: Option<u64>,
}

/// Counts over drives.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Totals {
    /// Drives.
    pub drives: u64,
    /// Those in real time; the others were in lockstep.
    pub real_time: u64,
    /// Faults that were made.
    pub faults: u64,
    /// The same by kind.
    pub kinds: BTreeMap<String, u64>,
    /// The same by what broke: a seat or a topic.
    pub targets: BTreeMap<String, u64>,
    /// Faults that could not be made.
    pub not_made: u64,
    /// Restarts of each seat.
    pub restarts: BTreeMap<String, u64>,
    /// Restarts that no fault explains.
    pub unasked: u64,
    /// Swaps by how they ended.
    pub swaps: BTreeMap<String, u64>,
    /// Contacts of own fault.
    pub contacts_own_fault: u64,
    /// Contacts with what moves that an oracle could have avoided and that are of no own fault.
    pub excused: u64,
    /// Drives that ended stuck, without a way or out of time, though not without faults.
    pub stuck: u64,
    /// Drives that did not reach their goals in another way: a stack that ended, a robot that stopped
    /// beside its goal.
    pub failed: u64,
    /// Drives that do not reach their goals without faults either.
    pub hopeless: u64,
    /// Processes, shared memory and temporary files that were left over.
    pub left: u64,
}

/// What a soak came to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SoakReport {
    /// Why it began no more drives.
    pub ended: End,
    /// Wall time that it was given, in all of its calls. [h]
    pub hours: f64,
    /// Wall time that it has used, in all of its calls. [s]
    pub used_s: f64,
    /// The worst of the criteria's verdicts.
    pub verdict: Verdict,
    /// What is asked of it.
    pub criteria: Vec<Criterion>,
    /// Counts over all drives.
    pub totals: Totals,
    /// The drives.
    pub drives: Vec<Soaked>,
}

impl Totals {
    /// Takes a drive in.
    pub(crate) fn add(&mut self, drive: &Soaked) {
        let add = |sums: &mut BTreeMap<String, u64>, more: &BTreeMap<String, u64>| {
            for (name, n) in more {
                let sum = sums.entry(name.clone()).or_default();
                *sum = sum.saturating_add(*n);
            }
        };
        self.drives += 1;
        self.real_time += u64::from(drive.mode == "real_time");
        self.faults = (drive.kinds.values()).fold(self.faults, |sum, n| sum.saturating_add(*n));
        add(&mut self.kinds, &drive.kinds);
        add(&mut self.targets, &drive.targets);
        add(&mut self.restarts, &drive.restarts);
        add(&mut self.swaps, &drive.swaps);
        self.not_made = self.not_made.saturating_add(drive.not_made);
        self.unasked += drive.unasked.len() as u64;
        self.contacts_own_fault =
            (self.contacts_own_fault).saturating_add(drive.contacts_own_fault);
        self.excused += drive.excused.len() as u64;
        self.left += drive.left.len() as u64;
        let ends = ["stuck", "unreachable", "timeout"];
        let is_stuck = (drive.outcome.as_deref()).is_some_and(|outcome| ends.contains(&outcome));
        let lost = drive.is_lost();
        self.stuck += u64::from(lost && is_stuck);
        self.failed += u64::from(lost && !is_stuck);
        self.hopeless += u64::from(!drive.arrived && !lost);
    }

    /// Restarts of a seat.
    fn restarts_of(&self, role: Role) -> u64 {
        self.restarts.get(role.label()).copied().unwrap_or(0)
    }

    /// The seat with the fewest restarts.
    pub(crate) fn restarts_least(&self) -> u64 {
        let of_seats = mortals().map(|role| self.restarts_of(role));
        of_seats.min().unwrap_or(0)
    }

    /// True when enough was broken and restarted.
    pub(crate) fn is_enough(&self) -> bool {
        self.faults >= FAULTS && self.restarts_least() >= RESTARTS
    }

    fn criteria(&self) -> Vec<Criterion> {
        let least = |name: String, wanted: u64, found: u64| Criterion {
            name,
            wanted: format!("at least {wanted}"),
            found,
            verdict: if found >= wanted {
                Verdict::Met
            } else {
                Verdict::Open
            },
            upper_95: None,
            per: None,
            of: None,
        };
        let none = |name: &str, found: u64, (per, of): (&'static str, u64)| Criterion {
            name: name.to_owned(),
            wanted: "0".to_owned(),
            found,
            verdict: match (found, of) {
                (0, 0) => Verdict::Open,
                (0, _) => Verdict::Met,
                _ => Verdict::NotMet,
            },
            upper_95: (found == 0).then(|| upper_95(of)).flatten(),
            per: Some(per),
            of: Some(of),
        };
        let (faults, drives) = (("fault", self.faults), ("drive", self.drives));
        let mut criteria = vec![least("faults".to_owned(), FAULTS, self.faults)];
        criteria.extend(mortals().map(|role| {
            let found = self.restarts_of(role);
            least(format!("restarts of {role}"), RESTARTS, found)
        }));
        criteria.extend([
            none("contacts of own fault", self.contacts_own_fault, faults),
            none("stuck", self.stuck, drives),
            none("failed", self.failed, drives),
            none("left over", self.left, drives),
        ]);
        criteria
    }
}

/// Upper bound at 95 % of the rate of something that did not happen in `n` independent trials; `None`
/// without a trial.
fn upper_95(n: u64) -> Option<f64> {
    (n > 0).then(|| 1.0 - 0.05_f64.powf(1.0 / n.to_f64()))
}

impl SoakReport {
    /// What these drives came to.
    pub(crate) fn new(ended: End, (hours, used_s): (f64, f64), drives: Vec<Soaked>) -> Self {
        let mut totals = Totals::default();
        for drive in &drives {
            totals.add(drive);
        }
        let criteria = totals.criteria();
        let verdicts = || criteria.iter().map(|criterion| criterion.verdict);
        let verdict = if verdicts().any(|verdict| verdict == Verdict::NotMet) {
            Verdict::NotMet
        } else if verdicts().any(|verdict| verdict == Verdict::Open) {
            Verdict::Open
        } else {
            Verdict::Met
        };
        Self {
            ended,
            hours,
            used_s,
            verdict,
            criteria,
            totals,
            drives,
        }
    }

    /// Its part of the page for people.
    pub(crate) fn write(&self, text: &mut String) {
        let totals = &self.totals;
        let why = match self.ended {
            End::Enough => "enough was broken",
            End::Hours => "its time was used up",
            End::Worlds => "all drives were made",
            End::Interrupted => "it was interrupted",
        };
        let lockstep = totals.drives - totals.real_time;
        let _ = writeln!(
            text,
            "\n  {} drives, {lockstep} in lockstep and {} in real time; {:.2} of {} h of wall time \
             used, {why}",
            totals.drives,
            totals.real_time,
            self.used_s / 3600.0,
            self.hours
        );
        let _ = writeln!(
            text,
            "\n  {:<28} {:>14} {:>7}  verdict",
            "", "asked for", "found"
        );
        for criterion in &self.criteria {
            let verdict = match criterion.verdict {
                Verdict::Met => "met",
                Verdict::Open => "open: more drives are needed",
                Verdict::NotMet => "not met",
            };
            let (name, wanted, found) = (&criterion.name, &criterion.wanted, criterion.found);
            let _ = write!(text, "  {name:<28} {wanted:>14} {found:>7}  {verdict}");
            let per = criterion.per.zip(criterion.of);
            if let (Some(rate), Some((per, n))) = (criterion.upper_95, per) {
                let _ = write!(text, ", below {rate:.5} per {per} at 95 % ({n} of them)");
            }
            text.push('\n');
        }
        for (title, counts) in [
            ("faults by kind", &totals.kinds),
            ("faults by seat and topic", &totals.targets),
            ("swaps", &totals.swaps),
        ] {
            let counts = counts.iter().map(|(name, n)| format!("{name} {n}"));
            let counts = counts.collect::<Vec<_>>().join(", ");
            let _ = writeln!(text, "  {title}: {counts}");
        }
        let (not_made, hopeless) = (totals.not_made, totals.hopeless);
        let _ = writeln!(
            text,
            "  faults not made, such as those of an empty seat: {not_made}; drives that do not arrive \
             without faults either: {hopeless}"
        );
        self.write_lines(
            "restarts that no fault explains",
            |drive| &drive.unasked,
            text,
        );
        self.write_lines("left over", |drive| &drive.left, text);
        let title = "contacts of no own fault that an oracle could have avoided";
        self.write_lines(title, |drive| &drive.excused, text);
    }

    /// Lines of the drives, each with the command that makes the drive again.
    fn write_lines(&self, title: &str, of: impl Fn(&Soaked) -> &Vec<String>, text: &mut String) {
        let lines =
            (self.drives.iter()).flat_map(|drive| of(drive).iter().map(move |it| (drive, it)));
        let n = lines.clone().count();
        let _ = writeln!(text, "  {title}: {n}");
        for (drive, line) in lines.take(LINES_MAX) {
            let _ = writeln!(
                text,
                "    {} seed {} ({}): {line}",
                drive.world, drive.seed, drive.mode
            );
        }
    }
}
