//! The parameters of one directive. A constructor takes its values and gives defaults; `finish` warns about unused
//! ones.

use std::collections::HashSet;

mod advice;
mod other_versions;

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use lookat_image::{Charge, MemoryBudget};
use lookat_syntax::{Diagnostic, Entity, Param, ParamType, Severity, Span, Text, Values};

use crate::angle;
use crate::color;
use crate::files::{Bytes, Files};
use crate::report::Report;
use crate::schema::{Key, Unit, Value};
use crate::transform::LARGEST;

/// The most light samples of a camera sample: about a hundredth of a second.
const MOST_NESTED: i32 = 1 << 16;

/// The most related places of one message.
const MOST_RELATED: usize = 10;

/// The parameters of a directive, with access to files and diagnostics.
pub(crate) struct Params<'a> {
    /// The keyword of the directive, for messages.
    keyword: &'static str,
    /// The type of thing, such as `sphere`.
    kind: Text,
    params: Vec<Param>,
    /// The names and types that the constructor has asked for.
    asked: Vec<(&'static str, ParamType)>,
    /// The places and types of the values taken.
    places: Vec<(&'static str, Span, ParamType)>,
    failed: bool,
    rest_ignored: bool,
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
            rest_ignored: false,
            files,
            report,
        };
        params.drop_repeated();
        params
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
    pub fn ask(&mut self, name: &'static str, ty: ParamType) {
        if !self.asked.contains(&(name, ty)) {
            self.asked.push((name, ty));
        }
    }

    /// Takes the value of a parameter, or its default. Rejects a value outside the range of the key.
    pub fn take<T: Value>(&mut self, key: &Key<T>) -> T::Taken {
        T::take(key, self)
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

    /// Takes a parameter of one of the types. pbrt-v3 ignores a parameter of another type.
    fn take_of(&mut self, name: &'static str, types: &[ParamType]) -> Option<Param> {
        self.ask(name, types[0]);
        let index = self.params.iter().rposition(|p| p.name.value == name && types.contains(&p.ty))?;
        let param = self.params.remove(index);
        self.places.push((name, param.values.span, param.ty));
        Some(param)
    }

    /// Like `take`, and reports an error unless there is exactly one value.
    fn take_one(&mut self, name: &'static str, types: &[ParamType]) -> Option<Param> {
        let param = self.take_of(name, types)?;
        // A list of wavelengths and values is one spectrum.
        if param.values.value.len() == 1 || param.ty == ParamType::Spectrum {
            return Some(param);
        }
        let message = format!("{name} takes 1 value, not {}", param.values.value.len());
        let has_comma = self.files.sources.text(param.values.span).contains(&b',');
        let help = has_comma.then_some("write the decimal separator as a point, not as a comma");
        self.reject(name, message, help);
        None
    }

    pub fn float(&mut self, name: &'static str, default: f64) -> f64 {
        self.float_if_given(name).unwrap_or(default)
    }

    pub fn float_if_given(&mut self, name: &'static str) -> Option<f64> {
        match self.take_one(name, &[ParamType::Float]).map(|p| p.values.value) {
            Some(Values::Numbers(values)) => Some(values[0]),
            _ => None,
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

    /// One point or direction.
    pub fn triple(&mut self, name: &'static str, ty: ParamType, default: [f64; 3]) -> DVec3 {
        match self.take_one(name, &[ty]).map(|p| p.values.value) {
            Some(Values::Triples(values)) => values[0].into(),
            _ => default.into(),
        }
    }

    /// A string from a closed list. The first is the default, which also replaces an unknown string, as in pbrt-v3.
    pub fn choice<'k>(&mut self, name: &'static str, known: &[&'k str]) -> &'k str {
        let Some(given) = self.string(name) else { return known[0] };
        if let Some(found) = known.iter().find(|known| **known == given.value) {
            return found;
        }
        self.unknown_choice(name, &given, known);
        known[0]
    }

    /// Reports lengths and coordinates outside the range of computation.
    pub fn check_range(&mut self, name: &'static str, values: &[f64]) {
        if let Some(beyond) = values.iter().find(|value| value.abs() > LARGEST) {
            self.reject(name, format!("{name} of {beyond:e} is too large; the limit is {LARGEST:e}"), None);
        }
    }

    pub fn floats(&mut self, name: &'static str) -> Option<Vec<f64>> {
        match self.take_of(name, &[ParamType::Float]).map(|p| p.values.value) {
            Some(Values::Numbers(values)) => Some(values),
            _ => None,
        }
    }

    pub fn integers(&mut self, name: &'static str) -> Option<Vec<i32>> {
        match self.take_of(name, &[ParamType::Integer]).map(|p| p.values.value) {
            Some(Values::Integers(values)) => Some(values),
            _ => None,
        }
    }

    pub fn triples(&mut self, name: &'static str, ty: ParamType) -> Option<Vec<[f64; 3]>> {
        match self.take_of(name, &[ty]).map(|p| p.values.value) {
            Some(Values::Triples(values)) => Some(values),
            _ => None,
        }
    }

    pub fn pairs(&mut self, name: &'static str) -> Option<Vec<[f64; 2]>> {
        match self.take_of(name, &[ParamType::Point2]).map(|p| p.values.value) {
            Some(Values::Pairs(values)) => Some(values),
            _ => None,
        }
    }

    /// A color: `rgb`, `xyz`, `blackbody` or `spectrum`.
    pub fn spectrum(&mut self, name: &'static str, default: Vec3) -> Vec3 {
        let Some(param) = self.take_one(name, SPECTRUM_TYPES) else { return default };
        let color = color::from_param(&param, self.files, self.report);
        if let (Values::Pairs(pairs), Ok(color)) = (&param.values.value, &color) {
            self.check_blackbody(name, pairs[0], *color);
        }
        match color {
            Ok(color) if color.abs().max_element() <= color::LARGEST => color,
            Ok(_) => {
                self.reject(name, format!("{name} is too bright; the limit is {:e}", color::LARGEST), None);
                default
            }
            Err(error) => {
                self.error_surely(*error);
                default
            }
        }
    }

    /// Reports temperatures without a color. In pbrt-v3, 0 kelvin gives NaN.
    fn check_blackbody(&mut self, name: &str, [kelvin, factor]: [f64; 2], color: Vec3) {
        let help = "\"blackbody\" takes a temperature in kelvin and a factor: [6500 1]";
        if kelvin <= 0.0 {
            self.reject(name, "the temperature of a blackbody must be above 0 kelvin", Some(help));
        } else if color == Vec3::ZERO && factor != 0.0 {
            self.warn(name, "a blackbody of this temperature emits no visible light", help);
        }
    }

    /// An angle in degrees.
    pub fn angle(&mut self, name: &'static str, default: f64) -> f64 {
        let given = self.float(name, default);
        if let Some((severity, message, help)) = angle::doubt(name, given) {
            self.remark(severity, name, &message, &help);
        }
        given
    }

    /// The number of samples within each camera sample, limited to `MOST_NESTED`.
    pub fn nested_samples(&mut self, key: &Key<i32>) -> i32 {
        let count = self.take(key);
        if count > MOST_NESTED {
            let message = format!("{} is limited to {MOST_NESTED}", key.name);
            let help = "to take more, increase the samples per pixel";
            self.note(key.name, &message, help);
        }
        count.min(MOST_NESTED)
    }

    /// The texture name of a parameter of type texture.
    pub fn texture(&mut self, name: &'static str) -> Option<Text> {
        match self.take_one(name, &[ParamType::Texture]).map(|p| p.values.value) {
            Some(Values::Strings(mut values)) => values.pop(),
            _ => None,
        }
    }

    /// The bytes of a file named by a parameter. Reports an unreadable file and returns `None`.
    pub fn file(&mut self, name: &Text) -> Option<(PathBuf, Bytes)> {
        let found = self.files.read_named(&name.value, name.span);
        let (path, bytes) = found.map_err(|(path, error)| self.unreadable(name, &path, &error)).ok()?;
        self.warn_of_path(name, &path);
        Some((path, bytes))
    }

    /// The bytes of a file that the rest does without. `None`, and a warning, where it cannot be read.
    pub fn file_if_readable(&mut self, name: &Text) -> Option<(PathBuf, Bytes)> {
        match self.files.read_named(&name.value, name.span) {
            Ok((path, bytes)) => {
                self.warn_of_path(name, &path);
                Some((path, bytes))
            }
            Err((path, error)) => {
                let unreadable = self.files.unreadable("read", name, &path, &error);
                self.push(Diagnostic { severity: Severity::Warning, ..unreadable });
                None
            }
        }
    }

    /// Opens a file named by a parameter. Reports a file that it cannot open and returns `None`.
    pub fn open(&mut self, name: &Text) -> Option<(PathBuf, Box<dyn Read>)> {
        let opened = self.files.open_named(&name.value, name.span);
        let (path, file) = opened.map_err(|(path, error)| self.unreadable(name, &path, &error)).ok()?;
        self.warn_of_path(name, &path);
        Some((path, file))
    }

    /// Warns of a name that leads to `path` here and not in pbrt-v3.
    pub fn warn_of_path(&mut self, name: &Text, path: &Path) {
        self.report.extend(self.files.not_found_by_pbrt(name, path));
    }

    /// The same, of a file that is not read.
    pub fn warn_of_unread_path(&mut self, name: &Text) {
        if let Ok((path, _)) = self.files.open_named(&name.value, name.span) {
            self.warn_of_path(name, &path);
        }
    }

    /// Reports an unreadable file.
    pub fn unreadable(&mut self, name: &Text, path: &Path, error: &io::Error) {
        let unreadable = self.files.unreadable("read", name, path, error);
        // Empty names are separate mistakes.
        if name.value.is_empty() { self.error(unreadable) } else { self.error_surely(unreadable) }
    }

    /// The first path that [`Params::file`] tries. It is equal for names of the same file.
    pub fn first_path(&self, name: &Text) -> PathBuf {
        self.files.beside(&name.value, name.span)
    }

    /// The place of the value of a taken parameter; the place of the type if it was not given.
    pub fn place(&self, name: &str) -> Span {
        self.places
            .iter()
            .rev()
            .find(|(taken, ..)| *taken == name)
            .map_or(self.kind.span, |(_, span, _)| *span)
    }

    /// True if a parameter was given and taken.
    pub fn was_taken(&self, name: &str) -> bool {
        self.places.iter().any(|(taken, ..)| *taken == name)
    }

    /// True if a parameter was given as red, green and blue.
    pub fn was_rgb(&self, name: &str) -> bool {
        self.places.iter().any(|(taken, _, ty)| *taken == name && *ty == ParamType::Rgb)
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

    /// The memory budget.
    pub fn memory(&self) -> &'a MemoryBudget {
        &self.files.memory
    }

    /// Reserves the memory of arrays. Reports an error at the parameter and returns `None` if it does not fit.
    pub fn reserve(&mut self, name: &str, bytes: usize) -> Option<Charge> {
        let reserved = self.memory().reserve(bytes as u64);
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
        match self.was_taken(name) && self.keyword != "Shape" {
            true => self.error_surely(error),
            false => self.error(error),
        }
    }

    /// Reports that the caller's overrides do not fit.
    pub fn misfit(&mut self, message: String) {
        self.report.misfit = Some(message);
    }

    /// Reports something, unless it may come of a part that could not be read.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        if !self.report.partial {
            self.report.push(diagnostic);
        }
    }

    /// Warns about the value of a parameter, unless an unreadable part may cause it.
    pub fn warn(&mut self, name: &str, message: &str, help: &str) {
        self.remark(Severity::Warning, name, message, help);
    }

    /// Gives a note about the value of a parameter, unless that may come of a part that could not be read.
    pub fn note(&mut self, name: &str, message: &str, help: &str) {
        self.remark(Severity::Note, name, message, help);
    }

    fn remark(&mut self, severity: Severity, name: &str, message: &str, help: &str) {
        if !self.report.partial {
            let remark = Diagnostic::warning(self.place(name), message).help(help);
            self.report.push(Diagnostic { severity, ..remark });
        }
    }

    /// Warns about a feature that is not rendered.
    pub fn unsupported(&mut self, message: String) {
        self.report.unsupported(self.kind.span, message);
    }

    /// Gives a note about a type that another one replaces without a change of the picture.
    pub fn replaced(&mut self, message: String, help: &str) {
        self.report.push(Diagnostic::note_at(self.kind.span, message).help(help));
    }

    /// Reports an unknown type and returns `None`.
    pub fn unknown_kind<T>(&mut self, known: &[&str]) -> Option<T> {
        self.failed = true;
        self.say_unknown_kind(known, Severity::Error);
        None
    }

    /// Reads optional parts: rejecting one does not reject the directive.
    pub fn dispensable<T>(&mut self, read: impl FnOnce(&mut Self) -> T) -> T {
        let failed = self.failed;
        let value = read(self);
        self.failed = failed;
        value
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

    /// Takes the parameters that the constructor has not asked for.
    pub fn take_rest(&mut self) -> Vec<Param> {
        let asked = &self.asked;
        let (known, rest) = std::mem::take(&mut self.params)
            .into_iter()
            .partition(|param| asked.iter().any(|(name, _)| *name == param.name.value));
        self.params = known;
        rest
    }

    /// Puts back parameters from `take_rest`.
    pub fn put_back(&mut self, params: Vec<Param>) {
        self.params.extend(params);
    }

    /// The names asked for so far.
    pub fn asked(&self) -> Vec<&'static str> {
        let mut names: Vec<&'static str> = Vec::new();
        for (name, _) in &self.asked {
            if !names.contains(name) {
                names.push(name);
            }
        }
        names
    }

    /// The names and types asked for. `None` if the rest is ignored.
    pub fn known(&self) -> Option<Vec<(&'static str, ParamType)>> {
        (!self.rest_ignored).then(|| self.asked.clone())
    }

    /// Warns about unused parameters. True if the result of the constructor is usable.
    pub fn finish(&mut self) -> bool {
        for param in std::mem::take(&mut self.params) {
            let warning = self.left_over(&param);
            self.report.push(warning);
        }
        !self.failed && !self.report.partial
    }

    /// The types asked for under a name.
    fn types(&self, name: &str) -> impl Iterator<Item = ParamType> {
        self.asked.iter().filter(move |(asked, _)| *asked == name).map(|(_, ty)| *ty)
    }
}

/// The class of interchangeable types: all color types are one class.
pub(crate) fn class(ty: ParamType) -> ParamType {
    if SPECTRUM_TYPES.contains(&ty) { ParamType::Spectrum } else { ty }
}
