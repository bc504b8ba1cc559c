//! The time that a run may take.

use std::time::Instant;

/// By how much a run may exceed its budget.
pub(super) const LATE: f64 = 1.15;

/// The wall time of a run, from its start on.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    /// When the run began.
    pub started: Instant,
    /// How long it may take, in seconds.
    pub seconds: f64,
}

impl Budget {
    /// The seconds that are left; 0 if there are none.
    pub fn left(&self) -> f64 {
        (self.seconds - self.spent()).max(0.0)
    }

    /// Whether it is time to break off.
    pub(super) fn is_exceeded(&self) -> bool {
        self.spent() > LATE * self.seconds
    }

    fn spent(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}
