//! Convex solids: the parts of plates. Measures how far two of them are apart, or how deep they are in each other.
//!
//! Two convex polyhedra are apart if and only if a plane keeps them apart that is parallel to a facet of one, or to an edge of
//! each (S. Gottschalk, "Separating axis theorem", 1996). The largest gap over these planes is a lower bound of the distance;
//! if the solids overlap, the least overlap is the length of the shortest way out. parry3d finds both by GJK and EPA, which
//! iterate up to a tolerance: here every bound is a proof, whatever rounding does, and thin plates are nearly flat.

use nalgebra::{Vector2, Vector3};

use super::{Plate, Plates, without_repeats};
use crate::collision::narrow::crossing::ConvexPiece;
use crate::collision::narrow::separation::distance;
use crate::folding::Pose;
use crate::pattern::{CreasePattern, VertexId};

/// Sine of the angle between two directions below which they are the same.
const SAME_SINE: f64 = 1e-9;

/// Numbers of radii and of steps in the search for a ball in two solids, and the part of the radius by which it may stand out.
const DEEP_HALVINGS: u32 = 8;
const DEEP_STEPS: u32 = 200;
const DEEP_SLACK: f64 = 0.25;

/// A convex part of a plate, in the frame of the flat sheet.
#[derive(Clone, Debug, Default)]
pub(in crate::collision) struct Solid {
    pub(in crate::collision) points: Vec<Vector3<f64>>,
    /// Unit normals of the facets and unit directions of the edges; those that differ.
    normals: Vec<Vector3<f64>>,
    edges: Vec<Vector3<f64>>,
    /// The corners of each facet among the points, counter-clockwise seen from outside, and its unit normal.
    facets: Vec<(Vec<u32>, Vector3<f64>)>,
    /// For each corner of the part, the number of the point that is its vertex; `None` if the material stays back from it.
    apexes: Vec<Option<u32>>,
    /// For each corner with an apex, points of which directions from it span a cone that has the solid.
    next_to: Vec<Vec<u32>>,
    /// `true` if facets and edges are those of the solid without exception.
    pub(in crate::collision) is_exact: bool,
    /// Distance between the lowest and the highest point.
    height: f64,
}

impl Solid {
    /// Makes the solid of a convex part of a plate.
    pub(in crate::collision) fn new(
        pattern: &CreasePattern,
        plates: &Plates,
        plate: &Plate,
        part: &[VertexId],
    ) -> Self {
        let (corners, layers) = (part.len(), plates.heights.len());
        let mut solid = Self {
            is_exact: true,
            ..Self::default()
        };
        // For each corner one or, where it is cut off, two columns of points, one point at each height.
        let mut columns: Vec<Vec<u32>> = Vec::with_capacity(corners);
        let mut of_corner = Vec::with_capacity(corners);
        for &vertex in part {
            let places = plate.places(pattern, vertex);
            let column = |side: usize, solid: &mut Self| {
                let places = places.iter().zip(&plates.heights);
                places
                    .map(|(at, &height)| solid.point(at[side].push(height)))
                    .collect::<Vec<u32>>()
            };
            let start = columns.len();
            columns.push(column(0, &mut solid));
            if places.iter().any(|[a, b]| a != b) {
                columns.push(column(1, &mut solid));
            }
            of_corner.push(start..columns.len());
        }
        let count = columns.len();
        let next = |k: usize| if k + 1 < count { k + 1 } else { 0 };
        let outline = |layer: usize| columns.iter().map(|it| it[layer]).collect::<Vec<_>>();
        let mut lower = outline(0);
        lower.reverse();
        solid.facet(lower);
        solid.facet(outline(layers - 1));
        for k in 0..count {
            let [here, there] = [&columns[k], &columns[next(k)]];
            for layer in 0..layers {
                solid.edge(here[layer], there[layer]);
            }
            for layer in 1..layers {
                let [a, b] = [here[layer - 1], there[layer - 1]];
                let [c, d] = [there[layer], here[layer]];
                solid.edge(a, d);
                solid.wall([a, b, c, d]);
            }
        }
        for layer in [0, layers - 1] {
            solid.is_exact &= solid.turns_left(&outline(layer));
        }
        let is_whole = corners == plate.corners.len();
        for (k, &vertex) in part.iter().enumerate() {
            let at = pattern.vertices()[vertex.index()];
            let touches = |point: &u32| (solid.points[*point as usize].xy() - at).norm() <= 0.0;
            let is_there = columns[of_corner[k].clone()].iter().flatten().any(touches);
            let apex = is_there.then(|| solid.point(at.push(0.0)));
            let near = if is_whole {
                vec![(k + corners - 1) % corners, k, (k + 1) % corners]
            } else {
                (0..corners).collect()
            };
            let near = near
                .into_iter()
                .flat_map(|k| &columns[of_corner[k].clone()]);
            let near: Vec<u32> = near.flatten().copied().collect();
            solid.apexes.push(apex);
            solid
                .next_to
                .push(apex.map_or_else(Vec::new, |apex| solid.rays(apex, near)));
        }
        let [low, high] = [plates.heights[0], plates.heights[layers - 1]];
        solid.height = high - low;
        solid
    }

