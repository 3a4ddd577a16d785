//! The button of a report that opens the trace of its run in Perfetto, with a page in Perfetto's place.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;
use zeronav_msgs::role::Role;
use zeronav_msgs::stages::Stage;
use zeronav_tests::browser::Browser;
use zeronav_tests::rooms::short_drive;
use zeronav_tests::trace::{check_stages, checked};
use zeronav_tests::{Ended, Zeronav, real_time_turn};

/// How long a page may take to be opened and to get the trace: longer than the report waits for it.
const LIMIT: Duration = Duration::from_secs(90);

/// Answers the second word that asks whether it is there, and sends what it gets to its server.
const STAND_IN: &str = r#"<!doctype html><title>stand-in</title><script>
let asked = 0;
addEventListener("message", ({ data, source }) => {
  if (data === "PING") {
    asked += 1;
    if (asked > 1) source.postMessage("PONG", "*");
    return;
  }
  const { buffer, title } = data.perfetto;
  fetch("/got/" + encodeURIComponent(title), { method: "POST", body: buffer });
});
</script>"#;

/// A page that goes away.
const GOES: &str = "<!doctype html><script>close()</script>";

/// What a page in Perfetto's place asks its server for: the way, and what it sends.
type Asked = (String, Vec<u8>);

/// Serves the pages on this machine; what they ask for comes to the receiver.
fn serve() -> (String, Receiver<Asked>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("its address").port();
    let (to, asked) = channel();
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let to = to.clone();
            std::thread::spawn(move || answer(stream, &to));
        }
    });
    (format!("http://127.0.0.1:{port}"), asked)
}

/// Answers one request; a browser also opens connections on which it asks for nothing.
fn answer(mut stream: TcpStream, to: &Sender<Asked>) -> Option<()> {
    let mut input = BufReader::new(stream.try_clone().ok()?);
    let mut line = String::new();
    input.read_line(&mut line).ok()?;
    let way = line.split(' ').nth(1)?.to_owned();
    let mut length = 0;
    loop {
        let mut line = String::new();
        input.read_line(&mut line).ok()?;
        let line = line.trim_end().to_lowercase();
        if line.is_empty() {
            break;
        }
        if let Some(number) = line.strip_prefix("content-length:") {
            length = number.trim().parse().ok()?;
        }
    }
    let mut body = vec![0; length];
    input.read_exact(&mut body).ok()?;
    let page = if way == "/goes" { GOES } else { STAND_IN };
    let _ = to.send((way, body));
    write!(
        stream,
        "HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nContent-Length: {}\r\n\
         Connection: close\r\n\r\n{page}",
        page.len()
    )
    .ok()
}

/// The next request for a way that begins like this, by what `browser` does.
fn next(browser: &mut Browser, asked: &Receiver<Asked>, way: &str) -> Asked {
    loop {
        let Ok(one) = asked.recv_timeout(LIMIT) else {
            let said = browser.script("document.getElementById('perfetto-said').textContent");
            panic!("nobody asks for {way}; the page says {said}");
        };
        if one.0.starts_with(way) {
            return one;
        }
    }
}

/// Clicks at the button as a person does: a browser opens no window otherwise.
fn press(browser: &mut Browser, page: &str) {
    let at = browser.script(&format!(
        "(() => {{ const button = document.getElementById('perfetto'); button.dataset.page = '{page}'; \
         button.scrollIntoView({{ block: 'center' }}); const box = button.getBoundingClientRect(); \
         return [box.x + box.width / 2, box.y + box.height / 2]; }})()"
    ));
    let at: [f64; 2] = serde_json::from_value(at).expect("a place");
    browser.click(at);
}

fn await_said(browser: &mut Browser, words: &str) {
    let says = format!("document.getElementById('perfetto-said').textContent.includes('{words}')");
    browser.wait_until(&format!("it says: {words}"), &says);
}

/// The report of `run` in a browser without network.
fn opened(run: &Path) -> Browser {
    let mut browser = Browser::start(1000, 800);
    browser.open_file(&run.join("report.html"));
    browser
}

