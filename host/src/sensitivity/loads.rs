//! The strength that the drives of a sheet need: the torques that hold it against gravity and springs, at rest at each moment.
//!
//! With the potential energy U of the panels' weights and of the hinges' springs, and the motions N that keep closure, the
//! torque at the drivers is Nᵀ dU/dθ: by how much the energy grows with each driver while the other drivers rest. Frictions
//! and accelerations are left out.
//!
//! A sheet with k degrees of freedom needs k drivers. With an orthonormal basis Z of the motions, a set d of hinges determines
//! all others if its rows Z_d are regular, and its torques are Z_d⁻ᵀ Zᵀ dU/dθ. The basis does not matter. The *regularity* of
//! a set is the smallest singular value of Z_d, 0 if it drives nothing. A set that is regular at two times can be singular in
//! between: then the determinant of Z_d changes its sign, relative to a basis that is carried along.

use core::time::Duration;

use nalgebra::{DMatrix, DVector, Vector2, Vector3};
use thiserror::Error;

use super::places::{FoldedSheet, Twist};
use super::{Conditions, NoDerivative, ROUNDING_RATIO, Sensitivity};
use crate::folding::STEP;
use crate::motion::Motion;
use crate::pattern::{CreaseId, CreasePattern, EdgeId, FaceId, Unit};
use crate::progress::{Stage, Watch};
use crate::util::parallel;

/// Acceleration of free fall, metres per second squared (the standard value).
pub const STANDARD_GRAVITY: f64 = 9.806_65;
/// Smallest regularity of a set of drivers.
pub const REGULAR: f64 = 1e-4;
/// Parts of the way to the next place at which a singular place is looked at instead.
const BESIDE: [f64; 3] = [0.02, 0.1, 0.5];
/// Largest number of sets of drivers of which all are looked at, times the number of times: some seconds of work.
const MAX_LOOKS: f64 = 5e6;

/// Weight and springs of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Mass of the panels, kilograms per square metre.
    pub areal_density: f64,
    /// The face that is held; `None` for the first face of the spanning tree, which lies in the middle.
    pub fixed: Option<FaceId>,
    /// Acceleration of gravity in the frame of the flat sheet in which the held face stays where it is drawn, metres per second
    /// squared.
    pub gravity: Vector3<f64>,
    /// Stiffness of the spring in each hinge, newton metres per radian. Springs rest in the flat sheet.
    pub spring: f64,
    /// Stiffness of the springs of single hinges, named by their edges, in place of `spring`; of two for one hinge the last.
    pub springs: Vec<(EdgeId, f64)>,
}

/// A kind of drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Name for people.
    pub name: String,
    /// Torque with which it stalls, newton metres.
    pub stall_torque: f64,
    /// Speed without load, radians per second. In between, speed falls with torque on a straight line.
    pub speed: f64,
}

/// Torques of a set of drivers over a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Loads {
    /// The drivers.
    pub drivers: Vec<CreaseId>,
    /// Times, seconds.
    pub times: Vec<f64>,
    /// Torque of each driver at each time, newton metres, positive in the sense of a valley fold.
    pub torques: Vec<Vec<f64>>,
    /// Speed of each driver at each time, radians per second.
    pub speeds: Vec<Vec<f64>>,
    /// The largest torque.
    pub peak: Peak,
    /// Smallest regularity of the drivers.
    pub regularity: f64,
    /// `true` if all sets of drivers were compared and this is the best, `false` if the set was given, is one that no exchange of
    /// one driver improves, or time ran out.
    pub is_least: bool,
    /// Number of times at which the configuration is singular, as in the flat sheet, which are left out.
    pub left_out: usize,
}

/// The largest torque over a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// The driver.
    pub driver: CreaseId,
    /// Its torque, newton metres.
    pub torque: f64,
    /// Time, seconds.
    pub at: f64,
}

