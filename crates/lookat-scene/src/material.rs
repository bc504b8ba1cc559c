//! `Material`: the scattering of surfaces.

mod disney;
mod fourier;
mod hair;
mod models;
mod subsurface;

use std::rc::Rc;
use std::sync::Arc;

use glam::Vec3;
use lookat_syntax::{Entity, Param, ParamType, Span, Text, Values};

use crate::material::models::bump;
use crate::names::Names;
use crate::params::value::Name;
use crate::params::{ParamValue, Params, class};
use crate::schema::{Key, Keys, Kind};
use crate::symbols::SymbolId;
use crate::texture::{AnyTexture, Texture};

pub use crate::material::disney::{Disney, ThinDisney};
pub(crate) use crate::material::fourier::Tables;
pub use crate::material::fourier::{FourierTable, Series};
pub use crate::material::hair::{Hair, HairColor};
pub use crate::material::models::{
    Glass, Matte, Metal, Mirror, Mix, Plastic, Roughness, Substrate, Translucent, Uber,
};
pub use crate::material::subsurface::{Interior, Subsurface};

/// A material.
#[derive(Debug, Clone)]
pub struct Material {
    pub(crate) kind: MaterialKind,
    pub(crate) bump: Option<Texture<f64>>,
    /// The type that its directive names. `None` for a material made in code.
    pub span: Option<Span>,
    /// The name that `MakeNamedMaterial` gives it.
    pub name: Option<String>,
    needs: Needs,
    /// The number of materials in it, counting the parts of nested mixes.
    parts: u32,
}

/// The scattering of a material. Reflectances are colors or textures; negative values count as 0.
#[derive(Debug, Clone)]
pub enum MaterialKind {
    /// Diffuse.
    Matte(Matte),
    /// A diffuse base under a rough dielectric coating.
    Plastic(Plastic),
    /// Diffuse and glossy reflection and transmission.
    Translucent(Translucent),
    /// A boundary between dielectrics.
    Glass(Glass),
    /// A perfect mirror.
    Mirror(Mirror),
    /// A rough conductor.
    Metal(Box<Metal>),
    /// A diffuse base under a glossy coating with Fresnel reflection.
    Substrate(Substrate),
    /// Diffuse, glossy and specular lobes in one material.
    Uber(Box<Uber>),
    /// The material of Disney's animation studio.
    Disney(Box<Disney>),
    /// A boundary around a medium in which light scatters.
    Subsurface(Box<Subsurface>),
    /// Hair and fur.
    Hair(Box<Hair>),
    /// Measured or simulated scattering, in a table.
    Fourier(Arc<FourierTable>),
    /// A blend of two materials.
    Mix(Mix),
    /// No surface: light passes through and shadow rays are blocked, as in pbrt-v3 (`"none"` and `""`).
    None,
}

impl Material {
    /// The material of shapes before any `Material` directive.
    pub const DEFAULT: Material = Material {
        kind: MaterialKind::Matte(Matte {
            kd: Texture::Constant(Vec3::splat(0.5)),
            sigma: Texture::Constant(0.0),
        }),
        bump: None,
        span: None,
        name: None,
        needs: Needs::NOTHING,
        parts: 1,
    };

    /// A material with this scattering, and a bump map if there is one: a displacement in world units that changes the shading
    /// normal.
    pub fn new(kind: MaterialKind, bump: Option<Texture<f64>>) -> Self {
        let needs = Needs::of(&kind, bump.as_ref());
        let parts = match &kind {
            MaterialKind::Mix(mix) => mix.parts(),
            _ => 1,
        };
        Material { kind, bump, span: None, name: None, needs, parts }
    }

    /// Its scattering.
    #[inline]
    pub fn kind(&self) -> &MaterialKind {
        &self.kind
    }

    /// The bump map (`bumpmap`).
    #[inline]
    pub fn bump(&self) -> Option<&Texture<f64>> {
        self.bump.as_ref()
    }

    /// This material, and all parts of a mix.
    pub(crate) fn all(&self) -> Vec<&Material> {
        let mut all = vec![self];
        let mut next = 0;
        while let Some(material) = all.get(next) {
            if let MaterialKind::Mix(mix) = &material.kind {
                all.extend(mix.materials.iter().map(|part| &**part));
            }
            next += 1;
        }
        all
    }

