//! [BAO] tables 1 to 4: traditional A* (TAA), virtual obstacles with the Manhattan distance (AAO) and
//! with the octile one (IAA), Dijkstra, full inflation (reference 31).

use crate::figure::Drawing;
use crate::maps::MapFamily;
use crate::row::{Place, Row};
use crate::solve::{Fault, Method, Way, Ways};
use crate::table::{
    Context, Outcome, TableError, change, corners, count, draw, excluded, failures, figure, paired,
    safety, solved, time,
};
use crate::timing;
use crate::verdict::{Printed, Standing};
use crate::{maps::Maze, stats};
use zeronav_global_planner::CornerRule;

/// A map of the paper and what is printed of it, changes as shares.
struct Printout {
    table: &'static str,
    size: [u32; 2],
    ratio: f64,
    aao_taa: f64,
    iaa_aao: f64,
    iaa_taa: f64,
    iaa_dij_time: f64,
    aao_taa_time: f64,
    /// "Basically the same" in the text, which is true of the first table.
    iaa_aao_time: Printed,
    /// Length and time against full inflation, where that works.
    iaa_full: Option<f64>,
    iaa_full_time: Option<f64>,
    /// Moving grids of TAA, AAO and IAA.
    grids: [f64; 3],
    full_works: f64,
    /// Virtual obstacles of AAO, IAA and Dijkstra.
    virtuals: [f64; 3],
}

const PRINTED: [Printout; 4] = [
    Printout {
        table: "1",
        size: [30, 20],
        ratio: 0.158,
        aao_taa: 0.0422,
        iaa_aao: -0.1192,
        iaa_taa: -0.0820,
        iaa_dij_time: -0.5242,
        aao_taa_time: 0.285,
        iaa_aao_time: Printed::Same(0.167 / 0.176 - 1.0),
        iaa_full: Some(38.2132 / 42.3137 - 1.0),
        iaa_full_time: Some(0.167 / 0.395 - 1.0),
        grids: [36.0, 39.0, 33.0],
        full_works: 1.0,
        virtuals: [15.0, 6.0, 6.0],
    },
    Printout {
        table: "2",
        size: [50, 40],
        ratio: 0.141,
        aao_taa: 0.0874,
        iaa_aao: -0.0572,
        iaa_taa: 0.0252,
        iaa_dij_time: -0.7151,
        aao_taa_time: 0.397,
        iaa_aao_time: Printed::Change(0.316 / 0.197 - 1.0),
        iaa_full: Some(71.5269 / 73.2843 - 1.0),
        iaa_full_time: Some(0.316 / 1.533 - 1.0),
        grids: [60.0, 69.0, 63.0],
        full_works: 1.0,
        virtuals: [8.0, 11.0, 10.0],
    },
    Printout {
        table: "3",
        size: [50, 40],
        ratio: 0.389,
        aao_taa: 0.2537,
        iaa_aao: -0.0488,
        iaa_taa: 0.1925,
        iaa_dij_time: -0.5087,
        aao_taa_time: 0.876,
        iaa_aao_time: Printed::Change(0.592 / 0.424 - 1.0),
        iaa_full: None,
        iaa_full_time: None,
        grids: [62.0, 80.0, 74.0],
        full_works: 0.0,
        virtuals: [11.0, 9.0, 12.0],
    },
    Printout {
        table: "4",
        size: [100, 100],
        ratio: 0.30,
        aao_taa: 0.1018,
        iaa_aao: -0.0253,
        iaa_taa: 0.0740,
        iaa_dij_time: -0.6841,
        aao_taa_time: 0.647,
        iaa_aao_time: Printed::Change(4.812 / 0.761 - 1.0),
        iaa_full: None,
        iaa_full_time: None,
        grids: [113.0, 140.0, 133.0],
        full_works: 0.0,
        virtuals: [129.0, 111.0, 108.0],
    },
];

