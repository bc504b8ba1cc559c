//! The parameters of one directive. A constructor takes the values that it knows, with their defaults; `finish` warns
//! about what is left.

use glam::{DVec3, Vec3};
use lookat_syntax::{Diagnostic, Entity, Param, ParamType, Span, Text, Values, nearest};

use crate::color;
use crate::files::Files;
use crate::report::Report;
use crate::texture::Textures;

/// What a constructor may ask about: the parameters, the textures in scope, and files.
pub(crate) struct Params<'a> {
    /// The keyword of the directive, for messages.
    keyword: &'static str,
    /// The type of thing, such as `sphere`.
    kind: Text,
    params: Vec<Param>,
    /// Names that were asked for.
    asked: Vec<&'static str>,
    /// Where the values that were taken stand.
    places: Vec<(&'static str, Span)>,
    failed: bool,
    textures: Option<&'a Textures>,
    files: &'a Files<'a>,
    report: &'a mut Report,
}

const SPECTRUM_TYPES: &[ParamType] =
    &[ParamType::Rgb, ParamType::Xyz, ParamType::Blackbody, ParamType::Spectrum];

impl<'a> Params<'a> {
    pub fn new(keyword: &'static str, entity: Entity, files: &'a Files<'a>, report: &'a mut Report) -> Self {
        let mut params = Params {
            keyword,
            kind: entity.name,
            params: entity.params,
            asked: Vec::new(),
            places: Vec::new(),
            failed: false,
            textures: None,
            files,
            report,
        };
        params.drop_repeated();
        params
    }

    pub fn with_textures(mut self, textures: &'a Textures) -> Self {
        self.textures = Some(textures);
        self
    }

    /// The type that the directive names.
    pub fn kind(&self) -> &str {
        &self.kind.value
    }

    /// Of a parameter given twice with the same type, pbrt-v3 keeps the last.
    fn drop_repeated(&mut self) {
        let mut index = 0;
        while index < self.params.len() {
            let this = &self.params[index];
            let same = |p: &&Param| p.name.value == this.name.value && class(p.ty) == class(this.ty);
            let again = self.params[index + 1..].iter().find(same);
            let Some(again) = again else {
                index += 1;
                continue;
            };
            let warning =
                Diagnostic::warning(again.name.span, format!("\"{}\" is given twice", this.name.value))
                    .note("this one counts")
                    .related(this.span(), "this one is dropped");
            self.report.push(warning);
            self.params.remove(index);
        }
    }

    pub fn given(&self, name: &str) -> bool {
        self.params.iter().any(|param| param.name.value == name)
    }

    /// Takes a parameter of one of the given types. pbrt-v3 does not see a parameter of another type.
    fn take(&mut self, name: &'static str, types: &[ParamType]) -> Option<Param> {
        if !self.asked.contains(&name) {
            self.asked.push(name);
        }
        let index = self.params.iter().rposition(|p| p.name.value == name && types.contains(&p.ty))?;
        let param = self.params.remove(index);
        self.places.push((name, param.values.span));
        Some(param)
    }

    /// Like `take`, and an error when there is not exactly one value.
    fn take_one(&mut self, name: &'static str, types: &[ParamType]) -> Option<Param> {
        let param = self.take(name, types)?;
        // A list of wavelengths makes one spectrum.
        if param.values.value.len() == 1 || param.ty == ParamType::Spectrum {
            return Some(param);
        }
        let message = format!("{name} takes 1 value, not {}", param.values.value.len());
        self.reject(name, message, None);
        None
    }

    pub fn float(&mut self, name: &'static str, default: f64) -> f64 {
        match self.take_one(name, &[ParamType::Float]).map(|p| p.values.value) {
            Some(Values::Numbers(values)) => values[0],
            _ => default,
        }
    }

    pub fn integer(&mut self, name: &'static str, default: i32) -> i32 {
        match self.take_one(name, &[ParamType::Integer]).map(|p| p.values.value) {
            Some(Values::Integers(values)) => values[0],
            _ => default,
        }
    }

    pub fn bool(&mut self, name: &'static str, default: bool) -> bool {
        match self.take_one(name, &[ParamType::Bool]).map(|p| p.values.value) {
            Some(Values::Bools(values)) => values[0],
            _ => default,
        }
    }

    pub fn string(&mut self, name: &'static str) -> Option<Text> {
        match self.take_one(name, &[ParamType::String]).map(|p| p.values.value) {
            Some(Values::Strings(mut values)) => values.pop(),
            _ => None,
        }
    }

    pub fn point(&mut self, name: &'static str, default: DVec3) -> DVec3 {
        match self.take_one(name, &[ParamType::Point3]).map(|p| p.values.value) {
            Some(Values::Triples(values)) => values[0].into(),
            _ => default,
        }
    }

