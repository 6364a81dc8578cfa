//! From a course to knots: as few as the bound on closure between them, the speed and the acceleration
//! of the hinges allow.

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

/// What the motion between knots has to keep.
pub(super) struct Terms<'a> {
    /// One star for each distinct closure condition, and the loops round holes.
    pub(super) stars: &'a ReducedStars,
    /// Largest closure residual; with `None`, any, and all waypoints are knots.
    pub(super) closure: Option<f64>,
    /// What the whole sheet is to keep, if it is asked.
    pub(super) folded: Option<Folded<'a>>,
    /// Lower and upper bound of each group angle, radians.
    pub(super) limits: &'a [(f64, f64)],
    /// Largest speed of a hinge, radians per second.
    pub(super) speed: f64,
    /// Largest acceleration of a hinge, radians per second squared; infinite for any.
    pub(super) acceleration: f64,
    /// Knots beyond which to give up.
    pub(super) most: usize,
}

/// Deformation and gap that a whole sheet is to keep.
#[derive(Clone)]
pub(super) struct Folded<'a> {
    pub(super) certifier: FoldingCertifier<'a>,
    /// As long as knots between bring it there.
    pub(super) aim: f64,
    /// In any case.
    pub(super) bound: f64,
}

/// How time runs along the course.
enum Pace {
    /// As fast as speed and acceleration of the hinges allow.
    Optimal(Law),
    /// In proportion to the angle of this group.
    Angle(usize),
    /// In proportion to the tangent of half the angle of this group.
    HalfAngle(usize),
    /// In proportion to the way in group angles.
    Way,
}

impl Pace {
    /// Time at a place, and the speed there: way per time.
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

/// Knots, what they are joined by, and what is certain of the motion.
pub(super) struct Placed {
    pub(super) interpolation: Interpolation,
    pub(super) knots: Vec<Knot>,
    /// On the closure over the whole motion.
    bounds: Bounds,
    /// Where it first does not close as it is to.
    open: Option<Open>,
}

/// The first segment of a motion that does not close as it is to.
struct Open {
    segment: usize,
    /// Way to its start.
    way: f64,
    /// Bounds on the closure before it.
    before: Bounds,
}

/// Bounds on the closure over some of the motion.
#[derive(Clone)]
struct Bounds {
    /// Of each star.
    stars: Vec<f64>,
    /// Of the rotation and the translation of each loop.
    loops: Vec<[f64; 2]>,
}

impl Bounds {
    fn closure(&self) -> Closure<'_> {
        Closure {
            stars: &self.stars,
            loops: &self.loops,
        }
    }

    /// Those over this and over another part of the motion.
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

    /// Leaves only the segments before the first that does not close as it is to; whether there is one.
    pub(super) fn cut(&mut self) -> bool {
        let Some(open) = self.open.take() else {
            return false;
        };
        self.knots.truncate(open.segment + 1);
        self.bounds = open.before;
        true
    }

    /// Way as far as which it closes as it is to.
    fn closes_to(&self) -> f64 {
        self.open.as_ref().map_or(f64::INFINITY, |open| open.way)
    }

    /// Seconds from the first knot to the last.
    fn duration(&self) -> f64 {
        self.knots.last().map_or(0.0, |last| last.time)
    }
}

/// The knots of a course: with the interpolation asked for, or that which needs the fewest. Homogeneous half
/// angles, which other programs do not know, only where they save most. `None` if none does with the most
/// allowed.
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
        // Nothing to close: hinges turn evenly. Nothing that closes: none is nearer to it, and this one is followed best.
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

/// The fastest pace of a course.
fn fastest(course: &Course, terms: &Terms<'_>) -> Pace {
    let groups = terms.limits.len();
    let parts = (GRID / groups.max(1)).clamp(1, PARTS);
    match course.fastest(parts, terms) {
        Ok(law) => Pace::Optimal(law),
        Err(_) => Pace::Way,
    }
}

/// Ways to let time run with which an interpolation may need few knots.
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

/// Knots that are few.
const FEW: usize = 12;
/// Factor in knots for which homogeneous half angles are worth it.
const WORTH: usize = 4;
/// Places between two waypoints at which the fastest motion is looked at, at most.
const PARTS: usize = 8;
/// Entries of all groups between two waypoints beyond which it is looked at in fewer places.
const GRID: usize = 4096;
/// Groups that are tried as the one whose half angle time goes by.
const LEADS: usize = 8;

/// Places knots on a course.
struct Placer<'a, 's> {
    course: &'a Course,
    terms: &'a Terms<'a>,
    solver: &'a mut ClosureSolver<'s>,
    /// Knots beyond which to give up.
    most: usize,
    certifier: SegmentCertifier,
    folded: Option<Folded<'a>>,
    /// Configurations found on the course apart from its waypoints.
    found: Vec<Site>,
    curves: Vec<Curve<f64>>,
    /// Bounds on the closure of segments that keep the terms, by the ways of their ends.
    known: HashMap<[u64; 2], Bounds>,
}