struct Methods {
    taa: Method,
    aao: Method,
    iaa: Method,
    dij: Method,
    full: Method,
    pulled: Method,
}

impl Methods {
    fn new() -> Self {
        Self {
            taa: Method::new("TAA", "bao_taa").under(CornerRule::Allow),
            aao: Method::new("AAO", "bao_aao"),
            iaa: Method::new("IAA", "bao_iaa"),
            dij: Method::new("Dijkstra", "bao_dij"),
            full: Method::new("full inflation", "bao_full"),
            pulled: Method::new("pulled A*", "c_los"),
        }
    }
}

/// Measures a table.
pub(super) fn run(context: &mut Context, index: usize) -> Result<Outcome, TableError> {
    let printed = &PRINTED[index];
    let mut outcome = Outcome::default();
    for family in context.families.clone() {
        let spec = corners(family, printed.size, printed.ratio);
        let (mazes, place) = draw(context, "BAO", printed.table, &spec)?;
        let methods = Methods::new();
        let taa = methods.taa.ways(&mazes.mazes)?;
        let aao = methods.aao.ways(&mazes.mazes)?;
        let iaa = methods.iaa.ways(&mazes.mazes)?;
        let dij = methods.dij.ways(&mazes.mazes)?;
        let full = methods.full.ways(&mazes.mazes)?;
        let pulled = methods.pulled.ways(&mazes.mazes)?;
        theorems(&iaa, &dij, &aao, &pulled)?;
        let rows = &mut outcome.rows;
        lengths(rows, &place, printed, [&taa, &aao, &iaa, &dij, &pulled]);
        effort(rows, &place, printed, [&iaa, &dij]);
        times(rows, &place, printed, (&methods, &mazes.mazes))?;
        others(rows, &place, printed, [&taa, &aao, &iaa, &full]);
        rows.push(
            place.row(
                figure(
                    "C6",
                    "success (share)",
                    "full inflation",
                    Printed::Share(printed.full_works),
                    (solved(&full), 0.0),
                )
                .noting(failures(&full)),
            ),
        );
        virtuals(rows, &place, printed, [&aao, &iaa, &dij]);
        curves(rows, &place, &mazes.mazes, &iaa);
        for (name, ways) in [("TAA", &taa), ("AAO", &aao), ("IAA", &iaa)] {
            rows.extend(safety("safety", name, ways).map(|figure| place.row(figure)));
        }
        if family == MapFamily::Blocky {
            let named = [
                ("TAA", &taa),
                ("AAO", &aao),
                ("IAA", &iaa),
                ("full inflation", &full),
                ("pulled A*", &pulled),
            ];
            outcome.drawing = Drawing::of(&mazes.mazes, &named);
        }
    }
    Ok(outcome)
}

/// What must hold on every map.
fn theorems(iaa: &Ways, dij: &Ways, aao: &Ways, pulled: &Ways) -> Result<(), Fault> {
    let broken = |map: usize, what: &str, problem: String| Fault::Broken {
        what: what.to_owned(),
        map,
        problem,
    };
    for (map, (((iaa, dij), aao), pulled)) in iaa.iter().zip(dij).zip(aao).zip(pulled).enumerate() {
        match (iaa, dij, aao) {
            (Ok(iaa), Ok(dij), Ok(aao)) => {
                if (iaa.length - dij.length).abs() > 1.0e-6 {
                    let problem = format!("{} and {} cells", iaa.length, dij.length);
                    return Err(broken(map, "length of IAA = length of Dijkstra", problem));
                }
                if aao.length < iaa.length - 1.0e-6 {
                    let problem = format!("{} and {} cells", aao.length, iaa.length);
                    return Err(broken(map, "nothing below the optimum", problem));
                }
                if let Ok(pulled) = pulled
                    && pulled.length > iaa.length + 1.0e-6
                {
                    let problem = format!("{} and {} cells", pulled.length, iaa.length);
                    return Err(broken(map, "pulling makes no path longer", problem));
                }
            }
            (Err(_), Err(_), Err(_)) => {}
            _ => {
                let problem = "they disagree about whether there is a way".to_owned();
                return Err(broken(map, "IAA, Dijkstra and AAO", problem));
            }
        }
    }
    Ok(())
}

