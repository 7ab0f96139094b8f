//! Columns that are a power of ten off what they should be.

use super::inertia::{FORCE, Inertia};
use super::smoothed::Smoothed;
use super::{Check, Finding};
use crate::diagnose::thresholds::{BEYOND_CHANCE, CERTAIN_FACTOR, MOST};
use crate::machine::Machine;
use crate::recording::{Run, Signal, plausibility};
use crate::units::{Dimension, Motion};

/// Units of motion that contradict each other, and forces that do not fit the moving mass.
pub fn unit(run: &Run, machine: &Machine, smoothed: &Smoothed) -> Vec<Finding> {
    // Of several things that are wrong with one signal the first says it best.
    let mut told = Vec::new();
    let first = |finding: &crate::recording::Finding| {
        let is_new = !told.contains(&finding.key);
        told.push(finding.key);
        is_new
    };
    let motion: Vec<Finding> = plausibility(run)
        .into_iter()
        .filter(first)
        .map(|finding| {
            let message = format!(
                "{}: {}, expected {}; {}.",
                finding.key, finding.found, finding.expected, finding.remedy
            );
            match Signal::from_key(finding.key) {
                Some((signal, _)) => {
                    Finding::column(run, Check::ImplausibleUnit, signal, finding.is_unit_factor, message)
                }
                None => Finding::warning(run.name(), Check::ImplausibleUnit, message),
            }
        })
        .collect();
    let force = FORCE.into_iter().filter_map(|signal| {
        let inertia = Inertia::of(machine, smoothed, signal)?;
        // Before its size means anything the motion must explain the force.
        let known = inertia.explained >= MOST && inertia.mass.significance() >= BEYOND_CHANCE;
        let ratio = inertia.mass.value.abs() / machine.constants().moving_mass;
        let (factor, unit) = known.then(|| likely(signal, run.motion(), ratio)).flatten()?;
        let (key, word) = (signal.key(run.motion()), signal.word(run.motion()));
        let is_certain = factor >= CERTAIN_FACTOR || factor <= 1.0 / CERTAIN_FACTOR;
        Some(Finding::column(
            run,
            Check::ImplausibleUnit,
            signal,
            is_certain,
            format!(
                "The {word} is about {} what the moving mass takes: it is probably in {unit}. Give `{key}` its \
                 unit in [columns], or correct the drive's constants in machine.toml.",
                if factor >= 1.0 { format!("{factor} ×") } else { format!("1/{} of", (1.0 / factor).round()) }
            ),
        ))
    });
    motion.into_iter().chain(force).collect()
}

/// A unit that makes numbers so many times larger than the SI unit does, and its name.
type UnitFactor = (f64, &'static str);

/// The unit whose numbers are `ratio` times those in SI.
fn likely(signal: Signal, motion: Motion, ratio: f64) -> Option<UnitFactor> {
    let units: &[UnitFactor] = match signal.dimension(motion) {
        Dimension::Current => &[(1e3, "mA"), (1e6, "µA"), (1e-3, "kA")],
        Dimension::Force => &[(1e-3, "kN"), (1e3, "mN"), (0.1, "daN or kgf")],
        Dimension::Torque => &[(1e3, "mN·m or N·mm"), (1e2, "N·cm"), (1e-3, "kN·m"), (0.1, "kgf·m")],
        Dimension::Voltage => &[(1e3, "mV"), (1e-3, "kV"), (10.0, "% of 10 V")],
        _ => &[],
    };
    // A load may add nearly as much as the moving part, not nine times it.
    let near = |factor: f64| ratio < factor / MOST && ratio > factor * MOST;
    units.iter().copied().find(|(factor, _)| near(*factor))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_only_unit_factors_are_units() {
        let current = |ratio| likely(Signal::Current, Motion::Prismatic, ratio).map(|unit| unit.1);
        assert_eq!(current(1100.0), Some("mA"));
        assert_eq!(current(1e-3), Some("kA"));
        for ratio in [0.1, 0.7, 1.0, 1.6, 3.0, 10.0, 100.0, 500.0, 2000.0] {
            assert_eq!(current(ratio), None, "{ratio}");
        }
        assert_eq!(likely(Signal::Thrust, Motion::Revolute, 1050.0).map(|u| u.1), Some("mN·m or N·mm"));
    }
}
