//! Names with scopes.

use std::collections::HashMap;

/// The names that are defined in the current block and around it.
///
/// Leaving a block takes its definitions back one by one. A copy of all names for each block, as pbrt-v3 makes where one
/// is defined, takes time and memory in proportion to their product.
pub(crate) struct Names<T> {
    known: HashMap<String, T>,
    /// What each definition replaced.
    replaced: Vec<(String, Option<T>)>,
}

impl<T> Default for Names<T> {
    fn default() -> Self {
        Names { known: HashMap::new(), replaced: Vec::new() }
    }
}

impl<T> Names<T> {
    pub fn get(&self, name: &str) -> Option<&T> {
        self.known.get(name)
    }

    pub fn keys(&self) -> impl Iterator<Item = &String> {
        self.known.keys()
    }

    pub fn define(&mut self, name: String, value: T) {
        let before = self.known.insert(name.clone(), value);
        self.replaced.push((name, before));
    }

    /// The number of definitions so far, for `take_back`.
    pub fn definitions(&self) -> usize {
        self.replaced.len()
    }

    /// Takes back all definitions but the first ones.
    pub fn take_back(&mut self, definitions: usize) {
        for (name, before) in self.replaced.drain(definitions..).rev() {
            match before {
                Some(value) => self.known.insert(name, value),
                None => self.known.remove(&name),
            };
        }
    }
}
