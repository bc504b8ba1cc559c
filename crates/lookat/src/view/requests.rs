//! What the pages ask for: the newest request of each kind, and each edit.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use super::messages::{Edit, Pick, Request, SetFilm, SetView};

/// The most edits that wait.
const MOST_EDITS: usize = 16;

/// The requests that wait for the engine.
#[derive(Default)]
pub struct Requests {
    pending: Mutex<Pending>,
    put: Condvar,
    /// Whether one waits, to be read without the lock.
    has_any: AtomicBool,
    /// Whether the engine has something else to do.
    is_woken: AtomicBool,
}

/// The newest request of each kind.
#[derive(Default)]
pub struct Pending {
    pub film: Option<SetFilm>,
    pub view: Option<SetView>,
    /// The newest of each page.
    pub picks: Vec<Pick>,
    /// All of them, in order.
    pub edits: Vec<Edit>,
}

impl Pending {
    pub fn is_any(&self) -> bool {
        self.film.is_some() || self.view.is_some() || !self.picks.is_empty() || !self.edits.is_empty()
    }
}

impl Requests {
    pub fn put(&self, request: Request) {
        let mut pending = self.pending.lock().unwrap_or_else(PoisonError::into_inner);
        match request {
            Request::Film(film) => pending.film = Some(film),
            Request::View(view) => pending.view = Some(view),
            Request::Pick(pick) => {
                pending.picks.retain(|other| other.by != pick.by);
                pending.picks.push(pick);
            }
            Request::Edit(_) if pending.edits.len() >= MOST_EDITS => return,
            Request::Edit(edit) => pending.edits.push(edit),
        }
        self.has_any.store(true, Ordering::Relaxed);
        self.put.notify_all();
    }

    /// Takes the request about a place alone: it can be answered while a picture is rendered.
    pub fn take_pick(&self) -> Option<Pick> {
        if !self.has_any() {
            return None;
        }
        let mut pending = self.pending.lock().unwrap_or_else(PoisonError::into_inner);
        let pick = pending.picks.pop();
        self.has_any.store(pending.is_any(), Ordering::Relaxed);
        pick
    }

    pub fn has_any(&self) -> bool {
        self.has_any.load(Ordering::Relaxed)
    }

    /// Ends waiting: a file has changed.
    pub fn wake(&self) {
        let _pending = self.pending.lock().unwrap_or_else(PoisonError::into_inner);
        self.is_woken.store(true, Ordering::Relaxed);
        self.put.notify_all();
    }

    /// Takes all requests, after waiting at most `time` for the first or until woken.
    pub fn take(&self, time: Duration) -> Pending {
        let pending = self.pending.lock().unwrap_or_else(PoisonError::into_inner);
        let is_idle = |_: &mut Pending| !self.has_any() && !self.is_woken.swap(false, Ordering::Relaxed);
        let waited = self.put.wait_timeout_while(pending, time, is_idle);
        let (mut pending, _) = waited.unwrap_or_else(PoisonError::into_inner);
        self.has_any.store(false, Ordering::Relaxed);
        std::mem::take(&mut pending)
    }
}
