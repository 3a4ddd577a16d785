//! What the clients are told, between the one thread that reads the stack and the server.
//!
//! The newest of everything is kept, never a queue: a client is given what is newer than what it
//! has, whenever it can take something, so one that is slow or stalled misses moments in between and
//! costs nothing.

use crate::scene::{Event, Fixed, Frame, Grid, Tile};
use core::fmt::Write;
use serde::Serialize;
use serde_json::Value;
use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::watch;

/// Events that a client which comes later is told.
const EVENTS_MAX: usize = 300;

/// Tiles of one message, so that a client that stalls at its first one keeps little memory.
const TILES_MAX: usize = 128;

/// The newest of everything.
#[derive(Debug)]
pub(crate) struct Feed {
    state: Mutex<State>,
    news: watch::Sender<u64>,
    watchers: AtomicUsize,
}

/// How far a client is.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Cursor {
    version: u64,
    /// As far as frames are concerned: before the first one there is nothing to draw.
    frame: u64,
    /// Serial of the last tile.
    tile: u64,
}

#[derive(Debug, Default)]
struct State {
    /// Grows with everything that is published.
    version: u64,
    fixed: (u64, String),
    status: (u64, String),
    run: (u64, String),
    /// `time_s`, `tick` and `robot` of the newest frame.
    head: (u64, String),
    /// The other keys of frames, with the version that brought them.
    parts: BTreeMap<String, (u64, String)>,
    grid: (u64, String),
    /// Tiles by the order in which they changed, and where each one is in it.
    tiles: BTreeMap<u64, String>,
    serials: BTreeMap<(u32, u32), u64>,
    last_serial: u64,
    events: VecDeque<(u64, String)>,
    is_over: bool,
}

/// A client that is listening, counted as long as it lives.
#[derive(Debug)]
pub(crate) struct Watching {
    feed: Arc<Feed>,
}

