//! What the page may ask of a stack: a list of requests that go on to launch's control socket as
//! they are. Launch checks what they say.

use serde_json::{Map, Value, json};
use zeronav_shell::control;
use zeronav_shell::folder::Folder;

/// The commands that go on, with the keys that they may have.
const COMMANDS: [(&str, &[&str]); 13] = [
    ("goal", &["goals", "repeats", "time_limit_s", "now"]),
    ("cancel", &["id"]),
    ("pause", &[]),
    ("resume", &[]),
    ("step", &["ticks"]),
    ("speed", &["factor"]),
    ("pose", &["pose"]),
    ("obstacle", &["name", "change"]),
    ("fault", &["fault"]),
    ("heal", &["target"]),
    ("swap", &["order"]),
    ("swap_status", &["id"]),
    ("swap_cancel", &[]),
];

/// The line for launch that a request of the page stands for.
///
/// # Errors
/// What is wrong with it, in one line.
pub(crate) fn line_of(body: &[u8]) -> Result<String, String> {
    let request: Map<String, Value> =
        serde_json::from_slice(body).map_err(|error| format!("not a request: {error}"))?;
    let command = request.get("command").and_then(Value::as_str);
    let command = command.ok_or("a request names its command")?;
    let known = COMMANDS.iter().find(|(name, _)| *name == command);
    let Some((_, keys)) = known else {
        let names: Vec<&str> = COMMANDS.iter().map(|(name, _)| *name).collect();
        return Err(format!("the page can ask for {}", names.join(", ")));
    };
    let foreign = request
        .keys()
        .find(|key| *key != "command" && !keys.contains(&key.as_str()));
    if let Some(key) = foreign {
        return Err(format!("{command} has no key {key:?}"));
    }
    // Written anew: on one line, whatever came.
    Ok(Value::Object(request).to_string())
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
    let mut answer = ask(folder, r#"{"command":"ps"}"#);
    answer.get_mut("run").map(Value::take)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_listed_requests_go_on_and_on_one_line() {
        let good = line_of(b"{\"command\":\n \"step\", \"ticks\": 5}").expect("a request");
        assert_eq!(good, r#"{"command":"step","ticks":5}"#);
        let wrong: [(&[u8], &str); 6] = [
            (b"{\"command\":\"down\"}", "the page can ask for goal"),
            (b"{\"command\":\"ps\"}", "the page can ask for goal"),
            (b"{\"command\":\"pause\",\"x\":1}", "pause has no key"),
            (b"{\"x\":1}", "names its command"),
            (b"[1]", "not a request"),
            (b"\xff\n", "not a request"),
        ];
        for (body, said) in wrong {
            let error = line_of(body).expect_err("it is not asked");
            assert!(error.contains(said), "{error}");
        }
    }
}