/// Reason why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NoLoads {
    /// The pattern has no unit of length.
    #[error("the file tells no unit of length, and torques need one")]
    NoUnit,
    /// The pattern is in several pieces.
    #[error("expected a sheet in one piece, found {sheets}")]
    Pieces {
        /// Their number.
        sheets: usize,
    },
    /// There is no such face.
    #[error("face {face} does not exist, expected 0 to {}", faces.saturating_sub(1))]
    NoFace {
        /// The number that was given.
        face: FaceId,
        /// The number of faces.
        faces: usize,
    },
    /// A spring is at an edge that is no hinge.
    #[error("edge {edge} is no hinge, and has no spring")]
    NoHinge {
        /// The edge.
        edge: EdgeId,
    },
    /// The sheet has too many creases to number their products.
    #[error("the sheet has too many creases")]
    TooLarge,
    /// No hinge turns.
    #[error("no hinge turns")]
    Still,
    /// The caller cancelled the call, or its time is up.
    #[error("time ran out before torques were found")]
    Cancelled,
    /// The motion does not close, or is singular all along.
    #[error("at {time:.3} s, {cause}")]
    NoMotion {
        /// The time, seconds.
        time: f64,
        /// The cause.
        cause: NoDerivative,
    },
    /// The sheet has more degrees of freedom at one time than at another.
    #[error(
        "the degrees of freedom change: {} at {:.3} s, {} at {:.3} s; no set of drivers serves both",
        freedom[0], times[0], freedom[1], times[1]
    )]
    FreedomChanges {
        /// Degrees of freedom at both times.
        freedom: [usize; 2],
        /// The times, seconds.
        times: [f64; 2],
    },
    /// The number of drivers that was asked for cannot drive the sheet.
    #[error(
        "expected {freedom} to {hinges} drivers, from the degrees of freedom to all hinges, found {size}"
    )]
    Size {
        /// The number that was asked for.
        size: usize,
        /// Degrees of freedom of the sheet.
        freedom: usize,
        /// Number of hinges.
        hinges: usize,
    },
    /// No set of hinges drives the sheet over the whole motion.
    #[error("no set of {size} hinges drives the sheet over the whole motion")]
    NoDrivers {
        /// The size of a set.
        size: usize,
    },
    /// No set that drives the sheet over the whole motion was found; there may be one, because not all were looked at.
    #[error(
        "no set of {size} hinges was found that drives the sheet over the whole motion; not all were tried"
    )]
    NoDriversFound {
        /// The size of a set.
        size: usize,
    },
}

impl Loads {
    /// Finds the drivers whose largest torque over a motion is least.
    ///
    /// Cost: for each of some ten to fifty times, a few sparse factorisations; then all sets of as many hinges as the sheet has
    /// degrees of freedom, or exchanges of one driver if there are too many.
    ///
    /// # Errors
    /// If the pattern has no unit or is in pieces, the face does not exist, no set drives the whole motion, or the watch is over.
    pub fn least(motion: &Motion, load: &Load, watch: Watch<'_>) -> Result<Self, NoLoads> {
        Self::least_of(motion, load, None, watch)
    }

    /// Finds the set of this many drivers whose largest torque over a motion is least; see [`least`](Self::least). Drivers beyond
    /// the degrees of freedom share the load: of all torques that hold the sheet those with the least sum of squares are taken.
    ///
    /// # Errors
    /// As for [`least`](Self::least), or if there are fewer drivers than degrees of freedom or more than hinges.
    pub fn least_of(
        motion: &Motion,
        load: &Load,
        size: Option<usize>,
        watch: Watch<'_>,
    ) -> Result<Self, NoLoads> {
        let sheet = LoadedMotion::new(motion, load, watch)?;
        let (freedom, hinges) = (sheet.freedom(), sheet.hinges());
        let size = size.unwrap_or(freedom);
        if !(freedom..=hinges).contains(&size) {
            return Err(NoLoads::Size {
                size,
                freedom,
                hinges,
            });
        }
        let (drivers, is_least) = sheet.least_set(size)?;
        Ok(sheet.loads(&drivers, is_least))
    }

