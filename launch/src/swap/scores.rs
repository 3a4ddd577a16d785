//! How far the answers of two processes differ, tick by tick. Pure.

use std::collections::BTreeMap;
use zeronav_casts::Cast;
use zeronav_measure::result::swap::Comparison;
use zeronav_msgs::command::{Intervention, VelocityCommand, VelocityRequest};
use zeronav_msgs::map::{COST_LETHAL, COST_UNKNOWN, MapView};

/// Ticks of which one answer waits for the other; the oldest go first.
const TICKS_MAX: usize = 256;

/// Difference of forward speed up to which two twists agree. [m/s]
const V_MPS_MAX: f64 = 0.1;

/// Difference of yaw rate up to which two twists agree. [rad/s]
const W_RADPS_MAX: f64 = 0.2;

/// Ratio of lengths up to which two paths agree.
const LENGTH_RATIO_MAX: f64 = 1.1;

/// An answer, as far as it is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Answer {
    /// Length of a path; `None` when there is none. [m]
    Path(Option<f64>),
    /// A requested twist. [m/s, rad/s]
    Request(f64, f64),
    /// A commanded twist, and whether the guard stopped or slowed the robot. [m/s, rad/s]
    Command(f64, f64, bool),
}

impl Answer {
    /// What a local planner wants.
    pub(crate) fn of_request(request: &VelocityRequest) -> Self {
        Self::Request(request.v_mps, request.w_radps)
    }

    /// What a guard lets the wheels do.
    pub(crate) fn of_command(command: &VelocityCommand) -> Self {
        let passes = matches!(
            command.intervention(),
            Some(Intervention::None | Intervention::Clamped)
        );
        Self::Command(command.v_mps, command.w_radps, !passes)
    }

    /// True for no path, and for rest that the guard has not caused.
    fn is_idle(self) -> bool {
        match self {
            Self::Path(length_m) => length_m.is_none(),
            Self::Request(v_mps, w_radps) | Self::Command(v_mps, w_radps, false) => {
                v_mps == 0.0 && w_radps == 0.0
            }
            Self::Command(_, _, true) => false,
        }
    }
}

/// Answers that wait for the other process, and what was found.
#[derive(Debug, Default)]
pub(crate) struct Scores {
    waiting: BTreeMap<u64, [Option<Answer>; 2]>,
    /// Newest tick that was compared: a second answer to it is not.
    compared_tick: u64,
    ticks: u64,
    /// Sum of the agreement of each tick, 0 to 1.
    agreed: f64,
    /// Name to sum, largest and number.
    sums: BTreeMap<&'static str, (f64, f64, f64)>,
}

impl Scores {
    /// Takes in the first answer of a process to a tick: the incumbent (0) or the newcomer (1).
    pub(crate) fn answer(&mut self, which: usize, tick: u64, answer: Answer) {
        if tick <= self.compared_tick {
            return;
        }
        let entry = self.waiting.entry(tick).or_default();
        let Some(place) = entry.get_mut(which) else {
            return;
        };
        place.get_or_insert(answer);
        if let [Some(incumbent), Some(newcomer)] = *entry {
            self.waiting.remove(&tick);
            self.compared_tick = tick;
            self.compare(incumbent, newcomer);
        } else if self.waiting.len() > TICKS_MAX {
            self.waiting.pop_first();
        }
    }

