//! Layers and colours of a DXF drawing, and the letters that they stand for.

use std::collections::{BTreeSet, HashMap};

use ::dxf::entities::EntityCommon;
use ::dxf::tables::Layer;
use ::dxf::{Color, Drawing};

use crate::colours::hex;
use crate::pattern::Letter;
use crate::read::ReadOptions;
use crate::read::colour::Kind;

/// Words of names of layers with their letters. A layer has the letter of the first row of which its name has a word: a
/// fold that is called a mountain is one. Creases that are told to be no more than creases fold like those of a carton, all
/// in one direction.
const WORDS: [(Letter, &[&str]); 7] = [
    (Letter::Mountain, &["MOUNTAIN", "MTN", "M"]),
    (Letter::Valley, &["VALLEY", "V"]),
    (Letter::Unassigned, &["UNASSIGNED", "FREE"]),
    (
        Letter::Flat,
        &["FLAT", "MARK", "ENGRAVE", "ETCH", "GUIDE", "CONSTRUCTION"],
    ),
    (
        Letter::Cut,
        &[
            "CUT", "CUTTING", "THRU", "THROUGH", "SLIT", "SLOT", "KNIFE", "HOLE", "WINDOW",
        ],
    ),
    (
        Letter::Boundary,
        &[
            "BORDER", "BOUNDARY", "OUTLINE", "CONTOUR", "PROFILE", "EDGE",
        ],
    ),
    (
        Letter::Valley,
        &[
            "CREASE",
            "CREASING",
            "FOLD",
            "FOLDING",
            "SCORE",
            "SCORING",
            "BEND",
            "HINGE",
            "PERF",
            "PERFORATION",
        ],
    ),
];
/// Words of names of layers whose lines belong to notes.
const NOTES: [&str; 9] = [
    "TEXT",
    "DIM",
    "DIMENSION",
    "NOTE",
    "ANNOTATION",
    "TITLE",
    "DEFPOINTS",
    "VIEWPORT",
    "LEGEND",
];

/// Layer, colour and line type of something drawn, as far as blocks around it say.
#[derive(Clone, Debug)]
pub(super) struct Style {
    pub(super) layer: String,
    /// Colour number (ACI) or RGB.
    colour: Colour,
    line_type: String,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Colour {
    Index(u8),
    Rgb([u8; 3]),
}

impl Default for Style {
    fn default() -> Self {
        Self {
            layer: "0".into(),
            colour: Colour::Index(7),
            line_type: "CONTINUOUS".into(),
        }
    }
}

/// Reason of the letter of a line.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Meaning {
    /// The user gave the layer this letter.
    Given(Letter),
    /// The name of the layer says so.
    Named(Letter),
    /// The line has this colour.
    Coloured(Kind, String),
    /// It is dashed, and the user gave dashes this letter.
    Dashed(Letter),
}

impl Meaning {
    pub(super) fn letter(&self) -> Letter {
        match self {
            Self::Given(letter) | Self::Named(letter) | Self::Dashed(letter) => *letter,
            Self::Coloured(kind, _) => kind.letter(),
        }
    }

    /// Returns what is said of lines of a layer with this meaning, before their number.
    pub(super) fn key(&self, layer: &str) -> String {
        let code = self.letter().code();
        match self {
            Self::Given(_) => {
                format!(
                    "lines of layer {layer} taken as {code}, the letter that the layer was given"
                )
            }
            Self::Named(_) => format!("lines of layer {layer} taken as {code}, by its name"),
            Self::Coloured(Kind::Unknown, colour) => format!(
                "lines of layer {layer} taken as {code}: neither its name nor the colour {colour} has a meaning"
            ),
            Self::Coloured(_, colour) => {
                format!("lines of layer {layer} taken as {code}, by their colour {colour}")
            }
            Self::Dashed(_) => {
                format!(
                    "dashed lines of layer {layer} taken as {code}, the letter that dashes were given"
                )
            }
        }
    }
}

/// The layers of a drawing.
pub(super) struct Layers<'a> {
    layers: HashMap<String, &'a Layer>,
    options: &'a ReadOptions,
}

impl<'a> Layers<'a> {
    pub(super) fn new(drawing: &'a Drawing, options: &'a ReadOptions) -> Self {
        let layers = drawing.layers();
        Self {
            layers: layers
                .map(|layer| (layer.name.to_uppercase(), layer))
                .collect(),
            options,
        }
    }

