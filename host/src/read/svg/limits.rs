//! Bounds the work and memory that a drawing asks of usvg, before usvg sees the drawing.
//!
//! A short file can ask for any amount: entities in entities, uses of uses, namespaces inherited by each element, rules
//! of style sheets tried on all elements. The limits admit drawings of a million lines.

use std::collections::HashMap;

use usvg::roxmltree::{Document, Node};

/// Largest number of bytes that entities may expand to, if every reference expands to all entity texts.
const MAX_ENTITY_BYTES: usize = 1 << 28;

/// Largest number of namespace declarations: each element that declares a namespace has a list of all that are in
/// scope.
const MAX_NAMESPACES: usize = 1 << 13;

/// Largest number of elements, uses expanded. usvg takes about a kilobyte for each.
const MAX_ELEMENTS: u64 = 1 << 19;

/// Largest sum of the bytes of attributes and the cubics that arcs are made of, uses expanded. usvg takes about 50
/// bytes for each of them in a long path.
const MAX_ATTRIBUTE_BYTES: u64 = 1 << 25;

/// Attributes that bound the size of an arc.
const LENGTHS: [&str; 11] = [
    "d", "r", "rx", "ry", "cx", "cy", "x", "y", "width", "height", "viewBox",
];

/// Largest depth of nested elements, uses expanded: usvg recurses once for each level.
const MAX_LEVELS: u64 = 256;

/// Largest number of comparisons of selectors with elements.
const MAX_COMPARISONS: u64 = 1 << 30;

/// Checks a text before it is parsed. The error describes the excess.
pub(super) fn of_text(text: &str) -> Result<(), String> {
    // A reference may hold 255 others.
    let entities: usize = text
        .match_indices("<!ENTITY")
        .map(|at| value(text, at.0))
        .sum();
    let references = text.bytes().filter(|byte| *byte == b'&').count();
    let grown = entities.saturating_mul(256).saturating_mul(references);
    if grown > MAX_ENTITY_BYTES {
        return Err("entities that could grow beyond all bounds".into());
    }
    if text.matches("xmlns").take(MAX_NAMESPACES + 1).count() > MAX_NAMESPACES {
        return Err(format!(
            "more than {MAX_NAMESPACES} declarations of namespaces"
        ));
    }
    Ok(())
}

/// Returns the number of bytes between the quotes of the entity declared at `at`, or 0 if no entity is declared there.
fn value(text: &str, at: usize) -> usize {
    let declared = &text[at + 1..];
    let Some(open) = declared.find(['"', '\'', '<']) else {
        return 0;
    };
    let (quote, rest) = declared[open..].split_at(1);
    match quote {
        "<" => 0,
        quote => rest.find(quote).unwrap_or(rest.len()),
    }
}

/// Checks a document before usvg makes a drawing of it. The error describes the excess.
pub(super) fn of_document(document: &Document<'_>) -> Result<(), String> {
    let Size {
        elements,
        attributes,
        levels,
    } = expanded(document)?;
    if levels > MAX_LEVELS {
        return Err(format!(
            "more than {MAX_LEVELS} levels of elements, each use counted"
        ));
    }
    if elements > MAX_ELEMENTS {
        return Err(format!(
            "more than {MAX_ELEMENTS} elements, each use counted"
        ));
    }
    if attributes > MAX_ATTRIBUTE_BYTES {
        return Err(format!(
            "more than {} MiB of attributes and of arcs, each use counted",
            MAX_ATTRIBUTE_BYTES >> 20
        ));
    }
    let styles = document.descendants().filter(|n| n.has_tag_name("style"));
    let styles = styles.filter_map(|style| style.text());
    let once: u64 = styles
        .map(|style| comparisons(style, levels))
        .fold(0, u64::saturating_add);
    if once.saturating_mul(elements) > MAX_COMPARISONS {
        return Err(
            "style sheets whose selectors take too long to compare with its elements".into(),
        );
    }
    Ok(())
}

fn index(node: Node<'_, '_>) -> usize {
    node.id().get_usize()
}

