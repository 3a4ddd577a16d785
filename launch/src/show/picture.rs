//! The picture of a run, as SVG: map, obstacles, planned paths, driven track.

use core::fmt::Write;
use zeronav_casts::Cast;
use zeronav_console::svg::escape;

/// A line with a name in the legend.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    /// Its name.
    pub name: String,
    /// Its colour, as in CSS.
    pub colour: &'static str,
    /// True for dashes.
    pub dashed: bool,
    /// Its points, `map` frame. [m]
    pub points_m: Vec<[f64; 2]>,
}

/// A filled outline with a name beside it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Area {
    /// Its name.
    pub name: String,
    /// Its colour, as in CSS.
    pub colour: &'static str,
    /// Its corners, `map` frame. [m]
    pub corners_m: Vec<[f64; 2]>,
}

/// Everything that is drawn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Picture {
    /// Title above the map.
    pub title: String,
    /// Second line of the title.
    pub subtitle: String,
    /// Lower-left and upper-right corner of the static map. [m]
    pub area_m: [[f64; 2]; 2],
    /// Its occupied rectangles: x and y of the lower-left corner, width, height. [m]
    pub walls_m: Vec<[f64; 4]>,
    /// Scripted obstacles.
    pub areas: Vec<Area>,
    /// Paths and the track, drawn in this order.
    pub lines: Vec<Line>,
    /// Start of the robot. [m]
    pub start_m: [f64; 2],
    /// Goals. [m]
    pub goals_m: Vec<[f64; 2]>,
    /// Radius of the robot. [m]
    pub robot_radius_m: f64,
}

/// Width of the drawing. [px]
const WIDTH_PX: f64 = 1200.0;
/// Height of the title. [px]
const TITLE_PX: f64 = 64.0;
/// Height of a row of the legend. [px]
const LEGEND_ROW_PX: f64 = 24.0;
/// Border around everything. [px]
const BORDER_PX: f64 = 16.0;

/// From metres in the `map` frame to pixels.
struct Frame {
    scale: f64,
    left_m: f64,
    top_m: f64,
}

impl Frame {
    fn x(&self, x_m: f64) -> f64 {
        BORDER_PX + (x_m - self.left_m) * self.scale
    }

    fn y(&self, y_m: f64) -> f64 {
        TITLE_PX + (self.top_m - y_m) * self.scale
    }

    fn points(&self, points_m: &[[f64; 2]]) -> String {
        let mut text = String::new();
        for [x_m, y_m] in points_m {
            let _ = write!(text, "{:.1},{:.1} ", self.x(*x_m), self.y(*y_m));
        }
        text
    }
}

