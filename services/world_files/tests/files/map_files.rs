//! Map files of every kind, written here and read back.

use flate2::{Compression, write::GzEncoder};
use std::io::Write;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use zeronav_files::Replace;
use zeronav_msgs::{Cell, GridGeometry};
use zeronav_world::{Occupancy, StaticMap};
use zeronav_world_files::map_file::{load, save, save_in};
use zeronav_world_files::{MapFileError, MapWarning};

use Occupancy::{Free, Occupied, Unknown};

struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let file = self.path().join(name);
        std::fs::write(&file, bytes).unwrap();
        file
    }

    fn yaml(&self, text: &str) -> PathBuf {
        self.write("map.yaml", text.as_bytes())
    }
}

fn yaml(image: &str, extra: &str) -> String {
    format!(
        "image: {image}\nresolution: 0.5\norigin: [-1.0, 2, 0]\nnegate: 0\n\
         occupied_thresh: 0.65\nfree_thresh: 0.196\n{extra}"
    )
}

/// 3 x 2 pixels: black, grey 205, white above; white, black, 100 below.
const P5: &[u8] = b"P5\n# made by hand\n3 2\n255\n\x00\xcd\xff\xff\x00\x64";
const P2: &[u8] = b"P2\n3 2\n255\n0 205 255\n255 0 100\n";

/// What [`P5`] means: 100 is an occupancy of 0.61.
const CELLS: [Occupancy; 6] = [Free, Occupied, Unknown, Occupied, Unknown, Free];

#[test]
fn binary_ascii_and_packed_images_are_the_same_map() {
    let folder = Folder::new();
    folder.write("binary.pgm", P5);
    folder.write("ascii.pgm", P2);
    let mut packed = GzEncoder::new(Vec::new(), Compression::default());
    packed.write_all(P5).unwrap();
    folder.write("packed.pgm.gz", &packed.finish().unwrap());
    for image in ["binary.pgm", "ascii.pgm", "packed.pgm"] {
        let loaded = load(&folder.yaml(&yaml(image, ""))).unwrap();
        assert_eq!(loaded.map.cells, CELLS, "{image}");
        assert!(loaded.warnings.is_empty());
        let geometry = GridGeometry {
            origin_x_m: -1.0,
            origin_y_m: 2.0,
            resolution_m: 0.5,
            width: 3,
            height: 2,
        };
        assert_eq!(loaded.map.geometry, geometry);
        // First row of the image = largest y.
        assert_eq!(loaded.map.get(Cell::new(0, 1)), Some(Occupied));
    }
}

#[test]
fn negate_turns_black_and_white_around() {
    let folder = Folder::new();
    folder.write("m.pgm", P5);
    for word in ["1", "true"] {
        let text = yaml("m.pgm", "").replace("negate: 0", &format!("negate: {word}"));
        let map = load(&folder.yaml(&text)).unwrap().map;
        let expected = [Occupied, Free, Unknown, Free, Occupied, Occupied];
        assert_eq!(map.cells, expected, "negate: {word}");
    }
}

/// Three pixels in a row.
fn png_of(colours: png::ColorType, samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 3, 1);
    encoder.set_color(colours);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(samples).unwrap();
    writer.finish().unwrap();
    bytes
}

/// Only what is opaque is known; `raw` does not ask.
#[test]
fn pixels_that_are_not_opaque_are_unknown_whatever_their_colour() {
    let folder = Folder::new();
    let pixels = [
        0, 255, /* transparent */ 255, 0, /* between */ 128, 255,
    ];
    folder.write("m.png", &png_of(png::ColorType::GrayscaleAlpha, &pixels));
    let veiled = [0, 254, 255, 254, 100, 0];
    folder.write("v.png", &png_of(png::ColorType::GrayscaleAlpha, &veiled));
    let colours = [0, 0, 0, 255, 255, 255, 255, 128, 0, 0, 0, 0];
    folder.write("c.png", &png_of(png::ColorType::Rgba, &colours));
    for (image, mode, expected) in [
        ("m.png", "scale", [Occupied, Unknown, Free]),
        ("m.png", "trinary", [Occupied, Unknown, Unknown]),
        ("v.png", "scale", [Unknown; 3]),
        ("v.png", "trinary", [Unknown; 3]),
        ("v.png", "raw", [Free, Unknown, Occupied]),
        ("c.png", "trinary", [Occupied, Unknown, Unknown]),
    ] {
        let text = yaml(image, &format!("mode: {mode}\n"));
        let map = load(&folder.yaml(&text)).unwrap().map;
        assert_eq!(map.cells, expected, "{image} {mode}");
    }
}

