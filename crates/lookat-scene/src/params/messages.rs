//! Messages about wrong parameters and types.

use lookat_syntax::{
    Diagnostic, Param, ParamType, Severity, Text, Values, begun, nearest, same_digits, shown,
};

use crate::names::Names;
use crate::params::{Params, class};
use crate::schema::{Kind, OLDER, Synonym, parameter_synonyms, type_synonym};
use crate::symbols::{SymbolKind, undefined};

impl Params<'_> {
    /// The value of a name. Reports an undefined name.
    pub fn find<'n, T: Clone>(&mut self, names: &'n Names<T>, name: &Text) -> Option<&'n T> {
        names.find(name, self.report)
    }

    /// A named texture. Reports a texture of the `other` value type, unless a missing file may define the right one.
    pub fn find_texture<'n, T: Clone, U: Clone>(
        &mut self,
        names: &'n Names<T>,
        other: &Names<U>,
        name: &Text,
    ) -> Option<&'n T> {
        if names.get(&name.value).is_some() || other.get(&name.value).is_none() {
            return self.find(names, name);
        }
        other.find(name, self.report);
        if !self.report.incomplete {
            let (has, needs) = match names.kind() {
                SymbolKind::FloatTexture => ("spectrum", "float"),
                _ => ("float", "spectrum"),
            };
            let help = format!("this texture has {has} values; this parameter needs a {needs} texture");
            self.report.push(undefined(names.kind(), name).help(help));
        }
        None
    }

    /// Reports a required parameter that was not taken as missing, or as declared with a wrong type.
    pub fn missing(&mut self, name: &str, message: &str, help: &str) {
        if self.was_taken(name) {
            return;
        }
        let named = |is: &dyn Fn(&str) -> bool| self.params.iter().position(|param| is(&param.name.value));
        let other = named(&|given| given == name).or_else(|| named(&|given| is_slip(given, name)));
        let error = match other.map(|index| self.params.remove(index)) {
            Some(param) if param.name.value == name => {
                Diagnostic { severity: Severity::Error, ..self.wrong_type(&param) }
            }
            Some(param) => {
                let declaration = format!("\"{} {name}\"", self.spelling(&param));
                let error = Diagnostic::error(param.name.span, message);
                error.help(format!("did you mean \"{name}\"?")).fix(param.name.span, declaration)
            }
            None => Diagnostic::error(self.kind.span, message).help(help),
        };
        self.error(error);
    }

    /// Reports a string outside its closed list.
    pub fn unknown_choice(&mut self, name: &str, given: &Text, known: &[&str]) {
        let message = format!("unknown {name} \"{}\"", shown(given.value.as_bytes()));
        let error = Diagnostic::error(given.span, message);
        self.error_surely(match nearest(&given.value, known.iter().copied()) {
            Some(near) => {
                error.help(format!("did you mean \"{near}\"?")).fix(given.span, format!("\"{near}\""))
            }
            None => error.help(format!("choose from {}", known.join(", "))),
        });
    }

    /// Reports an unknown type, as in: unknown Shape "sphrere".
    pub fn report_unknown_type(&mut self, known: &[Kind], severity: Severity) {
        let names: Vec<&str> = known.iter().map(|kind| kind.name).collect();
        let (kind, at) = (self.kind.value.clone(), self.kind.span);
        let name = shown(kind.as_bytes());
        let consequence = if self.keyword == "Accelerator" { ": pbrt-v3 renders no shapes" } else { "" };
        let unknown =
            Diagnostic::new(severity, at, format!("unknown {} \"{name}\"{consequence}", self.keyword));
        let is_v4 = is_of_v4(self.keyword, &kind);
        if is_v4 {
            self.report.v4_marks([at]);
        }
        let rename = |unknown: Diagnostic, name: &str| unknown.fix(at, format!("\"{name}\""));
        let source = format!("\"{kind}\" is a type of pbrt-v4; lookat reads the pbrt-v3 format");
        self.report.push(match type_synonym(self.keyword, &kind) {
            Some(Synonym { name: "", advice, .. }) if is_v4 => unknown.help(format!("{source}: {advice}")),
            Some(Synonym { name: "", advice, .. }) => unknown.help(advice),
            Some(Synonym { name, advice: "", .. }) if is_v4 => {
                rename(unknown.help(format!("{source}, where it is \"{name}\"")), name)
            }
            Some(Synonym { name, advice: "", .. }) => {
                rename(unknown.help(format!("did you mean \"{name}\"?")), name)
            }
            Some(Synonym { name, advice: OLDER, .. }) => {
                rename(unknown.help(format!("this is {OLDER}: write \"{name}\"")), name)
            }
            Some(Synonym { name, advice, .. }) => unknown.help(format!("did you mean \"{name}\"? {advice}")),
            None if is_v4 => unknown.help(source),
            None => {
                match nearest(&kind, names.iter().copied()).or_else(|| begun(&kind, names.iter().copied())) {
                    Some(near) => rename(unknown.help(format!("did you mean \"{near}\"?")), near),
                    None => {
                        let names: Vec<&str> = names.into_iter().filter(|name| !name.is_empty()).collect();
                        unknown.help(format!("the types are {}", names.join(", ")))
                    }
                }
            }
        });
    }

    /// The warning about one of several parameters that the constructor has not taken.
    pub(super) fn left_over(&self, param: &Param, all: &[Param]) -> Diagnostic {
        let (name, at, what) = (&param.name.value, param.name.span, self.subject());
        if self.was_taken(name) {
            return Diagnostic::warning(at, format!("\"{name}\" of {what} is also given with another type"))
                .help(format!("the {} is ignored, as in pbrt-v3", param.ty.name()));
        }
        if self.types(name).next().is_some() {
            let mut warning = self.wrong_type(param);
            warning.message += "; it is ignored";
            let help = "pbrt-v3 also ignores it and uses the default";
            warning.help = Some(warning.help.map_or(help.into(), |way| format!("{way}; {help}")));
            return warning;
        }
        let warning = Diagnostic::warning(at, format!("{what} has no parameter \"{name}\"; it is ignored"));
        let names = self.names();
        let left = || names.iter().copied().filter(|known| !self.was_taken(known));
        let is_left =
            |synonym: &Synonym| synonym.name.is_empty() || left().any(|known| known == synonym.name);
        let synonyms = |word: &str| parameter_synonyms(self.keyword, &self.kind.value, word);
        // Of several names, one that no other parameter means.
        let is_only = |other: &Param, name: &str| synonyms(&other.name.value).map(|it| it.name).eq([name]);
        let is_free = |synonym: &Synonym| !all.iter().any(|other| is_only(other, synonym.name));
        let synonym = synonyms(name).filter(is_left).find(is_free).or_else(|| synonyms(name).find(is_left));
        let synonym = match synonym {
            Some(Synonym { name: "", advice, .. }) => return warning.help(advice),
            Some(Synonym { name, advice, .. }) if !advice.is_empty() => {
                return warning.help(format!("write \"{name}\": {advice}"));
            }
            plain => plain.and_then(|synonym| left().find(|known| *known == synonym.name)),
        };
        match synonym.or_else(|| nearest(name, left())) {
            Some(known) => {
                let warning = warning.help(format!("did you mean \"{known}\"?"));
                // The type must match, too.
                let is_of = |ty: ParamType| class(ty) == class(param.ty);
                let types: Vec<ParamType> = self.types(known).collect();
                let ty = match types[..] {
                    [only] if !is_of(only) => only,
                    _ if !types.iter().any(|ty| is_of(*ty)) => return warning,
                    _ => return warning.fix(at, format!("\"{} {known}\"", self.spelling(param))),
                };
                if !may_be(&param.values.value, ty) {
                    return warning;
                }
                warning.fix(at, format!("\"{} {known}\"", ty.name()))
            }
            None if names.is_empty() => warning.help("it takes no parameters"),
            None => warning.help(format!("its parameters are {}", names.join(", "))),
        }
    }

    /// The spelling of the type in the file.
    fn spelling(&self, param: &Param) -> &str {
        let declaration = str::from_utf8(self.files.sources.text(param.name.span)).unwrap_or_default();
        declaration.trim_start_matches('"').split_ascii_whitespace().next().unwrap_or(param.ty.name())
    }

    /// The directive and its type, such as `Shape "sphere"`.
    pub(super) fn subject(&self) -> String {
        if self.kind.value.is_empty() {
            self.keyword.to_owned()
        } else {
            format!("{} \"{}\"", self.keyword, self.kind.value)
        }
    }

    /// The diagnostic of a parameter with a wrong type.
    pub(super) fn wrong_type(&self, param: &Param) -> Diagnostic {
        let (name, at) = (&param.name.value, param.name.span);
        let types: Vec<ParamType> = self.types(name).collect();
        let names: Vec<&str> = types.iter().map(|ty| ty.name()).collect();
        let message = format!(
            "\"{name}\" of {} is declared as {}, but its type is {}",
            self.subject(),
            param.ty.name(),
            names.join(" or "),
        );
        let warning = Diagnostic::warning(at, message);
        // One number in place of a color means gray.
        if let (Values::Numbers(numbers), true) = (&param.values.value, types.contains(&ParamType::Rgb))
            && let [gray] = numbers[..]
        {
            let declaration = format!("\"rgb {name}\" [{gray} {gray} {gray}]");
            return warning
                .help(format!("a color has three numbers: {declaration}"))
                .fix(param.span(), declaration);
        }
        let scalar = types.iter().find(|ty| matches!(ty, ParamType::Float | ParamType::Integer));
        if let (Some(number), Some(ty)) = (numeral(&param.values.value), scalar) {
            let declaration = format!("\"{} {name}\" {number}", ty.name());
            let help = format!("write the number without quotes: {declaration}");
            return warning.help(help).fix(param.span(), declaration);
        }
        match types[..] {
            [only] => {
                let declaration = format!("\"{} {name}\"", only.name());
                let warning = warning.help(format!("declare it as {declaration}"));
                if may_be(&param.values.value, only) { warning.fix(at, declaration) } else { warning }
            }
            // No fix: the texture may not exist.
            _ if types.contains(&ParamType::Texture) && param.ty == ParamType::String => {
                let (what, ty) =
                    if types.contains(&ParamType::Float) { ("number", "float") } else { ("color", "rgb") };
                warning.help(format!("declare a {what} as \"{ty} {name}\", a texture as \"texture {name}\""))
            }
            _ if types.contains(&ParamType::Float) => {
                let declaration = format!("\"float {name}\"");
                let warning = warning.help(format!("declare a number as {declaration}"));
                let is_one = param.values.value.len() == 1 && may_be(&param.values.value, ParamType::Float);
                if is_one { warning.fix(at, declaration) } else { warning }
            }
            _ if types.contains(&ParamType::Rgb) && may_be(&param.values.value, ParamType::Rgb) => {
                let declaration = format!("\"rgb {name}\"");
                warning.help(format!("declare a color as {declaration}")).fix(at, declaration)
            }
            _ => warning,
        }
    }
}

