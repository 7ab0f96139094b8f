//! Every number that decides a verdict, and why it is what it is.
//!
//! A number decides a verdict where another value of it may give another verdict, or other causes, from the same likelihoods, intervals and
//! gaps. A test keeps others out of the files that decide. Priors stand in `prior`; what else the diagnosis names says how a model is computed, how long a
//! search looks or what a report mentions.
//! The first three are the defaults of [`Limits`](super::decide::Limits), which a report prints.

/// Posterior probability from which something is decided: odds of seven to three. A caller may ask for more.
pub const PROBABILITY: f64 = 0.7;

/// Share of the gap's power that may stay open: 3 % of its amplitude, as well as stated constants and the form of a law are known.
pub const OPEN_SHARE: f64 = 1e-3;

/// What may stay open of a gap that is closed to [`LARGELY`], as a multiple of the noise: three standard deviations, as a
/// limit of detection is stated (IUPAC 1976, Pure Appl. Chem. 45:105).
pub const SMALL_GAP: f64 = 3.0;

/// Up to this gap nothing is left that noise would not leave: noise that was measured is known to 0.15 (logarithmic standard
/// deviation), and 1.25 is e^(1.5·0.15).
pub const ADEQUATE_GAP: f64 = 1.25;

/// Up to this multiple of its noise, where that was seen in the recording, a signal by itself shows nothing that noise would not leave: 1.4 is e^(2.25·0.15), which one of four signals exceeds with a
/// probability of [`SIGNIFICANCE`] where [`ADEQUATE_GAP`] is e^(1.5·0.15).
pub fn quiet_signal() -> f64 {
    ADEQUATE_GAP * ADEQUATE_GAP.sqrt()
}

/// Noise that is only stated is known to 0.5 (logarithmic standard deviation): its power may be e^(2·1.15) = 10 times what is stated, or a
/// tenth, at 2.3 standard deviations. Noise seen at standstill bears out the stated one where it is no less than that: a stuck axis is
/// quieter than a moving one.
pub const STATED_NOISE: f64 = 10.0;

/// Share from which something is explained, or closed, but for a small rest: the rest is a tenth of it.
pub const LARGELY: f64 = 0.9;

/// Share from which something is most of what there is: more than all others together.
pub const MOST: f64 = 0.5;

/// Probability with which an effect that is not there shows: the usual level of a test (R. A. Fisher, 1925, *Statistical Methods for
/// Research Workers*).
pub const SIGNIFICANCE: f64 = 0.05;

/// Standard errors beyond which a coefficient or a shift of a column is not chance: 6·10⁻⁷ by chance, so that none of a thousand recordings with ten
/// columns has one.
pub const BEYOND_CHANCE: f64 = 5.0;

/// From this factor on, or below its inverse, nothing but a unit is that far off; ten times may be a mass that nobody stated.
pub const CERTAIN_FACTOR: f64 = 100.0;
