//! Whether one node alone publishes a topic of the robot.

/// For how long a publisher counts after its last message. [ns]
const GONE_NS: u64 = 2_000_000_000;

/// Identity of a publisher.
pub type Gid = [u8; 16];

/// Who published what came on a topic.
#[derive(Debug, Clone, Default)]
pub struct Publishers {
    newest: Option<Gid>,
    /// Who published before it, and when last. [ns]
    before: Option<(Gid, u64)>,
    /// When two were heard in turn. [ns]
    mixed_ns: Option<u64>,
}

impl Publishers {
    /// A message of `gid` came. [ns]
    pub fn heard(&mut self, gid: Gid, came_ns: u64) {
        if self.newest == Some(gid) {
            return;
        }
        let is_back =
            |(before, at_ns): (Gid, u64)| before == gid && came_ns.saturating_sub(at_ns) < GONE_NS;
        // One that has taken the place of another is heard alone from then on.
        if self.before.is_some_and(is_back) {
            self.mixed_ns = Some(came_ns);
        }
        self.before = self.newest.map(|newest| (newest, came_ns));
        self.newest = Some(gid);
    }

    /// True while two publish.
    #[must_use]
    pub fn are_two(&self, now_ns: u64) -> bool {
        self.mixed_ns
            .is_some_and(|at_ns| now_ns.saturating_sub(at_ns) < GONE_NS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;
    const A: Gid = [1; 16];
    const B: Gid = [2; 16];

    #[test]
    fn a_successor_is_no_second_publisher() {
        let mut publishers = Publishers::default();
        for n in 0..10 {
            publishers.heard(A, n * S / 10);
        }
        for n in 10..20 {
            publishers.heard(B, n * S / 10);
            assert!(!publishers.are_two(n * S / 10));
        }
    }

    #[test]
    fn two_in_turn_are_two_until_one_is_gone() {
        let mut publishers = Publishers::default();
        publishers.heard(A, 0);
        publishers.heard(B, S / 10);
        assert!(!publishers.are_two(S / 10));
        publishers.heard(A, S / 5);
        assert!(publishers.are_two(S / 5));
        publishers.heard(B, S / 4);
        for n in 1..10 {
            publishers.heard(B, S / 4 + n * S / 2);
        }
        assert!(!publishers.are_two(5 * S));
    }
}
