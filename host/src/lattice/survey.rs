//! Finds the lattice of a sheet: takes the steps that [`translations`](super::translations) finds, walks from face to
//! face, and gives each face its orbit and cell.

use std::collections::VecDeque;

use foldpath_core::Membership;
use nalgebra::Vector2;

use super::orbits::{Lattice, LatticeCoord, Link, Orbit, shift};
use super::translations::{CENTRE, FaceAdjacency, NONE, Step};
use crate::pattern::{CreasePattern, FaceId};
use crate::util::csr::{Csr, group_by_key};

/// Ratio of the height to the length of a step up to which the step counts as level.
const LEVEL_RATIO: f64 = 1e-9;

impl Lattice {
    /// Finds the lattice of a single sheet with these crease groups. Returns `None` if no step is found that leaves at
    /// most half as many orbits as faces, or if there are several sheets. Cost: about linear.
    #[must_use]
    pub fn find(pattern: &CreasePattern, memberships: &[Membership]) -> Option<Self> {
        if pattern.sheets() != 1 {
            return None;
        }
        let mut sheet = FaceAdjacency::new(pattern, memberships)?;
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
        (2 * lattice.orbits.len() <= lattice.coords.len()).then_some(lattice)
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

/// Returns the difference of two cells.
fn minus(a: [i32; 2], b: [i32; 2]) -> [i32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// Orbits and cells under construction.
struct Survey<'a> {
    sheet: &'a FaceAdjacency<'a>,
    /// For each face its raw orbit, numbered in the order of the orbits' first faces, and its cell relative to that
    /// first face.
    raw: Vec<LatticeCoord>,
    /// For each raw orbit its final number, in the order of the walk, and the raw cell that becomes [0, 0].
    known: Vec<Option<LatticeCoord>>,
    shifts: Vec<Vector2<f64>>,
    representatives: Vec<FaceId>,
    tree: Vec<Link>,
    /// For each orbit the tree links that lead on from it.
    ways_on: Vec<Vec<Link>>,
    /// Links that lead to other cells, one for each difference of cells.
    loops: Vec<([i32; 2], Link)>,
}

impl<'a> Survey<'a> {
    fn new(sheet: &'a FaceAdjacency<'a>, steps: &[Step]) -> Self {
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
    fn coord(&self, face: u32) -> Option<LatticeCoord> {
        let raw = self.raw[face as usize];
        let known = self.known[raw.orbit as usize]?;
        Some(LatticeCoord {
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
            let Some(here) = self.coord(from) else {
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
                match self.coord(side.face) {
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
                Some((self.coord(side.face)?, link))
            })
            .collect();
        for &(here, link) in &links {
            for &before in &self.ways_on[here.orbit as usize] {
                let coords = [before.from, before.to].map(|face| self.coord(face.0));
                let [Some(from), Some(to)] = coords else {
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
        let here = self.coord(link.from.0).unwrap_or_default();
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
        self.known[raw.orbit as usize] = Some(LatticeCoord {
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
            let level = step.y.abs() <= LEVEL_RATIO * step.norm();
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
        let coords = faces.map(|face| {
            let coord = self.coord(face)?;
            let [x, y] = coord.cell;
            // Multiplies by the inverse of the matrix with columns a and b, whose determinant is 1 or -1.
            let cell = [det * (b[1] * x - b[0] * y), det * (a[0] * y - a[1] * x)];
            Some(LatticeCoord { cell, ..coord })
        });
        let coords: Vec<LatticeCoord> = coords.collect::<Option<_>>()?;
        let (orbits, rows) = rows(&coords, &self.representatives);
        Some(Lattice {
            steps,
            orbits,
            coords,
            rows,
            tree: self.tree,
            loops: basis.into_iter().map(|(_, link)| link).collect(),
        })
    }
}

/// Returns the raw orbit and cell of each face, and the number of raw orbits. Orbits are numbered in the order of their
/// first faces, and cells are relative to these.
fn orbits(faces: usize, steps: &[Step]) -> (Vec<LatticeCoord>, usize) {
    let none = LatticeCoord {
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
    let mut coords = vec![none; faces];
    let mut open = VecDeque::new();
    let mut orbit = 0;
    for start in 0..faces {
        if coords[start].orbit != NONE {
            continue;
        }
        coords[start].orbit = orbit;
        open.push_back(start);
        while let Some(face) = open.pop_front() {
            let here = coords[face];
            for (k, (step, origins)) in steps.iter().zip(&origins).enumerate() {
                for (to, by) in [(step.images[face], 1), (origins[face], -1)] {
                    if to != NONE && coords[to as usize].orbit == NONE {
                        let mut coord = here;
                        coord.cell[k] += by;
                        coords[to as usize] = coord;
                        open.push_back(to as usize);
                    }
                }
            }
        }
        orbit += 1;
    }
    (coords, orbit as usize)
}

/// Returns the orbits, and for each row of cells of each orbit the faces of the row, sorted by column.
fn rows(coords: &[LatticeCoord], representatives: &[FaceId]) -> (Vec<Orbit>, Csr<(i32, FaceId)>) {
    let orbits = representatives.iter().map(|&representative| {
        let cell = coords[representative.index()].cell;
        Orbit {
            representative,
            low: cell,
            high: cell,
            first_row: 0,
        }
    });
    let mut orbits: Vec<Orbit> = orbits.collect();
    for coord in coords {
        let orbit = &mut orbits[coord.orbit as usize];
        for k in 0..2 {
            orbit.low[k] = orbit.low[k].min(coord.cell[k]);
            orbit.high[k] = orbit.high[k].max(coord.cell[k]);
        }
    }
    let mut count = 0;
    for orbit in &mut orbits {
        orbit.first_row = count;
        count += orbit.high[1].abs_diff(orbit.low[1]) + 1;
    }
    let keyed = coords.iter().enumerate().map(|(face, coord)| {
        let orbit = &orbits[coord.orbit as usize];
        let row = orbit.first_row + coord.cell[1].abs_diff(orbit.low[1]);
        (row as usize, (coord.cell[0], FaceId::new(face)))
    });
    let mut rows = group_by_key(count as usize, &keyed.collect::<Vec<_>>());
    rows.sort_each();
    (orbits, rows)
}
