//! Vertex stars, the input of every closure condition: which creases meet at a vertex, in which directions, and which
//! unknown turns each of them.

use crate::{GroupId, Scalar};

/// One crease as seen from a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spoke<T> {
    /// The unknown whose value, up to sign, is this crease's fold angle.
    pub group: GroupId,
    /// `true` if the fold angle is minus the unknown.
    pub negative: bool,
    /// Unit direction (cos α, sin α) from the vertex along the crease in the flat sheet.
    pub direction: [T; 2],
}

impl<T: Scalar> Spoke<T> {
    /// Returns the crease's fold angle in radians; 0 if its group is not among the `unknowns`.
    #[inline]
    #[must_use]
    pub fn fold_angle(&self, unknowns: &[T]) -> T {
        let value = unknowns.get(self.group.index()).copied();
        let value = value.unwrap_or_else(T::zero);
        if self.negative { -value } else { value }
    }

    /// Returns the axis about which the unknown turns the faces behind this crease: `direction`, or its opposite if
    /// `negative`.
    #[inline]
    pub(crate) fn axis(&self) -> [T; 2] {
        // Multiplying by a sign is exact and takes fewer instructions than a choice between two axes.
        let sign = if self.negative { -T::one() } else { T::one() };
        self.direction.map(|coordinate| coordinate * sign)
    }

    /// Returns the spoke of a code in files and messages: four times its group, 2 more if it is the last of its star, 1
    /// more if it turns the opposite way. The flag is `true` for the last spoke.
    pub(crate) fn from_code(code: u32, direction: [T; 2]) -> (Self, bool) {
        let spoke = Self {
            group: GroupId(code >> 2),
            negative: code & 1 == 1,
            direction,
        };
        (spoke, code & 2 == 2)
    }

    /// Returns the code of the spoke, see [`from_code`](Self::from_code).
    pub(crate) fn code(&self, last: bool) -> u32 {
        4 * self.group.0 + 2 * u32::from(last) + u32::from(self.negative)
    }

    /// Returns `true` if the direction has length 1 up to rounding: its squared length is within √ε of 1.
    pub(crate) fn is_unit(&self) -> bool {
        let [x, y] = self.direction;
        (x * x + y * y - T::one()).abs() <= T::EPSILON.sqrt()
    }
}

/// The creases round one vertex, counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StarView<'a, T> {
    /// The spokes in counter-clockwise order.
    pub spokes: &'a [Spoke<T>],
}

impl<'a, T: Scalar> StarView<'a, T> {
    /// Iterates over the spokes, each with the code of [`Spoke::from_code`].
    pub(crate) fn codes(self) -> impl Iterator<Item = (u32, &'a Spoke<T>)> {
        (1..)
            .zip(self.spokes)
            .map(move |(count, spoke)| (spoke.code(count == self.spokes.len()), spoke))
    }
}

/// A list of stars in two borrowed arrays (compressed rows). Arrays, heapless vectors and `Vec` can all lend them.
#[derive(Clone, Copy, Debug)]
pub struct StarsView<'a, T> {
    spokes: &'a [Spoke<T>],
    ends: &'a [u32],
    unknowns: usize,
}

impl<'a, T: Scalar> StarsView<'a, T> {
    /// Creates a view of stars that are stored one after the other in `spokes`.
    ///
    /// Star i ends before spoke `ends[i]`. `unknowns` is the number of unknowns (group angles) that the stars refer to.
    ///
    /// Returns `None` if the ends decrease or the last end is not the number of spokes, if a group is out of range, or
    /// if a direction does not have length 1.
    #[must_use]
    pub fn new(spokes: &'a [Spoke<T>], ends: &'a [u32], unknowns: usize) -> Option<Self> {
        // Not `is_sorted`: it indexes inside, and so leaves panic code in the image.
        let sorted = ends.is_sorted_by(|a, b| a <= b);
        let complete = ends.last().map_or(0, |&end| end as usize) == spokes.len();
        let known = spokes.iter().all(|s| s.group.index() < unknowns);
        let unit = spokes.iter().all(Spoke::is_unit);
        (sorted && complete && known && unit).then_some(Self {
            spokes,
            ends,
            unknowns,
        })
    }

    /// Creates a view of stars that [`new`](Self::new) has accepted before. It is not checked again: the closure of stars that
    /// are not sound means nothing.
    #[must_use]
    pub fn accepted(spokes: &'a [Spoke<T>], ends: &'a [u32], unknowns: usize) -> Self {
        Self {
            spokes,
            ends,
            unknowns,
        }
    }

    /// Returns a view without stars.
    pub(crate) fn none() -> Self {
        Self {
            spokes: &[],
            ends: &[],
            unknowns: 0,
        }
    }

    /// Returns the number of stars.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns `true` if there is no star.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Returns the number of unknowns (group angles) that the stars refer to.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Returns the largest number of spokes in a star.
    #[must_use]
    pub fn max_degree(&self) -> usize {
        self.iter().map(|s| s.spokes.len()).max().unwrap_or(0)
    }

    /// Returns the star of this number, if there is one.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<StarView<'a, T>> {
        let end = *self.ends.get(index)? as usize;
        let before = index.checked_sub(1).and_then(|k| self.ends.get(k));
        let start = before.map_or(0, |&start| start as usize);
        let spokes = self.spokes.get(start..end)?;
        Some(StarView { spokes })
    }

    /// Iterates over the stars in order.
    pub fn iter(&self) -> impl Iterator<Item = StarView<'a, T>> + use<'a, T> {
        let spokes = self.spokes;
        self.ends.iter().scan(0, move |start, &end| {
            let range = *start..end as usize;
            *start = end as usize;
            spokes.get(range).map(|spokes| StarView { spokes })
        })
    }
}
