//! What the kernels work on: plain arrays, lane by lane.

use zeronav_casts::Cast;

/// Most lanes of a row.
pub(crate) const LANES_MAX: usize = 64;

/// One number per lane.
pub(crate) type Lanes = [f32; LANES_MAX];

/// Lanes that are worked on together; slices are multiples of it.
pub(crate) const WIDTH: usize = 8;

/// Samples of the stretch, a power of two.
pub(crate) const SAMPLES: usize = 32;

/// Bits of a number that tell a sample of a stretch.
pub(crate) const SAMPLE_BITS: u32 = 31;

/// The filled window: `side x side` clearances, row-major.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sheet<'a> {
    /// [m] at cell centres.
    pub(crate) cells: &'a [f32],
    pub(crate) side: i32,
    /// Index of the robot's centre, in cells.
    pub(crate) centre: (f32, f32),
    /// [m]
    pub(crate) resolution_m: f32,
    /// [1/m]
    pub(crate) inverse: f32,
}

/// Headings of the lanes of a rollout grid, and how each turns in the current step.
#[derive(Debug, Clone)]
pub(crate) struct Turns {
    pub(crate) cos: [f64; LANES_MAX],
    pub(crate) sin: [f64; LANES_MAX],
    /// Turned so far. [rad]
    pub(crate) turned: [f64; LANES_MAX],
    /// Of the step: its angle [rad], cosine and sine of half of it, chord per metre driven.
    pub(crate) angle: [f64; LANES_MAX],
    pub(crate) half_cos: [f64; LANES_MAX],
    pub(crate) half_sin: [f64; LANES_MAX],
    pub(crate) chord: [f64; LANES_MAX],
}

/// A point's place on the stretch.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Projection {
    /// [m] along the path from the robot's place, negative behind it.
    pub(crate) along: f32,
    /// [m] beside the path.
    pub(crate) beside: f32,
    /// Direction of the path there, in the map; zero for a path that is a single point.
    pub(crate) direction: (f32, f32),
}

/// Places on the stretch of as many points as there are lanes; see [`Projection`].
#[derive(Debug, Clone)]
pub(crate) struct Projections {
    pub(crate) along: Lanes,
    pub(crate) beside: Lanes,
    pub(crate) direction_x: Lanes,
    pub(crate) direction_y: Lanes,
}

impl Default for Projections {
    fn default() -> Self {
        let lanes = [0.0; LANES_MAX];
        Self {
            along: lanes,
            beside: lanes,
            direction_x: lanes,
            direction_y: lanes,
        }
    }
}

type Samples = [f32; SAMPLES];

/// Samples relative to the robot along the axes of the map, and the ways from each to the next. [m]
#[derive(Debug, Clone, Default)]
pub(crate) struct Stretch {
    pub(crate) n: usize,
    pub(crate) x: Samples,
    pub(crate) y: Samples,
    /// To the next sample.
    pub(crate) step_x: Samples,
    pub(crate) step_y: Samples,
    /// One over the squared length of that; 0 for none. [1/m^2]
    pub(crate) inverse: Samples,
    /// Along the path to the next sample, more than the length where a corner is cut.
    pub(crate) arc: Samples,
    /// Along the path from the robot's place to the sample.
    pub(crate) start: Samples,
    /// Direction of the path at the sample, over its neighbours.
    pub(crate) direction_x: Samples,
    pub(crate) direction_y: Samples,
}

pub(crate) fn narrow(value: f64) -> f32 {
    value.to_f32()
}

/// The smaller of two numbers, neither of which is NaN.
pub(crate) fn least(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// The larger of two numbers, neither of which is NaN.
pub(crate) fn most(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}
