//! Which known word a misspelt one was meant to be.

use strsim::osa_distance;

/// The known word that `word` is a part of, or else the one that takes the fewest edits to become
/// it, when these are few enough to be a slip: at most half of its letters.
#[must_use]
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .filter_map(|known| {
            let is_part = word.len() > 2 && known.contains(word);
            let edits = osa_distance(word, known);
            let is_slip = edits <= known.chars().count().div_ceil(2);
            (is_part || is_slip).then_some((!is_part, edits, known))
        })
        .min()
        .map(|(_, _, known)| known)
}

/// `there is no KIND WORD`, with the nearest known word, or all of them when none is near.
#[must_use]
pub fn unknown<'a>(
    kind: &str,
    word: &str,
    known: impl IntoIterator<Item = &'a str> + Clone,
) -> String {
    if let Some(meant) = nearest(word, known.clone()) {
        return format!("there is no {kind} `{word}`, did you mean `{meant}`?");
    }
    let known: Vec<&str> = known.into_iter().collect();
    let known = known.join(", ");
    format!("there is no {kind} `{word}`; known are {known}")
}

/// The message of a deserialiser in one line; where it lists what it expected in place of an unknown
/// field or variant, the nearest of them takes the place of the list.
#[must_use]
pub fn hinted(message: &str) -> String {
    let message = message.lines().collect::<Vec<_>>().join(", ");
    let word = ["unknown field `", "unknown variant `"]
        .iter()
        .find_map(|start| message.strip_prefix(start))
        .and_then(|rest| rest.split_once("`, expected "));
    let Some((word, expected)) = word else {
        return message;
    };
    // Every second part between backticks is a word.
    match nearest(word, expected.split('`').skip(1).step_by(2)) {
        Some(meant) => {
            let said = message.len() - expected.len() - "expected ".len();
            format!("{}did you mean `{meant}`?", &message[..said])
        }
        None => message,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_understood_and_other_words_are_not() {
        let known = ["blocked_aisle", "open_aisle", "sealed"];
        assert_eq!(nearest("blocked_ailse", known), Some("blocked_aisle"));
        assert_eq!(nearest("seald", known), Some("sealed"));
        assert_eq!(nearest("open", known), Some("open_aisle"));
        assert_eq!(nearest("quicksort", known), None);
        assert_eq!(nearest("x", []), None);
        assert_eq!(
            unknown("scenario", "seald", known),
            "there is no scenario `seald`, did you mean `sealed`?"
        );
        assert_eq!(
            unknown("scenario", "quicksort", known),
            "there is no scenario `quicksort`; known are blocked_aisle, open_aisle, sealed"
        );
    }

    #[test]
    fn what_a_deserialiser_expected_becomes_the_nearest_of_it() {
        for (said, told) in [
            (
                "unknown field `planer`, expected one of `planner`, `options`",
                "unknown field `planer`, did you mean `planner`?",
            ),
            (
                "unknown variant `bax`, expected `box` or `disc`",
                "unknown variant `bax`, did you mean `box`?",
            ),
            (
                "unknown field `colour`, expected `x`",
                "unknown field `colour`, expected `x`",
            ),
            (
                "unknown field `x`, there are no fields",
                "unknown field `x`, there are no fields",
            ),
            ("two\nlines", "two, lines"),
        ] {
            assert_eq!(hinted(said), told);
        }
    }
}
