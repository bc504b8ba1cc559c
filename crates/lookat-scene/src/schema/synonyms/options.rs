//! Words for the directives before `WorldBegin`.

use super::{OLDER, PLACE, SAMPLES, Table};

const LOOKAT: &str =
    "write LookAt before Camera, with the eye, the point to look at and the up vector, three numbers each";
const RESOLUTION: &str =
    "Film \"image\" sets the size, with \"integer xresolution\" and \"integer yresolution\"";
const APERTURE: &str = "lensradius is half the diameter of the aperture";

#[rustfmt::skip]
pub(super) const CAMERA: Table = Table {
    directive: "Camera",
    types: &[
        (&["thinlens", "pinhole", "persp", "perspectivepinhole"], "perspective", ""),
        (&["ortho", "parallel"], "orthographic", ""),
        (&["spherical", "panorama", "panoramic", "equirectangular", "latlong"], "environment", ""),
    ],
    parameters: &[
        (&["perspective", "orthographic", "environment"], &["aperture", "aperturediameter", "aperturesize", "aperturewidth", "lensdiameter"], "lensradius", APERTURE),
        (&[], &["aperture", "apertureradius", "radius", "lens", "defocusradius", "dof", "depthoffield", "bokeh", "blur", "defocus"], "lensradius", "focaldistance sets the distance that is sharp"),
        (&[], &["fstop", "fnumber", "aperturefstop"], "", "lensradius is the focal length divided by twice the f-stop, in the units of the scene"),
        (&[], &["focus", "focusdistance", "focaldist", "focallengthdistance", "focalplane", "distance"], "focaldistance", ""),
        (&[], &["focallength", "lenslength"], "", "\"float fov\" is the angle of the shorter side in degrees: 2 atan(s / 2f), with the shorter side s of the film and the focal length f"),
        (&["perspective"], &["zoom", "wideangle", "telephoto"], "", "\"float fov\" is the angle of view: a smaller angle shows less of the scene, and larger"),
        (&[], &["shutter", "shutterspeed", "exposuretime"], "", "\"float shutteropen\" and \"float shutterclose\" are the times of the shutter; \"float scale\" of Film sets the exposure"),
        (&[], &["angle", "fieldofview", "viewangle", "yfov", "xfov"], "fov", "fov is the angle of the shorter side, in degrees"),
        (&[], &["fovaxis"], "", "fov is always the angle of the shorter side: remove fov_axis"),
        (&[], &["eye", "origin", "position", "from", "location", "pos", "up", "lookat", "look", "target", "to", "direction", "sky"], "", LOOKAT),
        (&[], &["toworld", "transform", "matrix", "rotation", "translate"], "", PLACE),
        (&[], &["resolution", "width", "height", "xresolution", "yresolution", "size"], "", RESOLUTION),
        (&[], &["samples", "spp", "pixelsamples", "samplecount"], "", SAMPLES),
        (&[], &["near", "nearclip", "nearplane", "far", "farclip", "farplane", "clipstart", "clipend", "hither", "yon"], "", "pbrt-v3 has no clip planes: remove it"),
        (&[], &["aspect", "aspectratio"], "frameaspectratio", ""),
        (&[], &["orthowidth", "orthographicscale", "orthoscale", "scale"], "", "\"float screenwindow\" [xmin xmax ymin ymax] is the part that is seen"),
    ],
};

#[rustfmt::skip]
pub(super) const FILM: Table = Table {
    directive: "Film",
    types: &[
        (&["rgb", "hdrfilm", "ldrfilm", "exr", "png", "file"], "image", ""),
    ],
    parameters: &[
        (&[], &["width", "xres", "imagewidth", "resolutionx"], "xresolution", ""),
        (&[], &["height", "yres", "imageheight", "resolutiony"], "yresolution", ""),
        (&[], &["resolution", "size", "res"], "", "write \"integer xresolution\" and \"integer yresolution\""),
        (&[], &["output", "file", "outputfile", "image", "name"], "filename", ""),
        (&[], &["crop", "croprect", "cropbounds", "region"], "cropwindow", "cropwindow is xmin xmax ymin ymax, from 0 to 1"),
        (&[], &["exposure", "iso", "gain", "sensor", "imagingratio"], "", "\"float scale\" multiplies the picture: write 2 to the power of the exposure in stops"),
        (&[], &["gamma", "tonemap", "colorspace"], "", "exr and pfm pictures are linear, png and tga pictures sRGB: remove it"),
        (&[], &["filter", "rfilter"], "", "PixelFilter sets the filter"),
        (&[], &["premultiplyalpha", "writefrequency", "display"], "", "an option of an older pbrt: remove it"),
        (&[], &["samples", "spp", "pixelsamples"], "", SAMPLES),
        (&[], &["maxluminance", "clamp", "maxcomponentvalue"], "maxsampleluminance", "maxsampleluminance is the largest luminance of a sample"),
    ],
};