/// The text of a quoted number.
fn numeral(values: &Values) -> Option<&str> {
    let Values::Strings(texts) = values else { return None };
    let [text] = &texts[..] else { return None };
    text.value.parse::<f64>().ok().filter(|number| number.is_finite()).map(|_| text.value.as_str())
}

/// True if values of one type may be intended as values of another.
fn may_be(values: &Values, ty: ParamType) -> bool {
    match values {
        Values::Strings(_) => matches!(ty, ParamType::String | ParamType::Texture),
        Values::Bools(_) => ty == ParamType::Bool,
        _ if matches!(ty, ParamType::String | ParamType::Texture | ParamType::Bool) => false,
        Values::Numbers(numbers) => numbers.len().is_multiple_of(ty.arity()),
        Values::Pairs(_) => ty.arity() != 3,
        // Three numbers are a point or a color.
        Values::Triples(triples) => {
            triples.len() != 1 || !matches!(ty, ParamType::Float | ParamType::Integer)
        }
        Values::Integers(_) => true,
    }
}

/// True if a name is probably a misspelling of another. Names that differ in u and v alone belong to two axes.
fn is_slip(given: &str, name: &str) -> bool {
    let without_axis = |name: &str| name.replace('v', "u");
    same_digits(given, name) && without_axis(given) != without_axis(name) && nearest(given, [name]).is_some()
}

/// True for types introduced by pbrt-v4.
fn is_of_v4(keyword: &str, kind: &str) -> bool {
    let kinds: &[&str] = match keyword {
        "Shape" => &["bilinearmesh"],
        "Material" | "MakeNamedMaterial" => &[
            "coateddiffuse",
            "coatedconductor",
            "conductor",
            "dielectric",
            "diffuse",
            "diffusetransmission",
            "thindielectric",
            "interface",
        ],
        "Film" => &["rgb", "gbuffer", "spectral"],
        "Camera" => &["spherical"],
        "Sampler" => &["zsobol", "paddedsobol", "independent", "pmj02bn"],
        "Integrator" => &["simplepath", "simplevolpath", "lightpath", "randomwalk"],
        "Texture" => &["directionmix"],
        "MakeNamedMedium" => &["uniformgrid", "rgbgrid", "cloud", "nanovdb"],
        _ => &[],
    };
    kinds.contains(&kind)
}
