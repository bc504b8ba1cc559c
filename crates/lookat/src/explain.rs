//! `lookat explain`: the directives, types and parameters of the format.

use std::collections::HashSet;
use std::fmt::Write;
use std::process::ExitCode;

use lookat_scene::kinds;
use lookat_scene::schema::{
    Count, Effect, Kind, Parameter, REQUIRED, Synonym, parameter_synonyms, type_synonym,
};
use lookat_scene::syntax::{Directive, DirectiveForm, ParamType, directive_advice, nearest};
use serde::Serialize;
use serde_json::{Value, json};

use crate::args::Explain;
use crate::failure::Failure;

/// What the command prints, as text and as JSON.
struct Answer {
    text: String,
    json: Value,
}

/// Runs the command.
pub fn explain(arguments: &Explain) -> ExitCode {
    let printed = match answer(arguments) {
        Ok(Answer { json, .. }) if arguments.json => crate::print_json(&json).map(|()| 0),
        Ok(Answer { text, .. }) => crate::print(&text).map(|()| 0),
        Err(message) => {
            say!("error: {message}");
            let printed = if arguments.json {
                crate::print_json(&json!({"error": message.to_string()}))
            } else {
                Ok(())
            };
            printed.map(|()| crate::TROUBLE)
        }
    };
    crate::exit_code(printed)
}

fn answer(words: &Explain) -> Result<Answer, Failure> {
    let Some(word) = &words.directive else {
        return Ok(show_directives(&Directive::FORMS, &kinds().collect::<Vec<_>>()));
    };
    let Some(form) = Directive::FORMS.iter().find(|form| form.keyword == word) else {
        return any(&[word, words.kind.as_deref().unwrap_or(""), words.parameter.as_deref().unwrap_or("")]);
    };
    let kinds: Vec<&Kind> = kinds().filter(|kind| kind.directive == word).collect();
    let Some(name) = &words.kind else { return Ok(show_directives(&[*form], &kinds)) };
    if kinds.is_empty() {
        return Err(format!("{word} has no types: write {word} {}", form.arguments).trim().into());
    }
    let (kind, remark) = match find_kind(&kinds, name) {
        Ok(found) => found,
        Err(message) => {
            let found = uses(name, &kinds);
            return if found.is_empty() { Err(message) } else { Ok(answer_with("", &found)) };
        }
    };
    match &words.parameter {
        Some(parameter) => find_parameter(kind, parameter, remark),
        None => Ok(show_kind(kind, remark)),
    }
}

/// Words without the directive as pbrt writes it: a type, a parameter, a type and its parameter, or words of other programs.
fn any(words: &[&str; 3]) -> Result<Answer, Failure> {
    let [word, second, _] = *words;
    let phrase = words.join(" ");
    let phrase = phrase.trim_end();
    let kinds: Vec<&Kind> = kinds().collect();
    let mut found = uses(phrase, &kinds);
    if found.is_empty() && !second.is_empty() {
        let named: Vec<&Kind> =
            kinds.iter().copied().filter(|kind| kind.name.eq_ignore_ascii_case(word)).collect();
        found = uses(second, &named);
    }
    // MakeNamedMaterial has the same parameters and the same advice as Material.
    found.retain(|it| !it.repeats_material());
    let advice = directive_advice(phrase).filter(|_| types_and_parameters(phrase, &kinds).is_empty());
    let ty = ParamType::SPELLINGS.iter().find(|(name, _)| name.eq_ignore_ascii_case(phrase));
    let ty = ty.map(|(name, ty)| format!("\"{name} NAME\" declares a parameter: {}", ty.meaning()));
    let mut remark = advice.map(str::to_owned).or(ty).unwrap_or_default();
    if let Some(form) = Directive::FORMS.iter().find(|form| form.keyword.eq_ignore_ascii_case(word)) {
        if found.is_empty() || !second.is_empty() {
            let [_, kind, parameter] =
                words.map(|word| Some(word.to_owned()).filter(|word| !word.is_empty()));
            return answer(&Explain { directive: Some(form.keyword.into()), kind, parameter, json: false });
        }
        remark = format!("{}: {}", written(form), form.meaning);
    }
    if !remark.is_empty() || !found.is_empty() {
        return Ok(answer_with(&remark, &found));
    }
    let others = kinds.iter().flat_map(|kind| kind.parameters().map(|it| it.name).chain([kind.name]));
    let near = nearest(phrase, Directive::KEYWORDS.into_iter().chain(others));
    let advice =
        near.map_or("`lookat explain` lists everything".into(), |near| format!("did you mean {near}?"));
    Err(format!("nothing is called \"{phrase}\": {advice}").into())
}

