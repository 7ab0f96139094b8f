//! Keys, flags and units of sliding and turning axes, and what is missing by its flag.

use crate::units::Motion;

/// A number that is missing, and the flag that states it.
#[derive(Debug, Clone, PartialEq)]
pub struct Lack {
    /// The flag.
    pub flag: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it is, and why the log does not tell it.
    pub why: String,
}

/// Keys, flags and units that differ between sliding and turning axes.
pub struct Names {
    pub mass: &'static str,
    pub mass_unit: &'static str,
    pub acceleration_unit: &'static str,
    pub force_constant: &'static str,
    pub force_constant_key: &'static str,
    pub force_constant_unit: &'static str,
    pub force_per_volt: &'static str,
    pub force_per_volt_key: &'static str,
    pub force_per_volt_unit: &'static str,
    pub back_emf_key: &'static str,
    pub back_emf_unit: &'static str,
    pub viscous_key: &'static str,
    pub viscous_unit: &'static str,
    pub force_unit: &'static str,
    pub force_key: &'static str,
    pub resolution: &'static str,
    pub noise: &'static str,
    pub position_unit: &'static str,
    pub velocity_gain: &'static str,
    pub position_gain: &'static str,
}

impl Names {
    /// Those of a motion.
    pub fn of(motion: Motion) -> Self {
        match motion {
            Motion::Prismatic => Self {
                mass: "--mass",
                mass_unit: "kg",
                acceleration_unit: "m/s²",
                force_constant: "--force-constant",
                force_constant_key: "force_constant_n_per_a",
                force_constant_unit: "N/A",
                force_per_volt: "--force-per-volt",
                force_per_volt_key: "force_n_per_v",
                force_per_volt_unit: "N/V",
                back_emf_key: "back_emf_v_s_per_m",
                back_emf_unit: "V·s/m",
                viscous_key: "viscous_n_s_per_m",
                viscous_unit: "N·s/m",
                force_unit: "N",
                force_key: "force_n",
                resolution: "resolution_m",
                noise: "noise_m",
                position_unit: "m",
                velocity_gain: "velocity_gain_v_s_per_m",
                position_gain: "position_gain_v_per_m",
            },
            Motion::Revolute => Self {
                mass: "--inertia",
                mass_unit: "kg·m²",
                acceleration_unit: "rad/s²",
                force_constant: "--torque-constant",
                force_constant_key: "torque_constant_nm_per_a",
                force_constant_unit: "N·m/A",
                force_per_volt: "--torque-per-volt",
                force_per_volt_key: "torque_nm_per_v",
                force_per_volt_unit: "N·m/V",
                back_emf_key: "back_emf_v_s_per_rad",
                back_emf_unit: "V·s/rad",
                viscous_key: "viscous_nm_s_per_rad",
                viscous_unit: "N·m·s/rad",
                force_unit: "N·m",
                force_key: "torque_nm",
                resolution: "resolution_rad",
                noise: "noise_rad",
                position_unit: "rad",
                velocity_gain: "velocity_gain_v_s_per_rad",
                position_gain: "position_gain_v_per_rad",
            },
        }
    }
}
