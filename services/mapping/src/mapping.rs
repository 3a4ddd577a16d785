//! One scan after the other: where it was seen from, what moves in it, and what it says about the map.

mod whereabouts;
mod zones;

use crate::beams::{Beams, Sweep, ends_of, every_nth};
use crate::config::MappingConfig;
use crate::error::MappingError;
use crate::flips::Integrated;
use crate::localisation::StartPose;
use crate::localiser::{Localiser, OdometryAt};
use crate::located_scan::{LocatedScan, placed_at};
use crate::mapper::Mapper;
use crate::moved::Basis;
use crate::outline::Outline;
use crate::relocaliser::{Relocaliser, Step};
use crate::slip::Ends;
use crate::tracker::{ScanView, Tracker};
use crate::true_motion::TrueMotion;
use nalgebra::{Matrix3, Point2};
use zeronav_msgs::Pose;
use zeronav_msgs::description::{Corner, Description};
use zeronav_msgs::obstacles::Obstacle;
use zeronav_msgs::scan::Scan;
use zeronav_msgs::stages::{Stage, StageTimer};
use zeronav_msgs::time::seconds;
use zeronav_world::StaticMap;

/// How far beyond its radius the trail of something that moves is forgotten, in cells: its hits
/// count half a cell behind where they were measured, and its radius is a guess.
const TRAIL_MARGIN_CELLS: f64 = 2.0;

/// Most beams that are asked in every scan whether odometry is right.
const FEW: usize = 60;

/// Scans that lay a configured pose on the map.
const CONFIGURED_SCANS: u32 = 20;

/// A scan with what is known about where it was taken.
#[derive(Debug, Clone, Copy)]
pub struct Observation<'a> {
    /// A scan that was checked against [`Scan::check`].
    pub scan: &'a Scan,
    /// Its ranges. [m]
    pub ranges: &'a [f32],
    /// Run time of the capture, which is that of the last beam. [ns]
    pub run_ns: u64,
    /// `odom_from_base` at beam 0.
    pub odom_from_base_first: Pose,
    /// `odom_from_base` at the last beam.
    pub odom_from_base: Pose,
    /// What odometry says about its variances of x, y and yaw; all 0 = exact. [m^2, m^2, rad^2]
    pub odometry_variance: [f64; 3],
    /// Where the robot is going, in the map.
    pub goal: Option<Point2<f64>>,
    /// What moves, when that is told instead of tracked.
    pub told: Option<TrueMotion<'a>>,
}

/// The map and everything that is followed on it.
#[derive(Debug)]
pub struct Mapping {
    config: MappingConfig,
    has_static_map: bool,
    base_from_laser: Pose,
    outline: Outline,
    mapper: Mapper,
    localiser: Localiser,
    /// On a fixed static map on which the pose is corrected.
    relocaliser: Option<Relocaliser>,
    tracker: Tracker,
    /// The current scan, in `base` at its capture.
    beams: Beams,
    under_robot: Vec<usize>,
    /// Scratch: where beams ended on what is not known to move, in `base` [m], and which share of
    /// the scan was still to come.
    standing: Vec<Point2<f64>>,
    ago: Vec<f64>,
    /// Scratch: those that may be trusted to be on the map.
    landmarks: Vec<Point2<f64>>,
    /// Run time of the last scan. [ns]
    last_ns: u64,
    /// The grid changed with the last scan.
    moved: bool,
    /// What is left to ask of the last scan, and what that came to: it counts from the next scan on.
    unchecked: Option<Unchecked>,
    checked: Option<Checked>,
    /// The map had explained what is seen by the last scan, or nothing was to be confirmed.
    is_confirmed: bool,
    /// A configured `map_from_odom`, and for how many scans more it is laid on the map.
    configured: Option<(Pose, u32)>,
    timer: StageTimer,
}

/// A scan that [`Mapping::check`] has not looked at yet.
#[derive(Debug, Clone, Copy)]
struct Unchecked {
    odom_from_base: Pose,
    map_from_base: Pose,
    run_ns: u64,
    /// It becomes the next key scan.
    is_key: bool,
}

