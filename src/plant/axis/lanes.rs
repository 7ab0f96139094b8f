//! Several axes in one pass: structure of arrays.

use super::kernel::{
    Aligned, ApplyLanes, LANE_ROWS, LANES, Lane, LaneRows, MultiplyLanes, NO_LANE_ROWS, ROWS, Rows,
};
use super::slide::{Answers, SlideOrStick};
use super::{Axis, Layout, Matrices, at};
use crate::guide::{Coast, StepForce};
use pulp::{Arch, Simd, WithSimd};

/// Dry friction that does not depend on speed and is all that acts on the guides.
#[derive(Debug, Clone, Copy)]
pub struct Friction {
    /// N or N·m in the positive and the negative direction of each axis; 0 where there is no axis.
    pub level: [Lane; 2],
}

/// Up to [`LANES`] axes of one structure, advanced together.
///
/// The sums are those of [`Axis`], term by term in the same order, so that each lane is to the last bit what its axis
/// would be by itself.
#[derive(Debug, Clone)]
pub struct Lanes {
    axes: Vec<Axis>,
    is_forced: bool,
    columns: usize,
    /// Blocks of rows, in each the columns.
    transition: Vec<LaneRows>,
    by_earlier: Vec<LaneRows>,
    by_mean: Vec<LaneRows>,
    by_rise: Vec<LaneRows>,
    state: Vec<LaneRows>,
    ahead: Vec<LaneRows>,
    position: Lane,
    drive: Lane,
    inverse: [Lane; 4],
    arch: Arch,
}

impl Lanes {
    /// Packs axes in the states that they are in; gives them back where they do not fit into one pass. `is_forced`: a given
    /// force takes the motor's place until [`set_forced`](Self::set_forced) changes that.
    ///
    /// # Errors
    /// The axes themselves: more than [`LANES`], none, or axes that differ in step, winding or number of modes.
    pub fn pack(axes: Vec<Axis>, is_forced: bool) -> Result<Self, Vec<Axis>> {
        let same = |axis: &Axis| axis.layout() == axes[0].layout() && axis.step_s == axes[0].step_s;
        if axes.is_empty() || axes.len() > LANES || !axes.iter().all(same) {
            return Err(axes);
        }
        let columns = axes[0].voltage() + 1;
        // The states but the position, the voltage, the displacement.
        let blocks = (columns + 1).div_ceil(LANE_ROWS);
        let mut lanes = Self {
            is_forced,
            columns,
            transition: Vec::new(),
            by_mean: Vec::new(),
            by_rise: Vec::new(),
            by_earlier: vec![NO_LANE_ROWS; blocks],
            state: (0..blocks)
                .map(|block| lane_rows(|r| across(&axes, |axis| at(&axis.state, block * LANE_ROWS + r))))
                .collect(),
            ahead: vec![NO_LANE_ROWS; blocks],
            position: across(&axes, |axis| axis.position),
            drive: [0.0; LANES],
            inverse: [[0.0; LANES]; 4],
            arch: Arch::new(),
            axes,
        };
        lanes.gather_steps();
        Ok(lanes)
    }

    /// From the coming step on a given force takes the motor's place in every axis, or the voltage drives them again.
    pub fn set_forced(&mut self, is_forced: bool) {
        if self.is_forced != is_forced {
            self.is_forced = is_forced;
            self.gather_steps();
        }
    }

    /// Steps of the axes under what drives them, regrouped.
    fn gather_steps(&mut self) {
        let Self { axes, is_forced, columns, ahead, .. } = self;
        axes.iter_mut().for_each(|axis| axis.set_forced(*is_forced));
        let gathered = |width: usize, of: fn(&Matrices) -> &[Rows]| gather(axes, ahead.len(), width, of);
        self.transition = gathered(*columns, |m| &m.transition);
        self.by_mean = gathered(1, |m| &m.by_mean);
        self.by_rise = gathered(1, |m| &m.by_rise);
        self.inverse = [0, 1, 2, 3].map(|k| across(axes, |axis| axis.matrices().response.inverse()[k]));
    }

    /// No current flows in any winding.
    pub fn cut_currents(&mut self) {
        if self.axes[0].layout().has_winding {
            self.state[0][Layout::CURRENT] = [0.0; LANES];
        }
    }

    /// Length of a step in s.
    pub fn step_s(&self) -> f64 {
        self.axes[0].step_s
    }

    /// Number of axes.
    pub fn len(&self) -> usize {
        self.axes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.axes.is_empty()
    }

