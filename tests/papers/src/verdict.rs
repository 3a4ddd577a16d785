//! What a measured figure says about a printed one.

use crate::stats::Estimate;
use serde::{Deserialize, Serialize};

/// What is printed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Printed {
    /// A relative change, or another number with a sign. -0.1 = 10 % less.
    Change(f64),
    /// A share of the maps for which something holds, mostly 1: "always".
    Share(f64),
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
}

impl Verdict {
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
        }
    }
}

/// How near to a printed share a measured one's interval must come.
const SHARE_NEAR: f64 = 0.05;

/// The verdict on a figure.
///
/// A change is reproduced when it has the printed sign, its interval excludes zero and its size is
/// half to twice the printed one; qualitative when only the size differs; else not reproduced. An
/// artefact stays one only while it shows at all. For a share zero is no dividing line: it is
/// reproduced when its interval comes within five points of the printed share, qualitative when it
/// lies on the same side of one half, with all of its interval.
#[must_use]
pub fn verdict(printed: Printed, ours: Option<Estimate>, standing: Standing) -> Verdict {
    let Some(ours) = ours.filter(|_| standing != Standing::NotComparable) else {
        return Verdict::NotComparable;
    };
    let plain = match printed {
        Printed::Nothing => Verdict::NotComparable,
        Printed::Change(printed) => change(printed, ours),
        Printed::Share(printed) => share(printed, ours),
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
    fn a_standing_changes_what_a_figure_means() {
        let yes = |standing| of(Printed::Change(-0.1), -0.1, [-0.12, -0.08], standing);
        assert_eq!(yes(Standing::Artefact), Verdict::Artefact);
        assert_eq!(yes(Standing::NotComparable), Verdict::NotComparable);
        let no = of(Printed::Change(-0.1), 0.1, [0.08, 0.12], Standing::Artefact);
        assert_eq!(no, Verdict::NotReproduced, "not even with the fault");
        let always = of(Printed::Share(1.0), 1.0, [0.98, 1.0], Standing::Theorem);
        assert_eq!(always, Verdict::Theorem);
        let nothing = of(Printed::Nothing, 1.0, [0.9, 1.1], Standing::Fair);
        assert_eq!(nothing, Verdict::NotComparable);
        let unsolved = verdict(Printed::Change(-0.1), None, Standing::Fair);
        assert_eq!(unsolved, Verdict::NotComparable);
    }
}
