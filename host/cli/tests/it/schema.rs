//! Checks every JSON that the command prints, and the lines that `batch` reads, against the schemas in `docs/schema`.

use std::collections::BTreeMap;
use std::fs;

use crate::common::{PATTERNS, folder_with_path};
use serde_json::{Value, json};

/// The schemas by their file names.
struct Schemas(BTreeMap<String, Value>);

/// Keywords that say nothing about a value.
const SILENT: [&str; 5] = ["$schema", "title", "description", "default", "$defs"];

impl Schemas {
    fn read() -> Self {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/schema");
        let files = fs::read_dir(folder)
            .unwrap()
            .map(|file| file.unwrap().path());
        let schema = |file: std::path::PathBuf| {
            let text = fs::read_to_string(&file).unwrap();
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            (name, serde_json::from_str(&text).unwrap())
        };
        Self(files.map(schema).collect())
    }

    /// Returns why a value does not fit the schema of this file; `None` if it fits.
    fn flaw(&self, file: &str, value: &Value) -> Option<String> {
        self.flaw_of(&self.0[file], file, value, "")
    }

    /// Returns the first flaw of the value at `place`, by JSON Schema 2020-12. Keywords that this function does not know
    /// are defects of the schema.
    fn flaw_of(&self, schema: &Value, file: &str, value: &Value, place: &str) -> Option<String> {
        let keywords = schema.as_object().unwrap();
        let object = value.as_object();
        let mut flaws = keywords.iter().filter_map(|(keyword, rule)| {
            let below = |schema: &Value, value: &Value, key: &str| {
                self.flaw_of(schema, file, value, &format!("{place}/{key}"))
            };
            let flaw = |text: String| Some(format!("{place}: {text}"));
            match keyword.as_str() {
                word if SILENT.contains(&word) => None,
                "type" => {
                    let kinds = rule
                        .as_array()
                        .cloned()
                        .unwrap_or_else(|| vec![rule.clone()]);
                    let fits = kinds
                        .iter()
                        .any(|kind| is_of_type(value, kind.as_str().unwrap()));
                    if fits {
                        None
                    } else {
                        flaw(format!("expected {rule}, found {value}"))
                    }
                }
                "enum" if rule.as_array().unwrap().contains(value) => None,
                "enum" => flaw(format!("expected one of {rule}, found {value}")),
                "minimum" if value.as_f64().is_some_and(|x| x < rule.as_f64().unwrap()) => {
                    flaw(format!("{value} is below {rule}"))
                }
                "maximum" if value.as_f64().is_some_and(|x| x > rule.as_f64().unwrap()) => {
                    flaw(format!("{value} is above {rule}"))
                }
                "exclusiveMinimum"
                    if value.as_f64().is_some_and(|x| x <= rule.as_f64().unwrap()) =>
                {
                    flaw(format!("{value} is not above {rule}"))
                }
                "minItems"
                    if value
                        .as_array()
                        .is_some_and(|list| (list.len() as u64) < rule.as_u64().unwrap()) =>
                {
                    flaw("too few".into())
                }
                "maxItems"
                    if value
                        .as_array()
                        .is_some_and(|list| list.len() as u64 > rule.as_u64().unwrap()) =>
                {
                    flaw("too many".into())
                }
                "minimum" | "maximum" | "exclusiveMinimum" | "minItems" | "maxItems" => None,
                "items" => value
                    .as_array()?
                    .iter()
                    .enumerate()
                    .find_map(|(k, item)| below(rule, item, &k.to_string())),
                "required" => {
                    let missing = rule.as_array().unwrap().iter().find(|key| {
                        !object.is_some_and(|object| object.contains_key(key.as_str().unwrap()))
                    });
                    missing.and_then(|key| flaw(format!("{key} is missing")))
                }
                "properties" => object?
                    .iter()
                    .find_map(|(key, value)| below(rule.get(key)?, value, key)),
                "additionalProperties" => object?.iter().find_map(|(key, value)| {
                    let known = keywords
                        .get("properties")
                        .is_some_and(|known| known.get(key).is_some());
                    match rule {
                        _ if known => None,
                        Value::Bool(true) => None,
                        Value::Bool(false) => flaw(format!("{key} is not known")),
                        rule => below(rule, value, key),
                    }
                }),
                "oneOf" => {
                    let flaws = rule
                        .as_array()
                        .unwrap()
                        .iter()
                        .map(|one| self.flaw_of(one, file, value, place));
                    let flaws: Vec<Option<String>> = flaws.collect();
                    match flaws.iter().filter(|flaw| flaw.is_none()).count() {
                        1 => None,
                        fitting => flaw(format!(
                            "{fitting} of {} schemas fit: {flaws:?}",
                            flaws.len()
                        )),
                    }
                }
                "$ref" => {
                    let (other, pointer) = rule.as_str().unwrap().split_once('#').unwrap();
                    let other = if other.is_empty() { file } else { other };
                    let schema = self.0[other]
                        .pointer(pointer)
                        .unwrap_or_else(|| panic!("{rule}"));
                    self.flaw_of(schema, other, value, place)
                }
                _ => panic!("{file}: the keyword {keyword} is not known"),
            }
        });
        flaws.next()
    }
}

