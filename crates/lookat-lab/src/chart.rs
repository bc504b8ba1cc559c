//! Speed against accuracy: methods of rendering one scene, each with more and more samples, their time and their error.
//!
//! [`Runner`] renders, [`plan()`] decides how far to climb, [`Climb`] measures, [`Results`] draws conclusions, and [`draw()`],
//! [`as_csv`] and [`as_json`] show them.

mod climb;
mod draw;
mod equal;
mod estimate;
mod fit;
mod front;
mod level;
mod method;
mod plan;
mod point;
mod reference;
mod results;
mod runner;
mod table;

pub use climb::Climb;
pub use draw::draw;
pub use equal::{Curve, EqualValues};
pub use estimate::Estimate;
pub use fit::Fit;
pub use front::Reign;
pub use level::Level;
pub use method::{DEFAULT, METHODS, Method, named};
pub use plan::{Cost, FEWEST_SEEDS, MOST_RUNGS, Plan, plan};
pub use point::{Marker, Picture, Point};
pub use reference::{Fitted, Origin, Reference, fitted};
pub use results::{End, Measured, Results};
pub use runner::{Budget, Rendering, Runner, Watch};
pub use table::{Header, as_csv, as_json};
