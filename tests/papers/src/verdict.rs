//! What a measured figure says about a printed one.

use crate::stats::Estimate;
use serde::{Deserialize, Serialize};

/// What is printed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Printed {
    /// A relative change, or another number with a sign. -0.1 = 10 % less.
    Change(f64),
    /// A number of things, such as cells: it has no sign, and zero is no dividing line.
    Count(f64),
    /// A share of the maps for which something holds.
    Share(f64),
    /// "About the same", printed as this change: neither sign is for it or against it.
    Same(f64),
    /// Less of it, without a number.
    Less,
    /// More of it, without a number.
    More,
    /// "On all maps": one map on which it does not hold is enough against it.
    Always,
    /// Nothing to compare with.
    Nothing,
}

/// How the comparison stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// A comparison like any other.
    Fair,
    /// What the paper claims is a theorem: a single map against it would be a fault of ours.
    Theorem,
    /// The figure comes out only with a fault of the printed method switched on.
    Artefact,
    /// The setup is missing, so that the figure stands alone.
    NotComparable,
}

/// What came of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// A theorem, and it holds.
    Theorem,
    /// The same sign, an interval without zero, and half to twice the printed size.
    Reproduced,
    /// The same sign and an interval without zero, of another size.
    Qualitative,
    /// An interval with zero in it, or the other sign.
    NotReproduced,
    /// Only with a printed fault switched on.
    Artefact,
    /// The setup is missing.
    NotComparable,
    /// Fewer than [`MAPS_MIN`] maps could be counted.
    TooFew,
}

/// Fewest maps on which a figure is judged.
pub const MAPS_MIN: usize = 10;

impl Verdict {
    /// Those that say something of a claim, from the best on.
    pub const FROM_THE_BEST: [Self; 5] = [
        Self::Theorem,
        Self::Reproduced,
        Self::Qualitative,
        Self::Artefact,
        Self::NotReproduced,
    ];

    /// In words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Theorem => "theorem",
            Self::Reproduced => "reproduced",
            Self::Qualitative => "qualitative",
            Self::NotReproduced => "not reproduced",
            Self::Artefact => "artefact",
            Self::NotComparable => "not comparable",
            Self::TooFew => "too few maps",
        }
    }

    /// How much a fair figure says against the claim; `None` when it is none, or says nothing.
    const fn weight(self) -> Option<u8> {
        match self {
            Self::Theorem => Some(0),
            Self::Reproduced => Some(1),
            Self::Qualitative => Some(2),
            Self::NotReproduced => Some(3),
            Self::Artefact | Self::NotComparable | Self::TooFew => None,
        }
    }

    /// The verdict on a claim that several figures are measured for: that of the figure which says most
    /// against it; [`Self::Artefact`] where it fails without the printed fault and shows with it. `None`
    /// when none of them can be judged.
    #[must_use]
    pub fn of_all(verdicts: impl IntoIterator<Item = Self>) -> Option<Self> {
        let verdicts: Vec<Self> = verdicts.into_iter().collect();
        let fair = verdicts.iter().filter(|it| it.weight().is_some());
        let worst = fair.max_by_key(|it| it.weight()).copied();
        match worst {
            None | Some(Self::NotReproduced) if verdicts.contains(&Self::Artefact) => {
                Some(Self::Artefact)
            }
            worst => worst,
        }
    }
}

/// How near to a printed share a measured one's interval must come.
const SHARE_NEAR: f64 = 0.05;

/// Factors of "about the same": all of the interval within the first one, or at least within the other.
const SAME: f64 = 1.25;
const SAME_BROADLY: f64 = 2.0;

