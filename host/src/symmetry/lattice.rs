//! The lattice of a tessellation: translations of the flat sheet under which all hinges turn alike.

use std::collections::VecDeque;

use foldpath_core::Membership;
use nalgebra::Vector2;

use super::steps::{CENTRE, NONE, Sheet, Step};
use crate::pattern::{CreasePattern, EdgeId, FaceId};
use crate::ragged::{Ragged, group_by_key};

/// The lattice of a sheet, and the sheet in terms of it: each face is one of an *orbit*, in a *cell*.
///
/// # Why one face of each orbit stands for all
///
/// Let the faces A = F₀, F₁, … Fₖ = B follow each other across hinges, and let a step, the translation by
/// t, take each of them to a face of the sheet and each of these hinges to one of the same group and
/// sign, or a side that stays flat to such a side. The pose of B as seen from A is the product of the
/// turns about the hinges; the images' turns are the same, about lines moved by t. So B + t moves as seen
/// from A + t as B does as seen from A, whatever the group angles. In other words: with `pose` taking flat
/// points to folded ones, the rigid motion S that takes pose(A)(x) to pose(A + t)(x + t) is the same for
/// all faces that such chains join. Nothing else is asked of the step: what faces without an image do,
/// or parts of the sheet that no chain joins, is left open, and these have orbits of their own. Only a
/// face cut at the border that hangs on one of the same orbit as another, along the same hinge, moves as
/// that does.
///
/// With two steps, some face A has A + t₁, A + t₂ and A + t₁ + t₂ in the sheet. Wherever the sheet
/// closes, both ways to the last say that S₁ and S₂ commute, so that any way from a face to its image
/// along steps gives pose(A + i t₁ + j t₂)(x + i t₁ + j t₂) = S₁ⁱ S₂ʲ pose(A)(x), and pairs of faces of
/// the same orbits and the same difference of cells move alike. Other ways between cells may lead
/// through places where there is no face: what the formula says of the hinges there is the same.
///
/// Holes do not matter, as the sheet closes round them as well. What is exact for exact coordinates
/// holds to about [`deviation`](Self::deviation) times the square of the number of cells for others.
#[derive(Clone, Debug)]
pub struct Lattice {
    steps: Vec<Vector2<f64>>,
    orbits: Vec<Orbit>,
    places: Vec<Place>,
    /// For each row of cells of each orbit its faces by their column.
    rows: Ragged<(i32, FaceId)>,
    tree: Vec<Link>,
    loops: Vec<Link>,
    deviation: f64,
}

/// Where a face is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Its orbit.
    pub orbit: u32,
    /// Its cell, in steps; the second number is 0 where there is one step only.
    pub cell: [i32; 2],
}

/// Faces that steps take to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Orbit {
    /// One of its faces, as near to the middle of the sheet as any.
    pub representative: FaceId,
    /// Smallest coordinates of its cells.
    pub low: [i32; 2],
    /// Largest coordinates of its cells.
    pub high: [i32; 2],
    /// Its first row in the list of rows.
    first_row: u32,
}

/// Two faces and the edge between.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// The face the way comes from.
    pub from: FaceId,
    /// The face it leads to.
    pub to: FaceId,
    /// The edge between.
    pub edge: EdgeId,
}

impl Lattice {
    /// The lattice of one sheet with these crease groups; `None` if no step is found that leaves at most
    /// half as many orbits as faces, or there are several sheets. Cost: about linear.
    #[must_use]
    pub fn find(pattern: &CreasePattern, memberships: &[Membership]) -> Option<Self> {
        if pattern.sheets() != 1 {
            return None;
        }
        let mut sheet = Sheet::new(pattern, memberships)?;
        let mut steps = sheet.steps();
        if let [first, second] = &steps[..]
            && !meet(first, second)
        {
            steps.pop();
        }
        let seed = sheet.seed(CENTRE)?;
        let mut survey = Survey::new(&sheet, &steps);
        survey.walk(seed);
        let lattice = survey.into_lattice()?;
        (2 * lattice.orbits.len() <= lattice.places.len()).then_some(lattice)
    }

    /// One or two steps, which lead to the cells [1, 0] and [0, 1].
    #[must_use]
    pub fn steps(&self) -> &[Vector2<f64>] {
        &self.steps
    }

    /// The orbits; [`Place::orbit`] is the position here.
    #[must_use]
    pub fn orbits(&self) -> &[Orbit] {
        &self.orbits
    }

    /// For each face its place.
    #[must_use]
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// The place of a face.
    #[must_use]
    pub fn place(&self, face: FaceId) -> Place {
        self.places[face.index()]
    }