/// A type by its name, or by a word of other programs and then with a line about that word.
fn find_kind<'k>(kinds: &[&'k Kind], name: &str) -> Result<(&'k Kind, String), Failure> {
    let lacks = format!("{} has no type", kinds[0].directive);
    let named = |name: &str| kinds.iter().copied().find(|kind| kind.name.eq_ignore_ascii_case(name));
    if let Some(kind) = named(name) {
        return Ok((kind, String::new()));
    }
    let synonym = type_synonym(kinds[0].directive, name).filter(|synonym| !synonym.name.is_empty());
    let renamed = synonym.and_then(|synonym| Some((named(synonym.name)?, rename(name, synonym))));
    renamed.ok_or_else(|| {
        let names: Vec<&str> = kinds.iter().map(|kind| kind.name).collect();
        unknown(&lacks, name, nearest(name, names.iter().copied()), &names)
    })
}

/// A parameter by its name, or by a word of other programs and then with a line about that word.
fn find_parameter(kind: &Kind, name: &str, mut remark: String) -> Result<Answer, Failure> {
    let parameters: Vec<Parameter> = kind.parameters().collect();
    let named = |name: &str| parameters.iter().find(|it| it.name.eq_ignore_ascii_case(name));
    let lacks = format!("{} has no parameter", title(kind));
    if let Some(parameter) = named(name) {
        return Ok(show_parameter(parameter, remark));
    }
    let of_material: Vec<&Kind> = kinds().filter(|kind| kind.directive == "Material").collect();
    let overridden = types_and_parameters(name, &of_material);
    if kind.directive == "Shape" && !overridden.is_empty() {
        let remark = format!("a shape can override \"{name}\" of its material:");
        return Ok(answer_with(&remark, &overridden));
    }
    let is_known = |synonym: &Synonym| synonym.name.is_empty() || named(synonym.name).is_some();
    let synonym = parameter_synonyms(kind.directive, kind.name, name).find(is_known);
    if let Some(Synonym { name: "", advice, .. }) = synonym {
        bail!("{lacks} \"{name}\": {advice}");
    }
    if let Some((synonym, parameter)) = synonym.and_then(|synonym| Some((synonym, named(synonym.name)?))) {
        remark += &rename(name, synonym);
        return Ok(show_parameter(parameter, remark));
    }
    if parameters.is_empty() {
        bail!("{lacks} \"{name}\": it takes no parameters");
    }
    let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name).collect();
    Err(unknown(&lacks, name, nearest(name, names.iter().copied()), &names))
}

/// A line about a word of other programs.
fn rename(word: &str, Synonym { name, advice, .. }: Synonym) -> String {
    let colon = if advice.is_empty() { "" } else { ": " };
    format!("\"{word}\" is \"{name}\" in pbrt{colon}{advice}\n")
}

/// The message about an unknown name. `lacks` is its beginning.
fn unknown(lacks: &str, name: &str, near: Option<&str>, known: &[&str]) -> Failure {
    let known: Vec<&str> = known.iter().map(|known| if known.is_empty() { "\"\"" } else { known }).collect();
    let advice = match near {
        Some(near) => format!("did you mean {near}?"),
        None => format!("choose from {}", known.join(", ")),
    };
    format!("{lacks} \"{name}\": {advice}").into()
}

