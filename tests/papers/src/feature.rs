//! The acceptance tests of one row of the feature table.

use std::path::Path;
use std::process::{Command, Stdio};

/// Features with the packages that test them. A test's name begins with the key, in lower case and
/// with underscores.
pub const FEATURES: &[(&str, &[&str])] = &[
    ("C-GRID", &["zeronav-papers"]),
    ("C-GEN", &["zeronav-papers"]),
    ("C-ASTAR", &["zeronav-global-planner"]),
    ("C-LOS", &["zeronav-global-planner"]),
    ("C-EDT", &["zeronav-mapping"]),
    ("C-COLL", &["zeronav-world"]),
    ("TN-REG", &["zeronav-global-planner", "zeronav-mapping"]),
    ("TN-SW", &["zeronav-global-planner"]),
    ("TN-APF", &["zeronav-global-planner"]),
    ("TN-3N", &["zeronav-global-planner"]),
    ("TN-HYB", &["zeronav-global-planner"]),
    ("TN-A8", &["zeronav-global-planner"]),
    ("JU-ASTAR", &["zeronav-global-planner"]),
    ("JU-APF", &["zeronav-local-planner"]),
    ("JU-R6", &["zeronav-local-planner"]),
    ("JU-R7", &["zeronav-local-planner"]),
    ("JU-FUSION", &["zeronav-local-planner", "zeronav-papers"]),
    ("ZM-TRA", &["zeronav-global-planner"]),
    ("ZM-HW", &["zeronav-global-planner"]),
    ("ZM-IM", &["zeronav-global-planner"]),
    ("ZM-REP", &["zeronav-local-planner"]),
    ("ZM-ESC", &["zeronav-local-planner"]),
    ("ZM-RV", &["zeronav-local-planner"]),
    ("ZM-FULL", &["zeronav-local-planner"]),
    ("LWX-TA", &["zeronav-global-planner"]),
    ("LWX-OA", &["zeronav-global-planner"]),
    ("LWX-BI", &["zeronav-global-planner"]),
    ("LWX-APF", &["zeronav-local-planner"]),
    ("LWX-OAPF", &["zeronav-local-planner", "zeronav-papers"]),
    ("LWX-ITER", &["zeronav-local-planner"]),
    ("LWX-LSQ", &["zeronav-local-planner", "zeronav-papers"]),
    ("LWX-ACO", &["zeronav-global-planner"]),
    ("LWX-RRT", &["zeronav-global-planner"]),
    ("LWX-FUSION", &["zeronav-local-planner", "zeronav-papers"]),
    ("LWX-DYN", &["zeronav-tests"]),
    ("BAO-TAA", &["zeronav-global-planner"]),
    ("BAO-AAO", &["zeronav-global-planner"]),
    ("BAO-IAA", &["zeronav-global-planner"]),
    ("BAO-DIJ", &["zeronav-global-planner"]),
    ("BAO-FULL", &["zeronav-global-planner", "zeronav-mapping"]),
    ("BAO-SPL", &["zeronav-global-planner"]),
    ("BAO-DWA", &["zeronav-local-planner"]),
    ("BAO-DYN", &["zeronav-tests"]),
];

/// Why a feature was not tested.
#[derive(Debug, thiserror::Error)]
pub enum FeatureError {
    /// No feature has this key.
    #[error("no feature is called \"{key}\"; there are: {}", keys())]
    Unknown {
        /// The key asked for.
        key: String,
    },
    /// No cargo.
    #[error("cargo does not run: {0}")]
    Cargo(#[from] std::io::Error),
    /// The key has no test, which would pass for one that has.
    #[error("no test of {package} begins with {prefix}")]
    NoTest {
        /// Package.
        package: &'static str,
        /// Begin of the tests' names.
        prefix: String,
    },
    /// A test failed.
    #[error("{package}: a test of {key} failed, see above")]
    Failed {
        /// Package.
        package: &'static str,
        /// The key asked for.
        key: String,
    },
}

fn keys() -> String {
    let keys: Vec<&str> = FEATURES.iter().map(|(key, _)| *key).collect();
    keys.join(", ")
}

/// Runs the tests of a feature with cargo; gives their number.
///
/// # Errors
/// See [`FeatureError`].
pub fn test(key: &str) -> Result<usize, FeatureError> {
    let (_, packages) = FEATURES
        .iter()
        .find(|(known, _)| known.eq_ignore_ascii_case(key))
        .ok_or_else(|| FeatureError::Unknown {
            key: key.to_owned(),
        })?;
    let prefix = key.to_lowercase().replace('-', "_") + "_";
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut passed = 0;
    for package in *packages {
        let output = Command::new(&cargo)
            .args(["test", "--package", package, "--", &prefix])
            .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")))
            .stdin(Stdio::null())
            .stderr(Stdio::inherit())
            .output()?;
        let text = String::from_utf8_lossy(&output.stdout);
        print_lines(&text, &prefix);
        if !output.status.success() {
            let key = key.to_owned();
            return Err(FeatureError::Failed { package, key });
        }
        let found = text.lines().filter(|line| is_passed(line, &prefix)).count();
        if found == 0 {
            return Err(FeatureError::NoTest { package, prefix });
        }
        passed += found;
    }
    Ok(passed)
}

/// True for the line of a test of the feature that passed.
fn is_passed(line: &str, prefix: &str) -> bool {
    line.starts_with("test ") && line.ends_with(" ... ok") && line.contains(prefix)
}

#[allow(clippy::print_stdout, reason = "what the tests say is the answer")]
fn print_lines(text: &str, prefix: &str) {
    for line in text.lines() {
        let told = line.starts_with("test ") && line.contains(prefix);
        if told || line.starts_with("test result: FAILED") || line.starts_with("thread ") {
            println!("{line}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_feature_names_the_known_ones() {
        let error = test("XY-1").unwrap_err().to_string();
        assert!(
            error.contains("\"XY-1\"") && error.contains("TN-HYB"),
            "{error}"
        );
    }

    #[test]
    fn only_tests_that_passed_count() {
        assert!(is_passed(
            "test papers::zm::zm_esc_leaves ... ok",
            "zm_esc_"
        ));
        assert!(!is_passed(
            "test papers::zm::zm_esc_leaves ... FAILED",
            "zm_esc_"
        ));
        assert!(!is_passed(
            "test papers::zm::zm_rv_pushes ... ok",
            "zm_esc_"
        ));
    }
}
