//! Outlines of entities of a DXF drawing as lines and cubic curves on the sheet.

use core::f64::consts::{FRAC_PI_8, TAU};
use core::fmt::Debug;

use ::dxf::entities::{Ellipse, Entity, EntityType, Insert, Polyline, Spline};
use ::dxf::{Point, Vector};
use nalgebra::{Matrix2, Vector2, Vector3};

use crate::read::curves::{Curve, Piece};
use crate::read::segments::MAX_LINES;

/// Expected value and value found.
type Wrong = (String, String);

/// Largest angle of an arc that becomes one cubic curve, radians. The curve is then within 7e-8 radii of the arc.
const ARC_RAD: f64 = FRAC_PI_8;
/// Number of cubic curves for each span of a spline that cubic curves only approximate.
const SPAN_CURVES: u32 = 16;
/// Largest degree of a spline.
const MAX_DEGREE: i32 = 25;

/// Place of what a block holds.
#[derive(Clone, Debug)]
pub(super) struct Placement {
    turned: Matrix2<f64>,
    moved: Vector2<f64>,
    height: f64,
}

impl Default for Placement {
    fn default() -> Self {
        Self {
            turned: Matrix2::identity(),
            moved: Vector2::zeros(),
            height: 0.0,
        }
    }
}

/// The outline of an entity.
pub(super) struct Outline {
    pub(super) pieces: Vec<Piece>,
    /// Heights of its points over the plane.
    pub(super) heights: Vec<f64>,
}

/// Returns 1 if a plane is seen from above and -1 if it is seen from below, where x points the other way.
fn side(normal: &Vector) -> Result<f64, Wrong> {
    let length = normal.x.hypot(normal.y).hypot(normal.z);
    if normal.z.abs() >= (1.0 - 1e-9) * length && length > 0.0 {
        return Ok(normal.z.signum());
    }
    let found = format!("the normal ({}, {}, {})", normal.x, normal.y, normal.z);
    let expected = "a flat drawing, whose normals are (0, 0, 1) or (0, 0, -1)";
    Err((expected.into(), found))
}

impl Placement {
    /// Returns the place of a block that is inserted here, in a cell of an array: its column and its row.
    pub(super) fn of_insert(
        &self,
        insert: &Insert,
        base: &Point,
        cell: [f64; 2],
    ) -> Result<Self, Wrong> {
        let side = side(&insert.extrusion_direction)?;
        let [sin, cos]: [f64; 2] = insert.rotation.to_radians().sin_cos().into();
        let turned = Matrix2::new(cos, -sin, sin, cos);
        let scaled =
            Matrix2::from_diagonal(&Vector2::new(insert.x_scale_factor, insert.y_scale_factor));
        let mirrored = Matrix2::from_diagonal(&Vector2::new(side, 1.0));
        let cell = Vector2::new(
            cell[0] * insert.column_spacing,
            cell[1] * insert.row_spacing,
        );
        let at = Vector2::new(insert.location.x, insert.location.y);
        let inner = mirrored * turned;
        let linear = inner * scaled;
        let moved = mirrored * at + inner * cell - linear * Vector2::new(base.x, base.y);
        let height = side * insert.location.z - insert.z_scale_factor * base.z;
        Ok(Self {
            turned: self.turned * linear,
            moved: self.turned * moved + self.moved,
            height: self.height + height,
        })
    }

    fn apply(&self, at: Vector2<f64>) -> Vector2<f64> {
        self.turned * at + self.moved
    }
}

/// Returns the outline of an entity; `None` if it has none.
pub(super) fn outline(entity: &Entity, placement: &Placement) -> Result<Option<Outline>, Wrong> {
    let flat = |point: &Point| Vector2::new(point.x, point.y);
    let elevation = entity.common.elevation;
    let vertices = match &entity.specific {
        EntityType::LwPolyline(line) => line.vertices.len(),
        EntityType::Polyline(line) => line.vertices().count(),
        _ => 0,
    };
    if vertices > MAX_LINES {
        let expected = format!("a line of at most {MAX_LINES} pieces");
        return Err((expected, format!("{vertices} vertices")));
    }
    let (mut pieces, heights) = match &entity.specific {
        EntityType::Line(line) => {
            let piece = Piece::Line([flat(&line.p1), flat(&line.p2)]);
            (vec![piece], vec![line.p1.z, line.p2.z])
        }
        EntityType::LwPolyline(line) => {
            let side = side(&line.extrusion_direction)?;
            let vertices = line.vertices.iter();
            let vertices = vertices.map(|v| (Vector2::new(side * v.x, v.y), side * v.bulge));
            let pieces = polyline(&vertices.collect::<Vec<_>>(), line.is_closed());
            (pieces, vec![side * elevation])
        }
        EntityType::Polyline(line) => of_polyline(line)?,
        EntityType::Arc(arc) => {
            let ends = [arc.start_angle, arc.end_angle].map(f64::to_radians);
            circular(
                &arc.center,
                &arc.normal,
                arc.radius,
                counter_clockwise(ends),
            )?
        }
        EntityType::Circle(circle) => {
            circular(&circle.center, &circle.normal, circle.radius, [0.0, TAU])?
        }
        EntityType::Ellipse(ellipse) => of_ellipse(ellipse)?,
        EntityType::Spline(spline) => {
            let heights = spline.control_points.iter().map(|point| point.z);
            (of_spline(spline)?, heights.collect())
        }
        _ => return Ok(None),
    };
    for piece in &mut pieces {
        let hull = piece.hull_mut();
        if !hull.iter().all(|at| at.x.is_finite() && at.y.is_finite()) {
            return Err(("finite coordinates".into(), format!("{:?}", hull[0])));
        }
        hull.iter_mut().for_each(|at| *at = placement.apply(*at));
    }
    pieces.retain(|piece| !matches!(piece, Piece::Line([from, to]) if from == to));
    let heights = heights.into_iter().map(|height| height + placement.height);
    Ok(Some(Outline {
        pieces,
        heights: heights.collect(),
    }))
}