    /// The face of an orbit in a cell, if the sheet has it. Cost: logarithmic.
    #[must_use]
    pub fn face_at(&self, place: Place) -> Option<FaceId> {
        let orbit = self.orbits.get(place.orbit as usize)?;
        let [column, row] = place.cell;
        let row = self.row(orbit, row);
        let at = row.binary_search_by_key(&column, |&(column, _)| column);
        at.ok().map(|at| row[at].1)
    }

    /// Columns and faces of an orbit in a row of cells, ascending.
    pub(super) fn row(&self, orbit: &Orbit, row: i32) -> &[(i32, FaceId)] {
        if row < orbit.low[1] || row > orbit.high[1] {
            return &[];
        }
        &self.rows[orbit.first_row as usize + row.abs_diff(orbit.low[1]) as usize]
    }

    /// From cell [0, 0] to this cell in the flat sheet.
    #[must_use]
    pub fn translation(&self, cell: [i32; 2]) -> Vector2<f64> {
        shift(&self.steps, cell)
    }

    /// Ways to the second and every further orbit from one before it, within a cell.
    #[must_use]
    pub fn tree(&self) -> &[Link] {
        &self.tree
    }

    /// For each step a way that leads one step on.
    #[must_use]
    pub fn loops(&self) -> &[Link] {
        &self.loops
    }

    /// How far, over the median edge, a face may be from where the lattice has it, as seen from another, if stars
    /// close to `closure` only (norms of residuals); infinite round holes.
    ///
    /// Two ways from face to face, one along a tree and one along the steps of the lattice, enclose no more
    /// vertices than fit in the box of its cells, and each turns what is beyond by its residual.
    #[must_use]
    pub fn astray(&self, pattern: &CreasePattern, closure: f64) -> f64 {
        if !pattern.holes().is_empty() {
            return f64::INFINITY;
        }
        let ends = [0, 1].map(|k| {
            let low = self.orbits.iter().map(|orbit| orbit.low[k]).min();
            let high = self.orbits.iter().map(|orbit| orbit.high[k]).max();
            f64::from(high.unwrap_or_default()) - f64::from(low.unwrap_or_default()) + 1.0
        });
        #[allow(clippy::cast_precision_loss, reason = "counts of vertices and faces")]
        let [vertices, faces, orbits] = [
            pattern.vertices().len(),
            pattern.faces().len(),
            self.orbits.len(),
        ]
        .map(|count| count as f64);
        let enclosed = vertices * orbits / faces * ends[0] * ends[1];
        let ways = self.steps.iter().zip(ends);
        let reach: f64 = ways.map(|(step, count)| step.norm() * count).sum();
        closure * enclosed * reach / pattern.median_edge()
    }

    /// Largest distance in the flat sheet, in its units, between a corner moved by a step and the one it
    /// is taken for.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        self.deviation
    }
}

/// Whether some face has both images and their common one.
fn meet(first: &Step, second: &Step) -> bool {
    let image = |step: &Step, face: u32| step.images.get(face as usize).copied().unwrap_or(NONE);
    let mut pairs = first.images.iter().zip(&second.images);
    pairs.any(|(&a, &b)| {
        let common = image(second, a);
        common != NONE && common == image(first, b)
    })
}

/// So many of the first step and so many of the second.
fn shift(steps: &[Vector2<f64>], counts: [i32; 2]) -> Vector2<f64> {
    let parts = steps.iter().zip(counts);
    parts.map(|(step, count)| step * f64::from(count)).sum()
}

/// Difference of two cells.
fn minus(a: [i32; 2], b: [i32; 2]) -> [i32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// Orbits and cells while they are found.
struct Survey<'a> {
    sheet: &'a Sheet<'a>,
    /// For each face its orbit, in the order of the first faces, and its cell relative to that face.
    raw: Vec<Place>,
    /// For each raw orbit its number, in the order of the walk, and its cell that becomes [0, 0].
    known: Vec<Option<Place>>,
    shifts: Vec<Vector2<f64>>,
    representatives: Vec<FaceId>,
    tree: Vec<Link>,
    /// For each orbit the links of the tree that lead on from it.
    ways_on: Vec<Vec<Link>>,
    /// Links that lead to other cells, one for each difference of cells.
    loops: Vec<([i32; 2], Link)>,
}

