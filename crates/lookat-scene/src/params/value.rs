//! The types of a parameter's value: its default in words, and how a constructor takes it.

use glam::{DVec3, Vec3};
use lookat_syntax::{Param, ParamType, Text, Values};

use crate::params::{Params, SPECTRUM_TYPES};
use crate::schema::{Count, Described, Key, Parameter, Range, Unit, number};
use crate::texture::Texture;
use crate::transform::LARGEST;
use crate::{color, transform};

/// The most samples of a light, or of ambient occlusion, within each camera sample: about a hundredth of a second.
pub(crate) const MOST_NESTED: i32 = 1 << 16;

/// A type of value. The value itself is a default.
pub(crate) trait ParamValue: Copy + 'static {
    const COUNT: Count = Count::One;
    const IS_TEXTURED: bool = false;

    /// What the constructor gets.
    type Taken;

    /// The default in words.
    fn words(self) -> String {
        "none".into()
    }

    /// The range in words.
    fn range(self, range: Range) -> String {
        range.words()
    }

    /// Takes the parameter of a key.
    fn take(key: &Key<Self>, params: &mut Params) -> Self::Taken;
}

/// The one value of a parameter, or `None`.
macro_rules! one {
    ($params:expr, $name:expr, $types:expr, $variant:ident) => {
        match $params.take_one($name, $types).map(|param| param.values.value) {
            Some(Values::$variant(mut values)) => values.pop(),
            _ => None,
        }
    };
}

impl ParamValue for f64 {
    type Taken = f64;

    fn words(self) -> String {
        number(self)
    }

    /// An angle that looks like radians gets a message.
    fn take(key: &Key<f64>, params: &mut Params) -> f64 {
        let value = one!(params, key.name, &[key.ty], Numbers).unwrap_or(key.default);
        if key.unit == Unit::Degrees {
            params.doubt_angle(key.name, key.name, value);
        }
        if params.check_within(key, value) { value } else { key.default }
    }
}

impl ParamValue for i32 {
    type Taken = i32;

    fn words(self) -> String {
        self.to_string()
    }

    fn take(key: &Key<i32>, params: &mut Params) -> i32 {
        let value = one!(params, key.name, &[key.ty], Integers).unwrap_or(key.default);
        if params.check_within(key, value) { value } else { key.default }
    }
}

impl ParamValue for bool {
    type Taken = bool;

    fn words(self) -> String {
        self.to_string()
    }

    fn take(key: &Key<bool>, params: &mut Params) -> bool {
        one!(params, key.name, &[key.ty], Bools).unwrap_or(key.default)
    }
}

/// A closed list of strings. The first is the default, which also replaces an unknown string, as in pbrt-v3.
impl ParamValue for &'static [&'static str] {
    type Taken = &'static str;

    fn words(self) -> String {
        format!("\"{}\"", self[0])
    }

    fn range(self, _: Range) -> String {
        let words: Vec<String> = self.iter().map(|word| format!("\"{word}\"")).collect();
        format!("one of {}", words.join(", "))
    }

    fn take(key: &Key<Self>, params: &mut Params) -> &'static str {
        let known = key.default;
        let Some(given) = one!(params, key.name, &[key.ty], Strings) else { return known[0] };
        known.iter().find(|known| **known == given.value).copied().unwrap_or_else(|| {
            params.unknown_choice(key.name, &given, known);
            known[0]
        })
    }
}

/// A point or a direction.
impl ParamValue for [f64; 3] {
    type Taken = DVec3;

    fn words(self) -> String {
        self.map(number).join(" ")
    }

    fn take(key: &Key<Self>, params: &mut Params) -> DVec3 {
        one!(params, key.name, &[key.ty], Triples).unwrap_or(key.default).into()
    }
}

/// A color.
#[derive(Clone, Copy)]
pub(crate) struct Color(pub Vec3);

impl ParamValue for Color {
    type Taken = Vec3;

    fn words(self) -> String {
        match self.0.to_array() {
            [gray, green, blue] if gray == green && gray == blue => gray.to_string(),
            channels => channels.map(|channel| channel.to_string()).join(" "),
        }
    }

    fn take(key: &Key<Self>, params: &mut Params) -> Vec3 {
        params.spectrum(key.name, key.default.0)
    }
}

/// A number or the name of a float texture.
#[derive(Clone, Copy)]
pub(crate) struct FloatTexture(pub f64);

impl ParamValue for FloatTexture {
    const IS_TEXTURED: bool = true;

    type Taken = Texture<f64>;

    fn words(self) -> String {
        number(self.0)
    }

