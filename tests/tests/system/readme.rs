//! The READMEs say what the code says: topics, commands, scenarios, links, examples.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use zeronav_global_planner::PLANNERS;
use zeronav_msgs::role::Role;
use zeronav_msgs::seats::{Answers, SEATS, SeatRow};
use zeronav_msgs::topics::{Discipline, TopicRow, topics};
use zeronav_tests::results::readmes;
use zeronav_tests::{Zeronav, workspace, zeronav};

fn read(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

fn page(name: &str) -> String {
    read(&workspace().join(name))
}

/// Every page for people: READMEs and the pages at the top.
fn pages() -> Vec<PathBuf> {
    let mut pages = readmes();
    pages.extend(["CONTRIBUTING.md", "CHANGELOG.md"].map(|name| workspace().join(name)));
    pages
}

/// The code blocks of a page in a language.
fn blocks(text: &str, language: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut open: Option<(bool, String)> = None;
    for line in text.lines() {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(name)) => open = Some((name == language, String::new())),
            (Some((wanted, block)), Some(_)) => {
                if *wanted {
                    blocks.push(std::mem::take(block));
                }
                open = None;
            }
            (Some((_, block)), None) => {
                block.push_str(line);
                block.push('\n');
            }
            (None, None) => {}
        }
    }
    blocks
}

/// The text without comments, links' targets and code blocks.
fn words_of(text: &str) -> usize {
    let mut prose = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("<!--") {
        prose += before;
        rest = after.split_once("-->").map_or("", |(_, after)| after);
    }
    (prose + rest).split_whitespace().count()
}

