//! Proves that creases cannot turn in a first step from flat, by multipliers of the conditions on the rates, or on the
//! products of two rates.
//!
//! Let y be any multipliers of the conditions, and c_k = s_k (y · column of crease k) with the sign s_k of the crease.
//! Rates x of the cone satisfy Σ c_k |x_k| = 0. If all c_k are positive, no crease turns: this is Farkas' lemma. If
//! every direction may be wrong by the error of its digits, c_k may be less by e_k. With S = Σ max(0, e_k - c_k), and
//! |c_k| + e_k in place of it for a crease without sign, a crease with c_k > e_k turns at most S / (c_k - e_k) times as
//! fast as the fastest. `S = 0` proves that it does not turn at all, however the coordinates were rounded.
//!
//! The multipliers come from a linear program, but nothing depends on how well that was solved: the sums above are
//! computed here.

use nalgebra::DMatrix;

use super::flat_cone::{FlatConditions, STILL_RATIO, direction_errors, drawn_errors, held_by_few};
use super::locked_loop::{LockedLoop, locked_loops};
use super::products::{Products, has_foot};
use crate::pattern::{ClosureSite, CreasePattern, VertexId};
use crate::planner::reason::ProofOrder;
use crate::util::union_find::UnionFind;

/// Largest number of creases that are judged. Sheets of this size with random letters take 0.2 to 0.4 s.
pub(crate) const MAX_CREASES: usize = 3_000;
/// Largest number of creases in all programs that judge the creases without sign one by one: about 0.2 s.
const MAX_UNSIGNED_WORK: usize = 4_000;
/// Largest number of creases without sign in a connected part of the sheet that is proved to be rigid: about 0.1 s.
const MAX_UNSIGNED: usize = 150;
/// Largest number of creases whose conditions to second order are judged together: about 0.1 s.
const MAX_PRODUCT_CREASES: usize = 16;
/// Size below which a multiplier is an error of the program's solution. The multipliers that hold a crease are about 1.
const MIN_MULTIPLIER: f64 = 1e-6;
/// Rounding of a sum of products, as a fraction of the sum of their sizes.
const ROUNDING_RATIO: f64 = 1e-12;

/// Creases that the conditions at some vertices and holes prove to be locked.
#[derive(Clone, Debug)]
pub(crate) struct Lock {
    /// The creases that cannot turn, in order.
    pub(crate) creases: Vec<usize>,
    /// The places of the conditions, the one with the largest multiplier first.
    pub(crate) sites: Vec<ClosureSite>,
    /// The order of the conditions.
    pub(crate) order: ProofOrder,
}

/// The creases of a sheet that cannot turn in a first step from flat along given signs.
#[derive(Clone, Debug)]
pub(crate) struct Locks {
    /// For each crease `true` if it is locked.
    pub(crate) locked: Vec<bool>,
    /// For each crease `true` if its rate is proved to be exactly 0.
    at_rest: Vec<bool>,
    /// The proofs, other than vertices with fewer than four creases.
    pub(crate) proofs: Vec<Lock>,
}

impl Locks {
    /// Finds the creases that cannot turn, however the coordinates were rounded: each turns less than [`STILL_RATIO`]
    /// times as fast as the fastest, or not at all. Returns `None` if the sheet is too large.
    pub(crate) fn find(pattern: &CreasePattern, signs: &[f64]) -> Option<Self> {
        let sheet = Sheet::new(pattern, signs, direction_errors(pattern))?;
        let mut locks = sheet.locks(pattern)?;
        sheet.judge_unsigned(&mut locks)?;
        Some(locks)
    }

    /// Adds creases that the conditions at these vertices hold to second order.
    fn add_second_order(&mut self, vertices: &[VertexId], creases: Vec<usize>) {
        for &crease in &creases {
            self.locked[crease] = true;
            self.at_rest[crease] = true;
        }
        self.proofs.push(Lock {
            creases,
            sites: vertices.iter().copied().map(ClosureSite::Vertex).collect(),
            order: ProofOrder::Second,
        });
    }
}

