//! Directives for the page: their parameters from the schema, and the values that the text gives them.

use lookat_scene::schema::{Count, Effect, Kind};
use lookat_scene::syntax::{self, EntityKind, Param, Span};
use lookat_scene::{Sources, kinds};

use super::messages::{Described, Given, Parameter, Place, Values};
use crate::directive_text::DirectiveText;
use crate::explain::show::as_json;

/// The directive around a place. `None` for one without a type.
pub fn describe(sources: &Sources, place: Span, reading: u32) -> Option<Described> {
    let found = DirectiveText::at(sources, place)?;
    let kind = kind_of(&found)?;
    // Pages cannot show long lists; another type has other parameters.
    let parameters = kind.parameters().filter(|parameter| {
        let is_used = matches!(parameter.effect, Effect::Rendered | Effect::Own);
        parameter.count != Count::List && is_used && parameter.name != "type"
    });
    let described =
        |parameter| Parameter { facts: as_json(&parameter), given: found.param(parameter.name).map(given) };
    Some(Described {
        directive: kind.directive,
        kind: kind.name,
        name: is_named(&found).then(|| found.entity.name.value.clone()),
        place: Place::new(found.entity.name.span, sources, reading),
        parameters: parameters.map(described).collect(),
    })
}

/// The type of a directive in the schema.
pub fn kind_of(found: &DirectiveText) -> Option<&'static Kind> {
    let name = match found.param("type").map(|param| &param.values.value) {
        Some(syntax::Values::Strings(names)) if is_named(found) => &names.first()?.value,
        _ => &found.entity.name.value,
    };
    kinds().find(|kind| kind.directive == found.kind.keyword() && kind.name == name)
}

/// Whether the directive has a name in place of its type.
fn is_named(found: &DirectiveText) -> bool {
    found.kind == EntityKind::MakeNamedMaterial
}

fn given(param: &Param) -> Given {
    let whole = |list: &[i32]| list.iter().map(|value| f64::from(*value)).collect();
    let values = match &param.values.value {
        syntax::Values::Integers(list) => Values::Numbers(whole(list)),
        syntax::Values::Numbers(list) => Values::Numbers(list.clone()),
        syntax::Values::Pairs(list) => Values::Numbers(list.as_flattened().to_vec()),
        syntax::Values::Triples(list) => Values::Numbers(list.as_flattened().to_vec()),
        syntax::Values::Bools(list) => Values::Words(list.iter().map(bool::to_string).collect()),
        syntax::Values::Strings(list) => Values::Words(list.iter().map(|text| text.value.clone()).collect()),
    };
    Given { ty: param.ty.name(), values }
}
