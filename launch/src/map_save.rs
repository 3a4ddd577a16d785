//! `zeronav map save`: the map of a run as a file for the ROS `map_server`, and for the next run.

use crate::remote::cli::StackArgs;
use crate::topics::tap::{PAUSE, Tap};
use clap::{Args, Subcommand};
use serde_json::json;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};
use zeronav_console::exit::{EXIT_OUTPUT, EXIT_PASS};
use zeronav_console::terminal::{complain, say, say_json, usage};
use zeronav_files::{Folder, Replace};
use zeronav_msgs::header::Id;
use zeronav_msgs::replica::MapReplica;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{EVENT_NEED_KEYFRAME, MapKeyframe};
use zeronav_shell::clock::now_ns;
use zeronav_shell::doorbell::Bells;
use zeronav_shell::printable::printable;
use zeronav_world::{Occupancy, StaticMap};
use zeronav_world_files::map_file;

/// How long mapping may take to send its map.
const MAP_LIMIT: Duration = Duration::from_secs(5);

/// Time between two requests for a keyframe.
const ASK_PAUSE: Duration = Duration::from_millis(50);

/// Arguments of `zeronav map`.
#[derive(Debug, Clone, Args)]
pub struct MapArgs {
    /// What to do.
    #[command(subcommand)]
    pub verb: MapVerb,
}

/// What `zeronav map` does.
#[derive(Debug, Clone, Subcommand)]
pub enum MapVerb {
    /// Save the map as it is now, with what the lidar saw, for the ROS `map_server`.
    Save(MapSaveArgs),
}

