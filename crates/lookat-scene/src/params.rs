//! The parameters of one directive. A constructor takes its values and gives defaults; `finish` warns about unused
//! ones.

mod messages;
pub(crate) mod value;

use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};

use lookat_image::Charge;
use lookat_syntax::{Diagnostic, Entity, Param, ParamType, Severity, Span, Text};

use crate::cache::MeshKey;
use crate::files::{FileResult, Files};
use crate::report::Report;
use crate::schema::{Key, Kind, REQUIRED, Unit};
use crate::texture::Textures;

pub(crate) use crate::params::value::ParamValue;

/// The most related places of one message.
const MOST_RELATED: usize = 10;

/// The parameters of a directive, with access to files and diagnostics.
pub(crate) struct Params<'a> {
    /// The keyword of the directive, for messages.
    keyword: &'static str,
    /// The type of thing, such as `sphere`.
    kind: Text,
    params: Vec<Param>,
    /// The names and types of the parameters that the constructor takes.
    registered: Vec<(&'static str, ParamType)>,
    /// The places and types of the values taken.
    places: Vec<(&'static str, Span, ParamType)>,
    failed: bool,
    rest_ignored: bool,
    /// What the mesh depends on, if it can be kept.
    pub mesh_key: Option<MeshKey>,
    /// The textures in scope.
    textures: Option<&'a Textures>,
    pub files: &'a Files<'a>,
    pub report: &'a mut Report,
}

const SPECTRUM_TYPES: &[ParamType] =
    &[ParamType::Rgb, ParamType::Xyz, ParamType::Blackbody, ParamType::Spectrum];

impl<'a> Params<'a> {
    pub fn new(keyword: &'static str, entity: Entity, files: &'a Files<'a>, report: &'a mut Report) -> Self {
        let mut params = Params {
            keyword,
            kind: entity.name,
            params: entity.params,
            registered: Vec::new(),
            places: Vec::new(),
            failed: false,
            rest_ignored: false,
            mesh_key: None,
            textures: None,
            files,
            report,
        };
        params.drop_repeated();
        params
    }

    /// These parameters with the textures that they can name.
    pub fn with_textures(self, textures: &'a Textures) -> Self {
        Params { textures: Some(textures), ..self }
    }

    /// The type named by the directive.
    pub fn kind(&self) -> &str {
        &self.kind.value
    }

    /// The type that the directive names, and its place.
    pub fn kind_text(&self) -> Text {
        self.kind.clone()
    }

    /// Of several parameters with the same name and type, keeps the last, like pbrt-v3.
    fn drop_repeated(&mut self) {
        let key = |at: usize| (self.params[at].name.value.as_str(), class(self.params[at].ty) as u8);
        let mut order: Vec<usize> = (0..self.params.len()).collect();
        order.sort_by(|a, b| key(*a).cmp(&key(*b)));
        let mut dropped = HashSet::new();
        for same in order.chunk_by(|a, b| key(*a) == key(*b)) {
            let [earlier @ .., last] = same else { continue };
            let times = match earlier.len() {
                0 => continue,
                1 => "twice".to_owned(),
                more => format!("{} times", more + 1),
            };
            let last = &self.params[*last].name;
            let warning = Diagnostic::warning(last.span, format!("\"{}\" is given {times}", last.value))
                .note("this one is used");
            let shown = earlier.iter().take(MOST_RELATED);
            self.report.push(shown.fold(warning, |warning, at| {
                warning.related(self.params[*at].span(), "this one is ignored")
            }));
            dropped.extend(earlier.iter().copied());
        }
        let mut at = 0..;
        self.params.retain(|_| at.next().is_none_or(|at| !dropped.contains(&at)));
    }

    pub fn given(&self, name: &str) -> bool {
        self.params.iter().any(|param| param.name.value == name)
    }

    /// Registers a parameter name with a type.
    pub fn register(&mut self, name: &'static str, ty: ParamType) {
        if !self.registered.contains(&(name, ty)) {
            self.registered.push((name, ty));
        }
    }

    /// Takes the value of a parameter, or its default. Rejects a value outside the range of the key, and a directive that lacks
    /// a required parameter.
    pub fn take<T: ParamValue>(&mut self, key: &Key<T>) -> T::Taken {
        let taken = T::take(key, self);
        if key.default_words == REQUIRED {
            let article = if self.kind().starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
            let message = format!("{article} {} needs {}", self.kind(), key.name);
            let value = if key.ty == ParamType::String { "\"...\"" } else { "[...]" };
            // Files write "point", not "point3".
            let ty = key.ty.name().trim_end_matches('3');
            let help = format!("add \"{ty} {}\" {value}: {}", key.name, key.meaning);
            self.missing(key.name, &message, &help);
        }
        taken
    }

    /// Rejects a number outside the range of the key. True if it is inside.
    pub fn check_within<T>(&mut self, key: &Key<T>, value: impl Into<f64>) -> bool {
        let is_within = key.range.contains(value.into());
        if !is_within {
            let unit = match key.unit {
                Unit::Degrees => " degrees",
                Unit::Pixels => " pixels",
                _ => "",
            };
            self.reject(key.name, format!("{} must be {}{unit}", key.name, key.range.words()), None);
        }
        is_within
    }

    /// The place of the value of a taken parameter; the place of the type if it was not given.
    pub fn place(&self, name: &str) -> Span {
        self.places
            .iter()
            .rev()
            .find(|(taken, ..)| *taken == name)
            .map_or(self.kind.span, |(_, span, _)| *span)
    }

    /// The place of the value of a parameter that was given and taken.
    pub fn given_place(&self, name: &str) -> Option<Span> {
        self.was_taken(name).then(|| self.place(name))
    }

    /// True if a parameter was given and taken.
    pub fn was_taken(&self, name: &str) -> bool {
        self.places.iter().any(|(taken, ..)| *taken == name)
    }

    /// True if a parameter was given with one of these types.
    pub fn was_of_type(&self, name: &str, types: &[ParamType]) -> bool {
        self.places.iter().any(|(taken, _, given)| *taken == name && types.contains(given))
    }

    /// The place of one number in a taken list.
    pub fn value_place(&self, name: &str, index: usize) -> Span {
        self.files.sources.value_span(self.place(name), index)
    }

    /// Reports an error and rejects the directive. Stays silent if an unreadable part may cause the error.
    pub fn error(&mut self, diagnostic: Diagnostic) {
        if !self.report.partial {
            self.report.push(diagnostic);
        }
        self.failed = true;
    }

    /// Reports an error that does not depend on other parts of the directive.
    pub fn error_surely(&mut self, diagnostic: Diagnostic) {
        self.report.push(diagnostic);
        self.failed = true;
    }

    /// The number of places reported so far, of all directives. `None` if an unreadable part prevents reports.
    pub fn reported(&self) -> Option<usize> {
        (!self.report.partial).then(|| self.report.count())
    }

    /// Reserves the memory of arrays. Reports an error at the parameter and returns `None` if it does not fit.
    pub fn reserve(&mut self, name: &str, bytes: usize) -> Option<Charge> {
        let reserved = self.files.memory.reserve(bytes as u64);
        let refused = |shortage| {
            let message = format!("the {} is too large: {shortage}", self.kind());
            self.error_surely(Diagnostic::error(self.place(name), message));
        };
        reserved.map_err(refused).ok()
    }

    /// Reports an invalid value of a parameter.
    pub fn reject(&mut self, name: &str, message: impl Into<String>, help: Option<&str>) {
        let mut error = Diagnostic::error(self.place(name), message);
        error.help = help.map(str::to_owned);
        // The validity of shapes depends on several parameters.
        if self.was_taken(name) && self.keyword != "Shape" {
            self.error_surely(error)
        } else {
            self.error(error)
        }
    }

    /// Reports a problem, unless an unreadable part may cause it.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        if !self.report.partial {
            self.report.push(diagnostic);
        }
    }

    /// Warns about the value of a parameter, unless an unreadable part may cause it.
    pub fn warn(&mut self, name: &str, message: &str, help: &str) {
        self.remark(Severity::Warning, name, message, help);
    }

    /// Gives a note about the value of a parameter, unless an unreadable part may cause it.
    pub fn note(&mut self, name: &str, message: &str, help: &str) {
        self.remark(Severity::Note, name, message, help);
    }

    /// Warns about a given parameter that has no effect, and says why.
    pub fn unused(&mut self, name: &str, reason: &str, help: &str) {
        if self.was_taken(name) {
            self.warn(name, &format!("{name} is ignored: {reason}"), help);
        }
    }

    /// Warns about a given parameter that others replace.
    pub fn replaced_by(&mut self, name: &str, others: &[&str]) {
        if others.iter().all(|other| self.was_taken(other)) {
            let replace = if let [_] = others { "replaces" } else { "replace" };
            let reason = format!("{} {replace} it, as in pbrt-v3", others.join(" and "));
            self.unused(name, &reason, &format!("delete {name}, or {}", others.join(" and ")));
        }
    }

    fn remark(&mut self, severity: Severity, name: &str, message: &str, help: &str) {
        if !self.report.partial {
            self.report.push(Diagnostic::new(severity, self.place(name), message).help(help));
        }
    }

    /// Warns about a feature that is not rendered.
    pub fn unsupported(&mut self, message: String) {
        self.report.unsupported(self.kind.span, message);
    }

    /// True if the type is one of these.
    pub fn is_known_kind(&self, known: &[Kind]) -> bool {
        known.iter().any(|kind| kind.name == self.kind())
    }

    /// Reports an unknown type and returns `None`.
    pub fn reject_unknown_type<T>(&mut self, known: &[Kind]) -> Option<T> {
        self.failed = true;
        self.report_unknown_type(known, Severity::Error);
        None
    }

    /// Reads something optional: its errors do not reject the directive.
    pub fn without_rejection<R>(&mut self, read: impl FnOnce(&mut Self) -> R) -> R {
        let failed = std::mem::take(&mut self.failed);
        let result = read(self);
        self.failed = failed;
        result
    }

    /// True if nothing was rejected so far.
    pub fn usable(&self) -> bool {
        !self.failed
    }

    /// True if the unreadable parameter may be this one.
    pub fn may_lack(&self, name: &str) -> bool {
        self.report.partial && !self.was_taken(name)
    }

    /// Ignores the remaining parameters without a warning, for unsupported features.
    pub fn ignore_rest(&mut self) {
        self.params.clear();
        self.rest_ignored = true;
    }

    /// Takes the parameters that the constructor does not take and that `is_meant` accepts.
    pub fn take_rest(&mut self, is_meant: impl Fn(&Param) -> bool) -> Vec<Param> {
        let registered = &self.registered;
        let is_taken = |param: &Param| registered.iter().any(|(name, _)| *name == param.name.value);
        self.params.extract_if(.., |param| !is_taken(param) && is_meant(param)).collect()
    }

    /// The names registered so far, each once.
    pub fn names(&self) -> Vec<&'static str> {
        let mut names: Vec<&'static str> = Vec::new();
        for (name, _) in &self.registered {
            if !names.contains(name) {
                names.push(name);
            }
        }
        names
    }

    /// The registered names and types. `None` if the rest is ignored.
    pub fn known(&self) -> Option<&[(&'static str, ParamType)]> {
        (!self.rest_ignored).then_some(&self.registered)
    }

    /// Warns about unused parameters. True if the result of the constructor is usable.
    pub fn finish(&mut self) -> bool {
        let params = std::mem::take(&mut self.params);
        for param in &params {
            let warning = self.left_over(param, &params);
            self.report.push(warning);
        }
        !self.failed && !self.report.partial
    }

    /// The types registered under a name.
    fn types(&self, name: &str) -> impl Iterator<Item = ParamType> {
        self.registered.iter().filter(move |(taken, _)| *taken == name).map(|(_, ty)| *ty)
    }
}

