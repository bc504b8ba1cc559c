//! Reads files through the caller's function.

pub(crate) mod content;
mod nearby;

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io;
use std::path::{Component, Path, PathBuf};

use bytes::Bytes;
use lookat_image::{MemoryBudget, io_reason};
use lookat_syntax::{Diagnostic, Entity, FileId, LongList, Param, ParamType, Span, Text, read_list};

use crate::Transform;
use crate::cache::{KeptMesh, List, MeshKey, Reuse};
use crate::files::content::{LFS_POINTER, LFS_REASON};
use crate::sources::{Source, Sources};
use nearby::Folders;

use content::Content;
pub(crate) use content::{Access, Charged};
pub use content::{Open, Read};

/// A file and its path, or the first path tried and its error.
pub(crate) type FileResult<T> = Result<(PathBuf, T), (PathBuf, io::Error)>;

/// The files of a scene, with access to more.
pub(crate) struct Files<'a> {
    pub sources: Sources,
    access: Access<'a>,
    /// The memory budget of everything that is read.
    pub memory: MemoryBudget,
    /// What an earlier load has kept.
    pub reuse: Option<Reuse<'a>>,
    /// The directory of the scene file.
    root: PathBuf,
    /// The folders listed for missing files, if files are on disk.
    folders: Option<RefCell<Folders>>,
    /// All files read so far.
    inputs: RefCell<BTreeSet<PathBuf>>,
}

impl<'a> Files<'a> {
    pub fn new(scene: &Path, access: Access<'a>, memory: MemoryBudget, reuse: Option<Reuse<'a>>) -> Self {
        Files {
            sources: Sources::default(),
            access,
            memory,
            reuse,
            root: parent(scene),
            folders: matches!(access, Access::Open(_)).then(RefCell::default),
            inputs: RefCell::default(),
        }
    }

    /// Reads a scene file or an included one.
    pub fn open(&mut self, path: PathBuf, included_at: Option<Span>) -> io::Result<FileId> {
        let content = self.access.content(&path)?;
        let text = self.text(&path, content)?.keep();
        self.inputs.borrow_mut().insert(path.clone());
        Ok(self.add(path, text, included_at))
    }

    /// A text, which is not read if it is known.
    fn text(&self, path: &Path, content: Content) -> io::Result<Charged> {
        let known = self.reuse.and_then(|reuse| Charged::known(reuse.text(path)?, &self.memory));
        let before = || self.reuse.and_then(|reuse| reuse.length(path)).unwrap_or(0);
        known.map_or_else(|| content.bytes_after(before(), &self.memory), Ok)
    }

    /// Reads the lists that the parser left out.
    pub fn read_lists(&self, params: &mut [Param]) {
        for param in params.iter_mut().filter(|param| !param.is_read) {
            param.values.value = read_list(param.ty, self.sources.text(param.values.span));
            param.is_read = true;
        }
    }

    /// What the mesh of a directive depends on. `None` without a long list, and if there is more than the lists of a mesh to read.
    pub fn mesh_key(&self, entity: &Entity, world_from_object: &Transform) -> Option<MeshKey> {
        let is_long = |span: Span| (span.end - span.start) as usize >= LongList::BYTES;
        let has_long = entity.params.iter().any(|param| is_long(param.values.span));
        let reuse = self.reuse.filter(|_| has_long && entity.name.value == "trianglemesh")?;
        let mut lists = Vec::new();
        for Param { ty, name, values, is_read } in &entity.params {
            let types: &[ParamType] = match name.value.as_str() {
                "indices" | "faceIndices" => &[ParamType::Integer],
                "P" => &[ParamType::Point3],
                "N" => &[ParamType::Normal],
                "S" => &[ParamType::Vector3],
                "uv" | "st" => &[ParamType::Point2, ParamType::Float],
                _ => &[],
            };
            if !types.contains(ty) {
                // The directive has to be read.
                is_read.then_some(())?;
                continue;
            }
            let Span { file, start, .. } = values.span;
            let list = if is_long(values.span) {
                List::Long(reuse.list_number(&self.sources.file(file).path, start)?)
            } else {
                List::Short(self.sources.text(values.span).to_owned())
            };
            lists.push((name.value.clone(), *ty, list));
        }
        Some(MeshKey::Lists(lists, world_from_object.bits()))
    }

    /// A mesh that an earlier load has made. `None` also where memory is short, so that errors are the same as without it.
    pub fn kept_mesh(&self, key: &MeshKey) -> Option<KeptMesh> {
        let kept = self.reuse?.mesh(key)?;
        let _twice = self.memory.reserve(2 * kept.mesh.bytes() as u64).ok()?;
        Some(kept)
    }