/// What [`Mapping::check`] came to.
#[derive(Debug)]
struct Checked {
    step: Step,
    /// Of the scan that it looked at.
    odom_from_base: Pose,
}

impl Mapping {
    /// The map before the first scan, see [`Mapper::new`]. `corners` are those of the robot's
    /// description.
    ///
    /// # Errors
    /// What is wrong with configuration or static map.
    pub fn new(
        config: &MappingConfig,
        static_map: Option<&StaticMap>,
        description: &Description,
        corners: &[Corner],
    ) -> Result<Self, MappingError> {
        let [x_m, y_m, yaw_rad] = config.localisation.map_from_odom;
        let map_from_odom = Pose::new(x_m, y_m, yaw_rad);
        let fastest = (description.v_mps_max, description.w_radps_max);
        let mut localiser = Localiser::new(&config.pose_correction, fastest, map_from_odom);
        let room_m = description.inscribed_radius_m;
        let relocaliser = Relocaliser::of(config, static_map.is_some(), room_m)?;
        let is_told = relocaliser.as_ref().is_some_and(Relocaliser::is_told);
        if is_told {
            // Nobody configures a pose to the centimetre.
            localiser.relocate(map_from_odom, &Pose::default());
        }
        if config.localisation.start == StartPose::Unknown {
            localiser.lose();
        }
        let is_confirmed = relocaliser.as_ref().is_none_or(Relocaliser::is_confirmed);
        Ok(Self {
            has_static_map: static_map.is_some(),
            base_from_laser: description.base_from_laser,
            outline: Outline::new(description, corners),
            mapper: Mapper::new(config, static_map, description)?,
            localiser,
            relocaliser,
            last_ns: 0,
            tracker: Tracker::new(&config.tracking),
            beams: Beams::default(),
            under_robot: Vec::new(),
            standing: Vec::new(),
            ago: Vec::new(),
            landmarks: Vec::new(),
            moved: false,
            unchecked: None,
            checked: None,
            is_confirmed,
            configured: is_told.then_some((map_from_odom, CONFIGURED_SCANS)),
            timer: StageTimer::default(),
            config: config.clone(),
        })
    }

    /// What times the stages of [`Self::take_in`]; off unless the caller has put another one there.
    pub fn timer(&mut self) -> &mut StageTimer {
        &mut self.timer
    }

    /// Takes in a scan: corrects the pose, follows what moves, brings the map up to date; the rest is for [`Self::check`].
    pub fn take_in(&mut self, observation: &Observation<'_>) -> Integrated {
        self.check();
        self.heed_check();
        let odom_from_base = &observation.odom_from_base;
        self.cast(observation, None);
        let corrects = self.localiser.is_active(&observation.odometry_variance);
        let is_key = (corrects || self.localiser.watches()) && self.localise(observation);
        self.hold_to_configuration(odom_from_base);
        self.last_ns = observation.run_ns;
        let map_from_base = self.localiser.map_from_base(odom_from_base);
        self.unchecked = Some(Unchecked {
            odom_from_base: *odom_from_base,
            map_from_base,
            run_ns: observation.run_ns,
            is_key,
        });
        self.follow_window(map_from_base.point());
        self.timer.mark(Stage::Localise);
        let mapper = &mut self.mapper;
        if self.config.tracking.enabled {
            let view = ScanView {
                scan: observation.scan,
                ranges: observation.ranges,
                beams: &self.beams,
                map_from_frame: map_from_base,
                map_from_laser: map_from_base.then(&self.base_from_laser),
                run_ns: observation.run_ns,
                yaw_variance: self.localiser.yaw_variance(),
            };
            match &observation.told {
                Some(told) => told.teach(&mut self.tracker, &view),
                None => self
                    .tracker
                    .follow(&view, |point| mapper.is_near_static(point)),
            }
            let margin_m = TRAIL_MARGIN_CELLS * mapper.geometry().resolution_m;
            self.tracker.new_trails(|place, radius_m| {
                mapper.forget(place, radius_m + margin_m);
            });
        }
        self.under_robot.clear();
        if self.config.footprint_clearing {
            let under_robot = &mut self.under_robot;
            self.outline
                .cells_under(mapper.geometry(), &map_from_base, |index| {
                    under_robot.push(index);
                });
        }
        let sight = LocatedScan {
            map_from_frame: map_from_base,
            beams: self.beams.as_slice(),
            moving: self.tracker.moving_beams(),
            run_ns: observation.run_ns,
        };
        self.timer.mark(Stage::Track);
        // A scan from nobody knows where would only spoil what the robot can be found by.
        let integrated = if self.localiser.is_uncertain() {
            Integrated::default()
        } else {
            mapper.take_in(&sight, &self.under_robot, &mut self.timer)
        };
        mapper.regularise(observation.goal.map(|goal| (map_from_base.point(), goal)));
        self.timer.mark(Stage::Clearance);
        integrated
    }

