use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use super::{LoadCache, Stamp};
use crate::{LoadOptions, Loaded, Mesh, Shape, Varying, load_again, load_opened};

/// The contents of a file, and its stamp.
type TestFile = (Vec<u8>, Option<u64>);

/// Files in memory.
#[derive(Default)]
struct Disk {
    files: RefCell<BTreeMap<&'static str, TestFile>>,
    /// How many bytes have been read.
    bytes: Arc<std::sync::atomic::AtomicUsize>,
    changes: Cell<u64>,
}

/// A file that counts what is read of it.
struct Counted(io::Cursor<Vec<u8>>, Arc<std::sync::atomic::AtomicUsize>);

impl Read for Counted {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let count = self.0.read(to)?;
        self.1.fetch_add(count, std::sync::atomic::Ordering::Relaxed);
        Ok(count)
    }
}

impl Disk {
    fn write(&self, name: &'static str, contents: impl Into<Vec<u8>>) {
        self.changes.set(self.changes.get() + 1);
        self.files.borrow_mut().insert(name, (contents.into(), Some(self.changes.get())));
    }

    fn open(&self, path: &Path) -> io::Result<Box<dyn Read>> {
        let files = self.files.borrow();
        let found = path.to_str().and_then(|name| files.get(name)).ok_or(io::ErrorKind::NotFound)?;
        Ok(Box::new(Counted(io::Cursor::new(found.0.clone()), self.bytes.clone())))
    }

    fn load(&self, cache: &mut LoadCache, max_memory: Option<u64>) -> Loaded {
        let open = |path: &Path| self.open(path);
        let stamp = |path: &Path| {
            let number = self.files.borrow().get(path.to_str()?)?.1?;
            Some(Stamp { modified: None, length: 0, number })
        };
        let options = LoadOptions { max_memory, ..LoadOptions::default() };
        self.bytes.store(0, std::sync::atomic::Ordering::Relaxed);
        let again = load_again(Path::new("a.pbrt"), &open, cache, &stamp, &options);
        let read = self.bytes();
        let fresh = load_opened(Path::new("a.pbrt"), &open, &options);
        self.bytes.store(read, std::sync::atomic::Ordering::Relaxed);
        assert_eq!(format!("{:?}", again.diagnostics), format!("{:?}", fresh.diagnostics));
        assert_eq!(format!("{:?}", again.scene), format!("{:?}", fresh.scene));
        assert_eq!(format!("{:?}", again.symbols), format!("{:?}", fresh.symbols));
        assert_eq!(again.inputs, fresh.inputs);
        let texts =
            |loaded: &Loaded| loaded.sources.files.iter().map(|file| file.text.clone()).collect::<Vec<_>>();
        assert!(texts(&again) == texts(&fresh));
        again
    }

    fn bytes(&self) -> usize {
        self.bytes.load(std::sync::atomic::Ordering::Relaxed)
    }
}

/// A strip of triangles with a long list of points. The last triangle has no area.
fn strip(height: f64) -> String {
    let indices: String = (0..40).map(|at| format!("{at} {} {} ", at + 1, at + 2)).collect();
    let points: String =
        (0..43).map(|at| format!("{at}.000001 {}.000001 {height}.000001\n", at % 2)).collect();
    format!("Shape \"trianglemesh\" \"integer indices\" [{indices} 3 3 4] \"point P\" [{points}]\n")
}

fn scene(options: &str, world: &str) -> String {
    format!(
        "{options} Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\"
        WorldBegin LightSource \"infinite\" {world} WorldEnd"
    )
}

fn meshes(loaded: &Loaded) -> Vec<Arc<Mesh>> {
    let mesh = |shape: &Shape| match shape {
        Shape::TriangleMesh(mesh) => Some(mesh.clone()),
        _ => None,
    };
    let world = &loaded.scene.as_ref().unwrap_or_else(|| panic!("{:?}", loaded.diagnostics)).world;
    world.shapes().filter_map(|primitive| mesh(&primitive.shape)).collect()
}

/// For each mesh, whether the load before had it.
fn kept(before: &[Arc<Mesh>], now: &Loaded) -> Vec<bool> {
    meshes(now).iter().map(|mesh| before.iter().any(|before| Arc::ptr_eq(before, mesh))).collect()
}

