//! What a load keeps for the next load of a scene: texts with their long lists, meshes and pictures.

use std::any::{Any, TypeId};
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use bytes::Bytes;
use lookat_image::Wrap;
use lookat_syntax::{LongList, ParamType};
use rayon::prelude::*;

use crate::Mesh;
use crate::mesh::Oddities;

/// Tells one version of a file from another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Stamp {
    /// The time of the last change, if the system tells it.
    pub modified: Option<SystemTime>,
    /// The bytes of the file.
    pub length: u64,
    /// The number of the file, which changes if another one is renamed to it. 0 if the system tells none.
    pub number: u64,
}

/// A function that gives the stamp that a file had before it was opened. `None` for a file that may change without a new stamp, which
/// is read again.
pub type Stamped<'a> = dyn Fn(&Path) -> Option<Stamp> + 'a;

/// The texts, meshes and pictures of the last load without errors. The scene shares them.
#[derive(Default)]
pub struct LoadCache {
    pub(crate) kept: Kept,
}

/// Texts, meshes and pictures.
#[derive(Default)]
pub(crate) struct Kept {
    texts: HashMap<PathBuf, Arc<KeptText>>,
    meshes: HashMap<MeshKey, KeptMesh>,
    pictures: HashMap<KeptPictureKey, Arc<dyn Any + Send + Sync>>,
    /// The number of the next list that is new.
    next_list: u64,
}

/// The text of a file.
pub(crate) struct KeptText {
    text: Bytes,
    stamp: Option<Stamp>,
    /// Its long lists, each with a number: lists of equal numbers have equal bytes and types.
    lists: Vec<(LongList, u64)>,
}

/// All that a mesh depends on.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum MeshKey {
    /// The lists of a directive.
    Lists(Vec<(String, ParamType, List)>, TransformBits),
    /// A file.
    File(PathBuf, Stamp, TransformBits),
}

/// The text of a list.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum List {
    /// A long list, by its number.
    Long(u64),
    Short(Vec<u8>),
}

/// The bits of a transformation and of its inverse.
pub(crate) type TransformBits = [[u64; 12]; 2];

/// A mesh, and what is reported about it.
#[derive(Debug, Clone)]
pub(crate) struct KeptMesh {
    pub mesh: Arc<Mesh>,
    /// Triangles without area.
    pub flat: usize,
    /// What is odd about its file.
    pub oddities: Oddities,
}

/// The file and its settings, its version, and the type of the texels.
type KeptPictureKey = (PictureKey, Stamp, TypeId);

/// The settings for decoding a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct PictureSettings {
    pub wrap: Wrap,
    /// True to convert from sRGB to linear.
    pub gamma: bool,
    /// The bits of the factor on the linear values, which compare and hash.
    pub scale: u32,
    /// True if the first row is the bottom row, as in texture coordinates.
    pub bottom_up: bool,
    /// True to clamp negative values to 0, for pictures of light.
    pub not_negative: bool,
}

/// The file and its settings.
pub(crate) type PictureKey = (PathBuf, PictureSettings);

/// The access of a load to what the one before has kept.
#[derive(Clone, Copy)]
pub(crate) struct Reuse<'a> {
    pub stamp: &'a Stamped<'a>,
    pub old: &'a Kept,
    pub new: &'a RefCell<Kept>,
}

impl Kept {
    /// Nothing, for a load after this one.
    pub fn next(&self) -> RefCell<Kept> {
        RefCell::new(Kept { next_list: self.next_list, ..Kept::default() })
    }
}

