//! The types of a parameter's value: its default in words, and how a constructor takes it.

use glam::{DVec3, Vec3};
use lookat_syntax::{Param, ParamType, Text, Values};

use crate::params::{Params, SPECTRUM_TYPES};
use crate::sampler::MOST_NESTED;
use crate::schema::{Count, Key, REQUIRED, Range, Unit, number};
use crate::transform::LARGEST;
use crate::{color, transform};

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
        if let Some((severity, message, help)) = transform::doubt(name, given) {
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

/// A type of value: what a constructor gets for a key.
pub(crate) trait Take: DefaultValue {
    /// What the constructor gets.
    type Taken;

    fn take(key: &Key<Self>, params: &mut Params) -> Self::Taken;
}

impl Take for f64 {
    type Taken = f64;

    /// An angle that looks like radians gets a message.
    fn take(key: &Key<f64>, params: &mut Params) -> f64 {
        let value = match key.unit {
            Unit::Degrees => params.angle(key.name, key.default),
            _ => params.float(key.name, key.default),
        };
        if params.check_within(key, value) { value } else { key.default }
    }
}

impl Take for i32 {
    type Taken = i32;

    fn take(key: &Key<i32>, params: &mut Params) -> i32 {
        let value = params.integer(key.name, key.default);
        if params.check_within(key, value) { value } else { key.default }
    }
}

impl Take for bool {
    type Taken = bool;

    fn take(key: &Key<bool>, params: &mut Params) -> bool {
        params.bool(key.name, key.default)
    }
}

impl Take for &'static [&'static str] {
    type Taken = &'static str;

    fn take(key: &Key<Self>, params: &mut Params) -> &'static str {
        params.choice(key.name, key.default)
    }
}

impl Take for [f64; 3] {
    type Taken = DVec3;

    fn take(key: &Key<Self>, params: &mut Params) -> DVec3 {
        params.triple(key.name, key.ty, key.default)
    }
}

impl Take for Color {
    type Taken = Vec3;

    fn take(key: &Key<Self>, params: &mut Params) -> Vec3 {
        params.spectrum(key.name, Vec3::splat(key.default.0))
    }
}

impl Take for Edges {
    type Taken = Option<[f64; 4]>;

    fn take(key: &Key<Edges>, params: &mut Params) -> Option<[f64; 4]> {
        let edges: Result<[f64; 4], Vec<f64>> = params.floats(key.name)?.try_into();
        if let Err(other) = &edges {
            let message = format!("{} takes 4 values, not {}", key.name, other.len());
            params.reject(key.name, message, Some("write the edges as xmin xmax ymin ymax"));
        }
        edges.ok()
    }
}

impl Take for Needed {
    type Taken = Option<i32>;

    fn take(key: &Key<Self>, params: &mut Params) -> Option<i32> {
        let value = params.integer(key.name, 0);
        if params.was_taken(key.name) {
            return params.check_within(key, value).then_some(value);
        }
        let message = format!("a {} needs {}", params.kind(), key.name);
        params.missing(key.name, &message, &format!("\"integer {}\" is {}", key.name, key.meaning));
        None
    }
}

/// Values without a default: the constructor gets `None`.
macro_rules! take_optional {
    ($($name:ident: $taken:ty, $take:ident $($field:ident)?;)*) => {$(
        impl Take for $name {
            type Taken = Option<$taken>;

            fn take(key: &Key<Self>, params: &mut Params) -> Option<$taken> {
                params.$take(key.name $(, key.$field)?)
            }
        }
    )*};
}

take_optional! {
    Given: f64, float_if_given;
    Name: Text, string;
    Floats: Vec<f64>, floats;
    Integers: Vec<i32>, integers;
    Pairs: Vec<[f64; 2]>, pairs;
    Triples: Vec<[f64; 3]>, triples ty;
}

/// A default, as `lookat explain` shows it.
pub(crate) trait DefaultValue: Copy + 'static {
    const COUNT: Count = Count::One;
    const IS_TEXTURED: bool = false;

    /// The default in words.
    fn words(self) -> String;

    /// The range in words.
    fn range(self, range: Range) -> String {
        range.words()
    }
}

impl DefaultValue for f64 {
    fn words(self) -> String {
        number(self)
    }
}

impl DefaultValue for i32 {
    fn words(self) -> String {
        self.to_string()
    }
}

impl DefaultValue for bool {
    fn words(self) -> String {
        self.to_string()
    }
}

/// A closed list of strings. The first is the default.
impl DefaultValue for &'static [&'static str] {
    fn words(self) -> String {
        format!("\"{}\"", self[0])
    }

    fn range(self, _: Range) -> String {
        let words: Vec<String> = self.iter().map(|word| format!("\"{word}\"")).collect();
        format!("one of {}", words.join(", "))
    }
}

/// A point or a direction.
impl DefaultValue for [f64; 3] {
    fn words(self) -> String {
        self.map(number).join(" ")
    }
}

/// A color; the default is a gray.
#[derive(Clone, Copy)]
pub(crate) struct Color(pub f32);

impl DefaultValue for Color {
    fn words(self) -> String {
        self.0.to_string()
    }
}

/// A number or the name of a float texture.
#[derive(Clone, Copy)]
pub(crate) struct FloatTexture(pub f64);

impl DefaultValue for FloatTexture {
    const IS_TEXTURED: bool = true;

    fn words(self) -> String {
        number(self.0)
    }
}

/// A number or the name of a float texture, if given.
#[derive(Clone, Copy)]
pub(crate) struct GivenTexture;

impl DefaultValue for GivenTexture {
    const IS_TEXTURED: bool = true;

    fn words(self) -> String {
        "none".into()
    }
}

/// A color or the name of a spectrum texture.
#[derive(Clone, Copy)]
pub(crate) struct ColorTexture(pub Vec3);

impl DefaultValue for ColorTexture {
    const IS_TEXTURED: bool = true;

    fn words(self) -> String {
        match self.0.to_array() {
            [gray, green, blue] if gray == green && gray == blue => gray.to_string(),
            channels => channels.map(|channel| channel.to_string()).join(" "),
        }
    }
}

/// A whole number that a type needs. The constructor gets `None` after an error.
#[derive(Clone, Copy)]
pub(crate) struct Needed;

impl DefaultValue for Needed {
    fn words(self) -> String {
        REQUIRED.into()
    }
}

/// The four edges of a window, if given.
#[derive(Clone, Copy)]
pub(crate) struct Edges;

impl DefaultValue for Edges {
    const COUNT: Count = Count::Exactly(4);

    fn words(self) -> String {
        "none".into()
    }
}

/// Values without a default: the constructor gets `None`.
macro_rules! value_optional {
    ($($(#[$doc:meta])* $name:ident, $count:expr;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub(crate) struct $name;

        impl DefaultValue for $name {
            const COUNT: Count = $count;

            fn words(self) -> String {
                "none".into()
            }
        }
    )*};
}

value_optional! {
    /// A number, if given.
    Given, Count::One;
    /// A string, if given.
    Name, Count::One;
    /// A list of numbers, if given.
    Floats, Count::List;
    /// A list of whole numbers, if given.
    Integers, Count::List;
    /// A list of points in a plane, if given.
    Pairs, Count::List;
    /// A list of points, directions or normals, if given.
    Triples, Count::List;
}