    /// Compares two answers; those of which neither does anything tell nothing.
    fn compare(&mut self, incumbent: Answer, newcomer: Answer) {
        if incumbent.is_idle() && newcomer.is_idle() {
            return;
        }
        let agrees = match (incumbent, newcomer) {
            (Answer::Path(incumbent), Answer::Path(newcomer)) => match (incumbent, newcomer) {
                (Some(office_m), Some(newcomer_m)) => {
                    let ratio = newcomer_m.max(0.01) / office_m.max(0.01);
                    self.sum("length_ratio", ratio);
                    ratio <= LENGTH_RATIO_MAX
                }
                (None, None) => true,
                (Some(_), None) => {
                    self.sum("paths_missing", 1.0);
                    false
                }
                (None, Some(_)) => {
                    self.sum("paths_more", 1.0);
                    false
                }
            },
            (Answer::Request(v, w), Answer::Request(other_v, other_w)) => {
                self.compare_twists([v, w], [other_v, other_w])
            }
            (Answer::Command(v, w, stops), Answer::Command(other_v, other_w, other_stops)) => {
                match (stops, other_stops) {
                    (true, false) => self.sum("stops_missing", 1.0),
                    (false, true) => self.sum("stops_more", 1.0),
                    _ => {}
                }
                self.compare_twists([v, w], [other_v, other_w]) && stops == other_stops
            }
            _ => false,
        };
        self.add(f64::from(u8::from(agrees)));
    }

    fn compare_twists(&mut self, incumbent: [f64; 2], newcomer: [f64; 2]) -> bool {
        let dv = (newcomer[0] - incumbent[0]).abs();
        let dw = (newcomer[1] - incumbent[1]).abs();
        self.sum("v_difference_mps", dv);
        self.sum("w_difference_radps", dw);
        dv <= V_MPS_MAX && dw <= W_RADPS_MAX
    }

    /// Compares two maps of the same scan; nothing when their grids differ.
    pub(crate) fn maps(&mut self, incumbent: &MapView<'_>, newcomer: &MapView<'_>) {
        if incumbent.geometry != newcomer.geometry {
            self.add(0.0);
            return;
        }
        let (mut counted, mut differ) = (0.0, 0.0);
        for (one, other) in incumbent.cells.iter().zip(newcomer.cells) {
            let lethal = [one.cost == COST_LETHAL, other.cost == COST_LETHAL];
            let unknown = [one.cost == COST_UNKNOWN, other.cost == COST_UNKNOWN];
            let differs = lethal[0] != lethal[1] || unknown[0] != unknown[1];
            // What both take for free, or know nothing of, tells nothing about either.
            if differs || lethal[0] {
                counted += 1.0;
            }
            if differs {
                differ += 1.0;
            }
        }
        self.sum("cells_differ", differ);
        self.add(1.0 - differ / f64::max(counted, 1.0));
    }

    fn add(&mut self, agreement: f64) {
        self.ticks += 1;
        self.agreed += agreement;
    }

    fn sum(&mut self, name: &'static str, value: f64) {
        let sum = self.sums.entry(name).or_default();
        *sum = (sum.0 + value, sum.1.max(value), sum.2 + 1.0);
    }

