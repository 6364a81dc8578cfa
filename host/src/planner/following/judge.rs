//! Judges configurations on the whole sheet, to which a path found on few unknowns is lifted.

use nalgebra::Vector3;

use super::reduction::Reduction;
use crate::collision::{CollisionScene, Crossing, SweepCounts};
use crate::folding::{FoldingMap, Rigidity, SpanningTree};
use crate::motion::Knot;
use crate::pattern::{CreaseId, CreasePattern, FaceId};
use crate::planner::PlanOptions;
use crate::planner::problem::PlanningProblem;
use crate::symmetry::essential_pattern;

/// A whole sheet that is folded at one configuration after another.
pub(crate) struct Judge<'a> {
    pattern: &'a CreasePattern,
    reduction: &'a Reduction<'a>,
    map: FoldingMap,
    /// Depth up to which an overlap of faces is contact, median edges.
    contact: f64,
    scene: Option<CollisionScene>,
}

impl<'a> Judge<'a> {
    pub(crate) fn new(
        problem: &PlanningProblem<'a>,
        reduction: &'a Reduction<'a>,
        collision: bool,
    ) -> Self {
        let pattern = problem.pattern;
        Self {
            pattern,
            reduction,
            map: FoldingMap::flat(pattern),
            contact: problem.contact,
            scene: collision.then(|| CollisionScene::new(pattern)),
        }
    }

    /// Returns this judge for crossings of the plates that phases have to be free for, if any are.
    pub(crate) fn of_plates(self, problem: &PlanningProblem<'_>) -> Self {
        let scene = self.scene.map(|thin| match problem.plates {
            Some(plates) => CollisionScene::of_plates(problem.pattern, Some(plates)),
            None => thin,
        });
        Self { scene, ..self }
    }

    /// Folds the sheet by these group angles, and returns its errors; the twist is the closure residual, if that is larger.
    pub(crate) fn errors_at(&mut self, angles: &[f64]) -> Rigidity {
        self.place(angles);
        let rigidity = self.map.rigidity(self.pattern, self.reduction.tree);
        let closure = self.reduction.closure_of_sheet(angles);
        Rigidity {
            twist: closure.max(rigidity.twist),
            ..rigidity
        }
    }

    /// Returns `true` if the sheet closes at these fold angles of the creases (radians), and no faces cross.
    pub(crate) fn is_free(&mut self, creases: &[f64], options: &PlanOptions) -> bool {
        let errors = self.errors_at(&self.reduction.groups.reduce_all(creases));
        self.crossing().is_none() && errors.twist <= self.reduction.closure_tolerance(options)
    }

    /// Returns the positions of the vertices as the sheet was folded last.
    pub(crate) fn vertices(&self) -> &[Vector3<f64>] {
        self.map.vertices()
    }

    /// Returns the deepest crossing at these group angles, if crossings are looked for.
    pub(crate) fn crossing_at(&mut self, angles: &[f64]) -> Option<Crossing> {
        self.place(angles);
        self.crossing()
    }

    /// Returns the deepest crossing at these fold angles of the creases (radians), if crossings are looked for. Faces of one
    /// body, given for each face, are not compared.
    pub(crate) fn crossing_of_bodies(
        &mut self,
        creases: &[f64],
        bodies: &[FaceId],
    ) -> Option<Crossing> {
        self.place(&self.reduction.groups.reduce_all(creases));
        let scene = self.scene.as_mut()?;
        scene.deepest_crossing_of(&self.map, self.contact, |[a, b]| {
            bodies[a.index()] != bodies[b.index()]
        })
    }

    /// Folds the sheet by these group angles.
    fn place(&mut self, angles: &[f64]) {
        let (tree, groups) = (self.reduction.tree, &self.reduction.groups);
        self.map
            .fold_groups(self.pattern, tree, groups.memberships(), angles);
    }

    /// Returns the number of pairs that the searches for crossings looked at and skipped.
    pub(crate) fn counts(&self) -> SweepCounts {
        let counts = self.scene.as_ref().map(CollisionScene::counts);
        counts.unwrap_or_default()
    }

