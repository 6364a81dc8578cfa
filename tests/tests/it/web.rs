//! Does the page of `web/` plan what is dropped on it, in a real browser, from a disk and without a network?
//!
//! `web/build` builds the page; `FOLDPATH_WEB` names the folder in which it is. Without it these tests say that they are
//! skipped.

use std::path::PathBuf;

use foldpath::export::svg_pattern::by_letters;
use foldpath::planner::{Outcome, PlanOptions};
use foldpath::request::FAMILIES;
use foldpath::view::Scene;
use foldpath_tests::{Planned, path_file, pattern_file};
use serde_json::{Value, json};

use crate::chromium::View;

/// Opens the page; prints that the test is skipped and returns `None` if it is not built.
fn page() -> Option<View> {
    let Some(folder) = std::env::var_os("FOLDPATH_WEB").map(PathBuf::from) else {
        println!("skipped: FOLDPATH_WEB is not set");
        return None;
    };
    let html = std::fs::read_to_string(folder.join("foldpath.html")).expect("web/build ran");
    let view = View::open_page(&html, &[]);
    // The page begins with a pattern of its gallery.
    assert_eq!(first(&view), "miura-11x11.fold: planned");
    Some(view)
}

/// Waits for the answer to what the page itself has opened.
fn first(view: &View) -> String {
    view.wait_for("status.classList.contains('no') || !element('answer').hidden");
    view.text("#status")
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

    drop_file(&view, "scan.svg", "%PDF-1.7");
    let told = answer(&view);
    assert!(told.contains("export the drawing as SVG"), "{told}");

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

/// The panels of a Kresling pattern have to bend, and the answer says by how much.
#[test]
#[ignore = "needs the page that web/build builds"]
fn the_next_step_of_a_no_is_a_button() {
    let Some(view) = page() else { return };
    drop_file(&view, "kresling.fold", &kresling());
    let told = answer(&view);
    assert!(!told.contains("planned"), "{told}");
    let field = view.text("#next button");
    assert!(field.contains("Panels may bend by"), "{field}");
    view.click("#next button");
    assert!(answer(&view).ends_with(": planned"), "{}", answer(&view));
    let bend = view.run("Number(options.bend.value)").as_f64().unwrap();
    assert!(bend > 0.0, "{bend}");

    // The goal is the flat sheet.
    let flat = CP.replace("3 1 0 1 2", "0 1 0 1 2");
    view.run("options.reset()");
    drop_file(&view, "flat.cp", &flat);
    let told = answer(&view);
    assert!(view.run("status.className") == json!("no"), "{told}");
}

#[test]
#[ignore = "needs the page that web/build builds"]
fn a_pattern_is_drawn_before_its_plan_and_an_error_takes_the_old_answer_away() {
    let Some(view) = page() else { return };
    view.run(
        "window.seen = []; new MutationObserver(() => seen.push(element('pattern').alt)).observe(element('pattern'), { attributes: true }); 0",
    );
    drop_file(&view, "line.cp", CP);
    assert!(answer(&view).ends_with(": planned"));
    assert_eq!(
        view.run("seen.includes('Crease pattern of line.cp')"),
        json!(true)
    );
    assert_eq!(view.run("element('view').hidden"), json!(false));

    drop_file(&view, "bad.fold", "{\"vertices_coords\": 3}");
    assert!(answer(&view).contains("vertices_coords"));
    for part in ["answer", "next", "view", "pattern"] {
        assert_eq!(
            view.run(&format!("element('{part}').hidden")),
            json!(true),
            "{part}"
        );
    }
    assert_eq!(
        view.run("element('view').contentWindow.foldpath === undefined"),
        json!(true)
    );
}

#[test]
#[ignore = "needs the page that web/build builds"]
fn every_family_is_made_with_sliders() {
    let Some(view) = page() else { return };
    let families = view.run("[...family.options].map(it => it.value).join()");
    let families = families.as_str().unwrap().to_owned();
    let names: Vec<&str> = FAMILIES.iter().map(|family| family.name).collect();
    assert_eq!(families, format!(",{}", names.join(",")));
    let choose = |name: &str| {
        view.run(&format!(
            "say('working'); clear(); family.value = '{name}'; family.dispatchEvent(new Event('change')); 0"
        ));
        view.wait_for("status.classList.contains('no') || !element('answer').hidden");
        view.text("#status")
    };
    for info in FAMILIES {
        let told = choose(info.name);
        assert!(told.starts_with(&format!("{}-", info.name)), "{told}");
        let sliders = view.run("parameters.querySelectorAll('input, select').length");
        assert_eq!(sliders, json!(info.parameters.len()), "{}", info.name);
    }
    assert_eq!(choose("miura"), "miura-11x11.fold: planned");
    view.run("clear(); say('working'); (rows => { rows.value = 5; rows.dispatchEvent(new Event('input')); })(parameters.querySelector('[name=rows]')); 0");
    assert_eq!(first(&view), "miura-5x11.fold: planned");
    assert_eq!(
        in_picture(&view, CREASES),
        json!((4 * 11 + 5 * 10).to_string())
    );
}

/// A link carries the pattern with the options; whatever else stands in one is refused.
#[test]
#[ignore = "needs the page that web/build builds"]
fn links_carry_patterns_and_hostile_ones_are_refused() {
    let Some(view) = page() else { return };
    let copied = || {
        view.run("copyLink().then(() => { window.copied = location.hash.slice(1); }); 0");
        view.wait_for("window.copied !== undefined");
        let link = view.run("(link => { delete window.copied; return link; })(window.copied)");
        link.as_str().unwrap().to_owned()
    };
    view.run("options.fold.value = '0.25'");
    let family = copied();
    assert!(family.starts_with("family=miura&rows=11"), "{family}");
    drop_file(&view, "line.cp", CP);
    assert!(answer(&view).ends_with(": planned"));
    let file = copied();
    assert!(file.starts_with("name=line.cp&file="), "{file}");

    for (link, told) in [
        (&family, "miura-11x11.fold: planned"),
        (&file, "line.cp: planned"),
    ] {
        view.follow(link);
        assert_eq!(first(&view), told);
        assert_eq!(view.run("options.fold.value"), json!("0.25"));
    }

    // A megabyte and a byte of nothing take a thousand bytes.
    view.run("packed(new Uint8Array(MOST_BYTES + 1)).then(text => { window.bomb = text; }); 0");
    view.wait_for("window.bomb !== undefined");
    let bomb = view.run("bomb");
    let bomb = format!("name=a.fold&file={}", bomb.as_str().unwrap());
    let long = format!("name=a.fold&file={}", "A".repeat(40_000));
    for hostile in [
        "family=miura&rows=100000&cols=100000",
        "family=miura&rows=&cols=3",
        "family=__proto__",
        "family=miura&rows=3&cols=3&constructor=1",
        "family=<img src=x onerror=alert(1)>",
        "name=../a.fold&file=AAAA",
        "name=a.html&file=AAAA",
        "name=a.fold&file=%3Cscript%3E",
        "name=a.fold&file=AAAA",
        "name=a.fold",
        "family=miura&rows=3&cols=3&plan.timeout=1e9",
        "family=miura&rows=3&cols=3&plan.length=1",
        "family=miura&rows=3&cols=3&plan.goal=/etc/passwd",
        "family=miura&rows=3&cols=3&plan.collision=maybe",
        &bomb,
        &long,
        "x",
    ] {
        view.follow(hostile);
        let told = first(&view);
        let shown = &hostile[..hostile.len().min(60)];
        assert!(
            told.starts_with("This link is not opened: "),
            "{shown}: {told}"
        );
        assert_eq!(view.run("opened === null"), json!(true), "{shown}");
        assert_eq!(
            view.run("document.querySelectorAll('img, iframe').length"),
            json!(2)
        );
    }
}

/// Opens a file, sets an option, plays and downloads without a mouse.
#[test]
#[ignore = "needs the page that web/build builds"]
fn the_page_works_by_keyboard_at_all_widths() {
    let Some(view) = page() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("line.cp");
    std::fs::write(&file, CP).unwrap();
    let to = json!({ "behavior": "allow", "downloadPath": folder.path() });
    view.call("Page.setDownloadBehavior", to);
    let intercept = json!({ "enabled": true });
    view.call("Page.setInterceptFileChooserDialog", intercept);
    for (width, height) in [(360, 640), (768, 1024), (1280, 720)] {
        view.resize(width, height);
        view.run("clear(); say('working'); options.reset(); document.activeElement.blur(); scrollTo(0, 0)");
        view.tab_to("document.activeElement === element('file')");
        // The input itself is not seen; its label shows the focus.
        assert_eq!(
            view.run("getComputedStyle(element('file').parentElement).outlineStyle"),
            json!("solid")
        );
        view.key("Enter");
        let chooser = view.event("Page.fileChooserOpened");
        let chosen = json!({ "files": [file], "backendNodeId": chooser["backendNodeId"] });
        view.call("DOM.setFileInputFiles", chosen);
        assert_eq!(first(&view), "line.cp: planned");

        view.tab_to("document.activeElement === options.fold");
        view.run("clear(); say('working')");
        for key in ["0", ".", "2", "5", "Enter"] {
            view.key(key);
        }
        assert_eq!(first(&view), "line.cp: planned");
        assert_eq!(view.run("options.fold.value"), json!("0.25"));
        in_picture(&view, CREASES);

        view.run("document.activeElement.blur()");
        view.tab_to("document.activeElement === element('view') && element('view').contentDocument.activeElement?.id === 'play'");
        view.key(" ");
        let position = "element('view').contentWindow.foldpath.position() > 0";
        view.wait_for(position);

        view.tab_to("document.activeElement.value === 'csv'");
        view.key("Enter");
        let table = folder.path().join("line.csv");
        let start = std::time::Instant::now();
        while !table.exists() {
            assert!(start.elapsed() < crate::chromium::PATIENCE, "no download");
            std::thread::sleep(core::time::Duration::from_millis(20));
        }
        std::fs::remove_file(table).unwrap();

        assert_eq!(
            view.run("document.documentElement.scrollWidth"),
            json!(width)
        );
        assert_eq!(
            view.overlaps("header > *, main > section, main > form"),
            json!("")
        );
        if let Some(path) = std::env::var_os("FOLDPATH_SCREENSHOT") {
            let path = PathBuf::from(path).with_extension(format!("{width}.png"));
            std::fs::write(path, view.screenshot()).unwrap();
        }
    }
}

/// Writes the pictures of the documents into the folder `FOLDPATH_PICTURES`: `docs/pictures/shoot` runs it.
#[test]
#[ignore = "needs the page that web/build builds"]
fn the_documents_have_pictures_of_the_pages() {
    let Some(folder) = std::env::var_os("FOLDPATH_PICTURES").map(PathBuf::from) else {
        println!("skipped: FOLDPATH_PICTURES is not set");
        return;
    };
    let Some(page) = page() else { return };
    let shoot = |view: &View, name: &str, [width, height]: [u32; 2], picture: &str| {
        view.resize(width, height);
        view.run(&format!(
            "{picture}.foldpath.setPosition(0.7); {picture}.scrollTo(0, 0)"
        ));
        view.run(&format!("{picture}.foldpath.drawn()"));
        std::fs::write(folder.join(name), view.screenshot()).unwrap();
    };
    let inside = "document.getElementById('view').contentWindow";
    page.follow("family=waterbomb&rows=8&cols=10&fold=0.5");
    assert_eq!(first(&page), "waterbomb-8x10.fold: planned");
    in_picture(&page, CREASES);
    shoot(&page, "page.png", [1280, 800], inside);
    page.follow("family=kresling&rows=2&cols=6");
    assert!(first(&page).contains("partial"));
    in_picture(&page, CREASES);
    shoot(&page, "page-no.png", [1280, 800], inside);
    let planned = Planned::new("resch-3x3", &PlanOptions::default());
    let scene = Scene::of_path(&path_file(&planned.text()).unwrap());
    let view = View::open(&scene, &[]);
    shoot(&view, "view.png", [1280, 800], "window");
    shoot(&view, "view-phone.png", [360, 720], "window");
}

/// A Kresling pattern, whose panels have to bend.
fn kresling() -> String {
    std::fs::read_to_string(pattern_file("kresling-2x6")).unwrap()
}