    fn take(key: &Key<Self>, params: &mut Params) -> Texture<f64> {
        let texture = params.float_texture(key.name).unwrap_or(Texture::Constant(key.default.0));
        match texture.constant() {
            Some(value) if !params.check_within(key, value) => Texture::Constant(key.default.0),
            _ => texture,
        }
    }
}

/// A number or the name of a float texture, if given.
#[derive(Clone, Copy)]
pub(crate) struct OptionalTexture;

impl ParamValue for OptionalTexture {
    const IS_TEXTURED: bool = true;

    type Taken = Option<Texture<f64>>;

    fn take(key: &Key<Self>, params: &mut Params) -> Option<Texture<f64>> {
        let texture = params.float_texture(key.name)?;
        let is_within = texture.constant().is_none_or(|value| params.check_within(key, value));
        is_within.then_some(texture)
    }
}

/// A color or the name of a spectrum texture.
#[derive(Clone, Copy)]
pub(crate) struct ColorTexture(pub Vec3);

impl ParamValue for ColorTexture {
    const IS_TEXTURED: bool = true;

    type Taken = Texture<Vec3>;

    fn words(self) -> String {
        Color(self.0).words()
    }

    fn take(key: &Key<Self>, params: &mut Params) -> Texture<Vec3> {
        let default = key.default.0;
        let Some(name) = one!(params, key.name, &[ParamType::Texture], Strings) else {
            return Texture::Constant(params.spectrum(key.name, default));
        };
        params.register(key.name, ParamType::Rgb);
        let known = params.textures.and_then(|textures| {
            params.find_texture(&textures.spectrum, &textures.float, &name).cloned().flatten()
        });
        known.unwrap_or(Texture::Constant(default))
    }
}

/// The four edges of a window, if given.
#[derive(Clone, Copy)]
pub(crate) struct Edges;

impl ParamValue for Edges {
    const COUNT: Count = Count::Exactly(4);

    type Taken = Option<[f64; 4]>;

    fn take(key: &Key<Edges>, params: &mut Params) -> Option<[f64; 4]> {
        let edges: Result<[f64; 4], Vec<f64>> = params.take(&key.of(Floats))?.try_into();
        if let Err(other) = &edges {
            let message = format!("{} takes 4 values, not {}", key.name, other.len());
            params.reject(key.name, message, Some("write the edges as xmin xmax ymin ymax"));
        }
        edges.ok()
    }
}

