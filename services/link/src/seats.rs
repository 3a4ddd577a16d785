//! Heartbeats of the seats that are filled on the other host.
//!
//! Launch judges a seat by its heartbeat and by the process that sits in it. The one that comes from the other host
//! is written with the process id of the process that sits here, and while none comes, because the way is cut or the
//! process has not been started yet, the link beats in its place and says why: a way that is cut for some seconds is
//! no service that hangs.

use crate::lane::{Author, Parts};
use crate::socket::Sitter;
use bytemuck::{bytes_of, pod_read_unaligned};
use std::collections::BTreeMap;
use zeronav_casts::low_u32;
use zeronav_msgs::header::{Header, Id, Stamps};
use zeronav_msgs::health::{Health, HealthState, REASON_LINK};
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{Envelope, HealthTopic, Topic, TopicRow, health_of, seal};

type HealthEnvelope = <HealthTopic as Topic>::Envelope;

/// For how long a heart may be silent before the link beats for it. [ns]
const SILENT_NS: u64 = 250_000_000;

/// Time between two beats of the link's. [ns]
const BEAT_NS: u64 = 50_000_000;

#[derive(Debug, Default)]
struct Heart {
    /// Number of the last beat that was written here. It begins with the milliseconds of the clock, so that a link that
    /// was started again goes on above those of the one before.
    count: u64,
    /// What was said last.
    last: Health,
    /// When the last one came from the other host, and when one was written here. [ns]
    came_ns: u64,
    written_ns: u64,
}

/// The hearts, by author.
#[derive(Debug, Default)]
pub struct Hearts(BTreeMap<Author, Heart>);

/// The author that sits in a seat.
fn author(sitter: Sitter) -> Author {
    (sitter.seat.role, sitter.seat.epoch)
}

impl Hearts {
    /// Forgets those for whom nobody sits any more.
    pub fn keep(&mut self, sitters: &[Sitter]) {
        self.0
            .retain(|known, _| sitters.iter().any(|sitter| author(*sitter) == *known));
    }

    /// A beat that has come, as it is to be written here. Of a process for which nobody sits here, it stays.
    pub fn heard(&mut self, of: Author, sitters: &[Sitter], parts: Parts, now_ns: u64) -> Parts {
        let Some(sitter) = sitters.iter().find(|sitter| author(**sitter) == of) else {
            return parts;
        };
        let Some(row) = Role::from_code(of.0).and_then(health_of) else {
            return parts;
        };
        let envelope: HealthEnvelope = pod_read_unaligned(&parts.0);
        let heart = self.0.entry(of).or_default();
        heart.came_ns = now_ns;
        // Progress goes on from where the link's own beats left it.
        let progress = (heart.last.progress.max(envelope.meta().progress)).saturating_add(1);
        let health = Health {
            pid: sitter.pid,
            progress,
            ..*envelope.meta()
        };
        heart.write(row, *envelope.header(), health, now_ns)
    }

    /// The beats that the link writes in the place of silent hearts: of all while the way is cut, and of those that
    /// have not begun. One that falls silent on a way that is not cut hangs, and is left to launch.
    pub fn due(
        &mut self,
        sitters: &[Sitter],
        is_cut: bool,
        now_ns: u64,
    ) -> Vec<(&'static TopicRow, Parts)> {
        let mut due = Vec::new();
        for sitter in sitters {
            let heart = self.0.entry(author(*sitter)).or_default();
            let row = sitter.seat.role().and_then(health_of);
            let Some(row) = row else { continue };
            if !is_cut && heart.came_ns != 0
                || now_ns.saturating_sub(heart.came_ns) < SILENT_NS
                || now_ns.saturating_sub(heart.written_ns) < BEAT_NS
            {
                continue;
            }
            let was_ready = heart.last.state != HealthState::Starting.code();
            let state = if was_ready {
                HealthState::Degraded
            } else {
                HealthState::Starting
            };
            let health = Health {
                progress: heart.last.progress.saturating_add(1),
                state: state.code(),
                reasons: heart.last.reasons | REASON_LINK,
                pid: sitter.pid,
                ..heart.last
            };
            let header = Header {
                role: sitter.seat.role,
                schema: low_u32(row.schema),
                id: Id::new(sitter.seat.epoch, 0).0,
                stamps: Stamps {
                    woken_ns: now_ns,
                    started_ns: now_ns,
                    published_ns: now_ns,
                },
                ..Header::default()
            };
            due.push((row, heart.write(row, header, health, now_ns)));
        }
        due
    }
}

