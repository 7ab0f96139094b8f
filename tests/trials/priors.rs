//! Priors of the effects: every draw lies where the law's documentation says, spreads over it, and is a machine.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use rand::SeedableRng;
use rand::rngs::StdRng;
use slideway::drive::motor::Circuit;
use slideway::effect::{EffectId, Machinery, Prior};
use slideway::machine::Machine;
use slideway::units::Motion;
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

const DRAWS: u64 = 500;
const ARCMIN: f64 = PI / 10800.0;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn machine(name: &str) -> Machine {
    Machine::read(&root().join("models").join(name)).unwrap()
}

fn prismatic() -> Machinery {
    let constants = machine("grinder").constants();
    Machinery {
        constants,
        motion: Motion::Prismatic,
        rated_force: 500.0,
        voltage_v: 6.0,
        speed: 0.25,
        travel: -0.05,
        coulomb: 15.0,
    }
}

fn revolute() -> Machinery {
    let constants = machine("servo").constants();
    Machinery {
        constants,
        motion: Motion::Revolute,
        rated_force: 1.5,
        voltage_v: 9.0,
        speed: 30.0,
        travel: 7.0,
        coulomb: 0.01,
    }
}

fn draws(effect: EffectId, machinery: &Machinery) -> Vec<Vec<f64>> {
    let mut random = StdRng::seed_from_u64(effect as u64);
    let mut prior = Prior::new(&mut random);
    (0..DRAWS).map(|_| effect.draw(machinery, &mut prior)).collect()
}

/// How a number is spread between two others.
#[derive(Clone, Copy, PartialEq)]
enum Spread {
    /// Half of the draws below the mean of the limits.
    Even,
    /// Half of the draws below the geometric mean of the limits.
    Log,
    /// Somehow: a mixture, or one of a list.
    Somehow,
}
use Spread::{Even, Log, Somehow};

/// A number that parameters make.
type Number = Box<dyn Fn(&[f64]) -> f64>;

/// What the documentation of a law says of a number that its parameters make.
struct Claim {
    what: &'static str,
    of: Number,
    from: f64,
    to: f64,
    spread: Spread,
    /// Whether the limits are those of the magnitude and both signs occur.
    signed: bool,
}

fn claim(
    what: &'static str,
    spread: Spread,
    (from, to): (f64, f64),
    of: impl Fn(&[f64]) -> f64 + 'static,
) -> Claim {
    Claim { what, of: Box::new(of), from, to, spread, signed: false }
}

/// The claim on a parameter itself, by its place.
fn own(k: usize, spread: Spread, limits: (f64, f64)) -> Claim {
    claim("parameter", spread, limits, move |v| v[k])
}

fn signed(claim: Claim) -> Claim {
    Claim { signed: true, ..claim }
}

fn times(factor: f64, (from, to): (f64, f64)) -> (f64, f64) {
    (factor * from, factor * to)
}

fn wave(machinery: &Machinery, first: (f64, f64)) -> Vec<Claim> {
    let pitch = match machinery.motion {
        Motion::Prismatic => own(0, Even, (0.010, 0.060)),
        Motion::Revolute => {
            let of_a_turn = |v: &[f64]| {
                if (TAU / v[0] - (TAU / v[0]).round()).abs() < 1e-9 { TAU / v[0] } else { f64::NAN }
            };
            claim("poles or slots in a turn", Log, (2.0, 84.0), of_a_turn)
        }
    };
    vec![
        pitch,
        claim("first harmonic", Log, first, |v| v[1].hypot(v[2])),
        claim("second harmonic", Even, (0.0, 0.4), |v| v[3].hypot(v[4]) / v[1].hypot(v[2])),
        signed(claim("sine", Somehow, (0.0, 1.0), |v| v[1] / v[1].hypot(v[2]))),
        signed(claim("cosine", Somehow, (0.0, 1.0), |v| v[2] / v[1].hypot(v[2]))),
    ]
}

