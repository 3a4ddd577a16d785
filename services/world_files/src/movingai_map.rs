//! Maps of the `MovingAI` collection (Sturtevant, "Benchmarks for Grid-Based Pathfinding", IEEE
//! Transactions on Computational Intelligence and AI in Games 4(2), 2012) as static worlds.
//!
//! A text file: `type octile`, `height H`, `width W`, `map`, then H lines of W characters. `.`, `G`
//! and `S` are free; `@`, `O`, `T` and `W` are occupied. The first line has the largest y, as in a
//! picture; the lower left corner of the last one is the origin.

use crate::table::{DataError, read_text};
use std::path::Path;
use zeronav_msgs::GridGeometry;
use zeronav_msgs::grid::SIDE_CELLS_MAX;
use zeronav_world::static_map::{Occupancy, StaticMap};

/// Largest file: the largest map with ends of lines and a header. [bytes]
const BYTES_MAX: u64 = (SIDE_CELLS_MAX as u64 + 2) * SIDE_CELLS_MAX as u64 + 256;

/// True for files that [`load`] reads.
#[must_use]
pub(crate) fn is_one(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension == "map")
}

/// Reads a map whose cells have sides of `resolution_m`.
///
/// # Errors
/// See [`DataError`]. Whether `resolution_m` can be is looked at with the world.
pub(crate) fn load(file: &Path, resolution_m: f64) -> Result<StaticMap, DataError> {
    let text = read_text(file, BYTES_MAX)?;
    parse(&text, resolution_m).map_err(|(line, why)| DataError::Line {
        file: file.to_path_buf(),
        line,
        why,
    })
}

/// The map, or the number of the first wrong line and what is wrong.
fn parse(text: &str, resolution_m: f64) -> Result<StaticMap, (usize, String)> {
    let mut lines = (1..).zip(text.lines().map(str::trim_end));
    let mut n = 0;
    let mut next = |expected: &str| {
        n += 1;
        let line = lines.next();
        line.ok_or_else(|| (n, format!("the file ends before {expected}")))
    };
    let (line, kind) = next("`type octile`")?;
    if kind != "type octile" {
        return Err((line, "expected `type octile`".to_owned()));
    }
    let mut side = |word: &str| {
        let (line, text) = next(word)?;
        text.strip_prefix(word)
            .and_then(|number| number.trim().parse::<u32>().ok())
            .filter(|side| (1..=SIDE_CELLS_MAX).contains(side))
            .ok_or_else(|| {
                let why = format!("expected `{word}` and 1 to {SIDE_CELLS_MAX} cells");
                (line, why)
            })
    };
    let (height, width) = (side("height")?, side("width")?);
    let (line, word) = next("`map`")?;
    if word != "map" {
        return Err((line, "expected `map`".to_owned()));
    }
    let mut map = StaticMap::free(GridGeometry {
        origin_x_m: 0.0,
        origin_y_m: 0.0,
        resolution_m,
        width,
        height,
    });
    let width = width as usize;
    for row in map.cells.chunks_exact_mut(width).rev() {
        let (line, text) = next("its last row")?;
        if text.len() != width {
            return Err((line, format!("expected {width} characters")));
        }
        for (cell, character) in row.iter_mut().zip(text.chars()) {
            *cell = match character {
                '.' | 'G' | 'S' => Occupancy::Free,
                '@' | 'O' | 'T' | 'W' => Occupancy::Occupied,
                _ => {
                    return Err((
                        line,
                        format!("expected one of `.GS@OTW`, not {character:?}"),
                    ));
                }
            };
        }
    }
    Ok(map)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::WorldError;
    use nalgebra::Point2;
    use zeronav_world::spec::WorldSpec;

    const MAP: &str = "type octile\nheight 2\nwidth 3\nmap\n..@\nT.G\n";

    #[test]
    fn the_first_line_has_the_largest_y() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("x.map");
        std::fs::write(&file, MAP).unwrap();
        let spec = WorldSpec {
            resolution_m: 0.5,
            ..WorldSpec::of_map(&file)
        };
        let (world, warnings) = crate::load(&spec).unwrap();
        assert!(warnings.is_empty());
        let at = |x, y| world.rasterise().at(Point2::new(x, y));
        assert_eq!(at(1.25, 0.75), Some(Occupancy::Occupied));
        assert_eq!(at(0.25, 0.25), Some(Occupancy::Occupied));
        assert_eq!(at(0.25, 0.75), Some(Occupancy::Free));
        assert_eq!(at(1.25, 0.25), Some(Occupancy::Free));
        assert_eq!(at(1.75, 0.25), None);
        let wrong = WorldSpec {
            resolution_m: -1.0,
            ..spec
        };
        assert!(matches!(crate::load(&wrong), Err(WorldError::Spec(_))));
    }

    #[test]
    fn wrong_lines_are_named() {
        for (from, to, line) in [
            ("octile", "tile", 1),
            ("height 2", "height 0", 2),
            ("width 3", "length 3", 3),
            ("map", "pam", 4),
            ("..@", "..", 5),
            ("T.G", "T.?", 6),
            ("T.G\n", "", 6),
        ] {
            let text = MAP.replace(from, to);
            assert_eq!(parse(&text, 1.0).unwrap_err().0, line, "{text}");
        }
    }
}
