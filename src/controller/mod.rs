//! Controllers: what turns reference and measurement into the voltage commanded to the amplifier.
//!
//! A controller is its configuration and carries its law; what it remembers between samples lives in
//! a [`Memory`] handed in from outside. A new control law is one file here and one variant of [`Controller`].

pub mod cascade;
pub(crate) mod delay_line;
pub mod effort_limit;
pub mod filter;
mod gains;
pub mod integer;
pub mod pd;
pub mod pdf;
pub mod reference_delay;
pub mod regression;
pub mod regressor;

use filter::FilterMemory;
use serde::{Deserialize, Serialize};

pub use cascade::Cascade;
pub use effort_limit::{AntiWindup, EffortLimit};
pub use filter::{Filter, Filters};
pub use gains::Gains;
pub use pd::Pd;
pub use pdf::Pdf;
pub use reference_delay::ReferenceDelay;

/// What a controller sees at one sample, in SI (m or rad).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Input {
    /// Position reference.
    pub position_reference: f64,
    /// Velocity reference (difference of the position reference over one period).
    pub velocity_reference: f64,
    /// Encoder reading.
    pub position: f64,
    /// Velocity estimate of the sensor.
    pub velocity: f64,
}

/// What a controller remembers between two samples.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Memory {
    /// Integral part of the effort in V.
    pub integral_v: f64,
    /// State of the filters behind the law.
    pub filters: FilterMemory,
}

/// The control laws that a machine may run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(tag = "law", rename_all = "snake_case")]
pub enum Controller {
    /// Pseudo-derivative feedback with integer gains inside a position loop.
    Pdf(Pdf),
    /// Position P, velocity PI.
    Cascade(Cascade),
    /// Position P or PD.
    #[serde(alias = "p")]
    Pd(Pd),
}

impl Controller {
    /// The voltage commanded to the amplifier for this sample; `period_s` is the sample period.
    pub fn effort_v(&self, memory: &mut Memory, input: Input, period_s: f64) -> f64 {
        let gains = self.gains(period_s);
        let effort_v = match self.limit() {
            Some(limit) => limit.effort_v(&gains, memory, input, period_s),
            None => gains.effort_v(memory, input),
        };
        Filters::new(self.filters(), period_s).pass(&mut memory.filters, effort_v)
    }

    /// The filters that its effort, limited, passes before it is commanded.
    pub fn filters(&self) -> &[Filter] {
        match self {
            Self::Pdf(law) => &law.filter,
            Self::Cascade(law) => &law.filter,
            Self::Pd(law) => &law.filter,
        }
    }

    /// The same law without its filters.
    #[must_use]
    pub fn unfiltered(&self) -> Self {
        let mut law = self.clone();
        match &mut law {
            Self::Pdf(law) => law.filter.clear(),
            Self::Cascade(law) => law.filter.clear(),
            Self::Pd(law) => law.filter.clear(),
        }
        law
    }

    /// The limit of the effort inside the law, where it has one: beside it, the law is its [`gains`](Self::gains).
    pub fn limit(&self) -> Option<EffortLimit> {
        match self {
            Self::Pdf(_) | Self::Pd(_) => None,
            Self::Cascade(law) => law.limit(),
        }
    }

    /// The law as its gains, without its limit and its filters.
    pub fn gains(&self, period_s: f64) -> Gains {
        match self {
            Self::Pdf(law) => law.gains(period_s),
            Self::Cascade(law) => law.gains(period_s),
            Self::Pd(law) => law.gains(),
        }
    }

    /// The law with the gains of position loop, velocity loop (the proportional register) and integral multiplied.
    #[must_use]
    pub fn with_gains(&self, [position, velocity, integral]: [f64; 3]) -> Self {
        let mut scaled = self.clone();
        match &mut scaled {
            Self::Pdf(law) => {
                law.position_gain_per_s *= position;
                law.proportional_gain_per_count *= velocity;
                law.integral_gain_per_count *= integral;
            }
            Self::Cascade(law) => {
                law.position_gain_per_s *= position;
                law.velocity_gain_v_s_per_m *= velocity;
                law.velocity_integral_per_s *= integral;
            }
            Self::Pd(law) => {
                law.position_gain_v_per_m *= position;
                law.derivative_gain_v_s_per_m *= velocity;
            }
        }
        scaled
    }

    /// Share of the reference velocity that is fed forward.
    pub fn velocity_feedforward(&self) -> f64 {
        match self {
            Self::Pdf(law) => law.velocity_feedforward,
            Self::Cascade(law) => law.velocity_feedforward,
            Self::Pd(law) => law.velocity_feedforward,
        }
    }

    /// The law with this share of the reference velocity fed forward.
    #[must_use]
    pub fn with_velocity_feedforward(&self, share: f64) -> Self {
        let mut fed = self.clone();
        match &mut fed {
            Self::Pdf(law) => law.velocity_feedforward = share,
            Self::Cascade(law) => law.velocity_feedforward = share,
            Self::Pd(law) => law.velocity_feedforward = share,
        }
        fed
    }

    /// Whether the law has an integral part.
    pub fn integrates(&self) -> bool {
        match self {
            Self::Pdf(law) => law.integral_gain_si() != 0.0,
            Self::Cascade(law) => law.velocity_integral_per_s != 0.0,
            Self::Pd(_) => false,
        }
    }

    /// The memory with which this law would have commanded `effort_v` on `input`: how a replay
    /// that starts inside a recording takes over without a bump; without an integral part it does not reach as far. An effort at
    /// the law's limit is taken as just reaching it: how far the integral part is wound up is not recorded. Filters are
    /// taken as settled at it.
    pub fn memory_for(&self, effort_v: f64, input: Input, period_s: f64) -> Memory {
        let filters = Filters::new(self.filters(), period_s).steady(effort_v);
        if !self.integrates() {
            return Memory { filters, ..Memory::default() };
        }
        let mut blank = Memory::default();
        let without = self.gains(period_s).effort_v(&mut blank, input);
        // Both laws add the integral part linearly and first add this sample's increment to it.
        Memory { integral_v: effort_v - without, filters }
    }
}