    /// The part with a medium inside, in which light scatters and leaves at other points: the material or the first such part of a mix.
    pub fn inside(&self) -> Option<&MaterialKind> {
        match &self.kind {
            MaterialKind::Subsurface(_) => Some(&self.kind),
            MaterialKind::Disney(disney) => disney.scatters_inside().then_some(&self.kind),
            MaterialKind::Mix(mix) => mix.materials.iter().find_map(|part| part.inside()),
            _ => None,
        }
    }

    /// The textures and constants of this material and of all its parts.
    pub(crate) fn textures(&self) -> impl Iterator<Item = AnyTexture<'_>> {
        self.all()
            .into_iter()
            .flat_map(|part| part.kind.textures().chain(part.bump.as_ref().map(AnyTexture::Numbers)))
    }

    /// The surface data that it needs.
    #[inline]
    pub fn needs(&self) -> Needs {
        self.needs
    }
}

pub(crate) const TYPE: Key<Name> = Key::string("type", "the type of the material").required();

/// The type of a named material, which is a parameter.
pub(crate) fn named_type(params: &mut Params) -> Option<Text> {
    let kind = Name::take(&TYPE, params);
    let message = format!("named material \"{}\" has no type", params.kind());
    params.missing(TYPE.name, &message, "add \"string type\" \"matte\"");
    kind
}

const BUMP_KEYS: Keys = &[&models::BUMP];

pub(crate) const KINDS: &[Kind] = &[
    Kind::new("matte", "a diffuse surface", &[models::MATTE_KEYS, BUMP_KEYS]).by_default(),
    Kind::new("plastic", "a diffuse base under a glossy coating", &[models::PLASTIC_KEYS, BUMP_KEYS]),
    Kind::new(
        "translucent",
        "a thin surface that reflects and transmits",
        &[models::TRANSLUCENT_KEYS, BUMP_KEYS],
    ),
    Kind::new("glass", "smooth or rough glass", &[models::GLASS_KEYS, BUMP_KEYS]),
    Kind::new("mirror", "a perfect mirror", &[models::MIRROR_KEYS, BUMP_KEYS]),
    Kind::new("hair", "hair and fur", &[hair::KEYS]),
    Kind::new("disney", "the material of Disney's animation studio", &[disney::KEYS, BUMP_KEYS]),
    Kind::new("mix", "a blend of two named materials", &[models::MIX_KEYS]),
    Kind::new("metal", "a rough metal", &[models::METAL_KEYS, BUMP_KEYS]),
    Kind::new(
        "substrate",
        "a diffuse base under a coating that reflects more at grazing angles",
        &[models::SUBSTRATE_KEYS, BUMP_KEYS],
    ),
    Kind::new(
        "uber",
        "diffuse, glossy and specular reflection, refraction and opacity in one",
        &[models::UBER_KEYS, BUMP_KEYS],
    ),
    Kind::new(
        "subsurface",
        "subsurface scattering from coefficients",
        &[subsurface::COEFFICIENTS, subsurface::SURFACE, BUMP_KEYS],
    ),
    Kind::new(
        "kdsubsurface",
        "subsurface scattering from the diffuse color",
        &[subsurface::COLOR, subsurface::SURFACE, BUMP_KEYS],
    ),
    Kind::new("fourier", "measured or simulated scattering from a file", &[fourier::KEYS, BUMP_KEYS]),
    Kind::new(
        "none",
        "no surface: camera rays and paths pass, shadow rays only with volpath, bdpt and mlt",
        &[],
    ),
    Kind::new("", "the same as none", &[]),
];

/// The named materials.
pub(crate) type Named = Names<Rc<MaterialInstance>>;

