//! Places knots on a course: as few as the bound on closure between them and the limits on angle, speed and
//! acceleration of the hinges allow. Segments that do not fit are divided, then knots that are not needed are removed.

use core::f64::consts::PI;
use std::collections::HashMap;

use foldpath_core::{Curve, Interpolation, Node};

use super::course::{Course, Site};
use super::follow::max_norm;
use super::knots::Knot;
use super::options::{PlanOptions, Timing};
use super::overshoot::peaks;
use super::solver::ClosureSolver;
use super::timing::Law;
use crate::certificate::{Closure, FoldingCertifier, SegmentCertifier, range};
use crate::symmetry::ReducedStars;

/// Conditions that the motion between knots has to keep.
pub(super) struct Terms<'a> {
    /// One star for each distinct closure condition, and the loops round holes.
    pub(super) stars: &'a ReducedStars,
    /// Largest closure residual; with `None` any residual is allowed, and all waypoints are knots.
    pub(super) closure: Option<f64>,
    /// Bounds that the whole sheet has to keep, if any.
    pub(super) folded: Option<Folded<'a>>,
    /// Lower and upper bound of each group angle, radians.
    pub(super) limits: &'a [(f64, f64)],
    /// Largest speed of a hinge, radians per second.
    pub(super) speed: f64,
    /// Largest acceleration of a hinge, radians per second squared; infinite for any.
    pub(super) acceleration: f64,
    /// Largest number of knots.
    pub(super) most: usize,
}

/// Bounds on deformation and gap of the whole sheet.
#[derive(Clone)]
pub(super) struct Folded<'a> {
    pub(super) certifier: FoldingCertifier<'a>,
    /// Bound for which knots are added as long as that helps.
    pub(super) aim: f64,
    /// Bound that is kept in any case.
    pub(super) bound: f64,
}

/// Time law along the course.
enum Pace {
    /// As fast as speed and acceleration of the hinges allow.
    Optimal(Law),
    /// Time is proportional to the angle of this group.
    Angle(usize),
    /// Time is proportional to the tangent of half the angle of this group.
    HalfAngle(usize),
    /// Time is proportional to the path length in group angles.
    Way,
}

impl Pace {
    /// Returns the time at a configuration, and the speed there: path length per time.
    fn at(&self, site: &Site) -> [f64; 2] {
        match self {
            Self::Optimal(law) => [law.time_at(site.way), law.speed_at(site.way)],
            Self::Angle(lead) => [site.angles[*lead].abs(), 1.0 / site.tangent[*lead].abs()],
            Self::HalfAngle(lead) => {
                let tangent = (site.angles[*lead] / 2.0).tan();
                let rate = site.tangent[*lead] * (1.0 + tangent * tangent) / 2.0;
                [tangent.abs(), 1.0 / rate.abs()]
            }
            Self::Way => [site.way, 1.0],
        }
    }
}

/// Knots, the interpolation between them, and bounds on the motion.
pub(super) struct Placed {
    pub(super) interpolation: Interpolation,
    pub(super) knots: Vec<Knot>,
    /// Bounds on the closure over the whole motion.
    bounds: Bounds,
    /// First segment that does not keep the closure condition, if any.
    open: Option<Open>,
}

/// The first segment of a motion that does not keep the closure condition.
struct Open {
    segment: usize,
    /// Path length to the start of the segment.
    way: f64,
    /// Bounds on the closure before the segment.
    before: Bounds,
}

/// Bounds on the closure over a part of the motion.
#[derive(Clone)]
struct Bounds {
    /// Bound for each star.
    stars: Vec<f64>,
    /// Bounds for the rotation and the translation of each loop.
    loops: Vec<[f64; 2]>,
}

impl Bounds {
    fn closure(&self) -> Closure<'_> {
        Closure {
            stars: &self.stars,
            loops: &self.loops,
        }
    }

    /// Extends the bounds to another part of the motion.
    fn take_in(&mut self, other: &Self) {
        let loops = self.loops.as_flattened_mut().iter_mut();
        let others = other.stars.iter().chain(other.loops.as_flattened());
        for (worst, bound) in self.stars.iter_mut().chain(loops).zip(others) {
            *worst = worst.max(*bound);
        }
    }
}

