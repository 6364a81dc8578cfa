//! The page of `foldpath view` in a real browser without a network.
//!
//! Needs Chromium: `tests/run` installs it; `CHROME` names another one than `/usr/bin/chromium`.

use core::time::Duration;
use std::{
    ffi::OsStr,
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
    thread::sleep,
    time::Instant,
};

use foldpath::formats::fold::{PathWriter, PatternFile, read_path, read_pattern};
use foldpath::planner::{Goal, PlanOptions, plan};
use foldpath::view::{Scene, page};
use headless_chrome::{
    Browser, LaunchOptions, Tab,
    protocol::cdp::{
        Emulation::SetDeviceMetricsOverride, Input::DispatchMouseEvent, Log::LogEntryLevel,
        Network, Page::CaptureScreenshotFormatOption::Png, types::Event,
    },
};
use serde_json::{Value, json};
use tempfile::TempDir;

/// The path that the page shows in these tests: the README's, planned, written and read again.
fn scene() -> Scene {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../patterns/miura-11x11.fold");
    let PatternFile { title, pattern } = read_pattern(Path::new(file)).unwrap();
    let goal = Goal::of_pattern(&pattern).unwrap();
    let plan = plan(&pattern, &goal, &PlanOptions::default());
    let writer = PathWriter {
        title: &title,
        pattern: &pattern,
        vertices: true,
        seed: 0,
        max_speed: PlanOptions::default().max_speed,
        max_acceleration: None,
    };
    let directory = tempfile::tempdir().unwrap();
    let written = directory.path().join("path.fold");
    std::fs::write(&written, writer.text(&plan.path)).unwrap();
    Scene::of_path(&read_path(&written).unwrap())
}

#[test]
fn sheet_follows_the_slider_the_play_button_and_the_mouse() {
    let scene = scene();
    let view = View::open(&scene, &[]);

    let states = ["0", "0.5", "1"].map(|fold| {
        view.run(&format!(
            "fold.value = {fold}; fold.dispatchEvent(new Event('input'))"
        ));
        assert_eq!(view.run("String(foldpath.position())"), fold);
        (view.run("foldpath.drawn()"), view.canvas())
    });
    for (a, b) in [(0, 1), (1, 2), (2, 0)] {
        assert_ne!(states[a].0, states[b].0, "drawn() at {a} and {b}");
        assert!(
            states[a].1 != states[b].1,
            "the same picture at {a} and {b}"
        );
    }
    view.run("foldpath.setPosition(0)");
    assert_eq!(
        view.run("foldpath.drawn()"),
        states[0].0,
        "the same position gives the same pixels"
    );

    view.tab.find_element("#play").unwrap().click().unwrap();
    view.wait_for("foldpath.position() > 0.02");
    view.tab.press_key(" ").unwrap(); // pauses
    let paused = view.run("foldpath.position()");
    sleep(Duration::from_millis(200));
    assert_eq!(view.run("foldpath.position()"), paused);

    view.run("foldpath.setPosition(0)");
    view.tab.press_key("ArrowRight").unwrap();
    let second = format!("readout.innerText.includes('2 of {}')", scene.knots.len());
    assert_eq!(view.run(&second), json!(true));

    view.run("foldpath.setPosition(0.5)");
    let before = (view.run("foldpath.drawn()"), view.canvas());
    view.drag("canvas", (60.0, -20.0));
    assert_ne!(view.run("foldpath.drawn()"), before.0);
    assert!(view.canvas() != before.1, "dragging left the picture alone");

    if let Some(path) = std::env::var_os("FOLDPATH_SCREENSHOT") {
        std::fs::write(path, view.screenshot()).unwrap();
    }
    view.assert_quiet();
}

#[test]
fn path_without_positions_shows_the_flat_pattern_and_says_so() {
    let mut scene = scene();
    for knot in &mut scene.knots {
        knot.vertices = None;
    }
    let view = View::open(&scene, &[]);
    let message = view.run("message.innerText");
    assert!(
        message
            .as_str()
            .unwrap()
            .contains("without vertex positions"),
        "{message}"
    );
    let flat = view.run("foldpath.drawn()");
    view.run("foldpath.setPosition(1)");
    assert_eq!(view.run("foldpath.drawn()"), flat);
    assert_eq!(
        view.run("document.querySelectorAll('.curve').length"),
        json!(4)
    );
    view.assert_quiet();
}

#[test]
fn browser_without_webgl_is_told_and_still_gets_curves() {
    let view = View::open(&scene(), &["--disable-3d-apis"]);
    let message = view.run("message.innerText");
    assert!(message.as_str().unwrap().contains("WebGL"), "{message}");
    assert_eq!(
        view.run("document.querySelectorAll('.curve').length"),
        json!(4)
    );
    view.assert_quiet();
}

