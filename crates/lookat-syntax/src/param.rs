//! Parameters: `"float radius" [2]`.

use crate::{Span, Spanned, Text};

/// The declared type of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ParamType {
    /// Whole numbers.
    Integer,
    /// Numbers.
    Float,
    /// Positions in the plane, two numbers each.
    Point2,
    /// Directions in the plane, two numbers each.
    Vector2,
    /// Positions in space, three numbers each; `point` is another name.
    Point3,
    /// Directions in space, three numbers each; `vector` is another name.
    Vector3,
    /// Surface normals, three numbers each.
    Normal,
    /// `"true"` or `"false"`.
    Bool,
    /// Quoted strings.
    String,
    /// The name of a texture.
    Texture,
    /// Linear RGB colors, three numbers each; `color` is another name.
    Rgb,
    /// CIE XYZ colors, three numbers each.
    Xyz,
    /// Pairs of a temperature in kelvin and a scale.
    Blackbody,
    /// Pairs of a wavelength in nanometres and a value, or the names of files that hold such pairs.
    Spectrum,
}

impl ParamType {
    /// Every spelling that declares a type, the canonical one of each type first.
    pub const SPELLINGS: [(&'static str, ParamType); 17] = [
        ("integer", ParamType::Integer),
        ("float", ParamType::Float),
        ("point2", ParamType::Point2),
        ("vector2", ParamType::Vector2),
        ("point3", ParamType::Point3),
        ("point", ParamType::Point3),
        ("vector3", ParamType::Vector3),
        ("vector", ParamType::Vector3),
        ("normal", ParamType::Normal),
        ("bool", ParamType::Bool),
        ("string", ParamType::String),
        ("texture", ParamType::Texture),
        ("rgb", ParamType::Rgb),
        ("color", ParamType::Rgb),
        ("xyz", ParamType::Xyz),
        ("blackbody", ParamType::Blackbody),
        ("spectrum", ParamType::Spectrum),
    ];

    /// The type that a declaration names, if it is one.
    pub fn from_spelling(name: &str) -> Option<ParamType> {
        Self::SPELLINGS.iter().find(|(spelling, _)| *spelling == name).map(|(_, ty)| *ty)
    }

    /// The canonical spelling.
    pub fn name(self) -> &'static str {
        Self::SPELLINGS.iter().find(|(_, ty)| *ty == self).map_or("", |(spelling, _)| spelling)
    }

    /// How many numbers make one value: 1, 2 or 3.
    pub fn arity(self) -> usize {
        match self {
            ParamType::Point2 | ParamType::Vector2 | ParamType::Blackbody => 2,
            ParamType::Point3 | ParamType::Vector3 | ParamType::Normal | ParamType::Rgb | ParamType::Xyz => 3,
            _ => 1,
        }
    }
}

/// The values of a parameter, in the shape that its type asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// `integer`.
    Integers(Vec<i32>),
    /// `float`, and `spectrum` given as numbers.
    Numbers(Vec<f64>),
    /// `point2`, `vector2`, `blackbody`.
    Pairs(Vec<[f64; 2]>),
    /// `point3`, `vector3`, `normal`, `rgb`, `xyz`.
    Triples(Vec<[f64; 3]>),
    /// `bool`.
    Bools(Vec<bool>),
    /// `string`, `texture`, and `spectrum` given as file names.
    Strings(Vec<Text>),
}

impl Values {
    /// How many values there are: points count as one each.
    pub fn len(&self) -> usize {
        match self {
            Values::Integers(v) => v.len(),
            Values::Numbers(v) => v.len(),
            Values::Pairs(v) => v.len(),
            Values::Triples(v) => v.len(),
            Values::Bools(v) => v.len(),
            Values::Strings(v) => v.len(),
        }
    }

    /// Whether there are none: `[ ]`.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// One parameter of a directive.
#[derive(Debug, Clone, PartialEq)]
pub struct Param {
    /// The declared type.
    pub ty: ParamType,
    /// The declared name; the span is that of the whole quoted declaration.
    pub name: Text,
    /// The values; the span includes the brackets, if there are any.
    pub values: Spanned<Values>,
}

impl Param {
    /// The bytes of the whole parameter.
    pub fn span(&self) -> Span {
        self.name.span.to(self.values.span)
    }
}