/// Pixels and what `map_server` makes of them as a costmap reads it: thresholds count themselves, in
/// every mode, also where a pixel is at both.
#[test]
fn pixels_mean_what_they_mean_to_a_map_server() {
    let folder = Folder::new();
    // Occupancies of 1, 0.6, 0.2 and 0 as fractions of 255, and those beside them.
    folder.write("m.pgm", b"P5\n8 1\n255\n\x00\x01\x65\x66\x67\xcb\xcc\xff");
    // 0, 19, 20, 60, 99, 100 percent, and two beyond.
    folder.write("raw.pgm", b"P5\n8 1\n255\n\x00\x13\x14\x3c\x63\x64\x65\xff");
    let (f, u, o) = (Free, Unknown, Occupied);
    for (image, mode, negate, [occupied, free], expected) in [
        ("m", "trinary", 0, [0.6, 0.2], [o, o, o, o, u, u, f, f]),
        ("m", "trinary", 0, [1.0, 0.0], [o, u, u, u, u, u, u, f]),
        ("m", "trinary", 0, [0.6, 0.6], [o, o, o, f, f, f, f, f]),
        ("m", "trinary", 0, [0.0, 0.0], [o, o, o, o, o, o, o, f]),
        ("m", "trinary", 1, [0.8, 0.4], [f, f, f, f, u, u, o, o]),
        ("m", "trinary", 1, [1.0, 0.0], [f, u, u, u, u, u, u, o]),
        ("m", "scale", 0, [0.6, 0.2], [o, o, o, o, f, f, f, f]),
        // 254 of 255 rounds to 100 percent.
        ("m", "scale", 0, [1.0, 0.0], [o, o, f, f, f, f, f, f]),
        ("m", "scale", 1, [0.8, 0.4], [f, f, f, f, f, f, o, o]),
        ("m", "scale", 0, [0.6, 0.6], [o, o, o, f, f, f, f, f]),
        ("raw", "raw", 0, [0.6, 0.2], [f, f, f, o, o, o, u, u]),
        ("raw", "raw", 0, [1.0, 0.0], [f, u, u, u, u, o, u, u]),
        ("raw", "raw", 1, [1.0, 0.0], [f, u, u, u, u, o, u, u]),
    ] {
        let text = format!(
            "image: {image}.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: {negate}\n\
             occupied_thresh: {occupied}\nfree_thresh: {free}\nmode: {mode}\n"
        );
        let map = load(&folder.yaml(&text)).unwrap().map;
        assert_eq!(map.cells, expected, "{text}");
    }
}

#[test]
fn raw_pixels_are_percent() {
    let folder = Folder::new();
    folder.write("m.pgm", b"P5\n5 1\n255\n\x00\x64\x32\x65\xff");
    let map = load(&folder.yaml(&yaml("m.pgm", "mode: raw\n")))
        .unwrap()
        .map;
    assert_eq!(map.cells, [Free, Occupied, Unknown, Unknown, Unknown]);
}

#[test]
fn colours_count_by_their_mean() {
    let folder = Folder::new();
    let pixels = [255, 255, 255, 0, 0, 0, 255, 0, 0];
    folder.write("m.png", &png_of(png::ColorType::Rgb, &pixels));
    let map = load(&folder.yaml(&yaml("m.png", ""))).unwrap().map;
    // Pure red is a grey of 85, an occupancy of 0.67.
    assert_eq!(map.cells, [Free, Occupied, Occupied]);
}

