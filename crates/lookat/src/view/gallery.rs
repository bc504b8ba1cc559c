//! The newest picture, and the finished one as a file.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use lookat_image::Image;

/// The pictures of the view.
#[derive(Default)]
pub struct Gallery {
    pictures: Mutex<Pictures>,
    /// One file at a time, as it takes memory.
    writing: Mutex<()>,
}

#[derive(Default)]
struct Pictures {
    newest: Option<Arc<Image>>,
    finished: Option<Arc<Image>>,
}

impl Gallery {
    /// Takes a picture of full size, finished or not.
    pub fn put(&self, image: Image, is_final: bool) -> Arc<Image> {
        let image = Arc::new(image);
        let mut pictures = self.lock();
        pictures.newest = Some(image.clone());
        pictures.finished = is_final.then(|| image.clone());
        image
    }

    /// Forgets the pictures of another view.
    pub fn clear(&self) {
        *self.lock() = Pictures::default();
    }

    /// The newest picture.
    pub fn newest(&self) -> Option<Arc<Image>> {
        self.lock().newest.clone()
    }

    pub fn finished(&self) -> Option<Arc<Image>> {
        self.lock().finished.clone()
    }

    /// The finished picture as `render` writes it into a file of this name. `None` without a picture, or without room for it.
    pub fn file(&self, name: &str) -> Option<Vec<u8>> {
        let _turn = self.writing.lock().unwrap_or_else(PoisonError::into_inner);
        let image = self.finished()?;
        let folder = tempfile::tempdir().ok()?;
        let path = folder.path().join(Path::new(name).file_name()?);
        image.write(&path).ok()?;
        std::fs::read(path).ok()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Pictures> {
        self.pictures.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
