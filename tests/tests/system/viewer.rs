//! The live page of a real stack in a real browser: what it shows, what it may do, and that nothing
//! that a client does reaches the stack.

mod access;
mod client;
mod operator;
mod picture;
mod terminal;

use client::{Viewer, act, ask, connect, noise, stream_lines};
use serde_json::Value;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use zeronav_msgs::topics::{DebugRollouts, Topic};
use zeronav_tests::browser::Browser;
use zeronav_tests::up::Up;
use zeronav_tests::{real_time_turn, zeronav};

/// Epochs and process ids of the services.
fn seats(up: &Up) -> Vec<(Value, Value, Value)> {
    let report = up.status();
    let services = report["services"].as_array().expect("services").iter();
    let seat = |service: &Value| {
        let of = |key: &str| service[key].clone();
        (of("role"), of("epoch"), of("pid"))
    };
    services.map(seat).collect()
}

fn readers_of_rollouts(up: &Up) -> Value {
    let list = zeronav(&["topics", "--domain", &up.root, "--json"]).json();
    let mut topics = list["topics"].as_array().expect("topics").iter();
    let row = topics.find(|row| row["topic"] == DebugRollouts::ROW.name);
    row.expect("rollouts")["readers"].clone()
}

/// Where a place of the map is in the window. [pixels]
fn on_screen(browser: &mut Browser, x_m: f64, y_m: f64) -> [f64; 2] {
    let place = browser.script(&format!(
        "(() => {{ const box = document.getElementById('view').getBoundingClientRect(); \
         const [x, y] = zeronavPage.view.toScreen([{x_m}, {y_m}]); \
         return [x + box.left, y + box.top]; }})()"
    ));
    [0, 1].map(|at| place[at].as_f64().expect("a place"))
}

fn robot(browser: &mut Browser) -> [f64; 2] {
    let robot = browser.script("zeronavPage.scene.at(Infinity).robot");
    [0, 1].map(|at| robot[at].as_f64().expect("a coordinate"))
}

/// The page is there, with the whole map.
fn shown(viewer: &Viewer) -> Browser {
    let mut browser = Browser::open(&viewer.link);
    browser.wait_until("the page shows the stack", "window.zeronavPage?.scene");
    browser.wait_until(
        "the whole map is there",
        "(() => { const [log] = zeronavPage.scene.logs; \
         return log && log.versions.size === log.columns * log.rows; })()",
    );
    // Until then no place of the map is anywhere on the screen.
    browser.wait_until("the map is drawn", "zeronavPage.view.scale > 0");
    browser.wait_until(
        "it says how it is",
        "document.querySelector('.state.ready')",
    );
    browser
}