    /// What a mesh in a file depends on.
    pub fn mesh_file_key(&self, path: &Path, world_from_object: &Transform) -> Option<MeshKey> {
        let stamp = self.reuse.and_then(|reuse| (reuse.stamp)(path))?;
        Some(MeshKey::File(path.to_owned(), stamp, world_from_object.bits()))
    }

    /// The files of the scene's text, all that were read, and what memory is left.
    pub fn into_parts(self) -> (Sources, BTreeSet<PathBuf>, MemoryBudget) {
        (self.sources, self.inputs.into_inner(), self.memory)
    }

    /// Adds a file with a known text.
    pub fn add(&mut self, path: PathBuf, text: Bytes, included_at: Option<Span>) -> FileId {
        self.sources.files.push(Source::new(path, text, included_at));
        FileId(self.sources.files.len() as u32 - 1)
    }

    /// Reads the file named at `span`, relative to the file that contains the name, or else to the scene file.
    /// (pbrt-v3 does only the second.)
    pub fn read_named(&self, name: &str, span: Span) -> FileResult<Charged> {
        self.named(name, span, |_, content| no_pointer(content.bytes(&self.memory)?))
    }

    /// The text named at `span`. A text that an earlier load has kept is not read again.
    pub fn text_named(&self, name: &str, span: Span) -> FileResult<Charged> {
        self.named(name, span, |path, content| no_pointer(self.text(path, content)?))
    }

    /// Opens the file named at `span`, and reads it unless its contents are known.
    pub fn read_unless(
        &self,
        name: &str,
        span: Span,
        is_known: impl Fn(&Path) -> bool,
    ) -> FileResult<Option<Charged>> {
        self.named(name, span, |path, content| {
            if is_known(path) { Ok(None) } else { no_pointer(content.bytes(&self.memory)?).map(Some) }
        })
    }

    /// Opens the file named at `span` for streaming.
    pub fn open_named(&self, name: &str, span: Span) -> FileResult<Box<dyn io::Read>> {
        self.named(name, span, |_, content| Ok(content.stream()))
    }

    fn named<T>(
        &self,
        name: &str,
        span: Span,
        take: impl Fn(&Path, Content) -> io::Result<T>,
    ) -> FileResult<T> {
        let get = |path: &Path| {
            let taken = self.access.content(path).and_then(|content| take(path, content))?;
            self.inputs.borrow_mut().insert(path.to_owned());
            Ok(taken)
        };
        let beside = self.beside(name, span);
        let error = match get(&beside) {
            Ok(taken) => return Ok((beside, taken)),
            Err(error) => error,
        };
        let from_root = normal(&self.root.join(name));
        if from_root != beside
            && let Ok(taken) = get(&from_root)
        {
            return Ok((from_root, taken));
        }
        Err((beside, error))
    }

    /// The path of a file named at `span`, relative to the file that contains the name.
    pub fn beside(&self, name: &str, span: Span) -> PathBuf {
        normal(&self.folder(span).join(name))
    }

    /// The warning for a name that leads to `path` here and not in pbrt-v3, which looks beside the scene file alone
    /// (ResolveFilename in core/fileutil.cpp).
    pub fn not_found_by_pbrt(&self, name: &Text, path: &Path) -> Option<Diagnostic> {
        let there = normal(&self.root.join(&name.value));
        if there == *path {
            return None;
        }
        let message = match self.access.content(&there) {
            Ok(_) => {
                format!("pbrt-v3 reads {} here, and lookat reads {}", shown_path(&there), shown_path(path))
            }
            Err(_) => format!("pbrt-v3 does not find this file: it looks for {}", shown_path(&there)),
        };
        let warning = Diagnostic::warning(name.span, message);
        Some(match self.name_from_scene(path, name.span) {
            Some(better) => {
                let quoted = format!("\"{better}\"");
                warning.help(format!("write {quoted}, which both programs find")).fix(name.span, quoted)
            }
            None => {
                warning.help("pbrt-v3 takes names relative to the scene file: keep both files in one folder")
            }
        })
    }

    /// The name of a file relative to the scene file, where that name leads from `span` to the same file.
    fn name_from_scene(&self, path: &Path, span: Span) -> Option<String> {
        let root = normal(&self.root);
        let mut root: Vec<Component> = root.components().filter(|part| *part != Component::CurDir).collect();
        let mut parts: Vec<Component> = path.components().collect();
        let common = root.iter().zip(&parts).take_while(|(a, b)| a == b).count();
        root.drain(..common);
        parts.drain(..common);
        if root.iter().any(|part| !matches!(part, Component::Normal(_))) {
            return None;
        }
        let up = root.iter().map(|_| Some(".."));
        let names: Option<Vec<&str>> = up.chain(parts.iter().map(|part| part.as_os_str().to_str())).collect();
        let name = names?.join("/");
        let beside = self.beside(&name, span);
        let leads_here = beside == *path || self.access.content(&beside).is_err();
        (leads_here && !name.contains(['"', '\\']) && !name.contains(char::is_control)).then_some(name)
    }