#[test]
fn grey_values_count_as_part_of_the_images_own_white() {
    let folder = Folder::new();
    folder.write("m.pgm", b"P2\n3 1\n100\n0 100 50\n");
    let map = load(&folder.yaml(&yaml("m.pgm", ""))).unwrap().map;
    assert_eq!(map.cells, [Occupied, Free, Unknown]);
}

#[test]
fn a_threshold_that_frees_the_unknown_is_reported() {
    let folder = Folder::new();
    folder.write("m.pgm", P5);
    let file = folder.yaml(&yaml("m.pgm", "").replace("0.196", "0.25"));
    let loaded = load(&file).unwrap();
    assert_eq!(loaded.map.get(Cell::new(1, 1)), Some(Free));
    let warning = MapWarning::UnknownLoadsAsFree {
        file: file.clone(),
        free_thresh: 0.25,
        n_pixels: 1,
    };
    assert_eq!(loaded.warnings, [warning]);
    let words = loaded.warnings[0].to_string();
    assert!(
        words.contains("map.yaml") && words.contains("0.25"),
        "{words}"
    );
}

#[test]
fn a_yaw_of_more_than_a_turn_is_reported_as_degrees() {
    let folder = Folder::new();
    folder.write("m.pgm", P5);
    let warnings = |yaw: &str| {
        let text = yaml("m.pgm", "").replace("[-1.0, 2, 0]", &format!("[-1.0, 2, {yaw}]"));
        load(&folder.yaml(&text)).unwrap().warnings
    };
    for (degrees, radians) in [("90", "1.570796"), ("-180.0", "-3.141593")] {
        let words: Vec<String> = warnings(degrees).iter().map(ToString::to_string).collect();
        assert_eq!(words.len(), 1, "{words:?}");
        for part in ["map.yaml", "origin", "degrees", radians] {
            assert!(words[0].contains(part), "{words:?} without {part}");
        }
    }
    assert!(warnings("-3.2").is_empty());
    assert!(warnings("6.2").is_empty());
}

#[test]
fn a_half_turn_in_the_origin_is_honoured() {
    let folder = Folder::new();
    folder.write("m.pgm", P5);
    let half_turn = format!("[-1.0, 2, {}]", core::f64::consts::PI);
    let text = yaml("m.pgm", "").replace("[-1.0, 2, 0]", &half_turn);
    let map = load(&folder.yaml(&text)).unwrap().map;
    let mut reversed = CELLS;
    reversed.reverse();
    assert_eq!(map.cells, reversed);
    assert!((map.geometry.origin_x_m + 2.5).abs() < 1e-9);
    assert!((map.geometry.origin_y_m - 1.0).abs() < 1e-9);
}

#[test]
fn what_was_saved_is_loaded_again() {
    let folder = Folder::new();
    let map = StaticMap {
        geometry: GridGeometry {
            origin_x_m: -0.1 - 0.2,
            origin_y_m: 1.0e-7,
            resolution_m: 0.05,
            width: 3,
            height: 2,
        },
        cells: CELLS.to_vec(),
    };
    let file = save(&map, folder.path(), "saved").unwrap();
    let loaded = load(&file).unwrap();
    assert_eq!(loaded.map, map);
    assert!(loaded.warnings.is_empty());
}

#[test]
fn any_name_is_read_back_and_nothing_else_is_left() {
    let folder = Folder::new();
    let map = StaticMap {
        geometry: GridGeometry {
            origin_x_m: -3.0,
            origin_y_m: 1.0e-7,
            resolution_m: 0.05,
            width: 3,
            height: 2,
        },
        cells: CELLS.to_vec(),
    };
    let names = [
        "a map", "1.0", "it's", "a: b # c", "-", "null", "true", "[x]", "ü\"\\",
    ];
    for name in names {
        let file = save(&map, folder.path(), name).unwrap();
        assert_eq!(load(&file).unwrap().map, map, "{name}");
    }
    let files = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(files, 2 * names.len());
}