fn controller_and_drive(effect: EffectId, m: &Machinery) -> Option<Vec<Claim>> {
    let (period, volt, constants) = (m.constants.sample_period_s, m.voltage_v, &m.constants);
    let Circuit::Winding { resistance_ohm, inductance_h, force_constant, back_emf } = constants.circuit
    else {
        panic!("the machines of these tests have windings");
    };
    let claims = match effect {
        EffectId::PositionGain | EffectId::VelocityGain | EffectId::IntegralGain => {
            vec![own(0, Even, (0.5, 1.5))]
        }
        EffectId::VelocityFeedforward => {
            let stated = constants.controller.as_ref().unwrap().velocity_feedforward();
            let limits = if stated == 0.0 { (0.0, 1.0) } else { times(stated, (0.5, 1.5)) };
            vec![own(0, Even, limits)]
        }
        EffectId::LoopDelay => vec![own(0, Even, (0.0, 4.0 * period))],
        EffectId::VoltageSaturation => vec![match constants.effort_limit_v() {
            Some(stated) => own(0, Even, times(stated, (0.6, 0.95))),
            None => own(0, Even, times(volt, (0.5, 1.1))),
        }],
        EffectId::DeadZone => vec![own(0, Log, times(volt, (0.002, 0.05)))],
        EffectId::AmplifierOffset => vec![signed(own(0, Log, times(volt, (0.001, 0.02))))],
        EffectId::CurrentLoop => vec![own(0, Log, (50.0, 2000.0))],
        EffectId::WindingResistance => vec![own(0, Even, times(resistance_ohm, (0.961, 1.39)))],
        EffectId::WindingInductance => vec![own(0, Even, times(inductance_h, (0.7, 1.3)))],
        EffectId::BackEmf if back_emf > 0.0 => vec![own(0, Even, times(back_emf, (0.8, 1.05)))],
        EffectId::BackEmf => vec![own(0, Log, times(force_constant, (0.02, 1.0)))],
        EffectId::ForceConstant => vec![own(0, Even, (0.80, 1.05))],
        EffectId::ForceSaturation => {
            let peak = 4.0 * m.rated_force;
            vec![claim("loss at the peak", Log, (0.03, 0.40), move |v| v[0] * peak / (1.0 + v[0] * peak))]
        }
        EffectId::ForceRipple | EffectId::SecondForceRipple => wave(m, (0.01, 0.15)),
        EffectId::Cogging | EffectId::SecondCogging | EffectId::ThirdCogging => {
            wave(m, times(m.rated_force, (0.005, 0.10)))
        }
        _ => return None,
    };
    Some(claims)
}

fn guide(effect: EffectId, m: &Machinery) -> Option<Vec<Claim>> {
    let (rated, coulomb, travel, mass) = (m.rated_force, m.coulomb, m.travel, m.constants.moving_mass);
    let is_prismatic = m.motion == Motion::Prismatic;
    let claims = match effect {
        EffectId::ViscousFriction => {
            let (c, seal) = (m.constants.viscous, times(rated / m.speed, (0.002, 0.20)));
            vec![own(0, Somehow, (0.4 * c, (2.5 * c).max(c + seal.1)))]
        }
        EffectId::CoulombFriction => vec![own(0, Log, times(rated, (0.002, 0.20)))],
        EffectId::AsymmetricFriction => [0, 1].map(|k| signed(own(k, Log, (0.03, 0.4)))).into(),
        EffectId::StribeckFriction => {
            let (spread, slow) = if is_prismatic { (Log, (1e-3, 30e-3)) } else { (Somehow, (0.02, 3.0)) };
            vec![own(0, Even, (1.1, 2.0)), own(1, spread, slow)]
        }
        EffectId::Presliding => {
            let (spread, limits) = if is_prismatic { (Log, (1e-6, 50e-6)) } else { (Somehow, (2e-5, 5e-3)) };
            let ratio = move |v: &[f64]| v[1] / (2.0 * (v[0] * mass).sqrt());
            vec![
                claim("breakaway", spread, limits, move |v| coulomb / v[0]),
                claim("damping ratio", Log, (0.05, 1.0), ratio),
            ]
        }
        EffectId::LoadDependentFriction => {
            let limits = if m.constants.has_slider_loads { (0.002, 0.02) } else { (0.02, 0.2) };
            vec![own(0, Log, limits)]
        }
        EffectId::LocalFriction => vec![
            own(0, Somehow, (-0.9 * coulomb, 0.20 * rated)),
            claim("centre", Even, (0.0, 1.0), move |v| v[1] / travel),
            own(2, Log, if is_prismatic { (0.005, 0.150) } else { (0.05, 1.5) }),
        ],
        EffectId::FrictionDrift => vec![signed(own(0, Somehow, (0.05 / 1800.0, 0.30 / 120.0)))],
        EffectId::ConstantForce => vec![signed(own(0, Log, times(rated, (0.001, 0.10))))],
        EffectId::CableSpring => vec![
            own(0, Log, times(rated / travel.abs(), (0.002, 0.10))),
            claim("centre", Even, (0.0, 1.0), move |v| v[1] / travel),
        ],
        _ => return None,
    };
    Some(claims)
}

