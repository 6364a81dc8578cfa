//! Computes the scene of a path: the data that its page shows.

use foldpath_core::Membership;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};

use super::{
    Scene, SceneCause, SceneHingePlay, SceneMotion, ScenePlates, SceneShape, SceneShortfall,
    SceneTolerance, SceneVertexCost,
};
use crate::check::{
    self, CheckOptions, MergedGroups, WorstPair, check_until_over, clearances_until_over,
    differing_hinge, measure,
};
use crate::collision::{Plates, SheetMesh, Trims};
use crate::folding::{FoldingMap, STEP, SpanningTree, fit_sheets};
use crate::motion::{GroupNaming, Motion, REST, interpolation_name, leaders};
use crate::pattern::{CreaseId, CreasePattern, EdgeId, FaceId, Unit};
use crate::planner::{Cause, Note, Outcome, forecast};
use crate::progress::{Progress, Watch};
use crate::sensitivity::{FROM_DEG, Loads, Tolerance};
use crate::symmetry::CreaseGroups;

/// Least thickness that is drawn, and difference of thicknesses that counts, over the thickness of a path.
const NEXT_TO_NOTHING: f64 = 1e-6;

impl Scene {
    /// Computes the scene of a path: its motion, and errors measured afresh instead of those that the file claims.
    /// Cost: folding and measuring all shapes, and a sweep for the nearest faces.
    #[must_use]
    pub fn of_path(path: &Motion) -> Self {
        Self::of_path_watched(path, &Progress::default())
    }

    /// Computes the scene of a path and reports the progress to `progress`. Once cancelled, clearances not yet measured
    /// are left out.
    #[must_use]
    pub fn of_path_watched(path: &Motion, progress: &Progress) -> Self {
        let watch = Watch::new(progress);
        let shapes = &path.with_steps(STEP);
        let pattern = &path.pattern;
        let tree = pattern.tree();
        let measured = measure(shapes, tree);
        let clearances = clearances_until_over(path, shapes, &measured, watch);
        let worst = |value: fn(&crate::check::Measured) -> f64| {
            measured.iter().map(value).fold(0.0, f64::max)
        };
        let over_edge = |length: f64| length / pattern.median_edge();
        let places = places(shapes, tree);
        let numbers = shapes.knots.iter().zip(&measured).zip(&clearances.shapes);
        let shapes = numbers
            .zip(places)
            .map(|(((knot, measured), clearance), places)| SceneShape {
                time: knot.time,
                places,
                deformation: measured.rigidity.deformation,
                gap: measured.rigidity.gap,
                closure: measured.closure,
                clearance: clearance.map(over_edge),
                torques: Vec::new(),
            });
        let members = members(path);
        Self {
            title: path.title.clone(),
            vertices: pattern.vertices().iter().map(|&v| v.into()).collect(),
            vertex_faces: (pattern.corners().iter())
                .map(|faces| faces.first().copied())
                .collect(),
            faces: (pattern.triangles().iter())
                .map(|face| face.iter().map(|t| t.map(|v| v.0)).collect())
                .collect(),
            edges: pattern
                .edges()
                .iter()
                .map(|e| e.ends.map(|v| v.0))
                .collect(),
            letters: pattern.edges().iter().map(|e| e.letter.code()).collect(),
            turns: members.iter().map(|member| turn(*member)).collect(),
            roots: tree.roots().iter().map(|face| face.0).collect(),
            tree: steps(pattern, tree),
            motion: motion(path, &members),
            shapes: shapes.collect(),
            worst_pair: clearances.worst.map(|pair| WorstPair {
                distance: over_edge(pair.distance),
                ..pair
            }),
            plates: plates(path, watch),
            shortfall: shortfall(path, watch),
            phases: path.phases.clone(),
            creases: pattern.creases().len(),
            max_deformation: worst(|m| m.rigidity.deformation),
            max_gap: worst(|m| m.rigidity.gap),
            max_closure: worst(|m| m.closure),
            drivers: Vec::new(),
            tolerance: None,
        }
    }