fn check_quiet(mut browser: Browser) {
    browser.script("1"); // Whatever came before has come.
    let foreign = |url: &&String| !url.starts_with("file:") && !url.starts_with("data:");
    assert_eq!(browser.requests.iter().find(foreign), None, "no network");
    assert_eq!(browser.problems, [""; 0]);
}

fn text(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// A short drive in real time, and its folder.
fn driven(more: &[&str]) -> (Ended, PathBuf) {
    let folder = tempfile::tempdir().expect("a working folder");
    std::fs::write(folder.path().join("test.toml"), short_drive("")).expect("written");
    let arguments = ["run", "test.toml", "--headless", "--json"];
    let ended = Zeronav::start_in(folder, &[&arguments, more].concat()).finish();
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    let result = ended.json();
    let run = result["directory"].as_str().expect("its folder");
    let run = ended.folder.path().join(run);
    (ended, run)
}

#[test]
fn the_trace_of_a_report_opens_in_perfetto() {
    let turn = real_time_turn();
    let (ended, run) = driven(&[]);
    drop(turn);
    let trace = text(&run.join("trace.json"));
    let held = checked(&trace);
    check_stages(&held);
    assert!(held.n_flows("scan to wheel") > 5);
    assert!(held.count(Role::Mapping, Stage::Clearance.label()) > 5);
    assert!(held.count(Role::GlobalPlanner, Stage::Search.label()) >= 1);

    let (origin, asked) = serve();
    let mut browser = opened(&run);
    let page = browser.script("document.getElementById('perfetto').dataset.page");
    assert_eq!(page, "https://ui.perfetto.dev");
    let plain = browser.script("document.querySelector('#trace a').getAttribute('href')");
    assert_eq!(plain, "trace.json", "the file for those offline");
    let nothing = asked.recv_timeout(Duration::from_millis(1));
    assert_eq!(nothing, Err(RecvTimeoutError::Timeout), "nothing by itself");
    press(&mut browser, &format!("{origin}/"));
    let (way, body) = next(&mut browser, &asked, "/got/");
    assert!(way.starts_with("/got/test%2C%20"), "{way}");
    assert!(body == trace.as_bytes(), "the same trace");
    await_said(&mut browser, "in Perfetto");

    // A window that goes away is no reason to wait.
    press(&mut browser, &format!("{origin}/goes"));
    next(&mut browser, &asked, "/goes");
    await_said(&mut browser, "does not answer");
    check_quiet(browser);

    // A trace that is too large for the page is chosen by hand.
    let noise: Vec<Value> = (0..500_000_u64)
        .map(|n| (n.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 12).into())
        .collect();
    let mut large: Value = serde_json::from_str(&trace).expect("JSON");
    large["otherData"]["noise"] = noise.into();
    let large = large.to_string();
    std::fs::write(run.join("trace.json"), &large).expect("written");
    let name = run.strip_prefix(ended.folder.path()).expect("inside");
    let name = name.to_str().expect("a path").to_owned();
    let again = Zeronav::start_in(ended.folder, &["report", &name]).finish();
    assert_eq!(again.code(), 0, "{}", again.stderr);
    let mut browser = opened(&run);
    press(&mut browser, &format!("{origin}/"));
    await_said(&mut browser, "Choose the file");
    let document = browser.call("DOM.getDocument", json!({}));
    let query = json!({ "nodeId": document["root"]["nodeId"], "selector": "#trace-file" });
    let input = browser.call("DOM.querySelector", query);
    let files = json!({ "nodeId": input["nodeId"], "files": [run.join("trace.json")] });
    browser.call("DOM.setFileInputFiles", files);
    press(&mut browser, &format!("{origin}/"));
    let (_, body) = next(&mut browser, &asked, "/got/");
    assert!(body == large.as_bytes(), "the file that was chosen");
    check_quiet(browser);
}

#[test]
fn stages_are_timed_only_when_they_are_wanted() {
    let _turn = real_time_turn();
    let (_ended, run) = driven(&["--no-stages"]);
    let held = checked(&text(&run.join("trace.json")));
    assert!(held.n_flows("scan to wheel") > 5);
    let inner = held
        .tracks
        .values()
        .flatten()
        .filter(|slice| slice.depth > 0);
    assert_eq!(inner.count(), 0, "no stages");
}
