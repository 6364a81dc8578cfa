//! A page that is open in Chromium.
//!
//! `tests/run` installs Chromium. The environment variable `CHROME` names another program than `/usr/bin/chromium`.

use core::cell::RefCell;
use core::time::Duration;
use std::path::PathBuf;
use std::thread::sleep;
use std::time::Instant;

use base64::prelude::{BASE64_STANDARD, Engine as _};
use foldpath::view::{Scene, page};
use foldpath_tests::Random;
use nalgebra::{Matrix3, Vector3};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::devtools::Devtools;

/// Longest time that a busy machine may take for anything.
pub(crate) const PATIENCE: Duration = Duration::from_secs(120);

/// Keys that are held while another is pressed, as the protocol has them.
pub(crate) const SHIFT: u32 = 8;

/// Name of the file of the page.
const PAGE: &str = "path.html";

/// A page that is open in a browser of its own.
pub(crate) struct View {
    devtools: RefCell<Devtools>,
    /// Address of the page.
    url: String,
    directory: TempDir,
}

impl View {
    /// Opens the page of a path.
    pub(crate) fn open(scene: &Scene, switches: &[&str]) -> Self {
        let view = Self::open_page(&page(scene), switches);
        view.wait_for("window.foldpath !== undefined");
        view
    }

    /// Opens the page of another path in the same browser: to start one takes longer than most checks of a page.
    pub(crate) fn show(&self, scene: &Scene) {
        std::fs::write(self.directory.path().join(PAGE), page(scene)).unwrap();
        self.follow("");
        self.wait_for("window.foldpath !== undefined");
    }

    /// Opens a page from a disk, for a user who prefers that nothing moves by itself.
    pub(crate) fn open_page(html: &str, switches: &[&str]) -> Self {
        Self::open_page_for("reduce", html, switches)
    }

    /// Opens a page from a disk, for a user with this preference of motion, `reduce` or `no-preference`.
    pub(crate) fn open_page_for(motion: &str, html: &str, switches: &[&str]) -> Self {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join(PAGE);
        std::fs::write(&file, html).unwrap();
        let profile = directory.path().join("profile");
        let profile = format!("--user-data-dir={}", profile.display());
        let common = [
            &*profile,
            "--use-gl=angle",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--disable-component-update",
            "--disable-quic",
            "--hide-scrollbars",
        ];
        let switches: Vec<&str> = common.iter().chain(switches).copied().collect();
        let view = Self {
            devtools: RefCell::new(Devtools::start(&chromium(), &switches, PATIENCE)),
            url: format!("file://{}", file.display()),
            directory,
        };
        for domain in ["Runtime", "Log", "Network", "Page"] {
            view.call(&format!("{domain}.enable"), json!({}));
        }
        view.resize(1200, 800);
        view.prefer(&[("prefers-reduced-motion", motion)]);
        view.call("Page.navigate", json!({ "url": view.url }));
        view.wait_for("document.readyState === 'complete' && location.href !== 'about:blank'");
        view
    }

    /// Gives the window a size in pixels.
    pub(crate) fn resize(&self, width: u32, height: u32) {
        let size =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", size);
    }

    /// Sets preferences of the user, by the names of CSS.
    pub(crate) fn prefer(&self, preferences: &[(&str, &str)]) {
        let features = preferences.iter();
        let features: Vec<Value> = features
            .map(|(name, value)| json!({ "name": name, "value": value }))
            .collect();
        self.call(
            "Emulation.setEmulatedMedia",
            json!({ "features": features }),
        );
    }

    /// Opens the same page anew with something behind the `#` of its address.
    pub(crate) fn follow(&self, fragment: &str) {
        self.run("window.isOld = true; 0");
        let url = format!("{}#{fragment}", self.url);
        self.call("Page.navigate", json!({ "url": "about:blank" }));
        self.call("Page.navigate", json!({ "url": url }));
        self.wait_for("window.isOld === undefined && document.readyState === 'complete' && location.href !== 'about:blank'");
    }

    /// Returns the parameters of the last event with this name, once there is one.
    pub(crate) fn event(&self, name: &str) -> Value {
        let start = Instant::now();
        loop {
            self.run("0"); // reads the events before its answer
            let devtools = self.devtools.borrow();
            let found = devtools
                .events
                .iter()
                .rfind(|event| event["method"] == name);
            if let Some(event) = found {
                return event["params"].clone();
            }
            assert!(start.elapsed() < PATIENCE, "no {name}");
            drop(devtools);
            sleep(Duration::from_millis(20));
        }
    }

