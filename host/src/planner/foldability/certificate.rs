//! Proves that creases cannot turn in a first step from flat, by multipliers of the conditions on the rates.
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

use super::flat_cone::{DRAWN_RAD, FlatConditions, STILL_RATIO, direction_errors, held_by_few};
use crate::pattern::{ClosureSite, CreasePattern};
use crate::util::union_find::UnionFind;

/// Largest number of creases that are judged. The slowest sheet of this size takes 0.3 s.
pub(crate) const MAX_CREASES: usize = 6_000;
/// Largest number of creases in all programs that judge the creases without sign one by one: about 0.2 s.
const MAX_UNSIGNED_WORK: usize = 4_000;
/// Largest number of creases without sign in a connected part of the sheet that is proved to be rigid: about 0.1 s.
const MAX_UNSIGNED: usize = 150;
/// Size below which a multiplier is an error of the program's solution. The multipliers that hold a crease are about 1.
const NEGLIGIBLE: f64 = 1e-6;
/// Rounding of a sum of products, as a fraction of the sum of their sizes.
const ROUNDING: f64 = 1e-12;

/// Creases that the conditions at some vertices and holes prove to be locked.
#[derive(Clone, Debug)]
pub(crate) struct Lock {
    /// The creases that cannot turn, in order.
    pub(crate) creases: Vec<usize>,
    /// The places of the conditions, the one with the largest multiplier first.
    pub(crate) sites: Vec<ClosureSite>,
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
        let mut locks = sheet.locks()?;
        sheet.judge_unsigned(&mut locks)?;
        Some(locks)
    }
}

/// Proves, if it can, that no motion leaves flat along the `signs` and turns one of the `asked` creases: each connected
/// part of the sheet with such a crease has no rates but 0. The proof holds although the directions of all creases may be
/// wrong by [`DRAWN_RAD`]. Returns the locks that make up the proof.
///
/// Rates are a proof for motions of any kind, because the first derivatives of the fold angles of an analytic motion
/// that are not all 0 are rates of the cone (curve selection lemma).
pub(crate) fn cannot_leave(
    pattern: &CreasePattern,
    signs: &[f64],
    asked: &[bool],
) -> Option<Vec<Lock>> {
    let errors = direction_errors(pattern);
    let errors = errors.iter().map(|error| error.max(DRAWN_RAD)).collect();
    let sheet = Sheet::new(pattern, signs, errors)?;
    let locks = sheet.locks()?;
    let mut parts = sheet.parts().into_iter();
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

    /// Returns the creases that are not held, in sets that share no condition.
    fn parts(&self) -> Vec<Vec<usize>> {
        let mut sets = UnionFind::new(self.held.len());
        let mut first = vec![None; self.conditions.sites.len()];
        let free = || (0..self.held.len()).filter(|&crease| !self.held[crease]);
        for crease in free() {
            for coefficient in &self.conditions.columns[crease] {
                let other = *first[coefficient.row as usize].get_or_insert(crease);
                sets.join([crease, other]);
            }
        }
        let mut parts = vec![Vec::new(); self.held.len()];
        for crease in free() {
            parts[sets.find(crease)].push(crease);
        }
        parts.retain(|part| !part.is_empty());
        parts
    }

    /// Finds the locked creases among those with a sign.
    fn locks(&self) -> Option<Locks> {
        let mut locks = Locks {
            locked: self.held.clone(),
            at_rest: self.held.clone(),
            proofs: Vec::new(),
        };
        let active: Vec<usize> = self.parts().concat();
        // Errors at the largest rate, 1 / STILL_RATIO, as long as the ratio is all that is asked; errors at rate 1 find
        // multipliers that prove more where the digits are few.
        for slack in [1.0 / STILL_RATIO, 1.0] {
            let rates = self
                .conditions
                .solve(&active, self.signs, &self.errors, slack)?;
            self.certify(&rates.multipliers, self.signs, &mut locks);
        }
        Some(locks)
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
                    let sites = cluster.sites.clone();
                    locks.proofs.push(Lock { creases, sites });
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
                    + ROUNDING * coefficient.value.abs());
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
        for part in self.parts() {
            let part: Vec<usize> = part.into_iter().filter(|&k| !locks.locked[k]).collect();
            let unsigned: Vec<usize> = part
                .iter()
                .copied()
                .filter(|&crease| !(self.signs[crease].abs() > 0.0))
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
                    let rates =
                        self.conditions
                            .solve(&part, &signs, &self.errors, 1.0 / STILL_RATIO)?;
                    self.certify(&rates.multipliers, &signs, &mut tried);
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
        let Some(rates) = self.conditions.solve(part, self.signs, &self.errors, 1.0) else {
            return false;
        };
        let sums = |&crease: &usize| self.sums(&rates.multipliers, self.signs, crease);
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
        Some(values.min() - wrong.sqrt() - ROUNDING * values.max())
    }
}

/// Returns the multiplier, or 0 if it is negligible.
fn significant(multiplier: f64) -> f64 {
    if multiplier.abs() < NEGLIGIBLE {
        0.0
    } else {
        multiplier
    }
}
