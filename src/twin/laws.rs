//! The laws that act along the signal path while the twin runs.

use super::current::CurrentWithin;
use super::slides::SlidingStep;
use crate::effect::{Door, Effect, Wave, motor_factor};
use crate::guide::stick_slip::{friction, friction_at_first};
use crate::guide::{Coast, DryFriction, GAUSS, Sliding, StepEquation, StepForce};
use crate::machine::Machine;
use crate::plant::LoadFriction;
use crate::sensor::End;
use crate::solid::Weight;

/// Fixed-point steps with which a reading is traced back to a position.
pub(super) const MOST_INVERSIONS: usize = 12;

/// Where and when a step of the plant begins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Here {
    /// Position of the moving part.
    pub position: f64,
    /// Length of the step.
    pub step_s: f64,
    /// Time of the session.
    pub clock_s: f64,
}

/// Laws that act along the path while the twin runs, by the door through which they do.
#[derive(Debug, Clone)]
pub(super) struct Laws {
    /// Dry friction of the guide.
    dry: DryFriction,
    /// Its level at rest in the positive and the negative direction, without the part of the load.
    constant: [f64; 2],
    /// Drag in N·s/m or N·m·s/rad that the positive direction has more than the mean of both.
    drag: f64,
    /// Forces that repeat along the axis.
    waves: Vec<Wave>,
    /// Other forces of position and velocity.
    pushes: Vec<Effect>,
    shakes: Vec<Effect>,
    /// Laws that change the motor's force.
    changes: Vec<Effect>,
    transmissions: Vec<Effect>,
    /// Share of the motor's travel by which the load is carried along inside a play.
    carried: f64,
    /// Where between its stops the load lies where a run begins, from −1 (at the front one) to 1 (at the rear one).
    initial_share: f64,
    readings: Vec<Effect>,
    /// Weight along the joint, where there is any and the plant does not have it in itself.
    weight: Option<Weight>,
    loaded: Option<LoadFriction>,
}

/// Dry friction over a step: known, or that of bristles whose displacement is to be found.
#[derive(Debug, Clone, Copy)]
pub(super) enum Resistance {
    /// The friction; the bristles' force stays as it is.
    Known(StepForce),
    /// The equation for the displacement.
    Bristles(StepEquation),
}

impl Resistance {
    /// The friction, and the bristles' force at the end of the step, which was `bristle_force` at its beginning.
    #[inline]
    pub fn resolved(&self, bristle_force: f64) -> (StepForce, f64) {
        match self {
            Self::Known(force) => (*force, bristle_force),
            Self::Bristles(equation) => equation.solve(),
        }
    }
}

/// Forces along the joint where a replay begins, in N or N·m, positive in the joint's positive direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InitialForces {
    /// The motor's force, in proportion to its current.
    pub motor: f64,
    /// Weight along the joint.
    pub weight: f64,
    /// m·a + c·v, where the acceleration is known.
    pub inertial: Option<f64>,
}

impl Laws {
    /// The machine's laws; those that a plant which `carries_weight` does not need left out.
    pub fn of(machine: &Machine, carries_weight: bool) -> Self {
        let acting = machine.effects();
        let through = |door| acting.iter().filter(|e| e.acts_through(door)).cloned().collect::<Vec<_>>();
        let constants = machine.constants();
        let dry = constants.friction;
        Self {
            dry,
            constant: [1.0, -1.0].map(|direction| dry.level(direction, 0.0)),
            drag: dry.drag(constants.viscous),
            waves: through(Door::Push).iter().filter_map(Effect::push_wave).collect(),
            pushes: through(Door::Push).into_iter().filter(|e| e.push_wave().is_none()).collect(),
            shakes: through(Door::Shake),
            changes: through(Door::MotorForce),
            transmissions: through(Door::Transmission),
            carried: acting.iter().map(Effect::carried).fold(0.0, f64::max),
            initial_share: acting.iter().map(Effect::initial_share).sum(),
            readings: through(Door::Reading),
            weight: machine.weight().filter(|_| !carries_weight),
            loaded: LoadFriction::of(machine),
        }
    }

    /// Dry friction in the positive and the negative direction, where nothing else acts on the guide.
    pub fn constant_friction(&self) -> Option<[f64; 2]> {
        let alone = [&self.pushes, &self.shakes, &self.changes].iter().all(|laws| laws.is_empty())
            && self.waves.is_empty()
            && !self.varies()
            && !self.dry.has_place_or_time()
            && self.dry.bristle.is_none()
            && self.loaded.is_none()
            && self.weight.is_none();
        alone.then_some(self.constant)
    }

