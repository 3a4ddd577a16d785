//! Finds a robot that does not know where it is on its static map.
//!
//! [`LostWatch`] says when it is lost. Then [`GlobalSearch`] looks for the places at which a scan fits, a bounded share of the
//! work with every scan; these are made exact and held against the next scans, wherever the robot has moved by then, beams
//! that look through walls counting against a place. One that explains most, and clearly more than any other, is where the robot
//! is. Otherwise it is not known, and looked for again: never is a place guessed among equal ones.

use crate::beams::{Beam, every_nth, is_near};
use crate::config::MappingConfig;
use crate::explained::{Explained, Walls};
use crate::global_search::GlobalSearch;
use crate::localisation::StartPose;
use crate::localiser::CorrectionMode;
use crate::lost::{Judged, LostWatch, seems_elsewhere};
use crate::mapper::Mapper;
use crate::places::{Ground, Held, exact, is_same, lay, motion, n_hits};
use crate::scan_match::Match;
use crate::window::WindowMode;
use nalgebra::{Matrix3, Point2, Vector3};
use zeronav_casts::Cast;
use zeronav_msgs::Pose;
use zeronav_msgs::time::seconds;
use zeronav_params::ParameterError;

/// Beams of a first look, of a second one, and of a search: of more, every n-th.
const GLANCE: usize = 60;
const LOOK: usize = 180;

/// Share of the ends of a first look on the static map with which there is no second one.
const FINE: f64 = 0.75;

/// Beams that a search lays on the map with a scan, and cells of that map that are made with one. With every scan that is
/// less than 10 ms of a core of 2020.
const LAYS: usize = 800_000;
const MAKES: usize = 500_000;

/// How long an uncertain robot is looked for near by alone. [s]
const NEAR_BY_S: f64 = 1.0;

/// Time between two scans that counts at most. [s]
const STEP_S_MAX: f64 = 0.5;

/// Scans that places are held against.
const CHECKS: u32 = 5;

/// Least share that the place must explain, and the beams.
const EXPLAINS: (f64, f64) = (0.5, 30.0);

/// By how much more than any other it must explain: at least, by so large a share of what it leaves unexplained more, at
/// most. A chair that was carried from one of two equal rooms to the other must not decide.
const AHEAD: (f64, f64, f64) = (0.08, 0.3, 0.15);

/// What is asked more of a search that begins where the last one found several places, and at most.
const CAUTION: (f64, f64) = (0.03, 0.15);

/// Largest share of the beams that may look through walls at the place.
const THROUGH: f64 = 0.3;

/// Least deviations of a robot that was found. [m, rad]
const FOUND: (f64, f64) = (0.03, 0.02);

/// After how long a robot is looked for again, and after what motion. [s, m, rad]
const AGAIN: (f64, f64, f64) = (2.0, 0.3, 0.3);

/// Least number of a configured pose, in m or rad, that is not 0 by rounding.
const TOLD: f64 = 1.0e-9;

/// A scan, and where it was taken as far as is known.
#[derive(Clone, Copy)]
pub(crate) struct Sight<'a> {
    /// The beams, in `base`.
    pub(crate) beams: &'a [Beam],
    pub(crate) mapper: &'a Mapper,
    /// Where the robot takes itself to be, or how it has moved.
    pub(crate) map_from_base: Pose,
    /// Run time of the capture. [ns]
    pub(crate) run_ns: u64,
    /// True when the pose is uncertain.
    pub(crate) is_uncertain: bool,
}

/// What a scan came to.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Step {
    /// Nothing new.
    Nothing,
    /// The robot is not where it takes itself to be.
    Lost,
    /// The robot is there.
    Found(Match),
}

/// How far the robot knows where it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sought {
    /// It knows, or is looked for near by alone.
    #[default]
    Not,
    /// It is looked for on the whole map.
    Everywhere,
    /// There are so many places that fit.
    Ambiguous(usize),
    /// Too many poses fit a little to look at all of them.
    TooMany,
    /// No place fits.
    Nowhere,
}

#[derive(Debug)]
enum Stage {
    /// The robot knows where it is.
    Known,
    /// Waits for a scan to search with.
    Begin,
    Search {
        search: Box<GlobalSearch>,
        ends: Vec<Point2<f64>>,
        from: Pose,
    },
    Check {
        places: Vec<Held>,
        from: Pose,
        n_scans: u32,
        complete: bool,
    },
    Wait {
        since_ns: u64,
        from: Pose,
    },
}

