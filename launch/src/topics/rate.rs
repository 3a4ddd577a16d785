//! How often and how much is sent on a topic, in constant memory.

use super::message::Message;
use serde_json::json;
use zeronav_casts::Cast;
use zeronav_msgs::time::seconds;

/// Messages of a span of time.
#[derive(Debug, Clone, Default)]
pub(super) struct Rate {
    /// Messages that were read.
    pub messages: u64,
    /// Messages that were overwritten before they were read.
    pub missed: u64,
    /// Bytes of the messages that were read.
    bytes: u64,
    bytes_min: u64,
    bytes_max: u64,
    /// When the first and the last were sent. [ns]
    sent_ns: Option<[u64; 2]>,
    periods: Periods,
}

/// Times between messages that follow each other.
#[derive(Debug, Clone, Default)]
struct Periods {
    n: u32,
    /// [s]
    mean_s: f64,
    /// Sum of squared differences from the mean, by Welford's recurrence. [s^2]
    squares: f64,
    min_s: f64,
    max_s: f64,
}

impl Rate {
    /// Takes in a message; `before_ns` is when the one before it was sent, 0 = unknown.
    pub(super) fn add(&mut self, message: &Message, before_ns: u64) {
        let (now_ns, bytes) = (message.published_ns, message.bytes() as u64);
        self.bytes_min = match self.messages {
            0 => bytes,
            _ => self.bytes_min.min(bytes),
        };
        self.bytes_max = self.bytes_max.max(bytes);
        self.messages += 1;
        self.missed += message.missed;
        self.bytes += bytes;
        let [first_ns, last_ns] = self.sent_ns.unwrap_or([now_ns; 2]);
        self.sent_ns = Some([first_ns.min(now_ns), last_ns.max(now_ns)]);
        // Records of several processes do not come in the order in which they were written.
        if message.missed == 0 && before_ns > 0 && now_ns >= before_ns {
            self.periods.add(seconds(now_ns - before_ns));
        }
    }

    /// Messages sent per second within a second by the wall clock, or over all messages.
    fn per_second(&self, window_s: Option<f64>) -> f64 {
        let sent = count(self.messages + self.missed);
        match (window_s, self.sent_ns) {
            (Some(window_s), _) => sent / window_s,
            (None, Some([first_ns, last_ns])) if last_ns > first_ns => {
                (sent - 1.0) / seconds(last_ns - first_ns)
            }
            _ => 0.0,
        }
    }

    /// One line for people about the messages of `window_s`, or of all.
    pub(super) fn hz_line(&self, window_s: Option<f64>) -> String {
        if self.messages == 0 {
            return "no message".to_owned();
        }
        let Periods {
            mean_s,
            min_s,
            max_s,
            n,
            ..
        } = self.periods;
        let periods = match n {
            0 => String::new(),
            _ => format!(
                ", period {:.3} ms (min {:.3}, max {:.3}, sd {:.3})",
                1.0e3 * mean_s,
                1.0e3 * min_s,
                1.0e3 * max_s,
                1.0e3 * self.periods.deviation_s()
            ),
        };
        format!(
            "{:.2} Hz{periods}, {} messages{}",
            self.per_second(window_s),
            self.messages,
            self.missed_words()
        )
    }

    /// One line for people about the bytes.
    pub(super) fn bw_line(&self, window_s: Option<f64>) -> String {
        if self.messages == 0 {
            return "no message".to_owned();
        }
        format!(
            "{:.1} kB/s, {:.0} B a message (min {}, max {}), {} messages{}",
            1.0e-3 * self.bytes_per_second(window_s),
            self.mean_bytes(),
            self.bytes_min,
            self.bytes_max,
            self.messages,
            self.missed_words()
        )
    }

    fn missed_words(&self) -> String {
        match self.missed {
            0 => String::new(),
            missed => format!(", {missed} more were missed"),
        }
    }

