//! The directives of pbrt-v3: how a scene writes each, and what it does.

use crate::Directive;

/// A directive as documentation shows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Form {
    /// The keyword.
    pub keyword: &'static str,
    /// What a scene writes after the keyword; empty for nothing.
    pub arguments: &'static str,
    /// What it does, in a sentence without a period.
    pub meaning: &'static str,
}

const fn form(keyword: &'static str, arguments: &'static str, meaning: &'static str) -> Form {
    Form { keyword, arguments, meaning }
}

const TYPE: &str = "\"type\" parameters";
const MATRIX: &str = "[m00 m10 m20 m30 m01 ... m33]";

impl Directive {
    /// Every directive of pbrt-v3. The CTM is the current transformation matrix.
    #[rustfmt::skip]
    pub const FORMS: [Form; 37] = [
        form("Identity", "", "resets the current transformation matrix (CTM)"),
        form("Translate", "x y z", "moves what follows; before Camera, maps the world to the camera: moves the world, not the camera"),
        form("Scale", "x y z", "scales what follows; before Camera, scales the world that the camera sees"),
        form("Rotate", "angle x y z", "rotates what follows by an angle in degrees around an axis; before Camera, rotates the world, not the camera"),
        form("LookAt", "ex ey ez lx ly lz ux uy uz", "places the camera at e, which looks at l with u up; write it before Camera; in the world block, maps what follows to the space of such a camera"),
        form("Transform", MATRIX, "replaces the CTM by a matrix, column by column; before Camera, the matrix maps the world to the camera: the inverse of the matrices of Blender and glTF"),
        form("ConcatTransform", MATRIX, "multiplies the CTM by a matrix, column by column; before Camera, the CTM maps the world to the camera"),
        form("CoordinateSystem", "\"name\"", "names the CTM"),
        form("CoordSysTransform", "\"name\"", "makes a named transformation the CTM"),
        form("ActiveTransform", "All, StartTime or EndTime", "selects the times whose CTM the next transformations change"),
        form("TransformTimes", "start end", "sets the times of the two CTMs of a moving scene"),
        form("TransformBegin", "", "saves the CTM until TransformEnd"),
        form("TransformEnd", "", "restores the CTM of TransformBegin"),
        form("AttributeBegin", "", "saves the CTM, material, area light, media and orientation until AttributeEnd"),
        form("AttributeEnd", "", "restores what AttributeBegin saved"),
        form("ObjectBegin", "\"name\"", "starts the definition of an object: the shapes until ObjectEnd"),
        form("ObjectEnd", "", "ends the definition of an object"),
        form("ObjectInstance", "\"name\"", "places a copy of an object"),
        form("ReverseOrientation", "", "flips the normals of the shapes that follow"),
        form("WorldBegin", "", "ends the options, resets the CTM and begins the lights and shapes"),
        form("WorldEnd", "", "ends the lights and shapes"),
        form("NamedMaterial", "\"name\"", "gives a material of MakeNamedMaterial to the shapes that follow"),
        form("MediumInterface", "\"inside\" \"outside\"", "names the media on the sides of the shapes that follow; \"\" is empty space"),
        form("Texture", "\"name\" \"float or spectrum\" \"type\" parameters", "defines a texture, which parameters of materials name"),
        form("Include", "\"file\"", "reads another file at this place"),
        form("Camera", TYPE, "the camera, which stands at the inverse of the CTM"),
        form("Film", TYPE, "the size and the file of the picture"),
        form("PixelFilter", TYPE, "the filter that turns samples into pixels"),
        form("Sampler", TYPE, "the sample points, and their number in each pixel"),
        form("Integrator", TYPE, "the light transport algorithm"),
        form("Accelerator", TYPE, "the structure that finds the shapes on a ray"),
        form("Shape", TYPE, "adds a shape with the current transformation and material"),
        form("Material", TYPE, "sets the material of the shapes that follow"),
        form("MakeNamedMaterial", "\"name\" parameters", "defines a material for NamedMaterial and for mix"),
        form("LightSource", TYPE, "adds a light without a shape"),
        form("AreaLightSource", TYPE, "makes the shapes that follow emit light"),
        form("MakeNamedMedium", "\"name\" parameters", "defines a medium for MediumInterface"),
    ];

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