/// Says when the robot is lost, and looks for it.
#[derive(Debug)]
pub(crate) struct Relocaliser {
    lost_below: f64,
    /// How far beams count. [m]
    range_m_max: f64,
    /// Least clearance at which the robot can stand. [m]
    room_m: f64,
    watch: LostWatch,
    stage: Stage,
    sought: Sought,
    /// How long the pose has been uncertain. [s]
    uncertain_s: f64,
    /// What is asked beyond [`AHEAD`].
    caution: f64,
    /// Run time of the last scan. [ns] 0 = there was none.
    last_ns: u64,
    /// Made when it is searched for the first time.
    ground: Option<Ground>,
    /// Scratch: indices of the beams that stand.
    standing: Vec<usize>,
}

impl Relocaliser {
    /// For a robot that can stand where the clearance is `room_m`. `None` where it cannot be looked for: without a
    /// static map, on one that moves, and where `odom` is `map`.
    ///
    /// # Errors
    /// When it cannot, but its pose is unknown.
    pub(crate) fn of(
        config: &MappingConfig,
        has_static_map: bool,
        room_m: f64,
    ) -> Result<Option<Self>, ParameterError> {
        let can = has_static_map
            && config.window.mode == WindowMode::Fixed
            && config.pose_correction.mode != CorrectionMode::Off;
        if !can && config.localisation.start == StartPose::Unknown {
            return Err(ParameterError {
                path: "localisation.start".to_owned(),
                rule: "needs a static map, a fixed window and a pose that is corrected".to_owned(),
                value: "\"unknown\"".to_owned(),
            });
        }
        Ok(can.then(|| Self {
            lost_below: config.localisation.lost_below,
            range_m_max: config.obstacle_range_m,
            room_m,
            // Where `odom` begins as `map` nothing was told.
            watch: LostWatch::of(
                (config.localisation.map_from_odom.iter()).any(|it| it.abs() > TOLD),
            ),
            stage: Stage::Known,
            sought: Sought::Not,
            uncertain_s: 0.0,
            caution: 0.0,
            last_ns: 0,
            ground: None,
            standing: Vec::new(),
        }))
    }

    /// Begins anew: the robot was told where it is, or that nobody knows.
    pub(crate) fn restart(&mut self) {
        self.stage = Stage::Known;
        self.sought = Sought::Not;
        self.watch = LostWatch::of(self.watch.is_told());
        self.uncertain_s = 0.0;
        self.caution = 0.0;
        // Where there is room depends on what stood there then.
        self.ground = None;
    }

    /// As [`Self::restart`], of a robot that was told where it is.
    pub(crate) fn tell(&mut self) {
        self.restart();
        self.watch = LostWatch::of(true);
    }

    /// As [`Self::restart`], where the map has explained what is seen: the robot was found, or takes over from a process
    /// that knew where it is and had seen that.
    pub(crate) fn confirm(&mut self) {
        self.restart();
        self.watch = LostWatch::confirmed();
    }

    /// True when the robot was told where it is.
    pub(crate) fn is_told(&self) -> bool {
        self.watch.is_told()
    }

    /// True when nothing is to be confirmed, or the map has explained what the robot sees.
    pub(crate) fn is_confirmed(&self) -> bool {
        self.lost_below <= 0.0 || self.watch.is_confirmed()
    }

    /// How far the robot knows where it is.
    pub(crate) fn sought(&self) -> Sought {
        self.sought
    }

    /// Takes in a scan. `stands` says of a point of the map, as the robot takes itself to be on it, that nothing moves there.
    pub(crate) fn follow(
        &mut self,
        sight: &Sight<'_>,
        stands: impl Fn(Point2<f64>) -> bool,
    ) -> Step {
        // How long before its first scan things were as they are, nobody knows.
        let last_ns = core::mem::replace(&mut self.last_ns, sight.run_ns);
        let elapsed_s = if last_ns > 0 {
            seconds(sight.run_ns.saturating_sub(last_ns)).min(STEP_S_MAX)
        } else {
            0.0
        };
        if sight.is_uncertain {
            self.uncertain_s += elapsed_s;
            return self.seek(sight, stands);
        }
        if !matches!(self.stage, Stage::Known) {
            // It lies on the map again, near by: it knows as much as before.
            let watch = self.watch;
            self.restart();
            self.watch = watch.again();
        }
        self.uncertain_s = 0.0;
        if self.is_lost(sight, stands, elapsed_s) {
            self.restart();
            self.stage = Stage::Begin;
            return Step::Lost;
        }
        Step::Nothing
    }

