//! Tells a page how far a call has come.

use core::cell::RefCell;

use foldpath::progress::Progress;
use js_sys::{Date, Function};
use wasm_bindgen::JsValue;

/// Least time between two calls of the listener, milliseconds.
const PAUSE_MS: f64 = 50.0;

thread_local! {
    /// The function that listens, and when it was last called (milliseconds).
    static LISTENER: RefCell<Option<(Function, f64)>> = const { RefCell::new(None) };
}

/// Does the work and calls the function now and then with the stage and the part of it that is done.
pub(crate) fn with<T>(listener: Option<Function>, work: impl FnOnce(&Progress) -> T) -> T {
    LISTENER.set(listener.map(|listener| (listener, 0.0)));
    let result = work(&Progress::told_to(tell));
    LISTENER.set(None);
    result
}

fn tell(progress: &Progress) {
    LISTENER.with_borrow_mut(|listener| {
        let Some((listener, last)) = listener else {
            return;
        };
        let now = Date::now();
        if now < *last + PAUSE_MS {
            return;
        }
        *last = now;
        let (stage, part) = progress.now();
        let part = part.map_or(JsValue::UNDEFINED, JsValue::from);
        // What a listener throws is its own affair.
        let _ = listener.call2(&JsValue::NULL, &stage.name().into(), &part);
    });
}
