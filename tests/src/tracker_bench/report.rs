//! Tallies as tables: by data set, by what the robot does, by class.

use super::cases::Case;
use super::tally::{AFTER_S, AHEAD_S, Failing, Inside, JUDGED, Tally};
use crate::results::record::{Row, Table};
use crate::results::spread::Figure;
use zeronav_casts::Cast;

/// Share of 2-D normal samples in the ellipses of one and of two standard deviations. [%]
const EXPECTED: [f64; 2] = [39.3, 86.5];

/// The tallies of some cases.
struct Group<'a> {
    name: String,
    tallies: Vec<&'a Tally>,
}

impl Group<'_> {
    fn count(&self, of: impl Fn(&Tally) -> usize) -> usize {
        self.tallies.iter().map(|tally| of(tally)).sum()
    }

    fn sum(&self, of: impl Fn(&Tally) -> f64) -> f64 {
        self.tallies.iter().map(|tally| of(tally)).sum()
    }

    fn samples(&self, of: impl Fn(&Tally) -> &Vec<f64>) -> Vec<f64> {
        let all = self.tallies.iter().flat_map(|tally| of(tally));
        all.copied().collect()
    }

    /// How often something went wrong in a minute of `time_s`.
    fn per_min(&self, failing: Failing, time_s: f64) -> Figure {
        let n = number(self.count(|tally| tally.count(failing)));
        Figure::plain((time_s > 0.0).then(|| 60.0 * n / time_s))
    }

    fn inside(&self, of: impl Fn(&Tally) -> Inside) -> Inside {
        let mut all = Inside::default();
        for inside in self.tallies.iter().map(|tally| of(tally)) {
            all.n += inside.n;
            all.one += inside.one;
            all.two += inside.two;
        }
        all
    }
}

/// The tables of some cases and what each came to; `lidar` says with which lidar.
#[must_use]
pub fn tables(cases: &[Case], tallies: &[Tally], lidar: &str) -> Vec<Table> {
    let groups = groups(cases, tallies);
    let mut tables = vec![
        finding(&groups),
        velocity(&groups),
        prediction(&groups),
        calibration(&groups),
    ];
    for table in &mut tables {
        table.title = format!("{}, {lidar}", table.title);
    }
    tables
}

/// Each data set as a whole, then by what the robot does and by class.
fn groups<'a>(cases: &[Case], tallies: &'a [Tally]) -> Vec<Group<'a>> {
    let mut groups: Vec<Group<'a>> = Vec::new();
    let mut kinds: Vec<Vec<String>> = Vec::new();
    for case in cases {
        let motion = if case.drives { "driving" } else { "standing" };
        kinds.push(vec![
            format!("**{}**", case.set),
            format!("{}, robot {motion}", case.set),
            format!("{}, {}", case.set, case.class),
        ]);
    }
    for set in sorted(cases.iter().map(|case| case.set)) {
        let of_set = |kind: usize| {
            let all = cases.iter().zip(&kinds).filter(|(case, _)| case.set == set);
            sorted(all.map(|(_, names)| names[kind].as_str()))
        };
        for name in (0..3).flat_map(of_set) {
            let members = kinds
                .iter()
                .zip(tallies)
                .filter(|(names, _)| names.iter().any(|own| own == name));
            groups.push(Group {
                name: name.to_owned(),
                tallies: members.map(|(_, tally)| tally).collect(),
            });
        }
    }
    groups
}

/// Every value once, in the order of its first place.
fn sorted<'a>(values: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut once = Vec::new();
    for value in values {
        if !once.contains(&value) {
            once.push(value);
        }
    }
    once
}

fn finding(groups: &[Group<'_>]) -> Table {
    let row = |group: &Group<'_>| {
        let delays_s = group.samples(|tally| &tally.delays_s);
        let in_sight_s = group.sum(|tally| tally.in_sight_s);
        let run_s = group.sum(|tally| tally.run_s);
        let long = group.count(|tally| tally.long_sights);
        let never = group.count(|tally| tally.count(Failing::NeverFound));
        Row {
            name: group.name.clone(),
            n: group.count(|tally| tally.sights) as u64,
            figures: vec![
                Figure::median(&delays_s),
                Figure::percentile(&delays_s, 0.9),
                Figure::rate(never, long),
                Figure::plain(Some(number(long))),
                group.per_min(Failing::Lost, in_sight_s),
                group.per_min(Failing::Swapped, in_sight_s),
                Figure::plain(Some(in_sight_s / 60.0)),
                group.per_min(Failing::False, run_s),
                group.per_min(Failing::Doubled, run_s),
                Figure::plain(Some(run_s / 60.0)),
            ],
        }
    };
    table(
        "sights of what moves",
        &[
            "time to detection [s]",
            "p90 [s]",
            "never found of those in sight for over 1 s",
            "n of those",
            "lost [1/min in sight]",
            "swapped [1/min in sight]",
            "in sight [min]",
            "false [1/min of run]",
            "doubled [1/min of run]",
            "run [min]",
        ],
        groups.iter().map(row).collect(),
    )
}

