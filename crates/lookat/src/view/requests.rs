//! What the pages ask for.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::messages::{Pick, Request};

/// The most requests that wait.
const MOST: usize = 64;

/// The requests that wait for the engine, in order.
#[derive(Default)]
pub struct Requests {
    waiting: Mutex<Vec<Request>>,
    put: Condvar,
    /// Whether one waits, to be read without the lock.
    has_any: AtomicBool,
}

impl Requests {
    /// Replaces an earlier request for the same. Drops the request if too many wait.
    pub fn put(&self, request: Request) {
        let mut waiting = self.lock();
        waiting.retain(|earlier| !is_for_the_same(earlier, &request));
        if waiting.len() < MOST {
            waiting.push(request);
        }
        self.has_any.store(true, Ordering::Relaxed);
        self.put.notify_all();
    }

    /// Takes a request about a place alone: it can be answered while a picture is rendered.
    pub fn take_pick(&self) -> Option<Pick> {
        if !self.has_any() {
            return None;
        }
        let mut waiting = self.lock();
        let at = waiting.iter().position(|request| matches!(request, Request::Pick(_)))?;
        let Request::Pick(pick) = waiting.remove(at) else { return None };
        self.has_any.store(!waiting.is_empty(), Ordering::Relaxed);
        Some(pick)
    }

    pub fn has_any(&self) -> bool {
        self.has_any.load(Ordering::Relaxed)
    }

    /// Takes all requests, after waiting at most `time` for the first.
    pub fn take(&self, time: Duration) -> Vec<Request> {
        let waited = self.put.wait_timeout_while(self.lock(), time, |waiting| waiting.is_empty());
        let (mut waiting, _) = waited.unwrap_or_else(PoisonError::into_inner);
        self.has_any.store(false, Ordering::Relaxed);
        std::mem::take(&mut waiting)
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Request>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Whether the answer to an earlier request is of no use any more.
fn is_for_the_same(earlier: &Request, request: &Request) -> bool {
    match (earlier, request) {
        (Request::Film(_), Request::Film(_)) | (Request::View(_), Request::View(_)) => true,
        (Request::Pick(earlier), Request::Pick(request)) => earlier.by == request.by,
        (Request::Depths(earlier), Request::Depths(request)) => earlier.by == request.by,
        (Request::Change(earlier), Request::Change(request)) => {
            (earlier.by, earlier.at, &earlier.name) == (request.by, request.at, &request.name)
        }
        _ => false,
    }
}