fn is_of_type(value: &Value, kind: &str) -> bool {
    match kind {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        _ => panic!("{kind}"),
    }
}

#[test]
fn every_answer_fits_its_schema() {
    let schemas = Schemas::read();
    let folder = folder_with_path();
    folder.done("export path.fold --to traj -o path.traj");
    folder.write(
        "flipped.fold",
        &folder.read("path.fold").replace("\"M\"", "\"V\""),
    );
    let crossing = format!("{PATTERNS}/waterbomb-12x22-crossing.fold");
    folder.done(&format!("plan {crossing} --collision off -o crossing.fold"));
    let tent =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0.2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
    folder.write("tent.obj", tent);
    folder.write("drives.csv", "weak,1e-12,60\nstrong,10,60\n");
    let mut judged = BTreeMap::new();
    let twist = format!("info {PATTERNS}/square-twist-unfoldable.fold");
    let kresling = format!("plan {PATTERNS}/kresling-2x6.fold");
    let all_options = "plan miura.fold --crease 4=-45 --limit 16=0..180 --max-accel 90 --max-knots 50 \
                       --timeout 100 --contact 1e-6 --seed 7";
    let crosses = format!("plan {crossing}");
    for (file, arguments, status) in [
        ("info.json", "info miura.fold", 0),
        ("info.json", "info miura.fold --edges", 0),
        ("info.json", &twist, 0),
        ("plan.json", "plan miura.fold", 0),
        ("plan.json", all_options, 0),
        ("plan.json", "plan miura.fold --orders 2", 0),
        ("plan.json", "plan miura.fold --timeout 0", 1),
        ("plan.json", "plan miura.fold --bound 1e-99", 1),
        ("plan.json", &kresling, 1),
        ("plan.json", &crosses, 1),
        ("check.json", "check path.fold", 0),
        ("check.json", "check crossing.fold", 1),
        ("check.json", "check flipped.fold", 1),
        ("tolerance.json", "tolerance path.fold --error 0.001", 0),
        ("tolerance.json", "tolerance path.fold --play 0.01", 0),
        (
            "loads.json",
            "loads path.fold --areal-density 0.8 --unit mm --spring 1e-3 --drives drives.csv",
            1,
        ),
        ("unfold.json", "unfold path.fold -o a.fold", 0),
        ("unfold.json", "unfold tent.obj --cut none -o b.fold", 1),
        ("stream.json", "stream path.traj --to sim", 0),
        (
            "stream.json",
            "stream path.traj --to sim --sheet path.fold",
            0,
        ),
        ("stream.json", "stream path.traj --to tcp:1 --insecure", 1),
        (
            "stream.json",
            "stream path.traj --to sim --drives lag=0.01",
            0,
        ),
        ("error.json", "plan nowhere.fold", 2),
        ("error.json", "check path.fold --bound 0", 2),
        ("error.json", "info", 2),
    ] {
        let answer = folder
            .run(&format!("{arguments} --json"))
            .with_status(status);
        let flaw = schemas.flaw(file, &answer.json());
        assert_eq!(flaw, None, "{arguments}: {}", answer.stdout);
        *judged.entry(file).or_insert(0) += 1;
    }
    // Each answer of `drive` is on a line of its own.
    let commands = "watch 3 channel 3 7 zero 3 show jog 3 to 999";
    let answer = folder.run(&format!("drive --to sim --json {commands}"));
    assert_eq!(answer.stdout.lines().count(), 5);
    for line in answer.with_status(1).stdout.lines() {
        let flaw = schemas.flaw("drive.json", &serde_json::from_str(line).unwrap());
        assert_eq!(flaw, None, "{line}");
    }
    *judged.entry("drive.json").or_insert(0) += 1;
    let designs = [
        json!({"id": "a", "generate": {"family": "miura", "rows": 3, "cols": 3, "angle": 70}, "plan": {"seed": 3, "limit": ["4=-180..0"]}}),
        json!({"id": "b", "pattern": "miura.fold", "path": "b.fold", "plan": {"max_accel": 90, "keep": true}}),
        json!({"id": "c", "pattern": "nowhere.fold", "plan": null}),
        json!({"id": "d", "generate": {"family": "square-twist", "letters": "unfoldable"}}),
        json!({"id": "e", "pattern": "miura.fold", "plan": {"timeout": 0}}),
        json!({"id": "g", "pattern": folder.read_json("miura.fold")}),
        json!({"id": "f", "generate": {"family": "miura", "rows": 3, "columns": 3}, "plan": {"goal-tolerance": "2", "crease": "4=-45"}}),
    ];
    let mut lines = String::new();
    for design in &designs {
        assert_eq!(schemas.flaw("batch-design.json", design), None, "{design}");
        lines += &format!("{design}\n");
    }
    for options in ["", "--stable"] {
        let answer = folder
            .run_with(&format!("batch - -o - {options}"), lines.as_bytes())
            .with_status(0);
        assert_eq!(answer.stdout.lines().count(), designs.len());
        for line in answer.stdout.lines() {
            let flaw = schemas.flaw("batch-result.json", &serde_json::from_str(line).unwrap());
            assert_eq!(flaw, None, "{line}");
        }
    }
    *judged.entry("batch-design.json").or_insert(0) += 1;
    *judged.entry("batch-result.json").or_insert(0) += 1;
    // Every schema is judged (that of the options by others), and what does not fit is told.
    assert!(
        judged.keys().copied().eq(schemas
            .0
            .keys()
            .map(String::as_str)
            .filter(|name| *name != "options.json"))
    );
    let good = folder.done("plan miura.fold --json").json();
    for (pointer, value) in [
        ("/outcome", json!("perhaps")),
        ("/reached", json!(1.5)),
        ("/knots", json!(-1)),
        ("/options/seed", json!("seven")),
        ("/attempts/0", json!({"strategy": "a"})),
        ("/input", json!({"file": "a", "sha256": "b", "size": 1})),
        ("/time", Value::Null),
    ] {
        let mut bad = good.clone();
        *bad.pointer_mut(pointer).unwrap() = value;
        assert!(schemas.flaw("plan.json", &bad).is_some(), "{pointer}");
    }
    for bad in [
        json!({"id": "a"}),
        json!({"id": "a", "pattern": "a.fold", "generate": {"family": "resch"}}),
        json!({"id": "a", "generate": {"family": "miura", "rows": 3}}),
        json!({"id": "a", "generate": {"family": "miura", "rows": 3, "cols": 3, "size": 1}}),
        json!({"id": "a", "pattern": "a.fold", "plan": {"collision": "maybe"}}),
        json!({"id": "a", "pattern": "a.fold", "plan": {"keep": "yes"}}),
    ] {
        assert!(schemas.flaw("batch-design.json", &bad).is_some(), "{bad}");
    }
}
