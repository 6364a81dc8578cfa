//! Tests `batch`, which plans many designs.

use core::time::Duration;
use std::fs;
use std::process::{Child, Stdio};
use std::thread::sleep;

use crate::common::{PATTERNS, folder};
use foldpath_test_support::Folder;
use serde_json::{Value, json};

/// Designs of which some are broken, in a folder with the files that they name.
fn designs(folder: &Folder, count: usize) {
    folder.write("broken.fold", "{\"vertices_coords\": [[0, 0], [1, 0]");
    let mut text = String::new();
    for index in 0..count {
        let id = format!("design {index:05}");
        let design = match index % 25 {
            7 => json!({"id": id, "pattern": "broken.fold"}),
            13 => {
                json!({"id": id, "generate": {"family": "miura", "rows": 3, "cols": 3}, "plan": {"bound": 1e-99}})
            }
            19 => {
                json!({"id": id, "pattern": format!("{PATTERNS}/miura-3x3.fold"), "plan": {"timeout": 0}})
            }
            _ => json!({
                "id": id,
                "generate": {"family": "miura", "rows": 2 + index % 5, "cols": 3, "angle": 40 + index % 45},
                "plan": {"max_speed": 30 + index % 7},
            }),
        };
        text += &format!("{design}\n");
    }
    folder.write("designs.jsonl", &text);
}