    /// Positions in m or rad.
    pub fn positions(&self) -> &Lane {
        &self.position
    }

    /// Velocities in m/s or rad/s.
    pub fn velocities(&self) -> &Lane {
        &self.state[0][0]
    }

    /// Velocities at the end of the step that was looked at, as [`coast`](Self::coast) has them.
    pub fn free_velocities(&self) -> &Lane {
        &self.ahead[0][0]
    }

    /// Displacements over the step that was looked at, as [`coast`](Self::coast) has them.
    pub fn free_travels(&self) -> &Lane {
        &self.ahead[self.columns / LANE_ROWS][self.columns % LANE_ROWS]
    }

    /// Currents in A; none where the motor has no winding.
    pub fn currents(&self) -> Option<&Lane> {
        self.axes[0].layout().has_winding.then(|| &self.state[0][Layout::CURRENT])
    }

    /// Vector instructions of the processor at hand.
    pub fn arch(&self) -> Arch {
        self.arch
    }

    /// Position of one axis in m or rad.
    pub fn position(&self, lane: usize) -> f64 {
        self.position[lane]
    }

    /// Velocity of one axis in m/s or rad/s.
    pub fn velocity(&self, lane: usize) -> f64 {
        self.state[0][0][lane]
    }

    /// Current of one axis in A.
    pub fn current(&self, lane: usize) -> f64 {
        if self.axes[0].layout().has_winding { self.state[0][Layout::CURRENT][lane] } else { 0.0 }
    }

    /// Takes one axis to a position with a velocity.
    pub fn relocate(&mut self, lane: usize, position: f64, velocity: f64) {
        self.state[0][0][lane] = velocity;
        self.position[lane] = position;
    }

    /// Looks ahead: `voltage` (V, or N and N·m where a force is given) over the step, `earlier` (V) more of it until the
    /// share of the step at which each axis' voltage switches.
    pub fn look_ahead(&mut self, drive: &Lane, earlier: &Lane) {
        let switched = earlier.iter().any(|volt| *volt != 0.0);
        let voltage = self.columns - 1;
        self.drive = *drive;
        self.state[voltage / LANE_ROWS][voltage % LANE_ROWS] =
            if self.is_forced { [0.0; LANES] } else { *drive };
        let Self { arch, columns, transition, state, ahead, .. } = self;
        arch.dispatch(MultiplyLanes { matrix: transition, columns: *columns, by: state, into: ahead });
        self.add_inputs(drive, earlier, switched);
    }

    /// Looks ahead and makes the step where every axis slides on or stays stuck under this friction; else the answers that
    /// there are, the others to be found and the step to be made by [`advance`](Lanes::advance).
    pub fn travel(
        &mut self,
        drive: &Lane,
        earlier: &Lane,
        friction: &Friction,
    ) -> Option<[Option<StepForce>; LANES]> {
        if self.is_forced || earlier.iter().any(|volt| *volt != 0.0) {
            self.look_ahead(drive, earlier);
            return Some([None; LANES]);
        }
        let voltage = self.columns - 1;
        self.drive = *drive;
        self.state[voltage / LANE_ROWS][voltage % LANE_ROWS] = *drive;
        let arch = self.arch;
        let Answers { mean, rise, is_answer } = arch.dispatch(WholeStep { lanes: self, friction });
        let found = |k: usize| (is_answer[k] != 0.0).then_some(StepForce { mean: mean[k], rise: rise[k] });
        is_answer.contains(&0.0).then(|| std::array::from_fn(found))
    }

    fn add_inputs(&mut self, drive: &Lane, earlier: &Lane, switched: bool) {
        if switched {
            self.add(|lanes| &lanes.by_earlier, earlier);
        }
        if self.is_forced && drive.iter().any(|force| *force != 0.0) {
            self.add(|lanes| &lanes.by_mean, drive);
        }
    }

    /// Adds a column times a factor to what was looked ahead.
    fn add(&mut self, column: fn(&Self) -> &[LaneRows], factor: &Lane) {
        for block in 0..self.ahead.len() {
            let (ahead, column) = (self.ahead[block], column(self)[block]);
            self.ahead[block] =
                lane_rows(|r| std::array::from_fn(|k| ahead[r][k] + column[r][k] * factor[k]));
        }
    }

