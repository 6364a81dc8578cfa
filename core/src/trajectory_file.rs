//! Reads and writes `.traj` files: trajectories as they are flashed and streamed.
//!
//! A file is the postcard encoding of these values, one after the other:
//!
//! | value | type | meaning |
//! |---|---|---|
//! | magic | `[u8; 4]` | `FPTJ` |
//! | version | `u8` | 4 |
//! | interpolation | [`Interpolation`] | how the motion between knots is made |
//! | limits | `Vec<[f32; 4]>` | a group: lower and upper angle, speed, acceleration |
//! | hinges | `Vec<u32>` | a hinge: twice its group, and 1 more if it turns the opposite way |
//! | spokes | `Vec<(u32, [f32; 2])>` | a spoke of an essential vertex: four times its group, 2 more if it is the last of its vertex, 1 more if it turns the opposite way; its direction |
//! | closure | `f32` | the largest closure residual that a commanded configuration has, rounding included |
//! | knots | `Vec<(f32, [[f32; N]; GROUPS])>` | seconds since the knot before, 0 at the first; a group: angle, rate and, where N is 4, weight and its rate |
//! | most lag | `f32` | distance between a hinge and its command from which on the motion holds; infinite for that of the controller |
//! | gaps | `Vec<f32>` | a hinge: gap of the sheet for each radian by which it alone is off, median edges; of all hinges or none |
//! | path | `[u8; 4]` | number that tells this path from others: a checksum of hinges, spokes and knots, little endian |
//! | checksum | `[u8; 4]` | CRC-32 of all bytes before, little endian |
//!
//! N is 4 for [`Interpolation::Homogeneous`] and 2 for all others. Units are radians and seconds throughout. All knots
//! have the same size, so that a reader finds each knot without reading those before it. In files of versions 2 and 3 a knot
//! has the seconds since the start, and there is no number of the path; those of version 2 have no most lag and no gaps.

use core::fmt;

use crate::checksum::{checksum, checksum_on};
use crate::curve::{Interpolation, Node};
use crate::trajectory::{TrajectoryError, TrajectoryView, check_knot};
use crate::wire::path::{Content as _, PathOnSheet};
use crate::{GroupLimits, Membership, Spoke, StarsView};

/// First bytes of a file.
pub const MAGIC: [u8; 4] = *b"FPTJ";
/// Version that is written.
pub const VERSION: u8 = 4;
/// Oldest version that is read.
pub const OLDEST_VERSION: u8 = 2;
/// Oldest versions of which knots have spans and files the number of their path, and of which files have the cost of hinges that
/// lag.
const SPANS_VERSION: u8 = 4;
const COST_VERSION: u8 = 3;

/// Reason why bytes are not a trajectory, or why a trajectory cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FileError {
    /// The file does not begin with [`MAGIC`].
    Magic,
    /// The file has this version.
    Version(u8),
    /// The file ends within the value that begins at this byte.
    Truncated(usize),
    /// The file should end with the byte before this one.
    Trailing(usize),
    /// The number at this byte is larger than a `u32`.
    Number(usize),
    /// No interpolation has this number.
    Interpolation(u32),
    /// There are more than 65,535 groups.
    Groups,
    /// The checksum is not that of the bytes before.
    Checksum,
    /// The limits of the group of this number are missing or have no group, are no range, or are not above 0.
    Limits(usize),
    /// The hinge of this number follows a group that does not exist.
    Hinge(usize),
    /// The spoke of this number follows a group that does not exist, has a direction whose length is not 1, or is the
    /// last of all spokes without being marked as the last of its vertex.
    Spoke(usize),
    /// The largest closure residual is negative or not finite.
    Closure,
    /// A knot is not valid.
    Knot(TrajectoryError),
    /// The distance from which on the motion holds is not above 0.
    MostLag,
    /// The gap of the hinge of this number is missing, has no hinge, is negative or not finite.
    Gap(usize),
    /// The number of the path is not this one, which is that of its hinges, spokes and knots.
    Path(u32),
    /// The angle of this group at this knot is beyond its limits.
    Angle {
        /// Number of the knot.
        knot: usize,
        /// Number of the group.
        group: usize,
    },
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Magic => write!(f, "byte 0: expected the magic number FPTJ"),
            Self::Version(found) => write!(
                f,
                "byte 4: expected version {OLDEST_VERSION} to {VERSION}, found {found}"
            ),
            Self::Truncated(at) => write!(f, "byte {at}: the file ends within the value here"),
            Self::Trailing(at) => write!(f, "byte {at}: expected the end of the file"),
            Self::Number(at) => write!(f, "byte {at}: expected a number of at most 32 bits"),
            Self::Interpolation(found) => {
                write!(f, "byte 5: expected an interpolation 0 to 3, found {found}")
            }
            Self::Groups => write!(f, "expected at most 65535 groups"),
            Self::Checksum => write!(f, "the checksum is not that of the bytes before it"),
            Self::Limits(group) => write!(
                f,
                "group {group}: expected finite angles in order, a speed and an acceleration above 0"
            ),
            Self::Hinge(hinge) => write!(f, "hinge {hinge}: there is no group of its number"),
            Self::Spoke(spoke) => write!(
                f,
                "spoke {spoke}: expected a group that there is, a direction of length 1, and the last of all to end a vertex"
            ),
            Self::Closure => write!(f, "closure: expected a finite number from 0 on"),
            Self::Knot(error) => error.fmt(f),
            Self::MostLag => write!(f, "most lag: expected a number above 0"),
            Self::Gap(hinge) => write!(
                f,
                "gap of hinge {hinge}: expected a finite number from 0 on for each hinge, or none"
            ),
            Self::Path(number) => write!(f, "number of the path: expected {number:08x}"),
            Self::Angle { knot, group } => {
                write!(
                    f,
                    "knot {knot}: the angle of group {group} is beyond its limits"
                )
            }
        }
    }
}