/// Returns the pieces between vertices, each with the bulge of the piece after it: the tangent of a quarter of the angle of
/// an arc that runs counter-clockwise.
fn polyline(vertices: &[(Vector2<f64>, f64)], is_closed: bool) -> Vec<Piece> {
    let next = vertices.iter().cycle().skip(1);
    let count = vertices.len() - usize::from(!is_closed && !vertices.is_empty());
    let mut pieces = Vec::new();
    for (&(from, bulge), &(to, _)) in vertices.iter().zip(next).take(count) {
        let across = to - from;
        if bulge.abs() <= f64::EPSILON || across == Vector2::zeros() {
            pieces.push(Piece::Line([from, to]));
            continue;
        }
        let left = Vector2::new(-across.y, across.x);
        let center = (from + to) / 2.0 + left * ((1.0 - bulge * bulge) / (4.0 * bulge));
        let start = from - center;
        let turned = Vector2::new(-start.y, start.x);
        let mut arc = conic(center, [start, turned], [0.0, 4.0 * bulge.atan()]);
        // The ends are those in the file, to the last digit.
        if let Some(last) = arc.last_mut() {
            last.hull_mut()[3] = to;
        }
        arc[0].hull_mut()[0] = from;
        pieces.extend(arc);
    }
    pieces
}

fn of_polyline(line: &Polyline) -> Result<(Vec<Piece>, Vec<f64>), Wrong> {
    if line.is_3d_polygon_mesh() || line.is_polyface_mesh() {
        return Err(("lines".into(), "a mesh".into()));
    }
    let side = side(&line.normal)?;
    // The control points of a curve fitted to the others are no part of it.
    let vertices = || {
        line.vertices()
            .filter(|vertex| !vertex.is_spline_frame_control_point())
    };
    let points = vertices().map(|v| {
        (
            Vector2::new(side * v.location.x, v.location.y),
            side * v.bulge,
        )
    });
    let pieces = polyline(&points.collect::<Vec<_>>(), line.is_closed());
    let heights = if line.is_3d_polyline() {
        vertices().map(|vertex| vertex.location.z).collect()
    } else {
        vec![side * line.location.z]
    };
    Ok((pieces, heights))
}

/// Returns a circle between two angles, radians, with the height of its plane.
fn circular(
    center: &Point,
    normal: &Vector,
    radius: f64,
    ends: [f64; 2],
) -> Result<(Vec<Piece>, Vec<f64>), Wrong> {
    let side = side(normal)?;
    let axes = [Vector2::new(side * radius, 0.0), Vector2::new(0.0, radius)];
    let pieces = conic(Vector2::new(side * center.x, center.y), axes, ends);
    Ok((pieces, vec![side * center.z]))
}

/// Returns the angles from one to another counter-clockwise, a full turn if they are equal, radians.
fn counter_clockwise([from, to]: [f64; 2]) -> [f64; 2] {
    let turn = (to - from).rem_euclid(TAU);
    [from, from + if turn > 0.0 { turn } else { TAU }]
}

fn of_ellipse(ellipse: &Ellipse) -> Result<(Vec<Piece>, Vec<f64>), Wrong> {
    let side = side(&ellipse.normal)?;
    // Unlike other round things, ellipses are in the coordinates of the drawing.
    let major = Vector2::new(ellipse.major_axis.x, ellipse.major_axis.y);
    let minor = Vector2::new(-major.y, major.x) * (side * ellipse.minor_axis_ratio);
    let ends = counter_clockwise([ellipse.start_parameter, ellipse.end_parameter]);
    let center = Vector2::new(ellipse.center.x, ellipse.center.y);
    Ok((conic(center, [major, minor], ends), vec![ellipse.center.z]))
}

