//! Which name stands for which hidden effect.

use crate::diagnose::verdict::{Cause, Verdict};
use crate::trial::truth::HiddenEffect;
use crate::trial::verdict::Said;
use serde::Serialize;

/// Explanations of an undecided verdict that count as one group, as shares of the probability of the first.
const GROUP: f64 = 0.05;

/// What a name stands for, the closest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// It is the name of a hidden effect.
    Itself,
    /// It is the name of an effect that nobody could tell from a hidden one on these runs.
    Equal,
    /// It is reported in a group, and a member of the group is hidden.
    Group,
    /// In the tier of changes: it stands for what is hidden before and after alike.
    Before,
    /// It stands for nothing that is hidden: an extra name.
    Extra,
}

/// A name at its place: a named cause, or an effect that is only probable.
struct Place<'a> {
    name: &'a str,
    cause: Option<&'a Cause>,
    /// Not a cause itself, but in the group of one.
    is_in_group: bool,
}

impl Place<'_> {
    /// How the name stands for a hidden effect; none where it does not.
    ///
    /// A group is what a cause reports as `confusable_with`. In an undecided verdict it is also any explanation without the
    /// cause that is at least a twentieth as probable as the first.
    fn standing_for(&self, hidden: &HiddenEffect, said: &Said) -> Option<Standing> {
        if self.name == hidden.effect.name() {
            return Some(Standing::Itself);
        }
        if hidden.is_called(self.name) {
            return Some(Standing::Equal);
        }
        let reported = self.cause?.confusable_with.iter().any(|other| hidden.is_called(other));
        (reported || self.is_undecided(hidden, said)).then_some(Standing::Group)
    }

    fn is_undecided(&self, hidden: &HiddenEffect, said: &Said) -> bool {
        let first = said.ranking().first().map_or(0.0, |explanation| explanation.probability);
        said.verdict() == Some(Verdict::Undecided)
            && said.ranking().iter().any(|explanation| {
                explanation.probability >= GROUP * first
                    && explanation.effects.iter().any(|effect| hidden.is_called(effect))
                    && !explanation.effects.iter().any(|effect| effect == self.name)
            })
    }
}

/// The names of one verdict, each with what it stands for.
pub(super) struct Naming<'a> {
    places: Vec<Place<'a>>,
    /// Place by place.
    standings: Vec<Standing>,
    /// By hidden effect: the place that is its own, and how it is named there if it is a cause.
    own: Vec<Option<usize>>,
    named_as: Vec<Option<Standing>>,
}

impl<'a> Naming<'a> {
    /// Sets names against hidden effects; the first of these have the first choice.
    ///
    /// # Model
    /// The places are the named causes, most closing first, then the other effects by probability. One cause names one hidden
    /// effect: the assignment is one that leaves the fewest without a cause. A hidden effect without a cause has the place
    /// of its name, or of an equal's, among the probable effects.
    pub(super) fn of(hidden: &[&HiddenEffect], before: &[HiddenEffect], said: &'a Said) -> Self {
        let places = places(said);
        let causes = said.causes().len();
        let standings = places.iter().map(|place| standing(place, hidden, before, said)).collect();
        let stands = |h: &&HiddenEffect, from: usize, to: usize| -> Vec<usize> {
            (from..to).filter(|&p| places[p].standing_for(h, said).is_some()).collect()
        };
        let edges: Vec<Vec<usize>> = hidden.iter().map(|h| stands(h, 0, causes)).collect();
        let named = assignment(&edges, causes);
        let closest =
            |h: &&HiddenEffect| places[..causes].iter().filter_map(|place| place.standing_for(h, said)).min();
        let named_as = hidden.iter().zip(&named).map(|(h, named)| named.and_then(|_| closest(h))).collect();
        let probable = |h: &&HiddenEffect| stands(h, causes, places.len()).first().copied();
        let own = hidden.iter().zip(named).map(|(h, named)| named.or_else(|| probable(h))).collect();
        Self { places, standings, own, named_as }
    }

    /// How a hidden effect is named; none where it is not.
    pub(super) fn named_as(&self, hidden: usize) -> Option<Standing> {
        self.named_as.get(hidden).copied().flatten()
    }

    /// How many wrong names stand before the place of a hidden effect; none where it has no place.
    pub(super) fn wrong_before(&self, hidden: usize) -> Option<usize> {
        let place = self.own.get(hidden).copied().flatten()?;
        let before = self.places.iter().zip(&self.standings).take(place);
        Some(before.filter(|(place, standing)| **standing == Standing::Extra && !place.is_in_group).count())
    }

    /// The named causes, each with what it stands for.
    pub(super) fn causes(&self) -> impl Iterator<Item = (&'a Cause, Standing)> {
        self.places
            .iter()
            .zip(&self.standings)
            .filter_map(|(place, standing)| Some((place.cause?, *standing)))
    }
}

fn places(said: &Said) -> Vec<Place<'_>> {
    let causes = said.causes().iter();
    let causes = causes.map(|cause| Place { name: &cause.effect, cause: Some(cause), is_in_group: false });
    let rest = said.effects().iter().filter(|e| said.causes().iter().all(|cause| cause.effect != e.effect));
    let rest = rest.map(|e| Place {
        name: &e.effect,
        cause: None,
        is_in_group: said.causes().iter().any(|cause| cause.covers(&e.effect)),
    });
    causes.chain(rest).collect()
}

fn standing(place: &Place, hidden: &[&HiddenEffect], before: &[HiddenEffect], said: &Said) -> Standing {
    let closest = hidden.iter().filter_map(|h| place.standing_for(h, said)).min();
    let is_before = || before.iter().any(|h| place.standing_for(h, said).is_some());
    closest.unwrap_or_else(|| if is_before() { Standing::Before } else { Standing::Extra })
}

/// One place each for as many as possible, by augmenting paths; `edges` are the places that each could have.
fn assignment(edges: &[Vec<usize>], places: usize) -> Vec<Option<usize>> {
    let mut owners: Vec<Option<usize>> = vec![None; places];
    for seeker in 0..edges.len() {
        settle(seeker, edges, &mut owners, &mut vec![false; places]);
    }
    let of = |seeker| owners.iter().position(|owner| *owner == Some(seeker));
    (0..edges.len()).map(of).collect()
}

fn settle(seeker: usize, edges: &[Vec<usize>], owners: &mut [Option<usize>], seen: &mut [bool]) -> bool {
    for &place in &edges[seeker] {
        if seen[place] {
            continue;
        }
        seen[place] = true;
        if owners[place].is_none_or(|owner| settle(owner, edges, owners, seen)) {
            owners[place] = Some(seeker);
            return true;
        }
    }
    false
}