/// What a word names: a type, or a parameter of a type. Without a meaning, there is only advice about the directive or the type.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Serialize)]
struct Use {
    /// The directive.
    directive: &'static str,
    /// The type, or null.
    #[serde(rename = "type")]
    kind: Option<&'static str>,
    /// The parameter, or null.
    parameter: Option<&'static str>,
    /// Its meaning.
    meaning: &'static str,
    /// Other necessary changes, or what to write instead.
    advice: &'static str,
}

impl Use {
    /// True for what Material says of MakeNamedMaterial: all but the types.
    fn repeats_material(&self) -> bool {
        self.directive == "MakeNamedMaterial" && (self.parameter.is_some() || self.meaning.is_empty())
    }
}

/// The types and parameters with this name.
fn types_and_parameters(word: &str, kinds: &[&Kind]) -> Vec<Use> {
    found(kinds, |kind| named_of(word, kind))
}

/// The types and parameters that a word means, also as a word of other programs.
fn uses(word: &str, kinds: &[&Kind]) -> Vec<Use> {
    found(kinds, |kind| {
        let mut found = named_of(word, kind);
        found.extend(kind_synonym(word, kind));
        if found.is_empty() {
            found.extend(parameter_synonym(word, kind));
        }
        found
    })
}

/// What is found of each type, each once. Advice about most types of a directive is advice about the directive.
fn found(kinds: &[&Kind], find: impl Fn(&Kind) -> Vec<Use>) -> Vec<Use> {
    let mut found: Vec<Use> = kinds.iter().flat_map(|kind| find(kind)).collect();
    let (types, all) = (kinds.iter().map(|kind| kind.directive), found.clone());
    for it in found.iter_mut().filter(|it| it.meaning.is_empty()) {
        let equal = all.iter().filter(|other| (other.directive, other.advice) == (it.directive, it.advice));
        if 2 * equal.count() > types.clone().filter(|directive| *directive == it.directive).count() {
            it.kind = None;
        }
    }
    let mut seen = HashSet::new();
    found.retain(|it| seen.insert(*it));
    found
}

fn named_of(word: &str, kind: &Kind) -> Vec<Use> {
    let of_kind = kind.name.eq_ignore_ascii_case(word).then(|| of_kind(kind, ""));
    let parameters = kind.parameters().filter_map(|parameter| {
        let Parameter { name, meaning, range, .. } = &parameter;
        let mut values = range.strip_prefix("one of ").into_iter().flat_map(|values| values.split(", "));
        if name.eq_ignore_ascii_case(word) {
            Some(of_parameter(kind, name, meaning, ""))
        } else {
            values
                .any(|value| value.eq_ignore_ascii_case(word))
                .then(|| of_parameter(kind, name, meaning, "this is one of its values"))
        }
    });
    of_kind.into_iter().chain(parameters).collect()
}

fn of_kind(kind: &Kind, advice: &'static str) -> Use {
    let Kind { directive, name, meaning, .. } = *kind;
    Use { directive, kind: Some(name), parameter: None, meaning, advice }
}

fn of_parameter(kind: &Kind, name: &'static str, meaning: &'static str, advice: &'static str) -> Use {
    Use { directive: kind.directive, kind: Some(kind.name), parameter: Some(name), meaning, advice }
}

/// A type that a word of other programs means.
fn kind_synonym(word: &str, kind: &Kind) -> Option<Use> {
    let synonym = type_synonym(kind.directive, word)?;
    match synonym.name {
        "" => Some(Use { meaning: "", ..of_kind(kind, synonym.advice) }),
        name => (name == kind.name).then(|| of_kind(kind, synonym.advice)),
    }
}

/// A parameter that a word of other programs means.
fn parameter_synonym(word: &str, kind: &Kind) -> Option<Use> {
    parameter_synonyms(kind.directive, kind.name, word).find_map(|Synonym { name, advice: words, .. }| {
        if name.is_empty() {
            return Some(Use { meaning: "", ..of_kind(kind, words) });
        }
        let parameter = kind.parameters().find(|parameter| parameter.name == name)?;
        Some(of_parameter(kind, name, parameter.meaning, words))
    })
}

