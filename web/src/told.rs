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
    // A listener may call the module itself.
    let before = LISTENER.replace(listener.map(|listener| (listener, 0.0)));
    let result = work(&Progress::told_to(tell));
    LISTENER.set(before);
    result
}

fn tell(progress: &Progress) {
    let due = LISTENER.with_borrow_mut(|listener| {
        let (listener, last) = listener.as_mut()?;
        let now = Date::now();
        (now >= *last + PAUSE_MS).then(|| {
            *last = now;
            listener.clone()
        })
    });
    let Some(listener) = due else { return };
    let (stage, part) = progress.now();
    let part = part.map_or(JsValue::UNDEFINED, JsValue::from);
    // An exception of the listener does not end the call.
    let _ = listener.call2(&JsValue::NULL, &stage.name().into(), &part);
}
