//! Maps and questions of the `MovingAI` collection, with their known shortest lengths.
//!
//! Sturtevant, "Benchmarks for Grid-Based Pathfinding", IEEE Transactions on Computational
//! Intelligence and AI in Games 4(2), 2012. Eight neighbours, a straight step costs 1, a diagonal
//! one sqrt 2 and needs both cells beside it free: `CornerRule::ForbidAny`.

#![allow(dead_code, reason = "every test and example uses its own part")]

use zeronav_msgs::grid::SIDE_CELLS_MAX;
use zeronav_msgs::map::{COST_FREE, COST_LETHAL, FLAG_STATIC};
use zeronav_msgs::{Cell, GridGeometry, MapCell, MapView, Pose};

/// A `.map` file: row `y` of the map is line `y` of the file, the first is 0.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GridMap {
    /// One metre per cell, the outer corner of cell (0, 0) at the origin.
    pub(crate) geometry: GridGeometry,
    /// `geometry.len()` cells, row-major; free or lethal.
    pub(crate) cells: Vec<MapCell>,
}

/// A line of a `.scen` file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scenario {
    /// Where the way begins.
    pub(crate) start: Cell,
    /// Where it ends.
    pub(crate) goal: Cell,
    /// Length of the shortest one. [cells]
    pub(crate) optimal_cells: f64,
}

/// What is wrong with a file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum MovingAiError {
    /// A line does not say what it should.
    #[error("line {line}: expected {expected}")]
    Line {
        /// From 1.
        line: usize,
        /// What should stand there.
        expected: &'static str,
    },
    /// The file ends too early.
    #[error("the file ends before {0}")]
    Ends(&'static str),
}

impl GridMap {
    /// Reads a `.map` file.
    ///
    /// # Errors
    /// [`MovingAiError`] with the first line that is wrong.
    pub(crate) fn parse(text: &str) -> Result<Self, MovingAiError> {
        let mut lines = (1..).zip(text.lines().map(str::trim_end));
        let mut word = |key: &'static str, expected| {
            let (line, text) = lines.next().ok_or(MovingAiError::Ends(key))?;
            let rest = text.strip_prefix(key).map(str::trim);
            rest.ok_or(MovingAiError::Line { line, expected })
                .map(|rest| (line, rest))
        };
        let side = |(line, text): (usize, &str)| {
            let side = text.parse().ok();
            side.filter(|side| (1..=SIDE_CELLS_MAX).contains(side))
                .ok_or(MovingAiError::Line {
                    line,
                    expected: "a number of cells, at least 1",
                })
        };
        let (line, kind) = word("type", "`type octile`")?;
        if kind != "octile" {
            return Err(MovingAiError::Line {
                line,
                expected: "`type octile`",
            });
        }
        let height = side(word("height", "`height H`")?)?;
        let width = side(word("width", "`width W`")?)?;
        word("map", "`map`")?;
        let geometry = GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 1.0,
            width,
            height,
        };
        let mut cells = Vec::with_capacity(geometry.len());
        for _ in 0..height {
            let (line, row) = lines.next().ok_or(MovingAiError::Ends("its last row"))?;
            let wrong = MovingAiError::Line {
                line,
                expected: "one of `.GS@OTW` for every column",
            };
            if row.len() != width as usize {
                return Err(wrong);
            }
            for letter in row.bytes() {
                cells.push(cell_of(letter).ok_or_else(|| wrong.clone())?);
            }
        }
        Ok(Self { geometry, cells })
    }

    /// The map as planners see it.
    pub(crate) fn view(&self) -> MapView<'_> {
        MapView {
            geometry: &self.geometry,
            cells: &self.cells,
        }
    }

    /// Pose at the centre of a cell.
    pub(crate) fn pose(&self, cell: Cell) -> Pose {
        let centre = self.geometry.centre_of(cell);
        Pose::new(centre.x, centre.y, 0.0)
    }
}