impl Picture {
    /// The picture as a self-contained SVG document.
    #[must_use]
    pub(crate) fn to_svg(&self) -> String {
        let [low, high] = self.area_m;
        let [width_m, height_m] = [high[0] - low[0], high[1] - low[1]];
        let frame = Frame {
            scale: (WIDTH_PX - 2.0 * BORDER_PX) / width_m.max(1.0e-3),
            left_m: low[0],
            top_m: high[1],
        };
        let map_px = height_m * frame.scale;
        let legend_px = LEGEND_ROW_PX * self.lines.len().div_ceil(3).to_f64() + BORDER_PX;
        let height_px = TITLE_PX + map_px + legend_px + BORDER_PX;
        let mut svg = String::with_capacity(64 * 1024);
        let _ = write!(
            svg,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH_PX} {height_px:.0}\" \
             font-family=\"sans-serif\" font-size=\"14\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
             <text x=\"{BORDER_PX}\" y=\"28\" font-size=\"20\" font-weight=\"bold\">{}</text>\n\
             <text x=\"{BORDER_PX}\" y=\"50\" fill=\"#555555\">{}</text>\n",
            escape(&self.title),
            escape(&self.subtitle)
        );
        let _ = writeln!(
            svg,
            "<rect x=\"{BORDER_PX}\" y=\"{TITLE_PX}\" width=\"{:.1}\" height=\"{map_px:.1}\" \
             fill=\"#f4f4f2\" stroke=\"#999999\"/>",
            width_m * frame.scale
        );
        self.draw_map(&frame, &mut svg);
        for area in &self.areas {
            let _ = writeln!(
                svg,
                "<polygon points=\"{}\" fill=\"{}\" fill-opacity=\"0.75\" stroke=\"#7a1f1f\">\
                 <title>{}</title></polygon>",
                frame.points(&area.corners_m),
                area.colour,
                escape(&area.name)
            );
        }
        for line in &self.lines {
            let _ = writeln!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"3\" \
                 stroke-linejoin=\"round\" stroke-opacity=\"0.9\"{}><title>{}</title></polyline>",
                frame.points(&line.points_m),
                line.colour,
                if line.dashed {
                    " stroke-dasharray=\"9 6\""
                } else {
                    ""
                },
                escape(&line.name)
            );
        }
        let radius_px = (self.robot_radius_m * frame.scale).max(3.0);
        let mut mark = |[x_m, y_m]: [f64; 2], fill: &str, name: &str| {
            let (x, y) = (frame.x(x_m), frame.y(y_m));
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius_px:.1}\" fill=\"{fill}\" \
                 stroke=\"#222222\"/><text x=\"{:.1}\" y=\"{:.1}\">{name}</text>",
                x + radius_px + 4.0,
                y + 5.0
            );
        };
        mark(self.start_m, "#ffffff", "start");
        for goal_m in &self.goals_m {
            mark(*goal_m, "#ffd34d", "goal");
        }
        self.draw_legend(TITLE_PX + map_px + BORDER_PX, &mut svg);
        svg.push_str("</svg>\n");
        svg
    }

    /// The occupied rectangles.
    fn draw_map(&self, frame: &Frame, svg: &mut String) {
        svg.push_str("<path shape-rendering=\"crispEdges\" fill=\"#3c4650\" d=\"");
        for [x_m, y_m, width_m, height_m] in &self.walls_m {
            let (x, y) = (frame.x(*x_m), frame.y(y_m + height_m));
            let (width, height) = (width_m * frame.scale, height_m * frame.scale);
            let _ = write!(svg, "M{x:.1} {y:.1}h{width:.1}v{height:.2}h-{width:.1}z");
        }
        svg.push_str("\"/>\n");
    }

    fn draw_legend(&self, top_px: f64, svg: &mut String) {
        for (n, line) in self.lines.iter().enumerate() {
            let (x, y) = (
                BORDER_PX + (n % 3).to_f64() * (WIDTH_PX / 3.0),
                top_px + (n / 3).to_f64() * LEGEND_ROW_PX + 8.0,
            );
            let _ = writeln!(
                svg,
                "<line x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{:.1}\" y2=\"{y:.1}\" stroke=\"{}\" \
                 stroke-width=\"3\"{}/><text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                x + 36.0,
                line.colour,
                if line.dashed {
                    " stroke-dasharray=\"9 6\""
                } else {
                    ""
                },
                x + 44.0,
                y + 5.0,
                escape(&line.name)
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_is_upright_and_escaped() {
        let picture = Picture {
            title: "a < b".to_owned(),
            subtitle: String::new(),
            area_m: [[0.0, 0.0], [4.0, 2.0]],
            walls_m: vec![[0.0, 0.0, 2.0, 1.0], [3.0, 1.0, 1.0, 1.0]],
            areas: Vec::new(),
            lines: Vec::new(),
            start_m: [0.5, 0.5],
            goals_m: vec![[3.5, 1.5]],
            robot_radius_m: 0.2,
        };
        let svg = picture.to_svg();
        assert!(svg.contains("a &lt; b"));
        // What is low lies farther down the page.
        let scale = (WIDTH_PX - 2.0 * BORDER_PX) / 4.0;
        let lower = format!("M{BORDER_PX:.1} {:.1}h{:.1}", TITLE_PX + scale, 2.0 * scale);
        let upper = format!("M{:.1} {TITLE_PX:.1}h{scale:.1}", BORDER_PX + 3.0 * scale);
        assert!(svg.contains(&lower), "{lower}");
        assert!(svg.contains(&upper), "{upper}");
    }
}