    /// Returns the torques of the drivers that are given, which share the load as in [`least_of`](Self::least_of) if they are more
    /// than the degrees of freedom.
    ///
    /// # Errors
    /// As for [`least`](Self::least), or if these drivers do not determine the other hinges at every time.
    pub fn of(motion: &Motion, load: &Load, drivers: &[CreaseId]) -> Result<Self, NoLoads> {
        let sheet = LoadedMotion::new(motion, load, Watch::default())?;
        let size = sheet.freedom();
        let drivers: Vec<usize> = drivers.iter().map(|driver| driver.index()).collect();
        let exist = drivers.iter().all(|&driver| driver < sheet.hinges());
        if drivers.len() < size || !exist || sheet.peak(&drivers, f64::INFINITY).is_none() {
            return Err(NoLoads::NoDrivers { size });
        }
        Ok(sheet.loads(&drivers, false))
    }

    /// Returns the first time at which a drive of this kind stalls in place of any driver; `None` if it never does.
    #[must_use]
    pub fn stalls_at(&self, drive: &Drive) -> Option<f64> {
        let moments = self.times.iter().zip(&self.torques).zip(&self.speeds);
        let stalls = |torque: f64, speed: f64| {
            // A drive that is pushed along needs no more torque than one that stands.
            let speed = if torque * speed > 0.0 {
                speed.abs()
            } else {
                0.0
            };
            let is_enough = torque.abs() <= drive.stall_torque * (1.0 - speed / drive.speed);
            !is_enough
        };
        let mut stalled = moments.filter(|((_, torques), speeds)| {
            let mut both = torques.iter().zip(*speeds);
            both.any(|(torque, speed)| stalls(*torque, *speed))
        });
        stalled.next().map(|((time, _), _)| *time)
    }
}

/// The sheet at a time.
struct Moment {
    time: f64,
    /// Z: an orthonormal basis of the motions that keep closure.
    basis: DMatrix<f64>,
    /// Zᵀ dU/dθ, newton metres.
    forces: DVector<f64>,
}

impl Moment {
    /// Returns the torques of drivers, the least ones if they are more than the degrees of freedom, and the sign of the
    /// determinant of as many drivers, 0 for more.
    fn torques(&self, drivers: &[usize]) -> Option<(DVector<f64>, f64)> {
        let rows = self.basis.select_rows(drivers);
        if rows.is_square() {
            let factors = rows.transpose().lu();
            let sign = factors.determinant().signum();
            return Some((factors.solve(&self.forces)?, sign));
        }
        // Z_d (Z_dᵀ Z_d)⁻¹ Zᵀ dU/dθ is the pseudoinverse of Z_dᵀ.
        let shares = rows.tr_mul(&rows).cholesky()?.solve(&self.forces);
        Some((rows * shares, 0.0))
    }
}

/// A motion under a load.
struct LoadedMotion<'a> {
    motion: &'a Motion,
    watch: Watch<'a>,
    moments: Vec<Moment>,
    /// For each moment but the first, the sign of the determinant of the map from the basis before.
    carried: Vec<f64>,
    left_out: usize,
}

