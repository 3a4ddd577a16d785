//! Numbers, texts and lines as SVG.

use core::fmt::Write;
use zeronav_shell::printable::printable;

/// The points of a line, without those that lie on it anyway. [px]
#[must_use]
pub fn polyline(points: &[[f64; 2]]) -> String {
    let mut text = String::new();
    for [x, y] in simplified(points) {
        let _ = write!(text, "{},{} ", short(x, 1), short(y, 1));
    }
    text.trim_end().to_owned()
}

/// Points of a line that deviate less than this are left out. [px]
const BEND_PX: f64 = 0.4;

/// The fewest points, in halves, to which every other one is closer than [`BEND_PX`] (D. Douglas, T.
/// Peucker, 1973).
fn simplified(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else {
        return Vec::new();
    };
    let along = [last[0] - first[0], last[1] - first[1]];
    let length = along[0].hypot(along[1]);
    let aside = |point: &[f64; 2]| {
        let from = [point[0] - first[0], point[1] - first[1]];
        if length < 1.0 {
            return from[0].hypot(from[1]);
        }
        (along[0] * from[1] - along[1] * from[0]).abs() / length
    };
    let farthest = (1..points.len() - 1).max_by(|a, b| {
        let (a, b) = (aside(&points[*a]), aside(&points[*b]));
        a.total_cmp(&b)
    });
    match farthest.filter(|at| aside(&points[*at]) > BEND_PX) {
        Some(at) => {
            let mut kept = simplified(&points[..=at]);
            kept.pop();
            kept.extend(simplified(&points[at..]));
            kept
        }
        None if points.len() == 1 => vec![first],
        None => vec![first, last],
    }
}

/// A number with at most `digits` digits after the point.
#[must_use]
pub fn short(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = if digits > 0 {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        &text
    };
    if text == "-0" { "0" } else { text }.to_owned()
}

/// `text` safe inside SVG and HTML; what those or a reader could obey or not see is written out.
#[must_use]
pub fn escape(text: &str) -> String {
    printable(text)
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_keep_their_corners_only() {
        let straight: Vec<[f64; 2]> = (0..50).map(|at| [f64::from(at), 0.2]).collect();
        assert_eq!(polyline(&straight), "0,0.2 49,0.2");
        let corner = [[0.0, 0.0], [5.0, 0.1], [10.0, 0.0], [10.0, 10.0]];
        assert_eq!(polyline(&corner), "0,0 10,0 10,10");
        assert_eq!(polyline(&[[1.0, 2.0]]), "1,2");
        assert_eq!(polyline(&[]), "");
    }

    #[test]
    fn a_slow_bend_is_kept_within_half_a_pixel() {
        let arc = |at: i32| {
            let angle = f64::from(at) * 0.01;
            [100.0 * angle.cos(), 100.0 * angle.sin()]
        };
        let kept = simplified(&(0..=314).map(arc).collect::<Vec<_>>());
        assert!((10..40).contains(&kept.len()), "{}", kept.len());
        for pair in kept.windows(2) {
            let middle = [
                0.5 * (pair[0][0] + pair[1][0]),
                0.5 * (pair[0][1] + pair[1][1]),
            ];
            assert!(100.0 - middle[0].hypot(middle[1]) < 0.5, "{pair:?}");
        }
    }

    #[test]
    fn numbers_are_short_and_texts_escaped() {
        assert_eq!(
            [short(1.50, 2), short(-0.001, 1), short(20.0, 0)],
            ["1.5", "0", "20"]
        );
        assert_eq!(escape("a < \"b\" & c"), "a &lt; &quot;b&quot; &amp; c");
        assert_eq!(
            escape("\u{1}\u{202e}x\u{ffff}"),
            "\\u{1}\\u{202e}x\\u{ffff}"
        );
    }
}
