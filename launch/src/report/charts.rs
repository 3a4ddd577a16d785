//! Figures of a report, as inline SVG. Colours come from the page's style sheet, so that they follow
//! light, dark and paper.

use super::html::{number, text_of, time};
use core::fmt::Write;
use zeronav_casts::Cast;
use zeronav_measure::result::latency::Figures;
use zeronav_measure::timings::{BINS_PER_DECADE, Slow, Spread};

/// Size of a histogram. [px]
const WIDTH: f64 = 340.0;
const HEIGHT: f64 = 132.0;
/// Where its bars stand: left, right, top, bottom. [px]
const LEFT: f64 = 8.0;
const RIGHT: f64 = 332.0;
const TOP: f64 = 22.0;
const BOTTOM: f64 = 108.0;

/// Width of a label, and where the last one begins at most. [px]
const LABEL: f64 = 84.0;
const LABELS_END: f64 = RIGHT - 76.0;

/// Bins beyond these cannot come from a run. 0.1 ns and 3 hours.
const BINS: [i32; 2] = [-48, 120];

/// A histogram over a logarithmic scale of time.
pub(super) fn histogram(title: &str, spread: &Spread) -> String {
    let known = |bin: &&(i32, u64)| (BINS[0]..=BINS[1]).contains(&bin.0) && bin.1 > 0;
    let bins: Vec<(i32, u64)> = spread.bins.iter().filter(known).copied().collect();
    let figures = spread.figures.supported();
    let (Some(first), Some(last)) = (
        bins.iter().map(|bin| bin.0).min(),
        bins.iter().map(|bin| bin.0).max(),
    ) else {
        return String::new();
    };
    let (first, last) = (first - 1, last + 2);
    let most = bins.iter().map(|bin| bin.1).max().unwrap_or(1);
    let bin_px = (RIGHT - LEFT) / f64::from(last - first);
    let x_of_bin = |bin: f64| LEFT + (bin - f64::from(first)) * bin_px;
    let x = |us: f64| x_of_bin(us.max(1.0e-4).log10() * BINS_PER_DECADE).clamp(LEFT, RIGHT);
    let mut svg = format!(
        "<figure><figcaption><b>{}</b> n = {}{}</figcaption>\
         <svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">",
        text_of(title),
        figures.n,
        if figures.censored > 0 {
            format!(", {} unanswered", figures.censored)
        } else {
            String::new()
        },
        text_of(title)
    );
    axis(&mut svg, first, last, x_of_bin);
    for (bin, n) in &bins {
        let height = ((*n).to_f64() / most.to_f64() * (BOTTOM - TOP)).max(1.5);
        let _ = write!(
            svg,
            "<rect class=\"bar\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height:.1}\">\
             <title>{} from {} to {}</title></rect>",
            x_of_bin(f64::from(*bin)) + 0.4,
            BOTTOM - height,
            (bin_px - 0.8).max(0.6),
            n,
            time(edge_us(*bin)),
            time(edge_us(*bin + 1)),
        );
    }
    // Labels stand beside each other where their marks are close, the first one left of the last.
    let marks = [
        ("p50", figures.p50_us, LABELS_END - LABEL),
        ("p99", figures.p99_us, LABELS_END),
    ];
    let mut free_from = LEFT;
    for (name, us, label_px_max) in marks {
        let Some(us) = us.filter(|us| us.is_finite()) else {
            continue;
        };
        let at = x(us);
        let label_px = (at - 24.0).min(label_px_max).max(free_from);
        free_from = label_px + LABEL;
        let _ = write!(
            svg,
            "<line class=\"mark\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{:.1}\" y2=\"{BOTTOM}\"/>\
             <text x=\"{label_px:.1}\" y=\"12\">{name} {}</text>",
            TOP - 6.0,
            time(us)
        );
    }
    svg.push_str("</svg></figure>\n");
    svg
}

/// Lower edge of a bin. [us]
fn edge_us(bin: i32) -> f64 {
    10f64.powf(f64::from(bin) / BINS_PER_DECADE)
}

