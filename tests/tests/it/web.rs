//! Does the page of `web/` plan what is dropped on it, in a real browser, from a disk and without a network?
//!
//! `web/build` builds the page; `FOLDPATH_WEB` names the folder in which it is. Without it these tests say that they are
//! skipped.

use std::path::PathBuf;

use foldpath::export::svg_pattern::by_letters;
use foldpath::planner::{Outcome, PlanOptions};
use foldpath_tests::{Planned, pattern_file};
use serde_json::{Value, json};

use crate::chromium::View;

/// Opens the page; prints that the test is skipped and returns `None` if it is not built.
fn page() -> Option<View> {
    let Some(folder) = std::env::var_os("FOLDPATH_WEB").map(PathBuf::from) else {
        println!("skipped: FOLDPATH_WEB is not set");
        return None;
    };
    let html = std::fs::read_to_string(folder.join("foldpath.html")).expect("web/build ran");
    Some(View::open_page(&html, &[]))
}

/// Drops a file on the page.
fn drop_file(view: &View, name: &str, content: &str) {
    let [name, content] = [name, content].map(|text| json!(text).to_string());
    view.run(&format!(
        "(() => {{ say('working'); const data = new DataTransfer(); data.items.add(new File([{content}], {name}));
         dispatchEvent(new DragEvent('drop', {{ dataTransfer: data, cancelable: true }})); }})()"
    ));
}

/// Waits for the answer to what was dropped, and returns it with the file's name.
fn answer(view: &View) -> String {
    view.wait_for("waiting.size === 0 && cancel.hidden && !status.textContent.endsWith('working')");
    view.text("#status")
}

/// Waits until the picture of the sheet is drawn, and returns a value from its page, as an expression of its window
/// `picture`.
fn in_picture(view: &View, expression: &str) -> Value {
    let window = "document.getElementById('view').contentWindow";
    view.wait_for(&format!(
        "{window}.foldpath !== undefined && {window}.foldpath.drawn() !== 0"
    ));
    view.run(&format!("(picture => {expression})({window})"))
}

/// The number of creases in the header of the picture's page.
const CREASES: &str = "picture.document.querySelector('#counts div:nth-child(2) dd').textContent";

/// A square with a line from border to border.
const CP: &str = "1 0 0 2 0\n1 2 0 2 2\n1 2 2 0 2\n1 0 2 0 0\n3 1 0 1 2\n";
/// Three walls, and a floor between two of them.
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 0 1 1\nv 1 0 1\nv 1 1 1\n\
                   f 1 2 3 4\nf 5 1 4 6\nf 2 7 8 3\n";
/// A line that bends at a vertex inside the sheet cannot turn.
const LOCKED: &str =
    "1 0 0 2 0\n1 2 0 4 0\n1 4 0 4 2\n1 4 2 2 2\n1 2 2 0 2\n1 0 2 0 0\n3 2 0 2.5 1\n3 2.5 1 2 2\n";

#[test]
#[ignore = "needs the page that web/build builds"]
fn a_dropped_file_of_each_format_is_planned_and_shown() {
    let Some(view) = page() else { return };
    let planned = Planned::new("miura-3x3", &PlanOptions::default());
    let fold = std::fs::read_to_string(pattern_file("miura-3x3")).unwrap();
    let svg = by_letters("miura", &planned.file.pattern);
    for (name, content, creases) in [
        ("miura-3x3.fold", &*fold, 12),
        ("miura.svg", &svg, 12),
        ("line.cp", CP, 1),
        ("tray.obj", OBJ, 2),
    ] {
        drop_file(&view, name, content);
        let told = answer(&view);
        assert!(told.ends_with(": planned"), "{name}: {told}");
        assert_eq!(
            in_picture(&view, CREASES),
            json!(creases.to_string()),
            "{name}"
        );
        for format in ["fold", "csv", "glb", "traj", "pattern"] {
            view.run(&format!(
                "ask('file', {{ format: '{format}' }}).then(bytes => {{ window.size = bytes.length; }}); 0"
            ));
            view.wait_for("window.size > 0");
            view.run("delete window.size");
        }
        assert_eq!(
            in_picture(&view, "picture.foldpath.errors.length"),
            json!(0),
            "{name}"
        );
    }
}

#[test]
#[ignore = "needs the page that web/build builds"]
fn paths_have_the_bytes_of_the_command() {
    let Some(view) = page() else { return };
    let patterns = pattern_file("").with_extension("");
    let mut names: Vec<String> = std::fs::read_dir(patterns)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "fold"))
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    names.sort();
    let mut compared = 0;
    for name in &names {
        let planned = Planned::new(name, &PlanOptions::default());
        if planned.plan.outcome != Outcome::Planned {
            println!("{name}: {}", planned.plan.outcome.name());
            continue;
        }
        compared += 1;
        let text = std::fs::read_to_string(pattern_file(name)).unwrap();
        drop_file(&view, &format!("{name}.fold"), &text);
        let told = answer(&view);
        assert!(told.ends_with(": planned"), "{name}: {told}");
        view.run("ask('file', { format: 'fold' }).then(bytes => { window.found = new TextDecoder().decode(bytes); }); 0");
        view.wait_for("window.found !== undefined");
        let found = view.run("(found => { delete window.found; return found; })(window.found)");
        assert!(
            found.as_str() == Some(&planned.text()),
            "{name}: other bytes"
        );
    }
    assert!(compared >= 10, "{compared}");
}

