//! Several parameter sets of one machine in one pass.

use super::acting::{Acting, Begun};
use super::front::{Entry, Front};
use super::laws::Resistance;
use super::path::Path;
use super::slides::Slides;
use super::wave_lanes::WaveLanes;
use super::{Command, Sample, Twin};
use crate::guide::{StepEquations, StepForce};
use crate::plant::Drive;
use crate::plant::axis::{Axis, Friction, LANES, Lane, Lanes};

/// Twins from which on [`Slides`] cost less than one after the other: half of those that fit, since all are gone through.
const FEWEST: usize = LANES / 2;

/// What drives the twins of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driven {
    /// Their controllers.
    ByControllers,
    /// An effort that every command gives.
    ByEffort,
    /// A force in the motor's place that every command gives.
    ByForce,
}

/// Twins on the reduced axis that follow the same commands in one pass: one reference, several parameter sets.
///
/// The linear part of all of them is one product of arrays ([`Lanes`]), and so are friction, bristles, weight and what repeats along the axis where that pays; the rest goes lane by
/// lane through the code of a single [`Twin`]. Each lane is to the last bit what its twin would be by itself.
#[derive(Debug)]
pub struct Batch {
    paths: Vec<Path>,
    axes: Lanes,
    driven: Driven,
    /// Sensors, controller and amplifier in arrays, where all paths fit; the paths' own memories then stand still.
    front: Option<Front>,
    /// Dry friction of each direction, where nothing else acts on the guides.
    friction: Option<Friction>,
    /// Bristles of the guides, axis by axis.
    bristles: StepEquations<LANES>,
    /// Weight and friction of twins that slide on or stay stuck, where that pays.
    slides: Option<Slides<LANES>>,
    /// Forces that repeat along the axis, where a twin has any.
    waves: Option<WaveLanes>,
}

impl Batch {
    /// Joins twins in the states that they are in; gives them back where they do not fit into one pass.
    ///
    /// # Errors
    /// The twins themselves: more than [`LANES`], none, or twins that differ in steps, winding or number of modes.
    pub fn of(twins: Vec<Twin<Axis>>, driven: Driven) -> Result<Self, Vec<Twin<Axis>>> {
        let (paths, axes): (Vec<Path>, Vec<Axis>) =
            twins.into_iter().map(|twin| (twin.path, twin.plant)).unzip();
        let apart = |(paths, axes): (Vec<Path>, Vec<Axis>)| {
            paths.into_iter().zip(axes).map(|(path, plant)| Twin { path, plant }).collect()
        };
        if !paths.iter().all(|path| path.steps() == paths[0].steps()) {
            return Err(apart((paths, axes)));
        }
        let mut axes = match Lanes::pack(axes, driven == Driven::ByForce) {
            Ok(axes) => axes,
            Err(axes) => return Err(apart((paths, axes))),
        };
        for (lane, path) in paths.iter().enumerate() {
            (0..path.steps()).for_each(|step| axes.switch_at(lane, path.switch(step)));
        }
        let front = if driven == Driven::ByControllers { front(&paths) } else { None };
        let friction = constant_friction(&paths);
        let pays = paths.len() >= FEWEST && paths.iter().all(Path::may_slide);
        let slides = pays.then(|| Slides::new(axes.step_s()));
        let waves = WaveLanes::of(&paths.iter().map(Path::waves).collect::<Vec<_>>(), axes.step_s());
        let bristles = StepEquations::default();
        Ok(Self { paths, axes, driven, front, friction, bristles, slides, waves })
    }

    /// Number of twins.
    pub fn len(&self) -> usize {
        self.paths.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.paths.is_empty()
    }

    /// Positions and velocities of the twins' plants.
    pub fn states(&self) -> [[f64; 2]; LANES] {
        let (position, velocity) = (self.axes.positions(), self.axes.velocities());
        std::array::from_fn(|lane| [position[lane], velocity[lane]])
    }

    /// See [`Twin::restart`]; for twins that are not driven by their controllers.
    pub fn restart(&mut self, position: f64, velocity: f64) {
        debug_assert!(self.driven != Driven::ByControllers);
        for (lane, path) in self.paths.iter_mut().enumerate() {
            let now = [self.axes.position(lane), self.axes.velocity(lane)];
            let [motor, speed] = path.restart(now, position, velocity);
            self.axes.relocate(lane, motor, speed);
        }
    }

    /// One control period of every twin: `command` tells each what reaches it, `each` gets the samples, twin by twin.
    ///
    /// Controllers of a batch follow one reference: the first twin's. The drive of all of them is enabled where the first one's is.
    #[inline(always)]
    pub fn step(&mut self, command: impl Fn(usize) -> Command, mut each: impl FnMut(usize, Sample)) {
        let command = |lane: usize| command(lane).with_bridge_open();
        let is_open = !command(0).is_enabled;
        let is_forced = is_open || self.driven == Driven::ByForce;
        debug_assert!((0..self.len()).all(|lane| command(lane).thrust.is_some() == is_forced));
        self.axes.set_forced(is_forced);
        if is_open {
            self.axes.cut_currents();
        }
        let (now, earlier) = self.sample(&command, &mut each);
        for step in 0..self.paths[0].steps() {
            self.travel(step, |lane| command(lane).thrust, &now, &earlier);
        }
    }

