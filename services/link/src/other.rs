//! The other host, as its beats describe it: which start of it is heard, what is lost on the way, and by how much its
//! clock is ahead. Pure over frames and times.

use crate::clock_offset::{ClockFilter, Exchange, Offset};
use crate::frame::{Beat, Origin};
use zeronav_shell::printable::printable;

/// For how long no beat may have come before the way counts as cut: half of what launch lets a service stand still
/// (`hang_after_s`, 0.5 s), so that the link beats for the hearts of the other host before launch sees a hang. [ns]
const CUT_NS: u64 = 250_000_000;

/// For how long no beat may have come before the other host counts as gone. [ns]
const GONE_NS: u64 = 1_000_000_000;

/// For how long no beat may have come before another start of the other host, or another computer in its place, is
/// heard. [ns]
const ABANDONED_NS: u64 = 30_000_000_000;

/// Longest name of an instance, and as much as is shown of other foreign names. [characters]
const SHOWN_CHARS: usize = 64;

/// What this host says of itself in every beat.
#[derive(Debug, Clone)]
pub struct Own {
    /// Hash of all topics' schemas.
    pub contract: u64,
    /// Its name.
    pub host: String,
    /// Name of the other host.
    pub other: String,
    /// Hash of the scenario, as text.
    pub scenario: String,
    /// Name of its domain.
    pub instance: String,
    /// True on the host of launch.
    pub commands: bool,
}

impl Own {
    /// Why the sender of a beat cannot take part; `None` when it can.
    fn refusal(&self, beat: &Beat) -> Option<String> {
        let Self { host, other, .. } = self;
        if beat.host != *other {
            let name = shown(&beat.host);
            return Some(format!("`{name}` answers in the place of `{other}`"));
        }
        if beat.contract != self.contract {
            return Some(format!("{other} was built from another contract"));
        }
        if beat.scenario != self.scenario {
            return Some(format!("{other} has another scenario than this host"));
        }
        if beat.instance.is_empty() || beat.instance.len() > SHOWN_CHARS {
            return Some(format!("{other} does not say which start of it this is"));
        }
        if !beat.hears.is_empty() && beat.hears != self.instance {
            let hears = shown(&beat.hears);
            return Some(if self.commands {
                format!("{other} takes part in another run, {hears}")
            } else {
                format!("another computer is `{host}` for {other}, {hears}")
            });
        }
        None
    }
}

/// What became of a beat.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Heard {
    /// It counts.
    Taken,
    /// It counts, and comes from another start of the host than those before: the processes of that one have ended.
    Restarted,
    /// It is from a link that has been replaced.
    Late,
    /// It does not count, and why.
    Refused(String),
}

/// What is known of the other host.
#[derive(Debug, Default)]
pub struct Other {
    /// The newest beat, and when it came. [ns]
    beat: Option<Beat>,
    came_ns: u64,
    /// Its newest frame, and how many were lost.
    origin: Origin,
    lost: u64,
    clock: ClockFilter,
    /// Something was lost on the way there, or another link than before listens, which knows nothing.
    is_new: bool,
    /// It has heard this host, too.
    was_partner: bool,
    /// On the host beside launch: the run that it took part in is over, or another one has begun.
    over: bool,
}

impl Other {
    /// Takes in a beat.
    pub fn ingest(&mut self, own: &Own, origin: Origin, beat: Beat, now_ns: u64) -> Heard {
        let known = self.instance();
        let (is_known, is_first) = (beat.instance == known, known.is_empty());
        if let Some(why) = own.refusal(&beat) {
            // It hears another computer in the place of this one: if it has heard this one, the run is over here.
            if is_known && self.was_partner {
                self.over |= !own.commands;
            } else if is_known {
                *self = Self::default();
            }
            return Heard::Refused(why);
        }
        if !is_known && !is_first && !self.is_abandoned(now_ns) {
            let (other, name) = (&own.other, shown(&beat.instance));
            let seconds = ABANDONED_NS / 1_000_000_000;
            return Heard::Refused(format!(
                "{other} was started again, or is another computer ({name}): it is heard once the one before has been silent for {seconds} s"
            ));
        }
        if is_known && origin.sender < self.origin.sender || !is_known && beat.leaving {
            return Heard::Late;
        }
        let is_restart = !is_known && self.was_partner;
        if is_restart && !own.commands {
            self.over = true;
            return Heard::Late;
        }
        if !is_known {
            *self = Self {
                lost: self.lost,
                ..Self::default()
            };
        }
        self.count(origin);
        if beat.echo_sent_ns != 0 && beat.hears == own.instance {
            self.clock.add(Exchange {
                sent_ns: beat.echo_sent_ns,
                came_there_ns: beat.echo_received_ns,
                sent_there_ns: beat.sent_ns,
                came_ns: now_ns,
            });
        }
        self.is_new |= self.beat.as_ref().is_some_and(|last| beat.lost > last.lost);
        self.over |= beat.leaving && !own.commands;
        self.was_partner |= beat.hears == own.instance;
        self.came_ns = now_ns;
        self.beat = Some(beat);
        if is_restart {
            Heard::Restarted
        } else {
            Heard::Taken
        }
    }

