//! JSON documents that tests read and spoil.

use serde_json::Value;

/// Reads the numbers of a JSON list.
///
/// # Panics
/// If it is not a list, or if an entry is not a number.
#[must_use]
#[track_caller]
pub fn numbers(list: &Value) -> Vec<f64> {
    let entries = list.as_array().unwrap().iter();
    entries.map(|entry| entry.as_f64().unwrap()).collect()
}

/// Returns the document with some places changed. An edit is `/pointer = value`; `; ` separates edits. An edit without
/// a value removes the place. A place past the end of a list adds to the list.
///
/// # Panics
/// If an edit has no such form, or if a place is not in the document.
#[must_use]
#[track_caller]
pub fn edited(document: &Value, edits: &str) -> Value {
    let mut document = document.clone();
    for edit in edits.split("; ") {
        let (pointer, text) = edit.split_once(" =").unwrap();
        let text = text.trim();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let value = (!text.is_empty()).then(|| serde_json::from_str(text).unwrap());
        match (document.pointer_mut(parent), value) {
            (Some(Value::Object(map)), Some(value)) => drop(map.insert(key.into(), value)),
            (Some(Value::Object(map)), None) => drop(map.remove(key).unwrap()),
            (Some(Value::Array(list)), Some(value)) => {
                let index: usize = key.parse().unwrap();
                list.splice(index..list.len().min(index + 1), [value]);
            }
            (place, _) => panic!("{pointer}: {place:?}"),
        }
    }
    document
}
