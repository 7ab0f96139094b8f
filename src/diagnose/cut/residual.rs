//! Residuals of single stretches of the signal path, from measured input to measured output.

use crate::controller::Memory;
use crate::diagnose::experiment::Experiment;
use crate::diagnose::logged_input::LoggedInput;
use crate::drive::amplifier::SplitDelay;
use crate::drive::motor::CircuitStep;
use crate::effect::Constants;
use crate::machine::Machine;
use crate::recording::Signal;

/// Measured thrust less force constant times measured current, in N or N·m; none where one is not logged.
pub fn force_residual(experiment: &Experiment, constants: &Constants) -> Option<Vec<f64>> {
    let run = experiment.run();
    let (current, thrust) = (run.signal(Signal::Current)?, run.signal(Signal::Thrust)?);
    let constant = constants.force_constant() / constants.log_scale.current;
    Some(current.iter().zip(thrust).map(|(i, f)| f - constant * i).collect())
}

/// Samples after which a velocity estimate has forgotten how it began.
pub const FORGETTING: usize = 64;

/// Measured effort less what the controller computes from measured reference and position, in V; none at uneven times.
pub fn controller_residual(experiment: &Experiment, machine: &Machine) -> Option<Vec<f64>> {
    let run = experiment.run();
    if run.instants_s().is_some() {
        return None;
    }
    let (effort, position) = (run.signal(Signal::ControlEffort)?, run.signal(Signal::Position)?);
    let on_load = machine.description().load_sensor.as_ref().is_some_and(|s| s.closes_position_loop);
    let controlled = if on_load { run.signal(Signal::LoadPosition)? } else { position };
    let constants = machine.constants();
    let (controller, period) = (constants.controller.as_ref()?, run.sample_period_s());
    let mut inputs = LoggedInput::of(experiment, machine, &constants);
    let mut memory = None;
    let residual = experiment.recorded().commands().iter().enumerate().filter_map(|(k, command)| {
        let input = inputs.next(command, position[k], controlled[k]);
        // The estimate forgets what stood before the run; the integral part, taken over then, does not.
        if k < FORGETTING {
            return None;
        }
        if !command.is_enabled {
            memory = Some(Memory::default()); // it begins anew when it is enabled
            return Some(0.0);
        }
        let own = effort[k] / constants.log_scale.effort - command.disturbance_v;
        let memory = memory.get_or_insert_with(|| controller.memory_for(own, input, period));
        Some(own - controller.effort_v(memory, input, period))
    });
    Some(residual.collect())
}

/// Measured motor effort less what the drive's model makes of the measured voltage, in N or N·m.
pub fn drive_residual(experiment: &Experiment, constants: &Constants) -> Option<Vec<f64>> {
    let run = experiment.run();
    if run.instants_s().is_some() {
        return None;
    }
    let effort = run.signal(Signal::ControlEffort)?;
    let period = run.sample_period_s();
    let delay = SplitDelay::new(constants.amplifier.delay_s, period);
    let steps =
        [delay.fraction, 1.0 - delay.fraction].map(|f| CircuitStep::new(&constants.circuit, f * period));
    let (kt, winding) = (steps[0].effort_constant(), steps[0].has_current());
    let measured: Vec<f64> = match (run.signal(Signal::Current), run.signal(Signal::Thrust)) {
        (Some(current), _) if winding => {
            current.iter().map(|i| i / constants.log_scale.current * kt).collect()
        }
        (_, Some(thrust)) => thrust.to_vec(),
        _ => return None,
    };
    let position = run.signal(Signal::Position)?;
    let supply = run.signal(Signal::SupplyVoltage);
    let amplifier = &constants.amplifier;
    let as_commanded: Vec<f64> = effort.iter().map(|u| u / constants.log_scale.effort).collect();
    let commanded = experiment.recorded().commanded_v(&as_commanded);
    let applied = |k: usize, back: usize| {
        amplifier.gain_under(supply.map(|supply| supply[k]))
            * amplifier.output_v(commanded[k.saturating_sub(back)])
    };
    let mut current = measured[0] / kt;
    let modelled = (0..effort.len()).map(|k| {
        let velocity = if k == 0 { 0.0 } else { (position[k] - position[k - 1]) / period };
        let voltages = [applied(k, delay.periods + 1), applied(k, delay.periods)];
        let now = if winding { current } else { voltages[usize::from(delay.fraction == 0.0)] };
        if winding {
            for (step, voltage) in steps.iter().zip(voltages).filter(|(step, _)| step.duration_s() > 0.0) {
                step.advance(&mut current, voltage, velocity);
            }
        }
        now * kt
    });
    Some(measured.iter().zip(modelled).map(|(m, p)| m - p).collect())
}
