//! The gains of a law as unknowns: what each of them multiplies in the effort.

use super::integer::IntegerGain;
use super::{Cascade, Controller, Input, Pd, Pdf};

/// Which gains of a law are unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unknown {
    /// Those of the velocity loop; position gain and feed-forward are as stated.
    #[default]
    VelocityLoop,
    /// Those of the velocity loop, the position gain and the velocity feed-forward.
    BothLoops,
}

/// A gain of a law and its regressor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Key in the machine file, below `controller`.
    pub key: &'static str,
    /// What it multiplies, in the symbols of the law's docs.
    pub regressor: &'static str,
    /// The value stated.
    pub stated: f64,
    /// Content of the register that multiplies it, where it is a gain per count.
    pub register: Option<i64>,
}

/// Two consecutive samples of a law's inputs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Sample k − 1.
    pub before: Input,
    /// Sample k.
    pub now: Input,
    /// T in s.
    pub period_s: f64,
}

/// The signals of a sample that gains multiply.
#[derive(Debug, Clone, Copy)]
struct Terms {
    /// x_ref − x.
    position_error: f64,
    /// v_ref.
    reference: f64,
    /// v.
    velocity: f64,
}

impl Terms {
    fn of(input: Input) -> Self {
        Self {
            position_error: input.position_reference - input.position,
            reference: input.velocity_reference,
            velocity: input.velocity,
        }
    }

    /// e = position·(x_ref − x) + feedforward·v_ref − v.
    fn error(&self, position: f64, feedforward: f64) -> f64 {
        position * self.position_error + feedforward * self.reference - self.velocity
    }

    fn less(&self, before: &Self) -> Self {
        Self {
            position_error: self.position_error - before.position_error,
            reference: self.reference - before.reference,
            velocity: self.velocity - before.velocity,
        }
    }
}

/// What a law says of its effort at a sample, as a linear regression.
///
/// # Model
/// ```text
///   u(k) = ρ·u(k−1) + increment         ρ = 1 with an integral part, else 0 (no such term)
///   increment = I·e(k) + E·Δe(k) − V·Δv(k)              Δ: difference to sample k−1; without integral part: none
/// ```
/// with the gains I, E, V of [`Gains`](super::Gains). `regressors` are the derivatives of `increment` by the unknown
/// gains, at the law's own: with the gains of the position loop stated, the effort is linear in the others and the
/// regressors are those of the paper's eq. 10.
///
/// # Source
/// Liu, Lai, Yen (2009), eqs. 4–10, with the sign of C2 corrected.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// What the law with its own gains adds to ρ·u(k−1), V.
    pub increment: f64,
    /// One per unknown gain.
    pub regressors: Vec<f64>,
}

impl Controller {
    /// The unknown gains, in the order of [`Row::regressors`].
    pub fn unknown_gains(&self, unknown: Unknown) -> Vec<Gain> {
        let gain = |key, regressor, stated| Gain { key, regressor, stated, register: None };
        let mut gains = match self {
            Self::Pdf(law) => {
                let counted =
                    |gain: Gain, register: IntegerGain| Gain { register: Some(register.into()), ..gain };
                vec![
                    counted(
                        gain("integral_gain_per_count", "n_i·s·T·e(k)", law.integral_gain_per_count),
                        law.integral,
                    ),
                    counted(
                        gain("proportional_gain_per_count", "−n_p·s·Δv(k)", law.proportional_gain_per_count),
                        law.proportional,
                    ),
                ]
            }
            Self::Cascade(law) => {
                let velocity = law.velocity_gain_v_s_per_m;
                match self.integrates() {
                    true => vec![
                        gain("velocity_gain_v_s_per_m", "Δe(k) + Ki·T·e(k)", velocity),
                        gain("velocity_integral_per_s", "Kv·T·e(k)", law.velocity_integral_per_s),
                    ],
                    false => vec![gain("velocity_gain_v_s_per_m", "e(k)", velocity)],
                }
            }
            Self::Pd(law) => {
                let derivative = law.derivative_gain_v_s_per_m;
                let mut gains =
                    vec![gain("position_gain_v_per_m", "x_ref(k) − x(k)", law.position_gain_v_per_m)];
                if derivative != 0.0 {
                    gains.push(gain("derivative_gain_v_s_per_m", "f·v_ref(k) − v(k)", derivative));
                }
                gains
            }
        };
        if let (Unknown::BothLoops, Some([position, feedforward])) = (unknown, self.position_loop()) {
            gains.push(gain("position_gain_per_s", "x_ref − x, through e", position));
            gains.push(gain("velocity_feedforward", "v_ref, through e", feedforward));
        }
        gains
    }

