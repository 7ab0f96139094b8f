//! The axis plant against the rigid-body scene, and both against the published behaviour.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::Strokes;
use slideway::machine::Machine;
use slideway::plant::axis::{Axis, LONGEST_STEP_S};
use slideway::plant::rapier::Rig;
use slideway::recording::Role;
use slideway::replay::{Motion, Recorded, Stroke, Traces, follow, run};
use slideway::twin::{Sensing, Twin};
use std::path::Path;

/// The eight cells of the paper: six of its Table 1, then the two of Figs. 6 and 7 (m, m/min).
const CELLS: [(f64, f64); 8] = [
    (0.02, 4.0),
    (0.03, 4.0),
    (0.03, 8.0),
    (0.04, 8.0),
    (0.04, 16.0),
    (0.05, 16.0),
    (0.02, 8.0),
    (0.03, 16.0),
];
/// What the plants may differ by: a hundredth of the encoder's noise.
const PARITY_M: f64 = 0.3e-9;

fn grinder() -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap()
}

fn reference(machine: &Machine, (stroke, feed): (f64, f64)) -> Vec<f64> {
    let motion = Motion {
        strokes: vec![Stroke::metres_at_metres_per_minute(stroke, feed).unwrap()],
        lead_s: 0.02,
        dwell_s: 0.6,
        ramp_s: machine.description().reference.acceleration_time_s,
    };
    motion.reference(machine.description().sample_period_s)
}

fn on_axis(machine: &Machine, reference: &[f64]) -> Traces {
    let mut twin = Twin::new(machine, Axis::of(&machine.constants()), Sensing::Perfect);
    let period = twin.period_s();
    run(&mut twin, follow(reference, period), |_| ())
}

fn on_rapier(machine: &Machine, reference: &[f64]) -> Traces {
    let mut twin = Twin::new(machine, Rig::new(machine).unwrap(), Sensing::Perfect);
    let period = twin.period_s();
    run(&mut twin, follow(reference, period), |_| ())
}

fn rms_difference(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>() / a.len() as f64).sqrt()
}

fn assert_parity(machine: &Machine, cells: &[(f64, f64)]) {
    for &cell in cells {
        let reference = reference(machine, cell);
        let (axis, rapier) = (on_axis(machine, &reference), on_rapier(machine, &reference));
        let position = rms_difference(&axis.position, &rapier.position);
        let velocity = rms_difference(&axis.velocity, &rapier.velocity);
        let thrust = rms_difference(&axis.thrust, &rapier.thrust);
        println!("{cell:?}: position {position:.2e} m, velocity {velocity:.2e} m/s, thrust {thrust:.2e} N");
        assert!(position <= PARITY_M, "{cell:?}: {position:e} m");
    }
}

#[test]
fn ref_axis_and_rigid_body_scene_agree_on_all_cells() {
    assert_parity(&grinder(), &CELLS);
}

#[test]
fn ref_axis_and_rigid_body_scene_agree_with_friction() {
    let machine = grinder();
    let settings = [("effect.coulomb_friction.force_n", toml::Value::Float(15.0))];
    assert_parity(&machine.with_settings(settings).unwrap(), &CELLS);
    let asymmetric = [
        ("effect.coulomb_friction.force_n", toml::Value::Float(11.0)),
        ("effect.viscous_friction.viscous_n_s_per_m", toml::Value::Float(360.0)),
        ("effect.asymmetric_friction.coulomb_asymmetry", toml::Value::Float(-3.0 / 11.0)),
        ("effect.asymmetric_friction.viscous_asymmetry", toml::Value::Float(-1.0 / 6.0)),
        ("effect.payload.mass_kg", toml::Value::Float(9.0)),
        ("effect.constant_force.force_n", toml::Value::Float(5.0)),
        ("effect.loop_delay.delay_s", toml::Value::Float(400e-6)),
    ];
    assert_parity(&machine.with_settings(asymmetric).unwrap(), &CELLS[4..]);
}

