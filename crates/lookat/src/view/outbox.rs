//! What waits: messages for the pages, and requests of the pages.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError, Weak};
use std::time::Duration;

use tungstenite::Message;

use crate::view::messages::Request;
use crate::writer::lock;

/// The kinds of messages, in the order in which they are sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Topic {
    Scene,
    View,
    /// For the page with this number, as the next four.
    Picked(u32),
    Depths(u32),
    Changed(u32),
    Edited(u32),
    Values(u32),
    Looking,
    Reference,
    /// By its number.
    Layer(u8),
    Errors,
    Picture,
    Compared,
}

/// The messages that wait for one page.
#[derive(Default)]
pub struct Outbox {
    waiting: Mutex<Waiting>,
    told: Condvar,
}

#[derive(Default)]
struct Waiting {
    messages: BTreeMap<Topic, Message>,
    is_closed: bool,
}

impl Outbox {
    fn take_back(&self, topic: Topic) {
        lock(&self.waiting).messages.remove(&topic);
    }

    fn put(&self, topic: Topic, message: Message) {
        lock(&self.waiting).messages.insert(topic, message);
        self.told.notify_all();
    }

    /// Sends nothing more.
    pub fn close(&self) {
        lock(&self.waiting).is_closed = true;
        self.told.notify_all();
    }

