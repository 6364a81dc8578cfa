//! Errors of core's closure and solvers at one vertex, against the reference.

use core::fmt::Write;

use foldpath_core::least_squares::{ClosureProblem, Limits, Options, Outcome};
use foldpath_core::{
    DenseNormalEquations, GroupId, HalfAngle, Scalar, Spoke, StarsView, closure,
    levenberg_marquardt,
};
use nalgebra::Vector3;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use super::big::Big;
use super::reference::{self, length, minus};

/// Converts degrees to radians.
#[must_use]
pub fn degrees(degrees: f64) -> Big {
    Big::degrees(&Big::new(degrees))
}

/// A star; each spoke belongs to one unknown.
pub struct Star<T> {
    spokes: Vec<Spoke<T>>,
    unknowns: usize,
}

/// Core's residual, and its error.
#[derive(Clone, Copy, Debug, Default)]
struct Off {
    /// Length of core's closure residual.
    residual: f64,
    /// Length of the difference between core's residual and the exact residual of the same numbers.
    error: f64,
}

impl<T: Scalar> Star<T> {
    /// Creates a star with creases at these plane angles (radians). Each crease has the number of its unknown, and
    /// `true` if it turns against the unknown.
    fn new(creases: &[(Big, u32, bool)]) -> Self {
        let spokes = creases.iter().map(|(angle, group, negative)| {
            let [sin, cos] = angle.sin_cos();
            Spoke {
                group: GroupId(*group),
                negative: *negative,
                direction: [cos, sin].map(|c| T::lit(c.to_f64())),
            }
        });
        let groups = creases.iter().map(|(_, group, _)| group + 1).max();
        Self {
            spokes: spokes.collect(),
            unknowns: groups.unwrap_or_default() as usize,
        }
    }

    /// Creates a Miura vertex. Unknown 0 are its zigzag creases, unknown 1 its straight ones.
    #[must_use]
    pub fn miura(sector: &Big) -> Self {
        let zero = Big::new(0.0);
        Self::new(&[
            (zero.clone(), 1, true),
            (sector.clone(), 0, false),
            (Big::pi(), 1, false),
            (-sector, 0, false),
        ])
    }

    /// Returns core's residual at the angles, and its error.
    fn off(&self, angles: &[T]) -> Off {
        let ends = [u32::try_from(self.spokes.len()).unwrap_or(u32::MAX)];
        let stars = StarsView::new(&self.spokes, &ends, self.unknowns).expect("a good star");
        let mut halves = vec![HalfAngle::default(); self.unknowns];
        closure::half_angles(angles, &mut halves);
        let star = stars.iter().next().expect("one star");
        let found = closure::residual(star, &halves).map(T::to_f64);
        let spokes: Vec<_> = self.spokes.iter().collect();
        let exact = spokes
            .iter()
            .map(|s| (s.direction.map(T::to_f64), s.fold_angle(angles).to_f64()));
        let exact = reference::residual(&exact.collect::<Vec<_>>());
        let found_exactly = [found.x, found.y, found.z].map(Big::new);
        Off {
            residual: found.norm(),
            error: length(&minus(&found_exactly, &exact)).to_f64(),
        }
    }

    /// Closes the star from `x`, within limits.
    fn solve(&self, limits: &[(T, T)], x: &mut [T]) -> Outcome {
        let ends = [u32::try_from(self.spokes.len()).unwrap_or(u32::MAX)];
        let stars = StarsView::new(&self.spokes, &ends, self.unknowns).expect("a good star");
        let n = self.unknowns;
        let mut halves = vec![HalfAngle::default(); n];
        let mut columns = vec![Vector3::from([T::zero(); 3]); self.spokes.len()];
        let mut problem = ClosureProblem::new(stars, &mut halves, &mut columns).expect("room");
        let mut memory = vec![T::zero(); DenseNormalEquations::<T>::memory(n)];
        let mut equations = DenseNormalEquations::new(n, &mut memory).expect("room");
        let mut workspace = vec![T::zero(); 2 * n];
        let limits = if limits.is_empty() {
            Limits::HalfTurn
        } else {
            Limits::Each(limits)
        };
        let options = Options::default();
        levenberg_marquardt::solve(
            &mut problem,
            &mut equations,
            limits,
            &options,
            x,
            &mut workspace,
        )
        .outcome
    }

    /// Returns both angles of a Miura vertex: the zigzag angle as given, and the straight one, solved for from nearby.
    #[must_use]
    pub fn closed(&self, zigzag: &Big) -> [T; 2] {
        let zigzag = T::lit(zigzag.to_f64());
        // `T::PI` is the largest number of the type that is no more than half a turn.
        let zigzag = zigzag.min(T::PI);
        let mut x = [zigzag, zigzag];
        let limits = [(zigzag, zigzag), (T::zero(), T::PI)];
        self.solve(&limits, &mut x);
        x
    }
}

