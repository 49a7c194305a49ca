//! A solved hierarchy as a level of its own: its leaves are the patches.

use super::super::adaptive::Task;
use super::level::{LARGEST_EXACT, Level, Matrix, Solved, system};
use crate::error::Result;
use crate::solve::hierarchical::{self, Refinement};

/// Error of a link against the mean irradiance, times the patches along the longest side to the power of 3/2.
///
/// What is not refined is off by about the cube root of the allowed error, which so falls with the square root of the
/// size of the finest patches, as does the root mean square error of those along edges.
const ALLOWED: f64 = 0.7;

/// Refines and solves; finest patches of about `size`, in the program's frame, `patches` of them along the longest side.
pub(super) fn solve(task: &Task<'_>, size: f64, patches: u32, accuracy: f64) -> Result<Level> {
    let allowed = ALLOWED / f64::from(patches).powf(1.5);
    let refinement = Refinement { finest: size, allowed };
    let solved = hierarchical::solve(task.world, &|p| system(task, p), refinement, LARGEST_EXACT, accuracy)?;
    let (links, outcome) = (solved.hierarchy, solved.outcome);
    let direct = solved.system.irradiance(&links, &solved.system.emitted);
    let open = links.row_sums().into_iter().map(|sum| 1.0 - sum).collect();
    let level = Solved {
        solver: format!(
            "push-pull over {} links, refined by {} solutions; conjugate gradients, {} products: residual {:.1e}, unshot {:.1e} of the flux, error of the solution at most {:.1e}",
            links.links(),
            links.rounds,
            outcome.iterations,
            outcome.residual,
            outcome.unshot,
            outcome.bound
        ),
        closure: format!(
            "analytic, links that err by {allowed:.1e} of the mean irradiance at most; before the balance, rows of leaves off by {:.1e} (RMS), of roots by {:.1e} (worst)",
            links.closure_defect, links.worst_root.0
        ),
        iterations: outcome.iterations,
        rays: links.rays,
        factors: links.factors,
        links: Some(links.links() as u64),
        ambient: vec![0.0; solved.system.bands],
        iteration: outcome.bound,
        radiosity: outcome.radiosity,
        matrix: Some(Matrix { irradiance: outcome.irradiance, direct, open }),
    };
    Ok(Level { size, mesh: Box::new(links.tree), system: solved.system, solved: level })
}
