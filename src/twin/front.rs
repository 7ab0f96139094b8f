//! Sensors, controller and amplifier of several twins at once, where nothing but their numbers differs.

use super::{Command, Sample};
use crate::plant::axis::{LANES, Lane};
use pulp::{Simd, WithSimd};

/// The signal path from encoder to amplifier, lane by lane in arrays.
///
/// It takes the place of [`Path::sample`](super::path::Path::sample) for paths whose encoder shows the position as it is, whose velocity is a smoothed
/// difference, and whose controller sees the reference at once and has no limit; the operations are the same in the same order.
#[derive(Debug, Clone)]
pub(super) struct Front {
    lanes: usize,
    pub numbers: Numbers,
    previous: Lane,
    estimate: Lane,
    integral_v: Lane,
    /// Voltages commanded, a row a period; the newest at `newest`.
    commanded: Vec<Lane>,
    newest: usize,
    /// How many rows back the voltage is that the delay lets through.
    back: [usize; LANES],
    is_delayed: bool,
    /// Whether the command is a duty cycle.
    has_supply: bool,
}

/// The numbers of one path that the front needs, or of all of them.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Numbers<T = Lane> {
    /// One over the sample period.
    pub rate: T,
    pub share: T,
    pub position: T,
    pub feedforward: T,
    pub integral: T,
    pub error: T,
    pub velocity: T,
    pub dead_zone_v: T,
    pub offset_v: T,
    pub limit_v: T,
    /// Volts applied per volt of command.
    pub supply_v: T,
    pub force_constant: T,
}

/// What one path brings into the front.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub numbers: Numbers<f64>,
    pub previous: f64,
    pub estimate: f64,
    pub integral_v: f64,
    /// Commanded voltages, the newest first, as many as the delay needs.
    pub commanded: Vec<f64>,
    pub is_split: bool,
    /// Whether the command is a duty cycle.
    pub has_supply: bool,
    pub has_winding: bool,
}

/// Readings and efforts of one sample.
#[derive(Debug, Clone, Copy)]
struct Sampled {
    velocity: Lane,
    effort_v: Lane,
    /// What the amplifier makes of it without a delay.
    applied_v: Lane,
}

impl Front {
    /// The front of what the paths bring into it, in the states that they are in; none where one of them does not fit.
    pub fn of(entries: &[Entry]) -> Option<Self> {
        if !entries.iter().all(|entry| entry.has_winding) {
            return None;
        }
        let across = |of: &dyn Fn(&Entry) -> f64| -> Lane {
            // Lanes that are not there repeat the first: no number of theirs is ever out of range.
            std::array::from_fn(|k| of(entries.get(k).unwrap_or(&entries[0])))
        };
        let rows = entries.iter().map(|entry| entry.commanded.len()).max()?;
        let row = |k: usize| across(&|e| e.commanded.get(k).or(e.commanded.last()).copied().unwrap_or(0.0));
        let entry = |k: usize| entries.get(k).unwrap_or(&entries[0]);
        Some(Self {
            lanes: entries.len(),
            numbers: Numbers {
                rate: across(&|e| e.numbers.rate),
                share: across(&|e| e.numbers.share),
                position: across(&|e| e.numbers.position),
                feedforward: across(&|e| e.numbers.feedforward),
                integral: across(&|e| e.numbers.integral),
                error: across(&|e| e.numbers.error),
                velocity: across(&|e| e.numbers.velocity),
                dead_zone_v: across(&|e| e.numbers.dead_zone_v),
                offset_v: across(&|e| e.numbers.offset_v),
                limit_v: across(&|e| e.numbers.limit_v),
                supply_v: across(&|e| e.numbers.supply_v),
                force_constant: across(&|e| e.numbers.force_constant),
            },
            previous: across(&|e| e.previous),
            estimate: across(&|e| e.estimate),
            integral_v: across(&|e| e.integral_v),
            // Row 0 is the newest; the ring goes backwards in time from there.
            commanded: (0..rows).map(row).collect(),
            newest: 0,
            back: std::array::from_fn(|k| entry(k).commanded.len() - 2),
            has_supply: entries.iter().any(|entry| entry.has_supply),
            is_delayed: rows > 2 || entries.iter().any(|entry| entry.is_split),
        })
    }