    /// Returns the pairs of shown elements of a selector that lie over each other, neither in the other, by their texts.
    pub(crate) fn overlaps(&self, selector: &str) -> Value {
        self.run(&format!(
            "(all => all.flatMap((a, i) => all.slice(i + 1).filter(b => {{
               const [p, q] = [a, b].map(it => it.getBoundingClientRect());
               const over = (low, high) => Math.min(p[high], q[high]) - Math.max(p[low], q[low]);
               return !a.contains(b) && !b.contains(a) && over('left', 'right') > 0.5 && over('top', 'bottom') > 0.5;
             }}).map(b => [a, b].map(it => (it.id || it.textContent).slice(0, 40)).join(' over '))).join('; '))(
             [...document.querySelectorAll('{selector}')].filter(it => it.checkVisibility() && it.getBoundingClientRect().width > 0))"
        ))
    }

    /// Calls a method of the protocol and returns its result.
    pub(crate) fn call(&self, method: &str, parameters: Value) -> Value {
        self.devtools.borrow_mut().call(method, parameters)
    }

    /// Evaluates a JavaScript expression and returns its value.
    pub(crate) fn run(&self, script: &str) -> Value {
        let answer = self.call("Runtime.evaluate", json!({ "expression": script }));
        let thrown = &answer["exceptionDetails"];
        assert!(thrown.is_null(), "{script}: {thrown}");
        answer["result"]["value"].clone()
    }

    pub(crate) fn text(&self, selector: &str) -> String {
        let text = self.run(&format!("document.querySelector('{selector}').textContent"));
        text.as_str().unwrap_or_default().to_owned()
    }

    /// Returns the picture as one number.
    pub(crate) fn drawn(&self) -> Value {
        self.run("foldpath.drawn()")
    }

    /// Returns left, top, width and height of an element, scrolled into view, in pixels of the window.
    fn place(&self, selector: &str) -> [f64; 4] {
        let text = self.run(&format!(
            "(element => {{ element.scrollIntoViewIfNeeded(); const r = element.getBoundingClientRect();
             return JSON.stringify([r.left, r.top, r.width, r.height]); }})(document.querySelector('{selector}'))"
        ));
        serde_json::from_str(text.as_str().unwrap()).unwrap()
    }

    fn middle(&self, selector: &str) -> [f64; 2] {
        let [left, top, width, height] = self.place(selector);
        [left + width / 2.0, top + height / 2.0]
    }

    fn mouse(&self, kind: &str, [x, y]: [f64; 2]) {
        let event = json!({ "type": kind, "button": "left", "clickCount": 1, "x": x, "y": y });
        self.call("Input.dispatchMouseEvent", event);
    }

    fn click_point(&self, at: [f64; 2]) {
        for kind in ["mouseMoved", "mousePressed", "mouseReleased"] {
            self.mouse(kind, at);
        }
    }

    pub(crate) fn click(&self, selector: &str) {
        self.click_point(self.middle(selector));
    }

    pub(crate) fn key(&self, key: &str) {
        self.key_with(key, 0);
    }

    /// Presses a key while these others are held.
    pub(crate) fn key_with(&self, key: &str, modifiers: u32) {
        let mut event = json!({ "type": "keyDown", "key": key, "modifiers": modifiers });
        if key.chars().count() == 1 {
            event["text"] = json!(key);
        }
        if key == "Enter" {
            event["text"] = json!("\r");
        }
        // The browser knows its own keys by numbers: those that move the focus or press a button.
        let codes = [
            ("Tab", 9),
            ("Enter", 13),
            (" ", 32),
            ("ArrowLeft", 37),
            ("ArrowUp", 38),
            ("ArrowRight", 39),
            ("ArrowDown", 40),
        ];
        if let Some((_, code)) = codes.iter().find(|(name, _)| *name == key) {
            event["windowsVirtualKeyCode"] = json!(code);
        }
        self.call("Input.dispatchKeyEvent", event.clone());
        event["type"] = json!("keyUp");
        self.call("Input.dispatchKeyEvent", event);
    }

    /// Presses Tab until a condition holds.
    pub(crate) fn tab_to(&self, condition: &str) {
        for _ in 0..120 {
            if self.run(condition) == json!(true) {
                return;
            }
            self.key("Tab");
        }
        panic!("Tab does not lead to {condition}");
    }

    /// Clicks at this pixel of the canvas.
    pub(crate) fn click_at(&self, x: f64, y: f64) {
        let [left, top, ..] = self.place("canvas");
        self.click_point([left + x, top + y]);
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
                self.complaints()
            );
            sleep(Duration::from_millis(20));
        }
    }

    pub(crate) fn drag(&self, selector: &str, (dx, dy): (f64, f64)) {
        let [x, y] = self.middle(selector);
        for (kind, part) in [
            ("mousePressed", 0.0),
            ("mouseMoved", 0.5),
            ("mouseMoved", 1.0),
            ("mouseReleased", 1.0),
        ] {
            self.mouse(kind, [x + part * dx, y + part * dy]);
        }
    }

    /// Returns a PNG of the sheet.
    pub(crate) fn canvas(&self) -> Vec<u8> {
        let [x, y, width, height] = self.place("canvas");
        let clip = json!({ "x": x, "y": y, "width": width, "height": height, "scale": 1 });
        self.picture(json!({ "clip": clip }))
    }

    /// Returns a PNG of the page.
    pub(crate) fn screenshot(&self) -> Vec<u8> {
        self.picture(json!({}))
    }

    fn picture(&self, of: Value) -> Vec<u8> {
        let answer = self.call("Page.captureScreenshot", of);
        BASE64_STANDARD
            .decode(answer["data"].as_str().unwrap())
            .unwrap()
    }

    /// Returns errors, messages and requests so far, none of which a page causes that works by itself.
    fn complaints(&self) -> Vec<String> {
        let devtools = self.devtools.borrow();
        let complaints = devtools.events.iter();
        complaints
            .filter_map(|event| complaint(event, &self.url))
            .collect()
    }

    pub(crate) fn assert_quiet(&self) {
        assert_eq!(self.run("foldpath.errors.join('; ')"), json!(""));
        assert_eq!(self.complaints(), [""; 0]);
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

fn complaint(event: &Value, own: &str) -> Option<String> {
    let told = &event["params"];
    match event["method"].as_str()? {
        "Runtime.exceptionThrown" => Some(told["exceptionDetails"].to_string()),
        "Runtime.consoleAPICalled" => Some(told["args"].to_string()),
        "Log.entryAdded" if told["entry"]["level"] == "error" => Some(told["entry"].to_string()),
        "Network.requestWillBeSent" if told["request"]["url"] != own => {
            Some(format!("request for {}", told["request"]["url"]))
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
