//! Checks that the JSON objects of the commands have exactly the keys of the contract, with values of the right kinds.

use crate::common::{PATTERNS, folder, folder_with_path};
use serde_json::{Value, json};

/// Returns `true` if `value` is of the kind that `shape` states: a name (or several, separated by `|`), a list whose
/// entries all have one kind or each have their own, or an object with exactly these keys (`*` stands for any key).
fn fits(value: &Value, shape: &Value) -> bool {
    match (shape, value) {
        (Value::String(kinds), _) => kinds.split('|').any(|kind| match kind {
            "count" => value.is_u64(),
            "number" => value.is_number(),
            "text" => value.is_string(),
            "null" => value.is_null(),
            "bool" => value.is_boolean(),
            "object" => value.is_object(),
            kind => *value == *kind,
        }),
        (Value::Array(kinds), Value::Array(values)) => match kinds.as_slice() {
            [kind] => values.iter().all(|value| fits(value, kind)),
            kinds => {
                kinds.len() == values.len() && values.iter().zip(kinds).all(|(v, k)| fits(v, k))
            }
        },
        (Value::Object(kinds), Value::Object(values)) => match kinds.get("*") {
            Some(kind) => values.values().all(|value| fits(value, kind)),
            None => {
                let fits = |(key, kind)| values.get(key).is_some_and(|value| fits(value, kind));
                kinds.len() == values.len() && kinds.iter().all(fits)
            }
        },
        _ => false,
    }
}

fn info_shape() -> Value {
    json!({
        "vertices": "count", "edges": "count", "faces": "count", "sheets": "count",
        "creases": "count", "virtual_edges": "count", "free_hinges": "count",
        "real_vertices": "count", "virtual_vertices": "count", "letters": {"*": "count"},
        "groups": "count", "essential_vertices": "count", "closure_goal": "number|null",
        "amplification": "number|null", "repairs": ["text"], "assumptions": ["text"],
        "verdict": "likely|perhaps|no|unknown",
        "causes": [{
            "kind": "text", "vertices": ["count"], "edges": ["count"], "at": ["number", "number"],
            "message": "text",
        }],
        "locked_creases": ["count"], "flat_dof": "count|null", "goal_dof": "count|null",
        "drivers": ["count"], "skew_bound": "number|null",
    })
}

fn plan_shape() -> Value {
    json!({
        "version": "text", "input": {"file": "text", "sha256": "text"},
        "options": "object",
        "outcome": "planned|near_goal|partial|not_rigidly_foldable|goal_not_closed|crossing|undecided|timeout",
        "reason": "text|null", "reached": "number", "creases": "count", "real_vertices": "count",
        "groups": "count", "essential_vertices": "count", "unknowns": "count", "knots": "count",
        "max_deformation": "number", "certified_deformation": "number|null",
        "max_closure": "number", "max_gap": "number", "max_bend": "number",
        "goal_error": "number", "flat_creases": "count", "notes": ["text"],
        "min_clearance": "number|null", "contact_tolerance": "number", "undecided": ["text"],
        "attempts": [{
            "strategy": "text", "outcome": "text", "reason": "text|null", "seconds": "number",
        }],
        "time": {
            "total": "number", "read": "number", "symmetry": "number", "solve": "number",
            "fold": "number", "collision": "number", "write": "number",
        },
        "solver": {"iterations": "count", "evaluations": "count"},
        "collision": {
            "pairs": "count", "tested": "count", "skipped_symmetry": "count",
            "skipped_motion": "count", "skipped_bounds": "count", "skipped_edges": "count",
        },
        "seed": "count", "unit": "string|null", "precision": {"length": "number|null", "angle": "number|null"},
        "thickness": "number|null", "max_thickness": "null",
    })
}

/// A sheet for which many strategies are tried, all of which end early: their time is told as well.
#[test]
fn times_of_stages_add_up_to_the_whole() {
    let plan = folder().run(&format!("plan {PATTERNS}/kresling-2x6.fold --json"));
    let answer = plan.with_status(1).json();
    let time = answer["time"].as_object().unwrap();
    let seconds = |stage: &str| time[stage].as_f64().unwrap();
    let stages = time.keys().filter(|stage| *stage != "total");
    let sum: f64 = stages.map(|stage| seconds(stage)).sum();
    assert!(sum <= seconds("total"), "{time:?}");
    assert!(sum >= 0.95 * seconds("total"), "{time:?}");
}

fn check_shape() -> Value {
    json!({
        "outcome": "holds|fails|undecided", "reason": "text|null", "undecided": ["text"],
        "start": "flat|folded", "max_bend": "number", "certified_of": "text",
        "max_speed": "number", "max_acceleration": "number|null",
        "knots": "count",
        "max_deformation": "number", "max_gap": "number", "max_closure": "number",
        "certified_deformation": "number|null",
        "crossings": [{
            "faces": ["count", "count"], "between_knots": ["count", "count"], "at": "number",
        }],
        "min_clearance": "number|null", "contact_tolerance": "number",
    })
}

fn tolerance_shape() -> Value {
    json!({
        "error": "number|null", "unit": "text|null", "max_play": "number", "at": "number",
        "hinges": [{"edge": "count", "worst": "number", "expected": "number"}],
        "vertices": [{"vertex": "count", "cost": "number"}],
        "redundant": ["count"],
    })
}

