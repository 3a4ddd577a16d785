//! What is shown of a stack, as plain data: drawn on a terminal, printed, or written as JSON.

use serde::Serialize;
use zeronav_measure::result::latency::Figures;
use zeronav_observe::usage::Usage;

/// What is shown of a stack at a moment.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct View {
    /// The stack itself.
    pub run: RunLine,
    /// Its services, in the order of the data flow.
    pub services: Vec<ServiceLine>,
    /// The processes beside them, in the order of the scenario; empty while the stack does not answer.
    pub companions: Vec<CompanionLine>,
    /// Its topics, in the order of the table.
    pub topics: Vec<TopicLine>,
    /// Time over which rates and shares were taken. [s]
    pub window_s: f64,
    /// From the capture of a scan to the first command whose author checked its points; of the last
    /// seconds, empty in lockstep.
    pub reaction: Figures,
    /// The last path around an obstacle, hop by hop; `None` before the first, and in lockstep.
    pub replanning: Option<Replanning>,
    /// What happened, the newest last.
    pub events: Vec<EventLine>,
    /// What this view itself takes.
    pub own: Usage,
}

/// The stack itself.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct RunLine {
    /// Its scenario.
    pub scenario: String,
    /// Its domain.
    pub domain: String,
    /// `real_time` or `lockstep`.
    pub mode: String,
    /// Run time. [s]
    pub time_s: f64,
    /// Newest tick of the robot.
    pub tick: u64,
    /// True while run time is held.
    pub paused: bool,
    /// State of the task.
    pub task: String,
    /// Way left to the goal; `None` without one. [m]
    pub remaining_m: Option<f64>,
    /// Forward speed. [m/s]
    pub v_mps: Option<f64>,
}

/// One service.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct ServiceLine {
    /// Its seat.
    pub role: &'static str,
    /// The host that fills it, in a stack of two; what is taken is taken on the robot's host.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub host: Option<String>,
    /// Which start of the seat is obeyed; 0 before the first.
    pub epoch: u32,
    /// Restarts of the seat; `None` while the stack does not answer.
    pub restarts: Option<u32>,
    /// What its heartbeat says, or `silent` when none has come for half a second of wall time.
    pub state: &'static str,
    /// What it takes.
    #[serde(flatten)]
    pub usage: Usage,
    /// Messages that it has rejected.
    pub rejected: u64,
    /// Inputs that newer ones had overtaken.
    pub superseded: u64,
    /// Why it is degraded.
    pub reasons: Vec<&'static str>,
}

/// One companion.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct CompanionLine {
    /// Its name.
    pub name: String,
    /// `running`, `restarting` or `ended`.
    pub state: String,
    /// Its restarts.
    pub restarts: u32,
    /// What it takes; process id 0 while there is no process.
    #[serde(flatten)]
    pub usage: Usage,
    /// How the last process ended that has ended; empty before the first.
    pub end: String,
}

/// One topic.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct TopicLine {
    /// Its name.
    pub topic: &'static str,
    /// Messages per second.
    pub hz: f64,
    /// Bytes per second.
    pub bytes_per_s: f64,
    /// Since the last message was sent; `None` before the first. [s]
    pub age_s: Option<f64>,
    /// Messages that this view has missed.
    pub missed: u64,
}

/// The way of a scan to the wheels through a new path.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct Replanning {
    /// Run time of the path. [s]
    pub time_s: f64,
    /// From the capture of the scan to the wheels. [us]
    pub total_us: f64,
    /// Its hops in order.
    pub hops: Vec<HopLine>,
}

/// One hop.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct HopLine {
    /// Its name.
    pub hop: &'static str,
    /// Its length. [us]
    pub us: f64,
}

/// Something that happened.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct EventLine {
    /// Run time. [s]
    pub time_s: f64,
    /// `restart`, `fault`, `state`, `path`, `guard`, `task` or `swap`.
    pub kind: &'static str,
    /// What, in words.
    pub text: String,
}

/// How the topics are sorted on a terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Sort {
    /// As in the table of topics.
    #[default]
    Topic,
    /// The most frequent first.
    Rate,
    /// The most bytes first.
    Bandwidth,
    /// The longest silent first.
    Age,
}

impl Sort {
    /// The next way.
    pub(crate) fn next(self) -> Self {
        match self {
            Self::Topic => Self::Rate,
            Self::Rate => Self::Bandwidth,
            Self::Bandwidth => Self::Age,
            Self::Age => Self::Topic,
        }
    }

    /// Heading of the column that it sorts by.
    pub(crate) fn heading(self) -> &'static str {
        match self {
            Self::Topic => "topic",
            Self::Rate => "rate",
            Self::Bandwidth => "bandwidth",
            Self::Age => "age",
        }
    }

    /// Sorts lines; equal ones keep their order.
    pub(crate) fn sort(self, lines: &mut [TopicLine]) {
        let key = |line: &TopicLine| match self {
            Self::Topic => 0.0,
            Self::Rate => line.hz,
            Self::Bandwidth => line.bytes_per_s,
            // A topic without a message is no longest silence.
            Self::Age => line.age_s.unwrap_or(-1.0),
        };
        lines.sort_by(|a, b| key(b).total_cmp(&key(a)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_are_sorted_by_each_column_in_turn() {
        let line = |topic, hz, bytes_per_s, age_s| TopicLine {
            topic,
            hz,
            bytes_per_s,
            age_s,
            missed: 0,
        };
        let lines = [
            line("a", 1.0, 50.0, None),
            line("b", 9.0, 10.0, Some(0.1)),
            line("c", 1.0, 70.0, Some(7.0)),
        ];
        let mut sort = Sort::default();
        for expected in ["abc", "bac", "cab", "cba", "abc"] {
            let mut sorted = lines.clone();
            sort.sort(&mut sorted);
            let names: String = sorted.iter().map(|line| line.topic).collect();
            assert_eq!(names, expected, "{sort:?}");
            sort = sort.next();
        }
    }
}