    /// Returns the deepest crossing of the sheet as it was folded last, if crossings are looked for.
    pub(crate) fn crossing(&mut self) -> Option<Crossing> {
        let scene = self.scene.as_mut()?;
        scene.deepest_crossing(&self.map, self.contact)
    }

    /// Returns the largest deformation and gap of the essential crease pattern over some configurations, and its number
    /// of faces.
    pub(crate) fn essential<'k>(
        &self,
        configurations: impl Iterator<Item = &'k [f64]>,
    ) -> (Rigidity, usize) {
        let Some(mut part) = Part::of(self.pattern, self.reduction) else {
            return (Rigidity::default(), 0);
        };
        let mut worst = Rigidity::default();
        for angles in configurations {
            part.fold(self.reduction, angles);
            worst = worst.worse(part.rigidity());
        }
        (worst, part.pattern.faces().len())
    }

    /// Returns `true` if the essential crease pattern keeps a bound on deformation and gap in all configurations, folded
    /// along one of several spanning trees. Which tree that is hangs on how the sheet is drawn, and so must not decide.
    pub(crate) fn keeps_essentially<'k>(
        &self,
        bound: f64,
        configurations: impl Iterator<Item = &'k [f64]> + Clone,
    ) -> bool {
        let Some(mut part) = Part::of(self.pattern, self.reduction) else {
            return true;
        };
        SpanningTree::diverse(&part.pattern).iter().any(|tree| {
            configurations.clone().all(|angles| {
                let angles = part.creases_at(self.reduction, angles);
                part.map.fold(&part.pattern, tree, &angles);
                let Rigidity {
                    deformation, gap, ..
                } = part.map.rigidity(&part.pattern, tree);
                deformation <= bound && gap <= bound
            })
        })
    }

    /// Returns the first knot at which faces cross, and the deepest crossing of the whole sheet there. If vertices
    /// close `alike`, knots without a crossing of the essential crease pattern are skipped, as faces round all other
    /// vertices cross only if those round its vertices do.
    pub(crate) fn first_crossing(
        &mut self,
        knots: &[Knot],
        alike: bool,
    ) -> Option<(usize, Crossing)> {
        let mut part = alike
            .then(|| Part::of(self.pattern, self.reduction))
            .flatten();
        let mut scene = part.as_ref().map(|part| CollisionScene::new(&part.pattern));
        knots.iter().enumerate().find_map(|(index, knot)| {
            if let (Some(part), Some(scene)) = (&mut part, &mut scene) {
                part.fold(self.reduction, &knot.angles);
                scene.deepest_crossing(&part.map, self.contact)?;
            }
            let whole = || CollisionScene::new(self.pattern);
            self.scene.get_or_insert_with(whole);
            Some((index, self.crossing_at(&knot.angles)?))
        })
    }
}

/// The essential crease pattern, folded.
struct Part {
    pattern: CreasePattern,
    creases: Vec<CreaseId>,
    map: FoldingMap,
}

impl Part {
    fn of(sheet: &CreasePattern, reduction: &Reduction) -> Option<Self> {
        let (pattern, creases) = essential_pattern(sheet, &reduction.all).ok()?;
        Some(Self {
            map: FoldingMap::flat(&pattern),
            pattern,
            creases,
        })
    }

    /// Folds the essential crease pattern by these group angles.
    fn fold(&mut self, reduction: &Reduction, angles: &[f64]) {
        let angles = self.creases_at(reduction, angles);
        self.map.fold(&self.pattern, self.pattern.tree(), &angles);
    }

    /// Returns the angles of its creases at these group angles.
    fn creases_at(&self, reduction: &Reduction, angles: &[f64]) -> Vec<f64> {
        let angle = |crease: &CreaseId| {
            let membership = reduction.groups.of(*crease);
            membership.apply(angles[membership.group.index()])
        };
        self.creases.iter().map(angle).collect()
    }

    fn rigidity(&self) -> Rigidity {
        self.map.rigidity(&self.pattern, self.pattern.tree())
    }
}