/// pbrt-v3's MakeMaterial. An unknown type is an error and gives matte, as in pbrt-v3.
pub(crate) fn material(params: &mut Params, named: &Named, tables: &mut Tables) -> Material {
    let kind = match params.kind() {
        "matte" => MaterialKind::Matte(models::matte(params)),
        "plastic" => MaterialKind::Plastic(models::plastic(params)),
        "translucent" => MaterialKind::Translucent(models::translucent(params)),
        "glass" => MaterialKind::Glass(models::glass(params)),
        "mirror" => MaterialKind::Mirror(models::mirror(params)),
        "metal" => MaterialKind::Metal(Box::new(models::metal(params))),
        "substrate" => MaterialKind::Substrate(models::substrate(params)),
        "uber" => MaterialKind::Uber(Box::new(models::uber(params))),
        "disney" => MaterialKind::Disney(Box::new(disney::disney(params))),
        "subsurface" => MaterialKind::Subsurface(Box::new(subsurface::of_coefficients(params))),
        "kdsubsurface" => MaterialKind::Subsurface(Box::new(subsurface::of_color(params))),
        "mix" => {
            let mix = models::mix(params, named);
            params.finish();
            // pbrt-v3 uses the bump map of the first.
            let bump = mix.materials[0].bump.clone();
            return Material::new(MaterialKind::Mix(mix), bump);
        }
        "fourier" => match fourier::fourier(params, tables) {
            Some(table) => MaterialKind::Fourier(table),
            None => Material::DEFAULT.kind,
        },
        "hair" => {
            // pbrt-v3's hair has no bump map.
            let hair = hair::hair(params);
            params.finish();
            return Material::new(MaterialKind::Hair(Box::new(hair)), None);
        }
        "none" | "" => {
            params.finish();
            return Material::new(MaterialKind::None, None);
        }
        _ => {
            params.reject_unknown_type::<()>(KINDS);
            let kind = MaterialKind::Matte(models::matte(params));
            let bump = bump(params);
            params.ignore_rest();
            return Material::new(kind, bump);
        }
    };
    let bump = bump(params);
    params.finish();
    Material::new(kind, bump)
}

