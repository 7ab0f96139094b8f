//! Every effect of the catalogue: hidden, it is named with its size; where the data do not excite it, it is not named.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use slideway::diagnose::{Diagnosis, Options, diagnose};
use slideway::machine::Machine;
use slideway::recording::{Recording, Role, Run};
use slideway::replay::recording::recorded;
use slideway::replay::{Motion, PlantChoice, Stroke, run_seed, simulate};
use slideway::twin::Sensing;
use std::path::Path;

fn machine() -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap()
}

/// Stroke (m), feed (m/min) and role of each run.
const CELLS: [(f64, f64, Role); 5] = [
    (0.03, 4.0, Role::Training),
    (0.04, 16.0, Role::Training),
    (0.05, 8.0, Role::Training),
    (0.04, 8.0, Role::HeldOut),
    (0.05, 16.0, Role::HeldOut),
];

/// Hidden settings `key=value`, joined by spaces.
fn recording(hidden: &str, seed: u64) -> Recording {
    let stated = machine();
    let settings: Vec<(&str, toml::Value)> = hidden
        .split_whitespace()
        .map(|one| one.split_once('=').unwrap())
        .map(|(key, value)| (key, toml::Value::Float(value.parse().unwrap())))
        .collect();
    let real = stated.with_settings(settings).unwrap();
    let runs: Vec<Run> = CELLS
        .iter()
        .map(|&(stroke, feed, role)| {
            let there = Stroke::metres_at_metres_per_minute(stroke, feed).unwrap();
            let back = Stroke { stroke: -there.stroke, ..there };
            let motion = Motion { strokes: vec![there, back], lead_s: 0.1, dwell_s: 0.3, ramp_s: 0.02 };
            let reference = motion.reference(stated.description().sample_period_s);
            let name = format!("stroke{:.0}_feed{feed:.0}", there.stroke * 1e3);
            let sensing = Sensing::AsStated { seed: run_seed(seed, &name) };
            let traces = simulate(&real, PlantChoice::Axis, sensing, &reference, |_| ()).unwrap();
            let mut run = recorded(&name, &stated, &reference, traces).unwrap();
            run.role = Some(role);
            run
        })
        .collect();
    Recording::new(runs).unwrap()
}

fn report(name: &str, d: &Diagnosis, seconds: f64) {
    let named: Vec<String> = d
        .causes
        .iter()
        .map(|c| {
            let numbers: Vec<String> =
                c.parameters.iter().map(|(k, p)| format!("{k}={:.4}", p.value)).collect();
            format!("{} p={:.3} [{}] ~{:?}", c.effect, c.probability, numbers.join(" "), c.confusable_with)
        })
        .collect();
    println!(
        "== {name}: {:?} G {:.3} -> {:.3} closed {:.3} ({seconds:.1} s, {} hypotheses) {}",
        d.verdict,
        d.gap.before,
        d.gap.after,
        d.gap.closed,
        d.ranking.len(),
        named.join(" + ")
    );
}

#[test]
fn explore() {
    let cases = [
        "",
        "effect.controller_gain.position_factor=1.1 effect.controller_gain.velocity_factor=1 effect.controller_gain.integral_factor=1.2 effect.controller_gain.velocity_feedforward=0.7",
        "effect.loop_delay.delay_s=4e-4",
        "effect.voltage_saturation.limit_v=2",
        "effect.dead_zone.half_width_v=0.05",
        "effect.amplifier_offset.offset_v=0.1",
        "effect.winding_resistance.resistance_ohm=1.6",
        "effect.winding_inductance.inductance_h=0.011",
        "effect.back_emf.back_emf_v_s_per_m=20",
        "effect.force_constant.factor=0.9",
        "effect.force_ripple.period_m=0.024 effect.force_ripple.sine=0.03 effect.force_ripple.cosine=0.01",
        "effect.cogging.period_m=0.012 effect.cogging.sine_n=8 effect.cogging.cosine_n=3 effect.cogging.sine_2_n=2",
        "effect.viscous_friction.viscous_n_s_per_m=500",
        "effect.coulomb_friction.force_n=15",
        "effect.asymmetric_friction.coulomb_positive_n=8 effect.asymmetric_friction.coulomb_negative_n=16 effect.asymmetric_friction.viscous_positive_n_s_per_m=300 effect.asymmetric_friction.viscous_negative_n_s_per_m=420",
        "effect.stribeck_friction.coulomb_n=10 effect.stribeck_friction.stiction_n=16 effect.stribeck_friction.stribeck_velocity_m_per_s=0.01",
        "effect.presliding.force_n=15 effect.presliding.stiffness_n_per_m=5e5",
        "effect.load_dependent_friction.coefficient=0.03",
        "effect.constant_force.force_n=-12",
        "effect.cable_spring.stiffness_n_per_m=400 effect.cable_spring.centre_m=0.02",
        "effect.payload.mass_kg=6",
        "effect.base_mode_shift.mode=1 effect.base_mode_shift.frequency_factor=0.6 effect.base_mode_shift.mass_factor=1",
        "effect.flexible_mode.frequency_hz=45 effect.flexible_mode.mass_kg=600 effect.flexible_mode.damping_ratio=0.03",
        "effect.backlash.width_m=2e-5",
        "effect.screw_error.period_m=0.01 effect.screw_error.sine_m=5e-6 effect.screw_error.cosine_m=2e-6",
        "effect.encoder_scale.factor=1.08",
        "effect.encoder_periodic_error.period_m=0.004 effect.encoder_periodic_error.sine_m=2e-6 effect.encoder_periodic_error.cosine_m=1e-6",
        "effect.encoder_resolution.resolution_m=5e-6",
        "effect.velocity_filter.time_constant_s=2e-3",
    ];
    let only = std::env::var("ONLY").unwrap_or_default();
    for (seed, case) in cases.iter().enumerate().filter(|(_, c)| c.contains(&only)) {
        let recording = recording(case, seed as u64);
        let started = std::time::Instant::now();
        let struck = std::env::var_os("STRUCK").is_some();
        let catalogue: Vec<_> = slideway::effect::EffectId::ALL
            .iter()
            .copied()
            .filter(|e| !(struck && case.contains(&format!("effect.{}.", e.name()))))
            .collect();
        let options = Options { catalogue: &catalogue, ..Options::default() };
        let d = diagnose(&machine(), &recording, &options).unwrap();
        report(case, &d, started.elapsed().as_secs_f64());
        for r in d.ranking.iter().take(std::env::var("TOP").map_or(3, |t| t.parse().unwrap())) {
            println!("      {:?} p={:.4} G={:.3}", r.effects, r.probability, r.held_out_gap);
        }
    }
}