fn structure(effect: EffectId, m: &Machinery) -> Option<Vec<Claim>> {
    let (rated, mass, rate) = (m.rated_force, m.constants.moving_mass, 1.0 / m.constants.sample_period_s);
    let is_prismatic = m.motion == Motion::Prismatic;
    let claims = match effect {
        EffectId::ExternalVibration => {
            vec![own(0, Log, (5.0, 60.0)), own(1, Log, times(rated, (0.0005, 0.02)))]
        }
        EffectId::Payload => vec![own(0, Somehow, times(mass, (-0.2, 1.0)))],
        EffectId::BaseModeShift => vec![
            own(0, Somehow, (1.0, m.constants.modes.len().max(1) as f64)),
            claim("whole number", Somehow, (0.0, 0.0), |v| v[0].fract()),
            own(1, Even, (0.6, 1.4)),
            own(2, Log, (0.8, 1.25)),
        ],
        EffectId::FlexibleMode => vec![
            own(0, Log, (8.0, (0.2 * rate).min(400.0))),
            claim("mass ratio", Log, (0.01, 0.5), move |v| mass / v[1]),
            own(2, Log, (0.005, 0.06)),
        ],
        EffectId::Backlash => {
            let limits = if is_prismatic { (1e-6, 300e-6) } else { (ARCMIN, 10.0 * ARCMIN) };
            vec![own(0, Log, limits), own(1, Somehow, (0.0, 0.0))]
        }
        EffectId::ScrewError => {
            let (pitch, error, spread) = if is_prismatic {
                ((0.002, 0.040), (0.5e-6, 20e-6), Log)
            } else {
                ((TAU / 100.0, TAU), (0.1 * ARCMIN, 3.0 * ARCMIN), Somehow)
            };
            vec![
                own(0, Somehow, pitch),
                claim("amplitude", spread, error, |v| v[1].hypot(v[2])),
                claim("slope", Somehow, (error.0 / pitch.1, 0.01), |v| v[1].hypot(v[2]) / v[0]),
                signed(claim("sine", Somehow, (0.0, 1.0), |v| v[1] / v[1].hypot(v[2]))),
                own(3, Somehow, (0.0, 0.0)),
            ]
        }
        _ => return None,
    };
    Some(claims)
}

fn sensor(effect: EffectId, m: &Machinery) -> Option<Vec<Claim>> {
    let (period, stated) = (m.constants.sample_period_s, m.constants.encoder_step);
    let is_prismatic = m.motion == Motion::Prismatic;
    let claims = match effect {
        EffectId::SensorScale => vec![
            own(0, Somehow, (0.5, 2.0)),
            own(1, Somehow, (0.5, 2.0)),
            claim("one is right", Somehow, (0.0, 0.0), |v| (v[0] - 1.0) * (v[1] - 1.0)),
        ],
        EffectId::EncoderScale => {
            vec![signed(claim("off", Somehow, (1e-5, 0.20), |v| v[0] - 1.0))]
        }
        EffectId::EncoderZero => vec![signed(own(0, Somehow, (0.01, TAU / 15.0)))],
        EffectId::EncoderPeriodicError => {
            let (pitch, error) = if is_prismatic {
                ((4e-6, 4e-3), (10e-9, 500e-9))
            } else {
                ((TAU / 4096.0, TAU), (0.001 * TAU / 4096.0, 20e-6 / 0.010))
            };
            vec![
                own(0, Somehow, pitch),
                claim("amplitude", Somehow, error, |v| v[1].hypot(v[2])),
                claim("slope", Somehow, (error.0 / pitch.1, 0.02), |v| v[1].hypot(v[2]) / v[0]),
                signed(claim("sine", Somehow, (0.0, 1.0), |v| v[1] / v[1].hypot(v[2]))),
            ]
        }
        EffectId::EncoderResolution => {
            let most = if is_prismatic { 10e-6 } else { TAU / 1000.0 };
            vec![own(0, Somehow, (2.0 * stated, most))]
        }
        EffectId::VelocityFilter => vec![own(0, Log, (0.1 * period, 4.0 * period))],
        _ => return None,
    };
    Some(claims)
}

fn claims(effect: EffectId, m: &Machinery) -> Vec<Claim> {
    let of_any = controller_and_drive(effect, m)
        .or_else(|| guide(effect, m))
        .or_else(|| structure(effect, m))
        .or_else(|| sensor(effect, m));
    of_any.unwrap_or_else(|| panic!("{}: nothing is claimed of its prior", effect.name()))
}