/// Proves, if it can, that no motion leaves flat along the `signs` and turns one of the `asked` creases: each connected
/// part of the sheet with such a crease has no rates but 0. The proof holds although the directions of all creases may be
/// wrong by a milliradian. Returns the locks that make up the proof.
///
/// Rates are a proof for motions of any kind, because the first derivatives of the fold angles of an analytic motion
/// that are not all 0 are rates of the cone (curve selection lemma), and their products satisfy the conditions to second
/// order.
pub(crate) fn cannot_leave(
    pattern: &CreasePattern,
    signs: &[f64],
    asked: &[bool],
) -> Option<Vec<Lock>> {
    let sheet = Sheet::new(pattern, signs, drawn_errors(pattern))?;
    let locks = sheet.locks(pattern)?;
    let mut parts = sheet.parts(&sheet.held).into_iter();
    let is_asked = |part: &Vec<usize>| part.iter().any(|&crease| asked[crease]);
    parts
        .all(|part| !is_asked(&part) || sheet.is_rigid(&part, &locks))
        .then_some(locks.proofs)
}

/// The conditions of a sheet with the signs of its creases.
struct Sheet<'a> {
    conditions: FlatConditions,
    signs: &'a [f64],
    /// Largest error of the direction of each crease, radians.
    errors: Vec<f64>,
    /// Creases that a vertex with fewer than four creases holds at 0.
    held: Vec<bool>,
}

impl<'a> Sheet<'a> {
    fn new(pattern: &CreasePattern, signs: &'a [f64], errors: Vec<f64>) -> Option<Self> {
        (signs.len() <= MAX_CREASES).then(|| Self {
            conditions: FlatConditions::new(pattern),
            held: held_by_few(pattern, signs, &errors),
            signs,
            errors,
        })
    }

    /// Returns the creases that are not `held`, in sets that share no condition.
    fn parts(&self, held: &[bool]) -> Vec<Vec<usize>> {
        let mut sets = UnionFind::new(held.len());
        let mut first = vec![None; self.conditions.sites.len()];
        let free = || (0..held.len()).filter(|&crease| !held[crease]);
        for crease in free() {
            for coefficient in &self.conditions.columns[crease] {
                let other = *first[coefficient.row as usize].get_or_insert(crease);
                sets.join([crease, other]);
            }
        }
        let mut parts = vec![Vec::new(); held.len()];
        for crease in free() {
            parts[sets.find(crease)].push(crease);
        }
        parts.retain(|part| !part.is_empty());
        parts
    }

    /// Finds the locked creases among those with a sign.
    fn locks(&self, pattern: &CreasePattern) -> Option<Locks> {
        // Proofs to second order hang on how exactly a sheet is drawn.
        let errors = drawn_errors(pattern);
        let mut locks = self.first_order()?;
        let mut found = false;
        for LockedLoop {
            vertices, creases, ..
        } in locked_loops(pattern, self.signs, &errors, 0.0)
        {
            if creases.iter().any(|&crease| !locks.at_rest[crease]) {
                locks.add_second_order(&vertices, creases);
                found = true;
            }
        }
        found |= self.add_second_order(pattern, &errors, &mut locks);
        while found {
            self.add_first_order(&mut locks)?;
            found = self.add_second_order(pattern, &errors, &mut locks);
        }
        Some(locks)
    }

    /// Finds the creases with a sign that the conditions to first order lock.
    fn first_order(&self) -> Option<Locks> {
        let mut locks = Locks {
            locked: self.held.clone(),
            at_rest: self.held.clone(),
            proofs: Vec::new(),
        };
        self.add_first_order(&mut locks)?;
        Some(locks)
    }

    /// Adds the creases with a sign that the conditions to first order lock, given those that are locked.
    fn add_first_order(&self, locks: &mut Locks) -> Option<()> {
        let active: Vec<usize> = self.parts(&locks.at_rest).concat();
        // Errors at the largest rate that the ratio admits; errors at rate 1 find multipliers that prove more where the
        // digits are few.
        for slack in [1.0 / STILL_RATIO, 1.0] {
            let (_, multipliers) =
                self.conditions
                    .solve(&active, self.signs, &self.errors, slack)?;
            self.certify(&multipliers, self.signs, locks);
        }
        Some(())
    }

