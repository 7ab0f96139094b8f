//! The signal path cut at every logged signal: which stretch of it disagrees with the twin.

use super::experiment::Experiment;
use super::logged_input::LoggedInput;
use super::motion::Motion;
use super::noise::Floor;
use super::place::Share;
use super::thresholds::ADEQUATE_GAP;
use crate::drive::amplifier::SplitDelay;
use crate::drive::motor::{Circuit, CircuitStep};
use crate::effect::Constants;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::sensor::End;
use crate::twin::load_positions;
use rayon::prelude::*;

/// Shares of the gap by stretch of the signal path, in hardware order.
///
/// # Model
/// The path is cut at every logged signal; where one is missing, its two stretches merge, and a name lists all sites of
/// a stretch. Each is replayed alone from its measured input to its measured output: the controller from reference and
/// position to effort, the drive from effort to current or force, the mechanics from force to motion (inverse
/// dynamics while the axis moves: at standstill friction takes any value), the drive train from the motor's to the
/// load's sensor. The mean square of each residual is divided by what noise leaves of it, and a share is that of the
/// excess over 1. Noise: the same residual of a run that the second machine's twin would have logged with noise as
/// stated, at least the floor of the output's signal.
///
/// # Errors
/// Whatever a replay refuses.
pub fn segments(machines: [&Machine; 2], experiments: &[Experiment], floor: &Floor) -> Result<Vec<Share>> {
    let gathered: Result<Vec<Vec<(Stretch, f64)>>> = experiments
        .par_iter()
        .enumerate()
        .map(|(seed, experiment)| {
            let measured = stretches(experiment, machines[0])?;
            let imagined = stretches(&experiment.imagined(machines[1], seed as u64)?, machines[1])?;
            let noise = |stretch: &Stretch| {
                let own = imagined
                    .iter()
                    .find(|other| other.name == stretch.name)
                    .map_or(0.0, Stretch::mean_square);
                let logged = stretch.output.filter(|signal| experiment.signals().contains(signal));
                own.max(logged.map_or(0.0, |signal| floor.sigma(signal).powi(2)))
            };
            Ok(measured.into_iter().map(|stretch| (noise(&stretch), stretch)).map(|(n, s)| (s, n)).collect())
        })
        .collect();
    let mut sums: Vec<(String, f64, f64)> = Vec::new();
    for (stretch, noise) in gathered?.into_iter().flatten() {
        let weight = experiments.len() as f64;
        let (own, noise) = (stretch.mean_square() / weight, noise / weight);
        match sums.iter_mut().find(|(name, ..)| *name == stretch.name) {
            Some(sum) => (sum.1, sum.2) = (sum.1 + own, sum.2 + noise),
            None => sums.push((stretch.name, own, noise)),
        }
    }
    Ok(shares(&sums))
}

/// Shares of the excess over noise; a stretch that stands alone has everything.
fn shares(sums: &[(String, f64, f64)]) -> Vec<Share> {
    let excess = |&(_, own, noise): &(String, f64, f64)| {
        let level = own / noise.max(f64::MIN_POSITIVE);
        if own > 0.0 && level.sqrt() > ADEQUATE_GAP { (level - 1.0).min(LARGEST) } else { 0.0 }
    };
    let total: f64 = sums.iter().map(excess).sum();
    let share = |sum| match sums.len() {
        1 => 1.0,
        _ if total > 0.0 => excess(sum) / total,
        _ => 0.0,
    };
    sums.iter().map(|sum| Share { name: sum.0.clone(), share: share(sum) }).collect()
}

/// Excess of a stretch whose noise is nil.
const LARGEST: f64 = 1e12;

/// A stretch of the path between two logged signals, with its residual in the output's unit.
struct Stretch {
    name: String,
    residual: Vec<f64>,
    output: Option<Signal>,
}

impl Stretch {
    fn new(name: impl Into<String>, residual: Vec<f64>, output: Option<Signal>) -> Self {
        Self { name: name.into(), residual, output }
    }

    fn mean_square(&self) -> f64 {
        self.residual.iter().map(|x| x * x).sum::<f64>() / self.residual.len().max(1) as f64
    }
}