    /// Counts a frame that is no beat; false when it is not of the link that is heard.
    pub fn counts(&mut self, origin: Origin) -> bool {
        let is_heard = self.beat.is_some() && origin.sender == self.origin.sender;
        if is_heard {
            self.count(origin);
        }
        is_heard
    }

    fn count(&mut self, origin: Origin) {
        if origin.sender == self.origin.sender {
            let expected = self.origin.number.saturating_add(1);
            self.lose(origin.number.saturating_sub(expected));
        } else {
            // What it sent before anybody listened is not lost.
            self.is_new = true;
        }
        self.origin = origin;
    }

    /// So many of its frames, or of the messages in them, are lost.
    pub fn lose(&mut self, frames: u64) {
        self.lost = self.lost.saturating_add(frames);
    }

    /// Its frames that were lost.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Name of its domain; empty before anything was heard.
    #[must_use]
    pub fn instance(&self) -> &str {
        self.beat.as_ref().map_or("", |beat| &beat.instance)
    }

    /// True on the host beside launch once the run is over.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.over
    }

    /// Its newest beat, and when it came. [ns]
    #[must_use]
    pub fn beat(&self) -> Option<(&Beat, u64)> {
        self.beat.as_ref().map(|beat| (beat, self.came_ns))
    }

    /// Its newest beat while both hosts hear each other and the run goes on.
    #[must_use]
    pub fn partner(&self, own: &Own) -> Option<&Beat> {
        let hears = |beat: &&Beat| beat.hears == own.instance;
        self.beat.as_ref().filter(hears).filter(|_| !self.over)
    }

    fn has_beaten(&self, now_ns: u64, within_ns: u64) -> bool {
        let is_recent = now_ns.saturating_sub(self.came_ns) < within_ns;
        self.beat.as_ref().is_some_and(|beat| !beat.leaving) && is_recent
    }

    /// True while it has not been silent for long.
    #[must_use]
    pub fn is_there(&self, now_ns: u64) -> bool {
        self.has_beaten(now_ns, GONE_NS)
    }

    /// True while nothing comes.
    #[must_use]
    pub fn is_cut(&self, now_ns: u64) -> bool {
        !self.has_beaten(now_ns, CUT_NS)
    }

    /// True when another one may take its place: who has not heard this host has begun nothing for it.
    fn is_abandoned(&self, now_ns: u64) -> bool {
        let within_ns = if self.was_partner {
            ABANDONED_NS
        } else {
            GONE_NS
        };
        !self.has_beaten(now_ns, within_ns)
    }

    /// True once both hosts have heard each other.
    #[must_use]
    pub fn was_partner(&self) -> bool {
        self.was_partner
    }

    /// What was on the way there may be lost.
    pub fn may_have_missed(&mut self) {
        self.is_new = true;
    }

    /// True once when what is latched has to be sent again.
    pub fn take_new(&mut self) -> bool {
        core::mem::take(&mut self.is_new)
    }

    /// By how much its clock is ahead, as well as that is known.
    #[must_use]
    pub fn offset(&self, now_ns: u64) -> Option<Offset> {
        self.clock.offset(now_ns)
    }
}

