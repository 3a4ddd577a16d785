//! What is said of zones.

use super::tests::{path, says, standing};
use crate::why::around::Around;
use zeronav_measure::result::moment::{Command, Moment, Zone};
use zeronav_msgs::command::{Intervention, RequestCause, Validity};
use zeronav_msgs::map::ObstacleSource;
use zeronav_msgs::path::PathStatus;

fn zone(name: &str, limit_mps: Option<f64>) -> Zone {
    let name = name.to_owned();
    Zone { name, limit_mps }
}

/// A robot whose guard did that because of a zone.
fn held(intervention: Intervention, zone: Option<Zone>) -> Moment {
    let moment = standing(Validity::Drive, RequestCause::Free);
    let command = moment.command.map(|command| Command {
        intervention,
        ..command
    });
    Moment {
        command,
        zone,
        ..moment
    }
}

#[test]
fn a_zone_is_named_with_what_it_asks_for() {
    let around = Around::default();
    let slow = Moment {
        zone: Some(zone("ramp", Some(0.3))),
        ..standing(Validity::Drive, RequestCause::SpeedZone)
    };
    let words = [
        "slows down for the speed limit of a zone",
        "Slow: zone `ramp`, 0.3 m/s.",
    ];
    says(&slow, &around, &words);
    let slowed = held(Intervention::ZoneSlowed, Some(zone("ramp", Some(0.3))));
    says(
        &slowed,
        &around,
        &["collision guard slows down", "Slow: zone `ramp`, 0.3 m/s."],
    );
    let stopped = held(Intervention::ZoneStopped, Some(zone("wet floor", None)));
    says(
        &stopped,
        &around,
        &["farther in", "Stopped: zone `wet floor`, keepout."],
    );
    let mut short = stopped;
    if let Some(command) = &mut short.command {
        (command.v_mps, command.w_radps) = (0.1, 0.0);
    }
    says(&short, &around, &["Held back: zone `wet floor`, keepout."]);
    let missing = held(Intervention::ZonesMissing, None);
    says(
        &missing,
        &around,
        &["zones were announced that have not come"],
    );
    let mut closed = standing(Validity::NoPath, RequestCause::None);
    let mut none = path(PathStatus::Unreachable);
    none.source = ObstacleSource::Keepout;
    (closed.path, closed.zone) = (Some(none), Some(zone("dock", None)));
    says(&closed, &around, &["Stopped: zone `dock`, keepout."]);
}

#[test]
fn a_zone_that_is_not_what_the_stages_speak_of_is_not_named() {
    let moment = Moment {
        zone: Some(zone("ramp", Some(0.3))),
        ..standing(Validity::Drive, RequestCause::Corner)
    };
    assert!(!super::why(&moment, &Around::default()).contains("ramp"));
}
