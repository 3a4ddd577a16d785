//! The command line of `zeronav suite`.

use crate::output_args::OutputArgs;
use crate::recordings::{self, RecordingsArgs};
use clap::Args;
use core::ops::Range;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use zeronav_console::arguments::hours;
use zeronav_scenario::settings::DriverArgs;
use zeronav_scenario::{ForesightSpec, Perceive, Predict};
use zeronav_suite::merge;
use zeronav_suite::noise::Noise;
use zeronav_suite::plan::SuitePlan;
use zeronav_suite::shard::Shard;

/// Arguments of `zeronav suite`.
#[derive(Debug, Clone, Args)]
pub struct SuiteArgs {
    /// generated and field (where real robots fail) need no data; barn, dynabarn, pedestrians, kidnapped
    /// (robots that do not know where on a map they are), soak (drives under random faults), or a folder of scenarios; recordings, with a folder of them; merge,
    /// with the folders of all shards of a suite.
    #[arg(
        value_name = "generated|field|barn|dynabarn|pedestrians|kidnapped|soak|recordings|merge|FOLDER",
        default_value = "",
        hide_default_value = true,
        required_unless_present = "resume"
    )]
    pub suite: String,
    /// The folder of the recordings, `suite recordings FOLDER`: its MCAP files, and those in its folders;
    /// or of every shard, `suite merge FOLDER...`: where `--shard` drove it.
    #[arg(value_name = "FOLDER")]
    pub folders: Vec<PathBuf>,
    /// Of recordings.
    #[command(flatten)]
    pub recordings: RecordingsArgs,
    /// Go on with the suite in this folder, which was interrupted, with the arguments that it was
    /// begun with.
    #[arg(long, value_name = "FOLDER",
          conflicts_with_all = ["suite", "controller", "method", "setting", "seeds", "worlds", "noise",
                                 "perceive", "predict", "data", "out", "shard"])]
    pub resume: Option<PathBuf>,
    /// Wall time of a soak in all of its calls, after which it begins no more drives; without, an hour.
    #[arg(long, value_name = "H", value_parser = hours)]
    pub hours: Option<f64>,
    /// Key of the local planner's controller; without, beam for dynabarn, pedestrians and what moves
    /// in generated, else its default or the scenario's.
    #[arg(long, value_name = "KEY", conflicts_with = "method")]
    pub controller: Option<String>,
    /// Who drives.
    #[command(flatten)]
    pub driver: DriverArgs,
    /// Drive nothing: plan a way through each run's world that touches nothing, with exact wheels and
    /// the future of everything that moves known, and report what is possible. Where none is found
    /// there may be one.
    #[arg(long, conflicts_with_all = ["controller", "method", "setting", "resume", "perceive",
                                      "predict"])]
    pub bound: bool,
    /// Runs of each world, with the seeds 1 to N.
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u64).range(1..=10_000))]
    pub seeds: u64,
    /// Only the worlds with a number from A up to, but not including, B. Scenes and scenarios are
    /// numbered from 0 by name.
    #[arg(long, value_name = "A..B", value_parser = world_range)]
    pub worlds: Option<Range<u32>>,
    /// Drive only shard I of N, for one of several machines; the name of a run decides its shard. `suite merge`
    /// makes one suite of the folders of all shards.
    #[arg(long, value_name = "I/N", conflicts_with = "bound")]
    pub shard: Option<Shard>,
    /// How badly wheels, odometry and lidar do.
    #[arg(long, value_enum, default_value_t)]
    pub noise: Noise,
    /// How mapping knows what moves: truth measures what perception costs, and is no result.
    #[arg(long, value_enum, default_value_t)]
    pub perceive: Perceive,
    /// How the local planner knows where that will be: truth measures what prediction costs, and is no
    /// result.
    #[arg(long, value_enum, default_value_t)]
    pub predict: Predict,
    /// Folder of the data sets: barn, dynabarn, pedestrians and rosmaps lie in it. Without, the environment's
    /// `$ZERONAV_DATA`, then ./data.
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// Runs at a time; without, as many as there are cores.
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZeroUsize>,
    /// Print the report as one JSON object on standard output.
    #[arg(long)]
    pub json: bool,
    /// Show nothing while it runs.
    #[arg(long)]
    pub headless: bool,
    /// Folder in which the suite's own folder is made.
    #[arg(long, value_name = "FOLDER", default_value = "runs")]
    pub out: PathBuf,
}

