//! Whole numbers without which a constructor fails.

use super::value::{DefaultValue, Value};
use super::{Key, REQUIRED};
use crate::params::Params;

/// A whole number that a type needs. The constructor gets `None` after an error.
#[derive(Clone, Copy)]
pub(crate) struct Needed;

impl DefaultValue for Needed {
    fn words(self) -> String {
        REQUIRED.into()
    }
}

impl Value for Needed {
    type Taken = Option<i32>;

    fn take(key: &Key<Self>, params: &mut Params) -> Option<i32> {
        let value = params.integer(key.name, 0);
        if params.was_taken(key.name) {
            return params.check_within(key, value).then_some(value);
        }
        let message = format!("a {} needs {}", params.kind(), key.name);
        params.missing(key.name, &message, &format!("\"integer {}\" is {}", key.name, key.meaning));
        None
    }
}
