//! What forbids a verdict.

use super::check::{Finding, Severity};
use super::cut::Cut;
use super::cut::contradiction::Contradiction;
use super::prove::RigidBody;
use crate::units::engineering;
use serde::{Deserialize, Serialize};

/// What forbids the verdict that the evidence would give.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Veto {
    /// A column is certainly not what it is taken for: any explanation would be about that.
    Data,
    /// No explanation fits the reference of a comparison, or none that is identified: an error of the baseline cannot be told from a change.
    Reference,
    /// Of the explanation that predicts best an effect is not significant, or a number is at the bound of its range.
    Unidentified,
    /// With the explanation that predicts best, a stretch of the signal path does not give its logged output from its logged input.
    Stretch,
    /// In the rigid-body scene the explanation does not close what it closes on the reduced axis.
    RigidBody,
}

/// A verdict that was withheld: it is `unknown`, whatever the evidence says.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Withheld {
    /// What forbids it.
    pub by: Veto,
    /// Why, as a sentence.
    pub reason: String,
}

/// What the reference of a comparison came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Before {
    /// Whether an explanation fits it, or closes its gap for the most part.
    pub is_explained: bool,
    /// Whether that explanation is identified, or leaves no more than a small gap.
    pub is_identified: bool,
    /// G that is left of it.
    pub gap_after: f64,
}

/// Why an explanation is not identified by the training runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unidentified {
    /// An effect is not significant: the 95 % intervals of its numbers hold the twin's own.
    NotSignificant {
        /// Effect id.
        effect: &'static str,
    },
    /// A number is at the bound of where a fit may look.
    AtBound {
        /// Effect id.
        effect: &'static str,
        /// The number's key.
        number: &'static str,
        /// Where it ended, in `unit`.
        value: f64,
        /// Unit of the number.
        unit: &'static str,
    },
    /// The period of a wave over place is longer than the pitch of any motor, and not told: its 95 % interval is wider than an octave, and reaches beyond the longest that a fit may look for.
    PeriodOpen {
        /// Effect id.
        effect: &'static str,
        /// Upper end of the interval, in `unit`.
        up_to: f64,
        /// The longest pitch of a motor, in `unit`.
        of_motor: f64,
        /// Unit of the period.
        unit: &'static str,
    },
    /// Two effects are waves whose pitches are not told apart.
    Merged([&'static str; 2]),
    /// It has as many effects as are looked for at once.
    SearchEnded {
        /// How many.
        effects: usize,
    },
    /// The log contradicts it.
    Contradicted(Contradiction),
}

/// What may forbid a verdict.
#[derive(Debug, Clone, Copy, Default)]
pub struct Grounds<'a> {
    /// What the checks of the data found.
    pub checks: &'a [Finding],
    /// In a comparison, what the reference came to.
    pub reference: Option<Before>,
    /// Why the explanation that predicts best is not identified, where it is not.
    pub unidentified: Option<&'a Unidentified>,
    /// The proof of the explanation in the rigid-body scene, where there is one.
    pub rigid_body: Option<&'a RigidBody>,
}

/// The fatal findings.
pub fn fatal(checks: &[Finding]) -> impl Iterator<Item = &Finding> {
    checks.iter().filter(|finding| finding.severity == Severity::Fatal)
}

fn contradicted(contradiction: Contradiction) -> Withheld {
    let (cut, why) = match contradiction {
        Contradiction::AtRest => {
            (Cut::Controller, "reproduces the effort at rest worse with it than as stated")
        }
        Contradiction::Open(cut) => {
            (cut, "is off with it by more than the twin's closed loop is: what is missing is there")
        }
    };
    let reason = format!(
        "The explanation that predicts best is contradicted by the log: the stretch {}, replayed alone from its measured input, {why}.",
        cut.words()
    );
    Withheld { by: Veto::Stretch, reason }
}

impl Grounds<'_> {
    /// What forbids the verdict that the evidence would give; a reference that is not identified counts where the recording shows a gap, the rigid-body proof where a verdict
    /// rests on it.
    pub fn withhold(&self, shows_gap: bool, rests_on_proof: bool) -> Option<Withheld> {
        let proof = || rests_on_proof.then(|| self.failed_proof()).flatten();
        let baseline = || shows_gap.then(|| self.unidentified_reference()).flatten();
        let first = self.faulty_data().or_else(|| self.unexplained_reference()).or_else(baseline);
        first.or_else(|| self.not_identified()).or_else(proof)
    }

    fn faulty_data(&self) -> Option<Withheld> {
        let first = fatal(self.checks).next()?;
        Some(Withheld {
            by: Veto::Data,
            reason: format!("Any explanation would be about a fault of the data. {}", first.message),
        })
    }

    fn not_identified(&self) -> Option<Withheld> {
        let why = match *self.unidentified? {
            Unidentified::NotSignificant { effect } => {
                format!(
                    "{effect} is not significant in the training runs (the 95 % intervals of its numbers hold the twin's own)"
                )
            }
            Unidentified::AtBound { effect, number, value, unit } => {
                format!("{number} of {effect} is at the bound of where a fit may look ({value:.3e} {unit})")
            }
            Unidentified::PeriodOpen { effect, up_to, of_motor, unit } => {
                let [up_to, of_motor] = [up_to, of_motor].map(|length| engineering(length, unit));
                format!(
                    "the period of {effect} is uncertain (its 95 % interval reaches {up_to}, and the pitch of a motor is {of_motor} at most), and a force that changes along the travel without \
                     repeating does the same"
                )
            }
            Unidentified::Merged([one, other]) => {
                format!(
                    "the pitches of {one} and {other} are not told apart (the 95 % interval of their difference holds zero), and one wave whose amplitude changes \
                     along the travel does the same"
                )
            }
            Unidentified::SearchEnded { effects } => {
                format!(
                    "it takes {effects} effects, as many as are looked for at once, and one effect that is not in the catalogue, or was left out of it, may do what several of them do"
                )
            }
            Unidentified::Contradicted(contradiction) => return Some(contradicted(contradiction)),
        };
        let reason = format!("The explanation that predicts best is not identified: {why}.");
        Some(Withheld { by: Veto::Unidentified, reason })
    }

    fn failed_proof(&self) -> Option<Withheld> {
        let proof = self.rigid_body.filter(|proof| proof.has_failed())?;
        let reason = format!(
            "In the rigid-body scene the explanation closes {:.0} % of the gap (at most {:.0} %, the upper end of the 95 % interval), less than \
             half of the {:.0} % that it closes on the reduced axis: it rests on what that leaves out.",
            100.0 * proof.closed,
            100.0 * proof.closed_ci95[1],
            100.0 * proof.closed_on_axis
        );
        Some(Withheld { by: Veto::RigidBody, reason })
    }

    fn unexplained_reference(&self) -> Option<Withheld> {
        let reference = self.reference.filter(|reference| !reference.is_explained)?;
        let reason = format!(
            "No explanation fits the reference (a gap of {:.1} × noise is left of it): what the twin lacks of the machine before cannot be \
             told from what changed since.",
            reference.gap_after
        );
        Some(Withheld { by: Veto::Reference, reason })
    }

    fn unidentified_reference(&self) -> Option<Withheld> {
        let reference = self.reference.filter(|reference| !reference.is_identified)?;
        let reason = format!(
            "The explanation of the reference is not identified, and leaves a gap of {:.1} × noise. With another \
             explanation of the reference another change may be the cause.",
            reference.gap_after
        );
        Some(Withheld { by: Veto::Reference, reason })
    }
}
