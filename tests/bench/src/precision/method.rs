//! The solvers that are compared, ours and peers.

use core::time::Duration;

use foldpath_core::least_squares::Steps;

use super::{Problem, argmin_peers, minpack_peer, nlopt_peers, ours};

/// A solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// foldpath's Levenberg-Marquardt in f64, which with sparse matrices makes several steps with a factor.
    LmF64,
    /// The same that makes steps far from closing roughly, with sparse matrices, too.
    RoughLmF64,
    /// The same in f32, as the controller has it.
    LmF32,
    /// foldpath's gradient solver in f64.
    GradientF64,
    /// The same in f32.
    GradientF32,
    /// Samples nearer and nearer round the best one, the report's search without a goal.
    RandomSearch,
    /// Crate `levenberg-marquardt`: MINPACK's, dense QR with pivoting.
    Minpack,
    /// Crate `argmin`: L-BFGS with the line search of Moré and Thuente.
    ArgminLbfgs,
    /// Crate `argmin`: Gauss-Newton.
    ArgminGaussNewton,
    /// Crate `argmin`: trust region, Gauss-Newton's Hessian, conjugate gradients by Steihaug.
    ArgminTrustRegion,
    /// NLopt, without derivatives.
    Cobyla,
    /// NLopt, without derivatives.
    NelderMead,
    /// NLopt, without derivatives.
    Bobyqa,
    /// NLopt with forward differences.
    SlsqpDifferences,
    /// NLopt with forward differences.
    LbfgsDifferences,
    /// NLopt given foldpath's gradient.
    SlsqpGradient,
    /// NLopt given foldpath's gradient.
    LbfgsGradient,
}

use Method::{
    ArgminGaussNewton, ArgminLbfgs, ArgminTrustRegion, Bobyqa, Cobyla, GradientF32, GradientF64,
    LbfgsDifferences, LbfgsGradient, LmF32, LmF64, Minpack, NelderMead, RandomSearch, RoughLmF64,
    SlsqpDifferences, SlsqpGradient,
};

/// What a run came to.
#[derive(Clone, Debug)]
pub struct Run {
    /// Time of the call alone: memory and settings were made before.
    pub time: Duration,
    /// The best configuration.
    pub x: Vec<f64>,
    /// Evaluations without derivatives.
    pub values: u64,
    /// Evaluations with derivatives.
    pub derivatives: u64,
}

/// A solver with all memory for one problem.
pub trait Solver {
    /// Moves `start` to closure within the tolerance, if it can within the time.
    fn run(&mut self, start: &[f64], tolerance: f64, limit: Duration) -> Run;
}

impl Method {
    /// All of them, ours first.
    pub const ALL: [Self; 17] = [
        LmF64,
        RoughLmF64,
        LmF32,
        GradientF64,
        GradientF32,
        RandomSearch,
        Minpack,
        ArgminLbfgs,
        ArgminGaussNewton,
        ArgminTrustRegion,
        Cobyla,
        NelderMead,
        Bobyqa,
        SlsqpDifferences,
        LbfgsDifferences,
        SlsqpGradient,
        LbfgsGradient,
    ];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            LmF64 => "foldpath LM f64",
            RoughLmF64 => "foldpath rough LM f64",
            LmF32 => "foldpath LM f32",
            GradientF64 => "foldpath gradient f64",
            GradientF32 => "foldpath gradient f32",
            RandomSearch => "random search",
            Minpack => "levenberg-marquardt",
            ArgminLbfgs => "argmin L-BFGS",
            ArgminGaussNewton => "argmin Gauss-Newton",
            ArgminTrustRegion => "argmin trust region",
            Cobyla => "NLopt COBYLA",
            NelderMead => "NLopt Nelder-Mead",
            Bobyqa => "NLopt BOBYQA",
            SlsqpDifferences => "NLopt SLSQP, differences",
            LbfgsDifferences => "NLopt L-BFGS, differences",
            SlsqpGradient => "NLopt SLSQP, gradient",
            LbfgsGradient => "NLopt L-BFGS, gradient",
        }
    }

    /// Whether it is foldpath's own; the random search is nobody's.
    #[must_use]
    pub fn is_ours(self) -> bool {
        matches!(self, LmF64 | RoughLmF64 | LmF32 | GradientF64 | GradientF32)
    }

    /// Unknowns beyond which it is not tried: it works on dense matrices, and where one of its iterations takes
    /// minutes nothing can stop it in time.
    #[must_use]
    pub fn most_unknowns(self) -> usize {
        match self {
            Cobyla | SlsqpDifferences | SlsqpGradient => 250,
            // On the controller, with its few groups, there is dense linear algebra alone.
            LmF32 => 250,
            Minpack | ArgminGaussNewton | ArgminTrustRegion | Bobyqa => 1_200,
            _ => usize::MAX,
        }
    }

    /// The solver with memory for a problem.
    #[must_use]
    pub fn solver<'a>(self, problem: &'a Problem) -> Box<dyn Solver + 'a> {
        let stars = problem.stars();
        match self {
            LmF64 => ours::levenberg_marquardt_f64(stars, Steps::Repeated),
            RoughLmF64 => ours::levenberg_marquardt_f64(stars, Steps::Rough),
            LmF32 => ours::levenberg_marquardt_f32(stars),
            GradientF64 => ours::gradient::<f64>(stars),
            GradientF32 => ours::gradient::<f32>(stars),
            RandomSearch => ours::random_search(stars),
            Minpack => minpack_peer::solver(stars),
            ArgminLbfgs => argmin_peers::lbfgs(stars),
            ArgminGaussNewton => argmin_peers::gauss_newton(stars),
            ArgminTrustRegion => argmin_peers::trust_region(stars),
            Cobyla => nlopt_peers::solver(stars, nlopt::Algorithm::Cobyla, false),
            NelderMead => nlopt_peers::solver(stars, nlopt::Algorithm::Neldermead, false),
            Bobyqa => nlopt_peers::solver(stars, nlopt::Algorithm::Bobyqa, false),
            SlsqpDifferences => nlopt_peers::solver(stars, nlopt::Algorithm::Slsqp, false),
            LbfgsDifferences => nlopt_peers::solver(stars, nlopt::Algorithm::Lbfgs, false),
            SlsqpGradient => nlopt_peers::solver(stars, nlopt::Algorithm::Slsqp, true),
            LbfgsGradient => nlopt_peers::solver(stars, nlopt::Algorithm::Lbfgs, true),
        }
    }
}
