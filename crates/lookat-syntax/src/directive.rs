//! The statements of a scene file as written, before any name or default is resolved, and the form of each directive.

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

macro_rules! entity_kinds {
    ($($(#[$doc:meta])* $kind:ident,)*) => {
        /// The directives that consist of an [`Entity`].
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum EntityKind {$(
            $(#[$doc])*
            $kind,
        )*}

        impl EntityKind {
            /// Every kind.
            pub const ALL: &[EntityKind] = &[$(EntityKind::$kind),*];

            /// The keyword of the directive.
            pub fn keyword(self) -> &'static str {
                match self {
                    $(EntityKind::$kind => stringify!($kind),)*
                }
            }
        }
    };
}

entity_kinds! {
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

// The directives of pbrt-v3: how a scene writes each, and what it does.

/// A directive as documentation shows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DirectiveForm {
    /// The keyword.
    pub keyword: &'static str,
    /// What a scene writes after the keyword; empty for nothing.
    pub arguments: &'static str,
    /// What it does, in a sentence without a period.
    pub meaning: &'static str,
    /// An example; empty where messages need none.
    pub example: &'static str,
}

impl DirectiveForm {
    const fn like(self, example: &'static str) -> DirectiveForm {
        DirectiveForm { example, ..self }
    }
}

const fn form(keyword: &'static str, arguments: &'static str, meaning: &'static str) -> DirectiveForm {
    DirectiveForm { keyword, arguments, meaning, example: "" }
}

pub(crate) const NAME: &str = "\"name\"";
const TYPE: &str = "\"type\" parameters";
const MATRIX: &str = "[m00 m10 m20 m30 m01 ... m33]";

impl Directive {
    /// Every directive of pbrt-v3. The CTM is the current transformation matrix.
    #[rustfmt::skip]
    pub const FORMS: [DirectiveForm; 37] = [
        form("Identity", "", "resets the current transformation matrix (CTM)"),
        form("Translate", "x y z", "moves what follows; before Camera, maps the world to the camera: moves the world, not the camera").like("Translate 0 0 1"),
        form("Scale", "x y z", "scales what follows; before Camera, scales the world that the camera sees").like("Scale 1 1 1"),
        form("Rotate", "angle x y z", "rotates what follows by an angle in degrees around an axis; before Camera, rotates the world, not the camera").like("Rotate 45 0 1 0"),
        form("LookAt", "ex ey ez lx ly lz ux uy uz", "places the camera at e, which looks at l with u up; write it before Camera; in the world block, maps what follows to the space of such a camera"),
        form("Transform", MATRIX, "replaces the CTM by a matrix, column by column; before Camera, the matrix maps the world to the camera: the inverse of the matrices of Blender and glTF"),
        form("ConcatTransform", MATRIX, "multiplies the CTM by a matrix, column by column; before Camera, the CTM maps the world to the camera"),
        form("CoordinateSystem", NAME, "names the CTM").like("CoordinateSystem \"lamp\""),
        form("CoordSysTransform", NAME, "makes a named transformation the CTM").like("CoordSysTransform \"lamp\""),
        form("ActiveTransform", "All, StartTime or EndTime", "selects the times whose CTM the next transformations change"),
        form("TransformTimes", "start end", "sets the times of the two CTMs of a moving scene"),
        form("TransformBegin", "", "saves the CTM until TransformEnd"),
        form("TransformEnd", "", "restores the CTM of TransformBegin"),
        form("AttributeBegin", "", "saves the CTM, material, area light, media and orientation until AttributeEnd"),
        form("AttributeEnd", "", "restores what AttributeBegin saved"),
        form("ObjectBegin", NAME, "starts the definition of an object: the shapes until ObjectEnd").like("ObjectBegin \"tree\""),
        form("ObjectEnd", "", "ends the definition of an object"),
        form("ObjectInstance", NAME, "places a copy of an object").like("ObjectInstance \"tree\""),
        form("ReverseOrientation", "", "flips the normals of the shapes that follow"),
        form("WorldBegin", "", "ends the options, resets the CTM and begins the lights and shapes"),
        form("WorldEnd", "", "ends the lights and shapes"),
        form("NamedMaterial", NAME, "gives a material of MakeNamedMaterial to the shapes that follow").like("NamedMaterial \"red\""),
        form("MediumInterface", "\"inside\" \"outside\"", "names the media on the sides of the shapes that follow; \"\" is empty space").like("MediumInterface \"inside\" \"outside\""),
        form("Texture", "\"name\" \"float or spectrum\" \"type\" parameters", "defines a texture, which parameters of materials name").like("Texture \"wood\" \"spectrum\" \"imagemap\""),
        form("Include", "\"file\"", "reads another file at this place").like("Include \"part.pbrt\""),
        form("Camera", TYPE, "the camera, which stands at the inverse of the CTM").like("Camera \"perspective\""),
        form("Film", TYPE, "the size and the file of the picture").like("Film \"image\""),
        form("PixelFilter", TYPE, "the filter that turns samples into pixels").like("PixelFilter \"box\""),
        form("Sampler", TYPE, "the sample points, and their number in each pixel").like("Sampler \"halton\""),
        form("Integrator", TYPE, "the light transport algorithm").like("Integrator \"path\""),
        form("Accelerator", TYPE, "the structure that finds the shapes on a ray").like("Accelerator \"bvh\""),
        form("Shape", TYPE, "adds a shape with the current transformation and material").like("Shape \"sphere\""),
        form("Material", TYPE, "sets the material of the shapes that follow").like("Material \"matte\""),
        form("MakeNamedMaterial", "\"name\" parameters", "defines a material for NamedMaterial and for mix").like("MakeNamedMaterial \"red\" \"string type\" \"matte\""),
        form("LightSource", TYPE, "adds a light without a shape").like("LightSource \"point\""),
        form("AreaLightSource", TYPE, "makes the shapes that follow emit light").like("AreaLightSource \"diffuse\""),
        form("MakeNamedMedium", "\"name\" parameters", "defines a medium for MediumInterface").like("MakeNamedMedium \"fog\" \"string type\" \"homogeneous\""),
    ];

    /// The form of a keyword.
    pub(crate) fn form(keyword: &[u8]) -> Option<&'static DirectiveForm> {
        Directive::FORMS.iter().find(|form| form.keyword.as_bytes() == keyword)
    }

    /// Every keyword of pbrt-v3.
    pub const KEYWORDS: [&'static str; Directive::FORMS.len()] = {
        let mut keywords = [""; Directive::FORMS.len()];
        let mut index = 0;
        while index < keywords.len() {
            keywords[index] = Directive::FORMS[index].keyword;
            index += 1;
        }
        keywords
    };
}
