//! Places for connections: a fixed number, and who has to leave when one more comes. Pure but for
//! [`user_of`].
//!
//! A newcomer always gets a place. The oldest connection of the user that holds the most without
//! having shown the token leaves for it, so that nobody can lock another user out, however many
//! connections he holds open and whatever he leaves unread.

use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::oneshot;

/// Connections at a time.
const PLACES: usize = 64;

/// The places that are taken.
#[derive(Debug, Default)]
pub(crate) struct Places {
    taken: Mutex<Taken>,
}

#[derive(Debug, Default)]
struct Taken {
    last: u64,
    /// By age, the oldest first.
    held: BTreeMap<u64, Held>,
}

#[derive(Debug)]
struct Held {
    /// User id at the other end, where the system tells it.
    user: Option<u32>,
    /// It has shown the token.
    is_known: bool,
    /// Its connection is closed when this is dropped.
    _stay: oneshot::Sender<()>,
}

/// A place, free again when this is dropped.
#[derive(Debug)]
pub(crate) struct Place {
    card: Card,
    /// Ready when the connection has to leave.
    pub(crate) leave: oneshot::Receiver<()>,
}

/// Names a place to those who answer its requests.
#[derive(Debug, Clone)]
pub(crate) struct Card {
    places: Arc<Places>,
    id: u64,
}

impl Places {
    /// A place for a connection of this user.
    pub(crate) fn take(self: &Arc<Self>, user: Option<u32>) -> Place {
        let (stay, leave) = oneshot::channel();
        let mut taken = self.taken();
        while taken.held.len() >= PLACES {
            let leaves = taken.who_leaves();
            taken.held.remove(&leaves);
        }
        taken.last += 1;
        let id = taken.last;
        let held = Held {
            user,
            is_known: false,
            _stay: stay,
        };
        taken.held.insert(id, held);
        drop(taken);
        let card = Card {
            places: Arc::clone(self),
            id,
        };
        Place { card, leave }
    }

    fn taken(&self) -> MutexGuard<'_, Taken> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Taken {
    /// The oldest connection without the token of the user that has most of them; where all have
    /// shown it, the oldest.
    fn who_leaves(&self) -> u64 {
        let strangers = || self.held.iter().filter(|(_, held)| !held.is_known);
        let mut by_user: BTreeMap<Option<u32>, usize> = BTreeMap::new();
        for (_, held) in strangers() {
            *by_user.entry(held.user).or_default() += 1;
        }
        let most = by_user.into_iter().max_by_key(|(_, n)| *n);
        let oldest = |user| strangers().find(|(_, held)| held.user == user);
        let leaves = most.and_then(|(user, _)| oldest(user));
        let leaves = leaves.or_else(|| self.held.iter().next());
        leaves.map_or(0, |(id, _)| *id)
    }
}

impl Place {
    /// What names this place.
    pub(crate) fn card(&self) -> Card {
        self.card.clone()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.card.places.taken().held.remove(&self.card.id);
    }
}

impl Card {
    /// The connection has shown the token: it stays as long as others can leave.
    pub(crate) fn is_known(&self) {
        if let Some(held) = self.places.taken().held.get_mut(&self.id) {
            held.is_known = true;
        }
    }
}

/// User id of the process at the other end of a connection within this machine; `None` when the
/// system does not tell it.
pub(crate) fn user_of(peer: SocketAddr, own: SocketAddr) -> Option<u32> {
    user_in(&std::fs::read_to_string("/proc/net/tcp").ok()?, peer, own)
}

/// The same, from the table of the system.
fn user_in(table: &str, peer: SocketAddr, own: SocketAddr) -> Option<u32> {
    let (peer, own) = (in_table(peer)?, in_table(own)?);
    table.lines().find_map(|line| {
        let mut words = line.split_ascii_whitespace();
        let is_it = words.nth(1) == Some(&peer) && words.next() == Some(&own);
        // State, queues, timer, retransmissions; then user and, after a time-out, the inode.
        let user = is_it.then(|| words.nth(4)).flatten()?;
        // A socket that its process has closed is nobody's: it stands there with user 0.
        let inode = words.nth(1)?;
        (inode != "0").then(|| user.parse().ok()).flatten()
    })
}

/// An address as the table writes it: the words of the machine in hexadecimal.
fn in_table(address: SocketAddr) -> Option<String> {
    let IpAddr::V4(host) = address.ip() else {
        return None;
    };
    let host = u32::from_ne_bytes(host.octets());
    Some(format!("{host:08X}:{:04X}", address.port()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::{TcpListener, TcpStream};

    fn left(place: &mut Place) -> bool {
        place.leave.try_recv() == Err(oneshot::error::TryRecvError::Closed)
    }

    #[test]
    fn a_user_that_holds_every_place_makes_room_itself() {
        let places = Arc::new(Places::default());
        let mut owner = places.take(Some(1000));
        let mut hostile: Vec<Place> = (0..500).map(|_| places.take(Some(7))).collect();
        assert!(
            !left(&mut owner),
            "it is older, but the only one of its user"
        );
        assert_eq!(places.taken().held.len(), PLACES);
        assert!(left(&mut hostile[0]) && !left(&mut hostile[499]));
        // Those whose user cannot be told are one user.
        let mut unknown: Vec<Place> = (0..500).map(|_| places.take(None)).collect();
        assert!(!left(&mut owner) && !left(&mut hostile[499]));
        assert!(!left(&mut unknown[499]));
        drop((hostile, unknown));
        assert_eq!(places.taken().held.len(), 1);
    }

    #[test]
    fn those_with_the_token_leave_last() {
        let places = Arc::new(Places::default());
        let mut known: Vec<Place> = (0..PLACES).map(|_| places.take(Some(1))).collect();
        for place in &known {
            place.card().is_known();
        }
        let mut first = places.take(Some(2));
        assert!(left(&mut known[0]) && !left(&mut known[1]));
        let _second = places.take(Some(2));
        assert!(left(&mut first) && !left(&mut known[1]));
    }

    #[test]
    fn the_user_at_the_other_end_is_known() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let own = listener.local_addr().expect("its address");
        let client = TcpStream::connect(own).expect("a connection");
        let (_stream, peer) = listener.accept().expect("the other end");
        let uid = rustix::process::geteuid().as_raw();
        assert_eq!(user_of(peer, own), Some(uid));
        assert_eq!(user_of(own, own), None);
        drop(client);
        assert_eq!(user_of(peer, own), None, "nobody's");
    }
}