/// A line for each use, after a remark.
fn answer_with(remark: &str, uses: &[Use]) -> Answer {
    let lines: Vec<(String, String)> = uses.iter().map(line).collect();
    let remark_line = if remark.is_empty() { String::new() } else { format!("{remark}\n") };
    let json = json!({"remark": remark, "found": uses});
    Answer { text: remark_line + &columns(&lines), json }
}

/// What to write, and what it means.
fn line(Use { directive, kind, parameter, meaning, advice }: &Use) -> (String, String) {
    let kind = kind.map(|kind| if kind.is_empty() { "\"\"" } else { kind });
    let words: Vec<&str> = [Some(*directive), kind, *parameter].into_iter().flatten().collect();
    let texts: Vec<&str> = [*meaning, advice].into_iter().filter(|text| !text.is_empty()).collect();
    (words.join(" "), texts.join("; "))
}

fn title(kind: &Kind) -> String {
    format!("{} \"{}\"", kind.directive, kind.name)
}

/// Pairs of texts in two columns.
fn columns(lines: &[(String, String)]) -> String {
    let width = lines.iter().map(|(left, _)| left.chars().count()).max().unwrap_or(0);
    lines.iter().map(|(left, right)| format!("{left:width$}  {right}\n")).collect()
}

/// A line for each type, and for each directive without types. A single type is shown with all its parameters.
fn show_directives(forms: &[DirectiveForm], kinds: &[&Kind]) -> Answer {
    let is_plain = |form: &&DirectiveForm| kinds.iter().all(|kind| kind.directive != form.keyword);
    let plain: Vec<&DirectiveForm> = forms.iter().filter(is_plain).collect();
    if let ([], [only]) = (&plain[..], kinds) {
        return show_kind(only, String::new());
    }
    let forms = plain.iter().map(|form| (written(form), form.meaning.to_owned()));
    let lines: Vec<(String, String)> =
        forms.chain(kinds.iter().map(|kind| (title(kind), meaning(kind)))).collect();
    let json = plain
        .iter()
        .map(|form| TypeFacts::of_form(form))
        .chain(kinds.iter().map(|kind| TypeFacts::new(kind)));
    Answer { text: columns(&lines), json: json!(json.collect::<Vec<_>>()) }
}

/// A directive without types as a scene writes it.
fn written(form: &DirectiveForm) -> String {
    format!("{} {}", form.keyword, form.arguments).trim().to_owned()
}

fn meaning(kind: &Kind) -> String {
    let default = if kind.is_default { "; the default" } else { "" };
    match kind.instead {
        "" => format!("{}{default}", kind.meaning),
        instead => format!("{}; not supported: lookat renders {instead}", kind.meaning),
    }
}

/// A type with all its parameters, after a remark.
fn show_kind(kind: &Kind, remark: String) -> Answer {
    let mut text = format!("{remark}{}: {}\n", title(kind), meaning(kind));
    for parameter in kind.parameters() {
        text += &format!("\n{}", paragraph(&parameter));
    }
    Answer { text, json: json!([TypeFacts { remark: remarked(&remark), ..TypeFacts::new(kind) }]) }
}

/// A parameter, after a remark.
fn show_parameter(parameter: &Parameter, remark: String) -> Answer {
    let json = json!(ParameterFacts { remark: remarked(&remark), ..ParameterFacts::new(parameter) });
    Answer { json, text: remark + &paragraph(parameter) }
}

/// A remark without its line end. `None` if it is empty.
fn remarked(remark: &str) -> Option<String> {
    Some(remark.trim_end().to_owned()).filter(|remark| !remark.is_empty())
}

