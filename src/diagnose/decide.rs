//! The decision: what the evidence says, unless something forbids to say it.
//!
//! One pure function of the evidence and the grounds for withholding. Every verdict passes here: nothing else sets one.

use super::grounds::{Grounds, Withheld};
use super::thresholds::{ADEQUATE_GAP, LARGELY, OPEN_SHARE, PROBABILITY, SMALL_GAP, STATED_NOISE};
use crate::recording::Signal;
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

/// The limits of the decision, in the search and at its end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Posterior probability from which something is decided.
    pub probability: f64,
    /// Share of the gap's power up to which it may stay open where the noise was seen in the recording, ten times as much where it is
    /// only stated; what closes that much is worth naming. A thousandth is 3 % of the amplitude, as stated constants and the form of a
    /// law are known.
    pub open_share: f64,
    /// What may stay open of a gap that is closed to nine tenths, as a multiple of the noise: less need not be named.
    pub small_gap: f64,
}

impl Limits {
    /// Log-odds of the probability that decides: what one explanation must have over another to be taken in its place.
    pub fn log_odds(&self) -> f64 {
        (self.probability / (1.0 - self.probability)).ln()
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self { probability: PROBABILITY, open_share: OPEN_SHARE, small_gap: SMALL_GAP }
    }
}

/// Power of a gap above that of noise, in units of noise: G² − 1, nothing below.
pub fn above_noise(gap: f64) -> f64 {
    (gap * gap - 1.0).max(0.0)
}

/// What an explanation comes to for one signal of the held-out runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignalEvidence {
    /// The signal.
    pub signal: Signal,
    /// G of the signal.
    pub after: f64,
    /// Share of the power of its gap that is closed.
    pub closed: f64,
    /// Whether no more is left of it than noise would leave.
    pub is_quiet: bool,
}

/// What the evidence comes to for the most probable explanation.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// Whether it has effects.
    pub names_effects: bool,
    /// Whether the twin as it is leaves noise of each signal, and no more.
    pub was_quiet: bool,
    /// G with the explanation in the twin, its numbers moved as far as training and held-out runs together move them (the posterior-predictive gap).
    pub gap_after: f64,
    /// Share of the gap's power that its effects close beside calibration.
    pub closed: f64,
    /// The same of each signal by itself.
    pub signals: Vec<SignalEvidence>,
    /// G of the calibrated twin on the training runs.
    pub training_before: f64,
    /// G on the training runs with the explanation in the twin, as fitted to them.
    pub training_after: f64,
    /// Whether the noise was seen in the recording.
    pub noise_is_measured: bool,
    /// Posterior probability that all of its effects act.
    pub probability: f64,
}

impl Evidence {
    /// The verdict that the evidence gives.
    ///
    /// - `unknown`: more is left of the held-out runs, or of the training runs, than may stay open.
    /// - `no_gap`: no effect is named, and noise is all that is left of each signal, or all that there was.
    /// - `cause`: little is left, and the effects named act with the probability that decides.
    /// - `undecided`: little is left, and other effects may act in their place.
    pub fn verdict(&self, limits: &Limits) -> Verdict {
        if !self.leaves_little(limits) {
            Verdict::Unknown
        } else if !self.names_effects {
            Verdict::NoGap
        } else if self.probability >= limits.probability {
            Verdict::Cause
        } else {
            Verdict::Undecided
        }
    }

    /// Whether held-out and training runs are explained.
    pub fn leaves_little(&self, limits: &Limits) -> bool {
        self.explains_held_out(limits) && self.explains_training(limits)
    }

    /// Whether no more is left of the held-out runs than noise leaves, than a small gap, or than the share that may stay open, and no signal by
    /// itself is unexplained; without effects, noise is all that is left of each signal or all that there was.
    ///
    /// In units of its noise one signal may have nearly all of the gap, and its share hides that another is not explained: a back-EMF that closes 99.99 % of
    /// the position's and leaves nearly all of the current's is not what acts.
    pub fn explains_held_out(&self, limits: &Limits) -> bool {
        let is_little = self.leaves_little_in_all(limits)
            && !self.signals.iter().any(|of| self.is_unexplained(of, limits));
        let leaves_noise = self.gap_after <= ADEQUATE_GAP;
        if self.names_effects {
            leaves_noise || is_little
        } else {
            self.was_quiet || leaves_noise && self.signals.iter().all(|of| of.is_quiet)
        }
    }