/// The line under a histogram, with the powers of ten.
fn axis(svg: &mut String, first: i32, last: i32, x_of_bin: impl Fn(f64) -> f64) {
    let _ = write!(
        svg,
        "<line class=\"axis\" x1=\"{LEFT}\" x2=\"{RIGHT}\" y1=\"{BOTTOM}\" y2=\"{BOTTOM}\"/>"
    );
    let decade = 12;
    let narrow = last - first < 2 * decade;
    for bin in first..=last {
        let part = bin.rem_euclid(decade);
        // 1, and where there is room also 2 (3.6 bins on) and 5 (8.4).
        let marks: &[f64] = match (part, narrow) {
            (0, false) => &[1.0],
            (0, true) => &[1.0, 2.0, 5.0],
            _ => continue,
        };
        for mark in marks {
            let us = edge_us(bin) * mark;
            let at = x_of_bin(f64::from(bin) + mark.log10() * BINS_PER_DECADE);
            if at > RIGHT {
                continue;
            }
            let _ = write!(
                svg,
                "<line class=\"axis\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{BOTTOM}\" y2=\"{:.1}\"/>\
                 <text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                BOTTOM + 4.0,
                at.clamp(LEFT + 10.0, RIGHT - 12.0),
                BOTTOM + 17.0,
                short_time(us)
            );
        }
    }
}

/// A round time: `20 µs`, `1 ms`.
fn short_time(us: f64) -> String {
    match us {
        us if us < 0.95 => format!("{} ns", number(us * 1.0e3, 0)),
        us if us < 950.0 => format!("{} µs", number(us, 0)),
        us if us < 950_000.0 => format!("{} ms", number(us / 1.0e3, 0)),
        us => format!("{} s", number(us / 1.0e6, 0)),
    }
}

/// Class of a hop: the process that works, or waiting for one.
fn class(hop: &str) -> &'static str {
    match hop {
        "robot" => "h1",
        "mapping" => "h2",
        "global_planner" => "h3",
        "local_planner" => "h4",
        "collision_guard" => "h5",
        "detect" => "h6",
        _ => "h0",
    }
}

/// What the colours of hops mean.
pub(super) fn hop_legend() -> String {
    let mut html = "<p class=\"legend\">".to_owned();
    for (name, hop) in [
        ("robot", "robot"),
        ("mapping", "mapping"),
        ("global planner", "global_planner"),
        ("local planner", "local_planner"),
        ("collision guard", "collision_guard"),
        ("not yet on the map", "detect"),
        ("transport and waking", "to_robot"),
    ] {
        let _ = write!(html, "<span><i class=\"{}\"></i>{name}</span>", class(hop));
    }
    html.push_str("</p>\n");
    html
}

/// The hops of a slow answer as one bar, below them the stages of those that have some; `whole_us`
/// is as wide as the cell.
pub(super) fn waterfall(slow: &Slow, whole_us: f64) -> String {
    let mut svg =
        "<svg class=\"strip\" viewBox=\"0 0 1000 14\" preserveAspectRatio=\"none\">".to_owned();
    let scale = if whole_us > 0.0 {
        1000.0 / whole_us
    } else {
        0.0
    };
    let mut at = 0.0;
    for (name, us) in slow.hops.iter().take(16) {
        let us = if us.is_finite() { us.max(0.0) } else { 0.0 };
        let width = (us * scale).min(1000.0);
        let staged = slow.stages.iter().any(|stage| stage.hop == *name);
        let _ = write!(
            svg,
            "<rect class=\"{}\" x=\"{at:.1}\" width=\"{width:.1}\" height=\"{}\">\
             <title>{} {}</title></rect>",
            class(name),
            if staged { 7 } else { 14 },
            text_of(name),
            time(us)
        );
        at = (at + width).min(1000.0);
    }
    let mut shade = ["", " far"].into_iter().cycle();
    for stage in slow.stages.iter().take(32) {
        let px = |us: f64| (us * scale).clamp(0.0, 1000.0);
        let (from, to) = (px(stage.from_us), px(stage.from_us + stage.time_us));
        if !(from.is_finite() && to > from) {
            continue;
        }
        let _ = write!(
            svg,
            "<rect class=\"{}{}\" x=\"{from:.1}\" y=\"7\" width=\"{:.1}\" height=\"7\">\
             <title>{}: {} {}</title></rect>",
            class(&stage.hop),
            shade.next().unwrap_or_default(),
            to - from,
            text_of(&stage.hop),
            text_of(&stage.name),
            time(stage.time_us)
        );
    }
    svg.push_str("</svg>");
    svg
}

