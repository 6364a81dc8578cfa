//! Do planned motions follow the closed forms of their families? Compares knots, rates and the motion between knots.

use foldpath::generate::{Miura, Waterbomb, Yoshimura};
use foldpath::motion::{self, Knot};
use foldpath::pattern::{CreasePattern, Drawing, VertexId};
use foldpath::planner::{Goal, Outcome, PlanOptions, plan};
use foldpath_core::{Curve, Interpolation, Membership, Node};
use foldpath_tests::closed_form::{self, miura_straight, yoshimura_diagonal};
use foldpath_tests::worst;

/// A motion that is known in closed form.
struct Motion {
    name: String,
    drawing: Drawing,
    /// Returns the absolute fold angle of the crease between two points, by the absolute angle of the leading creases,
    /// radians.
    closed: Box<dyn Fn([[f64; 2]; 2], f64) -> f64>,
    /// Returns `true` if the crease between two points is a leading one.
    leads: fn([[f64; 2]; 2]) -> bool,
}

fn level([[_, y], [_, other_y]]: [[f64; 2]; 2]) -> bool {
    (other_y - y).abs() < 1e-9
}

fn upright([[x, _], [other_x, _]]: [[f64; 2]; 2]) -> bool {
    (other_x - x).abs() < 1e-9
}

/// Returns a Miura sheet whose zigzag creases lead, to `goal`; angles in degrees.
fn miura(sector_angle: f64, goal: f64) -> Motion {
    let miura = Miura {
        rows: 3,
        columns: 4,
        sector_angle: sector_angle.to_radians(),
        fold: goal / 180.0,
    };
    let straight = move |zigzag| miura_straight(sector_angle.to_radians(), zigzag);
    Motion {
        name: format!("Miura, sectors of {sector_angle}, to {goal} degrees"),
        drawing: miura.drawing().unwrap(),
        closed: Box::new(move |ends, lead| if level(ends) { straight(lead) } else { lead }),
        leads: |ends| !level(ends),
    }
}

/// Returns a waterbomb whose middle lines lead; `goal` is that of the boundary lines, degrees.
fn waterbomb(goal: f64) -> Motion {
    let waterbomb = Waterbomb {
        rows: 4,
        columns: 6,
        fold: goal / 180.0,
    };
    Motion {
        name: format!("waterbomb to {goal} degrees"),
        drawing: waterbomb.drawing().unwrap(),
        closed: Box::new(|ends, lead| {
            closed_form::Waterbomb::at((lead / 2.0).tan())
                .of_crease(ends)
                .abs()
        }),
        leads: |ends| {
            let at_one = closed_form::Waterbomb::at(1.0);
            (at_one.of_crease(ends) - at_one.middle).abs() < 1e-9
        },
    }
}

/// Returns a Yoshimura sheet whose straight creases lead, to `goal`; angles in degrees.
fn yoshimura(gamma: f64, goal: f64) -> Motion {
    let yoshimura = Yoshimura {
        rows: 4,
        columns: 5,
        angle: gamma.to_radians(),
        fold: goal / 180.0,
    };
    let diagonal = move |straight| yoshimura_diagonal(gamma.to_radians(), straight).abs();
    Motion {
        name: format!("Yoshimura, diagonals at {gamma}, to {goal} degrees"),
        drawing: yoshimura.drawing().unwrap(),
        closed: Box::new(move |ends, lead| if upright(ends) { lead } else { diagonal(lead) }),
        leads: upright,
    }
}

/// A motion and its plan.
struct Planned {
    path: motion::Motion,
    /// Group and sign of each crease.
    memberships: Vec<Membership>,
    leader: usize,
    ends: Vec<[[f64; 2]; 2]>,
    /// Signs of the assignments: valley 1, mountain -1.
    signs: Vec<f64>,
    motion: Motion,
}

