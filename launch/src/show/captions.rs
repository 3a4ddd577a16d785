//! What a replay of a run says, and when.

use super::recording::{Recording, first_and_last};

/// Events of a kind that are told at most.
const EVENTS_MAX: usize = 40;

/// What is said and from when on [s], in order.
pub(super) fn captions(run: &Recording) -> Vec<(f64, String)> {
    /// What happens within this time is said in one line. [s]
    const TOGETHER_S: f64 = 0.6;
    let mut events: Vec<(f64, String)> = Vec::new();
    for obstacle in first_and_last(&run.obstacles, EVENTS_MAX) {
        if let Some(first) = obstacle.poses.first().filter(|first| first[0] > TOGETHER_S) {
            events.push((first[0], format!("{} appears", obstacle.name)));
        }
    }
    for path in first_and_last(&run.paths, EVENTS_MAX) {
        let (what, length_m) = match path.cause.as_str() {
            "goal" => ("driving to the goal on a path of", path.length_m),
            "obstacle" => ("new path of", path.length_m),
            _ => continue,
        };
        events.push((path.time_s, format!("{what} {length_m:.1} m")));
    }
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    let end = format!(
        "{} after {:.1} s and {:.1} m, {} contacts",
        run.outcome.replace('_', " "),
        run.time_s,
        run.driven_m,
        run.contacts
    );
    events.push((run.time_s, end));
    let mut captions: Vec<(f64, String)> = Vec::new();
    for (time_s, text) in events {
        match captions.last_mut() {
            Some((before_s, line)) if time_s - *before_s < TOGETHER_S && time_s < run.time_s => {
                // An obstacle and the path around it are one line; of two paths the newer counts.
                *line = match line.find(" appears") {
                    Some(at) => format!("{} appears: {text}", &line[..at]),
                    None => text,
                };
            }
            _ => captions.push((time_s, text)),
        }
    }
    captions
}
