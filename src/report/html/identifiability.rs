//! Practical identifiability of each fitted parameter, and the correlation of the errors.

use super::page::Part;
use crate::diagnose::Diagnosis;
use crate::diagnose::identifiability::ParameterIdentifiability;
use crate::diagnose::verdict::{Cause, Parameter};
use crate::report::figure::{Figure, Ink, Matrix, Panel};
use crate::report::number::{percent, with_interval};
use crate::report::words::{name, phrase};

/// A constant's interval beyond this share of its tolerance comes from the tolerance.
const BY_TOLERANCE: f64 = 0.7;
/// Parameters with this interval inflation (a correlation of about 0.98) are identifiable only together.
const TOGETHER: f64 = 5.0;
/// Up to this share of its value, a parameter is well identifiable.
const WELL: f64 = 0.1;

/// The section; empty where nothing was fitted.
pub(super) fn part(diagnosis: &Diagnosis) -> Part {
    let mut part = Part::default();
    let identifiability = &diagnosis.identifiability;
    if identifiability.is_empty() {
        return part;
    }
    part.remark(
        "Standard errors of all parameters of the explanation, causes and stated constants alike, from the fit to the training \
         runs. Interval inflation is how many times wider an interval is than if all other parameters were known, the root of the \
         variance inflation factor: 1 is a parameter that no other compensates.",
    );
    let rows: Vec<Vec<String>> =
        identifiability.parameters.iter().enumerate().map(|(k, of)| row(diagnosis, k, of)).collect();
    part.table(
        &[
            "parameter",
            ">value, 95 % interval",
            ">interval / value",
            ">interval inflation",
            "most correlated with",
            "identifiable",
        ],
        &rows,
    );
    if identifiability.parameters.len() > 1 {
        let matrix = Matrix {
            names: identifiability.parameters.iter().map(|of| word(&of.path)).collect(),
            rows: identifiability.correlation.clone(),
        };
        let caption = "Correlation of the errors of the fitted parameters. Near ±1 the data determine a combination of two \
                       parameters, not each by itself.";
        let figure = Figure::new("correlation", caption, vec![Panel::Matrix(matrix)])
            .legend([(Ink::After, "rise together"), (Ink::Before, "one rises, the other falls")]);
        part.figure(figure);
    }
    part
}

fn row(diagnosis: &Diagnosis, k: usize, of: &ParameterIdentifiability) -> Vec<String> {
    let value = parameter(diagnosis, &of.path).map_or(String::new(), with_interval);
    let most = of.most_correlated_with.map(|other| {
        let rho = diagnosis.identifiability.correlation[k][other];
        format!("{} {} ({})", other + 1, word(&diagnosis.identifiability.parameters[other].path), signed(rho))
    });
    vec![
        format!("{} {}", k + 1, word(&of.path)),
        value,
        of.relative_half_width.map_or("–".to_owned(), half_width),
        of.interval_inflation.map_or("∞".to_owned(), times),
        most.unwrap_or("none".to_owned()),
        judged(of),
    ]
}

/// A parameter of a cause or a calibrated constant.
fn parameter<'a>(diagnosis: &'a Diagnosis, path: &str) -> Option<&'a Parameter> {
    let of_causes = diagnosis.causes.iter().flat_map(Cause::settings);
    let constants = diagnosis.calibration.iter().map(|c| (c.path.clone(), &c.parameter));
    of_causes.chain(constants).find(|(own, _)| own == path).map(|(_, parameter)| parameter)
}

fn word(path: &str) -> String {
    let parts = path.strip_prefix("effect.").and_then(|rest| rest.split_once('.'));
    parts.map_or_else(|| path.to_owned(), |(effect, key)| format!("{}, {}", phrase(effect), name(key)))
}

/// A share of the value; of a value near zero, how many times that.
fn half_width(share: f64) -> String {
    if share < 1.0 { format!("± {}", percent(share)) } else { format!("± {}", times(share)) }
}

fn times(factor: f64) -> String {
    if factor < 10.0 { format!("{factor:.1} ×") } else { format!("{factor:.0} ×") }
}

fn signed(correlation: f64) -> String {
    format!("{correlation:+.2}").replace('-', "−")
}

/// How well a parameter is identifiable, in words: a stated constant by its tolerance (its value may be zero), a cause's parameter
/// by its value.
pub(super) fn judged(of: &ParameterIdentifiability) -> String {
    let share = of.of_tolerance.or(of.relative_half_width);
    let bound = match of.most_correlated_with {
        Some(other) if of.interval_inflation.is_none_or(|factor| factor >= TOGETHER) => {
            format!(", bound to {}", other + 1)
        }
        _ => String::new(),
    };
    let words = match share {
        _ if of.of_tolerance.is_some_and(|share| share >= BY_TOLERANCE) => {
            return "by its tolerance, not by the data".to_owned();
        }
        Some(share) if share < WELL => "well",
        Some(share) if share < 1.0 => "roughly",
        Some(_) => "hardly: its interval is as wide as its value",
        None => "its value is zero: see the interval",
    };
    format!("{words}{bound}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_words_follow_what_bounds_a_parameter() {
        let well = ParameterIdentifiability {
            path: "effect.coulomb_friction.force_n".to_owned(),
            relative_half_width: Some(0.01),
            of_tolerance: None,
            interval_inflation: Some(1.2),
            most_correlated_with: Some(1),
        };
        assert_eq!(judged(&well), "well");
        assert_eq!(
            judged(&ParameterIdentifiability { relative_half_width: Some(0.3), ..well.clone() }),
            "roughly"
        );
        assert!(
            judged(&ParameterIdentifiability { relative_half_width: Some(1.3), ..well.clone() })
                .starts_with("hardly")
        );
        let together = ParameterIdentifiability { interval_inflation: Some(7.0), ..well.clone() };
        assert_eq!(judged(&together), "well, bound to 2");
        assert_eq!(
            judged(&ParameterIdentifiability { interval_inflation: None, ..well.clone() }),
            "well, bound to 2"
        );
        // A stated constant whose value is near zero is known by its tolerance.
        let near_zero =
            ParameterIdentifiability { of_tolerance: Some(1e-4), relative_half_width: Some(9.0), ..well };
        assert_eq!(judged(&near_zero), "well");
        let stated = ParameterIdentifiability { of_tolerance: Some(0.98), ..together };
        assert_eq!(judged(&stated), "by its tolerance, not by the data");
    }
}
