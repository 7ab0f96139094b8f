//! Numbers of form of a wave over place: what cogging and force ripple have in common.

use super::law::{FormNumber, Parameter};

/// A third or fourth harmonic is this share of the first one at most, inside the tolerance: two standard deviations. Finite-element and measured spectra
/// of linear motors have a few per cent.
const TOLERANCE: f64 = 0.1;

/// The third and the fourth harmonic, as shares of the first one's amplitude.
pub(super) const HIGHER: &[FormNumber] =
    &[share("sine_3"), share("cosine_3"), share("sine_4"), share("cosine_4")];

const fn share(name: &'static str) -> FormNumber {
    FormNumber { parameter: Parameter::same(name, "1").within(-1.0, 1.0), usual: 0.0, tolerance: TOLERANCE }
}
