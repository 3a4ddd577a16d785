//! The contract in C++: the system's compiler accepts the header, reads the same bytes as Rust, and
//! rejects a header whose fields are not those of the contract. Services in C++ on the real stack.

use rustix::process::Signal;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use tempfile::TempDir;
use zeronav_msgs::header::{Header, Id, Parents, Stamps};
use zeronav_msgs::role::Role;
use zeronav_msgs::task::{EndReason, StuckCause, TaskState, TaskStatus};
use zeronav_msgs::topics::{TaskState as Status, Topic, seal, topics};
use zeronav_tests::rooms::box_in_an_aisle;
use zeronav_tests::{
    Stranger, Zeronav, background, binaries, real_time_turn, send_signal, workspace,
};

const HEADER: &str = "services/cpp/zeronav.hpp";

/// Compiles `program` against `header` in a folder, with every warning an error.
fn compile(folder: &Path, header: &str, program: &str) -> Output {
    std::fs::write(folder.join("zeronav.hpp"), header).expect("written");
    std::fs::write(folder.join("program.cpp"), program).expect("written");
    background("g++")
        .args(["-std=c++17", "-O1", "-Wall", "-Wextra", "-Wconversion"])
        .args(["-pedantic", "-Werror", "program.cpp", "-o", "program"])
        .current_dir(folder)
        .output()
        .unwrap_or_else(|error| panic!("g++: {error}; install g++"))
}

fn header() -> String {
    std::fs::read_to_string(workspace().join(HEADER)).expect("the header")
}

/// What `program` prints, given `input` as its file `input`.
fn said(program: &str, input: &[u8]) -> String {
    let folder = TempDir::new().expect("a folder");
    let compiled = compile(folder.path(), &header(), program);
    let errors = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{errors}");
    std::fs::write(folder.path().join("input"), input).expect("written");
    let ran = Command::new(folder.path().join("program"))
        .current_dir(folder.path())
        .output()
        .expect("it runs");
    assert!(ran.status.success(), "{ran:?}");
    String::from_utf8(ran.stdout).expect("text")
}

#[test]
fn topics_are_the_same_in_cpp() {
    let program = r#"
        #include "zeronav.hpp"
        #include <cstdio>
        using namespace zeronav;

        template <typename T> void print(T) {
            std::size_t envelope = 0;
            if constexpr (!std::is_void_v<typename T::Envelope>) {
                envelope = sizeof(typename T::Envelope);
            }
            std::printf("%zu %s %zu %zu %016llx %zu %zu", T::NUMBER, T::NAME, envelope,
                        sizeof(typename T::Item), static_cast<unsigned long long>(T::SCHEMA),
                        T::LEN_MAX, T::BUFFER);
            for (Role role : T::WRITERS) std::printf(" w%d", static_cast<int>(role));
            for (Role role : T::RINGS) std::printf(" r%d", static_cast<int>(role));
            for (Role role : T::RINGS_IN_LOCKSTEP) std::printf(" l%d", static_cast<int>(role));
            std::printf("\n");
        }

        int main() {
            std::apply([](auto... topic) { (print(topic), ...); }, topics::All{});
        }
    "#;
    let mut expected = String::new();
    for row in topics() {
        let mut line = format!(
            "{} {} {} {} {:016x} {} {}",
            row.number,
            row.name,
            row.envelope_bytes,
            row.item_bytes,
            row.schema,
            row.len_max,
            row.service_buffer()
        );
        for (sign, roles) in [
            ("w", row.writers),
            ("r", row.rings),
            ("l", row.rings_in_lockstep),
        ] {
            for role in roles {
                let word = format!(" {sign}{}", role.code());
                line += &word;
            }
        }
        expected += &line;
        expected.push('\n');
    }
    assert_eq!(said(program, &[]), expected);
}