    /// True when the static map has explained too little for long.
    fn is_lost(
        &mut self,
        sight: &Sight<'_>,
        stands: impl Fn(Point2<f64>) -> bool,
        elapsed_s: f64,
    ) -> bool {
        if self.lost_below <= 0.0 {
            return false;
        }
        self.stand(sight, GLANCE, stands);
        let into_map = sight.map_from_base.isometry();
        let near = self.standing.iter().map(|n| &sight.beams[*n]);
        let near = near.filter(|beam| is_near(beam, self.range_m_max));
        let (mut n, mut on) = (0.0, 0.0);
        for end in near.filter_map(Beam::point) {
            n += 1.0;
            on += f64::from(u8::from(sight.mapper.is_near_static(into_map * end)));
        }
        if on >= FINE * n && n > 0.0 && self.watch.is_fine() {
            return false;
        }
        let beams = self.standing.iter().map(|n| &sight.beams[*n]);
        let explained = Walls::of(sight.mapper).explain(
            beams,
            &sight.map_from_base,
            self.range_m_max,
            |point| sight.mapper.is_near_static(point),
        );
        let judged = Judged {
            explained,
            n_ends: n,
            n_hits: n_hits(sight.beams, GLANCE, self.range_m_max),
            map_from_base: sight.map_from_base,
            is_inside: sight.mapper.is_in_static(sight.map_from_base.point()),
            elapsed_s,
        };
        self.watch.is_lost(&judged, self.lost_below)
    }

    /// Goes on with the search.
    fn seek(&mut self, sight: &Sight<'_>, stands: impl Fn(Point2<f64>) -> bool) -> Step {
        let Sight {
            mapper,
            map_from_base,
            ..
        } = sight;
        match core::mem::replace(&mut self.stage, Stage::Begin) {
            Stage::Known if self.uncertain_s < NEAR_BY_S => self.stage = Stage::Known,
            Stage::Known | Stage::Begin => {
                self.stand(sight, LOOK, stands);
                self.begin(sight);
            }
            Stage::Search {
                mut search,
                ends,
                from,
            } => {
                let ground = self.ground.as_mut();
                let Some(map) = ground.and_then(|it| it.make(mapper, MAKES)) else {
                    return Step::Nothing;
                };
                self.stage = if search.advance(map, LAYS) {
                    Stage::Check {
                        places: exact(&search, mapper, &ends),
                        from,
                        n_scans: 0,
                        complete: search.is_complete(),
                    }
                } else {
                    Stage::Search { search, ends, from }
                };
            }
            Stage::Check {
                mut places,
                from,
                n_scans,
                complete,
            } => {
                self.stand(sight, LOOK, stands);
                let came = motion(&from, map_from_base);
                self.hold(sight, &mut places, &came);
                if n_scans + 1 < CHECKS {
                    let n_scans = n_scans + 1;
                    self.stage = Stage::Check {
                        places,
                        from,
                        n_scans,
                        complete,
                    };
                    return Step::Nothing;
                }
                return self.decide(sight, places, &came, complete);
            }
            Stage::Wait { since_ns, from } => {
                let (wait_s, way_m, turn_rad) = AGAIN;
                let came = motion(&from, map_from_base);
                let has_moved = came.point().coords.norm() > way_m || came.yaw_rad.abs() > turn_rad;
                if has_moved {
                    self.caution = 0.0;
                }
                if !has_moved && seconds(sight.run_ns.saturating_sub(since_ns)) < wait_s {
                    self.stage = Stage::Wait { since_ns, from };
                }
            }
        }
        Step::Nothing
    }

