//! The pictures of lights and textures: handles while the scene is read, then decoded, each once for each settings.

mod decode;
pub(crate) mod key;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use lookat_image::MipMap;
use lookat_syntax::{Diagnostic, Text};

use crate::files::Files;
use crate::params::{FileParam, Params};
use crate::report::Report;
use crate::schema::{self, Name};
use decode::{Made, check_name, decode};

pub(crate) use decode::FromColor;
use key::Key;
pub(crate) use key::Settings;

/// The pictures of a scene so far.
#[derive(Default)]
pub(crate) struct Pictures {
    /// Color pictures.
    pub colors: Cache<Vec3>,
    /// Pictures of single numbers.
    pub numbers: Cache<f32>,
}

impl Pictures {
    /// The number of handles.
    pub fn len(&self) -> usize {
        self.colors.handles.len() + self.numbers.handles.len()
    }

    /// Reads the pictures of all handles.
    pub fn load(&mut self, files: &Files, report: &mut Report) {
        self.colors.load(files, report);
        self.numbers.load(files, report);
    }

    /// Reports missing files, and what their names say. Reads nothing.
    pub fn check(&self, files: &Files, report: &mut Report) {
        self.colors.check(files, report);
        self.numbers.check(files, report);
    }
}

/// Pictures with one texel type.
pub(crate) struct Cache<T> {
    handles: Vec<Handle<T>>,
    stand_ins: HashMap<Key, Arc<MipMap<T>>>,
    /// The file found for the first path tried.
    found: HashMap<PathBuf, PathBuf>,
    known: HashMap<Key, Made<T>>,
    /// What replaces the stand-in at an address. `None` after an error.
    loaded: HashMap<usize, Option<Arc<MipMap<T>>>>,
}

/// A picture to be read from a file.
struct Handle<T> {
    file: FileParam,
    parameter: &'static str,
    settings: Settings,
    /// What pbrt-v3 does with a picture that it does not read.
    instead: String,
    /// The map in place of the picture.
    stand_in: Arc<MipMap<T>>,
}

impl<T> Default for Cache<T> {
    fn default() -> Self {
        Cache {
            handles: Vec::new(),
            stand_ins: HashMap::new(),
            found: HashMap::new(),
            known: HashMap::new(),
            loaded: HashMap::new(),
        }
    }
}

impl<T: FromColor> Cache<T> {
    /// A stand-in for the picture in `file`, named by the parameter `key`: gray, as in pbrt-v3 without the picture.
    /// `instead`: what pbrt-v3 does with a picture that it does not read.
    pub fn handle(
        &mut self,
        params: &Params,
        key: &schema::Key<Name>,
        file: &Text,
        settings: Settings,
        instead: &str,
    ) -> Arc<MipMap<T>> {
        let stand_in =
            self.stand_ins.entry(Key::new(params.first_path(file), &settings)).or_insert_with(|| {
                let gray = T::from_color(Vec3::splat(0.5), &settings);
                Arc::new(MipMap::new(1, 1, vec![gray], settings.wrap))
            });
        self.handles.push(Handle {
            file: params.file_param(key, file),
            parameter: key.name,
            settings,
            instead: instead.into(),
            stand_in: stand_in.clone(),
        });
        stand_in.clone()
    }

    fn load(&mut self, files: &Files, report: &mut Report) {
        for Handle { file, parameter, settings, instead, stand_in } in std::mem::take(&mut self.handles) {
            let params = &mut Params::of_file(&file, files, report);
            let picture = self.get(params, parameter, &file.name, settings, &instead);
            self.loaded.insert(Arc::as_ptr(&stand_in).addr(), picture);
        }
    }

    fn check(&self, files: &Files, report: &mut Report) {
        for Handle { file, parameter, instead, .. } in &self.handles {
            let params = &mut Params::of_file(file, files, report);
            let Some((path, _)) = params.open(&file.name) else { continue };
            match check_name(&path) {
                Ok(()) => warn_of_format(params, parameter, &path, instead),
                Err((message, help)) => {
                    params.error_surely(Diagnostic::error(file.name.span, message).help(help))
                }
            }
        }
    }

    /// The picture for a stand-in. `None` after an error.
    pub fn loaded(&self, stand_in: &Arc<MipMap<T>>) -> Option<Arc<MipMap<T>>> {
        self.loaded.get(&Arc::as_ptr(stand_in).addr()).cloned().flatten()
    }

    /// The picture named by the parameter `name`. Reports an error and returns `None` without one.
    fn get(
        &mut self,
        params: &mut Params,
        name: &'static str,
        file: &Text,
        settings: Settings,
        instead: &str,
    ) -> Option<Arc<MipMap<T>>> {
        let first = params.first_path(file);
        let (path, bytes) = match self.found.get(&first) {
            Some(path) => {
                params.warn_of_path(file, path);
                (path.clone(), None)
            }
            None => {
                let reuse = params.reuse();
                let is_kept = |path: &Path| {
                    let key = Key::new(path.to_owned(), &settings);
                    reuse.is_some_and(|reuse| reuse.picture::<MipMap<T>>(&key).is_some())
                };
                let (path, bytes) = params.file_unless(file, is_kept)?;
                self.found.insert(first.clone(), path.clone());
                (path, bytes)
            }
        };
        let key = Key::new(path, &settings);
        if !self.known.contains_key(&key) {
            let made = match kept(params, &key) {
                Some(map) => Ok(map),
                None => {
                    let bytes = match bytes {
                        Some(bytes) => bytes,
                        None => params.file(file)?.1,
                    };
                    let reported = params.reported();
                    let made = decode(params, name, &key.path, bytes, &settings);
                    // Warnings are given when the picture is decoded.
                    if let (Some(reuse), Ok(map)) = (params.reuse(), &made)
                        && reported.is_some_and(|reported| params.reported() == Some(reported))
                    {
                        reuse.keep_picture(&key, map);
                    }
                    made
                }
            };
            self.known.insert(key.clone(), made);
        }
        match &self.known[&key] {
            Ok(map) => {
                warn_of_format(params, name, &key.path, instead);
                Some(map.clone())
            }
            Err((message, help)) => {
                params.error_surely(Diagnostic::error(file.span, message).help(help));
                None
            }
        }
    }
}

/// A picture that an earlier load has decoded. `None` also where memory is short, so that errors are the same as without it.
fn kept<T: FromColor>(params: &Params, key: &Key) -> Option<Arc<MipMap<T>>> {
    let map: Arc<MipMap<T>> = params.reuse()?.picture(key)?;
    let mut charge = params.memory().reserve(4 * map.bytes() as u64).ok()?;
    charge.resize(map.bytes() as u64).ok()?;
    charge.keep();
    Some(map)
}

/// Warns of a picture in a format that pbrt-v3 does not read (ReadImage in core/imageio.cpp).
fn warn_of_format(params: &mut Params, name: &str, path: &Path, instead: &str) {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
    if ["exr", "tga", "png", "pfm"].contains(&ending.as_str()) {
        return;
    }
    let message = format!("pbrt-v3 does not read .{ending} pictures: it {instead}");
    params.warn(name, &message, "convert the picture to .exr, which both programs read");
}
