//! Which stars does a view refuse, and what does it tell of the others?

use foldpath_core::least_squares::ClosureProblem;
use foldpath_core::{GroupId, HalfAngle, Membership, StarsView, expand};
use foldpath_test_support::stars::Stars;
use nalgebra::Vector3;

#[test]
fn a_view_lists_its_stars() {
    let three = Stars::<f64>::new(
        2,
        &[&[(0.0, 1, false), (90.0, 0, true)], &[], &[(0.0, 0, false)]],
    );
    let view = three.view();
    let degrees: Vec<usize> = view.iter().map(|star| star.spokes.len()).collect();
    assert_eq!(degrees, [2, 0, 1]);
    assert_eq!((view.len(), view.unknowns(), view.max_degree()), (3, 2, 2));
    assert!(!view.is_empty());

    let none = StarsView::<f64>::new(&[], &[], 0).unwrap();
    assert!(none.is_empty());
    assert_eq!((none.iter().count(), none.max_degree()), (0, 0));
}

#[test]
fn a_view_refuses_bad_input() {
    let Stars { spokes, .. } =
        Stars::<f64>::new(2, &[&[(0.0, 0, false), (90.0, 1, false), (180.0, 0, true)]]);
    let refused = |ends: &[u32], unknowns| StarsView::new(&spokes, ends, unknowns).is_none();
    assert!(!refused(&[1, 3], 2));
    assert!(refused(&[3, 1, 3], 2), "ends decrease");
    assert!(refused(&[1, 2], 2), "a spoke is left over");
    assert!(refused(&[1, 4], 2), "a spoke is missing");
    assert!(refused(&[], 2), "no star has the spokes");
    assert!(refused(&[3], 1), "group out of range");
    for bad in [
        [0.0, 0.0],
        [1.1, 0.0],
        [f64::NAN, 0.0],
        [f64::INFINITY, 0.0],
    ] {
        let mut spokes = spokes.clone();
        spokes[1].direction = bad;
        assert!(StarsView::new(&spokes, &[3], 2).is_none(), "{bad:?}");
    }
}

#[test]
fn a_problem_refuses_short_scratch() {
    let stars = Stars::<f64>::new(2, &[&[(0.0, 0, false), (90.0, 1, false), (180.0, 0, true)]]);
    let fits = |unknowns: usize, degree: usize| {
        let mut half_angles = vec![HalfAngle::default(); unknowns];
        let mut columns = vec![Vector3::zeros(); degree];
        ClosureProblem::new(stars.view(), &mut half_angles, &mut columns).is_some()
    };
    assert!(fits(2, 3) && fits(5, 5));
    assert!(!fits(1, 3) && !fits(2, 2));
}

#[test]
fn creases_follow_their_groups() {
    let member = |group, negative| Membership {
        group: GroupId(group),
        negative,
    };
    let members = [member(1, false), member(0, true), member(1, true)];
    let mut creases = [0.0; 3];
    assert!(expand(&members, &[0.5, 0.25], &mut creases));
    assert_eq!(
        creases.map(f64::to_bits),
        [0.25, -0.5, -0.25].map(f64::to_bits)
    );
    assert!(
        !expand(&members, &[0.5], &mut creases),
        "a group is missing"
    );
    assert!(
        !expand(&members, &[0.5, 0.25], &mut creases[..2]),
        "a crease is missing"
    );
}
