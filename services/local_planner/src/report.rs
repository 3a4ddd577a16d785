//! What an answer of the local planner says about its inputs and its recovery.

use zeronav_local_planner::Outputs;
use zeronav_local_planner::staleness::StaleInput;
use zeronav_msgs::health::{REASON_MAP, REASON_ODOMETRY, REASON_PATH, REASON_SCAN};
use zeronav_shell::Shell;

/// Reports in the heartbeat which inputs are old.
pub(crate) fn report(shell: &mut Shell, outputs: &Outputs) {
    for (input, bit) in [
        (StaleInput::Odometry, REASON_ODOMETRY),
        (StaleInput::Scan, REASON_SCAN),
        (StaleInput::Map, REASON_MAP),
        (StaleInput::Path, REASON_PATH),
    ] {
        // A pose that nobody knows comes with the map.
        let of_map = input == StaleInput::Map && outputs.stale == Some(StaleInput::Pose);
        shell.reason(
            bit,
            of_map || outputs.stale == Some(input) || outputs.ageing.includes(input),
        );
    }
}

/// Logs what the recovery does.
pub(crate) fn log(outputs: &Outputs) {
    if let Some(change) = outputs.recovery {
        tracing::info!(from = ?change.from, to = ?change.to, reason = ?change.reason, "recovery");
    }
}
