//! Who is obeyed in each seat, by the rosters in a recording.

use crate::layout::Layout;
use std::collections::BTreeMap;
use zeronav_msgs::header::SHADOW_EPOCH_MIN;
use zeronav_msgs::run::Seat;

/// The newest roster.
#[derive(Debug, Clone, Default)]
pub struct Holders {
    seats: BTreeMap<u16, Seat>,
}

impl Holders {
    /// Takes in the items of a message on `run/control`, each a seat. A field that this contract does not have, or that
    /// the recording lacks, is 0.
    pub fn see(&mut self, layout: &Layout, items: &[u8]) {
        self.seats.clear();
        for item in items.chunks_exact(layout.item_bytes.max(1)) {
            let number = |path: &str| Layout::unsigned(&layout.item, item, path).unwrap_or(0);
            let short = |path: &str| u32::try_from(number(path)).unwrap_or(0);
            let role = u16::try_from(number("role")).unwrap_or(0);
            let seat = Seat {
                role,
                epoch: short("epoch"),
                other: short("other"),
                off_tick: number("off_tick"),
                on_tick: number("on_tick"),
                hear_tick: number("hear_tick"),
                since_tick: number("since_tick"),
                other_tick: number("other_tick"),
                ..Seat::default()
            };
            self.seats.insert(role, seat);
        }
    }

    /// True when an author, given by role, epoch and tick, is the one that is obeyed. Where the recording does not say
    /// who is, everybody but a shadow.
    #[must_use]
    pub fn obey(&self, author: [Option<u64>; 3]) -> bool {
        let [role, epoch, tick] = author;
        let epoch = epoch.and_then(|epoch| u32::try_from(epoch).ok());
        let epoch = epoch.unwrap_or(0);
        let role = role.and_then(|role| u16::try_from(role).ok());
        let seat = role.and_then(|role| self.seats.get(&role));
        match seat {
            Some(seat) => seat.obeys(epoch, tick.unwrap_or(0)),
            None => epoch < SHADOW_EPOCH_MIN,
        }
    }
}