    /// Whether what opposes motion beside the mean drag depends on speed.
    fn varies(&self) -> bool {
        self.dry.varies() || self.drag != 0.0
    }

    /// Whether sensors show the motor's position as it is, and its force is in proportion to the current.
    pub fn shows_position(&self) -> bool {
        self.readings.is_empty() && self.transmissions.is_empty() && self.changes.is_empty()
    }

    /// What laws that change the motor's force add to it over a step, in N or N·m.
    ///
    /// `others` is the sum of the other forces over the step before, in N or N·m, this change included. It stands for that of the present step. `within` tells the motor's force at
    /// the [`GAUSS`] points of the step.
    #[inline(always)]
    pub fn motor_change_over(
        &self,
        coast: Coast,
        here: Here,
        others: f64,
        within: &[CurrentWithin; 2],
    ) -> StepForce {
        if self.changes.is_empty() {
            StepForce::ZERO
        } else {
            self.some_motor_change(coast, here, others, within)
        }
    }

    /// Forces that repeat along the axis.
    pub fn waves(&self) -> &[Wave] {
        &self.waves
    }

    /// What forces of position, velocity and time exert over a step; `waves` are those that repeat along the axis at the [`GAUSS`] points, where they are known.
    #[inline(always)]
    pub fn push_over(&self, coast: Coast, here: Here, waves: Option<[f64; 2]>) -> StepForce {
        if self.waves.is_empty() && self.pushes.is_empty() && self.shakes.is_empty() {
            StepForce::ZERO
        } else {
            self.some_push(coast, here, waves)
        }
    }

    // Both are taken at two points of the step.

    #[inline(never)]
    fn some_motor_change(
        &self,
        coast: Coast,
        here: Here,
        others: f64,
        within: &[CurrentWithin; 2],
    ) -> StepForce {
        let [begin_n, end_n] = coast.motor_force;
        let faster = coast.free_velocity - coast.velocity;
        let pushed = coast.under(StepForce::held(others));
        let at = |point: usize| {
            let current = &within[point];
            let motor_n = begin_n
                + current.changed * (end_n - begin_n)
                + current.bow * faster
                + current.by_velocity * (pushed.free_velocity - coast.free_velocity);
            let place = here.position + pushed.free_travel_until(GAUSS[point], here.step_s);
            motor_n * (self.motor_factor(place, motor_n) - 1.0)
        };
        StepForce::at_gauss(at(0), at(1))
    }

    // As they would be without friction.
    #[inline(never)]
    fn some_push(&self, coast: Coast, here: Here, waves: Option<[f64; 2]>) -> StepForce {
        let Here { position, step_s, clock_s } = here;
        let at = |point: usize| -> f64 {
            let share = GAUSS[point];
            let place = position + coast.free_travel_until(share, step_s);
            let velocity = coast.velocity + share * (coast.free_velocity - coast.velocity);
            let waves = waves
                .map_or_else(|| self.waves.iter().map(|wave| wave.at(place)).sum(), |known| known[point]);
            let pushed =
                self.pushes.iter().fold(waves, |sum: f64, effect| sum + effect.push(place, velocity));
            let time_s = clock_s + share * step_s;
            pushed + self.shakes.iter().map(|effect| effect.shake(time_s)).sum::<f64>()
        };
        StepForce::at_gauss(at(0), at(1))
    }

    /// Levels of friction in proportion to a load in the positive and the negative direction, from those of that friction, where there is any.
    #[inline(always)]
    pub fn loaded(&self, levels: impl FnMut(&LoadFriction) -> [f64; 2]) -> [f64; 2] {
        self.loaded.as_ref().map_or([0.0; 2], levels)
    }

    /// Weight and dry friction over a step, see [`friction`](Self::friction).
    #[inline(always)]
    pub fn weight_and_friction(
        &self,
        coast: Coast,
        here: Here,
        bristle_force: f64,
        loaded: [f64; 2],
    ) -> (StepForce, Resistance) {
        match &self.weight {
            None => (StepForce::ZERO, self.friction(coast, here, bristle_force, loaded)),
            Some(weight) if weight.is_constant() => {
                let pull = StepForce::held(weight.effort(here.position));
                (pull, self.friction(coast.under(pull), here, bristle_force, loaded))
            }
            Some(weight) => self.under_weight(weight, coast, here, bristle_force, loaded),
        }
    }