#[test]
fn the_bytes_of_a_message_mean_the_same_in_cpp() {
    let header = Header {
        role: Role::LocalPlanner.code(),
        schema: u32::try_from(Status::ROW.schema & 0xffff_ffff).expect("32 bits"),
        id: Id::new(3, 17).0,
        tick: 99,
        capture_ns: u64::MAX,
        parents: Parents {
            goal: 5,
            ..Parents::default()
        },
        stamps: Stamps {
            published_ns: 123_456_789,
            ..Stamps::default()
        },
        ..Header::default()
    };
    let status = TaskStatus {
        state: TaskState::Failed.code(),
        reason: EndReason::Stuck.code(),
        n_ended: 2,
        task: 5,
        goal: 8,
        remaining_m: 12.25,
        recoveries: 4,
        cause: StuckCause::NoProgress.code(),
        block_m: [3.5, -1.25],
        ..TaskStatus::default()
    };
    let message = seal::<Status>(header, status, &[]);
    let program = r#"
        #include "zeronav.hpp"
        #include <cstdio>
        using namespace zeronav;

        int main() {
            topics::task_status::Envelope message;
            std::FILE* file = std::fopen("input", "rb");
            if (!file || std::fread(&message, sizeof message, 1, file) != 1) return 1;
            const auto& head = message.header;
            const auto& meta = message.meta;
            bool right = head.role == static_cast<std::uint16_t>(Role::local_planner)
                && head.schema == static_cast<std::uint32_t>(topics::task_status::SCHEMA)
                && head.id == ((3ull << 40) | 17) && head.tick == 99 && head.run_ns == 0
                && head.capture_ns == ~0ull && head.parents.goal == 5
                && head.stamps.published_ns == 123456789
                && meta.state == static_cast<std::uint16_t>(TaskState::failed)
                && meta.reason == static_cast<std::uint16_t>(EndReason::stuck)
                && meta.n_ended == 2 && meta.task == 5 && meta.goal == 8
                && meta.recoveries == 4 && meta.block_m[0] == 3.5 && meta.block_m[1] == -1.25
                && meta.cause == static_cast<std::uint16_t>(StuckCause::no_progress);
            std::printf("%d %.2f", right, meta.remaining_m);
        }
    "#;
    assert_eq!(said(program, bytemuck::bytes_of(&message)), "1 12.25");
}

/// A renamed field, a wrong size, a wrong length, another type and another version: each is an error.
#[test]
fn a_header_that_is_not_the_contract_does_not_compile() {
    let good = header();
    let program = "#include \"zeronav.hpp\"\nint main() {}\n";
    let folder = TempDir::new().expect("a folder");
    assert!(compile(folder.path(), &good, program).status.success());
    for (from, to) in [
        ("double v_mps{};", "double w_radps_{};"),
        ("std::uint32_t n_tiles{};", "std::uint64_t n_tiles{};"),
        ("double covariance[6]{};", "double covariance[7]{};"),
        ("float range_m_min{};", "std::uint32_t range_m_min{};"),
        ("\"zeronav.Pose.v1\"", "\"zeronav.Pose.v2\""),
    ] {
        assert!(good.contains(from), "{from}");
        let wrong = good.replacen(from, to, 1);
        let compiled = compile(folder.path(), &wrong, program);
        let errors = String::from_utf8_lossy(&compiled.stderr);
        assert!(!compiled.status.success(), "{to} was accepted");
        let named = errors.contains("static assertion failed") || errors.contains("has no member");
        assert!(named, "{errors}");
    }
}

/// The example in the README compiles.
#[test]
fn the_example_of_the_readme_compiles() {
    let page = std::fs::read_to_string(workspace().join("services/cpp/README.md"));
    let page = page.expect("the README");
    let block = page.split("```cpp\n").nth(1).expect("an example");
    let lines = block.split("```").next().expect("its end");
    let (include, rest) = lines.split_once('\n').expect("lines");
    let program = format!("{include}\nint main() {{\n{rest}\nreturn request.v_mps > 0;\n}}\n");
    said(&program, &[]);
}

/// The library that services in C++ are linked with.
fn library() -> PathBuf {
    binaries().join("libzeronav_cpp.a")
}

/// Compiles a service with every warning an error.
fn build(source: &Path, program: &Path) {
    let output = Command::new("g++")
        .args(["-std=c++17", "-O2", "-Wall", "-Wextra", "-Wconversion"])
        .args(["-pedantic", "-Werror", "-I"])
        .arg(workspace().join("services/cpp"))
        .arg(source)
        .arg(library())
        .args(["-lpthread", "-ldl", "-lm", "-o"])
        .arg(program)
        .output()
        .unwrap_or_else(|error| panic!("g++: {error}; install g++"));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
}

/// The example guard, compiled once.
fn guard() -> &'static Path {
    static GUARD: OnceLock<PathBuf> = OnceLock::new();
    GUARD.get_or_init(|| {
        let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("guard");
        build(
            &workspace().join("services/cpp/examples/guard.cpp"),
            &program,
        );
        program
    })
}

/// Drives past a box in an aisle with the example guard.
fn start(flags: &[&str]) -> Zeronav {
    let folder = TempDir::new().expect("a folder");
    let text = box_in_an_aisle();
    let binary = guard().display();
    let text = format!("{text}\n[services.collision_guard]\nbinary = \"{binary}\"\n");
    std::fs::write(folder.path().join("it.toml"), text).expect("written");
    let arguments = ["run", "./it.toml", "--headless", "--json"];
    Zeronav::start_in(folder, &[&arguments[..], flags].concat())
}

fn assert_arrived(result: &Value) {
    assert_eq!(result["reached"], true, "{result:#}");
    assert_eq!(result["contacts"], 0, "{result:#}");
}

