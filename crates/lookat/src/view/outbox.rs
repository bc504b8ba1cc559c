//! What the pages are told: the newest message of each kind, so that a slow page holds up nobody and takes no memory.

use std::collections::BTreeMap;
use std::sync::{Arc, Condvar, Mutex, PoisonError, Weak};

use tungstenite::Message;

use crate::lock::lock;

/// The kinds of messages, in the order in which they are sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
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
    messages: BTreeMap<Kind, Message>,
    is_closed: bool,
}

impl Outbox {
    fn take_back(&self, kind: Kind) {
        lock(&self.waiting).messages.remove(&kind);
    }

    fn put(&self, kind: Kind, message: Message) {
        lock(&self.waiting).messages.insert(kind, message);
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
    newest: BTreeMap<Kind, Message>,
}

impl Hub {
    /// A box for a new page, with the news so far.
    pub fn join(&self) -> Arc<Outbox> {
        let outbox = Arc::new(Outbox::default());
        let mut told = lock(&self.0);
        told.newest.iter().for_each(|(kind, message)| outbox.put(*kind, message.clone()));
        told.pages.push(Arc::downgrade(&outbox));
        outbox
    }

    /// Takes back what is not true anymore, as far as it still waits.
    pub fn take_back(&self, kind: Kind) {
        let mut told = lock(&self.0);
        told.newest.remove(&kind);
        told.pages.iter().filter_map(Weak::upgrade).for_each(|page| page.take_back(kind));
    }

    /// Tells all pages.
    pub fn tell(&self, kind: Kind, message: Message) {
        let mut told = lock(&self.0);
        told.pages.retain(|page| {
            page.upgrade().is_some_and(|page| {
                page.put(kind, message.clone());
                true
            })
        });
        // What a page has not asked for is nothing new for it.
        let is_for_all = matches!(kind, Kind::Scene | Kind::View | Kind::Looking | Kind::Reference);
        if is_for_all || matches!(kind, Kind::Errors | Kind::Picture | Kind::Compared) {
            told.newest.insert(kind, message);
        }
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
            hub.tell(Kind::Picture, text.into());
            hub.tell(Kind::Picked(1), text.into());
        }
        hub.tell(Kind::Scene, "scene".into());
        hub.tell(Kind::Reference, "reference".into());
        hub.take_back(Kind::Reference);
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
}
