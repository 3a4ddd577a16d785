//! ZM-TRA, ZM-HW, ZM-IM.

use super::generate::{any, blocky, corners};
use super::{assert_close, count, plain, plan};
use crate::papers::field::{Field, Prices};
use crate::papers::weight::EtaOptions;
use crate::papers::weight::Weight;
use crate::support::Map;
use crate::{CornerRule, Unknown};
use zeronav_msgs::Cell;
use zeronav_observe::statistics::median;

const RULE: CornerRule = CornerRule::ForbidAny;

#[test]
fn zm_tra_equals_c_astar() {
    for seed in 0..200 {
        let map = any(20, 20, seed);
        let one = plan("zm_tra", &plain(), &map, RULE, corners(&map)).map(|found| found.cost);
        let other = plan("c_astar", &plain(), &map, RULE, corners(&map)).map(|found| found.cost);
        match (one, other) {
            // `c_astar` searches in integers, but reports the length of its path.
            (Ok(one), Ok(other)) => assert_close(one, other, 1e-9, &format!("seed {seed}")),
            (one, other) => assert_eq!(one, other, "seed {seed}"),
        }
    }
}

#[test]
fn zm_hw_costs_at_most_its_weight_and_expands_less() {
    for weight in [1.2, 1.5, 2.0, 3.0] {
        let mut options = plain();
        options.papers.weight = weight;
        let (mut hw, mut tra) = (Vec::new(), Vec::new());
        for seed in 0..120 {
            let map = blocky(20, 20, 15 + 10 * i32::from(seed % 2 == 0), seed);
            let (Ok(weighted), Ok(proper)) = (
                plan("zm_hw", &options, &map, RULE, corners(&map)),
                plan("zm_tra", &plain(), &map, RULE, corners(&map)),
            ) else {
                continue;
            };
            assert!(weighted.cost >= proper.cost - 1e-9, "seed {seed}");
            assert!(weighted.cost <= weight * proper.cost + 1e-9, "seed {seed}");
            hw.push(count(weighted.stats().expanded));
            tra.push(count(proper.stats().expanded));
        }
        assert!(hw.len() > 50);
        let (hw, tra) = (median(hw).unwrap(), median(tra).unwrap());
        assert!(hw < tra, "weight {weight}: {hw} of {tra} expansions");
    }
}

#[test]
fn zm_im_eta_at_its_breakpoints() {
    let eta = EtaOptions::default();
    // P0 / alpha = 1.5, where the default beta makes both zones meet.
    let emergency = 2.0 * (-1.5_f64).exp();
    assert_close(eta.eta(1.5), emergency, 1e-12, "end of the emergency zone");
    assert_close(
        eta.eta(1.5 + 1e-9),
        0.2975 * 1.5,
        1e-8,
        "begin of the mild zone",
    );
    assert_close(eta.eta(1.5 + 1e-9), emergency, 1e-4, "continuous");
    assert_close(eta.eta(1.0), 2.0 * (-2.0_f64).exp(), 1e-12, "inside");
    assert_close(eta.eta(3.0), 0.8925, 1e-12, "P0");
    assert_close(eta.eta(3.0 + 1e-9), 0.0, 1e-12, "beyond P0");
    assert_close(eta.eta_max(), 0.8925, 1e-12, "largest");
    let monotone = EtaOptions {
        monotone: true,
        ..eta
    };
    assert_close(monotone.eta(1.5), 0.5, 1e-12, "monotone");
    assert_close(monotone.eta(3.0), 0.0, 1e-12, "monotone, continuous at P0");
}

/// On cells of 5 cm three cells are 0.15 m. With the side of a cell of the paper distances are those of
/// the map's clearance, in such cells.
#[test]
fn zm_im_measures_in_cells_of_the_paper() {
    let mut map = Map::free(4, 4);
    for cell in &mut map.cells {
        cell.clearance_mm = 1500;
    }
    let prices = Prices::new(0.0);
    let here = Cell::new(1, 2);
    let field = Field {
        map: map.view(),
        unknown: Unknown::Free,
        corner_rule: RULE,
        prices: &prices,
        walls: &[],
        layers: 0,
        spared: [here, here],
    };
    let weight = |cell_m| {
        let eta = EtaOptions {
            cell_m,
            ..EtaOptions::default()
        };
        Weight::Eta(eta).at(&field, here)
    };
    let eta = EtaOptions::default();
    assert_close(weight(1.0), eta.eta(1.5).exp(), 1e-12, "cells of a metre");
    assert_close(weight(0.75), eta.eta(2.0).exp(), 1e-12, "smaller cells");
    assert_close(weight(0.4), 1.0, 1e-12, "beyond P0");
    assert_close(weight(0.0), 1.0, 1e-12, "no obstacle on the map");
}

#[test]
fn zm_im_eta_max_is_a_bound() {
    for alpha in [0.0, 0.5, 1.0, 1.1, 2.0, 4.0] {
        for (beta, p0_cells) in [(0.0, 1.0), (0.3, 3.0), (1.0, 5.0)] {
            for monotone in [false, true] {
                let eta = EtaOptions {
                    alpha,
                    beta,
                    p0_cells,
                    monotone,
                    ..EtaOptions::default()
                };
                let largest = (1..=600)
                    .map(|n| eta.eta(f64::from(n) * 0.01))
                    .fold(0.0, f64::max);
                let bound = eta.eta_max();
                assert!(largest <= bound + 1e-12, "{eta:?}: {largest} > {bound}");
                assert!(largest >= bound - 0.05 * bound.max(1.0), "{eta:?}: loose");
            }
        }
    }
}

#[test]
fn zm_im_without_gains_is_zm_tra() {
    let mut options = plain();
    options.papers.eta.alpha = 0.0;
    options.papers.eta.beta = 0.0;
    for seed in 0..100 {
        let map = any(20, 20, seed);
        let im = plan("zm_im", &options, &map, RULE, corners(&map)).map(|found| found.path);
        let tra = plan("zm_tra", &plain(), &map, RULE, corners(&map)).map(|found| found.path);
        assert_eq!(im, tra, "seed {seed}");
    }
}

#[test]
fn zm_im_keeps_its_bound_on_500_maps() {
    let mut dearer = 0;
    for seed in 0..500 {
        let map = any(20, 20, seed);
        let mut options = plain();
        options.papers.eta.alpha = [1.1, 2.0, 4.0][usize::try_from(seed % 3).unwrap()];
        options.papers.eta.monotone = seed.is_multiple_of(5);
        let bound = Weight::Eta(options.papers.eta).max();
        let (Ok(im), Ok(tra)) = (
            plan("zm_im", &options, &map, RULE, corners(&map)),
            plan("zm_tra", &plain(), &map, RULE, corners(&map)),
        ) else {
            continue;
        };
        assert!(im.cost >= tra.cost - 1e-9, "seed {seed}");
        assert!(im.cost <= bound * tra.cost + 1e-9, "seed {seed}");
        dearer += u32::from(im.cost > tra.cost + 1e-9);
    }
    assert!(dearer > 0, "the weight never changed a path");
}
