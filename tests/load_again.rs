//! Scenes that are loaded again are the same as scenes that are loaded alone, after any change.

use std::cell::RefCell;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};

use lookat_scene::{LoadCache, LoadOptions, Loaded, Stamp, load_again, load_opened};

/// The scenes below a folder.
fn scenes(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            scenes(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "pbrt") {
            found.push(path);
        }
    }
}

/// All that loading tells.
fn told(loaded: &Loaded) -> [String; 3] {
    let Loaded { scene, diagnostics, symbols, places, output, inputs, placement, .. } = loaded;
    let rest = (symbols, places, output, inputs, placement, loaded.can_keep_going, &loaded.override_error);
    let memory = scene.as_ref().map(|scene| scene.world.memory());
    let is_small = memory.is_none_or(|memory| memory.meshes + memory.picture_bytes < 100_000);
    let world = match is_small {
        true => format!("{scene:?}"),
        // Too much to print.
        false => format!("{memory:?} {:?}", scene.as_ref().map(|scene| scene.world.bounds())),
    };
    [format!("{diagnostics:?}"), world, format!("{rest:?}")]
}

fn check(path: &Path) {
    let text = RefCell::new(std::fs::read(path).unwrap());
    let open = |file: &Path| -> io::Result<Box<dyn Read>> {
        match file == path {
            true => Ok(Box::new(Cursor::new(text.borrow().clone()))),
            false => Ok(Box::new(lookat_image::open_file(file)?)),
        }
    };
    let stamp = |file: &Path| {
        let found = std::fs::metadata(file).ok().filter(|_| file != path)?;
        Some(Stamp { modified: found.modified().ok(), length: found.len(), number: 0 })
    };
    let options = LoadOptions { max_memory: Some(1_000_000_000), ..LoadOptions::default() };
    let mut cache = LoadCache::default();
    let mut check = |what: &str| {
        let alone = told(&load_opened(path, &open, &options));
        let again = told(&load_again(path, &open, &mut cache, &stamp, &options));
        assert!(alone == again, "{} {what}\n{}\n{}", path.display(), alone[0], again[0]);
    };
    let whole = text.borrow().clone();
    check("first");
    check("again");
    let lines: Vec<&[u8]> = whole.split_inclusive(|byte| *byte == b'\n').collect();
    for part in 0..4 {
        // Without a line, and back.
        let (before, after) = lines.split_at(part * lines.len() / 4);
        *text.borrow_mut() = [before, after.get(1..).unwrap_or_default()].concat().concat();
        check("without a line");
        *text.borrow_mut() = [before, &[b"# edited\n".as_slice()], after].concat().concat();
        check("with a comment");
    }
}

#[test]
fn scenes_are_the_same_when_they_are_loaded_again() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut found = Vec::new();
    ["pbrt-scenes", "tests"].iter().for_each(|folder| scenes(&root.join(folder), &mut found));
    assert!(found.len() > 300, "{}", found.len());
    found.iter().for_each(|path| check(path));
}
