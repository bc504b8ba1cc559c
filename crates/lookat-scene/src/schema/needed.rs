//! Whole numbers without which a constructor fails.

use super::REQUIRED;
use super::value::DefaultValue;

/// A whole number that a type needs. The constructor gets `None` after an error.
#[derive(Clone, Copy)]
pub(crate) struct Needed;

impl DefaultValue for Needed {
    fn words(self) -> String {
        REQUIRED.into()
    }
}