// long: the rows of one table, one after the other
fn lengths(rows: &mut Vec<Row>, place: &Place, printed: &Printout, ways: [&Ways; 5]) {
    let [taa, aao, iaa, dij, pulled] = ways;
    let by_length = |way: &Way| way.length;
    let both = iaa
        .iter()
        .zip(dij)
        .filter(|(iaa, dij)| iaa.is_ok() && dij.is_ok());
    let n = both.clone().count();
    let equal = both
        .filter(|(iaa, dij)| {
            let lengths = iaa.as_ref().ok().zip(dij.as_ref().ok());
            lengths.is_some_and(|(a, b)| (a.length - b.length).abs() < 1.0e-6)
        })
        .count();
    rows.push(
        place.row(
            figure(
                "C1",
                "same length (share)",
                "IAA = Dijkstra",
                Printed::Always,
                (stats::share(equal, n), excluded(n, iaa.len())),
            )
            .standing(Standing::Theorem),
        ),
    );
    let mut push = |claim, name: &str, base, ours, printed, note: &str| {
        let changes = change(paired(base, ours, by_length));
        rows.push(place.row(figure(claim, "length", name, printed, changes).noting(note)));
    };
    let as_printed = |value| Printed::Change(value);
    push(
        "C2",
        "IAA vs AAO",
        aao,
        iaa,
        as_printed(printed.iaa_aao),
        "",
    );
    let rules = "TAA cuts corners, the other does not: as in the paper";
    push(
        "C4",
        "IAA vs TAA",
        taa,
        iaa,
        as_printed(printed.iaa_taa),
        rules,
    );
    push(
        "C4",
        "AAO vs TAA",
        taa,
        aao,
        as_printed(printed.aao_taa),
        rules,
    );
    push(
        "C5",
        "pulled A* vs IAA",
        iaa,
        pulled,
        Printed::Nothing,
        "any angle",
    );
    let compared = iaa.iter().zip(pulled).filter_map(|pair| match pair {
        (Ok(iaa), Ok(pulled)) => Some(pulled.length < iaa.length - 1.0e-6),
        _ => None,
    });
    let shorter: Vec<bool> = compared.collect();
    let shortest = shorter.iter().filter(|shorter| !**shorter).count();
    rows.push(place.row(figure(
        "C5",
        "nothing shorter that cuts no corner (share)",
        "IAA, against pulled A*",
        Printed::Always,
        (
            stats::share(shortest, shorter.len()),
            excluded(shorter.len(), iaa.len()),
        ),
    )));
}

fn effort(rows: &mut Vec<Row>, place: &Place, printed: &Printout, [iaa, dij]: [&Ways; 2]) {
    let changes = change(paired(dij, iaa, |way| count(way.stats.expanded)));
    let time = Printed::Change(printed.iaa_dij_time);
    let figure = figure("C3", "expanded", "IAA vs Dijkstra", time, changes);
    rows.push(place.row(figure.noting("printed is time")));
}

fn times(
    rows: &mut Vec<Row>,
    place: &Place,
    printed: &Printout,
    (methods, mazes): (&Methods, &[Maze]),
) -> Result<(), Fault> {
    let Methods {
        taa,
        aao,
        iaa,
        dij,
        full,
        ..
    } = methods;
    for (claim, base, ours, printed) in [
        ("C3", dij, iaa, Printed::Change(printed.iaa_dij_time)),
        ("C4", taa, aao, Printed::Change(printed.aao_taa_time)),
        ("C10", aao, iaa, printed.iaa_aao_time),
        (
            "C11",
            full,
            iaa,
            (printed.iaa_full_time).map_or(Printed::Nothing, Printed::Change),
        ),
    ] {
        let name = format!("{} vs {}", ours.name, base.name);
        for changes in timing::changes(base, &[ours], mazes)? {
            rows.push(place.row(time(claim, &name, printed, changes)));
        }
    }
    Ok(())
}

