//! The newest picture, and the finished one as a file.

use std::path::Path;
use std::sync::{Arc, Mutex};

use lookat_image::Image;

use crate::lock::lock;

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
        let mut pictures = lock(&self.pictures);
        pictures.newest = Some(image.clone());
        pictures.finished = is_final.then(|| image.clone());
        image
    }

    /// Forgets the pictures of another view.
    pub fn clear(&self) {
        *lock(&self.pictures) = Pictures::default();
    }

    /// The newest picture.
    pub fn newest(&self) -> Option<Arc<Image>> {
        lock(&self.pictures).newest.clone()
    }

    pub fn finished(&self) -> Option<Arc<Image>> {
        lock(&self.pictures).finished.clone()
    }

    /// The finished picture as `render` writes it into a file of this name. `None` without a picture, or without room for it.
    pub fn file(&self, name: &str) -> Option<Vec<u8>> {
        let _turn = lock(&self.writing);
        let image = self.finished()?;
        image.to_bytes(Path::new(name)).ok()
    }
}