/// The class of interchangeable types: all color types are one class.
pub(crate) fn class(ty: ParamType) -> ParamType {
    if SPECTRUM_TYPES.contains(&ty) { ParamType::Spectrum } else { ty }
}

impl<'a> Params<'a> {
    /// A file named by a parameter, as `find` gives it. Reports an unreadable one and returns `None`.
    pub fn file<T>(
        &mut self,
        name: &Text,
        find: impl FnOnce(&Files<'a>, &str, Span) -> FileResult<T>,
    ) -> Option<(PathBuf, T)> {
        match find(self.files, &name.value, name.span) {
            Ok((path, file)) => {
                self.warn_of_path(name, &path);
                Some((path, file))
            }
            Err((path, error)) => {
                self.unreadable(name, &path, &error);
                None
            }
        }
    }

    /// Warns of a name that leads to `path` here and not in pbrt-v3.
    pub fn warn_of_path(&mut self, name: &Text, path: &Path) {
        self.report.extend(self.files.not_found_by_pbrt(name, path));
    }

    /// Reports an unreadable file.
    pub fn unreadable(&mut self, name: &Text, path: &Path, error: &io::Error) {
        let unreadable = self.files.unreadable("read", name, path, error);
        // Empty names are separate mistakes.
        if name.value.is_empty() { self.error(unreadable) } else { self.error_surely(unreadable) }
    }
}