impl Heart {
    /// The parts of the next beat.
    fn write(&mut self, row: &TopicRow, header: Header, health: Health, now_ns: u64) -> Parts {
        debug_assert_eq!(row.envelope_bytes, size_of::<HealthEnvelope>());
        self.count = (self.count + 1).max(now_ns / 1_000_000);
        self.written_ns = now_ns;
        self.last = Health {
            reasons: health.reasons & !REASON_LINK,
            ..health
        };
        let header = Header {
            id: Id::new(header.id().epoch(), self.count).0,
            ..header
        };
        let sealed = seal::<HealthTopic>(header, health, &[]);
        (bytes_of(&sealed).to_vec(), Vec::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::topics::decode;
    use zeronav_shell::remote_seats::SeatStart;

    const SITTER: Sitter = Sitter {
        seat: SeatStart { role: 3, epoch: 2 },
        pid: 77,
    };

    fn health(parts: &Parts) -> (Header, Health) {
        let envelope: HealthEnvelope = pod_read_unaligned(&parts.0);
        let row = health_of(Role::Mapping).expect("a heart");
        decode::<HealthTopic>(row, &envelope, &[]).expect("whole");
        (*envelope.header(), *envelope.meta())
    }

    fn beat(progress: u64, state: HealthState) -> Parts {
        let row = health_of(Role::Mapping).expect("a heart");
        let header = Header {
            role: Role::Mapping.code(),
            schema: low_u32(row.schema),
            id: Id::new(2, 900).0,
            ..Header::default()
        };
        let health = Health {
            progress,
            state: state.code(),
            pid: 5,
            ..Health::default()
        };
        let sealed = seal::<HealthTopic>(header, health, &[]);
        (bytes_of(&sealed).to_vec(), Vec::new())
    }

    #[test]
    fn a_silent_heart_goes_on_and_says_that_the_way_is_cut() {
        let mut hearts = Hearts::default();
        let mut now_ns = 1_000_000_000;
        // Not started yet.
        let due = hearts.due(&[SITTER], false, now_ns);
        let (header, first) = health(&due[0].1);
        assert_eq!((header.id().epoch(), header.id().count()), (2, 1_000));
        assert_eq!(first.state(), Some(HealthState::Starting));
        assert_eq!((first.reasons, first.pid), (REASON_LINK, 77));
        // It beats: under the process id of who sits here, numbered onwards.
        now_ns += 10_000_000;
        let heard = hearts.heard((3, 2), &[SITTER], beat(400, HealthState::Ready), now_ns);
        let (header, second) = health(&heard);
        assert_eq!((header.id().count(), second.pid), (1_010, 77));
        assert_eq!(second.state(), Some(HealthState::Ready));
        assert_eq!(second.reasons, 0);
        assert!(second.progress > 400);
        assert!(
            hearts
                .due(&[SITTER], true, now_ns + SILENT_NS - 1)
                .is_empty()
        );
        // It hangs: launch shall see it.
        assert!(
            hearts
                .due(&[SITTER], false, now_ns + 9 * SILENT_NS)
                .is_empty()
        );
        // The way is cut.
        now_ns += SILENT_NS;
        let due = hearts.due(&[SITTER], true, now_ns);
        let (_, third) = health(&due[0].1);
        assert_eq!(third.state(), Some(HealthState::Degraded));
        assert_eq!(third.reasons, REASON_LINK);
        assert!(third.progress > second.progress);
        assert!(hearts.due(&[SITTER], true, now_ns + BEAT_NS - 1).is_empty());
        // And is there again: a process that stood still has not gone back.
        now_ns += 1;
        let heard = hearts.heard((3, 2), &[SITTER], beat(401, HealthState::Ready), now_ns);
        let (_, fourth) = health(&heard);
        assert!(fourth.progress > third.progress && fourth.reasons == 0);
    }

    #[test]
    fn other_authors_beat_as_they_are() {
        let mut hearts = Hearts::default();
        let parts = beat(1, HealthState::Ready);
        assert_eq!(hearts.heard((3, 9), &[SITTER], parts.clone(), 1), parts);
        hearts.due(&[SITTER], true, 1_000_000_000);
        hearts.keep(&[]);
        assert!(hearts.0.is_empty());
    }
}