impl<'a> LoadedMotion<'a> {
    fn new(motion: &'a Motion, load: &Load, watch: Watch<'a>) -> Result<Self, NoLoads> {
        watch.begin(Stage::Folding);
        let pattern = &motion.pattern;
        let metres = pattern.unit().map(Unit::metres).ok_or(NoLoads::NoUnit)?;
        let sheets = pattern.sheets();
        if sheets > 1 {
            return Err(NoLoads::Pieces { sheets });
        }
        let faces = pattern.faces().len();
        if let Some(face) = load.fixed.filter(|face| face.index() >= faces) {
            return Err(NoLoads::NoFace { face, faces });
        }
        let stiffness = stiffness(pattern, load)?;
        let conditions = Conditions::new(pattern).ok_or(NoLoads::TooLarge)?;
        let panels = Panels::of(pattern);
        let steps = motion.with_steps(STEP);
        let times: Vec<f64> = steps.knots.iter().map(|knot| knot.time).collect();
        let numbers: Vec<usize> = (0..times.len()).collect();
        let found = parallel::map(&numbers, Duration::from_millis(1), |&k| {
            if watch.is_over() {
                return Err(NoLoads::Cancelled);
            }
            // A singular end is looked at within the motion.
            let next = times.get(k + 1).or_else(|| times.get(k.wrapping_sub(1)));
            let way = next.map_or(0.0, |next| next - times[k]);
            let beside = BESIDE.map(|part| times[k] + part * way);
            let mut first = None;
            for time in [times[k]].into_iter().chain(beside) {
                match Sensitivity::of_motion(&conditions, motion, time) {
                    Ok(at) => {
                        let energy = energy_gradient(&panels, &at, load, &stiffness, metres);
                        let basis = at.null_space.basis;
                        // The torques of a sheet in balance are 0 but for rounding.
                        let rounding = ROUNDING_RATIO * basis.abs().tr_mul(&energy.abs());
                        let forces = basis.tr_mul(&energy);
                        let forces = forces.zip_map(&rounding, |force, rounding| {
                            if force.abs() > rounding { force } else { 0.0 }
                        });
                        return Ok(Moment {
                            time,
                            basis,
                            forces,
                        });
                    }
                    Err(cause) => {
                        first.get_or_insert(NoLoads::NoMotion { time, cause });
                    }
                }
            }
            Err(first.unwrap_or(NoLoads::Still))
        });
        let count = found.len();
        let mut first = None;
        let mut moments = Vec::new();
        for moment in found {
            match moment {
                Ok(moment) => moments.push(moment),
                Err(NoLoads::NoMotion {
                    cause: cause @ NoDerivative::Singular { .. },
                    time,
                }) => {
                    first.get_or_insert(NoLoads::NoMotion { time, cause });
                }
                Err(other) => return Err(other),
            }
        }
        let Some(start) = moments.first() else {
            return Err(first.unwrap_or(NoLoads::Still));
        };
        let freedom = start.basis.ncols();
        if freedom == 0 {
            return Err(NoLoads::Still);
        }
        if let Some(other) = moments
            .iter()
            .find(|moment| moment.basis.ncols() != freedom)
        {
            return Err(NoLoads::FreedomChanges {
                freedom: [freedom, other.basis.ncols()],
                times: [start.time, other.time],
            });
        }
        let carried = moments.windows(2).map(|pair| {
            let map = pair[0].basis.tr_mul(&pair[1].basis);
            map.determinant().signum()
        });
        Ok(Self {
            motion,
            watch,
            carried: carried.collect(),
            left_out: count - moments.len(),
            moments,
        })
    }

    fn freedom(&self) -> usize {
        self.moments[0].basis.ncols()
    }

    fn hinges(&self) -> usize {
        self.moments[0].basis.nrows()
    }

    /// Returns the largest torque of a set of drivers if it is below `most`; `None` if it is not, or the set is singular
    /// somewhere.
    fn peak(&self, drivers: &[usize], most: f64) -> Option<f64> {
        let mut peak = 0.0_f64;
        let mut before = 0.0;
        for (k, moment) in self.moments.iter().enumerate() {
            let (torques, sign) = moment.torques(drivers)?;
            if k > 0 && sign * before * self.carried[k - 1] < 0.0 {
                return None;
            }
            before = sign;
            peak = peak.max(torques.amax());
            let is_below = peak < most;
            if !is_below {
                return None;
            }
        }
        (self.regularity(drivers) >= REGULAR).then_some(peak)
    }

    /// Returns the smallest singular value of Z_d.
    fn regularity(&self, drivers: &[usize]) -> f64 {
        let values = self.moments.iter().map(|moment| {
            let rows = moment.basis.select_rows(drivers);
            rows.singular_values().min()
        });
        values.fold(f64::INFINITY, f64::min)
    }

