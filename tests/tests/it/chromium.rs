//! A page that is open in Chromium.
//!
//! `tests/run` installs Chromium. The environment variable `CHROME` names another program than `/usr/bin/chromium`.

use core::time::Duration;
use std::ffi::OsStr;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::thread::sleep;
use std::time::Instant;

use foldpath::view::{Scene, page};
use foldpath_tests::Random;
use headless_chrome::browser::tab::ModifierKey;
use headless_chrome::protocol::cdp::Emulation::SetDeviceMetricsOverride;
use headless_chrome::protocol::cdp::Input::DispatchMouseEvent;
use headless_chrome::protocol::cdp::Log::LogEntryLevel;
use headless_chrome::protocol::cdp::Network;
use headless_chrome::protocol::cdp::Page::CaptureScreenshotFormatOption::Png;
use headless_chrome::protocol::cdp::types::Event;
use headless_chrome::{Browser, LaunchOptions, Tab};
use nalgebra::{Matrix3, Vector3};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Longest time that a busy machine may take for anything.
pub(crate) const PATIENCE: Duration = Duration::from_secs(120);

/// A page that is open in a browser of its own.
pub(crate) struct View {
    pub(crate) tab: Arc<Tab>,
    /// Errors, messages and requests, none of which a page causes that works by itself.
    complaints: Arc<Mutex<Vec<String>>>,
    _browser: Browser,
    _directory: TempDir,
}

impl View {
    /// Opens the page of a path.
    pub(crate) fn open(scene: &Scene, switches: &[&str]) -> Self {
        let view = Self::open_page(&page(scene), switches);
        view.wait_for("window.foldpath !== undefined");
        view
    }

