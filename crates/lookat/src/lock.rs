//! Access to what threads share.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// What no other thread uses meanwhile, also after a thread has panicked with it.
pub fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