/// What was logged between controller and guide.
struct Cuts<'a> {
    effort: Option<&'a [f64]>,
    current: Option<&'a [f64]>,
    thrust: Option<&'a [f64]>,
    position: &'a [f64],
    load: Option<&'a [f64]>,
}

impl<'a> Cuts<'a> {
    fn of(experiment: &'a Experiment, constants: &Constants) -> Result<Self> {
        let run = experiment.run();
        let winding = matches!(constants.circuit, Circuit::Winding { .. });
        let has_load = experiment.signals().contains(&Signal::LoadPosition);
        Ok(Self {
            effort: run.signal(Signal::ControlEffort),
            current: run.signal(Signal::Current).filter(|_| winding),
            thrust: run.signal(Signal::Thrust),
            position: run.require(Signal::Position)?,
            load: run.signal(Signal::LoadPosition).filter(|_| has_load),
        })
    }

    /// The motor's current or force, whichever comes first on the path.
    fn force(&self) -> Option<(Signal, &'a [f64])> {
        let current = self.current.map(|samples| (Signal::Current, samples));
        current.or_else(|| self.thrust.map(|samples| (Signal::Thrust, samples)))
    }
}

fn stretches(experiment: &Experiment, machine: &Machine) -> Result<Vec<Stretch>> {
    let machine = experiment.machine(machine)?;
    let constants = machine.constants();
    let cuts = Cuts::of(experiment, &constants)?;
    let mut list = Vec::new();
    // Between uneven time stamps neither controller nor drive is known: their stretches merge with the mechanics.
    let is_even = experiment.run().instants_s().is_none();
    let commanded = if experiment.input().is_none() && is_even {
        controller_effort(experiment, &machine, &cuts)
    } else {
        None
    };
    match (&commanded, cuts.effort, cuts.force()) {
        (Some(own), Some(effort), _) => {
            list.push(Stretch::new("controller", difference(effort, own), Some(Signal::ControlEffort)));
        }
        (Some(own), None, Some((signal, measured))) => {
            let modelled = drive(experiment, &constants, own, signal);
            list.push(Stretch::new(
                "controller+amplifier+motor",
                difference(measured, &modelled),
                Some(signal),
            ));
        }
        _ => {}
    }
    if let (Some(effort), Some((signal, measured)), true) = (cuts.effort, cuts.force(), is_even) {
        let modelled = drive(experiment, &constants, effort, signal);
        list.push(Stretch::new("amplifier+motor", difference(measured, &modelled), Some(signal)));
    }
    if let (Some(current), Some(thrust), Circuit::Winding { force_constant, .. }) =
        (cuts.current, cuts.thrust, &constants.circuit)
    {
        let needed: Vec<f64> = thrust.iter().map(|f| f / force_constant).collect();
        list.push(Stretch::new("motor", difference(current, &needed), Some(Signal::Current)));
    }
    let in_loop = commanded.is_some() || (!is_even && experiment.input().is_none());
    list.push(mechanics(experiment, &machine, &cuts, in_loop)?);
    if let Some(load) = cuts.load {
        list.push(drive_train(&machine, cuts.position, load));
    }
    Ok(list)
}

fn difference(measured: &[f64], modelled: &[f64]) -> Vec<f64> {
    measured.iter().zip(modelled).map(|(m, p)| m - p).collect()
}

/// Force that the moving part lacks, while it moves; where no signal tells the motor's force, the whole path is one
/// stretch and has no residual of its own.
fn mechanics(experiment: &Experiment, machine: &Machine, cuts: &Cuts, in_loop: bool) -> Result<Stretch> {
    let before = match (cuts.effort, cuts.current, cuts.thrust) {
        (_, _, Some(_)) => "",
        (_, Some(_), None) => "motor+",
        (Some(_), None, None) => "amplifier+motor+",
        (None, None, None) if in_loop => "controller+amplifier+motor+",
        (None, None, None) => "amplifier+motor+",
    };
    let behind = if cuts.load.is_some() { "guide+structure" } else { "guide+structure+sensor" };
    let motion = Motion::of(experiment, machine)?;
    let fastest = motion.velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let pairs = motion.missing_force.iter().zip(&motion.velocity);
    let moving = pairs.filter(|(_, v)| v.abs() > STILL_SHARE * fastest).map(|(force, _)| *force);
    Ok(Stretch::new(format!("{before}{behind}"), moving.collect(), None))
}