impl core::error::Error for FileError {}

/// Cost of hinges that are not where they are commanded to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagCost<'a> {
    /// Distance between a hinge and its command from which on the motion holds, radians; infinite for that of the
    /// controller.
    pub most_lag: f32,
    /// Gap of the sheet for each radian by which a hinge alone is off, median edges, for each hinge; empty if it is not known.
    pub gaps: &'a [f32],
}

impl LagCost<'_> {
    /// The cost that is not known.
    pub const UNKNOWN: Self = Self {
        most_lag: f32::INFINITY,
        gaps: &[],
    };
}

/// Writes a file piece by piece to `sink`: a trajectory with the limits of its groups, its hinges, its essential
/// vertices, the largest `closure` residual that they may have, and the `cost` of hinges that lag.
///
/// # Errors
/// If there is not one valid limit for each group, if a hinge or a spoke follows no group, if `closure` is negative or
/// not finite, if an angle is beyond its limits, or if the cost is not valid; nothing is written then.
pub fn write(
    trajectory: TrajectoryView<'_, f32>,
    limits: &[GroupLimits],
    hinges: &[Membership],
    stars: StarsView<'_, f32>,
    closure: f32,
    cost: LagCost<'_>,
    sink: impl FnMut(&[u8]),
) -> Result<(), FileError> {
    check_to_write(trajectory, limits, hinges)?;
    check_cost(cost.most_lag, hinges.len(), cost.gaps.iter().copied())?;
    let spokes = || stars.iter().flat_map(|star| star.spokes);
    if let Some(spoke) = spokes().position(|spoke| spoke.group.index() >= limits.len()) {
        return Err(FileError::Spoke(spoke));
    }
    if !is_residual(closure) {
        return Err(FileError::Closure);
    }
    let mut out = Writer { sink, sum: 0 };
    out.bytes(&MAGIC);
    out.bytes(&[VERSION]);
    out.count(trajectory.interpolation() as usize);
    out.count(limits.len());
    for group in limits {
        out.floats(&group.numbers());
    }
    out.count(hinges.len());
    for hinge in hinges {
        out.count(hinge.code() as usize);
    }
    out.count(spokes().count());
    for star in stars.iter() {
        for (code, spoke) in star.codes() {
            out.count(code as usize);
            out.floats(&spoke.direction);
        }
    }
    out.floats(&[closure]);
    out.count(trajectory.len());
    for knot in (0..trajectory.len()).filter_map(|index| trajectory.knot(index)) {
        out.floats(&[knot.span]);
        let mut weights = knot.weights.iter();
        for (&angle, &rate) in knot.angles.iter().zip(knot.rates) {
            out.floats(&[angle, rate]);
            if let Some(weight) = weights.next() {
                out.floats(weight);
            }
        }
    }
    out.floats(&[cost.most_lag]);
    out.count(cost.gaps.len());
    out.floats(cost.gaps);
    let content = PathOnSheet {
        limits,
        hinges,
        stars,
        path: trajectory,
    };
    out.bytes(&content.number().to_le_bytes());
    let checksum = out.sum.to_le_bytes();
    (out.sink)(&checksum);
    Ok(())
}