impl Reuse<'_> {
    fn kept_text(&self, path: &Path) -> Option<Arc<KeptText>> {
        self.new.borrow().texts.get(path).or(self.old.texts.get(path)).cloned()
    }

    /// The text of a file that has not changed.
    pub fn text(&self, path: &Path) -> Option<Bytes> {
        let stamp = (self.stamp)(path)?;
        self.kept_text(path).filter(|kept| kept.stamp == Some(stamp)).map(|kept| kept.text.clone())
    }

    /// The bytes that a file had before.
    pub fn length(&self, path: &Path) -> Option<usize> {
        self.kept_text(path).map(|kept| kept.text.len())
    }

    /// Keeps a text. Looks for its lists in the text that the file had before.
    pub fn keep_text(&self, path: &Path, text: Bytes) -> KnownLists {
        let known = KnownLists::new(self.kept_text(path), text.clone());
        let kept = KeptText { text, stamp: (self.stamp)(path), lists: Vec::new() };
        self.new.borrow_mut().texts.insert(path.to_owned(), Arc::new(kept));
        known
    }

    /// Keeps the next lists of a text.
    pub fn keep_lists(&self, path: &Path, known: &KnownLists, lists: Vec<LongList>) {
        let Kept { texts, next_list, .. } = &mut *self.new.borrow_mut();
        // Nothing else uses a text before its end.
        let Some(kept) = texts.get_mut(path).and_then(Arc::get_mut) else { return };
        kept.lists.extend(lists.into_iter().map(|list| {
            let number = known.found.get(&list.span.start).copied().unwrap_or_else(|| {
                *next_list += 1;
                *next_list
            });
            (list, number)
        }));
    }

    /// The number of the long list at a place.
    pub fn list_number(&self, path: &Path, start: u32) -> Option<u64> {
        let new = self.new.borrow();
        let lists = &new.texts.get(path)?.lists;
        let at = lists.binary_search_by_key(&start, |(list, _)| list.span.start).ok()?;
        Some(lists[at].1)
    }

    /// The mesh for a key.
    pub fn mesh(&self, key: &MeshKey) -> Option<KeptMesh> {
        let known = self.new.borrow().meshes.get(key).cloned();
        known.or_else(|| {
            let kept = self.old.meshes.get(key)?;
            self.keep_mesh(key.clone(), kept.clone());
            Some(kept.clone())
        })
    }

    pub fn keep_mesh(&self, key: MeshKey, mesh: KeptMesh) {
        self.new.borrow_mut().meshes.insert(key, mesh);
    }

    /// The picture for a key.
    pub fn picture<T: Any + Send + Sync>(&self, key: &PictureKey) -> Option<Arc<T>> {
        let key = (key.clone(), (self.stamp)(&key.0)?, TypeId::of::<T>());
        let kept = self.old.pictures.get(&key)?.clone();
        self.new.borrow_mut().pictures.insert(key, kept.clone());
        kept.downcast().ok()
    }

    /// True if the last load has kept a picture of this file.
    pub fn has_picture(&self, path: &Path) -> bool {
        self.old.pictures.keys().any(|((known, _), ..)| known == path)
    }

    pub fn keep_picture<T: Any + Send + Sync>(&self, key: &PictureKey, picture: &Arc<T>) {
        if let Some(stamp) = (self.stamp)(&key.0) {
            let key = (key.clone(), stamp, TypeId::of::<T>());
            self.new.borrow_mut().pictures.insert(key, picture.clone());
        }
    }
}

/// Finds lists of a text that the file had before, too.
pub(crate) struct KnownLists {
    before: Option<Arc<KeptText>>,
    pub(super) text: Bytes,
    /// The list after the last one that was found.
    next: usize,
    /// The numbers of the lists that were found, by their places.
    pub(super) found: HashMap<u32, u64>,
}

/// The most lists to compare: usually the next one matches, unless lists are gone or in another order.
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
                && if is_same_text {
                    list.span.start as usize == at
                } else {
                    starts_with(here, &before.text[range(list)])
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

/// True if a text starts with another. Threads share the work.
fn starts_with(text: &[u8], start: &[u8]) -> bool {
    const GRAIN: usize = 1 << 20;
    let same = |(a, b): (&[u8], &[u8])| a == b;
    text.len() >= start.len() && text[..start.len()].par_chunks(GRAIN).zip(start.par_chunks(GRAIN)).all(same)
}

/// The place of a list in its text.
pub(super) fn range(list: &LongList) -> std::ops::Range<usize> {
    list.span.start as usize..list.span.end as usize
}

#[cfg(test)]
mod tests;
