//! Faults drawn from a seed: the same seed and the same specification are the same faults.

use crate::{KINDS, RandomFaults, StackFault, faultable, mortals};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use zeronav_msgs::Role;
use zeronav_msgs::run::RunMode;
use zeronav_msgs::topics::TopicRow;
use zeronav_world::spec::Trigger;

/// Range of the time for which a drawn fault lasts. [s]
const LASTS_S: [f64; 2] = [0.2, 3.0];

/// Longest drawn delay of an answer. [ms]
const SLOW_MS_MAX: f64 = 20.0;

/// Shares of the messages of a topic that are lost or corrupted.
const SHARE: [f64; 2] = [0.05, 0.5];

/// Delays of messages: up to the period of a lidar. [ms]
const DELAY_MS: [f64; 2] = [2.0, 100.0];

/// Largest offset of a clock, either sign. [ms]
const CLOCK_MS_MAX: f64 = 300.0;

/// The faults of `spec` in the order of time, from its own seed or else from `seed`. A delay is at most
/// half of `hang_after_s`.
pub fn draw(spec: &RandomFaults, seed: u64, mode: RunMode, hang_after_s: f64) -> Vec<StackFault> {
    let mut dice = Pcg64Mcg::seed_from_u64(spec.seed.unwrap_or(seed));
    let lockstep = mode == RunMode::Lockstep;
    let fit = KINDS.into_iter().filter(|kind| kind.lockstep || !lockstep);
    let drawn = fit.filter(|kind| kind.is_drawn).map(|kind| kind.name);
    let kinds = chosen(&spec.kinds, drawn.collect());
    let services = chosen(&spec.services, mortals().map(Role::label).collect());
    let of_service = |row: &&TopicRow| {
        let mut writers = row.writers.iter().map(|role| role.label());
        spec.services.is_empty() || writers.any(|writer| services.contains(&writer))
    };
    let topics: Vec<&str> = (faultable().filter(of_service))
        .map(|row| row.name)
        .collect();
    let mut times_s: Vec<f64> = (0..spec.count)
        .map(|_| dice.random_range(spec.from_s..=spec.until_s))
        .collect();
    times_s.sort_by(f64::total_cmp);
    let mut faults = Vec::with_capacity(times_s.len());
    for at_s in times_s {
        let kind = kinds[dice.random_range(0..kinds.len())];
        let service = services[dice.random_range(0..services.len())].to_owned();
        let lasts_s = Some(dice.random_range(LASTS_S[0]..=LASTS_S[1]));
        let most_ms = SLOW_MS_MAX.min(hang_after_s * 500.0);
        let slow_ms = dice.random_range(0.1 * most_ms..=most_ms);
        let begins = Some(Trigger {
            at_s: Some(at_s),
            robot_near: None,
        });
        let mut topic = || topics[dice.random_range(0..topics.len())].to_owned();
        faults.push(match kind {
            "stop" => StackFault::Stop {
                service,
                begins,
                lasts_s: lasts_s.filter(|_| !lockstep),
            },
            "slow" => StackFault::Slow {
                service,
                by_ms: slow_ms,
                begins,
                lasts_s,
            },
            "drop" => StackFault::Drop {
                topic: topic(),
                share: dice.random_range(SHARE[0]..=SHARE[1]),
                begins,
                lasts_s,
            },
            "delay" => StackFault::Delay {
                topic: topic(),
                by_ms: dice.random_range(DELAY_MS[0]..=DELAY_MS[1]),
                begins,
                lasts_s,
            },
            "corrupt" => StackFault::Corrupt {
                topic: topic(),
                share: dice.random_range(SHARE[0]..=SHARE[1]),
                begins,
                lasts_s,
            },
            "clock" => StackFault::Clock {
                service,
                by_ms: dice.random_range(-CLOCK_MS_MAX..=CLOCK_MS_MAX),
                begins,
                lasts_s,
            },
            "fill_shm" => StackFault::FillShm { begins, lasts_s },
            "disk_full" => StackFault::DiskFull { begins, lasts_s },
            _ => StackFault::Kill { service, begins },
        });
    }
    faults
}

/// The names of a specification, or all.
fn chosen<'a>(names: &'a [String], all: Vec<&'a str>) -> Vec<&'a str> {
    if names.is_empty() {
        all
    } else {
        names.iter().map(String::as_str).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> RandomFaults {
        RandomFaults {
            count: 200,
            from_s: 2.0,
            until_s: 50.0,
            seed: None,
            kinds: Vec::new(),
            services: Vec::new(),
        }
    }

    #[test]
    fn a_seed_is_a_list_of_faults() {
        let draw_as = |spec: &RandomFaults, seed| draw(spec, seed, RunMode::Lockstep, 0.5);
        let faults = draw_as(&spec(), 7);
        assert_eq!(faults, draw_as(&spec(), 7));
        assert_ne!(faults, draw_as(&spec(), 8));
        let own = RandomFaults {
            seed: Some(7),
            ..spec()
        };
        assert_eq!(faults, draw_as(&own, 8));
    }

    #[test]
    fn what_is_drawn_passes_the_check_and_fits_the_mode() {
        for mode in [RunMode::RealTime, RunMode::Lockstep] {
            let faults = draw(&spec(), 1, mode, 0.5);
            assert_eq!(faults.len(), 200);
            let mut last_s = 2.0;
            for fault in &faults {
                fault.check().expect("a usable fault");
                assert_eq!(fault.unfit(mode), None);
                let at_s = fault.begins().and_then(|begins| begins.at_s);
                let at_s = at_s.expect("a time");
                assert!((last_s..=50.0).contains(&at_s), "{at_s} after {last_s}");
                last_s = at_s;
            }
            for kind in KINDS {
                let is_drawn = faults.iter().any(|fault| fault.kind() == kind.name);
                let fits = kind.lockstep || mode == RunMode::RealTime;
                assert_eq!(is_drawn, fits && kind.is_drawn, "{}", kind.name);
            }
            for role in mortals() {
                assert!(faults.iter().any(|fault| fault.role() == Some(role)));
            }
        }
    }

    #[test]
    fn only_what_is_named_is_drawn() {
        let spec = RandomFaults {
            kinds: vec!["kill".to_owned()],
            services: vec!["mapping".to_owned()],
            ..spec()
        };
        let faults = draw(&spec, 1, RunMode::RealTime, 0.5);
        let is_it = |fault: &StackFault| (fault.kind(), fault.target()) == ("kill", "mapping");
        assert!(faults.iter().all(is_it));
        let spec = RandomFaults {
            kinds: vec!["drop".to_owned()],
            ..spec
        };
        for fault in draw(&spec, 1, RunMode::RealTime, 0.5) {
            assert!(fault.target().starts_with("map/"), "{fault:?}");
        }
    }
}
