//! The catalogue of effects: what a real machine does that its twin may leave out.
//!
//! Each effect is one law in one file, attached to one [`Site`] of the signal path. To add one:
//! - write the law's file here, which implements [`Law`]: what the effect does, and what machine files, blind trials, reports
//!   and `slideway effects` need of it;
//! - add its line to `every_law!` below;
//! - implement [`Estimate`](crate::diagnose::estimate::Estimate) for it in `diagnose/estimate`: where a fit begins and how far it
//!   looks.
//!
//! A line without a law or without an estimate does not compile. The physics, which the twin calls, knows nothing of estimation.
//!
//! An effect in a machine file is a table under its id, for instance
//!
//! ```toml
//! [effect.coulomb_friction]
//! force_n = 15.0
//! ```
//!
//! # Design
//! The catalogue is a closed enum: it can be listed, written to a file and matched exhaustively. A machine
//! holds each effect at most once, so the order in which effects are written or found never matters.

pub mod amplifier_offset;
pub mod asymmetric_friction;
pub mod back_emf;
pub mod backlash;
pub mod base_mode_shift;
pub mod cable_spring;
mod catalogue;
pub mod cogging;
pub mod constant_force;
pub mod constants;
pub mod controller_gain;
pub mod coulomb_friction;
pub mod current_loop;
pub mod dead_zone;
pub mod encoder_periodic_error;
pub mod encoder_resolution;
pub mod encoder_scale;
pub mod encoder_zero;
pub mod external_vibration;
pub mod flexible_mode;
pub mod force_constant;
pub mod force_ripple;
pub mod force_saturation;
pub mod friction_drift;
pub mod further_pitch;
mod harmonics;
mod lack;
pub mod law;
pub mod likeness;
pub mod load_dependent_friction;
pub mod local_friction;
pub mod loop_delay;
pub mod payload;
pub mod presliding;
pub mod prior;
mod reading_error;
pub mod screw_error;
pub mod sensor_scale;
pub mod stretch;
pub mod stribeck_friction;
pub mod unlike;
pub mod velocity_feedforward;
pub mod velocity_filter;
pub mod viscous_friction;
pub mod voltage_saturation;
pub mod wave;
pub mod winding_inductance;
pub mod winding_resistance;

pub use amplifier_offset::AmplifierOffset;
pub use asymmetric_friction::AsymmetricFriction;
pub use back_emf::BackEmf;
pub use backlash::Backlash;
pub use base_mode_shift::BaseModeShift;
pub use cable_spring::CableSpring;
pub use cogging::Cogging;
pub use constant_force::ConstantForce;
pub use constants::Constants;
pub use controller_gain::{CONTROLLER_GAIN, IntegralGain, PositionGain, VelocityGain};
pub use coulomb_friction::CoulombFriction;
pub use current_loop::CurrentLoop;
pub use dead_zone::DeadZone;
pub use encoder_periodic_error::EncoderPeriodicError;
pub use encoder_resolution::EncoderResolution;
pub use encoder_scale::EncoderScale;
pub use encoder_zero::EncoderZero;
pub use external_vibration::ExternalVibration;
pub use flexible_mode::FlexibleMode;
pub use force_constant::ForceConstant;
pub use force_ripple::ForceRipple;
pub use force_saturation::ForceSaturation;
pub use friction_drift::FrictionDrift;
pub use further_pitch::{SecondCogging, SecondForceRipple, ThirdCogging};
pub use lack::Lack;
pub use law::{Door, FormNumber, Law, Nominal, Parameter, Site, Usual};
pub use likeness::{Degree, Likeness, Rule};
pub use load_dependent_friction::LoadDependentFriction;
pub use local_friction::LocalFriction;
pub use loop_delay::LoopDelay;
pub use payload::Payload;
pub use presliding::Presliding;
pub use prior::{Machinery, Prior};
pub use screw_error::ScrewError;
pub use sensor_scale::SensorScale;
pub use stretch::Stretch;
pub use stribeck_friction::StribeckFriction;
pub use unlike::Unlike;
pub use velocity_feedforward::VelocityFeedforward;
pub use velocity_filter::VelocityFilter;
pub use viscous_friction::ViscousFriction;
pub use voltage_saturation::VoltageSaturation;
pub use wave::Wave;
pub use winding_inductance::WindingInductance;
pub use winding_resistance::WindingResistance;

/// Gives the lines of the catalogue, `id: Struct` in the order of the signal path, to a macro.
macro_rules! every_law {
    ($make:ident) => {
        $make! {
            position_gain: PositionGain,
            velocity_gain: VelocityGain,
            integral_gain: IntegralGain,
            velocity_feedforward: VelocityFeedforward,
            loop_delay: LoopDelay,
            voltage_saturation: VoltageSaturation,
            dead_zone: DeadZone,
            amplifier_offset: AmplifierOffset,
            current_loop: CurrentLoop,
            winding_resistance: WindingResistance,
            winding_inductance: WindingInductance,
            back_emf: BackEmf,
            force_constant: ForceConstant,
            force_saturation: ForceSaturation,
            force_ripple: ForceRipple,
            second_force_ripple: SecondForceRipple,
            cogging: Cogging,
            second_cogging: SecondCogging,
            third_cogging: ThirdCogging,
            viscous_friction: ViscousFriction,
            coulomb_friction: CoulombFriction,
            asymmetric_friction: AsymmetricFriction,
            stribeck_friction: StribeckFriction,
            presliding: Presliding,
            load_dependent_friction: LoadDependentFriction,
            local_friction: LocalFriction,
            friction_drift: FrictionDrift,
            constant_force: ConstantForce,
            cable_spring: CableSpring,
            external_vibration: ExternalVibration,
            payload: Payload,
            base_mode_shift: BaseModeShift,
            flexible_mode: FlexibleMode,
            backlash: Backlash,
            screw_error: ScrewError,
            sensor_scale: SensorScale,
            encoder_scale: EncoderScale,
            encoder_zero: EncoderZero,
            encoder_periodic_error: EncoderPeriodicError,
            encoder_resolution: EncoderResolution,
            velocity_filter: VelocityFilter,
        }
    };
}
pub(crate) use every_law;

/// The motor's force per what would be in proportion to its current, at a position and at that force in N or N·m: `1 + Σ` of the
/// [changes](Law::motor_change) of these effects.
#[inline]
pub fn motor_factor(effects: &[Effect], position: f64, force: f64) -> f64 {
    1.0 + effects.iter().map(|effect| effect.motor_change(position, force)).sum::<f64>()
}

use catalogue::catalogue;
every_law!(catalogue);