    /// The folder of the file at a span.
    fn folder(&self, span: Span) -> PathBuf {
        parent(&self.sources.file(span.file).path)
    }

    /// The error for an unreadable file.
    pub fn unreadable(&self, verb: &str, name: &Text, path: &Path, error: &io::Error) -> Diagnostic {
        if name.value.is_empty() {
            return Diagnostic::error(name.span, "the name of the file is empty");
        }
        let shown = shown_path(path);
        let diagnostic = Diagnostic::error(name.span, format!("cannot {verb} {shown}: {}", io_reason(error)));
        if name.value.contains(char::is_control) {
            return diagnostic.help("\\ starts an escape in a string: write / or \\\\ instead");
        }
        if error.kind() != io::ErrorKind::NotFound {
            return diagnostic;
        }
        match self.meant(name) {
            Some(meant) => {
                // Under a name that pbrt-v3 finds, too.
                let path = self.beside(&meant, name.span);
                let is_found = normal(&self.root.join(&meant)) == path;
                let better = (!is_found).then(|| self.name_from_scene(&path, name.span)).flatten();
                let meant = better.unwrap_or(meant);
                let quoted = format!("\"{meant}\"");
                diagnostic.help(format!("did you mean {quoted}?")).fix(name.span, quoted)
            }
            None => {
                if let Some(folder) = self.missing_folder(path) {
                    let folder = shown_path(folder);
                    return Diagnostic::error(name.span, format!("there is no folder {folder}"))
                        .note(format!("needed for {shown}"))
                        .help("copy the folder to this path, or correct the names of the files in it");
                }
                let also = normal(&self.root.join(&name.value));
                let rule = match self.sources.files.first() {
                    Some(scene) if scene.path == Path::new("-") => {
                        "lookat looks in the folder of the file that names it; for standard input, in the working folder"
                    }
                    _ => {
                        "lookat looks in the folder of the file that names it, then in the folder of the scene"
                    }
                };
                diagnostic.help(if also == *path {
                    rule.to_owned()
                } else {
                    format!("{rule}: {} does not exist either", shown_path(&also))
                })
            }
        }
    }

    /// The outermost missing folder of a path. `None` if files are not on disk.
    fn missing_folder<'p>(&self, path: &'p Path) -> Option<&'p Path> {
        self.folders.as_ref()?;
        let folders = path.ancestors().skip(1).filter(|folder| !folder.as_os_str().is_empty());
        folders.take_while(|folder| !folder.exists()).last()
    }

    /// An existing file with a name similar to a missing scene file.
    pub fn meant_scene(&self, path: &Path) -> Option<String> {
        let listed = self.folders.as_ref()?;
        let ended = format!("{}.pbrt", path.to_str()?);
        if Path::new(&ended).is_file() {
            return Some(ended);
        }
        let from = if path.is_absolute() { "/" } else { "" };
        let meant = listed.borrow_mut().meant(path.to_str()?, &[PathBuf::from(from)])?;
        Some(format!("{from}{meant}"))
    }

    /// An existing file with a name similar to a missing one. Files that the scene already uses count only if the
    /// names differ in case alone, because the files of a scene have similar names.
    fn meant(&self, name: &Text) -> Option<String> {
        let listed = self.folders.as_ref()?;
        let folders = [self.folder(name.span), self.root.clone()];
        let meant = listed.borrow_mut().meant(&name.value, &folders)?;
        let is_known = |path: PathBuf| self.sources.files.iter().any(|source| source.path == path);
        let is_same = meant.to_lowercase() == name.value.to_lowercase();
        (is_same || !folders.iter().any(|folder| is_known(normal(&folder.join(&meant))))).then_some(meant)
    }
}

fn no_pointer(bytes: Charged) -> io::Result<Charged> {
    if bytes.starts_with(LFS_POINTER) { Err(io::Error::other(LFS_REASON)) } else { Ok(bytes) }
}

/// A path as messages show it.
pub(crate) fn shown_path(path: &Path) -> String {
    path.display().to_string().escape_debug().to_string()
}

fn parent(path: &Path) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).to_owned()
}

/// The path without `.` and resolvable `..`, so that a file has one name.
fn normal(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(out.components().next_back(), Some(Component::Normal(_))) => {
                out.pop();
            }
            other => out.push(other),
        }
    }
    if out.as_os_str().is_empty() { PathBuf::from(".") } else { out }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_have_one_name() {
        let check = |path, expected| assert_eq!(normal(Path::new(path)), Path::new(expected));
        check("a/./b/../c.pbrt", "a/c.pbrt");
        check("../a.pbrt", "../a.pbrt");
        check("a/../../b", "../b");
        check("/x/../y", "/y");
    }
}
