//! Times large work on one thread and on two: whole plans of Miura sheets with every crease an unknown of its own, the
//! plan of a net of 300 hinges, and the check of a torn sheet of 10,000 faces.
//!
//! `cargo bench -p foldpath-tests --bench full_dof` takes seconds. `-- large` adds the Miura sheet of 200 x 200 faces, the
//! net and the torn sheet. Runs on one and on two threads alternate, so that other work on the machine slows both alike,
//! and their answers must be the same.

use std::time::Instant;

use foldpath::check::{CheckOptions, check};
use foldpath::export::fold::motion_text;
use foldpath::generate::Miura;
use foldpath::motion::Motion;
use foldpath::pattern::{CreasePattern, Drawing};
use foldpath::planner::{Goal, PlanOptions, Symmetry, plan};
use foldpath_tests::{Random, meshes, path_file};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Numbers of threads that are compared.
const THREADS: [usize; 2] = [1, 2];

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let has = |name: &str| arguments.iter().any(|argument| argument == name);
    if !has("--bench") {
        return;
    }
    println!("| work | runs | one thread | two threads | times as fast |\n|---|---|---|---|---|");
    let mut sizes = vec![(24, 31), (48, 11), (96, 5)];
    if has("large") {
        sizes.push((200, 3));
    }
    for (size, runs) in sizes {
        let pattern = CreasePattern::new(miura(size, 150.0)).expect("a sheet");
        let options = PlanOptions::default().with(|it| {
            it.symmetry = Symmetry::Off;
            it.collision = false;
            it.max_step = 6.3_f64.to_radians();
        });
        let name = format!("full-DOF miura {size}x{size}");
        compare(&name, runs, || planned(&pattern, &options));
    }
    if !has("large") {
        return;
    }
    let mut random = Random::new(5);
    let net = core::iter::from_fn(|| Some(meshes::net_of(&mut random, 152)));
    let net = net.flatten().next().expect("a net");
    let net = CreasePattern::new(net).expect("a sheet");
    compare(&format!("net of {} hinges", net.creases().len()), 3, || {
        planned(&net, &PlanOptions::default())
    });
    let torn = torn(100);
    let name = format!(
        "check of a torn sheet of {} faces",
        torn.pattern.faces().len()
    );
    compare(&name, 3, || {
        format!("{:?}", check(&torn, &CheckOptions::default()))
    });
}

fn miura(size: usize, degrees: f64) -> Drawing {
    let miura = Miura {
        rows: size,
        columns: size,
        sector_angle: 60_f64.to_radians(),
        fold: degrees / 180.0,
    };
    miura.drawing().expect("a sheet")
}

/// Plans, and returns the outcome, the counts and the file of the path.
fn planned(pattern: &CreasePattern, options: &PlanOptions) -> String {
    let goal = Goal::of_pattern(pattern).expect("a goal");
    let plan = plan(pattern, &goal, options);
    let path = plan.motion.as_ref().map(motion_text);
    format!("{:?} {:?} {path:?}", plan.outcome, plan.crossings.counts)
}

/// Returns the motion of a Miura sheet of `size` x `size` faces, in which every hinge is off by up to 1e-6 degrees.
fn torn(size: usize) -> Motion {
    let pattern = CreasePattern::new(miura(size, 108.0)).expect("a sheet");
    let goal = Goal::of_pattern(&pattern).expect("a goal");
    let plan = plan(&pattern, &goal, &PlanOptions::default());
    let text = motion_text(&plan.motion.expect("a path"));
    let mut file: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    for key in ["foldpath:edges_group", "foldpath:edges_sign"] {
        file.as_object_mut().expect("an object").remove(key);
    }
    let mut random = Random::new(1);
    for frame in file["file_frames"].as_array_mut().expect("frames") {
        for angle in frame["edges_foldAngle"].as_array_mut().expect("angles") {
            if let Some(degrees) = angle.as_f64().filter(|degrees| degrees.abs() > 0.0) {
                *angle = (degrees + random.uniform(-1e-6, 1e-6)).into();
            }
        }
        let frame = frame.as_object_mut().expect("an object");
        for claim in ["deformation", "gap", "closure", "clearance"] {
            frame.remove(&format!("foldpath:{claim}"));
        }
        frame.remove("vertices_coords");
    }
    path_file(&file.to_string()).expect("a path")
}

/// Does the work alternately on one thread and on two, and prints the median times.
fn compare(name: &str, runs: usize, work: impl Fn() -> String + Sync) {
    let pools = THREADS.map(|threads| -> ThreadPool {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads")
    });
    let mut times = [Vec::new(), Vec::new()];
    let mut answer: Option<String> = None;
    for _ in 0..runs {
        for (pool, times) in pools.iter().zip(&mut times) {
            let start = Instant::now();
            let found = pool.install(&work);
            times.push(start.elapsed().as_secs_f64());
            let first = answer.get_or_insert_with(|| found.clone());
            assert!(*first == found, "{name}: another answer");
        }
    }
    let [one, two] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[runs / 2]
    });
    println!(
        "| {name} | {runs} | {one:.4} s | {two:.4} s | {:.2} |",
        one / two
    );
}