/// The verdict on a figure.
///
/// A change is reproduced when it has the printed sign, its interval excludes zero and its size is
/// half to twice the printed one; qualitative when only the size differs; else not reproduced. An
/// artefact stays one only while it shows at all. For a count zero is no dividing line: it is reproduced
/// within a factor of two, qualitative within a factor of three. Nor is it for a share: it is
/// reproduced when its interval comes within five points of the printed share, qualitative when it
/// lies on the same side of one half, with all of its interval. "About the same" is reproduced when all of
/// the interval lies within a quarter more or a fifth less, qualitative within twice and half. Less or more
/// without a number has no size that could be reproduced: it is qualitative with the right sign and an
/// interval without zero. What is said of all maps is reproduced
/// when it holds on every map, and not reproduced on one counterexample, however few maps there are; else
/// a figure of fewer than [`MAPS_MIN`] maps is not judged.
#[must_use]
pub fn verdict(printed: Printed, ours: Option<Estimate>, standing: Standing) -> Verdict {
    let Some(ours) = ours.filter(|_| standing != Standing::NotComparable) else {
        return Verdict::NotComparable;
    };
    let is_refuted = printed == Printed::Always && ours.mean < 1.0;
    let plain = match printed {
        Printed::Nothing => Verdict::NotComparable,
        _ if is_refuted => Verdict::NotReproduced,
        _ if ours.n < MAPS_MIN => Verdict::TooFew,
        Printed::Change(printed) => change(printed, ours),
        Printed::Count(printed) => count(printed, ours),
        Printed::Share(printed) => share(printed, ours),
        Printed::Same(_) => same(ours),
        Printed::Less => sign(ours.interval[1] < 0.0),
        Printed::More => sign(ours.interval[0] > 0.0),
        Printed::Always => Verdict::Reproduced,
    };
    match standing {
        Standing::Theorem if plain == Verdict::Reproduced => Verdict::Theorem,
        Standing::Artefact if matches!(plain, Verdict::Reproduced | Verdict::Qualitative) => {
            Verdict::Artefact
        }
        _ => plain,
    }
}

fn change(printed: f64, ours: Estimate) -> Verdict {
    let [low, high] = ours.interval;
    let excludes_zero = low > 0.0 || high < 0.0;
    let same_sign = printed * ours.mean > 0.0;
    if !excludes_zero || !same_sign {
        return Verdict::NotReproduced;
    }
    if (0.5..=2.0).contains(&(ours.mean / printed)) {
        Verdict::Reproduced
    } else {
        Verdict::Qualitative
    }
}

fn count(printed: f64, ours: Estimate) -> Verdict {
    let factor = (ours.mean / printed).max(printed / ours.mean);
    if factor <= 2.0 {
        Verdict::Reproduced
    } else if factor <= 3.0 {
        Verdict::Qualitative
    } else {
        Verdict::NotReproduced
    }
}

fn share(printed: f64, ours: Estimate) -> Verdict {
    let [low, high] = ours.interval;
    let same_side = if printed >= 0.5 {
        low > 0.5
    } else {
        high < 0.5
    };
    if low - SHARE_NEAR <= printed && printed <= high + SHARE_NEAR {
        Verdict::Reproduced
    } else if same_side {
        Verdict::Qualitative
    } else {
        Verdict::NotReproduced
    }
}

fn same(ours: Estimate) -> Verdict {
    let factor = |change: f64| (1.0 + change).max(1.0 / (1.0 + change));
    let [low, high] = ours.interval.map(factor);
    let farthest = low.max(high);
    if farthest <= SAME {
        Verdict::Reproduced
    } else if farthest <= SAME_BROADLY {
        Verdict::Qualitative
    } else {
        Verdict::NotReproduced
    }
}