    pub fn floats(&mut self, name: &'static str) -> Option<Vec<f64>> {
        match self.take(name, &[ParamType::Float]).map(|p| p.values.value) {
            Some(Values::Numbers(values)) => Some(values),
            _ => None,
        }
    }

    pub fn integers(&mut self, name: &'static str) -> Option<Vec<i32>> {
        match self.take(name, &[ParamType::Integer]).map(|p| p.values.value) {
            Some(Values::Integers(values)) => Some(values),
            _ => None,
        }
    }

    pub fn triples(&mut self, name: &'static str, ty: ParamType) -> Option<Vec<[f64; 3]>> {
        match self.take(name, &[ty]).map(|p| p.values.value) {
            Some(Values::Triples(values)) => Some(values),
            _ => None,
        }
    }

    pub fn pairs(&mut self, name: &'static str) -> Option<Vec<[f64; 2]>> {
        match self.take(name, &[ParamType::Point2]).map(|p| p.values.value) {
            Some(Values::Pairs(values)) => Some(values),
            _ => None,
        }
    }

    /// A color: `rgb`, `xyz`, `blackbody` or `spectrum`.
    pub fn spectrum(&mut self, name: &'static str, default: Vec3) -> Vec3 {
        let Some(param) = self.take_one(name, SPECTRUM_TYPES) else { return default };
        match color::from_param(&param, self.files) {
            Ok(color) => color,
            Err(error) => {
                self.report.push(error);
                self.failed = true;
                default
            }
        }
    }

    /// A color, or the texture of that name.
    pub fn spectrum_texture(&mut self, name: &'static str, default: Vec3) -> Vec3 {
        let Some(texture) = self.texture(name) else { return self.spectrum(name, default) };
        match self.textures.map(|textures| textures.spectrum.get(&texture.value)) {
            Some(Some(known)) => known.unwrap_or(default),
            _ => {
                self.undefined_texture(&texture, "spectrum");
                default
            }
        }
    }

    /// A number, or the texture of that name.
    pub fn float_texture(&mut self, name: &'static str, default: f64) -> f64 {
        let Some(texture) = self.texture(name) else { return self.float(name, default) };
        match self.textures.map(|textures| textures.float.get(&texture.value)) {
            Some(Some(known)) => known.unwrap_or(default),
            _ => {
                self.undefined_texture(&texture, "float");
                default
            }
        }
    }

    /// The name of a texture, where the parameter names one.
    pub fn texture(&mut self, name: &'static str) -> Option<Text> {
        match self.take_one(name, &[ParamType::Texture]).map(|p| p.values.value) {
            Some(Values::Strings(mut values)) => values.pop(),
            _ => None,
        }
    }

    fn undefined_texture(&mut self, texture: &Text, value: &str) {
        let Some(textures) = self.textures else { return };
        let (own, other) = match value {
            "float" => (textures.names(value), textures.names("spectrum")),
            _ => (textures.names(value), textures.names("float")),
        };
        let mut error =
            Diagnostic::error(texture.span, format!("there is no {value} texture \"{}\"", texture.value));
        if other.contains(&texture.value.as_str()) {
            let has = if value == "float" { "spectrum" } else { "float" };
            error = error
                .help(format!("the texture of that name is a {has} texture; a {value} one is needed here"));
        } else if let Some(known) = nearest(&texture.value, own) {
            error =
                error.help(format!("did you mean \"{known}\"?")).fix(texture.span, format!("\"{known}\""));
        } else {
            error =
                error.help("a Texture directive before this one, in the same or an outer block, defines it");
        }
        self.report.push(error);
        self.failed = true;
    }

    /// The bytes of a file that a parameter names. `None`, and an error, where it cannot be read.
    pub fn file(&mut self, name: &Text) -> Option<Vec<u8>> {
        match self.files.read_named(&name.value, name.span) {
            Ok((_, bytes)) => Some(bytes),
            Err((path, error)) => {
                let message = format!("cannot read {}: {}", path.display(), crate::files::reason(&error));
                self.error(Diagnostic::error(name.span, message));
                None
            }
        }
    }

    /// Where the value of a parameter that was taken stands; of one that was not given, the type of the directive.
    pub fn place(&self, name: &str) -> Span {
        self.places.iter().rev().find(|(taken, _)| *taken == name).map_or(self.kind.span, |(_, span)| *span)
    }

    /// Where one number of a list that was taken stands.
    pub fn value_place(&self, name: &str, index: usize) -> Span {
        self.files.sources.value_span(self.place(name), index)
    }