    /// Adds the play that the hinges of this path need for an error of each coordinate of each vertex, in the unit of the sheet;
    /// `None` stands for any error, none of which needs play.
    #[must_use]
    pub fn with_tolerance(
        mut self,
        path: &Motion,
        tolerance: &Tolerance,
        error: Option<f64>,
    ) -> Self {
        let pattern = &path.pattern;
        let edge = |crease: CreaseId| pattern.creases()[crease.index()];
        let scale = error.unwrap_or(0.0);
        let hinges = tolerance.ranked_hinges().into_iter();
        let vertices = tolerance.ranked_vertices().into_iter();
        self.tolerance = Some(SceneTolerance {
            error,
            unit: pattern.unit().map_or("", Unit::name),
            radian: pattern.median_edge(),
            from: FROM_DEG,
            hinges: hinges
                .map(|hinge| SceneHingePlay {
                    edge: edge(hinge.crease),
                    worst: scale * hinge.worst,
                    expected: scale * hinge.expected,
                    kind: hinge.kind.name(),
                    at: hinge.at,
                })
                .collect(),
            vertices: vertices
                .map(|(vertex, cost)| SceneVertexCost {
                    vertex,
                    cost: scale * cost,
                })
                .collect(),
            redundant: tolerance.redundant.iter().map(|&it| edge(it)).collect(),
        });
        self
    }

    /// Adds the torques of the drivers of this path. A shape gets those of its time, or of the next time before the shape after
    /// it: `loads` looks there if the sheet is singular.
    #[must_use]
    pub fn with_torques(mut self, path: &Motion, loads: &Loads) -> Self {
        let creases = path.pattern.creases();
        self.drivers = (loads.drivers.iter())
            .map(|driver| creases[driver.index()])
            .collect();
        for (time, torques) in loads.times.iter().zip(&loads.torques) {
            let after = self.shapes.partition_point(|shape| shape.time <= *time);
            // A singular end is looked at before it.
            let near = self.shapes[after.saturating_sub(1)..].iter_mut();
            if let Some(shape) = near.take(2).find(|shape| shape.torques.is_empty()) {
                shape.torques.clone_from(torques);
            }
        }
        self
    }
}

/// Returns crease group and sign of each edge: those that the file has, if its hinges turn as these say, or else groups
/// of hinges whose motions are equal.
fn members(path: &Motion) -> Vec<Option<Membership>> {
    if path.naming == GroupNaming::Named {
        return path.members.clone();
    }
    let pattern = &path.pattern;
    if let GroupNaming::Contradicted(named) = &path.naming {
        // Hinges of a group may differ by rounding.
        let mut hinges = pattern.edges().iter().zip(named);
        let whole = hinges.all(|(edge, member)| edge.crease.is_some() == member.is_some());
        if whole && differing_hinge(path).is_none() {
            return named.clone();
        }
    }
    let groups = MergedGroups::of(path).groups;
    let edges = pattern.edges().iter();
    edges.map(|edge| Some(groups.of(edge.crease?))).collect()
}

/// Returns the plates of a path, if its panels are plates that can be made, with what is proved of other thicknesses.
fn plates(path: &Motion, watch: Watch<'_>) -> Option<ScenePlates> {
    let options = path.plates?;
    let pattern = &path.pattern;
    let trims = Trims::of(path, &options);
    let made = |thickness: f64| {
        let options = options.with(|it| it.thickness = thickness);
        Plates::new(pattern, &trims, &options).ok()
    };
    let asked = CheckOptions::default().with(|it| it.thickest = true);
    let verdict = check_until_over(path, &asked, watch);
    // Plates are looked at only where the sheet itself holds.
    let found = (verdict.thickest).filter(|_| verdict.outcome() == check::Outcome::Holds);
    let proved = found.map_or(0.0, |found| found.proved);
    let mut thicknesses = vec![NEXT_TO_NOTHING * options.thickness, options.thickness];
    if proved > (1.0 + NEXT_TO_NOTHING) * options.thickness {
        thicknesses.push(proved);
    }
    let meshes: Option<Vec<SheetMesh>> = thicknesses
        .iter()
        .map(|&thickness| Some(made(thickness)?.sheet_mesh(pattern)))
        .collect();
    let meshes = meshes?;
    let of_face = made(options.thickness)?.of_face;
    let points = |mesh: &SheetMesh| mesh.vertices.iter().map(|(_, at)| (*at).into()).collect();
    let SheetMesh {
        vertices,
        triangles,
        ends,
        ..
    } = meshes.first()?.clone();
    Some(ScenePlates {
        thickness: options.thickness,
        unit: pattern.unit().map_or("", Unit::name),
        points: meshes.iter().map(points).collect(),
        thicknesses,
        faces: vertices.into_iter().map(|(face, _)| face).collect(),
        triangles,
        ends,
        of_face,
        proved,
        refuted: found.and_then(|found| Some(found.refuted?.0)),
        told: found.map_or_else(
            || "the path is not proved, so that nothing is known of other thicknesses".into(),
            |found| Note::Thickest(found).to_string(),
        ),
    })
}

