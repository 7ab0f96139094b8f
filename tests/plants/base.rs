//! The machine base: modes, equivalent chain and motion against closed forms.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::f64::consts::TAU;

use proptest::prelude::*;
use slideway::base::chain::Chain;
use slideway::base::modes::{Mode, Modes};
use slideway::base::motion::BaseMotion;
use slideway::error::ErrorKind;

/// Agreement of chain and modes: the inverse problem loses a few digits of sixteen for eight modes.
const CHAIN_RELATIVE: f64 = 1e-9;
/// Closed forms evaluated two ways differ by a few roundings.
const ROUNDING: f64 = 1e-12;

fn five_modes() -> Modes {
    let frequencies = [86.1, 88.69, 134.19, 140.92, 162.86];
    let masses = [1500.0, 1800.0, 2200.0, 2500.0, 3000.0];
    Modes::new(frequencies.iter().zip(masses).map(|(f, m)| Mode::new(*f, m, 0.02).unwrap()).collect())
}

fn undamped(modes: &Modes) -> Modes {
    let free = |m: &Mode| Mode::new(m.frequency_hz(), m.mass_kg(), 0.0).unwrap();
    Modes::new(modes.as_slice().iter().map(free).collect())
}

/// One to eight modes, each frequency at least 3 % above the one before, individually damped.
fn any_modes() -> impl Strategy<Value = Modes> {
    let rest = prop::collection::vec((1.03..1.35f64, 300.0..5000.0f64, 0.002..0.1f64), 1..=8);
    (20.0..60.0f64, rest).prop_map(|(lowest, rest)| {
        let mut frequency = lowest;
        Modes::new(
            rest.into_iter()
                .map(|(ratio, mass, damping)| {
                    frequency *= ratio;
                    Mode::new(frequency, mass, damping).unwrap()
                })
                .collect(),
        )
    })
}

fn largest_difference(modes: &Modes, chain: &Chain) -> f64 {
    (1..=400)
        .map(|f| {
            let (wanted, found) =
                (modes.drive_point_response(f64::from(f)), chain.drive_point_response(f64::from(f)).unwrap());
            (found - wanted).norm() / wanted.norm()
        })
        .fold(0.0, f64::max)
}

fn assert_same_modes(a: &Modes, b: &Modes, tolerance: f64) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.as_slice().iter().zip(b.as_slice()) {
        assert!((a.frequency_hz() / b.frequency_hz() - 1.0).abs() < tolerance, "{a:?} {b:?}");
        assert!((a.mass_kg() / b.mass_kg() - 1.0).abs() < tolerance, "{a:?} {b:?}");
        assert!((a.damping_ratio() - b.damping_ratio()).abs() < tolerance, "{a:?} {b:?}");
    }
}

#[test]
fn exact_receptance_of_one_mode() {
    let modes = Modes::new(vec![Mode::new(100.0, 2000.0, 0.05).unwrap()]);
    let stiffness = 2000.0 * (TAU * 100.0_f64).powi(2);
    assert!((modes.static_compliance_m_per_n() * stiffness - 1.0).abs() < ROUNDING);
    assert!((modes.drive_point_response(0.0).re * stiffness - 1.0).abs() < ROUNDING);
    // at resonance: 1/(2ζk), a quarter of a turn behind
    let resonant = modes.drive_point_response(100.0) * stiffness;
    assert!((resonant.im + 10.0).abs() < ROUNDING && resonant.re.abs() < ROUNDING, "{resonant}");
    // far above: −1/(Mω²)
    let high = modes.drive_point_response(1e6) * 2000.0 * (TAU * 1e6_f64).powi(2);
    assert!((high.re + 1.0).abs() < 1e-7, "{high}");
}

#[test]
fn exact_chain_of_two_equal_masses_by_hand() {
    // m = 1 kg twice, k = 1 N/m twice, mass 2 to ground: λ = (3 ∓ √5)/2
    let chain = Chain::new(vec![1.0, 1.0], vec![1.0, 1.0], &[0.0, 0.0]).unwrap();
    let modes = chain.to_modes().unwrap();
    let root = 5.0_f64.sqrt();
    for (mode, eigenvalue) in modes.as_slice().iter().zip([(3.0 - root) / 2.0, (3.0 + root) / 2.0]) {
        assert!(((TAU * mode.frequency_hz()).powi(2) - eigenvalue).abs() < ROUNDING);
    }
    assert!((chain.static_compliance_m_per_n() - 2.0).abs() < ROUNDING);
    let back = Chain::from_modes(&modes).unwrap();
    for (found, wanted) in back.masses_kg().iter().chain(back.springs_n_per_m()).zip([1.0; 4]) {
        assert!((found - wanted).abs() < ROUNDING, "{back:?}");
    }
}

