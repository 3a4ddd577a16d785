//! `KEY=VALUE` of a command line as keys of a configuration.

use toml::{Table, Value};

/// Tables are merged, everything else is replaced.
pub fn lay_over(under: &mut Table, over: Table) {
    for (key, value) in over {
        match (under.get_mut(&key), value) {
            (Some(Value::Table(under)), Value::Table(over)) => lay_over(under, over),
            (_, value) => {
                under.insert(key, value);
            }
        }
    }
}

/// `KEY=VALUE` as a table; a value that TOML cannot read is text.
///
/// # Errors
/// When it has no key.
pub fn assignment(text: &str) -> Result<Table, String> {
    let (key, value) = text
        .split_once('=')
        .ok_or_else(|| format!("`{text}` does not read like KEY=VALUE"))?;
    let (key, value) = (key.trim(), value.trim());
    let is_key = |part: &str| {
        let plain = |one: char| one.is_ascii_alphanumeric() || one == '_' || one == '-';
        !part.is_empty() && part.chars().all(plain)
    };
    if !key.split('.').all(is_key) {
        return Err(format!("`{key}` is no key of a configuration"));
    }
    let value = toml::from_str::<Table>(&format!("value = {value}"))
        .ok()
        .filter(|table| table.len() == 1)
        .and_then(|mut table| table.remove("value"))
        .unwrap_or_else(|| Value::String(value.to_owned()));
    let mut parts = key.rsplit('.');
    let last = parts.next().unwrap_or(key).to_owned();
    let mut table = Table::from_iter([(last, value)]);
    for part in parts {
        table = Table::from_iter([(part.to_owned(), Value::Table(table))]);
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_assignment_is_read_as_toml_or_as_text() {
        let of = |text| assignment(text).expect("an assignment").to_string();
        assert_eq!(of("controller=dwa"), "controller = \"dwa\"\n");
        assert_eq!(of("limits.v_mps = 0.5"), "[limits]\nv_mps = 0.5\n");
        assert_eq!(of("on=true"), "on = true\n");
        let lines: Table = assignment("a=1\nb=2").expect("text");
        assert_eq!(lines["a"].as_str(), Some("1\nb=2"));
        for wrong in ["controller", "=1", "a b=1", "a..b=1"] {
            assert!(assignment(wrong).is_err(), "{wrong}");
        }
    }
}