impl<'a> Survey<'a> {
    fn new(sheet: &'a Sheet<'a>, steps: &[Step]) -> Self {
        let (raw, orbits) = orbits(sheet.faces(), steps);
        Self {
            sheet,
            raw,
            known: vec![None; orbits],
            shifts: steps.iter().map(|step| step.shift).collect(),
            representatives: Vec::new(),
            tree: Vec::new(),
            ways_on: Vec::new(),
            loops: Vec::new(),
        }
    }

    /// Number of the face's orbit and its cell, once the orbit is known.
    fn place(&self, face: u32) -> Option<Place> {
        let raw = self.raw[face as usize];
        let known = self.known[raw.orbit as usize]?;
        Some(Place {
            orbit: known.orbit,
            cell: minus(raw.cell, known.cell),
        })
    }

    /// Goes from face to face until all orbits are known and the ways to other cells make a basis. An
    /// orbit's cells are counted so that it is reached within a cell.
    fn walk(&mut self, seed: FaceId) {
        let mut seen = vec![false; self.raw.len()];
        seen[seed.index()] = true;
        let mut open = VecDeque::from([seed.0]);
        let mut unknown = self.known.len();
        self.enter(seed.0, [0, 0]);
        while let Some(from) = open.pop_front() {
            let Some(here) = self.place(from) else {
                return;
            };
            for side in self.sheet.sides(from) {
                if side.face == NONE {
                    continue;
                }
                let link = Link {
                    from: FaceId(from),
                    to: FaceId(side.face),
                    edge: side.edge,
                };
                match self.place(side.face) {
                    None => {
                        unknown -= 1;
                        self.reach(link);
                    }
                    Some(there) => self.close(minus(there.cell, here.cell), link),
                }
                if !seen[side.face as usize] {
                    seen[side.face as usize] = true;
                    open.push_back(side.face);
                }
            }
            if unknown <= 1 && self.basis().is_some() {
                return;
            }
        }
    }

    /// Enters the orbit of the face that a link leads to. It may continue one that is known: faces cut at
    /// a border have images along it, even if a single step leads to none of them.
    fn reach(&mut self, link: Link) {
        let sides = self.sheet.sides(link.to.0).iter();
        let sides = sides.filter(|side| side.face != NONE);
        let links: Vec<_> = sides
            .filter_map(|side| {
                let link = Link {
                    from: FaceId(side.face),
                    to: link.to,
                    edge: side.edge,
                };
                Some((self.place(side.face)?, link))
            })
            .collect();
        for &(here, link) in &links {
            for &before in &self.ways_on[here.orbit as usize] {
                let places = [before.from, before.to].map(|face| self.place(face.0));
                let [Some(from), Some(to)] = places else {
                    continue;
                };
                let on = minus(here.cell, from.cell);
                if self.sheet.carries(shift(&self.shifts, on), [before, link]) {
                    let cell = [on[0] + to.cell[0], on[1] + to.cell[1]];
                    self.know(link.to.0, to.orbit, cell);
                    return;
                }
            }
        }
        let here = self.place(link.from.0).unwrap_or_default();
        self.enter(link.to.0, here.cell);
        self.tree.push(link);
        for (here, link) in links {
            self.ways_on[here.orbit as usize].push(link);
        }
    }

    /// Gives the orbit of a face the next number, and the face this cell.
    fn enter(&mut self, face: u32, cell: [i32; 2]) {
        let orbit = u32::try_from(self.representatives.len()).unwrap_or(NONE);
        self.representatives.push(FaceId(face));
        self.ways_on.push(Vec::new());
        self.know(face, orbit, cell);
    }

    fn know(&mut self, face: u32, orbit: u32, cell: [i32; 2]) {
        let raw = self.raw[face as usize];
        self.known[raw.orbit as usize] = Some(Place {
            orbit,
            cell: minus(raw.cell, cell),
        });
    }

    fn close(&mut self, way: [i32; 2], link: Link) {
        let back = minus([0, 0], way);
        let known = self.loops.iter().any(|(w, _)| *w == way || *w == back);
        if way != [0, 0] && !known {
            self.loops.push((way, link));
        }
    }

    /// Links whose ways generate all others, of those in hand the shortest.
    fn basis(&self) -> Option<Vec<([i32; 2], Link)>> {
        let length = |way: &[i32; 2]| shift(&self.shifts, *way).norm_squared();
        if self.shifts.len() == 1 {
            let one = self.loops.iter().find(|(way, _)| way[0].abs() == 1);
            return one.map(|one| vec![*one]);
        }
        let pairs = self.loops.iter().enumerate().flat_map(|(k, a)| {
            let others = self.loops[..k].iter();
            others.map(move |b| [*b, *a])
        });
        let pairs = pairs.filter(|[(a, _), (b, _)]| (a[0] * b[1] - a[1] * b[0]).abs() == 1);
        let size = |[(a, _), (b, _)]: &[([i32; 2], Link); 2]| length(a) + length(b);
        let best = pairs.min_by(|a, b| size(a).total_cmp(&size(b)));
        best.map(|pair| pair.to_vec())
    }

