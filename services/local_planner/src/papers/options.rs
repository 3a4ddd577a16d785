//! Gains of the papers' controllers, a group for each key. Where a default comes from is told in
//! PAPERS, Appendix B: the paper where it gives a number, this project where it does not.

use super::potential::Gains;
use zeronav_params::{choices, parameters};

/// A group that begins with the gains of a potential field.
macro_rules! field_parameters {
    (
        $(#[doc = $doc:literal])*
        $name:ident: $attract:literal, $repel:literal, $reach_m:literal;
        $($more:tt)*
    ) => {
        parameters! {
            $(#[doc = $doc])*
            #[derive(Copy)]
            pub struct $name {
                /// Gain of the attraction.
                attract: f64 = $attract, [0.001, 1.0e6];
                /// Gain of the repulsion.
                repel: f64 = $repel, [0.0, 1.0e6];
                /// Distance within which obstacles repel.
                reach_m: f64 = $reach_m, [0.01, 20.0] "m";
                $($more)*
            }
        }

        impl $name {
            /// Those of the field.
            #[must_use]
            pub const fn gains(&self) -> Gains {
                Gains {
                    attract: self.attract,
                    repel: self.repel,
                    reach: self.reach_m,
                }
            }
        }
    };
}

field_parameters! {
    /// The plain field of [JU].
    JuApfConfig: 40.0, 5.0, 2.0;
}

field_parameters! {
    /// Sub-goals of the path, reference 6 of [JU].
    JuR6Config: 40.0, 5.0, 2.0;
    /// Distance from a sub-goal at which the next one is taken.
    sub_tolerance_m: f64 = 0.3, [0.01, 5.0] "m";
    /// Exponent of the sub-goal's distance in the repulsion.
    n: i32 = 2, [0, 4];
}

field_parameters! {
    /// A carrot on the path, reference 7 of [JU].
    JuR7Config: 40.0, 5.0, 2.0;
    /// Distance along the path from the robot's place to the carrot.
    lookahead_m: f64 = 1.5, [0.1, 10.0] "m";
}

field_parameters! {
    /// The fused field of [JU].
    JuFusionConfig: 40.0, 5.0, 2.0;
    /// Distance around the robot within which points of the path attract (`r1`).
    r1_m: f64 = 1.5, [0.1, 10.0] "m";
    /// Distance between points of the path along an axis: the side of a cell of the paper's A*.
    point_m: f64 = 1.0, [0.05, 10.0] "m";
    /// Every attraction is a unit vector times the gain, so that the far goal does not drown the
    /// path (`norm_att`).
    normalised: bool = false;
}

field_parameters! {
    /// Repulsion that fades at the goal, [ZM].
    ZmRepConfig: 0.3, 0.03, 3.0;
    /// Exponent of the goal's distance in the repulsion.
    n: i32 = 1, [0, 4];
}

field_parameters! {
    /// Escapes from local minima of the plain field, [ZM].
    ZmEscConfig: 1.0, 1.0, 2.0;
    /// Way of the first escape; each further one is half as much longer.
    escape_m: f64 = 3.0, [0.1, 100.0] "m";
    /// Escapes without progress before the method gives up.
    tries: u32 = 3, [1, 100];
}

field_parameters! {
    /// Sideways repulsion from what approaches, on top of `zm_rep`, [ZM].
    ZmRvConfig: 0.3, 0.03, 3.0;
    /// Exponent of the goal's distance in the repulsion.
    n: i32 = 1, [0, 4];
    /// Gain of the relative velocity (`eta_v`).
    velocity: f64 = 1.0, [0.0, 1.0e6];
}

parameters! {
    /// The whole method of [ZM]: repulsion with the gain eta of eq. (5), escape, relative velocity.
    #[derive(Copy)]
    pub struct ZmFullConfig {
        /// Gain of the attraction.
        attract: f64 = 1.0, [0.001, 1.0e6];
        /// Gain of the repulsion near an obstacle.
        alpha: f64 = 2.0, [1.0, 100.0];
        /// Slope of the repulsion's gain further away.
        beta: f64 = 0.2975, [0.0, 100.0] "1/m";
        /// Distance within which obstacles repel.
        p0_m: f64 = 3.0, [0.01, 20.0] "m";
        /// Distance between nodes of the A* path, of which the next attracts: the side of a cell of
        /// the paper.
        point_m: f64 = 1.0, [0.05, 10.0] "m";
        /// Exponent of the next point's distance in the repulsion.
        n: i32 = 1, [0, 4];
        /// Whether the gain is differentiated, too (`F_rep3`).
        full_gradient: bool = false;
        /// Gain of the relative velocity (`eta_v`).
        velocity: f64 = 1.0, [0.0, 1.0e6];
        /// Way of the first escape; each further one is half as much longer.
        escape_m: f64 = 3.0, [0.1, 100.0] "m";
        /// Escapes without progress before the method gives up.
        tries: u32 = 3, [1, 100];
    }
}

field_parameters! {
    /// The plain field of [LWX], whose cells are half a metre here.
    LwxApfConfig: 5.0, 0.0625, 0.75;
}

field_parameters! {
    /// Turning points as interim goals, [LWX].
    LwxOapfConfig: 5.0, 0.0625, 0.75;
    /// Steps of 0.1 m that an interim goal may take per metre of its distance (`L` = 10 a cell).
    steps_per_m: f64 = 20.0, [0.1, 1.0e4] "1/m";
}

field_parameters! {
    /// Turning points as interim goals, each with its steps and no more, [LWX].
    LwxIterConfig: 5.0, 0.0625, 0.75;
    /// Steps of 0.1 m that an interim goal may take per metre of its distance (`L` = 10 a cell).
    steps_per_m: f64 = 20.0, [0.1, 1.0e4] "1/m";
}

choices! {
    /// What a path is fitted by.
    pub enum FitMode {
        /// x and y over the arc length, both ends exact.
        #[default]
        Parametric = "parametric",
        /// y over x, as printed: impossible for vertical and returning paths, which stay unfitted.
        YxLiteral = "yx_literal",
    }
}

field_parameters! {
    /// The path fitted by least squares, [LWX].
    LwxLsqConfig: 5.0, 0.0625, 0.75;
    /// Distance from the nearest point of the curve to the carrot.
    lookahead_m: f64 = 1.0, [0.1, 10.0] "m";
    /// What is fitted.
    mode: FitMode = FitMode::Parametric;
}

field_parameters! {
    /// Turning points as interim goals and a fit of the walk, [LWX].
    LwxFusionConfig: 5.0, 0.0625, 0.75;
    /// Steps of 0.1 m that an interim goal may take per metre of its distance (`L` = 10 a cell).
    steps_per_m: f64 = 20.0, [0.1, 1.0e4] "1/m";
    /// Distance from the nearest point of the curve to the carrot.
    lookahead_m: f64 = 1.0, [0.1, 10.0] "m";
}

choices! {
    /// How a term is scaled before it is weighed.
    pub enum Normalise {
        /// By its sum over the admissible twists.
        #[default]
        Sum = "sum",
        /// From 0 at its least to 1 at its largest.
        MinMax = "min_max",
    }
}

choices! {
    /// What becomes of the scores of neighbouring twists (`sigma`).
    pub enum Smooth {
        /// Nothing.
        #[default]
        Identity = "identity",
        /// The mean of 3 x 3 neighbours, as far as they are admissible.
        Box = "box",
    }
}

choices! {
    /// When the window decides.
    pub enum Switch {
        /// Always.
        #[default]
        Always = "always",
        /// While an obstacle that no map shows is near the way; the path is followed else.
        OnDetect = "on_detect",
    }
}

parameters! {
    /// The dynamic window of [BAO].
    #[derive(Copy)]
    pub struct BaoDwaConfig {
        /// Weight of heading (`alpha`).
        head: f64 = 0.15, [0.0, 1.0e3];
        /// Weight of distance (`beta`).
        dist: f64 = 0.2, [0.0, 1.0e3];
        /// Weight of speed (`gamma`).
        vel: f64 = 0.1, [0.0, 1.0e3];
        /// Weight of nearness to the path (`delta`).
        path: f64 = 0.1, [0.0, 1.0e3];
        /// Distance beyond which obstacles do not count.
        dist_m_max: f64 = 2.0, [0.1, 20.0] "m";
        /// Duration of a predicted arc.
        horizon_s: f64 = 3.0, [0.1, 10.0] "s";
        /// Control period of the window.
        period_s: f64 = 0.1, [0.01, 1.0] "s";
        /// Distance along the path from the robot's place to the local goal.
        lookahead_m: f64 = 1.0, [0.1, 10.0] "m";
        /// How a term is scaled before it is weighed.
        normalise: Normalise = Normalise::Sum;
        /// What becomes of the scores of neighbouring twists (`sigma`).
        smooth: Smooth = Smooth::Identity;
        /// When the window decides.
        switch: Switch = Switch::Always;
    }
}

parameters! {
    /// Gains of the papers' controllers, by key.
    #[derive(Copy)]
    pub struct PapersConfig {
        /// For `ju_apf`.
        ju_apf: JuApfConfig;
        /// For `ju_r6`.
        ju_r6: JuR6Config;
        /// For `ju_r7`.
        ju_r7: JuR7Config;
        /// For `ju_fusion`.
        ju_fusion: JuFusionConfig;
        /// For `zm_rep`.
        zm_rep: ZmRepConfig;
        /// For `zm_esc`.
        zm_esc: ZmEscConfig;
        /// For `zm_rv`.
        zm_rv: ZmRvConfig;
        /// For `zm_full`.
        zm_full: ZmFullConfig;
        /// For `lwx_apf`.
        lwx_apf: LwxApfConfig;
        /// For `lwx_oapf`.
        lwx_oapf: LwxOapfConfig;
        /// For `lwx_iter`.
        lwx_iter: LwxIterConfig;
        /// For `lwx_lsq`.
        lwx_lsq: LwxLsqConfig;
        /// For `lwx_fusion`.
        lwx_fusion: LwxFusionConfig;
        /// For `bao_dwa`.
        bao_dwa: BaoDwaConfig;
    }
}
