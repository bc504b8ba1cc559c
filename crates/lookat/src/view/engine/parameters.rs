//! Other values of parameters, as pages ask for them: the scene is read with them, and no file is written.

use lookat_scene::Sources;
use lookat_scene::syntax::{EntityKind, Fix, ParamType};

use super::Engine;
use crate::directive_text::DirectiveText;
use crate::view::describe::{describe, kind_of};
use crate::view::messages::{At, Change, Changed, News, Values};
use crate::view::outbox::Kind;
use crate::view::write::changes;

/// The directives that pages can change.
const CHANGEABLE: [EntityKind; 4] = [
    EntityKind::Material,
    EntityKind::MakeNamedMaterial,
    EntityKind::AreaLightSource,
    EntityKind::LightSource,
];

impl Engine {
    pub(super) fn change(&mut self, change: Change) {
        let (mut places, mut refused) = (change.shown.clone(), None);
        match self.try_change(&change) {
            Ok(fixes) => places.iter_mut().for_each(|at| *at = moved(*at, &fixes, self.reading)),
            Err(reason) => refused = Some(reason),
        }
        let sources = self.opened.as_ref().map(|opened| opened.sources());
        let current = places.iter().filter(|at| at.reading == self.reading);
        let directives = current.filter_map(|at| describe(sources?, at.span(), self.reading)).collect();
        let changed = Changed { by: change.by, number: change.number, directives, refused };
        self.hub.tell(Kind::Changed(change.by), News::Changed(changed).message());
    }

    /// Reads the scene with other values. Fails with the reason, and changes nothing.
    fn try_change(&mut self, change: &Change) -> Result<Vec<Fix>, String> {
        let opened = self.opened.as_ref().filter(|_| change.at.reading == self.reading);
        let sources = opened.ok_or("the file has changed: point at the shape again")?.sources();
        let fixes = fixes(sources, change)?;
        let before = self.unsaved.clone();
        self.unsaved.add(
            format!("{} {} {}", change.at.file, change.at.start, change.name),
            changes(sources, &fixes)?,
        );
        let loaded = self.load_once();
        let read = match loaded.scene {
            Some(_) => self.open(loaded),
            None => Err(first_error(&loaded)),
        };
        match &read {
            Ok(()) => {
                self.has_lost = false;
                self.tell_scene(None);
            }
            Err(_) => self.unsaved = before,
        }
        read.map(|()| fixes)
    }
}

/// The changes of the text. Fails with the reason why there is none.
fn fixes(
    sources: &Sources,
    Change { at, name, value_type, values, .. }: &Change,
) -> Result<Vec<Fix>, String> {
    let found = DirectiveText::at(sources, at.span()).filter(|found| CHANGEABLE.contains(&found.kind));
    let found = found.ok_or("there is no material and no light")?;
    let ty =
        ParamType::from_spelling(value_type).ok_or_else(|| format!("there is no type \"{value_type}\""))?;
    let mut known = kind_of(&found).into_iter().flat_map(|kind| kind.parameters());
    let parameter = known.find(|parameter| parameter.name == name);
    let parameter = parameter.ok_or_else(|| format!("there is no parameter \"{name}\""))?;
    // The text of a page may not make the program open files.
    let is_closed = matches!(ty, ParamType::Bool | ParamType::Texture) || !parameter.range.is_empty();
    if matches!(values, Values::Words(_)) && !is_closed {
        return Err(format!("change \"{name}\" in the file: the page cannot name files"));
    }
    let words: Vec<String> = match values {
        Values::Numbers(numbers) if numbers.iter().all(|number| number.is_finite()) => {
            numbers.iter().map(f64::to_string).collect()
        }
        Values::Words(words) if words.iter().all(|word| !word.contains(['"', '\\', '\n', '\r'])) => {
            words.iter().map(|word| format!("\"{word}\"")).collect()
        }
        _ => return Err("this value cannot be written".into()),
    };
    Ok(found.set(ty, name, &words))
}

/// A place after changes before it.
fn moved(at: At, fixes: &[Fix], reading: u32) -> At {
    let before = fixes.iter().filter(|fix| fix.span.file.0 == at.file && fix.span.start < at.start);
    let grown: i64 =
        before.map(|fix| fix.replacement.len() as i64 - i64::from(fix.span.end - fix.span.start)).sum();
    At { reading, start: (i64::from(at.start) + grown).max(0) as u32, ..at }
}

/// The message of the first error.
fn first_error(loaded: &lookat_scene::Loaded) -> String {
    use lookat_scene::syntax::Severity;
    let error = loaded.diagnostics.iter().find(|diagnostic| diagnostic.severity == Severity::Error);
    error.map(|error| error.message.clone()).or(loaded.override_error.clone()).unwrap_or_default()
}
