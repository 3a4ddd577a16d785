//! What a recording holds besides the topics of the contract.

use super::{info, n, read_by_others, recording_of};
use std::path::Path;
use zeronav_msgs::Role;
use zeronav_msgs::user::Form;
use zeronav_shell::{Domain, Draft, Peer};
use zeronav_tests::up::Up;
use zeronav_tests::zeronav;

#[test]
fn topics_of_users_logs_parameters_and_reasons_are_recorded() {
    let own = tempfile::tempdir().expect("a folder");
    let file = own.path().join("it.mcap");
    let record = format!("--record={}", file.display());
    let mut stack = Up::start(&["open_aisle", "--lockstep", &record]);
    stack.ask(&["pause"], 0);
    let form = Form::new("distance_m: f64, n: u16").expect("a form");
    let domain = Domain::join(Path::new(&stack.root)).expect("the domain");
    let peer = Peer::join(domain, Role::Tap, 1).expect("a place");
    let mut writer = peer.user_writer("nearest", &form, 64).expect("a writer");
    stack
        .stack
        .wait_until("the recorder reads it", |_| writer.is_read());
    for k in 0_u16..3 {
        let bytes = [&f64::from(k).to_le_bytes()[..], &(7 * k).to_le_bytes()].concat();
        assert!(writer.publish(&Draft::default(), &bytes).is_some());
    }
    stack.ask(&["step", "30"], 0);
    drop(writer);
    drop(peer);
    stack.down();

    let found = info(&file, 0);
    assert_eq!(found["valid"], true, "{found:#}");
    let verdict = &found["metadata"]["zeronav"];
    assert_eq!(n(&verdict["user/nearest.messages"]), 3, "{verdict:#}");
    assert_eq!(verdict["outcome"], "down");
    let parameters = &found["metadata"]["zeronav.parameters.local_planner"];
    assert!(parameters["controller"].is_string(), "{parameters:#}");
    assert_eq!(found["metadata"]["zeronav.start"]["driven_by"], "clients");

    let tables = own.path().join("tables");
    let arguments = [
        "bag",
        "export",
        &file.display().to_string(),
        "--csv",
        &tables.display().to_string(),
        "--topic",
        "user/nearest",
    ];
    assert_eq!(zeronav(&arguments).code(), 0);
    let table = std::fs::read_to_string(tables.join("user-nearest.items.csv")).expect("a table");
    assert_eq!(
        table,
        "message,item,distance_m,n\n0,0,0,0\n1,0,1,7\n2,0,2,14\n"
    );

    assert_eq!(played_again(&file, own.path()), table);

    let read = read_by_others(&file);
    let logs = read["rosout"].as_array().expect("logs");
    let of = |name: &str| logs.iter().filter(|it| it["name"] == name).count();
    assert!(of("launch") > 0 && of("mapping") > 0, "{logs:#?}");
    let reasons = read["why"].as_array().expect("reasons");
    let guard = reasons.iter().find(|it| it["name"] == "collision_guard");
    assert!(
        guard.is_some_and(|it| it["msg"].is_string()),
        "{reasons:#?}"
    );
}

/// The table of the topic of a user in the recording of an open loop to which `file` is played, as it was sent.
fn played_again(file: &Path, own: &Path) -> String {
    let replay = ["replay", &file.display().to_string(), "--open", "mapping"];
    let played = zeronav(&replay);
    // A run that ended before its first scan has nothing of mapping to compare.
    let is_played = [0, 1].contains(&played.code());
    assert!(is_played, "{}{}", played.stdout, played.stderr);
    let again = recording_of(played.folder.path()).display().to_string();
    let check = zeronav(&["bag", "check", &again]);
    assert_eq!(check.code(), 0, "{}", check.stderr);
    let tables = own.join("again");
    let folder = tables.display().to_string();
    let export = [
        "bag",
        "export",
        &again,
        "--csv",
        &folder,
        "--topic",
        "user/nearest",
    ];
    assert_eq!(zeronav(&export).code(), 0);
    std::fs::read_to_string(tables.join("user-nearest.items.csv")).expect("a table")
}
