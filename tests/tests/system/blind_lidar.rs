//! A lidar that sees nothing any more where there is something, in lockstep.

use serde_json::Value;
use zeronav_tests::Zeronav;

/// Crosses the hall with a lidar that shows nothing for a while; a box comes into the way meanwhile.
fn blind(lasts_s: f64, looks: &str) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let text = format!(
        r#"
        title = "No beam comes back"
        base = ["hall", "porter"]
        start = [1.5, 4.0, 0.0]

        [run]
        time_limit_s = 60.0

        [[goals]]
        pose = [8.5, 4.0, 0.0]

        [[world.obstacles]]
        name = "box"
        shape = {{ kind = "box", centre_m = [5.5, 4.0], size_m = [0.5, 1.5] }}
        appears = {{ robot_near = {{ point_m = [3.0, 4.0], distance_m = 0.4 }} }}

        [[robot.faults]]
        kind = "lidar_blackout"
        begins = {{ driven_m = 1.0 }}
        lasts_s = {lasts_s}
        looks = "{looks}"

        [expect]
        outcome = "reached"
        contacts_max = 0
        "#
    );
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = ["run", "./it.toml", "--lockstep", "--headless", "--json"];
    Zeronav::start_in(folder, &arguments).finish().expect(0)
}

#[test]
fn a_robot_whose_beams_come_back_from_nothing_stops_and_goes_on_afterwards() {
    for lasts_s in [1.0, 10.0] {
        for looks in ["no_return", "invalid"] {
            let result = blind(lasts_s, looks);
            assert_eq!(result["verdict"], "pass", "{looks}: {result:#}");
            let stale = &result["interventions_by_reason"]["scan_stale"];
            assert!(stale.as_u64() >= Some(1), "{looks}: {result:#}");
            // It stood for most of the time.
            let motion: Vec<[f64; 6]> =
                serde_json::from_value(result["motion"].clone()).expect("rows of six numbers");
            let standing = motion.iter().skip(20).filter(|row| row[4].abs() < 0.01);
            let standing_s = 0.1 * f64::from(u32::try_from(standing.count()).expect("a few"));
            assert!(standing_s > lasts_s - 0.8, "{looks}: {standing_s} s");
        }
    }
}
