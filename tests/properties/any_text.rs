//! What holds for every file: directives read back as they print, and whatever stands in a scene file, the reader and
//! the renderer neither panic nor break their promises.

use std::collections::BTreeMap;
use std::io::{Error, ErrorKind};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use glam::Vec3;
use lookat_scene::syntax::{
    ActiveTransform, Directive, Entity, EntityKind, FileId, Param, ParamType, Severity, Span, Spanned, Text,
    Values,
};
use lookat_scene::{
    FilmOverride, HairColor, Integrator, Light, LoadOptions, Loaded, Material, MaterialKind, Scene, Texture,
};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use proptest::sample::{Index, select};

use crate::promises;

/// The scenes of the repository and what they include, by their path from `pbrt-scenes`.
static FILES: LazyLock<BTreeMap<PathBuf, Vec<u8>>> = LazyLock::new(|| {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pbrt-scenes");
    let (mut files, mut folders) = (BTreeMap::new(), vec![root.clone()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.insert(path.strip_prefix(&root).unwrap().to_owned(), std::fs::read(&path).unwrap());
            }
        }
    }
    files
});

fn is_scene(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "pbrt")
}

/// `PROPTEST_CASES` asks for another number of cases. Failures become tests below, not files.
fn config(cases: u32) -> ProptestConfig {
    let asked = std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok());
    ProptestConfig { cases: asked.unwrap_or(cases), failure_persistence: None, ..ProptestConfig::default() }
}

// Print and read

fn spanned<T>(value: T) -> Spanned<T> {
    Spanned { value, span: Span { file: FileId(0), start: 0, end: 0 } }
}

fn string() -> impl Strategy<Value = String> {
    let odd =
        select(vec!['"', '\\', '\'', '\n', '\r', '\t', '\u{8}', '\u{c}', '\0', '#', '[', 'é', '\u{feff}']);
    vec(prop_oneof![any::<char>(), proptest::char::range(' ', '~'), odd], 0..8).prop_map(String::from_iter)
}

fn text() -> impl Strategy<Value = Text> {
    string().prop_map(spanned)
}

fn number() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    let extreme =
        select(vec![f64::MAX, f64::MIN, f64::MIN_POSITIVE, 5e-324, 1e16, 1e15, 9007199254740993.0, 0.1]);
    prop_oneof![POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO, (-9..9).prop_map(f64::from), extreme]
}

fn numbers<const N: usize>() -> impl Strategy<Value = [f64; N]> {
    vec(number(), N).prop_map(|numbers| numbers.try_into().unwrap())
}

fn values(ty: ParamType) -> BoxedStrategy<Values> {
    let strings = || vec(text(), 0..4).prop_map(Values::Strings);
    match ty {
        ParamType::Integer => vec(any::<i32>(), 0..5).prop_map(Values::Integers).boxed(),
        ParamType::Bool => vec(any::<bool>(), 0..4).prop_map(Values::Bools).boxed(),
        ParamType::String | ParamType::Texture => strings().boxed(),
        // An empty list of either kind is the same text.
        ParamType::Spectrum => {
            let names = vec(text(), 1..4).prop_map(Values::Strings);
            prop_oneof![vec(number(), 0..6).prop_map(Values::Numbers), names].boxed()
        }
        _ if ty.arity() == 2 => vec(numbers::<2>(), 0..4).prop_map(Values::Pairs).boxed(),
        _ if ty.arity() == 3 => vec(numbers::<3>(), 0..4).prop_map(Values::Triples).boxed(),
        _ => vec(number(), 0..5).prop_map(Values::Numbers).boxed(),
    }
}

fn param() -> impl Strategy<Value = Param> {
    // The declaration is split at blanks.
    let name = string().prop_map(|name| "n".to_owned() + &name.replace([' ', '\t'], "_"));
    let ty = select(ParamType::SPELLINGS.map(|(_, ty)| ty).to_vec());
    (ty, name).prop_flat_map(|(ty, name)| {
        let name = spanned(name);
        values(ty).prop_map(move |values| Param {
            ty,
            name: name.clone(),
            values: spanned(values),
            is_read: true,
        })
    })
}