    /// Returns the set of this many drivers with the least peak, and `true` if it is the least of all sets.
    fn least_set(&self, size: usize) -> Result<(Vec<usize>, bool), NoLoads> {
        let n = self.hinges();
        #[allow(clippy::cast_precision_loss, reason = "an estimate")]
        let sets = (0..size).fold(1.0, |sets, k| sets * (n - k) as f64 / (k + 1) as f64);
        #[allow(clippy::cast_precision_loss, reason = "an estimate")]
        let looks = sets * self.moments.len() as f64;
        let is_least = looks <= MAX_LOOKS;
        let found = match is_least {
            true => self.least_of_all(size),
            false => self.least_by_exchange(size),
        };
        if self.watch.is_over() {
            // A set that was found by then need not be the best.
            return found.map_or(Err(NoLoads::Cancelled), |set| Ok((set, false)));
        }
        found.map(|set| (set, is_least)).ok_or(match is_least {
            true => NoLoads::NoDrivers { size },
            false => NoLoads::NoDriversFound { size },
        })
    }

    /// Looks at all sets of hinges.
    fn least_of_all(&self, size: usize) -> Option<Vec<usize>> {
        let n = self.hinges();
        let mut set: Vec<usize> = (0..size).collect();
        let mut best = (f64::INFINITY, None);
        loop {
            // A set is better by more than rounding, so that of equal hinges the first is chosen.
            if let Some(peak) = self.peak(&set, best.0 * (1.0 - 1e-9)) {
                best = (peak, Some(set.clone()));
            }
            let next = (0..size).rev().find(|&k| set[k] < n - size + k);
            let next = next.filter(|_| !self.watch.is_over());
            let Some(k) = next else { return best.1 };
            set[k] += 1;
            for later in k + 1..size {
                set[later] = set[later - 1] + 1;
            }
        }
    }

    /// Exchanges one driver at a time, from sets that are most regular at one moment, to which drivers are added one by one.
    fn least_by_exchange(&self, size: usize) -> Option<Vec<usize>> {
        let mut best: (f64, Option<Vec<usize>>) = (f64::INFINITY, None);
        for moment in &self.moments {
            let mut set = super::independent_rows(&moment.basis);
            set.sort_unstable();
            if let Some(peak) = self.peak(&set, best.0) {
                best = (peak, Some(set));
            }
        }
        while best.1.as_ref()?.len() < size && !self.watch.is_over() {
            let set = best.1.take()?;
            best.0 = f64::INFINITY;
            for hinge in (0..self.hinges()).filter(|hinge| !set.contains(hinge)) {
                let mut more = set.clone();
                more.push(hinge);
                more.sort_unstable();
                if let Some(peak) = self.peak(&more, best.0 * (1.0 - 1e-9)) {
                    best = (peak, Some(more));
                }
            }
        }
        if best.1.as_ref()?.len() < size {
            return None;
        }
        loop {
            let set = best.1.clone()?;
            let before = best.0;
            for k in 0..set.len() {
                for hinge in (0..self.hinges()).filter(|hinge| !set.contains(hinge)) {
                    let mut other = set.clone();
                    other[k] = hinge;
                    other.sort_unstable();
                    if let Some(peak) = self.peak(&other, best.0 * (1.0 - 1e-9)) {
                        best = (peak, Some(other));
                    }
                }
            }
            let is_better = best.0 < before;
            if !is_better || self.watch.is_over() {
                return best.1;
            }
        }
    }

