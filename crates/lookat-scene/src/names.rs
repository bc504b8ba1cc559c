//! Names and what they stand for.

use lookat_syntax::Text;
use rpds::HashTrieMap;

use crate::report::Report;
use crate::symbols::{SymbolId, SymbolKind};

/// The names of one kind that are defined at a place of the scene. A copy, which a block saves, shares them: copying all names for each
/// block, as pbrt-v3 does, takes time and memory proportional to names times blocks.
#[derive(Clone)]
pub(crate) struct Names<T> {
    kind: SymbolKind,
    known: HashTrieMap<String, Named<T>>,
}

#[derive(Clone)]
struct Named<T> {
    value: T,
    /// `None` for a name that pbrt-v3 defines itself.
    symbol: Option<SymbolId>,
}

impl<T: Clone> Names<T> {
    pub fn new(kind: SymbolKind) -> Self {
        Names { kind, known: HashTrieMap::new() }
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
        self.known.insert_mut(name.value.clone(), Named { value, symbol: Some(symbol) });
        symbol
    }

    /// Defines a name that has no symbol.
    pub fn define_builtin(&mut self, name: &str, value: T) {
        self.known.insert_mut(name.into(), Named { value, symbol: None });
    }
}
