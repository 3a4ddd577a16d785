//! Whether the robot still is where it takes itself to be, by how much of its scans the static map explains.
//!
//! A robot that was carried away, or was told a wrong place, sees walls where there are none and looks through those that
//! there are. Furniture that was moved does the same to some beams, people and boxes end many of them short: so what counts
//! is that the map explains little *and* is contradicted, and for a while.
//!
//! A robot that was told where it is does not know that before the map has explained what it sees. Until then fewer beams
//! speak against the place, and what a robot sees of a bare hall adds up while it drives.

use crate::explained::Explained;
use zeronav_msgs::Pose;

/// What a beam counts that has met something new, beside one that is explained or contradicts the map.
const NEW_COUNTS: f64 = 0.3;

/// Share of the judged beams that must contradict the map.
const CONTRADICTS: f64 = 0.12;

/// Least number of judged beams, and of beams that ended somewhere: a lidar that sees nothing is blind.
const JUDGED_MIN: f64 = 25.0;

/// The same while a place that was told is not confirmed.
const JUDGED_MIN_UNCONFIRMED: f64 = 10.0;

/// Share of the beams that ended somewhere that the map must explain to confirm a place: what ends where nothing is known,
/// or on what may move, does not speak for it.
const CONFIRMS: f64 = 0.5;

/// How far a robot drives until it sees something else. [m]
const VIEW_M: f64 = 0.5;

/// How much faster a robot is lost whose place lies in an obstacle of the map.
const INSIDE_COUNTS: f64 = 4.0;

/// Share of the beams that end where nothing is known from which on a place is off the map, unless the map has explained
/// what is seen from there before.
const OFF: f64 = 0.7;

/// How long, in scans that say so, the robot must seem to be lost. [s]
const LASTS_S: f64 = 2.0;

/// How much faster it is forgotten than it is believed.
const FORGETS: f64 = 2.0;

/// Scans of which one is looked at closely, however well it lies on the map: it may lie on the far sides of its walls.
const CLOSELY_EVERY: u32 = 10;

/// What the map says of a scan.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judged {
    pub(crate) explained: Explained,
    /// Beams that ended where beams count, on what stands.
    pub(crate) n_ends: f64,
    /// The same, also on what may move: what the map does not explain may seem to.
    pub(crate) n_hits: f64,
    /// Where the robot takes itself to be.
    pub(crate) map_from_base: Pose,
    /// There it would stand in an obstacle of the map.
    pub(crate) is_inside: bool,
    /// Since the last scan. [s]
    pub(crate) elapsed_s: f64,
}

/// Takes in what the map explains of every scan, of a robot that was told nothing by default.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LostWatch {
    /// The robot was told where it is, by configuration or by a person: that may be wrong.
    is_told: bool,
    /// How long the robot has seemed to be lost. [s]
    seems_s: f64,
    /// The map has explained what is seen.
    confirmed: bool,
    /// What it has said of one scan of every view, until it is confirmed, how many beams of these ended, on what stands and
    /// on anything, and from where the last one was.
    views: Explained,
    view_ends: f64,
    view_hits: f64,
    last_view: Option<Pose>,
    /// Scans since the last close look.
    n_glances: u32,
}

/// True when the map is contradicted by what is seen, and explains less than the share `below` of it.
pub(crate) fn seems_elsewhere(explained: &Explained, below: f64) -> bool {
    let contradicts = explained.through >= CONTRADICTS * explained.judged();
    contradicts && explained.share(NEW_COUNTS) < below
}

impl LostWatch {
    /// Of a robot that was told where it is, or nothing.
    pub(crate) fn of(is_told: bool) -> Self {
        Self {
            is_told,
            ..Self::default()
        }
    }

    /// Of a robot of which the map has explained what it sees.
    pub(crate) fn confirmed() -> Self {
        Self {
            confirmed: true,
            ..Self::default()
        }
    }

    /// Of a robot that was uncertain meanwhile.
    pub(crate) fn again(self) -> Self {
        Self {
            is_told: self.is_told,
            confirmed: self.confirmed,
            ..Self::default()
        }
    }

