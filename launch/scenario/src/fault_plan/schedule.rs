//! When faults begin and end. Pure over the ticks and places of the robot.

use crate::StackFault;
use std::collections::BTreeMap;
use zeronav_casts::Cast;
use zeronav_msgs::time::nanoseconds;
use zeronav_world::spec::Near;

/// Something that happens to a fault.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// It begins.
    Begin(StackFault),
    /// The one with this number ends.
    End(u64),
}

/// Where the robot was seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// At this tick.
    pub tick: u64,
    /// Its centre in the map frame. [m]
    pub centre_m: [f64; 2],
}

/// How far a robot gets between two sights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace {
    /// Longest way from tick to tick. [m]
    pub step_m_max: f64,
    /// Most ticks from sight to sight.
    pub ticks: u64,
}

impl Pace {
    /// From the sight of a robot at a place to the fault, in lockstep: no sight before can have let the robot
    /// go farther.
    const fn notice(self) -> u64 {
        2 * self.ticks + 1
    }
}

/// What comes when.
#[derive(Debug, Default)]
pub struct Schedule {
    /// By tick, and in order at the same tick.
    timed: BTreeMap<(u64, u64), Event>,
    near: Vec<(Near, StackFault)>,
    added: u64,
}

impl Schedule {
    /// `faults` of a run with ticks of `tick_ns`; those that begin at once begin at the tick 0.
    #[must_use]
    pub fn new(faults: &[StackFault], tick_ns: u64) -> Self {
        let mut schedule = Self::default();
        for fault in faults {
            match fault
                .begins()
                .map(|begins| (begins.at_s, &begins.robot_near))
            {
                Some((None, Some(near))) => schedule.near.push((near.clone(), fault.clone())),
                begins => {
                    let at_s = begins.and_then(|(at_s, _)| at_s).unwrap_or(0.0);
                    let tick = nanoseconds(at_s) / tick_ns.max(1);
                    schedule.add(tick, Event::Begin(fault.clone()));
                }
            }
        }
        schedule
    }

    /// One more event at `tick`, after those that are there already.
    pub fn add(&mut self, tick: u64, event: Event) {
        self.added += 1;
        self.timed.insert((tick, self.added), event);
    }

    /// Takes the ends of the fault with this number out.
    pub fn forget(&mut self, id: u64) {
        self.timed.retain(|_, event| *event != Event::End(id));
    }

    /// The tick beyond which a robot that was seen there last may not go yet.
    #[must_use]
    pub fn limit(&self, last: &Sight, pace: Pace) -> u64 {
        let timed = self.timed.keys().next().map(|(tick, _)| *tick);
        let near = self.near.iter().map(|(near, _)| {
            let way_m = (distance_m(near, last.centre_m) - near.distance_m).max(0.0);
            // A little less than it could be, so that rounding lets none pass.
            let ticks = (way_m / (1.01 * pace.step_m_max + 1.0e-6)).floor().to_u64();
            last.tick.saturating_add(ticks.max(pace.notice()))
        });
        near.chain(timed).min().unwrap_or(u64::MAX)
    }

    /// Takes in where the robot was seen: what waits for that place is due at once, or with a `notice`
    /// when that is the same in every run.
    pub fn see(&mut self, sight: &Sight, notice: Option<Pace>) {
        let tick = sight.tick + notice.map_or(0, Pace::notice);
        let is_there =
            |(near, _): &mut (Near, _)| distance_m(near, sight.centre_m) <= near.distance_m;
        let due: Vec<_> = self.near.extract_if(.., is_there).collect();
        for (_, fault) in due {
            self.add(tick, Event::Begin(fault));
        }
    }

    /// The next event that is due at `tick`.
    pub fn next(&mut self, tick: u64) -> Option<Event> {
        let first = self.timed.first_entry()?;
        (first.key().0 <= tick).then(|| first.remove())
    }
}

fn distance_m(near: &Near, [x_m, y_m]: [f64; 2]) -> f64 {
    (near.point_m[0] - x_m).hypot(near.point_m[1] - y_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_world::spec::Trigger;

    const PACE: Pace = Pace {
        step_m_max: 0.02,
        ticks: 5,
    };

    fn kill(at_s: Option<f64>, robot_near: Option<Near>) -> StackFault {
        StackFault::Kill {
            service: "mapping".to_owned(),
            begins: Some(Trigger { at_s, robot_near }),
        }
    }

    fn sight(tick: u64, x_m: f64) -> Sight {
        let centre_m = [x_m, 0.0];
        Sight { tick, centre_m }
    }

    #[test]
    fn what_is_due_comes_in_order_and_the_robot_waits_for_it() {
        let (early, late) = (kill(Some(0.1), None), kill(Some(1.0), None));
        let mut schedule = Schedule::new(&[late.clone(), early.clone()], 20_000_000);
        let limit = |schedule: &Schedule| schedule.limit(&sight(0, 0.0), PACE);
        assert_eq!(limit(&schedule), 5);
        assert_eq!(schedule.next(4), None);
        assert_eq!(schedule.next(5), Some(Event::Begin(early)));
        schedule.add(50, Event::End(1));
        schedule.add(50, Event::End(2));
        schedule.forget(1);
        assert_eq!(limit(&schedule), 50);
        let late = Some(Event::Begin(late));
        assert_eq!(schedule.next(50), late, "it was there before");
        assert_eq!(schedule.next(50), Some(Event::End(2)));
        assert_eq!(limit(&schedule), u64::MAX);
    }

    /// At top speed towards the place, however late the sights come: the fault comes at the same tick,
    /// which the robot has not passed, and it is never held for good.
    #[test]
    fn a_fault_by_place_comes_at_the_same_tick_however_late_its_sight_comes() {
        let near = Near {
            point_m: [3.0, 0.0],
            distance_m: 0.5,
        };
        for start_m in [0.0, 0.01, 0.019, 2.4, 2.499] {
            let place_m = |tick: u64| start_m + 0.02 * f64::from(u32::try_from(tick).unwrap());
            let begun = [0, 1, 4].map(|late_ticks: u64| {
                let fault = kill(None, Some(near.clone()));
                let mut schedule = Schedule::new(core::slice::from_ref(&fault), 20_000_000);
                let (mut last, mut seen) = (sight(0, start_m), 0);
                let mut lease = schedule.limit(&last, PACE);
                for tick in 1.. {
                    assert!(tick <= lease, "held for good at {tick}");
                    // Sights of every fifth tick, but those of the last `late_ticks`.
                    while seen + 5 + late_ticks <= tick || (tick == lease && seen + 5 <= tick) {
                        seen += 5;
                        last = sight(seen, place_m(seen));
                        schedule.see(&last, Some(PACE));
                    }
                    lease = lease.max(schedule.limit(&last, PACE));
                    let due = schedule.timed.keys().next();
                    assert!(due.is_none_or(|(due, _)| *due >= lease), "passed");
                    if tick == lease && schedule.next(tick).is_some() {
                        return tick;
                    }
                }
                unreachable!("it is due at some tick");
            });
            assert!(begun.iter().all(|tick| *tick == begun[0]), "{begun:?}");
            let first = (1..1000).map(|n| 5 * n).find(|tick| place_m(*tick) >= 2.5);
            assert_eq!(begun[0], first.unwrap() + 11);
        }
    }
}