#[test]
fn a_guard_in_cpp_drives_the_same_way_twice() {
    let drive = || start(&["--lockstep"]).finish().expect(0);
    let (first, second) = (drive(), drive());
    assert_arrived(&first);
    assert_eq!(first["verdict"], "pass", "{first:#}");
    assert_eq!(first["restarts"], serde_json::json!([]), "{first:#}");
    let services = first["services"].as_array().expect("services");
    let seat = services
        .iter()
        .find(|seat| seat["name"] == "collision_guard");
    assert_eq!(seat.expect("a guard")["binary"], "guard");
    assert!(first["run_hash"].is_string(), "{first:#}");
    assert_eq!(first["run_hash"], second["run_hash"]);
}

#[test]
fn in_real_time_a_guard_in_cpp_keeps_up() {
    let _turn = real_time_turn();
    let result = start(&[]).finish().expect(0);
    assert_arrived(&result);
    assert_eq!(result["verdict"], "pass", "{result:#}");
    assert_eq!(result["restarts"], serde_json::json!([]), "{result:#}");
    let hops = result["latency"]["every_scan"]["direct"].as_array();
    let of_guard = |hop: &&Value| hop["name"] == "collision_guard";
    let guard = hops.and_then(|hops| hops.iter().find(of_guard));
    let n = guard.and_then(|hop| hop["n"].as_u64());
    assert!(n.is_some_and(|n| n > 40), "{hops:#?}");
}

#[test]
fn a_killed_guard_in_cpp_comes_back() {
    let mut run = start(&["--lockstep"]);
    run.wait_until("the robot is on its way", |run| {
        let report = run.report().unwrap_or_default();
        report["time_s"].as_f64().is_some_and(|now_s| now_s >= 3.0)
    });
    let guard = run.service("collision_guard").expect("the guard");
    assert!(send_signal(guard, Signal::KILL));
    let result = run.finish().expect(0);
    assert_arrived(&result);
    let restarts = result["restarts"].as_array().expect("restarts");
    assert_eq!(restarts.len(), 1, "{result:#}");
    assert_eq!(restarts[0]["service"], "collision_guard", "{result:#}");
}

/// An exception does not cross the border between the languages: it ends the process with its text.
#[test]
fn a_service_in_cpp_that_throws_ends_as_a_crash() {
    let folder = TempDir::new().expect("a folder");
    let source = folder.path().join("thrower.cpp");
    let text = "#include \"zeronav_service.hpp\"\n\
        #include <stdexcept>\n\
        struct Thrower {\n\
            static constexpr auto ROLE = zeronav::Role::collision_guard;\n\
            explicit Thrower(const zeronav::Shell&) {}\n\
            void wake(const zeronav::Shell&, std::uint64_t) {\n\
                throw std::runtime_error(\"no idea\");\n\
            }\n\
        };\n\
        int main() { return zeronav::run<Thrower>(); }\n";
    std::fs::write(&source, text).expect("written");
    let program = folder.path().join("thrower");
    build(&source, &program);
    let program = program.to_str().expect("a path");
    let flags = ["run", "unsealed", "--lockstep", "--headless", "--json"];
    let external = ["--external", "collision_guard"];
    let mut run = Zeronav::start(&[&flags[..], &external[..]].concat());
    run.wait_until("the others run", |run| run.children().len() == 4);
    run.wait_until("they know their domain", |run| run.domains().len() == 1);
    let root = run.domains().pop().expect("a domain");
    let (code, log) = Stranger::start(program, &root, &["--epoch", "0"]).left();
    assert_eq!(code, 2, "{log}");
    let (code, log) = Stranger::start(program, &root, &["--epoch", "1"]).left();
    assert_eq!(code, 1, "{log}");
    assert!(log.contains("the service failed: no idea"), "{log}");
}

#[test]
fn a_seat_that_no_service_in_cpp_can_take_is_an_error_of_usage() {
    let folder = TempDir::new().expect("a folder");
    let source = folder.path().join("robot.cpp");
    let text = "#include \"zeronav_service.hpp\"\n\
        struct Robot {\n\
            static constexpr auto ROLE = zeronav::Role::robot;\n\
            explicit Robot(const zeronav::Shell&) {}\n\
            void wake(const zeronav::Shell&, std::uint64_t) {}\n\
        };\n\
        int main() { return zeronav::run<Robot>(); }\n";
    std::fs::write(&source, text).expect("written");
    let program = folder.path().join("robot");
    build(&source, &program);
    let output = Command::new(program)
        .args(["--domain", "/nowhere", "--epoch", "1"])
        .output()
        .expect("it runs");
    let log = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{log}");
    assert!(
        log.starts_with("no service in C++ can take the seat robot;"),
        "{log}"
    );
    assert_eq!(log.lines().count(), 1, "{log}");
}