/// A material with its source, because a shape may replace its parameters.
pub(crate) struct MaterialInstance {
    pub material: Arc<Material>,
    /// Its type and parameters as written.
    pub entity: Option<Entity>,
    /// The names and types of its parameters. `None` after an error in its type.
    pub known: Option<Rc<[(&'static str, ParamType)]>>,
    /// For each parameter the definition of the texture or material that it names. Empty if none does.
    pub definitions: Vec<Option<SymbolId>>,
}

impl MaterialInstance {
    /// The parameter of a shape for which pbrt-v3 makes the material of the shape again, with the textures of that place: one that might
    /// be a material's (api.cpp, shapeMaySetMaterialParameters).
    pub fn renewing(params: &[Param]) -> Option<&Param> {
        params.iter().find(|Param { ty, name, values, .. }| {
            let geometry: &[&str] = match ty {
                ParamType::Texture => &["alpha", "shadowalpha"],
                ParamType::Float => &["radius"],
                ParamType::String => &["filename", "type", "scheme"],
                _ => &[],
            };
            // All numbers of a spectrum are one value.
            let is_one = match (ty, &values.value) {
                (ParamType::Texture, _) | (ParamType::Spectrum, Values::Numbers(_)) => true,
                (_, values) => values.len() == 1,
            };
            is_one && !geometry.contains(&name.value.as_str())
        })
    }

    /// True if it takes a parameter of this name and type, so that a shape can replace it.
    pub fn takes(&self, param: &Param) -> bool {
        let is_same =
            |(name, ty): &(&str, ParamType)| *name == param.name.value && class(*ty) == class(param.ty);
        self.known.as_ref().is_none_or(|known| known.iter().any(is_same))
    }
}

/// The material of shapes before any `Material` directive.
impl Default for MaterialInstance {
    fn default() -> Self {
        MaterialInstance {
            material: Arc::new(Material::DEFAULT),
            entity: None,
            definitions: Vec::new(),
            known: Some(Rc::new([
                ("Kd", ParamType::Texture),
                ("Kd", ParamType::Rgb),
                ("sigma", ParamType::Texture),
                ("sigma", ParamType::Float),
                ("bumpmap", ParamType::Texture),
            ])),
        }
    }
}

impl MaterialKind {
    /// The colors of this material, without those of the parts of a mix.
    pub(crate) fn colors(&self) -> Vec<&Texture<Vec3>> {
        match self {
            MaterialKind::Matte(it) => vec![&it.kd],
            MaterialKind::Plastic(it) => vec![&it.kd, &it.ks],
            MaterialKind::Translucent(it) => vec![&it.kd, &it.ks, &it.reflect, &it.transmit],
            MaterialKind::Glass(it) => vec![&it.kr, &it.kt],
            MaterialKind::Mirror(it) => vec![&it.kr],
            MaterialKind::Metal(it) => vec![&it.eta, &it.k],
            MaterialKind::Substrate(it) => vec![&it.kd, &it.ks],
            MaterialKind::Uber(it) => vec![&it.kd, &it.ks, &it.kr, &it.kt, &it.opacity],
            MaterialKind::Disney(it) => vec![&it.color, &it.scatter_distance],
            MaterialKind::Subsurface(it) => {
                let [a, b] = it.interior.colors();
                vec![&it.surface.kr, &it.surface.kt, a, b]
            }
            MaterialKind::Hair(it) => it.color.color().into_iter().collect(),
            MaterialKind::Mix(it) => vec![&it.amount],
            MaterialKind::Fourier(_) | MaterialKind::None => vec![],
        }
    }

    /// The numbers of this material that can be textures.
    fn numbers(&self) -> Vec<&Texture<f64>> {
        match self {
            MaterialKind::Disney(disney) => return disney.numbers(),
            MaterialKind::Hair(hair) => return hair.numbers(),
            _ => {}
        }
        let sigma = if let MaterialKind::Matte(it) = self { Some(&it.sigma) } else { None };
        let widths = self.roughness().into_iter().flat_map(|width| std::iter::once(&width.u).chain(&width.v));
        sigma.into_iter().chain(self.index()).chain(widths).collect()
    }

    /// The textures and constants of this material, without those of the parts of a mix.
    pub(crate) fn textures(&self) -> impl Iterator<Item = AnyTexture<'_>> {
        let colors = self.colors().into_iter().map(AnyTexture::Colors);
        colors.chain(self.numbers().into_iter().map(AnyTexture::Numbers))
    }

    /// True if it scatters no light. Textures that vary count as light.
    pub fn is_black(&self) -> bool {
        let are_black = |all: &[&Texture<Vec3>]| all.iter().all(|color| color.constant() == Some(Vec3::ZERO));
        match self {
            MaterialKind::Translucent(it) => {
                are_black(&[&it.kd, &it.ks]) || are_black(&[&it.reflect, &it.transmit])
            }
            MaterialKind::Uber(it) => {
                it.opacity.constant() == Some(Vec3::ONE) && are_black(&[&it.kd, &it.ks, &it.kr, &it.kt])
            }
            MaterialKind::Subsurface(it) => are_black(&[&it.surface.kr, &it.surface.kt]),
            MaterialKind::Mix(it) => it.materials.iter().all(|part| part.kind.is_black()),
            MaterialKind::Metal(_)
            | MaterialKind::Disney(_)
            | MaterialKind::Hair(_)
            | MaterialKind::Fourier(_)
            | MaterialKind::None => false,
            _ => are_black(&self.colors()),
        }
    }

    /// The index of refraction, if the material has one.
    pub(crate) fn index(&self) -> Option<&Texture<f64>> {
        match self {
            MaterialKind::Glass(glass) => Some(&glass.eta),
            MaterialKind::Uber(uber) => Some(&uber.eta),
            MaterialKind::Disney(disney) => Some(&disney.eta),
            MaterialKind::Subsurface(subsurface) => Some(&subsurface.surface.eta),
            MaterialKind::Hair(hair) => Some(&hair.eta),
            _ => None,
        }
    }

    /// The table, if the material has one.
    pub(crate) fn table(&self) -> Option<&Arc<FourierTable>> {
        if let MaterialKind::Fourier(table) = self { Some(table) } else { None }
    }

    /// The roughness, if the material has one.
    pub(super) fn roughness(&self) -> Option<&Roughness> {
        match self {
            MaterialKind::Plastic(plastic) => Some(&plastic.roughness),
            MaterialKind::Translucent(translucent) => Some(&translucent.roughness),
            MaterialKind::Glass(glass) => Some(&glass.roughness),
            MaterialKind::Metal(metal) => Some(&metal.roughness),
            MaterialKind::Substrate(substrate) => Some(&substrate.roughness),
            MaterialKind::Uber(uber) => Some(&uber.roughness),
            MaterialKind::Subsurface(subsurface) => Some(&subsurface.surface.roughness),
            _ => None,
        }
    }

    /// The type name in scene files.
    pub fn name(&self) -> &'static str {
        match self {
            MaterialKind::Matte(_) => "matte",
            MaterialKind::Plastic(_) => "plastic",
            MaterialKind::Translucent(_) => "translucent",
            MaterialKind::Glass(_) => "glass",
            MaterialKind::Mirror(_) => "mirror",
            MaterialKind::Metal(_) => "metal",
            MaterialKind::Substrate(_) => "substrate",
            MaterialKind::Uber(_) => "uber",
            MaterialKind::Disney(_) => "disney",
            MaterialKind::Subsurface(subsurface) => match subsurface.interior {
                Interior::Coefficients(_) => "subsurface",
                Interior::Color(_) => "kdsubsurface",
            },
            MaterialKind::Hair(_) => "hair",
            MaterialKind::Fourier(_) => "fourier",
            MaterialKind::Mix(_) => "mix",
            MaterialKind::None => "none",
        }
    }
}

