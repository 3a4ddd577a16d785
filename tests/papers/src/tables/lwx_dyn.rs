//! LWX-DYN, figure 13: twenty discs that appear or move, driven by the paper's planner and controller and
//! by the defaults of this project. The paper shows two pictures and prints no number.

use crate::drivers::{DEFAULTS, Driver, LWX, LWX_CELLS};
use crate::row::Place;
use crate::scenes::{Coming, Scene, lwx_dyn};
use crate::stack::Drive;
use crate::stats;
use crate::table::{Context, Outcome, TableError, excluded, figure};
use crate::verdict::{Printed, Standing};

/// Who drives. Of the two sets of gains that with cells of a metre is the paper's, because the cells of the
/// scenes are a metre; the other one is what this project ships, for robots of half a metre.
const DRIVERS: [Driver; 3] = [LWX, LWX_CELLS, DEFAULTS];

/// Measures the scenes.
pub(super) fn run(context: &mut Context) -> Result<Outcome, TableError> {
    let mut outcome = Outcome::default();
    for (coming, maps) in [
        (Coming::Appear, "20 discs appear, blocky 20x20 m, 15.0 %"),
        (Coming::Move, "20 discs move, blocky 20x20 m, 15.0 %"),
    ] {
        let seeds = context.seed..context.seed + context.drives;
        let scenes = seeds
            .map(|seed| lwx_dyn(coming, seed))
            .collect::<Result<Vec<Scene>, _>>()?;
        let place = Place {
            paper: "LWX",
            table: "dyn",
            maps: maps.to_owned(),
            acceptance: 1.0,
            seed: context.seed,
        };
        for Driver { name, settings } in DRIVERS {
            let drives = context.stack()?.drive(&scenes, settings)?;
            shares(&mut outcome, &place, "C7", name, &drives);
        }
    }
    Ok(outcome)
}

/// What every driven table tells of its drives.
pub(crate) fn shares(
    outcome: &mut Outcome,
    place: &Place,
    claim: &'static str,
    name: &str,
    drives: &[Drive],
) {
    let share = |is: &dyn Fn(&Drive) -> bool| {
        (
            stats::share(
                drives.iter().filter(|drive| is(drive)).count(),
                drives.len(),
            ),
            0.0,
        )
    };
    for (metric, ours) in [
        ("arrives without a contact (share)", share(&Drive::is_clean)),
        (
            "arrives and never drives into anything (share)",
            share(&Drive::is_blameless),
        ),
        ("arrives (share)", share(&|drive| drive.arrived())),
        ("stuck (share)", share(&|drive| drive.outcome == "stuck")),
    ] {
        let printed = if metric.starts_with("arrives without") {
            Printed::Share(1.0)
        } else {
            Printed::Nothing
        };
        let figure = figure(claim, metric, name, printed, ours).standing(Standing::NotComparable);
        outcome
            .rows
            .push(place.row(figure.noting("no number is printed")));
    }
    let nearest = drives.iter().filter_map(|drive| drive.clearance_m_min);
    let arrived = drives.iter().filter(|drive| drive.arrived());
    for (metric, values) in [
        ("min_clearance [m]", nearest.collect::<Vec<f64>>()),
        (
            "time until it arrives [s]",
            arrived.map(|drive| drive.time_s).collect(),
        ),
    ] {
        let left = excluded(values.len(), drives.len());
        let ours = (stats::mean(&values), left);
        let figure = figure(claim, metric, name, Printed::Nothing, ours);
        outcome.rows.push(place.row(figure));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::{BaoMap, LIMIT_S, ju_dyn};
    use serde_json::json;

    /// The time of those that arrive is a row, and the others are left out of it.
    #[test]
    fn a_driven_table_tells_how_long_it_took() {
        let drive = |outcome: &str, time_s: f64| -> Drive {
            let row = json!({
                "outcome": outcome, "contacts_moving": 0, "contacts_standing": 0, "time_s": time_s,
                "driven_m": 20.0, "clearance_m_min": 0.1, "directory": "nowhere"
            });
            serde_json::from_value(row).unwrap()
        };
        let drives = [
            drive("reached", 40.0),
            drive("timeout", LIMIT_S),
            drive("reached", 50.0),
            drive("stuck", 10.0),
        ];
        let place = Place {
            paper: "LWX",
            table: "dyn",
            maps: "none".to_owned(),
            acceptance: 1.0,
            seed: 1,
        };
        let mut outcome = Outcome::default();
        shares(&mut outcome, &place, "C7", "somebody", &drives);
        let row = outcome
            .rows
            .iter()
            .find(|row| row.metric.starts_with("time"));
        let row = row.unwrap();
        assert_eq!((row.ours, row.n), (Some(45.0), 2));
        assert!((row.excluded - 0.5).abs() < 1e-12, "{row:?}");
    }

    /// The slowest drives of [ZM] that arrive take 207 s: 120 s measured the clock.
    #[test]
    fn every_scene_leaves_the_time_to_arrive() {
        for text in [
            lwx_dyn(Coming::Move, 1).unwrap().text,
            ju_dyn(1).unwrap().text,
            BaoMap::new(1).unwrap().empty().text,
        ] {
            assert!(text.contains("time_limit_s = 300.0"), "{text}");
        }
    }
}
