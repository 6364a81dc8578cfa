//! The kernels whose instructions are counted, and their fixed inputs.

use core::hint::black_box;
use std::path::Path;

use foldpath::collision::CollisionScene;
use foldpath::folding::{FoldingMap, deformation};
use foldpath::pattern::CreasePattern;
use foldpath::planner::{Goal, Outcome, PlanOptions, Symmetry, plan};
use foldpath::read::read_pattern;
use foldpath::symmetry::CreaseGroups;

mod follower;
mod star;

/// A kernel: a piece of work on a fixed input.
pub(crate) struct Kernel {
    /// Name of the kernel.
    pub(crate) name: &'static str,
    /// Description of the work, for the table.
    pub(crate) work: &'static str,
    /// Number of calls that are counted.
    pub(crate) calls: u32,
    /// `true` if counting takes more than a few seconds.
    pub(crate) long: bool,
    /// Sets up the input, which is not counted, and returns the work.
    prepare: fn() -> Box<dyn FnMut()>,
}

impl Kernel {
    /// Runs the kernel once to warm up, then as often as it is counted.
    pub(crate) fn run(&self) {
        let mut work = (self.prepare)();
        work();
        counted(&mut *work, self.calls);
    }
}

/// Runs the counted calls. Callgrind looks for the name of this function.
#[inline(never)]
fn counted(work: &mut dyn FnMut(), calls: u32) {
    for _ in 0..calls {
        work();
    }
}

/// Returns the kernel of this name.
pub(crate) fn find(name: &str) -> Option<&'static Kernel> {
    ALL.iter().find(|kernel| kernel.name == name)
}

/// All kernels.
pub(crate) const ALL: &[Kernel] = &[
    Kernel {
        name: "closure-f64",
        work: "closure and Jacobian of a degree-4 star, half angles included, f64",
        calls: 10_000,
        long: false,
        prepare: star::closure::<f64>,
    },
    Kernel {
        name: "closure-f32",
        work: "the same in f32",
        calls: 10_000,
        long: false,
        prepare: star::closure::<f32>,
    },
    Kernel {
        name: "lm-f64",
        work: "Levenberg-Marquardt from 0.9, 1.4 rad to the tolerance, 4 unknowns, f64",
        calls: 1_000,
        long: false,
        prepare: star::levenberg_marquardt::<f64>,
    },
    Kernel {
        name: "lm-f32",
        work: "the same in f32",
        calls: 1_000,
        long: false,
        prepare: star::levenberg_marquardt::<f32>,
    },
    Kernel {
        name: "gradient-f64",
        work: "10 steps of the gradient solver, 4 unknowns, f64",
        calls: 100,
        long: false,
        prepare: star::gradient,
    },
    Kernel {
        name: "follower-tick",
        work: "a tick of the follower at 1 kHz, 2 groups, Hermite cubics, f32",
        calls: 5_000,
        long: false,
        prepare: follower::tick,
    },
    Kernel {
        name: "fold-24x24",
        work: "folding map of the 24x24 Miura",
        calls: 20,
        long: false,
        prepare: fold,
    },
    Kernel {
        name: "deformation-24x24",
        work: "deformation of its 1,104 creases and its boundary",
        calls: 20,
        long: false,
        prepare: measure,
    },
    Kernel {
        name: "collision-24x24",
        work: "crossings of its 576 faces at the goal",
        calls: 5,
        long: false,
        prepare: collide,
    },
    Kernel {
        name: "symmetry-24x24",
        work: "its crease groups",
        calls: 1,
        long: false,
        prepare: groups,
    },
    Kernel {
        name: "plan-miura-24x24",
        work: "a whole plan",
        calls: 1,
        long: false,
        prepare: || whole_plan("miura-24x24", Symmetry::Auto),
    },
    Kernel {
        name: "plan-waterbomb-12x22",
        work: "a whole plan",
        calls: 1,
        long: true,
        prepare: || whole_plan("waterbomb-12x22", Symmetry::Auto),
    },
    Kernel {
        name: "plan-miura-11x11-full",
        work: "a whole plan with each of 220 creases an unknown",
        calls: 1,
        long: true,
        prepare: || whole_plan("miura-11x11", Symmetry::Off),
    },
];

fn read(name: &str) -> CreasePattern {
    let path = format!("{}/../../patterns/{name}.fold", env!("CARGO_MANIFEST_DIR"));
    read_pattern(Path::new(&path)).expect("a pattern").pattern
}

/// A folded sheet at its goal.
struct Sheet {
    pattern: CreasePattern,
    angles: Vec<f64>,
    map: FoldingMap,
}

fn sheet() -> Sheet {
    let pattern = read("miura-24x24");
    let goals = pattern
        .creases()
        .iter()
        .map(|&edge| pattern.edge(edge).goal);
    let angles: Vec<f64> = goals.map(|goal| goal.expect("a goal")).collect();
    let map = FoldingMap::new(&pattern, pattern.tree(), &angles);
    Sheet {
        pattern,
        angles,
        map,
    }
}

fn fold() -> Box<dyn FnMut()> {
    let mut sheet = sheet();
    Box::new(move || {
        let Sheet {
            pattern,
            angles,
            map,
        } = &mut sheet;
        map.fold(pattern, pattern.tree(), black_box(angles));
        black_box(map);
    })
}

fn measure() -> Box<dyn FnMut()> {
    let sheet = sheet();
    Box::new(move || {
        black_box(deformation(&sheet.pattern, black_box(sheet.map.vertices())));
    })
}

fn collide() -> Box<dyn FnMut()> {
    let sheet = sheet();
    let mut scene = CollisionScene::new(&sheet.pattern);
    Box::new(move || {
        let crossing = scene.deepest_crossing(black_box(&sheet.map), 1e-6);
        assert_eq!(crossing, None);
    })
}

fn groups() -> Box<dyn FnMut()> {
    let pattern = read("miura-24x24");
    Box::new(move || {
        let groups = CreaseGroups::find(black_box(&pattern));
        assert_eq!(groups.len(), 2);
    })
}

fn whole_plan(name: &str, symmetry: Symmetry) -> Box<dyn FnMut()> {
    let pattern = read(name);
    let goal = Goal::of_pattern(&pattern).expect("a goal");
    let options = PlanOptions::default().with(|it| it.symmetry = symmetry);
    Box::new(move || {
        let plan = plan(black_box(&pattern), &goal, &options);
        assert_eq!(plan.outcome, Outcome::Planned);
    })
}
