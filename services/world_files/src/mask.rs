//! Masks of costmap filters as Nav2 has them: a map file that also says what its pixels ask for.
//!
//! `type` 0 keeps out: cells of 100 percent, or more, are closed, others cost more in proportion. `type` 1
//! limits the speed in percent of the robot's fastest, `type` 2 in m/s. The number of a pixel is
//! `base + multiplier * occupancy`, its occupancy 0 to 100 percent by the mode of the map file; 0 percent
//! and unknown pixels ask for nothing. In Nav2 the three keys belong to the server of the filter's
//! information; here they are in the YAML file of the mask.

use crate::map_file::{MapYaml, check, parse, shade_of, text_of};
use crate::map_file_error::MapFileError;
use crate::map_image;
use crate::pixels::Pixels;
use serde::Deserialize;
use std::path::Path;
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::zones::{
    ZONE_COST_MAX, ZONE_PARTS_MAX, ZONE_PERCENT_MIN, ZONE_SPEED_MPS_MIN, ZoneKind,
};

/// A rectangle of pixels that ask for the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaskPart {
    /// What they ask for.
    pub kind: ZoneKind,
    /// By kind, as in [`zeronav_msgs::zones::ZonePart::value`].
    pub value: f64,
    /// Corners of the rectangle in the map frame, counter-clockwise. [m]
    pub corners_m: [[f64; 2]; 4],
}

#[derive(Debug, Deserialize)]
struct FilterYaml {
    #[serde(rename = "type")]
    kind: Option<u8>,
    #[serde(default)]
    base: f64,
    #[serde(default = "one")]
    multiplier: f64,
}

const fn one() -> f64 {
    1.0
}

/// What a pixel asks for; `None` = nothing.
type Asked = Option<(ZoneKind, f64)>;

/// Reads the mask that a YAML file describes, as the rectangles that it is made of.
///
/// # Errors
/// See [`MapFileError`]; each names the file. A mask that needs more rectangles than there may be parts
/// of zones is rejected.
pub fn load(file: &Path) -> Result<Vec<MaskPart>, MapFileError> {
    let text = text_of(file)?;
    let (map, filter): (MapYaml, FilterYaml) = (parse(file, &text)?, parse(file, &text)?);
    check(file, &map)?;
    let wrong = |field: &'static str, why: String| MapFileError::Field {
        file: file.to_path_buf(),
        field,
        why,
    };
    let Some(kind @ 0..=2) = filter.kind else {
        let why = "must be 0 (keepout), 1 (speed limit in percent) or 2 (speed limit in m/s)";
        return Err(wrong("type", why.to_owned()));
    };
    for (field, value) in [("base", filter.base), ("multiplier", filter.multiplier)] {
        if !(-1.0e6..=1.0e6).contains(&value) {
            return Err(wrong(field, format!("must be -1e6 to 1e6, not {value}")));
        }
    }
    let image_file = file.parent().unwrap_or(Path::new("")).join(&map.image);
    let pixels = map_image::read(&image_file)?;
    let table: [Asked; 256] = core::array::from_fn(|pixel| {
        let pixel = u8::try_from(pixel).unwrap_or(u8::MAX);
        asked(kind, &filter, shade_of(&map, pixel)?)
    });
    let corner = Pose::new(map.origin[0], map.origin[1], map.origin[2]);
    rectangles(&pixels, |index| {
        let transparent = !map.is_raw() && pixels.alpha_at(index) < u8::MAX;
        table[usize::from(pixels.grey[index])].filter(|_| !transparent)
    })
    .map(|rects| {
        let part = |rect: &Rect| rect.part(&corner, map.resolution);
        rects.iter().map(part).collect()
    })
    .ok_or_else(|| {
        let why = format!(
            "it takes more than {ZONE_PARTS_MAX} rectangles of equal pixels: draw it with fewer \
             steps and shades, or its zones as polygons"
        );
        wrong("image", why)
    })
}

/// What an occupancy in percent asks for.
fn asked(kind: u8, filter: &FilterYaml, percent: f64) -> Asked {
    if percent <= 0.0 {
        return None;
    }
    let value = filter.base + filter.multiplier * percent;
    match kind {
        _ if value <= 0.0 => None,
        0 if value >= 100.0 => Some((ZoneKind::Keepout, 0.0)),
        // As Nav2's keepout filter makes costs of percents.
        0 => Some((
            ZoneKind::Cost,
            (value * 2.54).round().clamp(1.0, ZONE_COST_MAX),
        )),
        1 if value >= 100.0 => None,
        1 => Some((ZoneKind::SpeedPercent, value.max(ZONE_PERCENT_MIN))),
        _ => Some((ZoneKind::SpeedLimit, value.clamp(ZONE_SPEED_MPS_MIN, 1.0e3))),
    }
}

/// Columns and rows, from the lower left, half-open.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Rect {
    asked: (ZoneKind, f64),
    x: [usize; 2],
    y: [usize; 2],
}

impl Rect {
    fn part(&self, corner: &Pose, resolution_m: f64) -> MaskPart {
        let ([x0, x1], [y0, y1]) = (self.x, self.y);
        let at = |x: usize, y: usize| {
            let (x_m, y_m) = (x.to_f64() * resolution_m, y.to_f64() * resolution_m);
            corner.transform([x_m, y_m].into()).into()
        };
        MaskPart {
            kind: self.asked.0,
            value: self.asked.1,
            corners_m: [at(x0, y0), at(x1, y0), at(x1, y1), at(x0, y1)],
        }
    }
}