#[test]
fn map_that_cannot_be_written_leaves_the_one_before() {
    let folder = Folder::new();
    let map = |cells: [Occupancy; 6]| StaticMap {
        geometry: GridGeometry {
            origin_x_m: 0.0,
            origin_y_m: 0.0,
            resolution_m: 0.05,
            width: 3,
            height: 2,
        },
        cells: cells.to_vec(),
    };
    let before = map(CELLS);
    let file = save(&before, folder.path(), "m").unwrap();
    let place = zeronav_files::Folder::open(folder.path()).unwrap();
    assert!(save_in(&map([Free; 6]), &place, "m", Replace::No).is_err());
    // A folder that has the name of the YAML file.
    let aside = folder.path().join("aside");
    std::fs::rename(&file, &aside).unwrap();
    std::fs::create_dir(&file).unwrap();
    assert!(save(&map([Free; 6]), folder.path(), "m").is_err());
    std::fs::remove_dir(&file).unwrap();
    std::fs::rename(&aside, &file).unwrap();
    assert_eq!(load(&file).unwrap().map, before);
}

#[track_caller]
fn refused(text: &str, wanted: &[&str]) -> MapFileError {
    let folder = Folder::new();
    folder.write("m.pgm", P5);
    folder.write("broken.pgm", b"P5\n3 2\n255\n\x00");
    folder.write("letter.pgm", b"Dear Sir or Madam, ");
    folder.write("huge.pgm", b"P5\n9000 2\n255\n");
    folder.write("mud.pgm.gz", b"not packed at all");
    let error = load(&folder.yaml(text)).unwrap_err();
    let words = error.to_string();
    for part in wanted {
        assert!(words.contains(part), "{words:?} without {part:?}");
    }
    assert!(!words.contains('\n'), "{words:?} is more than one line");
    error
}

#[test]
fn errors_name_the_file_and_what_is_wrong() {
    let good = yaml("m.pgm", "");
    let with = |from: &str, to: &str| good.replace(from, to);
    refused(
        &with("m.pgm", "absent.pgm"),
        &["absent.pgm", "No such file"],
    );
    refused(
        &with("m.pgm", "broken.pgm"),
        &["broken.pgm", "truncated", "1 of 6 bytes"],
    );
    refused(&with("m.pgm", "letter.pgm"), &["letter.pgm"]);
    refused(&with("m.pgm", "mud.pgm"), &["mud.pgm.gz"]);
    refused(
        &with("m.pgm", "huge.pgm"),
        &["huge.pgm", "9000 x 2", "8192"],
    );
    refused(&with("resolution: 0.5\n", ""), &["map.yaml", "resolution"]);
    refused(&with("0.5", "0"), &["map.yaml", "resolution", "0.001"]);
    refused(&with("-1.0", ".nan"), &["map.yaml", "origin"]);
    refused(
        &with("0.65", "1.5"),
        &["map.yaml", "occupied_thresh", "1.5"],
    );
    refused(
        &with("0.196", "0.7"),
        &["free_thresh", "above occupied_thresh"],
    );
    refused(&with("negate: 0", "negate: 7"), &["map.yaml"]);
    refused(&yaml("m.pgm", "mode: cubist\n"), &["map.yaml", "cubist"]);
    refused("image: [", &["map.yaml"]);
    refused(&"# a novel\n".repeat(10_000), &["map.yaml", "65536"]);
    let error = load(Path::new("/nowhere/at/all.yaml")).unwrap_err();
    assert!(matches!(error, MapFileError::Read { .. }));
    assert!(error.to_string().contains("/nowhere/at/all.yaml"));
}

#[test]
fn a_map_that_a_turn_makes_too_large_is_refused() {
    let folder = Folder::new();
    let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(b"P5\n8192 8192\n255\n").unwrap();
    packed.write_all(&vec![0; 8192 * 8192]).unwrap();
    folder.write("m.pgm.gz", &packed.finish().unwrap());
    let text = yaml("m.pgm", "").replace("[-1.0, 2, 0]", "[-1.0, 2, 0.7]");
    let error = load(&folder.yaml(&text)).unwrap_err().to_string();
    assert!(
        error.contains("origin") && error.contains("8192"),
        "{error}"
    );
}
