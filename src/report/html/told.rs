//! How well the data tell each fitted number, and which numbers they tell only together.

use super::page::Part;
use crate::diagnose::Diagnosis;
use crate::diagnose::told::ToldNumber;
use crate::diagnose::verdict::Parameter;
use crate::report::figure::{Figure, Ink, Matrix, Panel};
use crate::report::number::{percent, with_interval};
use crate::report::sentence::{name, phrase};

/// A constant's interval beyond this share of its tolerance comes from the tolerance.
const BY_TOLERANCE: f64 = 0.7;
/// Numbers widened this often by others (a correlation of about 0.98) are told together only.
const TOGETHER: f64 = 5.0;
/// Up to this share of its value, a number is told well.
const WELL: f64 = 0.1;

/// The section; empty where nothing was fitted.
pub(super) fn part(diagnosis: &Diagnosis) -> Part {
    let mut part = Part::default();
    let told = &diagnosis.told;
    if told.is_empty() {
        return part;
    }
    part.remark(
        "Errors of all numbers of the explanation, causes and stated constants alike, as the fit to the training runs leaves \
         them. “Wider by others” is how many times narrower an interval were if all other numbers were known: 1 is a number \
         that stands alone.",
    );
    let rows: Vec<Vec<String>> =
        told.numbers.iter().enumerate().map(|(k, number)| row(diagnosis, k, number)).collect();
    part.table(
        &[
            "number",
            ">value, 95 % interval",
            ">interval / value",
            ">wider by others",
            "most correlated with",
            "told",
        ],
        &rows,
    );
    if told.numbers.len() > 1 {
        let matrix = Matrix {
            names: told.numbers.iter().map(|number| word(&number.path)).collect(),
            rows: told.correlation.clone(),
        };
        let caption = "Correlation of the errors of the fitted numbers. Near ±1 the data tell a combination of two numbers, \
                       not each by itself.";
        let figure = Figure::new("correlation", caption, vec![Panel::Matrix(matrix)])
            .legend([(Ink::After, "rise together"), (Ink::Before, "one rises, the other falls")]);
        part.figure(figure);
    }
    part
}

fn row(diagnosis: &Diagnosis, k: usize, number: &ToldNumber) -> Vec<String> {
    let value = parameter(diagnosis, &number.path).map_or(String::new(), with_interval);
    let most = number.most_with.map(|other| {
        let rho = diagnosis.told.correlation[k][other];
        format!("{} {} ({})", other + 1, word(&diagnosis.told.numbers[other].path), signed(rho))
    });
    vec![
        format!("{} {}", k + 1, word(&number.path)),
        value,
        number.relative_half_width.map_or("–".to_owned(), half_width),
        number.widened_by_others.map_or("∞".to_owned(), times),
        most.unwrap_or("none".to_owned()),
        judged(number),
    ]
}

/// A number of the causes or a calibrated constant.
fn parameter<'a>(diagnosis: &'a Diagnosis, path: &str) -> Option<&'a Parameter> {
    let of_cause = diagnosis.causes.iter().find_map(|cause| {
        let key = path.strip_prefix(&format!("effect.{}.", cause.effect))?;
        cause.parameters.get(key)
    });
    let constants = diagnosis.calibration.iter();
    of_cause.or_else(|| constants.filter(|c| c.path == path).map(|c| &c.parameter).next())
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

/// What is to be thought of a number, in words: a stated constant by its tolerance (its value may be zero), a cause's number by
/// its value.
pub(super) fn judged(number: &ToldNumber) -> String {
    let share = number.of_tolerance.or(number.relative_half_width);
    let bound = match number.most_with {
        Some(other) if number.widened_by_others.is_none_or(|factor| factor >= TOGETHER) => {
            format!(", bound to {}", other + 1)
        }
        _ => String::new(),
    };
    let words = match share {
        _ if number.of_tolerance.is_some_and(|share| share >= BY_TOLERANCE) => {
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
    fn exact_words_follow_what_bounds_a_number() {
        let number = ToldNumber {
            path: "effect.coulomb_friction.force_n".to_owned(),
            relative_half_width: Some(0.01),
            of_tolerance: None,
            widened_by_others: Some(1.2),
            most_with: Some(1),
        };
        assert_eq!(judged(&number), "well");
        assert_eq!(judged(&ToldNumber { relative_half_width: Some(0.3), ..number.clone() }), "roughly");
        assert!(
            judged(&ToldNumber { relative_half_width: Some(1.3), ..number.clone() }).starts_with("hardly")
        );
        let together = ToldNumber { widened_by_others: Some(7.0), ..number.clone() };
        assert_eq!(judged(&together), "well, bound to 2");
        assert_eq!(judged(&ToldNumber { widened_by_others: None, ..number.clone() }), "well, bound to 2");
        // A stated constant whose value is near zero is known by its tolerance.
        let near_zero = ToldNumber { of_tolerance: Some(1e-4), relative_half_width: Some(9.0), ..number };
        assert_eq!(judged(&near_zero), "well");
        let stated = ToldNumber { of_tolerance: Some(0.98), ..together };
        assert_eq!(judged(&stated), "by its tolerance, not by the data");
    }
}
