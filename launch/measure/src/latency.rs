//! The latency part of a result: distributions over events, scans and commands.

use super::distribution::Distribution;
use super::event::{Clearance, Event, EventOutcome, judge};
use super::index::Records;
use super::joins::{End, Joins};
use super::reaction::reactions;
use super::series::Series;
use crate::result::latency::{EveryScan, Figures, Hop, Latency, SecondClock};
use std::collections::{BTreeMap, BTreeSet};
use zeronav_msgs::span::Span;
use zeronav_observe::hop_chain::{ALL, DIRECT, HOPS, HopChain, THROUGH_MAP};

/// Latencies of all events and all scans. `radius_m` is that of the swept robot, `deadline_ns`
/// the time after which an event or a scan counts as unanswered.
#[must_use]
pub fn measure(
    records: &Records,
    clearance_m: Clearance<'_>,
    radius_m: f64,
    deadline_ns: u64,
) -> (Vec<Event>, Latency) {
    let events: Vec<Event> = records
        .sightings
        .iter()
        .map(|sighting| judge(records, sighting, clearance_m, radius_m, deadline_ns))
        .collect();
    let latency = Latency::of(&events, records, deadline_ns);
    (events, latency)
}

/// What is gathered over ways.
#[derive(Debug)]
pub(super) struct Ways {
    /// Ways share hops: each pair of stamps counts once.
    out_of_order: BTreeSet<(usize, u64, u64)>,
    followed: u64,
    broken: u64,
    /// Lengths of the hops of every scan that an author read itself.
    pub(super) direct: [Series; HOPS.len()],
    /// The same through map and path.
    pub(super) through_map: [Series; HOPS.len()],
    second: Distribution,
    difference: Distribution,
    beyond: u64,
}

impl Ways {
    fn new() -> Self {
        Self {
            out_of_order: BTreeSet::new(),
            followed: 0,
            broken: 0,
            direct: Default::default(),
            through_map: Default::default(),
            second: Distribution::new(),
            difference: Distribution::new(),
            beyond: 0,
        }
    }

    /// Follows every command that reached the wheels back to its scans.
    pub(super) fn follow(records: &Records) -> Self {
        let joins = Joins::of(records);
        let mut ways = Self::new();
        let (mut scans, mut paths) = (BTreeSet::new(), BTreeSet::new());
        for applied in joins.applied() {
            if let Some((spans, way)) = ways.look(joins.direct(applied), HopChain::direct)
                && scans.insert(spans[0].scan)
            {
                add(&mut ways.direct, &way);
            }
            if let Some((spans, way)) = ways.look(joins.through_map(applied), HopChain::through_map)
            {
                ways.followed += 1;
                ways.compare(&way);
                // What is said again about the same scan is no further way of that scan.
                if paths.insert(spans[2].output) {
                    add(&mut ways.through_map, &way);
                }
            }
        }
        ways
    }

