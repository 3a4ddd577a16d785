//! Nothing is allocated per scan.

#![allow(unsafe_code, reason = "a counting allocator")]

mod support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};
use support::{Room, config, description};
use zeronav_mapping::localiser::CorrectionMode;
use zeronav_mapping::{Mapping, Observation};
use zeronav_msgs::obstacles::Obstacle;

struct Counting;

static COUNT: AtomicUsize = AtomicUsize::new(0);

// SAFETY: everything is the system allocator's work, only counted.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promises are passed on.
        unsafe { System.realloc(pointer, layout, new_size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// A robot that drives a circle past a box that comes and goes, with tracking and pose correction
/// on: after the first round no scan allocates.
#[test]
fn no_scan_allocates_once_they_repeat_themselves() {
    let room = Room::walled(400, 400, 3);
    let mut with_box = room.clone();
    with_box.fill(240, 200, 250, 210, true);
    let mut config = config(&room);
    config.pose_correction.mode = CorrectionMode::On;
    let mut mapping =
        Mapping::new(&config, Some(&room.as_static_map()), &description(), &[]).unwrap();
    let mut tiles = Vec::with_capacity(1000);
    let mut obstacles: Vec<Obstacle> = Vec::with_capacity(200);
    let mut worst = 0;
    for n in 0..400_u64 {
        #[allow(clippy::cast_precision_loss, reason = "a few hundred")]
        let angle = 0.05 * n as f64;
        let from = room.pose(
            200.0 + 20.0 * angle.cos(),
            180.0 + 20.0 * angle.sin(),
            angle,
        );
        let seen = if n % 20 < 10 { &room } else { &with_box };
        let (scan, ranges) = seen.scan(&from);
        let before = COUNT.load(Ordering::Relaxed);
        mapping.take_in(&Observation {
            scan: &scan,
            ranges: &ranges,
            run_ns: n * 100_000_000,
            odom_from_base_first: from,
            odom_from_base: from,
            odometry_variance: [0.01; 3],
            goal: None,
        });
        tiles.clear();
        mapping.mapper_mut().take_dirty_tiles(&mut tiles);
        obstacles.clear();
        obstacles.extend(mapping.obstacles());
        let allocated = COUNT.load(Ordering::Relaxed) - before;
        if n >= 200 {
            worst = worst.max(allocated);
        }
    }
    assert_eq!(worst, 0, "allocations in one scan");
}