impl Drop for Watching {
    fn drop(&mut self) {
        self.feed.watchers.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Feed {
    pub(crate) fn new() -> Self {
        Self {
            state: Mutex::default(),
            news: watch::Sender::new(0),
            watchers: AtomicUsize::new(0),
        }
    }

    /// Counts a client in; `None` when there are `most` already.
    pub(crate) fn watch(self: &Arc<Self>, most: usize) -> Option<Watching> {
        let before = self.watchers.fetch_add(1, Ordering::Relaxed);
        let watching = Watching {
            feed: Arc::clone(self),
        };
        (before < most).then_some(watching)
    }

    /// Clients that listen now.
    pub(crate) fn watchers(&self) -> usize {
        self.watchers.load(Ordering::Relaxed)
    }

    /// Becomes ready when there is something new.
    pub(crate) fn news(&self) -> watch::Receiver<u64> {
        self.news.subscribe()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn publish(&self, change: impl FnOnce(&mut State, u64)) {
        let mut state = self.state();
        state.version += 1;
        let version = state.version;
        change(&mut state, version);
        drop(state);
        self.news.send_replace(version);
    }

    /// What does not change during the run; a client begins anew with it.
    pub(crate) fn fix(&self, fixed: &Fixed) {
        self.publish(|state, version| state.fixed = (version, text(fixed)));
    }

    /// How services and latencies are.
    pub(crate) fn status(&self, status: &Value) {
        self.publish(|state, version| state.status = (version, text(status)));
    }

    /// What launch says of its run.
    pub(crate) fn run(&self, report: &Value) {
        self.publish(|state, version| state.run = (version, text(report)));
    }

    /// A moment. Its map and events go by [`Self::map`] and [`Self::event`].
    pub(crate) fn frame(&self, frame: &Frame) {
        let Ok(Value::Object(mut keys)) = serde_json::to_value(frame) else {
            return;
        };
        let mut head = String::new();
        for key in ["time_s", "tick", "robot"] {
            if let Some(value) = keys.remove(key) {
                let comma = if head.is_empty() { "" } else { "," };
                let _ = write!(head, "{comma}\"{key}\":{value}");
            }
        }
        self.publish(|state, version| {
            state.head = (version, head);
            for (key, value) in keys {
                state.parts.insert(key, (version, value.to_string()));
            }
        });
    }

    /// Tiles that changed, by column and row, and the grid when it is new.
    pub(crate) fn map(&self, grid: Option<&Grid>, tiles: &[((u32, u32), Tile)]) {
        self.publish(|state, version| {
            if let Some(grid) = grid {
                state.grid = (version, text(grid));
                state.tiles.clear();
                state.serials.clear();
            }
            for (at, tile) in tiles {
                state.last_serial += 1;
                let serial = state.last_serial;
                if let Some(before) = state.serials.insert(*at, serial) {
                    state.tiles.remove(&before);
                }
                state.tiles.insert(serial, text(tile));
            }
        });
    }

    /// Something that happened.
    pub(crate) fn event(&self, event: &Event) {
        self.publish(|state, version| {
            if state.events.len() == EVENTS_MAX {
                state.events.pop_front();
            }
            state.events.push_back((version, text(event)));
        });
    }

    /// The run is over: clients are told, and then left.
    pub(crate) fn end(&self) {
        self.publish(|state, _| state.is_over = true);
    }

    /// True once the run is over.
    pub(crate) fn is_over(&self) -> bool {
        self.state().is_over
    }

    /// Everything that is newer than what the client has, as one JSON object; `None` when nothing
    /// is.
    pub(crate) fn newer(&self, cursor: &mut Cursor) -> Option<String> {
        let state = self.state();
        let has_tiles = state.last_serial > cursor.tile && !state.tiles.is_empty();
        if state.version == cursor.version && !has_tiles {
            return None;
        }
        let mut message = String::from("{");
        let mut add = |key: &str, value: &str| {
            let comma = if message.len() > 1 { "," } else { "" };
            let _ = write!(message, "{comma}\"{key}\":{value}");
        };
        let since = cursor.version;
        if state.fixed.0 > since {
            add("fixed", &state.fixed.1);
        }
        if let Some(frame) = state.frame(cursor) {
            add("frame", &frame);
        }
        if state.status.0 > since {
            add("status", &state.status.1);
        }
        if state.run.0 > since {
            add("run", &state.run.1);
        }
        if state.is_over {
            add("over", "true");
        }
        cursor.version = state.version;
        message.push('}');
        Some(message)
    }
}

impl State {
    /// The newest frame without what the client has; `None` before the first, without a robot, and
    /// when nothing of it is new.
    fn frame(&self, cursor: &mut Cursor) -> Option<String> {
        if self.head.1.is_empty() || self.fixed.1.is_empty() {
            return None;
        }
        let since = cursor.frame;
        let mut frame = format!("{{{}", self.head.1);
        for (key, (version, value)) in &self.parts {
            if *version > since {
                let _ = write!(frame, ",\"{key}\":{value}");
            }
        }
        let is_new = self.grid.0 > since;
        let first = if is_new { 0 } else { cursor.tile };
        let tiles = self.tiles.range(first + 1..).take(TILES_MAX);
        let mut texts = Vec::new();
        for (serial, tile) in tiles {
            texts.push(tile.as_str());
            cursor.tile = *serial;
        }
        if is_new || !texts.is_empty() {
            frame.push_str(",\"map\":{");
            if is_new {
                let _ = write!(frame, "\"grid\":{},", self.grid.1);
            }
            let _ = write!(frame, "\"tiles\":[{}]}}", texts.join(","));
        }
        let news = self.events.iter().filter(|(version, _)| *version > since);
        let events: Vec<&str> = news.map(|(_, event)| event.as_str()).collect();
        if !events.is_empty() {
            let _ = write!(frame, ",\"events\":[{}]", events.join(","));
        }
        frame.push('}');
        cursor.frame = self.version;
        Some(frame)
    }
}

fn text(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_else(|_| "null".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{FORMAT, Robot, Rounded, ScenePath, robot};
    use zeronav_msgs::Pose;
    use zeronav_msgs::grid::GridGeometry;
    use zeronav_msgs::map::MapTile;

    fn feed() -> Arc<Feed> {
        let feed = Feed::new();
        feed.fix(&Fixed {
            format: FORMAT,
            scenario: "a".to_owned(),
            mode: "real_time".to_owned(),
            robot: Robot::of(&zeronav_msgs::description::Description::default(), &[]),
        });
        Arc::new(feed)
    }

    fn frame(tick: u64, path: Option<ScenePath>) -> Frame {
        Frame {
            time_s: Rounded::thousandths(0.02),
            tick,
            robot: robot(&Pose::default(), 0.0, 0.0),
            path,
            ..Frame::default()
        }
    }

    fn path() -> ScenePath {
        ScenePath::of(&zeronav_msgs::path::Path::default(), &[])
    }

    fn next(feed: &Feed, cursor: &mut Cursor) -> Value {
        let text = feed.newer(cursor).expect("news");
        serde_json::from_str(&text).expect("JSON")
    }

    #[test]
    fn a_slow_client_gets_the_newest_and_nothing_twice() {
        let feed = feed();
        let mut cursor = Cursor::default();
        feed.frame(&frame(1, Some(path())));
        let first = next(&feed, &mut cursor);
        assert_eq!(first["fixed"]["scenario"], "a");
        assert_eq!(first["frame"]["path"]["id"], "0:0");
        assert!(feed.newer(&mut cursor).is_none());
        for tick in 2..50 {
            feed.frame(&frame(tick, None));
        }
        let second = next(&feed, &mut cursor);
        assert_eq!(second["frame"]["tick"], 49);
        assert_eq!(second["frame"].get("path"), None);
        assert_eq!(second.get("fixed"), None);
        assert!(feed.newer(&mut cursor).is_none());
    }

    #[test]
    fn tiles_come_in_pieces_and_each_in_its_newest_state() {
        let feed = feed();
        let grid = Grid::of(&GridGeometry::default());
        let tile = |x, y| {
            let tile = MapTile {
                tile_x: x,
                tile_y: y,
                ..MapTile::default()
            };
            ((x, y), Tile::of_flags(&tile))
        };
        let all: Vec<_> = (0..300).map(|n| tile(n % 20, n / 20)).collect();
        feed.frame(&frame(1, None));
        feed.map(Some(&grid), &all);
        let mut cursor = Cursor::default();
        let mut came = 0;
        while let Some(text) = feed.newer(&mut cursor) {
            let message: Value = serde_json::from_str(&text).expect("JSON");
            let tiles = message["frame"]["map"]["tiles"].as_array();
            assert!(tiles.is_some_and(|tiles| tiles.len() <= TILES_MAX));
            came += tiles.map_or(0, Vec::len);
        }
        assert_eq!(came, 300);
        // One tile changes three times; the client gets it once.
        for _ in 0..3 {
            feed.map(None, &[tile(4, 2)]);
        }
        let news = next(&feed, &mut cursor);
        assert_eq!(news["frame"]["map"]["tiles"][0][0], 4);
        assert_eq!(
            news["frame"]["map"]["tiles"].as_array().map(Vec::len),
            Some(1)
        );
        assert_eq!(feed.state().tiles.len(), 300);
        assert!(feed.newer(&mut cursor).is_none());
    }

    #[test]
    fn events_and_watchers_are_bounded() {
        let feed = feed();
        feed.frame(&frame(1, None));
        for n in 0..1000 {
            feed.event(&Event {
                time_s: Rounded::thousandths(f64::from(n)),
                kind: "guard",
                text: n.to_string(),
                hops_us: Vec::new(),
            });
        }
        let news = next(&feed, &mut Cursor::default());
        let events = news["frame"]["events"].as_array().expect("events");
        assert_eq!(events.len(), EVENTS_MAX);
        assert_eq!(events[EVENTS_MAX - 1]["text"], "999");
        let held: Vec<_> = (0..3).map(|_| feed.watch(3).expect("a place")).collect();
        assert!(feed.watch(3).is_none());
        assert_eq!(feed.watchers(), 3);
        drop(held);
        assert_eq!(feed.watchers(), 0);
    }
}