    /// Returns those of the points near an apex that lie on the edges of the cone that they span from it.
    fn rays(&self, apex: u32, near: Vec<u32>) -> Vec<u32> {
        let mut points: Vec<u32> = Vec::with_capacity(near.len());
        let mut along = Vec::with_capacity(near.len());
        for point in near {
            let away = self.points[point as usize] - self.points[apex as usize];
            if let Some(away) = away.try_normalize(0.0)
                && !points.contains(&point)
            {
                points.push(point);
                along.push(away);
            }
        }
        let edges = edges_of_cone(&along).into_iter();
        edges.map(|ray| points[ray]).collect()
    }

    /// Returns the number of a point, which is added if it is new.
    fn point(&mut self, at: Vector3<f64>) -> u32 {
        let known = self.points.iter().position(|point| *point == at);
        let index = known.unwrap_or_else(|| {
            self.points.push(at);
            self.points.len() - 1
        });
        VertexId::new(index).0
    }

    /// Adds a facet that is planar; none if it has no area.
    fn facet(&mut self, corners: Vec<u32>) {
        let corners = without_repeats(corners);
        if corners.len() < 3 {
            return;
        }
        let at = |k: usize| self.points[corners[k % corners.len()] as usize];
        let area: Vector3<f64> = (1..corners.len())
            .map(|k| (at(k) - at(0)).cross(&(at(k + 1) - at(0))))
            .sum();
        let Some(normal) = area.try_normalize(0.0) else {
            return;
        };
        if !self
            .normals
            .iter()
            .any(|known| known.cross(&normal).norm() <= SAME_SINE)
        {
            self.normals.push(normal);
        }
        self.facets.push((corners, normal));
    }

    /// Adds the wall between two heights at a side of the part. A wall inside a panel may be twisted: then the triangles on
    /// both of its diagonals count.
    fn wall(&mut self, [a, b, c, d]: [u32; 4]) {
        let at = |point: u32| self.points[point as usize];
        let size = (at(c) - at(a)).norm().max((at(d) - at(b)).norm());
        let volume = (at(b) - at(a))
            .cross(&(at(c) - at(a)))
            .dot(&(at(d) - at(a)))
            .abs();
        if volume <= SAME_SINE * size.powi(3) {
            self.facet(vec![a, b, c, d]);
            return;
        }
        self.is_exact = false;
        for [a, b, c] in [[a, b, c], [a, c, d], [a, b, d], [b, c, d]] {
            self.facet(vec![a, b, c]);
        }
        self.edge(a, c);
        self.edge(b, d);
    }

    fn edge(&mut self, from: u32, to: u32) {
        let along = self.points[to as usize] - self.points[from as usize];
        let Some(along) = along.try_normalize(0.0) else {
            return;
        };
        if !self
            .edges
            .iter()
            .any(|known| known.cross(&along).norm() <= SAME_SINE)
        {
            self.edges.push(along);
        }
    }

    /// Returns `true` if an outline nowhere bends to the right.
    fn turns_left(&self, outline: &[u32]) -> bool {
        let at = |k: usize| self.points[outline[k % outline.len()] as usize].xy();
        (0..outline.len()).all(|k| {
            let [along, next]: [Vector2<f64>; 2] = [at(k + 1) - at(k), at(k + 2) - at(k + 1)];
            along.perp(&next) >= -SAME_SINE * along.norm() * next.norm()
        })
    }

    /// Returns `true` if the solid stays, at each height, as far back from the line of a side as a hinge there asks with these
    /// tangents of half its largest angles, as a mountain and as a valley. `slack` is a distance that does not count.
    pub(in crate::collision) fn keeps_back(
        &self,
        [from, to]: [Vector2<f64>; 2],
        [mountain, valley]: [f64; 2],
        slack: f64,
    ) -> bool {
        let along = (to - from).normalize();
        self.points.iter().all(|point| {
            let depth = along.perp(&(point.xy() - from));
            depth >= (point.z * valley).max(-point.z * mountain) - slack
        })
    }