fn loads_shape() -> Value {
    json!({
        "drivers": ["count"], "times": ["number"], "torques": [["number"]],
        "peak": {"driver": "count", "torque": "number", "at": "number"},
        "regularity": "number", "is_least": "bool",
        "fits": [{"drive": "text", "fits": "bool", "at": "number|null"}],
    })
}

#[test]
fn every_answer_has_the_keys_of_the_contract() {
    let folder = folder_with_path();
    let crossing = format!("{PATTERNS}/waterbomb-12x22-crossing.fold");
    folder.done(&format!("plan {crossing} --collision off -o crossing.fold"));
    let cut = folder.read("path.fold").replace("\"M\"", "\"V\"");
    folder.write("flipped.fold", &cut);
    folder.write("servo.csv", "servo, 10, 600 # strong\n");
    folder.write("weak.csv", "weak, 1e-9, 600\n");

    let cases = [
        (
            "tolerance path.fold --error 0.001",
            0,
            tolerance_shape(),
            "error",
            json!(0.001),
        ),
        (
            "tolerance path.fold --play 0.01",
            0,
            tolerance_shape(),
            "unit",
            json!(null),
        ),
        (
            "loads path.fold --areal-density 0.8 --unit mm --drives servo.csv",
            0,
            loads_shape(),
            "is_least",
            json!(true),
        ),
        (
            "loads path.fold --areal-density 0.8 --unit mm --spring 1e-3 --spring 2=0.01 --timeout 60 --drives weak.csv",
            1,
            loads_shape(),
            "is_least",
            json!(true),
        ),
        ("info miura.fold", 0, info_shape(), "groups", json!(2)),
        (
            &format!("info {PATTERNS}/square-twist-unfoldable.fold"),
            0,
            info_shape(),
            "verdict",
            json!("no"),
        ),
        (
            "plan miura.fold",
            0,
            plan_shape(),
            "outcome",
            json!("planned"),
        ),
        (
            "plan miura.fold --timeout 0",
            1,
            plan_shape(),
            "outcome",
            json!("timeout"),
        ),
        (
            "plan miura.fold --bound 1e-99",
            1,
            plan_shape(),
            "outcome",
            json!("not_rigidly_foldable"),
        ),
        (
            &format!("plan {crossing}"),
            1,
            plan_shape(),
            "outcome",
            json!("crossing"),
        ),
        (
            "check path.fold",
            0,
            check_shape(),
            "outcome",
            json!("holds"),
        ),
        (
            "check path.fold --timeout 0",
            1,
            check_shape(),
            "outcome",
            json!("undecided"),
        ),
        (
            "check crossing.fold",
            1,
            check_shape(),
            "outcome",
            json!("fails"),
        ),
        (
            "check flipped.fold",
            1,
            check_shape(),
            "outcome",
            json!("fails"),
        ),
    ];
    for (arguments, status, shape, key, expected) in cases {
        let answer = folder
            .run(&format!("{arguments} --json"))
            .with_status(status);
        let json = answer.json();
        assert!(fits(&json, &shape), "{arguments}: {json:#}");
        assert_eq!(json[key], expected, "{arguments}");
        if let Some(outcome) = json.get("outcome") {
            let good = ["planned", "holds"].contains(&outcome.as_str().unwrap());
            assert_eq!(json["reason"].is_null(), good, "{arguments}: {json:#}");
        }
    }
}

/// With `--json`, errors are one JSON object on stdout as well, with the place if it is known.
#[test]
fn errors_have_the_keys_of_the_contract() {
    let shape = json!({"error": {
        "file": "text", "line": "count|null", "column": "count|null", "message": "text",
        "hint": "text|null",
    }});
    let folder = folder_with_path();
    folder.write(
        "broken.fold",
        "{\n  \"vertices_coords\": [[0, 0], [1, \"x\"]]\n}",
    );
    for (arguments, file, line) in [
        ("info none.fold", "none.fold", json!(null)),
        ("plan broken.fold", "broken.fold", json!(2)),
        ("check miura.fold", "miura.fold", json!(null)),
        ("plan miura.fold --bound 7", "", json!(null)),
        ("plan miura.fold --bound much", "", json!(null)),
        ("check", "", json!(null)),
    ] {
        let answer = folder.run(&format!("{arguments} --json")).with_status(2);
        let json = answer.json();
        assert!(fits(&json, &shape), "{arguments}: {json:#}");
        let found = json["error"]["file"].as_str().unwrap();
        assert!(
            found.ends_with(file) && found.is_empty() == file.is_empty(),
            "{json:#}"
        );
        assert_eq!(json["error"]["line"], line, "{arguments}: {json:#}");
        assert!(!json["error"]["message"].as_str().unwrap().is_empty());
    }
}

#[test]
fn shapes_tell_kinds_and_keys_apart() {
    let shape = json!({"n": "count", "x": "number|null", "list": ["text"]});
    for (value, good) in [
        (json!({"n": 1, "x": 0.5, "list": ["a"]}), true),
        (json!({"n": 1, "x": null, "list": []}), true),
        (json!({"n": 1.5, "x": null, "list": []}), false),
        (json!({"n": 1, "x": "0.5", "list": []}), false),
        (json!({"n": 1, "x": null, "list": [1]}), false),
        (json!({"n": 1, "x": null}), false),
        (json!({"n": 1, "x": null, "list": [], "more": 1}), false),
    ] {
        assert_eq!(fits(&value, &shape), good, "{value}");
    }
}