    /// One sample of every twin; the voltages applied until the next, the new ones and those of before.
    #[inline(always)]
    fn sample(
        &mut self,
        command: &impl Fn(usize) -> Command,
        each: &mut impl FnMut(usize, Sample),
    ) -> (Lane, Lane) {
        let Self { paths, axes, front, .. } = self;
        if let (Some(front), Some(current)) = (front, axes.currents()) {
            let [now, earlier] = front.sample(axes.arch(), command(0), axes.positions(), current, each);
            return (now, earlier);
        }
        let (mut now, mut earlier) = ([0.0; LANES], [0.0; LANES]);
        for (lane, path) in paths.iter_mut().enumerate() {
            let (sample, applied_v) = path.sample(command(lane), axes.position(lane), axes.current(lane));
            [now[lane], earlier[lane]] = applied_v;
            each(lane, sample);
        }
        (now, earlier)
    }

    /// One step of the plants.
    #[inline(always)]
    fn travel(&mut self, step: usize, thrust: impl Fn(usize) -> Option<f64>, now: &Lane, earlier: &Lane) {
        let (mut held, mut difference) = ([0.0; LANES], [0.0; LANES]);
        for (lane, path) in self.paths.iter().enumerate() {
            let drive = path.drive(step, [now[lane], earlier[lane]], thrust(lane));
            (held[lane], difference[lane]) = match drive {
                Drive::Force(force) => (force, 0.0),
                Drive::Voltage { now_v, switch, .. } if switch <= 0.0 => (now_v, 0.0),
                Drive::Voltage { earlier_v, switch, .. } if switch >= 1.0 => (earlier_v, 0.0),
                Drive::Voltage { earlier_v, now_v, .. } => (now_v, earlier_v - now_v),
            };
        }
        let found = match &self.friction {
            Some(friction) => match self.axes.travel(&held, &difference, friction) {
                None => return,
                Some(found) => found,
            },
            None => {
                self.axes.look_ahead(&held, &difference);
                [None; LANES]
            }
        };
        if let Some(waves) = &mut self.waves {
            waves.look(&self.axes);
        }
        let drives = |lane: usize, path: &Path| path.drive(step, [now[lane], earlier[lane]], thrust(lane));
        let mut forces = found.map(|force| force.unwrap_or(StepForce::ZERO));
        if self.slides.is_some() {
            self.slide(drives, &found, &mut forces);
        } else {
            self.resist(drives, &found, &mut forces);
        }
        self.axes.advance(&forces);
    }

    /// Forces of the twins that have none yet, weight and friction in arrays.
    #[inline(always)]
    fn slide(
        &mut self,
        drive: impl Fn(usize, &Path) -> Drive,
        found: &[Option<StepForce>; LANES],
        forces: &mut [StepForce; LANES],
    ) {
        let Self { paths, axes, slides: Some(slides), waves, .. } = self else { return };
        let mut begun: [Option<Begun>; LANES] = [None; LANES];
        for (lane, path) in paths.iter_mut().enumerate().filter(|(lane, _)| found[*lane].is_none()) {
            let waves = waves.as_ref().map(|waves| waves.at(lane));
            let step = path.begin(drive(lane, path), axes.coast(lane), axes.position(lane), waves, || None);
            slides.set(lane, &path.sliding(&step));
            begun[lane] = Some(step);
        }
        slides.solve_together(axes.arch());
        for (lane, path) in paths.iter_mut().enumerate() {
            let Some(begun) = &begun[lane] else { continue };
            let bristle = path.bristle_force();
            let (acting, friction) = match slides.answer(lane) {
                Some([weight, friction]) => (begun.under(weight), friction),
                None => {
                    let (acting, resistance) = path.resist(begun);
                    (acting, resistance.resolved(bristle).0)
                }
            };
            let [motor, guide] = path.end(&acting, (friction, bristle));
            forces[lane] = motor + guide;
        }
    }

    /// Forces of the twins that have none yet, whatever their guides have.
    #[inline(always)]
    fn resist(
        &mut self,
        drive: impl Fn(usize, &Path) -> Drive,
        found: &[Option<StepForce>; LANES],
        forces: &mut [StepForce; LANES],
    ) {
        let mut waiting: [Option<Acting>; LANES] = [None; LANES];
        for (lane, path) in self.paths.iter_mut().enumerate().filter(|(lane, _)| found[*lane].is_none()) {
            let (coast, position) = (self.axes.coast(lane), self.axes.position(lane));
            let waves = self.waves.as_ref().map(|waves| waves.at(lane));
            let begun = path.begin(drive(lane, path), coast, position, waves, || None);
            match path.resist(&begun) {
                (acting, Resistance::Bristles(equation)) => {
                    self.bristles.set(lane, &equation);
                    waiting[lane] = Some(acting);
                }
                (acting, Resistance::Known(friction)) => {
                    let [motor, guide] = path.end(&acting, (friction, path.bristle_force()));
                    forces[lane] = motor + guide;
                    self.bristles.clear(lane);
                }
            }
        }
        if waiting.iter().any(Option::is_some) {
            self.bristles.solve_together(self.axes.arch());
        }
        for (lane, path) in self.paths.iter_mut().enumerate() {
            if let Some(acting) = &waiting[lane] {
                let [motor, guide] = path.end(acting, self.bristles.answer(lane));
                forces[lane] = motor + guide;
            }
        }
    }
}

/// Sensors, controllers and amplifiers of these paths in arrays; none where one of them does not fit.
fn front(paths: &[Path]) -> Option<Front> {
    let entries: Vec<Entry> = paths.iter().map(Path::front).collect::<Option<_>>()?;
    Front::of(&entries)
}

/// Dry friction of each direction, twin by twin, where it is all that acts on the guides.
fn constant_friction(paths: &[Path]) -> Option<Friction> {
    let levels: Vec<[f64; 2]> = paths.iter().map(Path::constant_friction).collect::<Option<_>>()?;
    let lane =
        |direction: usize| std::array::from_fn(|k| levels.get(k).map_or(0.0, |level| level[direction]));
    Some(Friction { level: [lane(0), lane(1)] })
}
