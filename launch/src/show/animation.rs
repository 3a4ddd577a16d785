//! A recorded run as an animated SVG: map, robot, path, obstacles and clock, played in a loop.
//!
//! SMIL only, no script, so that it also plays as an image of a page. Attributes outside the
//! animations show the end of the run, for viewers that do not play it. Colours follow the viewer's
//! light or dark scheme.

use super::captions::captions;
use super::recording::{RecordedObstacle, Recording, first_and_last, unwrapped};
use core::fmt::Write;
use zeronav_casts::Cast;
use zeronav_console::svg::{escape, polyline, short};

/// Width of the drawing. [px]
const WIDTH_PX: f64 = 800.0;
/// Border around everything. [px]
const BORDER_PX: f64 = 14.0;
/// Height of the two lines above the map. [px]
const HEAD_PX: f64 = 62.0;
/// Height of the progress bar and the legend below the map. [px]
const FOOT_PX: f64 = 46.0;
/// A drive is played in about this time. [s]
const PLAYED_S: f64 = 12.0;
/// The end stays for so long before the loop begins again. [s]
const HOLD_S: f64 = 2.0;
/// Poses of one animation at most.
const FRAMES_MAX: usize = 360;
/// Paths that are shown at most: the first and the last ones.
const PATHS_MAX: usize = 40;
/// Points of a track or a path that are looked at, at most.
const POINTS_MAX: usize = 1500;
/// Replaced paths stay visible when there are no more than this.
const OLD_PATHS_MAX: usize = 4;
/// A small robot is drawn larger than it is, so that its nose reaches this far. [px]
const REACH_PX_MIN: f64 = 8.0;

/// Colours, light and dark.
const STYLE: &str = include_str!("animation/style.css");

/// The drawing while it is written.
struct Drawing<'run> {
    run: &'run Recording,
    svg: String,
    /// Pixels of a metre.
    scale: f64,
    /// Run time in which one second is played. [s]
    speed: f64,
    /// Run time of one loop, the hold at its end included. [s]
    loop_s: f64,
}

impl Recording {
    /// The run as a self-contained animated SVG document.
    #[must_use]
    pub(crate) fn to_animation(&self) -> String {
        let width_m = (self.area_m[1][0] - self.area_m[0][0]).max(1.0e-3);
        let speed = (self.time_s / PLAYED_S).round().max(1.0);
        let mut drawing = Drawing {
            run: self,
            svg: String::with_capacity(64 * 1024),
            scale: (WIDTH_PX - 2.0 * BORDER_PX) / width_m,
            speed,
            loop_s: self.time_s.max(0.1) + HOLD_S * speed,
        };
        drawing.draw();
        drawing.svg
    }
}