/// The scene takes the motor's force at the end of a step with friction and ripple in the velocity, the axis without: both follow the current within a step, so that ripple adds no more
/// than the 0.1 nm of other laws to what strong back-EMF makes between them.
#[test]
fn ref_axis_and_rigid_body_scene_agree_with_ripple_beside_back_emf() {
    let push = [
        ("effect.back_emf.back_emf_v_s_per_m", 200.0),
        ("effect.coulomb_friction.force_n", 40.0),
        ("effect.constant_force.force_n", 60.0),
    ];
    let ripple = [
        ("effect.force_ripple.period_m", 0.02),
        ("effect.force_ripple.sine", 0.05),
        ("effect.force_ripple.cosine", 0.03),
    ];
    let apart = |settings: &[(&'static str, f64)]| {
        let machine = with(&grinder(), settings);
        let reference = reference(&machine, CELLS[4]);
        let (axis, rapier) = (on_axis(&machine, &reference), on_rapier(&machine, &reference));
        rms_difference(&axis.position, &rapier.position)
    };
    let [alone, both] = [apart(&push), apart(&[&push[..], &ripple].concat())];
    println!("back-EMF alone {alone:.2e} m, with ripple {both:.2e} m");
    assert!((both - alone).abs() < OTHER_LAWS_M, "{alone:e} m, with ripple {both:e} m");
}

/// Position overshoot, peak velocity over the feed and most negative velocity, in % of stroke and feed.
fn overshoots(machine: &Machine, cell: (f64, f64)) -> [f64; 3] {
    let traces = on_axis(machine, &reference(machine, cell));
    let feed = cell.1 / 60.0;
    let most = |values: &[f64]| values.iter().copied().fold(f64::MIN, f64::max);
    let least = |values: &[f64]| values.iter().copied().fold(f64::MAX, f64::min);
    [
        100.0 * (most(&traces.position) / cell.0 - 1.0).max(0.0),
        100.0 * (most(&traces.velocity) / feed - 1.0),
        100.0 * least(&traces.velocity) / feed,
    ]
}

/// One row of the physics sheet's table: cell, then overshoots with 19/260 and with 22/220.
type Row = ((f64, f64), [f64; 3], [f64; 3]);
const SHEET: [Row; 3] = [
    ((0.02, 8.0), [4.09, 0.76, -3.15], [0.0, -0.8, 0.0]),
    ((0.03, 16.0), [4.36, -7.1, -2.52], [0.0, -2.8, 0.0]),
    ((0.05, 16.0), [3.79, 3.98, -3.65], [0.0, -0.2, 0.0]),
];
/// Half a digit of the sheet's one-decimal figures, plus the base modes' stated 0.02.
const SHEET_TOLERANCE: f64 = 0.07;

#[test]
fn ref_published_overshoots_and_their_cure() {
    let stated = grinder();
    let retuned = stated
        .with_settings([
            ("controller.integral", toml::Value::Integer(22)),
            ("controller.proportional", toml::Value::Integer(220)),
        ])
        .unwrap();
    for (cell, before, after) in SHEET {
        for (machine, expected) in [(&stated, before), (&retuned, after)] {
            let found = overshoots(machine, cell);
            for (e, f) in expected.iter().zip(found) {
                assert!((e - f).abs() < SHEET_TOLERANCE, "{cell:?}: expected {expected:?}, found {found:?}");
            }
        }
    }
}

/// The same on the axis with a step of its own, a share of the sample period.
fn on_finer_axis(machine: &Machine, reference: &[f64], division: u32) -> Traces {
    let constants = machine.constants();
    let axis = Axis::new(&constants, constants.sample_period_s / f64::from(division));
    let mut twin = Twin::new(machine, axis, Sensing::Perfect);
    let period = twin.period_s();
    run(&mut twin, follow(reference, period), |_| ())
}

fn with(machine: &Machine, settings: &[(&'static str, f64)]) -> Machine {
    machine.with_settings(settings.iter().map(|(key, v)| (*key, toml::Value::Float(*v)))).unwrap()
}

/// The linear axis is exact at any step: a step 64 times finer changes rounding only.
#[test]
fn exact_linear_axis_does_not_depend_on_the_step() {
    let linear: [&[(&str, f64)]; 4] = [
        &[],
        &[("effect.back_emf.back_emf_v_s_per_m", 50.0)],
        &[("effect.loop_delay.delay_s", 3.3e-4)],
        &[("effect.constant_force.force_n", 5.0), ("effect.payload.mass_kg", 9.0)],
    ];
    for settings in linear {
        let machine = with(&grinder(), settings);
        let reference = reference(&machine, (0.03, 16.0));
        let [coarse, fine] = [1, 64].map(|division| on_finer_axis(&machine, &reference, division));
        let error = rms_difference(&coarse.position, &fine.position);
        assert!(error < 1e-13, "{settings:?}: {error:e} m");
    }
}

/// With laws that are not linear, the error at the diagnosing step stays below σ/√N: 42 nm of noise, 40 000 samples.
#[test]
fn exact_axis_converges_below_what_a_diagnosis_sees() {
    const SEEN_M: f64 = 42e-9 / 200.0;
    let laws: [&[(&str, f64)]; 5] = [
        &[("effect.coulomb_friction.force_n", 15.0)],
        &[
            ("effect.coulomb_friction.force_n", 10.0),
            ("effect.stribeck_friction.peak_ratio", 1.8),
            ("effect.stribeck_friction.stribeck_velocity_m_per_s", 4e-3),
        ],
        &[
            ("effect.coulomb_friction.force_n", 11.0),
            ("effect.viscous_friction.viscous_n_s_per_m", 360.0),
            ("effect.asymmetric_friction.coulomb_asymmetry", -3.0 / 11.0),
            ("effect.asymmetric_friction.viscous_asymmetry", -1.0 / 6.0),
        ],
        &[
            ("effect.cogging.period_m", 0.02),
            ("effect.cogging.sine_n", 5.0),
            ("effect.cogging.cosine_n", 2.0),
        ],
        &[
            ("effect.force_ripple.period_m", 0.02),
            ("effect.force_ripple.sine", 0.05),
            ("effect.force_ripple.cosine", 0.0),
        ],
    ];
    for settings in laws {
        let machine = with(&grinder(), settings);
        for cell in [CELLS[0], CELLS[7]] {
            let reference = reference(&machine, cell);
            let [coarse, fine] = [1, 64].map(|division| on_finer_axis(&machine, &reference, division));
            let error = rms_difference(&coarse.position, &fine.position);
            println!("{} {cell:?}: {error:.1e} m", settings[0].0);
            assert!(error < SEEN_M, "{settings:?} {cell:?}: {error:e} m");
        }
    }
}

/// What README states for the step error of the axis with laws that are not linear, presliding aside.
const OTHER_LAWS_M: f64 = 0.1e-9;

/// Back-EMF bends the current within a step, and the guide's force changes what it takes: the ripple of the force follows both.
#[test]
fn exact_ripple_beside_back_emf_converges_below_what_a_diagnosis_sees() {
    let ripple = [
        ("effect.force_ripple.period_m", 0.02),
        ("effect.force_ripple.sine", 0.05),
        ("effect.force_ripple.cosine", 0.03),
        ("effect.back_emf.back_emf_v_s_per_m", 200.0),
    ];
    let beside = [("effect.coulomb_friction.force_n", 40.0), ("effect.constant_force.force_n", 60.0)];
    for settings in [ripple.to_vec(), [&ripple[..], &beside].concat()] {
        let machine = with(&grinder(), &settings);
        let reference = reference(&machine, CELLS[7]);
        let [coarse, fine] = [1, 64].map(|division| on_finer_axis(&machine, &reference, division));
        let error = rms_difference(&coarse.position, &fine.position);
        println!("{} keys: {error:.1e} m", settings.len());
        assert!(error < OTHER_LAWS_M, "{settings:?}: {error:e} m");
    }
}

/// Every feature of dry friction at once.
const FEATURES: [(&str, f64); 12] = [
    ("effect.coulomb_friction.force_n", 12.0),
    ("effect.load_dependent_friction.coefficient", 0.005),
    ("effect.asymmetric_friction.coulomb_asymmetry", 0.2),
    ("effect.asymmetric_friction.viscous_asymmetry", -0.2),
    ("effect.stribeck_friction.peak_ratio", 1.8),
    ("effect.stribeck_friction.stribeck_velocity_m_per_s", 4e-3),
    ("effect.presliding.stiffness_n_per_m", 2e6),
    ("effect.presliding.damping_n_s_per_m", 600.0),
    ("effect.local_friction.force_n", 6.0),
    ("effect.local_friction.centre_m", 0.012),
    ("effect.local_friction.width_m", 0.01),
    ("effect.friction_drift.rate_per_s", 0.1),
];

/// Sample periods of the controller and what the step may make of friction at them: the error grows with its square, and stays
/// below half the encoder's noise of 42 nm at 1 ms.
const PERIODS: [(f64, f64); 2] = [(250e-6, 1e-9), (1e-3, 21e-9)];

/// Each feature of dry friction behind bristles, and all at once, against steps 64 times finer. Bristles go through each step at an
/// even pace, also where they turn back inside it.
#[test]
fn exact_friction_converges_with_the_square_of_the_step() {
    let bristles = [FEATURES[0], FEATURES[6]];
    let beside = |features: &[(&'static str, f64)]| [&bristles, features].concat();
    let sets = [
        beside(&[]),
        beside(&FEATURES[1..2]),
        beside(&FEATURES[2..4]),
        beside(&FEATURES[4..6]),
        beside(&FEATURES[7..8]),
        beside(&FEATURES[8..11]),
        beside(&FEATURES[11..]),
        FEATURES.to_vec(),
    ];
    for (period_s, most) in PERIODS {
        for settings in &sets {
            let machine = with(&with(&grinder(), &[("sample_period_s", period_s)]), settings);
            for cell in [CELLS[0], CELLS[7]] {
                let reference = reference(&machine, cell);
                let [coarse, fine] = [1, 64].map(|division| on_finer_axis(&machine, &reference, division));
                let error = rms_difference(&coarse.position, &fine.position);
                println!("{period_s} s, {} keys, {cell:?}: {error:.1e} m", settings.len());
                assert!(error < most, "{period_s} s: {settings:?} {cell:?}: {error:e} m");
            }
        }
    }
}

/// The same in the rigid-body scene, against its own steps eight times finer, all features at once.
#[test]
fn exact_friction_converges_in_the_rigid_body_scene() {
    let machine = with(&grinder(), &FEATURES);
    let reference = reference(&machine, CELLS[0]);
    let period_s = machine.description().sample_period_s;
    let [coarse, fine] = [1.0, 8.0].map(|division| {
        let mut twin =
            Twin::new(&machine, Rig::with_step(&machine, period_s / division).unwrap(), Sensing::Perfect);
        run(&mut twin, follow(&reference, period_s), |_| ())
    });
    let error = rms_difference(&coarse.position, &fine.position);
    println!("scene: {error:.1e} m");
    assert!(error < SCENE_STEP_M, "{error:e} m");
}

/// What the scene's own step may make of all features of friction: a tenth of the encoder's noise.
const SCENE_STEP_M: f64 = 3e-9;

/// The loop written out by hand and integrated by Runge and Kutta's method in steps of 2 µs: winding, mass, drag and
/// base modes as the model states them, PDF law and velocity estimate as the controller computes them.
fn integrated(machine: &Machine, reference: &[f64]) -> Vec<f64> {
    const STEPS: usize = 125;
    let (m, c, kt, r, l) = (51.28, 333.3, 83.1, 1.3, 8e-3);
    let period = 250e-6;
    let modes: Vec<(f64, f64, f64)> = machine.description().base.as_ref().map_or(vec![], |base| {
        base.mode.iter().map(|q| (q.angular_frequency_rad_per_s(), q.mass_kg(), q.damping_ratio())).collect()
    });
    let m = m + machine.solid().moving_inertia_along_joint() - 51.28;
    // State: i, v, x (relative to the base), η_j, η̇_j.
    let rate = |s: &[f64], u: f64| -> Vec<f64> {
        let force = kt * s[0] - c * s[1];
        let mut d = vec![(u - r * s[0]) / l, force / m, s[1]];
        for (j, (w, mass, zeta)) in modes.iter().enumerate() {
            let (place, speed) = (s[3 + 2 * j], s[4 + 2 * j]);
            let acceleration = -force / mass - 2.0 * zeta * w * speed - w * w * place;
            d.extend([speed, acceleration]);
            d[1] -= acceleration;
        }
        d
    };
    let moved =
        |s: &[f64], d: &[f64], h: f64| -> Vec<f64> { s.iter().zip(d).map(|(s, d)| s + h * d).collect() };
    let mut state = vec![0.0; 3 + 2 * modes.len()];
    let (mut before, mut velocity, mut integral, mut reference_before) = (0.0, 0.0, 0.0, 0.0);
    let mut positions = Vec::with_capacity(reference.len());
    for &target in reference {
        let x = state[2];
        positions.push(x);
        velocity += period / (period + 0.5e-3) * ((x - before) / period - velocity);
        let speed = (target - reference_before) / period;
        let error = 1000.0 * (6.5 * (target - x) + 0.7 * speed - velocity);
        integral += 19.0 * 6.942e-2 * period * error;
        let u = integral - 260.0 * 2.359e-4 * 1000.0 * velocity;
        (before, reference_before) = (x, target);
        let h = period / STEPS as f64;
        for _ in 0..STEPS {
            let k1 = rate(&state, u);
            let k2 = rate(&moved(&state, &k1, 0.5 * h), u);
            let k3 = rate(&moved(&state, &k2, 0.5 * h), u);
            let k4 = rate(&moved(&state, &k3, h), u);
            for (n, s) in state.iter_mut().enumerate() {
                *s += h / 6.0 * (k1[n] + 2.0 * k2[n] + 2.0 * k3[n] + k4[n]);
            }
        }
    }
    positions
}

/// The axis against an integration that shares nothing with it, base included.
#[test]
fn exact_axis_is_the_converged_integration() {
    let machine = grinder();
    let reference = reference(&machine, (0.03, 16.0));
    let error = rms_difference(&on_axis(&machine, &reference).position, &integrated(&machine, &reference));
    assert!(reference.last().is_some_and(|end| *end == 0.03), "the axis is told to move");
    println!("axis against Runge–Kutta: {error:.1e} m");
    assert!(error < 1e-12, "{error:e} m");
}

/// Bristles that hold the axis do not make of a change of 1e-11 in the drag more than a trace of it.
#[test]
fn exact_bristles_are_well_conditioned() {
    let bristles = [("effect.coulomb_friction.force_n", 15.0), ("effect.presliding.stiffness_n_per_m", 2e6)];
    let machine = with(&grinder(), &bristles);
    let drag = machine.number("guide.viscous_n_s_per_m").unwrap();
    let nudged = with(&machine, &[("guide.viscous_n_s_per_m", drag * (1.0 + 1e-11))]);
    for cell in [CELLS[0], CELLS[2]] {
        let reference = reference(&machine, cell);
        let moved =
            rms_difference(&on_axis(&machine, &reference).position, &on_axis(&nudged, &reference).position);
        println!("{cell:?}: {moved:.1e} m");
        assert!(moved < 1e-11, "{cell:?}: {moved:e} m");
    }
}

/// Between two samples a twin without friction is linear, and exact at any step length: replays in steps of a control period of 1 ms are those in steps of
/// 250 µs. With friction, which is solved to second order inside a step, they differ by less than a third
/// of the encoder's noise.
#[test]
fn exact_a_linear_twin_is_the_same_in_steps_of_a_control_period() {
    let slow = grinder().with_settings([("sample_period_s", 1e-3.into())]).unwrap();
    let rubbing = slow.with_settings([("effect.coulomb_friction.force_n", 15.0.into())]).unwrap();
    let largest = |real: &Machine| {
        let run =
            Strokes::both_ways(real, real, 1).recording(&[(0.02, 8.0, Role::Training)]).runs()[0].clone();
        let recorded = Recorded::of(&run, real).unwrap();
        let [fine, coarse] = [LONGEST_STEP_S, 1e-3]
            .map(|step_s| recorded.replay_together(std::slice::from_ref(real), step_s).remove(0).position);
        fine.iter().zip(&coarse).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let [linear, friction] = [&slow, &rubbing].map(largest);
    println!("{linear:.1e} m; {friction:.1e} m with friction");
    assert!(linear < 1e-12 && friction > linear && friction < 1e-8);
}
