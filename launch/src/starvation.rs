//! Which services got no processor, and for how long.

use std::collections::BTreeMap;
use zeronav_measure::result::Starved;
use zeronav_msgs::role::Role;
use zeronav_supervise::hang;

/// The services that were starved so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct Starvation {
    seats: BTreeMap<Role, Starved>,
}

impl Starvation {
    /// Notes what was seen at the run time `time_s`. [s]
    pub(crate) fn note(&mut self, seen: &hang::Starved, time_s: f64) {
        let hang::Starved {
            role,
            waited,
            still,
        } = *seen;
        tracing::warn!(%role, ?waited, ?still, "starved: it got no processor");
        let [waited_s, still_s] = [waited, still].map(|time| time.as_secs_f64());
        let seat = self.seats.entry(role).or_insert_with(|| Starved {
            service: role.to_string(),
            time_s: (time_s - still_s).max(0.0),
            ..Starved::default()
        });
        seat.times += 1;
        seat.waited_s += waited_s;
        seat.longest_s = seat.longest_s.max(still_s);
    }

    /// One entry a seat.
    pub(crate) fn results(&self) -> Vec<Starved> {
        self.seats.values().cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_seat_is_named_once_with_its_longest_time() {
        let mut starvation = Starvation::default();
        for (role, ms) in [
            (Role::Mapping, 900),
            (Role::Mapping, 600),
            (Role::Robot, 700),
        ] {
            let seen = hang::Starved {
                role,
                waited: Duration::from_millis(ms - 100),
                still: Duration::from_millis(ms),
            };
            starvation.note(&seen, 2.0);
        }
        let results = starvation.results();
        let mapping = results.iter().find(|seat| seat.service == "mapping");
        let mapping = mapping.expect("mapping");
        assert_eq!((results.len(), mapping.times), (2, 2));
        let near = |one: f64, other: f64| (one - other).abs() < 1e-9;
        assert!(near(mapping.waited_s, 1.3) && near(mapping.longest_s, 0.9));
        assert!(near(mapping.time_s, 1.1), "{mapping:?}");
    }
}