impl Scenario {
    /// Reads a `.scen` file for a map of this geometry.
    ///
    /// # Errors
    /// [`MovingAiError`] with the first line that is wrong or leads off the map.
    pub(crate) fn parse_all(
        text: &str,
        geometry: &GridGeometry,
    ) -> Result<Vec<Self>, MovingAiError> {
        let mut lines = (1..).zip(text.lines());
        match lines.next() {
            Some((_, first)) if first.starts_with("version") => {}
            Some((line, _)) => {
                return Err(MovingAiError::Line {
                    line,
                    expected: "`version 1`",
                });
            }
            None => return Err(MovingAiError::Ends("its version")),
        }
        lines
            .filter(|(_, text)| !text.trim().is_empty())
            .map(|(line, text)| {
                Self::parse(text, geometry).ok_or(MovingAiError::Line {
                    line,
                    expected: "bucket, map, width, height, start, goal and length for this map",
                })
            })
            .collect()
    }

    fn parse(text: &str, geometry: &GridGeometry) -> Option<Self> {
        let mut words = text.split_whitespace().skip(2);
        let mut number = || words.next()?.parse::<i32>().ok();
        let size = (number()?, number()?);
        let start = Cell::new(number()?, number()?);
        let goal = Cell::new(number()?, number()?);
        let optimal_cells = words.next()?.parse().ok()?;
        let fits = size == geometry.size() && geometry.contains(start) && geometry.contains(goal);
        fits.then_some(Self {
            start,
            goal,
            optimal_cells,
        })
    }
}

const fn cell_of(letter: u8) -> Option<MapCell> {
    let (cost, flags, clearance_mm) = match letter {
        b'.' | b'G' | b'S' => (COST_FREE, 0, u16::MAX),
        b'@' | b'O' | b'T' | b'W' => (COST_LETHAL, FLAG_STATIC, 0),
        _ => return None,
    };
    Some(MapCell {
        cost,
        flags,
        clearance_mm,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAP: &str = "type octile\nheight 2\nwidth 3\nmap\n.@.\nGTS\n";

    #[test]
    fn reads_a_map_and_its_questions() {
        let map = GridMap::parse(MAP).unwrap();
        assert_eq!(map.geometry.size(), (3, 2));
        let blocked: Vec<bool> = map.cells.iter().map(|cell| cell.blocks_centre()).collect();
        assert_eq!(blocked, [false, true, false, false, true, false]);
        let text = "version 1\n0 a/b.map\t3\t2\t0\t0\t0\t1\t1.5\n";
        let read = Scenario::parse_all(text, &map.geometry).unwrap();
        assert_eq!(read.len(), 1);
        assert_eq!(
            (read[0].start, read[0].goal),
            (Cell::new(0, 0), Cell::new(0, 1))
        );
        assert!((read[0].optimal_cells - 1.5).abs() < 1e-12);
    }

    #[test]
    fn says_which_line_is_wrong() {
        let line = |text: &str| match GridMap::parse(text) {
            Err(MovingAiError::Line { line, .. }) => Some(line),
            _ => None,
        };
        assert_eq!(line(&MAP.replace("octile", "hex")), Some(1));
        assert_eq!(line(&MAP.replace("height 2", "height 0")), Some(2));
        assert_eq!(line(&MAP.replace("width 3", "width 99999")), Some(3));
        assert_eq!(line(&MAP.replace(".@.", ".@..")), Some(5));
        assert_eq!(line(&MAP.replace("GTS", "GxS")), Some(6));
        assert_eq!(
            GridMap::parse(&MAP.replace("GTS\n", "")),
            Err(MovingAiError::Ends("its last row"))
        );
        let map = GridMap::parse(MAP).unwrap();
        for wrong in [
            "0 m 3 2 0 0 0 2 1.0",
            "0 m 4 2 0 0 0 1 1.0",
            "0 m 3 2 0 0 0 1",
        ] {
            let text = format!("version 1\n\n{wrong}\n");
            let error = Scenario::parse_all(&text, &map.geometry).unwrap_err();
            assert!(matches!(error, MovingAiError::Line { line: 3, .. }));
        }
    }
}