    /// A share of the gap may stay open as stated constants and the form of a law are only nearly right. That shows in the training runs as well: what is left
    /// of the held-out runs is no more than a small gap beside it.
    fn leaves_little_in_all(&self, limits: &Limits) -> bool {
        let is_small = self.gap_after <= limits.small_gap && self.closed >= LARGELY;
        let shown = limits.small_gap * self.noise_power().sqrt() * self.training_after.max(1.0);
        is_small || self.closed >= 1.0 - self.may_stay(limits) && self.gap_after <= shown
    }

    /// The signals for which alone the held-out runs are not explained: all together leave little; without effects, noise.
    pub fn deciding_signals(&self, limits: &Limits) -> Vec<SignalEvidence> {
        let leaves_noise = self.gap_after <= ADEQUATE_GAP;
        let is_open = |of: &&SignalEvidence| match self.names_effects {
            true => !leaves_noise && self.leaves_little_in_all(limits) && self.is_unexplained(of, limits),
            false => leaves_noise && !of.is_quiet && !self.was_quiet,
        };
        self.signals.iter().filter(is_open).copied().collect()
    }

    /// Whether a signal is not explained: more than a small gap is left of it, and less than nine tenths of its gap's power is closed.
    fn is_unexplained(&self, of: &SignalEvidence, limits: &Limits) -> bool {
        of.closed < LARGELY && above_noise(of.after) > above_noise(limits.small_gap) * self.noise_power()
    }

    /// Whether no more is left of the training runs than a small gap, or than the share that may stay open.
    ///
    /// The numbers are fitted to these runs: what is left of them is no uncertainty of numbers. An event that the held-out runs do not have (a blow,
    /// a place that they do not reach) shows here only.
    pub fn explains_training(&self, limits: &Limits) -> bool {
        self.training_after <= limits.small_gap
            || above_noise(self.training_after) <= self.may_stay(limits) * above_noise(self.training_before)
    }

    /// Share of the gap's power that may stay open.
    fn may_stay(&self, limits: &Limits) -> f64 {
        limits.open_share * self.noise_power()
    }

    /// What the noise may have in power, in units of what was taken for it.
    fn noise_power(&self) -> f64 {
        if self.noise_is_measured { 1.0 } else { STATED_NOISE }
    }
}