    /// Returns `true` if the vertex at a corner of the part belongs to the solid.
    pub(in crate::collision) fn has_apex(&self, corner: u32) -> bool {
        self.apexes[corner as usize].is_some()
    }
}

/// A solid in space.
#[derive(Clone, Copy, Debug)]
pub(in crate::collision) struct PlacedSolid<'a> {
    pub(in crate::collision) solid: &'a Solid,
    pub(in crate::collision) pose: &'a Pose,
    /// Its points in space.
    pub(in crate::collision) points: &'a [Vector3<f64>],
}

impl PlacedSolid<'_> {
    fn turned<'s>(
        &'s self,
        directions: &'s [Vector3<f64>],
    ) -> impl Iterator<Item = Vector3<f64>> + 's {
        directions
            .iter()
            .map(|direction| self.pose.r_wf.rotate(direction))
    }

    /// Returns planes parallel to each facet that have the solid behind them, by their normals and a point.
    pub(in crate::collision) fn planes(
        &self,
    ) -> impl Iterator<Item = (Vector3<f64>, Vector3<f64>)> + '_ {
        self.solid.facets.iter().filter_map(|(_, normal)| {
            let normal = self.pose.r_wf.rotate(normal);
            Some((normal, self.farthest(&normal)?))
        })
    }

    /// Returns the point that is farthest in a direction.
    fn farthest(&self, direction: &Vector3<f64>) -> Option<Vector3<f64>> {
        let along = |point: &&Vector3<f64>| direction.dot(point);
        let mut points = self.points.iter();
        let first = points.next()?;
        Some(*points.fold(first, |last, point| {
            if along(&point) > along(&last) {
                point
            } else {
                last
            }
        }))
    }

    /// Returns planes that have this solid behind them and another one ahead, but for `depth`, by their normals and a point:
    /// those parallel to a facet of one or to an edge of each, and those half way between two of them.
    pub(in crate::collision) fn planes_before(
        &self,
        other: &Self,
        depth: f64,
    ) -> Vec<(Vector3<f64>, Vector3<f64>)> {
        let normals = self
            .turned(&self.solid.normals)
            .chain(other.turned(&other.solid.normals));
        let others: Vec<_> = other.turned(&other.solid.edges).collect();
        let edges = self.turned(&self.solid.edges).flat_map(|edge| {
            let across = others.iter().filter_map(move |other| {
                let direction = edge.cross(other);
                let sine = direction.norm();
                (sine > SAME_SINE).then(|| direction / sine)
            });
            across.collect::<Vec<_>>()
        });
        let plane = |normal: Vector3<f64>| {
            let [_, high] = extent(self.points, &normal);
            let [low, _] = extent(other.points, &normal);
            let last = self.farthest(&normal)?;
            (low >= high - depth).then_some((normal, last))
        };
        let both = normals.chain(edges).flat_map(|normal| [normal, -normal]);
        let mut planes: Vec<_> = both.filter_map(plane).collect();
        for b in 0..planes.len() {
            for a in 0..b {
                let between = (planes[a].0 + planes[b].0).try_normalize(SAME_SINE);
                planes.extend(between.and_then(plane));
            }
        }
        planes
    }

    /// Returns points that lie deep in two solids which overlap by a depth.
    pub(in crate::collision) fn points_in_both(
        &self,
        other: &Self,
        depth: f64,
    ) -> Vec<Vector3<f64>> {
        let planes: Vec<_> = self.planes().chain(other.planes()).collect();
        let middle = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / count(points);
        let start = middle(self.points).lerp(&middle(other.points), 0.5);
        let mut found = Vec::new();
        for halvings in 1..=DEEP_HALVINGS {
            // Looks for the centre of a ball in both, by going behind the plane from which it stands out most.
            let radius = depth / f64::from(1_u32 << halvings);
            let mut at = start;
            for _ in 0..DEEP_STEPS {
                let out = planes
                    .iter()
                    .map(|(normal, point)| (normal.dot(&(at - point)) + radius, normal))
                    .max_by(|a, b| a.0.total_cmp(&b.0));
                match out {
                    Some((out, normal)) if out > DEEP_SLACK * radius => at -= normal * out,
                    _ => {
                        found.push(at);
                        break;
                    }
                }
            }
        }
        found
    }

    /// Returns a lower bound of the distance of two solids or, if they overlap, the negative of the least way that parts them.
    /// The bound is above 0 if they are apart.
    pub(in crate::collision) fn separation(&self, other: &Self) -> f64 {
        let mut best = f64::NEG_INFINITY;
        let mut along = |direction: &Vector3<f64>| {
            let [low, high] = extent(self.points, direction);
            let [other_low, other_high] = extent(other.points, direction);
            best = best.max(other_low - high).max(low - other_high);
            best
        };
        for normal in self
            .turned(&self.solid.normals)
            .chain(other.turned(&other.solid.normals))
        {
            along(&normal);
        }
        let middle = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / count(points);
        if let Some(direction) = (middle(other.points) - middle(self.points)).try_normalize(0.0) {
            // Solids that are far from each other for their height are as good as faces.
            if along(&direction) > self.solid.height.max(other.solid.height) {
                return best;
            }
        }
        let others: Vec<_> = other.turned(&other.solid.edges).collect();
        for edge in self.turned(&self.solid.edges) {
            for other in &others {
                let direction = edge.cross(other);
                let sine = direction.norm();
                if sine > SAME_SINE {
                    along(&(direction / sine));
                }
            }
        }
        best
    }

    /// Returns the distance of two solids that do not overlap: that of their nearest facets. The nearest point of the other
    /// solid is ahead of one of the facets that have the nearest point of this one.
    pub(in crate::collision) fn distance(&self, other: &Self) -> f64 {
        let (facets, others) = (self.facets_towards(other), other.facets_towards(self));
        let mut nearest = f64::INFINITY;
        for (corners, normal) in &facets {
            for (other_corners, other_normal) in &others {
                let a = ConvexPiece {
                    corners,
                    normal: *normal,
                };
                let b = ConvexPiece {
                    corners: other_corners,
                    normal: *other_normal,
                };
                nearest = nearest.min(distance(&a, &b));
            }
        }
        nearest
    }

    /// Returns the corners and the normal of each facet that has a point of the other solid ahead.
    fn facets_towards(&self, other: &Self) -> Vec<(Vec<Vector3<f64>>, Vector3<f64>)> {
        let facets = self.solid.facets.iter().filter_map(|(corners, normal)| {
            let normal = self.pose.r_wf.rotate(normal);
            let corners = corners.iter().map(|&corner| self.points[corner as usize]);
            let corners: Vec<_> = corners.collect();
            let [_, high] = extent(other.points, &normal);
            (high >= normal.dot(&corners[0])).then_some((corners, normal))
        });
        facets.collect()
    }

    /// Returns a lower bound of the angle (radians) between the cones that two solids span from a vertex that they share, given
    /// the corners at which it is; 0 if they touch in more than the vertex, but for rounding.
    pub(in crate::collision) fn angle(&self, other: &Self, corners: [u32; 2]) -> f64 {
        let cone = |placed: &Self, corner: u32| -> Vec<Vector3<f64>> {
            let solid = placed.solid;
            let Some(apex) = solid.apexes[corner as usize] else {
                return Vec::new();
            };
            let apex = placed.points[apex as usize];
            let near = solid.next_to[corner as usize].iter();
            near.filter_map(|&point| (placed.points[point as usize] - apex).try_normalize(0.0))
                .collect()
        };
        cone_separation(&cone(self, corners[0]), &cone(other, corners[1])).max(0.0)
    }
}

