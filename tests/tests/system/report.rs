//! `report.html` of a run, `zeronav report` and `zeronav picture`.

use std::path::{Path, PathBuf};
use zeronav_tests::browser::Browser;
use zeronav_tests::rooms::short_drive;
use zeronav_tests::up::Up;
use zeronav_tests::{Ended, Zeronav, real_time_turn, zeronav};

/// Largest report. [bytes]
const SIZE_MAX: usize = 3_000_000;

/// The folder of a run that has ended.
fn folder_of(ended: &Ended) -> PathBuf {
    let result = ended.json();
    let run = result["directory"].as_str().expect("its folder");
    ended.folder.path().join(run)
}

fn text(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// A lockstep drive of a scenario with this text, and its result.
fn drive(scenario: &str, more: &[&str]) -> Ended {
    let folder = tempfile::tempdir().expect("a working folder");
    std::fs::write(folder.path().join("test.toml"), scenario).expect("written");
    let arguments = ["run", "test.toml", "--lockstep", "--headless", "--json"];
    Zeronav::start_in(folder, &[&arguments, more].concat()).finish()
}

/// Runs `zeronav` in `folder` until it ends.
fn run_in(folder: tempfile::TempDir, arguments: &[&str]) -> Ended {
    Zeronav::start_in(folder, arguments).finish()
}

/// Whether the pixels of the player's canvas are the same, in words that are compared.
const PIXELS: &str = "document.getElementById('view').toDataURL()";

/// What the player shows, once it has drawn.
fn pixels(browser: &mut Browser) -> String {
    browser.script("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))");
    browser.script(PIXELS).as_str().expect("pixels").to_owned()
}

fn time_s(browser: &mut Browser) -> f64 {
    let time = browser.script("Number(document.getElementById('time').value)");
    time.as_f64().expect("a time")
}

/// Plays, scrubs and jumps in the report of `blocked_aisle`.
fn play(browser: &mut Browser) {
    let at_start = pixels(browser);
    // It plays, and stops when it is told to.
    browser.script("document.getElementById('speed').value = 4");
    browser.script("document.getElementById('play').click()");
    browser.wait_until(
        "the page does",
        "Number(document.getElementById('time').value) > 2",
    );
    browser.script("document.getElementById('play').click()");
    let stopped_s = time_s(browser);
    let later = pixels(browser);
    assert!(at_start != later, "the robot has moved");
    assert!((time_s(browser) - stopped_s).abs() < 1e-9, "it stands");
    // To the event, by its row and by the key.
    browser.script(
        "[...document.querySelectorAll('#events tr')]\
         .find(row => row.textContent.includes('load appears')).querySelector('a').click()",
    );
    let appears_s = time_s(browser);
    let said = browser.script("document.getElementById('said').textContent");
    let said = said.as_str().expect("text");
    assert!(said.starts_with("load appears"), "{said}");
    let there = pixels(browser);
    browser.script("document.getElementById('player').focus()");
    browser.press("]");
    let next_s = time_s(browser);
    assert!(
        appears_s > 1.0 && next_s > appears_s,
        "{appears_s} {next_s}"
    );
    browser.press("Home");
    assert!(time_s(browser) < 0.2);
    assert!(
        pixels(browser) == at_start,
        "the same moment is the same picture"
    );
    // A drag of the line of time.
    browser.script(&format!(
        "(() => {{ const time = document.getElementById('time'); time.value = {appears_s}; \
         time.dispatchEvent(new Event('input')); }})()"
    ));
    assert!(
        pixels(browser) == there,
        "the same moment is the same picture"
    );
}

#[test]
fn a_report_plays_without_network_and_without_errors() {
    let ended = zeronav(&["run", "blocked_aisle", "--lockstep", "--headless", "--json"]);
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    let run = folder_of(&ended);
    let page = text(&run.join("report.html"));
    assert!(page.len() <= SIZE_MAX, "{} bytes", page.len());
    for words in [
        "A load drops into the aisle",
        ">pass</b>",
        "<h2>Expectations</h2>",
        "replans because of an obstacle",
        "<h2>Events</h2>",
        "load appears",
        "cause obstacle",
        "<h2>Computing</h2>",
        "<h2>Services</h2>",
        "zeronav-global-planner",
        ">zeronav run blocked_aisle --lockstep",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let mut browser = Browser::start(1200, 900);
    browser.open_file(&run.join("report.html"));
    browser.wait_until("the page does", "document.body.classList.contains('plays')");
    play(&mut browser);
    browser.script("1"); // Whatever came before has come.
    let asked = browser.requests.clone();
    let foreign = |url: &&String| !url.starts_with("file:") && !url.starts_with("data:");
    assert_eq!(asked.iter().find(foreign), None, "nothing from the network");
    assert_eq!(browser.problems, [""; 0]);

    // Written again it is the same, wherever that is asked for.
    std::fs::remove_file(run.join("report.html")).expect("removed");
    let run = run
        .strip_prefix(ended.folder.path())
        .expect("inside")
        .to_owned();
    let again = run_in(ended.folder, &["report", run.to_str().expect("a path")]);
    assert_eq!(again.code(), 0, "{}", again.stderr);
    let file = again.stdout.trim_end();
    assert_eq!(Path::new(file), run.join("report.html"));
    assert!(
        text(&again.folder.path().join(file)) == page,
        "the same page"
    );
}

/// In lockstep there are no latencies, so this drive takes its time.
#[test]
fn a_report_in_real_time_has_every_hop() {
    let _turn = real_time_turn();
    let folder = tempfile::tempdir().expect("a working folder");
    std::fs::write(folder.path().join("test.toml"), short_drive("")).expect("written");
    let ended = run_in(folder, &["run", "test.toml", "--headless", "--json"]);
    let result = ended.json();
    let reactions = result["latency"]["reaction"]["n"]
        .as_u64()
        .expect("a number");
    assert!(reactions > 5, "{result:#}");
    let page = text(&folder_of(&ended).join("report.html"));
    assert!(
        page.contains(&format!("<b>reaction</b> n = {reactions}")),
        "a histogram of all"
    );
    let slowest = page
        .split("<h3>Slowest reactions</h3>")
        .nth(1)
        .expect("the slowest");
    let slowest = slowest.split("</section>").next().expect("its end");
    assert_eq!(slowest.matches("<tr><td>").count(), 10);
    for hop in [
        "robot",
        "to_local_planner",
        "local_planner",
        "to_collision_guard",
        "collision_guard",
    ] {
        assert_eq!(
            slowest.matches(&format!("<title>{hop} ")).count(),
            10,
            "{hop}"
        );
    }
    for hop in ["to mapping", "global planner", "to robot"] {
        assert!(page.contains(&format!("<td>{hop}</td>")), "{hop}");
    }
}

#[test]
fn text_of_a_scenario_does_no_harm() {
    let evil = "</script><script>document.title='owned'</script><img src=x onerror=document.title='owned'>";
    let world = format!(
        "[[world.obstacles]]\nname = \"{evil}\"\nappears = {{ at_s = 0.5 }}\n\
         shape = {{ kind = \"box\", centre_m = [3.0, 3.0], size_m = [0.4, 0.4] }}\n"
    );
    let scenario = short_drive(&world).replace("A room", evil);
    let ended = drive(&scenario, &[]);
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    let page = text(&folder_of(&ended).join("report.html"));
    assert!(
        page.matches("&lt;/script&gt;").count() >= 2,
        "title and event"
    );
    assert!(!page.contains("<script>document") && !page.contains("<img src=x"));
    let mut browser = Browser::start(800, 800);
    browser.open_file(&folder_of(&ended).join("report.html"));
    browser.wait_until("the page does", "document.body.classList.contains('plays')");
    let next =
        "document.getElementById('next').click(), document.getElementById('said').textContent";
    let said: Vec<String> = (0..6)
        .map(|_| browser.script(next).as_str().unwrap_or_default().to_owned())
        .collect();
    let title = browser.script("document.title");
    assert!(
        !title.as_str().expect("a title").contains("owned"),
        "{title}"
    );
    assert!(
        said.iter().any(|said| said.contains("</script>")),
        "{said:?}"
    );
    assert_eq!(browser.problems, [""; 0]);
}

#[test]
fn a_narrow_page_does_not_scroll_sideways() {
    let ended = drive(&short_drive(""), &[]);
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    let mut browser = Browser::start(390, 800);
    browser.open_file(&folder_of(&ended).join("report.html"));
    for scheme in ["light", "dark"] {
        let features = serde_json::json!({ "name": "prefers-color-scheme", "value": scheme });
        browser.call(
            "Emulation.setEmulatedMedia",
            serde_json::json!({ "features": [features] }),
        );
        let wide = browser.script("document.documentElement.scrollWidth");
        assert!(
            wide.as_u64().is_some_and(|wide| wide <= 390),
            "{scheme}: {wide}"
        );
    }
    assert_eq!(browser.problems, [""; 0]);
}

#[test]
fn only_failures_are_reported_where_that_is_asked_for() {
    let passing = short_drive("");
    let failing = passing.clone() + "\n[expect]\noutcome = \"timeout\"\n";
    for (scenario, code, is_reported) in [(passing, 0, false), (failing, 1, true)] {
        let ended = drive(&scenario, &["--report-failures-only"]);
        assert_eq!(ended.code(), code, "{}", ended.stderr);
        let run = folder_of(&ended);
        assert_eq!(run.join("report.html").exists(), is_reported);
        let recording: serde_json::Value =
            serde_json::from_str(&text(&run.join("recording.json"))).expect("JSON");
        assert_eq!(recording["scene"].is_object(), is_reported);
    }
}

#[test]
fn a_stack_that_stayed_up_has_a_report() {
    let up = Up::start(&["open_aisle", "--lockstep"]);
    up.ask(&["goal", "6.0", "8.5", "0.0", "--wait"], 0);
    up.ask(&["down"], 0);
    let ended = up.stack.finish();
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
    let run = folder_of(&ended);
    let page = text(&run.join("report.html"));
    for words in [
        "1 of 1 goals reached",
        "by hand: reached",
        "id=\"data\"",
        "<h2>Services</h2>",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let mut browser = Browser::start(1000, 800);
    browser.open_file(&run.join("report.html"));
    browser.wait_until("the page does", "document.body.classList.contains('plays')");
    let at_start = pixels(&mut browser);
    browser.press("End");
    assert!(pixels(&mut browser) != at_start, "it has driven");
    assert_eq!(browser.problems, [""; 0]);
    assert!(run.join("run.svg").exists() && run.join("recording.json").exists());
}

#[test]
fn runs_are_compared_side_by_side() {
    let scenario = short_drive("");
    let slow = scenario.replace("v_mps_max = 1.0", "v_mps_max = 0.5");
    let folder = tempfile::tempdir().expect("a working folder");
    let mut runs = Vec::new();
    for text in [&scenario, &scenario, &slow] {
        let ended = drive(text, &[]);
        assert_eq!(ended.code(), 0, "{}", ended.stderr);
        let name = format!("run{}", runs.len());
        let kept = folder.path().join(&name);
        std::fs::rename(folder_of(&ended), &kept).expect("moved");
        runs.push((name, ended.json()));
    }
    let by_s = |at: usize| {
        let times = [0, at].map(|at| runs[at].1["time_s"].as_f64().expect("a time"));
        times[1] - times[0]
    };
    assert!(by_s(1).abs() < 1e-9, "lockstep");
    let slower = format!("+{:.2} s (+", by_s(2));
    let names: Vec<&str> = runs.iter().map(|(name, _)| name.as_str()).collect();
    let ended = run_in(
        folder,
        &[&["report"], &names[..], &["-o", "three.html"]].concat(),
    );
    assert_eq!((ended.code(), ended.stdout.trim_end()), (0, "three.html"));
    let page = text(&ended.folder.path().join("three.html"));
    let row = page.split("<tr><td>run time</td>").nth(1).expect("a row");
    let row = row.split("</tr>").next().expect("its end");
    assert_eq!(row.matches("no difference").count(), 1, "{row}");
    assert!(row.contains(&slower), "{slower}: {row}");
    assert!(page.contains("computing of mapping, p50"));
    let mut browser = Browser::start(1000, 800);
    browser.open_file(&ended.folder.path().join("three.html"));
    assert_eq!(browser.problems, [""; 0]);
}

#[test]
fn foreign_folders_give_one_clear_line() {
    let cases: [(&[(&str, &str)], &str); 6] = [
        (&[], "result.json"),
        (&[("result.json", "{")], "no result of a run"),
        (&[("result.json", "[]")], "no result of a run"),
        (
            &[("result.json", "{\"suite\": \"barn\"}")],
            "one of its runs",
        ),
        (
            &[("result.json", "{\"verdict\": \"pass\"}")],
            "missing field",
        ),
        (&[("result.json/x", "")], "not a file"),
    ];
    for (files, problem) in cases {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("theirs")).expect("made");
        for (name, text) in files {
            let file = folder.path().join("theirs").join(name);
            std::fs::create_dir_all(file.parent().expect("a folder")).expect("made");
            std::fs::write(file, text).expect("written");
        }
        let ended = run_in(folder, &["report", "theirs"]);
        assert_eq!(ended.code(), 2, "{files:?}: {}", ended.stderr);
        assert!(
            ended.stderr.contains(problem),
            "{problem}: {}",
            ended.stderr
        );
        assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
    }
    let nowhere = zeronav(&["report", "nowhere"]);
    assert_eq!(nowhere.code(), 2);
    assert!(
        nowhere.stderr.contains("nowhere: no such folder"),
        "{}",
        nowhere.stderr
    );
    assert_eq!(zeronav(&["report"]).code(), 2);

    // A run of which others have broken a part.
    let ended = drive(&short_drive(""), &[]);
    let run = folder_of(&ended);
    let recording = run.join("recording.json");
    std::fs::write(&recording, "{}").expect("written");
    let run = run
        .strip_prefix(ended.folder.path())
        .expect("inside")
        .to_owned();
    let run = run.to_str().expect("a path");
    let broken = run_in(ended.folder, &["report", run]);
    assert_eq!(broken.code(), 2);
    assert!(
        broken.stderr.contains("recording.json: missing field"),
        "{}",
        broken.stderr
    );
    // Without it there is a report without a player.
    std::fs::remove_file(broken.folder.path().join(run).join("recording.json")).expect("removed");
    let without = run_in(broken.folder, &["report", run]);
    assert_eq!(without.code(), 0, "{}", without.stderr);
    let page = text(&without.folder.path().join(without.stdout.trim_end()));
    assert!(page.contains("it cannot be played") && page.contains("<h2>Services</h2>"));
}

#[test]
fn a_picture_is_a_still_or_animated() {
    let ended = drive(&short_drive(""), &[]);
    let run = folder_of(&ended);
    let still = text(&run.join("run.svg"));
    let run = run
        .strip_prefix(ended.folder.path())
        .expect("inside")
        .to_owned();
    let run = run.to_str().expect("a path");
    std::fs::remove_file(ended.folder.path().join(run).join("run.svg")).expect("removed");
    let drawn = run_in(ended.folder, &["picture", run]);
    assert_eq!(drawn.code(), 0, "{}", drawn.stderr);
    let file = drawn.folder.path().join(drawn.stdout.trim_end());
    assert!(text(&file) == still, "the picture that the run has left");
    assert!(!still.contains("<animate"));
    let drawn = run_in(drawn.folder, &["picture", run, "-o", "x.svg", "--animated"]);
    assert_eq!((drawn.code(), drawn.stdout.trim_end()), (0, "x.svg"));
    let animated = text(&drawn.folder.path().join("x.svg"));
    assert!(animated.contains("<animate"));
    let drawn = run_in(drawn.folder, &["draw", run]);
    assert_eq!(drawn.code(), 0, "{}", drawn.stderr);
    let same = text(&drawn.folder.path().join(drawn.stdout.trim_end()));
    assert!(same == animated, "draw is picture --animated");
}
