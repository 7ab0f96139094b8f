//! The gap shared out to the sites and segments of the signal path.

use super::place::{Share, Where};
use super::verdict::Cause;
use crate::effect::{EffectId, Site, Stretch};
use std::collections::BTreeMap;

/// Shares by site and by segment, which agree with each other: what a cause closes lies at its site and in the segment in which it acts,
/// and what stays open lies in the segments in proportion to their measured residuals.
///
/// A segment of several sites says nothing about one of them: no logged signal separates them. What stays open in it is the share of the
/// whole block, by the segment's name, and its sites have a share of their own only where a cause was found.
pub fn attribute(place: &mut Where, causes: &[Cause], unexplained: f64) {
    let mut sites: BTreeMap<String, f64> = BTreeMap::new();
    let mut segments: Vec<f64> =
        place.segment.iter().map(|segment| unexplained.clamp(0.0, 1.0) * segment.share).collect();
    for (segment, open) in place.segment.iter().zip(&segments) {
        *sites.entry(segment.name.clone()).or_default() += open;
    }
    for cause in causes {
        let closes = cause.closes.max(0.0);
        *sites.entry(cause.site.clone()).or_default() += closes;
        if let Some(k) = segment_of(cause, &place.segment) {
            segments[k] += closes;
        }
    }
    let total: f64 = sites.values().sum();
    let share = |part: f64| if total > 0.0 { part / total } else { 0.0 };
    for (segment, part) in place.segment.iter_mut().zip(segments) {
        segment.share = share(part);
    }
    sites.retain(|name, part| *part > 0.0 || !name.contains('+'));
    let is_open = |site: Site| sites.keys().any(|name| name.contains('+') && holds(name, site));
    let nothing: Vec<Site> =
        Site::ALL.into_iter().filter(|site| !sites.contains_key(site.name()) && !is_open(*site)).collect();
    sites.extend(nothing.into_iter().map(|site| (site.name().to_owned(), 0.0)));
    place.site = sites.into_iter().map(|(name, part)| Share { name, share: share(part) }).collect();
    place.site.sort_by(|a, b| b.share.total_cmp(&a.share));
}

fn holds(segment: &str, site: Site) -> bool {
    segment.split('+').any(|name| name == site.name())
}

/// The segment in which a cause acts; none where it acts beside the path, or before the first signal that is known.
fn segment_of(cause: &Cause, segments: &[Share]) -> Option<usize> {
    let effect = EffectId::named(&cause.effect)?;
    let of = |site| segments.iter().enumerate().filter(move |(_, s)| holds(&s.name, site)).map(|(k, _)| k);
    match effect.stretch() {
        Stretch::Controller | Stretch::VelocityEstimate | Stretch::Rounding => of(Site::Controller).next(),
        Stretch::Drive => of(Site::Amplifier).next(),
        Stretch::MotorForce => of(Site::Motor).next_back(),
        // Between the two sensors and before the first one there is structure: it is where more is seen.
        Stretch::Mechanics if matches!(effect.site(), Site::Structure | Site::Sensor) => {
            of(effect.site()).max_by(|&a, &b| segments[a].share.total_cmp(&segments[b].share))
        }
        Stretch::Mechanics => of(Site::Guide).next(),
        Stretch::Log => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cause(effect: EffectId, closes: f64) -> Cause {
        let (effect, site) = (effect.name().to_owned(), effect.site().name().to_owned());
        let text = serde_json::json!({ "effect": effect, "site": site, "closes": closes });
        serde_json::from_value(text).unwrap()
    }

    fn place(segments: &[(&str, f64)]) -> Where {
        let share = |&(name, share): &(&str, f64)| Share { name: name.to_owned(), share };
        Where { segment: segments.iter().map(share).collect(), ..Where::default() }
    }

    fn shares(list: &[Share]) -> Vec<(&str, f64)> {
        list.iter().map(|s| (s.name.as_str(), (1e6 * s.share).round() / 1e6)).collect()
    }

    #[test]
    fn exact_what_no_signal_separates_is_one_block() {
        let mut open =
            place(&[("controller", 0.25), ("amplifier+motor", 0.0), ("guide+structure+sensor", 0.75)]);
        attribute(&mut open, &[], 1.0);
        let expected =
            [("guide+structure+sensor", 0.75), ("controller", 0.25), ("amplifier", 0.0), ("motor", 0.0)];
        assert_eq!(shares(&open.site), expected);
        let segments = [("controller", 0.25), ("amplifier+motor", 0.0), ("guide+structure+sensor", 0.75)];
        assert_eq!(shares(&open.segment), segments);
    }

    #[test]
    fn exact_a_cause_lies_at_its_site_and_in_its_segment() {
        // Replayed alone the mechanics show nothing beyond their noise; the cause in them closes most all the same.
        let mut found =
            place(&[("controller", 1.0), ("amplifier+motor", 0.0), ("guide+structure+sensor", 0.0)]);
        attribute(&mut found, &[cause(EffectId::CoulombFriction, 0.6), cause(EffectId::Cogging, 0.3)], 0.1);
        assert_eq!(shares(&found.site)[..3], [("guide", 0.6), ("motor", 0.3), ("controller", 0.1)]);
        let segments = [("controller", 0.1), ("amplifier+motor", 0.0), ("guide+structure+sensor", 0.9)];
        assert_eq!(shares(&found.segment), segments);
    }

    #[test]
    fn exact_shares_add_up_to_one() {
        let segments = [("controller+amplifier+motor+guide+structure+sensor", 1.0)];
        for unexplained in [0.0, 0.4, 1.0] {
            let mut all = place(&segments);
            attribute(&mut all, &[cause(EffectId::LoopDelay, 0.5)], unexplained);
            for list in [&all.site, &all.segment] {
                assert!((list.iter().map(|s| s.share).sum::<f64>() - 1.0).abs() < 1e-12, "{list:?}");
            }
            assert_eq!(all.site.iter().any(|s| s.name == "guide"), unexplained == 0.0);
        }
        let mut nothing = place(&[]);
        attribute(&mut nothing, &[], 0.0);
        assert!(nothing.site.len() == Site::ALL.len() && nothing.site.iter().all(|s| s.share == 0.0));
    }
}
