//! The statements of a scene file as written, before any name or default is resolved.

use crate::{Param, Span, Text};

/// A directive and its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Statement {
    /// The directive.
    pub directive: Directive,
    /// From the keyword to the last value.
    pub span: Span,
    /// The bytes of the keyword.
    pub keyword: Span,
    /// True if a part of the directive could not be read. The directive lacks this part, and the parser has reported
    /// it.
    pub faulty: bool,
}

/// One directive of a scene file. Numbers are as written; angles are in degrees.
#[derive(Debug, Clone, PartialEq)]
pub enum Directive {
    /// Resets the current transformation matrix (CTM).
    Identity,
    /// `CTM = CTM * translate(x, y, z)`.
    Translate([f64; 3]),
    /// `CTM = CTM * scale(x, y, z)`.
    Scale([f64; 3]),
    /// `CTM = CTM * rotate(angle, axis)`: angle in degrees, then the axis.
    Rotate([f64; 4]),
    /// `CTM = CTM * look_at(eye, look, up)`: three points of three numbers.
    LookAt([f64; 9]),
    /// `CTM = matrix`, column by column.
    Transform([f64; 16]),
    /// `CTM = CTM * matrix`, column by column.
    ConcatTransform([f64; 16]),
    /// Names the CTM.
    CoordinateSystem(Text),
    /// Makes a named transformation the CTM.
    CoordSysTransform(Text),
    /// Selects the CTM (start time, end time or both) that the next transformation directives change.
    ActiveTransform(ActiveTransform),
    /// The start time and the end time of the two CTMs.
    TransformTimes([f64; 2]),
    /// Saves the CTM.
    TransformBegin,
    /// Restores the CTM.
    TransformEnd,
    /// Saves the graphics state.
    AttributeBegin,
    /// Restores the graphics state.
    AttributeEnd,
    /// Starts the definition of an object.
    ObjectBegin(Text),
    /// Ends the definition of an object.
    ObjectEnd,
    /// Places a copy of an object.
    ObjectInstance(Text),
    /// Flips the normals of the following shapes.
    ReverseOrientation,
    /// Ends the options and begins the description of the world.
    WorldBegin,
    /// Ends the description of the world.
    WorldEnd,
    /// Makes a named material the current one.
    NamedMaterial(Text),
    /// The media inside and outside the following shapes. A single name stands for both.
    MediumInterface {
        /// Inside.
        inside: Text,
        /// Outside, if it was given.
        outside: Option<Text>,
    },
    /// `Texture "name" "float or spectrum" "class" parameters`.
    Texture {
        /// The name of the new texture.
        name: Text,
        /// `float`, or `spectrum` (`color`).
        value: Text,
        /// The class of texture and its parameters.
        entity: Entity,
    },
    /// A directive made of a keyword, a quoted type or name, and parameters.
    Entity(EntityKind, Entity),
    /// Reads another file at this place.
    Include {
        /// The file, as written.
        file: Text,
        /// Parameters after the file name. They belong to the last directive of the included file, because pbrt-v3
        /// splices tokens.
        rest: Vec<Param>,
    },
}

/// The argument of `ActiveTransform`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActiveTransform {
    /// Both CTMs.
    All,
    /// The CTM at the start time.
    StartTime,
    /// The CTM at the end time.
    EndTime,
}

/// A quoted type or name and its parameters: `"sphere" "float radius" [2]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Entity {
    /// The type, or the name for `MakeNamedMaterial` and `MakeNamedMedium`.
    pub name: Text,
    /// The parameters in the order of the file.
    pub params: Vec<Param>,
}