/// Whether a claim holds of numbers drawn, or what is wrong.
fn check(claim: &Claim, drawn: &[Vec<f64>]) -> Result<(), String> {
    let numbers: Vec<f64> = drawn.iter().map(|values| (claim.of)(values)).collect();
    let sizes: Vec<f64> = numbers.iter().map(|n| if claim.signed { n.abs() } else { *n }).collect();
    let (from, to) = (claim.from, claim.to);
    let slack = 1e-9 * from.abs().max(to.abs());
    if let Some(off) = sizes.iter().find(|n| !(from - slack..=to + slack).contains(*n)) {
        return Err(format!("{off} is outside {from} to {to}"));
    }
    if from == to {
        return Ok(());
    }
    let scale = |n: f64| {
        if claim.spread == Log || (claim.spread == Somehow && from > 0.0) { n.ln() } else { n }
    };
    let (from, to) = (scale(from), scale(to));
    let (least, most) = sizes
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), n| (l.min(scale(*n)), m.max(scale(*n))));
    let covered = (most - least) / (to - from);
    if covered < 0.7 {
        return Err(format!("only {covered} of its range occurs"));
    }
    let total = numbers.len() as f64;
    let low = sizes.iter().filter(|n| scale(**n) < 0.5 * (from + to)).count() as f64 / total;
    if claim.spread != Somehow && (low - 0.5).abs() > 0.1 {
        return Err(format!("{low} of it is in the lower half of its range"));
    }
    let positive = numbers.iter().filter(|n| **n > 0.0).count() as f64 / total;
    if claim.signed && (positive - 0.5).abs() > 0.1 {
        return Err(format!("{positive} of it is positive"));
    }
    Ok(())
}

#[test]
fn exact_draws_lie_where_documented_and_spread_over_it() {
    for machinery in [prismatic(), revolute()] {
        for &effect in EffectId::ALL {
            let drawn = draws(effect, &machinery);
            for values in &drawn {
                assert_eq!(values.len(), effect.parameters().len(), "{}", effect.name());
                assert!(values.iter().all(|v| v.is_finite()), "{}: {values:?}", effect.name());
            }
            for claim in claims(effect, &machinery) {
                if let Err(fault) = check(&claim, &drawn) {
                    panic!("{} of a {} axis, {}: {fault}", effect.name(), machinery.motion, claim.what);
                }
            }
        }
    }
}

#[test]
fn exact_wrong_claims_are_caught() {
    let drawn = draws(EffectId::CoulombFriction, &prismatic());
    let wrong = |spread, limits| check(&own(0, spread, times(500.0, limits)), &drawn).is_err();
    assert!(!wrong(Log, (0.002, 0.20)));
    assert!(wrong(Log, (0.004, 0.20)), "draws outside");
    assert!(wrong(Log, (1e-6, 0.20)), "a part of the range only");
    assert!(wrong(Even, (0.002, 0.20)), "another distribution");
    assert!(check(&signed(own(0, Log, (1.0, 100.0))), &drawn).is_err(), "one sign only");
}

/// What an effect modifies, first what that modifies itself.
fn modified(effect: EffectId, machinery: &Machinery, found: &mut Vec<EffectId>) {
    if let Some(&of) = effect.modifies().iter().find(|of| of.applies(&machinery.constants)) {
        modified(of, machinery, found);
        found.push(of);
    }
}

#[test]
fn exact_every_draw_is_a_machine() {
    let models = [
        ("grinder", 500),
        ("servo", 500),
        ("emps", 50),
        ("grinder_yaxis", 50),
        ("xl330", 50),
        ("delta_a3", 50),
    ];
    for (name, number) in models {
        let stated = machine(name);
        let base = if stated.motion() == Motion::Prismatic { prismatic() } else { revolute() };
        let machinery = Machinery { constants: stated.constants(), motion: stated.motion(), ..base };
        let mut random = StdRng::seed_from_u64(15);
        let mut prior = Prior::new(&mut random);
        for &effect in EffectId::ALL.iter().filter(|effect| effect.applies(&machinery.constants)) {
            let mut effects = Vec::new();
            modified(effect, &machinery, &mut effects);
            effects.push(effect);
            for _ in 0..number {
                let mut settings = Vec::new();
                for &effect in &effects {
                    for (parameter, value) in
                        effect.parameters().iter().zip(effect.draw(&machinery, &mut prior))
                    {
                        let path = format!("effect.{}.{}", effect.name(), parameter.key(stated.motion()));
                        settings.push((path, toml::Value::Float(value)));
                    }
                }
                let settings = settings.iter().map(|(path, value)| (path.as_str(), value.clone()));
                let real = stated.with_settings(settings).unwrap_or_else(|error| panic!("{name}: {error}"));
                assert!(real.description().effect.contains(effect), "{}", effect.name());
            }
        }
    }
}

