//! The sampled equations of motor, moving part and controller: as printed, and corrected.

use super::sheet::Section;
use crate::controller::Controller;
use crate::drive::motor::Motor;
use crate::drive::printed::{self, ControlEffort, Variant};
use crate::error::Result;
use crate::identify::transfer::TransferFunction;
use crate::machine::Machine;
use nalgebra::Complex;

const VARIANTS: [(Variant, &str); 2] = [(Variant::AsPrinted, "printed"), (Variant::Corrected, "corrected")];
/// Decimals of W(z) as printed, with which P*(z) is formed.
const W_DECIMALS: i32 = 2;
/// A pole nearer to the unit circle than this is on it.
const ON_CIRCLE: f64 = 1e-9;

/// L(z), W(z), P*(z) = W(z)·L(z) and the control effort, as printed and corrected, with poles and stability; none where
/// the machine has no winding or no integer PDF law.
///
/// `worktable` is the identified W(z), whatever period it belongs to: the paper takes its coefficients as they are.
///
/// # Errors
/// Numbers with which the printed motor has no value.
pub fn printed_equations(machine: &Machine, worktable: &TransferFunction) -> Result<Option<Section>> {
    let d = machine.description();
    let (Motor::Winding(winding), Some(Controller::Pdf(law))) = (&d.motor, &d.controller) else {
        return Ok(None);
    };
    let (r, l, kt) = (winding.resistance_ohm, winding.inductance_h, winding.force_constant_n_per_a);
    let w = printed::rounded(worktable, W_DECIMALS)?;
    let w = TransferFunction::new(w.numerator().to_vec(), w.denominator().to_vec(), d.sample_period_s)?;
    let mut rows = Vec::new();
    for (variant, name) in VARIANTS {
        let motor = printed::motor(variant, r, l, kt, d.sample_period_s)?;
        rows.push(row("L(z)", name, format!("{motor:.4}"), &motor, 4));
    }
    rows.push(row("W(z)", "", format!("{w:.2}"), &w, 2));
    for (variant, name) in VARIANTS {
        let plant = printed::plant(variant, &w, r, l, kt)?;
        rows.push(row("P*(z)", name, format!("{plant:.3}"), &plant, 4));
    }
    for (variant, name) in VARIANTS {
        let effort = ControlEffort::of(variant, law, d.sample_period_s);
        let sign = if effort.feeds_back_negatively() { "negatively" } else { "positively" };
        rows.push(vec![format!("u(k), {name}"), effort.to_string(), format!("feeds y back {sign}")]);
    }
    let exact = printed::zero_order_hold_pole(r, l, d.sample_period_s)?;
    Ok(Some(
        Section::new("Equations as printed and corrected")
            .table_with(&["", "equation", "poles"], rows, 3)
            .remark(format!(
                "Eqs. 7, 11 and 8. L(z) in N/V and W(z) in mm/s per N, with the digits with which a paper computes on; its sign of R·T in L(z) and \
                 of y in u(k) are misprints. The exact pole of the winding is {exact:.5}; replays use that."
            )),
    ))
}

fn row(what: &str, name: &str, text: String, function: &TransferFunction, decimals: usize) -> Vec<String> {
    let poles: Vec<String> = function.poles().iter().map(|pole| pole_text(*pole, decimals)).collect();
    let stability = if function.is_stable() { "stable" } else { "unstable" };
    let what = if name.is_empty() { what.to_owned() } else { format!("{what}, {name}") };
    vec![what, text, format!("{}: {stability}", poles.join(", "))]
}

fn pole_text(pole: Complex<f64>, decimals: usize) -> String {
    if pole.im.abs() < ON_CIRCLE { format!("{:.decimals$}", pole.re) } else { format!("{pole:.decimals$}") }
}