const fn sign(is_right: bool) -> Verdict {
    if is_right {
        Verdict::Qualitative
    } else {
        Verdict::NotReproduced
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(printed: Printed, mean: f64, interval: [f64; 2], standing: Standing) -> Verdict {
        let ours = Estimate {
            mean,
            interval,
            n: 100,
        };
        verdict(printed, Some(ours), standing)
    }

    fn fair(printed: f64, mean: f64, interval: [f64; 2]) -> Verdict {
        of(Printed::Change(printed), mean, interval, Standing::Fair)
    }

    #[test]
    fn a_change_is_judged_by_sign_interval_and_size() {
        assert_eq!(fair(-0.1, -0.1, [-0.12, -0.08]), Verdict::Reproduced);
        // Half and twice still count, the interval's size does not matter.
        assert_eq!(fair(-0.1, -0.05, [-0.09, -0.01]), Verdict::Reproduced);
        assert_eq!(fair(-0.1, -0.2, [-0.21, -0.19]), Verdict::Reproduced);
        assert_eq!(fair(-0.1, -0.049, [-0.05, -0.04]), Verdict::Qualitative);
        assert_eq!(fair(-0.1, -0.201, [-0.21, -0.19]), Verdict::Qualitative);
        assert_eq!(fair(0.1, 0.3, [0.2, 0.4]), Verdict::Qualitative);
        // Touching zero, or of the other sign.
        assert_eq!(fair(-0.1, -0.05, [-0.1, 0.0]), Verdict::NotReproduced);
        assert_eq!(fair(-0.1, 0.05, [0.04, 0.06]), Verdict::NotReproduced);
        // Nothing is printed as a change of nothing.
        assert_eq!(fair(0.0, 0.01, [0.005, 0.02]), Verdict::NotReproduced);
    }

    #[test]
    fn a_share_is_judged_by_its_distance() {
        let share =
            |printed, mean, interval| of(Printed::Share(printed), mean, interval, Standing::Fair);
        assert_eq!(share(1.0, 0.97, [0.93, 0.99]), Verdict::Reproduced);
        assert_eq!(share(1.0, 0.90, [0.85, 0.93]), Verdict::Qualitative);
        assert_eq!(share(1.0, 0.52, [0.45, 0.60]), Verdict::NotReproduced);
        assert_eq!(share(0.0, 0.01, [0.00, 0.04]), Verdict::Reproduced);
        assert_eq!(share(0.0, 0.30, [0.25, 0.35]), Verdict::Qualitative);
        assert_eq!(share(0.0, 0.60, [0.52, 0.67]), Verdict::NotReproduced);
    }

    #[test]
    fn a_count_is_judged_by_its_factor() {
        let count = |printed, mean: f64| {
            let near = [mean - 1.0, mean + 1.0];
            of(Printed::Count(printed), mean, near, Standing::Fair)
        };
        assert_eq!(count(6.0, 4.9), Verdict::Reproduced);
        assert_eq!(count(100.0, 50.0), Verdict::Reproduced);
        assert_eq!(count(100.0, 34.0), Verdict::Qualitative);
        assert_eq!(count(9.0, 27.0), Verdict::Qualitative);
        // Any positive change would have had "the same sign".
        assert_eq!(count(9.0, 102.0), Verdict::NotReproduced);
        assert_eq!(count(9.0, 0.0), Verdict::NotReproduced);
    }

    #[test]
    fn one_map_is_enough_against_what_is_said_of_all() {
        let always = |mean, n, standing| {
            let ours = Estimate {
                mean,
                interval: [0.9, 1.0],
                n,
            };
            verdict(Printed::Always, Some(ours), standing)
        };
        assert_eq!(always(1.0, 200, Standing::Fair), Verdict::Reproduced);
        // 199 of 200 come within five points.
        assert_eq!(always(0.995, 200, Standing::Fair), Verdict::NotReproduced);
        assert_eq!(always(0.5, 2, Standing::Fair), Verdict::NotReproduced);
        assert_eq!(always(1.0, 9, Standing::Fair), Verdict::TooFew);
        assert_eq!(always(1.0, 200, Standing::Theorem), Verdict::Theorem);
        assert_eq!(
            always(0.995, 200, Standing::Theorem),
            Verdict::NotReproduced
        );
    }

    #[test]
    fn one_map_is_no_figure() {
        let of_maps = |n| {
            let ours = Estimate {
                mean: -0.1,
                interval: [-0.1, -0.1],
                n,
            };
            verdict(Printed::Change(-0.1), Some(ours), Standing::Fair)
        };
        assert_eq!(of_maps(1), Verdict::TooFew);
        assert_eq!(of_maps(MAPS_MIN - 1), Verdict::TooFew);
        assert_eq!(of_maps(MAPS_MIN), Verdict::Reproduced);
    }

    #[test]
    fn several_figures_are_judged_by_the_worst() {
        use Verdict::{NotComparable, NotReproduced, Qualitative, Reproduced, Theorem, TooFew};
        let all = [Reproduced, NotReproduced, Qualitative, NotComparable];
        assert_eq!(Verdict::of_all(all), Some(NotReproduced));
        assert_eq!(Verdict::of_all([Theorem, Reproduced]), Some(Reproduced));
        assert_eq!(Verdict::of_all([TooFew, Reproduced]), Some(Reproduced));
        assert_eq!(Verdict::of_all([TooFew, NotComparable]), None);
    }

    /// An artefact is what shows with the fault only: of a claim that holds without it, it says nothing.
    #[test]
    fn a_claim_is_an_artefact_when_it_fails_without_the_fault() {
        use Verdict::{Artefact, NotComparable, NotReproduced, Qualitative};
        assert_eq!(Verdict::of_all([Artefact, NotReproduced]), Some(Artefact));
        assert_eq!(Verdict::of_all([Artefact, NotComparable]), Some(Artefact));
        assert_eq!(Verdict::of_all([Artefact, Qualitative]), Some(Qualitative));
    }

    /// A ratio of one has no sign: +1.5 % and +291 % would have "the same" one, -5 % and +3 % would not.
    #[test]
    fn about_the_same_has_no_sign() {
        let same =
            |printed, mean, interval| of(Printed::Same(printed), mean, interval, Standing::Fair);
        assert_eq!(same(-0.05, 0.03, [-0.01, 0.07]), Verdict::Reproduced);
        assert_eq!(same(0.015, 0.0, [0.0, 0.0]), Verdict::Reproduced);
        assert_eq!(same(0.015, 0.4, [0.3, 0.5]), Verdict::Qualitative);
        assert_eq!(same(0.015, -0.4, [-0.45, -0.35]), Verdict::Qualitative);
        assert_eq!(same(0.015, 2.91, [2.7, 3.1]), Verdict::NotReproduced);
        assert_eq!(same(0.015, -0.6, [-0.65, -0.55]), Verdict::NotReproduced);
    }

    #[test]
    fn less_and_more_without_a_number_are_judged_by_their_sign() {
        let of = |printed, interval: [f64; 2]| {
            let mean = 0.5 * (interval[0] + interval[1]);
            of(printed, mean, interval, Standing::Fair)
        };
        assert_eq!(of(Printed::Less, [-0.2, -0.1]), Verdict::Qualitative);
        assert_eq!(of(Printed::Less, [-0.2, 0.1]), Verdict::NotReproduced);
        assert_eq!(of(Printed::Less, [0.1, 0.2]), Verdict::NotReproduced);
        assert_eq!(of(Printed::More, [0.1, 0.2]), Verdict::Qualitative);
        assert_eq!(of(Printed::More, [-0.2, -0.1]), Verdict::NotReproduced);
    }

    #[test]
    fn a_standing_changes_what_a_figure_means() {
        let yes = |standing| of(Printed::Change(-0.1), -0.1, [-0.12, -0.08], standing);
        assert_eq!(yes(Standing::Artefact), Verdict::Artefact);
        assert_eq!(yes(Standing::NotComparable), Verdict::NotComparable);
        let no = of(Printed::Change(-0.1), 0.1, [0.08, 0.12], Standing::Artefact);
        assert_eq!(no, Verdict::NotReproduced, "not even with the fault");
        let always = of(Printed::Always, 1.0, [0.98, 1.0], Standing::Theorem);
        assert_eq!(always, Verdict::Theorem);
        let nothing = of(Printed::Nothing, 1.0, [0.9, 1.1], Standing::Fair);
        assert_eq!(nothing, Verdict::NotComparable);
        let unsolved = verdict(Printed::Change(-0.1), None, Standing::Fair);
        assert_eq!(unsolved, Verdict::NotComparable);
    }
}
