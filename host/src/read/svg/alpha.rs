//! Alpha of colours as it is written. usvg keeps eight bits of it, so that an alpha of 0.3333 would be 85/255; it is the
//! goal angle of a crease. So colours with alpha are first replaced by opaque colours that stand for them.

use std::collections::{HashMap, HashSet};

use svgtypes::Color;

/// Names of the functions of CSS that make a colour.
const FUNCTIONS: [&str; 5] = ["rgba", "rgb", "hsla", "hsl", "hwb"];
/// Largest number of characters between a function's parentheses.
const MAX_ARGUMENTS: usize = 100;

/// Opaque colours that stand for colours with alpha.
#[derive(Default)]
pub(super) struct Codes(HashMap<[u8; 3], ([u8; 3], f64)>);

impl Codes {
    /// Returns the colour that a colour stands for, and its alpha.
    pub(super) fn decode(&self, colour: [u8; 3]) -> ([u8; 3], f64) {
        self.0.get(&colour).copied().unwrap_or((colour, 1.0))
    }
}

/// Returns `true` if a colour with alpha is written in the text.
pub(super) fn has_alpha(text: &str) -> bool {
    literals(text).next().is_some()
}

/// Replaces the colours with alpha in the text of a drawing by opaque ones, none of which is in `used`.
pub(super) fn encoded(text: &str, used: &HashSet<[u8; 3]>) -> (String, Codes) {
    let mut free = (0..1_u32 << 24).map(|code| {
        let [_, red, green, blue] = code.to_be_bytes();
        [red, green, blue]
    });
    let mut known: HashMap<([u8; 3], u64), [u8; 3]> = HashMap::new();
    let (mut encoded, mut end) = (String::with_capacity(text.len()), 0);
    for Literal {
        from,
        to,
        rgb,
        alpha,
    } in literals(text)
    {
        let key = (rgb, alpha.to_bits());
        let code = match known.get(&key) {
            Some(code) => *code,
            None => match free.find(|code| !used.contains(code)) {
                Some(code) => *known.entry(key).or_insert(code),
                None => break,
            },
        };
        let [red, green, blue] = code;
        encoded += &text[end..from];
        encoded += &format!("rgb({red},{green},{blue})");
        end = to;
    }
    encoded += &text[end..];
    let codes = known.into_iter();
    let codes = codes.map(|((rgb, alpha), code)| (code, (rgb, f64::from_bits(alpha))));
    (encoded, Codes(codes.collect()))
}

/// A colour with alpha in a text.
struct Literal {
    /// First byte, and the byte after the last.
    from: usize,
    to: usize,
    rgb: [u8; 3],
    /// 0 to 1, as written.
    alpha: f64,
}

/// Returns the colours with alpha in a text, in their order.
fn literals(text: &str) -> impl Iterator<Item = Literal> {
    text.match_indices('(').filter_map(|(open, _)| {
        let name = FUNCTIONS.iter().find(|name| {
            let start = open.checked_sub(name.len());
            let word = start.and_then(|start| text.get(start..open));
            word.is_some_and(|word| word.eq_ignore_ascii_case(name))
        })?;
        let arguments = text[open + 1..].split(')').next()?;
        if arguments.len() > MAX_ARGUMENTS {
            return None;
        }
        let parts = arguments.split([',', '/', ' ', '\t', '\n', '\r']);
        let parts: Vec<&str> = parts.filter(|part| !part.is_empty()).collect();
        let &[a, b, c, alpha] = &parts[..] else {
            return None;
        };
        // Without its alpha, as not all ways to write that are known to the parser.
        let opaque = match name.trim_end_matches('a') {
            "hwb" => format!("hwb({a} {b} {c})"),
            name => format!("{name}({a},{b},{c})"),
        };
        let colour: Color = opaque.parse().ok()?;
        let alpha: f64 = match alpha.strip_suffix('%') {
            Some(percent) => percent.parse::<f64>().ok()? / 100.0,
            None => alpha.parse().ok()?,
        };
        alpha.is_finite().then(|| Literal {
            from: open - name.len(),
            to: open + arguments.len() + 2,
            rgb: [colour.red, colour.green, colour.blue],
            alpha: alpha.clamp(0.0, 1.0),
        })
    })
}