/// A parameter as a scene declares it, its facts, and its meaning.
fn paragraph(parameter: &Parameter) -> String {
    let Parameter { name, ty, default, range, unit, meaning, .. } = parameter;
    let mut text = format!("\"{} {name}\"", ty.name());
    match parameter.count {
        Count::One if parameter.is_textured => text += " or the name of a texture",
        Count::One => {}
        Count::Exactly(count) => _ = write!(text, ", {count} values"),
        Count::List => text += ", a list",
    }
    text += &match default.as_str() {
        REQUIRED => ", required".into(),
        _ => format!(", default {default}"),
    };
    if !range.is_empty() {
        _ = write!(text, ", {range}");
    }
    if !unit.name().is_empty() {
        _ = write!(text, ", in {}", unit.name());
    }
    let effect = match parameter.effect.words() {
        "" => String::new(),
        words => format!("; {words}"),
    };
    let synonyms = match &parameter.synonyms[..] {
        [] => String::new(),
        words => format!("      elsewhere: {}\n", words.join(", ")),
    };
    format!("  {text}\n      {meaning}{effect}\n{synonyms}")
}

/// A type, or a directive without types.
#[derive(Default, Serialize)]
struct TypeFacts {
    /// The directive, as a scene writes it.
    directive: &'static str,
    /// The type, as a scene writes it; null for a directive without types.
    #[serde(rename = "type")]
    kind: Option<&'static str>,
    /// What a scene writes after a directive without types.
    #[serde(skip_serializing_if = "Option::is_none")]
    arguments: Option<&'static str>,
    /// Of a type: whether a scene that lacks the directive gets it.
    #[serde(skip_serializing_if = "Option::is_none")]
    default: Option<bool>,
    /// What it is.
    meaning: &'static str,
    /// Of a type: what lookat renders instead, or null.
    #[serde(skip_serializing_if = "Option::is_none")]
    instead: Option<Option<&'static str>>,
    /// Its parameters.
    parameters: Vec<ParameterFacts>,
    /// About another program's word for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    remark: Option<String>,
}

impl TypeFacts {
    fn of_form(form: &DirectiveForm) -> TypeFacts {
        let &DirectiveForm { keyword, arguments, meaning, .. } = form;
        TypeFacts { directive: keyword, arguments: Some(arguments), meaning, ..TypeFacts::default() }
    }

    fn new(kind: &Kind) -> TypeFacts {
        TypeFacts {
            directive: kind.directive,
            kind: Some(kind.name),
            default: Some(kind.is_default),
            meaning: kind.meaning,
            instead: Some(Some(kind.instead).filter(|instead| !instead.is_empty())),
            parameters: kind.parameters().map(|parameter| ParameterFacts::new(&parameter)).collect(),
            ..TypeFacts::default()
        }
    }
}

/// The facts about a parameter.
#[derive(Debug, Serialize)]
pub struct ParameterFacts {
    /// The name, as a scene declares it.
    name: &'static str,
    /// The type, as a scene declares it.
    #[serde(rename = "type")]
    ty: &'static str,
    /// The number of values; null for a list.
    count: Option<usize>,
    /// Whether it can name a texture.
    texture: bool,
    /// The default, in words.
    default: String,
    /// The range, in words, or null.
    range: Option<String>,
    /// The unit, in words, or null.
    unit: Option<&'static str>,
    /// What it is.
    meaning: &'static str,
    /// `rendered`; `none`: it cannot change the picture; `ignored`: lookat ignores it; `own`: pbrt-v3 does not have it.
    effect: &'static str,
    /// Other programs' words for it, in lower case, without `_` and `-`.
    synonyms: Vec<&'static str>,
    /// About another program's word for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    remark: Option<String>,
}

impl ParameterFacts {
    pub fn new(parameter: &Parameter) -> ParameterFacts {
        ParameterFacts {
            name: parameter.name,
            ty: parameter.ty.name(),
            count: match parameter.count {
                Count::One => Some(1),
                Count::Exactly(count) => Some(count),
                Count::List => None,
            },
            texture: parameter.is_textured,
            default: parameter.default.clone(),
            range: Some(parameter.range.clone()).filter(|range| !range.is_empty()),
            unit: Some(parameter.unit.name()).filter(|unit| !unit.is_empty()),
            meaning: parameter.meaning,
            effect: match parameter.effect {
                Effect::Rendered => "rendered",
                Effect::NoEffect => "none",
                Effect::NotRendered => "ignored",
                Effect::Own => "own",
            },
            synonyms: parameter.synonyms.clone(),
            remark: None,
        }
    }
}