    /// Begins to search with a scan that sees enough, once there is a map for that.
    fn begin(&mut self, sight: &Sight<'_>) {
        if self.sought == Sought::Not {
            self.sought = Sought::Everywhere;
        }
        let (mapper, room_m) = (sight.mapper, self.room_m);
        let ground = (self.ground).get_or_insert_with(|| Ground::new(mapper, room_m));
        let Some(map) = ground.make(mapper, MAKES) else {
            return;
        };
        let ends = self.standing.iter().map(|n| &sight.beams[*n]);
        let ends = ends.filter(|beam| is_near(beam, self.range_m_max));
        let ends: Vec<_> = ends.filter_map(Beam::point).collect();
        if ends.len().to_f64() < EXPLAINS.1 {
            // It is tried with the next scan.
            return;
        }
        self.stage = Stage::Search {
            search: Box::new(GlobalSearch::new(map, &ends)),
            ends,
            from: sight.map_from_base,
        };
    }

    /// Holds places against a scan, `came` after the search began.
    fn hold(&self, sight: &Sight<'_>, places: &mut [Held], came: &Pose) {
        let Some(surfaces) = sight.mapper.surfaces() else {
            return;
        };
        let on_m = 2.0 * sight.mapper.geometry().resolution_m.max(0.05);
        let walls = Walls::of(sight.mapper);
        for place in places {
            let beams = self.standing.iter().map(|n| &sight.beams[*n]);
            let pose = place.pose.then(came);
            let seen = walls.explain(beams, &pose, self.range_m_max, |point| {
                surfaces.distance_m(point) <= on_m && sight.mapper.is_near_static(point)
            });
            place.explained.add(&seen);
        }
    }

    /// Where the robot is, if one place is better than all others.
    fn decide(
        &mut self,
        sight: &Sight<'_>,
        mut places: Vec<Held>,
        came: &Pose,
        complete: bool,
    ) -> Step {
        let share = |place: &Held| place.explained.share(1.0);
        places.sort_by(|a, b| share(b).total_cmp(&share(a)));
        self.stage = Stage::Wait {
            since_ns: sight.run_ns,
            from: sight.map_from_base,
        };
        // A search that was given up says nothing of the places that it has not come to.
        let none = if complete {
            Sought::Nowhere
        } else {
            Sought::TooMany
        };
        let Some(best) = places.first().copied() else {
            self.sought = none;
            return Step::Nothing;
        };
        let (least, unexplained, most) = AHEAD;
        let ahead = (least + unexplained * (1.0 - share(&best))).min(most) + self.caution;
        let rivals = places.iter().skip(1).filter(|place| {
            share(place) + ahead > share(&best) && !is_same(&place.pose, &best.pose)
        });
        let n_rivals = rivals.count();
        let Explained { on, through, .. } = best.explained;
        if share(&best) < EXPLAINS.0
            || on < EXPLAINS.1 * f64::from(CHECKS)
            || through > THROUGH * best.explained.judged()
            || seems_elsewhere(&best.explained, self.lost_below)
        {
            self.sought = none;
            return Step::Nothing;
        }
        if n_rivals > 0 || !complete {
            self.sought = if n_rivals > 0 {
                Sought::Ambiguous(n_rivals + 1)
            } else {
                Sought::TooMany
            };
            self.caution = (self.caution + CAUTION.0).min(CAUTION.1);
            return Step::Nothing;
        }
        let ends = self.standing.iter().filter_map(|n| sight.beams[*n].point());
        let ends: Vec<_> = ends.collect();
        let pose = best.pose.then(came);
        let found = (sight.mapper.surfaces())
            .and_then(|surfaces| lay(surfaces, &ends, &pose))
            .filter(|found| is_same(&found.pose, &pose));
        let Some(mut found) = found else {
            self.sought = Sought::Nowhere;
            return Step::Nothing;
        };
        let least = Vector3::new(FOUND.0, FOUND.0, FOUND.1);
        found.covariance += Matrix3::from_diagonal(&least.component_mul(&least));
        self.confirm();
        Step::Found(found)
    }

    /// Finds the beams that say something of what stands, at most about `n_max`.
    fn stand(&mut self, sight: &Sight<'_>, n_max: usize, stands: impl Fn(Point2<f64>) -> bool) {
        let every = every_nth(sight.beams, n_max);
        let into_map = sight.map_from_base.isometry();
        let beams = sight.beams.iter().enumerate().step_by(every);
        self.standing.clear();
        self.standing.extend(
            beams
                .filter(|(_, beam)| beam.point().is_none_or(|end| stands(into_map * end)))
                .map(|(n, _)| n),
        );
    }
}
