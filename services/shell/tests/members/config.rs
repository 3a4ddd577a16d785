//! What a service says about a configuration that it cannot use: file, line, field and reason.

use clap::Parser;
use serde::{Deserialize, Serialize};
use zeronav_shell::StartError;
use zeronav_shell::flags::{Flags, one_line};
use zeronav_shell::places::{Places, line_of};

/// A configuration with everything that an error can lie in.
#[derive(Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Config {
    #[serde(default)]
    speed_mps: f64,
    #[serde(default)]
    shapes: Vec<Shape>,
}

#[derive(Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Shape {
    size_m: f64,
    pose: (f64, f64),
}

fn flags(path: &std::path::Path) -> Flags {
    let path = path.to_str().expect("a path of text");
    let words = ["service", "--domain", "d", "--epoch", "1", "--config", path];
    Flags::try_parse_from(words).expect("flags")
}

/// What comes of this text when `check` judges the configuration.
fn read(
    text: &str,
    check: impl FnOnce(&Config) -> Result<(), StartError>,
) -> Result<Config, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("it.toml");
    std::fs::write(&path, text).expect("a file");
    let start = format!("configuration {}:", path.display());
    flags(&path).member.read_config(check).map_err(|error| {
        let error = error.to_string();
        let said = error.strip_prefix(&start);
        said.unwrap_or_else(|| panic!("{error} does not begin with {start}"))
            .to_owned()
    })
}

#[test]
fn a_wrong_value_is_named_with_its_line() {
    let whole = "speed_mps = 1.5\n[[shapes]]\nsize_m = 2.0\npose = [1.0, 2.0]\n";
    let shape = Shape {
        size_m: 2.0,
        pose: (1.0, 2.0),
    };
    let right = Config {
        speed_mps: 1.5,
        shapes: vec![shape],
    };
    assert_eq!(read(whole, |_| Ok(())), Ok(right));
    for (text, said) in [
        ("speed_mps = \"fast\"\n", "1: speed_mps: "),
        ("\nspeed = 1.0\n", "2: speed"),
        ("\n\nspeed_mps = \n", "3: "),
        (
            "[[shapes]]\nsize_m = 2.0\npose = [1.0, 2.0]\n[[shapes]]\npose = [1.0, 2.0]\n",
            "4: shapes[1].size_m: is missing",
        ),
        (
            "[[shapes]]\npose = [1.0, 2.0]\nsize_m = true\n",
            "3: shapes[0].size_m: ",
        ),
        (
            "[[shapes]]\nsize_m = 2.0\npose = [1.0, \"2\"]\n",
            "3: shapes[0].pose",
        ),
        // A deserialiser takes the first two and forgets the others.
        (
            "[[shapes]]\nsize_m = 2.0\n\npose = [1.0, 2.0, 3.0]\n",
            "4: shapes[0].pose: has more than 2 entries, the others mean nothing",
        ),
    ] {
        let error = read(text, |_| Ok(())).expect_err(text);
        assert!(error.starts_with(said), "{text:?}: {error}");
    }
    let hint = read("sped_mps = 1.0\n", |_| Ok(())).expect_err("a slip");
    assert!(hint.ends_with("did you mean `speed_mps`?"), "{hint}");
}

#[test]
fn what_the_service_refuses_is_named_with_its_line() {
    let text = "speed_mps = 1.0\n\n[[shapes]]\nsize_m = 2.0\npose = [1.0, 2.0]\n";
    for (field, line) in [
        ("speed_mps", 1),
        ("shapes[0]", 3),
        ("shapes[0].pose", 5),
        ("shapes[0].pose[1]", 5),
        // What is not there belongs to what could hold it.
        ("shapes[0].colour", 3),
        ("shapes[7].size_m", 3),
        ("elsewhere", 1),
    ] {
        let refuse = |_: &Config| Err(StartError::config(field, "is too much"));
        let error = read(text, refuse).expect_err(field);
        assert_eq!(error, format!("{line}: {field}: is too much"));
    }
}

#[test]
fn without_a_file_the_defaults_count() {
    let words = ["service", "--domain", "d", "--epoch", "1"];
    let flags = Flags::try_parse_from(words).expect("flags");
    let defaults = flags
        .member
        .read_config(|_: &Config| Ok(()))
        .expect("defaults");
    assert!(defaults.speed_mps.abs() < 1e-12 && defaults.shapes.is_empty());
    let refused = flags
        .member
        .read_config(|_: &Config| Err(StartError::config("speed_mps", "is 0")));
    assert!(refused.is_err());
    let needed = flags
        .member
        .read_config(|_: &Shape| Ok(()))
        .expect_err("a size");
    assert!(needed.to_string().contains("--config FILE is needed"));
    let absent = self::flags(std::path::Path::new("/nowhere.toml"));
    let absent = absent
        .member
        .read_config(|_: &Config| Ok(()))
        .expect_err("a file");
    assert!(absent.to_string().contains("/nowhere.toml"), "{absent}");
}

#[test]
fn a_wrong_flag_is_one_line() {
    let error = Flags::try_parse_from(["service", "--epoch", "0"]).expect_err("no epoch");
    let line = one_line(&error);
    assert!(line.starts_with("invalid value '0' for '--epoch <N>'"));
    assert!(!line.contains(['\n']) && !line.contains("Usage"), "{line}");
}

#[test]
fn places_are_found_by_field_and_by_range() {
    let text = "a = 1\n[b]\nc = [10, 20]\n";
    let table = toml::de::DeTable::parse(text).expect("a table");
    let places = Places::of(table.get_ref());
    let at = |what: &str| text.find(what).expect("there");
    assert_eq!(places.value_of("b.c[1]"), Some(at("20")));
    assert_eq!(places.value_of("a"), Some(at("1")));
    assert_eq!(places.value_of("b.d"), None);
    assert_eq!(places.key_of("b.c"), Some(at("c =")));
    assert_eq!(places.key_of("b.d"), places.key_of("b"));
    assert_eq!(places.key_of("z"), None);
    let line = at("c =")..text.len();
    assert_eq!(places.field_within(&line), Some("b.c"));
    assert_eq!(places.field_within(&(0..1)), Some("a"));
    assert_eq!(places.field_within(&(2..3)), None);
    for (offset, line) in [(0, 1), (5, 1), (6, 2), (at("20"), 3), (1000, 4)] {
        assert_eq!(line_of(text, offset), line, "{offset}");
    }
}