#[test]
fn exact_five_published_frequencies_as_a_chain() {
    let modes = five_modes();
    let chain = Chain::from_modes(&modes).unwrap();
    assert!(chain.masses_kg().iter().chain(chain.springs_n_per_m()).all(|x| *x > 0.0));
    let worst = largest_difference(&modes, &chain);
    assert!(worst < CHAIN_RELATIVE, "{worst:e}");
    assert_same_modes(&chain.to_modes().unwrap(), &modes, CHAIN_RELATIVE);
    // five individually damped modes are no chain of dashpots: equal ratios are not proportional to frequency
    assert_eq!(chain.neighbour_dashpots_n_s_per_m(), None);
}

#[test]
fn exact_undamped_chain_keeps_every_eigenfrequency() {
    let modes = undamped(&five_modes());
    let chain = Chain::from_modes(&modes).unwrap();
    assert_same_modes(&chain.to_modes().unwrap(), &modes, CHAIN_RELATIVE);
    assert!(largest_difference(&modes, &chain) < CHAIN_RELATIVE);
    assert_eq!(chain.neighbour_dashpots_n_s_per_m(), Some(vec![0.0; 5]));
}

#[test]
fn exact_single_damped_mode_among_undamped_ones_survives_the_chain() {
    for damped in 0..5 {
        let only = |(i, m): (usize, &Mode)| {
            let ratio = if i == damped { 0.3 } else { 0.0 };
            Mode::new(m.frequency_hz(), m.mass_kg(), ratio).unwrap()
        };
        let modes = Modes::new(five_modes().as_slice().iter().enumerate().map(only).collect());
        assert_same_modes(&Chain::from_modes(&modes).unwrap().to_modes().unwrap(), &modes, CHAIN_RELATIVE);
    }
}

#[test]
fn exact_damping_proportional_to_frequency_is_a_chain_of_dashpots() {
    let proportional = |m: &Mode| Mode::new(m.frequency_hz(), m.mass_kg(), 2e-4 * m.frequency_hz()).unwrap();
    let modes = Modes::new(five_modes().as_slice().iter().map(proportional).collect());
    let chain = Chain::from_modes(&modes).unwrap();
    let dashpots = chain.neighbour_dashpots_n_s_per_m().expect("proportional damping");
    let beta = 2.0 * 2e-4 / TAU;
    for (dashpot, spring) in dashpots.iter().zip(chain.springs_n_per_m()) {
        assert!((dashpot / (beta * spring) - 1.0).abs() < CHAIN_RELATIVE);
    }
    let masses = chain.masses_kg().to_vec();
    let rebuilt = Chain::new(masses, chain.springs_n_per_m().to_vec(), &dashpots).unwrap();
    assert!(largest_difference(&modes, &rebuilt) < CHAIN_RELATIVE);
}

#[test]
fn exact_dashpots_that_couple_modes_are_refused() {
    let chain = Chain::new(vec![1.0, 2.0], vec![30.0, 40.0], &[5.0, 0.0]).unwrap();
    assert_eq!(chain.to_modes().unwrap_err().kind(), ErrorKind::Undetermined);
}

#[test]
fn exact_equal_frequencies_are_refused() {
    let twice =
        Modes::new(vec![Mode::new(90.0, 1000.0, 0.02).unwrap(), Mode::new(90.0, 500.0, 0.01).unwrap()]);
    let error = Chain::from_modes(&twice).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Inconsistent);
    assert!(error.to_string().contains("90"), "{error}");
    assert_eq!(Chain::from_modes(&Modes::default()).unwrap_err().kind(), ErrorKind::Missing);
}