    /// Adds the creases that the conditions to second order hold, with these errors of directions (radians): first those of
    /// single vertices or, if there are none, those of small parts of the sheet. Returns `true` if there are any.
    fn add_second_order(&self, pattern: &CreasePattern, errors: &[f64], locks: &mut Locks) -> bool {
        let mut found = false;
        for vertex in pattern.real_vertices() {
            let star = pattern.stars()[vertex.index()].iter();
            let creases = star.filter_map(|&edge| pattern.edge(edge).crease);
            let moving = creases.map(|crease| crease.index());
            let moving: Vec<usize> = moving.filter(|&crease| !locks.at_rest[crease]).collect();
            if !has_foot(pattern, vertex, &moving, self.signs) {
                found |= self.hold_to_second_order(pattern, errors, &[vertex], moving, locks);
            }
        }
        if found {
            return true;
        }
        for part in self.parts(&locks.at_rest) {
            let ends = part
                .iter()
                .flat_map(|&crease| pattern.edge(pattern.creases()[crease]).ends);
            let mut vertices: Vec<VertexId> = ends.filter(|&end| pattern.is_real(end)).collect();
            vertices.sort_unstable();
            vertices.dedup();
            found |= self.hold_to_second_order(pattern, errors, &vertices, part, locks);
        }
        found
    }

    /// Adds these creases to the locks if the conditions at the vertices hold them to second order. Returns `true` if so.
    fn hold_to_second_order(
        &self,
        pattern: &CreasePattern,
        errors: &[f64],
        vertices: &[VertexId],
        creases: Vec<usize>,
        locks: &mut Locks,
    ) -> bool {
        let is_signed = |&crease: &usize| self.signs[crease].abs() > 0.0;
        if !(1..=MAX_PRODUCT_CREASES).contains(&creases.len()) || !creases.iter().all(is_signed) {
            return false;
        }
        let products = Products::new(pattern, &self.conditions, vertices, &creases);
        let sign = |&[a, b]: &[usize; 2]| self.signs[a] * self.signs[b];
        let signs: Vec<f64> = products.pairs.iter().map(sign).collect();
        let error = |&[a, b]: &[usize; 2]| errors[a] + errors[b];
        let sheet = Sheet {
            held: vec![false; signs.len()],
            errors: products.pairs.iter().map(error).collect(),
            signs: &signs,
            conditions: products.conditions,
        };
        let all: Vec<usize> = (0..signs.len()).collect();
        let solved = sheet.conditions.solve(&all, &signs, &sheet.errors, 1.0);
        let Some((_, multipliers)) = solved else {
            return false;
        };
        let is_held = |(pair, &[a, b]): (usize, &[usize; 2])| {
            let (c, e) = sheet.sums(&multipliers, &signs, pair);
            c > e || a != b && c >= e
        };
        if !products.pairs.iter().enumerate().all(is_held) {
            return false;
        }
        locks.add_second_order(vertices, creases);
        true
    }

    /// Adds the creases that these multipliers prove to be locked, first those that do not turn at all.
    fn certify(&self, multipliers: &[f64], signs: &[f64], locks: &mut Locks) {
        let clusters = self.clusters(multipliers);
        loop {
            let mut found = false;
            for cluster in &clusters {
                let moving = cluster.creases.iter().filter(|&&k| !locks.at_rest[k]);
                let moving: Vec<(usize, f64, f64)> = moving
                    .map(|&k| {
                        let (c, e) = self.sums(multipliers, signs, k);
                        (k, c, e)
                    })
                    .collect();
                let is_signed = |k: usize| signs[k].abs() > 0.0;
                let against = moving.iter().map(|&(k, c, e)| {
                    if is_signed(k) {
                        (e - c).max(0.0)
                    } else {
                        c.abs() + e
                    }
                });
                let against: f64 = against.sum();
                let mut creases = Vec::new();
                for &(k, c, e) in &moving {
                    if !is_signed(k) || c <= e || against > STILL_RATIO * (c - e) {
                        continue;
                    }
                    if against <= 0.0 {
                        locks.at_rest[k] = true;
                        found = true;
                    }
                    if !core::mem::replace(&mut locks.locked[k], true) {
                        creases.push(k);
                    }
                }
                if !creases.is_empty() {
                    locks.proofs.push(Lock {
                        creases,
                        ..cluster.clone()
                    });
                }
            }
            if !found {
                break;
            }
        }
    }

    /// Returns c and e of a crease.
    fn sums(&self, multipliers: &[f64], signs: &[f64], crease: usize) -> (f64, f64) {
        let sign = if signs[crease].abs() > 0.0 {
            signs[crease]
        } else {
            1.0
        };
        let mut sums = (0.0, 0.0);
        for coefficient in &self.conditions.columns[crease] {
            let y = significant(multipliers[coefficient.row as usize]);
            sums.0 += sign * y * coefficient.value;
            sums.1 += y.abs()
                * (coefficient.sensitivity * self.errors[crease]
                    + ROUNDING_RATIO * coefficient.value.abs());
        }
        sums
    }

