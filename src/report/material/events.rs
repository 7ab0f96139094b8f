//! What the axis was told to do: when it starts, cruises, stops, turns.

/// A moment of the commanded motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// When, in s.
    pub time_s: f64,
    /// What.
    pub word: &'static str,
}

/// Below this share of the largest commanded speed the axis is told to stand.
const STILL: f64 = 1e-3;
/// It cruises where its speed changes by less than this share of its steepest change.
const CRUISES: f64 = 0.05;
/// Samples over which a change is looked at.
const STRIDE: usize = 4;
/// A stop that is shorter is a reversal, in s.
const STOPS_S: f64 = 0.02;
/// More moments than this are none of a stroke: a reference that never rests is not marked.
const MOST: usize = 60;

/// Moments of a sampled position reference.
pub fn events(reference: &[f64], period_s: f64) -> Vec<Event> {
    let steps: Vec<f64> = reference.windows(2).map(|w| (w[1] - w[0]) / period_s).collect();
    let most = steps.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    if most <= 0.0 {
        return Vec::new();
    }
    let change = |k: usize| (steps[k] - steps[k.saturating_sub(STRIDE)]).abs();
    let steepest = (0..steps.len()).map(change).fold(0.0, f64::max);
    let mut list = Vec::new();
    let mut push = |sample: usize, word| list.push(Event { time_s: sample as f64 * period_s, word });
    let mut is_moving = false;
    let mut is_cruising = false;
    for (k, v) in steps.iter().enumerate() {
        let moves = v.abs() > STILL * most;
        // A peak of speed is flat for a sample or two; a cruise lasts.
        let ahead = if is_cruising { k + 1 } else { (k + 2 * STRIDE).min(steps.len()) };
        let cruises = moves && (k..ahead).all(|j| change(j) < CRUISES * steepest);
        let turns = k > 0 && steps[k - 1] * v < 0.0;
        match (is_moving, moves) {
            (false, true) => push(k, "start"),
            (true, false) => push(k, "stop"),
            (true, true) if turns => push(k, "reversal"),
            _ => {}
        }
        if cruises && !is_cruising {
            push(k, "cruise");
        } else if !cruises && is_cruising && moves && !turns {
            push(k, "brake");
        }
        (is_moving, is_cruising) = (moves, cruises);
    }
    let list = reversals(list);
    if list.len() > MOST { Vec::new() } else { list }
}

/// Stops that a start follows at once, made one moment.
fn reversals(list: Vec<Event>) -> Vec<Event> {
    let mut merged: Vec<Event> = Vec::new();
    for event in list {
        match merged.last_mut() {
            Some(last)
                if last.word == "stop" && event.word == "start" && event.time_s - last.time_s < STOPS_S =>
            {
                last.word = "reversal";
            }
            _ => merged.push(event),
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_trapezoid_has_four_moments() {
        // 100 samples at rest, 50 faster, 100 even, 50 slower, 100 at rest.
        let speed = |k: usize| match k {
            100..150 => (k - 99) as f64 / 50.0,
            150..250 => 1.0,
            250..300 => (300 - k) as f64 / 50.0,
            _ => 0.0,
        };
        let mut at = 0.0;
        let reference: Vec<f64> = (0..400)
            .map(|k| {
                at += 1e-3 * speed(k);
                at
            })
            .collect();
        let words: Vec<&str> = events(&reference, 1e-3).iter().map(|e| e.word).collect();
        assert_eq!(words, ["start", "cruise", "brake", "stop"]);
    }

    #[test]
    fn exact_a_triangle_turns_and_never_cruises() {
        // Speed up for 500 samples, down through zero for 1000, up again to rest.
        let speed = |k: usize| match k {
            0..500 => k as f64,
            500..1500 => 1000.0 - k as f64,
            _ => k as f64 - 2000.0,
        };
        let mut at = 0.0;
        let reference: Vec<f64> = (0..2000)
            .map(|k| {
                at += 1e-6 * speed(k);
                at
            })
            .collect();
        let words: Vec<&str> = events(&reference, 1e-3).iter().map(|e| e.word).collect();
        assert!(words.contains(&"reversal") && !words.contains(&"cruise"), "{words:?}");
    }

    #[test]
    fn exact_a_reference_at_rest_has_none() {
        assert!(events(&[0.3; 50], 1e-3).is_empty() && events(&[], 1e-3).is_empty());
    }
}
