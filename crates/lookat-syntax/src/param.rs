//! Parameters: `"float radius" [2]`.

use crate::{Span, Spanned, Text};

/// The declared type of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ParamType {
    /// Whole numbers.
    Integer,
    /// Numbers.
    Float,
    /// Points in the plane, two numbers each.
    Point2,
    /// Directions in the plane, two numbers each.
    Vector2,
    /// Points in space, three numbers each; also spelled `point`.
    Point3,
    /// Directions in space, three numbers each; also spelled `vector`.
    Vector3,
    /// Surface normals, three numbers each.
    Normal,
    /// `"true"` or `"false"`.
    Bool,
    /// Quoted strings.
    String,
    /// The name of a texture.
    Texture,
    /// Linear RGB colors, three numbers each; also spelled `color`.
    Rgb,
    /// CIE XYZ colors, three numbers each.
    Xyz,
    /// Pairs of a temperature in kelvin and a scale.
    Blackbody,
    /// Pairs of a wavelength in nanometers and a value, or names of files with such pairs.
    Spectrum,
}

impl ParamType {
    /// What the values of this type are, in words.
    pub fn meaning(self) -> &'static str {
        match self {
            ParamType::Integer => "whole numbers",
            ParamType::Float => "numbers",
            ParamType::Point2 => "points in the plane, two numbers each",
            ParamType::Vector2 => "directions in the plane, two numbers each",
            ParamType::Point3 => "points in space, three numbers each",
            ParamType::Vector3 => "directions in space, three numbers each",
            ParamType::Normal => "surface normals, three numbers each",
            ParamType::Bool => "\"true\" or \"false\"",
            ParamType::String => "text in quotes",
            ParamType::Texture => "the name of a texture",
            ParamType::Rgb => "a color: linear red, green and blue",
            ParamType::Xyz => "a color: CIE XYZ",
            ParamType::Blackbody => {
                "the color of a black body: its temperature in kelvin and a scale, as in [6500 1]"
            }
            ParamType::Spectrum => {
                "a color: pairs of a wavelength in nanometers and a value, or the name of a file with such pairs"
            }
        }
    }

    /// Every spelling of a type. The canonical spelling of each type comes first.
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

    /// The type with this spelling.
    pub fn from_spelling(name: &str) -> Option<ParamType> {
        Self::SPELLINGS.iter().find(|(spelling, _)| *spelling == name).map(|(_, ty)| *ty)
    }

    /// The canonical spelling.
    pub fn name(self) -> &'static str {
        Self::SPELLINGS.iter().find(|(_, ty)| *ty == self).map_or("", |(spelling, _)| spelling)
    }

    /// The numbers of one value: 1, 2 or 3.
    pub fn arity(self) -> usize {
        match self {
            ParamType::Point2 | ParamType::Vector2 | ParamType::Blackbody => 2,
            ParamType::Point3 | ParamType::Vector3 | ParamType::Normal | ParamType::Rgb | ParamType::Xyz => 3,
            _ => 1,
        }
    }
}

/// The values of a parameter, grouped as its type requires.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// `integer`.
    Integers(Vec<i32>),
    /// `float`, and a `spectrum` of numbers.
    Numbers(Vec<f64>),
    /// `point2`, `vector2`, `blackbody`.
    Pairs(Vec<[f64; 2]>),
    /// `point3`, `vector3`, `normal`, `rgb`, `xyz`.
    Triples(Vec<[f64; 3]>),
    /// `bool`.
    Bools(Vec<bool>),
    /// `string`, `texture`, and a `spectrum` of file names.
    Strings(Vec<Text>),
}

impl Values {
    /// The number of values; a point counts as one.
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

    /// True for an empty list, `[ ]`.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// One parameter of a directive.
#[derive(Debug, Clone, PartialEq)]
pub struct Param {
    /// The declared type.
    pub ty: ParamType,
    /// The declared name. Its span covers the whole quoted declaration.
    pub name: Text,
    /// The values. Their span includes any brackets.
    pub values: Spanned<Values>,
    /// False for a list that [`Parser`](crate::Parser) was told to leave out: it is empty.
    pub is_read: bool,
}

impl Param {
    /// The bytes of the whole parameter.
    pub fn span(&self) -> Span {
        self.name.span.to(self.values.span)
    }
}
