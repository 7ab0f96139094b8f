//! Whether stated probabilities are kept: of what is said with 0.9, nine in ten should be true.

use super::interval::Rate;
use super::judge::Judged;
pub use super::statement::Statement;
use serde::Serialize;

/// Edges of the bins of stated probability; the lower edge belongs to a bin, and 1 to the last.
const EDGES: [f64; 8] = [0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 1.0];

/// The statements of one bin.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bin {
    /// Least stated probability.
    pub from: f64,
    /// Largest; it belongs to the next bin, except 1.
    pub to: f64,
    /// Mean stated probability; none where there is no statement.
    pub stated: Option<f64>,
    /// Share that is true.
    pub share_true: Rate,
}

/// How far stated probabilities are kept.
///
/// # Model
/// With N statements of probability p and truth t, 1 or 0:
/// - Brier score: the mean of (p − t)². 0 is knowing all; stating 0.5 always gives 0.25.
/// - Expected calibration error: Σ (nᵦ/N)·|mean p − mean t| over the bins. 0 is keeping every promise, however vague.
///
/// # Source
/// Brier (1950), *Verification of forecasts expressed in terms of probability*; Naeini et al. (2015), *Obtaining well calibrated
/// probabilities using Bayesian binning*.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reliability {
    /// Number of statements.
    pub statements: usize,
    /// Brier score; none without statements.
    pub brier_score: Option<f64>,
    /// Expected calibration error; none without statements.
    pub expected_calibration_error: Option<f64>,
    /// Bin by bin, least probability first.
    pub bins: Vec<Bin>,
}

impl Reliability {
    /// Counts the statements of all cases.
    pub fn of(cases: &[Judged]) -> Self {
        let all: Vec<&Statement> = cases.iter().flat_map(|case| &case.statements).collect();
        let bins: Vec<Bin> = EDGES.windows(2).map(|edges| bin(&all, edges[0], edges[1])).collect();
        let truth = |s: &Statement| f64::from(u8::from(s.is_true));
        let error = |bin: &Bin| {
            let difference = bin.stated.zip(bin.share_true.value).map_or(0.0, |(p, t)| (p - t).abs());
            bin.share_true.of as f64 * difference
        };
        let mean = |sum: f64| (!all.is_empty()).then(|| sum / all.len() as f64);
        Self {
            statements: all.len(),
            brier_score: mean(all.iter().map(|s| (s.probability - truth(s)).powi(2)).sum()),
            expected_calibration_error: mean(bins.iter().map(error).sum()),
            bins,
        }
    }
}

fn bin(all: &[&Statement], from: f64, to: f64) -> Bin {
    let holds = |p: f64| p >= from && (p < to || to >= 1.0);
    let own: Vec<&&Statement> = all.iter().filter(|s| holds(s.probability)).collect();
    let sum: f64 = own.iter().map(|s| s.probability).sum();
    Bin {
        from,
        to,
        stated: (!own.is_empty()).then(|| sum / own.len() as f64),
        share_true: Rate::count(own.iter().map(|s| s.is_true)),
    }
}
