//! What came on a topic while the doctor listened.

use zeronav_casts::Cast;

/// What came on a topic.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Heard {
    /// Messages.
    pub n: u64,
    /// Arrival of the first and of the newest. [ns]
    first_ns: u64,
    newest_ns: u64,
    /// Longest time between two. [ns]
    longest_ns: u64,
    /// Frame of the newest.
    pub frame: String,
    /// By how much a message came after its stamp, at least and at most, by this system's clock. [ns]
    age_ns: Option<[i64; 2]>,
}

impl Heard {
    /// A message with this stamp, by the clock of its author, came when this system's clock was at `came_ns`. [ns]
    pub fn note(&mut self, stamp_ns: u64, came_ns: u64, frame: &str) {
        if self.n == 0 {
            self.first_ns = came_ns;
        } else {
            let gap_ns = came_ns.saturating_sub(self.newest_ns);
            self.longest_ns = self.longest_ns.max(gap_ns);
        }
        self.n += 1;
        self.newest_ns = came_ns;
        frame.clone_into(&mut self.frame);
        let signed = |ns: u64| i64::try_from(ns).unwrap_or(i64::MAX);
        let age_ns = signed(came_ns).saturating_sub(signed(stamp_ns));
        let [least, most] = self.age_ns.unwrap_or([age_ns; 2]);
        self.age_ns = Some([least.min(age_ns), most.max(age_ns)]);
    }

    /// Nothing more came until this system's clock was at `now_ns`. [ns]
    pub fn end(&mut self, now_ns: u64) {
        if self.n > 0 {
            let gap_ns = now_ns.saturating_sub(self.newest_ns);
            self.longest_ns = self.longest_ns.max(gap_ns);
        }
    }

    /// Messages a second; `None` before the second one. [Hz]
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        let took_s = self.newest_ns.saturating_sub(self.first_ns).to_f64() * 1.0e-9;
        (self.n > 1 && took_s > 0.0).then(|| (self.n - 1).to_f64() / took_s)
    }

    /// Longest time without a message after the first one. [s]
    #[must_use]
    pub fn longest_s(&self) -> f64 {
        self.longest_ns.to_f64() * 1.0e-9
    }

    /// Age at arrival, at least and at most, by this system's clock. [s]
    #[must_use]
    pub fn age_s(&self) -> Option<[f64; 2]> {
        self.age_ns
            .map(|ages| ages.map(|age_ns| age_ns.to_f64() * 1.0e-9))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn rates_gaps_and_ages_are_those_of_the_messages() {
        let mut heard = Heard::default();
        for (stamp, came) in [(1_000, 1_003), (1_100, 1_109), (1_200, 1_402)] {
            heard.note(stamp * MS, came * MS, "laser");
        }
        let rate_hz = heard.rate_hz().expect("a rate");
        assert!((rate_hz - 2.0 / 0.399).abs() < 1.0e-9, "{rate_hz}");
        assert!((heard.longest_s() - 0.293).abs() < 1.0e-9);
        let [least, most] = heard.age_s().expect("ages");
        assert!((least - 0.003).abs() < 1.0e-9 && (most - 0.202).abs() < 1.0e-9);
        assert_eq!(Heard::default().rate_hz(), None);
        heard.end(3_402 * MS);
        assert!(
            (heard.longest_s() - 2.0).abs() < 1.0e-9,
            "it has fallen silent"
        );
    }
}
