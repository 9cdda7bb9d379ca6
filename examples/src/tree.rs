//! Settings as TOML: one file over another, and one field by its name.

use crate::heats::SettingsError;
use toml::{Table, Value};

/// Lays `over` upon `under`: its values stand in place of those of `under`, section by section.
pub(crate) fn overlay(under: &mut Table, over: Table) {
    for (key, value) in over {
        match (under.get_mut(&key), value) {
            (Some(Value::Table(below)), Value::Table(above)) => overlay(below, above),
            (_, value) => {
                under.insert(key, value);
            }
        }
    }
}

/// Carries out `section.field=value`. A bare word is a string, anything else is TOML; whole numbers stand for floats where the
/// field is one.
///
/// # Errors
/// [`SettingsError`] naming the assignment.
pub(crate) fn assign(tree: &mut Table, assignment: &str) -> Result<(), SettingsError> {
    let (key, value) = assignment
        .split_once('=')
        .map(|(key, value)| (key.trim(), value.trim()))
        .ok_or_else(|| SettingsError::Assignment(assignment.to_owned()))?;
    let value = toml::from_str::<Table>(&format!("v = {value}"))
        .ok()
        .and_then(|mut table| table.remove("v"))
        .unwrap_or_else(|| Value::String(value.to_owned()));
    let (sections, field) = key.rsplit_once('.').unwrap_or(("", key));
    let mut table = tree;
    for part in sections.split('.').filter(|part| !part.is_empty()) {
        table = table
            .entry(part)
            .or_insert_with(|| Value::Table(Table::new()))
            .as_table_mut()
            .ok_or_else(|| {
                SettingsError::Parse(format!("{key}: {part} is a value, not a section"))
            })?;
    }
    let value = match (table.get(field), value) {
        (Some(Value::Float(_)), Value::Integer(i)) => Value::Float(i as f64),
        (_, value) => value,
    };
    table.insert(field.to_owned(), value);
    Ok(())
}