#[test]
fn long_lists_that_are_the_same_are_not_read_again() {
    let (disk, mut cache) = (Disk::default(), LoadCache::default());
    let [a, b] = [strip(1.0), strip(2.0)];
    let texts = [
        (scene("", &format!("{a} {b}")), [false, false]),
        (scene("LookAt 0 0 -4 0 0 0 0 1 0", &format!("{a} {b}")), [true, true]),
        (
            scene(
                "LookAt 0 0 -4 0 0 0 0 1 0",
                &format!("Material \"mirror\" {a} # more\n {b} Shape \"sphere\""),
            ),
            [true, true],
        ),
        (scene("", &format!("{a} Translate 1 0 0 {b}")), [true, false]),
        (scene("", &format!("{} Translate 1 0 0 {b}", a.replace("7.000001", "7.000002"))), [false, true]),
        (scene("", &format!("{} Translate 1 0 0 {b}", a.replace("3 3 4", "3 5 4"))), [false, true]),
        // Other places of the same lists.
        (scene("", &format!("{b} Identity Scale -1 1 1 {a}")), [false, false]),
        (
            scene("", &format!("{b} Identity Scale -1 1 1 {a} \"rgb Kd\" [1 0 0] \"float alpha\" 0")),
            [true, true],
        ),
        (
            scene(
                "",
                &format!("{b} Scale -1 1 1 {}", a.replace("\"point P\"", "\"point P\" [] \"point P\"")),
            ),
            [true, false],
        ),
        (scene("", &format!("{} {b}", a.replace(" 3 3 4]", " 3 3 4 ] \"bool x\" \"true\""))), [false, true]),
    ];
    let mut before = Vec::new();
    for (text, expected) in texts {
        disk.write("a.pbrt", text.clone());
        let loaded = disk.load(&mut cache, None);
        assert_eq!(kept(&before, &loaded), expected, "{text}");
        before = meshes(&loaded);
    }
    assert_eq!(cache.kept.meshes.len(), 2);
    disk.write("a.pbrt", scene("", "Shape \"sphere\""));
    disk.load(&mut cache, None);
    assert_eq!(cache.kept.meshes.len(), 0);
}

#[test]
fn lists_with_mistakes_are_read_again() {
    let (disk, mut cache) = (Disk::default(), LoadCache::default());
    let a = strip(1.0);
    let mistakes = [
        a.replace("7.000001 1", "7.000001, 1"),
        a.replace("3 3 4]", "3 3 4.5]"),
        a.replace("3 3 4]", "3 3 99]"),
        a.replace("3 3 4]", "3 3]"),
        a.replace("8.000001", "8.00000x"),
        a.replace("\"point P\"", "\"float P\""),
        a.replace("\"point P\"", "\"point p\""),
        a.replace("\"point P\"", "\"string P\""),
        a.replace("trianglemesh", "trianglemsh"),
        a.replace("trianglemesh", "loopsubdiv"),
        a.replace("\"point P\"", "\"float uv\""),
        a.replace("Shape", "Material"),
        format!("{a} \"float uv\" [0 0 1]"),
        format!("{a} \"texture alpha\" \"missing\""),
        format!("{a} \"normal N\" [0 0 1]"),
        format!("Scale 1e40 1 1 Scale 1e20 1 1 {a}"),
    ];
    for text in mistakes.iter().flat_map(|mistake| [mistake, &a, mistake, mistake, &a]) {
        disk.write("a.pbrt", scene("", text));
        disk.load(&mut cache, None);
    }
    // A list that was fine is found in a scene with errors, too.
    let before = meshes(&disk.load(&mut cache, None));
    disk.write("a.pbrt", scene("", "Shape \"sphrere\""));
    disk.load(&mut cache, None);
    disk.write("a.pbrt", scene("Identity", &a));
    assert_eq!(kept(&before, &disk.load(&mut cache, None)), [true]);
}

