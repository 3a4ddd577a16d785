//! A run whose launch does not answer: it is listed as such, and `zeronav down` ends it.

use rustix::process::Signal;
use serde_json::Value;
use std::path::{Path, PathBuf};
use zeronav_tests::up::Up;
use zeronav_tests::{leftovers, real_time_turn, zeronav};

#[test]
fn a_run_whose_launch_is_stopped_is_listed_and_ended() {
    let _turn = real_time_turn();
    let up = Up::start(&["open_aisle"]);
    let pid = up.stack.pid().to_string();
    up.stack.signal(Signal::STOP);

    let listed = zeronav(&["ps", "--json"]).expect(0);
    let runs = listed["runs"].as_array().expect("a list");
    let of_domain = |run: &&Value| run["domain"] == up.root.as_str();
    let run = runs.iter().find(of_domain).expect("it is listed");
    assert_eq!(run["pid"].to_string(), pid, "{run}");
    assert_eq!(run["silent"], "no answer within 5 s", "{run}");
    let listed = zeronav(&["ps"]).stdout;
    let line = listed.lines().find(|line| line.contains(&up.root));
    let line = line.expect(&listed);
    let way_out = format!("`zeronav down --domain {}` ends it", up.root);
    for said in ["does not answer", &format!("pid {pid}"), &way_out] {
        assert!(line.contains(said), "{line}");
    }

    // A request says the same, and changes nothing.
    let refused = up.ask(&["status"], 2);
    for said in ["no answer within 5 s", &pid, "`zeronav down` ends it"] {
        assert!(refused.contains(said), "{refused}");
    }

    let said = up.ask(&["down"], 0);
    assert!(said.contains("is down, ended by SIGTERM"), "{said}");
    let result = up.stack.finish().expect(130);
    assert_eq!(result["outcome"], "interrupted", "{result:#}");
    assert_eq!(leftovers(Path::new(&up.root)), Vec::<PathBuf>::new());
}