/// Values without a default: the constructor gets `None`.
macro_rules! optional {
    ($($(#[$doc:meta])* $name:ident, $count:expr, $taken:ty, |$params:ident, $key:ident| $take:expr;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub(crate) struct $name;

        impl ParamValue for $name {
            const COUNT: Count = $count;

            type Taken = Option<$taken>;

            fn take($key: &Key<Self>, $params: &mut Params) -> Option<$taken> {
                $take
            }
        }
    )*};
}

/// All values of a parameter, or `None`.
macro_rules! all {
    ($params:expr, $key:expr, $variant:ident) => {
        match $params.take_of($key.name, &[$key.ty]).map(|param| param.values.value) {
            Some(Values::$variant(values)) => Some(values),
            _ => None,
        }
    };
}

optional! {
    /// A number, if given.
    OptionalFloat, Count::One, f64, |params, key| one!(params, key.name, &[key.ty], Numbers);
    /// A whole number, if given.
    OptionalInteger, Count::One, i32, |params, key| {
        one!(params, key.name, &[key.ty], Integers).filter(|value| params.check_within(key, *value))
    };
    /// A string, if given.
    Name, Count::One, Text, |params, key| one!(params, key.name, &[key.ty], Strings);
    /// A list of numbers, if given.
    Floats, Count::List, Vec<f64>, |params, key| all!(params, key, Numbers);
    /// A list of whole numbers, if given.
    Integers, Count::List, Vec<i32>, |params, key| all!(params, key, Integers);
    /// A list of points in a plane, if given.
    Pairs, Count::List, Vec<[f64; 2]>, |params, key| all!(params, key, Pairs);
    /// A list of points, directions or normals, if given.
    Triples, Count::List, Vec<[f64; 3]>, |params, key| all!(params, key, Triples);
}

/// Constructors of keys: the name, the type of the default as the constructor takes it, the declared type and the value.
macro_rules! constructors {
    ($($(#[$doc:meta])* $of:ty: $name:ident($($default:ident: $ty:ty)?) = $declared:ident, $value:expr;)*) => {$(
        impl Key<$of> {
            $(#[$doc])*
            pub const fn $name(name: &'static str, $($default: $ty,)? meaning: &'static str) -> Self {
                Key::new(name, ParamType::$declared, $value, meaning)
            }
        }
    )*};
}

constructors! {
    f64: float(default: f64) = Float, default;
    i32: integer(default: i32) = Integer, default;
    OptionalInteger: optional_integer() = Integer, OptionalInteger;
    Color: color(default: f32) = Rgb, Color(Vec3::splat(default));
    FloatTexture: float_texture(default: f64) = Float, FloatTexture(default);
    OptionalTexture: optional_texture() = Float, OptionalTexture;
    ColorTexture: color_texture(default: f32) = Rgb, ColorTexture(Vec3::splat(default));
    Name: string() = String, Name;
    [f64; 3]: point(default: [f64; 3]) = Point3, default;
    bool: bool(default: bool) = Bool, default;
    /// One of the words; the first is the default.
    &'static [&'static str]: choice(words: &'static [&'static str]) = String, words;
}

impl<T: ParamValue> Described for Key<T> {
    fn parameter(&self) -> Parameter {
        let default = match self.default_words {
            "" => self.default.words(),
            words => words.into(),
        };
        Parameter {
            name: self.name,
            ty: self.ty,
            count: T::COUNT,
            is_textured: T::IS_TEXTURED,
            default,
            range: self.default.range(self.range),
            unit: self.unit,
            meaning: self.meaning,
            effect: self.effect,
            synonyms: Vec::new(),
        }
    }
}

/// A value of a type, for messages.
fn example(ty: ParamType) -> &'static str {
    match ty {
        ParamType::Integer | ParamType::Float => "1",
        ParamType::Bool => "\"true\"",
        ParamType::String | ParamType::Texture => "\"NAME\"",
        ParamType::Blackbody => "[6500 1]",
        ParamType::Spectrum => "[400 1 700 1]",
        ParamType::Point2 | ParamType::Vector2 => "[0 0]",
        ParamType::Point3 | ParamType::Vector3 => "[0 0 0]",
        ParamType::Normal => "[0 0 1]",
        ParamType::Rgb | ParamType::Xyz => "[1 1 1]",
    }
}

impl Params<'_> {
    /// Takes a parameter of one of the types. pbrt-v3 ignores a parameter of another type.
    fn take_of(&mut self, name: &'static str, types: &[ParamType]) -> Option<Param> {
        self.register(name, types[0]);
        let index = self.params.iter().rposition(|p| p.name.value == name && types.contains(&p.ty))?;
        let param = self.params.remove(index);
        self.places.push((name, param.values.span, param.ty));
        Some(param)
    }

    /// Like `take_of`, and reports an error unless there is exactly one value.
    fn take_one(&mut self, name: &'static str, types: &[ParamType]) -> Option<Param> {
        let param = self.take_of(name, types)?;
        // A list of wavelengths and values is one spectrum.
        if param.values.value.len() == 1 || param.ty == ParamType::Spectrum {
            return Some(param);
        }
        if param.values.value.is_empty() {
            let help = format!("write a value: \"{} {name}\" {}", param.ty.name(), example(param.ty));
            self.reject(name, format!("{name} has no value"), Some(&help));
            return None;
        }
        let message = format!("{name} takes 1 value, not {}", param.values.value.len());
        let has_comma = self.files.sources.text(param.values.span).contains(&b',');
        let help = has_comma.then_some("write the decimal separator as a point, not as a comma");
        self.reject(name, message, help);
        None
    }

    /// A number or a named texture, if the parameter is given and has a value.
    fn float_texture(&mut self, name: &'static str) -> Option<Texture<f64>> {
        let Some(texture) = one!(self, name, &[ParamType::Texture], Strings) else {
            return one!(self, name, &[ParamType::Float], Numbers).map(Texture::Constant);
        };
        self.register(name, ParamType::Float);
        let textures = self.textures?;
        self.find_texture(&textures.float, &textures.spectrum, &texture).cloned().flatten()
    }

    /// A color: `rgb`, `xyz`, `blackbody` or `spectrum`.
    fn spectrum(&mut self, name: &'static str, default: Vec3) -> Vec3 {
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

    /// Reports lengths and coordinates outside the range of computation.
    pub fn check_range(&mut self, name: &'static str, values: &[f64]) {
        if let Some(beyond) = values.iter().find(|value| value.abs() > LARGEST) {
            self.reject(name, format!("{name} of {beyond:e} is too large; the limit is {LARGEST:e}"), None);
        }
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
}