    /// Waits for the next message. `None` once the box is closed.
    pub fn next(&self) -> Option<Message> {
        let mut waiting = lock(&self.waiting);
        loop {
            if waiting.is_closed {
                return None;
            }
            if let Some((_, message)) = waiting.messages.pop_first() {
                return Some(message);
            }
            waiting = self.told.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// All pages.
#[derive(Default)]
pub struct Hub(Mutex<Told>);

#[derive(Default)]
struct Told {
    pages: Vec<Weak<Outbox>>,
    /// What a new page is told first.
    newest: BTreeMap<Topic, Message>,
}

impl Hub {
    /// A box for a new page, with the news so far.
    pub fn join(&self) -> Arc<Outbox> {
        let outbox = Arc::new(Outbox::default());
        let mut told = lock(&self.0);
        for (topic, message) in &told.newest {
            outbox.put(*topic, message.clone());
        }
        told.pages.push(Arc::downgrade(&outbox));
        outbox
    }

    /// Takes back what is not true anymore, as far as it still waits.
    pub fn take_back(&self, topic: Topic) {
        let mut told = lock(&self.0);
        told.newest.remove(&topic);
        for page in told.pages.iter().filter_map(Weak::upgrade) {
            page.take_back(topic);
        }
    }

    /// Tells all pages.
    pub fn tell(&self, topic: Topic, message: impl Into<Message>) {
        let message = message.into();
        let mut told = lock(&self.0);
        told.pages.retain(|page| {
            page.upgrade().is_some_and(|page| {
                page.put(topic, message.clone());
                true
            })
        });
        // What a page has not asked for is nothing new for it.
        let is_for_all = matches!(topic, Topic::Scene | Topic::View | Topic::Looking | Topic::Reference);
        if is_for_all || matches!(topic, Topic::Errors | Topic::Picture | Topic::Compared) {
            told.newest.insert(topic, message);
        }
    }
}

/// The most requests that wait.
const MOST: usize = 64;

/// The requests that wait for the engine, in order.
#[derive(Default)]
pub struct Requests {
    waiting: Mutex<Vec<Request>>,
    put: Condvar,
    /// There may be room for another request.
    taken: Condvar,
    /// Whether a request waits that is no query, to be read without the lock.
    has_any: AtomicBool,
    /// Whether the engine has something else to do.
    is_woken: AtomicBool,
}

impl Requests {
    /// Replaces an earlier request for the same. Waits while too many others wait, so that none is lost: a page that floods the
    /// engine is read no faster than it is answered.
    pub fn put(&self, request: Request) {
        let is_full = |waiting: &mut Vec<Request>| {
            waiting.retain(|earlier| !earlier.is_outdated_by(&request));
            // Of these, only one waits.
            let is_single =
                matches!(request, Request::Film { .. } | Request::View(_) | Request::Errors { .. });
            waiting.len() >= MOST && !is_single
        };
        let waited = self.taken.wait_while(lock(&self.waiting), is_full);
        let mut waiting = waited.unwrap_or_else(PoisonError::into_inner);
        waiting.push(request);
        self.has_any.store(!waiting.iter().all(Request::is_query), Ordering::Relaxed);
        self.put.notify_all();
    }

    /// Puts queries that are not answered yet before the others, unless there are newer ones for the same.
    pub fn put_back(&self, queries: Vec<Request>) {
        let mut waiting = lock(&self.waiting);
        for query in queries.into_iter().rev() {
            if !waiting.iter().any(|later| query.is_outdated_by(later)) {
                waiting.insert(0, query);
            }
        }
    }

    /// Takes the queries that `accepts` names, after waiting at most `time` for the first. They overtake no request. `None` once
    /// they are stopped.
    pub fn take_queries(
        &self,
        time: Duration,
        accepts: impl Fn(&Request) -> bool,
        is_stopped: &AtomicBool,
    ) -> Option<Vec<Request>> {
        let is_stopped = || is_stopped.load(Ordering::Relaxed);
        let is_first =
            |waiting: &[Request]| waiting.iter().all(Request::is_query) && waiting.iter().any(&accepts);
        let is_idle = |waiting: &mut Vec<Request>| !is_stopped() && !is_first(waiting);
        let waited = self.put.wait_timeout_while(lock(&self.waiting), time, is_idle);
        let (mut waiting, _) = waited.unwrap_or_else(PoisonError::into_inner);
        if is_stopped() {
            return None;
        }
        let may_take = is_first(&waiting);
        let queries = waiting.extract_if(.., |request| may_take && accepts(request)).collect();
        self.taken.notify_all();
        Some(queries)
    }

    /// Ends the waiting for queries.
    pub fn stop_queries(&self, is_stopped: &AtomicBool) {
        // With the lock, nobody is between looking and waiting.
        let _waiting = lock(&self.waiting);
        is_stopped.store(true, Ordering::Relaxed);
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
        self.taken.notify_all();
        std::mem::take(&mut waiting)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_gets_the_newest_message_of_each_kind() {
        let hub = Hub::default();
        let early = hub.join();
        for text in ["1", "2"] {
            hub.tell(Topic::Picture, text);
            hub.tell(Topic::Picked(1), text);
        }
        hub.tell(Topic::Scene, "scene");
        hub.tell(Topic::Reference, "reference");
        hub.take_back(Topic::Reference);
        let late = hub.join();
        let all = |outbox: &Outbox| {
            std::iter::from_fn(|| lock(&outbox.waiting).messages.pop_first())
                .map(|(_, it)| it)
                .collect::<Vec<_>>()
        };
        assert_eq!(all(&early), ["scene", "2", "2"].map(Message::from));
        assert_eq!(all(&late), ["scene", "2"].map(Message::from));
        early.close();
        assert_eq!(early.next(), None);
    }

    fn request(text: &str) -> Request {
        serde_json::from_str(text).unwrap()
    }

    /// A page that moves the camera and then asks for a place means the new picture.
    #[test]
    fn queries_overtake_no_requests() {
        let (requests, is_stopped) = (Requests::default(), AtomicBool::new(false));
        let queries =
            || requests.take_queries(Duration::ZERO, |_| true, &is_stopped).map(|queries| queries.len());
        let pick = r#"{"type": "pick", "by": 1, "number": 2, "at": [0, 0]}"#;
        requests.put(request(pick));
        assert!(!requests.has_any());
        assert_eq!(queries(), Some(1));
        requests.put(request(r#"{"type": "view", "by": 1, "number": 1, "camera": {}}"#));
        requests.put(request(pick));
        assert!(requests.has_any());
        assert_eq!(queries(), Some(0));
        assert!(matches!(requests.take(Duration::ZERO)[..], [Request::View(_), Request::Pick { .. }]));
        requests.put(request(pick));
        requests.stop_queries(&is_stopped);
        assert_eq!(queries(), None);
    }
    /// A page that asks faster than the engine answers waits, and loses nothing. Pages share the camera, so it never waits.
    #[test]
    fn no_request_is_dropped() {
        const PICKS: usize = 1000;
        let requests = Requests::default();
        let (mut picks, mut views) = (0, 0);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for by in 0..PICKS {
                    requests.put(request(&format!(
                        r#"{{"type": "pick", "by": {by}, "number": 2, "at": [0, 0]}}"#
                    )));
                }
            });
            let end = std::time::Instant::now() + Duration::from_secs(60);
            while lock(&requests.waiting).len() < MOST {
                assert!(std::time::Instant::now() < end);
            }
            requests.put(request(r#"{"type": "view", "by": 1, "number": 1, "camera": {}}"#));
            while picks < PICKS {
                assert!(std::time::Instant::now() < end);
                let taken = requests.take(Duration::from_millis(10));
                assert!(taken.len() <= MOST + 1);
                views += taken.iter().filter(|request| matches!(request, Request::View(_))).count();
                picks += taken.iter().filter(|request| request.is_query()).count();
            }
        });
        assert_eq!((picks, views), (PICKS, 1));
    }
}
