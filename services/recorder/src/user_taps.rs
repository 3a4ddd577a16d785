//! Which topics of users there are: they come and go while a run goes on.

use std::collections::BTreeSet;
use std::time::{Duration, Instant, SystemTime};
use zeronav_msgs::user::Form;
use zeronav_shell::{Peer, RawReader};

/// One that is just being made is looked for again after this time, then after twice as long, up to the second one. To list
/// them takes some milliseconds, in which nothing is read.
const FIRST_PAUSE: Duration = Duration::from_millis(10);
const LAST_PAUSE: Duration = Duration::from_secs(1);

/// Time between two looks at whether there is news, which are system calls.
const LOOK: Duration = Duration::from_millis(4);

/// Most topics of users that are recorded.
const TOPICS_MAX: usize = 64;

/// A topic that was found.
#[derive(Debug)]
pub(crate) struct FoundTopic {
    pub row: &'static zeronav_msgs::topics::TopicRow,
    pub form: Form,
    pub reader: RawReader,
}

/// Looks for them.
#[derive(Debug)]
pub(crate) struct UserTopics {
    known: BTreeSet<String>,
    changed: Option<SystemTime>,
    /// When they are listed again, and the time until then.
    next: Option<(Instant, Duration)>,
    looked_at: Option<Instant>,
    /// The first that could not be opened.
    pub problem: Option<String>,
}

impl UserTopics {
    pub(crate) fn new() -> Self {
        Self {
            known: BTreeSet::new(),
            changed: None,
            next: None,
            looked_at: None,
            problem: None,
        }
    }

    /// Those that were made since the last look, each opened.
    pub(crate) fn look(&mut self, peer: &Peer) -> Vec<FoundTopic> {
        let now = Instant::now();
        if (self.looked_at).is_some_and(|at| now.duration_since(at) < LOOK) {
            return Vec::new();
        }
        self.looked_at = Some(now);
        let changed = peer.topics_changed();
        // What was there before is whole: it is listed once, before the stack begins.
        let is_first = self.changed.is_none();
        let pause = match self.next {
            _ if changed != self.changed => FIRST_PAUSE,
            Some((at, pause)) if now >= at => 2 * pause,
            _ => return Vec::new(),
        };
        self.changed = changed;
        self.next = (!is_first && pause <= LAST_PAUSE).then_some((now + pause, pause));
        let mut found = Vec::new();
        // A topic that goes while it is listed is no error: the next look finds what there is.
        for listed in peer.user_topics().unwrap_or_default() {
            if self.known.contains(&listed.name) {
                continue;
            }
            let opened = if self.known.len() < TOPICS_MAX {
                let opened = peer.raw_user(&listed.name, &listed.form);
                opened.map_err(|error| error.to_string())
            } else {
                Err(format!("there are more than {TOPICS_MAX} topics of users"))
            };
            self.known.insert(listed.name);
            match opened {
                Ok((row, reader)) => found.push(FoundTopic {
                    row,
                    form: listed.form,
                    reader,
                }),
                Err(why) => {
                    self.problem.get_or_insert(why);
                }
            }
        }
        found
    }
}
