//! Objects: their definition and their instances.

use lookat_syntax::{Diagnostic, Span, Text};

use super::Resolver;
use crate::state::{Open, Saved};
use crate::symbols::SymbolKind;

impl Resolver<'_> {
    pub(super) fn define_object(&mut self, name: Text, object: usize, at: Span) {
        let is_empty = |object: usize| self.draft.objects[object].primitives.is_empty();
        let known = self.definitions.objects.get(&name.value).filter(|known| !is_empty(**known));
        if known.is_some() && !name.value.is_empty() {
            self.facts.redefined.push((SymbolKind::Object, name.value.clone(), at));
        }
        let symbol = self.definitions.objects.define(&name, object, &mut self.report);
        if !is_empty(object) {
            self.facts.objects.push((at, symbol));
        }
    }

    pub(super) fn object_begin(&mut self, name: Text, at: Span) -> Result<(), Box<Diagnostic>> {
        self.end_forgotten_object();
        let saved = Saved::new(&self.state, &self.definitions);
        let Some(outer) = self.open_object() else {
            if self.begin(Open::Object { saved, name: Some(name), at }) {
                self.draft.open = Some(self.draft.new_object());
            }
            return Ok(());
        };
        // Its ObjectEnd and its instances are not errors.
        self.begin(Open::Object { saved, name: None, at });
        if self.definitions.objects.get(&name.value).is_none() {
            self.definitions.objects.define(&name, self.draft.new_object(), &mut self.report);
        }
        Err(Box::new(
            Diagnostic::error(at, "ObjectBegin inside the definition of an object")
                .related(outer, "the outer object begins here"),
        ))
    }

    pub(super) fn object_instance(&mut self, name: Text) -> Result<(), Box<Diagnostic>> {
        self.end_forgotten_object();
        if let Some(outer) = self.open_object() {
            return Err(Box::new(
                Diagnostic::error(name.span, "ObjectInstance inside the definition of an object")
                    .related(outer, "the object begins here"),
            ));
        }
        if let Some(object) = self.definitions.objects.find(&name, &mut self.report) {
            self.draft.instances.push((*object, self.state.ctm));
        }
        Ok(())
    }

    /// The place of the outermost open object.
    fn open_object(&self) -> Option<Span> {
        self.blocks.open.iter().find(|open| open.is_object()).map(Open::at)
    }

    /// Ends an object that an AttributeEnd crossed and no ObjectEnd closed, and reports the missing ObjectEnd.
    pub(super) fn end_forgotten_object(&mut self) {
        if self.blocks.crossed.is_none() || !self.blocks.open.last().is_some_and(Open::is_object) {
            return;
        }
        if let (Some(at), Some(open)) = (self.blocks.crossed.take(), self.blocks.open.pop()) {
            let error = Diagnostic::error(at, "ObjectEnd is missing before this AttributeEnd");
            self.report.push(error.related(open.at(), "the object begins here"));
            self.restore(open);
        }
    }
}
