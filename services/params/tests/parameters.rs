//! The macros from the outside: reading, writing, ranges, relations, descriptions.

use zeronav_params::{Parameter, Type, Value, check, choices, describe, parameters};

choices! {
    /// A side.
    pub enum Side {
        /// Towards the heart.
        #[default]
        Left = "left",
        /// Away from it.
        Right = "right",
    }
}

parameters! {
    /// An inner group.
    #[derive(Copy)]
    pub struct Inner {
        /// Number of samples,
        /// in two lines.
        samples: u32 = 20, [2, 64];
        /// Speed.
        speed_mps: f64 = 0.5, [f64::MIN_POSITIVE, 1.0e6] "m/s";
    }
}

parameters! {
    /// A configuration.
    pub struct Config {
        /// Which side.
        side: Side = Side::default();
        /// Whether.
        enabled: bool = true;
        /// Any text.
        name: String = "it".to_owned();
        /// Shorter than `far_m`.
        near_m: f64 = 1.0, [0.0, 10.0] "m";
        /// Longer than `near_m`.
        far_m: f64 = 2.0, [0.0, 10.0] "m";
        /// May be left out.
        #[serde(skip_serializing_if = "Option::is_none")]
        step: Option<i16> = None, [-5, 5];
        /// Corners of an area.
        #[serde(skip_serializing_if = "Option::is_none")]
        area_m: Option<[[f64; 2]; 2]> = None, [-1.0e6, 1.0e6] "m";
        /// The inner group.
        inner: Inner;
    }
    relations |own| {
        far_m: own.far_m > own.near_m, "must be more than near_m";
    }
}

/// The complaint about a default configuration after `change`.
fn complaint(change: impl FnOnce(&mut Config)) -> String {
    let mut config = Config::default();
    change(&mut config);
    check(&config).map_or_else(|error| error.to_string(), |()| String::new())
}

#[test]
fn a_default_is_accepted_and_survives_serde() {
    assert_eq!(complaint(|_| ()), "");
    let text = toml::to_string(&Config::default()).unwrap();
    assert!(
        text.contains("side = \"left\"") && !text.contains("step"),
        "{text}"
    );
    assert_eq!(toml::from_str::<Config>(&text), Ok(Config::default()));
    assert_eq!(toml::from_str::<Config>(""), Ok(Config::default()));
    let unknown = toml::from_str::<Config>("inner.sampels = 3").unwrap_err();
    assert!(unknown.to_string().contains("sampels"), "{unknown}");
    assert!(toml::from_str::<Config>("side = \"up\"").is_err());
}

#[test]
fn errors_name_path_range_and_value() {
    assert_eq!(
        complaint(|config| config.inner.samples = 65),
        "inner.samples must be a number from 2 to 64, not 65"
    );
    assert_eq!(
        complaint(|config| config.inner.speed_mps = 0.0),
        "inner.speed_mps must be a number above 0, at most 1e6, not 0.0"
    );
    assert_eq!(
        complaint(|config| config.step = Some(-6)),
        "step must be a number from -5 to 5, not -6"
    );
    assert_eq!(complaint(|config| config.step = Some(-5)), "");
}

#[test]
fn nan_and_infinity_are_rejected_everywhere() {
    for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(complaint(|config| config.near_m = wrong).starts_with("near_m "));
        assert!(complaint(|config| config.inner.speed_mps = wrong).starts_with("inner.speed_mps "));
        let area = Some([[0.0, 0.0], [1.0, wrong]]);
        assert!(complaint(|config| config.area_m = area).starts_with("area_m "));
    }
}

#[test]
fn relations_are_checked_after_all_ranges() {
    assert_eq!(
        complaint(|config| config.far_m = 0.5),
        "far_m must be more than near_m, not 0.5"
    );
    let both = complaint(|config| {
        config.far_m = 0.5;
        config.inner.samples = 0;
    });
    assert!(both.starts_with("inner.samples"), "{both}");
}

#[test]
fn a_description_says_all_that_was_declared_and_survives_json() {
    let parameters = describe::<Config>();
    let of = |path: &str| parameters.iter().find(|one| one.path == path).unwrap();
    let samples = of("inner.samples");
    assert_eq!(samples.description, "Number of samples, in two lines.");
    assert_eq!((samples.kind, samples.min), (Type::Integer, Some(2.0)));
    assert_eq!(of("near_m").unit, "m");
    assert_eq!(of("side").choices[1].key, "right");
    assert_eq!(of("side").choices[1].description, "Away from it.");
    assert_eq!(of("far_m").relations[0].rule, "must be more than near_m");
    assert_eq!(of("step").value, Value::Unset);
    let text = serde_json::to_string(&parameters).unwrap();
    assert!(
        text.contains(r#""path":"inner.samples","type":"integer""#),
        "{text}"
    );
    let read: Vec<Parameter> = serde_json::from_str(&text).unwrap();
    assert_eq!(read, parameters);
}
