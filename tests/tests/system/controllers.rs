//! Every controller of the papers in the stack, by its key, in lockstep through the real processes: where
//! it arrives, and where its field keeps it, which is then the point of the scene.

use serde_json::Value;
use zeronav_local_planner::table::CONTROLLERS;
use zeronav_tests::{Zeronav, shipped};

/// Scenes: a post on the straight line, a U of one metre and one of four that no map shows.
const SCENES: [&str; 3] = ["symmetric_post", "u_trap_1m", "u_trap_4m"];

/// What becomes of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    Reached,
    /// In the minimum of its field until the time or the patience of the task ends.
    Caught,
}

use End::{Caught, Reached};

/// The papers' controllers with their ends in [`SCENES`].
const ENDS: &[(&str, [End; 3])] = &[
    // Fields towards the goal: nothing leads around a U.
    ("ju_apf", [Reached, Caught, Caught]),
    ("lwx_apf", [Reached, Caught, Caught]),
    ("zm_rep", [Reached, Caught, Caught]),
    ("zm_rv", [Reached, Caught, Caught]),
    // The path's points help past a small one.
    ("ju_fusion", [Reached, Reached, Caught]),
    // Escapes of three metres and more leave a small one, too.
    ("zm_esc", [Reached, Reached, Caught]),
    // Those that follow the path leave any.
    ("zm_full", [Reached, Reached, Reached]),
    ("ju_r6", [Reached, Reached, Reached]),
    ("ju_r7", [Reached, Reached, Reached]),
    ("lwx_oapf", [Reached, Reached, Reached]),
    ("lwx_iter", [Reached, Reached, Reached]),
    ("lwx_lsq", [Reached, Reached, Reached]),
    ("lwx_fusion", [Reached, Reached, Reached]),
    ("bao_dwa", [Reached, Reached, Reached]),
];

/// Time limit of a U that keeps a robot for ever: who gets out of one is at its goal by then. [s]
const KEPT_S: f64 = 45.0;

/// Drives these of the shipped files with a controller, each as `edit` leaves it: a row per scene.
fn drive(key: &str, files: &[&str], edit: impl Fn(String) -> String) -> Vec<Value> {
    let folder = tempfile::tempdir().expect("a folder");
    let scenes = folder.path().join("scenes");
    std::fs::create_dir(&scenes).expect("a folder");
    for name in files {
        let file = scenes.join(format!("{name}.toml"));
        std::fs::write(file, edit(shipped(name))).expect("written");
    }
    let arguments = ["suite", "scenes", "--controller", key, "--json"];
    let report = Zeronav::start_in(folder, &arguments).finish().expect(0);
    report["runs"].as_array().expect("runs").clone()
}

/// The row of a scene.
fn row<'a>(rows: &'a [Value], scene: &str) -> &'a Value {
    let found = rows.iter().find(|row| row["world"] == scene);
    found.unwrap_or_else(|| panic!("{scene} was not driven"))
}