fn velocity(groups: &[Group<'_>]) -> Table {
    let mut rows = Vec::new();
    for group in groups {
        for (at, after_s) in AFTER_S.iter().enumerate() {
            let errors = group.samples(|tally| &tally.early[at].errors_mps);
            let headings = group.samples(|tally| &tally.early[at].headings_deg);
            let too_fast = group.samples(|tally| &tally.early[at].too_fast_mps);
            let untracked = group.count(|tally| tally.early[at].untracked);
            let n = errors.len() + untracked;
            rows.push(Row {
                name: format!("{}, {after_s} s", group.name),
                n: n as u64,
                figures: vec![
                    Figure::rate(untracked, n),
                    Figure::median(&errors),
                    Figure::percentile(&errors, 0.9),
                    Figure::median(&headings),
                    Figure::percentile(&headings, 0.9),
                    Figure::median(&too_fast),
                ],
            });
        }
    }
    table(
        "velocity after the first sight",
        &[
            "not yet tracked",
            "error of the velocity [m/s]",
            "p90 [m/s]",
            "error of the heading [degrees]",
            "p90 [degrees]",
            "too fast by [m/s]",
        ],
        rows,
    )
}

fn prediction(groups: &[Group<'_>]) -> Table {
    let mut rows = Vec::new();
    for group in groups {
        for (at, ahead_s) in AHEAD_S.iter().enumerate() {
            let errors = group.samples(|tally| &tally.ahead[at].errors_m);
            let straight = group.samples(|tally| &tally.ahead[at].straight_m);
            rows.push(Row {
                name: format!("{}, {ahead_s} s", group.name),
                n: errors.len() as u64,
                figures: vec![
                    Figure::median(&errors),
                    Figure::percentile(&errors, 0.9),
                    Figure::median(&straight),
                    Figure::percentile(&straight, 0.9),
                ],
            });
        }
    }
    table(
        "prediction",
        &[
            "error [m]",
            "p90 [m]",
            "error from the true place and velocity [m]",
            "p90 of it [m]",
        ],
        rows,
    )
}

fn calibration(groups: &[Group<'_>]) -> Table {
    let mut rows = Vec::new();
    for group in groups {
        let now = group.inside(|tally| tally.now);
        let then = group.inside(|tally| tally.then);
        let ahead = format!("{} s ahead", AHEAD_S[JUDGED]);
        for (when, inside) in [("now", now), (ahead.as_str(), then)] {
            let share = |k: usize| {
                Figure::plain((inside.n > 0).then(|| 100.0 * number(k) / number(inside.n)))
            };
            rows.push(Row {
                name: format!("{}, {when}", group.name),
                n: inside.n as u64,
                figures: vec![share(inside.one), share(inside.two)],
            });
        }
    }
    let columns = ["one", "two"]
        .iter()
        .zip(EXPECTED)
        .map(|(sigmas, expected)| format!("within {sigmas} sigma, {expected} expected [%]"));
    let columns: Vec<String> = columns.collect();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    table("truth in the ellipse of the covariance", &columns, rows)
}

fn table(title: &str, columns: &[&str], rows: Vec<Row>) -> Table {
    Table {
        title: title.to_owned(),
        columns: columns.iter().map(|&column| column.to_owned()).collect(),
        rows,
    }
}

fn number(n: usize) -> f64 {
    n.to_f64()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_msgs::Pose;
    use zeronav_world::WorldSpec;

    #[test]
    fn groups_count_every_case_once_by_set_motion_and_class() {
        let case = |set: &'static str, class: &str, drives: bool| Case {
            name: String::new(),
            set,
            class: class.to_owned(),
            world: WorldSpec::area([0.0, 0.0], [1.0, 1.0]),
            start: Pose::default(),
            goal: Pose::default(),
            drives,
            radius_m: 0.3,
            seed: 1,
        };
        let cases = [
            case("dynabarn", "easy", false),
            case("dynabarn", "easy", true),
            case("dynabarn", "hard", true),
        ];
        let tally = Tally {
            sights: 2,
            delays_s: vec![0.5],
            in_sight_s: 30.0,
            run_s: 60.0,
            now: Inside {
                n: 4,
                one: 1,
                two: 3,
            },
            ..Tally::default()
        };
        let tables = tables(&cases, &[tally.clone(), tally.clone(), tally], "a lidar");
        let names: Vec<(&str, u64)> = tables[0]
            .rows
            .iter()
            .map(|row| (row.name.as_str(), row.n))
            .collect();
        let expected = [
            ("**dynabarn**", 6),
            ("dynabarn, robot standing", 2),
            ("dynabarn, robot driving", 4),
            ("dynabarn, easy", 4),
            ("dynabarn, hard", 2),
        ];
        assert_eq!(names, expected);
        for table in &tables {
            assert!(table.title.ends_with(", a lidar"), "{}", table.title);
            let fits = |row: &Row| row.figures.len() == table.columns.len();
            assert!(table.rows.iter().all(fits), "{}", table.title);
        }
        let shares = &tables[3].rows[0].figures;
        assert_eq!((shares[0].value, shares[1].value), (Some(25.0), Some(75.0)));
        assert!(
            tables[3].columns[0].contains("39.3"),
            "{:?}",
            tables[3].columns
        );
    }
}
