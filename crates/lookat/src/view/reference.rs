//! The pictures of the view: the newest, the finished one as a file, and the reference that pages compare with.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use lookat_image::{
    Aligned, Charge, Comparison, Image, MemoryBudget, PictureFile, Rules, THRESHOLD, Window, align,
};

use crate::compare::{as_text, check_memory, pixel_bytes};
use crate::failure::Failure;
use crate::live::Watch;
use crate::view::messages::News;
use crate::view::outbox::{Hub, Requests};
use crate::writer::{Writer, lock};

/// What the engine and the server share.
#[derive(Default)]
pub struct Shared {
    pub requests: Requests,
    pub hub: Hub,
    pub gallery: Gallery,
}

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

/// A picture that others are compared with.
pub struct Reference {
    pub name: String,
    pub image: Arc<Image>,
    _charge: Option<Charge>,
}

/// The reference, and the file that can be one.
pub struct References {
    /// The one that the command names.
    named: Option<PathBuf>,
    /// The one beside the scene, which can be read and is not read for it.
    pub beside: Option<PathBuf>,
    pub current: Option<Reference>,
    /// Why there is none, or why it is not the newest one.
    pub refused: Option<String>,
    /// Whether the pages have its pixels, and why they do not fit.
    pub is_shown: bool,
    pub mismatch: Option<String>,
    pub watch: Watch,
    pub memory: MemoryBudget,
}

impl References {
    pub fn new(named: Option<PathBuf>, memory: MemoryBudget) -> References {
        let watch = Watch::default();
        let (is_shown, mismatch) = (false, None);
        References { named, beside: None, current: None, refused: None, is_shown, mismatch, watch, memory }
    }

    /// The file that can be the reference.
    pub fn file(&self) -> Option<&Path> {
        self.named.as_deref().or(self.beside.as_deref())
    }

    /// Reads the file. The reference before stays if that fails.
    pub fn read(&mut self) {
        let Some(path) = self.file().map(Path::to_owned) else { return };
        self.watch.restart();
        self.watch.note(&path);
        match PictureFile::open(&path, &self.memory).and_then(PictureFile::read) {
            Ok((image, charge)) => {
                let name = path.display().to_string();
                let image = Arc::new(image);
                self.current = Some(Reference { name, image, _charge: Some(charge) });
                self.refused = None;
            }
            Err(error) => self.refused = Some(error.to_string()),
        }
    }

    /// Keeps a picture as the reference.
    pub fn keep(&mut self, image: Arc<Image>) {
        self.watch.restart();
        self.current = Some(Reference { name: "kept picture".into(), image, _charge: None });
        self.refused = None;
    }

    pub fn clear(&mut self) {
        self.watch.restart();
        (self.current, self.refused) = (None, None);
    }
}

/// The pixels of a reference where a picture has them. NaN where the reference has none. Fails as `compare`.
pub fn over(
    reference: &Image,
    data_window: Window,
    display_window: Window,
) -> Result<Vec<[f32; 3]>, Failure> {
    let area = data_window.area() as usize;
    let blank = Image::from_rgb(data_window, display_window, &vec![[0.0; 3]; area]);
    let Aligned { window, expected, .. } = align(&blank, reference)?;
    let mut pixels = vec![[f32::NAN; 3]; area];
    let left = (window.x - data_window.x) as usize;
    for (row, values) in expected.chunks_exact(window.width as usize).enumerate() {
        let y = row + (window.y - data_window.y) as usize;
        pixels[y * data_window.width as usize + left..][..values.len()].copy_from_slice(values);
    }
    Ok(pixels)
}

/// Compares pictures on a thread of its own, one pair at a time.
pub struct Comparer {
    /// `None` without a thread: then pictures are not compared.
    worker: Option<Writer<Box<dyn FnOnce() + Send>>>,
    /// Counts the comparisons: only the last one counts.
    newest: Arc<Mutex<u32>>,
}

impl Comparer {
    pub fn new() -> Comparer {
        let worker = Writer::new(|compare: Box<dyn FnOnce() + Send>, _| {
            // After a panic, others are still compared.
            let _ = catch_unwind(AssertUnwindSafe(compare));
            ControlFlow::Continue(())
        });
        Comparer { worker: worker.ok(), newest: Arc::default() }
    }

