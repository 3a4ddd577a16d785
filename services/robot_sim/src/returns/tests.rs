use super::*;
use zeronav_casts::Cast;

const SEED: u64 = 5;

fn spec() -> LidarSpec {
    LidarSpec::exact(360, 10.0, 0.1..10.0)
}

fn of_scan(spec: &LidarSpec, scan: u64, true_m: &[f64]) -> Vec<Return> {
    let mut found = vec![Return::NONE; true_m.len()];
    Returns::new(spec, SEED).of_scan(scan, true_m, true, &mut found);
    found
}

/// Returns of `n_scans` scans of a round wall.
fn many(spec: &LidarSpec, n_scans: u64, wall_m: f64) -> Vec<Return> {
    (1..=n_scans)
        .flat_map(|scan| of_scan(spec, scan, &[wall_m; 360]))
        .collect()
}

fn share(found: &[Return], which: impl Fn(&Return) -> bool) -> f64 {
    found.iter().filter(|found| which(found)).count().to_f64() / found.len().to_f64()
}

fn deviation(found: &[Return], true_m: f64) -> f64 {
    let squares: f64 = found
        .iter()
        .map(|found| (found.range_m - true_m).powi(2))
        .sum();
    (squares / found.len().to_f64()).sqrt()
}

#[test]
fn without_noise_ranges_are_exact() {
    let found = of_scan(
        &spec(),
        1,
        &[0.0, 0.05, 0.1, 5.0, 10.0, 10.1, f64::INFINITY],
    );
    let ranges = found.iter().map(|found| found.range_m);
    let expected = [
        f64::NAN,
        f64::NAN,
        0.1,
        5.0,
        10.0,
        f64::INFINITY,
        f64::INFINITY,
    ];
    for (found, expected) in ranges.zip(expected) {
        assert!(
            found.to_bits() == expected.to_bits() || (found.is_nan() && expected.is_nan()),
            "{found}, not {expected}"
        );
    }
    let genuine: Vec<bool> = found.iter().map(|found| found.genuine).collect();
    assert_eq!(genuine, [false, false, true, true, true, false, false]);
}

#[test]
fn noise_grows_with_the_range_above_its_floor() {
    let mut spec = spec();
    (spec.sigma_m, spec.sigma_ratio) = (0.02, 0.01);
    for (wall_m, sigma_m) in [(1.0, 0.02), (2.0, 0.02), (8.0, 0.08)] {
        let found = deviation(&many(&spec, 100, wall_m), wall_m);
        // Five standard errors of a deviation of 36 000 draws.
        assert!(
            (found / sigma_m - 1.0).abs() < 5.0 / (2.0_f64 * 36_000.0).sqrt(),
            "seed {SEED}: {found} at {wall_m} m"
        );
    }
}

#[test]
fn ranges_are_whole_steps_after_the_noise() {
    let mut spec = spec();
    (spec.sigma_m, spec.quantum_m) = (0.03, 0.01);
    let found = many(&spec, 10, 3.0);
    for found in &found {
        let steps = found.range_m / 0.01;
        assert!((steps - steps.round()).abs() < 1e-9, "{found:?}");
    }
    // The step's own error is uniform: a twelfth of its square.
    let expected = (0.03_f64.powi(2) + 0.01_f64.powi(2) / 12.0).sqrt();
    let spread = deviation(&found, 3.0);
    assert!(
        (spread / expected - 1.0).abs() < 0.07,
        "seed {SEED}: {spread}"
    );
}

#[test]
fn returns_get_lost_in_the_given_share_and_look_as_asked() {
    let mut spec = spec();
    spec.dropout_ratio = 0.05;
    let found = many(&spec, 100, 3.0);
    let lost = share(&found, |found| {
        found.range_m.is_infinite() && !found.genuine
    });
    assert!((lost - 0.05).abs() < 0.006, "seed {SEED}: {lost}");
    spec.dropout_as = Dropout::Invalid;
    let found = many(&spec, 100, 3.0);
    let invalid = share(&found, |found| found.range_m.is_nan());
    assert!((invalid - lost).abs() < 1e-12, "the same beams");
    // What came from nowhere cannot get lost.
    let nothing = of_scan(&spec, 1, &[f64::INFINITY; 360]);
    assert!(nothing.iter().all(|found| found.range_m.is_infinite()));
}

#[test]
fn short_returns_are_exponential_up_to_the_true_range() {
    let mut spec = spec();
    (spec.short_ratio, spec.short_mean_m, spec.range_m_min) = (0.1, 2.0, 0.0);
    let found = many(&spec, 200, 4.0);
    let short: Vec<Return> = found.into_iter().filter(|found| !found.genuine).collect();
    let ratio = f64::from(u32::try_from(short.len()).unwrap()) / 72_000.0;
    assert!((ratio - 0.1).abs() < 0.006, "seed {SEED}: {ratio}");
    assert!(
        short
            .iter()
            .all(|found| (0.0..=4.0).contains(&found.range_m))
    );
    // F(2 m) of the distribution that is cut at 4 m.
    let expected = (1.0 - (-1.0_f64).exp()) / (1.0 - (-2.0_f64).exp());
    let below = share(&short, |found| found.range_m < 2.0);
    assert!((below - expected).abs() < 0.03, "seed {SEED}: {below}");
}

#[test]
fn beams_behind_an_edge_mix_both_sides() {
    let mut spec = spec();
    spec.edge_ratio = 1.0;
    // A post before a wall, beams 4 to 6; the wall goes round, so beam 0 has no edge.
    let mut true_m = [5.0; 12];
    true_m[4..7].fill(2.0);
    let found = of_scan(&spec, 1, &true_m);
    for (beam, found) in found.iter().enumerate() {
        if beam == 3 || beam == 7 {
            assert!(!found.genuine && found.range_m > 2.0 && found.range_m < 5.0);
        } else {
            assert!(found.genuine && (found.range_m - true_m[beam]).abs() < 1e-12);
        }
    }
    // An edge between the last beam and the first counts only all around.
    let mut true_m = [5.0; 12];
    true_m[0] = 2.0;
    assert!(!of_scan(&spec, 1, &true_m)[11].genuine);
    let mut open = vec![Return::NONE; 12];
    Returns::new(&spec, SEED).of_scan(1, &true_m, false, &mut open);
    assert!(open[11].genuine && !open[1].genuine);
    // A step that is no edge, and nothing behind the edge.
    assert!(of_scan(&spec, 1, &[5.0, 5.05, 5.0])[1].genuine);
    assert!(
        of_scan(&spec, 1, &[5.0, f64::INFINITY, 5.0])[1]
            .range_m
            .is_infinite()
    );
}

#[test]
fn one_source_of_noise_does_not_change_what_another_draws() {
    let mut one = spec();
    one.dropout_ratio = 0.2;
    let mut both = one.clone();
    (both.sigma_m, both.short_ratio, both.edge_ratio) = (0.05, 0.1, 0.5);
    let lost = |spec: &LidarSpec| -> Vec<bool> {
        many(spec, 5, 3.0)
            .iter()
            .map(|found| found.range_m.is_infinite())
            .collect()
    };
    assert_eq!(lost(&one), lost(&both));
}