/// Part by which a hinge may exceed its limits before the time is stretched in the end.
const HASTE: f64 = 0.02;
/// Part by which the time is stretched more, so that rounding the knots passes no limit.
const MARGIN: f64 = 1e-5;
/// Part of the distance of the two waypoints around them below which no knot is put between two others.
const NARROWEST: f64 = 1.0 / 256.0;
/// Way in which a hinge that would be at its limit rests there: where others move on, solving moves it to and fro.
const RESTING: f64 = 1e-4;
/// Radians: this near half a turn, the digits that an angle is written with leave too few of its half angle's tangent for
/// what is proved of it to be proved again.
const BLUNT: f64 = 1e-4;
/// Radians: a hinge this far beyond its limit is at it.
const AT_LIMIT: f64 = 1e-9;

/// Whether a hinge keeps its limits all along its curve.
fn is_within((curve, limit): (&Curve<f64>, &(f64, f64))) -> bool {
    let [lower, upper] = range(curve);
    lower >= limit.0 - AT_LIMIT && upper <= limit.1 + AT_LIMIT
}

impl Placer<'_, '_> {
    /// The only configuration of a course that goes nowhere.
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

    /// The fewest knots found with this interpolation and pace. What cannot be kept with knots as dense as
    /// they get is said by the bound on closure. `None` if that takes too many, or the interpolation does
    /// not pass where the course does.
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
        // Where the motion rests, where a phase ends, and where accelerations jump, knots are needed first of all.
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

    /// Lets a hinge rest at two knots between which it would turn beyond its limits, as it does on a motion that closes
    /// only roughly: it then turns from one angle to the other and no farther.
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

    /// Takes knots away while what is left keeps the terms.
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

    /// Makes the curves between two places, and returns the time between them. `None` if there are none, or out of time.
    fn span(&mut self, maker: &Maker<'_>, from: &Site, to: &Site) -> Option<f64> {
        if self.solver.is_late() {
            return None;
        }
        maker.curves(from, to, &mut self.curves)
    }

    /// Whether the motion between two places keeps the terms.
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
        // Most of what does not close enough is seen in the middle.
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

    /// Whether the whole sheet deforms by no more than this over the present curves, if it is asked.
    fn deforms_within(&mut self, most: fn(&Folded<'_>) -> f64) -> bool {
        let Some(folded) = &mut self.folded else {
            return true;
        };
        let most = most(folded);
        folded.certifier.rigidity(&self.curves, most).is_some()
    }

    /// Bounds on the closure over the present curves.
    fn bounds(&mut self) -> Bounds {
        let stars = self.terms.stars;
        let (stars, loops) = (stars.view(), stars.loops());
        let Closure { stars, loops } = self.certifier.closure(stars, loops, &self.curves);
        Bounds {
            stars: stars.to_vec(),
            loops: loops.to_vec(),
        }
    }

    /// Those where nothing moves.
    fn closed(&self) -> Bounds {
        Bounds {
            stars: vec![0.0; self.terms.stars.vertices().len()],
            loops: vec![[0.0; 2]; self.terms.stars.holes().len()],
        }
    }

    /// Whether the hinges of the present curves, made between these places, are too fast by more than knots between
    /// could mend: at these already, one that rests at its limit may leave the others faster than they were paced.
    fn is_hasty(&self, maker: &Maker<'_>, from: &Site, to: &Site, span: f64) -> bool {
        let haste = self.haste(maker.kind, span) / (1.0 + HASTE);
        let mut rates = maker.nodes(from).chain(maker.nodes(to));
        haste > 1.0 && rates.all(|node| node.rate.abs() < haste * self.terms.speed)
    }

    /// How much too fast the hinges of the present curves are: the factor by which time has to be
    /// stretched.
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

    /// The waypoint of that number between the ends.
    fn waypoint(&mut self, index: usize) -> Site {
        let site = self.course.site(index);
        self.within_limits(site)
    }

    /// A configuration between the ends. A hinge at its limit there has come to it or leaves it: it does
    /// neither at speed.
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

    /// A configuration between two.
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

    /// The configuration at a place.
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

    /// The knots at these places, with the time stretched so that no hinge is too fast.
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

/// Names the segment between two places.
fn key(from: &Site, to: &Site) -> [u64; 2] {
    [from, to].map(|site| site.way.to_bits())
}

/// Makes the curves between places.
struct Maker<'a> {
    kind: Interpolation,
    pace: &'a Pace,
    /// The group whose half angle's cosine all share, for homogeneous ones; none for tangents.
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

    /// The curves between two places, and the time between them. `None` if one is not on its curve, or time
    /// stands still there or runs back.
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

    /// One node a group.
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

    /// Weight of a homogeneous half angle and its rate. The cosines of all groups are the same function of
    /// time, that of the lead: then groups whose tangents of half angles keep their ratio move exactly.
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
            // Both cosines vanish: their ratio is that of the rates.
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

/// Cosine of half an angle that is half a turn.
const FOLDED_FLAT: f64 = 1e-6;