impl Placed {
    pub(super) fn closure(&self) -> Closure<'_> {
        self.bounds.closure()
    }

    /// Keeps only the segments before the first that breaks the closure condition. Returns `true` if there is one.
    pub(super) fn cut(&mut self) -> bool {
        let Some(open) = self.open.take() else {
            return false;
        };
        self.knots.truncate(open.segment + 1);
        self.bounds = open.before;
        true
    }

    /// Returns the path length up to which the motion keeps the closure condition; infinite if all of it does.
    fn closes_to(&self) -> f64 {
        self.open.as_ref().map_or(f64::INFINITY, |open| open.way)
    }

    /// Returns the seconds from the first knot to the last.
    fn duration(&self) -> f64 {
        self.knots.last().map_or(0.0, |last| last.time)
    }
}

/// Places knots on a course, with the interpolation asked for or the one that needs the fewest.
///
/// Homogeneous half angles, which other programs do not know, are taken only if they save most of the knots. Returns
/// `None` if no interpolation keeps the conditions with the largest number of knots.
pub(super) fn place(
    course: &Course,
    terms: &Terms<'_>,
    solver: &mut ClosureSolver<'_>,
    options: &PlanOptions,
) -> Option<Placed> {
    let mut placer = Placer {
        course,
        terms,
        solver,
        most: terms.most,
        certifier: SegmentCertifier::default(),
        folded: terms.folded.clone(),
        found: Vec::new(),
        curves: Vec::new(),
        known: HashMap::new(),
    };
    if course.ways().len() < 2 {
        return placer.alone();
    }
    let all = [
        Interpolation::HalfAngle,
        Interpolation::Hermite,
        Interpolation::Homogeneous,
    ];
    let kinds = match &options.interpolation {
        Some(kind) => core::slice::from_ref(kind),
        // Without conditions hinges turn evenly. If nothing closes, no interpolation is nearer to closing, and Hermite
        // is the best to follow.
        None if terms.stars.is_empty() || terms.folded.is_some() => &all[1..2],
        None => &all,
    };
    let optimal = (options.pace == Timing::Optimal).then(|| [fastest(course, terms)]);
    let mut best: Option<Placed> = None;
    for &kind in kinds {
        if let Some(best) = best.as_ref().filter(|best| best.open.is_none()) {
            if best.knots.len() <= FEW {
                break;
            }
            placer.most = match kind {
                Interpolation::Homogeneous => best.knots.len() / WORTH,
                _ => best.knots.len() - 1,
            };
        }
        let sparse;
        let paces: &[Pace] = if let Some(optimal) = &optimal {
            optimal
        } else {
            sparse = sparse_paces(course, kind);
            &sparse
        };
        for pace in paces {
            let Some(placed) = placer.place(kind, pace) else {
                continue;
            };
            let better = best.as_ref().is_none_or(|best| {
                let order = best.closes_to().total_cmp(&placed.closes_to());
                order
                    .then(placed.knots.len().cmp(&best.knots.len()))
                    .then(placed.duration().total_cmp(&best.duration()))
                    .is_lt()
            });
            if better {
                if placed.open.is_none() {
                    placer.most = placer.most.min(placed.knots.len());
                }
                best = Some(placed);
            }
        }
    }
    best
}

/// Returns the fastest time law of a course.
fn fastest(course: &Course, terms: &Terms<'_>) -> Pace {
    let groups = terms.limits.len();
    let parts = (GRID / groups.max(1)).clamp(1, PARTS);
    match course.fastest(parts, terms) {
        Ok(law) => Pace::Optimal(law),
        Err(_) => Pace::Way,
    }
}

/// Returns the time laws with which an interpolation may need few knots.
fn sparse_paces(course: &Course, kind: Interpolation) -> Vec<Pace> {
    let leads = 0..course.site(0).angles.len().min(LEADS);
    match kind {
        Interpolation::HalfAngle => leads.map(Pace::HalfAngle).collect(),
        Interpolation::Homogeneous => {
            let angles = leads.clone().map(Pace::Angle);
            angles.chain(leads.map(Pace::HalfAngle)).collect()
        }
        Interpolation::Linear | Interpolation::Hermite => vec![Pace::Way],
    }
}

/// Number of knots that is few enough to try no other interpolation.
const FEW: usize = 12;
/// Factor by which homogeneous half angles have to reduce the number of knots.
const WORTH: usize = 4;
/// Largest number of intervals between two waypoints on which the fastest motion is computed.
const PARTS: usize = 8;
/// Number of group angles between two waypoints above which there are fewer intervals.
const GRID: usize = 4096;
/// Largest number of groups that are tried as the one to whose angle or half angle time is proportional.
const LEADS: usize = 8;

