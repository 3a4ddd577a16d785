//! The picture of the live page that the READMEs show.

use super::client::Viewer;
use super::{on_screen, shown};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;
use std::path::Path;
use zeronav_tests::up::Up;

/// Writes it again: `cargo test --workspace --test system viewer::picture -- --ignored`.
#[test]
#[ignore = "writes services/viewer/live_page.webp"]
fn picture_of_the_page() {
    let up = Up::start(&["open_aisle"]);
    let viewer = Viewer::start(&up.root, &[]);
    let mut browser = shown(&viewer);
    let goal = on_screen(&mut browser, 26.0, 8.5);
    browser.click(goal);
    browser.wait_until(
        "the robot drives",
        "zeronavPage.scene.at(Infinity).robot[0] > 5",
    );
    let from = on_screen(&mut browser, 15.0, 5.7);
    let to = on_screen(&mut browser, 15.4, 7.2);
    browser.shift_drag(from, to);
    browser.wait_until(
        "its new path leads around the obstacle",
        "document.querySelectorAll('#replanning b').length",
    );
    browser.wait_until(
        "nothing is said any more",
        "document.getElementById('said').hidden",
    );
    let format = json!({ "format": "webp", "quality": 82 });
    let shot = browser.call("Page.captureScreenshot", format);
    let picture = STANDARD.decode(shot["data"].as_str().expect("a picture"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let file = root.join("services/viewer/live_page.webp");
    std::fs::write(file, picture.expect("base64")).expect("written");
    up.down();
}