impl Planned {
    fn new(motion: Motion, interpolation: Option<Interpolation>) -> Self {
        let pattern = CreasePattern::new(motion.drawing.clone()).unwrap();
        let goal = Goal::of_pattern(&pattern).unwrap();
        let options = PlanOptions::default().with(|it| it.interpolation = interpolation);
        let plan = plan(&pattern, &goal, &options);
        assert_eq!(
            plan.outcome,
            Outcome::Planned,
            "{}: {:?}",
            motion.name,
            plan.reason
        );
        let edges = || pattern.creases().iter().map(|&edge| pattern.edge(edge));
        let place = |vertex: VertexId| pattern.vertices()[vertex.index()].into();
        let ends: Vec<_> = edges().map(|edge| edge.ends.map(place)).collect();
        Self {
            memberships: plan.motion.as_ref().unwrap().memberships(),
            path: plan.motion.unwrap(),
            leader: ends.iter().position(|&ends| (motion.leads)(ends)).unwrap(),
            signs: edges().map(|edge| edge.letter.sign()).collect(),
            ends,
            motion,
        }
    }

    /// Returns the angles of all creases by those of the groups, or their rates by the groups' rates.
    fn creases(&self, groups: &[f64]) -> Vec<f64> {
        let memberships = self.memberships.iter();
        memberships
            .map(|m| m.apply(groups[m.group.index()]))
            .collect()
    }

    /// Returns the closed form's angles of all creases by the angle of the leading creases.
    fn closed(&self, lead: f64) -> Vec<f64> {
        let creases = self.ends.iter().zip(&self.signs);
        creases
            .map(|(&ends, sign)| sign * (self.motion.closed)(ends, lead))
            .collect()
    }

    /// Returns the largest difference from the closed form.
    fn error(&self, groups: &[f64]) -> f64 {
        let creases = self.creases(groups);
        let closed = self.closed(creases[self.leader].abs());
        worst(
            creases
                .iter()
                .zip(closed)
                .map(|(angle, closed)| (angle - closed).abs()),
        )
    }

    /// Returns the largest difference of the rates from the tangent of the closed form, both divided by the leaders'
    /// rate.
    fn rate_error(&self, groups: &[f64], rates: &[f64]) -> f64 {
        const H: f64 = 1e-6;
        let lead = self.creases(groups)[self.leader].abs();
        let [before, after] = [(lead - H).max(0.0), lead + H].map(|lead| (lead, self.closed(lead)));
        let rates = self.creases(rates);
        let errors = rates
            .iter()
            .zip(before.1.iter().zip(&after.1))
            .map(|(rate, (from, to))| {
                let slope = (to - from) / (after.0 - before.0);
                (rate / rates[self.leader].abs() - slope).abs()
            });
        worst(errors)
    }

    /// Returns this motion with one more knot in the middle of each segment. The leaders move as before; the closed
    /// form gives the angles of the other creases.
    fn refined(mut self) -> Self {
        const H: f64 = 1e-6;
        let leader = self.memberships[self.leader];
        let mut knots = Vec::new();
        for pair in self.path.knots.windows(2) {
            let node = |knot: &Knot| Node {
                angle: knot.angles[leader.group.index()],
                rate: knot.rates[leader.group.index()],
                weight: [1.0, 0.0],
            };
            let span = pair[1].time - pair[0].time;
            let curve =
                Curve::between(Interpolation::Hermite, span, node(&pair[0]), node(&pair[1]));
            let lead = leader.apply(curve.angle(0.5));
            let rate = leader.apply(curve.derivatives(0.5)[0]) / span;
            let [before, at, after] = [-H, 0.0, H].map(|h| self.closed(lead.abs() + h));
            let (mut angles, mut rates) = (pair[0].angles.clone(), pair[0].rates.clone());
            for (crease, member) in self.memberships.iter().enumerate() {
                let slope = (after[crease] - before[crease]) / (2.0 * H) * lead.signum();
                angles[member.group.index()] = member.apply(at[crease]);
                rates[member.group.index()] = member.apply(slope * rate);
            }
            let middle = Knot {
                time: pair[0].time + span / 2.0,
                angles,
                rates,
                ..Knot::default()
            };
            knots.extend([pair[0].clone(), middle]);
        }
        knots.extend(self.path.knots.last().cloned());
        self.path.knots = knots;
        self
    }

