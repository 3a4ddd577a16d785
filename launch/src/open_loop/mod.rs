//! `zeronav replay --open`: what a recording holds goes into the open seats, and what they send is compared with what is
//! in the recording. It needs neither world nor robot, so that recordings of real robots are driven again, too.

mod once;
mod play;
mod player;
mod score;
mod ticks;

use crate::prepare::{Prepared, prepare};
use crate::recorded::end_tick;
use crate::recorded::notes::user_topics;
use crate::run_plan::RunPlan;
use crate::show::log;
use play::{PlayError, play};
use score::{Score, notes_of};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use ticks::in_ticks;
use zeronav_console::exit::{EXIT_INTERRUPTED, EXIT_SERVICE, EXIT_USAGE};
use zeronav_msgs::role::Role;
use zeronav_recorder::read::Summary;

/// The seats that can be open: those between the sensors and the wheels.
pub(crate) const SEATS: [Role; 4] = [
    Role::Mapping,
    Role::GlobalPlanner,
    Role::LocalPlanner,
    Role::CollisionGuard,
];

/// What was played.
#[derive(Debug)]
pub(crate) struct Played {
    /// The run's own folder.
    pub folder: PathBuf,
    /// What was played: the recording, or the form of it that has ticks.
    pub compared: PathBuf,
    /// The recording of it.
    pub file: PathBuf,
    /// The last tick that was played.
    pub last_tick: u64,
}

/// Why nothing can be compared: in a line, and the exit code.
#[derive(Debug)]
pub(crate) struct NotPlayed {
    pub why: String,
    pub code: u8,
}

impl From<String> for NotPlayed {
    fn from(why: String) -> Self {
        Self {
            why,
            code: EXIT_USAGE,
        }
    }
}

/// Plays the recording in `file`, summed up as `found`, of a run in lockstep or in real time, to the seats in `live`, up to
/// `to_s` of run time. [s]
///
/// # Errors
/// [`NotPlayed`].
pub(crate) fn open_loop(
    (file, found, is_lockstep): (&Path, &Summary, bool),
    plan: &RunPlan,
    live: &[Role],
    to_s: Option<f64>,
    interrupted: &Arc<AtomicBool>,
) -> Result<Played, NotPlayed> {
    let users = user_topics(found).map_err(|why| format!("{}: {why}", file.display()))?;
    let notes = notes_of(file, (found, &users))?;
    let prepared = prepare(plan)?;
    // What was recorded in real time is brought into ticks, and is compared as such.
    let (notes, compared) = if is_lockstep {
        (notes, file.to_owned())
    } else {
        in_ticks((notes, &users), &prepared, end_tick(found))?
    };
    let score = Score {
        users,
        ..Score::of(notes, live)
    };
    let last_tick = last_tick(&score, found, &prepared, to_s);
    if let Err(error) = log::open(&prepared.logs) {
        tracing::warn!(%error, "no log of the supervisor");
    }
    let of_seats = |why| NotPlayed {
        why,
        code: EXIT_SERVICE,
    };
    play(&prepared, &score, live, last_tick, interrupted).map_err(|error| match error {
        PlayError::Start(why) => NotPlayed::from(why),
        PlayError::Seat(why) => of_seats(why),
        PlayError::Interrupted => NotPlayed {
            why: "interrupted".to_owned(),
            code: EXIT_INTERRUPTED,
        },
    })?;
    let file = prepared.recording.clone();
    Ok(Played {
        folder: prepared.directory.clone(),
        compared,
        file: file.ok_or_else(|| "the run was not recorded".to_owned())?,
        last_tick,
    })
}

/// The last tick that is played: what the robot did when the run was over, until everything had stopped, followed the
/// clock of the machine.
fn last_tick(score: &Score, found: &Summary, prepared: &Prepared, to_s: Option<f64>) -> u64 {
    let last = score.last_tick();
    let last = end_tick(found).map_or(last, |end_tick| last.min(end_tick.saturating_sub(1)));
    let to_ns = to_s.map(zeronav_msgs::time::nanoseconds);
    to_ns.map_or(last, |to_ns| {
        last.min(to_ns / prepared.scenario.run.tick_ns().max(1))
    })
}
