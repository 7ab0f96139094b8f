//! Reports of a diagnosis for people: the same numbers as in its JSON, in the order in which a servo engineer asks.
//!
//! What are the data → what is it → (in a comparison) what changed → where does it lie → which effect → how far does the gap shrink → what was
//! calibrated, what was noticed in the data → what next.

mod catalogue;
mod changes;
mod compared;
pub mod confusion;
mod crosscheck;
mod drive;
mod extent;
pub mod figure;
mod findings;
mod follow_up;
mod gains;
mod grid;
pub mod html;
mod kinds;
mod ladder;
mod layout;
pub mod material;
mod number;
mod place;
mod printed;
mod remains;
mod sentence;
pub mod sheet;
mod signals;
pub mod stretches;
mod style;
pub mod swept;
mod terminal;
mod tuned;
mod untested;
mod which;
mod withheld;
mod words;
mod wrap;

pub use catalogue::{effect_list, effect_sheet, example};
pub use compared::{Comparison, compared};
pub use crosscheck::crosscheck;
pub use gains::{gain_table, gains};
pub use grid::grid;
pub use kinds::{kind_example, kind_list, kind_sheet};
pub use ladder::ladder;
pub use printed::printed_equations;
pub use sentence::sentence;
pub use signals::{signal_list, signal_sheet};
pub use style::Style;
pub use terminal::terminal;
pub use tuned::{tuned, tuning_map};
pub use wrap::wrap;
