//! Reduces a path from fold angles of hinges to angles of crease groups, as controllers store it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::{GroupId, Interpolation, Membership, Node};

use super::FileError;
use super::fold::PathFile;
use crate::pattern::{CreaseId, EdgeId};

/// A path in group angles.
pub(super) struct GroupPath {
    pub(super) interpolation: Interpolation,
    /// Group and sign of each hinge, in the order of the edges.
    pub(super) hinges: Vec<Membership>,
    pub(super) groups: usize,
    /// Seconds.
    pub(super) times: Vec<f64>,
    /// One row for each knot, radians.
    pub(super) angles: Vec<f64>,
    /// One row for each knot, radians per second.
    pub(super) rates: Vec<f64>,
    /// One row for each knot; empty unless the interpolation is homogeneous.
    pub(super) weights: Vec<[f64; 2]>,
}

/// Largest difference (radians, or radians per second) between two hinges that count as turning alike.
const ALIKE: f64 = 1e-9;

impl GroupPath {
    /// Reduces a path to the crease groups that its file names. A file without groups gives every hinge a group of its
    /// own.
    ///
    /// # Errors
    /// If a hinge is in no group or does not turn as its group does.
    pub(super) fn of(path: &PathFile, file: &Path) -> Result<Self, FileError> {
        let hinges = hinges(path, file)?;
        let groups = hinges.iter().map(|(_, member)| member.group.index() + 1);
        let groups = groups.max().unwrap_or(0);
        let mut this = Self {
            interpolation: path.interpolation,
            hinges: hinges.iter().map(|(_, member)| *member).collect(),
            groups,
            times: path.knots.iter().map(|knot| knot.time).collect(),
            angles: Vec::with_capacity(path.knots.len() * groups),
            rates: Vec::with_capacity(path.knots.len() * groups),
            weights: Vec::new(),
        };
        for (index, knot) in path.knots.iter().enumerate() {
            let mut row = vec![None; groups];
            for &(edge, member) in &hinges {
                let node = knot.node(edge);
                let node = Node {
                    angle: member.apply(node.angle),
                    rate: member.apply(node.rate),
                    ..node
                };
                let group: Node<f64> = *row[member.group.index()].get_or_insert(node);
                if !alike(node, group) {
                    return Err(FileError::Expected {
                        path: file.to_path_buf(),
                        place: format!("file_frames[{index}].edges_foldAngle[{}]", edge.index()),
                        expected: "angle, rate and weight of its crease group".into(),
                        found: format!("{} degrees", knot.fold_angles[edge.index()].to_degrees()),
                    });
                }
            }
            let nodes = || row.iter().flatten();
            this.angles.extend(nodes().map(|node| node.angle));
            this.rates.extend(nodes().map(|node| node.rate));
            if path.interpolation == Interpolation::Homogeneous {
                this.weights.extend(nodes().map(|node| node.weight));
            }
        }
        Ok(this)
    }

    /// Returns the path as a trajectory of core.
    ///
    /// # Errors
    /// If a controller cannot follow a knot; the error names the place.
    pub(super) fn view(&self, file: &Path) -> Result<TrajectoryView<'_, f64>, FileError> {
        let view = TrajectoryView::new(
            self.interpolation,
            self.groups,
            &self.times,
            &self.angles,
            &self.rates,
            &self.weights,
        );
        view.map_err(|error| unfit(file, &error))
    }
}

/// Makes the error of a trajectory that a controller cannot follow.
pub(super) fn unfit(file: &Path, error: &dyn core::error::Error) -> FileError {
    FileError::Expected {
        path: file.to_path_buf(),
        place: "file_frames".into(),
        expected: "knots that a controller can follow".into(),
        found: error.to_string(),
    }
}

fn alike(a: Node<f64>, b: Node<f64>) -> bool {
    let differences = [
        a.angle - b.angle,
        a.rate - b.rate,
        a.weight[0] - b.weight[0],
        a.weight[1] - b.weight[1],
    ];
    differences.iter().all(|d| d.abs() <= ALIKE)
}

/// Returns the hinges with their crease groups, renumbered from 0 without gaps.
pub(super) fn hinges(path: &PathFile, file: &Path) -> Result<Vec<(EdgeId, Membership)>, FileError> {
    let edges = path.pattern.edges().iter().enumerate();
    let hinges = edges.filter_map(|(edge, parts)| parts.crease.map(|crease| (edge, crease)));
    let member = |(edge, crease): (usize, CreaseId)| {
        let own = Membership {
            group: GroupId(crease.0),
            negative: false,
        };
        let member = path.members.get(edge).copied().unwrap_or(Some(own));
        let member = member.ok_or_else(|| FileError::Expected {
            path: file.to_path_buf(),
            place: format!("foldpath:edges_group[{edge}]"),
            expected: "a group, as the edge is a hinge".into(),
            found: "null".into(),
        });
        Ok((EdgeId::new(edge), member?))
    };
    let mut hinges: Vec<_> = hinges.map(member).collect::<Result<_, FileError>>()?;
    let numbers: BTreeSet<GroupId> = hinges.iter().map(|(_, member)| member.group).collect();
    let numbers: BTreeMap<_, _> = numbers.into_iter().zip((0..).map(GroupId)).collect();
    for (_, member) in &mut hinges {
        member.group = numbers[&member.group];
    }
    Ok(hinges)
}