/// The directives that consist of an [`Entity`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EntityKind {
    /// The camera model.
    Camera,
    /// The size and the file of the picture.
    Film,
    /// The reconstruction filter.
    PixelFilter,
    /// The generator of sample points.
    Sampler,
    /// The light transport algorithm.
    Integrator,
    /// The ray intersection accelerator.
    Accelerator,
    /// A shape.
    Shape,
    /// The material of the following shapes.
    Material,
    /// A material with a name.
    MakeNamedMaterial,
    /// A light without a shape.
    LightSource,
    /// Makes the following shapes emit light.
    AreaLightSource,
    /// A participating medium with a name.
    MakeNamedMedium,
}

impl EntityKind {
    /// Every kind.
    pub const ALL: [EntityKind; 12] = [
        EntityKind::Camera,
        EntityKind::Film,
        EntityKind::PixelFilter,
        EntityKind::Sampler,
        EntityKind::Integrator,
        EntityKind::Accelerator,
        EntityKind::Shape,
        EntityKind::Material,
        EntityKind::MakeNamedMaterial,
        EntityKind::LightSource,
        EntityKind::AreaLightSource,
        EntityKind::MakeNamedMedium,
    ];

    /// The keyword of the directive.
    pub fn keyword(self) -> &'static str {
        match self {
            EntityKind::Camera => "Camera",
            EntityKind::Film => "Film",
            EntityKind::PixelFilter => "PixelFilter",
            EntityKind::Sampler => "Sampler",
            EntityKind::Integrator => "Integrator",
            EntityKind::Accelerator => "Accelerator",
            EntityKind::Shape => "Shape",
            EntityKind::Material => "Material",
            EntityKind::MakeNamedMaterial => "MakeNamedMaterial",
            EntityKind::LightSource => "LightSource",
            EntityKind::AreaLightSource => "AreaLightSource",
            EntityKind::MakeNamedMedium => "MakeNamedMedium",
        }
    }
}

impl Directive {
    /// True for the directives that change the CTM by numbers, except LookAt.
    pub fn is_transformation(&self) -> bool {
        matches!(
            self,
            Directive::Translate(_)
                | Directive::Scale(_)
                | Directive::Rotate(_)
                | Directive::Transform(_)
                | Directive::ConcatTransform(_)
        )
    }

    /// The keyword of the directive.
    pub fn keyword(&self) -> &'static str {
        match self {
            Directive::Identity => "Identity",
            Directive::Translate(_) => "Translate",
            Directive::Scale(_) => "Scale",
            Directive::Rotate(_) => "Rotate",
            Directive::LookAt(_) => "LookAt",
            Directive::Transform(_) => "Transform",
            Directive::ConcatTransform(_) => "ConcatTransform",
            Directive::CoordinateSystem(_) => "CoordinateSystem",
            Directive::CoordSysTransform(_) => "CoordSysTransform",
            Directive::ActiveTransform(_) => "ActiveTransform",
            Directive::TransformTimes(_) => "TransformTimes",
            Directive::TransformBegin => "TransformBegin",
            Directive::TransformEnd => "TransformEnd",
            Directive::AttributeBegin => "AttributeBegin",
            Directive::AttributeEnd => "AttributeEnd",
            Directive::ObjectBegin(_) => "ObjectBegin",
            Directive::ObjectEnd => "ObjectEnd",
            Directive::ObjectInstance(_) => "ObjectInstance",
            Directive::ReverseOrientation => "ReverseOrientation",
            Directive::WorldBegin => "WorldBegin",
            Directive::WorldEnd => "WorldEnd",
            Directive::NamedMaterial(_) => "NamedMaterial",
            Directive::MediumInterface { .. } => "MediumInterface",
            Directive::Texture { .. } => "Texture",
            Directive::Include { .. } => "Include",
            Directive::Entity(kind, _) => kind.keyword(),
        }
    }

    /// The parameter list of the directive; `None` for directives without parameters.
    pub fn params_mut(&mut self) -> Option<&mut Vec<Param>> {
        match self {
            Directive::Texture { entity, .. } | Directive::Entity(_, entity) => Some(&mut entity.params),
            Directive::Include { rest, .. } => Some(rest),
            _ => None,
        }
    }
}