    /// Where the robot is: by the scan before, and by the map. True when this is to be the next key scan of odometry that
    /// is watched.
    fn localise(&mut self, observation: &Observation<'_>) -> bool {
        let run_ns = observation.run_ns;
        let odometry = OdometryAt {
            odom_from_base: observation.odom_from_base,
            claimed_yaw: observation.odometry_variance[2],
            run_s: seconds(run_ns),
        };
        let mut guess = self.localiser.map_from_base(&odometry.odom_from_base);
        let sweep_share = self.sweep_share(observation);
        let something_moves = self.tracker.sees_motion(run_ns);
        let noise = self.localiser.step(&odometry);
        if let Some(noise) = &noise
            && self.localiser.watches()
            && self.goes_along(noise, sweep_share, something_moves)
        {
            return self.localiser.is_key_due();
        }
        let are_most = self.find_standing(&guess, run_ns);
        let ends = Ends::of((&self.standing, &self.ago), sweep_share, are_most);
        let moved = self
            .localiser
            .predict(noise.as_ref(), &ends, something_moves);
        if self.localiser.watches()
            && !self
                .localiser
                .notices(moved.as_ref(), &ends, something_moves)
        {
            return false;
        }
        if let Some(moved) = moved.filter(|moved| moved.basis == Basis::Scans) {
            if sweep_share > 0.0 {
                self.cast(observation, Some((&moved.last_from_base, sweep_share)));
            }
            guess = self.localiser.pose();
            self.find_standing(&guess, run_ns);
        }
        self.find_landmarks(&guess);
        self.mapper.make_surfaces();
        let mapper = &self.mapper;
        let was_uncertain = self.localiser.is_uncertain();
        if let Some(surfaces) = mapper.surfaces() {
            self.localiser.lay(
                &self.standing,
                &self.landmarks,
                surfaces,
                |point| mapper.is_known(point),
                |point| mapper.is_near_static(point),
            );
        }
        if was_uncertain && !self.localiser.is_uncertain() {
            // What was tracked meanwhile was seen from elsewhere.
            self.tracker.restart();
        }
        false
    }

    /// True when a few beams of the scan do not speak against odometry, whose step since the last scan has the covariance
    /// `noise`: nothing else is done with most scans.
    fn goes_along(
        &mut self,
        noise: &Matrix3<f64>,
        sweep_share: f64,
        something_moves: bool,
    ) -> bool {
        let beams = self.beams.as_slice();
        let ends = (&mut self.standing, &mut self.ago);
        let every = every_nth(beams, FEW);
        ends_of(beams, every, self.config.obstacle_range_m, ends, |_| true);
        let few = Ends::of((&self.standing, &self.ago), sweep_share, true);
        self.localiser.goes_along(noise, &few, something_moves)
    }