    /// Returns the torques of a regular set of drivers.
    fn loads(&self, drivers: &[usize], is_least: bool) -> Loads {
        let torques = self.moments.iter().map(|moment| {
            let solved = moment.torques(drivers);
            // The sum turns -0 into 0.
            solved.map_or(vec![f64::NAN; drivers.len()], |(solved, _)| {
                solved.iter().map(|torque| torque + 0.0).collect()
            })
        });
        let torques: Vec<Vec<f64>> = torques.collect();
        let peaks = self
            .moments
            .iter()
            .zip(&torques)
            .flat_map(|(moment, torques)| {
                drivers.iter().zip(torques).map(|(&driver, &torque)| Peak {
                    driver: CreaseId::new(driver),
                    torque,
                    at: moment.time,
                })
            });
        // The first of equal peaks.
        let peak = peaks.reduce(|most, next| {
            if next.torque.abs() > most.torque.abs() {
                next
            } else {
                most
            }
        });
        let none = Peak {
            driver: CreaseId::default(),
            torque: 0.0,
            at: 0.0,
        };
        let members = self.motion.memberships();
        let speeds = self.moments.iter().map(|moment| {
            let rates = self.motion.rates(moment.time);
            let speed = |&driver: &usize| {
                let member = members[driver];
                member.apply(rates[member.group.index()])
            };
            drivers.iter().map(speed).collect()
        });
        Loads {
            drivers: drivers
                .iter()
                .map(|&driver| CreaseId::new(driver))
                .collect(),
            times: self.moments.iter().map(|moment| moment.time).collect(),
            speeds: speeds.collect(),
            torques,
            peak: peak.unwrap_or(none),
            regularity: self.regularity(drivers),
            is_least,
            left_out: self.left_out,
        }
    }
}

/// Area and centre of mass of each face, in units of the sheet.
struct Panels(Vec<(f64, Vector2<f64>)>);

impl Panels {
    fn of(pattern: &CreasePattern) -> Self {
        let faces = pattern.faces().iter().map(|face| {
            let corner = |k: usize| pattern.vertices()[face[k].index()];
            let origin = corner(0);
            let mut area = 0.0;
            let mut moment = Vector2::zeros();
            for k in 1..face.len().saturating_sub(1) {
                let (a, b) = (corner(k) - origin, corner(k + 1) - origin);
                let part = a.perp(&b) / 2.0;
                area += part;
                moment += (a + b) * (part / 3.0);
            }
            (area.abs(), origin + moment / area)
        });
        Self(faces.collect())
    }
}

/// Returns the stiffness of the spring in each crease, newton metres per radian.
fn stiffness(pattern: &CreasePattern, load: &Load) -> Result<Vec<f64>, NoLoads> {
    let mut stiffness = vec![load.spring; pattern.creases().len()];
    for &(edge, spring) in &load.springs {
        let found = pattern.edges().get(edge.index());
        let crease = found.and_then(|edge| edge.crease);
        let crease = crease.ok_or(NoLoads::NoHinge { edge })?;
        stiffness[crease.index()] = spring;
    }
    Ok(stiffness)
}

/// Returns dU/dθ, newton metres per radian.
fn energy_gradient(
    panels: &Panels,
    at: &Sensitivity<'_>,
    load: &Load,
    stiffness: &[f64],
    metres: f64,
) -> DVector<f64> {
    let pattern = at.conditions.pattern();
    let sheet = FoldedSheet::new(pattern, &at.angles);
    let fixed = load.fixed.unwrap_or(pattern.tree().roots()[0]);
    let gravity = sheet.pose(fixed).r_wf.rotate(&load.gravity);
    let mut wrenches = vec![Twist::zero(); pattern.faces().len()];
    let mut sum = Twist::zero();
    for (face, (area, centre)) in (0..).map(FaceId).zip(&panels.0) {
        // Kilograms times metres per second squared times metres for each unit of length.
        let force = -gravity * (load.areal_density * area * metres.powi(3));
        let place = sheet.pose(face).apply(*centre);
        wrenches[face.index()].push(force, place);
        sum.push(force, place);
    }
    // The held face takes the weight of all others.
    let held = &mut wrenches[fixed.index()];
    held.turn -= sum.turn;
    held.shift -= sum.shift;
    let mut gradient = sheet.carried(&mut wrenches).angles;
    for ((by, angle), stiffness) in gradient.iter_mut().zip(&at.angles).zip(stiffness) {
        *by += stiffness * angle;
    }
    DVector::from_vec(gradient)
}
