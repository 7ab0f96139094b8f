//! Higher harmonics of what repeats along the axis: found as a further pitch, told as part of the first one.

use super::amplitude::Wave;
use super::cause::{Cause, Harmonic};
use super::parameter::Parameter;

/// The lowest harmonic.
const FIRST_ORDER: f64 = 2.0;
/// Harmonics below this order are parameters of the law with the pitch itself.
const FIRST_FURTHER: u32 = 3;
/// And up to this one: beyond it unrelated pitches come near a whole ratio by chance.
const LAST_ORDER: f64 = 12.0;
/// A ratio so near to a whole number is one: unrelated pitches come as near once in fifty times, harmonics are the rule.
const WHOLE: f64 = 0.01;
/// The same of a wave smaller than [`SMALL`], which a further harmonic next to it pulls aside.
const WHOLE_IF_SMALL: f64 = 0.1;
/// Share of the whole's amplitude below which a wave is more often a harmonic than a pitch of its own: harmonics are a few per cent of
/// the first, two pitches are of one size or another. One in five unrelated pitches is so near a whole ratio.
const SMALL: f64 = 0.1;
/// An interval that is wider holds a whole number by chance more often than once in ten times.
const WIDEST: f64 = 0.05;

/// Makes causes that are harmonics of another one of their group part of that one, and returns their effects.
///
/// # Model
/// A further pitch p′ is the n-th harmonic of the pitch p where p/p′ is a whole number n, 2 ≤ n ≤ 12, within its 95 % interval (taken
/// as at least 0.01 and at most 0.05; as 0.1 where its amplitude is less than a tenth of the whole's). The force of magnets and slots has all harmonics of its pitch; that another source has a
/// pitch in such a ratio is a coincidence.
///
/// Of a further pitch whose second wave is larger than its first one, that wave is what may be a harmonic; the first one takes up what other
/// harmonics leave.
///
/// Of half a pitch, the first wave is one with the second harmonic that the law itself has, and its own second one is the fourth:
/// `summed` gives the amplitude of waves of one period.
pub fn fold(causes: &mut Vec<Cause>, summed: &dyn Fn(&[Wave]) -> Option<Parameter>) -> Vec<String> {
    let mut folded = Vec::new();
    while let Some((part, whole, order)) = harmonic(causes) {
        let Cause { effect, closes, parameters, amplitudes, .. } = causes.remove(part);
        let whole = &mut causes[if part < whole { whole - 1 } else { whole }];
        whole.closes += closes;
        for (key, amplitude) in amplitudes {
            let own = suffix(&key);
            let Some(key) = order.key(&key) else { continue };
            let is_of_law = whole.amplitudes.contains_key(&key) && order.order < FIRST_FURTHER;
            let of_law = Wave { effect: &whole.effect, suffix: suffix(&key) };
            let both = is_of_law.then(|| summed(&[of_law, Wave { effect: &effect, suffix: own }])).flatten();
            // Two parts may have a wave of one order: the larger one is told.
            let is_larger = |known: &Parameter| known.value > amplitude.value;
            if both.is_some() || !whole.amplitudes.get(&key).is_some_and(is_larger) {
                whole.amplitudes.insert(key, both.unwrap_or(amplitude));
            }
        }
        folded.push(effect.clone());
        whole.harmonics.push(Harmonic { order: order.order, effect, parameters });
    }
    causes.sort_by(|a, b| b.closes.total_cmp(&a.closes));
    folded
}

/// A cause that is a harmonic of another one, that one, and the order: the pair whose ratio is nearest to a whole number.
fn harmonic<'a>(causes: &'a [Cause]) -> Option<(usize, usize, Order)> {
    let group = |cause: &'a Cause| cause.group.as_deref().unwrap_or(&cause.effect);
    let pairs = (0..causes.len()).flat_map(|part| (0..causes.len()).map(move |whole| (part, whole)));
    // The pitch that its law has by itself stays, whatever it is a part of.
    let pairs = pairs.filter(|&(part, whole)| {
        part != whole && causes[part].group.is_some() && group(&causes[part]) == group(&causes[whole])
    });
    let orders = pairs.filter_map(|(part, whole)| {
        let least = if is_small(&causes[part], &causes[whole]) { WHOLE_IF_SMALL } else { WHOLE };
        let (order, off) = order(period(&causes[whole])?, period(&causes[part])?, least, 1)
            .or_else(|| doubled(&causes[whole], &causes[part], least))?;
        Some((part, whole, order, off))
    });
    let nearest = orders.min_by(|a, b| a.3.total_cmp(&b.3));
    nearest.map(|(part, whole, order, _)| (part, whole, order))
}