/// Size of an element with all its descendants, each use counted as the element that it refers to.
#[derive(Clone, Copy, Default)]
struct Size {
    elements: u64,
    /// Bytes of attributes plus cubics of arcs.
    attributes: u64,
    levels: u64,
}

/// Returns the size of the paint that usvg copies for each element: patterns and gradients, if a stroke is painted with
/// any of them. Patterns in patterns would be copies of copies, and are refused.
fn copied_paint(document: &Document<'_>, cubics: u64) -> Result<u64, String> {
    let nodes = document.descendants();
    let mut in_paint = vec![false; nodes.len()];
    let (mut painted, mut painted_paint, mut patterns, mut paint) = (false, false, false, 0_u64);
    for node in nodes {
        let name = node.tag_name().name();
        let is_in_paint = matches!(name, "pattern" | "linearGradient" | "radialGradient")
            || node.parent().is_some_and(|parent| in_paint[index(parent)]);
        in_paint[index(node)] = is_in_paint;
        patterns |= name == "pattern";
        let sheet = node
            .text()
            .filter(|_| name == "style")
            .map(without_comments);
        let by_sheet = sheet.is_some_and(|css| strokes_paint(&css));
        let by_itself = node.attributes().any(|attribute| match attribute.name() {
            "stroke" => attribute.value().contains("url("),
            "style" => strokes_paint(&without_comments(attribute.value())),
            _ => false,
        });
        painted |= by_sheet || by_itself;
        painted_paint |= by_sheet || (by_itself && is_in_paint);
        if is_in_paint {
            paint = paint.saturating_add(1 + attributes(node, cubics));
        }
    }
    if painted_paint && patterns {
        return Err("strokes with a pattern in what may be a pattern".into());
    }
    Ok(if painted { paint } else { 0 })
}

/// Returns the size of the document with all uses expanded.
fn expanded(document: &Document<'_>) -> Result<Size, String> {
    let nodes = document.descendants();
    let cubics = cubics(nodes.clone().map(reach).sum());
    let each = copied_paint(document, cubics)?;
    let mut ids = HashMap::new();
    for node in nodes.clone() {
        if let Some(id) = node.attribute("id") {
            ids.entry(id).or_insert(node);
        }
    }
    let mut done: Vec<Option<Size>> = vec![None; nodes.len()];
    let mut begun = vec![false; nodes.len()];
    let mut open = vec![document.root()];
    while let Some(&node) = open.last() {
        let used = node
            .attributes()
            .filter(|a| a.name() == "href" && node.tag_name().name() == "use");
        let used = used.filter_map(|href| ids.get(href.value().trim().strip_prefix('#')?));
        let parts = node.children().chain(used.copied());
        if done[index(node)].is_some() {
            open.pop();
        } else if begun[index(node)] {
            let own = Size {
                elements: u64::from(node.is_element()),
                attributes: attributes(node, cubics).saturating_add(each),
                levels: 0,
            };
            let sizes = parts.filter_map(|part: Node<'_, '_>| done[index(part)]);
            let sum = sizes.fold(own, |sum, part: Size| Size {
                elements: sum.elements.saturating_add(part.elements),
                attributes: sum.attributes.saturating_add(part.attributes),
                levels: sum.levels.max(part.levels + 1),
            });
            done[index(node)] = Some(sum);
            open.pop();
        } else {
            begun[index(node)] = true;
            for part in parts {
                if done[index(part)].is_none() && begun[index(part)] {
                    return Err("a use of what it is in".into());
                }
                open.push(part);
            }
        }
    }
    Ok(done[index(document.root())].unwrap_or_default())
}

/// Returns the bytes of an element's attributes plus the cubics of its arcs, each of which may take `cubics` of them.
fn attributes(node: Node<'_, '_>, cubics: u64) -> u64 {
    let bytes: u64 = node.attributes().map(|a| a.value().len() as u64).sum();
    let arcs = match node.tag_name().name() {
        // One `a` may lead many arcs of seven numbers each; flags and points may pack an arc into a few bytes.
        "path" if node.attribute("d").is_some_and(|d| d.contains(['a', 'A'])) => bytes / 8 + 1,
        "circle" | "ellipse" | "rect" => 4,
        _ => 0,
    };
    bytes.saturating_add(arcs.saturating_mul(cubics))
}

