//! A planned fold in the form in which it is streamed.

use std::path::Path;

use foldpath::export::fold::motion_text;
use foldpath::export::traj::TrajFile;
use foldpath::planner::PlanOptions;
use foldpath::read::read_pattern;
use foldpath::symmetry::{CreaseGroups, ReducedStars};
use foldpath_core::acceptance::{Setpoint, SheetView};
use foldpath_core::follower::{CheckedOptions, Follower, FollowerPosition};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::trajectory_file::TrajectoryFile;
use foldpath_core::wire::path::PathItems;
use foldpath_core::{
    GroupLimits, HalfAngle, Interpolation, Membership, Objective, Scalar, Spoke, StarsView,
};
use foldpath_tests::{Planned, path_file, pattern_file};

/// Largest closure residual that a commanded configuration may have.
pub(crate) const CLOSURE: f32 = 1e-4;

/// A fold of two groups that owns its memory.
pub(crate) struct Fold {
    interpolation: Interpolation,
    spans: Vec<f32>,
    angles: Vec<f32>,
    rates: Vec<f32>,
    limits: Vec<GroupLimits>,
    hinges: Vec<Membership>,
    spokes: Vec<Spoke<f32>>,
    ends: Vec<u32>,
}

impl Fold {
    /// Plans and exports a Miura fold of 24 x 24 faces with 1,104 hinges. The fold takes 2.6 seconds.
    pub(crate) fn miura() -> Self {
        let options = PlanOptions::default().with(|it| {
            it.interpolation = Some(Interpolation::Hermite);
            it.max_speed = 1.5;
            it.max_acceleration = Some(6.0);
            it.collision = false;
        });
        let file = read_pattern(&pattern_file("miura-24x24")).unwrap();
        let groups = CreaseGroups::find(&file.pattern);
        let stars = ReducedStars::all(&file.pattern, &groups).essential();
        let planned = Planned::of(file, &options);
        let path = path_file(&motion_text(planned.plan.motion.as_ref().unwrap())).unwrap();
        let bytes = TrajFile::of(&path, Path::new("path.fold")).unwrap().bytes;
        let file = TrajectoryFile::read(&bytes).unwrap();
        assert_eq!((file.groups(), file.hinges()), (2, 1104));
        assert!(file.memberships().eq(groups.memberships().iter().copied()));
        let places = (0..file.len()).flat_map(|k| (0..2).map(move |g| (k, g)));
        let nodes: Vec<_> = places.map(|(k, g)| file.node(k, g).unwrap()).collect();
        let (mut spokes, mut ends) = (Vec::new(), Vec::new());
        for star in stars.view().iter() {
            spokes.extend(star.spokes.iter().map(|spoke| Spoke {
                group: spoke.group,
                negative: spoke.negative,
                direction: spoke.direction.map(f32::lit),
            }));
            ends.push(u32::try_from(spokes.len()).unwrap());
        }
        Self {
            interpolation: file.interpolation(),
            spans: (0..file.len()).map(|k| file.span(k).unwrap()).collect(),
            angles: nodes.iter().map(|node| node.angle).collect(),
            rates: nodes.iter().map(|node| node.rate).collect(),
            limits: (0..2).map(|g| file.limits(g).unwrap()).collect(),
            hinges: file.memberships().collect(),
            spokes,
            ends,
        }
    }

    /// Returns the number of knots.
    pub(crate) fn len(&self) -> usize {
        self.spans.len()
    }

    pub(crate) fn limits(&self) -> &[GroupLimits] {
        &self.limits
    }

    /// Returns the last place of the path, and the angles at that place.
    pub(crate) fn end(&self) -> (FollowerPosition<f32>, [f32; 2]) {
        let knot = self.len() - 1;
        let place = FollowerPosition {
            knot: u32::try_from(knot).unwrap(),
            into: 0.0,
        };
        (place, [self.angles[2 * knot], self.angles[2 * knot + 1]])
    }

    /// Returns the seconds from the start of the path to a place.
    pub(crate) fn time(&self, place: FollowerPosition<f32>) -> f64 {
        let spans = &self.spans[..=place.knot as usize];
        spans
            .iter()
            .chain([&place.into])
            .map(|span| f64::from(*span))
            .sum()
    }

    pub(crate) fn view(&self) -> TrajectoryView<'_, f32> {
        TrajectoryView::new(
            self.interpolation,
            2,
            &self.spans,
            &self.angles,
            &self.rates,
            &[],
        )
        .unwrap()
    }

    fn stars(&self) -> StarsView<'_, f32> {
        StarsView::new(&self.spokes, &self.ends, 2).unwrap()
    }

    /// Returns the fold as items for the line.
    pub(crate) fn items(&self) -> PathItems<'_> {
        let place = FollowerPosition::default();
        let (limits, hinges) = (&self.limits, &self.hinges);
        PathItems::new(self.view(), limits, hinges, self.stars(), CLOSURE, place).unwrap()
    }

    /// Returns the angles that a follower on this machine commands at a place.
    pub(crate) fn follow(&self, place: FollowerPosition<f32>) -> [f32; 2] {
        let sheet = SheetView {
            interpolation: self.interpolation,
            limits: &self.limits,
            stars: self.stars(),
            closure: CLOSURE,
        };
        let mut follower = Follower::<f32, 2, 2>::new(CheckedOptions::default());
        follower.load(&sheet, place).unwrap();
        for knot in (place.knot as usize..self.len()).take(2) {
            let setpoint = Setpoint {
                number: u32::try_from(knot).unwrap(),
                span: self.spans[knot],
                last: knot + 1 == self.len(),
                nodes: (0..2).map(|group| self.node(knot, group)).collect(),
            };
            follower.accept(&sheet, setpoint).unwrap();
        }
        follower.confirm().unwrap();
        follower.start().unwrap();
        [follower.angles()[0], follower.angles()[1]]
    }

    fn node(&self, knot: usize, group: usize) -> foldpath_core::Node<f32> {
        foldpath_core::Node {
            angle: self.angles[2 * knot + group],
            rate: self.rates[2 * knot + group],
            weight: [1.0, 0.0],
        }
    }

    /// Returns the closure residual of the sheet at these angles.
    pub(crate) fn residual(&self, angles: [f32; 2]) -> f32 {
        let mut scratch = [HalfAngle::default(); 2];
        let value = Objective::Max.value(self.stars(), &angles, &mut scratch);
        value.unwrap() / 2_f32.sqrt()
    }
}