/// Below this share of the largest speed the axis counts as standing still.
const STILL_SHARE: f64 = 0.02;

/// Reading of the load's sensor less what the twin's drive train makes of the encoder's; its zero is its own.
fn drive_train(machine: &Machine, position: &[f64], load: &[f64]) -> Stretch {
    let is_motor = machine.description().encoder.end == End::Motor;
    let modelled = if is_motor { load_positions(machine, position) } else { position.to_vec() };
    let residual = difference(load, &modelled);
    let zero = residual.iter().sum::<f64>() / residual.len().max(1) as f64;
    let name = if is_motor { "structure+sensor" } else { "sensor" };
    Stretch::new(name, residual.iter().map(|r| r - zero).collect(), Some(Signal::LoadPosition))
}

/// What the controller computes from measured reference and position, injected disturbance included, in V; none for a
/// machine whose controller is not stated.
fn controller_effort(experiment: &Experiment, machine: &Machine, cuts: &Cuts) -> Option<Vec<f64>> {
    let (recorded, constants) = (experiment.recorded(), machine.constants());
    let controller = constants.controller.as_ref()?;
    let (period, start) = (experiment.run().sample_period_s(), recorded.start());
    let on_load = machine.description().load_sensor.as_ref().is_some_and(|s| s.closes_position_loop);
    let seen = if on_load { cuts.load? } else { cuts.position };
    let first = match (cuts.effort, cuts.force()) {
        (Some(effort), _) => effort[0],
        (None, Some((Signal::Thrust, thrust))) => {
            thrust[0] / constants.force_per_volt() - start.feedforward_v
        }
        (None, Some((_, current))) => {
            current[0] * current_force(&constants) / constants.force_per_volt() - start.feedforward_v
        }
        (None, None) => 0.0,
    };
    let mut inputs = LoggedInput::of(experiment, machine, &constants);
    let mut memory = None;
    let effort = recorded.commands().iter().enumerate().map(|(k, command)| {
        let input = inputs.next(command, cuts.position[k], seen[k]);
        let memory =
            memory.get_or_insert_with(|| controller.memory_for(first - command.disturbance_v, input, period));
        command.disturbance_v + controller.effort_v(memory, input, period)
    });
    Some(effort.collect())
}

/// N/A or N·m/A of the winding, N/V or N·m/V without one.
fn current_force(constants: &Constants) -> f64 {
    match constants.circuit {
        Circuit::Winding { force_constant, .. } => force_constant,
        Circuit::Direct { force_per_volt } => force_per_volt,
    }
}

/// What the drive's model makes of a commanded voltage: current in A, or force in N or N·m.
fn drive(experiment: &Experiment, constants: &Constants, effort: &[f64], output: Signal) -> Vec<f64> {
    let run = experiment.run();
    let period = run.sample_period_s();
    let delay = SplitDelay::new(constants.amplifier.delay_s, period);
    let steps =
        [delay.fraction, 1.0 - delay.fraction].map(|f| CircuitStep::new(&constants.circuit, f * period));
    let unit = if output == Signal::Current { 1.0 } else { current_force(constants) };
    let winding = steps[0].has_current();
    let position = run.signal(Signal::Position).unwrap_or_default();
    let supply = run.signal(Signal::SupplyVoltage);
    let amplifier = &constants.amplifier;
    let commanded = experiment.recorded().commanded_v(effort);
    let applied = |k: usize, back: usize| {
        amplifier.gain_under(supply.map(|supply| supply[k]))
            * amplifier.output_v(commanded[k.saturating_sub(back)])
    };
    let mut current = run.signal(output).map_or(0.0, |measured| measured[0] / unit);
    (0..effort.len())
        .map(|k| {
            let velocity = if k == 0 { 0.0 } else { (position[k] - position[k - 1]) / period };
            let voltages = [applied(k, delay.periods + 1), applied(k, delay.periods)];
            let now = if winding { current } else { voltages[usize::from(delay.fraction == 0.0)] };
            if winding {
                for (step, voltage) in steps.iter().zip(voltages).filter(|(step, _)| step.duration_s() > 0.0)
                {
                    step.advance(&mut current, voltage, velocity);
                }
            }
            now * unit
        })
        .collect()
}