    /// True when the robot was told where it is.
    pub(crate) fn is_told(&self) -> bool {
        self.is_told
    }

    /// True once the map has explained what is seen, or when nothing is to be confirmed.
    pub(crate) fn is_confirmed(&self) -> bool {
        self.confirmed || !self.is_told
    }

    /// Takes in a scan that lies on the map at a first look; false when that is not enough: one in ten, and every
    /// one of a robot that seems to be lost or is not confirmed, wants a closer look.
    pub(crate) fn is_fine(&mut self) -> bool {
        self.n_glances += 1;
        self.confirmed && self.seems_s <= 0.0 && self.n_glances < CLOSELY_EVERY
    }

    /// Takes in what the map says of a scan; true when the robot is lost: the map explains less than the share `below`,
    /// and has for long. Where all that is seen is new, as in a hall that the lidar does not reach across, nothing says that
    /// the robot is elsewhere. A robot that was told nothing is doubted no sooner than one that is confirmed, unless it sees
    /// nothing of the map.
    pub(crate) fn is_lost(&mut self, scan: &Judged, below: f64) -> bool {
        self.n_glances = 0;
        let Judged {
            explained,
            n_ends,
            n_hits,
            elapsed_s,
            ..
        } = *scan;
        let n_judged = explained.judged().min(n_ends);
        let fits = |seen: &Explained, n_judged: f64, n_hits: f64| {
            let is_explained = seen.share(1.0) >= below && seen.on >= CONFIRMS * n_hits;
            n_judged >= JUDGED_MIN && is_explained
        };
        let is_doubted = self.is_told && !self.confirmed;
        let judged_min = if is_doubted {
            JUDGED_MIN_UNCONFIRMED
        } else {
            JUDGED_MIN
        };
        let is_judged = n_judged >= judged_min;
        let is_off = n_ends >= JUDGED_MIN && explained.judged() < (1.0 - OFF) * n_ends;
        let differs =
            (is_off && !self.confirmed) || (is_judged && seems_elsewhere(&explained, below));
        // What one scan says alone outweighs what others have said from elsewhere.
        let fits_alone = !differs && fits(&explained, n_judged, n_hits);
        // A robot whose scan fits drives over a cell of the map that is wrong.
        if is_doubted && scan.is_inside && !fits_alone {
            self.seems_s += INSIDE_COUNTS * elapsed_s;
            return self.seems_s >= LASTS_S;
        }
        let mut is_elsewhere = differs;
        self.confirmed |= fits_alone;
        if is_doubted {
            let (views, n_viewed) = self.add_view(scan);
            let views_differ = n_viewed >= JUDGED_MIN && seems_elsewhere(&views, below);
            is_elsewhere |= views_differ && !fits_alone;
            self.confirmed |= !is_elsewhere && fits(&views, n_viewed, self.view_hits);
        }
        self.count(is_elsewhere, is_judged, elapsed_s);
        self.seems_s >= LASTS_S
    }

    /// Takes in whether a scan says that the robot is elsewhere, or nothing when it is not judged.
    fn count(&mut self, is_elsewhere: bool, is_judged: bool, elapsed_s: f64) {
        if is_elsewhere {
            self.seems_s += elapsed_s;
        } else if is_judged {
            self.seems_s = (self.seems_s - FORGETS * elapsed_s).max(0.0);
        }
    }

    /// Adds a scan to the views unless it shows the last one again; all of them, and how many beams are judged.
    fn add_view(&mut self, scan: &Judged) -> (Explained, f64) {
        let at = &scan.map_from_base;
        if (self.last_view).is_none_or(|last| last.distance_m(at) >= VIEW_M) {
            self.last_view = Some(*at);
            self.views.add(&scan.explained);
            self.view_ends += scan.n_ends;
            self.view_hits += scan.n_hits;
        }
        (self.views, self.views.judged().min(self.view_ends))
    }
}

#[cfg(test)]
mod tests;
