//! What breaks by script: which faults hold at a moment, and what they do to a scan.

use crate::slip::Grip;
use zeronav_msgs::Pose;
use zeronav_msgs::time::nanoseconds;
use zeronav_robot_description::Blackout;
use zeronav_robot_description::FaultSpec;

/// The faults of one run.
#[derive(Debug, Clone)]
pub struct Faults {
    faults: Vec<Fault>,
    /// Ranges of the newest scan that was not frozen; empty before it. [m]
    seen_m: Vec<f32>,
}

#[derive(Debug, Clone, Copy)]
struct Fault {
    spec: FaultSpec,
    /// Run time at which it begins; `None` while it is unknown. [ns]
    from_ns: Option<u64>,
    /// A jump has been made.
    over: bool,
}

impl Fault {
    fn new(spec: FaultSpec) -> Self {
        Self {
            spec,
            from_ns: spec.begins().at_s.map(nanoseconds),
            over: false,
        }
    }

    fn holds_at(&self, run_ns: u64) -> bool {
        let Some(from_ns) = self.from_ns else {
            return false;
        };
        let lasts_ns = self.spec.lasts_s().map_or(u64::MAX, nanoseconds);
        from_ns <= run_ns && run_ns < from_ns.saturating_add(lasts_ns)
    }
}

impl Faults {
    /// The faults of `specs`, which [`FaultSpec::check`] accepts, of a lidar with `n_beams`.
    #[must_use]
    pub fn new(specs: &[FaultSpec], n_beams: usize) -> Self {
        Self {
            faults: specs.iter().copied().map(Fault::new).collect(),
            seen_m: Vec::with_capacity(n_beams),
        }
    }

    /// Begins what waits for a distance: the robot has really driven `driven_m` when a tick begins
    /// at `run_ns`.
    pub fn notice(&mut self, run_ns: u64, driven_m: f64) {
        for fault in &mut self.faults {
            let begins_m = fault.spec.begins().driven_m;
            if fault.from_ns.is_none() && begins_m.is_some_and(|begins_m| driven_m >= begins_m) {
                fault.from_ns = Some(run_ns);
            }
        }
    }

    /// What odometry adds in `base` at the end of a tick, at `run_ns`. Every jump is made once.
    pub fn take_jump(&mut self, run_ns: u64) -> Option<Pose> {
        let mut jump: Option<Pose> = None;
        for fault in &mut self.faults {
            if let FaultSpec::OdometryJump {
                shift: [x, y, yaw], ..
            } = fault.spec
                && !fault.over
                && fault.holds_at(run_ns)
            {
                fault.over = true;
                jump = Some(jump.unwrap_or_default().then(&Pose::new(x, y, yaw)));
            }
        }
        jump
    }

    /// What is left of the motion in a tick that begins at `run_ns`.
    #[must_use]
    pub fn grip(&self, run_ns: u64) -> Grip {
        let mut grip = Grip::FULL;
        for fault in self.holding(run_ns) {
            if let FaultSpec::Slip {
                forward_ratio,
                turn_ratio,
                ..
            } = fault
            {
                grip.forward *= 1.0 - forward_ratio;
                grip.turn *= 1.0 - turn_ratio;
            }
        }
        grip
    }

    /// By how much the lidar is turned in its mount at `run_ns`. [rad]
    #[must_use]
    pub fn turned_rad(&self, run_ns: u64) -> f64 {
        let turned_rad = |fault: FaultSpec| match fault {
            FaultSpec::LidarTurned { angle_rad, .. } => angle_rad,
            _ => 0.0,
        };
        self.holding(run_ns).map(turned_rad).sum()
    }

    /// True when a scan of `run_ns` is not sent.
    #[must_use]
    pub fn is_silent(&self, run_ns: u64) -> bool {
        self.holding(run_ns).any(|fault| {
            let FaultSpec::LidarBlackout { looks, .. } = fault else {
                return false;
            };
            looks == Blackout::Silent
        })
    }

    /// Makes of the scan of `run_ns` what the lidar sends; true when it still shows the world.
    pub fn spoil(&mut self, run_ns: u64, ranges: &mut [f32]) -> bool {
        let frozen = self.faults.iter().any(|fault| {
            matches!(fault.spec, FaultSpec::LidarFrozen { .. }) && fault.holds_at(run_ns)
        });
        let repeats = frozen && self.seen_m.len() == ranges.len();
        if repeats {
            ranges.copy_from_slice(&self.seen_m);
        } else {
            self.seen_m.clear();
            self.seen_m.extend_from_slice(ranges);
        }
        let blank_m = self.holding(run_ns).find_map(|fault| match fault {
            FaultSpec::LidarBlackout { looks, .. } => match looks {
                Blackout::Silent => None,
                Blackout::NoReturn => Some(f32::INFINITY),
                Blackout::Invalid => Some(f32::NAN),
            },
            _ => None,
        });
        if let Some(blank_m) = blank_m {
            ranges.fill(blank_m);
        }
        !repeats && blank_m.is_none()
    }

    fn holding(&self, run_ns: u64) -> impl Iterator<Item = FaultSpec> {
        let holds = move |fault: &&Fault| fault.holds_at(run_ns);
        self.faults.iter().filter(holds).map(|fault| fault.spec)
    }
}

#[cfg(test)]
mod tests;