/// The anchor of a heading, as GitHub makes it.
fn anchor(heading: &str) -> String {
    let text = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = text
        .chars()
        .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let mut broken = Vec::new();
    let mut links = 0;
    for page in pages() {
        let text = read(&page);
        for part in text.split("](").skip(1) {
            let target = part.split(')').next().expect("the end of a link");
            if target.starts_with("http") {
                continue;
            }
            links += 1;
            let (file, heading) = target.split_once('#').unwrap_or((target, ""));
            let file = match file {
                "" => page.clone(),
                file => page.parent().expect("a folder").join(file),
            };
            let leads = file.exists()
                && (heading.is_empty() || {
                    let text = read(&file);
                    let mut headings = text.lines().filter(|line| line.starts_with('#'));
                    headings.any(|line| anchor(line) == heading)
                });
            if !leads {
                broken.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(links > 20, "{links} links");
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn the_front_page_is_short() {
    let words = words_of(&page("README.md"));
    assert!((700..=900).contains(&words), "{words} words");
}

#[test]
fn the_table_of_topics_is_that_of_the_code() {
    let text = page("msgs/README.md");
    let labels = |roles: &[Role]| match roles {
        [] => "-".to_owned(),
        roles => roles
            .iter()
            .map(|role| role.label())
            .collect::<Vec<_>>()
            .join(", "),
    };
    let rows: Vec<Vec<&str>> = text
        .lines()
        .filter(|line| line.starts_with("| `") && line.contains('/'))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let mut named = BTreeSet::new();
    for topic in topics()
        .iter()
        .filter(|topic| !topic.name.starts_with("health"))
    {
        let name = format!("`{}`", topic.name);
        let row = rows.iter().find(|row| row[0] == name);
        let row = row.unwrap_or_else(|| panic!("{name} is not in msgs/README.md"));
        let discipline = match topic.discipline {
            Discipline::Latest => "latest",
            Discipline::Latched => "latched",
            Discipline::Stream => "stream",
            Discipline::Records => "records",
        };
        let expected = [
            labels(topic.writers),
            labels(topic.rings),
            discipline.to_owned(),
        ];
        assert_eq!(row[2..], expected, "{name}");
        named.insert(name);
    }
    let unknown = rows.iter().filter(|row| !named.contains(row[0]));
    assert_eq!(unknown.count(), 0, "topics that are no longer there");
}

/// A row of the table of seats.
fn seat_line(seat: &SeatRow) -> String {
    let names = |rows: &[&TopicRow]| {
        let names: Vec<String> = rows.iter().map(|row| format!("`{}`", row.name)).collect();
        names.join(", ")
    };
    let writes: Vec<String> = (seat.writes().iter())
        .map(|row| {
            let owed = seat.owes.iter().any(|owed| owed.name == row.name);
            let bold = if owed { "**" } else { "" };
            // Topics without items have a slice of bytes that stays empty.
            let most = if row.item_bytes == 1 {
                String::new()
            } else {
                format!(" ({})", row.len_max)
            };
            format!("{bold}`{}`{bold}{most}", row.name)
        })
        .collect();
    let ticks = match seat.answers {
        Answers::EveryTick => "every tick",
        Answers::TicksWithScan => "ticks with a scan",
    };
    let after: Vec<String> = (seat.after.iter())
        .map(|role| format!(", after {}", role.label()))
        .collect();
    let (role, reads, writes) = (seat.role.label(), names(seat.reads), writes.join(", "));
    let (after, idle, without) = (after.concat(), names(seat.idle), seat.without_input);
    format!("| `{role}` | {ticks}{after} | {reads} | {writes} | {idle} | {without} |")
}

#[test]
fn the_table_of_seats_is_that_of_the_code() {
    let lines: Vec<String> = SEATS.iter().map(seat_line).collect();
    let table = lines.join("\n");
    let text = page("services/README.md");
    assert!(
        text.contains(&format!("|---|---|---|---|---|---|\n{table}\n\n")),
        "\n{table}"
    );
}

/// Identifiers of a source file; comments and tests are left out.
fn identifiers(source: &str) -> BTreeSet<String> {
    let code = source.split("#[cfg(test)]").next().unwrap_or_default();
    let code = code
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    code.flat_map(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_'))
        .map(str::to_owned)
        .collect()
}

/// Topics that the main program of a service opens itself or through a reader of the shell.
fn topics_of_main(folder: &str) -> BTreeSet<String> {
    let root = workspace().join("services").join(folder).join("src");
    let main = read(&root.join("main.rs"));
    let modules = main
        .lines()
        .filter_map(|line| line.strip_prefix("mod ")?.strip_suffix(';'));
    let mut found = identifiers(&main);
    for module in modules {
        found.extend(identifiers(&read(&root.join(format!("{module}.rs")))));
    }
    for (reader, file) in [
        ("CurrentGoal", "current_goal"),
        ("Tasks", "tasks"),
        ("MapInput", "map_input"),
        ("OdometryReader", "odometry"),
        ("ZoneInput", "zone_input"),
    ] {
        if found.contains(reader) {
            found.extend(identifiers(&page(&format!("services/shell/src/{file}.rs"))));
        }
    }
    // The macro's rows: `    RobotScan = 1 "robot/scan" {`.
    let declarations = page("msgs/src/topics.rs");
    let rows = declarations.lines().filter_map(|line| {
        let (name, rest) = line.strip_prefix("    ")?.split_once(" = ")?;
        let topic = rest.split('"').nth(1).filter(|topic| topic.contains('/'))?;
        found.contains(name).then(|| topic.to_owned())
    });
    rows.collect()
}

#[test]
fn stock_services_open_the_topics_of_their_seats() {
    for seat in &SEATS {
        let folder = match seat.role {
            Role::Robot => "robot_sim",
            role => role.label(),
        };
        let rows = seat.reads.iter().copied().chain(seat.writes());
        let expected: BTreeSet<String> = rows.map(|row| row.name.to_owned()).collect();
        assert_eq!(topics_of_main(folder), expected, "{folder}");
    }
}

#[test]
fn every_command_is_described() {
    let text = page("launch/README.md");
    let help = zeronav(&["--help"]);
    assert_eq!(help.code(), 0, "{}", help.stderr);
    let commands = help.stdout.split("Commands:").nth(1).expect("commands");
    let names: Vec<&str> = commands
        .lines()
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.strip_prefix("  ")?.split(' ').next())
        .filter(|name| !name.is_empty() && *name != "help")
        .collect();
    assert!(names.len() >= 9, "{names:?}");
    for name in names {
        assert!(
            text.contains(&format!("`zeronav {name}")),
            "{name} is not described"
        );
    }
}

#[test]
fn flags_in_examples_exist() {
    let mut checked = 0;
    for page in pages() {
        let blocks = blocks(&read(&page), "sh");
        let lines = blocks.iter().flat_map(|block| block.lines());
        for line in lines.filter(|line| line.starts_with("zeronav ")) {
            let words: Vec<&str> = line.split(" #").next().unwrap_or("").split(' ').collect();
            // The second word may be a verb of the first.
            let is_word = |word: &&&str| !word.starts_with('-');
            let verbs = words[1..].iter().take(2).take_while(is_word).copied();
            let help: Vec<&str> = verbs.chain(["--help"]).collect();
            let help = zeronav(&help);
            for flag in words.iter().filter(|word| word.starts_with("--")) {
                assert!(help.stdout.contains(flag), "{line}: {flag}");
                checked += 1;
            }
        }
    }
    assert!(checked > 5, "{checked} flags");
}

#[test]
fn packages_and_tests_in_examples_exist() {
    let mut checked = 0;
    for page in pages() {
        let blocks = blocks(&read(&page), "sh");
        for line in blocks.iter().flat_map(|block| block.lines()) {
            let words: Vec<&str> = line.split_whitespace().collect();
            if words.first() != Some(&"cargo") {
                continue;
            }
            for pair in words.windows(2) {
                let found = match pair[0] {
                    "-p" => page_of_package(pair[1]),
                    "--test" => is_test(pair[1]),
                    _ => continue,
                };
                assert!(found, "{}: {line}", page.display());
                checked += 1;
            }
        }
    }
    assert!(checked > 10, "{checked} names");
}

/// True for the name of a package of the workspace.
fn page_of_package(name: &str) -> bool {
    let manifest = page("Cargo.toml");
    manifest.contains(&format!("\n{name} = {{ path")) || name == "zeronav-tests"
}

/// True for a test program of a package.
fn is_test(name: &str) -> bool {
    let services = workspace().join("services").read_dir().expect("services");
    let mut folders: Vec<PathBuf> = services
        .map(|entry| entry.expect("an entry").path())
        .collect();
    folders.extend(["msgs", "launch", "tests"].map(|folder| workspace().join(folder)));
    let is_there = |folder: &PathBuf, file: &str| folder.join("tests").join(file).is_file();
    folders.iter().any(|folder| {
        is_there(folder, &format!("{name}.rs")) || is_there(folder, &format!("{name}/main.rs"))
    })
}

#[test]
fn the_planner_of_the_front_page_is_the_example() {
    let code = blocks(&page("README.md"), "rust");
    let example = page("services/shell/examples/own_planner/src/main.rs");
    assert_eq!(code.len(), 1);
    assert!(
        example.contains(&code[0]),
        "not in the example:\n{}",
        code[0]
    );
    assert_eq!(code[0].lines().count(), 10, "ten lines");
    let lines = format!("{} lines in all", example.lines().count());
    let text = page("README.md").replace('\n', " ");
    assert!(text.contains(&lines), "{lines}");
}

#[test]
fn planners_are_counted_and_groups_named() {
    let planners = format!("{} planners by name", PLANNERS.len());
    for name in ["README.md", "CHANGELOG.md"] {
        assert!(page(name).contains(&planners), "{name}: {planners}");
    }
    let list = zeronav(&["list", "--json"]);
    let list: serde_json::Value = serde_json::from_str(&list.stdout).expect("a list");
    let groups: BTreeSet<String> = texts(&list, "group");
    assert!(groups.len() >= 5, "{groups:?}");
    let text = page("launch/README.md");
    for group in groups {
        assert!(
            text.contains(&format!("| {group} | |")),
            "no table of group {group}"
        );
    }
}

/// Every text with this key, at any depth.
fn texts(value: &serde_json::Value, key: &str) -> BTreeSet<String> {
    use serde_json::Value;
    match value {
        Value::Array(all) => all.iter().flat_map(|one| texts(one, key)).collect(),
        Value::Object(map) => {
            let own = map.get(key).and_then(Value::as_str).map(str::to_owned);
            let inner = map.values().flat_map(|one| texts(one, key));
            own.into_iter().chain(inner).collect()
        }
        _ => BTreeSet::new(),
    }
}

#[test]
fn the_scenario_of_the_front_page_is_accepted() {
    let scenarios = blocks(&page("README.md"), "toml");
    let scenario = scenarios.iter().find(|block| block.contains("[robot]"));
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = scenario.expect("a scenario");
    std::fs::write(folder.path().join("mine.toml"), scenario).expect("written");
    // Ten metres by ten without anything.
    let image = [b"P5\n200 200\n255\n".as_slice(), &vec![254; 40_000]].concat();
    std::fs::write(folder.path().join("building.pgm"), image).expect("written");
    let yaml = "image: building.pgm\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n\
        occupied_thresh: 0.65\nfree_thresh: 0.196\n";
    std::fs::write(folder.path().join("building.yaml"), yaml).expect("written");
    let ended = Zeronav::start_in(folder, &["check", "mine.toml"]).finish();
    assert_eq!(ended.code(), 0, "{}", ended.stderr);
}

#[test]
fn the_version_names_the_commit() {
    let ended = zeronav(&["--version"]);
    let expected = format!("zeronav {} (commit ", env!("CARGO_PKG_VERSION"));
    let is_checkout = workspace().join(".git").exists();
    assert_eq!(
        ended.stdout.starts_with(&expected),
        is_checkout,
        "{}",
        ended.stdout
    );
    assert!(
        ended.stdout.starts_with(&expected[..expected.len() - 9]),
        "{}",
        ended.stdout
    );
}