    /// Compares as `lookat compare actual reference`, and tells the result, unless another comparison begins meanwhile.
    pub fn compare(
        &self,
        generation: u32,
        [actual, reference]: [(String, Arc<Image>); 2],
        memory: MemoryBudget,
        tell: impl FnOnce(News) + Send + 'static,
    ) {
        let (own, newest) = (self.cancel(), self.newest.clone());
        let compare = Box::new(move || {
            let names = [&*actual.0, &*reference.0];
            let (text, agrees) = compared(names, [&actual.1, &reference.1], &memory)
                .unwrap_or_else(|reason| (format!("{reason}\n"), None));
            // With the lock, nobody cancels it meanwhile.
            let newest = lock(&newest);
            if *newest == own {
                tell(News::Compared { generation, text, agrees });
            }
        });
        if let Some(worker) = &self.worker {
            worker.put(|waiting| waiting.push_back(compare));
        }
    }

    /// Ends comparisons that have not told yet. Returns the number of the next.
    pub fn cancel(&self) -> u32 {
        if let Some(worker) = &self.worker {
            worker.put(|waiting| waiting.clear());
        }
        let mut newest = lock(&self.newest);
        *newest = newest.wrapping_add(1);
        *newest
    }
}

/// What `compare` prints, and whether noise explains the differences.
fn compared(
    names: [&str; 2],
    [actual, reference]: [&Image; 2],
    memory: &MemoryBudget,
) -> Result<(String, Option<bool>), Failure> {
    let pair = align(actual, reference)?;
    check_memory(pair.window, pair.window.area() * pixel_bytes(&pair), memory)?;
    let rules = Rules { limits: &[], only: &[], is_layer: false, threshold: THRESHOLD };
    let comparison = Comparison::new(names, &pair, rules)?;
    Ok((as_text(&comparison), comparison.agrees()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever comes in between: only the newest pair counts, and pairs are compared again later.
    #[test]
    fn the_last_comparison_is_told() {
        let window = Window { x: 0, y: 0, width: 16, height: 16 };
        let image = Arc::new(Image::from_rgb(window, window, &[[0.5; 3]; 256]));
        let (comparer, (tell, told)) = (Comparer::new(), std::sync::mpsc::channel());
        for last in [20, 40] {
            for generation in last - 9..=last {
                let tell = tell.clone();
                let pictures = [("a".into(), image.clone()), ("b".into(), image.clone())];
                comparer.compare(generation, pictures, MemoryBudget::default(), move |news| {
                    let News::Compared { generation, .. } = news else { panic!("{news:?}") };
                    tell.send(generation).unwrap();
                });
            }
            let second = std::time::Duration::from_secs(1);
            while told.recv_timeout(60 * second).unwrap() != last {}
            assert!(told.try_recv().is_err());
        }
        comparer.cancel();
    }

    #[test]
    fn a_reference_is_cut_to_the_picture() {
        let full = Window { x: 0, y: 0, width: 4, height: 3 };
        let pixels: Vec<[f32; 3]> = (0..12).map(|at| [at as f32; 3]).collect();
        let whole = Image::from_rgb(full, full, &pixels);
        let crop = Window { x: 1, y: 1, width: 2, height: 2 };
        let first = |pixels: Vec<[f32; 3]>| pixels.iter().map(|it| it[0]).collect::<Vec<_>>();
        assert_eq!(first(over(&whole, crop, full).unwrap()), [5.0, 6.0, 9.0, 10.0]);
        let part = Image::from_rgb(crop, full, &pixels[..4]);
        let found = first(over(&part, full, full).unwrap());
        assert!(found[0].is_nan() && found[5..7] == [0.0, 1.0] && found[9..11] == [2.0, 3.0]);
        let larger = Window { width: 5, ..full };
        assert_eq!(over(&whole, larger, larger).unwrap_err().to_string(), "the sizes differ: 5x3 and 4x3");
    }
}