fn entity() -> impl Strategy<Value = Entity> {
    (text(), vec(param(), 0..4)).prop_map(|(name, params)| Entity { name, params })
}

fn directive() -> impl Strategy<Value = Directive> {
    let which = select(vec![ActiveTransform::All, ActiveTransform::StartTime, ActiveTransform::EndTime]);
    let bare = vec![
        Directive::Identity,
        Directive::TransformBegin,
        Directive::TransformEnd,
        Directive::AttributeBegin,
        Directive::AttributeEnd,
        Directive::ObjectEnd,
        Directive::ReverseOrientation,
        Directive::WorldBegin,
        Directive::WorldEnd,
    ];
    prop_oneof![
        select(bare),
        which.prop_map(Directive::ActiveTransform),
        numbers().prop_map(Directive::Translate),
        numbers().prop_map(Directive::Scale),
        numbers().prop_map(Directive::Rotate),
        numbers().prop_map(Directive::LookAt),
        numbers().prop_map(Directive::Transform),
        numbers().prop_map(Directive::ConcatTransform),
        numbers().prop_map(Directive::TransformTimes),
        text().prop_map(Directive::CoordinateSystem),
        text().prop_map(Directive::CoordSysTransform),
        text().prop_map(Directive::ObjectBegin),
        text().prop_map(Directive::ObjectInstance),
        text().prop_map(Directive::NamedMaterial),
        (text(), option::of(text()))
            .prop_map(|(inside, outside)| Directive::MediumInterface { inside, outside }),
        (text(), text(), entity()).prop_map(|(name, value, entity)| Directive::Texture {
            name,
            value,
            entity
        }),
        (select(EntityKind::ALL.to_vec()), entity())
            .prop_map(|(kind, entity)| Directive::Entity(kind, entity)),
        (text(), vec(param(), 0..3)).prop_map(|(file, rest)| Directive::Include { file, rest }),
    ]
}

proptest! {
    #![proptest_config(config(1000))]

    #[test]
    fn directives_read_back_as_they_print(directives in vec(directive(), 0..6)) {
        promises::check_printed(&directives);
    }
}

#[test]
fn the_scenes_read_back_as_they_print() {
    let scenes = FILES.iter().filter(|(path, _)| is_scene(path));
    for (path, text) in scenes {
        assert_eq!(promises::round_trip(text), Some(()), "{}", path.display());
    }
}

// Damaged files

/// A change of a text: what it does, where, and with what.
type Change = (u8, Index, Index);

const NUMBERS: [&str; 18] = [
    "0",
    "-0",
    "-1",
    "1e308",
    "-1e308",
    "1e200",
    "-1e160",
    "1e38",
    "3e38",
    "1e20",
    "1e-20",
    "1e-200",
    "1e-320",
    "2147483647",
    "-2147483648",
    "0.5",
    "180",
    "90",
];

/// Words, numbers and the bytes between them.
fn tokens(text: &[u8]) -> Vec<Vec<u8>> {
    let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-._".contains(byte);
    text.chunk_by(|a, b| is_word(a) && is_word(b)).map(<[u8]>::to_vec).collect()
}

fn is_number(token: &[u8]) -> bool {
    std::str::from_utf8(token).is_ok_and(|text| text.parse::<f64>().is_ok())
}

/// Changes a text. Most changes concern words; replaced numbers leave most scenes whole.
fn damage(text: &[u8], changes: &[Change]) -> Vec<u8> {
    let mut tokens = tokens(text);
    let places = |tokens: &[Vec<u8>], wanted: fn(&[u8]) -> bool| -> Vec<usize> {
        (0..tokens.len()).filter(|at| wanted(&tokens[*at])).collect()
    };
    for (what, at, with) in changes {
        let wanted: fn(&[u8]) -> bool = if *what < 8 { is_number } else { |token| token.len() > 1 };
        let places = places(&tokens, wanted);
        if places.is_empty() {
            break;
        }
        let (at, other) = (places[at.index(places.len())], places[with.index(places.len())]);
        match what {
            0..8 => tokens[at] = with.get(&NUMBERS).as_bytes().to_vec(),
            8 => drop(tokens.remove(at)),
            9 => tokens.insert(at, [&tokens[at][..], b" "].concat()),
            10 => tokens.swap(at, other),
            11 => tokens[at] = tokens[other].clone(),
            12 => tokens.insert(at, with.get(&Directive::KEYWORDS).as_bytes().to_vec()),
            13 => {
                let bit = with.index(8 * tokens[at].len());
                tokens[at][bit / 8] ^= 1 << (bit % 8);
            }
            14 => tokens[at - at.min(1)] = vec![*with.get(b"\"[]#,\\\n\0\xff")],
            _ => tokens.truncate(at),
        }
    }
    tokens.concat()
}

