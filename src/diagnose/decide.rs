//! The verdict: what the evidence says, unless something forbids to say it.

use super::verdict::{Reference, Verdict};
use serde::Serialize;

/// What forbids the verdict that the evidence would give.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Veto {
    /// No explanation fits the reference of a comparison: what it leaves open cannot be told from a change.
    Reference,
}

/// A verdict that was withheld: it is `unknown`, whatever the evidence says.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Withheld {
    /// What forbids it.
    pub by: Veto,
    /// Why, as a sentence.
    pub reason: String,
}

/// What may forbid a verdict.
#[derive(Debug, Clone, Copy, Default)]
pub struct Grounds<'a> {
    /// In a comparison, the diagnosis of the reference.
    pub reference: Option<&'a Reference>,
}

/// The verdict on evidence that speaks for `evident`, and what forbids to give that.
///
/// A reference that came to `unknown` forbids every verdict but `unknown`. One that is `undecided` forbids none: its explanations
/// predict it alike, so what changed since does not depend on the choice among them; only the values before do.
pub fn decide(evident: Verdict, grounds: &Grounds) -> (Verdict, Option<Withheld>) {
    match veto(grounds) {
        Some(withheld) => (Verdict::Unknown, Some(withheld)),
        None => (evident, None),
    }
}

fn veto(grounds: &Grounds) -> Option<Withheld> {
    let reference = grounds.reference.filter(|reference| reference.verdict == Verdict::Unknown)?;
    let reason = format!(
        "No explanation fits the reference (a gap of {:.3} × noise is left of it): what the twin lacks of the machine before cannot be \
         told from what changed since.",
        reference.gap_after
    );
    Some(Withheld { by: Veto::Reference, reason })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::verdict::Data;

    const ALL: [Verdict; 4] = [Verdict::NoGap, Verdict::Cause, Verdict::Undecided, Verdict::Unknown];

    fn reference(verdict: Verdict) -> Reference {
        let data = Data {
            machine: String::new(),
            training: Vec::new(),
            held_out: Vec::new(),
            sha256: String::new(),
            note: None,
        };
        Reference { verdict, causes: Vec::new(), gap_before: 20.0, gap_after: 5.0, data }
    }

    #[test]
    fn exact_a_reference_without_an_explanation_withholds_every_verdict() {
        let unknown = reference(Verdict::Unknown);
        for evident in ALL {
            let (verdict, withheld) = decide(evident, &Grounds { reference: Some(&unknown) });
            assert_eq!((verdict, withheld.map(|w| w.by)), (Verdict::Unknown, Some(Veto::Reference)));
        }
    }

    #[test]
    fn exact_any_other_reference_and_none_leave_the_verdict_to_the_evidence() {
        for evident in ALL {
            assert_eq!(decide(evident, &Grounds::default()), (evident, None));
            for before in [Verdict::NoGap, Verdict::Cause, Verdict::Undecided] {
                let reference = reference(before);
                assert_eq!(decide(evident, &Grounds { reference: Some(&reference) }), (evident, None));
            }
        }
    }
}