    /// Returns the conditions whose multipliers are not negligible, and the creases in them, in sets that share no
    /// crease: each set is a proof of its own.
    fn clusters(&self, multipliers: &[f64]) -> Vec<Lock> {
        let rows = self.conditions.sites.len();
        let mut sets = UnionFind::new(rows);
        let held = |row: u32| significant(multipliers[row as usize]).abs() > 0.0;
        let active = || (0..self.held.len()).filter(|&crease| !self.held[crease]);
        let rows_of = |crease: usize| {
            let column = self.conditions.columns[crease].iter();
            column
                .map(|c| c.row)
                .filter(|&row| held(row))
                .map(|row| row as usize)
        };
        for crease in active() {
            let mut rows = rows_of(crease);
            if let Some(first) = rows.next() {
                rows.for_each(|row| sets.join_to_smaller([first, row]));
            }
        }
        let mut clusters: Vec<(f64, Lock)> = Vec::new();
        let mut numbers = vec![None; rows];
        for crease in active() {
            if let Some(row) = rows_of(crease).next() {
                let number = *numbers[sets.find(row)].get_or_insert_with(|| {
                    let empty = Lock {
                        creases: Vec::new(),
                        sites: Vec::new(),
                        order: ProofOrder::First,
                    };
                    clusters.push((0.0, empty));
                    clusters.len() - 1
                });
                clusters[number].1.creases.push(crease);
            }
        }
        for row in 0..rows {
            let Some(number) = numbers[sets.find(row)] else {
                continue;
            };
            let size = significant(multipliers[row]).abs();
            let (largest, cluster) = &mut clusters[number];
            let site = self.conditions.sites[row];
            let known = cluster.sites.iter().position(|&known| known == site);
            if size > 0.0 && known.is_none() {
                cluster.sites.push(site);
            }
            if size > *largest {
                *largest = size;
                let place = known.unwrap_or(cluster.sites.len() - 1);
                cluster.sites.swap(0, place);
            }
        }
        clusters.into_iter().map(|(_, cluster)| cluster).collect()
    }

    /// Adds the creases without sign that are locked: those that turn neither way.
    fn judge_unsigned(&self, locks: &mut Locks) -> Option<()> {
        let mut work = 0;
        for part in self.parts(&self.held) {
            // Creases that are only slow remain in the sums of the proof, and therefore in the program.
            let part: Vec<usize> = part.into_iter().filter(|&k| !locks.at_rest[k]).collect();
            let unsigned: Vec<usize> = part
                .iter()
                .copied()
                .filter(|&crease| self.signs[crease].abs() <= 0.0)
                .collect();
            work += 2 * unsigned.len() * part.len();
            if work > MAX_UNSIGNED_WORK {
                break;
            }
            for crease in unsigned {
                let still = |sign: f64| {
                    let mut signs = self.signs.to_vec();
                    signs[crease] = sign;
                    let mut tried = locks.clone();
                    let (_, multipliers) =
                        self.conditions
                            .solve(&part, &signs, &self.errors, 1.0 / STILL_RATIO)?;
                    self.certify(&multipliers, &signs, &mut tried);
                    Some(tried.locked[crease])
                };
                if still(1.0)? && still(-1.0)? {
                    locks.locked[crease] = true;
                }
            }
        }
        Some(())
    }

