//! The contract in C++: the system's compiler accepts the header, reads the same bytes as Rust, and
//! rejects a header whose fields are not those of the contract.

use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;
use zeronav_msgs::header::{Header, Id, Parents, Stamps};
use zeronav_msgs::role::Role;
use zeronav_msgs::task::{EndReason, StuckCause, TaskState, TaskStatus};
use zeronav_msgs::topics::{Envelope, TaskState as Status, Topic, topics};
use zeronav_tests::workspace;

const HEADER: &str = "services/cpp/zeronav.hpp";

/// Compiles `program` against `header` in a folder, with every warning an error.
fn compile(folder: &Path, header: &str, program: &str) -> Output {
    std::fs::write(folder.join("zeronav.hpp"), header).expect("written");
    std::fs::write(folder.join("program.cpp"), program).expect("written");
    Command::new("g++")
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
        spare: 0,
    };
    let message = <Status as Topic>::Envelope::new(header, status);
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
                && meta.recoveries == 4
                && meta.cause == static_cast<std::uint16_t>(StuckCause::no_progress);
            std::printf("%d %.2f", right, meta.remaining_m);
        }
    "#;
    assert_eq!(said(program, bytemuck::bytes_of(&message)), "1 12.25");
}

/// Two swapped fields of equal size, a renamed field, a wrong length: each is an error.
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