/// A bar of p50 on one of p99 or the worst, as far as there are so many samples; `whole_us` is as
/// wide as the cell.
pub(super) fn hop_bar(name: &str, figures: &Figures, whole_us: f64) -> String {
    let figures = figures.supported();
    let scale = if whole_us > 0.0 {
        1000.0 / whole_us
    } else {
        0.0
    };
    let px = |us: Option<f64>| us.filter(|us| us.is_finite()).map_or(0.0, |us| us * scale);
    let far = px(figures.p99_us.or(figures.max_us)).clamp(0.0, 1000.0);
    let near = px(figures.p50_us.or(figures.max_us)).clamp(0.0, 1000.0);
    let class = class(name);
    format!(
        "<svg class=\"strip\" viewBox=\"0 0 1000 14\" preserveAspectRatio=\"none\">\
         <rect class=\"{class} far\" width=\"{far:.1}\" height=\"14\"/>\
         <rect class=\"{class}\" width=\"{near:.1}\" height=\"14\"/></svg>"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_measure::timings::SlowStage;

    fn stage(hop: &str, name: &str, from_us: f64, time_us: f64) -> SlowStage {
        SlowStage {
            hop: hop.to_owned(),
            name: name.to_owned(),
            from_us,
            time_us,
        }
    }

    fn figures(p50_us: f64, p99_us: f64) -> Figures {
        Figures {
            n: 200,
            censored: 0,
            p50_us: Some(p50_us),
            p90_us: Some(p50_us),
            p99_us: Some(p99_us),
            max_us: Some(p99_us),
        }
    }

    #[test]
    fn bars_of_a_histogram_lie_in_order_and_inside() {
        let spread = Spread {
            figures: figures(450.0, 2000.0),
            bins: vec![(31, 150), (32, 40), (39, 10)],
            ..Spread::default()
        };
        let svg = histogram("a < b", &spread);
        assert!(svg.contains("a &lt; b") && svg.contains("n = 200"));
        assert_eq!(svg.matches("class=\"bar\"").count(), 3);
        let xs: Vec<f64> = svg
            .split("class=\"bar\" x=\"")
            .skip(1)
            .map(|rest| rest.split('"').next().unwrap().parse().unwrap())
            .collect();
        assert!(xs.is_sorted() && xs[0] > LEFT && xs[2] < RIGHT, "{xs:?}");
        assert!(svg.contains("p50 450 µs") && svg.contains("p99 2.00 ms"));
        assert_eq!(histogram("none", &Spread::default()), "");
    }

    #[test]
    fn labels_of_marks_at_the_right_edge_stay_inside() {
        let spread = Spread {
            figures: figures(450.0, 455.0),
            bins: vec![(0, 1), (31, 150)],
            ..Spread::default()
        };
        let svg = histogram("late", &spread);
        let label = |name: &str| {
            let before = &svg[..svg.find(&format!(">{name} ")).expect("a label")];
            let at = before.rfind("<text x=\"").expect("its place") + "<text x=\"".len();
            before[at..]
                .split('"')
                .next()
                .unwrap()
                .parse::<f64>()
                .unwrap()
        };
        assert!((label("p99") - LABELS_END).abs() < 0.1, "{svg}");
        assert!((label("p50") + LABEL - LABELS_END).abs() < 0.1, "{svg}");
    }

    #[test]
    fn foreign_numbers_break_nothing() {
        let spread = Spread {
            figures: Figures {
                p50_us: Some(f64::INFINITY),
                ..figures(-5.0, f64::NAN)
            },
            bins: vec![(i32::MIN, 5), (i32::MAX, 5), (3, 0), (4, 1)],
            ..Spread::default()
        };
        let svg = histogram("x", &spread);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        let slow = Slow {
            time_s: 0.0,
            round: None,
            total_us: 1.0,
            hops: vec![("</svg>".to_owned(), f64::NAN), ("robot".to_owned(), 1e300)],
            stages: vec![
                stage("robot", "</svg>", 0.0, f64::INFINITY),
                stage("robot", "cast", f64::NAN, 1.0),
            ],
        };
        let svg = waterfall(&slow, 10.0);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        assert_eq!(svg.matches("</svg>").count(), 1);
    }

    #[test]
    fn hops_of_a_waterfall_add_up() {
        let slow = Slow {
            time_s: 0.0,
            round: None,
            total_us: 100.0,
            hops: vec![("robot".to_owned(), 25.0), ("to_robot".to_owned(), 75.0)],
            stages: vec![stage("robot", "step", 5.0, 20.0)],
        };
        let svg = waterfall(&slow, 200.0);
        assert!(
            svg.contains("class=\"h1\" x=\"0.0\" width=\"125.0\""),
            "{svg}"
        );
        assert!(
            svg.contains("class=\"h0\" x=\"125.0\" width=\"375.0\""),
            "{svg}"
        );
        assert!(svg.contains("x=\"25.0\" y=\"7\" width=\"100.0\""), "{svg}");
        assert!(svg.contains("robot: step 20 µs"), "{svg}");
    }
}
