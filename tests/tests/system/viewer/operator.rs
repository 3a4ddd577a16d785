//! What an operator does on the live page, and what the page says of it.

use super::client::Viewer;
use super::{on_screen, shown};
use rustix::process::Signal;
use serde_json::{Value, json};
use zeronav_tests::browser::Browser;
use zeronav_tests::up::Up;
use zeronav_tests::{await_by_itself, send_signal};

/// Events of the page whose text has all of `words`.
fn n_events(words: &[&str]) -> String {
    let has: Vec<String> = words
        .iter()
        .map(|word| format!("line.textContent.includes({word:?})"))
        .collect();
    format!(
        "[...document.querySelectorAll('#events li')].filter((line) => {}).length",
        has.join(" && ")
    )
}

fn press(browser: &mut Browser, id: &str) {
    browser.script(&format!("document.getElementById({id:?}).click()"));
}

fn choose(browser: &mut Browser, pace: &str) {
    browser.script(&format!(
        "(() => {{ const pace = document.getElementById('pace'); pace.value = {pace:?}; \
         pace.dispatchEvent(new Event('change')); }})()"
    ));
    let said = "document.getElementById('said').textContent === 'speed set'";
    browser.wait_until("the pace is set", said);
}

/// In lockstep, too, the page shows that run time is held, lets ticks pass and lets it go on.
fn holds_and_steps(browser: &mut Browser, up: &Up) {
    press(browser, "pause");
    let words = "document.getElementById('pause').textContent";
    browser.wait_until("run time is held", &format!("{words} === 'Resume'"));
    browser.wait_until(
        "the page says so",
        "document.getElementById('link').textContent === 'paused' \
         && !document.getElementById('steps').hidden",
    );
    let before = up.status();
    assert_eq!(before["paused"], true, "{before}");
    let tick = |report: &Value| report["tick"].as_u64().expect("a tick");
    press(browser, "step");
    await_by_itself("ten ticks have passed", || {
        tick(&up.status()) == tick(&before) + 10
    });
    press(browser, "pause");
    browser.wait_until("run time goes on", &format!("{words} === 'Pause'"));
    await_by_itself("more ticks pass", || {
        tick(&up.status()) > tick(&before) + 10
    });
}

#[test]
fn a_drag_gives_the_yaw_a_shift_click_queues_and_lockstep_is_held_and_stepped() {
    let up = Up::start(&["open_aisle", "--lockstep"]);
    let viewer = Viewer::start(&up.root, &[]);
    let mut browser = shown(&viewer);
    holds_and_steps(&mut browser, &up);

    // Slow enough that the robot is still on its way when the next goal is sent.
    choose(&mut browser, "0.1");
    let from = on_screen(&mut browser, 24.0, 8.0);
    let to = on_screen(&mut browser, 24.0, 10.0);
    browser.drag(from, to);
    // Up the page is +y: a quarter turn. One pixel is some centimetres here.
    browser.wait_until(
        "the goal has the yaw of the drag",
        "zeronavPage.scene.at(Infinity).goals?.some(([x, y, yaw]) => \
         Math.abs(x - 24) < 0.2 && Math.abs(y - 8) < 0.2 && Math.abs(yaw - Math.PI / 2) < 0.05)",
    );
    assert_eq!(up.status()["goals_waiting"], 0);
    let next = on_screen(&mut browser, 26.0, 8.5);
    browser.shift_click(next);
    await_by_itself("the next goal waits", || up.status()["goals_waiting"] == 1);
    let goal = up.status()["goal"].clone();
    assert_eq!(goal["outcome"], "active", "the first one stays: {goal}");

    // A pose estimate: where the robot is, and which way it looks.
    browser.script("document.querySelector('[data-tool=pose]').click()");
    let estimate = up.status()["estimate"].clone();
    let [x_m, y_m] = [0, 1].map(|at| estimate[at].as_f64().expect("an estimate"));
    let from = on_screen(&mut browser, x_m, y_m);
    let to = on_screen(&mut browser, x_m + 2.0, y_m);
    browser.drag(from, to);
    browser.wait_until(
        "the estimate is sent",
        "document.getElementById('said').textContent === 'pose estimate sent'",
    );
    assert_eq!(browser.problems, Vec::<String>::new());
    up.down();
    assert_eq!(viewer.code(), Some(0));
}

#[test]
fn the_page_tells_each_end_of_a_swap() {
    let up = Up::start(&["open_aisle", "--lockstep"]);
    let viewer = Viewer::start(&up.root, &[]);
    let mut browser = shown(&viewer);
    press(&mut browser, "seat-mapping");
    browser.script("document.querySelector('[data-act=swap]').click()");
    let told = |words: &[&str]| format!("{} === 1", n_events(words));
    let done = ["of mapping: done, the newcomer has the seat"];
    browser.wait_until("a swap of the page is done", &told(&done));
    assert_eq!(
        browser.script(&n_events(&["of mapping: accepted"])),
        1,
        "its beginning is told once"
    );
    // Those of others are told, too: one that was rolled back, and one that was rejected.
    let liar = ["swap", "local_planner", "nan_once_obeyed"];
    up.ask(
        &[&liar[..], &["--shadow", "0s", "--keep", "30s"]].concat(),
        1,
    );
    let back = ["of local planner: rolled back: "];
    browser.wait_until("a swap of others is rolled back", &told(&back));
    up.ask(&["swap", "global_planner", "stays_silent"], 1);
    let rejected = ["of global planner: rejected: "];
    browser.wait_until("a swap of others is rejected", &told(&rejected));
    assert_eq!(browser.problems, Vec::<String>::new());
    up.down();
    assert_eq!(viewer.code(), Some(0));
}

#[test]
fn the_driven_line_has_gaps_where_it_was_not_seen_and_a_phone_shows_everything() {
    let up = Up::start(&["open_aisle", "--lockstep"]);
    let viewer = Viewer::start(&up.root, &[]);
    let mut browser = shown(&viewer);
    choose(&mut browser, "1");
    let part = "zeronavPage.scene.at(Infinity).part";
    browser.wait_until("frames come", "zeronavPage.scene.states.length > 3");
    assert_eq!(browser.script(part), 0, "nothing was missed yet");
    let pid = viewer.process.id();
    assert!(send_signal(pid, Signal::STOP));
    let time_s = |up: &Up| up.status()["time_s"].as_f64().expect("a time");
    let since_s = time_s(&up);
    await_by_itself("two seconds were not seen", || time_s(&up) > since_s + 2.0);
    assert!(send_signal(pid, Signal::CONT));
    browser.wait_until("the line goes on as another part", &format!("{part} === 1"));

    let phone = json!({ "width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": true });
    browser.call("Emulation.setDeviceMetricsOverride", phone);
    browser.wait_until("it is narrow", "innerWidth === 390");
    // On the screen and of some size; the line of the reason while there is one.
    browser.wait_until(
        "the screen has all that an operator needs",
        "['stop', 'pause', 'view', 'why', 'services', 'reaction', 'events'].every((id) => { \
         const box = document.getElementById(id).getBoundingClientRect(); \
         return box.left >= 0 && box.right <= innerWidth && box.width; })",
    );
    assert_eq!(
        browser.script("document.documentElement.scrollWidth <= innerWidth"),
        true
    );
    let stop = browser.script("document.getElementById('stop').getBoundingClientRect().bottom");
    assert!(stop.as_f64() < Some(844.0), "without scrolling: {stop}");
    assert_eq!(browser.problems, Vec::<String>::new());
    up.down();
    assert_eq!(viewer.code(), Some(0));
}