fn load(files: &BTreeMap<PathBuf, Vec<u8>>, scene: &Path, options: &LoadOptions) -> Loaded {
    let read = |path: &Path| files.get(path).cloned().ok_or_else(|| Error::from(ErrorKind::NotFound));
    lookat_scene::load(scene, &read, options)
}

/// Bounds what a scene may ask for and no test can wait for, or no number can hold.
fn tame(scene: &mut Scene) {
    scene.view.sampler = scene.view.sampler.with_samples(2);
    match &mut scene.view.integrator {
        Integrator::DirectLighting { max_depth, .. } | Integrator::Path { max_depth, .. } => {
            *max_depth = (*max_depth).min(8);
        }
        Integrator::AmbientOcclusion { samples, .. } => *samples = (*samples).min(4),
    }
    let world = Arc::make_mut(&mut scene.world);
    for light in &mut world.lights {
        if let Light::Infinite { samples, .. } = light {
            *samples = (*samples).min(4);
        }
    }
    let of_objects = world.instances.iter_mut().flat_map(|i| &mut Arc::make_mut(&mut i.object).primitives);
    for primitive in world.primitives.iter_mut().chain(of_objects) {
        for emission in primitive.emission.iter_mut().map(Arc::make_mut) {
            emission.samples = emission.samples.min(4);
        }
        // Surfaces that give back a billion times the light go beyond any number in a few bounces.
        tame_material(&mut primitive.material);
    }
}

fn tame_material(material: &mut Arc<Material>) {
    let mut kind = material.kind().clone();
    let shares: Vec<&mut Texture<Vec3>> = match &mut kind {
        MaterialKind::Matte(m) => vec![&mut m.kd],
        MaterialKind::Plastic(m) => vec![&mut m.kd, &mut m.ks],
        MaterialKind::Translucent(m) => vec![&mut m.kd, &mut m.ks, &mut m.reflect, &mut m.transmit],
        MaterialKind::Glass(m) => vec![&mut m.kr, &mut m.kt],
        MaterialKind::Mirror(m) => vec![&mut m.kr],
        MaterialKind::Substrate(m) => vec![&mut m.kd, &mut m.ks],
        MaterialKind::Uber(m) => vec![&mut m.kd, &mut m.ks, &mut m.kr, &mut m.kt, &mut m.opacity],
        MaterialKind::Mix(m) => {
            m.materials.iter_mut().for_each(tame_material);
            vec![&mut m.amount]
        }
        MaterialKind::Disney(it) => {
            for strength in [&mut it.sheen, &mut it.clearcoat, &mut it.roughness] {
                *strength = Texture::Constant(strength.constant().unwrap_or(0.5).min(1.0));
            }
            vec![&mut it.color]
        }
        MaterialKind::Hair(it) => match &mut it.color {
            HairColor::Absorption(color) | HairColor::Reflectance(color) => vec![color],
            HairColor::Pigments { .. } => Vec::new(),
        },
        MaterialKind::Subsurface(it) => vec![&mut it.surface.kr, &mut it.surface.kt],
        MaterialKind::Metal(_) | MaterialKind::Fourier(_) | MaterialKind::None => Vec::new(),
    };
    for share in shares {
        let color = share.constant().unwrap_or(Vec3::splat(0.5));
        *share = Texture::Constant(color.min(Vec3::ONE));
    }
    *material = Arc::new(Material::new(kind, material.bump().cloned()));
}

