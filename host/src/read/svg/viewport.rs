//! The coordinates of an SVG drawing: user units as they were written, in the unit of the drawing's width if that has one.
//!
//! usvg resolves a drawing to pixels, moved by the origin of the view box. Neither is what people draw in, so that the
//! group with this transform is left out, and lengths are multiplied by the length of a user unit instead.

use svgtypes::{AspectRatio, Length, LengthUnit, ViewBox};
use usvg::roxmltree::Node;
use usvg::{Group, Size, Transform};

use super::decimal;
use crate::pattern::Unit;

/// Pixels in an inch, as CSS has them, and points in a pica.
const PIXELS_PER_INCH: f64 = 96.0;
const POINTS_PER_PICA: f64 = 12.0;
/// Largest relative difference of two scales, and of two places in pixels, that are equal but for single precision.
const SAME_RATIO: f64 = 1e-4;
/// Largest difference of the length of a user unit from 1 that is rounding of width and height.
const UNIT_RATIO: f64 = 1e-4;

/// An affine transform of the plane, in two rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine(pub(super) [[f64; 3]; 2]);

impl Affine {
    fn scale([x, y]: [f64; 2]) -> Self {
        Self([[x, 0.0, 0.0], [0.0, y, 0.0]])
    }

    /// Returns the transform that does this one after the other.
    pub(super) fn after(self, first: Transform) -> Self {
        let t = first;
        let [sx, kx, tx, ky, sy, ty] = [t.sx, t.kx, t.tx, t.ky, t.sy, t.ty].map(decimal);
        Self(
            self.0
                .map(|[a, b, c]| [a * sx + b * ky, a * kx + b * sy, a * tx + b * ty + c]),
        )
    }
}

/// Unit and scale of the coordinates, as the root element gives them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Viewport {
    /// Unit of lengths, if the drawing's width and height have one.
    pub(super) unit: Option<Unit>,
    /// Transform from user units to pixels, without the part that aligns the view box.
    pixels: Affine,
    /// Length of a user unit, and of a pixel, in the unit; 1 without one.
    user: [f64; 2],
    pixel: f64,
}

impl Viewport {
    /// Takes width, height and view box of the root element. `size` is the size in pixels.
    pub(super) fn of(root: Node<'_, '_>, size: Size) -> Self {
        let length = |name: &str| -> Option<Length> { root.attribute(name)?.parse().ok() };
        let [width, height] = ["width", "height"].map(length);
        let unit = width.or(height).and_then(|length| unit(length.unit));
        // Both have to have the same unit.
        let other = height.or(width).and_then(|length| self::unit(length.unit));
        let unit = unit.filter(|unit| other == Some(*unit));
        let pixel = unit.map_or(1.0, |(unit, _)| {
            Unit::Inch.metres() / PIXELS_PER_INCH / unit.metres()
        });
        let view: Option<ViewBox> = root.attribute("viewBox").and_then(|text| text.parse().ok());
        let aspect = root.attribute("preserveAspectRatio");
        let aspect: AspectRatio = aspect
            .and_then(|text| text.parse().ok())
            .unwrap_or_default();
        let size = [size.width(), size.height()].map(decimal);
        let scales = view.map_or([1.0; 2], |view| {
            fitted([size[0] / view.w, size[1] / view.h], aspect)
        });
        let user = match (unit, view) {
            (None, _) => [1.0, scales[1] / scales[0]],
            (Some(_), None) => [pixel; 2],
            (Some((_, factor)), Some(view)) => {
                // Without rounding by way of pixels, where width and height are given.
                let exact = |length: Option<Length>, of: f64, scale: f64| {
                    length.map_or(scale * pixel, |length| length.number * factor / of)
                };
                let user = fitted(
                    [
                        exact(width, view.w, scales[0]),
                        exact(height, view.h, scales[1]),
                    ],
                    aspect,
                );
                user.map(|length| {
                    if (length - 1.0).abs() <= UNIT_RATIO {
                        1.0
                    } else {
                        length
                    }
                })
            }
        };
        let mut pixels = Affine::scale(scales);
        if let Some(view) = view {
            pixels.0[0][2] = -view.x * scales[0];
            pixels.0[1][2] = -view.y * scales[1];
        }
        Self {
            unit: unit.map(|(unit, _)| unit),
            pixels,
            user,
            pixel,
        }
    }

    /// Returns the group with the content of the drawing, and the transform from its coordinates to those of the sheet.
    pub(super) fn content<'a>(&self, root: &'a Group) -> (&'a Group, Affine) {
        if let [usvg::Node::Group(group)] = root.children()
            && self.is_view(group.transform())
        {
            return (group, Affine::scale(self.user));
        }
        let is_plain = self.is_view(Transform::default());
        let scale = if is_plain { self.user } else { [self.pixel; 2] };
        (root, Affine::scale(scale))
    }

    /// Returns `true` if a transform is that from user units to pixels. The alignment of the view box does not count.
    fn is_view(&self, found: Transform) -> bool {
        let Affine([[sx, ..], [_, sy, _]]) = self.pixels;
        let Affine([[fx, kx, tx], [ky, fy, ty]]) = Affine::scale([1.0; 2]).after(found);
        let same = |a: f64, b: f64| (a - b).abs() <= SAME_RATIO * b.abs();
        let Affine([[.., x], [.., y]]) = self.pixels;
        // An aligned view box is moved on along one axis at most.
        let near = |a: f64, b: f64| (a - b).abs() <= SAME_RATIO * (1.0 + b.abs());
        same(fx, sx) && same(fy, sy) && kx.abs() + ky.abs() <= 0.0 && (near(tx, x) || near(ty, y))
    }
}

/// Returns the scales of both axes that the aspect ratio makes of those that fill the viewport.
fn fitted([x, y]: [f64; 2], aspect: AspectRatio) -> [f64; 2] {
    match aspect {
        AspectRatio {
            align: svgtypes::Align::None,
            ..
        } => [x, y],
        AspectRatio { slice: true, .. } => [x.max(y); 2],
        _ => [x.min(y); 2],
    }
}

/// Returns the unit of a length, and how many of them it is.
fn unit(unit: LengthUnit) -> Option<(Unit, f64)> {
    match unit {
        LengthUnit::Mm => Some((Unit::Millimetre, 1.0)),
        LengthUnit::Cm => Some((Unit::Centimetre, 1.0)),
        LengthUnit::In => Some((Unit::Inch, 1.0)),
        LengthUnit::Pt => Some((Unit::Point, 1.0)),
        LengthUnit::Pc => Some((Unit::Point, POINTS_PER_PICA)),
        LengthUnit::None
        | LengthUnit::Em
        | LengthUnit::Ex
        | LengthUnit::Px
        | LengthUnit::Percent => None,
    }
}