fn period(cause: &Cause) -> Option<&Parameter> {
    cause.parameters.iter().find(|(key, _)| key.starts_with("period_")).map(|(_, parameter)| parameter)
}

fn is_small(part: &Cause, whole: &Cause) -> bool {
    let largest = |cause: &Cause| cause.amplitudes.values().map(|a| a.value.abs()).fold(0.0, f64::max);
    largest(part) < SMALL * largest(whole)
}

/// Which wave of a part, its first or its second one, is a harmonic of the whole, and of which order.
#[derive(Clone, Copy)]
struct Order {
    wave: u32,
    order: u32,
}

impl Order {
    /// A part's `amplitude_n` and `amplitude_2_n` as amplitudes of the whole: of a third harmonic `amplitude_3_n` and `amplitude_6_n`, without
    /// the unit where they have none. None of the first wave where only the second one is a harmonic.
    fn key(self, key: &str) -> Option<String> {
        let suffix = suffix(key);
        match (suffix.strip_prefix("_2"), self.wave) {
            (Some(unit), 1) => Some(format!("amplitude_{}{unit}", 2 * self.order)),
            (Some(unit), _) => Some(format!("amplitude_{}{unit}", self.order)),
            (None, 1) => Some(format!("amplitude_{}{suffix}", self.order)),
            (None, _) => None,
        }
    }
}

/// The order of a part by its second wave, where that is the larger one.
fn doubled(whole: &Cause, part: &Cause, least: f64) -> Option<(Order, f64)> {
    let size = |is_second: bool| {
        let own = part.amplitudes.iter().filter(|(key, _)| suffix(key).starts_with("_2") == is_second);
        own.map(|(_, amplitude)| amplitude.value).fold(0.0, f64::max)
    };
    if size(true) > size(false) { order(period(whole)?, period(part)?, least, 2) } else { None }
}

/// The order of a wave of a part of a whole and how far the ratio is off it, `least` being how far it may always be.
fn order(whole: &Parameter, part: &Parameter, least: f64, wave: u32) -> Option<(Order, f64)> {
    let share = |p: &Parameter| 0.5 * (p.ci95[1] - p.ci95[0]) / p.value;
    let ratio = f64::from(wave) * whole.value / part.value;
    let half = ratio * share(whole).hypot(share(part));
    let order = ratio.round();
    let off = (ratio - order).abs();
    let is_whole = off <= half.clamp(least, WIDEST.max(least));
    let order_of_wave = Order { wave, order: order as u32 };
    ((FIRST_ORDER..=LAST_ORDER).contains(&order) && is_whole).then_some((order_of_wave, off))
}