    /// Share, 0 to 1, of the time since the last scan that the scan took; 0 = all beams at once.
    fn sweep_share(&self, observation: &Observation<'_>) -> f64 {
        let scan = observation.scan;
        let took_s = f64::from(scan.n_beams.saturating_sub(1)) * f64::from(scan.time_increment_s);
        let elapsed_s = seconds(observation.run_ns.saturating_sub(self.last_ns));
        if self.last_ns > 0 && elapsed_s > 0.0 {
            (took_s / elapsed_s).clamp(0.0, 1.0)
        } else {
            0.0
        }
    }

    /// The beams in `base` as it was at the last one: by odometry, or by another motion since the last
    /// scan and the share of it during which they were taken.
    fn cast(&mut self, observation: &Observation<'_>, other: Option<(&Pose, f64)>) {
        let Observation {
            odom_from_base_first: first,
            odom_from_base: last,
            ..
        } = observation;
        let base_from_first = match other {
            Some((motion, share)) => Pose::new(
                motion.x_m * share,
                motion.y_m * share,
                motion.yaw_rad * share,
            )
            .isometry()
            .inverse(),
            None => last.isometry().inverse() * first.isometry(),
        };
        let sweep = if other.is_none() && first == last {
            Sweep::still(self.base_from_laser)
        } else {
            Sweep {
                first: Pose::from(base_from_first * self.base_from_laser.isometry()),
                last: self.base_from_laser,
            }
        };
        self.beams
            .cast(observation.scan, observation.ranges, &sweep);
    }

    /// Leaves out the beams that ended on what may move: laid onto the map of a moment ago they
    /// would carry the robot along. True when most beams are left.
    fn find_standing(&mut self, guess: &Pose, run_ns: u64) -> bool {
        let in_map = placed_at(guess);
        let range_m_max = self.config.obstacle_range_m;
        let tracker = &self.tracker;
        let ends = (&mut self.standing, &mut self.ago);
        let n_ends = ends_of(self.beams.as_slice(), 1, range_m_max, ends, |end| {
            !tracker.may_be_dynamic_at(in_map(end), run_ns)
        });
        let mut are_most = 4 * self.standing.len() >= 3 * n_ends;
        if !are_most && tracker.sees_motion(run_ns) {
            self.standing.clear();
            self.ago.clear();
        } else if !are_most && !self.localiser.watches() {
            // Nothing was seen to move, and what seems to is too much for somebody who comes into view: what stands
            // seems to move by the lidar's noise, or because the wheels slip.
            let ends = (&mut self.standing, &mut self.ago);
            ends_of(self.beams.as_slice(), 1, range_m_max, ends, |_| true);
            are_most = true;
        }
        are_most
    }

    /// Of what stands, what may be trusted to be on the map.
    fn find_landmarks(&mut self, guess: &Pose) {
        let (in_map, mapper) = (placed_at(guess), &self.mapper);
        let known = |end: &&Point2<f64>| mapper.is_matchable(in_map(end));
        self.landmarks.clear();
        self.landmarks
            .extend(self.standing.iter().filter(known).copied());
    }

    /// Lets the map go where the robot is.
    fn follow_window(&mut self, robot: Point2<f64>) {
        let window = &self.config.window;
        if let Some((geometry, shift)) = window.follow(self.mapper.geometry(), robot) {
            self.mapper = self.mapper.moved(&geometry, shift, &self.config);
            self.moved = true;
        }
    }

    /// True once after the map has come to lie elsewhere: readers need all of it.
    pub fn take_moved(&mut self) -> bool {
        core::mem::take(&mut self.moved)
    }

    /// The map.
    #[must_use]
    pub fn mapper(&self) -> &Mapper {
        &self.mapper
    }

    /// The map, to take its changes.
    pub fn mapper_mut(&mut self) -> &mut Mapper {
        &mut self.mapper
    }

    /// What moves, in the map, at the last scan.
    pub fn obstacles(&self) -> impl Iterator<Item = Obstacle> + '_ {
        self.tracker.obstacles()
    }
}
