//! What is wrong with the words of a scenario.

use zeronav_params::ParameterError;

/// A value that cannot be, named by its place.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {why}")]
pub struct SpecError {
    /// Path of the value below the specification that was checked, such as `shapes[3].size_m`.
    pub field: String,
    /// What is wrong and what would be right.
    pub why: String,
}

impl From<ParameterError> for SpecError {
    fn from(error: ParameterError) -> Self {
        let why = format!("{}, not {}", error.rule, error.value);
        Self::new(error.path, why)
    }
}

impl SpecError {
    /// `field` is wrong because of `why`.
    #[must_use]
    pub fn new(field: impl Into<String>, why: impl Into<String>) -> Self {
        Self {
            field: field.into(),
            why: why.into(),
        }
    }

    /// The same error seen from the specification that holds the checked one as `parent`.
    #[must_use]
    pub fn within(mut self, parent: &str) -> Self {
        let dot = if self.field.is_empty() || self.field.starts_with('[') {
            ""
        } else {
            "."
        };
        self.field = format!("{parent}{dot}{}", self.field);
        self
    }
}

/// Accepts numbers from `min` to `max`, both included.
///
/// # Errors
/// `field` with the range in words; also for NaN.
pub fn number(value: f64, min: f64, max: f64, field: &str) -> Result<(), SpecError> {
    if (min..=max).contains(&value) {
        return Ok(());
    }
    Err(SpecError::new(
        field,
        // Debug writes what is very large or small with an exponent.
        format!("must be a number from {min} to {max}, not {value:?}"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_named_from_the_outside_in() {
        let error = number(f64::NAN, 0.0, 1.0, "[1]")
            .unwrap_err()
            .within("size_m")
            .within("shapes[3]")
            .within("world");
        assert_eq!(
            error.to_string(),
            "world.shapes[3].size_m[1]: must be a number from 0 to 1, not NaN"
        );
        assert_eq!(number(1.0, 0.0, 1.0, "x"), Ok(()));
    }
}