#[test]
fn exact_chain_with_a_mass_of_zero_is_refused() {
    let error = Chain::new(vec![1.0, 0.0], vec![1.0, 1.0], &[0.0, 0.0]).unwrap_err();
    assert_eq!(error.key_name(), Some("masses_kg"));
    assert!(Chain::new(vec![1.0], vec![1.0, 1.0], &[0.0]).is_err());
    assert!(Chain::new(vec![1.0], vec![f64::NAN], &[0.0]).is_err());
    assert!(Chain::new(vec![1.0], vec![1.0], &[-1.0]).is_err());
}

#[test]
fn exact_mode_out_of_range_is_refused() {
    for (f, m, z, key) in [
        (0.0, 1.0, 0.1, "frequency_hz"),
        (f64::NAN, 1.0, 0.1, "frequency_hz"),
        (1.0, -1.0, 0.1, "mass_kg"),
        (1.0, f64::INFINITY, 0.1, "mass_kg"),
        (1.0, 1.0, 1.0, "damping_ratio"),
        (1.0, 1.0, -0.1, "damping_ratio"),
        (1.0, 1.0, f64::NAN, "damping_ratio"),
    ] {
        assert_eq!(Mode::new(f, m, z).unwrap_err().key_name(), Some(key));
    }
}

#[test]
fn exact_modes_from_toml_with_unknown_or_bad_key_is_refused() {
    #[derive(serde::Deserialize, Debug)]
    struct Base {
        mode: Modes,
    }
    let good: Base =
        toml::from_str("[[mode]]\nfrequency_hz = 86.1\nmass_kg = 1500\ndamping_ratio = 0.02\n").unwrap();
    assert_eq!(good.mode.len(), 1);
    let unknown = toml::from_str::<Base>(
        "[[mode]]\nfrequency_hz = 86.1\nmass_kg = 1500\ndamping_ratio = 0.02\nmas = 1\n",
    );
    assert!(unknown.unwrap_err().to_string().contains("mas"));
    let bad =
        toml::from_str::<Base>("[[mode]]\nfrequency_hz = 86.1\nmass_kg = -1500\ndamping_ratio = 0.02\n");
    assert!(bad.unwrap_err().to_string().contains("mass_kg"));
}

/// Step response of an underdamped mode at rest, from the textbook.
fn step_response(mode: &Mode, force_n: f64, t: f64) -> (f64, f64) {
    let omega = mode.angular_frequency_rad_per_s();
    let zeta = mode.damping_ratio();
    let root = (1.0 - zeta * zeta).sqrt();
    let phase = omega * root * t;
    let decay = (-zeta * omega * t).exp();
    let settled = force_n / mode.stiffness_n_per_m();
    let position = settled * (1.0 - decay * (phase.cos() + zeta / root * phase.sin()));
    (position, settled * decay * omega / root * phase.sin())
}

#[test]
fn exact_step_response_of_the_base() {
    let modes = five_modes();
    let motion = BaseMotion::new(&modes, 0.25e-3).unwrap();
    let mut state = vec![0.0; motion.state_len()];
    let scale = 200.0 * modes.static_compliance_m_per_n();
    let top_speed = scale * TAU * 162.86;
    for k in 1..=2000 {
        motion.advance(&mut state, 200.0);
        let t = 0.25e-3 * f64::from(k);
        let responses: Vec<_> = modes.as_slice().iter().map(|m| step_response(m, 200.0, t)).collect();
        let (x, v) = responses.iter().fold((0.0, 0.0), |(x, v), r| (x + r.0, v + r.1));
        assert!((motion.displacement(&state) - x).abs() < ROUNDING * scale, "sample {k}");
        assert!((motion.velocity(&state) - v).abs() < ROUNDING * top_speed, "sample {k}");
    }
}

#[test]
fn exact_velocity_splits_into_free_part_and_force() {
    let motion = BaseMotion::new(&five_modes(), 62.5e-6).unwrap();
    let mut state: Vec<f64> = (0..10).map(|i| 1e-6 * f64::from(i * i - 30)).collect();
    let expected = motion.free_velocity(&state) + 150.0 * motion.velocity_per_force();
    let (before, mut unforced) = (state.clone(), state.clone());
    motion.advance(&mut unforced, 0.0);
    motion.advance(&mut state, 150.0);
    assert!((motion.velocity(&state) - expected).abs() < ROUNDING * expected.abs());
    let moved = motion.displacement(&state) - motion.displacement(&unforced);
    assert!(
        (moved - 150.0 * motion.displacement_per_force()).abs()
            < ROUNDING * motion.displacement(&before).abs()
    );
}

