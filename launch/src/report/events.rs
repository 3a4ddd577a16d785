//! What happened in a run, in order of time.

use super::folder::{Outcome, RunFolder};
use super::html::{Cell, table, text_of, words};
use crate::show::recording::Recording;
use serde::Serialize;
use zeronav_casts::Cast;
use zeronav_measure::result::fault::FaultResult;
use zeronav_measure::result::swap::SwapResult;
use zeronav_measure::result::{PlannedPath, Redirect, Restart, Touch};

/// Events that a player marks at most.
const MARKED_MAX: usize = 400;

/// Longest text of an event. [characters]
const TEXT_MAX: usize = 160;

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Event {
    /// Time since the first goal. [s]
    pub time_s: f64,
    /// What kind: a word of this room.
    pub kind: &'static str,
    /// In words.
    pub text: String,
}

/// Everything that happened.
pub(super) fn events(run: &RunFolder) -> Vec<Event> {
    let recording = run.recording.as_ref();
    let mut events = Vec::new();
    let from_s = recording.map_or(0.0, |recording| recording.first_goal_s);
    match &run.outcome {
        Outcome::Run(result) => {
            events.extend(result.plans.iter().map(path));
            events.extend(result.touches.iter().map(touch));
            events.extend(result.restarts.iter().map(|one| restart(one, from_s)));
            events.extend(result.faults.iter().map(|one| fault(one, from_s)));
            events.extend(result.redirects.iter().map(redirect));
            events.extend(swaps(&result.swaps, recording));
            let time_s = recording.map_or(result.time_s, |recording| recording.time_s);
            events.push(end(time_s, &result.outcome));
        }
        Outcome::Stay(result) => {
            let paths = recording.map_or(&[][..], |recording| &recording.paths);
            events.extend(paths.iter().map(|path| Event {
                time_s: path.time_s,
                kind: "path",
                text: format!(
                    "path of {:.1} m, cause {}",
                    path.length_m,
                    words(&path.cause)
                ),
            }));
            events.extend(result.restarts.iter().map(|one| restart(one, from_s)));
            events.extend(result.faults.iter().map(|one| fault(one, from_s)));
            events.extend(result.goals.iter().map(redirect));
            events.extend(swaps(&result.swaps, recording));
            let time_s = recording.map_or(result.time_s, |recording| recording.time_s);
            events.push(end(time_s, &result.outcome));
        }
    }
    in_order(events, recording)
}

/// What happened in a run that is read from the recording of its messages.
pub(super) fn of_messages(
    plans: &[PlannedPath],
    touches: &[Touch],
    recording: &Recording,
) -> Vec<Event> {
    let mut events: Vec<Event> = plans.iter().map(path).collect();
    events.extend(touches.iter().map(touch));
    events.push(end(recording.time_s, &recording.outcome));
    in_order(events, Some(recording))
}

/// The events with those of the recording, in order of time.
fn in_order(mut events: Vec<Event>, recording: Option<&Recording>) -> Vec<Event> {
    if let Some(recording) = recording {
        events.extend(recording.obstacles.iter().filter_map(|obstacle| {
            let time_s = obstacle.poses.first()?[0];
            (time_s > 0.0).then(|| Event {
                time_s,
                kind: "obstacle",
                text: format!("{} appears", obstacle.name),
            })
        }));
        let interventions = recording.interventions.iter();
        events.extend(interventions.map(|(time_s, why)| Event {
            time_s: *time_s,
            kind: "guard",
            text: format!("guard: {}", words(why)),
        }));
    }
    events.retain(|event| event.time_s.is_finite());
    for event in &mut events {
        if let Some((end, _)) = event.text.char_indices().nth(TEXT_MAX) {
            event.text.truncate(end);
            event.text.push('…');
        }
    }
    // What appears is the cause of what is answered at the same moment.
    let is_answer = |event: &Event| event.kind != "obstacle";
    events.sort_by(|a, b| {
        let by_time = a.time_s.total_cmp(&b.time_s);
        by_time.then(is_answer(a).cmp(&is_answer(b)))
    });
    events
}

