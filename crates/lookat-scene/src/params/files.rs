//! Reads the files that parameters name.

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use lookat_syntax::{Diagnostic, Entity, ParamType, Severity, Span, Text};

use super::Params;
use crate::Transform;
use crate::cache::MeshKey;
use crate::files::{Charged, Files};
use crate::report::Report;
use crate::schema::{Key, Name};

/// A file that a parameter names, and what messages about it need.
pub(crate) struct FileParam {
    /// The name of the file.
    pub name: Text,
    keyword: &'static str,
    kind: Text,
    parameter: &'static str,
    /// The place of the value.
    place: Span,
    /// True if a part of the directive is unreadable.
    partial: bool,
}

impl<'a> Params<'a> {
    /// A handle for a file, to read it later.
    pub fn file_param(&self, key: &Key<Name>, name: &Text) -> FileParam {
        FileParam {
            name: name.clone(),
            keyword: self.keyword,
            kind: self.kind.clone(),
            parameter: key.name,
            place: self.place(key.name),
            partial: self.report.partial,
        }
    }

    /// The parameters of a directive of which only a file is left to read.
    pub fn of_file(file: &FileParam, files: &'a Files<'a>, report: &'a mut Report) -> Self {
        report.partial = file.partial;
        let entity = Entity { name: file.kind.clone(), params: Vec::new() };
        let mut params = Params::new(file.keyword, entity, files, report);
        params.places.push((file.parameter, file.place, ParamType::String));
        params
    }
}

impl Params<'_> {
    /// The bytes of a file named by a parameter. Reports an unreadable file and returns `None`.
    pub fn file(&mut self, name: &Text) -> Option<(PathBuf, Charged)> {
        self.read(name).map_err(|(path, error)| self.unreadable(name, &path, &error)).ok()
    }

    /// The bytes of a file that the rest does without. `None`, and a warning, where it cannot be read.
    pub fn file_if_readable(&mut self, name: &Text) -> Option<(PathBuf, Charged)> {
        let read = self.read(name);
        read.map_err(|(path, error)| {
            let unreadable = self.files.unreadable("read", name, &path, &error);
            self.push(Diagnostic { severity: Severity::Warning, ..unreadable });
        })
        .ok()
    }

    /// The bytes of a file named by a parameter, or `None` for them if they are known. Reports an unreadable file and returns `None`.
    pub fn file_unless(
        &mut self,
        name: &Text,
        is_known: impl Fn(&Path) -> bool,
    ) -> Option<(PathBuf, Option<Charged>)> {
        let read = self.files.read_unless(&name.value, name.span, is_known);
        let (path, bytes) = read.map_err(|(path, error)| self.unreadable(name, &path, &error)).ok()?;
        self.warn_of_path(name, &path);
        Some((path, bytes))
    }

    /// What a mesh in a file depends on.
    pub fn mesh_file_key(&self, path: &Path, world_from_object: &Transform) -> Option<MeshKey> {
        self.files.mesh_file_key(path, world_from_object)
    }

    fn read(&mut self, name: &Text) -> Result<(PathBuf, Charged), (PathBuf, io::Error)> {
        self.files.read_named(&name.value, name.span).inspect(|(path, _)| self.warn_of_path(name, path))
    }

    /// Opens a file named by a parameter. Reports a file that it cannot open and returns `None`.
    pub fn open(&mut self, name: &Text) -> Option<(PathBuf, Box<dyn Read>)> {
        let opened = self.files.open_named(&name.value, name.span);
        let (path, file) = opened.map_err(|(path, error)| self.unreadable(name, &path, &error)).ok()?;
        self.warn_of_path(name, &path);
        Some((path, file))
    }

    /// Warns of a name that leads to `path` here and not in pbrt-v3.
    pub fn warn_of_path(&mut self, name: &Text, path: &Path) {
        self.report.extend(self.files.not_found_by_pbrt(name, path));
    }

    /// The same, of a file that is not read.
    pub fn warn_of_unread_path(&mut self, name: &Text) {
        if let Ok((path, _)) = self.files.open_named(&name.value, name.span) {
            self.warn_of_path(name, &path);
        }
    }

    /// Reports an unreadable file.
    pub fn unreadable(&mut self, name: &Text, path: &Path, error: &io::Error) {
        let unreadable = self.files.unreadable("read", name, path, error);
        // Empty names are separate mistakes.
        if name.value.is_empty() { self.error(unreadable) } else { self.error_surely(unreadable) }
    }

    /// The first path that [`Params::file`] tries. It is equal for names of the same file.
    pub fn first_path(&self, name: &Text) -> PathBuf {
        self.files.beside(&name.value, name.span)
    }
}