/// The verdict on evidence, and what forbids to give it.
///
/// A fatal finding in the data forbids every verdict but `unknown`.
///
/// A reference that no explanation fits forbids every verdict but `unknown`. One that is explained for nine tenths forbids none: the rest is noise
/// of the comparison, and a change has to stand out of it. One that is `undecided` forbids none: its explanations
/// predict it alike, to what need not be named, so what changed since does not depend on the choice among them; only the values before do. One whose explanation is not identified, and leaves
/// more than a small gap, forbids every verdict but `unknown` and `no_gap`: an error of the baseline cannot be told from a change.
///
/// An explanation that is not identified forbids every verdict but `unknown`: an effect of it is not significant, or a number is at the bound
/// of its range.
///
/// A rigid-body proof that fails forbids `cause`, and `unknown` that calls its causes found in part. `no_gap` has no explanation to
/// prove. `undecided` names none: the proof is of one of several explanations and does not judge the others.
pub fn decide(evidence: &Evidence, limits: &Limits, grounds: &Grounds) -> (Verdict, Option<Withheld>) {
    let evident = evidence.verdict(limits);
    let rests_on_proof = matches!(evident, Verdict::Cause | Verdict::Unknown);
    match grounds.withhold(evident != Verdict::NoGap, rests_on_proof) {
        Some(withheld) => (Verdict::Unknown, Some(withheld)),
        None => (evident, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::check::{Finding, Severity};
    use crate::diagnose::grounds::{Before, Unidentified, Veto};
    use crate::diagnose::prove::RigidBody;

    const LIMITS: Limits = Limits { probability: 0.7, open_share: 1e-3, small_gap: 3.0 };
    const ALL: [Verdict; 4] = [Verdict::NoGap, Verdict::Cause, Verdict::Undecided, Verdict::Unknown];

    /// Beside a gap of 1000, nearly all closed, by effects that act for certain.
    const CLEAR: Evidence = Evidence {
        names_effects: true,
        was_quiet: false,
        gap_after: 1.0,
        closed: 1.0,
        signals: Vec::new(),
        training_before: 1000.0,
        training_after: 1.0,
        noise_is_measured: true,
        probability: 1.0,
    };

    /// Evidence that gives this verdict.
    fn evidence(verdict: Verdict) -> Evidence {
        match verdict {
            Verdict::NoGap => Evidence { names_effects: false, ..CLEAR },
            Verdict::Cause => CLEAR,
            Verdict::Undecided => Evidence { probability: 0.5, ..CLEAR },
            Verdict::Unknown => Evidence { gap_after: 100.0, closed: 0.99, ..CLEAR },
        }
    }

    fn decided(verdict: Verdict, grounds: &Grounds) -> (Verdict, Option<Withheld>) {
        decide(&evidence(verdict), &LIMITS, grounds)
    }

    /// Beside a gap of 1000 × noise, 30 left are a thousandth of its power, 100 a hundredth: that much may stay open where the noise
    /// was seen, and where it is only stated.
    #[test]
    fn exact_a_small_share_of_the_gap_may_stay_open() {
        let verdict = |gap: f64, noise_is_measured: bool| {
            let closed = 1.0 - (gap * gap - 1.0) / (1e6 - 1.0);
            Evidence { gap_after: gap, closed, noise_is_measured, training_after: 20.0, ..CLEAR }
                .verdict(&LIMITS)
        };
        assert_eq!([verdict(30.0, true), verdict(33.0, true)], [Verdict::Cause, Verdict::Unknown]);
        assert_eq!([verdict(95.0, false), verdict(105.0, false)], [Verdict::Cause, Verdict::Unknown]);
    }

    /// Of 1000 × noise 20 may stay, where the training runs show 7 of them, and not where they show 6: that is no fault of the form of a law.
    #[test]
    fn exact_what_the_training_runs_do_not_show_may_not_stay() {
        let verdict = |training_after: f64| {
            Evidence { gap_after: 20.0, closed: 0.9996, training_after, ..CLEAR }.verdict(&LIMITS)
        };
        assert_eq!([verdict(7.0), verdict(6.0)], [Verdict::Cause, Verdict::Unknown]);
        let stated = Evidence { gap_after: 20.0, closed: 0.9996, noise_is_measured: false, ..CLEAR };
        let verdict = |training_after: f64| Evidence { training_after, ..stated.clone() }.verdict(&LIMITS);
        assert_eq!([verdict(2.2), verdict(2.0)], [Verdict::Cause, Verdict::Unknown]);
    }

    /// A gap up to three times the noise may stay of one that is closed to nine tenths, and 1.25 of any.
    #[test]
    fn exact_a_small_gap_may_stay() {
        let verdict = |gap_after: f64, closed: f64| Evidence { gap_after, closed, ..CLEAR }.verdict(&LIMITS);
        assert_eq!([verdict(2.9, 0.91), verdict(2.9, 0.89)], [Verdict::Cause, Verdict::Unknown]);
        assert_eq!([verdict(3.1, 0.91), verdict(1.24, 0.1)], [Verdict::Unknown, Verdict::Cause]);
        let nothing = |was_quiet: bool, gap_after: f64| {
            Evidence { names_effects: false, was_quiet, gap_after, ..CLEAR }.verdict(&LIMITS)
        };
        assert_eq!([nothing(false, 1.2), nothing(true, 9.0)], [Verdict::NoGap; 2]);
        assert_eq!(nothing(false, 1.3), Verdict::Unknown);
    }

    /// Without effects one signal that is not quiet is a gap, though all together leave noise, and is told; with effects it may be a small gap.
    #[test]
    fn exact_one_signal_that_is_not_quiet_is_a_gap() {
        let evidence = |names_effects: bool, was_quiet: bool, is_quiet: bool| {
            let signals =
                vec![SignalEvidence { signal: Signal::Position, after: 1.5, closed: 0.0, is_quiet }];
            Evidence { names_effects, was_quiet, signals, gap_after: 1.2, closed: 0.0, ..CLEAR }
        };
        let verdict = |names, was, is| evidence(names, was, is).verdict(&LIMITS);
        assert_eq!([verdict(false, false, true), verdict(false, true, false)], [Verdict::NoGap; 2]);
        assert_eq!(
            [verdict(false, false, false), verdict(true, false, false)],
            [Verdict::Unknown, Verdict::Cause]
        );
        let told = |names, was, is| evidence(names, was, is).deciding_signals(&LIMITS).len();
        assert_eq!(
            [told(false, false, false), told(false, true, false), told(true, false, false)],
            [1, 0, 0]
        );
    }

    /// Beside a gap of 1000 × noise that is closed but for 30, a signal that keeps more than three times its noise must be closed to nine tenths; noise that
    /// is only stated may be ten times as much.
    #[test]
    fn exact_one_signal_that_is_not_explained_is_enough() {
        let verdict = |after: f64, closed: f64, noise_is_measured: bool| {
            let of = |signal, after, closed| SignalEvidence { signal, after, closed, is_quiet: false };
            let signals = vec![of(Signal::Position, 1.0, 1.0), of(Signal::Current, after, closed)];
            let left = Evidence { gap_after: 30.0, closed: 0.9991, training_after: 20.0, ..CLEAR };
            Evidence { signals, noise_is_measured, ..left }.verdict(&LIMITS)
        };
        assert_eq!(
            [verdict(60.0, 0.91, true), verdict(60.0, 0.89, true)],
            [Verdict::Cause, Verdict::Unknown]
        );
        assert_eq!([verdict(2.9, 0.0, true), verdict(3.1, 0.0, true)], [Verdict::Cause, Verdict::Unknown]);
        assert_eq!([verdict(8.9, 0.0, false), verdict(9.1, 0.0, false)], [Verdict::Cause, Verdict::Unknown]);
        let deciding = |gap_after: f64, closed: f64| {
            let signals =
                vec![SignalEvidence { signal: Signal::Current, after: 60.0, closed: 0.4, is_quiet: false }];
            Evidence { gap_after, closed, signals, training_after: 20.0, ..CLEAR }
                .deciding_signals(&LIMITS)
                .len()
        };
        assert_eq!([deciding(30.0, 0.9991), deciding(300.0, 0.91), deciding(1.2, 1.0)], [1, 0, 0]);
    }

    /// What explains the held-out runs is no verdict where of the training runs more than a small gap is left, and more than a thousandth of the power
    /// that calibration leaves of them.
    #[test]
    fn exact_training_runs_that_are_not_explained_withhold_every_verdict_of_the_held_out_runs() {
        for evident in [Verdict::NoGap, Verdict::Cause, Verdict::Undecided] {
            let verdict = |training_before: f64, training_after: f64| {
                Evidence { training_before, training_after, ..evidence(evident) }.verdict(&LIMITS)
            };
            assert_eq!([verdict(3.0, 2.9), verdict(3.2, 3.1)], [evident, Verdict::Unknown]);
            assert_eq!([verdict(1000.0, 31.0), verdict(1000.0, 33.0)], [evident, Verdict::Unknown]);
        }
    }

    const UNEXPLAINED: Before = Before { is_explained: false, is_identified: true, gap_after: 5.0 };

    #[test]
    fn exact_a_reference_without_an_explanation_withholds_every_verdict() {
        for evident in ALL {
            let grounds = Grounds { reference: Some(UNEXPLAINED), ..Grounds::default() };
            let (verdict, withheld) = decided(evident, &grounds);
            assert_eq!((verdict, withheld.map(|w| w.by)), (Verdict::Unknown, Some(Veto::Reference)));
        }
    }

    /// An explanation may close all of the gap: with a number at the bound of its range it is not identified, and the reason names the number.
    #[test]
    fn exact_what_is_not_identified_withholds_every_verdict() {
        let hidden = Unidentified::NotSignificant { effect: "friction_drift" };
        let ran_off =
            Unidentified::AtBound { effect: "local_friction", number: "width_m", value: 0.113, unit: "m" };
        let open = Unidentified::PeriodOpen { effect: "cogging", up_to: 1.57, of_motor: 0.06, unit: "m" };
        for evident in ALL {
            let all = [
                (hidden, "friction_drift"),
                (ran_off, "width_m of local_friction"),
                (Unidentified::SearchEnded { effects: 6 }, "6 effects, as many as are looked for"),
                (open, "reaches 1.57 m, and the pitch of a motor is 60.0 mm at most"),
            ];
            for (unidentified, told) in all {
                let grounds = Grounds { unidentified: Some(&unidentified), ..Grounds::default() };
                let (verdict, withheld) = decided(evident, &grounds);
                let withheld = withheld.unwrap();
                assert_eq!((verdict, withheld.by), (Verdict::Unknown, Veto::Unidentified));
                assert!(withheld.reason.contains(told), "{}", withheld.reason);
            }
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
        for evident in ALL {
            let by = |severity| {
                let checks = [finding(Severity::Note), finding(severity)];
                let grounds = Grounds { checks: &checks, reference: Some(UNEXPLAINED), ..Grounds::default() };
                decided(evident, &grounds).1.unwrap().by
            };
            assert_eq!(by(Severity::Fatal), Veto::Data);
            assert_eq!(by(Severity::Warning), Veto::Reference);
        }
    }

    #[test]
    fn exact_any_other_reference_and_none_leave_the_verdict_to_the_evidence() {
        for evident in ALL {
            assert_eq!(decided(evident, &Grounds::default()), (evident, None));
            let reference = Some(Before { is_explained: true, ..UNEXPLAINED });
            assert_eq!(decided(evident, &Grounds { reference, ..Grounds::default() }), (evident, None));
        }
    }

    #[test]
    fn exact_a_reference_that_is_not_identified_withholds_every_verdict_about_a_gap() {
        let reference = Some(Before { is_explained: true, is_identified: false, gap_after: 67.0 });
        for evident in ALL {
            let (verdict, withheld) = decided(evident, &Grounds { reference, ..Grounds::default() });
            let by = withheld.map(|withheld| withheld.by);
            match evident {
                Verdict::NoGap => assert_eq!((verdict, by), (evident, None)),
                _ => assert_eq!((verdict, by), (Verdict::Unknown, Some(Veto::Reference))),
            }
        }
    }

    fn proof(closed: f64, upper: f64, on_axis: f64) -> RigidBody {
        let closed_ci95 = [closed - 0.1, upper];
        RigidBody { before: 10.0, after: 8.0, closed, closed_ci95, closed_on_axis: on_axis, runs: Vec::new() }
    }

    #[test]
    fn exact_a_proof_that_surely_closes_less_than_half_of_what_the_axis_closes_forbids_a_cause() {
        let on = |evident, closed, upper, on_axis| {
            let proof = proof(closed, upper, on_axis);
            let (verdict, withheld) =
                decided(evident, &Grounds { rigid_body: Some(&proof), ..Grounds::default() });
            (verdict, withheld.map(|w| w.by))
        };
        let by = |evident, closed, upper| on(evident, closed, upper, 1.0);
        let failed = Some(Veto::RigidBody);
        assert_eq!(by(Verdict::Cause, -3.3, -1.0), (Verdict::Unknown, failed));
        assert_eq!(by(Verdict::Cause, 0.3, 0.49), (Verdict::Unknown, failed));
        assert_eq!(by(Verdict::Unknown, 0.3, 0.49), (Verdict::Unknown, failed));
        // What closes as little on both plants is confirmed, however little it is.
        assert_eq!(on(Verdict::Unknown, 0.3, 0.4, 0.32), (Verdict::Unknown, None));
        assert_eq!(on(Verdict::Unknown, 0.1, 0.15, 0.32), (Verdict::Unknown, failed));
        // What may be half is not refuted, and what cannot be told is no proof against.
        assert_eq!(by(Verdict::Cause, 0.4, 0.5), (Verdict::Cause, None));
        assert_eq!(by(Verdict::Cause, 0.4, f64::NAN), (Verdict::Cause, None));
        assert_eq!(by(Verdict::Undecided, 0.1, 0.2), (Verdict::Undecided, None));
        assert_eq!(by(Verdict::NoGap, 0.1, 0.2), (Verdict::NoGap, None));
    }
}