/// Returns a lower bound of the angle (radians) between two convex cones, each spanned by unit directions. If they overlap,
/// returns the negative sine of an angle by which a plane between them would have to be passed.
fn cone_separation(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    cone_separation_up_to(a, b, &mut Vector3::zeros(), f64::INFINITY)
}

/// Returns a lower bound as [`cone_separation`] does, which may be less as soon as it is above `enough`. The first plane that is
/// tried has the normal `last`, and the last one that is tried leaves its normal there.
pub(super) fn cone_separation_up_to(
    a: &[Vector3<f64>],
    b: &[Vector3<f64>],
    last: &mut Vector3<f64>,
    enough: f64,
) -> f64 {
    let mut best = f64::NEG_INFINITY;
    let known = *last;
    let mut is_enough = |normal: Vector3<f64>| {
        let size = normal.norm();
        if size > SAME_SINE {
            let normal = normal / size;
            *last = normal;
            let ([low, high], [other_low, other_high]) = (extent(a, &normal), extent(b, &normal));
            for (near, far) in [(low, -other_high), (-high, other_low)] {
                let separation = if near >= 0.0 && far >= 0.0 {
                    near.min(1.0).asin() + far.min(1.0).asin()
                } else {
                    near.min(far)
                };
                best = best.max(separation);
            }
        }
        best > enough
    };
    // Half way between the middles of the cones is often enough.
    let middles =
        a.iter().sum::<Vector3<f64>>() / count(a) - b.iter().sum::<Vector3<f64>>() / count(b);
    let within = |cone: &[Vector3<f64>], is_enough: &mut dyn FnMut(Vector3<f64>) -> bool| {
        let mut firsts = cone.iter().enumerate();
        firsts.any(|(k, first)| {
            cone[k + 1..]
                .iter()
                .any(|second| is_enough(first.cross(second)))
        })
    };
    let between = |is_enough: &mut dyn FnMut(Vector3<f64>) -> bool| {
        a.iter().any(|first| {
            let mut seconds = b.iter();
            seconds.any(|second| is_enough(first.cross(second)) || is_enough(first - second))
        })
    };
    let _found = is_enough(known)
        || is_enough(middles)
        || within(a, &mut is_enough)
        || within(b, &mut is_enough)
        || between(&mut is_enough);
    best
}

