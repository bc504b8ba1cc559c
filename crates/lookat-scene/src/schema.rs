//! The schema of the format: what describes a type of a directive and its parameters. The constructors read parameters by it.

mod synonyms;

use lookat_syntax::ParamType;

pub(crate) use crate::schema::synonyms::OLDER;
pub use crate::schema::synonyms::{Synonym, parameter_synonyms, type_synonym};

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
    /// Parameters after `keys`, which lookat ignores, unlike pbrt-v3.
    ignored: &'static [Keys],
}

impl Kind {
    /// A type that lookat renders. Its parameters are lists, so that types can share some. [`crate::kinds()`] adds the directive.
    pub(crate) const fn new(name: &'static str, meaning: &'static str, keys: &'static [Keys]) -> Kind {
        Kind { directive: "", name, meaning, instead: "", is_default: false, keys, first: &[], ignored: &[] }
    }

    /// A type that lookat does not render, and what it renders instead.
    pub(crate) const fn instead(self, instead: &'static str) -> Kind {
        Kind { instead, ..self }
    }

    /// This type with parameters that lookat ignores, unlike pbrt-v3.
    pub(crate) const fn ignoring(self, ignored: &'static [Keys]) -> Kind {
        Kind { ignored, ..self }
    }

    /// The type that pbrt-v3 uses if a scene lacks the directive.
    pub(crate) const fn by_default(self) -> Kind {
        Kind { is_default: true, ..self }
    }

    /// This type for a directive. Named materials have more parameters, and no default.
    pub(crate) fn of(self, directive: &'static str, first: Keys) -> Kind {
        Kind { directive, first, is_default: self.is_default && first.is_empty(), ..self }
    }

    /// The parameters, in the order of the documentation.
    pub fn parameters(&self) -> impl Iterator<Item = Parameter> {
        let keys = self.first.iter().chain(self.keys.iter().copied().flatten());
        let ignored = self.ignored.iter().copied().flatten().map(|key| key.parameter());
        let ignored = ignored.map(|parameter| Parameter { effect: Effect::NotRendered, ..parameter });
        keys.map(|key| key.parameter()).chain(ignored).map(|parameter| Parameter {
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

impl<T: Copy> Key<T> {
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

    /// Describes in words a default that is not a constant.
    pub const fn default_words(self, default_words: &'static str) -> Key<T> {
        Key { default_words, ..self }
    }

    /// Words the default of a parameter without which the constructor fails.
    pub const fn required(self) -> Key<T> {
        self.default_words(REQUIRED)
    }

    /// Marks a parameter that lookat ignores, unlike pbrt-v3.
    pub const fn not_rendered(self) -> Key<T> {
        self.effect(Effect::NotRendered)
    }

    /// This parameter with another type of value.
    pub fn of<U>(self, default: U) -> Key<U> {
        let Key { name, ty, range, unit, meaning, effect, default_words, .. } = self;
        Key { name, ty, default, range, unit, meaning, effect, default_words }
    }

    pub const fn effect(self, effect: Effect) -> Key<T> {
        Key { effect, ..self }
    }
}

/// The description of a parameter, for every type of value.
pub(crate) trait Described {
    fn parameter(&self) -> Parameter;
}

/// A range of numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Range {
    least: f64,
    most: f64,
    /// True for each end that the range does not contain.
    is_open: [bool; 2],
}

impl Range {
    pub const ALL: Range = Range { least: f64::NEG_INFINITY, most: f64::INFINITY, is_open: [false; 2] };

    pub const fn above(least: f64) -> Range {
        Range { least, most: f64::INFINITY, is_open: [true; 2] }
    }

    pub const fn at_least(least: f64) -> Range {
        Range { least, ..Range::ALL }
    }

    pub const fn below(most: f64) -> Range {
        Range { least: f64::NEG_INFINITY, most, is_open: [true; 2] }
    }

    /// An open interval.
    pub const fn between(least: f64, most: f64) -> Range {
        Range { least, most, is_open: [true; 2] }
    }

    /// Excludes `least`, includes `most`.
    pub const fn above_to(least: f64, most: f64) -> Range {
        Range { least, most, is_open: [true, false] }
    }

    /// With the ends.
    pub const fn from_to(least: f64, most: f64) -> Range {
        Range { least, most, is_open: [false; 2] }
    }

    pub fn contains(self, value: f64) -> bool {
        let Range { least, most, is_open: [without_least, without_most] } = self;
        let is_end = |is_open: bool, end: f64| is_open && end.is_finite() && value == end;
        least <= value && value <= most && !is_end(without_least, least) && !is_end(without_most, most)
    }

    /// As in "must be above 0 and below 180". Empty for all numbers.
    pub fn words(self) -> String {
        let [least, most] = [self.least, self.most].map(number);
        let [above, below] = self.is_open;
        match (self.least.is_finite(), self.most.is_finite()) {
            (false, false) => String::new(),
            (true, true) if !above && !below => format!("from {least} to {most}"),
            (has_least, has_most) => {
                let least = format!("{} {least}", if above { "above" } else { "at least" });
                let most = format!("{} {most}", if below { "below" } else { "at most" });
                let ends = [(has_least, least), (has_most, most)];
                ends.into_iter()
                    .filter(|(has, _)| *has)
                    .map(|(_, words)| words)
                    .collect::<Vec<_>>()
                    .join(" and ")
            }
        }
    }
}

/// A number in few characters.
pub(crate) fn number(value: f64) -> String {
    // The nearest `f32` of a short decimal number, unless it is a count.
    let is_count = value.fract() == 0.0 && value.abs() < 9e15;
    let value = match (value as f32).to_string().parse::<f64>() {
        Ok(short) if f64::from(value as f32) == value && !is_count => short,
        _ => value,
    };
    match value.abs() {
        0.0 | 0.001..1e6 => value.to_string(),
        f64::INFINITY => "infinity".into(),
        _ => {
            let (plain, power) = (value.to_string(), format!("{value:e}"));
            if plain.len() < power.len() { plain } else { power }
        }
    }
}
