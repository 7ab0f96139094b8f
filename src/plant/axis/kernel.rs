//! The arithmetic of one step in the widest vector instructions that the processor at hand has.
//!
//! Sums run over the columns in their order, product by product, whatever the width: one axis and eight in one pass
//! come out with the same bits. With AVX2 or AVX-512 a product and a sum are rounded once (fused), without them twice.

use pulp::{Simd, WithSimd};
use std::ops::{Deref, DerefMut};

/// Rows that a block of one axis has.
pub(super) const ROWS: usize = 16;
/// Axes that one pass takes.
pub const LANES: usize = 8;
/// Rows that a block of several axes has.
pub(super) const LANE_ROWS: usize = 8;

/// One number of each axis.
pub type Lane = [f64; LANES];
/// Rows of one column of one axis.
pub(super) type Rows = Aligned<[f64; ROWS]>;
/// Rows of one column of several axes.
pub(super) type LaneRows = Aligned<[Lane; LANE_ROWS]>;

/// An array that begins on a cache line, so that no vector of it lies across two.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(super) struct Aligned<T>(pub T);

impl<T> Deref for Aligned<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T> DerefMut for Aligned<T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.0
    }
}

/// Rows of zeros.
pub(super) const NO_ROWS: Rows = Aligned([0.0; ROWS]);
/// Rows of zeros for several axes.
pub(super) const NO_LANE_ROWS: LaneRows = Aligned([[0.0; LANES]; LANE_ROWS]);

/// `into = matrix·by` for one axis; the matrix as blocks of rows, in each the columns.
pub(super) struct Multiply<'a> {
    pub matrix: &'a [Rows],
    pub columns: usize,
    pub by: &'a [Rows],
    pub into: &'a mut [Rows],
}

impl WithSimd for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let parts = ROWS / S::F64_LANES;
        for (into, block) in self.into.iter_mut().zip(self.matrix.chunks_exact(self.columns)) {
            let mut sum = [simd.splat_f64s(0.0); ROWS];
            for (columns, values) in block.chunks(ROWS).zip(self.by) {
                for (rows, value) in columns.iter().zip(&values.0) {
                    let (rows, value) = (S::as_simd_f64s(&rows.0).0, simd.splat_f64s(*value));
                    for part in 0..parts {
                        sum[part] = simd.mul_add_e_f64s(rows[part], value, sum[part]);
                    }
                }
            }
            S::as_mut_simd_f64s(&mut into.0).0.copy_from_slice(&sum[..parts]);
        }
    }
}

/// `into = ahead + by_mean·mean + by_rise·rise` for one axis.
pub(super) struct Apply<'a> {
    pub ahead: &'a [Rows],
    pub by_mean: &'a [Rows],
    pub by_rise: &'a [Rows],
    pub mean: f64,
    pub rise: f64,
    pub into: &'a mut [Rows],
}

impl WithSimd for Apply<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (mean, rise) = (simd.splat_f64s(self.mean), simd.splat_f64s(self.rise));
        let rows = self.ahead.iter().zip(self.by_mean).zip(self.by_rise);
        for (into, ((ahead, by_mean), by_rise)) in self.into.iter_mut().zip(rows) {
            let into = S::as_mut_simd_f64s(&mut into.0).0;
            let [ahead, by_mean, by_rise] = [ahead, by_mean, by_rise].map(|rows| S::as_simd_f64s(&rows.0).0);
            for (part, into) in into.iter_mut().enumerate() {
                let under_mean = simd.mul_add_e_f64s(by_mean[part], mean, ahead[part]);
                *into = simd.mul_add_e_f64s(by_rise[part], rise, under_mean);
            }
        }
    }
}

/// [`Multiply`] for several axes.
pub(super) struct MultiplyLanes<'a> {
    pub matrix: &'a [LaneRows],
    pub columns: usize,
    pub by: &'a [LaneRows],
    pub into: &'a mut [LaneRows],
}

impl WithSimd for MultiplyLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let parts = LANES / S::F64_LANES;
        for (into, block) in self.into.iter_mut().zip(self.matrix.chunks_exact(self.columns)) {
            let mut sum = [simd.splat_f64s(0.0); LANES * LANE_ROWS];
            for (columns, values) in block.chunks(LANE_ROWS).zip(self.by) {
                for (rows, value) in columns.iter().zip(&values.0) {
                    let (rows, value) = (S::as_simd_f64s(rows.0.as_flattened()).0, S::as_simd_f64s(value).0);
                    // `parts` vectors a row: those of the value repeat from row to row.
                    for k in 0..LANE_ROWS * parts {
                        sum[k] = simd.mul_add_e_f64s(rows[k], value[k % parts], sum[k]);
                    }
                }
            }
            let into = S::as_mut_simd_f64s(into.0.as_flattened_mut()).0;
            into.copy_from_slice(&sum[..LANE_ROWS * parts]);
        }
    }
}

/// `into = from + Σ columns·factors` for several axes, row by row.
pub(super) struct ApplyLanes<'a, const N: usize> {
    pub from: &'a [LaneRows],
    pub columns: [&'a [LaneRows]; N],
    pub factors: [&'a Lane; N],
    pub into: &'a mut [LaneRows],
}

impl<const N: usize> WithSimd for ApplyLanes<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let parts = LANES / S::F64_LANES;
        for (block, into) in self.into.iter_mut().enumerate() {
            for (row, into) in into.0.iter_mut().enumerate() {
                let (into, from) = (S::as_mut_simd_f64s(into).0, S::as_simd_f64s(&self.from[block].0[row]).0);
                for part in 0..parts {
                    let mut sum = from[part];
                    for (column, factor) in self.columns.iter().zip(self.factors) {
                        let (column, factor) =
                            (S::as_simd_f64s(&column[block].0[row]).0, S::as_simd_f64s(factor).0);
                        sum = simd.mul_add_e_f64s(column[part], factor[part], sum);
                    }
                    into[part] = sum;
                }
            }
        }
    }
}