/// Returns cubic curves along the center plus `u cos t + v sin t`, for t from one angle to another, radians.
fn conic(center: Vector2<f64>, [u, v]: [Vector2<f64>; 2], [from, to]: [f64; 2]) -> Vec<Piece> {
    let count = ((to - from).abs() / ARC_RAD).ceil().clamp(1.0, 64.0);
    let step = (to - from) / count;
    let handle = 4.0 / 3.0 * (step / 4.0).tan();
    let at = |t: f64| {
        let (sin, cos) = t.sin_cos();
        (center + u * cos + v * sin, v * cos - u * sin)
    };
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most 64"
    )]
    let count = count as u32;
    let places: Vec<_> = (0..=count)
        .map(|k| at(from + f64::from(k) * step))
        .collect();
    let pieces = places.windows(2).map(|pair| {
        let [(start, out), (end, into)] = [pair[0], pair[1]];
        Piece::Curve(Curve([
            start,
            start + out * handle,
            end - into * handle,
            end,
        ]))
    });
    pieces.collect()
}

/// Returns cubic curves along a spline: exactly, if it has no weights and at most degree three.
fn of_spline(spline: &Spline) -> Result<Vec<Piece>, Wrong> {
    let wrong = |expected: &str, found: &dyn Debug| Err((expected.into(), format!("{found:?}")));
    let (points, knots) = (&spline.control_points, &spline.knot_values);
    let degree = match usize::try_from(spline.degree_of_curve) {
        Ok(degree) if (1..=MAX_DEGREE).contains(&spline.degree_of_curve) => degree,
        _ => {
            return wrong(
                &format!("a degree from 1 to {MAX_DEGREE}"),
                &spline.degree_of_curve,
            );
        }
    };
    if points.is_empty() {
        return wrong("a spline with control points", &"none");
    }
    if points.len() <= degree
        || knots.len() != points.len() + degree + 1
        || points.len() > MAX_LINES
    {
        let found = format!("{} control points and {} knots", points.len(), knots.len());
        let expected = "as many knots as control points and the degree plus one";
        return Err((expected.into(), found));
    }
    if !knots.is_sorted() || !knots.iter().all(|knot| knot.is_finite()) {
        return wrong("knots that do not fall", knots);
    }
    let weights = &spline.weight_values;
    if !weights.is_empty() && (weights.len() != points.len() || !weights.iter().all(|w| *w > 0.0)) {
        return wrong("a positive weight for each control point", weights);
    }
    let weight = |k: usize| weights.get(k).copied().unwrap_or(1.0);
    let control: Vec<Vector3<f64>> = (0..points.len())
        .map(|k| Vector3::new(points[k].x, points[k].y, 1.0) * weight(k))
        .collect();
    let rates: Vec<Vector3<f64>> = (1..points.len())
        .map(|k| {
            let span = knots[k + degree] - knots[k];
            let rate = if span > 0.0 {
                degree_of(degree) / span
            } else {
                0.0
            };
            (control[k] - control[k - 1]) * rate
        })
        .collect();
    let is_cubic = degree <= 3 && (0..points.len()).all(|k| (weight(k) - weight(0)).abs() <= 0.0);
    let parts = if is_cubic { 1 } else { SPAN_CURVES };
    let mut pieces = Vec::new();
    for span in degree..points.len() {
        let [start, end] = [knots[span], knots[span + 1]];
        if start >= end {
            continue;
        }
        let step = (end - start) / f64::from(parts);
        let at = |part: u32| {
            let t = start + f64::from(part) * step;
            let place = de_boor(&control, knots, degree, span, t);
            let rate = de_boor(&rates, &knots[1..knots.len() - 1], degree - 1, span - 1, t);
            let here = place.xy() / place.z;
            (here, (rate.xy() - here * rate.z) / place.z)
        };
        for part in 0..parts {
            let ([from, out], [to, into]) =
                (<[_; 2]>::from(at(part)), <[_; 2]>::from(at(part + 1)));
            let third = step / 3.0;
            let hull = [from, from + out * third, to - into * third, to];
            pieces.push(if degree == 1 {
                Piece::Line([from, to])
            } else {
                Piece::Curve(Curve(hull))
            });
        }
        if pieces.len() > MAX_LINES {
            return wrong("a spline of fewer spans", &points.len());
        }
    }
    Ok(pieces)
}

#[allow(clippy::cast_precision_loss, reason = "at most 25")]
fn degree_of(degree: usize) -> f64 {
    degree as f64
}

/// Returns the point of a spline at a parameter within a span of its knots (C. de Boor, "On calculating with B-splines",
/// 1972).
fn de_boor(
    control: &[Vector3<f64>],
    knots: &[f64],
    degree: usize,
    span: usize,
    t: f64,
) -> Vector3<f64> {
    let mut points: Vec<_> = control[span - degree..=span].to_vec();
    for level in 1..=degree {
        for k in (level..=degree).rev() {
            let first = span - degree + k;
            let [low, high] = [knots[first], knots[first + degree + 1 - level]];
            let part = (t - low) / (high - low);
            points[k] = points[k - 1] * (1.0 - part) + points[k] * part;
        }
    }
    points[degree]
}