    /// Reports an error; the directive makes nothing.
    pub fn error(&mut self, diagnostic: Diagnostic) {
        self.report.push(diagnostic);
        self.failed = true;
    }

    /// Reports that the value of a parameter has no meaning.
    pub fn reject(&mut self, name: &str, message: impl Into<String>, help: Option<&str>) {
        let mut error = Diagnostic::error(self.place(name), message);
        error.help = help.map(str::to_owned);
        self.error(error);
    }

    /// Warns about the value of a parameter.
    pub fn warn(&mut self, name: &str, message: &str, help: &str) {
        self.report.push(Diagnostic::warning(self.place(name), message).help(help));
    }

    /// Warns, once per scene, about a feature that is not rendered.
    pub fn unsupported(&mut self, message: String) {
        self.report.unsupported(self.kind.span, message);
    }

    /// The error for a type that pbrt-v3 does not have.
    pub fn unknown_kind<T>(&mut self, known: &[&str]) -> Option<T> {
        let (kind, at) = (self.kind.value.clone(), self.kind.span);
        let error = Diagnostic::error(at, format!("unknown {} \"{kind}\"", self.keyword));
        let error = if let Some(known) = nearest(&kind, known.iter().copied()) {
            error.help(format!("did you mean \"{known}\"?")).fix(at, format!("\"{known}\""))
        } else if V4_KINDS.contains(&kind.as_str()) {
            error.help(format!("\"{kind}\" is a type of pbrt-v4; lookat reads the pbrt-v3 format"))
        } else {
            error.help(format!("pbrt-v3 knows {}", known.join(", ")))
        };
        self.error(error);
        None
    }

    /// Whether nothing has been rejected so far.
    pub fn usable(&self) -> bool {
        !self.failed
    }

    /// Leaves the remaining parameters unread, without a word: those of a feature that is not rendered.
    pub fn ignore_rest(&mut self) {
        self.params.clear();
    }

    /// The parameters that nobody has asked for.
    pub fn take_rest(&mut self) -> Vec<Param> {
        let asked = &self.asked;
        let (known, rest) = std::mem::take(&mut self.params)
            .into_iter()
            .partition(|param| asked.contains(&param.name.value.as_str()));
        self.params = known;
        rest
    }

    /// Gives back what `take_rest` took.
    pub fn put_back(&mut self, params: Vec<Param>) {
        self.params.extend(params);
    }

    /// The names that were asked for so far.
    pub fn asked(&self) -> &[&'static str] {
        &self.asked
    }

    /// Warns about parameters that are left. Whether the constructor's result is to be used.
    pub fn finish(&mut self) -> bool {
        for param in std::mem::take(&mut self.params) {
            let warning = self.left_over(&param);
            self.report.push(warning);
        }
        !self.failed
    }

    fn left_over(&self, param: &Param) -> Diagnostic {
        let (name, at) = (&param.name.value, param.name.span);
        let of = if self.kind.value.is_empty() { String::new() } else { format!(" \"{}\"", self.kind.value) };
        let what = format!("{}{of}", self.keyword);
        if self.asked.contains(&name.as_str()) {
            return Diagnostic::warning(
                at,
                format!("{name} of {what} is not of type {}; it is ignored", param.ty.name()),
            )
            .help("pbrt-v3 ignores it too, and uses the default; declare it with the type that it takes");
        }
        let warning = Diagnostic::warning(at, format!("{what} has no parameter \"{name}\"; it is ignored"));
        match nearest(name, self.asked.iter().copied()) {
            Some(known) => warning
                .help(format!("did you mean \"{known}\"?"))
                .fix(at, format!("\"{} {known}\"", param.ty.name())),
            None if self.asked.is_empty() => warning.help("it has none"),
            None => warning.help(format!("it has {}", self.asked.join(", "))),
        }
    }
}

/// Types that replace each other: all that give colors do.
fn class(ty: ParamType) -> ParamType {
    if SPECTRUM_TYPES.contains(&ty) { ParamType::Spectrum } else { ty }
}

/// Types that pbrt-v4 introduced.
const V4_KINDS: &[&str] = &[
    "bilinearmesh",
    "coateddiffuse",
    "coatedconductor",
    "conductor",
    "dielectric",
    "diffuse",
    "diffusetransmission",
    "thindielectric",
    "interface",
    "measured",
    "rgb",
    "gbuffer",
    "spectral",
    "spherical",
    "zsobol",
    "paddedsobol",
    "independent",
    "pmj02bn",
    "simplepath",
    "simplevolpath",
    "lightpath",
    "randomwalk",
    "uniformgrid",
    "rgbgrid",
    "nanovdb",
    "cloud",
    "directionmix",
    "imageinfinite",
    "portalimageinfinite",
];
