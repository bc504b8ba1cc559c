//! Names with scopes.

use std::collections::HashMap;

/// The names defined in the current block and the blocks around it.
///
/// The end of a block undoes its definitions one by one. Copying all names for each block, as pbrt-v3 does, takes
/// time and memory proportional to names times blocks.
pub(crate) struct Names<T> {
    known: HashMap<String, T>,
    /// The values that definitions replaced.
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

    /// The number of definitions so far, as input for `take_back`.
    pub fn definitions(&self) -> usize {
        self.replaced.len()
    }

    /// Undoes all definitions after the first `definitions`.
    pub fn take_back(&mut self, definitions: usize) {
        for (name, before) in self.replaced.drain(definitions..).rev() {
            match before {
                Some(value) => self.known.insert(name, value),
                None => self.known.remove(&name),
            };
        }
    }
}
