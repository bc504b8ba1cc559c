//! Error against render time: several methods render one scene, each with more and more samples per pixel.
//!
//! [`Plan`] chooses the samples, [`Measurement`] renders the pictures, [`Chart`] holds what follows from them, and [`draw()`]
//! and [`as_csv`] show it.

mod draw;
mod measure;
mod method;
mod reference;
mod results;

pub use draw::{Plot, draw};
pub use measure::{
    CommonSquare, End, FEWEST_SEEDS, MOST_POINTS, Measured, Measurement, Picture, Plan, Point, Renderer,
    Watch,
};
pub use method::{DEFAULT, METHODS, Method, named};
pub use reference::{Fitted, Origin, Reference, Unfit, fitted};
pub use results::{Chart, ChartSetup, EqualTable, FrontPoint, MethodResult, OtherResult, as_csv};