#[test]
fn exact_base_without_modes_is_rigid() {
    let motion = BaseMotion::new(&Modes::default(), 1e-3).unwrap();
    motion.advance(&mut [], 1000.0);
    assert_eq!((motion.state_len(), motion.displacement(&[])), (0, 0.0));
}

#[test]
fn exact_step_of_zero_is_refused() {
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(BaseMotion::new(&five_modes(), dt).unwrap_err().key_name(), Some("dt_s"));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn exact_chain_answers_as_its_modes(modes in any_modes()) {
        let chain = Chain::from_modes(&modes).unwrap();
        let worst = largest_difference(&modes, &chain);
        prop_assert!(worst < CHAIN_RELATIVE, "{worst:e}");
        let compliance = chain.static_compliance_m_per_n() / modes.static_compliance_m_per_n();
        prop_assert!((compliance - 1.0).abs() < CHAIN_RELATIVE);
    }

    #[test]
    fn exact_modes_survive_the_chain(modes in any_modes()) {
        assert_same_modes(&Chain::from_modes(&modes).unwrap().to_modes().unwrap(), &modes, CHAIN_RELATIVE);
    }

    #[test]
    fn exact_chain_survives_its_modes(
        elements in prop::collection::vec((200.0..2000.0f64, 1e8..1e9f64), 1..=8),
        beta in 1e-6..1e-4f64,
    ) {
        let (masses, springs): (Vec<_>, Vec<_>) = elements.into_iter().unzip();
        let dashpots: Vec<_> = springs.iter().map(|k| beta * k).collect();
        let chain = Chain::new(masses, springs, &dashpots).unwrap();
        let back = Chain::from_modes(&chain.to_modes().unwrap()).unwrap();
        let pairs = back.masses_kg().iter().zip(chain.masses_kg());
        for (a, b) in pairs.chain(back.springs_n_per_m().iter().zip(chain.springs_n_per_m())) {
            prop_assert!((a / b - 1.0).abs() < CHAIN_RELATIVE, "{a} {b}");
        }
        let c = chain.damping_matrix_n_s_per_m();
        prop_assert!((back.damping_matrix_n_s_per_m() - c).amax() < CHAIN_RELATIVE * c.amax());
    }

    #[test]
    fn exact_two_half_steps_are_one(
        modes in any_modes(),
        force in -500.0..500.0f64,
        dt in 1e-6..1e-2f64,
        seed in 0.1..1.0f64,
    ) {
        let (whole, half) = (BaseMotion::new(&modes, dt).unwrap(), BaseMotion::new(&modes, 0.5 * dt).unwrap());
        // displacements of some µm and speeds of some mm/s
        let start: Vec<f64> =
            (0..whole.state_len()).map(|i| (seed * 7.0 * i as f64).sin() * if i % 2 == 0 { 1e-6 } else { 1e-3 }).collect();
        let (mut once, mut twice) = (start.clone(), start);
        whole.advance(&mut once, force);
        half.advance(&mut twice, force);
        half.advance(&mut twice, force);
        for (i, (a, b)) in once.iter().zip(&twice).enumerate() {
            let scale: f64 = if i % 2 == 0 { 1e-6 } else { 1e-3 };
            prop_assert!((a - b).abs() < ROUNDING * scale.max(a.abs()), "{a} {b}");
        }
    }

    #[test]
    fn exact_energy_without_damping_or_force_is_kept(modes in any_modes(), dt in 1e-5..1e-2f64) {
        let modes = undamped(&modes);
        let motion = BaseMotion::new(&modes, dt).unwrap();
        let energy = |state: &[f64]| -> f64 {
            modes.as_slice().iter().zip(state.chunks_exact(2))
                .map(|(m, s)| 0.5 * m.stiffness_n_per_m() * s[0] * s[0] + 0.5 * m.mass_kg() * s[1] * s[1])
                .sum()
        };
        let mut state = vec![1e-5; motion.state_len()];
        let before = energy(&state);
        for _ in 0..1000 {
            motion.advance(&mut state, 0.0);
        }
        // rounding of a thousand steps
        prop_assert!((energy(&state) / before - 1.0).abs() < 1e3 * ROUNDING);
    }
}
