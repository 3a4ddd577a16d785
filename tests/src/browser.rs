//! Chromium without a screen, driven over its `DevTools` protocol on a pair of pipes.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// How long the browser may take for an answer.
const ANSWER_LIMIT: Duration = Duration::from_secs(60);

/// Key code of shift in events of the mouse.
const SHIFT: u32 = 8;

/// A browser with one page.
#[derive(Debug)]
pub struct Browser {
    process: Child,
    input: ChildStdin,
    messages: Receiver<Value>,
    session: Option<String>,
    last_id: u64,
    /// What the page has logged as an error, and exceptions that nothing caught.
    pub problems: Vec<String>,
    /// Addresses that the page has asked for.
    pub requests: Vec<String>,
    _profile: tempfile::TempDir,
}

impl Browser {
    /// Opens `url` in a window of 1280 x 800 pixels.
    ///
    /// # Panics
    /// When there is no `chromium`, or it does not start.
    #[must_use]
    pub fn open(url: &str) -> Self {
        let mut browser = Self::start(1280, 800);
        browser.call("Page.navigate", json!({ "url": url }));
        browser
    }

    /// Starts it without a page, with a window of this size. [px]
    ///
    /// # Panics
    /// As [`Self::open`].
    #[must_use]
    pub fn start(width: u32, height: u32) -> Self {
        let profile = tempfile::tempdir().expect("a folder");
        // The protocol is spoken on the descriptors 3 and 4.
        let command = "exec chromium --headless --no-sandbox --disable-gpu --disable-quic \
            --no-first-run --disable-background-networking --disable-component-update \
            --disable-sync --window-size=1280,800 --remote-debugging-pipe \
            --user-data-dir=\"$1\" about:blank 3<&0 4>&1 1>/dev/null 2>/dev/null";
        let mut process = Command::new("sh")
            .args(["-c", command, "sh"])
            .arg(profile.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("a shell");
        let input = process.stdin.take().expect("its input");
        let output = process.stdout.take().expect("its output");
        let (to, messages) = channel();
        std::thread::spawn(move || {
            for message in BufReader::new(output).split(0).map_while(Result::ok) {
                let Ok(message) = serde_json::from_slice(&message) else {
                    return;
                };
                if to.send(message).is_err() {
                    return;
                }
            }
        });
        let mut browser = Self {
            process,
            input,
            messages,
            session: None,
            last_id: 0,
            problems: Vec::new(),
            requests: Vec::new(),
            _profile: profile,
        };
        let target = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let session = browser.call("Target.attachToTarget", attach);
        browser.session = session["sessionId"].as_str().map(str::to_owned);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        let size =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        browser.call("Emulation.setDeviceMetricsOverride", size);
        browser
    }

    /// Opens a file without network.
    ///
    /// # Panics
    /// When it cannot be opened.
    pub fn open_file(&mut self, file: &Path) {
        let none = json!({
            "offline": true, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0,
        });
        self.call("Network.emulateNetworkConditions", none);
        let file = std::path::absolute(file).expect("a path");
        let url = json!({ "url": format!("file://{}", file.display()) });
        let opened = self.call("Page.navigate", url);
        assert!(opened.get("errorText").is_none(), "{opened}");
        self.wait_until("it is loaded", "document.readyState === 'complete'");
    }

    /// Calls a method of the protocol.
    ///
    /// # Panics
    /// When the browser says no, says nothing, or is gone (it may not be installed).
    #[allow(clippy::needless_pass_by_value, reason = "written where it is passed")]
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last_id += 1;
        let id = self.last_id;
        let mut request = json!({ "id": id, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            request["sessionId"] = json!(session);
        }
        let gone = "chromium is not there; apt-get install chromium";
        write!(self.input, "{request}\0").expect(gone);
        self.input.flush().expect(gone);
        loop {
            let message = self.messages.recv_timeout(ANSWER_LIMIT);
            let message = message.unwrap_or_else(|error| panic!("{method}: {error}; {gone}"));
            if message["id"] == id {
                assert!(message.get("error").is_none(), "{method}: {message}");
                return message["result"].clone();
            }
            self.note_problem(&message);
        }
    }

    fn note_problem(&mut self, message: &Value) {
        let parameters = &message["params"];
        if message["method"] == "Network.requestWillBeSent" {
            let url = parameters["request"]["url"].as_str().unwrap_or_default();
            self.requests.push(url.to_owned());
        }
        let is_problem = match message["method"].as_str() {
            Some("Runtime.exceptionThrown") => true,
            Some("Runtime.consoleAPICalled") => parameters["type"] == "error",
            Some("Log.entryAdded") => parameters["entry"]["level"] == "error",
            _ => false,
        };
        if is_problem {
            self.problems.push(parameters.to_string());
        }
    }

    /// The value of an expression on the page.
    ///
    /// # Panics
    /// When it throws.
    pub fn script(&mut self, expression: &str) -> Value {
        let parameters =
            json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let result = self.call("Runtime.evaluate", parameters);
        let thrown = result.get("exceptionDetails");
        assert!(thrown.is_none(), "{expression}: {result}");
        result["result"]["value"].clone()
    }

    /// Waits until an expression on the page is true.
    ///
    /// # Panics
    /// When it does not become true.
    pub fn wait_until(&mut self, what: &str, expression: &str) {
        let began = Instant::now();
        while self.script(&format!("Boolean({expression})")) != true {
            assert!(
                began.elapsed() < ANSWER_LIMIT,
                "waited too long until {what}; problems: {:?}",
                self.problems
            );
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], modifiers: u32) {
        let event = json!({
            "type": kind, "x": x, "y": y, "button": "left", "clickCount": 1, "modifiers": modifiers,
        });
        self.call("Input.dispatchMouseEvent", event);
    }

    /// Presses at one place of the window, moves to another and lets go.
    fn press_and_move(&mut self, from: [f64; 2], to: [f64; 2], modifiers: u32) {
        self.mouse("mousePressed", from, modifiers);
        self.mouse("mouseMoved", to, modifiers);
        self.mouse("mouseReleased", to, modifiers);
    }

    /// Clicks at a place of the window.
    pub fn click(&mut self, at: [f64; 2]) {
        self.mouse("mousePressed", at, 0);
        self.mouse("mouseReleased", at, 0);
    }

    /// Clicks at a place of the window with the shift key held.
    pub fn shift_click(&mut self, at: [f64; 2]) {
        self.press_and_move(at, at, SHIFT);
    }

    /// Drags from one place of the window to another.
    pub fn drag(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.press_and_move(from, to, 0);
    }

    /// Drags from one place of the window to another with the shift key held.
    pub fn shift_drag(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.press_and_move(from, to, SHIFT);
    }

    /// Presses a key.
    pub fn press(&mut self, key: &str) {
        for kind in ["keyDown", "keyUp"] {
            self.call(
                "Input.dispatchKeyEvent",
                json!({ "type": kind, "key": key }),
            );
        }
    }

    /// A picture of the square with this centre and half side in the window: a PNG as base64.
    pub fn picture(&mut self, [x, y]: [f64; 2], half: f64) -> String {
        let clip = json!({
            "x": (x - half).floor(), "y": (y - half).floor(),
            "width": 2.0 * half, "height": 2.0 * half, "scale": 1,
        });
        let shot = self.call(
            "Page.captureScreenshot",
            json!({ "format": "png", "clip": clip }),
        );
        shot["data"].as_str().unwrap_or_default().to_owned()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