    /// Whether weight and dry friction are among those that several twins take [together](super::slides): friction that depends on speed or weight that depends on position (others
    /// cost less one by one), no bristles, and friction that does not depend on the way that weight makes of the step.
    pub fn may_slide(&self) -> bool {
        let weight_varies = self.weight.is_some_and(|weight| !weight.is_constant());
        self.dry.bristle.is_none()
            && (self.dry.varies() || weight_varies)
            && !(weight_varies && self.dry.has_place_or_time())
    }

    /// What weight and dry friction of a step depend on, of laws that [may slide](Self::may_slide).
    #[inline(always)]
    pub fn sliding(&self, coast: Coast, here: Here, loaded: [f64; 2]) -> SlidingStep {
        let Here { position, step_s, clock_s } = here;
        let middle = || {
            let pull = self.weight.map_or(0.0, |weight| weight.effort(position));
            let way = coast.under(StepForce::held(pull)).free_travel;
            [position + 0.5 * way, clock_s + 0.5 * step_s]
        };
        SlidingStep {
            coast,
            position,
            weight: self.weight.map_or([0.0; 3], |weight| weight.numbers()),
            constant: self.constant,
            level: self.dry.level_over(loaded, self.dry.has_place_or_time().then(middle)),
            drag: self.drag,
        }
    }

    /// Weight and dry friction over a step where the weight depends on position, in N or N·m, positive in the joint's positive direction.
    ///
    /// # Model
    /// The weight is taken at two points of the way that the step makes under the weight and the friction F₁ of its beginning, held. The way without friction is known to third
    /// order in the step h.
    ///
    /// # Validity
    /// Friction that changes by ΔF over the step moves that way by up to h²·ΔF/2m, and the weight by its slope times that: with m·ω² for the slope 2·10⁻⁵ of ΔF at ω = 7 rad/s and h = 1 ms.
    /// Without friction period and energy are exact to 10⁻⁹ (`cargo test --release --test plants gravity`).
    #[inline(always)]
    fn under_weight(
        &self,
        weight: &Weight,
        coast: Coast,
        here: Here,
        bristle_force: f64,
        loaded: [f64; 2],
    ) -> (StepForce, Resistance) {
        let near = weight.near(here.position);
        let pull = |coast: Coast| coast.force_over(0.0, here.step_s, near);
        let falling = coast.under(pull(coast));
        let held = match &self.dry.bristle {
            Some(_) => bristle_force,
            None => friction_at_first(falling, here.step_s, self.constant),
        };
        let pull = pull(falling.under(StepForce::held(held)));
        (pull, self.friction(coast.under(pull), here, bristle_force, loaded))
    }

    /// Dry friction of the guide over a step, from the bristles' force at its beginning.
    ///
    /// `loaded` are the levels of friction in proportion to a load, see [`loaded`](Self::loaded). A level that depends on place or time is
    /// taken in the middle of the step.
    #[inline(always)]
    pub fn friction(&self, coast: Coast, here: Here, bristle_force: f64, loaded: [f64; 2]) -> Resistance {
        let Here { position, step_s, clock_s } = here;
        let varies = self.varies();
        let has_place_or_time = self.dry.has_place_or_time();
        if self.loaded.is_none() && !has_place_or_time && self.dry.bristle.is_none() && !varies {
            if self.constant == [0.0; 2] {
                return Resistance::Known(StepForce::ZERO);
            }
            let level = |direction, _| of_direction(self.constant, direction);
            return Resistance::Known(friction(coast, step_s, level));
        }
        let middle = [position + 0.5 * coast.free_travel, clock_s + 0.5 * step_s];
        let level = self.dry.level_over(loaded, has_place_or_time.then_some(middle));
        let at_rest = level.at_rest();
        let drag = self.drag;
        match &self.dry.bristle {
            Some(bristle) if at_rest != [0.0; 2] => {
                let sliding = Sliding { level, drag };
                Resistance::Bristles(bristle.step_equation(bristle_force, coast, step_s, sliding))
            }
            _ if at_rest == [0.0; 2] && drag == 0.0 => Resistance::Known(StepForce::ZERO),
            _ if self.dry.varies() => Resistance::Known(friction(coast, step_s, |direction, speed| {
                level.at(direction, speed) + direction * drag * speed
            })),
            _ => Resistance::Known(friction(coast, step_s, |direction, speed| {
                of_direction(at_rest, direction) + direction * drag * speed
            })),
        }
    }