fn end(time_s: f64, outcome: &str) -> Event {
    Event {
        time_s,
        kind: "end",
        text: words(outcome),
    }
}

fn touch(touch: &Touch) -> Event {
    Event {
        time_s: touch.time_s,
        kind: "contact",
        text: format!(
            "contact with {} at {:.2} m/s, {}",
            touch.with,
            touch.v_mps,
            if touch.moving { "moving" } else { "standing" }
        ),
    }
}

fn path(plan: &PlannedPath) -> Event {
    let beside = if plan.beside_goal_m < 0.005 {
        String::new()
    } else {
        format!(", ends {:.2} m beside the goal", plan.beside_goal_m)
    };
    let clearance = match plan.clearance_m_min {
        Some(clearance_m) if plan.collides => format!(", collides by {:.2} m", -clearance_m),
        Some(clearance_m) => format!(", {clearance_m:.2} m clear"),
        None => String::new(),
    };
    Event {
        time_s: plan.time_s,
        kind: "path",
        text: format!(
            "path by {}: {}, {:.1} m{clearance}, {} expanded, cause {}{beside}",
            plan.planner,
            words(&plan.status),
            plan.length_m,
            plan.expanded,
            words(&plan.cause)
        ),
    }
}

fn restart(restart: &Restart, from_s: f64) -> Event {
    Event {
        time_s: (restart.time_s - from_s).max(0.0),
        kind: "restart",
        text: format!("{} restarted: {}", words(&restart.service), restart.how),
    }
}

fn fault(fault: &FaultResult, from_s: f64) -> Event {
    let answered = match (&fault.why, fault.recovery_ms) {
        (Some(why), _) => format!(", not made: {why}"),
        (None, Some(ms)) => format!(", answered again after {ms:.0} ms"),
        (None, None) => String::new(),
    };
    let target = words(&fault.target);
    let what = format!("fault: {} {target} {}", fault.kind, fault.figures);
    Event {
        time_s: (fault.time_s - from_s).max(0.0),
        kind: "fault",
        text: format!("{}{answered}", what.trim_end()),
    }
}

fn redirect(redirect: &Redirect) -> Event {
    let [x_m, y_m, yaw_rad] = redirect.goal;
    Event {
        time_s: redirect.time_s,
        kind: "goal",
        text: format!(
            "goal ({x_m:.2}, {y_m:.2}, {yaw_rad:.2}) by hand: {}",
            words(&redirect.outcome)
        ),
    }
}

fn swaps<'a>(
    swaps: &'a [SwapResult],
    recording: Option<&'a Recording>,
) -> impl Iterator<Item = Event> + 'a {
    let timed = recording.filter(|recording| recording.tick_s > 0.0);
    let at = move |tick: Option<u64>| {
        let recording = timed?;
        Some((tick?.to_f64() * recording.tick_s - recording.first_goal_s).max(0.0))
    };
    swaps.iter().flat_map(move |swap| {
        let who = format!("{}: {}", words(&swap.role), swap.binary);
        [
            (swap.cut_over_tick, format!("swap: {who} is obeyed")),
            (swap.roll_back_tick, format!("swap: {who} is rolled back")),
        ]
        .into_iter()
        .filter_map(move |(tick, text)| {
            Some(Event {
                time_s: at(tick)?,
                kind: "swap",
                text,
            })
        })
    })
}

/// The events that a player marks: of very many, those of the guard are left out first.
pub(super) fn marked(events: &[Event]) -> Vec<&Event> {
    let all = events.iter();
    if events.len() <= MARKED_MAX {
        return all.collect();
    }
    let others = all.filter(|event| event.kind != "guard");
    others.take(MARKED_MAX).collect()
}

/// The table of events.
pub(super) fn list(events: &[Event]) -> String {
    let row = |event: &Event| {
        let kind = format!("<span class=\"kind {0}\">{0}</span>", text_of(event.kind));
        vec![
            Cell::moment(event.time_s),
            Cell::Html(kind),
            Cell::text(event.text.clone()),
        ]
    };
    let rows: Vec<Vec<Cell>> = events.iter().map(row).collect();
    table(&["time", "kind", "what"], &rows)
}