/// A foreign name as it may be shown.
fn shown(name: &str) -> String {
    let short: String = name.chars().take(SHOWN_CHARS).collect();
    printable(&short).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    fn own(commands: bool) -> Own {
        let (host, other) = if commands {
            ("robot", "base")
        } else {
            ("base", "robot")
        };
        Own {
            contract: 7,
            host: host.to_owned(),
            other: other.to_owned(),
            scenario: "s".to_owned(),
            instance: host.to_owned(),
            commands,
        }
    }

    /// A beat that a host with this instance sends to the one with `own`.
    fn beat(own: &Own, instance: &str) -> Beat {
        Beat {
            contract: 7,
            host: own.other.clone(),
            instance: instance.to_owned(),
            scenario: "s".to_owned(),
            ..Beat::default()
        }
    }

    /// As [`beat`], of one that hears the receiver.
    fn hearing(own: &Own, instance: &str) -> Beat {
        Beat {
            hears: own.instance.clone(),
            ..beat(own, instance)
        }
    }

    fn from(sender: u64, number: u64) -> Origin {
        Origin { sender, number }
    }

    #[test]
    fn another_start_is_heard_once_the_one_before_is_silent_or_has_left() {
        let own = own(true);
        let mut other = Other::default();
        assert_eq!(
            other.ingest(&own, from(5, 1), hearing(&own, "a"), S),
            Heard::Taken
        );
        assert!(!other.is_cut(S) && other.is_there(S));
        let refused = other.ingest(&own, from(1, 1), beat(&own, "b\n"), 30 * S);
        assert!(
            matches!(&refused, Heard::Refused(why) if why.contains("(b\\n)")),
            "{refused:?}"
        );
        assert_eq!(other.instance(), "a");
        assert_eq!(
            other.ingest(&own, from(1, 2), hearing(&own, "b"), 31 * S),
            Heard::Restarted
        );
        assert_eq!(other.instance(), "b");
        // It leaves: the next one need not wait.
        let leaves = Beat {
            leaving: true,
            ..hearing(&own, "b")
        };
        assert_eq!(
            other.ingest(&own, from(1, 3), leaves.clone(), 32 * S),
            Heard::Taken
        );
        assert!(other.is_cut(32 * S) && !other.is_there(32 * S));
        assert_eq!(
            other.ingest(&own, from(2, 1), beat(&own, "c"), 32 * S),
            Heard::Restarted
        );
        // Whoever hears nobody, or another computer, is waited for no longer.
        let elsewhere = Beat {
            hears: "x".to_owned(),
            ..beat(&own, "c")
        };
        let refused = other.ingest(&own, from(2, 2), elsewhere, 32 * S);
        assert!(matches!(refused, Heard::Refused(_)) && other.instance().is_empty());
        assert_eq!(
            other.ingest(&own, from(3, 1), beat(&own, "d"), 32 * S),
            Heard::Taken
        );
        let refused = other.ingest(&own, from(4, 1), beat(&own, "e"), 32 * S);
        assert!(matches!(refused, Heard::Refused(_)));
        assert_eq!(
            other.ingest(&own, from(4, 2), beat(&own, "e"), 33 * S),
            Heard::Taken
        );
    }

    #[test]
    fn beside_launch_another_run_or_another_computer_ends_this_one() {
        let own = own(false);
        let ingest =
            |other: &mut Other, beat: Beat, at: u64| other.ingest(&own, from(5, 1), beat, at);
        let mut other = Other::default();
        ingest(&mut other, beat(&own, "run"), S);
        assert!(other.partner(&own).is_none(), "it does not hear this host");
        let hears = |instance: &str| Beat {
            hears: instance.to_owned(),
            ..beat(&own, "run")
        };
        ingest(&mut other, hears("base"), S);
        assert!(other.partner(&own).is_some());
        ingest(&mut other, beat(&own, "next"), 2 * S);
        assert!(!other.is_over());
        ingest(&mut other, beat(&own, "next"), 31 * S);
        assert!(other.is_over() && other.partner(&own).is_none());
        let mut other = Other::default();
        // At the beginning the robot still hears the base before.
        assert!(matches!(
            ingest(&mut other, hears("x"), S),
            Heard::Refused(_)
        ));
        assert!(!other.is_over() && other.beat().is_none());
        ingest(&mut other, hears("base"), S);
        ingest(&mut other, hears("x"), S);
        assert!(other.is_over());
    }

    #[test]
    fn what_is_missing_is_lost_and_a_link_that_was_started_again_begins_anew() {
        let own = own(true);
        let mut other = Other::default();
        assert!(!other.counts(from(5, 1)));
        other.ingest(&own, from(5, 9), beat(&own, "a"), S);
        assert!(other.take_new() && !other.take_new());
        assert!(other.counts(from(5, 10)) && other.counts(from(5, 13)));
        assert_eq!(other.lost(), 2);
        assert!(!other.counts(from(6, 1)));
        other.ingest(&own, from(6, 4), beat(&own, "a"), S);
        assert_eq!(
            other.ingest(&own, from(5, 14), beat(&own, "a"), S),
            Heard::Late
        );
        assert!(other.counts(from(6, 5)) && other.take_new());
        assert_eq!(other.lost(), 2);
        // It has lost something: it hears what is latched again.
        let lossy = Beat {
            lost: 1,
            ..beat(&own, "a")
        };
        other.ingest(&own, from(6, 6), lossy, S);
        assert!(other.take_new());
        other.counts(from(6, u64::MAX));
        other.counts(from(6, 1));
        other.lose(u64::MAX);
        assert_eq!(other.lost(), u64::MAX);
    }

    #[test]
    fn hosts_that_do_not_fit_are_named() {
        let own = own(true);
        let said = |change: fn(&mut Beat)| {
            let mut beat = beat(&own, "a");
            change(&mut beat);
            match Other::default().ingest(&own, from(1, 1), beat, S) {
                Heard::Refused(why) => why,
                heard => format!("{heard:?}"),
            }
        };
        assert!(said(|beat| beat.host = "x\u{1b}".repeat(99)).contains("\\u{1b}"));
        assert!(said(|beat| beat.contract = 8).contains("another contract"));
        assert!(said(|beat| beat.scenario.clear()).contains("another scenario"));
        assert!(said(|beat| beat.instance.clear()).contains("which start"));
        assert!(said(|beat| beat.hears = "x".to_owned()).contains("another run, x"));
        assert_eq!(said(|beat| beat.hears = "robot".to_owned()), "Taken");
    }
}