    /// What was found so far.
    pub(crate) fn report(&self, comparison: &mut Comparison) {
        comparison.ticks = self.ticks;
        let agree = self.agreed / self.ticks.max(1).to_f64();
        comparison.agree = (self.ticks > 0).then_some(agree);
        comparison.measures.clear();
        for (name, (sum, max, n)) in &self.sums {
            let figures = if name.starts_with("paths_") || name.starts_with("stops_") {
                vec![((*name).to_owned(), *sum)]
            } else {
                vec![
                    (format!("{name}_mean"), sum / n),
                    (format!("{name}_max"), *max),
                ]
            };
            comparison.measures.extend(figures);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::grid::GridGeometry;
    use zeronav_msgs::map::MapCell;

    fn report(scores: &Scores) -> Comparison {
        let mut comparison = Comparison::default();
        scores.report(&mut comparison);
        comparison
    }

    #[test]
    fn only_answers_to_the_same_tick_are_compared_and_the_first_counts() {
        let mut scores = Scores::default();
        scores.answer(0, 5, Answer::Request(0.5, 0.0));
        scores.answer(0, 5, Answer::Request(0.0, 0.0));
        scores.answer(1, 6, Answer::Request(0.5, 0.0));
        assert_eq!(report(&scores).agree, None);
        scores.answer(1, 5, Answer::Request(0.55, 0.1));
        scores.answer(0, 6, Answer::Request(0.5, 0.3));
        let found = report(&scores);
        assert_eq!((found.ticks, found.agree), (2, Some(0.5)));
        scores.answer(0, 5, Answer::Request(0.5, 0.0));
        scores.answer(1, 5, Answer::Request(0.5, 0.0));
        assert_eq!(report(&scores).ticks, 2, "compared before");
        let dw = found.measures["w_difference_radps_max"];
        assert!((dw - 0.3).abs() < 1e-12, "{dw}");
    }

    #[test]
    fn paths_agree_by_length_and_guards_by_their_stops() {
        let mut scores = Scores::default();
        for (tick, incumbent, newcomer) in [
            (1, Some(10.0), Some(10.9)),
            (2, Some(10.0), Some(11.2)),
            (3, None, None),
            (4, Some(10.0), None),
            (5, Some(10.0), Some(9.0)),
        ] {
            scores.answer(0, tick, Answer::Path(incumbent));
            scores.answer(1, tick, Answer::Path(newcomer));
        }
        let found = report(&scores);
        assert_eq!(found.agree, Some(0.5), "the third tells nothing");
        assert!((found.measures["paths_missing"] - 1.0).abs() < 1e-12);
        let mut scores = Scores::default();
        scores.answer(0, 1, Answer::Command(0.0, 0.0, true));
        scores.answer(1, 1, Answer::Command(0.0, 0.0, false));
        assert_eq!(report(&scores).agree, Some(0.0));
        assert!((report(&scores).measures["stops_missing"] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_robot_that_stands_shows_nothing_of_its_processes() {
        let mut scores = Scores::default();
        for (tick, answer) in [
            (1, Answer::Path(None)),
            (2, Answer::Request(0.0, 0.0)),
            (3, Answer::Command(0.0, 0.0, false)),
        ] {
            scores.answer(0, tick, answer);
            scores.answer(1, tick, answer);
        }
        assert_eq!(report(&scores).agree, None);
        scores.answer(0, 4, Answer::Command(0.0, 0.0, true));
        scores.answer(1, 4, Answer::Command(0.0, 0.0, true));
        assert_eq!(report(&scores).agree, Some(1.0), "both guards stop it");
    }

    #[test]
    fn a_map_without_what_the_lidar_sees_does_not_agree() {
        let geometry = GridGeometry {
            resolution_m: 0.05,
            width: 100,
            height: 10,
            ..GridGeometry::default()
        };
        let cell = |cost| MapCell {
            cost,
            ..MapCell::default()
        };
        // Ten cells of a wall, which are static, and ten of a load.
        let mut incumbent = vec![cell(0); 1000];
        incumbent[..20].fill(cell(COST_LETHAL));
        let mut newcomer = incumbent.clone();
        newcomer[10..20].fill(cell(0));
        let agree = |newcomer: &[MapCell]| {
            let (geometry, cells) = (&geometry, &incumbent[..]);
            let mut scores = Scores::default();
            let newcomer = MapView {
                geometry,
                cells: newcomer,
            };
            scores.maps(&MapView { geometry, cells }, &newcomer);
            report(&scores).agree.expect("a comparison")
        };
        assert!((agree(&newcomer) - 0.5).abs() < 1e-12);
        assert!((agree(&incumbent) - 1.0).abs() < 1e-12);
        newcomer.fill(cell(COST_UNKNOWN));
        assert!(agree(&newcomer) < 1e-12, "an empty map");
    }

    #[test]
    fn what_never_gets_an_answer_is_forgotten() {
        let mut scores = Scores::default();
        for tick in 1..10_000 {
            scores.answer(0, tick, Answer::Path(None));
        }
        assert!(scores.waiting.len() <= TICKS_MAX);
    }
}