/// Returns an upper bound of the extent of an element in its own units, from the numbers of its attributes.
fn reach(node: Node<'_, '_>) -> f64 {
    let lengths = node.attributes().filter(|a| LENGTHS.contains(&a.name()));
    lengths.map(|a| sum(a.value())).sum()
}

/// Returns the sum of the absolute values of the numbers in a list.
pub(super) fn sum(list: &str) -> f64 {
    let (mut sum, mut rest) = (0.0, list);
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit() || c == '.') {
        rest = &rest[start..];
        let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
        let mut end = digits(rest);
        if rest[end..].starts_with('.') {
            end += 1 + digits(&rest[end + 1..]);
        }
        if rest[end..].starts_with(['e', 'E']) {
            let sign = usize::from(rest[end + 1..].starts_with(['+', '-']));
            match digits(&rest[end + 1 + sign..]) {
                0 => {}
                exponent => end += 1 + sign + exponent,
            }
        }
        sum += rest[..end].parse().unwrap_or(0.0);
        rest = &rest[end..];
    }
    sum
}

/// Returns the largest number of cubics that an arc with an extent of at most `reach` (units) is made of: as many as
/// keep every cubic within a tenth of a unit of the arc, an error that falls with the sixth power of their number, and
/// at least one for each quarter turn.
fn cubics(reach: f64) -> u64 {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "what is too large is the largest"
    )]
    let cubics = (11.2 * reach).powf(1.0 / 6.0).ceil() as u64;
    cubics.max(4)
}

/// Returns an upper bound of the comparisons of a style sheet's selectors with one element below `deepest` others: each
/// part of a selector after the first may be tried on all of these.
fn comparisons(style: &str, deepest: u64) -> u64 {
    let sheet = without_comments(style);
    let rules = sheet.split('}').filter_map(|rule| rule.rsplit_once('{'));
    let selectors = rules.flat_map(|(selectors, _)| selectors.split(','));
    let cost = |selector: &str| {
        let parts = selector.split(|c: char| c.is_whitespace() || matches!(c, '>' | '+' | '~'));
        let parts = parts.filter(|part| !part.is_empty()).count().max(1);
        let ways = deepest.saturating_pow(u32::try_from(parts - 1).unwrap_or(u32::MAX));
        (selector.len() as u64 + 1).saturating_mul(ways)
    };
    selectors.map(cost).fold(0, u64::saturating_add)
}

fn without_comments(style: &str) -> String {
    let mut left = String::with_capacity(style.len());
    let mut rest = style;
    while let Some((before, comment)) = rest.split_once("/*") {
        left.push_str(before);
        rest = comment.split_once("*/").map_or("", |(_, behind)| behind);
    }
    left + rest
}

/// Returns `true` if declarations, given without comments, paint strokes with a pattern or gradient.
fn strokes_paint(declarations: &str) -> bool {
    let mut values = declarations.split("stroke").skip(1);
    values.any(|behind| {
        let value = behind.trim_start().strip_prefix(':');
        let value = value.and_then(|value| value.split([';', '}']).next());
        value.is_some_and(|value| value.contains("url("))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_numbers_of_a_list_count() {
        let list = "M10-20A5.5.3-4 010-.1 1e3-2E+2e9.z#";
        let expected = 10.0 + 20.0 + 5.5 + 0.3 + 4.0 + 10.0 + 0.1 + 1e3 + 200.0 + 9.0;
        assert!((sum(list) - expected).abs() < 1e-9, "{}", sum(list));
        assert!(sum(&"9".repeat(400)).is_infinite());
        assert_eq!(cubics(f64::INFINITY), u64::MAX);
        assert_eq!(cubics(1.0), 4);
    }
}
