//! One map with the ways of all algorithms, as SVG.

use crate::maps::Maze;
use crate::rollout::Rollout;
use crate::solve::{Way, Ways};
use nalgebra::Point2;
use std::fmt::Write as _;
use zeronav_msgs::Cell;

/// Side of a cell on maps of up to forty cells a side; smaller on larger ones. [px]
const CELL_PX: f64 = 20.0;

/// Longest side of a map. [px]
const SIDE_PX_MAX: f64 = 800.0;

/// Colours that are told apart by most readers (Okabe, Ito 2008).
const COLOURS: [&str; 5] = ["#d55e00", "#0072b2", "#009e73", "#cc79a7", "#56b4e9"];

/// A drawing.
#[derive(Debug, Clone)]
pub struct Drawing {
    svg: String,
    cells: String,
}

/// A named line in cells.
type Line = (String, Vec<Point2<f64>>);

impl Drawing {
    /// The first map that most methods solve, with their ways.
    #[must_use]
    pub(crate) fn of(mazes: &[Maze], named: &[(&str, &Ways)]) -> Option<Self> {
        let solved = |n: &usize| named.iter().filter(|(_, ways)| ways[*n].is_ok()).count();
        // The first of equally good ones.
        let best = (0..mazes.len()).rev().max_by_key(solved)?;
        let lines = named.iter().filter_map(|(name, ways)| {
            let way = ways[best].as_ref().ok()?;
            Some(((*name).to_owned(), line_of(&mazes[best], way)))
        });
        let mut drawing = Self::draw(&mazes[best], &lines.collect::<Vec<_>>());
        for (name, ways) in named {
            if let Ok(way) = &ways[best] {
                let cells = way
                    .cells
                    .iter()
                    .map(|cell| mazes[best].bao_index(*cell).to_string());
                let _ = writeln!(
                    drawing.cells,
                    "{name},{}",
                    cells.collect::<Vec<_>>().join(" ")
                );
            }
        }
        Some(drawing)
    }

    /// The first map on which most roll-outs arrive, with their walks and the way of A*.
    #[must_use]
    pub(crate) fn of_rollouts(
        mazes: &[Maze],
        ways: &[Way],
        named: &[(&str, &[Rollout])],
    ) -> Option<Self> {
        let n = mazes.len().min(ways.len());
        let arrived = |at: &usize| {
            let here = named.iter().filter_map(|(_, rollouts)| rollouts.get(*at));
            here.filter(|rollout| rollout.arrived()).count()
        };
        let best = (0..n).rev().max_by_key(arrived)?;
        let mut lines: Vec<Line> = vec![("A*".to_owned(), line_of(&mazes[best], &ways[best]))];
        for (name, rollouts) in named {
            if let Some(rollout) = rollouts.get(best) {
                let end = if rollout.arrived() {
                    ""
                } else {
                    " (does not arrive)"
                };
                lines.push((format!("{name}{end}"), rollout.trace.points.clone()));
            }
        }
        Some(Self::draw(&mazes[best], &lines))
    }

    fn draw(maze: &Maze, lines: &[Line]) -> Self {
        let (columns, rows) = maze.size();
        let side = f64::from(columns.max(rows));
        let px = CELL_PX.min(SIDE_PX_MAX / side);
        let (width, height) = (f64::from(columns) * px, f64::from(rows) * px);
        // Maps grow upwards, pictures downwards.
        let at = |point: &Point2<f64>| (point.x * px, height - point.y * px);
        let legend_px = 22.0 * f64::from(u32::try_from(lines.len()).unwrap_or(0)) + 14.0;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-8 -8 {:.0} {:.0}\" \
             font-family=\"sans-serif\" font-size=\"14\">\n\
             <rect x=\"-8\" y=\"-8\" width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
             <rect width=\"{width:.1}\" height=\"{height:.1}\" fill=\"#f7f7f5\" stroke=\"#555555\"/>\n",
            width.max(260.0) + 16.0,
            height + legend_px + 16.0
        );
        for y in 0..rows {
            for x in 0..columns {
                if !maze.is_free(Cell::new(x, y)) {
                    let (left, top) = at(&Point2::new(f64::from(x), f64::from(y + 1)));
                    let _ = writeln!(
                        svg,
                        "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{px:.1}\" height=\"{px:.1}\" fill=\"#3c3c3c\"/>"
                    );
                }
            }
        }
        for (n, (name, points)) in lines.iter().enumerate() {
            let colour = COLOURS[n % COLOURS.len()];
            // Beside each other where they are the same.
            let centre = f64::from(u32::try_from(lines.len()).unwrap_or(1)) - 1.0;
            let aside =
                (f64::from(u32::try_from(n).unwrap_or(0)) - 0.5 * centre) * (0.09 * px).min(1.8);
            let mut path = String::new();
            for point in points {
                let (x, y) = at(point);
                let _ = write!(path, "{:.1},{:.1} ", x + aside, y + aside);
            }
            let _ = writeln!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{:.1}\" \
                 stroke-linejoin=\"round\" opacity=\"0.9\"/>",
                path.trim_end(),
                (0.12 * px).clamp(1.2, 2.4)
            );
            let low = height + 22.0 * f64::from(u32::try_from(n).unwrap_or(0)) + 20.0;
            let _ = writeln!(
                svg,
                "<line x1=\"0\" y1=\"{low:.1}\" x2=\"26\" y2=\"{low:.1}\" stroke=\"{colour}\" stroke-width=\"3\"/>\
                 <text x=\"34\" y=\"{:.1}\" fill=\"#222222\">{name}</text>",
                low + 5.0
            );
        }
        for (cell, colour) in [(maze.start, "#2ca02c"), (maze.goal, "#d62728")] {
            let pose = maze.pose(cell);
            let (x, y) = at(&Point2::new(pose.x_m, pose.y_m));
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\" fill=\"{colour}\"/>",
                0.3 * px
            );
        }
        svg.push_str("</svg>\n");
        Self {
            svg,
            cells: String::new(),
        }
    }

    /// The ways cell by cell, one method a line, numbered as [BAO] does (eq. 1); empty for roll-outs.
    #[must_use]
    pub fn cells(&self) -> &str {
        &self.cells
    }

    /// The picture.
    #[must_use]
    pub fn svg(&self) -> &str {
        &self.svg
    }
}

fn line_of(maze: &Maze, way: &Way) -> Vec<Point2<f64>> {
    if way.curve.is_empty() {
        let centres = way.cells.iter().map(|cell| maze.pose(*cell));
        centres
            .map(|pose| Point2::new(pose.x_m, pose.y_m))
            .collect()
    } else {
        way.curve.clone()
    }
}