    /// Initial state of the friction: the bristles' force on the moving part at a replay's first position and velocity, in N or N·m,
    /// positive in the joint's positive direction; 0 without bristles.
    ///
    /// # Model
    /// Where the acceleration is known, the equation of motion of the moving part gives it, as far as bristles can deflect:
    /// `f = m·a + c·v − F_motor − F_push − F_weight`, limited to `−g(+, |v|) … g(−, |v|)`, g the static friction curve. Where it is
    /// not known they slide: `f = −sgn(v)·g(sgn v, |v|)`.
    ///
    /// # Validity
    /// The base is taken to be at rest, its reaction to hold. With a base that still rings, the force is wrong by the moving
    /// mass times the base's acceleration.
    ///
    /// # Source
    /// The equation of motion; state and limits of the bristles as C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky (1995),
    /// *A new model for control of systems with friction*, IEEE Trans. Automatic Control 40:419.
    pub fn initial_bristle_force(
        &self,
        [position, velocity]: [f64; 2],
        clock_s: f64,
        start: InitialForces,
    ) -> f64 {
        if self.dry.bristle.is_none() {
            return 0.0;
        }
        let waves = self.waves.iter().map(|wave| wave.at(position));
        let pushes = waves.chain(self.pushes.iter().map(|effect| effect.push(position, velocity)));
        let shakes = self.shakes.iter().map(|effect| effect.shake(clock_s));
        let motor = start.motor * self.motor_factor(position, start.motor);
        let acting = motor + pushes.chain(shakes).sum::<f64>() + start.weight;
        let balance = start.inertial.map(|inertial| inertial - acting);
        let loaded = self
            .loaded
            .as_ref()
            .map_or([0.0; 2], |friction| friction.levels(None, [motor, balance.unwrap_or(0.0)], position));
        let level = |direction: f64| {
            let level = self.dry.level_under(of_direction(loaded, direction), direction, velocity.abs());
            self.dry.level_at(level, position, clock_s)
        };
        match balance {
            Some(force) => force.max(-level(1.0)).min(level(-1.0)),
            None => -velocity.signum() * level(velocity.signum()),
        }
    }

    /// The motor's force per `force`, which would be in proportion to the current.
    #[inline(always)]
    pub fn motor_factor(&self, position: f64, force: f64) -> f64 {
        motor_factor(&self.changes, position, force)
    }

    /// Stops between which the drive train holds the load while the motor's end stands at `motor`.
    #[inline(always)]
    fn stops(&self, motor: f64) -> [f64; 2] {
        self.transmissions.iter().fold([motor; 2], |stops, effect| effect.stops(stops))
    }

    /// The load's position behind the drive train, from that before and the motor's travel since then.
    #[inline(always)]
    pub fn transmit(&self, motor: f64, before: f64, travel: f64) -> f64 {
        let [rear, front] = self.stops(motor);
        let before = before + self.carried * travel;
        // Not `clamp`: a position that a diverged replay has lost must not stop the program.
        if rear < front { before.max(rear).min(front) } else { 0.5 * (rear + front) }
    }

    /// The load's position where a run begins, see [`Law::initial_share`](crate::effect::Law::initial_share).
    pub fn load_at_start(&self, motor: f64) -> f64 {
        let [rear, front] = self.stops(motor);
        0.5 * (rear + front) - 0.5 * self.initial_share * (front - rear).max(0.0)
    }

    #[inline(always)]
    pub fn read(&self, position: f64) -> f64 {
        self.readings.iter().fold(position, |reading, effect| effect.read(reading))
    }

    /// The position of the motor's end at which the encoder would show `reading` where a run begins.
    pub fn position_at(&self, reading: f64, end: End) -> f64 {
        let shown = |motor: f64| self.read(if end == End::Motor { motor } else { self.load_at_start(motor) });
        // Errors of a reading are small against it, but a scale is not: divide by it first.
        let slope = (shown(reading + 1.0) - shown(reading)).abs().max(1e-3);
        (0..MOST_INVERSIONS).fold(reading, |motor, _| motor + (reading - shown(motor)) / slope)
    }
}

/// The number of a direction, from those of the positive and of the negative one.
#[inline(always)]
fn of_direction([positive, negative]: [f64; 2], direction: f64) -> f64 {
    if direction > 0.0 { positive } else { negative }
}

/// Positions of the load behind the machine's drive train while an encoder at the motor's end shows `shown` from the
/// beginning of a run on.
pub fn load_positions(machine: &Machine, shown: &[f64]) -> Vec<f64> {
    let laws = Laws::of(machine, true);
    let place = |&reading: &f64| {
        if laws.readings.is_empty() { reading } else { laws.position_at(reading, End::Motor) }
    };
    let mut before = shown.first().map_or(0.0, &place);
    let mut load = laws.load_at_start(before);
    let follow = |reading| {
        let motor = place(reading);
        load = laws.transmit(motor, load, motor - before);
        before = motor;
        load
    };
    shown.iter().map(follow).collect()
}
