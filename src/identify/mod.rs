//! Identification from recorded signals: ARX, frequency response, excitation, least squares.
//!
//! Everything here takes plain slices sampled at one period in seconds; units of the signals are the
//! caller's. "The data do not determine it" is an [`Outcome`](excitation::Outcome), not an error.

pub mod arx;
mod check;
pub mod continuous;
pub mod decimation;
pub mod excitation;
pub mod first_order;
pub mod frequency_response;
pub mod least_squares;
pub mod loop_response;
pub mod margins;
pub mod modes;
pub mod nonlinear;
mod polynomial;
pub mod stepped_sine;
pub mod transfer;
pub mod whiteness;