/// Places knots on a course.
struct Placer<'a, 's> {
    course: &'a Course,
    terms: &'a Terms<'a>,
    solver: &'a mut ClosureSolver<'s>,
    /// Largest number of knots.
    most: usize,
    certifier: SegmentCertifier,
    folded: Option<Folded<'a>>,
    /// Configurations found on the course in addition to its waypoints.
    found: Vec<Site>,
    curves: Vec<Curve<f64>>,
    /// Bounds on the closure of segments that keep the conditions, by the path lengths at their ends.
    known: HashMap<[u64; 2], Bounds>,
}

/// Fraction by which a hinge may exceed its limits before time is stretched at the end.
const HASTE: f64 = 0.02;
/// Fraction by which time is stretched in addition, so that rounding the knots passes no limit.
const MARGIN: f64 = 1e-5;
/// Distance of two knots, as a fraction of that of the waypoints around them, below which no knot is put between them.
const NARROWEST: f64 = 1.0 / 256.0;
/// Path length from its limit within which a hinge is put to rest at the limit: while others move on, solving would
/// move it to and fro.
const RESTING: f64 = 1e-4;
/// Distance from half a turn, radians, below which the digits that an angle is written with leave too few digits of its
/// half angle's tangent to prove again what is proved of the tangent.
const BLUNT: f64 = 1e-4;
/// Distance beyond its limit up to which a hinge counts as being at the limit, radians.
const AT_LIMIT: f64 = 1e-9;

/// Returns `true` if a hinge keeps its limits all along its curve.
fn is_within((curve, limit): (&Curve<f64>, &(f64, f64))) -> bool {
    let [lower, upper] = range(curve);
    lower >= limit.0 - AT_LIMIT && upper <= limit.1 + AT_LIMIT
}

impl Placer<'_, '_> {
    /// Returns the single configuration of a course of length 0.
    fn alone(&mut self) -> Option<Placed> {
        let first = self.course.ways().first().map(|_| self.course.site(0))?;
        Some(Placed {
            interpolation: Interpolation::Hermite,
            knots: vec![Knot {
                rates: vec![0.0; first.angles.len()],
                angles: first.angles,
                ..Knot::default()
            }],
            bounds: self.closed(),
            open: None,
        })
    }

    /// Places the fewest knots found with this interpolation and time law. If even the densest knots do not keep the
    /// closure condition, the bound on closure says so. Returns `None` if more knots are needed than allowed, or the
    /// interpolation does not pass where the course does.
    fn place(&mut self, kind: Interpolation, pace: &Pace) -> Option<Placed> {
        self.known.clear();
        let maker = Maker::new(self.course, kind, pace);
        let last = self.course.ways().len().checked_sub(1)?;
        let mut sites = vec![self.course.site(0)];
        let mut open = vec![self.course.site(last)];
        if self.terms.closure.is_none() {
            open.extend(self.course.inner().rev().map(|index| self.waypoint(index)));
            sites.extend(open.drain(..).rev());
            self.stay_within(&maker, &mut sites)?;
            return self.knots(&maker, &sites);
        }
        // Knots are needed first of all at configurations where the motion rests, a phase ends, or accelerations jump.
        let mut needed: Vec<Site> = self
            .course
            .inner()
            .map(|index| self.waypoint(index))
            .collect();
        needed.retain(Site::stays);
        if let (Pace::Optimal(law), true) = (pace, self.terms.acceleration.is_finite()) {
            let switches = law.switches().iter().map(|k| law.parameters()[*k]);
            let (start, end) = (sites[0].way, open[0].way);
            let inner = switches.filter(|way| *way > start && *way < end);
            needed.extend(inner.filter_map(|way| self.site_at(way)));
        }
        needed.sort_by(|a, b| b.way.total_cmp(&a.way).then(a.rests().cmp(&b.rests())));
        needed.dedup_by(|a, b| {
            let same = a.way.to_bits() == b.way.to_bits();
            b.ends_phase |= same && a.ends_phase;
            same
        });
        open.extend(needed);
        let mut fits = true;
        while let (Some(from), Some(to)) = (sites.last(), open.last()) {
            let (from, to) = (from.clone(), to.clone());
            if self.fits(&maker, &from, &to)? {
                sites.extend(open.pop());
            } else if let Some(between) = self.between(&from, &to) {
                open.push(between);
            } else if self.deforms_within(|folded| folded.bound) {
                fits = false;
                sites.extend(open.pop());
            } else {
                return None;
            }
            // Halving a segment that does not fit leaves less than twice the knots needed.
            if sites.len() + open.len() > self.most.saturating_mul(2) {
                return None;
            }
        }
        self.thin(&maker, &mut sites)?;
        if !fits {
            self.stay_within(&maker, &mut sites)?;
        }
        if sites.len() > self.most {
            return None;
        }
        self.knots(&maker, &sites)
    }

