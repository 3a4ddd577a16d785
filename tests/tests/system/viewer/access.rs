//! What other users of the machine can do with a viewer.

use super::client::{Viewer, ask, connect, stream_lines};
use std::io::{Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use zeronav_tests::up::Up;
use zeronav_tests::{await_by_itself, real_time_turn};

/// A browser that notes what it was given, and what is in the file that was named.
const BROWSER: &str = r#"#!/bin/sh
here=$(dirname "$0")
stat -c %a "$1" > "$here/mode"
cat "$1" > "$here/page"
printf '%s\n' "$@" > "$here/arguments.part"
mv "$here/arguments.part" "$here/arguments"
"#;

/// `--open`: no argument of any process has the token, only a file that others cannot read and that
/// goes when the page is open.
#[test]
fn the_link_is_handed_over_without_showing_its_token() {
    let up = Up::start(&["open_aisle", "--lockstep"]);
    let folder = tempfile::tempdir().expect("a folder");
    let browser = folder.path().join("xdg-open");
    std::fs::write(&browser, BROWSER).expect("written");
    std::fs::set_permissions(&browser, PermissionsExt::from_mode(0o755)).expect("executable");
    let path = std::env::var("PATH").unwrap_or_default();
    let path = format!("{}:{path}", folder.path().display());
    let viewer = Viewer::start_in(&up.root, &["--open"], &path);
    let (host, token) = viewer.address();
    let noted = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap_or_default();
    await_by_itself("the browser is asked", || !noted("arguments").is_empty());
    let arguments = noted("arguments");
    assert!(!arguments.contains(&token), "{arguments}");
    assert_eq!(noted("mode").trim(), "600");
    assert!(noted("page").contains(&viewer.link), "{}", noted("page"));
    let file = Path::new(arguments.trim());
    assert!(file.exists());
    let mut stream = connect(&host);
    let request = stream_lines(&host, &token).join("\r\n") + "\r\n\r\n";
    stream.write_all(request.as_bytes()).expect("sent");
    await_by_itself("the file is gone", || !file.exists());
    assert_eq!(leaks(&up, &token), Vec::<String>::new());
    up.down();
    assert_eq!(viewer.code(), Some(0));
}

/// Places in which others could read the token: arguments and environments of all processes, logs.
fn leaks(up: &Up, token: &str) -> Vec<String> {
    let has_it = |path: &Path| {
        std::fs::read(path).is_ok_and(|bytes| {
            let mut windows = bytes.windows(token.len());
            windows.any(|window| window == token.as_bytes())
        })
    };
    let mut files = Vec::new();
    for process in std::fs::read_dir("/proc").expect("/proc").flatten() {
        files.extend(["cmdline", "environ"].map(|name| process.path().join(name)));
    }
    let run = up.status()["folder"]
        .as_str()
        .unwrap_or_default()
        .to_owned();
    for log in std::fs::read_dir(Path::new(&run).join("logs"))
        .expect("logs")
        .flatten()
    {
        files.push(log.path());
    }
    let leaks = files.into_iter().filter(|file| has_it(file));
    leaks.map(|file| file.display().to_string()).collect()
}

/// Another user that opens more connections than there are places, asks on each, and reads nothing.
struct Unread(Child);

impl Unread {
    fn start(host: &str) -> Self {
        let port = host.split_once(':').expect("a port").1;
        let script = format!(
            "ask=$(for n in $(seq 80); do \
               printf 'GET /scene.js HTTP/1.1\\r\\nHost: {host}\\r\\n\\r\\n'; done); \
             for n in $(seq 70); do exec {{f}}<>/dev/tcp/127.0.0.1/{port}; printf '%s' \"$ask\" >&$f; done; \
             echo there; exec sleep 600"
        );
        let is_root = rustix::process::geteuid().is_root();
        let mut command = if is_root {
            let mut other = Command::new("setpriv");
            other.args(["--reuid=65534", "--regid=65534", "--clear-groups", "bash"]);
            other
        } else {
            Command::new("bash")
        };
        let mut process = command
            .args(["-c", &script])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .expect("bash");
        let mut said = [0; 6];
        let mut output = process.stdout.take().expect("its output");
        output.read_exact(&mut said).expect("it is connected");
        Self(process)
    }
}

impl Drop for Unread {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn answers_that_another_user_leaves_unread_lock_nobody_out() {
    let _turn = real_time_turn();
    let up = Up::start(&["open_aisle", "--lockstep"]);
    let viewer = Viewer::start(&up.root, &[]);
    let (host, token) = viewer.address();
    let mut page = connect(&host);
    let request = stream_lines(&host, &token).join("\r\n") + "\r\n\r\n";
    page.write_all(request.as_bytes()).expect("sent");
    let _unread = Unread::start(&host);
    for _ in 0..3 {
        let (status, page) = ask(&host, &["GET / HTTP/1.1", &format!("Host: {host}")], "");
        assert_eq!((status, page.contains("<canvas")), (200, true));
    }
    // The page that is open stays so.
    let mut told = [0; 4096];
    page.read_exact(&mut told).expect("it is told what is new");
    up.down();
    assert_eq!(viewer.code(), Some(0));
}
