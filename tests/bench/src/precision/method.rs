//! The solvers that are compared: foldpath's own and peers.

use core::time::Duration;

use super::{Problem, argmin_peers, minpack_peer, nlopt_peers, ours};

/// A solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// foldpath's Levenberg-Marquardt in f64. With sparse matrices it reuses a factorisation for several steps (chord
    /// method).
    LmF64,
    /// foldpath's Levenberg-Marquardt in f32, as on the controller.
    LmF32,
    /// foldpath's gradient solver in f64.
    GradientF64,
    /// foldpath's gradient solver in f32.
    GradientF32,
    /// Random samples round the best one, from a radius that shrinks: the report's search without a goal.
    RandomSearch,
    /// Crate `levenberg-marquardt`: MINPACK's method, with a dense pivoted QR factorisation.
    Minpack,
    /// Crate `argmin`: L-BFGS with the line search of Moré and Thuente.
    ArgminLbfgs,
    /// Crate `argmin`: Gauss-Newton.
    ArgminGaussNewton,
    /// Crate `argmin`: trust region with the Gauss-Newton Hessian and Steihaug's conjugate gradients.
    ArgminTrustRegion,
    /// NLopt's COBYLA, without derivatives.
    Cobyla,
    /// NLopt's Nelder-Mead, without derivatives.
    NelderMead,
    /// NLopt's BOBYQA, without derivatives.
    Bobyqa,
    /// NLopt's SLSQP, with forward differences.
    SlsqpDifferences,
    /// NLopt's L-BFGS, with forward differences.
    LbfgsDifferences,
    /// NLopt's SLSQP, with foldpath's gradient.
    SlsqpGradient,
    /// NLopt's L-BFGS, with foldpath's gradient.
    LbfgsGradient,
}

use Method::{
    ArgminGaussNewton, ArgminLbfgs, ArgminTrustRegion, Bobyqa, Cobyla, GradientF32, GradientF64,
    LbfgsDifferences, LbfgsGradient, LmF32, LmF64, Minpack, NelderMead, RandomSearch,
    SlsqpDifferences, SlsqpGradient,
};

/// Result of a run.
#[derive(Clone, Debug)]
pub struct Run {
    /// Time of the call alone; memory and settings were prepared before.
    pub time: Duration,
    /// The best configuration.
    pub x: Vec<f64>,
    /// Number of evaluations without derivatives.
    pub values: u64,
    /// Number of evaluations with derivatives.
    pub derivatives: u64,
}

/// A solver with all memory for one problem.
pub trait Solver {
    /// Moves `start` to closure within the tolerance, if the solver can within the time.
    fn run(&mut self, start: &[f64], tolerance: f64, limit: Duration) -> Run;
}

impl Method {
    /// All methods, foldpath's first.
    pub const ALL: [Self; 16] = [
        LmF64,
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

    /// Returns the name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            LmF64 => "foldpath LM f64",
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

    /// Returns `true` for foldpath's own solvers; the random search counts as a peer.
    #[must_use]
    pub fn is_ours(self) -> bool {
        matches!(self, LmF64 | LmF32 | GradientF64 | GradientF32)
    }

    /// Returns the largest number of unknowns at which the method is tried. A method with dense matrices may take
    /// minutes for one iteration, which nothing can stop in time.
    #[must_use]
    pub fn most_unknowns(self) -> usize {
        match self {
            Cobyla | SlsqpDifferences | SlsqpGradient => 250,
            // On the controller, with its few groups, all linear algebra is dense.
            LmF32 => 250,
            Minpack | ArgminGaussNewton | ArgminTrustRegion | Bobyqa => 1_200,
            _ => usize::MAX,
        }
    }

    /// Returns the solver with memory for a problem.
    #[must_use]
    pub fn solver<'a>(self, problem: &'a Problem) -> Box<dyn Solver + 'a> {
        let stars = problem.stars();
        match self {
            LmF64 => ours::levenberg_marquardt_f64(stars),
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
