//! Finds the lattice of a tessellation: translations of the flat sheet under which all hinges turn alike.

use std::collections::VecDeque;

use foldpath_core::Membership;
use nalgebra::Vector2;

use super::steps::{CENTRE, NONE, Sheet, Step};
use crate::pattern::{CreasePattern, EdgeId, FaceId};
use crate::ragged::{Ragged, group_by_key};

/// The lattice of a sheet. It gives each face a place: an *orbit* under the translations, and a lattice *cell*.
///
/// # Why one face of each orbit stands for all
///
/// A *step* is a translation by t. Let the faces A = F₀, F₁, … Fₖ = B follow each other across hinges, and let the step
/// take each of these faces to a face of the sheet, and each of these hinges to a hinge of the same group and sign, or
/// a side that stays flat to such a side. The pose of B relative to A is the product of the turns about the hinges. The
/// images of the hinges turn by the same angles, about lines moved by t. So B + t moves relative to A + t as B does
/// relative to A, for any group angles. In other words: let `pose` take flat points to folded points; then the rigid
/// motion S that takes pose(A)(x) to pose(A + t)(x + t) is the same for all faces that such chains join. Nothing else
/// is required of the step: faces without an image, and parts of the sheet that no chain joins, may move otherwise, and
/// they have orbits of their own. There is one exception: if two faces of one orbit are joined by corresponding hinges
/// to a face X at the border and to a face Y, then X moves as Y does and belongs to the orbit of Y.
///
/// With two steps, some face A has its images A + t₁, A + t₂ and A + t₁ + t₂ in the sheet. Wherever the sheet closes,
/// the two paths to A + t₁ + t₂ show that S₁ and S₂ commute. So any path from a face to its image along steps gives
/// pose(A + i t₁ + j t₂)(x + i t₁ + j t₂) = S₁ⁱ S₂ʲ pose(A)(x), and pairs of faces of the same orbits and the same
/// difference of cells move alike. Other paths between cells may lead through places without a face: the formula holds
/// for the hinges there all the same.
///
/// Holes do not matter, because the sheet closes round them as well. These statements are exact for exact coordinates.
/// For other coordinates they hold to about [`deviation`](Self::deviation) times the square of the number of cells.
#[derive(Clone, Debug)]
pub struct Lattice {
    steps: Vec<Vector2<f64>>,
    orbits: Vec<Orbit>,
    places: Vec<Place>,
    /// For each row of cells of each orbit the faces of the row, sorted by column.
    rows: Ragged<(i32, FaceId)>,
    tree: Vec<Link>,
    loops: Vec<Link>,
    deviation: f64,
}

/// Position of a face in the lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The face's orbit.
    pub orbit: u32,
    /// The face's cell, counted in steps; the second number is 0 if there is only one step.
    pub cell: [i32; 2],
}

/// A class of faces that steps take to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Orbit {
    /// A face of the orbit, as near to the middle of the sheet as any.
    pub representative: FaceId,
    /// Smallest coordinates of the orbit's cells.
    pub low: [i32; 2],
    /// Largest coordinates of the orbit's cells.
    pub high: [i32; 2],
    /// Index of the orbit's first row in the list of rows.
    first_row: u32,
}

/// Two adjacent faces and the edge between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// The face that the path leaves.
    pub from: FaceId,
    /// The face that the path enters.
    pub to: FaceId,
    /// The edge between the two faces.
    pub edge: EdgeId,
}

impl Lattice {
    /// Finds the lattice of a single sheet with these crease groups. Returns `None` if no step is found that leaves at
    /// most half as many orbits as faces, or if there are several sheets. Cost: about linear.
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

    /// Returns the one or two steps, which lead to the cells [1, 0] and [0, 1].
    #[must_use]
    pub fn steps(&self) -> &[Vector2<f64>] {
        &self.steps
    }

    /// Returns the orbits; [`Place::orbit`] is an index into this list.
    #[must_use]
    pub fn orbits(&self) -> &[Orbit] {
        &self.orbits
    }

    /// Returns the place of each face.
    #[must_use]
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// Returns the place of a face.
    #[must_use]
    pub fn place(&self, face: FaceId) -> Place {
        self.places[face.index()]
    }

    /// Returns the face of an orbit in a cell, if the sheet has it. Cost: logarithmic.
    #[must_use]
    pub fn face_at(&self, place: Place) -> Option<FaceId> {
        let orbit = self.orbits.get(place.orbit as usize)?;
        let [column, row] = place.cell;
        let row = self.row(orbit, row);
        let at = row.binary_search_by_key(&column, |&(column, _)| column);
        at.ok().map(|at| row[at].1)
    }

