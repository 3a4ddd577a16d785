//! The kinds of suites.

/// What a suite is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Barn,
    Dynabarn,
    Pedestrians,
    Generated,
    Field,
    Kidnapped,
    Soak,
    Folder,
}

impl Kind {
    /// What the first word after `suite` means.
    pub(super) fn of(word: &str) -> Self {
        match word {
            "barn" => Self::Barn,
            "dynabarn" => Self::Dynabarn,
            "pedestrians" => Self::Pedestrians,
            "generated" => Self::Generated,
            "field" => Self::Field,
            "kidnapped" => Self::Kidnapped,
            "soak" => Self::Soak,
            _ => Self::Folder,
        }
    }

    pub(super) const fn label(self) -> &'static str {
        match self {
            Self::Barn => "barn",
            Self::Dynabarn => "dynabarn",
            Self::Pedestrians => "pedestrians",
            Self::Generated => "generated",
            Self::Field => "field",
            Self::Kidnapped => "kidnapped",
            Self::Soak => "soak",
            Self::Folder => "folder",
        }
    }

    /// What the numbers are, and what they are not.
    pub(super) const fn note(self) -> &'static str {
        match self {
            Self::Barn => {
                "BARN worlds in our own 2-D simulator, unknown to the robot at the start: \
                 no leaderboard entry"
            }
            Self::Dynabarn => {
                "DynaBARN worlds in our own 2-D simulator, obstacles straight from key frame to \
                 key frame: no leaderboard entry"
            }
            Self::Pedestrians => {
                "recorded people in our own 2-D simulator, who do not see the robot; starts and \
                 goals are ours: no published figure compares"
            }
            Self::Generated => {
                "worlds drawn from their numbers in our own 2-D simulator: no benchmark of others"
            }
            Self::Field => {
                "worlds of what real robots meet, drawn from their numbers in our own 2-D simulator: no \
                 benchmark of others"
            }
            Self::Kidnapped => {
                "robots that wake on a map without a pose, or with a wrong one, in our own 2-D simulator: a \
                 success has found itself and arrived; no published figure compares"
            }
            Self::Soak => {
                "drives with random faults in our own 2-D simulator: what breaks is put right, and \
                 nothing is left over"
            }
            Self::Folder => "scenarios in our own 2-D simulator, judged by what they expect",
        }
    }
}