/// Returns for a Miura vertex: core's residual of the rounded closed form, the error of this residual, and the absolute
/// and relative difference of the solved angle from the closed form.
fn miura<T: Scalar>(sector: &Big, zigzag: &Big) -> [f64; 4] {
    let star = Star::<T>::miura(sector);
    let zigzag = T::lit(zigzag.to_f64()).min(T::PI);
    let exact = reference::straight(sector, &Big::new(zigzag.to_f64()));
    let Off { residual, error } = star.off(&[zigzag, T::lit(exact.to_f64())]);
    let [_, straight] = star.closed(&Big::new(zigzag.to_f64()));
    let off = (&Big::new(straight.to_f64()) - &exact).abs();
    [residual, error, off.to_f64(), (&off / &exact).to_f64()]
}

/// Writes a table row for both precisions.
fn row(table: &mut String, csv: &mut String, name: &str, sector: &Big, zigzag: &Big) {
    let both = [miura::<f64>(sector, zigzag), miura::<f32>(sector, zigzag)];
    let cells = both.iter().flatten().map(|x| format!("{x:.1e}"));
    let cells: Vec<_> = cells.collect();
    let _ok = writeln!(table, "| {name} | {} |", cells.join(" | "));
    for (numbers, [residual, error, angle, relative]) in ["f64", "f32"].into_iter().zip(both) {
        let _ok = writeln!(
            csv,
            "{name},{numbers},{residual:e},{error:e},{angle:e},{relative:e}"
        );
    }
}

const HEAD: &str = "f64: residual | off the truth | solved angle off | relative | f32: residual | off the truth | \
                    solved angle off | relative |\n|---|---|---|---|---|---|---|---|---|\n";

/// Returns the table of fold angles at a sector angle of 60 degrees.
#[must_use]
pub fn fold_angles(csv: &mut String) -> String {
    let mut table = format!("| zigzag fold angle | {HEAD}");
    let sector = Big::new(60_f64.to_radians());
    csv.push_str("at,numbers,residual,off,angle,relative\n");
    for near in [1e-9, 1e-6, 1e-3, 1.0] {
        row(
            &mut table,
            csv,
            &format!("{near:e}"),
            &sector,
            &degrees(near),
        );
    }
    for middle in [45.0, 90.0, 150.0] {
        row(
            &mut table,
            csv,
            &format!("{middle}"),
            &sector,
            &degrees(middle),
        );
    }
    for near in [1.0, 1e-3, 1e-6, 1e-9] {
        let zigzag = Big::degrees(&(&Big::new(180.0) - &Big::new(near)));
        row(
            &mut table,
            csv,
            &format!("180 - {near:e}"),
            &sector,
            &zigzag,
        );
    }
    table
}

/// Returns the table of sector angles at a zigzag fold angle of 150 degrees.
#[must_use]
pub fn sectors(csv: &mut String) -> String {
    let mut table = format!("| sector angle | {HEAD}");
    csv.push_str("sector,numbers,residual,off,angle,relative\n");
    for sector in [1.0, 5.0, 30.0, 45.0, 60.0, 75.0, 85.0, 89.0] {
        let name = format!("{sector}");
        row(&mut table, csv, &name, &degrees(sector), &degrees(150.0));
    }
    table
}

/// Returns the worst of random stars of a degree: the largest error of a residual; then, among the stars that core
/// closed, the largest exact residual, and the fraction of these stars.
fn random<T: Scalar>(degree: u32, count: u32) -> [f64; 3] {
    let mut rng = Pcg64::seed_from_u64(u64::from(degree));
    let mut uniform = || f64::from(rng.next_u32()) / f64::from(u32::MAX);
    let (mut error, mut closed, mut open) = (0.0_f64, 0, 0.0_f64);
    for _ in 0..count {
        let mut angles: Vec<f64> = (0..degree).map(|_| uniform()).collect();
        angles.sort_unstable_by(f64::total_cmp);
        let creases: Vec<_> = angles
            .iter()
            .zip(0..)
            .map(|(angle, k)| (degrees(360.0 * angle), k, false))
            .collect();
        let star = Star::<T>::new(&creases);
        let start = (0..degree).map(|_| T::lit(core::f64::consts::PI * (2.0 * uniform() - 1.0)));
        let mut x: Vec<T> = start.collect();
        error = error.max(star.off(&x).error);
        if star.solve(&[], &mut x) == Outcome::Converged {
            closed += 1;
            let off = star.off(&x);
            error = error.max(off.error);
            open = open.max(off.residual + off.error);
        }
    }
    [error, open, f64::from(closed) / f64::from(count)]
}

/// Returns the table of degrees.
#[must_use]
pub fn vertex_degrees(count: u32, csv: &mut String) -> String {
    let mut table = String::from(
        "| degree | f64: off the truth | true residual where closed | closed | f32: off the truth | true residual where \
         closed | closed |\n|---|---|---|---|---|---|---|\n",
    );
    csv.push_str("degree,numbers,off,residual,closed\n");
    for degree in [4, 6, 8, 16, 32, 64] {
        let both = [random::<f64>(degree, count), random::<f32>(degree, count)];
        let cells = both.map(|[error, open, closed]| {
            format!("{error:.1e} | {open:.1e} | {:.0} %", 100.0 * closed)
        });
        let _ok = writeln!(table, "| {degree} | {} |", cells.join(" | "));
        for (numbers, [error, open, closed]) in ["f64", "f32"].into_iter().zip(both) {
            let _ok = writeln!(csv, "{degree},{numbers},{error:e},{open:e},{closed}");
        }
    }
    table
}