#[test]
#[ignore = "needs the page that web/build builds"]
fn a_no_shows_its_place_and_bad_input_is_told() {
    let Some(view) = page() else { return };
    drop_file(&view, "locked.cp", LOCKED);
    let told = answer(&view);
    assert!(
        told.starts_with("locked.cp: ") && !told.contains("planned"),
        "{told}"
    );
    assert_eq!(view.run("status.className"), json!("no"));
    let place = in_picture(
        &view,
        "picture.document.querySelector('#shortfall').textContent",
    );
    assert!(place.as_str().unwrap().contains("at (2.5, 1)"), "{place}");
    assert_eq!(in_picture(&view, "picture.foldpath.view.cause"), json!(0));
    if let Some(path) = std::env::var_os("FOLDPATH_SCREENSHOT") {
        std::fs::write(path, view.screenshot()).unwrap();
    }

    drop_file(&view, "bad.fold", "{\"vertices_coords\": 3}");
    let told = answer(&view);
    assert!(told.contains("vertices_coords"), "{told}");

    drop_file(&view, "line.cp", CP);
    assert!(answer(&view).ends_with(": planned"));
    view.run("options.fold.value = '0.25'; options.dispatchEvent(new Event('change')); 0");
    assert!(answer(&view).ends_with(": planned"));
    let angle = in_picture(
        &view,
        "(picture.foldpath.setPosition(1), Math.max(...picture.foldpath.angles().map(Math.abs)))",
    );
    assert!(
        (angle.as_f64().unwrap().to_degrees() - 45.0).abs() < 1e-9,
        "{angle}"
    );
}

#[test]
#[ignore = "needs the page that web/build builds"]
fn a_long_plan_is_cancelled_and_another_begins() {
    let Some(view) = page() else { return };
    view.run("options.timeout.value = '100'; ask('generate', { family: { family: 'miura', rows: 3, cols: 3 } }).then(() => { window.warm = true; }); 0");
    view.wait_for("window.warm");
    // A sheet of 300 rows of 300 faces takes seconds to read and to plan.
    view.run(
        "ask('generate', { family: { family: 'miura', rows: 300, cols: 300 } }).then(text => { window.large = text; }); 0",
    );
    view.wait_for("window.large !== undefined");
    view.run("openPattern('large.fold', new TextEncoder().encode(window.large)); 0");
    view.wait_for("!cancel.hidden");
    view.run("new MutationObserver(() => { window.ended ??= performance.now(); }).observe(status, { childList: true });
         window.pressed = performance.now(); cancel.click(); 0");
    view.wait_for("status.textContent === 'cancelled'");
    println!("cancelled after {} ms", view.run("ended - pressed"));
    drop_file(&view, "line.cp", CP);
    assert!(answer(&view).ends_with(": planned"));
}

/// As other programs for origami open a window and send it a pattern.
#[test]
#[ignore = "needs the page that web/build builds"]
fn a_pattern_sent_by_another_window_is_answered() {
    let Some(view) = page() else { return };
    let fold = std::fs::read_to_string(pattern_file("miura-3x3")).unwrap();
    view.run(
        "window.replies = []; addEventListener('message', ({ data }) => { if (data.from === 'foldpath') replies.push(data); }); 0",
    );
    view.run(&format!(
        "postMessage({{ op: 'importFold', fold: {fold} }}, '*'); 0"
    ));
    view.wait_for("replies.length > 0");
    assert_eq!(view.run("replies[0].outcome"), json!("planned"));
    assert_eq!(view.run("replies[0].answer.groups"), json!(2));
}

/// A path of panels that bend holds with the bend of the form, and not without it.
#[test]
#[ignore = "needs the page that web/build builds"]
fn a_dropped_path_is_judged_with_the_options_of_the_form() {
    let Some(view) = page() else { return };
    let options = PlanOptions::default().with(|it| it.bend = 12_f64.to_radians());
    let bent = Planned::new("kresling-2x6", &options);
    assert!(bent.plan.max_bend > 0.0);
    drop_file(&view, "bent.fold", &bent.text());
    assert!(answer(&view).contains("fails"), "{}", answer(&view));
    view.run(
        "options.bend.value = '12'; say('working'); options.dispatchEvent(new Event('change')); 0",
    );
    let told = answer(&view);
    assert!(told.ends_with(": holds"), "{told}");
    assert_eq!(view.run("element('files').checkVisibility()"), json!(false));
}
