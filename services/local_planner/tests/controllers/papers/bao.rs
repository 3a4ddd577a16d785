//! The dynamic window of BAO.

use super::*;

#[test]
fn bao_dwa_windows_are_those_of_the_paper() {
    let robot = zeronav_msgs::description::Description {
        v_mps_max: 0.5,
        w_radps_max: 1.2,
        a_mps2_max: 0.5,
        brake_mps2: 0.5,
        alpha_radps2_max: 2.0,
        ..Default::default()
    };
    let (v, w) = window(&robot, Twist::new(0.2, 1.1), 0.1);
    assert!((v.low - 0.15).abs() < 1e-12 && (v.high - 0.25).abs() < 1e-12);
    assert!((w.low - 0.9).abs() < 1e-12 && (w.high - 1.2).abs() < 1e-12);
    // sqrt(2 * 0.16 * 0.5) = 0.4.
    assert!(is_admissible(&robot, Twist::new(0.399, 0.0), 0.16));
    assert!(!is_admissible(&robot, Twist::new(0.401, 0.0), 0.16));
    // w^2 <= 2 (dist |w| / v) alpha: 1.0 <= 2 * 0.16 / 0.3 * 2.
    assert!(is_admissible(&robot, Twist::new(0.3, 1.0), 0.16));
    assert!(!is_admissible(&robot, Twist::new(0.3, 1.2), 0.08));
}

#[test]
fn bao_dwa_choice_does_not_depend_on_sigma() {
    for seed in 0..50 {
        let mut random = Pcg32::seed_from_u64(seed);
        let samples: Vec<Sample> = (0..40)
            .map(|_| Sample {
                twist: Twist::new(
                    random.random_range(0.0..0.5),
                    random.random_range(-1.2..1.2),
                ),
                head: random.random_range(0.0..3.1),
                dist: random.random_range(0.0..2.0),
            })
            .collect();
        let chosen = choose(&samples, &BaoWeights::default());
        for sigma in [0.1, 7.0] {
            let weights = BaoWeights {
                sigma,
                ..BaoWeights::default()
            };
            assert_eq!(choose(&samples, &weights), chosen, "seed {seed}");
        }
    }
    assert_eq!(choose(&[], &BaoWeights::default()), None);
}

#[test]
fn bao_dwa_tells_which_term_decided_against_the_fastest_twist() {
    let sample = |v_mps, head, dist| Sample {
        twist: Twist::new(v_mps, 0.0),
        head,
        dist,
    };
    let decisive = |samples: &[Sample]| decisive(samples, &BaoWeights::default());
    let near = [sample(0.5, 3.0, 0.1), sample(0.3, 3.0, 1.9)];
    assert_eq!(decisive(&near), RequestCause::ClearanceCritic);
    let beside = [sample(0.5, 0.2, 1.0), sample(0.3, 3.0, 1.0)];
    assert_eq!(decisive(&beside), RequestCause::PathCritic);
    let fastest = [sample(0.5, 3.0, 1.0), sample(0.3, 3.0, 1.0)];
    assert_eq!(decisive(&fastest), RequestCause::StoppingDistance);
    assert_eq!(decisive(&[]), RequestCause::Critics);
}