/// A browser on a busy machine connects long before it asks.
fn is_answered(mut early: TcpStream, host: &str) {
    let request = format!("GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
    early.write_all(request.as_bytes()).expect("sent");
    let mut answer = String::new();
    early.read_to_string(&mut answer).expect("an answer");
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
}

/// A click on a new path shows where its time went, until the page is live again.
fn shows_a_past_replanning(browser: &mut Browser) {
    let at_the_wheels = "[...document.querySelectorAll('#events li')]\
        .find((line) => line.textContent.includes('new path at the wheels'))";
    browser.wait_until("a new path is at the wheels", at_the_wheels);
    browser.script("new Promise((done) => setTimeout(done, 400))");
    browser.script(&format!("{at_the_wheels}.click()"));
    let title = "document.getElementById('replanning-title').textContent";
    let past = browser.script(title);
    assert!(
        past.as_str()
            .is_some_and(|title| title.starts_with("Replanning at")),
        "{past}"
    );
    assert_eq!(
        browser.script("document.querySelectorAll('#replanning b').length"),
        10
    );
    browser.script("document.getElementById('live').click()");
    browser.wait_until(
        "the newest one is shown",
        &format!("{title}.startsWith('Last')"),
    );
}

/// One button brings the robot to rest, and the page says so; a swap that is rejected is said, too,
/// the first time and again.
fn stops_the_robot(browser: &mut Browser, up: &Up) {
    let said = "document.getElementById('said').textContent";
    browser.script("document.getElementById('stop').click()");
    browser.wait_until("it stands", &format!("{said}.includes('the robot stands')"));
    assert_eq!(up.status()["goal"], Value::Null);
    browser.wait_until(
        "the page says why",
        "document.getElementById('why').textContent",
    );
    browser.script("document.querySelector('.seat-acts input').value = 'no_such_program'");
    for times in 1..=2 {
        browser.script("document.querySelector('[data-act=swap]').click()");
        let told = "[...document.querySelectorAll('#events li')]\
            .filter((line) => line.textContent.includes('of mapping: rejected')).length";
        browser.wait_until("it is rejected", &format!("{told} === {times}"));
    }
}

/// A service that is killed turns red, and green again.
fn kills_mapping(browser: &mut Browser, up: &Up) {
    let state = "document.querySelector('#seat-mapping .state').className";
    assert_eq!(browser.script(state), "state ready");
    browser.script("document.getElementById('seat-mapping').click()");
    let listed = "[...document.getElementById('binaries').options].map((one) => one.value)";
    assert_eq!(
        browser.script(listed),
        serde_json::json!(["zeronav-mapping"])
    );
    // Faults stand behind a switch, and the worst ones are asked for twice.
    assert_eq!(
        browser.script("document.querySelector('[data-act=kill]')"),
        Value::Null
    );
    browser.script("document.getElementById('faults').click()");
    let kill = "document.querySelector('[data-act=kill]')";
    browser.script(&format!("{kill}.click()"));
    let sure = browser.script(&format!("{kill}.textContent"));
    assert_eq!(sure, "Kill mapping: click again");
    browser.script(&format!("{kill}.click()"));
    browser.wait_until(
        "the seat is red",
        "document.querySelector('#seat-mapping .silent, #seat-mapping .restarted')",
    );
    browser.wait_until(
        "the seat is green",
        "document.querySelector('#seat-mapping .state.ready')",
    );
    let mapping = seats(up).into_iter().find(|(role, ..)| role == "mapping");
    assert_eq!(mapping.map(|(_, epoch, _)| epoch), Some(Value::from(2)));
}

// long: the story of one page
#[test]
fn the_page_shows_the_robot_and_steers_it() {
    let _turn = real_time_turn();
    let up = Up::start(&["open_aisle"]);
    let viewer = Viewer::start(&up.root, &[]);
    assert_eq!(readers_of_rollouts(&up), 0, "no page is open");
    let (host, _) = viewer.address();
    let early = connect(&host);
    let mut browser = shown(&viewer);

    // A click sends a goal, through the lower aisle.
    let goal = on_screen(&mut browser, 26.0, 8.5);
    browser.click(goal);
    browser.wait_until(
        "the robot has a path",
        "zeronavPage.scene.at(Infinity).path?.points_m.length > 1",
    );
    let outcomes = "zeronavPage.scene.at(Infinity).rollouts?.map(([outcome]) => outcome)";
    browser.wait_until("it looks ahead", &format!("{outcomes}?.includes('chosen')"));
    assert_eq!(readers_of_rollouts(&up), 1);
    browser.wait_until(
        "a legend is there",
        "!document.getElementById('legend').hidden",
    );
    let sent = up.status()["goal"].clone();
    assert_eq!(sent["outcome"], "active", "{sent}");

    // The robot leaves its place on the picture; what does not move stays as it is.
    let [x_m, y_m] = robot(&mut browser);
    let (place, corner) = (on_screen(&mut browser, x_m, y_m), [900.0, 760.0]);
    let before = [browser.picture(place, 12.0), browser.picture(corner, 12.0)];
    browser.wait_until(
        "the robot has moved by a metre",
        &format!(
            "(() => {{ const [x, y] = zeronavPage.scene.at(Infinity).robot; \
             return Math.hypot(x - {x_m}, y - {y_m}) > 1; }})()"
        ),
    );
    browser.script("new Promise((done) => setTimeout(done, 400))");
    let after = [browser.picture(place, 12.0), browser.picture(corner, 12.0)];
    assert_ne!(before[0], after[0], "the robot is where it was");
    assert_eq!(before[1], after[1]);

    // An obstacle across the aisle: the path leads through the other one.
    let crosses = |y_m: f64| {
        format!("zeronavPage.scene.at(Infinity).path.points_m.some(([, y]) => y > {y_m})")
    };
    assert_eq!(
        browser.script(&crosses(10.0)),
        false,
        "the lower aisle is nearer"
    );
    let from = on_screen(&mut browser, 15.0, 5.7);
    let to = on_screen(&mut browser, 15.4, 7.2);
    browser.shift_drag(from, to);
    let drawn = "zeronavPage.scene.at(Infinity).bodies?.length";
    browser.wait_until(
        "the obstacle is drawn, seen or not",
        &format!("{drawn} === 1"),
    );
    browser.wait_until("the path leads around the obstacle", &crosses(12.0));
    browser.wait_until(
        "the page says why",
        "[...document.querySelectorAll('#events li')].some((line) => line.textContent.includes('obstacle:'))",
    );

    is_answered(early, &host);
    shows_a_past_replanning(&mut browser);

    kills_mapping(&mut browser, &up);
    stops_the_robot(&mut browser, &up);

    // Time travel: the robot drives on, and the page shows where it was.
    browser.script("document.querySelector('#events li:last-child').click()");
    let shown_s = browser.script("zeronavPage.view.time_s").as_f64();
    let newest_s = browser.script("zeronavPage.scene.end_s").as_f64();
    assert!(
        shown_s.is_some() && shown_s < newest_s,
        "{shown_s:?}, {newest_s:?}"
    );

    assert_eq!(browser.problems, Vec::<String>::new());
    up.down();
    browser.wait_until(
        "the page says that the run is over",
        "document.getElementById('link').textContent.includes('over')",
    );
    assert_eq!(viewer.code(), Some(0));
}

#[test]
fn only_the_page_with_the_token_may_act() {
    let up = Up::start(&["open_aisle", "--lockstep"]);
    let viewer = Viewer::start(&up.root, &[]);
    let (host, token) = viewer.address();
    assert_eq!(token.len(), 32, "{token}");
    let pause = r#"{"command":"pause"}"#;
    let paused = |up: &Up| up.status()["paused"].clone();
    let wrong = token.replace(|digit: char| digit.is_ascii_hexdigit(), "0");
    for (token, more) in [
        ("", ""),
        (wrong.as_str(), ""),
        (&token[1..], ""),
        (token.as_str(), "Origin: http://evil.example"),
        (token.as_str(), "Origin: null"),
        (token.as_str(), "Host: evil.example"),
    ] {
        let (status, said) = act(&host, token, more, pause);
        assert_eq!(status, 403, "{token} {more}: {said}");
    }
    for lines in [
        ["GET / HTTP/1.1", "Host: evil.example:8090"],
        ["GET /stream HTTP/1.1", "Host: localhost.evil.example"],
        ["GET /scene.js HTTP/1.1", "Host: 127.0.0.1"],
    ] {
        assert_eq!(ask(&host, &lines, "").0, 403, "{lines:?}");
    }
    assert_eq!(paused(&up), false, "none of them did anything");
    // Nor is anything told.
    for token in ["", wrong.as_str(), &token[1..]] {
        let (status, said) = ask(&host, &stream_lines(&host, token), "");
        assert_eq!(status, 403, "{token}: {said}");
        let header = format!("X-Zeronav-Token: {token}");
        let own = format!("Host: {host}");
        let lines = ["GET /access HTTP/1.1", own.as_str(), header.as_str()];
        assert_eq!(ask(&host, &lines, "").0, 403, "{token}");
    }
    // What is not on the list, and what launch does not accept.
    let (status, said) = act(&host, &token, "", r#"{"command":"down"}"#);
    assert_eq!(
        (status, said.contains("cannot ask for")),
        (400, true),
        "{said}"
    );
    let (status, said) = act(&host, &token, "", r#"{"command":"step","ticks":0}"#);
    assert_eq!((status, said.contains("error")), (200, true), "{said}");
    let own = format!("Origin: http://{host}");
    let (status, said) = act(&host, &token, &own, pause);
    assert_eq!((status, said.as_str()), (200, "\"done\""));
    assert_eq!(paused(&up), true);

    // A port that is taken is a usage error, and a page for looking has no acts.
    let port = host.split_once(':').expect("a port").1;
    let ended = zeronav(&["view", "--domain", &up.root, "--port", port]);
    assert_eq!(
        (ended.code(), ended.stderr.contains("taken")),
        (2, true),
        "{}",
        ended.stderr
    );
    let looking = Viewer::start(&up.root, &["--view-only"]);
    let (other, none) = looking.address();
    assert_eq!(none, "");
    let (status, said) = act(&other, &token, "", r#"{"command":"resume"}"#);
    assert_eq!((status, said.contains("view-only")), (403, true), "{said}");
    let mut stream = connect(&other);
    let request = stream_lines(&other, "").join("\r\n") + "\r\n\r\n";
    stream.write_all(request.as_bytes()).expect("sent");
    let mut answer = [0; 12];
    stream.read_exact(&mut answer).expect("an answer");
    assert_eq!(&answer, b"HTTP/1.1 101", "everybody may look");
    up.down();
    assert_eq!((viewer.code(), looking.code()), (Some(0), Some(0)));
}

#[test]
fn hostile_and_stalled_clients_leave_the_stack_and_the_others_alone() {
    let _turn = real_time_turn();
    let up = Up::start(&["open_aisle"]);
    let before = seats(&up);
    let viewer = Viewer::start(&up.root, &[]);
    let (host, token) = viewer.address();
    // One that asks for the stream and never reads.
    let mut stalled = connect(&host);
    let upgrade = stream_lines(&host, &token).join("\r\n") + "\r\n\r\n";
    stalled.write_all(upgrade.as_bytes()).expect("sent");
    // Garbage, also where a request was promised.
    for seed in 0..60 {
        let mut stream = connect(&host);
        let _ = stream.write_all(&noise(seed * 7919 + 1, 2048));
        let _ = stream.shutdown(Shutdown::Write);
        let _ = stream.read_to_end(&mut Vec::new());
    }
    for seed in 0..60 {
        let body = String::from_utf8_lossy(&noise(seed * 104_729 + 3, 300)).into_owned();
        let (status, said) = act(&host, &token, "", &body);
        assert_eq!(status, 400, "{said}");
    }
    // Headers and bodies without an end.
    let huge = format!("X: {}", "x".repeat(1 << 20));
    let (status, _) = ask(
        &host,
        &["GET / HTTP/1.1", &format!("Host: {host}"), &huge],
        "",
    );
    assert!(status == 431 || status == 0, "{status}");
    let (status, _) = act(&host, &token, "", &"x".repeat(1 << 20));
    assert!(status == 413 || status == 0, "{status}");
    // More connections than there are places, which never finish their headers: others get theirs.
    let slow: Vec<TcpStream> = (0..100)
        .map(|_| {
            let mut stream = connect(&host);
            let _ = stream.write_all(b"GET / HTTP/1.1\r\nHost: ");
            stream
        })
        .collect();
    let (status, page) = ask(&host, &["GET / HTTP/1.1", &format!("Host: {host}")], "");
    assert_eq!((status, page.contains("<canvas")), (200, true));
    drop(slow);
    assert_eq!(seats(&up), before, "the services are the same processes");
    drop(stalled);
    up.down();
    assert_eq!(viewer.code(), Some(0));
}