    /// Returns the faces of an orbit in a row of cells, with their columns in increasing order.
    pub(super) fn row(&self, orbit: &Orbit, row: i32) -> &[(i32, FaceId)] {
        if row < orbit.low[1] || row > orbit.high[1] {
            return &[];
        }
        &self.rows[orbit.first_row as usize + row.abs_diff(orbit.low[1]) as usize]
    }

    /// Returns the translation from cell [0, 0] to this cell in the flat sheet.
    #[must_use]
    pub fn translation(&self, cell: [i32; 2]) -> Vector2<f64> {
        shift(&self.steps, cell)
    }

    /// Returns links that lead to the second and every further orbit from an earlier orbit, within one cell.
    #[must_use]
    pub fn tree(&self) -> &[Link] {
        &self.tree
    }

    /// Returns for each step a link that leads from one cell to the cell one step on.
    #[must_use]
    pub fn loops(&self) -> &[Link] {
        &self.loops
    }

    /// Returns a bound, in median edges, on the distance of a face from its position by the lattice, as seen from any
    /// other face, if all stars close to within `closure` (norm of the residual). The bound is infinite if the sheet
    /// has holes.
    ///
    /// Two paths between the faces, one along a spanning tree and one along the steps of the lattice, enclose at most
    /// the vertices that fit in the bounding box of the cells. Each enclosed vertex turns the part beyond it by its
    /// residual.
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

    /// Returns the largest distance, in the units of the flat sheet, between a corner moved by a step and the corner
    /// that counts as its image.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        self.deviation
    }
}

/// Returns `true` if some face has both images and their common image.
fn meet(first: &Step, second: &Step) -> bool {
    let image = |step: &Step, face: u32| step.images.get(face as usize).copied().unwrap_or(NONE);
    let mut pairs = first.images.iter().zip(&second.images);
    pairs.any(|(&a, &b)| {
        let common = image(second, a);
        common != NONE && common == image(first, b)
    })
}

/// Returns the sum of `counts[0]` times the first step and `counts[1]` times the second.
fn shift(steps: &[Vector2<f64>], counts: [i32; 2]) -> Vector2<f64> {
    let parts = steps.iter().zip(counts);
    parts.map(|(step, count)| step * f64::from(count)).sum()
}

/// Returns the difference of two cells.
fn minus(a: [i32; 2], b: [i32; 2]) -> [i32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// Orbits and cells under construction.
struct Survey<'a> {
    sheet: &'a Sheet<'a>,
    /// For each face its raw orbit, numbered in the order of the orbits' first faces, and its cell relative to that
    /// first face.
    raw: Vec<Place>,
    /// For each raw orbit its final number, in the order of the walk, and the raw cell that becomes [0, 0].
    known: Vec<Option<Place>>,
    shifts: Vec<Vector2<f64>>,
    representatives: Vec<FaceId>,
    tree: Vec<Link>,
    /// For each orbit the tree links that lead on from it.
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

    /// Returns the final orbit and cell of a face, once its orbit is known.
    fn place(&self, face: u32) -> Option<Place> {
        let raw = self.raw[face as usize];
        let known = self.known[raw.orbit as usize]?;
        Some(Place {
            orbit: known.orbit,
            cell: minus(raw.cell, known.cell),
        })
    }

    /// Walks breadth-first from face to face until all orbits are known and the links to other cells contain a basis.
    /// The cells of each orbit are shifted such that the walk enters the orbit without leaving the cell.
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

    /// Gives a number to the raw orbit of the face that a link leads to. The raw orbit may continue a known orbit:
    /// faces cut at a border have images along the border, even if a single step leads to none of them.
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

    /// Returns the shortest links found whose differences of cells generate all cells.
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

    /// Makes the lattice whose steps are the differences of cells of the basis.
    fn into_lattice(self) -> Option<Lattice> {
        let mut basis = self.basis()?;
        let mut steps = Vec::new();
        for (way, link) in &mut basis {
            let mut step = shift(&self.shifts, *way);
            // A step and its opposite are equivalent; the one kept leads up or, if level, to the right.
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
            // Multiplies by the inverse of the matrix with columns a and b, whose determinant is 1 or -1.
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

/// Returns the raw orbit and cell of each face, and the number of raw orbits. Orbits are numbered in the order of their
/// first faces, and cells are relative to these.
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

/// Returns the orbits, and for each row of cells of each orbit the faces of the row, sorted by column.
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
