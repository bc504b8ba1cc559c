//! What the pages ask for.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use super::messages::Request;
use crate::lock::lock;

/// The most requests that wait.
const MOST: usize = 64;

/// The requests that wait for the engine, in order.
#[derive(Default)]
pub struct Requests {
    waiting: Mutex<Vec<Request>>,
    put: Condvar,
    /// Whether one waits that is not answered query, to be read without the lock.
    has_any: AtomicBool,
    /// Whether the engine has something else to do.
    is_woken: AtomicBool,
}

impl Requests {
    /// Replaces an earlier request for the same. Drops the request if too many wait.
    pub fn put(&self, request: Request) {
        let mut waiting = lock(&self.waiting);
        waiting.retain(|earlier| !is_for_the_same(earlier, &request));
        if waiting.len() < MOST {
            waiting.push(request);
        }
        self.count(&waiting);
        self.put.notify_all();
    }

    /// Puts a request that is not answered yet before the others, unless there is a newer one for the same.
    pub fn put_back(&self, request: Request) {
        let mut waiting = lock(&self.waiting);
        if !waiting.iter().any(|later| is_for_the_same(&request, later)) {
            waiting.insert(0, request);
        }
    }

    /// Takes the requests that are wanted, after waiting at most `time` for the first. They overtake no others. `None` once it is
    /// over.
    pub fn take_wanted(
        &self,
        time: Duration,
        is_wanted: impl Fn(&Request) -> bool,
        is_over: &AtomicBool,
    ) -> Option<Vec<Request>> {
        let is_over = || is_over.load(Ordering::Relaxed);
        let is_idle = |waiting: &mut Vec<Request>| {
            !is_over() && (!waiting.iter().all(Request::is_query) || !waiting.iter().any(&is_wanted))
        };
        let waited = self.put.wait_timeout_while(lock(&self.waiting), time, is_idle);
        let (mut waiting, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let is_free = waiting.iter().all(Request::is_query);
        (!is_over()).then(|| waiting.extract_if(.., |request| is_free && is_wanted(request)).collect())
    }

    /// Ends the waiting for those that are wanted.
    pub fn end_wanted(&self, is_over: &AtomicBool) {
        // With the lock, nobody is between looking and waiting.
        let _waiting = lock(&self.waiting);
        is_over.store(true, Ordering::Relaxed);
        self.put.notify_all();
    }

    pub fn has_any(&self) -> bool {
        self.has_any.load(Ordering::Relaxed)
    }

    /// Ends waiting: a file has changed.
    pub fn wake(&self) {
        let _waiting = lock(&self.waiting);
        self.is_woken.store(true, Ordering::Relaxed);
        self.put.notify_all();
    }

    /// Takes all requests, after waiting at most `time` for the first or until woken.
    pub fn take(&self, time: Duration) -> Vec<Request> {
        let is_idle =
            |waiting: &mut Vec<Request>| waiting.is_empty() && !self.is_woken.swap(false, Ordering::Relaxed);
        let waited = self.put.wait_timeout_while(lock(&self.waiting), time, is_idle);
        let (mut waiting, _) = waited.unwrap_or_else(PoisonError::into_inner);
        self.has_any.store(false, Ordering::Relaxed);
        std::mem::take(&mut waiting)
    }

    fn count(&self, waiting: &[Request]) {
        let has_any = waiting.iter().any(|request| !request.is_query());
        self.has_any.store(has_any, Ordering::Relaxed);
    }
}

/// Whether the answer to an earlier request is of no use any more.
fn is_for_the_same(earlier: &Request, request: &Request) -> bool {
    match (earlier, request) {
        (Request::Film(_), Request::Film(_)) | (Request::View(_), Request::View(_)) => true,
        (Request::Pick(earlier), Request::Pick(request)) => earlier.by == request.by,
        (Request::Open(earlier), Request::Open(request)) => earlier.by == request.by,
        (Request::Depths(earlier), Request::Depths(request)) => earlier.by == request.by,
        (Request::Change(earlier), Request::Change(request)) => {
            (earlier.by, earlier.at, &earlier.name) == (request.by, request.at, &request.name)
        }
        (Request::Layer(earlier), Request::Layer(request)) => earlier == request,
        (Request::Values(earlier), Request::Values(request)) => earlier.by == request.by,
        (Request::Errors(_), Request::Errors(_)) | (Request::Reference(_), Request::Reference(_)) => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(text: &str) -> Request {
        serde_json::from_str(text).unwrap()
    }

    /// A page that moves the camera and then asks for a place means the new picture.
    #[test]
    fn questions_overtake_no_requests() {
        let (requests, is_over) = (Requests::default(), AtomicBool::new(false));
        let questions = || {
            let taken = requests.take_wanted(Duration::ZERO, Request::is_query, &is_over);
            taken.map(|questions| questions.len())
        };
        let pick = r#"{"type": "pick", "by": 1, "number": 2, "at": [0, 0]}"#;
        requests.put(request(pick));
        assert!(!requests.has_any());
        assert_eq!(questions(), Some(1));
        requests.put(request(r#"{"type": "view", "by": 1, "number": 1, "camera": {}}"#));
        requests.put(request(pick));
        assert!(requests.has_any());
        assert_eq!(questions(), Some(0));
        assert!(matches!(requests.take(Duration::ZERO)[..], [Request::View(_), Request::Pick(_)]));
        requests.put(request(pick));
        requests.end_wanted(&is_over);
        assert_eq!(questions(), None);
    }
}
