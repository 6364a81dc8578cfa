//! The scene of a path.

use foldpath_core::Membership;

use super::{Scene, SceneEdge, SceneKnot};
use crate::check::measure;
use crate::formats::fold::PathFile;
use crate::pattern::EdgeId;
use crate::shapes::{STEP, shapes};

impl Scene {
    /// What there is to see of a path: its shapes, and what is measured on them now rather than what
    /// the file claims.
    #[must_use]
    pub fn of_path(path: &PathFile) -> Self {
        let path_knots = path.knots.len();
        // Between shapes vertices are drawn on straight lines.
        let path = &path.with_steps(STEP);
        let pattern = &path.pattern;
        let leaders = path.curves_shown();
        let measured = measure(path);
        let worst = |value: fn(&crate::check::Measured) -> f64| {
            measured.iter().map(value).fold(0.0, f64::max)
        };
        let mut knots = Vec::with_capacity(path.knots.len());
        for ((knot, measured), shape) in path.knots.iter().zip(&measured).zip(shapes(path)) {
            let group_angle = |&(edge, member): &(EdgeId, Option<Membership>)| {
                let angle = knot.fold_angles[edge.index()];
                member.map_or(angle, |m| m.apply(angle)).to_degrees()
            };
            knots.push(SceneKnot {
                time: knot.time,
                vertices: Some(shape.iter().map(|&p| p.into()).collect()),
                group_angles: leaders.iter().map(group_angle).collect(),
                deformation: measured.rigidity.deformation,
                gap: measured.rigidity.gap,
                closure: measured.closure,
            });
        }
        Self {
            title: path.title.clone(),
            vertices: pattern.vertices().iter().map(|&v| v.into()).collect(),
            faces: pattern
                .faces()
                .iter()
                .map(|f| f.iter().map(|v| v.0).collect())
                .collect(),
            triangles: pattern
                .triangles()
                .items()
                .iter()
                .map(|t| t.map(|v| v.0))
                .collect(),
            edges: pattern
                .edges()
                .iter()
                .map(|edge| SceneEdge {
                    ends: edge.ends.map(|v| v.0),
                    letter: edge.letter.code().to_string(),
                })
                .collect(),
            knots,
            path_knots,
            creases: pattern.creases().len(),
            groups: leaders.len(),
            max_deformation: worst(|m| m.rigidity.deformation),
            max_gap: worst(|m| m.rigidity.gap),
            max_closure: worst(|m| m.closure),
        }
    }
}
