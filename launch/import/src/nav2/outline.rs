//! The robot's outline: convex and counter-clockwise, as a scenario wants it, whatever was given.

use super::yaml::{self, Value};
use zeronav_msgs::description::FOOTPRINT_CORNERS_MAX;

/// Largest coordinate of a corner. [m]
const CORNER_M_MAX: f64 = 100.0;

/// What was changed of an outline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mended {
    /// Nothing.
    Nothing,
    /// It was listed clockwise.
    Reversed,
    /// It was not convex, or had corners on its sides.
    Hull,
}

/// The corners in the text of `footprint`, such as `[[0.2, 0.1], ...]`; none when it is empty. [m]
///
/// # Errors
/// What is wrong.
pub(super) fn corners_of(value: &Value) -> Result<Vec<[f64; 2]>, String> {
    let shape = "must be a list of at least three corners, such as \"[[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2]]\"";
    let wrong = || shape.to_owned();
    let list = match value {
        Value::Text(text) if text.trim().is_empty() => return Ok(Vec::new()),
        Value::Text(text) => yaml::read(text).map_err(|_| wrong())?.value,
        other => other.clone(),
    };
    let Value::List(corners) = list else {
        return Err(wrong());
    };
    if corners.is_empty() {
        return Ok(Vec::new());
    }
    let mut read = Vec::new();
    for corner in &corners {
        let Value::List(numbers) = &corner.value else {
            return Err(wrong());
        };
        match numbers.iter().map(|it| &it.value).collect::<Vec<_>>()[..] {
            [Value::Number(x), Value::Number(y)] => read.push([*x, *y]),
            _ => return Err(wrong()),
        }
    }
    if read.len() < 3 {
        return Err(wrong());
    }
    Ok(read)
}

/// The outline of corners, convex and counter-clockwise, and what was changed. [m]
///
/// # Errors
/// What is wrong: a number, too many corners, no area, or an origin that is not inside.
pub(super) fn upright(corners: &[[f64; 2]]) -> Result<(Vec<[f64; 2]>, Mended), String> {
    if let Some(wrong) = corners
        .iter()
        .flatten()
        .find(|it| !it.is_finite() || it.abs() > CORNER_M_MAX)
    {
        return Err(format!(
            "its coordinates must be -{CORNER_M_MAX} to {CORNER_M_MAX} m, not {wrong}"
        ));
    }
    let hull = hull(corners);
    if hull.len() > FOOTPRINT_CORNERS_MAX {
        return Err(format!(
            "has {} corners, at most {FOOTPRINT_CORNERS_MAX}",
            hull.len()
        ));
    }
    let inscribed_m = inscribed_m(&hull);
    if hull.len() < 3 || inscribed_m < 1.0e-3 {
        let why = "must hold the origin of the base frame, the point about which the robot turns";
        return Err(why.to_owned());
    }
    let area = |corners: &[[f64; 2]]| -> f64 {
        let sides = corners.iter().zip(corners.iter().cycle().skip(1));
        sides.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum()
    };
    // All corners are on the hull, and in its order when the area is the same.
    if hull.len() < corners.len() || (area(corners).abs() - area(&hull)).abs() > 1.0e-9 {
        return Ok((hull, Mended::Hull));
    }
    if area(corners) < 0.0 {
        return Ok((corners.iter().rev().copied().collect(), Mended::Reversed));
    }
    Ok((corners.to_vec(), Mended::Nothing))
}

/// Distance from the origin to the nearest side of a convex outline, counter-clockwise; negative when the origin is
/// outside. [m]
pub(super) fn inscribed_m(corners: &[[f64; 2]]) -> f64 {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let distances =
        sides.map(|(a, b)| (a[0] * b[1] - a[1] * b[0]) / (b[0] - a[0]).hypot(b[1] - a[1]));
    distances.fold(f64::INFINITY, f64::min)
}

/// The convex hull, counter-clockwise, without corners on its sides (Andrew's monotone chain, 1979).
pub(super) fn hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    let mut hull = half(sorted.iter());
    let back = half(sorted.iter().rev());
    hull.pop();
    hull.extend(back);
    hull.pop();
    hull
}

/// One half of the hull.
fn half<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> Vec<[f64; 2]> {
    let mut chain: Vec<[f64; 2]> = Vec::new();
    for point in points {
        while let [.., a, b] = chain[..] {
            let turn = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]);
            if turn > 1.0e-9 {
                break;
            }
            chain.pop();
        }
        chain.push(*point);
    }
    chain
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: [[f64; 2]; 4] = [[-0.2, -0.3], [0.4, -0.3], [0.4, 0.3], [-0.2, 0.3]];

    #[test]
    fn a_convex_counter_clockwise_outline_stays_as_it_is() {
        assert_eq!(upright(&BOX), Ok((BOX.to_vec(), Mended::Nothing)));
        assert!((inscribed_m(&BOX) - 0.2).abs() < 1e-12);
        // Begun at another corner, too.
        let turned = [BOX[2], BOX[3], BOX[0], BOX[1]];
        assert_eq!(upright(&turned), Ok((turned.to_vec(), Mended::Nothing)));
    }

    #[test]
    fn a_clockwise_outline_is_reversed_and_a_dented_one_becomes_its_hull() {
        let clockwise: Vec<[f64; 2]> = BOX.iter().rev().copied().collect();
        assert_eq!(upright(&clockwise), Ok((BOX.to_vec(), Mended::Reversed)));
        let dent = [BOX[0], BOX[1], [0.1, 0.0], BOX[2], BOX[3]];
        assert_eq!(
            upright(&dent),
            Ok((vec![BOX[0], BOX[1], BOX[2], BOX[3]], Mended::Hull))
        );
        let crossed = [BOX[0], BOX[2], BOX[1], BOX[3]];
        let (hull, mended) = upright(&crossed).expect("a hull");
        assert_eq!((hull.len(), mended), (4, Mended::Hull));
    }

    #[test]
    fn outlines_beside_the_origin_and_numbers_that_cannot_be_are_rejected() {
        for corners in [
            vec![[0.1, 0.0], [1.0, 0.0], [1.0, 1.0]],
            vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]],
            vec![[-1.0, -1.0], [f64::NAN, -1.0], [1.0, 1.0]],
            vec![[-1.0, -1.0], [1.0e9, -1.0], [1.0, 1.0]],
            Vec::new(),
        ] {
            upright(&corners).expect_err("no outline");
        }
    }

    #[test]
    fn the_text_of_a_footprint_is_read_as_ros_writes_it() {
        let read = |text: &str| corners_of(&Value::Text(text.to_owned()));
        let corners = read("[ [0.4, 0.3], [-0.2,0.3], [-0.2, -0.3], [4e-1, -0.3] ]");
        assert_eq!(corners.map(|it| it[3]), Ok([0.4, -0.3]));
        assert_eq!(read("[]"), Ok(Vec::new()));
        assert_eq!(read(""), Ok(Vec::new()));
        for text in [
            "[[1, 2], [3, 4]]",
            "[[1, 2, 3], [1, 2], [2, 1]]",
            "[1, 2, 3]",
            "round",
            "[[",
        ] {
            let why = read(text).expect_err(text);
            assert!(why.contains("corners"), "{text}: {why}");
        }
    }
}
