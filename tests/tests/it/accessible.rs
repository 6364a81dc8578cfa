//! Does axe-core find what keeps people from using the pages (WCAG 2.1, levels A and AA)? It judges the pages of `foldpath view` and
//! that of `web/`, at the widths of a phone, a tablet and a desk, in light and dark.
//!
//! `FOLDPATH_AXE` names the file `axe.min.js` of the npm package axe-core, which `tests/run full` installs. Without it these tests say
//! that they are skipped; without `FOLDPATH_WEB` the page of `web/` is left out.

use std::path::PathBuf;

use foldpath::motion::PlateOptions;
use foldpath::pattern::Unit;
use foldpath::planner::{PlanOptions, PlateRequest};
use foldpath::progress::Watch;
use foldpath::read::fold::PatternFile;
use foldpath::read::parse_pattern;
use foldpath::sensitivity::{Loads, Tolerance};
use foldpath::view::{Scene, page, pattern_page};
use foldpath_tests::{Planned, path_file, pattern_file};
use serde_json::json;

use crate::chromium::View;
use crate::loads::load;

/// Returns the text of axe-core; prints that the test is skipped and returns `None` if it is not there.
fn axe() -> Option<String> {
    let Some(path) = std::env::var_os("FOLDPATH_AXE").map(PathBuf::from) else {
        println!("skipped: FOLDPATH_AXE is not set");
        return None;
    };
    Some(std::fs::read_to_string(path).expect("axe-core is installed"))
}

/// Returns what axe-core finds in the page, one line for each place. A frame is a page of its own.
fn violations(view: &View) -> String {
    view.run(
        "axe.run({ runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa'], iframes: false }).then(({ violations, passes }) => {
           window.found = violations.flatMap(({ id, help, nodes }) => nodes.map(node => `${id}: ${help}: ${node.html} ${node.failureSummary}`)).join('\\n');
           if (passes.length < 8) window.found += 'hardly a rule applies';
         }); 0",
    );
    view.wait_for("window.found !== undefined");
    let found = view.run("(found => { delete window.found; return found; })(window.found)");
    found.as_str().unwrap().to_owned()
}

/// Asserts that axe-core finds nothing, at any width, in light and dark, and that nothing is beyond the width.
fn assert_accessible(name: &str, view: &View, axe: &str) {
    view.run(&format!("{axe}; 0"));
    for scheme in ["light", "dark"] {
        view.prefer(&[
            ("prefers-color-scheme", scheme),
            ("prefers-reduced-motion", "reduce"),
        ]);
        for (width, height) in [(360, 640), (768, 1024), (1280, 720)] {
            view.resize(width, height);
            assert_eq!(violations(view), "", "{name}, {width} pixels, {scheme}");
            let reach = view.run("document.documentElement.scrollWidth");
            assert_eq!(reach, json!(width), "{name}");
            if let Some(folder) = std::env::var_os("FOLDPATH_SCREENSHOTS") {
                let file = format!("{name}-{width}-{scheme}.png");
                std::fs::write(PathBuf::from(folder).join(file), view.screenshot()).unwrap();
            }
        }
    }
}

fn scene(planned: &Planned) -> Scene {
    Scene::of_path(&path_file(&planned.text()).unwrap())
}

fn file(name: &str) -> PatternFile {
    let path = pattern_file(name);
    parse_pattern(&path, &std::fs::read(&path).unwrap()).unwrap()
}

#[test]
#[ignore = "needs axe-core"]
fn pages_of_paths_and_patterns_have_no_violation() {
    let Some(axe) = axe() else { return };
    let plates = PlateRequest::given(PlateOptions::of_thickness(0.1));
    let defaults = PlanOptions::default();
    for (name, pattern, options) in [
        ("plain", "waterbomb-4x6", defaults.clone()),
        (
            "plates",
            "miura-3x3",
            defaults.clone().with(|it| it.plates = Some(plates)),
        ),
        (
            "crossing",
            "waterbomb-12x22-crossing",
            defaults.clone().with(|it| it.collision = false),
        ),
        ("shortfall", "kresling-2x6", defaults.clone()),
    ] {
        let planned = Planned::new(pattern, &options);
        if planned.plan.motion.is_none() {
            panic!("{name}: {:?}", planned.plan.reason);
        }
        let view = View::open_page(&page(&scene(&planned)), &[]);
        view.wait_for("window.foldpath !== undefined");
        view.run("foldpath.setPosition(0.5); select(scene.turns.findIndex(turn => turn))");
        assert_accessible(name, &view, &axe);
        view.run("help.showModal()");
        assert_accessible(&format!("{name}-help"), &view, &axe);
    }
    let mut motion = path_file(&Planned::new("waterbomb-4x6", &defaults).text()).unwrap();
    motion.measured_in(Unit::Millimetre);
    let tolerance = Tolerance::of(&motion, Watch::default()).unwrap();
    let load = load([0.0, 0.0, -9.81], 0.0, None);
    let loads = Loads::least(&motion, &load, Watch::default()).unwrap();
    let asked = Scene::of_path(&motion).with_tolerance(&motion, &tolerance, Some(0.01));
    let view = View::open(&asked.with_torques(&motion, &loads), &[]);
    view.run("foldpath.setPosition(0.5); select(scene.turns.findIndex(turn => turn))");
    assert_accessible("asked", &view, &axe);
    let PatternFile { title, pattern } = file("kresling-2x6");
    let view = View::open_page(&pattern_page(&title, &pattern, Watch::default()), &[]);
    assert_accessible("pattern", &view, &axe);
    // axe-core looks at this page.
    view.run("document.documentElement.removeAttribute('lang')");
    assert!(violations(&view).starts_with("html-has-lang"));
}

#[test]
#[ignore = "needs axe-core, and the page that web/build builds"]
fn the_page_has_no_violation() {
    let Some(axe) = axe() else { return };
    let Some(folder) = std::env::var_os("FOLDPATH_WEB").map(PathBuf::from) else {
        println!("skipped: FOLDPATH_WEB is not set");
        return;
    };
    let html = std::fs::read_to_string(folder.join("foldpath.html")).expect("web/build ran");
    let view = View::open_page(&html, &[]);
    for (name, link) in [
        ("page", "family=miura&rows=6&cols=8"),
        ("page-no", "family=kresling&rows=2&cols=6"),
        ("page-refuses", "family=none"),
    ] {
        view.follow(link);
        view.wait_for("status.classList.contains('no') || !element('answer').hidden");
        assert_accessible(name, &view, &axe);
    }
}
