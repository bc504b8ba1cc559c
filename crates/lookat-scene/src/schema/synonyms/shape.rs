//! Words for `Shape`.

use super::{EMIT, Table};

const SURFACE: &str =
    "to set the surface, write Material before the Shape, as in Material \"matte\" \"rgb Kd\" [.5 .5 .5]";

#[rustfmt::skip]
pub(super) const TABLE: Table = Table {
    directive: "Shape",
    types: &[
        (&["mesh", "triangles", "triangle", "polymesh", "polygonmesh", "indexedfaceset"], "trianglemesh", ""),
        (&["ply", "meshfile"], "plymesh", ""),
        (&["obj", "wavefront", "serialized", "stl", "gltf", "fbx"], "plymesh", "\"plymesh\" reads only PLY: convert the mesh to PLY"),
        (&["rectangle", "quad", "square", "plane", "bilinearmesh"], "", "pbrt-v3 has no such shape: write it as Shape \"trianglemesh\" \"point P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] \"integer indices\" [0 1 2 0 2 3]"),
        (&["cube", "box"], "", "pbrt-v3 has no such shape: write it as a \"trianglemesh\" of 8 points and 12 triangles"),
        (&["torus"], "", "pbrt-v3 has no such shape: convert it to PLY for Shape \"plymesh\""),
        (&["ball", "globe", "uvsphere", "icosphere"], "sphere", ""),
        (&["circle", "disc"], "disk", ""),
        (&["tube", "rod"], "cylinder", ""),
        (&["hair", "curves", "bsplinecurve", "linearcurve", "bezier", "strand"], "curve", ""),
        (&["subdiv", "subdivision", "catmullclark"], "loopsubdiv", "\"loopsubdiv\" takes triangles"),
        (&["terrain", "height", "displacementmap"], "heightfield", ""),
        (&["instance", "shapegroup"], "", "ObjectBegin and ObjectEnd define an object, ObjectInstance places a copy"),
    ],
    parameters: &[
        (&["sphere", "disk", "cylinder", "cone", "paraboloid"], &["r", "rad", "size"], "radius", ""),
        (&["sphere", "disk", "cylinder", "cone", "paraboloid"], &["diameter"], "radius", "radius is half the diameter"),
        (&["sphere", "disk", "cylinder", "cone", "paraboloid", "hyperboloid"], &["center", "position", "origin", "location", "pos"], "", "the shape is at the origin: to move it, write Translate before the Shape"),
        (&["cylinder", "paraboloid"], &["height", "length", "p0", "p1"], "", "\"float zmin\" and \"float zmax\" are its ends along z"),
        (&["curve"], &["radius", "thickness", "widths", "r"], "width", "width is twice the radius"),
        (&["trianglemesh", "plymesh", "loopsubdiv", "nurbs", "heightfield", "hyperboloid"], &["radius", "size", "scale"], "", "to change its size, write Scale before the Shape"),
        (&["trianglemesh", "loopsubdiv", "curve", "nurbs"], &["vertices", "points", "positions", "vertex", "controlpoints", "pos"], "P", ""),
        (&["trianglemesh", "loopsubdiv"], &["faces", "triangles", "index", "tris", "vertexindices", "faceindex"], "indices", ""),
        (&["trianglemesh", "curve"], &["normals", "vertexnormals", "normal"], "N", ""),
        (&["trianglemesh"], &["tangents", "tangent"], "S", ""),
        (&["trianglemesh"], &["texcoords", "uvs", "texturecoordinates", "texcoord"], "uv", ""),
        (&["trianglemesh"], &["file", "filename"], "", "Shape \"plymesh\" reads a mesh from a file"),
        (&["plymesh"], &["file", "mesh", "path", "name"], "filename", ""),
        (&["heightfield"], &["heights", "z"], "Pz", ""),
        (&[], &["toworld", "transform", "matrix", "rotation", "translate", "flipnormals"], "", "to place the shape, write Translate, Rotate, Scale or Transform before the Shape; ReverseOrientation flips its normals"),
        (&[], &["emission", "emit", "radiance", "emitter", "l", "intensity", "power", "strength", "light"], "", EMIT),
        (&[], &["material", "bsdf", "shader", "color", "albedo", "diffuse", "basecolor", "roughness", "kd"], "", SURFACE),
    ],
};