#[test]
fn exact_stated_pitches_are_taken_half_of_the_time() {
    let stated = 0.0321;
    let mut machinery = prismatic();
    machinery.constants.stated_pitches = vec![stated];
    let share = |effect: EffectId| {
        let drawn = draws(effect, &machinery);
        drawn.iter().filter(|values| values[0] == stated).count() as f64 / DRAWS as f64
    };
    for effect in [EffectId::Cogging, EffectId::ForceRipple, EffectId::ScrewError] {
        assert!((share(effect) - 0.5).abs() < 0.1, "{}", effect.name());
    }
    for effect in [EffectId::SecondCogging, EffectId::ThirdCogging, EffectId::SecondForceRipple] {
        assert_eq!(share(effect), 0.0, "{}", effect.name());
    }
}

/// A motor behind a transmission turns more often than the joint, and so do its poles.
#[test]
fn exact_pitches_are_those_of_a_turn_of_the_motor() {
    let mut machinery = revolute();
    let free = draws(EffectId::SecondCogging, &machinery);
    machinery.constants.has_transmission = true;
    machinery.constants.stated_pitches = vec![0.3, TAU / 50.0];
    for (behind, direct) in draws(EffectId::SecondCogging, &machinery).iter().zip(&free) {
        assert!((behind[0] * 50.0 / direct[0] - 1.0).abs() < 1e-12);
    }
}

#[test]
fn exact_features_stand_on_the_friction_that_they_modify() {
    let breakaway = |coulomb: f64, friction: f64| {
        let machinery = Machinery { coulomb, ..prismatic() };
        draws(EffectId::Presliding, &machinery)
            .iter()
            .map(|values| friction / values[0])
            .collect::<Vec<f64>>()
    };
    let [stated, none] = [breakaway(15.0, 15.0), breakaway(0.0, 0.02 * 500.0)];
    for (stated, none) in stated.iter().zip(&none) {
        assert!((stated / none - 1.0).abs() < 1e-12, "{stated} {none}");
    }
    let none = Machinery { coulomb: 0.0, ..prismatic() };
    assert!(draws(EffectId::LocalFriction, &none).iter().all(|values| values[0] > 0.0));
}

#[test]
fn exact_coarser_steps_are_coarser_than_any_stated_one() {
    for stated in [0.0, 1e-9, 3e-6, 1e-3] {
        for mut machinery in [prismatic(), revolute()] {
            machinery.constants.encoder_step = stated;
            let drawn = draws(EffectId::EncoderResolution, &machinery);
            assert!(drawn.iter().all(|values| values[0] > 0.0 && values[0] >= 2.0 * stated), "{stated}");
        }
    }
}

/// Rust files of the effects with a law in them.
fn laws() -> Vec<(PathBuf, String)> {
    let files = std::fs::read_dir(root().join("src/effect")).unwrap().map(|entry| entry.unwrap().path());
    let read = files.map(|path| (path.clone(), std::fs::read_to_string(path).unwrap()));
    read.filter(|(_, text)| text.contains("\nimpl Law for ") || text.contains(" impl Law for ")).collect()
}

/// Where a prior is from: a catalogue, standard, data sheet or manual, or a paper or book by its year.
fn has_source(section: &str) -> bool {
    let words = ["atalogue", "ISO ", "IEC ", "ata sheet", "anual", "brochure"];
    let year = |at: usize| section[at + 1..].chars().take_while(char::is_ascii_digit).count() == 4;
    words.iter().any(|word| section.contains(word)) || section.match_indices('(').any(|(at, _)| year(at))
}

#[test]
fn exact_every_law_documents_its_prior_and_where_it_is_from() {
    let laws = laws();
    assert!(laws.len() > 30, "only {} laws", laws.len());
    for (path, text) in &laws {
        let lines = text.lines().map(str::trim_start).skip_while(|line| *line != "/// # Prior").skip(1);
        let section: Vec<&str> = lines.take_while(|line| line.starts_with("///") && *line != "///").collect();
        assert!(section.len() > 1, "{}: no prior", path.display());
        assert!(has_source(&section.join(" ").replace(" /// ", " ")), "{}: {section:#?}", path.display());
    }
    for effect in EffectId::ALL {
        let is_file = |name: &str| laws.iter().any(|(path, _)| path.file_stem().unwrap() == name);
        let found = is_file(effect.name()) || is_file(effect.group().unwrap_or_default());
        assert!(found, "{}", effect.name());
    }
}