    /// Returns the largest difference from the closed form at 99 points of each segment.
    fn error_between_knots(&self) -> f64 {
        let curves = (0..self.path.segments()).map(|segment| self.path.curves(segment).collect());
        let curves: Vec<Vec<Curve<f64>>> = curves.collect();
        let points = curves.iter().flat_map(|segment| {
            (1..100).map(move |k| {
                let s = f64::from(k) / 100.0;
                segment
                    .iter()
                    .map(|curve| curve.angle(s))
                    .collect::<Vec<_>>()
            })
        });
        worst(points.map(|groups| self.error(&groups)))
    }
}

/// Returns Miura sheets of several sector angles and goals of the zigzag creases, degrees.
fn miuras() -> impl Iterator<Item = Motion> {
    let goals = [90.0, 150.0, 170.0, 179.9];
    let sectors = [30.0, 45.0, 60.0, 75.0, 85.0];
    sectors
        .into_iter()
        .flat_map(move |sector| goals.map(|goal| miura(sector, goal)))
}

/// Returns waterbombs and Yoshimura sheets. Yoshimura sheets with steeper diagonals or farther goals meet themselves.
fn others() -> impl Iterator<Item = Motion> {
    let waterbombs = [30.0, 90.0, 120.0, 170.0].map(waterbomb);
    let yoshimuras = [
        (20.0, 80.0),
        (30.0, 10.0),
        (30.0, 80.0),
        (45.0, 80.0),
        (60.0, 45.0),
    ];
    let yoshimuras = yoshimuras.map(|(gamma, goal)| yoshimura(gamma, goal));
    waterbombs.into_iter().chain(yoshimuras)
}

#[test]
fn knots_lie_on_the_closed_form() {
    let motions = miuras()
        .map(|motion| (motion, 1e-12))
        .chain(others().map(|motion| (motion, 1e-11)));
    for (motion, limit) in motions {
        let planned = Planned::new(motion, None);
        for (index, knot) in planned.path.knots.iter().enumerate() {
            let error = planned.error(&knot.angles);
            assert!(
                error <= limit,
                "{}, knot {index}: {error:e}",
                planned.motion.name
            );
        }
    }
}

/// The rates are right up to the error of finite differences. At flat, where the closure conditions fix no direction,
/// they are right up to the error of a secant.
#[test]
fn rates_lie_along_the_closed_form() {
    for motion in miuras().chain(others()) {
        let planned = Planned::new(motion, None);
        for (index, knot) in planned.path.knots.iter().enumerate() {
            let error = planned.rate_error(&knot.angles, &knot.rates);
            let limit = if index == 0 { 1e-6 } else { 1e-8 };
            assert!(
                error <= limit,
                "{}, knot {index}: {error:e}",
                planned.motion.name
            );
        }
    }
}

/// Half the step leaves a sixteenth of the error.
#[test]
fn hermite_interpolation_is_of_fourth_order() {
    for motion in miuras().chain(others()) {
        let planned = Planned::new(motion, Some(Interpolation::Hermite));
        let coarse = planned.refined().refined();
        let (error, name) = (coarse.error_between_knots(), coarse.motion.name.clone());
        let fine = coarse.refined().error_between_knots();
        println!("{name}: {error:e} to {fine:e}");
        assert!(error > 1e-12, "{name}: {error:e} is rounding");
        assert!(fine <= error / 10.0, "{name}: {error:e} to {fine:e}");
    }
}

/// Tangents of half angles keep their ratio, so that interpolation in half angles is exact.
#[test]
fn half_angles_are_exact_for_miuras() {
    for motion in miuras() {
        let planned = Planned::new(motion, Some(Interpolation::HalfAngle));
        let (error, name) = (planned.error_between_knots(), &planned.motion.name);
        assert!(error <= 1e-12, "{name}: {error:e}");
    }
}
