//! The closure residual of a loop of faces round a hole and its analytic Jacobian: do the panels round a hole meet
//! again?
//!
//! Round a vertex all axes pass through one point, so that the rotations alone decide whether the panels meet again.
//! Round a hole the axes lie anywhere: the product L of the rigid motions across the creases of the loop has to be the
//! identity in rotation and in translation, which is six conditions. This is the folding map of
//! [XiLien2015](crate#references), section 3.2, closed to a cycle; L is its holonomy.
//!
//! Places are measured from a point near the middle of the loop, in units of the loop's size, so that both residuals
//! are dimensionless: r of L's rotation, as for a [star](crate::closure), and t, the displacement of that point by L.
//!
//! With P and p the rotation and translation before crease k, a = P·axis and q = P·place + p, a turn of crease k turns
//! everything behind the crease about the axis a through the point q. Therefore ∂r/∂ρ = w a + a × v as for a star, and
//! ∂t/∂ρ = a × (t − q).

use nalgebra::Vector3;

use crate::closure::{derivative, positive};
use crate::{HalfAngle, Rotation, Scalar, Spoke, StarsView};

/// The creases that a closed path from face to face round a hole crosses, in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopView<'a, T> {
    /// The creases; each is directed so that the face that the path enters lies on its left.
    pub spokes: &'a [Spoke<T>],
    /// A point on the line of each crease, in the coordinates of the [module](self).
    pub places: &'a [[T; 2]],
}

/// A list of loops in three borrowed arrays: stars whose spokes have places.
#[derive(Clone, Copy, Debug)]
pub struct LoopsView<'a, T> {
    stars: StarsView<'a, T>,
    places: &'a [[T; 2]],
}

impl<'a, T: Scalar> LoopsView<'a, T> {
    /// Returns a view without loops: a sheet without holes.
    #[must_use]
    pub fn none() -> Self {
        Self {
            stars: StarsView::none(),
            places: &[],
        }
    }

    /// Creates a view of loops that are stored one after the other; loop i ends before spoke `ends[i]`.
    ///
    /// Returns `None` if the ends decrease or the last end is not the number of spokes, if there is not one place for
    /// each spoke, if a group is not below `unknowns`, or if a direction does not have length 1.
    #[must_use]
    pub fn new(
        spokes: &'a [Spoke<T>],
        places: &'a [[T; 2]],
        ends: &'a [u32],
        unknowns: usize,
    ) -> Option<Self> {
        let stars = StarsView::new(spokes, ends, unknowns)?;
        (places.len() == spokes.len()).then_some(Self { stars, places })
    }

    /// Returns the number of loops.
    #[must_use]
    pub fn len(&self) -> usize {
        self.stars.len()
    }

    /// Returns `true` if there is no loop.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.stars.is_empty()
    }

    /// Returns the largest number of spokes in a loop.
    #[must_use]
    pub fn max_degree(&self) -> usize {
        self.stars.max_degree()
    }

    /// Iterates over the loops in order.
    pub fn iter(&self) -> impl Iterator<Item = LoopView<'a, T>> + use<'a, T> {
        self.stars.iter().scan(self.places, |left, star| {
            let (places, rest) = left.split_at_checked(star.spokes.len())?;
            *left = rest;
            Some(LoopView {
                spokes: star.spokes,
                places,
            })
        })
    }
}

/// Returns the residuals of rotation and translation (dimensionless), which are zero exactly if the loop closes.
///
/// `half_angles` has one entry for each unknown; a spoke whose group has no entry counts as flat.
#[must_use]
pub fn residuals<T: Scalar>(
    cycle: LoopView<'_, T>,
    half_angles: &[HalfAngle<T>],
) -> [Vector3<T>; 2] {
    let mut motion = Motion::none();
    for (spoke, place) in cycle.spokes.iter().zip(cycle.places) {
        if let Some(half) = half_angles.get(spoke.group.index()) {
            motion.turn(half.signed(spoke.negative), spoke, place);
        }
    }
    [positive(motion.turned).v * T::TWO, motion.moved]
}

/// Returns the residuals of rotation and translation and writes their derivatives by the unknown of each spoke.
///
/// `columns` receives first the derivatives of the rotation, then those of the translation. The sign of a `negative`
/// spoke is included. Returns `None` if `columns` does not have two entries for each spoke, or if a group is missing.
pub fn residuals_and_jacobian<T: Scalar>(
    cycle: LoopView<'_, T>,
    half_angles: &[HalfAngle<T>],
    columns: &mut [Vector3<T>],
) -> Option<[Vector3<T>; 2]> {
    let (turns, moves) = columns.split_at_mut_checked(cycle.spokes.len())?;
    if moves.len() != turns.len() {
        return None;
    }
    let spokes = || cycle.spokes.iter().zip(cycle.places);
    let mut motion = Motion::none();
    for ((spoke, place), (axis, through)) in spokes().zip(turns.iter_mut().zip(moves.iter_mut())) {
        *axis = motion.turned.rotate_in_sheet(spoke.direction);
        *through = motion.apply(place);
        let half = half_angles.get(spoke.group.index())?;
        motion.turn(half.signed(spoke.negative), spoke, place);
    }
    let closure = positive(motion.turned);
    for (spoke, (turn, shift)) in cycle.spokes.iter().zip(turns.iter_mut().zip(moves)) {
        let axis = if spoke.negative { -*turn } else { *turn };
        *turn = derivative(closure, &axis);
        *shift = axis.cross(&(motion.moved - *shift));
    }
    Some([closure.v * T::TWO, motion.moved])
}

/// Rigid motion of a face of the loop.
pub(crate) struct Motion<T> {
    pub(crate) turned: Rotation<T>,
    pub(crate) moved: Vector3<T>,
}

impl<T: Scalar> Motion<T> {
    pub(crate) fn none() -> Self {
        Self {
            turned: Rotation::identity(),
            moved: Vector3::new(T::zero(), T::zero(), T::zero()),
        }
    }

    pub(crate) fn apply(&self, place: &[T; 2]) -> Vector3<T> {
        self.turned.rotate_in_sheet(*place) + self.moved
    }

    /// Moves on to the face behind a crease: turns about the crease's line, whose points stay where they are.
    pub(crate) fn turn(&mut self, half: HalfAngle<T>, spoke: &Spoke<T>, place: &[T; 2]) {
        let before = self.apply(place);
        self.turned = self.turned.across_crease(half, spoke.direction);
        self.moved += before - self.apply(place);
    }
}
