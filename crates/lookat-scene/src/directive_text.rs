//! Directives in the text of a scene, and changes of their parameters.

use lookat_syntax::{
    Directive, Entity, EntityKind, Fix, Param, ParamType, Span, Values, statement_at, value_span,
};

use crate::sources::Sources;

/// A directive with parameters, in its text.
pub struct DirectiveText<'s> {
    text: &'s [u8],
    /// The directive.
    pub kind: EntityKind,
    /// Its type and parameters, with their places.
    pub entity: Entity,
}

impl<'s> DirectiveText<'s> {
    /// The directive around a place. `None` if there is none, or one without parameters.
    pub fn at(sources: &'s Sources, place: Span) -> Option<DirectiveText<'s>> {
        let text = &sources.files.get(place.file.0 as usize)?.text[..];
        match statement_at(text, place)?.directive {
            Directive::Entity(kind, entity) => Some(DirectiveText { text, kind, entity }),
            _ => None,
        }
    }

    /// The parameter of this name that counts.
    pub fn param(&self, name: &str) -> Option<&Param> {
        self.entity.params.iter().rev().find(|param| param.name.value == name)
    }

    /// The changes that give a parameter these values, as words of the text. In a list of the same type, only the words that differ
    /// change.
    pub fn set(&self, ty: ParamType, name: &str, words: &[String]) -> Vec<Fix> {
        let list = if let [word] = words { word.clone() } else { format!("[{}]", words.join(" ")) };
        let replacement = format!("\"{} {name}\" {list}", ty.name());
        match self.param(name) {
            Some(param) if param.ty == ty && count(&param.values.value) == words.len() => {
                words.iter().enumerate().filter_map(|(at, word)| self.replace(param, at, word)).collect()
            }
            Some(param) => vec![Fix { span: param.span(), replacement }],
            None => {
                let last = self.entity.params.last().map_or(self.entity.name.span, Param::span);
                let span = Span { start: last.end, ..last };
                vec![Fix { span, replacement: format!(" {replacement}") }]
            }
        }
    }

    /// The change of a value, if it differs.
    fn replace(&self, param: &Param, at: usize, word: &str) -> Option<Fix> {
        let span = value_span(self.text, param.values.span, at);
        let before = std::str::from_utf8(&self.text[span.start as usize..span.end as usize]).ok()?;
        let number = |word: &str| word.parse::<f64>().ok();
        let is_same = before == word || number(before).is_some_and(|before| number(word) == Some(before));
        (!is_same).then(|| Fix { span, replacement: word.to_owned() })
    }
}

/// The words of a list of values.
fn count(values: &Values) -> usize {
    let each = match values {
        Values::Pairs(_) => 2,
        Values::Triples(_) => 3,
        _ => 1,
    };
    each * values.len()
}