/// Rectangles that cover what asks for something: runs of a row, and equal runs above one another joined.
/// `None` when they are too many.
fn rectangles(pixels: &Pixels, asked: impl Fn(usize) -> Asked) -> Option<Vec<Rect>> {
    let (width, height) = (pixels.width as usize, pixels.height as usize);
    let (mut closed, mut open): (Vec<Rect>, Vec<Rect>) = (Vec::new(), Vec::new());
    for y in 0..height {
        // The first row of the image is the highest.
        let row = (height - 1 - y) * width;
        let mut runs: Vec<Rect> = Vec::new();
        for x in 0..width {
            let Some(asked) = asked(row + x) else {
                continue;
            };
            match runs.last_mut() {
                Some(run) if run.x[1] == x && run.asked == asked => run.x[1] = x + 1,
                _ => runs.push(Rect {
                    asked,
                    x: [x, x + 1],
                    y: [y, y + 1],
                }),
            }
        }
        for run in &mut runs {
            let below = open
                .iter()
                .position(|it| it.x == run.x && it.asked == run.asked);
            if let Some(below) = below {
                run.y[0] = open.swap_remove(below).y[0];
            }
        }
        closed.append(&mut open);
        open = runs;
        if closed.len() + open.len() > ZONE_PARTS_MAX {
            return None;
        }
    }
    closed.append(&mut open);
    Some(closed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// What a mask of these pixels is made of, from the top row down.
    fn of(yaml: &str, width: usize, grey: &[u8]) -> Result<Vec<MaskPart>, String> {
        let folder = tempfile::tempdir().unwrap();
        let head = format!("P5\n{width} {}\n255\n", grey.len() / width);
        fs::write(
            folder.path().join("mask.pgm"),
            [head.as_bytes(), grey].concat(),
        )
        .unwrap();
        let text = format!(
            "image: mask.pgm\nresolution: 0.5\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n{yaml}"
        );
        let file = folder.path().join("mask.yaml");
        fs::write(&file, text).unwrap();
        load(&file).map_err(|error| error.to_string())
    }

    const UPRIGHT: &str = "origin: [1.0, 2.0, 0.0]\n";

    #[test]
    fn black_keeps_out_and_grey_costs() {
        let grey = [254, 0, 0, 254, 0, 0, 254, 254, 0];
        let parts = of(&format!("{UPRIGHT}type: 0\n"), 3, &grey).unwrap();
        let closed: Vec<_> = parts.iter().map(|part| part.corners_m).collect();
        assert_eq!(
            closed,
            [
                [[2.0, 2.0], [2.5, 2.0], [2.5, 2.5], [2.0, 2.5]],
                [[1.5, 2.5], [2.5, 2.5], [2.5, 3.5], [1.5, 3.5]],
            ]
        );
        assert!(parts.iter().all(|part| part.kind == ZoneKind::Keepout));
        // In scale mode 127 is half of the way between the thresholds or so.
        let scaled = of(&format!("{UPRIGHT}mode: scale\ntype: 0\n"), 1, &[147]).unwrap();
        assert_eq!((scaled[0].kind, scaled[0].value), (ZoneKind::Cost, 127.0));
    }

    #[test]
    fn limits_follow_base_and_multiplier() {
        let raw = |yaml: &str, percent| of(&format!("{UPRIGHT}mode: raw\n{yaml}"), 1, &[percent]);
        let one = |yaml: &str, percent| {
            let parts = raw(yaml, percent).unwrap();
            parts.first().map(|part| (part.kind, part.value))
        };
        assert_eq!(one("type: 1\n", 40), Some((ZoneKind::SpeedPercent, 40.0)));
        assert_eq!(one("type: 1\n", 100), None);
        let slower = "type: 1\nbase: 100.0\nmultiplier: -1.0\n";
        assert_eq!(one(slower, 70), Some((ZoneKind::SpeedPercent, 30.0)));
        assert_eq!(one(slower, 0), None, "nothing is asked for");
        let absolute = "type: 2\nmultiplier: 0.01\n";
        assert_eq!(one(absolute, 30), Some((ZoneKind::SpeedLimit, 0.3)));
        assert_eq!(one(absolute, 101), None, "unknown");
    }

    #[test]
    fn a_turned_mask_is_turned_about_its_origin() {
        let turned = "origin: [1.0, 2.0, 1.5707963267948966]\ntype: 0\n";
        let parts = of(turned, 2, &[254, 0]).unwrap();
        let expected = [[1.0, 2.5], [1.0, 3.0], [0.5, 3.0], [0.5, 2.5]];
        for (corner, expected) in parts[0].corners_m.iter().zip(expected) {
            assert!((corner[0] - expected[0]).abs() < 1e-9, "{corner:?}");
            assert!((corner[1] - expected[1]).abs() < 1e-9, "{corner:?}");
        }
    }

    #[test]
    fn what_is_no_mask_is_named_with_its_file() {
        let why = of(UPRIGHT, 1, &[0]).unwrap_err();
        assert!(
            why.contains("mask.yaml: type: must be 0 (keepout)"),
            "{why}"
        );
        let why = of(&format!("{UPRIGHT}type: 1\nbase: .nan\n"), 1, &[0]).unwrap_err();
        assert!(why.contains("mask.yaml: non-finite float"), "{why}");
        let why = of(&format!("{UPRIGHT}type: 1\nbase: 2.0e6\n"), 1, &[0]).unwrap_err();
        assert!(why.contains("mask.yaml: base: must be"), "{why}");
        // Every other pixel black: no two are neighbours.
        let chess: Vec<u8> = (0..1600)
            .map(|n| if (n + n / 40) % 2 == 0 { 0 } else { 254 })
            .collect();
        let why = of(&format!("{UPRIGHT}type: 0\n"), 40, &chess).unwrap_err();
        assert!(
            why.contains("more than 512 rectangles") && why.contains("polygons"),
            "{why}"
        );
    }
}
