//! The macro that turns the catalogue's lines into types.

/// From lines `id: Struct` makes [`EffectId`](super::EffectId), [`Effect`](super::Effect) and the
/// machine file's table [`Effects`](super::Effects).
macro_rules! catalogue {
    ($($id:ident : $law:ident),+ $(,)?) => {
        /// Names the effects of the catalogue.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
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

            /// See [`Law::FURTHER`].
            pub fn further(self) -> &'static [Parameter] {
                match self { $(Self::$law => <$law as Law>::FURTHER,)+ }
            }

            /// See [`Law::FORM`].
            pub fn form(self) -> &'static [FormNumber] {
                match self { $(Self::$law => <$law as Law>::FORM,)+ }
            }

            /// Its parameters, its further numbers and those of its form, one after the other.
            pub fn numbers(self) -> impl Iterator<Item = &'static Parameter> {
                let form = self.form().iter().map(|form| &form.parameter);
                self.parameters().iter().chain(self.further()).chain(form)
            }

            /// See [`Law::MODIFIES`].
            pub fn modifies(self) -> &'static [EffectId] {
                match self { $(Self::$law => <$law as Law>::MODIFIES,)+ }
            }

            /// See [`Law::FOLLOWS`].
            pub fn follows(self) -> bool {
                match self { $(Self::$law => <$law as Law>::FOLLOWS,)+ }
            }

            /// The effect with this id; none where the catalogue has none.
            pub fn named(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|effect| effect.name() == name)
            }

            /// Whether one of the effects that a feature modifies is there, or the effect is no feature (heredity).
            pub fn has_modified(self, is_there: impl Fn(EffectId) -> bool) -> bool {
                self.modifies().is_empty() || self.modifies().iter().any(|of| is_there(*of))
            }

            /// See [`Law::GROUP`].
            pub fn group(self) -> Option<&'static str> {
                match self { $(Self::$law => <$law as Law>::GROUP,)+ }
            }

            /// See [`Law::MAKES_NOISE`].
            pub fn makes_noise(self) -> bool {
                match self { $(Self::$law => <$law as Law>::MAKES_NOISE,)+ }
            }

            /// See [`Law::RARITY`].
            pub fn rarity(self) -> f64 {
                match self { $(Self::$law => <$law as Law>::RARITY,)+ }
            }

            /// What the effect is, in a phrase.
            pub fn phrase(self) -> &'static str {
                match self { $(Self::$law => <$law as Law>::PHRASE,)+ }
            }

            /// Whether a machine with these constants can have the effect at all.
            pub fn applies(self, constants: &Constants) -> bool {
                self.lacks(constants).is_none()
            }

            /// See [`Law::lacks`].
            pub fn lacks(self, constants: &Constants) -> Option<Lack> {
                match self { $(Self::$law => <$law as Law>::lacks(constants),)+ }
            }

            /// Whether a machine with these constants has nothing that the effect could change: it would do nothing.
            pub fn has_nothing_to_change(self, constants: &Constants) -> bool {
                self.lacks(constants).is_some_and(Lack::is_refused)
            }

            /// See [`Law::draw`].
            pub fn draw(self, machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
                match self { $(Self::$law => <$law as Law>::draw(machine, prior),)+ }
            }

            /// See [`Law::NOMINAL`].
            pub fn nominal(self) -> Option<Nominal> {
                match self { $(Self::$law => <$law as Law>::NOMINAL,)+ }
            }

            /// See [`Law::EQUATION`].
            pub fn equation(self) -> &'static str {
                match self { $(Self::$law => <$law as Law>::EQUATION,)+ }
            }

            /// See [`Law::SYMBOLS`].
            pub fn symbols(self) -> &'static [&'static str] {
                match self { $(Self::$law => <$law as Law>::SYMBOLS,)+ }
            }

            /// See [`Law::SOURCE`].
            pub fn source(self) -> &'static str {
                match self { $(Self::$law => <$law as Law>::SOURCE,)+ }
            }

            /// See [`Law::SHOWN_BY`].
            pub fn shown_by(self) -> &'static str {
                match self { $(Self::$law => <$law as Law>::SHOWN_BY,)+ }
            }

            /// See [`Law::EXAMPLE`].
            pub fn example(self) -> &'static [f64] {
                match self { $(Self::$law => <$law as Law>::EXAMPLE,)+ }
            }

            /// See [`Law::CONFUSABLE`].
            pub(super) fn confusable(self) -> &'static [Likeness] {
                match self { $(Self::$law => <$law as Law>::CONFUSABLE,)+ }
            }

            /// See [`Law::STRETCH`].
            pub fn stretch(self) -> Stretch {
                match self { $(Self::$law => <$law as Law>::STRETCH,)+ }
            }

            /// Values of the parameters that leave the twin as its constants state it.
            pub fn neutral(self, constants: &Constants) -> Vec<f64> {
                match self { $(Self::$law => <$law as Law>::neutral(constants),)+ }
            }
        }

        $(const _: () = assert!(
            <$law as Law>::EXAMPLE.len() == <$law as Law>::PARAMETERS.len()
                && <$law as Law>::SYMBOLS.len()
                    == <$law as Law>::PARAMETERS.len() + <$law as Law>::FURTHER.len() + <$law as Law>::FORM.len(),
            "an example has a value for each parameter, and an equation a symbol for each number"
        );)+

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

            /// See [`Law::push_wave`].
            pub fn push_wave(&self) -> Option<Wave> {
                match self { $(Self::$law(law) => law.push_wave(),)+ }
            }

            /// See [`Law::push`].
            #[inline]
            pub fn push(&self, position: f64, velocity: f64) -> f64 {
                match self { $(Self::$law(law) => law.push(position, velocity),)+ }
            }

            /// See [`Law::shake`].
            #[inline]
            pub fn shake(&self, time_s: f64) -> f64 {
                match self { $(Self::$law(law) => law.shake(time_s),)+ }
            }

            /// See [`Law::motor_change`].
            #[inline]
            pub fn motor_change(&self, position: f64, force: f64) -> f64 {
                match self { $(Self::$law(law) => law.motor_change(position, force),)+ }
            }

            /// See [`Law::stops`].
            #[inline]
            pub fn stops(&self, stops: [f64; 2]) -> [f64; 2] {
                match self { $(Self::$law(law) => law.stops(stops),)+ }
            }

            /// See [`Law::carried`].
            pub fn carried(&self) -> f64 {
                match self { $(Self::$law(law) => law.carried(),)+ }
            }

            /// See [`Law::initial_share`].
            pub fn initial_share(&self) -> f64 {
                match self { $(Self::$law(law) => law.initial_share(),)+ }
            }

            /// See [`Law::read`].
            #[inline]
            pub fn read(&self, position: f64) -> f64 {
                match self { $(Self::$law(law) => law.read(position),)+ }
            }

            /// See [`Law::unlike`].
            pub fn unlike(&self) -> Unlike {
                match self { $(Self::$law(law) => law.unlike(),)+ }
            }

            /// Whether the law acts through a door.
            pub fn acts_through(&self, door: Door) -> bool {
                match self { $(Self::$law(_) => <$law as Law>::DOORS.contains(&door),)+ }
            }
        }

        /// The effects that a machine file states, a table per effect.
        #[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct Effects {
            $(
                #[doc = concat!("Parameters of `", stringify!($id), "`, if present.")]
                #[serde(default, skip_serializing_if = "Option::is_none")]
                pub $id: Option<$law>,
            )+
        }

        impl Effects {
            /// The effects stated, in signal-path order.
            pub fn acting(&self) -> Vec<Effect> {
                let mut present: Vec<Effect> = Vec::new();
                $(if let Some(law) = &self.$id { present.push(Effect::$law(law.clone())); })+
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