/// The data needed to shade a point, besides its normals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Needs {
    /// Texture coordinates and their derivatives, for textures, bump maps and anisotropic lobes.
    pub coordinates: bool,
    /// The texture footprint (ray differentials), for filtered textures.
    pub footprint: bool,
}

impl Needs {
    /// A surface without textures needs nothing.
    pub const NOTHING: Needs = Needs { coordinates: false, footprint: false };

    pub(super) fn of(kind: &MaterialKind, bump: Option<&Texture<f64>>) -> Self {
        let mut needs = Needs { coordinates: bump.is_some(), footprint: bump.is_some() };
        for texture in kind.textures().map(AnyTexture::properties) {
            needs.coordinates |= texture.cost > 0;
            needs.footprint |= texture.filtered;
        }
        if let Some(Roughness { u, v: Some(v), .. }) = kind.roughness() {
            needs.coordinates |= u.constant() != v.constant();
        }
        if let MaterialKind::Disney(disney) = kind {
            needs.coordinates |= disney.anisotropic.constant() != Some(0.0);
        }
        // The place across a hair, and the direction along it.
        needs.coordinates |= matches!(kind, MaterialKind::Hair(_));
        if let MaterialKind::Mix(mix) = kind {
            for Material { needs: part, .. } in mix.materials.iter().map(|part| &**part) {
                needs.coordinates |= part.coordinates;
                needs.footprint |= part.footprint;
            }
        }
        needs
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::Vec3;

    use crate::{LoadOptions, MaterialKind, Texture, load};

    /// The Kd of each shape: of the last definition where pbrt-v3 makes the material again.
    #[test]
    fn shapes_make_their_material_again_as_in_pbrt() {
        let kd = |shape: &str, end: &str| {
            let text = format!(
                "Camera \"perspective\" Film \"image\" WorldBegin LightSource \"infinite\"
                 Texture \"f\" \"float\" \"constant\" Texture \"t\" \"color\" \"constant\" \"rgb value\" [1 0 0]
                 MakeNamedMaterial \"m\" \"string type\" \"matte\" \"texture Kd\" \"t\" \"float sigma\" 0
                 NamedMaterial \"m\" AttributeBegin Texture \"t\" \"float\" \"constant\"
                 Texture \"t\" \"color\" \"constant\" \"rgb value\" [0 1 0] {end} Shape {shape} WorldEnd"
            );
            let loaded = load(Path::new("a.pbrt"), &|_| Ok(text.clone().into()), &LoadOptions::default());
            let scene = loaded.scene.unwrap_or_else(|| panic!("{:?} {shape}", loaded.diagnostics));
            let material = &scene.world.primitives[0].material;
            assert_eq!(material.name.as_deref(), if shape.contains("sigma") { None } else { Some("m") });
            match material.kind() {
                MaterialKind::Matte(matte) => match matte.kd {
                    Texture::Constant(color) => color,
                    Texture::Varying(_) => panic!("{shape}"),
                },
                _ => panic!("{shape}"),
            }
        };
        let mesh = "\"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [0 0 0 1 0 0 0 1 0]";
        let [first, last] = [Vec3::X, Vec3::Y];
        for (shape, expected) in [
            ("\"sphere\"", first),
            ("\"sphere\" \"float radius\" 2", first),
            ("\"sphere\" \"float radius\" 2 \"float zmin\" -.5", last),
            ("\"sphere\" \"float phimax\" [360]", last),
            ("\"sphere\" \"float sigma\" 10", last),
            ("\"cylinder\" \"float radius\" 2", first),
            ("\"hyperboloid\" \"point p1\" [1 0 0]", last),
            ("\"curve\" \"string type\" \"flat\" \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]", first),
            ("\"curve\" \"float width\" 1 \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]", last),
            (mesh, first),
            (&format!("{mesh} \"texture alpha\" \"f\""), first),
            (&format!("{mesh} \"float alpha\" 1"), last),
            (&format!("{mesh} \"float uv\" [0 0 1 0 1 1]"), first),
        ] {
            assert_eq!(kd(shape, ""), expected, "{shape}");
            assert_eq!(kd(shape, "AttributeEnd"), first, "{shape}");
        }
    }
}
