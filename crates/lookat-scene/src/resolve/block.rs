//! Blocks: the place of each directive, opening and closing, and objects.

use std::sync::Arc;

use lookat_syntax::{Diagnostic, Directive, EntityKind, Span, Statement, Text, shown};

use super::{Block, Resolver};
use crate::elsewhere::Kind;
use crate::state::{Open, Saved};
use crate::undefined::undefined;
use crate::{Instance, Object, Transform};

/// The deepest nesting of blocks.
const MAX_OPEN: usize = 1000;

impl Resolver<'_> {
    /// Reports a directive in the wrong block.
    pub(super) fn belongs_here(&mut self, statement: &Statement) -> bool {
        let (home, at) = (home_block(&statement.directive), statement.keyword);
        let keyword = statement.directive.keyword();
        if self.block == Block::Ended {
            let message = "lookat ignores directives after WorldEnd: it renders one picture per file";
            self.report.unsupported(at, message.into());
            return false;
        }
        match (home, self.block) {
            (Some(Block::Options), Block::World) => self.report_late(&statement.directive, at),
            // Reported once the place of WorldBegin is known.
            (Some(Block::World), Block::Options) => self.early.push((keyword, at)),
            _ => return true,
        }
        false
    }

    pub(super) fn report_late(&mut self, directive: &Directive, at: Span) {
        let error = match directive {
            Directive::WorldBegin => {
                Diagnostic::error(at, "a second WorldBegin").help("put the second world into a separate file")
            }
            other => Diagnostic::error(at, format!("{} inside the world block", other.keyword()))
                .help("move it before WorldBegin"),
        };
        let error = match self.world_begin {
            Some(begin) => error.related(begin, "the world block begins here"),
            None => error,
        };
        self.report.push(error);
    }

    pub(super) fn report_early(&mut self, world_begin: Span) {
        for (keyword, at) in std::mem::take(&mut self.early) {
            let error = Diagnostic::error(at, format!("{keyword} before WorldBegin"))
                .help("move it after WorldBegin")
                .related(world_begin, "the world block begins here");
            self.report.push(error);
        }
    }

    pub(super) fn report_no_world(&mut self, end: Span) {
        if self.report.incomplete {
            return;
        }
        let error = match self.early.first() {
            None => Diagnostic::error(end, "the file has no WorldBegin: there is nothing to render")
                .help("put the lights and shapes between WorldBegin and WorldEnd; if another scene includes this file, check that scene"),
            Some((keyword, at)) => {
                let before = Span { end: at.start, ..*at };
                Diagnostic::error(*at, format!("{keyword} without WorldBegin"))
                    .help("put the lights and shapes between WorldBegin and WorldEnd")
                    .fix(before, "WorldBegin\n")
            }
        };
        self.report.push(error);
    }

    /// Treats the following directives as part of a world without `WorldBegin`. Another file may define their names.
    pub fn begin_part(&mut self, first: Span) {
        self.part = Some(first);
        self.block = Block::World;
        self.report.incomplete = true;
    }

    /// Treats options as a file that other scenes include, if the caller accepts one.
    pub fn begin_options_part(&mut self, first: Span) {
        if self.overrides.accept_part {
            self.part = Some(first);
            self.report.incomplete = true;
        }
    }

    /// Resolves these options, so that their errors are reported.
    pub(super) fn end_options_part(&mut self, first: Span) {
        let options = std::mem::take(&mut self.options);
        options.settle(first, self.overrides, &self.files, &mut self.report);
        self.report_part(first, "WorldBegin");
    }

    /// Reports a part of a scene. `without` lists the missing directives.
    pub(super) fn report_part(&mut self, at: Span, without: &str) {
        let message = format!("this file is a part of a scene: it has no {without}");
        let help = "check or render the scene that includes it";
        self.report.push(match self.overrides.accept_part {
            true => Diagnostic::note_at(at, message)
                .help("the scene that includes it may define the missing names"),
            false => Diagnostic::error(at, message).help(help),
        });
    }

    pub(super) fn report_no_end(&mut self, end: Span) {
        // pbrt-v4 has no WorldEnd.
        if self.report.is_v4(&self.files.sources) || self.report.incomplete || self.report.incomplete_end {
            return;
        }
        let warning = Diagnostic::warning(end, "the file ends without WorldEnd")
            .help("add WorldEnd: without it, pbrt-v3 renders nothing");
        self.report.push(warning);
    }

    pub(super) fn world_begin(&mut self, at: Span) {
        self.block = Block::World;
        self.world_begin = Some(at);
        self.report_early(at);
        self.state.ctm = Transform::IDENTITY;
        self.state.at_start = true;
        self.coordinate_systems.insert("world".into(), Transform::IDENTITY);
        if let Some(idle) = self.idle_transform.take() {
            let warning = Diagnostic::warning(idle, "a transformation after Camera has no effect")
                .help("move it before Camera to place the camera, or after WorldBegin to place shapes");
            self.report.push(warning);
        }
        let options = std::mem::take(&mut self.options);
        self.settled = Some(options.settle(at, self.overrides, &self.files, &mut self.report));
    }

    pub(super) fn world_end(&mut self) {
        self.end_forgotten_object();
        for open in std::mem::take(&mut self.open).into_iter().rev() {
            let (begin, end) = open.keywords();
            let warning = Diagnostic::warning(open.at(), format!("this {begin} is not closed"))
                .help(format!("add {end} before the end of the world block"));
            self.report.push(warning);
            self.restore(open);
        }
        self.block = Block::Ended;
    }

    /// Opens a block, unless the nesting is too deep.
    pub(super) fn begin(&mut self, open: Open) -> bool {
        let few = self.open.len() < MAX_OPEN;
        if few {
            self.open.push(open);
        } else {
            let (begin, end) = open.keywords();
            let error = Diagnostic::error(open.at(), format!("more than {MAX_OPEN} blocks are open"))
                .help(format!("each {begin} needs an {end}: add the missing one"));
            self.report.push(error);
            *self.forgiven.entry(end).or_default() += 1;
        }
        few
    }

    pub(super) fn close(&mut self, keyword: &'static str, at: Span) -> Result<(), Box<Diagnostic>> {
        let Some(inner) = self.open.last().map(|open| (open.keywords(), open.at())) else {
            return self.close_nothing(keyword, at);
        };
        let ((begin, end), opened) = inner;
        if end == keyword {
            self.open.pop().into_iter().for_each(|open| self.restore(open));
            return Ok(());
        }
        if self.cross(keyword) {
            // The end of an open object shows the actual mistake.
            match keyword {
                "AttributeEnd" => self.crossed = self.crossed.or(Some(at)),
                _ => self.warn_crossed(keyword, at, opened, (begin, end)),
            }
            return Ok(());
        }
        self.close_wrongly(keyword);
        let error = Diagnostic::error(at, format!("{keyword} inside the block of {begin}"))
            .note(format!("expected {end}"))
            .related(opened, "the block opens here");
        Err(Box::new(error))
    }

    /// Ends the innermost block of a kind although other attribute or object blocks are open inside it. pbrt-v3 keeps
    /// their states on one stack, so the state saved last is restored first.
    fn cross(&mut self, keyword: &str) -> bool {
        let Some(at) = self.open.iter().rposition(|open| open.keywords().1 == keyword) else { return false };
        let is_state = |open: &Open| matches!(open, Open::Attribute { .. } | Open::Object { .. });
        if !self.open[at..].iter().all(is_state) {
            return false;
        }
        for next in at + 1..self.open.len() {
            if let [outer, inner] = &mut self.open[next - 1..=next] {
                if let (Some(a), Some(b)) = (outer.saved(), inner.saved()) {
                    std::mem::swap(a, b);
                }
                std::mem::swap(outer, inner);
            }
        }
        self.open.pop().into_iter().for_each(|open| self.restore(open));
        true
    }

    fn warn_crossed(&mut self, keyword: &str, at: Span, opened: Span, (begin, end): (&str, &str)) {
        let warning = Diagnostic::warning(at, format!("{keyword} inside the block of {begin}"))
            .related(opened, "the block opens here")
            .help(format!("as in pbrt-v3, this closes the outer block and leaves the inner block open: write {end} before this directive"));
        self.report.push(warning);
    }

    /// Ends an object that an AttributeEnd crossed and no ObjectEnd closed, and reports the missing ObjectEnd.
    fn end_forgotten_object(&mut self) {
        if self.crossed.is_none() || !matches!(self.open.last(), Some(Open::Object { .. })) {
            return;
        }
        if let (Some(at), Some(open)) = (self.crossed.take(), self.open.pop()) {
            let error = Diagnostic::error(at, "ObjectEnd is missing before this AttributeEnd");
            self.report.push(error.related(open.at(), "the object begins here"));
            self.restore(open);
        }
    }

    pub(super) fn close_nothing(&mut self, keyword: &'static str, at: Span) -> Result<(), Box<Diagnostic>> {
        if let Some(forgiven) = self.forgiven.get_mut(keyword).filter(|count| **count > 0) {
            *forgiven -= 1;
            return Ok(());
        }
        let begin = keyword.replace("End", "Begin");
        Err(Box::new(Diagnostic::error(at, format!("{keyword} without {begin}"))))
    }

    /// Recovers from a wrong end with one error: closes blocks up to a matching one. Without a match, closes the
    /// innermost block, unless the block or the keyword belongs to an object.
    pub(super) fn close_wrongly(&mut self, keyword: &'static str) {
        let depth = match self.open.iter().rposition(|open| open.keywords().1 == keyword) {
            Some(matching) => matching,
            None if keyword == "ObjectEnd" || matches!(self.open.last(), Some(Open::Object { .. })) => return,
            None => self.open.len() - 1,
        };
        for open in self.open.split_off(depth).into_iter().rev() {
            let end = open.keywords().1;
            if end != keyword {
                *self.forgiven.entry(end).or_default() += 1;
            }
            self.restore(open);
        }
    }

    pub(super) fn restore(&mut self, open: Open) {
        match open {
            Open::Attribute { saved, .. } => saved.restore(&mut self.state, &mut self.definitions),
            Open::Transform { saved, .. } => (self.state.ctm, self.state.at_start) = *saved,
            Open::Object { saved, name, at } => {
                if let Some(crossed) = self.crossed.take() {
                    self.warn_crossed("AttributeEnd", crossed, at, ("ObjectBegin", "ObjectEnd"));
                }
                saved.restore(&mut self.state, &mut self.definitions);
                if let Some(name) = name {
                    let object = self.object.take().unwrap_or_default();
                    let is_known = |known: &Arc<Object>| !known.primitives.is_empty() && !name.is_empty();
                    if self.objects.get(&name).is_some_and(is_known) {
                        self.note_again("object", &shown(name.as_bytes()), at);
                    }
                    if !object.primitives.is_empty() {
                        self.idle_objects.insert(name.clone(), at);
                    }
                    self.objects.insert(name, Arc::new(object));
                }
            }
        }
    }

    pub(super) fn object_begin(&mut self, name: Text, at: Span) -> Result<(), Box<Diagnostic>> {
        self.end_forgotten_object();
        let inside = self.open.iter().find(|open| matches!(open, Open::Object { .. })).map(Open::at);
        let saved = Saved::new(&self.state, &self.definitions);
        let Some(outer) = inside else {
            if self.begin(Open::Object { saved, name: Some(name.value.clone()), at }) {
                self.report.define(Kind::Object, &name);
                self.object = Some(Object::default());
            }
            return Ok(());
        };
        // Its ObjectEnd and its instances are not errors.
        self.begin(Open::Object { saved, name: None, at });
        self.objects.entry(name.value).or_default();
        Err(Box::new(
            Diagnostic::error(at, "ObjectBegin inside the definition of an object")
                .related(outer, "the outer object begins here"),
        ))
    }

    pub(super) fn object_instance(&mut self, name: Text) -> Result<(), Box<Diagnostic>> {
        self.end_forgotten_object();
        if let Some(Open::Object { at, .. }) =
            self.open.iter().find(|open| matches!(open, Open::Object { .. }))
        {
            return Err(Box::new(
                Diagnostic::error(name.span, "ObjectInstance inside the definition of an object")
                    .related(*at, "the object begins here"),
            ));
        }
        let Some(object) = self.objects.get(&name.value) else {
            undefined(&mut self.report, Kind::Object, &name, self.objects.keys());
            return Ok(());
        };
        self.idle_objects.remove(&name.value);
        if !object.primitives.is_empty() {
            self.instances.push(Instance { object: object.clone(), world_from_object: self.state.ctm });
        }
        Ok(())
    }
}

/// The block of a directive. `None` if it may appear in both.
pub(crate) fn home_block(directive: &Directive) -> Option<Block> {
    match directive {
        Directive::WorldBegin | Directive::TransformTimes(_) => Some(Block::Options),
        Directive::Entity(kind, _) => match kind {
            EntityKind::Camera
            | EntityKind::Film
            | EntityKind::PixelFilter
            | EntityKind::Sampler
            | EntityKind::Integrator
            | EntityKind::Accelerator => Some(Block::Options),
            EntityKind::MakeNamedMedium => None,
            _ => Some(Block::World),
        },
        Directive::AttributeBegin
        | Directive::AttributeEnd
        | Directive::TransformBegin
        | Directive::TransformEnd
        | Directive::ObjectBegin(_)
        | Directive::ObjectEnd
        | Directive::ObjectInstance(_)
        | Directive::ReverseOrientation
        | Directive::NamedMaterial(_)
        | Directive::Texture { .. }
        | Directive::WorldEnd => Some(Block::World),
        _ => None,
    }
}