#[rustfmt::skip]
pub(super) const PIXEL_FILTER: Table = Table {
    directive: "PixelFilter",
    types: &[
        (&["tent", "bartlett"], "triangle", ""),
        (&["lanczos", "windowedsinc"], "sinc", ""),
        (&["gauss"], "gaussian", ""),
        (&["catmullrom"], "mitchell", "Catmull-Rom is \"mitchell\" with \"float B\" 0 and \"float C\" 0.5"),
        (&["blackmanharris"], "gaussian", ""),
    ],
    parameters: &[
        (&[], &["radius", "size", "support"], "", "\"float xwidth\" and \"float ywidth\" are the radius along each axis, in pixels"),
        (&[], &["width"], "", "\"float xwidth\" and \"float ywidth\" are half the width, in pixels"),
        (&[], &["xradius"], "xwidth", ""),
        (&[], &["yradius"], "ywidth", ""),
        (&["gaussian"], &["stddev", "sigma"], "", "\"float alpha\" is 1 / (2 sigma^2)"),
    ],
};

#[rustfmt::skip]
pub(super) const SAMPLER: Table = Table {
    directive: "Sampler",
    types: &[
        (&["independent", "uniform"], "random", ""),
        (&["ldsampler", "hammersley"], "halton", ""),
        (&["bestcandidate", "adaptive"], "halton", OLDER),
        (&["zsobol", "paddedsobol", "pmj02bn", "pmj", "bluenoise", "orthogonal"], "sobol", ""),
        (&["multijitter", "jittered", "grid"], "stratified", ""),
    ],
    parameters: &[
        (&["stratified"], &["samples", "spp", "pixelsamples", "samplecount", "samplesperpixel", "count", "nsamples"], "", "\"integer xsamples\" times \"integer ysamples\" is the number of samples of each pixel"),
        (&[], &["samples", "spp", "samplecount", "samplesperpixel", "count", "nsamples", "aasamples"], "pixelsamples", ""),
        (&["random"], &["xsamples", "ysamples"], "", "\"integer pixelsamples\" is the product of xsamples and ysamples"),
        (&[], &["minsamples", "maxsamples"], "pixelsamples", ""),
        (&[], &["seed"], "", "the option --seed of lookat sets the seed"),
    ],
};

#[rustfmt::skip]
pub(super) const INTEGRATOR: Table = Table {
    directive: "Integrator",
    types: &[
        (&["pathtracer", "pathtracing", "simplepath", "gi"], "path", ""),
        (&["irradiancecache", "igi", "glossyprt", "diffuseprt", "useprobes", "dipolesubsurface"], "path", OLDER),
        (&["direct"], "directlighting", ""),
        (&["ao", "ambient", "occlusion"], "ambientocclusion", ""),
        (&["volpathmis", "volpathsimple", "simplevolpath", "volumetricpath"], "volpath", ""),
        (&["bidirectional", "ptracer"], "bdpt", ""),
        (&["pssmlt", "metropolis"], "mlt", ""),
        (&["photonmapper", "ppm"], "sppm", ""),
        (&["photonmap", "exphotonmap"], "sppm", OLDER),
    ],
    parameters: &[
        (&[], &["depth", "bounces", "maxbounces", "raydepth", "recursion", "maxraydepth"], "maxdepth", ""),
        (&[], &["samples", "spp", "pixelsamples", "samplecount"], "", SAMPLES),
        (&["sppm"], &["maxdist"], "radius", "radius is the first search radius of photons, in the units of the scene"),
        (&[], &["maxspeculardepth"], "maxdepth", ""),
        (&[], &["rrdepth", "russianroulettedepth"], "", "roulette starts at the fifth surface; \"float rrthreshold\" 0 turns it off"),
        (&[], &["lightsampler"], "lightsamplestrategy", "lightsamplestrategy is \"uniform\", \"power\" or \"spatial\""),
    ],
};

#[rustfmt::skip]
pub(super) const ACCELERATOR: Table = Table {
    directive: "Accelerator",
    types: &[
        (&["octree", "embree", "sah"], "bvh", ""),
        (&["grid"], "bvh", OLDER),
    ],
    parameters: &[
        (&[], &["refineimmediately"], "", "an option of an older pbrt: remove it"),
    ],
};