/// Checks the distance from which on the motion holds, and the gaps of the hinges.
fn check_cost(
    most_lag: f32,
    hinges: usize,
    gaps: impl ExactSizeIterator<Item = f32>,
) -> Result<(), FileError> {
    // False for a NaN.
    let is_distance = most_lag > 0.0;
    if !is_distance {
        return Err(FileError::MostLag);
    }
    let count = gaps.len();
    if count > 0 && count != hinges {
        return Err(FileError::Gap(count.min(hinges)));
    }
    let mut gaps = gaps;
    gaps.position(|gap| !is_residual(gap))
        .map_or(Ok(()), |hinge| Err(FileError::Gap(hinge)))
}

fn is_residual(closure: f32) -> bool {
    closure.is_finite() && closure >= 0.0
}

/// Checks the limits, the motion and the hinges for [`write`].
fn check_to_write(
    trajectory: TrajectoryView<'_, f32>,
    limits: &[GroupLimits],
    hinges: &[Membership],
) -> Result<(), FileError> {
    if limits.len() != trajectory.groups() {
        return Err(FileError::Limits(limits.len().min(trajectory.groups())));
    }
    if u16::try_from(limits.len()).is_err() {
        return Err(FileError::Groups);
    }
    if let Some(group) = limits.iter().position(|limits| !limits.are_sound()) {
        return Err(FileError::Limits(group));
    }
    let outside = |hinge: &Membership| hinge.group.index() >= limits.len();
    if let Some(hinge) = hinges.iter().position(outside) {
        return Err(FileError::Hinge(hinge));
    }
    for (index, knot) in (0..trajectory.len()).filter_map(|i| Some((i, trajectory.knot(i)?))) {
        let beyond = |(limits, angle): (&GroupLimits, &f32)| !limits.allow(*angle);
        if let Some(group) = limits.iter().zip(knot.angles).position(beyond) {
            return Err(FileError::Angle { knot: index, group });
        }
    }
    Ok(())
}

/// Writes values in postcard's encoding and computes their checksum.
struct Writer<S> {
    sink: S,
    /// Checksum of all bytes so far.
    sum: u32,
}

impl<S: FnMut(&[u8])> Writer<S> {
    fn bytes(&mut self, bytes: &[u8]) {
        self.sum = checksum_on(self.sum, bytes);
        (self.sink)(bytes);
    }

    fn floats(&mut self, values: &[f32]) {
        for value in values {
            self.bytes(&value.to_le_bytes());
        }
    }

    /// Writes a varint: seven bits in each byte, the lowest first; the highest bit says that more bytes follow.
    fn count(&mut self, mut value: usize) {
        loop {
            let [low, ..] = value.to_le_bytes();
            value >>= 7;
            let more = u8::from(value > 0) << 7;
            self.bytes(&[low & 0x7f | more]);
            if more == 0 {
                break;
            }
        }
    }
}

/// A checked trajectory file, read in place from flash or memory.
#[derive(Clone, Copy, Debug)]
pub struct TrajectoryFile<'a> {
    interpolation: Interpolation,
    groups: u16,
    knots: usize,
    hinges: usize,
    /// Four numbers for each group.
    limits: &'a [[u8; 4]],
    /// One varint for each hinge.
    hinge_codes: &'a [u8],
    spokes: usize,
    /// One varint and two numbers for each spoke.
    spoke_codes: &'a [u8],
    closure: f32,
    /// `true` if a record begins with the time of the knot instead of its span.
    is_timed: bool,
    /// One record for each knot.
    records: &'a [[u8; 4]],
    most_lag: f32,
    /// One number for each hinge, or none.
    gaps: &'a [[u8; 4]],
    /// Number of the path.
    path: u32,
}