/// Reference 31 where it finds a way, and the grids that a robot moves over.
fn others(
    rows: &mut Vec<Row>,
    place: &Place,
    printed: &Printout,
    [taa, aao, iaa, full]: [&Ways; 4],
) {
    let changes = change(paired(full, iaa, |way: &Way| way.length));
    let of_full = (printed.iaa_full).map_or(Printed::Nothing, Printed::Change);
    rows.push(place.row(figure(
        "C11",
        "length",
        "IAA vs full inflation",
        of_full,
        changes,
    )));
    let [of_taa, of_aao, of_iaa] = printed.grids;
    let cells = |way: &Way| count(way.cells.len() as u64);
    for (name, base, grids) in [("IAA vs TAA", taa, of_taa), ("IAA vs AAO", aao, of_aao)] {
        let changes = change(paired(base, iaa, cells));
        let printed = Printed::Change(of_iaa / grids - 1.0);
        rows.push(place.row(figure("C12", "moving grids", name, printed, changes)));
    }
}

fn virtuals(rows: &mut Vec<Row>, place: &Place, printed: &Printout, ways: [&Ways; 3]) {
    for ((name, ways), printed) in ["AAO", "IAA", "Dijkstra"]
        .iter()
        .zip(ways)
        .zip(printed.virtuals)
    {
        for (metric, printed, of) in [
            (
                "virtual obstacles on the path",
                Printed::Count(printed),
                (|way: &Way| way.stats.remarks.virtual_on_path) as fn(&Way) -> u64,
            ),
            ("virtual obstacles in all", Printed::Nothing, |way| {
                way.stats.remarks.virtual_total
            }),
        ] {
            let counts: Vec<f64> = ways.iter().flatten().map(|way| count(of(way))).collect();
            let left = excluded(counts.len(), ways.len());
            let ours = (stats::mean(&counts), left);
            rows.push(place.row(figure("C7", metric, name, printed, ours)));
        }
    }
}

/// The spline: how much shorter, and whether it keeps off every obstacle.
fn curves(rows: &mut Vec<Row>, place: &Place, mazes: &[Maze], iaa: &Ways) {
    let found: Vec<(&Maze, &Way)> = mazes
        .iter()
        .zip(iaa)
        .filter_map(|(maze, way)| Some((maze, way.as_ref().ok()?)))
        .collect();
    let left = excluded(found.len(), iaa.len());
    let change: Vec<f64> = found
        .iter()
        .map(|(_, way)| way.curve_length() / way.length - 1.0)
        .collect();
    let ours = (stats::mean(&change), left);
    rows.push(place.row(figure(
        "C8",
        "length",
        "spline vs its path",
        Printed::Nothing,
        ours,
    )));
    // 0.465 cells is the least distance that the control points of such a path allow.
    let safe = found.iter().filter(|(maze, way)| {
        !way.stats.remarks.curve_dropped
            && maze.world.polyline_clearance_m(&way.curve) >= 0.465 - 1e-3
    });
    let ours = (stats::share(safe.count(), found.len()), left);
    let metric = "curve keeps 0.465 cells from every obstacle (share)";
    rows.push(place.row(figure("C8", metric, "IAA's spline", Printed::Always, ours)));
    let sharpest: Vec<f64> = found
        .iter()
        .map(|(_, way)| way.stats.remarks.curvature_max_1pm)
        .collect();
    let ours = (stats::mean(&sharpest), left);
    let metric = "sharpest turn [1/cell]";
    rows.push(place.row(figure("C8", metric, "IAA's spline", Printed::Nothing, ours)));
}
