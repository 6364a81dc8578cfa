//! Hinges and groups of a motion as controllers number them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use foldpath_core::{GroupId, Membership, Node};

use crate::motion::{GroupNaming, Motion};
use crate::pattern::{CreasePattern, EdgeId};
use crate::planner::forecast;
use crate::progress::Watch;
use crate::read::FileError;
use crate::symmetry::CreaseGroups;

/// Largest difference (radians, or radians per second) between two hinges that count as turning alike.
const SAME_ANGLE_RAD: f64 = 1e-9;

/// Returns the hinges that drive a sheet near flat, as `foldpath info` names them. Empty if they are not known.
pub(super) fn drivers(pattern: &CreasePattern) -> Vec<EdgeId> {
    let groups = CreaseGroups::find(pattern);
    forecast(pattern, &groups, Watch::default()).drivers(pattern, &groups)
}

/// The hinges of a motion with their groups, renumbered from 0 without gaps.
pub(super) struct HingeGroups {
    /// Group and sign of each hinge, in the order of the edges.
    pub(super) hinges: Vec<Membership>,
    /// For each group its first hinge with its sign.
    leaders: Vec<(EdgeId, Membership)>,
}

impl HingeGroups {
    /// Finds the groups that the file names; if the file names none, each hinge has a group of its own.
    ///
    /// # Errors
    /// If a hinge is in no group or does not turn as its group does.
    pub(super) fn of(motion: &Motion, file: &Path) -> Result<Self, FileError> {
        let named = match &motion.naming {
            GroupNaming::Contradicted(named) => named,
            GroupNaming::Named | GroupNaming::Unnamed => &motion.members,
        };
        let creases = motion.pattern.creases().iter();
        let members = creases.map(|&edge| {
            let place = || format!("foldpath:edges_group[{edge}]");
            let expected = "a group, as the edge is a hinge";
            let member = named[edge.index()]
                .ok_or_else(|| FileError::expected(file, place(), expected, "null"));
            Ok((edge, member?))
        });
        let mut members: Vec<(EdgeId, Membership)> = members.collect::<Result<_, FileError>>()?;
        let numbers: BTreeSet<GroupId> = members.iter().map(|(_, member)| member.group).collect();
        let numbers: BTreeMap<_, _> = numbers.into_iter().zip((0..).map(GroupId)).collect();
        let mut leaders = vec![None; numbers.len()];
        for (edge, member) in &mut members {
            member.group = numbers[&member.group];
            leaders[member.group.index()].get_or_insert((*edge, *member));
        }
        let groups = Self {
            hinges: members.iter().map(|(_, member)| *member).collect(),
            leaders: leaders.into_iter().flatten().collect(),
        };
        if matches!(motion.naming, GroupNaming::Contradicted(_)) {
            groups.compare(motion, &members, file)?;
        }
        Ok(groups)
    }

    /// Number of groups.
    pub(super) fn len(&self) -> usize {
        self.leaders.len()
    }

    /// Returns angle, rate and weight of each group at a knot.
    pub(super) fn nodes(&self, motion: &Motion, knot: usize) -> impl Iterator<Item = Node<f64>> {
        let leaders = self.leaders.iter();
        leaders.map(move |&(edge, member)| motion.group_node(knot, edge, member))
    }

    /// Checks that each hinge turns as the first hinge of its group does.
    fn compare(
        &self,
        motion: &Motion,
        members: &[(EdgeId, Membership)],
        file: &Path,
    ) -> Result<(), FileError> {
        for knot in 0..motion.knots.len() {
            let nodes: Vec<_> = self.nodes(motion, knot).collect();
            for &(edge, member) in members {
                let node = motion.group_node(knot, edge, member);
                if !alike(node, nodes[member.group.index()]) {
                    let degrees = motion.node(knot, edge).angle.to_degrees();
                    let place = format!("file_frames[{knot}].edges_foldAngle[{edge}]");
                    let expected = "angle, rate and weight of its crease group";
                    let found = format!("{degrees} degrees");
                    return Err(FileError::expected(file, place, expected, found));
                }
            }
        }
        Ok(())
    }
}

fn alike(a: Node<f64>, b: Node<f64>) -> bool {
    let differences = [
        a.angle - b.angle,
        a.rate - b.rate,
        a.weight[0] - b.weight[0],
        a.weight[1] - b.weight[1],
    ];
    differences.iter().all(|d| d.abs() <= SAME_ANGLE_RAD)
}