    fn layer(&self, name: &str) -> Option<&'a Layer> {
        self.layers.get(&name.to_uppercase()).copied()
    }

    /// Returns the style of something drawn in a block of a style. On layer 0 it is on the layer of the block.
    pub(super) fn style(&self, common: &EntityCommon, within: &Style) -> Style {
        let layer = match &*common.layer {
            "0" | "" => within.layer.clone(),
            name => name.to_string(),
        };
        let of_layer = self.layer(&layer);
        let indexed = |colour: &Color| colour.index().map(Colour::Index);
        let by_layer = || {
            of_layer
                .and_then(|layer| indexed(&layer.color))
                .unwrap_or(Colour::Index(7))
        };
        let colour = if common.color_24_bit > 0 {
            let [_, red, green, blue] = common.color_24_bit.to_be_bytes();
            Colour::Rgb([red, green, blue])
        } else if common.color.is_by_block() {
            within.colour
        } else {
            indexed(&common.color).unwrap_or_else(by_layer)
        };
        let line_type = match &*common.line_type_name.to_uppercase() {
            "BYLAYER" | "" => of_layer
                .map_or("CONTINUOUS", |layer| &layer.line_type_name)
                .to_uppercase(),
            "BYBLOCK" => within.line_type.clone(),
            name => name.to_string(),
        };
        Style {
            layer,
            colour,
            line_type,
        }
    }

    pub(super) fn is_off(&self, style: &Style) -> bool {
        let is_off = |layer: &Layer| !layer.is_layer_on || layer.color.is_turned_off();
        self.layer(&style.layer).is_some_and(is_off)
    }

    pub(super) fn is_dashed(&self, style: &Style) -> bool {
        !matches!(&*style.line_type, "CONTINUOUS" | "")
    }

    /// Returns the meaning of a style; `None` for lines of notes.
    pub(super) fn meaning(&self, style: &Style) -> Option<Meaning> {
        if let Some(letter) = self.options.layers.of(&style.layer) {
            return Some(Meaning::Given(letter));
        }
        let colour = rgb(style.colour);
        let kind = Kind::of(colour, &self.options.colours);
        if matches!(kind, Kind::Chosen(_) | Kind::NearChosen(..)) {
            return Some(Meaning::Coloured(kind, hex(colour)));
        }
        let words = words(&style.layer);
        let has = |of: &[&str]| words.iter().any(|word| of.contains(&&**word));
        let row = WORDS.iter().find(|(_, of)| has(of));
        if let Some((letter, _)) = row {
            return Some(Meaning::Named(*letter));
        }
        (!has(&NOTES)).then(|| Meaning::Coloured(kind, hex(colour)))
    }

    /// Notes the layers that were given letters although no line is on them.
    pub(super) fn unused<'s>(&self, drawn: impl Iterator<Item = &'s str>) -> Vec<String> {
        let drawn: BTreeSet<String> = drawn.map(str::to_uppercase).collect();
        let given = self.options.layers.iter();
        let unused = given.filter(|(name, _)| !drawn.contains(&name.to_uppercase()));
        let notes = unused.map(|(name, letter)| {
            let code = letter.code();
            format!("the layer {name} was given the letter {code}, but no line is on it")
        });
        notes.collect()
    }
}

/// Returns the words of a name in capitals, each also without an S at its end.
fn words(name: &str) -> Vec<String> {
    let name = name.to_uppercase();
    let words = name
        .split(|c: char| !c.is_alphabetic())
        .filter(|word| !word.is_empty());
    let singular = |word: &str| word.strip_suffix('S').map(String::from);
    let both = words.flat_map(|word| [Some(word.to_string()), singular(word)]);
    both.flatten().collect()
}

/// Returns the colour of a number of the AutoCAD Color Index, 0 to 255 for each channel. White, which is black on paper, is
/// black.
fn rgb(colour: Colour) -> [u8; 3] {
    let index = match colour {
        Colour::Rgb([255, 255, 255]) => return [0; 3],
        Colour::Rgb(rgb) => return rgb,
        Colour::Index(index) => index,
    };
    match index {
        1 => [255, 0, 0],
        2 => [255, 255, 0],
        3 => [0, 255, 0],
        4 => [0, 255, 255],
        5 => [0, 0, 255],
        6 => [255, 0, 255],
        8 => [128; 3],
        9 => [192; 3],
        10..250 => {
            // 24 hues from red on, each in five degrees of brightness, with full and with half saturation.
            let (hue, row) = (f64::from(index / 10 - 1) * 15.0, index % 10);
            let value = [1.0, 0.8, 0.6, 0.5, 0.3][usize::from(row / 2)];
            let least = if row % 2 == 1 { 0.5 * value } else { 0.0 };
            let channel = |at: f64| {
                let away = (hue - at).abs().min(360.0 - (hue - at).abs());
                let part = (2.0 - away / 60.0).clamp(0.0, 1.0);
                let level = 255.0 * (least + (value - least) * part);
                #[allow(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "from 0 to 255"
                )]
                let level = level.round() as u8;
                level
            };
            [channel(0.0), channel(120.0), channel(240.0)]
        }
        _ => [0; 3],
    }
}