fn check_render(mut scene: Scene) {
    tame(&mut scene);
    let settings = lookat_render::Settings { threads: 1, ..Default::default() };
    let rendered = lookat_render::render(&scene, &settings, &|_| ControlFlow::Continue(()));
    assert_eq!(rendered.statistics.rejected, 0, "samples that are not finite: {scene:?}");
    let pixels = rendered.image.rgb().unwrap();
    assert!(pixels.as_flattened().iter().all(|value| value.is_finite()), "{pixels:?} {scene:?}");
}

/// What a picture of a few pixels takes.
fn small() -> LoadOptions {
    let film = FilmOverride { resolution: Some([8, 8]), ..FilmOverride::default() };
    LoadOptions { film, ..LoadOptions::default() }
}

proptest! {
    #![proptest_config(config(if cfg!(debug_assertions) { 300 } else { 6000 }))]

    #[test]
    fn damaged_scenes_keep_the_promises(
        scene in any::<Index>(),
        file in any::<Index>(),
        changes in vec((0..16_u8, any::<Index>(), any::<Index>()), 1..5),
    ) {
        let scenes: Vec<&PathBuf> = FILES.keys().filter(|path| is_scene(path) && path.parent() == Some(Path::new(""))).collect();
        let geometry: Vec<&PathBuf> =
            FILES.keys().filter(|path| !scenes.contains(path) && !path.starts_with("gallery")).collect();
        let scene = *scene.get(&scenes);
        // Once in a while what the scene with meshes reads.
        let (scene, file) = match file.index(10) {
            0 => (Path::new("meshes.pbrt"), *file.get(&geometry)),
            _ => (scene.as_path(), scene),
        };
        let mut files = FILES.clone();
        files.insert(file.clone(), damage(&FILES[file], &changes));
        if is_scene(file) {
            promises::round_trip(&files[file]);
        }
        let loaded = load(&files, scene, &small());
        promises::check(&loaded);
        if let Some(scene) = loaded.scene {
            check_render(scene);
        }
        let rest = load(&files, scene, &LoadOptions { keep_going: true, ..small() });
        rest.scene.iter().for_each(promises::check_scene);
    }
}

// Cases that were once wrong

/// Loads a scene with these files beside it; it names them `0`, `1` and so on.
fn load_world(world: &str, others: &[String]) -> Loaded {
    let mut files =
        BTreeMap::from([(PathBuf::from("scene.pbrt"), format!("WorldBegin {world} WorldEnd").into())]);
    let name = |(index, text): (usize, &String)| (PathBuf::from(index.to_string()), text.clone().into());
    files.extend(others.iter().enumerate().map(name));
    let loaded = load(&files, Path::new("scene.pbrt"), &small());
    promises::check(&loaded);
    loaded
}

/// The messages of the errors of a world.
fn errors(world: &str, others: &[String]) -> Vec<String> {
    let diagnostics = load_world(world, others).diagnostics.into_iter();
    diagnostics.filter(|d| d.severity == Severity::Error).map(|d| d.message).collect()
}

/// The number of undefined names of a world.
fn undefined(world: &str) -> usize {
    let diagnostics = load_world(world, &[]).diagnostics;
    diagnostics.iter().filter(|d| d.message.starts_with("there is no ")).count()
}

