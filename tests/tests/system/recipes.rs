//! The recipes of CONTRIBUTING, walked in a copy of the source tree: the files that they list and the
//! command that they name suffice.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Output;
use tempfile::TempDir;
use zeronav_tests::{background, binaries, workspace};

/// An edit of a recipe: the file, the line in front of which the text is put (none: a new file), and
/// the text.
type Edit = (&'static str, Option<&'static str>, &'static str);

const PLANNER: &[Edit] = &[
    (
        "services/global_planner/src/renamed.rs",
        None,
        "//! `renamed`: A* over costs under another name.\n\n\
         use crate::astar::CAstar;\n\
         use crate::planner::{CellPath, Control, Expansions, GlobalPlanner, PlanError, PlanQuery, PlanStats};\n\n\
         pub(crate) struct Renamed(pub(crate) CAstar);\n\n\
         impl GlobalPlanner for Renamed {\n\
             fn plan(\n\
                 &mut self,\n\
                 query: &PlanQuery<'_>,\n\
                 budget: &mut dyn FnMut(Expansions) -> Control,\n\
                 path: &mut CellPath,\n\
             ) -> Result<PlanStats, PlanError> {\n\
                 self.0.plan(query, budget, path)\n\
             }\n\
         }\n",
    ),
    (
        "services/global_planner/src/lib.rs",
        Some("mod replan;"),
        "mod renamed;\n",
    ),
    (
        "services/global_planner/src/table.rs",
        Some("    PlannerRow {"),
        "    PlannerRow {\n\
         key: \"renamed\",\n\
         title: \"A* over costs\",\n\
         source: \"a recipe\",\n\
         complete: true,\n\
         build: |options| Box::new(crate::renamed::Renamed(CAstar::new(options.map()))),\n\
         },\n",
    ),
    (
        "services/global_planner/README.md",
        Some("| `c_astar`"),
        "| `renamed` | – | A* over costs | yes |\n",
    ),
];

const CONTROLLER: &[Edit] = &[
    (
        "services/local_planner/src/creep.rs",
        None,
        "//! `creep`: straight towards the local goal, slowly.\n\n\
         use crate::dwa::options::DwaConfig;\n\
         use crate::pilot::Pilot;\n\
         use crate::pilot::perception::Tracks;\n\
         use crate::pilot::scene::{Choose, ControlOutput, Scene};\n\
         use zeronav_motion::Twist;\n\n\
         #[derive(Debug)]\n\
         struct Creep;\n\n\
         pub(crate) fn creep(config: DwaConfig) -> Pilot {\n\
             Pilot::new(config, Tracks::Ignored, Box::new(Creep))\n\
         }\n\n\
         impl Choose for Creep {\n\
             fn choose(&mut self, scene: &mut Scene<'_>) -> ControlOutput {\n\
                 match scene.heading() {\n\
                     Ok(heading) => scene.steer_or_rest(Some(Twist {\n\
                         v_mps: heading.fastest_mps.min(0.05),\n\
                         w_radps: heading.to_goal.y,\n\
                     })),\n\
                     Err(turn) => turn,\n\
                 }\n\
             }\n\
         }\n",
    ),
    (
        "services/local_planner/src/lib.rs",
        Some("pub mod dwa;"),
        "mod creep;\n",
    ),
    (
        "services/local_planner/src/table.rs",
        Some("    ControllerRow {"),
        "    ControllerRow {\n\
         key: \"creep\",\n\
         title: \"Straight towards the local goal\",\n\
         source: \"a recipe\",\n\
         of_a_paper: false,\n\
         build: |config| crate::creep::creep(config.dwa).shaped(config.shaping),\n\
         },\n",
    ),
    (
        "services/local_planner/README.md",
        Some("| `dwa` | dynamic window"),
        "| `creep` | straight towards the local goal | a recipe |\n",
    ),
];

const TOPIC: &[Edit] = &[
    (
        "msgs/src/battery.rs",
        None,
        "//! `robot/battery`: what is left in the battery.\n\n\
         use crate::message;\n\
         use crate::message::{Refusal, ZeroCopySend, number};\n\n\
         message! {\n\
             /// The state of the battery.\n\
             pub struct Battery = \"zeronav.Battery.v1\" {\n\
                 /// [1] 0 to 1.\n\
                 pub charge: f64,\n\
             }\n\
         }\n\n\
         impl Battery {\n\
             /// Accepts shares.\n\
             ///\n\
             /// # Errors\n\
             /// The charge, when it is none.\n\
             pub fn check(&self) -> Result<(), Refusal> {\n\
                 number(self.charge, 0.0, 1.0, \"charge\")\n\
             }\n\
         }\n",
    ),
    (
        "msgs/src/lib.rs",
        Some("pub mod certainty;"),
        "pub mod battery;\n",
    ),
    (
        "msgs/src/topics.rs",
        Some("    /// `health/<role>`"),
        "/// `robot/battery`: what is left in the battery.\n\
         RobotBattery = 28 \"robot/battery\" {\n\
             envelope: BatteryEnvelope = \"zeronav.robot.battery.v1\" (crate::battery::Battery),\n\
             item: u8, Latest,\n\
             writers: [Robot], rings: [], in_lockstep: [],\n\
             len_max: 1,\n\
             check: |meta, items| { no_items(items)?; meta.check() },\n\
         }\n",
    ),
];

/// Where the line of the new topic goes in the golden layout.
const LAYOUT: (&str, &str) = ("msgs/tests/layout.rs", "    (\"health/robot\"");

/// The files that the recipe under this heading names.
fn listed(contributing: &str, heading: &str) -> BTreeSet<String> {
    let section = contributing
        .split("\n## ")
        .find(|section| section.starts_with(heading));
    let section = section.unwrap_or_else(|| panic!("no section {heading:?}"));
    let names = section.split('`').skip(1).step_by(2);
    names
        .filter(|name| name.contains('/') && !name.contains(' '))
        .map(str::to_owned)
        .collect()
}

/// Edits the copy as a recipe says.
fn walk(copy: &Path, edits: &[Edit]) {
    for (file, line, text) in edits {
        match line {
            None => std::fs::write(copy.join(file), text).expect("written"),
            Some(line) => put_before(copy, file, line, text),
        }
    }
}

fn put_before(copy: &Path, file: &str, line: &str, text: &str) {
    let path = copy.join(file);
    let old = std::fs::read_to_string(&path).expect("it is read");
    let at = old
        .find(&format!("\n{line}"))
        .unwrap_or_else(|| panic!("no {line:?} in {file}"));
    let (before, after) = old.split_at(at + 1);
    std::fs::write(&path, [before, text, after].concat()).expect("written");
}

/// A copy of the source tree without what is built.
fn copy() -> TempDir {
    let copy = tempfile::tempdir().expect("a folder");
    let sources = [
        "Cargo.toml",
        "Cargo.lock",
        "CONTRIBUTING.md",
        "msgs",
        "services",
        "launch",
        "tests",
    ];
    let status = background("cp")
        .arg("-r")
        .args(sources.map(|name| workspace().join(name)))
        .arg(copy.path())
        .status();
    assert!(
        status.expect("it starts").success(),
        "the sources are not copied"
    );
    copy
}

/// Where the copy is built, which stays for the next time.
fn target() -> PathBuf {
    binaries().join("recipes")
}

/// Runs cargo in the copy.
fn cargo(copy: &Path, verb: &str, arguments: &[&str]) -> Output {
    background(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args([verb, "--locked", "--target-dir"])
        .arg(target())
        .args(arguments)
        .envs([
            ("CARGO_PROFILE_DEV_OPT_LEVEL", "0"),
            ("CARGO_PROFILE_TEST_OPT_LEVEL", "0"),
            ("CARGO_PROFILE_DEV_DEBUG", "none"),
            ("CARGO_NET_OFFLINE", "true"),
        ])
        .current_dir(copy)
        .output()
        .expect("it starts")
}

fn text(output: &Output) -> String {
    let [out, error] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    format!("{out}{error}")
}

#[test]
fn the_files_that_a_recipe_lists_and_its_command_suffice() {
    let copy = copy();
    let copy = copy.path();
    let contributing = std::fs::read_to_string(copy.join("CONTRIBUTING.md")).expect("it is read");
    for (heading, edits) in [
        ("Add a planner", PLANNER),
        ("Add a controller", CONTROLLER),
        ("Add a topic", TOPIC),
    ] {
        walk(copy, edits);
        let listed = listed(&contributing, heading);
        for (file, line, _) in edits {
            let folder = Path::new(file).parent().expect("a folder");
            let is_listed = listed.iter().any(|name| match line {
                Some(_) => name == file,
                None => Path::new(name).parent() == Some(folder) || Path::new(name) == folder,
            });
            assert!(is_listed, "{heading} does not list {file}: {listed:?}");
        }
    }
    let seams = [
        "-p=zeronav-msgs",
        "-p=zeronav-global-planner",
        "-p=zeronav-local-planner",
    ];
    let arguments = [&seams[..], &["--no-default-features", "--test=layout"]].concat();

    // The line of the layout is the one that its test prints.
    let output = cargo(copy, "test", &arguments);
    let said = text(&output);
    let line = said.lines().find(|line| line.contains("robot/battery"));
    let line = line.unwrap_or_else(|| panic!("the layout's test prints no line:\n{said}"));
    put_before(copy, LAYOUT.0, LAYOUT.1, &format!("{line}\n"));
    assert!(listed(&contributing, "Add a topic").contains(LAYOUT.0));
    let output = cargo(copy, "test", &arguments);
    assert!(output.status.success(), "{}", text(&output));

    // What the command of the recipe runs for the contract; the rest of it takes the whole workspace.
    // The tables are compiled; what their tests say of a new row is theirs to say.
    let built = ["--no-default-features", "--lib", "--example=bindings"];
    let arguments = [&seams[..], &built].concat();
    let output = cargo(copy, "build", &arguments);
    assert!(output.status.success(), "{}", text(&output));
    let bindings = background(target().join("debug/examples/bindings")).status();
    assert!(bindings.expect("it starts").success());
    for file in [
        "services/python/zeronav/contract.py",
        "services/cpp/zeronav.hpp",
    ] {
        let bindings = std::fs::read_to_string(copy.join(file)).expect("it is read");
        assert!(bindings.contains("robot/battery"), "{file} lacks the topic");
    }
}