#[test]
fn files_are_read_again_if_they_have_changed() {
    let ply = |z: u32| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z
element face 3\nproperty list uchar int vertex_indices\nend_header
0 0 {z}\n1 0 {z}\n0 1 {z}\n1 1 {z}\n3 0 1 2\n3 1 1 2\n5 0 1 2 3 0\nrest"
        )
    };
    let pfm = |gray: f32| [b"Pf\n1 1\n-1\n".as_slice(), &gray.to_le_bytes()].concat();
    let world = "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"b.pfm\"
        Texture \"n\" \"float\" \"imagemap\" \"string filename\" \"b.pfm\" Material \"matte\" \"texture Kd\" \"t\" \"texture sigma\" \"n\"
        Include \"more.pbrt\" Shape \"plymesh\" \"string filename\" \"c.ply\" Translate 0 0 1
        Shape \"plymesh\" \"string filename\" \"c.ply\"";
    let (disk, mut cache) = (Disk::default(), LoadCache::default());
    disk.write("a.pbrt", scene("", world));
    disk.write("b.pfm", pfm(0.5));
    disk.write("c.ply", ply(1));
    disk.write("more.pbrt", strip(1.0));
    let mut before = disk.load(&mut cache, None);
    let map = |loaded: &Loaded| {
        let world = &loaded.scene.as_ref().unwrap().world;
        let crate::Texture::Varying(node) = world.primitives[0].material.kind.colors()[0] else { panic!() };
        let Varying::ImageMap(image) = &node.texture else { panic!() };
        image.map.clone()
    };
    let mut check = |expected: [bool; 4]| {
        let loaded = disk.load(&mut cache, None);
        let mut found = kept(&meshes(&before), &loaded);
        found.push(Arc::ptr_eq(&map(&before), &map(&loaded)));
        assert_eq!(found, expected);
        before = loaded;
        disk.bytes()
    };
    disk.write("a.pbrt", scene("Identity", world));
    // Only the text of the scene.
    assert_eq!(check([true; 4]), scene("Identity", world).len());
    disk.write("c.ply", ply(2));
    check([true, false, false, true]);
    disk.write("b.pfm", pfm(0.25));
    check([true, true, true, false]);
    disk.write("more.pbrt", strip(3.0));
    check([false, true, true, true]);
    disk.write("more.pbrt", format!("# moved\n{}", strip(3.0)));
    check([true; 4]);
    // May change without another stamp.
    disk.files.borrow_mut().values_mut().for_each(|(_, stamp)| *stamp = None);
    check([true, false, false, false]);
    check([true, false, false, false]);
    disk.write("a.pbrt", scene("", &format!("{world} Include \"more.pbrt\"")));
    let loaded = disk.load(&mut cache, None);
    assert_eq!(meshes(&loaded).len(), 4);
    // A file that is gone is missing.
    disk.files.borrow_mut().remove("c.ply");
    assert!(disk.load(&mut cache, None).scene.is_none());
}

/// Whatever memory there is.
#[test]
fn memory_is_charged_as_if_all_were_read() {
    let (disk, mut cache) = (Disk::default(), LoadCache::default());
    disk.write("a.pbrt", scene("", &format!("Include \"b.pbrt\" {}", strip(1.0))));
    disk.write("b.pbrt", strip(2.0));
    disk.load(&mut cache, None);
    let mut whole = 0;
    for limit in (0..80_000).step_by(500) {
        whole += u32::from(disk.load(&mut cache, Some(limit)).scene.is_some());
    }
    assert!((1..160).contains(&whole), "{whole}");
}

/// A text of megabytes is read into other memory than a new one. It may be larger or smaller than the text before.
#[test]
fn long_texts_are_the_same() {
    let (disk, mut cache) = (Disk::default(), LoadCache::default());
    let text = |megabytes: usize| {
        let comment = "# A line of sixteen.\n".repeat(megabytes * 50_000);
        scene("", &format!("{} {comment} Shape \"sphere\"", strip(1.0)))
    };
    for megabytes in [3, 3, 1, 3, 9, 8, 20, 1] {
        disk.write("a.pbrt", text(megabytes));
        assert!(disk.load(&mut cache, None).scene.is_some());
        assert_eq!(disk.bytes(), text(megabytes).len());
    }
    disk.write("a.pbrt", text(3));
    disk.load(&mut cache, None);
    for megabytes in [3, 9] {
        let length = text(megabytes).len() as u64;
        disk.write("a.pbrt", text(megabytes));
        let mut whole = 0;
        for limit in (1..30).map(|tenth| length * tenth / 10) {
            whole += u32::from(disk.load(&mut cache, Some(limit)).scene.is_some());
        }
        assert!((1..29).contains(&whole), "{whole}");
    }
}
