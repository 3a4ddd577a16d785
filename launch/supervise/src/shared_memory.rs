//! How much shared memory the topics of a run reserve, and how much they use.

use std::fs::{DirEntry, Metadata};
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use zeronav_msgs::map::{GROWING_TILES_MAX, tiles_of};
use zeronav_msgs::topics::{MapKeyframe, RobotScan, SPANS, Topic, topics};
use zeronav_scenario::Scenario;
use zeronav_shell::Domain;
use zeronav_shell::memory::SHM;
use zeronav_world::World;

/// Shared memory that the stack will reserve. [bytes]
#[must_use]
pub fn planned_bytes(scenario: &Scenario, world: &World) -> u64 {
    let (columns, rows) = tiles_of(world.geometry());
    let tiles = keyframe_tiles(scenario, columns as usize * rows as usize);
    topics_bytes(tiles, scenario.robot.lidar.n_beams as usize)
}

/// Shared memory of a stack whose map may grow, with the largest scans. [bytes]
#[must_use]
pub fn most_bytes() -> u64 {
    topics_bytes(GROWING_TILES_MAX, RobotScan::ROW.len_max)
}

/// Shared memory of all topics, with keyframes of `tiles` and scans of `n_beams`. [bytes]
fn topics_bytes(tiles: usize, n_beams: usize) -> u64 {
    let bytes = topics().into_iter().map(|row| {
        let len = if row.number == MapKeyframe::ROW.number {
            tiles
        } else if row.number == RobotScan::ROW.number {
            n_beams
        } else {
            row.len_max
        };
        let writers = if row.number == SPANS.number {
            row.writers.len()
        } else {
            1
        };
        (row.segment_bytes(len) * writers) as u64
    });
    bytes.sum()
}

/// Shared memory that a domain has reserved or used. [bytes]
pub fn used_bytes(domain: &Domain) -> u64 {
    let files = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten();
    let of_domain = |entry: &DirEntry| {
        let name = entry.file_name();
        name.to_str()
            .is_some_and(|name| name.starts_with(domain.prefix()))
    };
    files(Path::new(SHM))
        .filter(of_domain)
        .chain(files(domain.root()))
        .filter_map(|entry| entry.metadata().ok())
        .filter(Metadata::is_file)
        .map(|meta| meta.blocks() * 512)
        .sum()
}

/// Most tiles that the keyframe of a world of `tiles` will ever have: a map that grows takes the
/// memory of its largest at once.
fn keyframe_tiles(scenario: &Scenario, tiles: usize) -> usize {
    let window = scenario.services.mapping.config.get("window");
    let word = |name| window.and_then(|window| window.get(name));
    if word("mode").and_then(toml::Value::as_str) != Some("growing") {
        return tiles;
    }
    let most = word("tiles_max").and_then(toml::Value::as_integer);
    tiles.max(most.map_or(GROWING_TILES_MAX, |most| usize::try_from(most).unwrap_or(0)))
}
