//! What the page may ask of a stack: a list of requests that go on to launch's control socket as
//! they are. Launch checks what they say.

use serde_json::{Map, Value, json};
use zeronav_observe::control::Request;
use zeronav_shell::control;
use zeronav_shell::folder::Folder;

/// A request of the page: what launch checks goes on as it came.
type Asked = Request<Value, Value, Value, Value>;

/// Whether the page may ask for this.
const fn is_listed(asked: &Asked) -> bool {
    match asked {
        Request::Goal { .. }
        | Request::Cancel { .. }
        | Request::Pause
        | Request::Resume
        | Request::Step { .. }
        | Request::Speed { .. }
        | Request::Pose { .. }
        | Request::Obstacle { .. }
        | Request::ZoneAdd { .. }
        | Request::ZoneRemove { .. }
        | Request::Zones
        | Request::Fault { .. }
        | Request::Heal { .. }
        | Request::Swap { .. }
        | Request::SwapStatus { .. }
        | Request::SwapCancel => true,
        Request::Ps | Request::GoalStatus { .. } | Request::Why { .. } | Request::Down => false,
    }
}

/// The line for launch that a request of the page stands for.
///
/// # Errors
/// What is wrong with it, in one line.
pub(crate) fn line_of(body: &[u8]) -> Result<String, String> {
    let wrong = |error: serde_json::Error| format!("not a request: {error}");
    let given: Map<String, Value> = serde_json::from_slice(body).map_err(wrong)?;
    let asked: Asked = serde_json::from_value(Value::Object(given.clone())).map_err(wrong)?;
    // Written anew: on one line, whatever came.
    let line = serde_json::to_value(&asked).map_err(wrong)?;
    if !is_listed(&asked) {
        return Err(format!("the page cannot ask for {}", line["command"]));
    }
    match given.keys().find(|key| line.get(key.as_str()).is_none()) {
        Some(key) => Err(format!("{} has no key {key:?}", line["command"])),
        None => Ok(line.to_string()),
    }
}

/// Asks launch; its answer, or an error in the same form.
pub(crate) fn ask(folder: &Folder, line: &str) -> Value {
    if line.len() >= control::LINE_BYTES_MAX {
        return json!({ "error": "the request is too long" });
    }
    let answer = control::ask(folder, line);
    let read = answer.and_then(|answer| Ok(serde_json::from_slice(&answer)?));
    read.unwrap_or_else(|error| json!({ "error": format!("the stack does not answer: {error}") }))
}

/// What launch says of its run; `None` when it does not answer.
pub(crate) fn report(folder: &Folder) -> Option<Value> {
    let mut answer = ask(folder, &serde_json::to_string(&Asked::Ps).ok()?);
    answer.get_mut("run").map(Value::take)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_listed_requests_go_on_and_on_one_line() {
        let good = line_of(b"{\"command\":\n \"step\", \"ticks\": 5}").expect("a request");
        assert_eq!(good, r#"{"command":"step","ticks":5}"#);
        let wrong: [(&[u8], &str); 8] = [
            (b"{\"command\":\"down\"}", "the page cannot ask for"),
            (b"{\"command\":\"ps\"}", "the page cannot ask for"),
            (b"{\"command\":\"pause\",\"x\":1}", "\"pause\" has no key"),
            (b"{\"x\":1}", "command"),
            (
                b"{\"command\":\"step\",\"ticks\":5,\"x\":1}",
                "unknown field",
            ),
            (b"{\"command\":\"jump\"}", "unknown variant"),
            (b"[1]", "not a request"),
            (b"\xff\n", "not a request"),
        ];
        for (body, said) in wrong {
            let error = line_of(body).expect_err("it is not asked");
            assert!(error.contains(said), "{error}");
        }
    }
}