    /// One sample of every lane: what is recorded, then the voltages applied until the next sample, the new ones and those
    /// that the delay still lets through before them.
    pub fn sample(
        &mut self,
        arch: pulp::Arch,
        command: Command,
        position: &Lane,
        current: &Lane,
        mut each: impl FnMut(usize, Sample),
    ) -> [Lane; 2] {
        let feedforward_v = if command.is_enabled { command.feedforward_v } else { 0.0 };
        let command = Command { feedforward_v, ..command };
        let Sampled { velocity, effort_v, applied_v } = arch.dispatch(Law { front: self, command, position });
        let commanded_v = || effort_v.map(|effort_v| effort_v + command.feedforward_v);
        let mut applied_v = if self.is_delayed { self.delayed(commanded_v()) } else { [applied_v; 2] };
        if self.has_supply {
            self.supplied(&mut applied_v, command.supply_v);
        }
        for k in 0..self.lanes {
            let thrust = command.thrust.unwrap_or(current[k] * self.numbers.force_constant[k]);
            each(
                k,
                Sample {
                    position: position[k],
                    velocity: velocity[k],
                    effort_v: effort_v[k],
                    current: current[k],
                    thrust,
                    load_position: position[k],
                },
            );
        }
        applied_v
    }

    /// Duty cycles become voltages.
    fn supplied(&self, applied_v: &mut [Lane; 2], recorded_v: Option<f64>) {
        let supply_v = recorded_v.map_or(self.numbers.supply_v, |recorded| [recorded; LANES]);
        for lanes in applied_v {
            lanes.iter_mut().zip(&supply_v).for_each(|(applied, supply)| *applied *= supply);
        }
    }

    /// The voltages that the delays let through, the newest of them being `commanded_v`.
    fn delayed(&mut self, commanded_v: Lane) -> [Lane; 2] {
        self.newest = if self.newest == 0 { self.commanded.len() - 1 } else { self.newest - 1 };
        self.commanded[self.newest] = commanded_v;
        let row = |back: usize| (self.newest + back) % self.commanded.len();
        let let_through =
            |more: usize| -> Lane { std::array::from_fn(|k| self.commanded[row(self.back[k] + more)][k]) };
        [amplified(&self.numbers, &let_through(0)), amplified(&self.numbers, &let_through(1))]
    }
}

/// Velocity estimate and control law of one sample.
struct Law<'a> {
    front: &'a mut Front,
    command: Command,
    position: &'a Lane,
}

impl WithSimd for Law<'_> {
    type Output = Sampled;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Sampled {
        let Self { front, command, position } = self;
        // Values of their own, not places in the front: nothing then keeps the loops from being vectors.
        let (n, position, previous) = (front.numbers, *position, front.previous);
        let (mut estimate, mut integral_v, mut effort_v) = (front.estimate, front.integral_v, [0.0; LANES]);
        for k in 0..LANES {
            let difference = (position[k] - previous[k]) * n.rate[k];
            estimate[k] += n.share[k] * (difference - estimate[k]);
        }
        for k in 0..LANES {
            let error = n.position[k] * (command.position_reference - position[k])
                + n.feedforward[k] * command.velocity_reference
                - estimate[k];
            integral_v[k] += n.integral[k] * error;
            effort_v[k] =
                integral_v[k] + n.error[k] * error - n.velocity[k] * estimate[k] + command.disturbance_v;
        }
        if !command.is_enabled {
            // The controller begins anew when the drive is enabled again.
            (integral_v, effort_v) = ([0.0; LANES], [0.0; LANES]);
        }
        (front.previous, front.estimate, front.integral_v) = (position, estimate, integral_v);
        let mut commanded_v = effort_v;
        for voltage in &mut commanded_v {
            *voltage += command.feedforward_v;
        }
        Sampled { velocity: estimate, effort_v, applied_v: amplified(&n, &commanded_v) }
    }
}

/// The amplifier's law, see [`crate::drive::amplifier::Amplifier`].
#[inline(always)]
fn amplified(n: &Numbers, command_v: &Lane) -> Lane {
    let mut applied = [0.0; LANES];
    for k in 0..LANES {
        let dead = command_v[k].max(-n.dead_zone_v[k]).min(n.dead_zone_v[k]);
        let live = command_v[k] - dead + n.offset_v[k];
        applied[k] = live.max(-n.limit_v[k]).min(n.limit_v[k]);
    }
    applied
}
