//! Which branch does the planner take out of the flat sheet, where many branches meet? It must end on the branch of the
//! assignments, or say that it did not.

use foldpath::generate::Miura;
use foldpath::pattern::CreasePattern;
use foldpath::planner::leave_flat;
use foldpath_tests::closed_form::miura_straight;
use foldpath_tests::{Random, worst};

const SECTOR: f64 = core::f64::consts::FRAC_PI_3;
/// Largest distance of a configuration that closes to rounding from the closed form, radians. Near flat the closure
/// conditions are of second order: an error of 1e-14 in them is an error of 1e-10 in the angles at 1e-4 rad.
const SAME: f64 = 1e-7;
/// Angle below which a closure residual of 1e-14 does not tell the branches apart, radians.
const FLAT: f64 = 1e-5;
/// Largest closure residual of a configuration that counts as closed.
const CLOSED: f64 = 1e-12;
/// Numbers of rows and of columns of the sheets.
const SIZES: [usize; 4] = [3, 5, 11, 24];
/// Number of starts on each sheet.
const STARTS: u64 = 200;

/// The configuration that a start leads to.
struct Landing {
    /// Fold angles of the creases, radians.
    angles: Vec<f64>,
    /// `true` if the planner claims that it is on the branch of the assignments.
    claimed: bool,
}

/// Leaves the flat sheet from `start`, fold angles of the creases in radians. Returns `None` if the result does not
/// close.
fn land(pattern: &CreasePattern, start: &[f64]) -> Option<Landing> {
    let departure = leave_flat(pattern, start);
    (departure.closure <= CLOSED).then_some(Landing {
        angles: departure.fold_angles,
        claimed: departure.against.is_empty(),
    })
}

/// Returns `true` if every crease turns the way of its assignment.
fn as_lettered(pattern: &CreasePattern, angles: &[f64]) -> bool {
    let signs = pattern
        .creases()
        .iter()
        .map(|&crease| pattern.edge(crease).letter.sign());
    signs.zip(angles).all(|(sign, angle)| sign * angle > 0.0)
}

/// Returns `true` if a configuration is the flat sheet.
fn is_flat(angles: &[f64]) -> bool {
    worst(angles.iter().map(|a| a.abs())) <= FLAT
}

/// A Miura sheet, whose motion is known in closed form.
struct Sheet {
    pattern: CreasePattern,
    /// For each crease `true` if it is a straight one.
    straight: Vec<bool>,
    /// Signs of the creases' assignments.
    signs: Vec<f64>,
}

impl Sheet {
    fn new(size: usize) -> Self {
        let miura = Miura {
            rows: size,
            columns: size,
            sector_angle: SECTOR,
            fold: 0.5,
        };
        let pattern = CreasePattern::new(miura.drawing().unwrap()).unwrap();
        let edges = || pattern.creases().iter().map(|&crease| pattern.edge(crease));
        let level = |edge: &foldpath::pattern::Edge| {
            let [a, b] = edge.ends.map(|end| pattern.vertices()[end.index()]);
            (a.y - b.y).abs() < 1e-9
        };
        Self {
            straight: edges().map(level).collect(),
            signs: edges().map(|edge| edge.letter.sign()).collect(),
            pattern,
        }
    }

    /// Returns the configuration on the branch of the assignments, by the fold angle of the zigzag creases.
    fn motion(&self, zigzag: f64) -> Vec<f64> {
        let straight = miura_straight(SECTOR, zigzag);
        let size = |&is_straight: &bool| if is_straight { straight } else { zigzag };
        let sizes = self.straight.iter().map(size);
        sizes.zip(&self.signs).map(|(size, s)| size * s).collect()
    }

    /// Returns the largest difference from the branch of the assignments at the angle of the first zigzag crease.
    fn off_motion(&self, angles: &[f64]) -> f64 {
        let leader = self.straight.iter().position(|straight| !straight);
        let motion = self.motion(angles[leader.unwrap()].abs());
        worst(angles.iter().zip(motion).map(|(a, b)| (a - b).abs()))
    }

    /// Draws a start: a step along the branch of the assignments as it leaves flat, whose largest angle is `scale`
    /// radians, plus `noise` times as long a step in a random direction.
    fn start(&self, random: &mut Random, scale: f64, noise: f64) -> Vec<f64> {
        let length = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let along = self.motion(1e-6);
        let along: Vec<f64> = along.iter().map(|a| a / 1e-6).collect();
        let aside: Vec<f64> = along.iter().map(|_| random.normal()).collect();
        let noise = noise * length(&along) / length(&aside);
        let sum = along.iter().zip(&aside);
        sum.map(|(along, aside)| scale * (along + noise * aside))
            .collect()
    }
}

/// Numbers of starts by where they led.
#[derive(Debug, Default)]
struct Count {
    /// On the branch of the assignments.
    lettered: usize,
    /// On another branch.
    other: usize,
    /// Back in the flat sheet.
    flat: usize,
    /// Not closed.
    unclosed: usize,
    /// Starts without noise that are not on the branch of the assignments.
    clean_lost: usize,
}

/// Lands from seeded starts: a tenth without noise, the others with up to `noisiest` times the signal.
fn count(size: usize, noisiest: f64) -> Count {
    let sheet = Sheet::new(size);
    let mut count = Count::default();
    for seed in 0..STARTS {
        let mut random = Random::new(seed);
        let scale = random.log_uniform(1e-3, 0.2);
        let clean = seed.is_multiple_of(10);
        let noise = if clean {
            0.0
        } else {
            random.uniform(0.0, noisiest)
        };
        let start = sheet.start(&mut random, scale, noise);
        let Some(landing) = land(&sheet.pattern, &start) else {
            count.unclosed += 1;
            count.clean_lost += usize::from(clean);
            continue;
        };
        // Classifies the result by its signs and by the closed form, whatever the planner claims.
        let what = format!("{size} x {size}, seed {seed}, scale {scale}, noise {noise}");
        let flat = is_flat(&landing.angles);
        let signs = as_lettered(&sheet.pattern, &landing.angles);
        let off = sheet.off_motion(&landing.angles);
        let lettered = !flat && off <= SAME;
        assert_eq!(lettered, !flat && signs, "{what}: {off:e} off the motion");
        assert!(
            lettered || !landing.claimed,
            "{what}: another branch, silently"
        );
        count.lettered += usize::from(lettered);
        count.flat += usize::from(flat);
        count.other += usize::from(!flat && !lettered);
        count.clean_lost += usize::from(clean && !lettered);
    }
    count
}

/// The signs of a Miura sheet's assignments belong to one branch, its closed form. With noise up to the size of the
/// signal every start lands on that branch. With more noise a start may land elsewhere, but the planner says so.
#[test]
fn whoever_leaves_flat_lands_as_lettered_or_says_so() {
    for noisiest in [1.0, 3.0] {
        for size in SIZES {
            let count = count(size, noisiest);
            println!("Miura {size} x {size}, noise up to {noisiest}: {count:?}");
            assert_eq!(count.clean_lost, 0, "{size} x {size}");
            assert!(
                noisiest > 1.0 || count.other + count.flat + count.unclosed == 0,
                "{size} x {size}: {count:?}"
            );
        }
    }
}