/// Returns the results in a file.
fn results(folder: &Folder, name: &str) -> Vec<Value> {
    let text = folder.read(name);
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

/// Leaves out what depends on the clock: the times, and all that is told of a plan whose time was up but the outcome.
fn without_times(mut result: Value) -> Value {
    let fields = result.as_object_mut().unwrap();
    fields.remove("time");
    for attempt in fields
        .get_mut("attempts")
        .and_then(Value::as_array_mut)
        .into_iter()
        .flatten()
    {
        attempt.as_object_mut().unwrap().remove("seconds");
    }
    if fields
        .get("outcome")
        .is_some_and(|outcome| outcome == "timeout")
    {
        fields.retain(|key, _| {
            ["id", "design", "version", "input", "options", "outcome"].contains(&key.as_str())
        });
    }
    result
}

#[test]
fn a_result_is_the_answer_of_plan_with_an_id() {
    let folder = folder();
    folder.done("generate miura --rows 3 --cols 4 --angle 70 -o miura.fold");
    let lines = [
        json!({"id": "file", "pattern": "miura.fold", "plan": {"max-accel": 90.5, "limit": ["4=-180..180"], "via": null}, "path": "path.fold"}),
        json!({"id": "generated", "generate": {"family": "miura", "rows": 3, "cols": 4, "angle": 70}}),
    ];
    folder.write("designs.jsonl", &format!("{}\n\n{}", lines[0], lines[1]));
    let said = folder.done("batch designs.jsonl -o results.jsonl").stdout;
    assert!(
        said.starts_with("2 designs, written to results.jsonl\n          2 planned\n"),
        "{said}"
    );
    let mut found = results(&folder, "results.jsonl");
    let text = folder.read("results.jsonl");
    assert!(text.starts_with("{\"id\":\"file\",\"design\":{"), "{text}");
    // Each carries its design, with which it is planned again.
    for (result, line) in found.iter_mut().zip(&lines) {
        let result = result.as_object_mut().unwrap();
        let mut design = result.remove("design").unwrap();
        design["id"] = line["id"].clone();
        assert_eq!(design, *line);
        let figures = result.remove("figures").unwrap();
        let sides =
            |key: &str| -> Vec<f64> { serde_json::from_value(figures[key].clone()).unwrap() };
        let (flat, folded) = (sides("flat_box"), sides("folded_box"));
        // A Miura of 3 x 4 unit panels with a sector of 70 degrees, whose zigzag creases turn by 162 degrees.
        let (t, g) = (81_f64.to_radians(), 70_f64.to_radians());
        let height = t.sin() * g.sin();
        let slope = t.cos() * g.tan();
        let offset = 1.0 / (1.0 + slope * slope).sqrt();
        let mut expected = [
            4.0 * (1.0 - height * height).sqrt() + offset,
            3.0 * slope * offset,
            height,
        ];
        expected.sort_by(|a, b| b.total_cmp(a));
        for (side, expected) in folded.iter().zip(expected) {
            assert!((side - expected).abs() < 1e-6, "{folded:?} {expected}");
        }
        assert!((flat[0] - (4.0 + g.cos())).abs() < 1e-9, "{flat:?}");
        assert!((flat[1] - 3.0 * g.sin()).abs() < 1e-9, "{flat:?}");
        let ratio = flat[0] * flat[1] / (folded[0] * folded[1]);
        assert!((figures["packing_ratio"].as_f64().unwrap() - ratio).abs() < 1e-9);
        assert!((figures["largest_angle"].as_f64().unwrap() - 162.0).abs() < 1e-6);
    }
    let mut expected = folder
        .done("plan miura.fold --max-accel 90.5 --limit 4=-180..180 --timeout 60 --json")
        .json();
    expected["id"] = "file".into();
    assert_eq!(without_times(found[0].clone()), without_times(expected));
    // A pattern that is generated is that of the file.
    let mut expected = folder.done("plan miura.fold --timeout 60 --json").json();
    expected["id"] = "generated".into();
    expected["input"]["file"] = "generate Miura 3x4".into();
    assert_eq!(without_times(found[1].clone()), without_times(expected));
    folder.done("plan miura.fold --max-accel 90.5 --limit 4=-180..180 -o expected.fold");
    assert_eq!(folder.read("path.fold"), folder.read("expected.fold"));
}

/// A pattern may stand in its line, and the answer is that of its file.
#[test]
fn patterns_stand_in_their_lines() {
    let folder = folder();
    folder.done("generate miura --rows 3 --cols 4 -o miura.fold");
    let mut broken = folder.read_json("miura.fold");
    broken["edges_vertices"][0] = json!([0, 99]);
    let lines = [
        json!({"id": "in line", "pattern": folder.read_json("miura.fold")}),
        json!({"id": "file", "pattern": "miura.fold"}),
        json!({"id": "broken", "pattern": broken}),
        json!({"id": "number", "pattern": 3}),
    ];
    let text: Vec<String> = lines.iter().map(Value::to_string).collect();
    folder.write("designs.jsonl", &text.join("\n"));
    folder.done("batch designs.jsonl -o results.jsonl");
    let mut found = results(&folder, "results.jsonl");
    for (result, line) in found.iter().zip(&lines) {
        assert_eq!(result["design"]["pattern"], line["pattern"]);
    }
    assert_eq!(found[0]["input"]["file"], "pattern of in line");
    let mut of_file = without_times(found[1].take());
    for key in ["id", "design", "input"] {
        of_file[key] = found[0][key].clone();
    }
    assert_eq!(without_times(found[0].take()), of_file);
    let error = found[2]["error"]["message"].as_str().unwrap();
    assert!(error.contains("edges_vertices[0]"), "{error}");
    let error = found[3]["error"]["message"].as_str().unwrap();
    assert!(
        error.starts_with("pattern: expected the name of a file"),
        "{error}"
    );
}

/// Designs whose result is an error are planned again, and the results of all others stay.
#[test]
fn errors_are_retried() {
    let folder = folder();
    folder.done("generate miura --rows 2 --cols 3 -o miura.fold");
    let lines = ["a", "b", "c"].map(|id| json!({"id": id, "pattern": format!("{id}.fold")}));
    let text: Vec<String> = lines.iter().map(Value::to_string).collect();
    folder.write("designs.jsonl", &text.join("\n"));
    let miura = folder.read("miura.fold");
    folder.write("b.fold", &miura);
    folder.done("batch designs.jsonl -o results.jsonl --stable");
    let of_b = folder
        .read("results.jsonl")
        .lines()
        .nth(1)
        .unwrap()
        .to_string();
    folder.write("c.fold", &miura);
    // Without the option errors are results.
    let said = folder.done("batch designs.jsonl -o results.jsonl --stable --resume");
    assert!(said.stdout.starts_with("0 designs"), "{}", said.stdout);
    for option in ["--retry-errors", "--resume --retry-errors"] {
        let said = folder.done(&format!(
            "batch designs.jsonl -o results.jsonl --stable {option}"
        ));
        let left = if option.starts_with("--retry") { 2 } else { 1 };
        let told = format!("{left} designs, written to results.jsonl");
        assert!(said.stdout.starts_with(&told), "{}", said.stdout);
    }
    let found = results(&folder, "results.jsonl");
    let ids: Vec<&str> = found
        .iter()
        .map(|result| result["id"].as_str().unwrap())
        .collect();
    assert_eq!(ids, ["b", "c", "a"]);
    assert_eq!(folder.read("results.jsonl").lines().next().unwrap(), of_b);
    assert_eq!(found[1]["outcome"], "planned");
    assert!(
        found[2]["error"]["message"]
            .as_str()
            .unwrap()
            .contains("a.fold")
    );
}

/// No design writes over what another reads or writes, and a run that cannot begin leaves the results that are there.
#[test]
fn designs_do_not_write_over_each_other() {
    let folder = folder();
    let miura = json!({"family": "miura", "rows": 3, "cols": 3});
    let lines = [
        json!({"id": "a", "generate": miura, "path": "a.fold"}),
        json!({"id": "b", "generate": miura, "path": "./a.fold"}),
        json!({"id": "c", "generate": miura, "path": "results.jsonl"}),
        json!({"id": "d", "generate": miura, "path": "/dev/stdout"}),
        json!({"id": "e", "pattern": "/dev/stdin"}),
        json!({"id": "f", "generate": miura, "plan": {"timeout": "30"}}),
        json!({"id": "g", "generate": miura, "plan": {"timeout": {"seconds": 3}}}),
    ];
    let text: Vec<String> = lines.iter().map(Value::to_string).collect();
    folder.write("designs.jsonl", &text.join("\n"));
    folder.done("batch designs.jsonl -o results.jsonl");
    let answers = results(&folder, "results.jsonl");
    let of = |k: usize| {
        let error = answers[k]["error"]["message"].as_str();
        (
            answers[k]["id"].as_str().unwrap(),
            error.unwrap_or("planned"),
        )
    };
    assert_eq!(of(0), ("a", "planned"));
    let taken = "path: expected a file that nothing else of the run writes or reads";
    assert_eq!(of(1), ("b", taken));
    assert_eq!(of(2), ("c", taken));
    assert_eq!(
        of(3),
        ("d", "expected a file, found the device /dev/stdout")
    );
    assert_eq!(of(4), ("e", "expected a file, found the device /dev/stdin"));
    assert_eq!(of(5), ("f", "planned"));
    assert!(of(6).0 == "g" && of(6).1.contains("timeout"), "{:?}", of(6));
    let before = folder.read("results.jsonl");
    folder.run("batch . -o results.jsonl").with_status(2);
    assert_eq!(folder.read("results.jsonl"), before);
}

#[test]
fn the_bytes_do_not_depend_on_jobs_or_shards() {
    let folder = folder();
    designs(&folder, 120);
    folder.done("batch designs.jsonl -o all.jsonl --stable --jobs 1");
    let all = folder.read("all.jsonl");
    assert_eq!(all.lines().count(), 120);
    for outcome in [
        "\"planned\"",
        "\"timeout\"",
        "\"error\"",
        "\"not_rigidly_foldable\"",
    ] {
        assert!(all.contains(outcome), "{outcome}");
    }
    folder.done("batch designs.jsonl -o many.jsonl --stable --jobs 5");
    assert_eq!(folder.read("many.jsonl"), all);
    let mut parts = Vec::new();
    for shard in 0..3 {
        folder.done(&format!(
            "batch designs.jsonl -o part.jsonl --stable --shard {shard}/3"
        ));
        let part: Vec<String> = folder
            .read("part.jsonl")
            .lines()
            .map(String::from)
            .collect();
        assert!(part.len() > 20, "shard {shard}: {}", part.len());
        parts.extend(part);
    }
    parts.sort();
    let mut sorted: Vec<&str> = all.lines().collect();
    sorted.sort_unstable();
    assert_eq!(parts, sorted);
    // With times, the rest is the same.
    folder.done("batch designs.jsonl -o timed.jsonl");
    let timed = results(&folder, "timed.jsonl")
        .into_iter()
        .map(without_times);
    assert!(timed.eq(results(&folder, "all.jsonl").into_iter().map(without_times)));
    assert!(results(&folder, "timed.jsonl")[0]["time"]["total"].is_number());
}

fn start(folder: &Folder, arguments: &str) -> Child {
    let mut command = folder.command(arguments);
    command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Kills the run again and again, each time after some more results, until one run ends.
#[test]
fn a_run_that_is_killed_goes_on_to_the_same_bytes() {
    let folder = folder();
    designs(&folder, 300);
    folder.done("batch designs.jsonl -o whole.jsonl --stable");
    let whole = folder.read("whole.jsonl");
    let length = || fs::metadata(folder.path("results.jsonl")).map_or(0, |found| found.len());
    let mut kills = 0;
    for kill in 1..=10 {
        let enough = whole.len() as u64 * kill / 11;
        let mut run = start(
            &folder,
            "batch designs.jsonl -o results.jsonl --stable --resume --jobs 2",
        );
        while length() < enough && run.try_wait().unwrap().is_none() {
            sleep(Duration::from_millis(1));
        }
        kills += u64::from(run.try_wait().unwrap().is_none());
        // A run that has ended cannot be killed.
        let _ended = run.kill();
        run.wait().unwrap();
        // Half a line, as a machine that fails may leave it.
        let mut cut = fs::read(folder.path("results.jsonl")).unwrap();
        assert!(whole.as_bytes().starts_with(&cut));
        let torn = [7, 14, 21, 28, 35, 42, 49, 6, 13, 20][usize::try_from(kill - 1).unwrap()];
        cut.truncate(cut.len() - cut.len().min(torn));
        fs::write(folder.path("results.jsonl"), cut).unwrap();
    }
    assert!(kills >= 5, "{kills}");
    let said = folder
        .done("batch designs.jsonl -o results.jsonl --stable --resume")
        .stdout;
    assert!(said.contains(" there before"), "{said}");
    assert_eq!(folder.read("results.jsonl"), whole);
    // There is nothing left to do.
    let said = folder
        .done("batch designs.jsonl -o results.jsonl --stable --resume")
        .stdout;
    assert!(
        said.starts_with("0 designs") && said.contains("300 there before"),
        "{said}"
    );
    assert_eq!(folder.read("results.jsonl"), whole);
    folder.write("results.jsonl", "no result\n");
    let refused = folder
        .run("batch designs.jsonl -o results.jsonl --resume")
        .with_status(2);
    assert!(
        refused.begins("results.jsonl: line 1: expected a result of batch"),
        "{refused:?}"
    );
    assert_eq!(folder.read("results.jsonl"), "no result\n");
}

#[test]
fn every_line_has_a_result_whatever_is_in_it() {
    let folder = folder();
    folder.done("generate miura --rows 2 --cols 2 -o miura.fold");
    let bad = [
        ("{\"id\": \"cut", "line 1", "EOF while parsing"),
        ("[]", "line 2", "invalid length"),
        (
            "{\"id\": 5, \"pattern\": \"miura.fold\"}",
            "line 3",
            "expected a string",
        ),
        (
            "{\"id\": \"a\", \"patern\": \"miura.fold\"}",
            "a",
            "unknown field `patern`",
        ),
        (
            "{\"id\": \"b\"}",
            "b",
            "expected either pattern or generate",
        ),
        (
            "{\"id\": \"c\", \"pattern\": \"missing.fold\"}",
            "c",
            "missing.fold: No such file",
        ),
        (
            "{\"id\": \"d\", \"pattern\": \"miura.fold\", \"plan\": {\"bound\": 0}}",
            "d",
            "--bound: expected a fraction above 0 and at most 1, found 0",
        ),
        (
            "{\"id\": \"e\", \"pattern\": \"miura.fold\", \"plan\": {\"boud\": 1}}",
            "e",
            "unexpected argument '--boud'",
        ),
        (
            "{\"id\": \"f\", \"pattern\": \"miura.fold\", \"plan\": {\"json\": true}}",
            "f",
            "plan: json: expected an option of planning",
        ),
        (
            "{\"id\": \"g\", \"pattern\": \"miura.fold\", \"plan\": {\"collision\": false}}",
            "g",
            "--collision: expected a number or text",
        ),
        (
            "{\"id\": \"h\", \"pattern\": \"-\"}",
            "h",
            "expected a file, found -",
        ),
        (
            "{\"id\": \"i\", \"generate\": {\"family\": \"miura\", \"rows\": 0, \"cols\": 3}}",
            "i",
            "expected 1 to 3000, found 0",
        ),
        (
            "{\"id\": \"j\", \"generate\": {\"family\": \"cube\"}}",
            "j",
            "family: expected one of miura, waterbomb, yoshimura, quad, square-twist, resch, kresling, found cube",
        ),
        (
            "{\"id\": \"k\", \"pattern\": \"miura.fold\", \"path\": \"miura.fold\"}",
            "k",
            "is an input file",
        ),
        (
            "{\"id\": \"l\", \"pattern\": \"miura.fold\", \"path\": \"nowhere/a.fold\"}",
            "l",
            "nowhere/a.fold",
        ),
        (
            "{\"id\": \"l\", \"pattern\": \"miura.fold\"}",
            "line 16",
            "expected an id that no line before has, found \"l\"",
        ),
        (
            "{\"id\": \"m\", \"pattern\": \"miura.fold\", \"plan\": {\"keep\": true}}",
            "m",
            "--output",
        ),
    ];
    let good = "{\"id\": \"last\", \"pattern\": \"miura.fold\"}";
    let mut text: Vec<u8> = bad
        .iter()
        .flat_map(|(line, ..)| [line.as_bytes(), b"\n"].concat())
        .collect();
    text.extend(b"\xff\xfe\n");
    text.extend(vec![b'x'; (1 << 27) + 3]);
    text.extend(format!("\n{good}\r\n").as_bytes());
    fs::write(folder.path("designs.jsonl"), text).unwrap();
    folder.done("batch designs.jsonl -o results.jsonl");
    let found = results(&folder, "results.jsonl");
    assert_eq!(found.len(), bad.len() + 3);
    for (result, (line, id, message)) in found.iter().zip(bad) {
        assert_eq!(result["id"], id, "{line}: {result}");
        let told = result["error"]["message"].as_str().unwrap();
        assert!(told.contains(message), "{line}: {told}");
    }
    assert!(
        found[bad.len()]["error"]["message"]
            .as_str()
            .unwrap()
            .contains("UTF-8")
    );
    assert!(
        found[bad.len() + 1]["error"]["message"]
            .as_str()
            .unwrap()
            .contains("64 MiB")
    );
    assert_eq!(found[bad.len() + 2]["outcome"], "planned");
    // An error has the place in its file, as that of `plan`.
    folder.write("broken.fold", "{\n\"a\": ]}");
    let answer = folder.run_with(
        "batch - -o -",
        b"{\"id\": \"a\", \"pattern\": \"broken.fold\"}",
    );
    let result: Value = serde_json::from_str(&answer.stdout).unwrap();
    let plan = folder.run("plan broken.fold --json").json();
    assert_eq!(result["error"], plan["error"]);
    assert_eq!(answer.status, Some(0));
}

/// Returns the numbers of the processes that a process has started.
#[cfg(target_os = "linux")]
fn children(of: u32) -> Vec<String> {
    let file = format!("/proc/{of}/task/{of}/children");
    let mut all = fs::read_to_string(file).unwrap_or_default();
    // Each thread has children of its own.
    for entry in fs::read_dir(format!("/proc/{of}/task"))
        .into_iter()
        .flatten()
        .flatten()
    {
        all += " ";
        all += &fs::read_to_string(entry.path().join("children")).unwrap_or_default();
    }
    let mut all: Vec<String> = all.split_whitespace().map(String::from).collect();
    all.sort();
    all.dedup();
    all
}

/// A process that plans designs is killed, or stopped so that it hangs; both are told in the result, and the others go on.
#[test]
#[cfg(target_os = "linux")]
fn a_design_that_ends_its_process_or_hangs_is_a_result() {
    for (signal, expected) in [
        ("-KILL", "its process ended (signal: 9"),
        ("-STOP", "did not end at its timeout"),
    ] {
        let folder = folder();
        // A pipe keeps the process at its first design until the signal has come.
        assert!(
            std::process::Command::new("mkfifo")
                .arg(folder.path("pipe.fold"))
                .status()
                .unwrap()
                .success()
        );
        folder.done("generate miura --rows 2 --cols 2 -o miura.fold");
        folder.write(
            "designs.jsonl",
            "{\"id\": \"a\", \"pattern\": \"pipe.fold\", \"plan\": {\"timeout\": 0.1}}\n{\"id\": \"b\", \"pattern\": \"miura.fold\"}\n",
        );
        let mut run = start(&folder, "batch designs.jsonl -o results.jsonl --jobs 1");
        let worker = loop {
            // Stopped before it is a program of its own, it would stop the process that starts it.
            if let [worker] = &children(run.id())[..]
                && fs::read_to_string(format!("/proc/{worker}/cmdline"))
                    .is_ok_and(|arguments| arguments.contains("--worker"))
            {
                break worker.clone();
            }
            sleep(Duration::from_millis(5));
        };
        let status = std::process::Command::new("kill")
            .args([signal, &worker])
            .status()
            .unwrap();
        assert!(status.success());
        assert!(run.wait().unwrap().success());
        let found = results(&folder, "results.jsonl");
        let told = found[0]["error"]["message"].as_str().unwrap();
        assert!(found[0]["id"] == "a" && told.contains(expected), "{told}");
        assert_eq!(found[1]["outcome"], "planned");
    }
}

#[test]
fn results_come_on_stdout_in_the_order_of_designs_on_stdin() {
    let folder = folder();
    designs(&folder, 30);
    folder.done("batch designs.jsonl -o results.jsonl --stable");
    // As an editor on another system writes it.
    let marked = format!("\u{feff}{}", folder.read("designs.jsonl"));
    let answer = folder.run_with("batch - -o - --stable --jobs 3", marked.as_bytes());
    assert_eq!(answer.stdout, folder.read("results.jsonl"));
    assert!(
        answer.stderr.starts_with("30 designs, written to <stdout>"),
        "{}",
        answer.stderr
    );
    let mut ids: Vec<String> = answer
        .stdout
        .lines()
        .map(|line| line[..22].to_string())
        .collect();
    let in_order = ids.clone();
    ids.sort();
    assert_eq!(ids, in_order);
}