#[test]
fn every_controller_of_the_papers_ends_its_scenes_as_it_should() {
    let of_papers = CONTROLLERS.iter().filter(|row| row.of_a_paper);
    for row in of_papers {
        assert!(
            ENDS.iter().any(|(key, _)| *key == row.key),
            "{} has no ends",
            row.key
        );
    }
    let mut faults = Vec::new();
    for (key, ends) in ENDS {
        let limit = format!("time_limit_s = {KEPT_S:?}");
        let is_kept = ends.contains(&Caught);
        let edit = |text: String| {
            if is_kept {
                text.replace("time_limit_s = 90.0", &limit)
            } else {
                text
            }
        };
        let rows = drive(key, &["symmetric_post", "u_trap"], edit);
        for (scene, end) in SCENES.iter().zip(ends) {
            let row = row(&rows, scene);
            let found = match row["outcome"].as_str() {
                Some("reached") => Some(Reached),
                Some("stuck" | "timeout") => Some(Caught),
                _ => None,
            };
            let told = format!(
                "{key} in {}: {} after {} s",
                row["world"], row["outcome"], row["time_s"]
            );
            eprintln!("{told}");
            if found != Some(*end) || row["contacts_moving"] != 0 || row["contacts_standing"] != 0 {
                faults.push(told);
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// A gain of a controller is a parameter. With half a step per cell it is stuck again and again; with one
/// it still creeps to the goal, as every path that it asks for gives it new steps.
#[test]
fn lwx_iter_gives_up_where_its_steps_are_too_few() {
    let config = "\n[services.local_planner.config]\npapers.lwx_iter.steps_per_m = 1.0\n";
    let end = |key: &str| {
        let rows = drive(key, &["symmetric_post"], |text| text + config);
        row(&rows, "symmetric_post")["outcome"].clone()
    };
    assert_ne!(end("lwx_iter"), "reached");
    // The same steps are no limit of `lwx_oapf`, which has its own.
    assert_eq!(end("lwx_oapf"), "reached");
}

/// A U that the map shows, and what mapping and global planner are told.
fn layers(planner: &str, options: &str, mapping: &str) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let text = format!(
        "title = \"Layers of the map\"\nbase = [\"porter\"]\nstart = [1.5, 4.0, 0.0]\n\
         [[goals]]\npose = [12.0, 4.0, 0.0]\n\
         [run]\ntime_limit_s = 40.0\n[expect]\noutcome = \"reached\"\n\
         [world]\narea_m = [[0.0, 0.0], [14.0, 8.0]]\nresolution_m = 0.05\nshapes = [\n\
         {{ kind = \"box\", centre_m = [7.5, 4.0], size_m = [0.2, 2.6] }},\n\
         {{ kind = \"box\", centre_m = [6.5, 5.2], size_m = [2.0, 0.2] }},\n\
         {{ kind = \"box\", centre_m = [6.5, 2.8], size_m = [2.0, 0.2] }},\n]\n\
         [services.global_planner.config]\nplanner = \"{planner}\"\n{options}\n\
         [services.mapping.config]\n{mapping}\n"
    );
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    Zeronav::start_in(folder, &arguments).finish().json()
}

/// How many samples of the driven track lie in the pocket of the U.
fn in_pocket(result: &Value) -> usize {
    let track: Vec<[f64; 2]> = serde_json::from_value(result["track_m"].clone()).expect("a track");
    let inside = |[x, y]: &[f64; 2]| (5.6..7.4).contains(x) && (3.0..5.0).contains(y);
    track.iter().filter(|at| inside(at)).count()
}

#[test]
fn the_walk_of_three_neighbours_drives_around_what_mapping_regularised() {
    let plain = layers("tn_3n", "", "");
    assert!(in_pocket(&plain) > 20, "{}", in_pocket(&plain));
    let regularised = layers("tn_3n", "", "regularisation.enabled = true");
    assert_eq!(regularised["outcome"], "reached");
    assert_eq!(
        (in_pocket(&regularised), regularised["contacts"].as_u64()),
        (0, Some(0))
    );
    // The default planner's row does not say that it honours the layer: the same drive.
    let other = |mapping| layers("mpgaa", "", mapping)["track_m"].clone();
    assert_eq!(other(""), other("regularisation.enabled = true"));
}

#[test]
fn full_inflation_keeps_clear_of_the_virtual_obstacles_of_mapping() {
    let clearance_m = |mapping| {
        let result = layers("bao_full", "options.cost_weight = 0.0", mapping);
        assert_eq!(result["outcome"], "reached", "{mapping}");
        let plan = &result["plans"][0];
        assert_eq!(plan["collides"], false);
        plan["clearance_m_min"].as_f64().expect("a clearance")
    };
    // A ring of eight cells is a tenth of a metre wider than what inflation blocks anyway.
    let (plain, ring) = (
        clearance_m(""),
        clearance_m("virtual_obstacles = { kind = \"ring\", radius_cells = 8 }"),
    );
    assert!((0.05..0.15).contains(&plain), "{plain}");
    assert!((plain + 0.05..0.3).contains(&ring), "{ring}");
}