/// What a key has after `amplitude`.
fn suffix(key: &str) -> &str {
    key.strip_prefix("amplitude").unwrap_or(key)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn parameter(value: f64, half: f64) -> Parameter {
        Parameter { value, ci95: [value - half, value + half], unit: "m".to_owned(), twin: f64::NAN }
    }

    fn pitch(effect: &str, period: f64, closes: f64) -> Cause {
        let group = (effect != "cogging").then(|| "cogging".to_owned());
        Cause {
            effect: effect.to_owned(),
            group,
            site: "motor".to_owned(),
            probability: 1.0,
            closes,
            confusable_with: Vec::new(),
            confusable_reason: None,
            parameters: BTreeMap::from([("period_m".to_owned(), parameter(period, 1e-6 * period))]),
            amplitudes: ["amplitude_n", "amplitude_2_n"]
                .map(|key| (key.to_owned(), parameter(closes, 0.0)))
                .into(),
            phases: Vec::new(),
            harmonics: Vec::new(),
        }
    }

    fn fold(causes: &mut Vec<Cause>) -> Vec<String> {
        super::fold(causes, &|_| None)
    }

    /// Half a pitch beside the pitch: its first wave and the second harmonic are one, its second wave is the fourth.
    #[test]
    fn exact_half_a_pitch_is_its_second_and_fourth_harmonic() {
        let mut causes = vec![pitch("cogging", 0.024, 0.9), pitch("second_cogging", 0.012, 0.02)];
        let both = |waves: &[Wave]| {
            let pairs: Vec<(&str, &str)> = waves.iter().map(|wave| (wave.effect, wave.suffix)).collect();
            assert_eq!(pairs, [("cogging", "_2_n"), ("second_cogging", "_n")]);
            Some(parameter(0.5, 0.1))
        };
        assert_eq!(super::fold(&mut causes, &both), ["second_cogging"]);
        let sizes: Vec<(&str, f64)> =
            causes[0].amplitudes.iter().map(|(key, a)| (key.as_str(), a.value)).collect();
        assert_eq!(sizes, [("amplitude_2_n", 0.5), ("amplitude_4_n", 0.02), ("amplitude_n", 0.9)]);
    }

    /// Two thirds of a pitch, of which the second wave is the larger one: that is the third harmonic. Where the first one is larger it is a pitch of
    /// its own.
    #[test]
    fn exact_the_larger_wave_is_the_harmonic() {
        let folded = |second: f64| {
            let mut part = pitch("second_cogging", 0.016, 0.02);
            part.amplitudes.insert("amplitude_2_n".to_owned(), parameter(second, 0.0));
            let mut causes = vec![pitch("cogging", 0.024, 0.9), part];
            let folded = fold(&mut causes);
            (folded, causes.remove(0).amplitudes)
        };
        let (effects, amplitudes) = folded(0.05);
        assert_eq!(effects, ["second_cogging"]);
        let keys: Vec<&String> = amplitudes.keys().collect();
        assert_eq!(keys, ["amplitude_2_n", "amplitude_3_n", "amplitude_n"]);
        assert!((amplitudes["amplitude_3_n"].value - 0.05).abs() < 1e-15);
        assert!(folded(0.01).0.is_empty());
    }

    #[test]
    fn exact_amplitudes_of_a_harmonic_are_those_of_the_whole() {
        let keys = ["amplitude_n", "amplitude_2_n", "amplitude", "amplitude_2"]
            .map(|key| Order { wave: 1, order: 3 }.key(key).unwrap());
        assert_eq!(keys, ["amplitude_3_n", "amplitude_6_n", "amplitude_3", "amplitude_6"]);
    }

    #[test]
    fn exact_a_third_of_a_pitch_is_its_third_harmonic() {
        let mut causes = vec![
            pitch("cogging", 0.024, 0.9),
            pitch("second_cogging", 0.008_002, 0.06),
            pitch("third_cogging", 0.0171, 0.02),
        ];
        assert_eq!(fold(&mut causes), ["second_cogging"]);
        let [whole, other] = &causes[..] else { panic!("{causes:?}") };
        assert_eq!((&*other.effect, whole.closes, whole.harmonics.len()), ("third_cogging", 0.96, 1));
        assert_eq!((whole.harmonics[0].order, &*whole.harmonics[0].effect), (3, "second_cogging"));
        assert_eq!(
            whole.amplitudes.keys().collect::<Vec<_>>(),
            ["amplitude_2_n", "amplitude_3_n", "amplitude_6_n", "amplitude_n"]
        );
        let settings: Vec<String> = whole.settings().map(|(path, _)| path).collect();
        assert_eq!(settings, ["effect.cogging.period_m", "effect.second_cogging.period_m"]);
    }

    #[test]
    fn exact_a_pitch_of_its_own_stays_one() {
        for period in [0.0124, 0.0078, 0.0171, 0.036] {
            let mut causes = vec![pitch("cogging", 0.024, 0.9), pitch("second_cogging", period, 0.3)];
            assert!(fold(&mut causes).is_empty() && causes.len() == 2, "{period}");
        }
        // The third part of the second pitch is its harmonic, not the first one's.
        let mut causes = vec![
            pitch("cogging", 0.0164, 0.9),
            pitch("second_cogging", 0.0199, 0.06),
            pitch("third_cogging", 0.0199 / 3.0, 0.02),
        ];
        assert_eq!(fold(&mut causes), ["third_cogging"]);
        assert_eq!(causes[1].harmonics[0].order, 3);
        // A small wave that is near a fifth part of the one and is the sixth part of the other.
        let mut causes = vec![
            pitch("cogging", 0.0164, 0.9),
            pitch("second_cogging", 0.0199, 0.5),
            pitch("third_cogging", 0.0199 / 6.0, 0.02),
        ];
        fold(&mut causes);
        assert_eq!((&*causes[1].effect, causes[1].harmonics[0].order), ("second_cogging", 6));
        // A small wave is pulled aside; a large one that is as far off has a pitch of its own.
        let folded = |amplitude: f64| {
            let mut part = pitch("second_cogging", 0.0164 / 3.06, 0.01);
            part.amplitudes.values_mut().for_each(|a| a.value = amplitude);
            fold(&mut vec![pitch("cogging", 0.0164, 0.9), part]).len()
        };
        assert_eq!([folded(0.05), folded(0.5)], [1, 0]);
        // Without the pitch that it would be a harmonic of.
        assert!(fold(&mut vec![pitch("second_cogging", 0.008, 0.06)]).is_empty());
    }
}
