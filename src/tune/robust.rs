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

/// What a setting does on machines that depart from the stated one.
#[derive(Debug, Clone)]
pub struct Robustness {
    /// Each departure with what the setting does there.
    pub rows: Vec<(Departure, Setting)>,
}

impl Robustness {
    /// Measures one setting on every departure that the machine can have.
    ///
    /// # Errors
    /// What the machine refuses.
    pub(super) fn of(
        machine: &Machine,
        tuning: &Tuning,
        values: &[f64],
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
            let setting = bench.measure(&[values.to_vec()], each)?;
            Ok(setting.into_iter().next().map(|setting| (departure, setting)))
        };
        let rows: Vec<_> = departures.into_iter().map(row).collect::<Result<_>>()?;
        Ok(Self { rows: rows.into_iter().flatten().collect() })
    }

    /// What gives first for departures of one kind: the smallest departure beyond the limits, and the criterion.
    pub fn gives_first(&self, limits: &Limits, kind: Kind) -> Option<(Departure, Criterion)> {
        let of_kind = self.rows.iter().filter(|(departure, _)| departure.kind() == kind);
        let given =
            of_kind.filter_map(|(departure, setting)| Some((*departure, limits.worst(&setting.worst())?)));
        given.min_by(|(a, _), (b, _)| a.size().total_cmp(&b.size()))
    }
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

    fn size(self) -> f64 {
        match self {
            Self::Mass(size) | Self::Friction(size) | Self::BaseFrequencies(size) => size.abs(),
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
            Self::Friction(level) => vec![effect(EffectId::CoulombFriction, level)],
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