    /// Prepares steps in which an axis' voltage switches at this share of them.
    pub fn switch_at(&mut self, lane: usize, switch: f64) {
        if switch > 0.0 && switch < 1.0 {
            let values = self.axes[lane].by_earlier(switch).iter().flat_map(|rows| rows.0);
            let rows = self.by_earlier.iter_mut().flat_map(|rows| rows.0.iter_mut());
            rows.zip(values).for_each(|(row, value)| row[lane] = value);
        }
    }

    /// How the step that was looked at would end for one axis.
    #[inline(always)]
    pub fn coast(&self, lane: usize) -> Coast {
        let displacement = self.columns;
        let of = |rows: &[LaneRows], row: usize| rows[row / LANE_ROWS][row % LANE_ROWS][lane];
        let constant = self.axes[lane].force_constant;
        let motor_force = match (self.is_forced, self.axes[0].layout().has_winding) {
            (true, _) => [self.drive[lane]; 2],
            (false, true) => {
                let (begin, end) = (self.state[0][Layout::CURRENT][lane], of(&self.ahead, Layout::CURRENT));
                [constant * begin, constant * end]
            }
            (false, false) => [constant * self.drive[lane]; 2],
        };
        Coast {
            velocity: self.state[0][0][lane],
            free_velocity: of(&self.ahead, 0),
            free_travel: of(&self.ahead, displacement),
            motor_force,
            response: self.axes[lane].matrices().response,
        }
    }

    /// Makes the step that was looked at, under the forces of motor and guide of each axis.
    pub fn advance(&mut self, forces: &[StepForce; LANES]) {
        let (mean, rise) = (forces.map(|f| f.mean), forces.map(|f| f.rise));
        self.arch.dispatch(Advance { lanes: self, mean: &mean, rise: &rise });
    }
}

/// Makes the step that was looked at.
struct Advance<'a> {
    lanes: &'a mut Lanes,
    mean: &'a Lane,
    rise: &'a Lane,
}

impl WithSimd for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Lanes { state, ahead, by_mean, by_rise, position, columns, .. } = self.lanes;
        let (columns_of, factors) = ([by_mean.as_slice(), by_rise], [self.mean, self.rise]);
        ApplyLanes { from: ahead, columns: columns_of, factors, into: state }.with_simd(simd);
        for (position, travel) in position.iter_mut().zip(&state[*columns / LANE_ROWS][*columns % LANE_ROWS])
        {
            *position += travel;
        }
    }
}

/// A whole step where every axis slides on or stays stuck; else only the look ahead.
struct WholeStep<'a> {
    lanes: &'a mut Lanes,
    friction: &'a Friction,
}

impl WithSimd for WholeStep<'_> {
    type Output = Answers;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Answers {
        let Lanes { axes, columns, transition, state, ahead, by_mean, inverse, .. } = &mut *self.lanes;
        MultiplyLanes { matrix: transition, columns: *columns, by: state, into: ahead }.with_simd(simd);
        let answers = SlideOrStick {
            velocity: &state[0][0],
            free_velocity: &ahead[0][0],
            free_travel: &ahead[*columns / LANE_ROWS][*columns % LANE_ROWS],
            mobility: &by_mean[0][0],
            inverse,
            step_s: axes[0].step_s,
            level: &self.friction.level,
        }
        .with_simd(simd);
        if !answers.is_answer.contains(&0.0) {
            Advance { lanes: self.lanes, mean: &answers.mean, rise: &answers.rise }.with_simd(simd);
        }
        answers
    }
}

/// A block of rows, row by row.
fn lane_rows(of: impl FnMut(usize) -> Lane) -> LaneRows {
    Aligned(std::array::from_fn(of))
}

/// One number of each axis; zero where there is none.
fn across(axes: &[Axis], of: impl Fn(&Axis) -> f64) -> Lane {
    std::array::from_fn(|k| axes.get(k).map_or(0.0, &of))
}

/// Blocks of rows of each axis, `columns` to a block, regrouped to blocks of several axes.
fn gather(axes: &[Axis], blocks: usize, columns: usize, of: fn(&Matrices) -> &[Rows]) -> Vec<LaneRows> {
    let entry = |axis: &Axis, row: usize, column: usize| {
        of(axis.matrices())[row / ROWS * columns + column][row % ROWS]
    };
    let places = (0..blocks).flat_map(|block| (0..columns).map(move |column| (block, column)));
    let rows =
        |(block, column)| lane_rows(|r| across(axes, |axis| entry(axis, block * LANE_ROWS + r, column)));
    places.map(rows).collect()
}
