use crate::every_field::{OTHERS, documents};
use std::path::{Path, PathBuf};
use toml::Table;

/// The checked-in schema; a test of the whole system keeps it current.
struct Form {
    schemas: boon::Schemas,
    root: boon::SchemaIndex,
}

impl Form {
    fn new() -> Self {
        const NAME: &str = "scenario.schema.json";
        let schema = serde_json::from_str(include_str!("../../../scenario.schema.json")).unwrap();
        let mut schemas = boon::Schemas::new();
        let mut compiler = boon::Compiler::new();
        compiler.add_resource(NAME, schema).unwrap();
        let root = compiler.compile(NAME, &mut schemas).unwrap();
        Self { schemas, root }
    }

    /// What is wrong with a document; nothing when it is valid.
    fn complaints(&self, document: &impl serde::Serialize) -> Option<String> {
        let document = serde_json::to_value(document).unwrap();
        let outcome = self.schemas.validate(&document, self.root);
        outcome.err().map(|problem| problem.to_string())
    }
}

/// All files `*.toml` below `folder`.
fn toml_files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let of = |path: PathBuf| {
        if path.is_dir() {
            toml_files(&path)
        } else {
            vec![path]
        }
    };
    let mut files: Vec<_> = paths.flat_map(of).collect();
    files.retain(|file| {
        file.extension()
            .is_some_and(|extension| extension == "toml")
    });
    files
}

#[test]
fn every_document_has_the_form_of_the_schema() {
    let form = Form::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut n_files = 0;
    for folder in ["../scenarios", "../worlds", "../../tests/scenarios"] {
        for file in toml_files(&root.join(folder)) {
            let document: Table = std::fs::read_to_string(&file).unwrap().parse().unwrap();
            assert_eq!(form.complaints(&document), None, "{}", file.display());
            n_files += 1;
        }
    }
    assert!(n_files > 30, "only {n_files} files");
    for document in documents() {
        assert_eq!(form.complaints(&document), None, "{document}");
    }
}

#[test]
fn the_schema_rejects_unknown_fields_and_numbers_out_of_range() {
    let form = Form::new();
    let good: Table = OTHERS[0].parse().unwrap();
    assert_eq!(form.complaints(&good), None);
    let stock = "[services.local_planner]\nconfig.dwa.horizon_s = 2.0";
    assert_eq!(form.complaints(&stock.parse::<Table>().unwrap()), None);
    for wrong in [
        "titel = 'x'",
        "run.tick_hz = 0.5",
        "run.seed = -1",
        "restart.per_runs = 1",
        "robot.preset = 'roomba'",
        "robot.v_mps_max = 2000.0",
        "robot.lidar.n_beams = 1",
        "robot.slip.forward_ratio = 0.95",
        "start = [0.0, 0.0]",
        "goals = [{ tolerance_m = 0.1 }]",
        "world.shapes = [{ kind = 'box', radius_m = 1.0 }]",
        "world.shapes = [{ kind = 'disc', centre_m = [0.0, 0.0], radius_m = 0.0 }]",
        "world.resolution_m = 0.0",
        "world.pedestrians = { file = 'scene.csv', radius_m = 20.0 }",
        "world.obstacles = [{ name = 'cart', shape = { kind = 'disc', centre_m = [0.0, 0.0], \
         radius_m = 0.3 }, speed_mps = -1.0 }]",
        "faults = [{ kind = 'kill', service = 'robot', begins = { at_s = 1.0 } }]",
        "faults = [{ kind = 'kill', service = 'mapping' }]",
        "faults = [{ kind = 'drop', topic = 'run/clock', share = 0.5, begins = { at_s = 1.0 } }]",
        "faults = [{ kind = 'drop', topic = 'plan/path', share = 1.5, begins = { at_s = 1.0 } }]",
        "faults = [{ kind = 'clock', service = 'mapping', by_ms = 2e4, begins = { at_s = 1.0 } }]",
        "faults = [{ kind = 'disk_full', service = 'mapping', begins = { at_s = 1.0 } }]",
        "expect.outcome = 'reaches'",
        "services.mapping.config.resolution_m = 0.0",
        "services.local_planner.config.dwa.horizon = 2.0",
        "services.local_planner.config.controller = 'no_controller'",
        "services.global_planner.config.planner = 'no_planner'",
        "services.collision_guard.config.slow_mps = 1000.0",
        "variants.fast.robot.v_mps_max = 2000.0",
    ] {
        let document: Table = wrong.parse().unwrap();
        assert_ne!(form.complaints(&document), None, "{wrong} was accepted");
    }
}
