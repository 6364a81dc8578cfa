//! A path with its sheet, as it is sent.

use std::path::Path;

use foldpath_core::follower::Place;
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::trajectory_file::TrajectoryFile;
use foldpath_core::wire::path::PathItems;
use foldpath_core::{GroupLimits, Interpolation, Membership, Scalar, Spoke, StarsView};

use crate::formats::FileError;
use crate::formats::fold::PathFile;
use crate::formats::traj::TrajFile;
use crate::pattern::CreasePattern;
use crate::symmetry::{CreaseGroups, ReducedStars};

/// Radians: sectors of stars that are equal but for the rounding of coordinates differ by less.
const SAME_SECTOR: f64 = 1e-6;
/// Closure residual that the rounding of an `f32` may give a configuration, as the controller computes it.
const FLOOR: f64 = 2e-6;
/// Places of each segment at which the residual is sampled.
const SAMPLES: u8 = 16;
/// Bytes of a setpoint's numbers that fit in a frame of 256 with all that goes with them.
const WIDEST: usize = 256 - 25;

/// A path in numbers of its own.
#[derive(Clone, Debug)]
pub struct StreamPath {
    interpolation: Interpolation,
    times: Vec<f32>,
    /// A row a knot, as the next two.
    angles: Vec<f32>,
    rates: Vec<f32>,
    weights: Vec<[f32; 2]>,
    limits: Vec<GroupLimits>,
    hinges: Vec<Membership>,
    /// Spokes of the essential vertices, and where each vertex ends.
    spokes: Vec<Spoke<f32>>,
    ends: Vec<u32>,
    /// All closure conditions; `None` if the sheet is not known.
    stars: Option<ReducedStars>,
    closure: f32,
}

impl StreamPath {
    /// The path of a FOLD animation, rounded as `export --to traj` does.
    ///
    /// # Errors
    /// If it cannot be exported, or has more groups than fit in a frame.
    pub fn of_fold(path: &PathFile, file: &Path) -> Result<Self, FileError> {
        let traj = TrajFile::of(path, file)?;
        Self::of_traj(&traj.bytes, Some(&path.pattern), file)
    }

    /// The path of the bytes of a `.traj` file, on the sheet of `pattern`. Without one the controller is given no
    /// vertices to check.
    ///
    /// # Errors
    /// If the bytes are no trajectory, its hinges are not those of the pattern, or it has more groups than
    /// fit in a frame.
    pub fn of_traj(
        bytes: &[u8],
        pattern: Option<&CreasePattern>,
        file: &Path,
    ) -> Result<Self, FileError> {
        let bad = |place: &str, expected: String, found: String| FileError::Expected {
            path: file.to_path_buf(),
            place: place.into(),
            expected,
            found,
        };
        let traj = TrajectoryFile::read(bytes)
            .map_err(|error| bad("trajectory", "a sound one".into(), error.to_string()))?;
        let hinges: Vec<Membership> = traj.memberships().collect();
        if let Some(pattern) = pattern.filter(|p| p.creases().len() != hinges.len()) {
            let expected = format!("the {} hinges of the pattern", pattern.creases().len());
            return Err(bad("hinges", expected, hinges.len().to_string()));
        }
        let (groups, width) = (traj.groups(), traj.interpolation().width());
        let places = (0..traj.len()).flat_map(|k| (0..groups).map(move |g| (k, g)));
        let nodes: Vec<_> = places.filter_map(|(k, g)| traj.node(k, g)).collect();
        let weighted = traj.interpolation() == Interpolation::Homogeneous;
        let stars = pattern.map(|pattern| {
            let groups = CreaseGroups::of_memberships(hinges.clone(), SAME_SECTOR / 4.0);
            ReducedStars::all(pattern, &groups)
        });
        let mut path = Self {
            interpolation: traj.interpolation(),
            times: (0..traj.len()).filter_map(|k| traj.time(k)).collect(),
            angles: nodes.iter().map(|node| node.angle).collect(),
            rates: nodes.iter().map(|node| node.rate).collect(),
            weights: nodes
                .iter()
                .filter(|_| weighted)
                .map(|n| n.weight)
                .collect(),
            limits: (0..groups).filter_map(|g| traj.limits(g)).collect(),
            hinges,
            spokes: Vec::new(),
            ends: Vec::new(),
            closure: f32::lit(FLOOR),
            stars: None,
        };
        if let Some(stars) = stars {
            path.set_stars(&stars);
        }
        let most = WIDEST / (4 * width);
        if groups > most || path.items().is_none() {
            let expected = format!("1 to {most} crease groups and at most 16384 hinges and spokes");
            let found = format!("{groups} groups, {} hinges", path.hinges.len());
            return Err(bad("path", expected, found));
        }
        Ok(path)
    }

    fn set_stars(&mut self, stars: &ReducedStars) {
        for star in stars.essential().view().iter() {
            self.spokes.extend(star.spokes.iter().map(|spoke| Spoke {
                group: spoke.group,
                negative: spoke.negative,
                direction: spoke.direction.map(f32::lit),
            }));
            self.ends
                .push(u32::try_from(self.spokes.len()).unwrap_or(u32::MAX));
        }
        self.stars = Some(stars.distinct());
        let sampled = self.sampled_closure();
        self.closure = f32::lit(FLOOR.max(sampled + FLOOR / 2.0));
    }

    /// The largest residual of samples all along the path.
    fn sampled_closure(&self) -> f64 {
        let Some(view) = self.view() else { return 0.0 };
        let mut worst = 0.0_f64;
        for segment in 0..self.times.len().saturating_sub(1) {
            for sample in 0..=SAMPLES {
                let s = f32::from(sample) / f32::from(SAMPLES);
                let curves = (0..self.groups()).filter_map(|group| view.curve(segment, group));
                let angles: Vec<f32> = curves.map(|curve| curve.angle(s)).collect();
                worst = worst.max(self.residual(&angles).unwrap_or(0.0));
            }
        }
        worst
    }

    /// Number of crease groups.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.limits.len()
    }

    /// Seconds of the knots.
    #[must_use]
    pub fn times(&self) -> &[f32] {
        &self.times
    }

    /// The largest closure residual that the controller is to let pass: that of the path, rounding included.
    #[must_use]
    pub fn closure(&self) -> f32 {
        self.closure
    }

    /// The largest closure residual of the sheet at these group angles, radians; `None` if the sheet is not known.
    #[must_use]
    pub fn residual(&self, angles: &[f32]) -> Option<f64> {
        let angles: Vec<f64> = angles.iter().map(|angle| angle.to_f64()).collect();
        let stars = self.stars.as_ref();
        stars
            .filter(|_| angles.len() == self.groups())
            .map(|stars| stars.largest_residual(&angles))
    }

    /// The path as core's trajectory.
    #[must_use]
    pub fn view(&self) -> Option<TrajectoryView<'_, f32>> {
        TrajectoryView::new(
            self.interpolation,
            self.groups(),
            &self.times,
            &self.angles,
            &self.rates,
            &self.weights,
        )
        .ok()
    }

    /// The path as what is sent, from its start.
    pub(super) fn items(&self) -> Option<PathItems<'_>> {
        let stars = StarsView::new(&self.spokes, &self.ends, self.groups())?;
        let (limits, hinges) = (&self.limits, &self.hinges);
        PathItems::new(
            self.view()?,
            limits,
            hinges,
            stars,
            self.closure,
            Place::default(),
        )
    }
}