/// A page open in a browser of its own.
struct View {
    tab: Arc<Tab>,
    /// What a page that works by itself never causes: errors, messages and requests.
    complaints: Arc<Mutex<Vec<String>>>,
    _browser: Browser,
    _directory: TempDir,
}

impl View {
    fn open(scene: &Scene, switches: &[&str]) -> Self {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("path.html");
        std::fs::write(&file, page(scene)).unwrap();
        let url = format!("file://{}", file.display());

        let switches = [
            "--use-gl=angle",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--disable-component-update",
            "--disable-quic",
            "--hide-scrollbars",
        ]
        .iter()
        .chain(switches)
        .map(OsStr::new)
        .collect();
        let browser = Browser::new(LaunchOptions {
            path: Some(chromium()),
            sandbox: false, // a container's root user cannot have one
            user_data_dir: Some(directory.path().join("profile")),
            args: switches,
            ..LaunchOptions::default()
        })
        .expect("Chromium starts");

        let tab = browser.new_tab().unwrap();
        tab.enable_runtime().unwrap();
        tab.enable_log().unwrap();
        let network: Network::Enable = serde_json::from_value(json!({})).unwrap();
        tab.call_method(network).unwrap();
        let size: SetDeviceMetricsOverride = serde_json::from_value(json!({
            "width": 1200, "height": 800, "deviceScaleFactor": 1, "mobile": false,
        }))
        .unwrap();
        tab.call_method(size).unwrap();
        let complaints = Arc::<Mutex<Vec<String>>>::default();
        let (list, own) = (complaints.clone(), url.clone());
        tab.add_event_listener(Arc::new(move |event: &Event| {
            list.lock().unwrap().extend(complaint(event, &own));
        }))
        .unwrap();

        tab.navigate_to(&url)
            .unwrap()
            .wait_until_navigated()
            .unwrap();
        let view = Self {
            tab,
            complaints,
            _browser: browser,
            _directory: directory,
        };
        view.wait_for("window.foldpath !== undefined");
        view
    }

    /// Value of a JavaScript expression.
    fn run(&self, script: &str) -> Value {
        let result = self.tab.evaluate(script, false).unwrap();
        result.value.unwrap_or_default()
    }

    fn wait_for(&self, condition: &str) {
        let start = Instant::now();
        while self.run(condition) != json!(true) {
            assert!(
                start.elapsed() < Duration::from_secs(20),
                "in vain: {condition}; {:?}",
                self.complaints.lock().unwrap()
            );
            sleep(Duration::from_millis(20));
        }
    }

    fn drag(&self, selector: &str, (dx, dy): (f64, f64)) {
        let from = self.tab.find_element(selector).unwrap();
        let from = from.get_midpoint().unwrap();
        for (kind, part) in [
            ("mousePressed", 0.0),
            ("mouseMoved", 0.5),
            ("mouseMoved", 1.0),
            ("mouseReleased", 1.0),
        ] {
            let event: DispatchMouseEvent = serde_json::from_value(json!({
                "type": kind, "button": "left", "clickCount": 1,
                "x": from.x + part * dx, "y": from.y + part * dy,
            }))
            .unwrap();
            self.tab.call_method(event).unwrap();
        }
    }

    /// PNG of the sheet.
    fn canvas(&self) -> Vec<u8> {
        let canvas = self.tab.find_element("canvas").unwrap();
        canvas.capture_screenshot(Png).unwrap()
    }

    /// PNG of the page.
    fn screenshot(&self) -> Vec<u8> {
        self.tab.capture_screenshot(Png, None, None, true).unwrap()
    }

    fn assert_quiet(&self) {
        assert_eq!(self.run("foldpath.errors.join('; ')"), json!(""));
        let complaints = self.complaints.lock().unwrap();
        assert!(complaints.is_empty(), "{complaints:#?}");
    }
}

fn complaint(event: &Event, own: &str) -> Option<String> {
    match event {
        Event::RuntimeExceptionThrown(e) => Some(format!("{:?}", e.params.exception_details)),
        Event::RuntimeConsoleAPICalled(e) => Some(format!("{:?}", e.params.args)),
        Event::LogEntryAdded(e) if e.params.entry.level == LogEntryLevel::Error => {
            Some(e.params.entry.text.clone())
        }
        Event::NetworkRequestWillBeSent(e) if e.params.request.url != own => {
            Some(format!("request for {}", e.params.request.url))
        }
        _ => None,
    }
}

fn chromium() -> PathBuf {
    let path = std::env::var_os("CHROME").map_or("/usr/bin/chromium".into(), PathBuf::from);
    assert!(
        path.exists(),
        "no Chromium at {}: run the tests with tests/run, which installs it, or set CHROME",
        path.display()
    );
    path
}