impl SuiteArgs {
    /// What the arguments mean when they are about recordings; `None` when they are about worlds.
    ///
    /// # Errors
    /// One line when they are about both.
    pub fn of_recordings(&self) -> Result<Option<recordings::Plan<'_>>, String> {
        let folders = self.folders.as_slice();
        if self.suite != recordings::SUITE {
            return if self.recordings.is_given() {
                Err("--open, --swap, --scenario and --slower: only `zeronav suite recordings FOLDER` takes them".to_owned())
            } else {
                Ok(None)
            };
        }
        let [folder] = folders else {
            return Err("which recordings? `zeronav suite recordings FOLDER`".to_owned());
        };
        if self.is_of_worlds() {
            return Err(
                "recordings are played as they are, one after the other: of worlds and drives are --controller (--set \
                 local_planner.controller=KEY), --bound, --seeds, --worlds, --noise, --perceive, --predict, --data, \
                 --hours, --jobs and --shard"
                    .to_owned(),
            );
        }
        Ok(Some(recordings::Plan {
            folder,
            arguments: &self.recordings,
            driver: &self.driver,
            output: OutputArgs {
                json: self.json,
                headless: self.headless,
                out: self.out.clone(),
                log_level: "info".to_owned(),
            },
        }))
    }

    /// The folders of the shards that are to be merged; `None` when none are.
    ///
    /// # Errors
    /// One line when the arguments are about something else, too.
    pub fn of_merge(&self) -> Result<Option<&[PathBuf]>, String> {
        if self.suite != merge::WORD {
            return if self.folders.is_empty() {
                Ok(None)
            } else {
                Err("only `zeronav suite recordings FOLDER` and `zeronav suite merge FOLDER...` take folders".to_owned())
            };
        }
        if self.is_of_worlds() || !self.driver.settings().is_empty() {
            return Err("what was driven is merged as it is: `zeronav suite merge` takes --json and --out alone".to_owned());
        }
        Ok(Some(&self.folders))
    }

    /// True when an argument is given that is about worlds and drives.
    fn is_of_worlds(&self) -> bool {
        self.controller.is_some()
            || self.bound
            || self.seeds != 1
            || self.worlds.is_some()
            || self.noise != Noise::default()
            || self.perceive != Perceive::default()
            || self.predict != Predict::default()
            || self.data.is_some()
            || self.hours.is_some()
            || self.jobs.is_some()
            || self.shard.is_some()
    }

    /// What the arguments mean.
    #[must_use]
    pub fn plan(&self) -> SuitePlan {
        SuitePlan {
            suite: self.suite.clone(),
            resume: self.resume.clone(),
            controller: self.controller.clone(),
            settings: self.driver.settings(),
            bound: self.bound,
            seeds: self.seeds,
            worlds: self.worlds.clone(),
            noise: self.noise,
            foresight: ForesightSpec {
                perceive: self.perceive,
                predict: self.predict,
            },
            data: self.data.clone(),
            hours: self.hours,
            shard: self.shard,
            jobs: self.jobs,
            progress: !self.headless,
            out: self.out.clone(),
        }
    }
}

/// `0..20` as 0 to 19.
fn world_range(text: &str) -> Result<Range<u32>, String> {
    let (from, until) = text.split_once("..").ok_or("worlds read like 0..20")?;
    let number = |text: &str| {
        text.parse::<u32>()
            .map_err(|_| format!("`{text}` is no number of a world"))
    };
    let range = number(from)?..number(until)?;
    if range.is_empty() {
        return Err(format!("range {text} contains no world"));
    }
    Ok(range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Command;

    #[test]
    fn only_what_recordings_take_stands_under_their_heading() {
        let suite = SuiteArgs::augment_args(Command::new("suite"));
        let under = suite
            .get_arguments()
            .filter(|arg| arg.get_help_heading().is_some());
        let names: Vec<&str> = under.map(|arg| arg.get_id().as_str()).collect();
        assert_eq!(names, ["open", "swap", "scenario", "slower"]);
    }
}
