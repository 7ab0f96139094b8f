//! The macro that turns the catalogue's lines into types.

/// From lines `id: Struct` makes [`EffectId`](super::EffectId), [`Effect`](super::Effect) and the
/// machine file's table [`Effects`](super::Effects).
macro_rules! catalogue {
    ($($id:ident : $law:ident),+ $(,)?) => {
        /// Names the effects of the catalogue.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum EffectId {
            $(#[doc = concat!("`", stringify!($id), "`, see [`", stringify!($law), "`].")] $law,)+
        }

        impl EffectId {
            /// Every effect of the catalogue, in signal-path order.
            pub const ALL: &'static [Self] = &[$(Self::$law),+];

            /// The id used in machine files, reports and JSON.
            pub fn name(self) -> &'static str {
                match self { $(Self::$law => stringify!($id),)+ }
            }

            /// Where on the signal path the effect sits.
            pub fn site(self) -> Site {
                match self { $(Self::$law => <$law as Law>::SITE,)+ }
            }

            /// The effect's parameters, in the order in which a fit handles them.
            pub fn parameters(self) -> &'static [Parameter] {
                match self { $(Self::$law => <$law as Law>::PARAMETERS,)+ }
            }

            /// The effects whose say this one takes over where both are present.
            pub fn supersedes(self) -> &'static [EffectId] {
                match self { $(Self::$law => <$law as Law>::SUPERSEDES,)+ }
            }

            /// See [`Law::CUMULATIVE`].
            pub fn is_cumulative(self) -> bool {
                match self { $(Self::$law => <$law as Law>::CUMULATIVE,)+ }
            }

            /// What the effect is, in a phrase.
            pub fn phrase(self) -> &'static str {
                match self { $(Self::$law => <$law as Law>::PHRASE,)+ }
            }

            /// Values of the parameters that leave the twin as its constants state it.
            pub fn neutral(self, constants: &Constants) -> Vec<f64> {
                match self { $(Self::$law => <$law as Law>::neutral(constants),)+ }
            }

            /// Starting values of a fit, one set or several, from what screening found.
            pub fn start(self, screen: &Screen) -> Vec<Vec<f64>> {
                match self { $(Self::$law => <$law as Law>::start(screen),)+ }
            }

            /// The range in which a fit may look for each parameter.
            pub fn range(self, screen: &Screen) -> Vec<(f64, f64)> {
                match self { $(Self::$law => <$law as Law>::range(screen),)+ }
            }
        }

        /// One effect with its parameters.
        #[derive(Debug, Clone, PartialEq)]
        pub enum Effect {
            $(#[doc = concat!("`", stringify!($id), "`")] $law($law),)+
        }

        impl Effect {
            /// Which effect it is.
            pub fn id(&self) -> EffectId {
                match self { $(Self::$law(_) => EffectId::$law,)+ }
            }

            /// See [`Law::alter`].
            pub fn alter(&self, constants: &mut Constants) {
                match self { $(Self::$law(law) => law.alter(constants),)+ }
            }

            /// See [`Law::resistance`].
            #[inline]
            pub fn resistance(&self, direction: f64, speed: f64) -> f64 {
                match self { $(Self::$law(law) => law.resistance(direction, speed),)+ }
            }

            /// See [`Law::push`].
            #[inline]
            pub fn push(&self, position: f64, velocity: f64) -> f64 {
                match self { $(Self::$law(law) => law.push(position, velocity),)+ }
            }

            /// Whether the law has a resistance, and whether it has a push.
            pub fn acts(&self) -> (bool, bool) {
                match self { $(Self::$law(_) => (<$law as Law>::RESISTS, <$law as Law>::PUSHES),)+ }
            }
        }

        /// The effects that a machine file states, a table per effect.
        #[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct Effects {
            $(
                #[doc = concat!("Parameters of `", stringify!($id), "`, if present.")]
                #[serde(default, skip_serializing_if = "Option::is_none")]
                pub $id: Option<$law>,
            )+
        }

        impl Effects {
            /// The effects that act: those present and not superseded by another one present.
            pub fn acting(&self) -> Vec<Effect> {
                let mut present: Vec<Effect> = Vec::new();
                $(if let Some(law) = &self.$id { present.push(Effect::$law(law.clone())); })+
                let superseded: Vec<EffectId> =
                    present.iter().flat_map(|e| e.id().supersedes()).copied().collect();
                present.retain(|effect| !superseded.contains(&effect.id()));
                present
            }

            /// Whether the effect is stated.
            pub fn contains(&self, id: EffectId) -> bool {
                match id { $(EffectId::$law => self.$id.is_some(),)+ }
            }

            /// The first fault of any effect's parameters, as key path and sentence.
            pub fn fault(&self) -> Option<(String, String)> {
                $(if let Some(fault) = self.$id.as_ref().and_then(Law::fault) {
                    return Some((format!("effect.{}", stringify!($id)), fault));
                })+
                None
            }
        }
    };
}

pub(super) use catalogue;