    /// Lets a hinge rest at two knots between which it would turn beyond its limits, as happens on a motion that closes
    /// only roughly. The hinge then turns from one angle to the other and no farther.
    fn stay_within(&mut self, maker: &Maker<'_>, sites: &mut [Site]) -> Option<()> {
        let mut turned = true;
        while core::mem::take(&mut turned) {
            for index in 1..sites.len() {
                self.span(maker, &sites[index - 1], &sites[index])?;
                for (group, pair) in self.curves.iter().zip(self.terms.limits).enumerate() {
                    if is_within(pair) {
                        continue;
                    }
                    for site in &mut sites[index - 1..=index] {
                        turned |= site.tangent[group].abs() > 0.0;
                        site.tangent[group] = 0.0;
                    }
                    self.known.clear();
                }
            }
        }
        Some(())
    }

    /// Removes knots while the motion between those that remain keeps the conditions.
    fn thin(&mut self, maker: &Maker<'_>, sites: &mut Vec<Site>) -> Option<()> {
        let mut index = 1;
        while index + 1 < sites.len() {
            if !sites[index].stays() && self.fits(maker, &sites[index - 1], &sites[index + 1])? {
                sites.remove(index);
            } else {
                index += 1;
            }
        }
        Some(())
    }

    /// Makes the curves between two configurations, and returns the time between them. Returns `None` if there are no
    /// such curves, or time is up.
    fn span(&mut self, maker: &Maker<'_>, from: &Site, to: &Site) -> Option<f64> {
        if self.solver.is_late() {
            return None;
        }
        maker.curves(from, to, &mut self.curves)
    }

    /// Returns `true` if the motion between two configurations keeps the conditions; `None` if there are no curves
    /// between them, or time is up.
    fn fits(&mut self, maker: &Maker<'_>, from: &Site, to: &Site) -> Option<bool> {
        let span = self.span(maker, from, to)?;
        let terms = self.terms;
        let within = self.curves.iter().zip(terms.limits).all(is_within);
        let paced = matches!(maker.pace, Pace::Optimal(_));
        if !within || paced && self.is_hasty(maker, from, to, span) {
            return Some(false);
        }
        let Some(most) = terms.closure else {
            return Some(true);
        };
        // Most segments that do not close well enough show it in the middle.
        let middle: Vec<f64> = self.curves.iter().map(|curve| curve.angle(0.5)).collect();
        if terms.stars.largest_residual(&middle) > most {
            return Some(false);
        }
        let bounds = self.bounds();
        let closes = bounds.closure().worst() <= most;
        let fits = closes && self.deforms_within(|folded| folded.aim);
        if fits {
            self.known.insert(key(from, to), bounds);
        }
        Some(fits)
    }

