//! The verdict: what the evidence says, unless something forbids to say it.
//!
//! Every verdict passes here: nothing else sets one.

use super::check::{Finding, Severity};
use super::prove::RigidBody;
use serde::{Deserialize, Serialize};

/// What a diagnosis comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The twin predicts the held-out runs as well as noise allows, calibration inside tolerance included.
    NoGap,
    /// One or several effects explain the gap.
    Cause,
    /// Several explanations do equally well on the held-out runs.
    Undecided,
    /// There is a gap that no effect of the catalogue explains.
    Unknown,
}

impl Verdict {
    /// The word of the JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoGap => "no_gap",
            Self::Cause => "cause",
            Self::Undecided => "undecided",
            Self::Unknown => "unknown",
        }
    }
}

/// What forbids the verdict that the evidence would give.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Veto {
    /// A column is certainly not what it is taken for: any explanation would be about that.
    Data,
    /// No explanation fits the reference of a comparison: what it leaves open cannot be told from a change.
    Reference,
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
    /// Its verdict.
    pub verdict: Verdict,
    /// G that is left of it.
    pub gap_after: f64,
}

/// What may forbid a verdict.
#[derive(Debug, Clone, Copy, Default)]
pub struct Grounds<'a> {
    /// What the checks of the data found.
    pub checks: &'a [Finding],
    /// In a comparison, what the reference came to.
    pub reference: Option<Before>,
    /// The proof of the explanation in the rigid-body scene, where there is one.
    pub rigid_body: Option<&'a RigidBody>,
}

/// The verdict on evidence that speaks for `evident`, and what forbids to give that.
///
/// A fatal finding in the data forbids every verdict but `unknown`.
///
/// A reference that came to `unknown` forbids every verdict but `unknown`. One that is `undecided` forbids none: its explanations
/// predict it alike, so what changed since does not depend on the choice among them; only the values before do.
///
/// A rigid-body proof that fails forbids `cause`, and `unknown` that calls its causes found in part. `no_gap` has no explanation to
/// prove. `undecided` names none: the proof is of one of several explanations and does not judge the others.
pub fn decide(evident: Verdict, grounds: &Grounds) -> (Verdict, Option<Withheld>) {
    let proof =
        || matches!(evident, Verdict::Cause | Verdict::Unknown).then(|| failed_proof(grounds)).flatten();
    match faulty_data(grounds).or_else(|| unexplained_reference(grounds)).or_else(proof) {
        Some(withheld) => (Verdict::Unknown, Some(withheld)),
        None => (evident, None),
    }
}

/// The fatal findings.
pub fn fatal(checks: &[Finding]) -> impl Iterator<Item = &Finding> {
    checks.iter().filter(|finding| finding.severity == Severity::Fatal)
}

fn faulty_data(grounds: &Grounds) -> Option<Withheld> {
    let first = fatal(grounds.checks).next()?;
    Some(Withheld {
        by: Veto::Data,
        reason: format!("Any explanation would be about a fault of the data. {}", first.message),
    })
}

fn failed_proof(grounds: &Grounds) -> Option<Withheld> {
    let proof = grounds.rigid_body.filter(|proof| proof.has_failed())?;
    let reason = format!(
        "In the rigid-body scene the explanation closes {:.0} % of the gap (at most {:.0} %, the upper end of the 95 % interval), less than \
         half: it rests on what the reduced axis leaves out.",
        100.0 * proof.closed,
        100.0 * proof.closed_ci95[1]
    );
    Some(Withheld { by: Veto::RigidBody, reason })
}

fn unexplained_reference(grounds: &Grounds) -> Option<Withheld> {
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

    const ALL: [Verdict; 4] = [Verdict::NoGap, Verdict::Cause, Verdict::Undecided, Verdict::Unknown];

    fn reference(verdict: Verdict) -> Before {
        Before { verdict, gap_after: 5.0 }
    }

    #[test]
    fn exact_a_reference_without_an_explanation_withholds_every_verdict() {
        let unknown = reference(Verdict::Unknown);
        for evident in ALL {
            let grounds = Grounds { reference: Some(unknown), ..Grounds::default() };
            let (verdict, withheld) = decide(evident, &grounds);
            assert_eq!((verdict, withheld.map(|w| w.by)), (Verdict::Unknown, Some(Veto::Reference)));
        }
    }

    #[test]
    fn exact_a_fatal_finding_withholds_every_verdict_before_all_else() {
        let finding = |severity| Finding {
            run: String::new(),
            check: crate::diagnose::check::Check::SwappedSign,
            severity,
            signal: None,
            message: "The current has the wrong sign.".to_owned(),
        };
        let unknown = reference(Verdict::Unknown);
        for evident in ALL {
            let by = |severity| {
                let checks = [finding(Severity::Note), finding(severity)];
                let grounds = Grounds { checks: &checks, reference: Some(unknown), ..Grounds::default() };
                decide(evident, &grounds).1.unwrap().by
            };
            assert_eq!(by(Severity::Fatal), Veto::Data);
            assert_eq!(by(Severity::Warning), Veto::Reference);
        }
    }

    #[test]
    fn exact_any_other_reference_and_none_leave_the_verdict_to_the_evidence() {
        for evident in ALL {
            assert_eq!(decide(evident, &Grounds::default()), (evident, None));
            for before in [Verdict::NoGap, Verdict::Cause, Verdict::Undecided] {
                let reference = reference(before);
                let grounds = Grounds { reference: Some(reference), ..Grounds::default() };
                assert_eq!(decide(evident, &grounds), (evident, None));
            }
        }
    }

    fn proof(closed: f64, upper: f64) -> RigidBody {
        RigidBody { before: 10.0, after: 8.0, closed, closed_ci95: [closed - 0.1, upper], runs: Vec::new() }
    }

    #[test]
    fn exact_a_proof_that_surely_closes_less_than_half_forbids_a_cause() {
        let by = |evident, closed, upper| {
            let proof = proof(closed, upper);
            let (verdict, withheld) =
                decide(evident, &Grounds { rigid_body: Some(&proof), ..Grounds::default() });
            (verdict, withheld.map(|w| w.by))
        };
        let failed = Some(Veto::RigidBody);
        assert_eq!(by(Verdict::Cause, -3.3, -1.0), (Verdict::Unknown, failed));
        assert_eq!(by(Verdict::Cause, 0.3, 0.49), (Verdict::Unknown, failed));
        assert_eq!(by(Verdict::Unknown, 0.3, 0.49), (Verdict::Unknown, failed));
        // What may be half is not refuted, and what cannot be told is no proof against.
        assert_eq!(by(Verdict::Cause, 0.4, 0.5), (Verdict::Cause, None));
        assert_eq!(by(Verdict::Cause, 0.4, f64::NAN), (Verdict::Cause, None));
        assert_eq!(by(Verdict::Undecided, 0.1, 0.2), (Verdict::Undecided, None));
        assert_eq!(by(Verdict::NoGap, 0.1, 0.2), (Verdict::NoGap, None));
    }
}