    /// Position gain in 1/s and velocity feed-forward of the loop around the velocity loop; none for a law without one.
    fn position_loop(&self) -> Option<[f64; 2]> {
        match self {
            Self::Pdf(law) => Some([law.position_gain_per_s, law.velocity_feedforward]),
            Self::Cascade(law) => Some([law.position_gain_per_s, law.velocity_feedforward]),
            Self::Pd(_) => None,
        }
    }

    /// The law with these values of its unknown gains.
    pub fn with_unknown_gains(&self, unknown: Unknown, values: &[f64]) -> Self {
        let mut law = self.clone();
        let mut values = values.iter().copied();
        let mut next = |slot: &mut f64| *slot = values.next().unwrap_or(*slot);
        let integrates = self.integrates();
        match &mut law {
            Self::Pdf(law) => {
                next(&mut law.integral_gain_per_count);
                next(&mut law.proportional_gain_per_count);
                if unknown == Unknown::BothLoops {
                    next(&mut law.position_gain_per_s);
                    next(&mut law.velocity_feedforward);
                }
            }
            Self::Cascade(law) => {
                next(&mut law.velocity_gain_v_s_per_m);
                if integrates {
                    next(&mut law.velocity_integral_per_s);
                }
                if unknown == Unknown::BothLoops {
                    next(&mut law.position_gain_per_s);
                    next(&mut law.velocity_feedforward);
                }
            }
            Self::Pd(law) => {
                next(&mut law.position_gain_v_per_m);
                if law.derivative_gain_v_s_per_m != 0.0 {
                    next(&mut law.derivative_gain_v_s_per_m);
                }
            }
        }
        law
    }

    /// The regression at a sample.
    pub fn regress(&self, unknown: Unknown, step: Step) -> Row {
        let (now, before) = (Terms::of(step.now), Terms::of(step.before));
        let gains = self.gains(step.period_s);
        let is_level = !self.integrates();
        // Without an integral part the effort itself is linear, not its increment.
        let change = if is_level { now } else { now.less(&before) };
        let error = |terms: &Terms| terms.error(gains.position, gains.feedforward);
        let increment =
            gains.integral * error(&now) + gains.error * error(&change) - gains.velocity * change.velocity;
        let mut regressors = match self {
            Self::Pdf(law) => pdf(law, error(&now), change.velocity, step.period_s),
            Self::Cascade(law) => cascade(law, error(&now), error(&change), step.period_s, is_level),
            Self::Pd(law) => pd(law, &now),
        };
        if unknown == Unknown::BothLoops && self.position_loop().is_some() {
            let by = |pick: fn(&Terms) -> f64| gains.integral * pick(&now) + gains.error * pick(&change);
            regressors.push(by(|terms| terms.position_error));
            regressors.push(by(|terms| terms.reference));
        }
        Row { increment, regressors }
    }
}

fn pdf(law: &Pdf, error: f64, change: f64, period_s: f64) -> Vec<f64> {
    let units = law.velocity_units_per_si;
    vec![
        f64::from(law.integral.value()) * units * period_s * error,
        -f64::from(law.proportional.value()) * units * change,
    ]
}

fn pd(law: &Pd, now: &Terms) -> Vec<f64> {
    let mut regressors = vec![now.position_error];
    if law.derivative_gain_v_s_per_m != 0.0 {
        regressors.push(law.velocity_feedforward * now.reference - now.velocity);
    }
    regressors
}

fn cascade(law: &Cascade, error: f64, change: f64, period_s: f64, is_level: bool) -> Vec<f64> {
    if is_level {
        return vec![change];
    }
    let by_integral = law.velocity_gain_v_s_per_m * period_s * error;
    vec![change + law.velocity_integral_per_s * period_s * error, by_integral]
}