#[test]
fn numbers_beyond_reason_are_refused() {
    for world in [
        "Scale 1e40 1 1 Scale 1e40 1 1",
        "Scale 1e-40 1 1 Scale 1e-40 1 1",
        "Translate 1e308 0 0",
        "LookAt 1e308 0 0 -1e308 0 0 0 1 0",
        "Transform [1e300 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1]",
        "LightSource \"distant\" \"rgb L\" [1e308 1 1]",
        "LightSource \"point\" \"blackbody I\" [5000 1e300]",
        "LightSource \"distant\" \"point from\" [1e308 0 0]",
        "AreaLightSource \"diffuse\" \"rgb L\" [1e39 0 0]",
        "Shape \"sphere\" \"float radius\" 1e300",
        "Shape \"sphere\" \"float radius\" 1e-320",
        "Scale 1e45 1 1 Shape \"sphere\" \"float radius\" 1e45",
        "Scale 1e45 1 1 Shape \"curve\" \"point P\" [1e45 0 0 1 0 0 2 0 0 3 0 0]",
        "Scale 1e45 1 1 Shape \"curve\" \"float width\" 1e45 \"point P\" [0 0 0 1 0 0 2 0 0 3 0 0]",
        "Shape \"loopsubdiv\" \"integer nlevels\" 20 \"integer indices\" [0 1 2] \"point P\" [0 0 0 1 0 0 0 1 0]",
        "Shape \"heightfield\" \"integer nu\" 2000000000 \"integer nv\" 2000000000 \"float Pz\" [0 0 0 0]",
        "Scale 1e45 1 1 Shape \"trianglemesh\" \"integer indices\" [0 0 0] \"point P\" [1e45 0 0]",
    ] {
        assert_eq!(errors(world, &[]).len(), 1, "{world}");
    }
}

#[test]
fn blocks_are_bounded() {
    let deep = "AttributeBegin ".repeat(100_000) + &"AttributeEnd ".repeat(100_000);
    assert_eq!(errors(&deep, &[]), ["more than 1000 blocks are open"]);
    let few = "AttributeBegin ".repeat(1000) + &"AttributeEnd ".repeat(1000);
    assert!(errors(&few, &[]).is_empty());
}

#[test]
fn includes_are_bounded() {
    let row = |times: usize, length: usize| -> Vec<String> {
        (1..=length).map(|next| format!("Include \"{next}\" ").repeat(times)).chain([String::new()]).collect()
    };
    assert_eq!(errors("Include \"0\"", &row(1, 5000)), ["more than 100 nested includes"]);
    assert!(errors("Include \"0\"", &row(1, 90)).is_empty());
    assert_eq!(errors("Include \"0\"", &row(2, 30)), ["the scene includes more than 10000 files"]);
    // Long files, and those of many directives.
    for (part, times) in [("#".repeat(1 << 24) + "\n", 300), ("Identity ".repeat(100_000), 250)] {
        let again = errors(&"Include \"0\" ".repeat(times), &[part]);
        assert_eq!(again, ["repeated includes add up to more than 4 GiB"]);
    }
}

/// Time and memory once grew with the product of what stands here.
#[test]
fn many_names_are_no_burden() {
    let many = |count: usize, text: &dyn Fn(usize) -> String| (0..count).map(text).collect::<String>();
    let materials = many(20_000, &|i| format!("MakeNamedMaterial \"m{i}\" \"string type\" \"matte\"\n"));
    let blocks = many(20_000, &|i| {
        format!("AttributeBegin MakeNamedMaterial \"b{i}\" \"string type\" \"matte\" AttributeEnd\n")
    });
    assert!(errors(&(materials.clone() + &blocks), &[]).is_empty());
    let unknown = many(20_000, &|i| format!("NamedMaterial \"n{i}\"\n"));
    assert_eq!(undefined(&(materials + &unknown)), 20_000);
    let repeated = "Shape \"sphere\"".to_owned() + &" \"float radius\" 1".repeat(50_000);
    assert!(errors(&repeated, &[]).is_empty());
    let media = many(20_000, &|i| {
        format!("MakeNamedMedium \"m{i}\" \"string type\" \"homogeneous\" MediumInterface \"m{i}\"\n")
    });
    assert!(errors(&media, &[]).is_empty());
}

#[test]
fn a_block_takes_back_its_definitions() {
    let define = "MakeNamedMaterial \"a\" \"string type\" \"matte\" Texture \"t\" \"float\" \"constant\"";
    let use_both = "NamedMaterial \"a\" Material \"matte\" \"texture sigma\" \"t\"";
    assert_eq!(undefined(&format!("{define} AttributeBegin {define} AttributeEnd {use_both}")), 0);
    assert_eq!(undefined(&format!("AttributeBegin {define} {use_both} AttributeEnd {use_both}")), 2);
}