impl Drawing<'_> {
    fn draw(&mut self) {
        let map_px = (self.run.area_m[1][1] - self.run.area_m[0][1]) * self.scale;
        let height_px = HEAD_PX + map_px + FOOT_PX;
        let _ = write!(
            self.svg,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH_PX} {height_px:.0}\" \
             role=\"img\"><title>{}</title><style>{STYLE}</style>\n\
             <rect class=\"background\" x=\".5\" y=\".5\" width=\"{}\" height=\"{:.1}\" rx=\"10\"/>\n",
            escape(&format!(
                "zeronav: {}, {}",
                self.run.scenario, self.run.outcome
            )),
            WIDTH_PX - 1.0,
            height_px - 1.0
        );
        self.map(map_px);
        let _ = writeln!(
            self.svg,
            "<clipPath id=\"map\"><rect width=\"{:.1}\" height=\"{map_px:.1}\"/></clipPath>\
             <g transform=\"translate({BORDER_PX} {HEAD_PX})\" clip-path=\"url(#map)\">",
            WIDTH_PX - 2.0 * BORDER_PX
        );
        self.goals();
        self.paths();
        self.track();
        for obstacle in &self.run.obstacles {
            self.obstacle(obstacle);
        }
        self.robot();
        self.svg.push_str("</g>\n");
        self.head();
        self.foot(HEAD_PX + map_px);
        self.svg.push_str("</svg>\n");
    }

    fn x(&self, x_m: f64) -> f64 {
        (x_m - self.run.area_m[0][0]) * self.scale
    }

    fn y(&self, y_m: f64) -> f64 {
        (self.run.area_m[1][1] - y_m) * self.scale
    }

    /// Share of the loop at a run time, for `keyTimes`.
    fn share(&self, time_s: f64) -> f64 {
        (time_s / self.loop_s).clamp(0.0, 1.0)
    }

    /// What every animation has in common.
    fn clock(&self) -> String {
        format!(
            "dur=\"{:.2}s\" repeatCount=\"indefinite\"",
            self.loop_s / self.speed
        )
    }

    /// An animation of `opacity`: `levels` from their run times on.
    fn opacity(&self, levels: &[(f64, f64)]) -> String {
        let (mut values, mut times) = (String::new(), String::new());
        for (at, (time_s, level)) in levels.iter().enumerate() {
            let separator = if at == 0 { "" } else { ";" };
            let _ = write!(values, "{separator}{level}");
            let _ = write!(times, "{separator}{}", short(self.share(*time_s), 4));
        }
        format!(
            "<animate attributeName=\"opacity\" calcMode=\"discrete\" values=\"{values}\" \
             keyTimes=\"{times}\" {}/>",
            self.clock()
        )
    }

    /// Frames of the animations of poses, evenly over the loop: run times. [s]
    fn frames(&self) -> impl Iterator<Item = f64> + use<> {
        let n = (self.loop_s * 10.0).to_usize().clamp(2, FRAMES_MAX);
        let step_s = self.loop_s / (n - 1).to_f64();
        (0..n).map(move |frame| frame.to_f64() * step_s)
    }

    fn map(&mut self, map_px: f64) {
        let _ = write!(
            self.svg,
            "<rect class=\"floor\" x=\"{BORDER_PX}\" y=\"{HEAD_PX}\" width=\"{:.1}\" \
             height=\"{map_px:.1}\"/><path class=\"wall\" \
             shape-rendering=\"crispEdges\" d=\"",
            WIDTH_PX - 2.0 * BORDER_PX
        );
        for [x_m, y_m, width_m, height_m] in &self.run.walls_m {
            let (x, y) = (self.x(*x_m) + BORDER_PX, self.y(y_m + height_m) + HEAD_PX);
            let (width, height) = (width_m * self.scale, height_m * self.scale);
            let _ = write!(
                self.svg,
                "M{} {}h{}v{}h-{}z",
                short(x, 1),
                short(y, 1),
                short(width, 1),
                short(height, 1),
                short(width, 1)
            );
        }
        self.svg.push_str("\"/>\n");
    }

    fn goals(&mut self) {
        for [x_m, y_m, _] in &self.run.goals {
            let (x, y) = (self.x(*x_m), self.y(*y_m));
            let _ = writeln!(
                self.svg,
                "<circle class=\"goal\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"6\" stroke-width=\"2\"/>\
                 <circle class=\"goal\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"11\" stroke-width=\"2\" \
                 style=\"fill:none\"/>"
            );
        }
    }

    /// Each path from its time until the next one; of a few, replaced ones stay as pale dashes.
    fn paths(&mut self) {
        let paths = first_and_last(&self.run.paths, PATHS_MAX);
        let old_stay = paths.len() <= OLD_PATHS_MAX;
        for (at, path) in paths.iter().enumerate() {
            let from_s = path.time_s;
            let until_s = paths.get(at + 1).map(|next| next.time_s);
            let points = self.line(path.points_m.iter().copied());
            let line = "class=\"path\" fill=\"none\" stroke-width=\"3\"";
            if let Some(until_s) = until_s.filter(|_| old_stay) {
                let animation = self.opacity(&[(0.0, 0.0), (until_s, 0.35)]);
                let _ = writeln!(
                    self.svg,
                    "<polyline {line} stroke-dasharray=\"5 7\" opacity=\".35\" points=\"{points}\">\
                     {animation}</polyline>"
                );
            }
            let mut levels = vec![(0.0, 0.0), (from_s, 1.0)];
            levels.extend(until_s.map(|until_s| (until_s, 0.0)));
            let last = u8::from(until_s.is_none());
            let _ = writeln!(
                self.svg,
                "<polyline {line} opacity=\"{last}\" points=\"{points}\">{}{}</polyline>",
                self.opacity(&levels),
                self.swell(from_s)
            );
        }
    }

    /// A line through these points of the map, every n-th of very many. [m]
    fn line(&self, points_m: impl ExactSizeIterator<Item = [f64; 2]>) -> String {
        let step = points_m.len().div_ceil(POINTS_MAX).max(1);
        let last = points_m.len().saturating_sub(1);
        let kept = points_m
            .enumerate()
            .filter(|(at, _)| at % step == 0 || *at == last);
        let points: Vec<[f64; 2]> = kept
            .map(|(_, [x_m, y_m])| [self.x(x_m), self.y(y_m)])
            .collect();
        polyline(&points)
    }

    /// A line that is wide for a moment when it appears.
    fn swell(&self, from_s: f64) -> String {
        let [from, wide, thin] = [0.0, 0.15, 0.6].map(|s| self.share(from_s + s * self.speed));
        if from <= 0.0 || thin >= 1.0 {
            return String::new();
        }
        format!(
            "<animate attributeName=\"stroke-width\" values=\"3;3;8;3;3\" \
             keyTimes=\"0;{};{};{};1\" {}/>",
            short(from, 4),
            short(wide, 4),
            short(thin, 4),
            self.clock()
        )
    }

    /// The driven track, which grows with the distance.
    fn track(&mut self) {
        let robot = &self.run.robot;
        let points = self.line(robot.iter().map(|at| [at[1], at[2]]));
        let mut driven = vec![0.0];
        for pair in robot.windows(2) {
            let step_m = (pair[1][1] - pair[0][1]).hypot(pair[1][2] - pair[0][2]);
            driven.push(driven[driven.len() - 1] + step_m);
        }
        let whole_m = driven[driven.len() - 1].max(1.0e-6);
        let mut values = String::new();
        for time_s in self.frames() {
            let at = robot
                .partition_point(|pose| pose[0] <= time_s)
                .saturating_sub(1);
            let left = 1.0 - driven[at] / whole_m;
            let _ = write!(values, "{};", short(left, 4));
        }
        let _ = writeln!(
            self.svg,
            "<polyline class=\"track\" fill=\"none\" stroke-width=\"4\" opacity=\".85\" \
             pathLength=\"1\" stroke-dasharray=\"1 1\" points=\"{}\">\
             <animate attributeName=\"stroke-dashoffset\" values=\"{}\" {}/></polyline>",
            points,
            values.trim_end_matches(';'),
            self.clock()
        );
    }

    /// Animations of place and yaw along `poses`, each of which holds until the next.
    fn motion(&self, poses: &[[f64; 4]]) -> (String, String) {
        let (mut places, mut turns) = (String::new(), String::new());
        for time_s in self.frames() {
            let at = poses
                .partition_point(|pose| pose[0] <= time_s)
                .saturating_sub(1);
            let [_, x_m, y_m, yaw_rad] = poses[at];
            let (x, y) = (self.x(x_m), self.y(y_m));
            let _ = write!(places, "{} {};", short(x, 1), short(y, 1));
            let _ = write!(turns, "{};", short(-yaw_rad.to_degrees(), 0));
        }
        let animate = |kind: &str, values: &str| {
            format!(
                "<animateTransform attributeName=\"transform\" type=\"{kind}\" values=\"{}\" {}/>",
                values.trim_end_matches(';'),
                self.clock()
            )
        };
        (animate("translate", &places), animate("rotate", &turns))
    }

    /// Opens the groups of something that moves along `poses`; two groups are to be closed.
    fn open_moving(&mut self, poses: &[[f64; 4]]) {
        let [_, x_m, y_m, yaw_rad] = poses[poses.len() - 1];
        let place = format!("translate({:.1} {:.1})", self.x(x_m), self.y(y_m));
        let (places, turns) = match poses.len() {
            1 => (String::new(), String::new()),
            _ => self.motion(&unwrapped(poses)),
        };
        let turn = format!("rotate({:.1})", -yaw_rad.to_degrees());
        let _ = write!(
            self.svg,
            "<g transform=\"{place}\">{places}<g transform=\"{turn}\">{turns}"
        );
    }

    fn robot(&mut self) {
        let run = self.run;
        if run.robot.is_empty() {
            return;
        }
        self.open_moving(&run.robot);
        let reach_m = run.footprint_m.iter().map(|at| at[0]).fold(0.01, f64::max);
        let reach = (reach_m * self.scale).max(REACH_PX_MIN);
        let larger = reach / (reach_m * self.scale);
        let outline: Vec<[f64; 2]> = run
            .footprint_m
            .iter()
            .map(|at| at.map(|m| larger * m))
            .collect();
        let outline = self.outline(&outline);
        let _ = writeln!(
            self.svg,
            "<circle class=\"robot\" stroke=\"none\" opacity=\".25\" r=\"{0:.1}\"/>\
             <polygon class=\"robot\" stroke-width=\"1.5\" points=\"{outline}\"/>\
             <path class=\"nose\" d=\"M{1:.1} 0L-{2:.1} {2:.1}L-{3:.1} 0L-{2:.1}-{2:.1}z\"/></g></g>",
            1.7 * reach,
            0.75 * reach,
            0.5 * reach,
            0.2 * reach
        );
    }

    /// An obstacle, which drops at its time: a ring spreads from the place.
    fn obstacle(&mut self, obstacle: &RecordedObstacle) {
        let Some(first) = obstacle.poses.first() else {
            return;
        };
        let appears_s = first[0];
        let drops = self.share(appears_s) > 0.002;
        let _ = write!(self.svg, "<g>");
        if drops {
            self.svg += &self.opacity(&[(0.0, 0.0), (appears_s, 1.0)]);
        }
        self.open_moving(&obstacle.poses);
        let outline = self.outline(&obstacle.outline_m);
        let [from, to, gone] = [0.0, 0.3, 0.9].map(|s| self.share(appears_s + s * self.speed));
        let times = |end: f64| format!("0;{};{};1", short(from, 4), short(end, 4));
        let (mut drop, mut ring) = (String::new(), String::new());
        if drops {
            drop = format!(
                "<animateTransform attributeName=\"transform\" type=\"scale\" values=\"2.2;2.2;1;1\" \
                 keyTimes=\"{}\" {}/>",
                times(to),
                self.clock()
            );
            ring = format!(
                "<circle class=\"ring\" fill=\"none\" stroke-width=\"3\" r=\"0\" opacity=\"0\">\
                 <animate attributeName=\"r\" values=\"0;8;60;60\" keyTimes=\"{0}\" {1}/>\
                 <animate attributeName=\"opacity\" values=\"0;1;0;0\" keyTimes=\"{0}\" {1}/></circle>",
                times(gone),
                self.clock()
            );
        }
        let _ = writeln!(
            self.svg,
            "{ring}<g>{drop}<polygon class=\"obstacle\" stroke-width=\"1.5\" points=\"{outline}\">\
             <title>{}</title></polygon></g></g></g></g>",
            escape(&obstacle.name)
        );
    }

    /// An outline in its own frame, upright.
    fn outline(&self, corners_m: &[[f64; 2]]) -> String {
        let corners = corners_m.iter();
        polyline(
            &corners
                .map(|[x, y]| [x * self.scale, -y * self.scale])
                .collect::<Vec<_>>(),
        )
    }

    /// Scenario, clock, and what has just happened.
    fn head(&mut self) {
        let _ = writeln!(
            self.svg,
            "<text class=\"strong\" x=\"{BORDER_PX}\" y=\"28\" font-size=\"19\" font-weight=\"600\">{}</text>",
            escape(&self.run.scenario)
        );
        let right = WIDTH_PX - BORDER_PX;
        // A second of run time for each text, more in runs of more than two minutes.
        let step_s = (self.run.time_s / 120.0).ceil().max(1.0);
        let mut time_s = 0.0;
        while time_s <= self.run.time_s {
            let is_last = time_s + step_s > self.run.time_s;
            let text = format!("{time_s:.0} s");
            let until_s = (!is_last).then_some(time_s + step_s);
            let font = "text-anchor=\"end\" font-size=\"19\" font-weight=\"600\" y=\"28\"";
            self.text(right, font, "strong", &text, time_s, until_s);
            time_s += step_s;
        }
        let _ = writeln!(
            self.svg,
            "<text class=\"muted\" x=\"{right}\" y=\"50\" text-anchor=\"end\" font-size=\"14\">{:.0}x real \
             time</text>",
            self.speed
        );
        let captions = captions(self.run);
        for (at, (time_s, text)) in captions.iter().enumerate() {
            let until_s = captions.get(at + 1).map(|next| next.0);
            self.text(
                BORDER_PX,
                "font-size=\"15\" y=\"50\"",
                "muted",
                text,
                *time_s,
                until_s,
            );
        }
    }

    /// A text that is shown for a time. [s]
    fn text(
        &mut self,
        x: f64,
        font: &str,
        class: &str,
        text: &str,
        from_s: f64,
        until_s: Option<f64>,
    ) {
        let mut levels = vec![(0.0, f64::from(u8::from(from_s <= 0.0)))];
        if from_s > 0.0 {
            levels.push((from_s, 1.0));
        }
        levels.extend(until_s.map(|until_s| (until_s, 0.0)));
        let last = u8::from(until_s.is_none());
        let animation = self.opacity(&levels);
        let _ = writeln!(
            self.svg,
            "<text class=\"{class}\" x=\"{x}\" {font} opacity=\"{last}\">{}{animation}</text>",
            escape(text)
        );
    }

    /// The progress bar and the legend.
    fn foot(&mut self, top_px: f64) {
        let width = WIDTH_PX - 2.0 * BORDER_PX;
        let (bar_y, legend_y) = (top_px + 8.0, top_px + 32.0);
        let _ = writeln!(
            self.svg,
            "<rect class=\"bar\" x=\"{BORDER_PX}\" y=\"{bar_y:.1}\" width=\"{width}\" height=\"4\" \
             rx=\"2\"/><rect class=\"done\" x=\"{BORDER_PX}\" y=\"{bar_y:.1}\" width=\"{width}\" \
             height=\"4\" rx=\"2\"><animate attributeName=\"width\" values=\"0;{width};{width}\" \
             keyTimes=\"0;{};1\" {}/></rect>",
            short(self.share(self.run.time_s), 4),
            self.clock()
        );
        let rows = [
            ("track", "driven", ""),
            ("path", "path", ""),
            (
                "path",
                "replaced path",
                " stroke-dasharray=\"5 6\" opacity=\".5\"",
            ),
        ];
        let mut x = BORDER_PX;
        for (class, name, look) in rows {
            let _ = writeln!(
                self.svg,
                "<path class=\"{class}\" d=\"M{x} {legend_y:.1}h26\" stroke-width=\"4\"{look}/>\
                 <text class=\"muted\" x=\"{}\" y=\"{:.1}\" font-size=\"13\">{name}</text>",
                x + 34.0,
                legend_y + 4.5
            );
            x += if name.len() > 6 { 146.0 } else { 100.0 };
        }
        let _ = writeln!(
            self.svg,
            "<rect class=\"obstacle\" x=\"{x}\" y=\"{:.1}\" width=\"14\" height=\"12\"/>\
             <text class=\"muted\" x=\"{}\" y=\"{:.1}\" font-size=\"13\">obstacle that no map shows</text>",
            legend_y - 6.0,
            x + 22.0,
            legend_y + 4.5
        );
    }
}

#[cfg(test)]
mod tests;