    /// Opens a page from a disk.
    pub(crate) fn open_page(html: &str, switches: &[&str]) -> Self {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("path.html");
        std::fs::write(&file, html).unwrap();
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
            idle_browser_timeout: PATIENCE,
            ..LaunchOptions::default()
        })
        .expect("Chromium starts");

        let tab = browser.new_tab().unwrap();
        tab.set_default_timeout(PATIENCE);
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
        Self {
            tab,
            complaints,
            _browser: browser,
            _directory: directory,
        }
    }

    /// Evaluates a JavaScript expression and returns its value.
    pub(crate) fn run(&self, script: &str) -> Value {
        let result = self.tab.evaluate(script, false).unwrap();
        result.value.unwrap_or_default()
    }

    pub(crate) fn text(&self, selector: &str) -> String {
        let text = self.run(&format!("document.querySelector('{selector}').textContent"));
        text.as_str().unwrap_or_default().to_owned()
    }

    /// Returns the picture as one number.
    pub(crate) fn drawn(&self) -> Value {
        self.run("foldpath.drawn()")
    }

    pub(crate) fn click(&self, selector: &str) {
        self.tab.find_element(selector).unwrap().click().unwrap();
    }

    pub(crate) fn key(&self, key: &str) {
        self.tab.press_key(key).unwrap();
    }

    pub(crate) fn key_with(&self, key: &str, modifiers: &[ModifierKey]) {
        let pressed = self.tab.press_key_with_modifiers(key, Some(modifiers));
        pressed.unwrap();
    }

    /// Clicks at this pixel of the canvas.
    pub(crate) fn click_at(&self, x: f64, y: f64) {
        let script = "(r => JSON.stringify([r.left, r.top]))(canvas.getBoundingClientRect())";
        let corner: [f64; 2] = serde_json::from_str(self.run(script).as_str().unwrap()).unwrap();
        let (x, y) = (corner[0] + x, corner[1] + y);
        let point = headless_chrome::browser::tab::point::Point { x, y };
        self.tab.click_point(point).unwrap();
    }

    /// Clicks the middle of an edge.
    pub(crate) fn click_edge(&self, edge: usize) {
        let place = self.run(&format!("JSON.stringify(foldpath.middleOf({edge}))"));
        let [x, y] = serde_json::from_str(place.as_str().unwrap()).unwrap();
        self.click_at(x, y);
    }

    /// Returns a list of coordinates on the page.
    pub(crate) fn points(&self, script: &str) -> Vec<Vector3<f64>> {
        let text = self.run(&format!("JSON.stringify({script})"));
        let numbers: Vec<f64> = serde_json::from_str(text.as_str().unwrap()).unwrap();
        let points = numbers.chunks(3).map(Vector3::from_column_slice);
        points.collect()
    }

    /// Returns what a JavaScript function of the time returns while the sheet is at each of these times. One script asks
    /// for all: between two scripts the browser would draw the sheet.
    pub(crate) fn at_times(&self, times: &[f64], function: &str) -> Vec<Vec<f64>> {
        let text = self.run(&format!(
            "JSON.stringify({times:?}.map(time => {{ foldpath.setTime(time); return [...{function}]; }}))"
        ));
        serde_json::from_str(text.as_str().unwrap()).unwrap()
    }

    /// Asserts that the sheet on the page has the expected shapes at these times, in whatever position: distances and
    /// volumes between random vertices are equal, to 1e-6 of its size.
    pub(crate) fn assert_shapes<'a>(
        &self,
        shapes: impl Iterator<Item = (f64, &'a [Vector3<f64>])> + Clone,
    ) {
        let times: Vec<f64> = shapes.clone().map(|(time, _)| time).collect();
        let found = self.at_times(&times, "foldpath.vertices()");
        for ((time, expected), numbers) in shapes.zip(found) {
            let points = numbers.chunks(3).map(Vector3::from_column_slice);
            assert_same_shape(time, &points.collect::<Vec<_>>(), expected);
        }
    }

    pub(crate) fn wait_for(&self, condition: &str) {
        let start = Instant::now();
        while self.run(condition) != json!(true) {
            assert!(
                start.elapsed() < PATIENCE,
                "in vain: {condition}; {:?}",
                self.complaints.lock().unwrap()
            );
            sleep(Duration::from_millis(20));
        }
    }

    pub(crate) fn drag(&self, selector: &str, (dx, dy): (f64, f64)) {
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

    /// Returns a PNG of the sheet.
    pub(crate) fn canvas(&self) -> Vec<u8> {
        let canvas = self.tab.find_element("canvas").unwrap();
        canvas.capture_screenshot(Png).unwrap()
    }

    /// Returns a PNG of the page.
    pub(crate) fn screenshot(&self) -> Vec<u8> {
        self.tab.capture_screenshot(Png, None, None, true).unwrap()
    }

    pub(crate) fn assert_quiet(&self) {
        assert_eq!(self.run("foldpath.errors.join('; ')"), json!(""));
        let complaints = self.complaints.lock().unwrap();
        assert!(complaints.is_empty(), "{complaints:#?}");
    }
}

fn assert_same_shape(time: f64, found: &[Vector3<f64>], expected: &[Vector3<f64>]) {
    assert_eq!(found.len(), expected.len());
    let from = |shape: &[Vector3<f64>], [i, j]: [usize; 2]| shape[j] - shape[i];
    let size = expected.iter().map(|p| (p - expected[0]).norm());
    let size = size.fold(0.0, f64::max);
    let mut random = Random::new(1);
    for _ in 0..500 {
        let mut draw = || random.whole(0, found.len() - 1);
        let [i, j, k, l] = [draw(), draw(), draw(), draw()];
        let [a, b] = [found, expected].map(|shape| {
            let arms = [j, k, l].map(|other| from(shape, [i, other]));
            (arms[0].norm(), Matrix3::from_columns(&arms).determinant())
        });
        assert!((a.0 - b.0).abs() < 1e-6 * size, "{time}: {i} and {j}");
        let volume = 1e-6 * size.powi(3);
        assert!((a.1 - b.1).abs() < volume, "{time}: {i}, {j}, {k}, {l}");
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