/// Returns the numbers of those of the unit directions which are edges of the convex cone that all of them span, so that they
/// span it alone; all numbers if the cone holds a line. Cost: O(n^3) for n directions.
fn edges_of_cone(rays: &[Vector3<f64>]) -> Vec<usize> {
    let all = 0..rays.len();
    let mut is_edge = vec![false; rays.len()];
    for b in all.clone() {
        for a in all.clone().filter(|a| *a != b) {
            let Some(normal) = rays[a].cross(&rays[b]).try_normalize(SAME_SINE) else {
                if rays[a].dot(&rays[b]) < 0.0 {
                    return all.collect();
                }
                continue;
            };
            // The two are edges of a facet if no other ray is beyond the facet's plane nor, within the plane, beyond the sector
            // between the two.
            let sector = [normal.cross(&rays[a]), rays[b].cross(&normal)];
            let is_within = |ray: &Vector3<f64>| {
                let height = normal.dot(ray);
                let in_sector = || sector.iter().all(|side| side.dot(ray) >= -SAME_SINE);
                height > SAME_SINE || height >= -SAME_SINE && in_sector()
            };
            if rays.iter().all(is_within) {
                (is_edge[a], is_edge[b]) = (true, true);
            }
        }
    }
    let edges: Vec<usize> = all.clone().filter(|ray| is_edge[*ray]).collect();
    if edges.is_empty() {
        all.collect()
    } else {
        edges
    }
}

fn extent(points: &[Vector3<f64>], direction: &Vector3<f64>) -> [f64; 2] {
    let start = [f64::INFINITY, f64::NEG_INFINITY];
    points.iter().fold(start, |[low, high], point| {
        let along = direction.dot(point);
        [low.min(along), high.max(along)]
    })
}

#[allow(clippy::cast_precision_loss, reason = "a mean")]
fn count(points: &[Vector3<f64>]) -> f64 {
    points.len() as f64
}

#[cfg(test)]
mod tests {
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::Rng;

    use super::*;

    /// A half-space has all directions of a cone if and only if it has those that are kept: for random directions, some of them
    /// in the plane of two others, for wedges, half-spaces and the whole space.
    #[test]
    fn the_edges_of_a_cone_span_it() {
        let mut random = Pcg64::new(1, 0);
        let mut noise = || f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0;
        let mut dropped = 0;
        for round in 0..1000 {
            let mut direction = || Vector3::from_fn(|_, _| noise()).normalize();
            let up = direction();
            // Cones within a half-space, and any.
            let mut rays: Vec<_> = (0..3 + round % 6)
                .map(|_| direction())
                .map(|ray| {
                    if round % 4 > 0 {
                        ray * ray.dot(&up).signum()
                    } else {
                        ray
                    }
                })
                .collect();
            for k in 1..rays.len() {
                rays.push((rays[k] + rays[k - 1]).normalize());
            }
            match round % 4 {
                // A wedge, and a half-space.
                2 => rays.push(-rays[0]),
                3 => {
                    let across = up.cross(&rays[0]).normalize();
                    rays.extend([across, -across, across.cross(&up), up.cross(&across)]);
                }
                _ => {}
            }
            let kept = edges_of_cone(&rays);
            dropped += rays.len() - kept.len();
            // Half-spaces in general position, and those of which the border has two of the directions.
            let pairs = (1..rays.len()).map(|k| rays[k].cross(&rays[k - 1]));
            let normals: Vec<_> = pairs.chain([up]).flat_map(|it| [it, -it]).collect();
            for normal in normals.into_iter().chain((0..30).map(|_| direction())) {
                let holds = |ray: &Vector3<f64>| normal.dot(ray) >= -1e-7;
                let kept = kept.iter().all(|ray| holds(&rays[*ray]));
                assert_eq!(kept, rays.iter().all(holds), "{round}");
            }
        }
        assert!(dropped > 1000, "{dropped}");
    }
}