    /// Returns `true` if a part of the sheet has no rates but 0, however the directions are wrong by their errors.
    ///
    /// Creases with a sign are held by the multipliers y, and those without sign by their columns, which have to be
    /// independent: |x_f| ≤ |A_s x_s| / σ with the least singular value σ of these columns. Both together exclude all
    /// rates if min (c_k - e_k) of the creases with sign exceeds √n max (|c_f| + e_f) · (length of a column) / σ over the
    /// n creases without.
    fn is_rigid(&self, part: &[usize], locks: &Locks) -> bool {
        let is_signed = |crease: &usize| self.signs[*crease].abs() > 0.0;
        let (signed, unsigned): (Vec<usize>, Vec<usize>) = part.iter().partition(|k| is_signed(k));
        if unsigned.is_empty() {
            return signed.iter().all(|&crease| locks.at_rest[crease]);
        }
        let Some(least) = self
            .least_singular_value(&unsigned)
            .filter(|least| *least > 0.0)
        else {
            return false;
        };
        if signed.is_empty() {
            return true;
        }
        let solved = self.conditions.solve(part, self.signs, &self.errors, 1.0);
        let Some((_, multipliers)) = solved else {
            return false;
        };
        let sums = |&crease: &usize| self.sums(&multipliers, self.signs, crease);
        let held = signed.iter().map(sums).map(|(c, e)| c - e);
        let pushed = unsigned.iter().map(sums).map(|(c, e)| c.abs() + e);
        let length = |&crease: &usize| {
            let column = self.conditions.columns[crease].iter();
            let wrong = |c: &super::flat_cone::Coefficient| c.sensitivity * self.errors[crease];
            column
                .map(|c| (c.value.abs() + wrong(c)).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let longest = signed.iter().map(length).fold(0.0, f64::max);
        #[allow(clippy::cast_precision_loss, reason = "at most MAX_UNSIGNED")]
        let count = (unsigned.len() as f64).sqrt();
        let leaks = count * pushed.fold(0.0, f64::max) * longest / least;
        held.fold(f64::INFINITY, f64::min) > leaks
    }

    /// Returns a lower bound of the least singular value of the columns of these creases, less their errors. Returns
    /// `None` if there are too many.
    fn least_singular_value(&self, creases: &[usize]) -> Option<f64> {
        if creases.len() > MAX_UNSIGNED {
            return None;
        }
        let mut rows: Vec<u32> = creases
            .iter()
            .flat_map(|&crease| self.conditions.columns[crease].iter().map(|c| c.row))
            .collect();
        rows.sort_unstable();
        rows.dedup();
        if rows.len() < creases.len() {
            return None;
        }
        let mut matrix = DMatrix::zeros(rows.len(), creases.len());
        let mut wrong = 0.0;
        for (column, &crease) in creases.iter().enumerate() {
            for coefficient in &self.conditions.columns[crease] {
                let row = rows.binary_search(&coefficient.row).ok()?;
                matrix[(row, column)] = coefficient.value;
                wrong += (coefficient.sensitivity * self.errors[crease]).powi(2);
            }
        }
        let values = matrix.singular_values();
        Some(values.min() - wrong.sqrt() - ROUNDING_RATIO * values.max())
    }
}

/// Returns the multiplier, or 0 if it is negligible.
fn significant(multiplier: f64) -> f64 {
    if multiplier.abs() < MIN_MULTIPLIER {
        0.0
    } else {
        multiplier
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use nalgebra::{DVector, Vector2};
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::Rng;

    use super::super::flat_cone::{MAX_RATE, MIN_SLACK};
    use super::*;
    use crate::pattern::{Drawing, DrawnEdge, Letter};

    fn random(rng: &mut Pcg64) -> f64 {
        f64::from(rng.next_u32()) / f64::from(u32::MAX)
    }

    /// Makes a grid of squares or triangles with moved inner vertices, random letters and some creases without.
    fn sheet(cells: usize, rng: &mut Pcg64, unsigned: f64, diagonals: bool) -> CreasePattern {
        let side = cells + 1;
        let is_inner = |k: usize| (1..cells).contains(&k);
        let mut vertices = Vec::new();
        for k in 0..side * side {
            #[allow(clippy::cast_precision_loss, reason = "a small grid")]
            let [x, y] = [k % side, k / side].map(|k| k as f64);
            let moved = if is_inner(k % side) && is_inner(k / side) {
                0.3
            } else {
                0.0
            };
            let mut shift = || moved * (random(rng) - 0.5);
            vertices.push(Vector2::new(x + shift(), y + shift()));
        }
        let mut edges = Vec::new();
        for k in 0..side * side {
            let (column, row) = (k % side, k / side);
            let mut edge = |to: usize, border: bool| {
                let letter = match random(rng) {
                    _ if border => Letter::Boundary,
                    at if at < unsigned => Letter::Unassigned,
                    at if at < unsigned + 0.5 * (1.0 - unsigned) => Letter::Mountain,
                    _ => Letter::Valley,
                };
                edges.push(DrawnEdge {
                    ends: [k, to],
                    letter,
                    goal: None,
                });
            };
            if column < cells {
                edge(k + 1, row == 0 || row == cells);
            }
            if row < cells {
                edge(k + side, column == 0 || column == cells);
            }
            if column < cells && row < cells && diagonals {
                edge(k + side + 1, false);
            }
        }
        CreasePattern::new(Drawing {
            vertices,
            edges,
            faces: None,
        })
        .unwrap()
    }

    /// Returns the conditions at the real vertices by a second formula: the angles of the creases.
    fn matrix(pattern: &CreasePattern) -> DMatrix<f64> {
        let real: Vec<_> = pattern.real_vertices().collect();
        let mut matrix = DMatrix::zeros(2 * real.len(), pattern.creases().len());
        for (k, vertex) in real.iter().enumerate() {
            for (crease, &edge) in pattern.creases().iter().enumerate() {
                let [a, b] = pattern.edge(edge).ends;
                let other = match *vertex {
                    v if v == a => b,
                    v if v == b => a,
                    _ => continue,
                };
                let way = pattern.vertices()[other.index()] - pattern.vertices()[vertex.index()];
                let angle = way.y.atan2(way.x);
                matrix[(2 * k, crease)] = angle.cos();
                matrix[(2 * k + 1, crease)] = angle.sin();
            }
        }
        matrix
    }

    /// Returns the distance of `target` from the cone of the columns (Lawson and Hanson 1974, algorithm NNLS).
    fn distance_from_cone(columns: &DMatrix<f64>, target: &DVector<f64>) -> f64 {
        let n = columns.ncols();
        let mut x = DVector::<f64>::zeros(n);
        let mut free: Vec<usize> = Vec::new();
        for _ in 0..10 * n {
            let rest = target - columns * &x;
            let gradient = columns.transpose() * &rest;
            let outside = (0..n).filter(|k| !free.contains(k));
            let Some(best) = outside.max_by(|&a, &b| gradient[a].total_cmp(&gradient[b])) else {
                break;
            };
            if gradient[best] < 1e-9 {
                break;
            }
            free.push(best);
            loop {
                let part = columns.select_columns(&free);
                let solved = part.svd(true, true).solve(target, 1e-12).unwrap();
                let mut step: f64 = 1.0;
                for (k, &column) in free.iter().enumerate() {
                    if solved[k] <= 0.0 {
                        step = step.min(x[column] / (x[column] - solved[k]));
                    }
                }
                for (k, &column) in free.iter().enumerate() {
                    x[column] += step * (solved[k] - x[column]);
                }
                if step >= 1.0 {
                    break;
                }
                free.retain(|&column| x[column] > 1e-12);
                for column in 0..n {
                    if !free.contains(&column) {
                        x[column] = 0.0;
                    }
                }
            }
        }
        (target - columns * x).norm()
    }

    /// Returns `true` if a crease has a rate of this sign in some rates of the cone: if the opposite of its column is in
    /// the cone of the others.
    fn turns(matrix: &DMatrix<f64>, signs: &[f64], crease: usize, sign: f64) -> bool {
        let mut columns = Vec::new();
        for (k, own) in signs.iter().enumerate().filter(|(k, _)| *k != crease) {
            for way in [1.0, -1.0] {
                if own * way >= 0.0 {
                    columns.push(matrix.column(k) * way);
                }
            }
        }
        let target = matrix.column(crease) * -sign;
        distance_from_cone(&DMatrix::from_columns(&columns), &target) < 1e-6
    }

    /// On random sheets, the creases said to be locked are those that another method finds, and the rates of the program
    /// satisfy the conditions, have the right signs and turn all other creases.
    #[test]
    fn locked_creases_are_those_that_another_method_finds() {
        let rng = &mut Pcg64::new(1, 0);
        let [mut locked, mut turning, mut unsigned_locked, mut missed] = [0; 4];
        for round in 0..60 {
            let unsigned = [0.0, 0.15, 0.3][round % 3];
            let pattern = sheet(2 + round % 4, rng, unsigned, round % 2 == 0);
            let signs: Vec<f64> = pattern
                .creases()
                .iter()
                .map(|&edge| pattern.edge(edge).letter.sign())
                .collect();
            let matrix = matrix(&pattern);
            let sheet = Sheet::new(&pattern, &signs, direction_errors(&pattern)).unwrap();
            let mut locks = sheet.first_order().unwrap();
            sheet.judge_unsigned(&mut locks).unwrap();
            for (crease, &is_locked) in locks.locked.iter().enumerate() {
                let ways = [1.0, -1.0]
                    .into_iter()
                    .filter(|way| way * signs[crease] >= 0.0);
                let mut expected = ways.map(|way| turns(&matrix, &signs, crease, way));
                let expected = !expected.any(|turns| turns);
                assert!(expected || !is_locked, "round {round}, crease {crease}");
                missed += usize::from(expected && !is_locked);
                locked += usize::from(is_locked);
                turning += usize::from(!is_locked);
                unsigned_locked += usize::from(is_locked && signs[crease] == 0.0);
            }
            let conditions = FlatConditions::new(&pattern);
            let all: Vec<usize> = (0..signs.len()).collect();
            let errors = direction_errors(&pattern);
            let (rates, _) = conditions
                .solve(&all, &signs, &errors, 1.0 / STILL_RATIO)
                .unwrap();
            for (crease, rate) in rates.iter().enumerate() {
                let along = rate * signs[crease];
                assert!(along >= 0.0 && rate.abs() <= MAX_RATE + 1.0);
                let signed = signs[crease] != 0.0;
                assert!(!signed || along < 0.9 || !locks.locked[crease], "{rate}");
            }
            let open = (&matrix * DVector::from_vec(rates)).amax();
            assert!(open < 1.01 * MIN_SLACK, "round {round}: {open}");
        }
        assert!(
            locked > 200 && turning > 200 && unsigned_locked > 10,
            "{locked} {turning} {unsigned_locked}"
        );
        // A proof is missed if it needs multipliers of a thousand, as nearly dependent conditions do.
        assert!(missed < locked / 20, "{missed} of {locked}");
    }

    /// A proof that nothing leaves flat holds for every sheet whose vertices are moved by less than the proof allows.
    #[test]
    fn proofs_hold_for_moved_vertices() {
        let rng = &mut Pcg64::new(2, 0);
        let mut proved = 0;
        for round in 0..200 {
            let pattern = sheet(2 + round % 3, rng, [0.0, 0.1][round % 2], false);
            let letters = pattern
                .creases()
                .iter()
                .map(|&edge| pattern.edge(edge).letter);
            let signs: Vec<f64> = letters.map(Letter::sign).collect();
            let asked: Vec<bool> = signs.iter().map(|sign| *sign != 0.0).collect();
            let proofs = cannot_leave(&pattern, &signs, &asked);
            let is_first = |proofs: &Vec<Lock>| {
                let mut orders = proofs.iter().map(|lock| lock.order);
                orders.all(|order| order == ProofOrder::First)
            };
            if !proofs.is_some_and(|proofs| is_first(&proofs)) {
                continue;
            }
            proved += 1;
            let moved = pattern.vertices().iter().map(|at| {
                let mut shift = || 5e-4 * (random(rng) - 0.5);
                at + Vector2::new(shift(), shift())
            });
            let edges = pattern.edges().iter().map(|edge| DrawnEdge {
                ends: edge.ends.map(|end| end.index()),
                letter: edge.letter,
                goal: None,
            });
            let drawing = Drawing {
                vertices: moved.collect(),
                edges: edges.collect(),
                faces: None,
            };
            let matrix = matrix(&CreasePattern::new(drawing).unwrap());
            for crease in 0..signs.len() {
                for way in [1.0, -1.0]
                    .into_iter()
                    .filter(|way| way * signs[crease] >= 0.0)
                {
                    assert!(
                        !turns(&matrix, &signs, crease, way),
                        "round {round}, crease {crease}"
                    );
                }
            }
        }
        assert!(proved > 10, "{proved} proofs");
    }

    /// The distance from a cone of two directions has a closed form.
    #[test]
    fn the_other_method_finds_distances() {
        let columns = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 0.0, 1.0]);
        for (angle, expected) in [
            (0.3, 0.0),
            (PI / 4.0, 0.0),
            (PI / 2.0, 0.5_f64.sqrt()),
            (PI, 1.0),
            (-0.5, 0.5_f64.sin()),
        ] {
            let target = DVector::from_vec(vec![f64::cos(angle), f64::sin(angle)]);
            let found = distance_from_cone(&columns, &target);
            assert!((found - expected).abs() < 1e-9, "{angle}: {found}");
        }
    }
}
