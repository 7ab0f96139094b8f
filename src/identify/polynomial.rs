//! Roots of a real polynomial.

use std::f64::consts::TAU;

use nalgebra::Complex;

/// Sweeps after which the iteration is stopped; simple roots need about ten, multiple roots a few tens.
const LARGEST_SWEEPS: usize = 500;
/// Angle that keeps the starting points off the real axis and off the roots of unity.
const STARTING_ANGLE: f64 = 0.7;
/// Imaginary part, relative to the modulus, below which a root of a real polynomial is called real.
const REAL_WITHIN: f64 = 1e-12;

/// Roots of c₀ zⁿ + c₁ zⁿ⁻¹ + … + cₙ, without roots at z = 0 (trailing zeros are dropped, as are leading
/// ones).
///
/// Closed form up to degree 2, above it the simultaneous iteration of Aberth and Ehrlich (the QR iteration on
/// a companion matrix without exceptional shifts never ends on zⁿ − 1). Largest modulus first.
pub(super) fn roots(coefficients: &[f64]) -> Vec<Complex<f64>> {
    let Some(first) = coefficients.iter().position(|c| *c != 0.0) else { return Vec::new() };
    let last = coefficients.iter().rposition(|c| *c != 0.0).unwrap_or(first);
    let c = &coefficients[first..=last];
    let mut found = match c.len() - 1 {
        0 => Vec::new(),
        1 => vec![Complex::new(-c[1] / c[0], 0.0)],
        2 => quadratic(c[0], c[1], c[2]),
        _ => simultaneous(c),
    };
    for root in &mut found {
        if root.im.abs() <= REAL_WITHIN * root.norm() {
            root.im = 0.0;
        }
    }
    found.sort_by(|a, b| b.norm().total_cmp(&a.norm()).then(b.im.total_cmp(&a.im)));
    found
}

fn quadratic(a: f64, b: f64, c: f64) -> Vec<Complex<f64>> {
    let half = -0.5 * b / a;
    let discriminant = half * half - c / a;
    if discriminant < 0.0 {
        let im = (-discriminant).sqrt();
        return vec![Complex::new(half, im), Complex::new(half, -im)];
    }
    // the larger root first, the other from the product: no cancellation
    let large = half + discriminant.sqrt().copysign(half);
    let small = if large == 0.0 { 0.0 } else { c / a / large };
    vec![Complex::new(large, 0.0), Complex::new(small, 0.0)]
}

fn simultaneous(c: &[f64]) -> Vec<Complex<f64>> {
    let degree = c.len() - 1;
    let radius = (c[degree] / c[0]).abs().powf(1.0 / degree as f64);
    let mut z: Vec<_> = (0..degree)
        .map(|k| Complex::from_polar(radius, STARTING_ANGLE + TAU * k as f64 / degree as f64))
        .collect();
    for _ in 0..LARGEST_SWEEPS {
        let mut settled = true;
        for k in 0..degree {
            let newton = newton_step(c, z[k]);
            let repulsion: Complex<f64> = (0..degree).filter(|j| *j != k).map(|j| (z[k] - z[j]).inv()).sum();
            let step = newton / (Complex::new(1.0, 0.0) - newton * repulsion);
            if step.is_finite() {
                z[k] -= step;
                settled &= step.norm() <= f64::EPSILON * z[k].norm();
            }
        }
        if settled {
            break;
        }
    }
    z
}

fn newton_step(c: &[f64], z: Complex<f64>) -> Complex<f64> {
    let zero = Complex::new(0.0, 0.0);
    let (value, slope) = c.iter().fold((zero, zero), |(p, dp), &c| (p * z + c, dp * z + p));
    if value == zero { zero } else { value / slope }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simple roots of a well-conditioned polynomial come out to a few roundings.
    const SIMPLE: f64 = 1e-12;
    /// A triple root moves by the cube root of rounding.
    const TRIPLE: f64 = 1e-4;

    #[test]
    fn exact_roots_of_unity() {
        let found = roots(&[1.0, 0.0, 0.0, 0.0, -1.0]);
        assert_eq!(found.len(), 4);
        for root in found {
            assert!((root.powu(4) - 1.0).norm() < SIMPLE, "{root}");
        }
    }

    #[test]
    fn exact_triple_root() {
        for root in roots(&[1.0, -2.7, 2.43, -0.729]) {
            assert!((root - 0.9).norm() < TRIPLE, "{root}");
        }
    }

    #[test]
    fn exact_known_roots_of_degree_five() {
        // (z − 0.5)(z + 0.25)(z − 0.9)(z² − 1.2 z + 0.72)
        let mut c = vec![1.0];
        for factor in [&[1.0, -0.5][..], &[1.0, 0.25], &[1.0, -0.9], &[1.0, -1.2, 0.72]] {
            let mut product = vec![0.0; c.len() + factor.len() - 1];
            for (i, a) in c.iter().enumerate() {
                for (j, b) in factor.iter().enumerate() {
                    product[i + j] += a * b;
                }
            }
            c = product;
        }
        let found = roots(&c);
        for truth in [(0.5, 0.0), (-0.25, 0.0), (0.9, 0.0), (0.6, 0.6), (0.6, -0.6)] {
            let truth = Complex::new(truth.0, truth.1);
            assert!(found.iter().any(|r| (r - truth).norm() < SIMPLE), "{truth} not in {found:?}");
        }
    }

    #[test]
    fn exact_small_root_of_a_quadratic_keeps_its_digits() {
        let found = roots(&[1.0, -1e8, 1.0]);
        assert!((found[1].re * 1e8 - 1.0).abs() < SIMPLE);
    }
}