impl<'a> TrajectoryFile<'a> {
    /// Checks a whole file. Cost: proportional to its bytes, without memory of its own.
    ///
    /// # Errors
    /// The first defect, in this order: of the lengths, of the checksum, of the numbers.
    pub fn read(bytes: &'a [u8]) -> Result<Self, FileError> {
        let mut cursor = Cursor { bytes, at: 0 };
        if cursor.array::<4>()? != MAGIC {
            return Err(FileError::Magic);
        }
        let [version] = cursor.array()?;
        if !(OLDEST_VERSION..=VERSION).contains(&version) {
            return Err(FileError::Version(version));
        }
        let kind = cursor.number()?;
        let interpolation = Interpolation::ALL.get(kind as usize).copied();
        let interpolation = interpolation.ok_or(FileError::Interpolation(kind))?;
        let groups = u16::try_from(cursor.number()?).map_err(|_| FileError::Groups)?;
        let limits = cursor.floats(usize::from(groups), 4)?;
        let hinges = cursor.count()?;
        let first = cursor.at;
        for _ in 0..hinges {
            cursor.number()?;
        }
        let hinge_codes = bytes.get(first..cursor.at).unwrap_or(&[]);
        let spokes = cursor.count()?;
        let first = cursor.at;
        for _ in 0..spokes {
            cursor.spoke()?;
        }
        let spoke_codes = bytes.get(first..cursor.at).unwrap_or(&[]);
        let closure = f32::from_le_bytes(cursor.array()?);
        let knots = cursor.count()?;
        let mut file = Self {
            interpolation,
            groups,
            knots,
            hinges,
            limits,
            hinge_codes,
            spokes,
            spoke_codes,
            closure,
            is_timed: version < SPANS_VERSION,
            records: &[],
            most_lag: f32::INFINITY,
            gaps: &[],
            path: 0,
        };
        file.records = cursor.floats(knots, file.record())?;
        if version >= COST_VERSION {
            file.most_lag = f32::from_le_bytes(cursor.array()?);
            let gaps = cursor.count()?;
            file.gaps = cursor.floats(gaps, 1)?;
        }
        let path = if file.is_timed {
            None
        } else {
            Some(u32::from_le_bytes(cursor.array()?))
        };
        let body = bytes.get(..cursor.at).unwrap_or(&[]);
        let sum = u32::from_le_bytes(cursor.array()?);
        if cursor.at < bytes.len() {
            return Err(FileError::Trailing(cursor.at));
        }
        if checksum(body) != sum {
            return Err(FileError::Checksum);
        }
        file.check()?;
        file.path = file.number();
        if path.is_some_and(|path| path != file.path) {
            return Err(FileError::Path(file.path));
        }
        Ok(file)
    }

    /// Checks the numbers of the file.
    fn check(&self) -> Result<(), FileError> {
        for group in 0..self.groups() {
            if !self.limits(group).is_some_and(|limits| limits.are_sound()) {
                return Err(FileError::Limits(group));
            }
        }
        let outside = |hinge: Membership| hinge.group.index() >= self.groups();
        if let Some(hinge) = self.memberships().position(outside) {
            return Err(FileError::Hinge(hinge));
        }
        let count = self.spokes;
        for (number, (spoke, last)) in (1..).zip(self.spokes()) {
            let known = spoke.group.index() < self.groups() && spoke.is_unit();
            if !known || number == count && !last {
                return Err(FileError::Spoke(number - 1));
            }
        }
        if !is_residual(self.closure) {
            return Err(FileError::Closure);
        }
        check_cost(self.most_lag, self.hinges, self.gaps())?;
        for index in 0..self.knots {
            let missing = FileError::Knot(TrajectoryError::Width(index));
            let span = self.span(index).ok_or(missing)?;
            let nodes = (0..self.groups()).filter_map(|group| self.node(index, group));
            let checked = check_knot(self.interpolation, index, span, nodes.clone());
            checked.map_err(FileError::Knot)?;
            let mut limited = (0..).map_while(|group| self.limits(group)).zip(nodes);
            if let Some(group) = limited.position(|(limits, node)| !limits.allow(node.angle)) {
                return Err(FileError::Angle { knot: index, group });
            }
        }
        Ok(())
    }

    /// Returns the kind of motion between knots.
    #[must_use]
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// Returns the number of group angles in a knot.
    #[must_use]
    pub fn groups(&self) -> usize {
        usize::from(self.groups)
    }

    /// Returns the number of hinges.
    #[must_use]
    pub fn hinges(&self) -> usize {
        self.hinges
    }

    /// Returns the number of knots.
    #[must_use]
    pub fn len(&self) -> usize {
        self.knots
    }

