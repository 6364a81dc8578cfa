//! Shapes that are hidden, as those of layers that are not shown. They are no part of the drawing, and are told.

use usvg::roxmltree;

/// Style sheet that shows every shape.
pub(super) const SHOWN: &str = "* { display: inline !important; visibility: visible !important }";

/// Namespace of Inkscape, which names its layers.
const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";
/// Largest number of hidden elements that are named.
const MAX_NAMED: usize = 5;
/// Largest number of characters of a name.
const MAX_NAME_CHARS: usize = 40;

/// Returns `true` if a drawing may have hidden shapes.
pub(super) fn may_hide(text: &str) -> bool {
    text.contains("display") || text.contains("visibility")
}

/// Returns a number of hidden shapes, with the names of the elements that hide them.
pub(super) fn in_words(document: &roxmltree::Document<'_>, count: usize) -> String {
    let hides = |node: &roxmltree::Node<'_, '_>| {
        let is = |name: &str, value: &str| {
            let style = node.attribute("style").unwrap_or_default();
            let mut declared = style.split(';').filter_map(|entry| entry.split_once(':'));
            let in_style = declared.any(|(key, set)| key.trim() == name && set.trim() == value);
            in_style || node.attribute(name) == Some(value)
        };
        is("display", "none") || is("visibility", "hidden")
    };
    let name = |node: roxmltree::Node<'_, '_>| -> Option<String> {
        let name = node
            .attribute((INKSCAPE, "label"))
            .or(node.attribute("id"))?;
        Some(name.chars().take(MAX_NAME_CHARS).collect())
    };
    let hiding = document.descendants().filter(hides).filter_map(name);
    let names: Vec<String> = hiding.take(MAX_NAMED + 1).collect();
    let mut said = count.to_string();
    for (index, name) in names.iter().take(MAX_NAMED).enumerate() {
        said += if index == 0 { ", in " } else { ", " };
        said += name;
    }
    if names.len() > MAX_NAMED {
        said += ", ...";
    }
    said
}