/// Arguments of `zeronav map save`.
#[derive(Debug, Clone, Args)]
pub struct MapSaveArgs {
    /// The YAML file to write, such as `maps/hall.yaml`; the image is written beside it.
    pub file: PathBuf,
    /// Replace a map of the same name.
    #[arg(long)]
    pub force: bool,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// `zeronav map`.
#[must_use]
pub fn map(arguments: &MapArgs) -> ExitCode {
    let MapVerb::Save(arguments) = &arguments.verb;
    let replace = if arguments.force {
        Replace::Yes
    } else {
        Replace::No
    };
    let (folder, name) = match place(&arguments.file, replace) {
        Ok(place) => place,
        Err(problem) => return usage(&problem),
    };
    let (map, revision) = match current_map(arguments.stack.domain.as_deref()) {
        Ok(map) => map,
        Err(problem) => return usage(&problem),
    };
    let saved = Folder::make(folder)
        .map_err(|error| format!("{}: {error}", folder.display()))
        .and_then(|folder| {
            let saved = map_file::save_in(&map, &folder, name, replace);
            saved.map_err(|error| error.to_string())
        });
    let file = match saved {
        Ok(file) => file,
        Err(problem) => {
            complain(&problem);
            return ExitCode::from(EXIT_OUTPUT);
        }
    };
    let geometry = &map.geometry;
    let [occupied, free, unknown] =
        [Occupancy::Occupied, Occupancy::Free, Occupancy::Unknown].map(|wanted| map.count(wanted));
    if arguments.stack.json {
        say_json(&json!({
            "file": file,
            "image": folder.join(format!("{name}.pgm")),
            "revision": revision.to_string(),
            "width": geometry.width,
            "height": geometry.height,
            "resolution_m": geometry.resolution_m,
            "origin_m": [geometry.origin_x_m, geometry.origin_y_m],
            "occupied": occupied,
            "free": free,
            "unknown": unknown,
        }));
    } else {
        say(&format!(
            "{}: {} x {} cells of {} m, {occupied} occupied, {free} free, {unknown} unknown\n",
            file.display(),
            geometry.width,
            geometry.height,
            geometry.resolution_m,
        ));
    }
    ExitCode::from(EXIT_PASS)
}

/// Folder, which may be missing, and name, without its ending, of the file to write.
fn place(file: &Path, replace: Replace) -> Result<(&Path, &str), String> {
    let shown = printable(&file.to_string_lossy()).into_owned();
    let wrong = |problem: &str| Err(format!("{shown}: {problem}"));
    if file.file_name().is_some_and(|name| name == ".yaml") {
        return wrong("a map needs a name before .yaml, such as hall.yaml");
    }
    if file.extension().is_none_or(|extension| extension != "yaml") {
        return wrong("the name of a map ends in .yaml");
    }
    let name = file.file_stem().and_then(|name| name.to_str());
    let Some(name) = name.filter(|name| !name.contains(char::is_control)) else {
        return wrong("the name of a map is plain text");
    };
    let folder = file.parent().unwrap_or(Path::new(""));
    let open = match Folder::open(folder) {
        // It is made when there is a map to put into it.
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok((folder, name)),
        open => open.map_err(|error| format!("the folder of {shown}: {error}"))?,
    };
    for ending in ["yaml", "pgm"] {
        let free = open.check_free(&format!("{name}.{ending}"), replace);
        free.map_err(|error| {
            let shown = printable(&file.with_extension(ending).to_string_lossy()).into_owned();
            format!("{shown} {error}; choose another name, or replace that map with --force")
        })?;
    }
    Ok((folder, name))
}

/// The map of the run as it is now, and its revision: a keyframe that was made since it was asked
/// for. The latched one is older.
fn current_map(root: Option<&Path>) -> Result<(StaticMap, Id), String> {
    let mut tap = Tap::join(root)?;
    let (mut keyframe, bells) =
        tap.open(|peer| Ok((peer.latest::<MapKeyframe>()?, Bells::open(peer)?)))?;
    let began_ns = now_ns();
    let began = Instant::now();
    let mut asked: Option<Instant> = None;
    let found = loop {
        if asked.is_none_or(|asked| asked.elapsed() > ASK_PAUSE) {
            bells.ring(Role::Mapping, EVENT_NEED_KEYFRAME);
            asked = Some(Instant::now());
        }
        keyframe.poll(tap.poll());
        if let Some(view) = keyframe.get()
            && view.header.stamps.published_ns >= began_ns
        {
            let mut replica = MapReplica::new();
            replica.keyframe(view.meta, view.items);
            break match replica.view() {
                Some(map) => Ok((StaticMap::of(&map), replica.revision())),
                None => Err("mapping sends a map with holes".to_owned()),
            };
        }
        // There are few places for keyframes.
        keyframe.release();
        if tap.peer().domain().is_orphaned() {
            break Err("the run has ended".to_owned());
        }
        if began.elapsed() > MAP_LIMIT {
            break Err(format!("mapping has sent no map within {MAP_LIMIT:?}"));
        }
        std::thread::sleep(PAUSE);
    };
    drop((keyframe, bells));
    tap.leave();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_no_map_can_have_are_told_apart() {
        let folder = tempfile::tempdir().expect("a folder");
        let good = folder.path().join("new/a map.yaml");
        let (missing, name) = place(&good, Replace::No).expect("a place");
        assert_eq!(
            (missing, name),
            (folder.path().join("new").as_path(), "a map")
        );
        for bad in ["hall", "hall.pgm", "/dev/null/hall.yaml", "..", ".yaml"] {
            assert!(place(Path::new(bad), Replace::No).is_err(), "{bad}");
        }
        let why = place(Path::new(".yaml"), Replace::No).expect_err("no name");
        assert!(why.contains("before .yaml"), "{why}");
        let why = place(Path::new("a\nb.yaml"), Replace::No).expect_err("no text");
        assert!(why.contains("a\\nb.yaml"), "{why}");
    }

    #[test]
    fn another_map_is_replaced_only_when_asked() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("hall.yaml");
        for taken in ["hall.yaml", "hall.pgm"] {
            let taken = folder.path().join(taken);
            std::fs::write(&taken, "mine").expect("written");
            let why = place(&file, Replace::No).expect_err("it is there");
            assert!(why.contains("--force"), "{why}");
            assert!(place(&file, Replace::Yes).is_ok());
            std::fs::remove_file(&taken).expect("removed");
        }
    }
}