    /// Returns `true` if the whole sheet deforms by no more than `most` over the present curves, or no bound on it is
    /// asked for.
    fn deforms_within(&mut self, most: fn(&Folded<'_>) -> f64) -> bool {
        let Some(folded) = &mut self.folded else {
            return true;
        };
        let most = most(folded);
        folded.certifier.rigidity(&self.curves, most).is_some()
    }

    /// Returns bounds on the closure over the present curves.
    fn bounds(&mut self) -> Bounds {
        let stars = self.terms.stars;
        let (stars, loops) = (stars.view(), stars.loops());
        let Closure { stars, loops } = self.certifier.closure(stars, loops, &self.curves);
        Bounds {
            stars: stars.to_vec(),
            loops: loops.to_vec(),
        }
    }

    /// Returns the bounds of a motion in which nothing moves.
    fn closed(&self) -> Bounds {
        Bounds {
            stars: vec![0.0; self.terms.stars.vertices().len()],
            loops: vec![[0.0; 2]; self.terms.stars.holes().len()],
        }
    }

    /// Returns `true` if hinges of the present curves, made between these configurations, are too fast, and more knots
    /// between could mend that. They cannot if a hinge is too fast at one of the two: while one hinge rests at its
    /// limit, others may be faster than the time law allows.
    fn is_hasty(&self, maker: &Maker<'_>, from: &Site, to: &Site, span: f64) -> bool {
        let haste = self.haste(maker.kind, span) / (1.0 + HASTE);
        let mut rates = maker.nodes(from).chain(maker.nodes(to));
        haste > 1.0 && rates.all(|node| node.rate.abs() < haste * self.terms.speed)
    }

    /// Returns the factor by which time has to be stretched so that the hinges of the present curves keep their limits.
    fn haste(&self, kind: Interpolation, span: f64) -> f64 {
        let peaks = self.curves.iter().map(peaks);
        let most = peaks.fold([0.0; 2], |most, peaks| {
            [0, 1].map(|k| f64::max(most[k], peaks[k]))
        });
        let speed = most[0] / (span * self.terms.speed);
        if kind == Interpolation::Linear {
            return speed;
        }
        speed.max((most[1] / (span * span * self.terms.acceleration)).sqrt())
    }

    /// Returns the waypoint of this number, which is not an end.
    fn waypoint(&mut self, index: usize) -> Site {
        let site = self.course.site(index);
        self.within_limits(site)
    }

    /// Corrects a configuration between the ends. A hinge at its limit has just reached the limit or is about to leave
    /// it, so that its rate is 0.
    fn within_limits(&mut self, mut site: Site) -> Site {
        let hinges = site.angles.iter().zip(&site.tangent);
        let limits = hinges.zip(self.terms.limits);
        let at_limit = limits.map(|((angle, rate), (lower, upper))| {
            let near = AT_LIMIT.max(RESTING * rate.abs());
            let mut limits = [*lower, *upper].into_iter();
            limits.find(|limit| (angle - limit).abs() <= near)
        });
        let at_limit: Vec<Option<f64>> = at_limit.collect();
        let mut rates = at_limit.iter().zip(&site.tangent);
        if rates.any(|(limit, rate)| limit.is_some() && rate.abs() > 0.0) {
            let angles = site.angles.iter().zip(&at_limit);
            let angles: Vec<f64> = angles.map(|(a, limit)| limit.unwrap_or(*a)).collect();
            let held = self.solver.project_on_motions(&angles, &mut site.tangent);
            if held.is_none() {
                site.tangent.fill(0.0);
            }
            let rates = site.tangent.iter_mut().zip(&at_limit);
            rates
                .filter(|(_, limit)| limit.is_some())
                .for_each(|(rate, _)| *rate = 0.0);
        }
        site
    }

    /// Returns a configuration between two others, if they are far enough apart.
    fn between(&mut self, from: &Site, to: &Site) -> Option<Site> {
        if let Some(index) = self.course.waypoint_between(from.way, to.way) {
            return Some(self.waypoint(index));
        }
        let middle = (from.way + to.way) / 2.0;
        let ways = self.course.ways();
        let next = ways.partition_point(|way| *way <= middle);
        let around = ways.get(next)? - ways.get(next.checked_sub(1)?)?;
        if to.way - from.way <= NARROWEST * around {
            return None;
        }
        self.site_at(middle)
    }

    /// Returns the closed configuration at a path length.
    fn site_at(&mut self, way: f64) -> Option<Site> {
        let known = self
            .found
            .iter()
            .find(|site| site.way.to_bits() == way.to_bits());
        if let Some(site) = known {
            return Some(site.clone());
        }
        let site = self.course.closed(self.solver, way)?;
        let site = self.within_limits(site);
        self.found.push(site.clone());
        Some(site)
    }

    /// Makes the knots at these configurations, with time stretched so that no hinge is too fast.
    fn knots(&mut self, maker: &Maker<'_>, sites: &[Site]) -> Option<Placed> {
        let (mut bounds, mut open) = (self.closed(), None);
        let most = self.terms.closure.unwrap_or(f64::INFINITY);
        let mut stretch = 0.0;
        for (segment, pair) in sites.windows(2).enumerate() {
            let span = self.span(maker, &pair[0], &pair[1])?;
            let known = self.known.remove(&key(&pair[0], &pair[1]));
            let deforms = known.is_none() && !self.deforms_within(|folded| folded.bound);
            let here = known.unwrap_or_else(|| self.bounds());
            if open.is_none() && (deforms || here.closure().worst() > most) {
                open = Some(Open {
                    segment,
                    way: pair[0].way,
                    before: bounds.clone(),
                });
            }
            bounds.take_in(&here);
            stretch = f64::max(stretch, self.haste(maker.kind, span));
        }
        stretch *= 1.0 + MARGIN;
        let start = maker.pace.at(&sites[0])[0];
        let knots = sites.iter().map(|site| {
            let nodes: Vec<Node<f64>> = maker.nodes(site).collect();
            let homogeneous = maker.kind == Interpolation::Homogeneous;
            let weights = nodes.iter().filter(|_| homogeneous);
            Knot {
                time: (maker.pace.at(site)[0] - start) * stretch,
                angles: site.angles.clone(),
                rates: nodes.iter().map(|node| node.rate / stretch).collect(),
                weights: weights
                    .map(|node| [node.weight[0], node.weight[1] / stretch])
                    .collect(),
                ends_phase: site.ends_phase,
                ..Knot::default()
            }
        });
        Some(Placed {
            interpolation: maker.kind,
            knots: knots.collect(),
            bounds,
            open,
        })
    }
}

/// Returns the key of the segment between two configurations.
fn key(from: &Site, to: &Site) -> [u64; 2] {
    [from, to].map(|site| site.way.to_bits())
}

/// Makes the curves between configurations.
struct Maker<'a> {
    kind: Interpolation,
    pace: &'a Pace,
    /// Group whose half angle's cosine all groups share in homogeneous half angles; `None` for tangents of half angles.
    lead: Option<usize>,
}

