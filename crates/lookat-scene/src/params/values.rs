//! Takes values by name and type, for the types of [`Key`].

use glam::{DVec3, Vec3};
use lookat_syntax::{Param, ParamType, Text, Values};

use super::{Params, SPECTRUM_TYPES};
use crate::sampler::MOST_NESTED;
use crate::schema::Key;
use crate::transform::LARGEST;
use crate::{angle, color};

impl Params<'_> {
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

    pub(super) fn float(&mut self, name: &'static str, default: f64) -> f64 {
        self.float_if_given(name).unwrap_or(default)
    }

    pub fn float_if_given(&mut self, name: &'static str) -> Option<f64> {
        match self.take_one(name, &[ParamType::Float]).map(|p| p.values.value) {
            Some(Values::Numbers(values)) => Some(values[0]),
            _ => None,
        }
    }

    pub(super) fn integer(&mut self, name: &'static str, default: i32) -> i32 {
        match self.take_one(name, &[ParamType::Integer]).map(|p| p.values.value) {
            Some(Values::Integers(values)) => values[0],
            _ => default,
        }
    }

    pub(super) fn bool(&mut self, name: &'static str, default: bool) -> bool {
        match self.take_one(name, &[ParamType::Bool]).map(|p| p.values.value) {
            Some(Values::Bools(values)) => values[0],
            _ => default,
        }
    }

    pub(super) fn string(&mut self, name: &'static str) -> Option<Text> {
        match self.take_one(name, &[ParamType::String]).map(|p| p.values.value) {
            Some(Values::Strings(mut values)) => values.pop(),
            _ => None,
        }
    }

    /// One point or direction.
    pub(super) fn triple(&mut self, name: &'static str, ty: ParamType, default: [f64; 3]) -> DVec3 {
        match self.take_one(name, &[ty]).map(|p| p.values.value) {
            Some(Values::Triples(values)) => values[0].into(),
            _ => default.into(),
        }
    }

    /// A string from a closed list. The first is the default, which also replaces an unknown string, as in pbrt-v3.
    pub(super) fn choice<'k>(&mut self, name: &'static str, known: &[&'k str]) -> &'k str {
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

    pub(super) fn floats(&mut self, name: &'static str) -> Option<Vec<f64>> {
        match self.take_of(name, &[ParamType::Float]).map(|p| p.values.value) {
            Some(Values::Numbers(values)) => Some(values),
            _ => None,
        }
    }

    pub(super) fn integers(&mut self, name: &'static str) -> Option<Vec<i32>> {
        match self.take_of(name, &[ParamType::Integer]).map(|p| p.values.value) {
            Some(Values::Integers(values)) => Some(values),
            _ => None,
        }
    }

    pub(super) fn triples(&mut self, name: &'static str, ty: ParamType) -> Option<Vec<[f64; 3]>> {
        match self.take_of(name, &[ty]).map(|p| p.values.value) {
            Some(Values::Triples(values)) => Some(values),
            _ => None,
        }
    }

    pub(super) fn pairs(&mut self, name: &'static str) -> Option<Vec<[f64; 2]>> {
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
            Ok(color) if color::is_in_range(color) => color,
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
    pub(super) fn angle(&mut self, name: &'static str, default: f64) -> f64 {
        let given = self.float(name, default);
        self.doubt_angle(name, name, given);
        given
    }

    /// Reports at the place of a parameter that an angle looks like radians.
    pub fn doubt_angle(&mut self, name: &str, place: &str, given: f64) {
        if let Some((severity, message, help)) = angle::doubt(name, given) {
            self.remark(severity, place, &message, &help);
        }
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
}