    fn mean_bytes(&self) -> f64 {
        count(self.bytes) / count(self.messages.max(1))
    }

    /// Missed messages count as large as the mean.
    fn bytes_per_second(&self, window_s: Option<f64>) -> f64 {
        self.per_second(window_s) * self.mean_bytes()
    }

    /// The same for machines.
    pub(super) fn to_json(&self, topic: &str, window_s: Option<f64>) -> serde_json::Value {
        let periods = (self.periods.n > 0).then(|| {
            json!({
                "mean": self.periods.mean_s,
                "min": self.periods.min_s,
                "max": self.periods.max_s,
                "sd": self.periods.deviation_s(),
            })
        });
        json!({
            "topic": topic,
            "window_s": window_s,
            "messages": self.messages,
            "missed": self.missed,
            "hz": self.per_second(window_s),
            "period_s": periods,
            "bytes_per_s": self.bytes_per_second(window_s),
            "message_bytes": {
                "mean": self.mean_bytes(),
                "min": self.bytes_min,
                "max": self.bytes_max,
            },
        })
    }
}

impl Periods {
    fn add(&mut self, period_s: f64) {
        self.min_s = match self.n {
            0 => period_s,
            _ => self.min_s.min(period_s),
        };
        self.max_s = self.max_s.max(period_s);
        self.n = self.n.saturating_add(1);
        let off_s = period_s - self.mean_s;
        self.mean_s += off_s / f64::from(self.n);
        self.squares += off_s * (period_s - self.mean_s);
    }

    fn deviation_s(&self) -> f64 {
        (self.squares / f64::from(self.n.max(1))).sqrt()
    }
}

fn count(n: u64) -> f64 {
    n.to_f64()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::topics::{RobotOdometry, Topic};

    fn at(ms: u64, missed: u64) -> Message {
        let mut message = Message::of_topic::<RobotOdometry>(RobotOdometry::ROW);
        message.published_ns = 1_000_000 * ms;
        message.missed = missed;
        message
    }

    #[test]
    fn missed_messages_count_for_the_rate_and_not_for_the_periods() {
        let mut rate = Rate::default();
        let mut before_ns = 0;
        for message in [at(100, 0), at(120, 0), at(142, 0), at(200, 2)] {
            rate.add(&message, before_ns);
            before_ns = message.published_ns;
        }
        assert!((rate.per_second(None) - 50.0).abs() < 1e-9);
        let json = rate.to_json("it", None);
        assert_eq!(json["messages"], 4);
        assert_eq!(json["missed"], 2);
        let period = |key: &str| json["period_s"][key].as_f64().expect("seconds");
        assert!((period("mean") - 0.021).abs() < 1e-12);
        assert!((period("min") - 0.020).abs() < 1e-12);
        assert!((period("max") - 0.022).abs() < 1e-12);
        assert!((period("sd") - 0.001).abs() < 1e-12);
        let line = rate.hz_line(None);
        assert!(line.starts_with("50.00 Hz, period 21.000 ms"), "{line}");
        assert!(line.ends_with("4 messages, 2 more were missed"), "{line}");
    }

    #[test]
    fn bytes_are_those_of_header_fields_and_slice() {
        let mut rate = Rate::default();
        rate.add(&at(0, 0), 0);
        let json = rate.to_json("it", Some(0.5));
        let bytes = RobotOdometry::ROW.envelope_bytes;
        assert_eq!(json["message_bytes"]["max"], bytes);
        assert!(
            (json["bytes_per_s"].as_f64().expect("a rate") - 2.0 * count(bytes as u64)).abs()
                < 1e-9
        );
    }

    #[test]
    fn one_message_has_no_rate_yet() {
        let mut rate = Rate::default();
        assert_eq!(rate.hz_line(None), "no message");
        rate.add(&at(5, 0), 0);
        assert_eq!(rate.to_json("it", None)["hz"], 0.0);
        assert_eq!(rate.hz_line(None), "0.00 Hz, 1 messages");
    }
}
