//! Tests the folding map against its definition.

use core::f64::consts::PI;

use foldpath::folding::{FoldingMap, Pose, Rigidity};
use foldpath::generate::Miura;
use foldpath::pattern::{CreasePattern, FaceId};
use foldpath_core::{GroupId, HalfAngle, Membership, Rotation};

/// Returns a sheet and groups of its creases, three in turn, every fifth crease against its group.
fn sheet() -> (CreasePattern, Vec<Membership>) {
    let miura = Miura {
        rows: 5,
        columns: 6,
        sector_angle: 1.0,
        fold: 0.5,
    };
    let pattern = CreasePattern::new(miura.drawing().unwrap()).unwrap();
    let creases = 0..u32::try_from(pattern.creases().len()).unwrap();
    let memberships = creases.map(|crease| Membership {
        group: GroupId(crease % 3),
        negative: crease % 5 == 0,
    });
    let memberships = memberships.collect();
    (pattern, memberships)
}

/// The angles close nowhere: faces, vertices and edges are all displaced, and each measure is the largest
/// of all that it is defined for.
#[test]
fn a_torn_sheet_is_measured_as_defined() {
    let (pattern, memberships) = sheet();
    let angles = [0.3, -1.1, 2.0];
    let mut map = FoldingMap::flat(&pattern);
    map.fold_groups(&pattern, pattern.tree(), &memberships, &angles);
    let rigidity = map.rigidity(&pattern, pattern.tree());

    let rotated = |face: &FaceId, v: usize| {
        let Pose { r_wf, p_w, .. } = map.poses()[face.index()];
        r_wf.rotate(&pattern.vertices()[v].push(0.0)) + p_w
    };
    let (mut gap, mut deformation, mut twist) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (v, faces) in pattern.corners().iter().enumerate() {
        for (a, b) in faces.iter().flat_map(|a| faces.iter().map(move |b| (a, b))) {
            gap = gap.max((rotated(a, v) - rotated(b, v)).norm() / pattern.median_edge());
        }
    }
    for [a, b] in pattern.struts() {
        let folded = (map.vertex(b) - map.vertex(a)).norm();
        deformation = deformation.max((folded / pattern.length([a, b]) - 1.0).abs());
    }
    for (membership, &edge) in memberships.iter().zip(pattern.creases()) {
        let [left, right] = pattern.edge(edge).inner_faces().unwrap();
        let [r_wl, r_wr] = [left, right].map(|face| map.poses()[face.index()].r_wf.matrix());
        let angle = membership.apply(angles[membership.group.index()]);
        let axis = pattern.direction(edge, pattern.edge(edge).ends[0]);
        let half = HalfAngle::of(angle);
        let r_rl = Rotation::about_crease(half, axis.into()).matrix();
        let off = (r_wr * r_rl).transpose() * r_wl;
        let cos = ((off.trace() - 1.0) / 2.0).clamp(-1.0, 1.0);
        twist = twist.max(2.0 * (cos.acos() / 2.0).sin());
    }
    assert!((rigidity.gap - gap).abs() < 1e-13 && gap > 0.1);
    assert!((rigidity.deformation - deformation).abs() < 1e-13 && deformation > 0.1);
    assert!((rigidity.twist - twist).abs() < 1e-7 && twist > 0.1);
}

#[test]
fn groups_fold_as_their_creases_do() {
    let (pattern, memberships) = sheet();
    let angles = [0.3, -1.1, PI];
    let creases = memberships.iter();
    let creases: Vec<_> = creases.map(|m| m.apply(angles[m.group.index()])).collect();
    let single = FoldingMap::new(&pattern, pattern.tree(), &creases);
    let mut grouped = FoldingMap::flat(&pattern);
    grouped.fold_groups(&pattern, pattern.tree(), &memberships, &angles);
    assert_eq!(single.poses(), grouped.poses());
}

#[test]
fn a_broken_map_never_passes_for_a_good_one() {
    let (pattern, memberships) = sheet();
    let map = FoldingMap::new(&pattern, pattern.tree(), &vec![f64::NAN; memberships.len()]);
    let Rigidity {
        deformation,
        gap,
        twist,
    } = map.rigidity(&pattern, pattern.tree());
    assert!(deformation.is_nan() && gap.is_nan() && twist.is_nan());
}
