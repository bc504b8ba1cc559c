//! Names with scopes.

use std::collections::HashMap;

use lookat_syntax::Text;

use crate::report::Report;
use crate::symbols::{SymbolId, SymbolKind};

/// The names of one kind that are defined in the current block and the blocks around it, or everywhere if the kind has no
/// scopes.
///
/// The end of a block undoes its definitions one by one. Copying all names for each block, as pbrt-v3 does, takes
/// time and memory proportional to names times blocks.
pub(crate) struct Names<T> {
    kind: SymbolKind,
    known: HashMap<String, Named<T>>,
    /// The values that definitions replaced.
    replaced: Vec<(String, Option<Named<T>>)>,
}

struct Named<T> {
    value: T,
    /// `None` for a name that pbrt-v3 defines itself.
    symbol: Option<SymbolId>,
}

impl<T> Names<T> {
    pub fn new(kind: SymbolKind) -> Self {
        Names { kind, known: HashMap::new(), replaced: Vec::new() }
    }

    pub fn kind(&self) -> SymbolKind {
        self.kind
    }

    pub fn get(&self, name: &str) -> Option<&T> {
        self.known.get(name).map(|named| &named.value)
    }

    /// The definition of a name.
    pub fn symbol(&self, name: &str) -> Option<SymbolId> {
        self.known.get(name)?.symbol
    }

    /// The value of a name, and one more use of it. Reports an undefined name.
    pub fn find(&self, name: &Text, report: &mut Report) -> Option<&T> {
        match self.known.get(&name.value) {
            Some(Named { value, symbol }) => {
                if let Some(symbol) = symbol {
                    report.symbols.use_at(*symbol, name.span);
                }
                Some(value)
            }
            None => {
                report.undefined(self.kind, name, self.known.keys());
                None
            }
        }
    }

    pub fn define(&mut self, name: &Text, value: T, report: &mut Report) -> SymbolId {
        let symbol = report.symbols.define(self.kind, name);
        self.insert(name.value.clone(), value, Some(symbol));
        symbol
    }

    /// Defines a name that has no symbol.
    pub fn define_builtin(&mut self, name: &str, value: T) {
        self.insert(name.into(), value, None);
    }

    fn insert(&mut self, name: String, value: T, symbol: Option<SymbolId>) {
        if !self.kind.is_scoped() {
            self.known.insert(name, Named { value, symbol });
            return;
        }
        let before = self.known.insert(name.clone(), Named { value, symbol });
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
