//! A chosen setting re-checked where the machine is not the stated one.

use super::{Bench, Criterion, Limits, Setting, Tuning};
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;

/// Changes of the moving mass or inertia.
const MASS: [f64; 4] = [-0.2, -0.1, 0.1, 0.2];
/// Shares of the largest friction.
const FRICTION: [f64; 4] = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0];
/// Changes of the base's frequencies.
const BASE: [f64; 4] = [-0.1, -0.05, 0.05, 0.1];
/// Departures at most.
pub(super) const DEPARTURES: usize = MASS.len() + FRICTION.len() + BASE.len();

/// How a machine departs from the stated one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Departure {
    /// Moving mass or inertia changed by this share.
    Mass(f64),
    /// Coulomb friction of this level instead of the stated one, N or N·m.
    Friction(f64),
    /// Frequencies of the base's modes changed by this share.
    BaseFrequencies(f64),
}

/// What settings do on machines that depart from the stated one.
#[derive(Debug, Clone)]
pub struct Robustness {
    /// Each departure with what each setting does there.
    pub rows: Vec<(Departure, Vec<Setting>)>,
    /// Coulomb friction as stated, N or N·m.
    stated_friction: f64,
}

impl Robustness {
    /// Measures settings on every departure that the machine can have.
    ///
    /// # Errors
    /// What the machine refuses.
    pub fn of(
        machine: &Machine,
        tuning: &Tuning,
        settings: &[Vec<f64>],
        each: &(impl Fn(usize) + Sync),
    ) -> Result<Self> {
        let mut departures: Vec<Departure> = MASS.map(Departure::Mass).to_vec();
        if tuning.friction > 0.0 {
            departures.extend(FRICTION.map(|share| Departure::Friction(share * tuning.friction)));
        }
        if !machine.constants().modes.is_empty() {
            departures.extend(BASE.map(Departure::BaseFrequencies));
        }
        let row = |departure: Departure| {
            let departed = departure.machine(machine)?;
            let bench = Bench::new(&departed, &tuning.knobs, &tuning.cells, tuning.dwell_s)?;
            Ok((departure, bench.measure(settings, each)?))
        };
        let stated_friction = machine.number(&friction_path(machine)).unwrap_or(0.0);
        Ok(Self { rows: departures.into_iter().map(row).collect::<Result<_>>()?, stated_friction })
    }

    /// The settings at these places only, the one at `first` first.
    pub(super) fn only(&self, first: usize, others: std::ops::Range<usize>) -> Self {
        let pick = |settings: &Vec<Setting>| {
            [&settings[first]].into_iter().chain(&settings[others.clone()]).cloned().collect()
        };
        let rows = self.rows.iter().map(|(departure, settings)| (*departure, pick(settings))).collect();
        Self { rows, ..*self }
    }

    /// Excess of a setting over the limits, all departures together.
    pub fn excess(&self, setting: usize, limits: &Limits) -> f64 {
        self.rows.iter().map(|(_, settings)| settings[setting].excess(limits)).sum()
    }

    /// What gives first for departures of one kind: the smallest departures at which the first setting exceeds a limit
    /// that it keeps on the stated machine. `nominal`: what it does there.
    pub fn gives_first(&self, limits: &Limits, nominal: &Setting, kind: Kind) -> Vec<Given> {
        let kept = limits.exceeded(&nominal.worst());
        let given = |(departure, settings): &(Departure, Vec<Setting>)| {
            let setting = &settings[0];
            let fresh = limits.exceeded(&setting.worst()).into_iter().filter(|c| !kept.contains(c)).collect();
            let given = Given { departure: *departure, criteria: fresh, is_stable: setting.is_stable };
            (!given.criteria.is_empty() || (nominal.is_stable && !given.is_stable)).then_some(given)
        };
        let of_kind = self.rows.iter().filter(|(departure, _)| departure.kind() == kind);
        let all: Vec<Given> = of_kind.filter_map(given).collect();
        let size = |given: &Given| given.departure.size(self.stated_friction);
        let least = all.iter().map(size).fold(f64::INFINITY, f64::min);
        all.into_iter().filter(|given| size(given) <= least * (1.0 + 1e-9)).collect()
    }
}

/// A departure at which a setting gives, and what it no longer keeps there.
#[derive(Debug, Clone, PartialEq)]
pub struct Given {
    /// The departure.
    pub departure: Departure,
    /// Criteria beyond their limits that were kept before.
    pub criteria: Vec<Criterion>,
    /// Whether the loop is stable there.
    pub is_stable: bool,
}

fn friction_path(machine: &Machine) -> String {
    let id = EffectId::CoulombFriction;
    format!("effect.{}.{}", id.name(), id.parameters()[0].key(machine.motion()))
}

/// What departs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Moving mass or inertia.
    Mass,
    /// Coulomb friction.
    Friction,
    /// Frequencies of the base.
    BaseFrequencies,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 3] = [Self::Mass, Self::Friction, Self::BaseFrequencies];

    /// Its word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mass => "mass",
            Self::Friction => "friction",
            Self::BaseFrequencies => "base frequencies",
        }
    }
}

impl Departure {
    /// What departs.
    pub fn kind(self) -> Kind {
        match self {
            Self::Mass(_) => Kind::Mass,
            Self::Friction(_) => Kind::Friction,
            Self::BaseFrequencies(_) => Kind::BaseFrequencies,
        }
    }

    /// How far it is from the stated machine.
    fn size(self, stated_friction: f64) -> f64 {
        match self {
            Self::Mass(share) | Self::BaseFrequencies(share) => share.abs(),
            Self::Friction(level) => (level - stated_friction).abs(),
        }
    }

    /// The machine that departs.
    fn machine(self, machine: &Machine) -> Result<Machine> {
        let effect = |id: EffectId, value: f64| {
            let path = format!("effect.{}.{}", id.name(), id.parameters()[0].key(machine.motion()));
            (path, value)
        };
        let settings: Vec<(String, f64)> = match self {
            Self::Mass(share) => {
                let (path, more) = effect(EffectId::Payload, share * machine.constants().moving_mass);
                let now = machine.number(&path).unwrap_or(0.0);
                vec![(path, now + more)]
            }
            Self::Friction(level) => vec![(friction_path(machine), level)],
            Self::BaseFrequencies(share) => {
                let modes = machine.description().base.as_ref().map_or(0, |base| base.mode.len());
                (0..modes)
                    .filter_map(|k| {
                        let path = format!("base.mode.{k}.frequency_hz");
                        machine.number(&path).map(|now| (path, now * (1.0 + share)))
                    })
                    .collect()
            }
        };
        machine.with_settings(settings.iter().map(|(path, value)| (path.as_str(), (*value).into())))
    }
}
