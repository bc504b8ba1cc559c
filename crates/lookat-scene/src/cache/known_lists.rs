//! Long lists of a text that the file had before, too.

use std::collections::HashMap;
use std::sync::Arc;

use bytes::Bytes;
use lookat_syntax::{LongList, ParamType};
use rayon::prelude::*;

use super::KeptText;

/// Finds lists of a text that the file had before, too.
pub(crate) struct KnownLists {
    before: Option<Arc<KeptText>>,
    pub(super) text: Bytes,
    /// The list after the last one that was found.
    next: usize,
    /// The numbers of the lists that were found, by their places.
    pub(super) found: HashMap<u32, u64>,
}

/// So many lists are compared: most are the next one, unless lists are gone or in another order.
const MOST_COMPARED: usize = 64;

impl KnownLists {
    pub(super) fn new(before: Option<Arc<KeptText>>, text: Bytes) -> KnownLists {
        KnownLists { before, text, next: 0, found: HashMap::new() }
    }

    /// The length of the list at a place, if it was there before.
    pub fn find(&mut self, ty: ParamType, at: usize) -> Option<usize> {
        let before = self.before.as_ref()?;
        let here = &self.text[at..];
        // Most lists are short.
        if here.len() < LongList::BYTES || here[..LongList::BYTES - 1].contains(&b']') {
            return None;
        }
        let is_same_text = std::ptr::eq(&*before.text, &*self.text);
        let is_here = |index: &usize| {
            let (list, _) = &before.lists[*index];
            list.ty == ty
                && match is_same_text {
                    true => list.span.start as usize == at,
                    false => starts_with(here, &before.text[range(list)]),
                }
        };
        let from_next = (self.next..before.lists.len()).chain(0..self.next);
        let found = from_next.take(MOST_COMPARED).find(is_here)?;
        let (list, number) = before.lists[found];
        self.next = found + 1;
        self.found.insert(at as u32, number);
        Some(range(&list).len())
    }
}

/// Whether a text starts with another. Threads share the work.
fn starts_with(text: &[u8], start: &[u8]) -> bool {
    const GRAIN: usize = 1 << 20;
    let same = |(a, b): (&[u8], &[u8])| a == b;
    text.len() >= start.len() && text[..start.len()].par_chunks(GRAIN).zip(start.par_chunks(GRAIN)).all(same)
}

/// The place of a list in its text.
pub(super) fn range(list: &LongList) -> std::ops::Range<usize> {
    list.span.start as usize..list.span.end as usize
}