    /// Counts what is wrong with the way that these records tell.
    fn look<'a, const N: usize>(
        &mut self,
        followed: Result<[&'a Span; N], End>,
        way: fn([&Span; N]) -> HopChain,
    ) -> Option<([&'a Span; N], HopChain)> {
        match followed {
            Ok(spans) => {
                let way = way(spans);
                self.count(&way);
                Some((spans, way))
            }
            Err(End::Nothing) => None,
            Err(End::Missing) => {
                self.broken += 1;
                None
            }
        }
    }

    fn count(&mut self, way: &HopChain) {
        self.out_of_order.extend(way.out_of_order());
    }

    fn compare(&mut self, way: &HopChain) {
        let (Some(second_ns), Some(difference_ns)) = (way.second_ns, way.difference_ns()) else {
            return;
        };
        self.second.add(second_ns);
        self.difference.add(difference_ns);
        self.beyond += u64::from(way.is_beyond());
    }

    fn disorder(&self) -> BTreeMap<String, u64> {
        let mut disorder: BTreeMap<_, _> =
            HOPS.into_iter().map(|hop| (hop.to_owned(), 0)).collect();
        for (hop, ..) in &self.out_of_order {
            *disorder.entry(HOPS[*hop].to_owned()).or_default() += 1;
        }
        disorder
    }

    fn second_clock(&self) -> Option<SecondClock> {
        (!self.second.is_empty()).then(|| SecondClock {
            end_to_end: self.second.figures(),
            difference: self.difference.figures(),
            beyond: self.beyond,
        })
    }
}

fn add(hops: &mut [Series; HOPS.len()], way: &HopChain) {
    for (place, length_ns) in way.lengths_ns() {
        hops[place].add(length_ns);
    }
}

fn table(places: &[usize], hops: &[Series; HOPS.len()], deadline_ns: u64) -> Vec<Hop> {
    let row = |place: &usize| Hop {
        name: HOPS[*place].to_owned(),
        figures: hops[*place].figures(deadline_ns),
        clock_uncertainty_us: None,
    };
    places.iter().map(row).collect()
}

impl Latency {
    /// The figures of `events`, and of all scans and commands of `records`.
    #[must_use]
    pub fn of(events: &[Event], records: &Records, deadline_ns: u64) -> Self {
        let mut replanning = Distribution::new();
        let mut event_to_motion = Distribution::new();
        let mut hops: [Series; HOPS.len()] = Default::default();
        let mut ways = Ways::follow(records);
        for event in events {
            match event.outcome {
                EventOutcome::NotInTheWay => {}
                EventOutcome::Censored => {
                    replanning.censor(deadline_ns);
                    event_to_motion.censor(deadline_ns);
                }
                EventOutcome::Answered | EventOutcome::Early => {
                    if let Some(time_ns) = event.replanning_ns {
                        replanning.add(time_ns);
                    }
                    if let Some(time_ns) = event.event_to_motion_ns {
                        event_to_motion.add(time_ns);
                    }
                }
            }
            ways.broken += u64::from(event.way_broken);
            if let Some(way) = &event.way {
                ways.count(way);
                add(&mut hops, way);
            }
        }
        let count = |is: &dyn Fn(&Event) -> bool| events.iter().filter(|event| is(event)).count();
        let outcome = |outcome| count(&|event| event.outcome == outcome) as u64;
        Self {
            reaction: reactions(records, deadline_ns).figures(deadline_ns),
            replanning: replanning.figures(),
            event_to_motion: event_to_motion.figures(),
            hops: table(&ALL, &hops, deadline_ns),
            transport_floor: None,
            replanning_to_floor: None,
            every_scan: EveryScan {
                direct: table(&DIRECT, &ways.direct, deadline_ns),
                through_map: table(&THROUGH_MAP, &ways.through_map, deadline_ns),
            },
            hops_out_of_order: ways.disorder(),
            ways: ways.followed,
            ways_broken: ways.broken,
            second_clock: ways.second_clock(),
            early: outcome(EventOutcome::Early),
            revised: count(&|event| event.revised > 0) as u64,
            not_in_the_way: outcome(EventOutcome::NotInTheWay),
        }
    }

    /// Several rounds as one: percentiles are the median of the rounds', the worst is the worst
    /// of all, samples are counted together.
    #[must_use]
    pub fn of_rounds(rounds: &[Self]) -> Self {
        let figures = |of: &dyn Fn(&Self) -> Option<Figures>| {
            let of_each: Vec<Figures> = rounds.iter().filter_map(of).collect();
            (!of_each.is_empty()).then(|| Figures::of_rounds(&of_each))
        };
        let hops = |of: fn(&Self) -> &Vec<Hop>| {
            let first = rounds.first().map_or(&[][..], |round| of(round));
            let row = |(at, hop): (usize, &Hop)| Hop {
                name: hop.name.clone(),
                figures: figures(&|round| of(round).get(at).map(|hop| hop.figures))
                    .unwrap_or_default(),
                clock_uncertainty_us: hop.clock_uncertainty_us,
            };
            first.iter().enumerate().map(row).collect()
        };
        let sum = |of: fn(&Self) -> u64| rounds.iter().map(of).sum::<u64>();
        let replanning = figures(&|round| Some(round.replanning)).unwrap_or_default();
        let transport_floor = figures(&|round| round.transport_floor);
        let floor_us = transport_floor.and_then(|floor| floor.p50_us);
        let clocks = || {
            rounds
                .iter()
                .filter_map(|round| round.second_clock.as_ref())
        };
        let clock = |of: fn(&SecondClock) -> Figures| {
            Figures::of_rounds(&clocks().map(of).collect::<Vec<Figures>>())
        };
        let mut hops_out_of_order = BTreeMap::new();
        for (hop, n) in rounds.iter().flat_map(|round| &round.hops_out_of_order) {
            *hops_out_of_order.entry(hop.clone()).or_default() += n;
        }
        Self {
            reaction: figures(&|round| Some(round.reaction)).unwrap_or_default(),
            replanning,
            event_to_motion: figures(&|round| Some(round.event_to_motion)).unwrap_or_default(),
            hops: hops(|round| &round.hops),
            transport_floor,
            replanning_to_floor: replanning
                .p50_us
                .zip(floor_us)
                .map(|(replanning_us, floor_us)| replanning_us / floor_us),
            every_scan: EveryScan {
                direct: hops(|round| &round.every_scan.direct),
                through_map: hops(|round| &round.every_scan.through_map),
            },
            hops_out_of_order,
            ways: sum(|round| round.ways),
            ways_broken: sum(|round| round.ways_broken),
            second_clock: clocks().next().map(|_| SecondClock {
                end_to_end: clock(|second| second.end_to_end),
                difference: clock(|second| second.difference),
                beyond: clocks().map(|second| second.beyond).sum(),
            }),
            early: sum(|round| round.early),
            revised: sum(|round| round.revised),
            not_in_the_way: sum(|round| round.not_in_the_way),
        }
    }
}
