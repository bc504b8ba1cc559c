//! The schema of the format: what describes a type of a directive and its parameters. The constructors read parameters by it.

mod key;
mod range;
mod synonyms;
mod value;

use lookat_syntax::ParamType;

pub(crate) use key::{Described, Key};
pub(crate) use range::Range;
pub(crate) use synonyms::OLDER;
pub use synonyms::{Synonym, parameter_synonyms, type_synonym};
pub(crate) use value::{
    Color, ColorTexture, DefaultValue, Edges, FloatTexture, Floats, Given, GivenTexture, Integers, Name,
    Needed, Pairs, Triples,
};

/// The default of a parameter without which a constructor fails, in words.
pub const REQUIRED: &str = "required";

/// Parameters that several types share.
pub(crate) type Keys = &'static [&'static (dyn Described + Sync)];

/// A type of a directive, such as `Camera "perspective"`.
#[derive(Clone, Copy)]
pub struct Kind {
    /// The directive, such as `Camera`.
    pub directive: &'static str,
    /// The name of the type.
    pub name: &'static str,
    /// What it is, in a sentence without a period.
    pub meaning: &'static str,
    /// What lookat renders instead; empty for a type that it renders.
    pub instead: &'static str,
    /// True for the type that pbrt-v3 uses if a scene lacks the directive.
    pub is_default: bool,
    keys: &'static [Keys],
    /// Parameters before `keys`.
    first: Keys,
}

impl Kind {
    /// A type that lookat renders. Its parameters are lists, so that types can share some.
    pub(crate) const fn new(
        directive: &'static str,
        name: &'static str,
        meaning: &'static str,
        keys: &'static [Keys],
    ) -> Kind {
        Kind { directive, name, meaning, instead: "", is_default: false, keys, first: &[] }
    }

    /// A type that lookat does not render, and what it renders instead.
    pub(crate) const fn instead(self, instead: &'static str) -> Kind {
        Kind { instead, ..self }
    }

    /// The type that pbrt-v3 uses if a scene lacks the directive.
    pub(crate) const fn by_default(self) -> Kind {
        Kind { is_default: true, ..self }
    }

    /// The same type of another directive, with more parameters.
    pub(crate) const fn of(self, directive: &'static str, first: Keys) -> Kind {
        Kind { directive, first, is_default: false, ..self }
    }

    /// The parameters, in the order of the documentation.
    pub fn parameters(&self) -> impl Iterator<Item = Parameter> {
        let keys = self.first.iter().chain(self.keys.iter().copied().flatten());
        keys.map(|key| key.parameter()).map(|parameter| Parameter {
            synonyms: synonyms::words_for(self.directive, self.name, parameter.name),
            ..parameter
        })
    }
}

/// A parameter of a type.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// The name, such as `fov`.
    pub name: &'static str,
    /// The type of its values. All color types are interchangeable.
    pub ty: ParamType,
    /// How many values it takes.
    pub count: Count,
    /// True if it can name a texture instead.
    pub is_textured: bool,
    /// The default in words, or [`REQUIRED`].
    pub default: String,
    /// The range in words, such as "above 0 and below 180". Empty if every value is right.
    pub range: String,
    /// The unit of the values.
    pub unit: Unit,
    /// What it is, in a sentence without a period.
    pub meaning: &'static str,
    /// What lookat does with it.
    pub effect: Effect,
    /// Words of other programs for it, in lower case and without `_` and `-`.
    pub synonyms: Vec<&'static str>,
}

/// The number of values of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Count {
    /// One value.
    One,
    /// A fixed number of values.
    Exactly(usize),
    /// A list of any length.
    List,
}

/// The unit of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// A pure number, a color or a text.
    None,
    /// Degrees.
    Degrees,
    /// Pixels of the picture.
    Pixels,
    /// Lengths in camera space.
    CameraSpace,
    /// Lengths in the space of the current transformation.
    ObjectSpace,
    /// Lengths in world space.
    WorldSpace,
}

impl Unit {
    /// Its name. Empty for a pure number.
    pub fn name(self) -> &'static str {
        match self {
            Unit::None => "",
            Unit::Degrees => "degrees",
            Unit::Pixels => "pixels",
            Unit::CameraSpace => "units of camera space",
            Unit::ObjectSpace => "units of object space",
            Unit::WorldSpace => "units of world space",
        }
    }
}

/// The names of types, as a scene writes them.
pub(crate) fn names(kinds: &[Kind]) -> Vec<&'static str> {
    kinds.iter().map(|kind| kind.name).collect()
}

/// What lookat does with a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effect {
    /// It renders the parameter as pbrt-v3 does.
    Rendered,
    /// It checks the value, but the picture cannot depend on it.
    NoEffect,
    /// It ignores the parameter, unlike pbrt-v3.
    NotRendered,
    /// The parameter is lookat's own: pbrt-v3 does not have it.
    Own,
}

impl Effect {
    /// What to add to the meaning of a parameter. Empty for one that lookat renders.
    pub fn words(self) -> &'static str {
        match self {
            Effect::Rendered => "",
            Effect::NoEffect => "no effect on the picture",
            Effect::NotRendered => "lookat ignores it",
            Effect::Own => "not in pbrt-v3",
        }
    }
}