/// Returns what the path leaves undone, if the planner said so.
fn shortfall(path: &Motion, watch: Watch<'_>) -> Option<SceneShortfall> {
    let answer = path.answer.as_ref()?;
    if answer.outcome == Outcome::Planned.name() {
        return None;
    }
    let pattern = &path.pattern;
    // A crossing is shown by its pair of faces.
    let falls_short = Outcome::FALLS_SHORT
        .map(Outcome::name)
        .contains(&&*answer.outcome);
    let causes = if falls_short {
        forecast(pattern, &CreaseGroups::trivial(pattern), watch).causes
    } else {
        Vec::new()
    };
    Some(SceneShortfall {
        outcome: answer.outcome.clone(),
        reached: answer.reached,
        causes: causes
            .iter()
            .map(|cause| scene_cause(pattern, cause))
            .collect(),
    })
}

/// Describes a cause and the edges that it lights.
pub(super) fn scene_cause(pattern: &CreasePattern, cause: &Cause) -> SceneCause {
    let mut edges: Vec<u32> = cause.edges.iter().map(|edge| edge.0).collect();
    if edges.is_empty() {
        let vertices = cause.vertices.iter();
        let stars = vertices.flat_map(|vertex| &pattern.stars()[vertex.index()]);
        edges.extend(stars.map(|edge| edge.0));
        edges.sort_unstable();
        edges.dedup();
    }
    SceneCause {
        edges,
        message: cause.to_string(),
    }
}

/// Encodes a membership as one number, as in [`Scene::turns`].
pub(super) fn turn(member: Option<Membership>) -> i64 {
    member.map_or(0, |m| {
        let number = i64::from(m.group.0) + 1;
        if m.negative { -number } else { number }
    })
}

/// Returns the motion of the groups at the knots of the path.
fn motion(path: &Motion, members: &[Option<Membership>]) -> SceneMotion {
    let leaders = leaders(members);
    let nodes = (0..path.knots.len()).flat_map(|knot| {
        leaders.iter().map(move |leader| {
            leader.map_or(REST, |(edge, member)| path.group_node(knot, edge, member))
        })
    });
    let weighted = path.knots.iter().any(|knot| !knot.weights.is_empty());
    SceneMotion {
        interpolation: interpolation_name(path.interpolation),
        groups: leaders.len(),
        times: path.knots.iter().map(|knot| knot.time).collect(),
        angles: nodes.clone().map(|node| node.angle).collect(),
        rates: nodes.clone().map(|node| node.rate).collect(),
        weights: nodes.filter(|_| weighted).map(|node| node.weight).collect(),
    }
}

/// Returns the steps of the tree, as in [`Scene::tree`].
fn steps(pattern: &CreasePattern, tree: &SpanningTree) -> Vec<[u32; 4]> {
    let start = |edge: EdgeId, face| u32::from(pattern.edge(edge).faces[0] != Some(face));
    let steps = tree.steps().iter();
    steps
        .map(|step| {
            [
                step.face.0,
                step.parent.0,
                step.edge.0,
                start(step.edge, step.face),
            ]
        })
        .collect()
}

/// Returns the pose of each sheet in each shape. Each shape is registered rigidly to the shape before, starting from
/// the flat sheet, so that the whole stays where it is while it folds.
fn places(shapes: &Motion, tree: &SpanningTree) -> Vec<Vec<[f64; 7]>> {
    let pattern = &shapes.pattern;
    let mut map = FoldingMap::flat(pattern);
    let mut before = map.vertices().to_vec();
    let knots = (0..shapes.knots.len()).map(|knot| {
        map.fold(pattern, tree, &shapes.crease_angles(knot));
        let (r_wf, [from, to]) = fit_sheets(pattern, map.vertices(), &before);
        let laid = |point: &Vector3<f64>| r_wf * (point - from) + to;
        before = map.vertices().iter().map(laid).collect();
        let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(r_wf));
        // The folding map leaves the root faces where they are drawn.
        let place = |root: &FaceId| {
            let first = pattern.triangles()[root.index()].first();
            let pivot = first.map_or(Vector3::zeros(), |corners| pattern.point(corners[0]));
            let p = laid(&pivot);
            [q.w, q.i, q.j, q.k, p.x, p.y, p.z]
        };
        tree.roots().iter().map(place).collect()
    });
    knots.collect()
}
