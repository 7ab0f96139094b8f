//! Several twins in one pass are, each to the last bit, what they are one by one.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use slideway::machine::Machine;
use slideway::plant::axis::{Axis, LANES};
use slideway::replay::{Stroke, Traces, follow, run, run_together};
use slideway::twin::{Batch, Command, Driven, Sensing, Twin};
use std::path::Path;

fn machine(name: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name)).unwrap()
}

fn with(machine: &Machine, settings: &[(&'static str, f64)]) -> Machine {
    machine.with_settings(settings.iter().map(|(key, v)| (*key, toml::Value::Float(*v)))).unwrap()
}

fn twin(machine: &Machine) -> Twin<Axis> {
    Twin::new(machine, Axis::of(&machine.constants()), Sensing::Perfect)
}

/// There and back with a dwell: slides, stops, sticks, breaks away, reverses.
fn commands(machine: &Machine, stroke: f64, feed: f64) -> Vec<Command> {
    let there = Stroke::new(stroke, feed).unwrap();
    let strokes = vec![there, Stroke { stroke: -stroke, ..there }];
    let motion = slideway::replay::Motion { strokes, lead_s: 0.02, dwell_s: 0.3, ramp_s: 0.02 };
    let period = machine.description().sample_period_s;
    follow(&motion.reference(period), period).collect()
}

pub(super) fn assert_same(machines: &[Machine], driven: Driven, commands: &[Command], what: &str) {
    let mut together: Vec<Traces> = machines.iter().map(|_| Traces::default()).collect();
    run_together(
        machines.iter().map(twin).collect(),
        driven,
        commands.len(),
        |_, k| commands[k],
        |_| None,
        |lane, _, sample| together[lane].push(sample),
    );
    for (k, (machine, traces)) in machines.iter().zip(&together).enumerate() {
        let alone = run(&mut twin(machine), commands.iter().copied(), |_| ());
        assert!(alone.position.iter().any(|x| *x != 0.0), "{what}: nothing moves");
        assert_eq!(traces.position, alone.position, "{what}, twin {k}");
        assert_eq!(traces.velocity, alone.velocity, "{what}, twin {k}");
        assert_eq!(traces.effort_v, alone.effort_v, "{what}, twin {k}");
        assert_eq!(traces.current, alone.current, "{what}, twin {k}");
        assert_eq!(traces.thrust, alone.thrust, "{what}, twin {k}");
    }
}

/// Parameter sets around one machine, as a fit's sensitivities ask for them.
fn around(stated: &Machine) -> Vec<Machine> {
    let one = |key: &'static str, value: f64| with(stated, &[(key, value)]);
    vec![
        stated.clone(),
        one("effect.payload.mass_kg", 0.01),
        one("guide.viscous_n_s_per_m", 340.0),
        one("effect.force_constant.factor", 1.01),
        one("effect.loop_delay.delay_s", 1.2e-4),
        one("effect.loop_delay.delay_s", 6.0e-4),
        one("effect.back_emf.back_emf_v_s_per_m", 20.0),
        one("effect.voltage_saturation.limit_v", 3.0),
        one("effect.dead_zone.half_width_v", 0.05),
        one("effect.amplifier_offset.offset_v", 0.1),
    ]
}

#[test]
fn exact_a_batch_is_its_twins_one_by_one() {
    let stated = machine("grinder");
    let commands = commands(&stated, 0.03, 0.2667);
    assert_same(&around(&stated), Driven::ByControllers, &commands, "linear");
    let coulomb = with(&stated, &[("effect.coulomb_friction.force_n", 15.0)]);
    assert_same(&around(&coulomb), Driven::ByControllers, &commands, "Coulomb");
    let laws: [&[(&str, f64)]; 4] = [
        &[
            ("effect.cogging.period_m", 0.02),
            ("effect.cogging.sine_n", 5.0),
            ("effect.cogging.cosine_n", 2.0),
        ],
        &[
            ("effect.coulomb_friction.force_n", 12.0),
            ("effect.presliding.stiffness_n_per_m", 2e6),
            ("effect.presliding.damping_n_s_per_m", 600.0),
        ],
        &[
            ("effect.coulomb_friction.force_n", 10.0),
            ("effect.stribeck_friction.peak_ratio", 1.8),
            ("effect.stribeck_friction.stribeck_velocity_m_per_s", 4e-3),
        ],
        &[("effect.encoder_scale.factor", 1.001)],
    ];
    for law in laws {
        assert_same(&around(&with(&stated, law)), Driven::ByControllers, &commands, law[0].0);
    }
}

#[test]
fn exact_a_batch_driven_by_effort_or_force_is_its_twins() {
    let stated = with(&machine("grinder"), &[("effect.coulomb_friction.force_n", 15.0)]);
    let wave = |k: usize| (k as f64 * 0.01).sin();
    let command = |k| Command { effort_v: Some(2.0 * wave(k)), ..Command::follow(0.0, 0.0) };
    let efforts: Vec<Command> = (0..4000).map(command).collect();
    assert_same(&around(&stated), Driven::ByEffort, &efforts, "effort");
    let force = |k| Command { thrust: Some(60.0 * wave(k)), ..command(k) };
    let forces: Vec<Command> = (0..4000).map(force).collect();
    assert_same(&around(&stated), Driven::ByForce, &forces, "force");
}

/// The bridge opens twice while the axis moves; it coasts, and the controllers begin anew.
#[test]
fn exact_a_batch_whose_bridge_opens_is_its_twins() {
    let stated = machine("grinder");
    let mut opened = commands(&stated, 0.03, 0.2667);
    for (k, command) in opened.iter_mut().enumerate() {
        command.is_enabled = !(150..190).contains(&k) && !(300..420).contains(&k);
        command.feedforward_v = 0.3;
    }
    let bristles = [
        ("effect.coulomb_friction.force_n", 12.0),
        ("effect.presliding.stiffness_n_per_m", 2e6),
        ("effect.presliding.damping_n_s_per_m", 600.0),
    ];
    for law in [&[][..], &bristles[..1], &bristles] {
        let machines = around(&with(&stated, law));
        let what = format!("open bridge, {} numbers of friction", law.len());
        assert_same(&machines, Driven::ByControllers, &opened, &what);
        let wave = |k: usize| Some(2.0 * (k as f64 * 0.01).sin());
        let efforts: Vec<Command> =
            opened.iter().enumerate().map(|(k, c)| Command { effort_v: wave(k), ..*c }).collect();
        assert_same(&machines, Driven::ByEffort, &efforts, &what);
    }
    let direct = machine("emps");
    let machines = [150.0, 200.0, 250.0].map(|c| with(&direct, &[("guide.viscous_n_s_per_m", c)]));
    let mut opened = commands(&direct, 0.1, 0.1);
    opened[200..700].iter_mut().for_each(|command| command.is_enabled = false);
    assert_same(&machines, Driven::ByControllers, &opened, "open bridge of a direct motor");
}

/// A direct motor, four steps a period, velocity by taps.
#[test]
fn exact_a_batch_of_another_machine_is_its_twins() {
    let stated = machine("emps");
    let machines: Vec<Machine> =
        [150.0, 200.0, 250.0].map(|c| with(&stated, &[("guide.viscous_n_s_per_m", c)])).to_vec();
    assert_same(&machines, Driven::ByControllers, &commands(&stated, 0.1, 0.1), "direct motor");
}

/// Weight that turns with the axis, with friction of every kind that has no bristles, in proportion to load among them: what slides on and what stays stuck is found for all
/// of them together, and the rest one by one.
#[test]
fn exact_a_batch_of_pendulums_is_its_twins() {
    let coulomb = ("effect.coulomb_friction.torque_nm", 0.01);
    let asymmetric = [coulomb, ("effect.asymmetric_friction.coulomb_asymmetry", 0.3)];
    let stribeck = [
        coulomb,
        ("effect.load_dependent_friction.coefficient", 0.3),
        ("effect.stribeck_friction.peak_ratio", 1.6),
        ("effect.stribeck_friction.stribeck_velocity_rad_per_s", 0.05),
    ];
    let stated = machine("xl330");
    let commands = commands(&stated, 1.0, 3.0);
    for law in [&[][..], &[coulomb], &asymmetric, &stribeck] {
        let base = with(&stated, law);
        let one = |key: &'static str, value: f64| with(&base, &[(key, value)]);
        let machines = [
            base.clone(),
            one("guide.viscous_nm_s_per_rad", 2e-3),
            one("effect.payload.inertia_kg_m2", 1e-3),
            one("effect.force_constant.factor", 1.1),
            one("effect.position_gain.factor", 1.5),
            one("effect.encoder_zero.zero_rad", 0.05),
        ];
        let what = law.last().map_or("no friction", |(key, _)| *key);
        assert_same(&machines, Driven::ByControllers, &commands, what);
        let machines = &machines[..5];
        let wave = |k: usize| 0.8 * (k as f64 * 0.004).sin();
        let effort = |(k, command): (usize, &Command)| Command { effort_v: Some(wave(k)), ..*command };
        let efforts: Vec<Command> = commands.iter().enumerate().map(effort).collect();
        assert_same(machines, Driven::ByEffort, &efforts, what);
    }
}

/// A Stribeck curve with friction of a place and friction that drifts, under control, under force, and with an open bridge; waves of which some have more than others.
#[test]
fn exact_a_batch_with_laws_in_lanes_is_its_twins() {
    let stated = machine("grinder");
    let law = [
        ("effect.coulomb_friction.force_n", 12.0),
        ("effect.stribeck_friction.peak_ratio", 1.6),
        ("effect.stribeck_friction.stribeck_velocity_m_per_s", 4e-3),
        ("effect.local_friction.force_n", 8.0),
        ("effect.local_friction.centre_m", 0.012),
        ("effect.local_friction.width_m", 0.01),
        ("effect.friction_drift.rate_per_s", 0.05),
        ("effect.asymmetric_friction.viscous_asymmetry", 0.2),
    ];
    let commands = commands(&stated, 0.03, 0.2667);
    let mut opened = commands.clone();
    opened[150..190].iter_mut().for_each(|command| command.is_enabled = false);
    let force = |k: usize| Command {
        effort_v: Some(0.0),
        thrust: Some(60.0 * (k as f64 * 0.01).sin()),
        ..Command::follow(0.0, 0.0)
    };
    let forces: Vec<Command> = (0..3000).map(force).collect();
    for laws in [3, 6, 7, 8] {
        let machines = around(&with(&stated, &law[..laws]));
        assert_same(&machines, Driven::ByControllers, &commands, law[laws - 1].0);
        assert_same(&machines, Driven::ByControllers, &opened, law[laws - 1].0);
        assert_same(&machines, Driven::ByForce, &forces, law[laws - 1].0);
    }
    let cogging = [
        ("effect.cogging.period_m", 0.02),
        ("effect.cogging.sine_n", 5.0),
        ("effect.cogging.cosine_n", 2.0),
        ("effect.cogging.sine_3", 0.05),
        ("effect.second_cogging.period_m", 0.013),
        ("effect.second_cogging.sine_n", 1.0),
        ("effect.second_cogging.cosine_n", -3.0),
    ];
    let mut machines: Vec<Machine> = around(&with(&stated, &cogging[..4])).into_iter().take(4).collect();
    machines.push(with(&stated, &cogging));
    machines.push(with(&stated, &cogging[..3]));
    assert_same(&machines, Driven::ByControllers, &commands, "two pitches beside one");
}

/// Twins of different structure come back and are walked one by one.
#[test]
fn exact_twins_that_do_not_fit_into_one_pass_come_back() {
    let stated = machine("grinder");
    let mode = [
        ("effect.flexible_mode.frequency_hz", 40.0),
        ("effect.flexible_mode.mass_kg", 300.0),
        ("effect.flexible_mode.damping_ratio", 0.03),
    ];
    let machines = [stated.clone(), with(&stated, &mode)];
    let back = Batch::of(machines.iter().map(twin).collect(), Driven::ByControllers).unwrap_err();
    assert_eq!(back.len(), 2);
    assert_same(&machines, Driven::ByControllers, &commands(&stated, 0.02, 0.1333), "two structures");
    let many: Vec<_> = (0..=LANES).map(|_| twin(&stated)).collect();
    assert_eq!(Batch::of(many, Driven::ByControllers).unwrap_err().len(), LANES + 1);
    assert!(Batch::of(Vec::new(), Driven::ByControllers).is_err());
}