impl<'a> Maker<'a> {
    fn new(course: &Course, kind: Interpolation, pace: &'a Pace) -> Self {
        let last = course.site(course.ways().len() - 1);
        let widest = |group: &usize| last.angles[*group].abs();
        let lead = match pace {
            Pace::Angle(lead) => Some(*lead),
            Pace::HalfAngle(_) => None,
            _ => (0..last.angles.len()).max_by(|a, b| widest(a).total_cmp(&widest(b))),
        };
        Self { kind, pace, lead }
    }

    /// Makes the curves between two configurations, and returns the time between them. Returns `None` if a
    /// configuration is not on its curve, or time stands still there or runs backwards.
    fn curves(&self, from: &Site, to: &Site, curves: &mut Vec<Curve<f64>>) -> Option<f64> {
        let span = self.pace.at(to)[0] - self.pace.at(from)[0];
        curves.clear();
        let nodes = self.nodes(from).zip(self.nodes(to));
        curves.extend(nodes.map(|(from, to)| Curve::between(self.kind, span, from, to)));
        let passes = span > 0.0
            && [from, to].into_iter().all(|site| {
                let tangents = self.kind == Interpolation::HalfAngle;
                let sharp = !tangents || max_norm(&site.angles) < PI - BLUNT;
                sharp && self.pace.at(site)[1].is_finite()
            });
        passes.then_some(span)
    }

    /// Returns one node for each group.
    fn nodes<'n>(&'n self, site: &'n Site) -> impl Iterator<Item = Node<f64>> + 'n {
        let speed = self.pace.at(site)[1];
        (0..site.angles.len()).map(move |group| Node {
            angle: site.angles[group],
            rate: site.tangent[group] * speed,
            weight: if self.kind == Interpolation::Homogeneous {
                self.weight(site, group, speed)
            } else {
                [1.0, 0.0]
            },
        })
    }

    /// Returns the weight of a homogeneous half angle and the rate of the weight. The cosines of all groups are the
    /// same function of time, that of the lead, so that groups whose tangents of half angles keep their ratio move
    /// exactly.
    fn weight(&self, site: &Site, group: usize, speed: f64) -> [f64; 2] {
        let (sin, cos) = (site.angles[group] / 2.0).sin_cos();
        let turn = site.tangent[group] * speed / 2.0;
        let (lead_cos, lead_rate) = match self.lead {
            Some(lead) => {
                let (sin, cos) = (site.angles[lead] / 2.0).sin_cos();
                (cos, -sin * site.tangent[lead] * speed / 2.0)
            }
            None => (1.0, 0.0),
        };
        if cos.abs() < FOLDED_FLAT || lead_cos.abs() < FOLDED_FLAT {
            // Both cosines vanish, and their ratio is that of the rates.
            let ratio = self
                .lead
                .map_or(1.0, |lead| (site.tangent[lead] / site.tangent[group]).abs());
            let sound = ratio.is_finite() && ratio > 0.0;
            return [if sound { ratio } else { 1.0 }, 0.0];
        }
        let weight = lead_cos / cos;
        [weight, (lead_rate + weight * turn * sin) / cos]
    }
}

/// Cosine of half an angle below which the angle is half a turn.
const FOLDED_FLAT: f64 = 1e-6;