    /// The lattice with the ways of the loops as its steps.
    fn into_lattice(self) -> Option<Lattice> {
        let mut basis = self.basis()?;
        let mut steps = Vec::new();
        for (way, link) in &mut basis {
            let mut step = shift(&self.shifts, *way);
            // Of a step and its opposite, the one that leads up, or else to the right.
            let level = step.y.abs() <= 1e-9 * step.norm();
            if if level { step.x < 0.0 } else { step.y < 0.0 } {
                (*way, step) = (minus([0, 0], *way), -step);
                (link.from, link.to) = (link.to, link.from);
            }
            steps.push(step);
        }
        let a = basis[0].0;
        let b = basis.get(1).map_or([0, a[0]], |(way, _)| *way);
        let det = a[0] * b[1] - a[1] * b[0];
        let faces = 0..u32::try_from(self.raw.len()).unwrap_or(NONE);
        let places = faces.map(|face| {
            let place = self.place(face)?;
            let [x, y] = place.cell;
            // By the inverse of the matrix with columns a and b, whose determinant is 1 or -1.
            let cell = [det * (b[1] * x - b[0] * y), det * (a[0] * y - a[1] * x)];
            Some(Place { cell, ..place })
        });
        let places: Vec<Place> = places.collect::<Option<_>>()?;
        let (orbits, rows) = rows(&places, &self.representatives);
        Some(Lattice {
            steps,
            orbits,
            places,
            rows,
            tree: self.tree,
            loops: basis.into_iter().map(|(_, link)| link).collect(),
            deviation: self.sheet.deviation,
        })
    }
}

/// For each face its orbit, in the order of the first faces, and its cell relative to that face; and
/// the number of orbits.
fn orbits(faces: usize, steps: &[Step]) -> (Vec<Place>, usize) {
    let none = Place {
        orbit: NONE,
        cell: [0, 0],
    };
    let mut origins = vec![vec![NONE; faces]; steps.len()];
    for (origins, step) in origins.iter_mut().zip(steps) {
        for (face, &image) in (0..).zip(&step.images) {
            if image != NONE {
                origins[image as usize] = face;
            }
        }
    }
    let mut places = vec![none; faces];
    let mut open = VecDeque::new();
    let mut orbit = 0;
    for start in 0..faces {
        if places[start].orbit != NONE {
            continue;
        }
        places[start].orbit = orbit;
        open.push_back(start);
        while let Some(face) = open.pop_front() {
            let here = places[face];
            for (k, (step, origins)) in steps.iter().zip(&origins).enumerate() {
                for (to, by) in [(step.images[face], 1), (origins[face], -1)] {
                    if to != NONE && places[to as usize].orbit == NONE {
                        let mut place = here;
                        place.cell[k] += by;
                        places[to as usize] = place;
                        open.push_back(to as usize);
                    }
                }
            }
        }
        orbit += 1;
    }
    (places, orbit as usize)
}

/// The orbits, and for each row of cells of each of them its faces by their column.
fn rows(places: &[Place], representatives: &[FaceId]) -> (Vec<Orbit>, Ragged<(i32, FaceId)>) {
    let orbits = representatives.iter().map(|&representative| {
        let cell = places[representative.index()].cell;
        Orbit {
            representative,
            low: cell,
            high: cell,
            first_row: 0,
        }
    });
    let mut orbits: Vec<Orbit> = orbits.collect();
    for place in places {
        let orbit = &mut orbits[place.orbit as usize];
        for k in 0..2 {
            orbit.low[k] = orbit.low[k].min(place.cell[k]);
            orbit.high[k] = orbit.high[k].max(place.cell[k]);
        }
    }
    let mut count = 0;
    for orbit in &mut orbits {
        orbit.first_row = count;
        count += orbit.high[1].abs_diff(orbit.low[1]) + 1;
    }
    let keyed = places.iter().enumerate().map(|(face, place)| {
        let orbit = &orbits[place.orbit as usize];
        let row = orbit.first_row + place.cell[1].abs_diff(orbit.low[1]);
        (row as usize, (place.cell[0], FaceId::new(face)))
    });
    let mut rows = group_by_key(count as usize, &keyed.collect::<Vec<_>>());
    rows.sort_each();
    (orbits, rows)
}
