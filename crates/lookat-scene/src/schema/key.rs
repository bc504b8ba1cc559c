//! Parameters as typed constants.

use glam::Vec3;
use lookat_syntax::ParamType;

use super::value::{Color, ColorTexture, DefaultValue, FloatTexture, GivenTexture, Name, Needed};
use super::{Effect, Parameter, REQUIRED, Range, Unit};

/// A parameter with the type of its value. A constructor takes its value.
#[derive(Clone, Copy)]
pub(crate) struct Key<T> {
    pub name: &'static str,
    pub ty: ParamType,
    pub default: T,
    pub range: Range,
    pub unit: Unit,
    pub meaning: &'static str,
    pub effect: Effect,
    /// The default in words, if it depends on something.
    pub default_words: &'static str,
}

impl<T: DefaultValue> Key<T> {
    pub const fn new(name: &'static str, ty: ParamType, default: T, meaning: &'static str) -> Key<T> {
        let (range, unit, effect) = (Range::ALL, Unit::None, Effect::Rendered);
        Key { name, ty, default, range, unit, meaning, effect, default_words: "" }
    }

    /// Rejects values outside a range.
    pub const fn within(self, range: Range) -> Key<T> {
        Key { range, ..self }
    }

    pub const fn unit(self, unit: Unit) -> Key<T> {
        Key { unit, ..self }
    }

    /// Words a default that depends on something.
    pub const fn default_words(self, default_words: &'static str) -> Key<T> {
        Key { default_words, ..self }
    }

    /// Words the default of a parameter without which the constructor fails.
    pub const fn required(self) -> Key<T> {
        self.default_words(REQUIRED)
    }

    pub const fn effect(self, effect: Effect) -> Key<T> {
        Key { effect, ..self }
    }
}

impl Key<f64> {
    pub const fn float(name: &'static str, default: f64, meaning: &'static str) -> Self {
        Key::new(name, ParamType::Float, default, meaning)
    }
}

impl Key<i32> {
    pub const fn integer(name: &'static str, default: i32, meaning: &'static str) -> Self {
        Key::new(name, ParamType::Integer, default, meaning)
    }
}

impl Key<Needed> {
    pub const fn needed(name: &'static str, meaning: &'static str) -> Self {
        Key::new(name, ParamType::Integer, Needed, meaning)
    }
}

impl Key<Color> {
    pub const fn color(name: &'static str, default: f32, meaning: &'static str) -> Self {
        Key::new(name, ParamType::Rgb, Color(default), meaning)
    }
}

impl Key<FloatTexture> {
    pub const fn float_texture(name: &'static str, default: f64, meaning: &'static str) -> Self {
        Key::new(name, ParamType::Float, FloatTexture(default), meaning)
    }
}

impl Key<GivenTexture> {
    pub const fn given_texture(name: &'static str, meaning: &'static str) -> Self {
        Key::new(name, ParamType::Float, GivenTexture, meaning)
    }
}

impl Key<ColorTexture> {
    pub const fn color_texture(name: &'static str, default: f32, meaning: &'static str) -> Self {
        Key::new(name, ParamType::Rgb, ColorTexture(Vec3::splat(default)), meaning)
    }
}

impl Key<Name> {
    pub const fn string(name: &'static str, meaning: &'static str) -> Self {
        Key::new(name, ParamType::String, Name, meaning)
    }
}

impl Key<[f64; 3]> {
    pub const fn point(name: &'static str, default: [f64; 3], meaning: &'static str) -> Self {
        Key::new(name, ParamType::Point3, default, meaning)
    }
}

impl Key<bool> {
    pub const fn bool(name: &'static str, default: bool, meaning: &'static str) -> Self {
        Key::new(name, ParamType::Bool, default, meaning)
    }
}

impl Key<&'static [&'static str]> {
    /// One of the words; the first is the default.
    pub const fn choice(name: &'static str, words: &'static [&'static str], meaning: &'static str) -> Self {
        Key::new(name, ParamType::String, words, meaning)
    }
}

/// The description of a parameter, for every type of value.
pub(crate) trait Described {
    fn parameter(&self) -> Parameter;
}

impl<T: DefaultValue> Described for Key<T> {
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