    /// Returns `true` if there is no knot.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.knots == 0
    }

    /// Returns the limits of a group.
    #[must_use]
    pub fn limits(&self, group: usize) -> Option<GroupLimits> {
        let (numbers, _) = self.limits.as_chunks::<4>();
        let numbers = numbers.get(group)?.map(f32::from_le_bytes);
        Some(GroupLimits::from_numbers(numbers))
    }

    /// Iterates over group and sign of each hinge, in order.
    pub fn memberships(&self) -> impl Iterator<Item = Membership> + use<'a> {
        let mut cursor = Cursor {
            bytes: self.hinge_codes,
            at: 0,
        };
        core::iter::from_fn(move || Some(Membership::from_code(cursor.number().ok()?)))
    }

    /// Iterates over the spokes of the essential vertices, in order. The flag is `true` for the last spoke of a vertex.
    pub fn spokes(&self) -> impl Iterator<Item = (Spoke<f32>, bool)> + use<'a> {
        let mut cursor = Cursor {
            bytes: self.spoke_codes,
            at: 0,
        };
        core::iter::from_fn(move || cursor.spoke().ok())
    }

    /// Returns the largest closure residual that a commanded configuration has, rounding included.
    #[must_use]
    pub fn closure(&self) -> f32 {
        self.closure
    }

    /// Returns the distance between a hinge and its command from which on the motion holds, radians; infinite if the file
    /// tells none.
    #[must_use]
    pub fn most_lag(&self) -> f32 {
        self.most_lag
    }

    /// Iterates over the gap of the sheet for each radian by which a hinge alone is off, median edges, for each hinge; empty
    /// if the file tells none.
    pub fn gaps(&self) -> impl ExactSizeIterator<Item = f32> + use<'a> {
        self.gaps.iter().copied().map(f32::from_le_bytes)
    }

    /// Returns the number that tells this path from others: [`SheetHead::path`](crate::wire::message::SheetHead::path).
    #[must_use]
    pub fn path(&self) -> u32 {
        self.path
    }

    /// Returns the seconds of a knot since the knot before; 0 at the first knot.
    #[must_use]
    pub fn span(&self, knot: usize) -> Option<f32> {
        let number = self.value(knot, 0)?;
        match knot.checked_sub(1) {
            Some(before) if self.is_timed => Some(number - self.value(before, 0)?),
            None if self.is_timed => Some(0.0),
            _ => Some(number),
        }
    }

    /// Returns angle and rate of a group at a knot, with weight 1 if the interpolation has no weights.
    #[must_use]
    pub fn node(&self, knot: usize, group: usize) -> Option<Node<f32>> {
        if group >= self.groups() {
            return None;
        }
        let width = self.interpolation.width();
        let place = 1 + group * width;
        let weight = if width == 4 {
            [self.value(knot, place + 2)?, self.value(knot, place + 3)?]
        } else {
            [1.0, 0.0]
        };
        Some(Node {
            angle: self.value(knot, place)?,
            rate: self.value(knot, place + 1)?,
            weight,
        })
    }

    /// Returns the number of `f32` in the record of a knot.
    fn record(&self) -> usize {
        1 + self.groups() * self.interpolation.width()
    }

    /// Returns number `place` of the record of a knot.
    fn value(&self, knot: usize, place: usize) -> Option<f32> {
        let index = knot.checked_mul(self.record())?.checked_add(place)?;
        self.records.get(index).copied().map(f32::from_le_bytes)
    }
}

/// A reading position in a slice of bytes.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], FileError> {
        let truncated = FileError::Truncated(self.at);
        let end = self.at.checked_add(count).ok_or(truncated)?;
        let taken = self.bytes.get(self.at..end).ok_or(truncated)?;
        self.at = end;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], FileError> {
        let truncated = FileError::Truncated(self.at);
        self.take(N)?.try_into().map_err(|_| truncated)
    }

    /// Reads `rows` rows of `width` numbers.
    fn floats(&mut self, rows: usize, width: usize) -> Result<&'a [[u8; 4]], FileError> {
        let bytes = rows.checked_mul(width).and_then(|n| n.checked_mul(4));
        let bytes = bytes.ok_or(FileError::Truncated(self.at))?;
        let (numbers, _) = self.take(bytes)?.as_chunks();
        Ok(numbers)
    }

    fn count(&mut self) -> Result<usize, FileError> {
        let start = self.at;
        usize::try_from(self.number()?).map_err(|_| FileError::Number(start))
    }

    /// Reads a spoke; the flag is `true` if it is the last of its vertex.
    fn spoke(&mut self) -> Result<(Spoke<f32>, bool), FileError> {
        let code = self.number()?;
        let direction = [self.array()?, self.array()?].map(f32::from_le_bytes);
        Ok(Spoke::from_code(code, direction))
    }

    /// Reads a varint of at most 32 bits.
    fn number(&mut self) -> Result<u32, FileError> {
        let start = self.at;
        let mut value = 0;
        for place in 0..5 {
            let [byte] = self.array().map_err(|_| FileError::Truncated(start))?;
            let bits = u32::from(byte & 0x7f);
            if place == 4 && bits > 0xf {
                break;
            }
            value |= bits << (7 * place);
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(FileError::Number(start))
    }
}
